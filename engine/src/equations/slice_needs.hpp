/// What expressions depend on, and the part of a system that they need.
#pragma once

#include <span>
#include <vector>

#include "bgsim/slice.hpp"

namespace bgsim {

/// What some expressions depend on: states, and unknowns by their equations.
struct Needs {
  std::vector<bool> states, equations;
};
/// Follows @p roots through equations and rates to the end. Time linear in the system.
Needs needs_of(const EquationSystem& system, std::span<const ExprId> roots);

/// States, blocks and dependent stores that @p needs keeps, with everything that goes with them.
Slice take(const EquationSystem& system, const BlockOrder& order, const Needs& needs);

}  // namespace bgsim
