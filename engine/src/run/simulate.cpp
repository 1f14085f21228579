#include "bgsim/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"
#include "run/clock.hpp"
#include "run/failures.hpp"
#include "run/integrate/integrator.hpp"
#include "run/integrate/separability.hpp"
#include "run/integrate/spectrum.hpp"
#include "run/measure/energy_audit.hpp"
#include "run/notes.hpp"
#include "run/tolerances.hpp"
#include "run/watch/branch_watch.hpp"
#include "run/watch/events.hpp"
#include "run/watch/pace_judge.hpp"
#include "run/watch/source_pace.hpp"
#include "run/watch/time_constants.hpp"

namespace bgsim {

namespace {

/// One run: what the loop carries from step to step.
class Run {
 public:
  Run(const Program& program, const RunInputs& inputs, const SimulateOptions& options)
      : program_(program),
        inputs_(inputs),
        options_(options),
        evaluator_(program, inputs.parameters),
        implicit_(!program.state_names.empty() &&
                  (inputs.method == Method::ida ||
                   (inputs.method == Method::automatic && program.system_class == SystemClass::implicit_dae) ||
                   !program.plan.explicit_form)),
        tolerances_(program, inputs, implicit_),
        events_(program, evaluator_, tolerances_, inputs.stop - inputs.start, !implicit_),
        branches_(program, evaluator_, inputs.start, inputs.stop),
        audit_(program, evaluator_, options.energy_audit),
        clock_(options, inputs.start),
        pace_(program, evaluator_, inputs, options) {}

  RunResult execute();

 private:
  bool begin();
  bool choose_integrator();
  bool integrate();
  bool integrate_to(double limit);
  void go_to(double t);
  bool after_step();
  bool take_time_event();
  bool take_state_event();
  bool step_is_vital();
  bool limit_order();
  bool go_back();
  void hold_or_not();
  bool follow_grid();

  bool emit_before(double t);
  bool emit_here();
  bool emit_row(double t, const double* y, Branch& branch);
  void audit_to(double t);

  bool fail(Diagnostic diagnostic);
  bool fail_with_fault() { return fail(fault_failure(evaluator_.fault())); }
  bool rescue();
  bool fail_as_integrator();
  bool fail_as_stuck(const std::string& words);
  [[nodiscard]] StuckPoint stuck_point(const std::string& words);
  bool goes_on(double t);
  bool end_here(double t);
  void remember_magnitudes(double t);
  [[nodiscard]] std::vector<double> source_times();
  void report();
  void note(const std::optional<std::string>& text);

  const Program& program_;
  const RunInputs& inputs_;
  const SimulateOptions& options_;
  Evaluator evaluator_;
  bool implicit_;
  Tolerances tolerances_;
  EventWatch events_;
  BranchWatch branches_;
  EnergyAuditor audit_;
  RunClock clock_;
  PaceJudge pace_;
  std::unique_ptr<Integrator> integrator_;
  RunResult result_;
  // Where the run is: all that goes on from here follows from these.
  double t_ = 0.0;  ///< reached, with all events up to here taken
  std::vector<double> x_;
  Branch branch_;
  std::vector<double> y_;  ///< scratch for interpolation
  Branch probe_;
  std::vector<double> row_;
  double audited_ = 0.0;  ///< energy is accounted for up to here
  std::size_t next_output_ = 0;
  std::uint64_t steps_ = 0, time_events_ = 0, tiny_steps_ = 0, empty_steps_ = 0, next_estimate_ = 0, rescued_at_ = 0,
                looked_at_step_ = 0;
  std::vector<double> largest_early_, largest_now_;
  double early_until_ = 0.0;
  SourcePlan sources_;
  std::optional<double> next_known_;  ///< time at which something changes
  double jumped_at_ = 0.0;            ///< where something last did
  double strayed_at_ = 0.0;           ///< where a step last had to be made again for a loop's sake
  int strayed_ = 0;                   ///< how often there
  std::optional<SpentMode> spent_;
  double looked_at_time_ = 0.0;  ///< at the modes
  double integration_seconds_ = 0.0, output_seconds_ = 0.0, audit_seconds_ = 0.0;
};

RunResult Run::execute() {
  result_.trace.names = program_.output_names;
  result_.trace.units = program_.output_units;
  result_.trace.columns.resize(program_.output_names.size());
  if (!options_.rows) {
    result_.trace.times.reserve(inputs_.output_times.size());
    for (std::vector<double>& column : result_.trace.columns) column.reserve(inputs_.output_times.size());
  }
  row_.resize(program_.output_names.size());
  t_ = jumped_at_ = inputs_.start;

  double total = 0.0;
  {
    const Stopwatch watch(total);
    if (begin()) {
      if (program_.state_names.empty())
        follow_grid();
      else
        integrate();
    }
  }
  evaluator_.watch({});
  integration_seconds_ = total - output_seconds_ - audit_seconds_;
  report();
  return std::move(result_);
}

/// Initial states, modes and loops; everything that can be at fault before the first step.
bool Run::begin() {
  branch_ = first_branch(program_);
  evaluator_.set_time_modes(t_, branch_);
  x_ = initial_states(evaluator_, inputs_);
  y_.resize(x_.size() + evaluator_.tears());
  evaluator_.watch([this] { return clock_.look(); });
  std::vector<std::string> found;
  // The modes need the loops' solutions and these the modes. A loop whose solution is not found from 0 may have one
  // that is found from elsewhere.
  bool settled = events_.start(t_, x_.data(), branch_);
  if (!settled && evaluator_.explore_loops(t_, x_.data(), branch_, found))
    settled = events_.start(t_, x_.data(), branch_);
  if (!settled) return fail(*events_.failure());
  found.clear();
  if (!evaluator_.explore_loops(t_, x_.data(), branch_, found)) return fail_with_fault();
  for (std::string& line : found) result_.report.notes.push_back(std::move(line));
  if (!events_.settle(t_, x_.data(), branch_)) return fail(*events_.failure());

  note(negative_start_note(program_, x_));

  largest_early_.assign(x_.size(), 0.0);
  largest_now_.assign(x_.size(), 0.0);
  audited_ = t_;
  const Stopwatch watch(audit_seconds_);
  audit_.record_course(inputs_.output_times, options_.energy_course);
  audit_.begin(t_, x_.data(), branch_, inputs_.stop);
  return true;
}

/// False if the method asked for cannot be used on this system.
bool Run::choose_integrator() {
  RunReport& report = result_.report;
  const MethodFacts& facts = facts_of(inputs_.method);
  if (implicit_) {
    if (facts.family != MethodFamily::multistep) return fail(needs_explicit_form_failure(facts.name));
    integrator_ = make_ida_integrator(program_, evaluator_, tolerances_, inputs_);
    report.method_reason = inputs_.method == Method::ida ? "asked for"
                           : program_.plan.explicit_form ? "a loop is too large to be solved inside the state equations"
                                                         : "eliminating the loops would fill the Jacobian";
  } else {
    if (inputs_.method == Method::verlet) {
      NotSeparable obstacle;
      if (!separate(program_, obstacle)) return fail(not_separable_failure(program_, obstacle));
      integrator_ = make_verlet_integrator(program_, evaluator_, inputs_);
    } else if (facts.family == MethodFamily::multistep) {
      integrator_ = make_cvode_integrator(program_, evaluator_, tolerances_, inputs_);
    } else {
      integrator_ = make_arkode_integrator(program_, evaluator_, tolerances_, inputs_);
    }
    report.method_reason = inputs_.method != Method::automatic ? "asked for"
                           : program_.blocks.empty()           ? "state equations without loops"
                                                               : "loops are solved inside the state equations";
  }
  report.step = inputs_.step;
  return true;
}

/// Times at which to ask what the sources will do: spread over the scene, and just after its first known events.
std::vector<double> Run::source_times() {
  constexpr std::size_t kEvents = 3;
  std::vector<double> times;
  double t = t_;
  for (std::size_t i = 0; i < kEvents; ++i) {
    const auto event = evaluator_.next_time_event(t, inputs_.stop);
    if (!event) break;
    t = *event;
    times.push_back(t);
  }
  for (std::size_t i = 0; i < std::min(kEvents, sources_.pulses.size()); ++i)
    times.push_back(sources_.pulses[i].begin + (sources_.pulses[i].end - sources_.pulses[i].begin) / 2);
  for (const double part : {0.0137, 0.113, 0.379, 0.731}) times.push_back(t_ + part * (inputs_.stop - t_));
  return times;
}

bool Run::integrate() {
  if (!emit_here()) return false;
  if (!(inputs_.stop > t_)) return true;
  if (!choose_integrator()) return false;
  if (auto failure = implicit_ ? std::nullopt : too_fast_state(evaluator_, inputs_, x_.data(), branch_))
    return fail(std::move(*failure));
  sources_ = plan_sources(program_, inputs_.parameters, t_, inputs_.stop);
  if (const auto& pulse = sources_.too_narrow)
    return fail(narrow_pulse_failure(
        to_text(program_.pool, pulse->source, [&](SymbolId id) { return program_.symbol_names[id.index()]; }),
        pulse->when.begin, pulse->when.end - pulse->when.begin, pulse->wide_enough,
        only_element_of_time(*program_.model)));
  if (sources_.longest_step > 0.0) integrator_->limit_step(sources_.longest_step);
  pace_.know_sources(sources_.longest_step, sources_.frequency);
  tolerances_.know_edges(sources_.edges);
  tolerances_.estimate(evaluator_, t_, x_.data(), branch_, source_times());
  next_estimate_ = 20;
  looked_at_time_ = t_;
  while (t_ < inputs_.stop) {
    next_known_ = evaluator_.next_time_event(t_, inputs_.stop);
    if (const auto edge = sources_.next_edge(t_); edge && !(next_known_ && *next_known_ <= *edge)) next_known_ = edge;
    if (!integrate_to(next_known_.value_or(inputs_.stop))) return false;
    if (next_known_) {
      ++time_events_;
      jumped_at_ = t_;
      if (sources_.is_edge(t_)) tolerances_.forget_noise();
      if (!take_time_event()) return false;
      if (!events_.settle(t_, x_.data(), branch_)) return fail(*events_.failure());
    }
    if (!emit_here()) return false;
  }
  return true;
}

/// Modes beyond a known time. False where it is one at which a law divides by zero.
bool Run::take_time_event() {
  const std::vector<double> before = branch_.modes;
  evaluator_.set_time_modes(t_, branch_);
  for (std::size_t i = 0; i < program_.relations.size(); ++i)
    if (program_.relations[i].kind == Relation::Kind::pole && program_.relations[i].time_only &&
        branch_.modes[i] != before[i])
      return fail(pole_failure(program_, i, t_));
  return true;
}

/// To the next known time. State events on the way restart the integrator; x_ is the state at t_ in the end.
bool Run::integrate_to(double limit) {
  bool restart = true;
  while (t_ < limit) {
    if (restart) hold_or_not();
    if (restart && !integrator_->restart(t_, x_.data(), branch_, limit))
      return fail(fault_failure(integrator_->last_fault()));
    if (restart) branches_.begin(integrator_->branch());
    restart = false;
    if (!integrator_->advance()) {
      if (!rescue()) return fail_as_integrator();
      restart = true;
      continue;
    }
    ++steps_;
    if (auto jump = implicit_ ? std::nullopt : branches_.check(*integrator_)) {
      if (!go_back()) return fail(std::move(*jump));
      restart = true;
      continue;
    }
    if (!step_is_vital()) return fail_as_stuck("time no longer advances");
    switch (events_.search(*integrator_)) {
      case EventWatch::Search::failed:
        return fail(*events_.failure());
      case EventWatch::Search::found:
        if (!take_state_event()) return false;
        restart = true;
        break;
      case EventWatch::Search::none:
        if (!after_step()) return false;
        restart = limit_order();
    }
    if (!goes_on(t_)) return false;
  }
  return true;
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
  return true;
}

/// While signs are held at their border, the rates are what balances them.
void Run::hold_or_not() {
  if (!events_.holding()) return integrator_->use_rates({});
  integrator_->use_rates([this](double t, const double* x, Branch& branch, double* rates) {
    return events_.prepare(t, x, branch) && evaluator_.rates(t, x, branch, rates);
  });
}

/// To a time within the integrator's last step.
void Run::go_to(double t) {
  branch_ = integrator_->branch();
  integrator_->interpolate(t, y_.data(), branch_);
  branch_.given = false;
  std::copy_n(y_.begin(), x_.size(), x_.begin());
  t_ = t;
}

/// A step without events: account for it and go on.
bool Run::after_step() {
  const double t = integrator_->time();
  if (!emit_before(t)) return false;
  audit_to(t);
  go_to(t);
  remember_magnitudes(t);
  if (steps_ >= next_estimate_ && !implicit_) {
    next_estimate_ *= 8;
    tolerances_.estimate(evaluator_, t_, x_.data(), branch_, {});
  }
  return true;
}

/// BDF stays below the orders in which modes that are over would live on. True if the order fell just now: the
/// integrator has to start again. Looked at seldom: what it costs must not show in a run.
bool Run::limit_order() {
  constexpr std::uint64_t kFirst = 100, kMostBetween = 1000;
  const std::uint64_t since = steps_ - looked_at_step_;
  if (since < std::clamp(looked_at_step_, kFirst, kMostBetween)) return false;
  const double step = (t_ - looked_at_time_) / static_cast<double>(since);
  looked_at_step_ = steps_;
  looked_at_time_ = t_;
  const bool bdf = inputs_.method == Method::automatic || inputs_.method == Method::bdf;
  if (!bdf || implicit_ || inputs_.max_order > 0 || x_.size() > kDenseStates) return false;
  const auto spent = spent_mode(program_, evaluator_, t_, x_.data(), branch_, inputs_.stop - inputs_.start, step);
  if (!spent || (spent_ && spent_->order <= spent->order)) return false;
  spent_ = spent;
  integrator_->limit_order(spent->order);
  return true;
}

bool Run::take_state_event() {
  const double t = events_.event_time();
  // The moment is known to within its roundings: an output time as near as that shows what comes after.
  constexpr double kLocated = 100.0 * std::numeric_limits<double>::epsilon();
  if (!emit_before(t - kLocated * std::abs(t))) return false;
  audit_to(t);
  go_to(t);
  jumped_at_ = t;
  if (!events_.cross(x_.data(), branch_)) return fail(*events_.failure());
  return emit_here();
}

/// False when the steps have become so small that they are roundings of the time. After a restart some are normal: a
/// state at zero with a strong push starts with steps that move it by no more than its tolerance.
bool Run::step_is_vital() {
  constexpr double kRoundings = 100.0;
  constexpr std::uint64_t kPatience = 1000, kPatienceWithNone = 30;
  const double step = integrator_->step();
  const bool tiny = step < kRoundings * std::numeric_limits<double>::epsilon() * std::abs(integrator_->time());
  tiny_steps_ = tiny ? tiny_steps_ + 1 : 0;
  empty_steps_ = step > 0.0 ? 0 : empty_steps_ + 1;
  return tiny_steps_ < kPatience && empty_steps_ < kPatienceWithNone;
}

/// A model without states: its outputs on the grid.
bool Run::follow_grid() {
  result_.report.method = "none (no states)";
  result_.report.method_reason = "nothing is stored";
  const auto evaluate = [this](double t, Branch& branch) { return evaluator_.initialize_modes(t, x_.data(), branch); };
  const auto reach = [&](double t) {
    while (audited_ < t) {
      const double to = evaluator_.next_time_event(audited_, t).value_or(t);
      if (to < t) ++time_events_;
      const Stopwatch watch(audit_seconds_);
      constexpr int kSmooth = 12;
      audit_.add(audited_, to, kSmooth, branch_, [&](double at, double*, Branch& branch) { evaluate(at, branch); });
      audited_ = to;
    }
    if (!evaluate(t, branch_)) return fail_with_fault();
    t_ = t;
    return true;
  };
  for (std::size_t i = 0; i < inputs_.output_times.size(); ++i) {
    const double t = inputs_.output_times[i];
    if (!reach(t) || !emit_here() || !goes_on(t)) return false;
  }
  return t_ >= inputs_.stop || reach(inputs_.stop);
}

bool Run::emit_before(double t) {
  if (next_output_ >= inputs_.output_times.size() || !(inputs_.output_times[next_output_] < t)) return true;
  probe_ = integrator_->branch();
  while (next_output_ < inputs_.output_times.size() && inputs_.output_times[next_output_] < t) {
    const Stopwatch watch(output_seconds_);
    integrator_->interpolate(inputs_.output_times[next_output_], y_.data(), probe_);
    if (!emit_row(inputs_.output_times[next_output_], y_.data(), probe_)) return false;
  }
  return true;
}

/// At the point that the run has reached.
bool Run::emit_here() {
  if (next_output_ >= inputs_.output_times.size() || !(inputs_.output_times[next_output_] <= t_)) return true;
  probe_ = branch_;
  while (next_output_ < inputs_.output_times.size() && inputs_.output_times[next_output_] <= t_) {
    const Stopwatch watch(output_seconds_);
    if (!emit_row(inputs_.output_times[next_output_], x_.data(), probe_)) return false;
  }
  return true;
}

bool Run::emit_row(double t, const double* y, Branch& branch) {
  if (!events_.prepare(t, y, branch) || !evaluator_.outputs(t, y, branch, row_.data())) return fail_with_fault();
  if (options_.rows) {
    options_.rows(t, row_);
  } else {
    result_.trace.times.push_back(t);
    for (std::size_t i = 0; i < row_.size(); ++i) result_.trace.columns[i].push_back(row_[i]);
  }
  ++next_output_;
  ++result_.rows;
  clock_.reach(t);
  return clock_.end() == RunClock::End::none || t >= inputs_.stop || end_here(t);
}

void Run::audit_to(double t) {
  if (!audit_.measuring()) return;
  const Stopwatch watch(audit_seconds_);
  audit_.add(audited_, t, integrator_->order(), integrator_->branch(), [this](double at, double* y, Branch& branch) {
    integrator_->interpolate(at, y, branch);
    events_.prepare(at, y, branch);
  });
  audited_ = t;
}

bool Run::fail(Diagnostic diagnostic) {
  // What fails after its time is over fails because nothing is evaluated any more.
  if (clock_.end() != RunClock::End::none) return end_here(t_);
  result_.stop = StopReason::failed;
  result_.failure = std::move(diagnostic);
  return false;
}

/// What may go on although the integrator gave up: past a border that the laws on this side end at, or, once, with a
/// fresh start where a kink spoiled what the integrator remembered.
bool Run::rescue() {
  constexpr std::uint64_t kStepsBetween = 10;
  if (clock_.end() != RunClock::End::none || integrator_->failure().too_accurate) return false;
  if (integrator_->failure().fault) {
    std::vector<double> tolerance(x_.size());
    for (std::size_t i = 0; i < x_.size(); ++i) tolerance[i] = tolerances_.absolute(i);
    if (events_.take_across(t_, x_.data(), branch_, tolerance)) return true;
  }
  if (steps_ < rescued_at_ + kStepsBetween) return false;
  rescued_at_ = steps_;
  return true;
}

bool Run::fail_as_integrator() {
  const Integrator::Failure& failure = integrator_->failure();
  if (failure.too_accurate) return fail(accuracy_failure(t_, inputs_.relative));
  return fail_as_stuck(failure.words);
}

/// The cause is the law without a value just ahead, if there is one; else what the states show.
bool Run::fail_as_stuck(const std::string& words) {
  constexpr double kJustAhead = 1e-6;
  const StuckPoint point = stuck_point(words);
  const Fault& fault = integrator_->last_fault();
  const bool faulty = integrator_->failure().fault || (fault.kind != Fault::Kind::none &&
                                                       std::abs(fault.time - t_) <= kJustAhead * (t_ - inputs_.start));
  if (const auto pole = events_.pole_ahead(t_, x_.data(), branch_)) return fail(pole_failure(program_, *pole, t_));
  return fail(faulty && !recognise_blow_up(point) ? fault_failure(fault) : stuck_failure(point));
}

StuckPoint Run::stuck_point(const std::string& words) {
  StuckPoint point;
  point.t = t_;
  point.start = inputs_.start;
  point.words = words;
  point.names = program_.state_names;
  for (const StateInfo& state : program_.states) point.places.emplace_back(state.place);
  point.places.resize(y_.size());
  for (const ProgramBlock& block : program_.blocks)
    std::fill_n(point.places.begin() + static_cast<std::ptrdiff_t>(x_.size() + block.first_tear), block.size,
                block.place);
  if (implicit_) point.names.insert(point.names.end(), program_.tear_names.begin(), program_.tear_names.end());
  point.y.assign(y_.size(), 0.0);
  std::copy(x_.begin(), x_.end(), point.y.begin());
  point.rate.resize(x_.size());
  probe_ = branch_;
  if (!evaluator_.rates(t_, x_.data(), probe_, point.rate.data())) point.rate.clear();
  std::copy(probe_.tears.begin(), probe_.tears.end(), point.y.begin() + static_cast<std::ptrdiff_t>(x_.size()));
  point.largest_early = largest_early_;
  point.weighted_error.assign(integrator_->size(), 0.0);
  integrator_->weighted_errors(point.weighted_error.data());
  return point;
}

/// Magnitudes in the first half of the run so far, to tell sudden growth from size.
void Run::remember_magnitudes(double t) {
  const double elapsed = t - inputs_.start;
  if (elapsed > 2.0 * early_until_) {
    largest_early_ = largest_now_;
    early_until_ = elapsed;
  }
  for (std::size_t i = 0; i < x_.size(); ++i) largest_now_[i] = std::max(largest_now_[i], std::abs(x_[i]));
}

bool Run::goes_on(double t) {
  if (options_.max_steps > 0 && steps_ >= options_.max_steps && t < inputs_.stop)
    return fail(step_limit_failure(t, inputs_.stop, options_.max_steps));
  clock_.reach(t);
  if (clock_.end() != RunClock::End::none && t < inputs_.stop) return end_here(t);
  if (!clock_.looked()) return true;
  auto reason =
      pace_.judge({clock_.seconds(), t, x_.data(), &branch_, steps_, result_.rows, events_.count(), time_events_,
                   jumped_at_, next_known_, events_.latest_relation(), integrator_.get(), !implicit_});
  return !reason || fail(std::move(*reason));
}

/// Ends the run because the caller asked for it or its time is over.
bool Run::end_here(double t) {
  const bool interrupted = clock_.end() == RunClock::End::interrupted;
  result_.stop = interrupted ? StopReason::interrupted : StopReason::failed;
  result_.failure = interrupted ? interrupted_failure(t) : time_limit_failure(t, inputs_.stop, options_.time_limit);
  return false;
}

void Run::note(const std::optional<std::string>& text) {
  if (text) result_.report.notes.push_back(*text);
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
    if (spent_) report.method_reason += "; " + spent_mode_words(*spent_);
    const Integrator::Counts counts = integrator_->counts();
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
    if (inputs_.method == Method::erk8) note(unseen_error_note(program_));
    if (result_.stop == StopReason::completed)
      note(fast_sources_note(sources_.frequency, inputs_.stop - inputs_.start, steps_));
  }
  report.loop_iterations = evaluator_.counts().loop_iterations;
  if (result_.failure && x_.empty() && !program_.state_names.empty()) {
    report.energy.why_not = "the run did not start";
  } else {
    const Stopwatch watch(audit_seconds_);
    report.energy = audit_.finish(t_, x_.data(), branch_);
    if (options_.energy_audit && !report.energy.done && clock_.end() != RunClock::End::none)
      report.energy.why_not = "the run was ended within a step";
    if (result_.stop == StopReason::completed) note(open_balance_note(report.energy, inputs_.relative));
  }
  report.stage_seconds = {
      {"integration", integration_seconds_}, {"outputs", output_seconds_}, {"audit", audit_seconds_}};
}

}  // namespace

RunResult simulate(const Program& program, const RunInputs& inputs, const SimulateOptions& options) {
  return Run(program, inputs, options).execute();
}

}  // namespace bgsim
