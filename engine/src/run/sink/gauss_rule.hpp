/// Gauss-Legendre quadrature on [0, 1].
#pragma once

#include <vector>

namespace bgsim {

struct GaussRule {
  std::vector<double> position, weight;  ///< from left to right; of equal length
  /// Of the points of the rule over [0, 1/2] and then over [1/2, 1]: with these the polynomial through them is that at
  /// 0.
  std::vector<double> at_begin;
};

constexpr int kMostGaussPoints = 7;

/// The rule with @p points points, whose error over a step h is of the order h^(2 points + 1). A solution of order q
/// has one of the order h^(q + 1): with q/2 + 1 points the quadrature's is of higher order.
/// @pre 1 <= points <= kMostGaussPoints
const GaussRule& gauss_rule(int points);

}  // namespace bgsim
