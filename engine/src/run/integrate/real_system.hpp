/// The one linear system of a step by a Rosenbrock method.
#pragma once

#include <cstddef>
#include <memory>

#include "bgsim/program.hpp"

namespace bgsim {

/// (shift M - h J) u = r, as the real one of RadauSystems is, which has a complex one beside it.
class RealSystem {
 public:
  virtual ~RealSystem() = default;
  RealSystem(const RealSystem&) = delete;
  RealSystem& operator=(const RealSystem&) = delete;

  /// Whether jacobian() of factor() is a full matrix, column by column, or the entries by the pattern.
  [[nodiscard]] virtual bool dense() const = 0;
  /// @param weight  of the unknowns in the error test, by which pivots are compared (row_scales.hpp)
  /// @return  false if the matrix is singular, or not finite.
  virtual bool factor(double shift, double h, const double* jacobian, const double* weight) = 0;
  /// By the last factor(): the right side becomes the solution.
  virtual void solve(double* u) = 0;

 protected:
  RealSystem() = default;
};

/// Written out for up to eight states, dense up to a hundred, sparse beyond, as make_radau_systems() does.
/// @param states  of the pattern's unknowns, the first ones
std::unique_ptr<RealSystem> make_real_system(const Sparsity& pattern, std::size_t states);

}  // namespace bgsim
