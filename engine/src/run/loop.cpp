// The loop of a run: steps to the next known time, each made again, cut at an event, or accepted.
#include <algorithm>
#include <limits>
#include <utility>

#include "run/failures.hpp"
#include "run/run.hpp"
#include "run/sink/trajectory.hpp"
#include "run/watch/onset.hpp"
#include "run/watch/time_constants.hpp"

namespace bgsim {

bool Run::integrate() {
  const bool resumed = !options_.resume.empty();
  if (!resumed && !known_events_ && !begin_events()) return false;
  if (!resumed && !settle_instant()) return false;
  if (!resumed && !emit_here()) return false;
  if (!(inputs_.stop > t_)) return !resumed || choose_integrator();
  if (!resumed && program_.plan.explicit_form)
    if (auto failure = too_fast_state(evaluator_, inputs_, x_.data(), branch_)) return fail(std::move(*failure));
  if (!plan()) return false;
  if (!resumed) {
    // Where the scales of all states are known, what sources will do later is of no interest, and takes a search.
    const bool known = !known_scales_.empty() &&
                       std::all_of(known_scales_.begin(), known_scales_.end(), [](double s) { return s > 0.0; });
    tolerances_.estimate(evaluator_, t_, x_.data(), branch_, known ? std::vector<double>{} : schedule_.samples(t_));
    mode_order_.begin(t_);
    stiffness_.begin(t_, x_.data(), branch_, tolerances_.solver_cost());
  }
  if (!choose_integrator()) return false;
  if (late_watch_) evaluator_.watch([this] { return clock_.look(); });
  if (resumed || steps_before_ == 0)
    next_snapshot_ = steps_before_ + steps_ + options_.snapshot_steps;
  else if (options_.max_steps > 0 && steps_before_ >= options_.max_steps)
    return fail(step_limit_failure(t_, inputs_.stop, options_.max_steps));
  while (true) {
    if (due_ && !take_time_event()) return false;
    if (!emit_here()) return false;
    if (!(t_ < inputs_.stop)) return true;
    next_known_ = schedule_.next(t_);
    if (const auto late = delays_.next(t_); late && (!next_known_ || *late < *next_known_)) next_known_ = late;
    if (!schedule_.denominators().empty()) known_from_ = x_;
    if (!integrate_to(next_known_.value_or(inputs_.stop))) return false;
  }
}

/// To the next known time.
bool Run::integrate_to(double limit) {
  fresh_ = true;
  while (t_ < limit) {
    if (options_.snapshot_steps > 0 && steps_before_ + steps_ >= next_snapshot_) offer_snapshot();
    // What an event on the way has changed comes through a delay, perhaps before the limit.
    if (const auto late = fresh_ ? delays_.next(t_) : std::nullopt; late && *late < limit) {
      next_known_ = late;
      limit = *late;
    }
    if (fresh_ && !start_here(limit)) return false;
    if (!integrator_->advance()) {
      if (integrator_->failure().too_accurate) return fail(accuracy_failure(t_, inputs_.relative));
      if (!rescue() && !left_mode_ && !eliminate_loops() && (jump_ || !take_multistep()))
        return jump_ ? fail(std::move(*jump_)) : fail_as_stuck(integrator_->failure().words);
      if (left_mode_) return false;
      continue;
    }
    ++steps_;
    if (!take_step() || !goes_on()) return false;
  }
  return true;
}

/// What is sampled or latched at the start is so from the start on.
bool Run::begin_events() {
  if (!jumps_.begin(t_, x_.data(), branch_)) return fail(*jumps_.failure());
  return settle_memory() &&
         (jumps_.begin_others(t_, x_.data(), branch_, result_.report.notes) || fail(*jumps_.failure()));
}

/// The integrator at the run's point. While signs are held at their border, the rates are what balances them.
bool Run::start_here(double limit) {
  if (events_.holding() && differentiates()) return fail(held_variation_failure(program_, t_));
  // Modes that depend on the point are set within rates: the integrator's unknowns are the states alone.
  if (events_.holding()) eliminate_loops();
  if (events_.holding())
    integrator_->use_rates([this](double t, const double* x, Branch& branch, double* rates) {
      return events_.rates(t, x, branch, rates);
    });
  else
    integrator_->use_rates({});
  tolerances_.accept(t_, x_);
  if (step_ends_ && t_ < *step_ends_) limit = std::min(limit, *step_ends_);
  if (!integrator_->restart(t_, x_.data(), branch_, events_.limit(t_, defects_.limit(t_, limit))))
    return eliminate_loops() ? start_here(limit) : fail(fault_failure(integrator_->last_fault()));
  tolerances_.accept(t_, {integrator_->end(), tolerances_.size()});
  loops_.begin(*integrator_);
  fresh_ = false;
  return true;
}

/// The integrator's last step: made again, cut at an event, or accepted.
bool Run::take_step() {
  if (auto jump = integrator_->branch().given ? std::nullopt : loops_.check(*integrator_))
    return go_back() || fail(std::move(*jump));
  if (!vitality_.look(integrator_->step(), integrator_->time())) {
    if (leave_law()) return jump_ ? fail(std::move(*jump_)) : settle_instant();
    return eliminate_loops() || take_multistep() || fail_as_stuck("time no longer advances");
  }
  const Fault& fault = integrator_->last_fault();
  if (fault.kind != Fault::Kind::none && vitality_.blocked(integrator_->step(), t_, fault.time) && leave_law())
    return jump_ ? fail(std::move(*jump_)) : settle_instant();
  const double* end = integrator_->end();
  // Of a state that was not watched the step says how large it is, and no more: neither where it has crossed a border.
  if (!facts_of(inputs_.method).fixed_step() && take_first_scales(x_, end, tolerances_)) {
    constexpr double kShorter = 0.1;
    integrator_->begin_with(kShorter * integrator_->step());
    fresh_ = true;
    return true;
  }
  const double* tears = integrator_->branch().given ? end + x_.size() : integrator_->branch().tears.data();
  const StepEnds ends{t_, integrator_->time(), x_.data(), end, branch_.tears.data(), tears};
  switch (events_.search(*integrator_, ends)) {
    case EventWatch::Search::failed:
      return eliminate_loops() || fail(*events_.failure());
    case EventWatch::Search::nearer:
      fresh_ = true;
      return true;
    case EventWatch::Search::found:
      return (events_.event_time() > t_ && !holds(ends, events_.event_time(), true)) || take_state_event();
    case EventWatch::Search::none:
      break;
  }
  const double t = integrator_->time();
  if (!holds(ends, t, false)) return true;
  if (jumps_.any() && jumps_.overdue(t)) return fail(*jumps_.failure());
  events_.pass();
  tolerances_.accept(t, {end, tolerances_.size()});
  errors_.add(t_, x_, t, *integrator_);
  if (!emit(recorder_.before(t, *integrator_))) return false;
  if (!audit_to(t)) return false;
  go_to(t);
  magnitudes_.take(t_ - inputs_.start, x_);
  if (steps_ >= next_estimate_ && !implicit_) {
    next_estimate_ *= 8;
    tolerances_.estimate(evaluator_, t_, x_.data(), branch_, {});
  }
  fresh_ = defects_.is_limit(t_) || events_.is_limit(t_) || t_ == step_ends_;
  if (!bring_back()) return false;
  if (iteration_stalls() && !eliminate_loops() && !take_multistep()) give_loops();
  follow_stiffness();
  if (!one_step_ && !implicit_ && mode_order_.look(t_, x_.data(), branch_, steps_)) {
    integrator_->limit_order(mode_order_.spent()->order);
    fresh_ = true;
  }
  return true;
}

/// To a time within the integrator's last step.
void Run::go_to(double t) {
  branch_ = integrator_->branch();
  integrator_->interpolate(t, y_.data(), branch_);
  branch_.given = false;
  std::copy_n(y_.begin(), x_.size(), x_.begin());
  t_ = t;
  due_ = next_known_ && *next_known_ == t;
}

/// What is held at its border and has drifted away is brought back to it, and the run goes on from there.
bool Run::bring_back() {
  constexpr double kOneStep = 1.0, kMultistep = 10.0;  // tolerances; these begin again at the first order
  if (!events_.holding()) return true;
  const bool multistep = !one_step_ && facts_of(inputs_.method).family == MethodFamily::multistep;
  // What jumps at a known time may let go of what is held: there it is looked at only.
  const double least = due_ ? std::numeric_limits<double>::infinity() : multistep ? kMultistep : kOneStep;
  return !put_on_borders(least) || events_.settle(t_, x_.data(), branch_) || fail(*events_.failure());
}

/// @param least  in tolerances: what has drifted by less stays
/// @return whether anything was brought back
bool Run::put_on_borders(double least) {
  std::vector<double> x = x_;
  if (!events_.bring_back(t_, x, branch_, least)) return false;
  errors_.before_set(t_, x_, branch_, [this](double t, std::vector<double>& states, Branch branch) {
    events_.bring_back(t, states, branch, 0.0);
    return true;
  });
  x_ = std::move(x);
  errors_.after_set(t_, x_, branch_);
  fresh_ = true;
  return true;
}

/// Sinks take the last step up to @p t.
bool Run::audit_to(double t) {
  const auto solution = [this](double at, double* y, Branch& branch) {
    integrator_->interpolate(at, y, branch);
    events_.prepare(at, y, branch);
  };
  audit_.add(t, integrator_->order(), integrator_->branch(), solution);
  measures_.add(t, integrator_->order(), integrator_->branch(), solution);
  if (options_.trajectory != nullptr)
    options_.trajectory->add(t_, t, integrator_->order(), integrator_->branch(), solution);
  return delays_.add(t, integrator_->order(), integrator_->branch(), solution) || fail(*delays_.failure());
}

}  // namespace bgsim
