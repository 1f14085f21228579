/// The length of the next step by Radau IIA.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace bgsim {

/// Gustafsson's predictive control: as errors went from the step before to this one, they go to the next.
/// @cite hairer1996 IV.8
template <std::size_t Stages>
class RadauControl {
 public:
  /// The iterations of Newton's method that are allowed, 7, 12 and 17 as in the program RADAU: what a stage of a high
  /// order begins with is further off in tolerances. Steps that need many are made shorter.
  static constexpr int kIterations = 7 + 5 * (static_cast<int>(Stages) - 3) / 2;
  /// By what power of its length the estimated error of a step falls, one over.
  static constexpr double kExponent = 1.0 / (Stages + 1);

  /// A new stretch.
  void begin() { accepted_ = 0; }

  /// By what a step of that error is divided.
  [[nodiscard]] static double quotient_of(double error, int iterations) {
    const double safety = std::min(kSafety, kSafety * (1.0 + 2.0 * kIterations) / (iterations + 2.0 * kIterations));
    return std::clamp(std::pow(error, kExponent) / safety, kMostGrowth, kMostCut);
  }

  /// After a step of length @p h that was accepted.
  /// @param rejected  whether a longer one was not
  double next_length(double h, double error, double quotient, bool rejected) {
    if (++accepted_ > 1) {
      const double predicted = (step_ / h) * std::pow(error * error / error_, kExponent) / kSafety;
      quotient = std::max(quotient, std::clamp(predicted, kMostGrowth, kMostCut));
    }
    step_ = h;
    error_ = std::max(1e-2, error);
    return rejected ? std::min(h / quotient, h) : h / quotient;
  }

 private:
  static constexpr double kSafety = 0.9, kMostCut = 5.0, kMostGrowth = 1.0 / 8.0;
  std::uint64_t accepted_ = 0;
  double step_ = 0.0, error_ = 0.0;  ///< of the last one
};

}  // namespace bgsim
