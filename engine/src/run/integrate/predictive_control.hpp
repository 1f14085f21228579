/// The length of the next step of a stiff method.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace bgsim {

/// Gustafsson's predictive control: as errors went from the step before to this one, they go to the next.
/// @cite hairer1996 IV.8
/// @tparam Power       of its length by which the estimated error of a step falls
/// @tparam MostGrowth  of a step to the next
template <int Power, int MostGrowth>
class PredictiveControl {
 public:
  static constexpr double kExponent = 1.0 / Power;

  /// A new stretch.
  void begin() { accepted_ = 0; }

  /// By what a step of that error is divided.
  [[nodiscard]] static double quotient_of(double error, double safety = kSafety) {
    return std::clamp(std::pow(error, kExponent) / safety, kLeast, kMostCut);
  }

  /// After a step of length @p h that was accepted.
  /// @param rejected  whether a longer one was not
  double next_length(double h, double error, double quotient, bool rejected) {
    if (++accepted_ > 1)
      quotient = std::max(
          quotient, std::clamp((step_ / h) * std::pow(error * error / error_, kExponent) / kSafety, kLeast, kMostCut));
    step_ = h;
    error_ = std::max(1e-2, error);
    return rejected ? std::min(h / quotient, h) : h / quotient;
  }

 protected:
  static constexpr double kSafety = 0.9;

 private:
  static constexpr double kMostCut = 5.0, kLeast = 1.0 / MostGrowth;
  std::uint64_t accepted_ = 0;
  double step_ = 0.0, error_ = 0.0;  ///< of the last one
};

/// Of Radau IIA.
template <std::size_t Stages>
class RadauControl : public PredictiveControl<static_cast<int>(Stages) + 1, 8> {
  using Base = PredictiveControl<static_cast<int>(Stages) + 1, 8>;

 public:
  /// The iterations of Newton's method that are allowed, 7, 12 and 17 as in the program RADAU: what a stage of a high
  /// order begins with is further off in tolerances. Steps that need many are made shorter.
  static constexpr int kIterations = 7 + 5 * (static_cast<int>(Stages) - 3) / 2;

  [[nodiscard]] static double quotient_of(double error, int iterations) {
    constexpr double kSafety = Base::kSafety;
    return Base::quotient_of(error,
                             std::min(kSafety, kSafety * (1.0 + 2.0 * kIterations) / (iterations + 2.0 * kIterations)));
  }
};

}  // namespace bgsim
