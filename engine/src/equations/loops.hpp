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

struct StrongParts {
  std::vector<std::uint32_t> part_of;  ///< by equation; parts are numbered so that what others depend on comes first
  std::uint32_t count = 0;
};
/// The strongly connected parts of what depends on what, in linear time.
StrongParts strong_parts(const std::vector<std::vector<std::uint32_t>>& depends_on);

}  // namespace bgsim
