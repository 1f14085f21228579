/// Radau IIA: the coefficients of order 5, and what RADAU5 makes of them; for orders 9 and 13 in radau_tables.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "run/integrate/radau_tables.hpp"

namespace bgsim::radau {

/// Collocation at c[0] < c[1] < c[2] = 1, the zeros of d^2/dx^2 x^2 (x - 1)^3. Exact: the numbers are given with the
/// digits of a double, and tests derive them.
/// @cite hairer1996 IV.5 (table 5.6), IV.8
inline constexpr double kRoot6 = 2.449489742783178;  // sqrt(6)
inline constexpr std::array<double, 3> kAt = {(4.0 - kRoot6) / 10.0, (4.0 + kRoot6) / 10.0, 1.0};
inline constexpr std::array<std::array<double, 3>, 3> kCoefficients = {
    {{(88.0 - 7.0 * kRoot6) / 360.0, (296.0 - 169.0 * kRoot6) / 1800.0, (-2.0 + 3.0 * kRoot6) / 225.0},
     {(296.0 + 169.0 * kRoot6) / 1800.0, (88.0 + 7.0 * kRoot6) / 360.0, (-2.0 - 3.0 * kRoot6) / 225.0},
     {(16.0 - kRoot6) / 36.0, (16.0 + kRoot6) / 36.0, 1.0 / 9.0}}};

/// Eigenvalues of the inverse of the coefficients.
inline constexpr double kGamma = 3.637834252744496;
inline constexpr double kAlpha = 2.681082873627752, kBeta = 3.050430199247411;

/// The columns: eigenvector of kGamma, real and imaginary part of that of kAlpha + i kBeta; scaled such that the last
/// row is (t, 1, 0).
inline constexpr std::array<std::array<double, 3>, 3> kTransform = {
    {{9.1232394870892942792e-02, -0.14125529502095420843, -3.0029194105147424492e-02},
     {0.24171793270710701896, 0.20412935229379993199, 0.38294211275726193779},
     {0.96604818261509293619, 1.0, 0.0}}};
inline constexpr std::array<std::array<double, 3>, 3> kBack = {
    {{4.3255798900631553510, 0.33919925181580986954, 0.54177053993587487119},
     {-4.1787185915519047273, -0.32768282076106238708, 0.47662355450055045196},
     {-0.50287263494578687595, 2.5719269498556054292, -0.59603920482822492497}}};

/// The inverse of the coefficients.
constexpr std::array<std::array<double, 3>, 3> inverse_of_coefficients() {
  const auto& t = kTransform;
  const auto& b = kBack;
  std::array<std::array<double, 3>, 3> inverse{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      inverse[i][j] = t[i][0] * kGamma * b[0][j] + t[i][1] * (kAlpha * b[1][j] - kBeta * b[2][j]) +
                      t[i][2] * (kBeta * b[1][j] + kAlpha * b[2][j]);
  return inverse;
}
inline constexpr std::array<std::array<double, 3>, 3> kInverse = inverse_of_coefficients();

/// The embedded formula of order 3 has the stages' weights and 1/gamma for the rates at the beginning. Its distance
/// from the step's end, times gamma, is h f + sum of these times the stages' increments.
inline constexpr std::array<double, 3> kError = {-(13.0 + 7.0 * kRoot6) / 3.0, (-13.0 + 7.0 * kRoot6) / 3.0,
                                                 -1.0 / 3.0};

inline constexpr std::array<double, 1> kBubbleZeros = {0.4};
inline constexpr double kLargestBubble = 0.0068;
/// Where bubble_slope / bubble is kGamma: a correction that satisfies the equations there needs no other matrix.
inline constexpr double kCorrectedAt = 0.5572271856295500;

/// The collocation polynomial and its slope at @p u, by the stages' increments.
constexpr std::array<double, 3> value_by_stages(double u) {
  const auto& c = kAt;
  return {u * (u - c[1]) * (u - c[2]) / (c[0] * (c[0] - c[1]) * (c[0] - c[2])),
          u * (u - c[0]) * (u - c[2]) / (c[1] * (c[1] - c[0]) * (c[1] - c[2])),
          u * (u - c[0]) * (u - c[1]) / (c[2] * (c[2] - c[0]) * (c[2] - c[1]))};
}
constexpr std::array<double, 3> slope_by_stages(double u) {
  std::array<double, 3> slope{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double a = kAt[(k + 1) % 3], b = kAt[(k + 2) % 3];
    slope[k] = ((u - a) * (u - b) + u * (u - b) + u * (u - a)) / (kAt[k] * (kAt[k] - a) * (kAt[k] - b));
  }
  return slope;
}
inline constexpr std::array<double, 3> kValue = value_by_stages(kCorrectedAt), kSlope = slope_by_stages(kCorrectedAt);

template <>
inline constexpr RadauTable<3> kTable<3> = {.at = kAt,
                                            .inverse = kInverse,
                                            .gamma = kGamma,
                                            .pairs = {{{kAlpha, kBeta}}},
                                            .transform = kTransform,
                                            .back = kBack,
                                            .error = kError,
                                            .bubble_zeros = kBubbleZeros,
                                            .largest_bubble = kLargestBubble,
                                            .corrected_at = kCorrectedAt,
                                            .value = kValue,
                                            .slope = kSlope};

/// The collocation polynomial of s stages misses the solution within a step by h^(s+1) times this, and by h^(s+2) where
/// it is corrected: bubble() vanishes at the stages' rates (its slope is the product of u - c), and at both ends.
template <std::size_t Stages>
constexpr double bubble(double u) {
  double product = 1.0 / (Stages + 1) * u * (u - 1.0) * (u - 1.0);
  for (const double zero : kTable<Stages>.bubble_zeros) product *= u - zero;
  return product;
}
template <std::size_t Stages>
constexpr double bubble_slope(double u) {
  double product = 1.0;
  for (const double at : kTable<Stages>.at) product *= u - at;
  return product;
}

/// The stage that is nearest to where the dense output is corrected.
template <std::size_t Stages>
constexpr std::size_t corrected_stage() {
  const RadauTable<Stages>& table = kTable<Stages>;
  const auto away = [&](std::size_t k) {
    const double distance = table.at[k] - table.corrected_at;
    return distance < 0.0 ? -distance : distance;
  };
  std::size_t nearest = 0;
  for (std::size_t k = 1; k < Stages; ++k)
    if (away(k) < away(nearest)) nearest = k;
  return nearest;
}

/// Row times column.
template <std::size_t N>
constexpr double dot(const std::array<double, N>& a, const std::array<double, N>& b) {
  double sum = a[0] * b[0];
  for (std::size_t k = 1; k < N; ++k) sum += a[k] * b[k];
  return sum;
}

/// The length of a first step: over it the solution is to bend by some tolerances in the order after that of the
/// stages, as if all orders had the time scale of the first two.
/// @param speed,bend  norms of the first and second derivative, in tolerances
/// @param left        how much there is to go
/// @param exponent    1 over one more than the stages
inline double first_length(double exponent, double speed, double bend, double left) {
  double h = 0.1 * left;
  if (!(bend > 0.0) || !std::isfinite(bend)) return h;
  const double scale = speed / bend;
  const double wanted = std::pow(std::max(speed * scale, 1e-100), -exponent) * scale;
  h = std::min(h, 0.5 * std::max(wanted, speed > 0.0 ? 0.0 : std::sqrt(1.0 / bend)));
  return h > 0.0 ? h : 0.5 * std::sqrt(1.0 / bend);
}

}  // namespace bgsim::radau
