#include "run/sink/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace bgsim {
namespace {

/// Chebyshev's points of the second kind on [-1, 1], from 1 on down: both ends are among them.
double node(std::uint32_t k, std::uint32_t count) { return std::cos(std::numbers::pi * k / (count - 1)); }

double place(const Trajectory::Step& step, std::uint32_t k) {
  if (k == 0) return step.to;
  if (k + 1 == step.nodes) return step.from;
  return std::clamp(step.from + 0.5 * (1.0 + node(k, step.nodes)) * (step.to - step.from), step.from, step.to);
}

}  // namespace

void Trajectory::begin(double /*t*/, const std::vector<double>& x, const Branch& branch) {
  *this = {};
  start_ = x;
  start_branch_ = branch;
  largest_.assign(x.size(), 0.0);
  take(x.data());
  stretches_.push_back({{}, branch});
}

void Trajectory::take(const double* x) {
  for (std::size_t i = 0; i < largest_.size(); ++i) largest_[i] = std::max(largest_[i], std::abs(x[i]));
}

void Trajectory::add(double from, double to, int order, const Branch& branch, const Solution& solution) {
  if (!(to > from)) return;
  // No method's dense output is of a degree above its order; Hermite's of one-step methods may be of the fifth.
  constexpr int kLeastDegree = 5;
  Step step{from, to, values_.size(), static_cast<std::uint32_t>(std::max(order, kLeastDegree) + 1)};
  const std::size_t n = states();
  // The solution may hold the loops' variables behind the states.
  scratch_.resize(n + branch.tears.size());
  Branch here = branch;
  for (std::uint32_t k = 0; k < step.nodes; ++k) {
    solution(place(step, k), scratch_.data(), here);
    values_.insert(values_.end(), scratch_.begin(), scratch_.begin() + static_cast<std::ptrdiff_t>(n));
    take(scratch_.data());
  }
  stretches_.back().steps.push_back(step);
  stretches_.back().end = branch;
  stretches_.back().end.given = false;
}

void Trajectory::event(double t, const std::vector<double>& x, const Branch& before, const Branch& after,
                       std::optional<std::size_t> crossed) {
  if (before.modes == after.modes) return;
  events_.push_back({t, x, before, after, crossed, {}, {}});
  stretches_.push_back({{}, after});
}

void Trajectory::set(double t, std::vector<double> x_before, const Branch& before, const std::vector<double>& x,
                     const Branch& after, const std::vector<std::size_t>& events) {
  take(x.data());
  events_.push_back({t, std::move(x_before), before, after, std::nullopt, events, x});
  stretches_.push_back({{}, after});
}

/// The barycentric formula, whose weights at these points are 1 and -1 in turn, halved at the ends.
void Trajectory::interpolate(const Step& step, double t, std::vector<double>& x) const {
  const std::size_t n = states();
  x.assign(n, 0.0);
  const double u = 2.0 * (t - step.from) / (step.to - step.from) - 1.0;
  double sum = 0.0;
  for (std::uint32_t k = 0; k < step.nodes; ++k) {
    const double* value = values_.data() + step.first + k * n;
    const double off = u - node(k, step.nodes);
    if (off == 0.0) {
      std::copy_n(value, n, x.begin());
      return;
    }
    const double weight = (k % 2 == 0 ? 1.0 : -1.0) * (k == 0 || k + 1 == step.nodes ? 0.5 : 1.0) / off;
    sum += weight;
    for (std::size_t i = 0; i < n; ++i) x[i] += weight * value[i];
  }
  for (double& value : x) value /= sum;
}

}  // namespace bgsim
