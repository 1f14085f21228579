#include "run/watch/continuity_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bgsim/text.hpp"

namespace bgsim {

namespace {

constexpr double kShort = 1e-6;  ///< of the scene

}  // namespace

ContinuityWatch::ContinuityWatch(Evaluator& evaluator, double span, double relative)
    : evaluator_(evaluator),
      span_(span),
      relative_(relative),
      rates_(evaluator.states()),
      x_(evaluator.states()),
      guards_(evaluator.program().must_not_jump.empty() ? 0 : evaluator.guard_count()),
      earlier_guards_(guards_.size()) {
  const std::size_t count = evaluator.program().must_not_jump.size();
  const std::vector<bool>& set = evaluator.program().jumps_if_set;
  watches_sets_ = std::find(set.begin(), set.end(), true) != set.end();
  for (auto* values : {&before_, &after_, &beside_, &before_bounds_, &after_bounds_, &beside_bounds_, &variation_})
    values->resize(count);
}

bool ContinuityWatch::evaluate(double t, const double* x, const Branch& branch, std::vector<double>& values,
                               std::vector<double>& bounds) {
  constexpr double kNeighbours = 4.0 * std::numeric_limits<double>::epsilon();  // as near as events are located
  branch_ = branch;
  const double time_error = kNeighbours * std::max(std::abs(t), 1e-3 * span_);
  return evaluator_.continuous(t, x, branch_, time_error, values.data(), bounds.data());
}

/// How much the quantities change within a step on one side of the change, by their own motion.
void ContinuityWatch::vary(double t, const double* x, const Branch& branch, double step,
                           const std::vector<double>& values) {
  branch_ = branch;
  if (!evaluator_.rates(t, x, branch_, rates_.data())) return;
  for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = x[i] + step * rates_[i];
  if (!evaluate(t + step, x_.data(), branch, beside_, beside_bounds_)) return;
  for (std::size_t i = 0; i < values.size(); ++i)
    variation_[i] = std::max(variation_[i], std::abs(beside_[i] - values[i]));
}

void ContinuityWatch::before(double t, const double* x, const Branch& branch) {
  known_ = !before_.empty() && evaluate(t, x, branch, before_, before_bounds_);
  if (!known_) return;
  std::fill(variation_.begin(), variation_.end(), 0.0);
  std::fill(guards_.begin(), guards_.end(), 0.0);
  earlier_guards_ = guards_;
  modes_ = branch.modes;
  vary(t, x, branch, -kShort * span_, before_);
  branch_ = branch;
  if (!evaluator_.guards(t, x, branch_, guards_.data())) return;
  if (!evaluator_.guards(t - kShort * span_, x_.data(), branch_, earlier_guards_.data())) earlier_guards_ = guards_;
}

/// How long ago the conditions that change had come to their borders: not at all where an event was located.
double ContinuityWatch::lateness(const Branch& branch) const {
  constexpr double kMost = 1e3;  // of the short time
  double most = 0.0;
  for (std::size_t i = 0; i < guards_.size(); ++i) {
    const std::size_t relation = evaluator_.guard_relation(i);
    const double change = std::abs(guards_[i] - earlier_guards_[i]);
    const bool border = evaluator_.program().relations[relation].has_borders();
    if (modes_[relation] == branch.modes[relation] || change == 0.0 || (border && guards_[i] > 0.0)) continue;
    most = std::max(most, std::min(kMost, std::abs(guards_[i]) / change));
  }
  return most * kShort * span_;
}

std::optional<Diagnostic> ContinuityWatch::after(double t, const double* x, const Branch& branch) {
  return compare(t, x, branch, false);
}

std::optional<Diagnostic> ContinuityWatch::after_sets(double t, const double* x, const Branch& branch) {
  return compare(t, x, branch, true);
}

std::optional<Diagnostic> ContinuityWatch::compare(double t, const double* x, const Branch& branch, bool sets_alone) {
  // Right at a border a quotient may be 0/0. Where the values are not finite the run itself has to say so.
  if (!known_ || !evaluate(t, x, branch, after_, after_bounds_)) return std::nullopt;
  vary(t, x, branch, kShort * span_, after_);
  constexpr double kRoundings = 100.0, kOfVariation = 1e-3;
  const double of_variation = kOfVariation + 2.0 * lateness(branch) / (kShort * span_);
  for (std::size_t i = 0; i < before_.size(); ++i) {
    if (sets_alone && !evaluator_.program().jumps_if_set[i]) continue;
    const double bounds = kRoundings * (before_bounds_[i] + after_bounds_[i]);
    const double allowed = relative_ * std::max(std::abs(before_[i]), std::abs(after_[i])) +
                           of_variation * variation_[i] + (std::isfinite(bounds) ? bounds : 0.0);
    if (std::abs(after_[i] - before_[i]) <= allowed) continue;
    Diagnostic fault = evaluator_.program().must_not_jump[i];
    fault.situation +=
        ": from " + number_text(before_[i], 6) + " to " + number_text(after_[i], 6) + " at t = " + number_text(t, 10);
    return fault;
  }
  return std::nullopt;
}

std::optional<Diagnostic> ContinuityWatch::between(double from, double to,
                                                   const std::function<bool(double, Branch&)>& modes_at) {
  if (before_.empty()) return std::nullopt;
  constexpr int kMostChanges = 1000;
  Branch low = first_branch(evaluator_.program()), high = low, middle = low;
  if (!modes_at(from, low) || !modes_at(to, high)) return std::nullopt;
  for (int change = 0; change < kMostChanges && low.modes != high.modes; ++change) {
    double begin = from, end = to;
    Branch at_end = high;
    while (std::nextafter(begin, end) < end) {
      const double at = begin + (end - begin) / 2;
      if (!(at > begin && at < end) || !modes_at(at, middle)) break;
      if (middle.modes == low.modes) {
        begin = at;
      } else {
        end = at;
        at_end = middle;
      }
    }
    before(begin, nullptr, low);
    if (auto jump = after(end, nullptr, at_end)) return jump;
    from = end;
    low = at_end;
  }
  return std::nullopt;
}

}  // namespace bgsim
