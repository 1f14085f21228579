// What an instant makes of the error: an event that comes early or late, and states that are set.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bgsim/text.hpp"
#include "run/sink/global_error.hpp"

namespace bgsim {

namespace {

/// Where states would be set if the error were not as it is estimated, in parts of the way to the exact solution.
constexpr std::array<double, 2> kFarther{3.0, -2.0};

}  // namespace

void GlobalError::before_event(double t, const std::vector<double>& x, const Branch& branch) {
  if (!measuring_) return;
  branch_before_ = branch;
  if (!evaluator_.rates(t, x.data(), branch_before_, rates_before_.data()))
    std::fill(rates_before_.begin(), rates_before_.end(), 0.0);
}

void GlobalError::after_event(double t, const std::vector<double>& x, const Branch& branch,
                              std::optional<std::size_t> guard) {
  if (!measuring_ || !guard) return;
  const std::size_t relation = evaluator_.guard_relation(*guard);
  if (program_.relations[relation].is_between(branch_before_.modes[relation]))
    return;  // what was held is released where the rates are continuous
  const Stopwatch watch(seconds_);
  branch_ = branch;
  if (!evaluator_.rates(t, x.data(), branch_, rates_.data())) return;
  guards_.resize(evaluator_.guard_count());
  guards_off_.resize(guards_.size());
  // The guard at the event, where the exact states are, and a moment before: by so much the event comes early or late.
  constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
  const double moment = std::max(1e-3 * (to_ - from_), kRounding * std::abs(t));
  for (std::size_t i = 0; i < x.size(); ++i) y_[i] = x[i];
  if (!evaluator_.guards(t, y_.data(), branch_before_, guards_.data())) return;
  const double here = guards_[*guard];
  for (std::size_t i = 0; i < x.size(); ++i) y_[i] = x[i] - error_[i];
  if (!evaluator_.guards(t, y_.data(), branch_before_, guards_off_.data())) return;
  const double exact = guards_off_[*guard];
  for (std::size_t i = 0; i < x.size(); ++i) y_[i] = x[i] - moment * rates_before_[i];
  if (!evaluator_.guards(t - moment, y_.data(), branch_before_, guards_off_.data())) return;
  const double speed = (here - guards_off_[*guard]) / moment;
  const double late = (here - exact) / speed;
  if (!std::isfinite(late)) return;
  instant_ = {t, late, x, false};
  for (std::size_t i = 0; i < x.size(); ++i) instant_.exact[i] += late * rates_before_[i] - error_[i];
  for (std::size_t i = 0; i < x.size(); ++i) error_[i] += late * (rates_[i] - rates_before_[i]);
}

/// To an instant of which nothing is known yet: at a known time, or at the start.
void GlobalError::come_to(double t, const std::vector<double>& x) {
  if (instant_.t == t) return;
  instant_ = {t, 0.0, x};
  for (std::size_t i = 0; i < x.size(); ++i) instant_.exact[i] -= error_[i];
}

void GlobalError::before_set(double t, const std::vector<double>& x, const Branch& branch, const Set& set) {
  if (!measuring_) return;
  come_to(t, x);
  for (std::vector<double>& farther : farther_) farther.clear();
  // The modes are those of the point, unless it is at the border of what sets.
  const auto set_there = [&](double at, std::vector<double>& states) {
    branch_there_ = branch;
    if (instant_.known) {
      std::copy(states.begin(), states.end(), y_.begin());
      if (!set_modes(at, y_, branch_there_)) return false;
    }
    return set(at, states, branch_there_);
  };
  if (instant_.known)
    for (std::size_t k = 0; k < kFarther.size(); ++k) {
      farther_[k] = x;
      for (std::size_t i = 0; i < x.size(); ++i) farther_[k][i] += kFarther[k] * (instant_.exact[i] - x[i]);
      if (!set_there(t, farther_[k])) farther_[k].clear();
    }
  if (!set_there(t + instant_.late, instant_.exact))
    give_up("what is set at t = " + number_text(t, 6) + " has no value for the exact solution");
}

void GlobalError::after_set(double t, const std::vector<double>& x, const Branch& branch) {
  if (!measuring_) return;
  for (std::size_t i = 0; i < x.size(); ++i) error_[i] = x[i] - instant_.exact[i];
  for (std::size_t k = 0; k < kFarther.size() && !doubtful_set_; ++k)
    for (std::size_t i = 0; i < farther_[k].size() && !doubtful_set_; ++i) {
      const double much = OutputErrors::kLarge * std::max(tolerances_.largest(i), std::abs(x[i]));
      const double jump = farther_[k][i] - x[i] + kFarther[k] * error_[i];
      if (std::abs(error_[i]) <= much && std::abs(jump) > much) doubtful_set_ = DoubtfulSet{i, t};
    }
  if (instant_.late == 0.0) return;
  branch_ = branch;
  if (!evaluator_.rates(t, x.data(), branch_, rates_.data())) return;
  for (std::size_t i = 0; i < x.size(); ++i) error_[i] += instant_.late * rates_[i];
}

const GlobalError::Instant& GlobalError::leave(double t, const std::vector<double>& x) {
  come_to(t, x);
  return instant_;
}

}  // namespace bgsim
