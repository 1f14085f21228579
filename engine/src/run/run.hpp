/// One run, as simulate() makes it: its parts, and where it is.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/simulate.hpp"
#include "run/choose.hpp"
#include "run/clock.hpp"
#include "run/event_log.hpp"
#include "run/failures.hpp"
#include "run/integrate/integrator.hpp"
#include "run/sink/energy_audit.hpp"
#include "run/sink/global_error.hpp"
#include "run/sink/magnitudes.hpp"
#include "run/sink/output_measures.hpp"
#include "run/sink/recorder.hpp"
#include "run/tolerances.hpp"
#include "run/variation.hpp"
#include "run/watch/branch_watch.hpp"
#include "run/watch/continuity_watch.hpp"
#include "run/watch/defect_watch.hpp"
#include "run/watch/delay_lines.hpp"
#include "run/watch/event_jumps.hpp"
#include "run/watch/events.hpp"
#include "run/watch/mode_order.hpp"
#include "run/watch/pace_limit.hpp"
#include "run/watch/schedule.hpp"
#include "run/watch/stiffness.hpp"
#include "run/watch/vitality.hpp"

namespace bgsim {

/// What the estimate of errors hands on from one mode to the next.
struct ErrorMemory {
  GlobalError::Sums sums;
  double late = 0.0;  ///< see GlobalError::Instant
  Stored exact;       ///< what the stores hold in the exact solution, at its own time
};

/// One run: a loop over stretches between known times, with watches that end or shorten them and sinks that take each
/// accepted step. All that goes on from a point is in the members that carry() names.
class Run {
 public:
  /// @param delayed    tables of the program's delayed signals, which the run fills
  /// @param evaluator  of the program with the inputs' parameters; none: the run makes its own
  Run(const Program& program, const RunInputs& inputs, const SimulateOptions& options, Clock clock,
      const DelayTables& delayed = {}, Evaluator* evaluator = nullptr)
      : program_(program),
        inputs_(inputs),
        options_(options),
        implicit_(begins_with_loops(program, inputs)),
        own_evaluator_(evaluator != nullptr ? nullptr : std::make_unique<Evaluator>(program, inputs.parameters)),
        evaluator_(evaluator != nullptr ? *evaluator : *own_evaluator_),
        clock_(options, std::move(clock), inputs.start),
        own_log_(options, inputs),
        tolerances_(program, inputs, implicit_),
        schedule_(program, evaluator_, inputs),
        events_(program, inputs, evaluator_, tolerances_, program.plan.explicit_form),
        jumps_(program, evaluator_, inputs),
        delays_(program, evaluator_, inputs, delayed),
        defects_(program, inputs, evaluator_, tolerances_),
        loops_(program, evaluator_, inputs.start, inputs.stop),
        continuity_(evaluator_, inputs.stop - inputs.start, inputs.relative),
        variations_(program.varied_states, false, inputs.stop - inputs.start),
        mode_order_(program, evaluator_, inputs),
        stiffness_(program, evaluator_, inputs, implicit_),
        pace_(program, evaluator_, inputs, options),
        errors_(program, evaluator_, tolerances_, inputs, options.error_estimate && program.delays.empty()),
        recorder_(program, evaluator_, events_, errors_, clock_, inputs, options, result_),
        audit_(program, evaluator_, inputs, options.energy_audit),
        measures_(program, inputs.parameters, evaluator_, options.measures),
        magnitudes_(program.state_names.size()) {}

  RunResult execute();

  /// Whether the run has ended before its time because a switch leaves the side that it is on in this program.
  [[nodiscard]] bool left_mode() const { return left_mode_; }
  /// Whether that was after a change of a condition on states, not at a known time or at the start.
  [[nodiscard]] bool left_by_states() const { return left_by_states_; }
  /// Before the start: see EventWatch.
  void know_at_border(std::vector<AtBorder> laws) { events_.know_at_border(std::move(laws)); }
  /// Resistors whose laws were held at their border at the end.
  [[nodiscard]] std::vector<AtBorder> held() const { return events_.held_laws(); }
  /// By Program::switch_elements: not 0 where one leaves it.
  [[nodiscard]] const std::vector<double>& leaving() const { return leaves_; }
  /// Of a program with variations: where it has left the mode.
  /// @param refused  BG414 if what made it leave has no instant that is known
  [[nodiscard]] std::optional<Departure> departure(std::optional<Diagnostic>& refused);
  /// Of a program with variations, where this run is one of many stretches: the states' derivatives are those at an
  /// instant that moves with what is varied by @p instant. @param first  of the stretches
  void know_instant(double instant, bool first) { instant_ = instant, follows_another_ = !first; }
  /// Four values by Program::diode_elements where it has left the mode (see Evaluator::diodes).
  [[nodiscard]] const std::vector<double>& diodes() const { return diodes_; }
  /// Of the model's events, from the stretch before and for the one after.
  void know_events(EventMemory memory) { jumps_.remember(std::move(memory)), known_events_ = true; }
  [[nodiscard]] const EventMemory& events() const { return jumps_.memory(); }
  /// Of the delayed signals, the same.
  void know_delays(DelayMemory memory) { delays_.remember(std::move(memory)); }
  [[nodiscard]] const DelayMemory& delays() const { return delays_.memory(); }
  /// Where this run is one of many stretches, the log of all of them; it must outlive the run.
  void share_log(EventLog& log) { log_ = &log; }
  /// Of the mode before, with the errors of this one's states; and of this one, if there is an estimate.
  void know_errors(ErrorMemory memory, std::vector<double> error);
  [[nodiscard]] std::optional<ErrorMemory> errors();
  /// Where this run is one of many stretches: so many steps the others have made. An interruption is looked for where
  /// there is a state to go on from only, if @p snapshots are wanted.
  /// @param next_snapshot  at so many steps of all of them
  void know_steps(std::uint64_t steps, std::uint64_t next_snapshot, bool snapshots) {
    steps_before_ = steps;
    next_snapshot_ = next_snapshot;
    late_watch_ = snapshots;
  }
  /// No step goes beyond this time; once.
  void stop_at(double t) { step_ends_ = t; }
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  /// Of all stretches: when the next snapshot is due.
  [[nodiscard]] std::uint64_t next_snapshot() const { return next_snapshot_; }
  /// How large the states have been in programs of other modes; by state.
  void know_scales(std::vector<double> scales) { known_scales_ = std::move(scales); }
  [[nodiscard]] double largest(std::size_t state) const { return tolerances_.largest(state); }
  [[nodiscard]] double tolerance(std::size_t state) const { return tolerances_.absolute(state); }

 private:
  bool begin();
  bool choose_integrator();
  bool plan();
  bool start_here(double limit);
  bool integrate();
  bool integrate_to(double limit);
  bool take_step();
  bool holds(const StepEnds& ends, double until, bool event);
  bool take_time_event();
  bool take_state_event();
  bool go_back();
  bool leave_law();
  bool rescue();
  bool eliminate_loops();
  bool take_multistep();
  bool iteration_stalls();
  void give_loops();
  void follow_stiffness();
  bool change_form(bool implicit);
  bool begin_events();
  bool settle_memory();
  bool settle_instant();
  bool stays_in_mode();
  bool take_events();
  void go_to(double t);
  bool bring_back();
  bool put_on_borders(double least);
  bool audit_to(double t);
  bool follow_grid();
  [[nodiscard]] bool at_end() const;
  bool look_before_end(const GuardSlopes& guards, const Branch& before);
  void look_beyond_end();
  bool vary_event(const Branch& before, std::optional<std::size_t> crossed);
  bool vary_sets(const std::vector<double>& before);
  /// Whether derivatives of the run are wanted, in it or of what is recorded: what has none ends it.
  [[nodiscard]] bool differentiates() const { return program_.varied_states > 0 || options_.trajectory != nullptr; }

  bool resume();
  void offer_snapshot();
  template <class Archive>
  void carry(Archive& archive);

  bool emit(Recorder::Outcome outcome);
  bool emit_here() { return emit(recorder_.at(t_, x_, branch_)); }
  [[nodiscard]] Integrator::Counts counts() const;
  bool goes_on();
  bool fail(Diagnostic diagnostic);
  bool fail_with_fault() { return fail(fault_failure(evaluator_.fault())); }
  bool fail_as_stuck(const std::string& words);
  bool end_here();
  void report();
  [[nodiscard]] Stored stored();
  [[nodiscard]] Stored stored_at(double t, const std::vector<double>& x);
  void note(const std::optional<std::string>& text);
  void note_undecided(std::string text);

  const Program& program_;
  const RunInputs& inputs_;
  const SimulateOptions& options_;
  bool implicit_;
  std::unique_ptr<Evaluator> own_evaluator_;
  Evaluator& evaluator_;
  RunResult result_;
  RunClock clock_;
  EventLog own_log_;
  EventLog* log_ = &own_log_;

  // Watches
  Tolerances tolerances_;
  Schedule schedule_;
  EventWatch events_;
  EventJumps jumps_;
  DelayLines delays_;
  DefectWatch defects_;
  BranchWatch loops_;
  ContinuityWatch continuity_;
  VariationEvents variations_;
  std::optional<Diagnostic> jump_;  ///< where the run was taken across a border
  Vitality vitality_;
  ModeOrder mode_order_;
  StiffnessWatch stiffness_;
  PaceLimit pace_;
  // Sinks
  GlobalError errors_;
  Recorder recorder_;
  EnergyAuditor audit_;
  OutputMeasures measures_;
  Magnitudes magnitudes_;

  std::unique_ptr<Integrator> integrator_;
  Integrator::Counts counts_before_;  ///< of the integrators before this one
  std::uint64_t loop_iterations_before_ = 0;
  bool fresh_ = true;  ///< the integrator has to be restarted where the run is

  // Where the run is
  double t_ = 0.0;  ///< reached; all events before are taken
  std::vector<double> x_;
  Branch branch_;
  bool due_ = false;                                ///< t_ is a known time, whose event is not taken yet
  bool between_ = false;                            ///< an event is being taken: not a point to go on from
  std::optional<double> given_at_, eliminated_at_;  ///< from here on loops are unknowns of the integrator, or not
  std::optional<double> multistep_at_;              ///< from here on `auto` is BDF, where it was a one-step method
  bool one_step_ = false;                           ///< it is Radau IIA or the explicit method now
  long failures_seen_ = 0;
  std::uint64_t steps_before_ = 0;  ///< of the stretches before this run
  bool late_watch_ = false;         ///< see know_steps()
  std::uint64_t steps_ = 0, next_look_ = 0, time_events_ = 0, next_estimate_ = 20, rescued_at_ = 0, next_snapshot_ = 0;
  std::optional<double> step_ends_;  ///< see stop_at()
  double jumped_at_ = 0.0;           ///< where something last changed at once
  double strayed_at_ = 0.0;          ///< where a step last had to be made again for a loop's sake
  int strayed_ = 0;                  ///< how often there
  std::optional<double> next_known_;
  std::vector<double> known_from_;  ///< states where the run began to go there
  std::vector<double> y_;           ///< scratch
  std::vector<double> leaves_, diodes_, known_scales_;
  bool known_events_ = false;
  bool left_mode_ = false, left_by_states_ = false, follows_another_ = false;
  double instant_ = 0.0;  ///< see know_instant()
  double integration_seconds_ = 0.0;
};

/// Why the method is what it is, after a run has changed the form of its loops.
std::string given_loops_words(double since);
std::string eliminated_loops_words(double since);

}  // namespace bgsim
