/// The linear systems of a step by Radau IIA of order 5.
#pragma once

#include <cstddef>
#include <memory>

#include "bgsim/program.hpp"

namespace bgsim {

/// The inverse of the coefficients of Radau IIA of order 5 has a real eigenvalue and a complex pair. In the basis of
/// its eigenvectors Newton's equations of the three stages, 3n unknowns, fall apart into a real and a complex system of
/// n:
///
///     (gamma I - h J) u = r,    ((alpha + i beta) I - h J) (v + i w) = p + i q
///
/// @cite hairer1996 IV.8 (transformation by J. C. Butcher and T. A. Bickart)
class RadauSystems {
 public:
  virtual ~RadauSystems() = default;
  RadauSystems(const RadauSystems&) = delete;
  RadauSystems& operator=(const RadauSystems&) = delete;

  /// Whether jacobian() of factor() is a full matrix, column by column, or the entries by the pattern.
  [[nodiscard]] virtual bool dense() const = 0;
  /// False if one of the two is singular, or not finite.
  virtual bool factor(double h, const double* jacobian) = 0;
  /// By the last factor(): the right side becomes the solution.
  virtual void solve_real(double* u) = 0;
  virtual void solve_complex(double* v, double* w) = 0;

 protected:
  RadauSystems() = default;
};

/// Written out for up to eight states, dense up to a hundred, sparse (with complete pivoting left out, columns
/// ordered to keep the fill-in low) beyond.
std::unique_ptr<RadauSystems> make_radau_systems(const Sparsity& pattern);

}  // namespace bgsim
