/// What the derivatives at the end of a fit say of its values.
#pragma once

#include <vector>

#include "bgsim/fit.hpp"

namespace bgsim {

struct FitJacobian {
  std::size_t rows = 0, columns = 0;
  std::vector<double> derivatives;  ///< of weighted residuals, row by row
  std::vector<double> residuals;    ///< weighted
};

struct FitStatistics {
  std::vector<std::vector<double>> covariance, correlation;  ///< by value; NaN where there is none
  std::vector<double> errors;                                ///< by value; NaN likewise
  std::vector<char> determined;                              ///< by value
  std::vector<FitDirection> undetermined;
  double deviation = 0.0;
  double quantile = 0.0;  ///< how many standard errors 95 % confidence is to either side
};

/// @param free  by value: whether it can move (it does not sit on a bound)
/// @param scales  by value: what a relative change of it is relative to
/// @param accuracy  relative, of the derivatives: what is below it tells nothing apart
FitStatistics fit_statistics(const FitPlan& plan, const FitJacobian& jacobian, const std::vector<char>& free,
                             const std::vector<double>& scales, double accuracy, bool known_sigma);

/// How far a point is from the least sum of squares: the part of the residuals that a linear step can take away, per
/// value, over what remains, per degree of freedom; so the step in standard errors (Bates, Watts, Technometrics 23,
/// 1981; from memory). No unit of a value or a residual matters.
/// @param held  by value: whether it cannot move
/// @param accuracy  as above
/// @param noise  norm of residuals below which they say nothing
double relative_offset(const FitJacobian& jacobian, const std::vector<char>& held, double accuracy, double noise);

/// Residuals and derivatives whose squares add up to the loss of what they were: those that Levenberg-Marquardt takes.
/// @param derivatives  row by row; may be null
void root_of_loss(FitLoss loss, double at, std::size_t rows, std::size_t columns, double* residuals,
                  double* derivatives);

}  // namespace bgsim
