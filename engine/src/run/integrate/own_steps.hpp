/// What the integrators with error-controlled steps of bgsim's own share.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "run/integrate/integrator.hpp"

namespace bgsim {

/// Steps that know nothing of the ones before, from y_ at time_ towards limit_.
class OwnSteps : public Integrator {
 public:
  [[nodiscard]] const double* end() const override { return y_.data(); }
  [[nodiscard]] Counts counts() const override { return counts_; }
  [[nodiscard]] bool one_step() const override { return true; }

 protected:
  static constexpr double kEps = std::numeric_limits<double>::epsilon();
  using Integrator::Integrator;

  bool fail(const char* words) {
    failure_.words = words;
    failure_.fault = faulted_;
    return false;
  }

  /// Puts the solution into @p y if it is one that needs no dense output: an end of the last step, or of one by hand.
  bool is_end(double t, double* y) const {
    const bool at_end = by_hand_ || t == time_ || !(time_ > previous_);
    if (!at_end && t != previous_) return false;
    const std::vector<double>& from = at_end ? y_ : begin_;
    std::copy(from.begin(), from.end(), y);
    return true;
  }

  [[nodiscard]] bool limit_is_at_hand() const {
    const double resolution = 4.0 * kEps * std::max(std::abs(time_), std::abs(limit_));
    return limit_ - time_ <= resolution || is_nothing(limit_ - time_);
  }
  /// An explicit step over a stretch of a few roundings of the time.
  void step_by_hand(const std::vector<double>& rate) {
    begin_ = y_;
    for (std::size_t i = 0; i < size_; ++i) y_[i] += (limit_ - time_) * rate[i];
    previous_ = time_;
    time_ = limit_;
    order_ = 1;
    by_hand_ = true;
    ++counts_.steps;
  }

  /// Up to the limit in one step, or in two of one length, or what is wanted. A first step is no part of what time
  /// resolves: an event just before the limit may leave some roundings of the time.
  [[nodiscard]] double fit(double h) const {
    const double left = limit_ - time_, least = 16.0 * kEps * std::abs(time_);
    if (longest_ > 0.0) h = std::min(h, longest_);
    h = h >= left * (1.0 - 1e-10) ? left : 2.0 * h > left ? left / 2.0 : h;
    if (!first_ || h >= least) return h;
    return left <= 2.0 * least ? left : least;
  }

  double limit_ = 0.0;
  std::vector<double> y_, begin_;  ///< at the end of the last step, and at its beginning
  bool first_ = true;              ///< no step since the restart
  bool faulted_ = false;           ///< the latest evaluation failed: last_fault_
  bool by_hand_ = false;           ///< the last step was one
  Counts counts_;
};

}  // namespace bgsim
