/// Whether conditions make a quantity jump.
#pragma once

#include "bgsim/equations.hpp"

namespace bgsim {

/// Looks at points on the borders of the conditions of @p expression (of sign, step, floor and the like), with the
/// first scene's parameters: true if both sides of one of them differ wherever it was met. False where they are equal
/// somewhere, where no point was found, or where the quantities on the border depend on loops, which only a run solves.
bool certainly_jumps(const Model& model, const EquationSystem& system, ExprId expression);

}  // namespace bgsim
