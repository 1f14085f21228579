/// Algebraic loops: unknowns that depend on each other.
#pragma once

#include <cstdint>
#include <vector>

#include "bgsim/equations.hpp"

namespace bgsim {

/// Positions of the equations of the unknowns that @p expression depends on.
std::vector<std::uint32_t> equations_in(const EquationSystem& system, ExprId expression);

/// Whose an equation is: the element's, or the signal's that its expression was made for.
Origin origin_of(const EquationSystem& system, const Equation& equation);

}  // namespace bgsim
