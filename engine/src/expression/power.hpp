/// Powers, as every evaluation takes them.
#pragma once

#include <cmath>
#include <limits>

namespace bgsim {

/// a^3, wrong by half a rounding and 2^-48 of one at most, as std::pow is but for its larger part of a rounding (0.52):
/// a sum of a product that is rounded and what that leaves out, both times, without a conversion or a table, so that
/// loops of it become vector instructions. For |a| between kLeastCube and kMostCube only; outside, the parts that are
/// left out are no doubles. @cite dekker1971 (the product of two doubles as a sum of two)
inline constexpr double kLeastCube = 1e-95, kMostCube = 1e95;
inline double cube_within(double a) {
  const double square = a * a, cube = square * a;
#ifdef __FP_FAST_FMA
  const double of_square = __builtin_fma(a, a, -square), of_cube = __builtin_fma(square, a, -cube);
#else
  constexpr double kHalves = 134217729.0;  // 2^27 + 1
  const auto high = [](double x) { return kHalves * x - (kHalves * x - x); };
  const double a1 = high(a), a2 = a - a1, s1 = high(square), s2 = square - s1;
  const double of_square = ((a1 * a1 - square) + 2.0 * (a1 * a2)) + a2 * a2;
  const double of_cube = (((s1 * a1 - cube) + s1 * a2) + s2 * a1) + s2 * a2;
#endif
  return cube + (of_cube + of_square * a);
}

/// a^3 for all numbers. Below kLeastCube the two roundings of a product stay: beside 1e-285 of whatever else.
inline double cubed(double a) {
  const double size = std::fabs(a);
  if (size > kLeastCube && size < kMostCube) return cube_within(a);
  return a * a * a;
}

/// Squares and cubes, which laws are full of, cost std::pow twenty times as much as they have to.
inline double power(double a, double b) {
  if (b == 2.0) return a * a;
  if (b == 3.0) return cubed(a);
  // std::pow(NaN, 0) and std::pow(1, NaN) are 1
  return std::isnan(a) || std::isnan(b) ? std::numeric_limits<double>::quiet_NaN() : std::pow(a, b);
}

}  // namespace bgsim
