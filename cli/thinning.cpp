#include "thinning.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace bgsim::cli {

namespace {

std::vector<std::size_t> thinned_by_buckets(std::span<const double> x, std::span<const double> y, std::size_t buckets) {
  std::vector<std::size_t> kept;
  const double width = (x.back() - x.front()) / static_cast<double>(buckets);
  std::size_t begin = 0;
  for (std::size_t bucket = 0; begin < x.size(); ++bucket) {
    std::size_t end = begin;
    const bool last = bucket + 1 >= buckets || !(width > 0.0);
    const double bound = x.front() + static_cast<double>(bucket + 1) * width;
    while (end < x.size() && (last || x[end] < bound)) ++end;
    if (end == begin) continue;
    const auto low =
        std::min_element(y.begin() + static_cast<std::ptrdiff_t>(begin), y.begin() + static_cast<std::ptrdiff_t>(end));
    const auto high =
        std::max_element(y.begin() + static_cast<std::ptrdiff_t>(begin), y.begin() + static_cast<std::ptrdiff_t>(end));
    std::array<std::size_t, 4> points{begin, static_cast<std::size_t>(low - y.begin()),
                                      static_cast<std::size_t>(high - y.begin()), end - 1};
    std::sort(points.begin(), points.end());
    for (const std::size_t point : points)
      if (kept.empty() || kept.back() != point) kept.push_back(point);
    begin = end;
  }
  return kept;
}

std::vector<std::size_t> thinned_by_distance(std::span<const double> x, std::span<const double> y,
                                             std::size_t buckets) {
  const auto [x_low, x_high] = std::minmax_element(x.begin(), x.end());
  const auto [y_low, y_high] = std::minmax_element(y.begin(), y.end());
  const double x_step = (*x_high - *x_low) / static_cast<double>(buckets);
  const double y_step = (*y_high - *y_low) / static_cast<double>(buckets);
  std::vector<std::size_t> kept{0};
  for (std::size_t i = 1; i < x.size(); ++i) {
    const std::size_t before = kept.back();
    if (i + 1 == x.size() || std::abs(x[i] - x[before]) > x_step || std::abs(y[i] - y[before]) > y_step)
      kept.push_back(i);
  }
  return kept;
}

}  // namespace

std::vector<std::size_t> thinned(std::span<const double> x, std::span<const double> y, std::size_t buckets) {
  if (x.size() <= 4 * buckets) {
    std::vector<std::size_t> all(x.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
  }
  return std::is_sorted(x.begin(), x.end()) ? thinned_by_buckets(x, y, buckets) : thinned_by_distance(x, y, buckets);
}

}  // namespace bgsim::cli
