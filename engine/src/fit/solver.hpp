/// Nonlinear least squares within bounds, as a function over values: the libraries that solve it are behind these two.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bgsim/fit.hpp"

namespace bgsim {

struct LeastSquares {
  std::size_t residuals = 0;
  std::vector<double> start, lower, upper;  ///< by variable, of size 1 or so; lower <= start <= upper
  FitLoss loss = FitLoss::squares;
  double loss_at = 0.0;
  std::uint64_t iterations = 100;
  /// Fills the residuals and, unless it is null, the derivatives (row by row) at a point. False: it has none there.
  /// What it throws ends the search.
  std::function<bool(const double* x, double* residuals, double* derivatives)> evaluate;
};

struct LeastSquaresSolution {
  std::vector<double> x;
  std::uint64_t iterations = 0;
  bool converged = false;
  std::string stopped;  ///< why, in words
};

/// Levenberg-Marquardt by Ceres.
LeastSquaresSolution solve_least_squares(const LeastSquares& problem);

/// The best of @p points all over the (finite) bounds, by division of the rectangle (DIRECT) as NLopt has it.
/// @param cost  of a point; infinite where it has none.
std::vector<double> search_everywhere(const std::vector<double>& lower, const std::vector<double>& upper,
                                      std::uint64_t points,
                                      const std::function<double(const std::vector<double>&)>& cost);

}  // namespace bgsim
