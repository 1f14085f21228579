#include "run/arrivals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bgsim {
namespace {

constexpr std::size_t kArrivals = 16;

/// (E - r)^2 y / (1 - r)^2.
double twice_shifted(double first, double second, double third, double r) {
  return (third - 2.0 * r * second + r * r * first) / ((1.0 - r) * (1.0 - r));
}

}  // namespace

void Arrivals::add(Arrival arrival, double value) {
  constexpr double kRounding = 1e-6;
  if (!latest.empty() && latest.back().t == arrival.t) return;
  if (!latest.empty() && latest.back().program != arrival.program) {  // other states
    latest.clear();
    sizes.clear();
  }
  const double part = value > 0.0 ? kRounding / value : 0.0;
  sizes.resize(arrival.moved.size(), 0.0);
  for (std::size_t i = 0; i < sizes.size(); ++i)
    sizes[i] = std::max({sizes[i], arrival.terms[i], part * std::abs(arrival.x[i])});
  size_of_instant = std::max({size_of_instant, std::abs(arrival.instant), part * std::abs(arrival.t)});
  if (latest.size() == kArrivals) latest.erase(latest.begin());
  latest.push_back(std::move(arrival));
}

std::optional<Arrival> limit_of(const Arrivals& arrivals, const Accumulation& series) {
  constexpr double kAgree = 1e-6, kSteady = 1e-2;
  const std::vector<Arrival>& k = arrivals.latest;
  const double r = series.ratio;
  if (k.size() < 4 || !(r > 0.0)) return std::nullopt;
  const std::size_t n = k.back().x.size();
  std::vector<double> before, limit(n + 1), best;  // of the states, then of t'
  double least = kAgree;
  // Flights before the series, all of one length on a wall that shakes, say, have limits of their own.
  const auto in_series = [&](std::size_t j) {
    return std::abs((k[j].t - k[j - 1].t) - r * (k[j - 1].t - k[j - 2].t)) <= kSteady * (k[j].t - k[j - 1].t);
  };
  std::size_t first = k.size();
  while (first > 2 && in_series(first - 1)) --first;
  for (std::size_t j = first; j < k.size(); ++j) {
    for (std::size_t i = 0; i < n; ++i)
      limit[i] = twice_shifted(k[j - 2].moved[i], k[j - 1].moved[i], k[j].moved[i], r);
    limit[n] = twice_shifted(k[j - 2].instant, k[j - 1].instant, k[j].instant, r);
    double apart = before.empty() ? std::numeric_limits<double>::infinity() : 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      const double size = std::max(i < n ? arrivals.sizes[i] : arrivals.size_of_instant, std::abs(limit[i]));
      if (size > 0.0) apart = std::max(apart, std::abs(limit[i] - before[i]) / size);
    }
    if (apart < least) {
      least = apart;
      best = limit;
    }
    before = limit;
  }
  if (best.empty()) return std::nullopt;
  Arrival result{k.back().program, series.limit, {}, {best.begin(), best.end() - 1}, {}, best.back()};
  for (std::size_t i = 0; i < n; ++i) result.x.push_back((k.back().x[i] - r * k[k.size() - 2].x[i]) / (1.0 - r));
  return result;
}

}  // namespace bgsim
