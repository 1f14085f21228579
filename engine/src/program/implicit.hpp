/// What is solved for along a step: loops' variables, and what holds a guard at its border.
#pragma once

#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// Whether a relation is of the kind that can be held at its border: in the law of a resistor, with two sides.
[[nodiscard]] bool can_rest(const Program& program, std::uint32_t relation);

/// Fills Program::loop_equations and Program::border_rates. Call when the slots of the program's symbols are known.
/// @param rates      frozen, by state
/// @param residuals  frozen, by block
/// @note  Cost: reverse derivatives of the guards that can rest, of their rates and, where there is such a guard or one
/// that a loop moves, of the loops' residuals.
void add_implicit_equations(Program& program, const std::vector<ExprId>& rates,
                            const std::vector<std::vector<ExprId>>& residuals);

}  // namespace bgsim
