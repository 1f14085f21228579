// The loop of a run.
#include "bgsim/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "base/codes.hpp"
#include "base/stopwatch.hpp"
#include "bgsim/text.hpp"
#include "run/failures.hpp"
#include "run/run.hpp"
#include "run/sink/trajectory.hpp"
#include "run/snapshot.hpp"
#include "run/watch/onset.hpp"
#include "run/watch/time_constants.hpp"

namespace bgsim {

RunResult Run::execute() {
  double total = 0.0;
  {
    const Stopwatch watch(total);
    y_.resize(program_.state_names.size() + program_.tear_names.size());
    if (!late_watch_) evaluator_.watch([this] { return clock_.look(); });
    if (options_.resume.empty() ? begin() : resume()) {
      if (program_.state_names.empty())
        follow_grid();
      else
        integrate();
    }
  }
  evaluator_.watch({});
  integration_seconds_ = total - recorder_.seconds() - audit_.seconds();
  const bool may_go_on = result_.stop != StopReason::failed || clock_.end() != RunClock::End::none ||
                         (result_.failure && result_.failure->code == "BG607");
  if (may_go_on && !left_mode_) offer_snapshot();
  result_.stored = stored();
  report();
  return std::move(result_);
}

/// At one instant: switches first, then the events of the model that are due, until neither does anything. False if the
/// run ends here.
bool Run::settle_instant() {
  std::optional<std::size_t> latest;
  bool turned = false;
  if (auto full = log_->full(t_)) return fail(std::move(*full));
  while (stays_in_mode()) {
    if (!jumps_.any()) return true;
    if (!events_.prepare(t_, x_.data(), branch_)) return fail_with_fault();
    if (!jumps_.look(t_, x_.data(), branch_)) return fail(*jumps_.failure());
    if (!jumps_.due().empty()) {
      if (turned && jumps_.repeats(t_))
        return fail(jumps_.endless(t_, "it is due again as soon as it has taken place"));
      latest = jumps_.due().front();
      if (!take_events()) return false;
    } else if (latest && events_.turn_back(t_, x_.data(), branch_)) {
      turned = true;
      log_->look(t_, branch_);
    } else {
      if (!latest) return true;
      if (events_.unresolved()) return fail(jumps_.accumulation(*latest, t_));
      if (events_.rests())
        if (auto note = jumps_.resting(*latest, t_)) result_.report.notes.push_back(std::move(*note));
      return true;
    }
  }
  return false;
}

/// What the events that are due set.
bool Run::take_events() {
  if (events_.unresolved()) return fail(jumps_.accumulation(jumps_.due().front(), t_));
  jumped_at_ = t_;
  fresh_ = true;
  std::vector<double> rates(program_.varied_states > 0 ? x_.size() : 0);
  if (!rates.empty() && !evaluator_.rates(t_, x_.data(), branch_, rates.data())) return fail_with_fault();
  errors_.before_set(t_, x_, branch_, [this](double t, std::vector<double>& x, const Branch& branch) {
    return jumps_.set_elsewhere(t, x, branch);
  });
  for (const std::size_t event : jumps_.due()) {
    const std::vector<double> before = log_->wanted() ? x_ : std::vector<double>{};
    audit_.before_jump(t_, x_.data(), branch_);
    jumps_.set(event, x_);
    if (!events_.jumped(t_, x_.data(), branch_)) return fail(*events_.failure());
    const double energy = audit_.after_jump(t_, x_.data(), branch_);
    jumps_.bring(event, energy);
    if (!log_->wanted()) continue;
    log_->add_set(t_, program_, event, before, x_, options_.energy_audit ? std::optional(energy) : std::nullopt);
    log_->look(t_, branch_);
  }
  if (!rates.empty() && !vary_sets(rates)) return false;
  errors_.after_set(t_, x_, branch_);
  if (auto full = log_->full(t_)) return fail(std::move(*full));
  tolerances_.forget_noise();
  tolerances_.accept(t_, x_);
  return jumps_.taken(t_) || fail(*jumps_.failure());
}

/// Whether all switches stay on their side. If not, the run ends here, before anything is recorded of this instant.
bool Run::stays_in_mode() {
  if (program_.switch_elements.empty()) return true;
  leaves_.resize(program_.switch_elements.size());
  if (!events_.prepare(t_, x_.data(), branch_) || !evaluator_.switches(t_, x_.data(), branch_, leaves_.data()))
    return fail_with_fault();
  left_mode_ = std::any_of(leaves_.begin(), leaves_.end(), [](double leaves) { return leaves != 0.0; });
  if (left_mode_ && !program_.diode_elements.empty()) {
    diodes_.resize(4 * program_.diode_elements.size());
    if (!evaluator_.diodes(t_, x_.data(), branch_, diodes_.data())) return fail_with_fault();
  }
  return !left_mode_;
}

bool Run::integrate() {
  const bool resumed = !options_.resume.empty();
  if (!resumed && !known_events_ && !jumps_.begin(t_, x_.data(), branch_, result_.report.notes))
    return fail(*jumps_.failure());
  if (!resumed && !settle_instant()) return false;
  if (!resumed && !emit_here()) return false;
  if (!(inputs_.stop > t_)) return !resumed || choose_integrator();
  if (!resumed && !implicit_)
    if (auto failure = too_fast_state(evaluator_, inputs_, x_.data(), branch_)) return fail(std::move(*failure));
  if (!plan()) return false;
  if (!resumed) {
    if (!known_scales_.empty()) tolerances_.accept(t_, known_scales_);
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

/// The integrator at the run's point. While signs are held at their border, the rates are what balances them.
bool Run::start_here(double limit) {
  if (events_.holding() && differentiates()) return fail(held_variation_failure(program_, t_));
  // Modes that depend on the point are set within rates: the integrator's unknowns are the states alone.
  if (events_.holding()) eliminate_loops();
  if (events_.holding())
    integrator_->use_rates([this](double t, const double* x, Branch& branch, double* rates) {
      return events_.prepare(t, x, branch) && evaluator_.rates(t, x, branch, rates);
    });
  else
    integrator_->use_rates({});
  tolerances_.accept(t_, x_);
  if (step_ends_ && t_ < *step_ends_) limit = std::min(limit, *step_ends_);
  if (!integrator_->restart(t_, x_.data(), branch_, events_.limit(t_, defects_.limit(t_, limit))))
    return eliminate_loops() ? start_here(limit) : fail(fault_failure(integrator_->last_fault()));
  tolerances_.accept(t_, {integrator_->end(), tolerances_.size()});
  loops_.begin(integrator_->branch());
  fresh_ = false;
  return true;
}

/// The integrator's last step: made again, cut at an event, or accepted.
bool Run::take_step() {
  if (auto jump = implicit_ ? std::nullopt : loops_.check(*integrator_)) return go_back() || fail(std::move(*jump));
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
      return !holds(ends, events_.event_time(), true) || take_state_event();
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
  if (iteration_stalls() && !take_multistep()) give_loops();
  follow_stiffness();
  if (!one_step_ && mode_order_.look(t_, x_.data(), branch_, steps_)) {
    integrator_->limit_order(mode_order_.spent()->order);
    fresh_ = true;
  }
  return true;
}

/// Whether the last step, up to @p until, is what its rates add up to. If not, it is made again.
bool Run::holds(const StepEnds& ends, double until, bool event) {
  if (events_.holding() || defects_.look(*integrator_, ends, until, event)) return true;
  tolerances_.forget_noise();  // of where the step went
  fresh_ = true;
  return false;
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
  return delays_.add(t, integrator_->branch(), solution) || fail(*delays_.failure());
}

/// Modes beyond a known time.
bool Run::take_time_event() {
  between_ = true;
  ++time_events_;
  jumped_at_ = t_;
  continuity_.before(t_, x_.data(), branch_);
  const Branch before = differentiates() ? branch_ : Branch{};
  if (auto singularity = schedule_.pass(t_, branch_)) return fail(std::move(*singularity));
  delays_.pass(t_);
  if (!events_.settle(t_, x_.data(), branch_)) return fail(*events_.failure());
  if (differentiates() && !vary_event(before, {})) return false;
  if (auto jump = continuity_.after(t_, x_.data(), branch_)) return fail(std::move(*jump));
  log_->look(t_, branch_);
  due_ = between_ = false;
  return settle_instant() && (delays_.changed(t_, x_.data(), branch_) || fail(*delays_.failure()));
}

bool Run::take_state_event() {
  const double t = events_.event_time();
  // The moment is known to within its roundings: an output time as near as that shows what comes after.
  errors_.add(t_, x_, t, *integrator_);
  constexpr double kLocated = 100.0 * std::numeric_limits<double>::epsilon();
  if (!emit(recorder_.before(t - kLocated * std::abs(t), *integrator_))) return false;
  if (!audit_to(t)) return false;
  between_ = true;
  go_to(t);
  jumped_at_ = t;
  continuity_.before(t_, x_.data(), branch_);
  errors_.before_event(t_, x_, branch_);
  const Branch before = differentiates() ? branch_ : Branch{};
  if (!events_.cross(x_.data(), branch_)) return fail(*events_.failure());
  delays_.pass(t_);
  if (delays_.any() && !events_.settle(t_, x_.data(), branch_)) return fail(*events_.failure());
  if (differentiates() && !vary_event(before, events_.crossed_guard())) return false;
  errors_.after_event(t_, x_, branch_, events_.crossed_guard());
  if (auto jump = continuity_.after(t_, x_.data(), branch_)) return fail(std::move(*jump));
  tolerances_.forget_noise();  // of rates beyond the event, evaluated on the side before it
  between_ = false;
  fresh_ = true;
  log_->look(t_, branch_);
  if (events_.stays_within_tolerance()) take_multistep();
  if (settle_instant()) return delays_.changed(t_, x_.data(), branch_) ? emit_here() : fail(*delays_.failure());
  left_by_states_ = left_mode_;
  return false;
}

/// A step in which a loop came to another of its solutions is made again, ever shorter: the iteration may have strayed.
/// False if that does not help: the solution ends here.
bool Run::go_back() {
  constexpr double kShorter = 0.1;
  constexpr int kMostTimes = 10;
  if (t_ > strayed_at_) strayed_ = 0;
  strayed_at_ = t_;
  if (++strayed_ > kMostTimes) return false;
  integrator_->begin_with(kShorter * integrator_->step());
  fresh_ = true;
  return true;
}

/// Past a border that the laws on this side end at: no step gets there, and those that come near grow ever shorter.
/// True if there is one; jump_ is set if the laws make a jump there.
bool Run::leave_law() {
  if (integrator_->last_fault().kind == Fault::Kind::none) return false;
  continuity_.before(t_, x_.data(), branch_);
  if (!events_.take_across(t_, x_.data(), branch_)) return false;
  if (differentiates()) {
    jump_ = ended_law_failure(t_);
    return true;
  }
  fresh_ = true;
  log_->look(t_, branch_);
  vitality_ = {};
  jump_ = continuity_.after(t_, x_.data(), branch_);
  return true;
}

/// What may go on although the integrator gave up: past a border, or, once, with a fresh start where a kink spoiled
/// what the integrator remembered.
bool Run::rescue() {
  constexpr std::uint64_t kStepsBetween = 10;
  if (clock_.end() != RunClock::End::none) return false;
  fresh_ = true;
  if (integrator_->failure().fault && leave_law()) return !jump_ && settle_instant();
  if (events_.failure()) return false;
  if (steps_ < rescued_at_ + kStepsBetween) return false;
  rescued_at_ = steps_;
  return true;
}

/// A model without states: its outputs on the grid.
bool Run::follow_grid() {
  result_.report.method = "none (no states)";
  result_.report.method_reason = "nothing is stored";
  double reached = inputs_.start;
  const auto evaluate = [this](double t, Branch& branch) { return evaluator_.initialize_modes(t, x_.data(), branch); };
  const auto reach = [&](double t) {
    while (reached < t) {
      const double to = evaluator_.next_time_event(reached, t).value_or(t);
      if (to < t) ++time_events_;
      constexpr int kSmooth = 12;
      const auto solution = [&](double at, double*, Branch& branch) { evaluate(at, branch); };
      audit_.add(to, kSmooth, branch_, solution);
      measures_.add(to, kSmooth, branch_, solution);
      reached = to;
      if (!log_->wanted()) continue;
      if (!evaluate(to, branch_)) return fail_with_fault();
      log_->look(to, branch_);
      if (auto full = log_->full(to)) return fail(std::move(*full));
    }
    if (auto jump = continuity_.between(t_, t, evaluate)) return fail(std::move(*jump));
    t_ = t;
    return evaluate(t, branch_) || fail_with_fault();
  };
  for (std::size_t i = 0; i < inputs_.output_times.size(); ++i)
    if (!reach(inputs_.output_times[i]) || !emit_here() || !goes_on()) return false;
  return t_ >= inputs_.stop || reach(inputs_.stop);
}

RunResult simulate(const Program& program, const RunInputs& inputs, const SimulateOptions& options) {
  return simulate(program, inputs, options, wall_seconds);
}

RunResult simulate(const Program& program, const RunInputs& inputs, const SimulateOptions& options, Clock clock) {
  if (options.measures && (!options.resume.empty() || options.snapshot))
    throw std::invalid_argument("a snapshot does not hold what the outputs are measured to be");
  if (options.trajectory != nullptr && !options.resume.empty())
    throw std::invalid_argument("a snapshot does not hold the solution before it");
  const DelayTables tables = own_tables(program);
  std::optional<Program> own;
  if (!tables.empty()) own.emplace(with_tables(program, tables));
  Run run(own ? *own : program, inputs, options, std::move(clock), tables);
  RunResult result = run.execute();
  if (!run.left_mode() || result.stop != StopReason::completed) return result;
  result.stop = StopReason::failed;
  result.failure = diagnostic_of("BG619", "at t = " + number_text(result.report.reached) + " a switch leaves its side",
                                 {}, "a program is that of one mode of the switches",
                                 "run the scene by Simulation::simulate, which goes on to the next mode");
  return result;
}

}  // namespace bgsim
