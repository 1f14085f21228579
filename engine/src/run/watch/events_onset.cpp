// Guards that are exactly 0 where a stretch begins (a product of two states at rest): which way they go is what the
// equations say, and not what a first step makes of it.
#include <algorithm>
#include <cmath>
#include <limits>

#include "program/guard_series.hpp"
#include "program/mode_borders.hpp"
#include "run/watch/events.hpp"

namespace bgsim {
namespace {

/// How long a series has the sign of its leading term, by the terms that are known of it; 0 if these are too few.
double duration_of_sign(const PowerSeries& series) {
  constexpr double kOfTheWay = 0.25;
  constexpr int kFewest = 3;
  if (series.zero || series.known < series.order + kFewest) return 0.0;
  for (const double c : series.coefficient)
    if (!std::isfinite(c)) return 0.0;
  double shortest = std::numeric_limits<double>::infinity();
  for (int k = 1; k < PowerSeries::kTerms; ++k) {
    const double ratio = std::abs(series.coefficient[static_cast<std::size_t>(k)] / series.coefficient[0]);
    if (ratio > 0.0) shortest = std::min(shortest, kOfTheWay * std::pow(ratio, -1.0 / k));
  }
  return shortest;
}

}  // namespace

/// Keeps where a stretch begins, if guards are 0 there.
/// @param branch  of that stretch
void EventWatch::keep_start(const StepEnds& ends, const Branch& branch) {
  onsets_.begins = false;
  onsets_.from = onsets_.until = -std::numeric_limits<double>::infinity();
  onsets_.known = true;
  for (std::size_t i = 0; i < side_.size(); ++i) {
    if (!may_set_out(i) || values_[i] != 0.0) continue;
    onsets_.from = onsets_.until = ends.begin;
    onsets_.known = false;
    // One that something has brought to its border has no side any more, if its mode is that of the border.
    onsets_.before = side_;
    for (std::size_t k = 0; k < side_.size(); ++k)
      if (may_set_out(k) && !border_[k] && branch.modes[relation_[k]] == mode_at_zero(relation_[k]))
        onsets_.before[k] = 0;
    onsets_.states.assign(ends.states_at_begin, ends.states_at_begin + program_.state_names.size());
    return;
  }
}

bool EventWatch::may_set_out(std::size_t guard) const {
  const Relation::Kind kind = program_.relations[relation_[guard]].kind;
  if (kind == Relation::Kind::sign || kind == Relation::Kind::denominator) return false;
  return !(rest_[guard] > 0.0) && !followed_[guard] && !stiction_.held(guard);
}

/// Whether a guard that was 0 where the stretch began is rounding's at the end of the first step: a side taken from
/// that would be kept, and the crossing to the other one found later, where nothing is 0 any more.
bool EventWatch::sets_out_in_rounding(const StepEnds& ends, const Branch& branch) {
  constexpr double kEps = std::numeric_limits<double>::epsilon(), kRoundings = 4.0;
  if (onsets_.known || ends.begin != onsets_.from) return false;
  Branch there = branch;
  std::vector<double> moved(ends.states_at_end, ends.states_at_end + program_.state_names.size());
  if (!evaluator_.guards(ends.end, moved.data(), there, at_probe_.data())) return false;
  for (std::size_t k = 0; k < moved.size(); ++k) moved[k] *= 1.0 + (k % 2 == 0 ? kEps : -kEps);
  std::vector<double> beside(side_.size());
  if (!evaluator_.guards(ends.end * (1.0 + kEps), moved.data(), there, beside.data())) return false;
  for (std::size_t i = 0; i < side_.size(); ++i)
    if (values_[i] == 0.0 && may_set_out(i) &&
        std::abs(at_probe_[i]) <= kRoundings * std::abs(beside[i] - at_probe_[i]))
      return true;
  return false;
}

/// Takes the sides of the guards that were 0 where the stretch began from their series. Those without one are measured
/// by what they are at the end of the step that is searched: what is next to nothing beside that is rounding's.
/// @return whether a step in which a guard has crossed is to be searched again.
bool EventWatch::find_onsets(const Integrator& integrator, const StepEnds& ends) {
  constexpr double kLongest = 1e-3;  // of the scene
  if (onsets_.known || !(ends.begin < onsets_.from + kLongest * span_)) return false;
  onsets_.known = true;
  const Branch& branch = integrator.branch();
  Branch probe = branch;
  std::vector<double> rates(program_.state_names.size());
  if (!evaluator_.rates(onsets_.from, onsets_.states.data(), probe, rates.data()) ||
      !evaluator_.guards(onsets_.from, onsets_.states.data(), probe, at_probe_.data()))
    return false;
  std::vector<std::size_t> guards;
  std::vector<GuardAtBorder> at_border;
  for (std::size_t i = 0, next = 0; i < side_.size(); ++i) {
    const std::size_t position = is_upper(i) ? next - 1 : next++;
    if (!may_set_out(i) || at_probe_[i] != 0.0) continue;
    guards.push_back(i);
    at_border.push_back({position, 0.0});
    if (!border_[i]) continue;
    const auto [lower, upper] = mode_borders(program_, program_.relations[relation_[i]], branch.modes[relation_[i]]);
    at_border.back().border = is_upper(i) ? upper : lower;
  }
  const std::vector<PowerSeries> series =
      guard_series(program_, evaluator_.constants(), onsets_.from, onsets_.states.data(), probe, at_border);
  Branch there = branch;
  const bool measured = evaluator_.guards(ends.end, ends.states_at_end, there, at_probe_.data());
  bool any = false;
  double until = onsets_.from + kLongest * span_;
  onsets_.side.assign(side_.size(), 0);
  onsets_.size.assign(side_.size(), 0.0);
  for (std::size_t n = 0; n < guards.size(); ++n) {
    const std::size_t i = guards[n];
    const int side = is_upper(i) ? -series[n].sign() : series[n].sign();
    const double duration = duration_of_sign(series[n]);
    if (duration == 0.0) {
      if (measured && std::abs(at_probe_[i]) > largest_[i]) {
        largest_[i] = std::abs(at_probe_[i]);
        any = true;
      }
    } else if (onsets_.before[i] == 0 || side_[i] == side) {
      if (side_[i] != side) side_[i] = 0;  // what a first step made of it was no more than that step is wrong by
      onsets_.side[i] = side;
      until = std::min(until, onsets_.from + duration);
      any = true;
    }
  }
  onsets_.until = until;
  for (std::size_t n = 0; n < guards.size(); ++n)
    if (onsets_.side[guards[n]] != 0)
      onsets_.size[guards[n]] = std::abs(series[n].coefficient[0]) * std::pow(until - onsets_.from, series[n].order);
  return any;
}

/// Whether a guard without a side goes to one where its mode is another one.
bool EventWatch::crosses_at_once(double t, const Branch& branch) const {
  if (t != onsets_.from || !(t < onsets_.until)) return false;
  for (std::size_t i = 0; i < side_.size(); ++i)
    if (onsets_.side[i] != 0 && side_[i] == 0 && changes_mode(i, onsets_.side[i], branch)) return true;
  return false;
}

/// A guard whose states an event sets is at its border again if it is 0 then.
void EventWatch::forget_onsets(const ProgramEvent& event) {
  for (std::size_t i = 0; i < hold_.size(); ++i) {
    if (hold_[i] != kSetOut) continue;
    const std::vector<SymbolId> symbols = symbols_in(program_.pool, {&program_.relations[relation_[i]].guard, 1});
    for (const ProgramEvent::Set& set : event.sets)
      if (set.state && std::any_of(symbols.begin(), symbols.end(), [&](SymbolId s) {
            return program_.symbol_names[s.index()] == program_.state_names[*set.state];
          }))
        hold_[i] = 0.0;
  }
}

/// While the series tell the sign, no value says otherwise that is within what the guard comes to in that time.
void EventWatch::keep_onsets(double t, std::vector<double>& values) const {
  if (!(t < onsets_.until)) return;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (onsets_.side[i] != 0 && onsets_.side[i] * values[i] <= 0.0 && std::abs(values[i]) <= onsets_.size[i])
      values[i] = onsets_.side[i] * kSetOut;
}

}  // namespace bgsim
