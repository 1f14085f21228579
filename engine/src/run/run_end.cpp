// How a run ends, and its report.
#include "run/failures.hpp"
#include "run/notes.hpp"
#include "run/run.hpp"
#include "run/stuck.hpp"

namespace bgsim {

bool Run::emit(Recorder::Outcome outcome) {
  if (outcome == Recorder::Outcome::fault) return fail_with_fault();
  return outcome == Recorder::Outcome::recorded || end_here();
}

bool Run::goes_on() {
  if (options_.max_steps > 0 && steps_before_ + steps_ >= options_.max_steps && t_ < inputs_.stop)
    return fail(step_limit_failure(t_, inputs_.stop, options_.max_steps));
  clock_.reach(t_);
  if (clock_.end() != RunClock::End::none && t_ < inputs_.stop) return end_here();
  if (!clock_.looked()) return true;
  auto reason =
      pace_.check({clock_.seconds(), t_, x_.data(), &branch_, steps_, result_.rows, events_.count(), time_events_,
                   jumped_at_, next_known_, events_.latest_relation(), integrator_.get(), !implicit_});
  return !reason || fail(std::move(*reason));
}

bool Run::fail(Diagnostic diagnostic) {
  // What fails after its time is over fails because nothing is evaluated any more.
  if (clock_.end() != RunClock::End::none) return end_here();
  result_.stop = StopReason::failed;
  result_.failure = std::move(diagnostic);
  return false;
}

bool Run::fail_as_stuck(const std::string& words) {
  if (events_.failure()) return fail(*events_.failure());
  return fail(
      stuck_at({t_, inputs_.start, x_, branch_}, words, program_, evaluator_, *integrator_, events_, magnitudes_));
}

/// Ends the run because the caller asked for it or its time is over.
bool Run::end_here() {
  const bool interrupted = clock_.end() == RunClock::End::interrupted;
  result_.stop = interrupted ? StopReason::interrupted : StopReason::failed;
  result_.failure = interrupted ? interrupted_failure(t_) : time_limit_failure(t_, inputs_.stop, options_.time_limit);
  return false;
}

Integrator::Counts Run::counts() const {
  Integrator::Counts counts = counts_before_;
  return integrator_ ? counts += integrator_->counts() : counts;
}

void Run::note(const std::optional<std::string>& text) {
  if (text) result_.report.notes.push_back(*text);
}

/// Of what may have happened within steps without being seen.
void Run::note_undecided(std::string text) {
  result_.report.undecided.push_back(text);
  result_.report.notes.push_back(std::move(text));
}

void Run::report() {
  RunReport& report = result_.report;
  report.model = program_.model->name;
  report.scene = inputs_.scene;
  report.left_out = program_.left_out;
  report.states = program_.state_names.size();
  report.algebraic = program_.tear_names.size();
  report.loops = program_.blocks.size();
  report.relative = inputs_.relative;
  report.start = inputs_.start;
  report.stop = inputs_.stop;
  report.reached = t_;
  report.time_events = time_events_;
  report.state_events = events_.count();
  if (integrator_) {
    report.method = integrator_->method();
    if (mode_order_.spent()) report.method_reason += "; " + spent_mode_words(*mode_order_.spent());
    const Integrator::Counts counts = this->counts();
    const auto number = [](long n) { return static_cast<std::uint64_t>(n); };
    report.steps = number(counts.steps);
    report.rate_evaluations = number(counts.rates);
    report.jacobian_evaluations = number(counts.jacobians);
    report.factorizations = number(counts.factorizations);
    report.nonlinear_iterations = number(counts.iterations);
    report.error_test_failures = number(counts.error_failures);
    report.convergence_failures = number(counts.convergence_failures);
    for (std::size_t i = 0; i < x_.size(); ++i)
      report.absolute.emplace_back(program_.state_names[i], tolerances_.absolute(i));
    note(quiet_states_note(tolerances_, program_.state_names));
    for (std::size_t i = 0; i < events_.undecided().size(); ++i)
      note_undecided(unproven_note(program_.relations[events_.undecided()[i]], events_.undecided_at()[i]));
    note(indefinite_shares_note(events_.indefinite(), program_.output_names));
    if (const auto unseen = defects_.unseen())
      note_undecided(unseen_law_note(program_.state_names[unseen->first], unseen->second));
    if (result_.stop == StopReason::completed && !left_mode_)
      note(fast_sources_note(schedule_.sources().frequency, inputs_.stop - inputs_.start, steps_));
  }
  for (const auto& [relation, since] : evaluator_.undecided_relations())
    note(undecided_note(program_.relations[relation], since));
  report.loop_iterations = loop_iterations_before_ + evaluator_.counts().loop_iterations;
  if (result_.failure && x_.empty() && !program_.state_names.empty()) {
    report.energy.why_not = "the run did not start";
  } else {
    report.energy = audit_.finish(t_, x_.data(), branch_);
    if (options_.energy_audit && !report.energy.done && clock_.end() != RunClock::End::none)
      report.energy.why_not = "the run was ended within a step";
    if (result_.stop == StopReason::completed && program_.switch_elements.empty())
      note(open_balance_note(report.energy, inputs_.relative));
  }
  // A mode that is left where it began has been nowhere.
  if (options_.measures && !(left_mode_ && !(t_ > inputs_.start))) {
    report.measures = measures_.finish(t_, x_.data(), branch_);
    if (result_.stop == StopReason::completed && !left_mode_) look_beyond_end();
    report.why_not_measured = measures_.why_not();
    for (const std::size_t output : measures_.coarse())
      note("the integral and the extremes of \"" + program_.output_names[output] +
           "\" are less accurate than the tolerance: it varies too fast within the steps");
  }
  for (std::size_t i = 0; i < program_.events.size(); ++i)
    report.set_events.push_back({program_.events[i].name, jumps_.memory().counts[i], jumps_.memory().energies[i]});
  report.errors = errors_.finish(result_.stop == StopReason::completed);
  if (const DelayMemory& memory = delays_.memory(); memory.coarse_at && !left_mode_)
    note_undecided(coarse_delay_note(program_.delays[memory.coarse].name, *memory.coarse_at));
  if (!program_.delays.empty()) {
    report.errors.possible = false;
    report.errors.why_not = "the model has delayed signals";
  }
  for (const NearMisses::Miss& miss : errors_.missed()) note(near_miss_note(program_.relations[miss.relation], miss.t));
  if (const auto& set = errors_.doubtful_set()) note(doubtful_set_note(program_.state_names[set->state], set->t));
  if (program_.switch_elements.empty()) {  // else of all modes together
    if (errors_.lost() && result_.stop == StopReason::completed) note(lost_errors_note(*errors_.lost()));
    note(output_errors_note(report.errors, program_.output_names, inputs_.relative));
  }
  report.stage_seconds = {
      {"integration", integration_seconds_}, {"outputs", recorder_.seconds()}, {"audit", audit_.seconds()}};
}

}  // namespace bgsim
