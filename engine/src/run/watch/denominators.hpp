/// Denominators that come to zero within a step: a singularity, or a quotient that stays finite (sin(x)/x).
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// Rates at (t, x); false if they cannot be evaluated.
using RatesAt = std::function<bool(double t, const double* x, double* rates)>;

/// The straight line on which the unknowns come to where a denominator is zero.
struct Approach {
  double t = 0.0;             ///< of the zero
  double nearest = 0.0;       ///< time before it at which its own rounding does not yet matter
  std::vector<double> at;     ///< unknowns there, states first
  std::vector<double> slope;  ///< their rates of change on the line
};

/// Whether a rate has no bound on the way: at distances each a tenth of the one before it, its change grows by a factor
/// each time, however small it is as yet, and comes to be more than rounding makes of a quotient of two zeros. True
/// also where the rates cannot be evaluated.
/// @note ten evaluations at most.
bool grows_without_bound(const Approach& approach, std::size_t states, const RatesAt& rates);

/// The guards of a program that are denominators' factors.
class Denominators {
 public:
  /// @param relation  by guard.
  Denominators(const Program& program, std::span<const std::size_t> relation);

  [[nodiscard]] bool has(std::size_t guard) const { return is_[guard]; }
  /// In increasing order.
  [[nodiscard]] const std::vector<std::size_t>& guards() const { return guards_; }
  /// The guard that has fallen to next to nothing of what it was; none if none has.
  /// @param values, largest  by guard: now, and the largest magnitude so far.
  [[nodiscard]] std::optional<std::size_t> next_to_zero(std::span<const double> values,
                                                        std::span<const double> largest) const;

 private:
  std::vector<bool> is_;
  std::vector<std::size_t> guards_;
};

}  // namespace bgsim
