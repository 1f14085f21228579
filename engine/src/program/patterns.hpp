/// Which entries the Jacobians of a program have.
#pragma once

#include "bgsim/program.hpp"

namespace bgsim {

/// On which states each loop's variables depend, through earlier loops too, from the partials in the plan. Decides
/// whether the loops are eliminated from the Jacobian: where that would fill it too much, the system is solved with the
/// loops' variables as unknowns, as it also is where it is one by itself.
void find_supports(Program& program, SystemClass system_class);

/// The patterns of both forms, each with the whole diagonal. After find_supports().
/// @param states,tears  how many there are
void make_patterns(Program& program, std::size_t states, std::size_t tears);

}  // namespace bgsim
