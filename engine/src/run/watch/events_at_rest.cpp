// Borders of conditions at which states rest, or laws end: what the tolerances leave open is no change of a condition.
#include <algorithm>
#include <array>
#include <cmath>

#include "run/failures.hpp"
#include "run/watch/events.hpp"

namespace bgsim {

/// Conditions that change again and again within a few steps, while their guards never leave what the tolerances leave
/// open of them, tell of no motion. A sign that may be 0 there is, up to some tolerances.
void EventWatch::widen_bands_of_returns(double t, const double* x, Branch& branch) {
  constexpr double kOfTolerances = 4.0;
  const std::vector<double> error = guard_errors(t, x, branch);
  for (std::size_t i = 0; i < side_.size(); ++i) {
    if (returns_[i] < kReturns) continue;
    returns_[i] = 0;
    if (error.empty() || !(excursion_[i] <= error[i])) continue;
    if (rests_at_zero(i, error[i], t, x, branch)) {
      branch.modes[relation_[i]] = 0.0;
      side_[i] = 0;
      rest_[i] = kOfTolerances * error[i];
    } else if (leads_back_only(i, t, x, branch)) {
      band_[i] = std::max(2.0 * band_[i], kOfTolerances * error[i]);
    } else {
      stays_within_tolerance_ = true;
    }
  }
}

/// Whether the law with a sign at 0 is that of both sides, but for what the tolerances make of it (no relay), and
/// leaves the guard where it is for a hundredth of the scene: a store that has run empty through an orifice.
bool EventWatch::rests_at_zero(std::size_t guard, double error, double t, const double* x, const Branch& branch) {
  constexpr double kOfTheScene = 1e-2;
  const std::size_t states = program_.state_names.size(), relation = relation_[guard];
  if (program_.relations[relation].kind != Relation::Kind::sign || stiction_.held(guard) || denominators_.has(guard))
    return false;
  std::vector<double> zero(states), side(states), moved(x, x + states);
  const auto rates_with = [&](double mode, std::vector<double>& rates) {
    Branch with = branch;
    with.modes[relation] = mode;
    return prepare(t, x, with) && evaluator_.rates(t, x, with, rates.data());
  };
  if (!rates_with(0.0, zero)) return false;
  for (const double mode : {-1.0, 1.0}) {
    if (!rates_with(mode, side)) return false;
    Branch with = branch;
    with.modes[relation] = mode;
    const std::vector<double> noise = shaken(t, x, with, side);
    for (std::size_t k = 0; k < states; ++k)
      if (!(std::abs(side[k] - zero[k]) <= noise[k])) return false;
  }
  for (std::size_t k = 0; k < states; ++k) moved[k] += kOfTheScene * span_ * zero[k];
  Branch there = branch;
  there.modes[relation] = 0.0;
  return evaluator_.guards(t, moved.data(), there, at_probe_.data()) && std::abs(at_probe_[guard]) <= error;
}

/// Whether the law of one side leads back to the border, and that of the other side leaves the guard where it is: an
/// integral that stops at its limit (`if(x >= top, min(u, 0), u)`). The solution stays there. That a step left it is
/// what the step does not know, as when u turns within it.
bool EventWatch::leads_back_only(std::size_t guard, double t, const double* x, const Branch& branch) {
  constexpr double kNothing = 1e-6;  // beside the way back
  const std::size_t states = program_.state_names.size();
  if (border_[guard] || followed_[guard] || stiction_.held(guard) || denominators_.has(guard)) return false;
  std::vector<double> rates(states), moved(x, x + states);
  std::vector<int> direction(side_.size(), 0);
  std::array<double, 2> outwards{};  // from the border, by side
  for (const int side : {-1, 1}) {
    direction[guard] = side;
    Branch with = branch;
    evaluator_.cross(direction, with);
    if (!evaluator_.rates(t, x, with, rates.data()) || !evaluator_.guards(t, x, with, at_probe_.data())) return false;
    // Over a time in which states move by their tolerances at most: the guard's slope is that at the border.
    double moment = span_;
    for (std::size_t k = 0; k < states; ++k)
      if (rates[k] != 0.0) moment = std::min(moment, tolerances_.absolute(k) / std::abs(rates[k]));
    for (std::size_t k = 0; k < states; ++k) moved[k] = x[k] + moment * rates[k];
    const double here = at_probe_[guard];
    if (!(moment > 0.0) || !evaluator_.guards(t, moved.data(), with, at_probe_.data())) return false;
    outwards[side < 0 ? 0 : 1] = side * (at_probe_[guard] - here) / moment;
  }
  const auto [least, most] = std::minmax(outwards[0], outwards[1]);
  return least < 0.0 && std::abs(most) <= kNothing * -least;
}

bool EventWatch::take_across(double t, const double* x, Branch& branch) {
  constexpr double kClearly = 4.0;
  constexpr std::size_t kMostReturns = 20;
  if (!any()) return false;
  const std::vector<double> error = guard_errors(t, x, branch);
  const std::size_t states = program_.state_names.size();
  std::vector<double> rates(states);
  bool taken = false;
  for (std::size_t i = 0; i < error.size(); ++i) {
    direction_[i] = 0;
    // One that was taken across before came to the end of the law on its other side, too: a root on each. One that is
    // exactly zero has no side yet, and no step to find it by.
    const bool again = hold_[i] > 0.0 || side_[i] == 0;
    if (border_[i] || followed_[i] || stiction_.held(i) || (again && !may_hold_)) continue;
    if (!(std::abs(values_[i]) < std::max(error[i], hold_[i])) && values_[i] != 0.0) continue;
    if (denominators_.has(i) && is_singular_at(t, x, branch)) continue;
    direction_[i] = -side_[i];
    Branch other = branch;
    evaluator_.cross(direction_, other);
    const bool goes_on = !again && evaluator_.rates(t, x, other, rates.data());
    if (!goes_on) direction_[i] = 0;
    if (!goes_on && !may_hold_) continue;
    hold_[i] = std::max(hold_[i], kClearly * error[i]);
    away_[i] = kClearlyOut * error[i];
    relations_.push_back(relation_[i]);
    taken = true;
    if (!goes_on) {
      // At a start nothing may be known of the states' sizes: as far as the guard moves by itself in a moment.
      constexpr double kMoment = 1e-6;
      probe_ = branch;
      if (hold_[i] == 0.0 && evaluator_.guards(t + kMoment * span_, x, probe_, at_probe_.data()))
        hold_[i] = std::abs(at_probe_[i]);
      followed_[i] = followed_any_ = true;
      continue;
    }
    // A relay whose law ends at its border (if(e > 0, sqrt(e), -1)) is pushed back by what the tolerance leaves open.
    if (!is_kink(i, t, x, branch) && ++taken_[i] >= kMostReturns) {
      failure_ = returning_failure(program_, relation_[i], t, kMostReturns);
      return false;
    }
    side_[i] = -side_[i];
  }
  if (!taken) return false;
  evaluator_.cross(direction_, branch);
  std::fill(direction_.begin(), direction_.end(), 0);
  ++count_;
  event_time_ = t;
  return settle(t, x, branch) && check_for_chattering(t, x, branch);
}

/// Gives the relations that are followed the sides on which their guards are at a point.
bool EventWatch::follow(double t, const double* x, Branch& branch) {
  guards_here_.resize(side_.size());
  sides_here_.assign(side_.size(), 0);
  if (!evaluator_.guards(t, x, branch, guards_here_.data())) return false;
  for (std::size_t i = 0; i < side_.size(); ++i)
    if (followed_[i]) sides_here_[i] = guards_here_[i] < 0.0 ? -1 : 1;
  evaluator_.cross(sides_here_, branch);
  return true;
}

void EventWatch::stop_following(std::size_t guard) {
  followed_[guard] = false;
  hold_[guard] = 0.0;
  followed_any_ = std::find(followed_.begin(), followed_.end(), true) != followed_.end();
}

/// Whether rates grow without bound on the way on which they lead to a point.
bool EventWatch::is_singular_at(double t, const double* x, const Branch& branch) {
  constexpr double kRoundings = 1e4 * 0x1p-52;
  const std::size_t states = program_.state_names.size();
  const auto rates = [&](double at, const double* point, double* result) {
    probe_ = branch;
    return evaluator_.rates(at, point, probe_, result);
  };
  Approach line{
      t, kRoundings * std::max(std::abs(t), span_ * kRoundings), {x, x + states}, std::vector<double>(states)};
  return !rates(t, x, line.slope.data()) || grows_without_bound(line, states, rates);
}

/// By how much each guard is changed when a state is by its tolerance. Empty if a guard cannot be evaluated.
std::vector<double> EventWatch::guard_errors(double t, const double* x, const Branch& branch) {
  std::vector<double> error(side_.size(), 0.0), moved(x, x + program_.state_names.size());
  probe_ = branch;
  if (!evaluator_.guards(t, x, probe_, values_.data())) return {};
  for (std::size_t j = 0; j < moved.size(); ++j) {
    for (const double step : {tolerances_.absolute(j), -tolerances_.absolute(j)}) {
      moved[j] = x[j] + step;
      if (!evaluator_.guards(t, moved.data(), probe_, at_probe_.data())) continue;
      for (std::size_t i = 0; i < error.size(); ++i) error[i] = std::max(error[i], std::abs(at_probe_[i] - values_[i]));
    }
    moved[j] = x[j];
  }
  return error;
}

/// By how much the rates @p f at a point change when states change by their tolerances.
std::vector<double> EventWatch::shaken(double t, const double* x, Branch branch, const std::vector<double>& f) {
  std::vector<double> noise(f.size(), 0.0), moved(x, x + f.size()), there(f.size());
  for (std::size_t j = 0; j < moved.size(); ++j) {
    moved[j] = x[j] + tolerances_.absolute(j);
    if (evaluator_.rates(t, moved.data(), branch, there.data()))
      for (std::size_t k = 0; k < f.size(); ++k) noise[k] += std::abs(there[k] - f[k]);
    moved[j] = x[j];
  }
  return noise;
}

/// Whether the rates differ on both sides of a border by no more than what the tolerances make of them.
bool EventWatch::is_kink(std::size_t guard, double t, const double* x, const Branch& branch) {
  const std::size_t states = program_.state_names.size();
  std::vector<double> here(states), there(states);
  Branch same = branch, other = branch;
  std::vector<int> direction(side_.size(), 0);
  direction[guard] = side_[guard] != 0 ? -side_[guard] : -1;
  evaluator_.cross(direction, other);
  direction[guard] = 1;
  if (side_[guard] == 0) evaluator_.cross(direction, same);
  if (!evaluator_.rates(t, x, same, here.data()) || !evaluator_.rates(t, x, other, there.data())) return false;
  const std::vector<double> noise = shaken(t, x, same, here);
  const std::vector<double> beyond = shaken(t, x, other, there);
  for (std::size_t k = 0; k < states; ++k)
    if (!(std::abs(here[k] - there[k]) <= kClearlyOut * (noise[k] + beyond[k]))) return false;
  return true;
}

/// By state its tolerance, with the sign of the way on which a guard rises. Empty if it cannot be evaluated.
std::vector<double> EventWatch::uphill(std::size_t guard, double t, const double* x, const Branch& branch) {
  const std::size_t states = program_.state_names.size();
  probe_ = branch;
  if (!evaluator_.guards(t, x, probe_, at_probe_.data())) return {};
  const double here = at_probe_[guard];
  std::vector<double> moved(x, x + states), result(states, 0.0);
  for (std::size_t j = 0; j < states; ++j) {
    moved[j] = x[j] + tolerances_.absolute(j);
    if (evaluator_.guards(t, moved.data(), probe_, at_probe_.data()))
      result[j] = sign_of(at_probe_[guard] - here) * tolerances_.absolute(j);
    moved[j] = x[j];
  }
  return result;
}

/// Whether the laws of both sides have values a tolerance beyond the border, too.
bool EventWatch::both_go_on(std::size_t guard, double t, const double* x, const Branch& branch) {
  const std::vector<double> up = uphill(guard, t, x, branch);
  std::vector<double> moved(up.size()), rates(up.size());
  if (up.empty()) return false;
  std::vector<int> direction(side_.size(), 0);
  for (const int law : {-1, 1}) {
    direction[guard] = law;
    for (const int side : {-1, 1}) {
      for (std::size_t j = 0; j < moved.size(); ++j) moved[j] = x[j] + side * up[j];
      probe_ = branch;
      evaluator_.cross(direction, probe_);
      if (!evaluator_.rates(t, moved.data(), probe_, rates.data())) return false;
    }
  }
  return true;
}

/// Whether rates agree across the border, within what the tolerances make of them, each side's taken where they hold: a
/// tolerance away from it.
bool EventWatch::meets_at_border(std::size_t guard, double t, const double* x, const Branch& branch) {
  const std::size_t states = program_.state_names.size();
  const std::vector<double> up = uphill(guard, t, x, branch);
  if (up.empty()) return false;
  std::vector<double> moved(states), rates(states), first, noise(states, 0.0);
  for (const int side : {-1, 1}) {
    for (std::size_t j = 0; j < states; ++j) moved[j] = x[j] + side * up[j];
    Branch there = branch;
    std::vector<int> direction(side_.size(), 0);
    direction[guard] = side;
    evaluator_.cross(direction, there);
    if (!evaluator_.rates(t, moved.data(), there, rates.data())) return false;
    const std::vector<double> by_tolerance = shaken(t, moved.data(), there, rates);
    for (std::size_t k = 0; k < states; ++k) noise[k] += by_tolerance[k];
    if (side < 0) first = rates;
  }
  for (std::size_t k = 0; k < states; ++k)
    if (!(std::abs(rates[k] - first[k]) <= kClearlyOut * noise[k])) return false;
  return true;
}

/// Borders that are crossed in a row although the rates differ on both sides by no more than what the tolerances make
/// of them: what is at rest near a kink crosses it by what the tolerance leaves open (a transistor without a voltage
/// across it). Each is given a band of some tolerances, within which it does not change, until it has clearly left
/// that. False if there is none, or all of them have had their share of widening.
bool EventWatch::rest_at_kinks(double t, const double* x, const Branch& branch) {
  constexpr double kOfTolerances = 4.0, kWidest = 1e4;
  const std::vector<double> error = guard_errors(t, x, branch);
  if (error.empty()) return false;
  bool any = false;
  for (std::size_t i = 0; i < side_.size(); ++i) {
    if (border_[i] || followed_[i] || stiction_.held(i) || denominators_.has(i) || !(error[i] > 0.0)) continue;
    if (std::find(relations_.begin(), relations_.end(), relation_[i]) == relations_.end()) continue;
    if (!(std::abs(values_[i]) <= kClearlyOut * std::max(error[i], band_[i]))) continue;
    if (side_[i] == 0 || !(is_kink(i, t, x, branch) || leads_back_only(i, t, x, branch))) {
      // The law of one side has no value on the other, as a root has none: that of each point holds there.
      if (!may_hold_ || !meets_at_border(i, t, x, branch)) continue;
      followed_[i] = followed_any_ = any = true;
      hold_[i] = std::max(hold_[i], kOfTolerances * error[i]);
      away_[i] = kClearlyOut * error[i];
      continue;
    }
    if (band_[i] > kWidest * error[i]) continue;
    band_[i] = std::max(2.0 * band_[i], kOfTolerances * error[i]);
    any = true;
  }
  return any;
}

}  // namespace bgsim
