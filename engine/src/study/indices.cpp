#include "bgsim/indices.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace bgsim {

namespace {

constexpr double kNoIndex = std::numeric_limits<double>::quiet_NaN();
constexpr double kNormal95 = 1.959963984540054;  // quantile of 97.5 %

/// Runs of one point: A, B, and A with one quantity of B.
struct ThreeRuns {
  double a, b, mixed;
};

struct Moments {
  double mean = 0.0, variance = 0.0;
};

/// Of all runs A and B. Results are compared with the first, so that an equal result is an exact 0.
template <class Runs>
Moments moments_of(const std::vector<Runs>& runs) {
  const double origin = runs.front().a, count = 2.0 * static_cast<double>(runs.size());
  double sum = 0.0, squares = 0.0;
  for (const Runs& run : runs) sum += (run.a - origin) + (run.b - origin);
  const double mean = sum / count;
  for (const Runs& run : runs) {
    const double a = run.a - origin - mean, b = run.b - origin - mean;
    squares += a * a + b * b;
  }
  return {origin + mean, squares / count};
}

/// The ratio of the mean of @p parts to the variance, whose own terms are @p wholes, and its interval: a ratio's error
/// is, to first order, the mean of (part - ratio whole)/variance.
std::pair<double, double> ratio_of(const std::vector<double>& parts, const std::vector<double>& wholes,
                                   double variance) {
  const auto count = static_cast<double>(parts.size());
  double sum = 0.0, squares = 0.0;
  for (const double part : parts) sum += part;
  const double ratio = sum / count / variance;
  for (std::size_t g = 0; g < parts.size(); ++g) {
    const double deviation = (parts[g] - ratio * wholes[g]) / variance;
    squares += deviation * deviation;
  }
  return {ratio, kNormal95 * std::sqrt(squares / count / (count - 1.0))};
}

VarianceShare share_of(const std::vector<ThreeRuns>& runs) {
  VarianceShare share{kNoIndex, kNoIndex, kNoIndex, kNoIndex, runs.size()};
  if (runs.size() < 2) return share;
  const Moments moments = moments_of(runs);
  if (!(moments.variance > 0.0)) return share;
  std::vector<double> first, total, wholes;
  for (const ThreeRuns& run : runs) {
    const double a = run.a - moments.mean, b = run.b - moments.mean, change = run.mixed - run.a;
    first.push_back(b * change);
    total.push_back(0.5 * change * change);
    wholes.push_back(0.5 * (a * a + b * b));
  }
  std::tie(share.first, share.first_within) = ratio_of(first, wholes, moments.variance);
  std::tie(share.total, share.total_within) = ratio_of(total, wholes, moments.variance);
  return share;
}

}  // namespace

VarianceShares variance_shares(const SweepPoints& points, const std::vector<double>& results) {
  const std::size_t count = points.plan().variations.size(), runs = count + 2;
  VarianceShares shares;
  shares.mean = shares.deviation = kNoIndex;
  std::vector<ThreeRuns> both;
  for (std::size_t at = 0; at + runs <= results.size(); at += runs)
    if (std::isfinite(results[at]) && std::isfinite(results[at + 1]))
      both.push_back({results[at], results[at + 1], 0.0});
  shares.points = both.size();
  if (!both.empty()) {
    const Moments moments = moments_of(both);
    shares.mean = moments.mean;
    shares.deviation = std::sqrt(moments.variance);
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<ThreeRuns> three;
    for (std::size_t at = 0; at + runs <= results.size(); at += runs) {
      const ThreeRuns run{results[at], results[at + 1], results[at + 2 + i]};
      if (std::isfinite(run.a) && std::isfinite(run.b) && std::isfinite(run.mixed)) three.push_back(run);
    }
    shares.of.push_back(share_of(three));
  }
  return shares;
}

std::vector<ElementaryEffect> elementary_effects(const SweepPoints& points, const std::vector<double>& results) {
  const std::size_t count = points.plan().variations.size();
  std::vector<std::vector<double>> effects(count);
  for (std::size_t at = 0; at + 1 < results.size(); ++at) {
    if (at % (count + 1) == count) continue;  // the end of a path
    if (!std::isfinite(results[at]) || !std::isfinite(results[at + 1])) continue;
    const SweepPoints::Move move = points.move_after(at);
    effects[move.variation].push_back((results[at + 1] - results[at]) / move.share);
  }
  std::vector<ElementaryEffect> result;
  for (const std::vector<double>& own : effects) {
    ElementaryEffect effect{kNoIndex, kNoIndex, kNoIndex, kNoIndex, own.size()};
    const auto n = static_cast<double>(own.size());
    const auto spread = [&](double mean, auto&& value) {
      double squares = 0.0;
      for (const double each : own) squares += (value(each) - mean) * (value(each) - mean);
      return std::sqrt(squares / (n - 1.0));
    };
    if (own.size() >= 2) {
      effect.mean = effect.magnitude = 0.0;
      for (const double each : own) {
        effect.mean += each / n;
        effect.magnitude += std::abs(each) / n;
      }
      effect.deviation = spread(effect.mean, [](double each) { return each; });
      effect.within = boost::math::quantile(boost::math::students_t(n - 1.0), 0.975) *
                      spread(effect.magnitude, [](double each) { return std::abs(each); }) / std::sqrt(n);
    }
    result.push_back(effect);
  }
  return result;
}

}  // namespace bgsim
