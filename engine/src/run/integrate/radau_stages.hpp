/// The equations of a step's stages by Radau IIA, each stage with its own Jacobian.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "run/integrate/column_lu.hpp"

namespace bgsim {

/// With Z the stages' increments, F their rates and A the coefficients, Newton's step d for Z = h A F(Z) is
///
///     (A^-1 x M - h diag(J_0, J_1, ...)) d = h F - (A^-1 x M) Z,
///
/// with M as in RadauSystems, s n equations for s stages. They do not fall apart as those with one matrix for all
/// stages do (radau_systems.hpp).
class RadauStages {
 public:
  using Stages = std::span<std::vector<double>>;
  /// Rates, or the Jacobian as a full matrix, column by column, of stage k at @p x; false where there are none.
  using AtStage = std::function<bool(std::size_t k, const double* x, double* out)>;

  /// @param states   of the unknowns, the first ones
  /// @param inverse  A^-1 by rows; must outlive this
  RadauStages(std::size_t size, std::size_t states, std::size_t stages, const double* inverse, AtStage rates,
              AtStage jacobian);
  RadauStages(const RadauStages&) = delete;
  RadauStages& operator=(const RadauStages&) = delete;

  /// Newton's method, damped such that each simplified step is shorter than the step before it (natural monotonicity):
  /// a law with a kink is overshot from either side in turn by full steps.
  ///
  /// @param y  states at the step's beginning. @param z  in: a guess; out: the stages' increments, if found.
  /// @param weight  by state. @param reached  the error allowed in the root mean square of weighted increments.
  /// @return  false if they were not found.
  /// Cost: 2/3 (s n)^3 operations an iteration; s Jacobians, s rates for each damping tried.
  /// @cite deuflhard2004 (3.3, error-oriented)
  bool solve(double h, const double* y, Stages z, const double* weight, double reached);

  /// Of the last solve().
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  bool defects(double h, const double* y, const std::vector<double>& z, std::vector<double>& out);
  bool see(double h, const double* y, const std::vector<double>& z, const double* weight);
  [[nodiscard]] double norm(const std::vector<double>& x, const double* weight) const;

  std::size_t size_, states_, stages_;
  const double* inverse_;
  AtStage rates_, jacobian_;
  int iterations_ = 0;
  ColumnLu<false> lu_;
  std::vector<double> scales_;  ///< of the rows
  std::vector<double> at_, rate_, full_;
  std::vector<double> now_, trial_, defect_, step_, next_, simplified_;  ///< of all stages, one after the other
};

}  // namespace bgsim
