#include "run/integrate/fastest_mode.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>

#include "run/integrate/dormand_prince_formula.hpp"

namespace bgsim {

namespace {

void multiply(const Sparsity& pattern, const std::vector<double>& entries, const std::vector<double>& x,
              std::vector<double>& y) {
  std::fill(y.begin(), y.end(), 0.0);
  for (std::size_t column = 0; column < pattern.size; ++column)
    for (auto k = static_cast<std::size_t>(pattern.column_start[column]);
         k < static_cast<std::size_t>(pattern.column_start[column + 1]); ++k)
      y[static_cast<std::size_t>(pattern.row[k])] += entries[k] * x[column];
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

void scale(std::vector<double>& x, double factor) {
  for (double& value : x) value *= factor;
}

/// Of the root of larger magnitude of z^2 = a z + b, where next = a now + b before as nearly as can be.
double angle_of(const std::vector<double>& before, const std::vector<double>& now, const std::vector<double>& next) {
  constexpr double kParallel = 1e-12;
  const double pp = dot(before, before), pn = dot(before, now), nn = dot(now, now), determinant = pp * nn - pn * pn;
  if (!(determinant > kParallel * pp * nn)) return pn < 0.0 ? 0.0 : std::acos(-1.0);
  const double right_p = dot(before, next), right_n = dot(now, next);
  const double a = (pp * right_n - pn * right_p) / determinant, b = (nn * right_p - pn * right_n) / determinant;
  const std::complex<double> root = std::sqrt(std::complex<double>(a * a / 4.0 + b, 0.0));
  const std::complex<double> one = a / 2.0 + root, other = a / 2.0 - root;
  return std::acos(-1.0) - std::abs(std::arg(std::abs(one) > std::abs(other) ? one : other));
}

}  // namespace

FastestMode fastest_mode(const Sparsity& pattern, const std::vector<double>& entries) {
  constexpr int kWindow = 8, kMostWindows = 8;
  constexpr double kSettled = 0.05;
  std::vector<double> before(pattern.size), now(pattern.size), next(pattern.size);
  std::uint64_t random = 0x9E3779B97F4A7C15U;
  for (double& value : next) {  // xorshift64
    random ^= random << 13U;
    random ^= random >> 7U;
    random ^= random << 17U;
    value = static_cast<double>(random >> 11U) * 0x1p-53 - 0.5;
  }
  scale(next, 1.0 / std::sqrt(dot(next, next)));
  double rate = 0.0;
  for (int window = 0; window < kMostWindows; ++window) {
    double growth = 0.0;
    for (int k = 0; k < kWindow; ++k) {
      std::swap(now, next);
      multiply(pattern, entries, now, next);
      const double size = std::sqrt(dot(next, next));
      if (size == 0.0) return {0.0, 0.0};
      if (!std::isfinite(size)) return {std::numeric_limits<double>::infinity(), 0.0};
      growth += std::log(size);
      scale(next, 1.0 / size);
    }
    const double found = std::exp(growth / kWindow);
    const bool settled = std::abs(found - rate) < kSettled * found;
    rate = found;
    if (settled) break;
  }
  multiply(pattern, entries, next, before);
  multiply(pattern, entries, before, now);
  return {rate, angle_of(next, before, now)};
}

double dormand_prince::stable_reach(double angle) {
  constexpr double kStep = 0.02, kMost = 5.0, kNoGrowth = 1.0 + 1e-9;
  const std::complex<double> direction = -std::polar(1.0, angle);
  double reach = 0.0;
  for (double r = kStep; r < kMost; r += kStep) {
    const std::complex<double> z = r * direction;
    const std::complex<double> value =
        1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0 * (1.0 + z / 5.0 * (1.0 + z / 5.0)))));
    if (std::abs(value) > kNoGrowth) break;
    reach = r;
  }
  return reach;
}

}  // namespace bgsim
