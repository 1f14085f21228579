/// Roots in algebraic loops: their slope has no bound where a flow rests, and a condition keeps their sign.
#pragma once

#include "bgsim/equations.hpp"

namespace bgsim {

/// Where a law of an algebraic loop takes a root (a power between 0 and 1) of x, a sum of the loop's unknowns, the root
/// becomes an unknown w of its own, with x = w |w| for a square root: of `f = a*sign(e)*sqrt(abs(e)) + b*e` is left
/// f = a w + b w |w|, which has a slope at rest and no condition. The law is looked at on each side of x = 0, so that
/// it does not matter how it is written (sign, if, abs, max). Laws that jump there are left as they are, and so are
/// loops whose form for that is known (Equation::loop_form of a power) and laws that take no such root. A law that is a
/// sum of powers on both sides is written as one of odd powers first (odd_power_sum).
/// @note Time linear in the system; where no power depends on an unknown, that of looking through the pool.
void name_roots_in_loops(EquationSystem& system);

}  // namespace bgsim
