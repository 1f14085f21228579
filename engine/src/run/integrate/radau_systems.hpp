/// The linear systems of a step by Radau IIA.
#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// Of the inverse of the coefficients.
struct RadauEigenvalues {
  double gamma;
  std::vector<std::complex<double>> pairs;  ///< alpha + i beta of each
};

/// The inverse of the coefficients of Radau IIA of s stages, s odd, has a real eigenvalue and (s - 1)/2 complex pairs.
/// In the basis of its eigenvectors Newton's equations of the stages, s n unknowns, fall apart into a real system of n
/// and a complex one for each pair:
///
///     (gamma M - h J) u = r,    ((alpha + i beta) M - h J) (v + i w) = p + i q
///
/// for M y' = f(t, y), where M is 1 on the diagonal for states and 0 for the loops' variables behind them.
///
/// @cite hairer1996 IV.8 (transformation by J. C. Butcher and T. A. Bickart)
class RadauSystems {
 public:
  virtual ~RadauSystems() = default;
  RadauSystems(const RadauSystems&) = delete;
  RadauSystems& operator=(const RadauSystems&) = delete;

  /// Whether jacobian() of factor() is a full matrix, column by column, or the entries by the pattern.
  [[nodiscard]] virtual bool dense() const = 0;
  /// @param weight  of the unknowns in the error test, by which pivots are compared (row_scales.hpp)
  /// @return  false if one of them is singular, or not finite.
  virtual bool factor(double h, const double* jacobian, const double* weight) = 0;
  /// By the last factor(): the right side becomes the solution.
  virtual void solve_real(double* u) = 0;
  virtual void solve_complex(std::size_t pair, double* v, double* w) = 0;

 protected:
  RadauSystems() = default;
};

/// Written out for up to eight states, dense up to a hundred, sparse (with complete pivoting left out, columns
/// ordered to keep the fill-in low) beyond.
/// @param states  of the pattern's unknowns, the first ones
std::unique_ptr<RadauSystems> make_radau_systems(const Sparsity& pattern, std::size_t states,
                                                 const RadauEigenvalues& eigenvalues);

}  // namespace bgsim
