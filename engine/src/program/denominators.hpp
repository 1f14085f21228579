/// Where a law divides by something that can pass zero during a run.
#pragma once

#include <vector>

#include "bgsim/ordering.hpp"

namespace bgsim {

/// A factor of a denominator.
struct DenominatorFactor {
  ExprId factor;  ///< in the order's pool
  Origin where;   ///< whose law divides by it
  bool structural =
      false;  ///< the division is the bond graph's own: by a resistance, capacitance, inertance or modulus
};

/// The factors of all denominators in @p roots that vary, each once. Factors that cannot pass zero smoothly are left
/// out: those with jumps in them, and functions without a zero (exp, cosh, squares with something positive added).
/// @param varies  by symbol: whether it changes during a run.
/// @note Time linear in what @p roots depend on.
std::vector<DenominatorFactor> denominator_factors(const Model& model, const BlockOrder& order,
                                                   const std::vector<ExprId>& roots, const std::vector<bool>& varies);

}  // namespace bgsim
