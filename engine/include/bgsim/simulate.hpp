/// simulate: integrates a Program with SUNDIALS and reports what it took.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/modes.hpp"

namespace bgsim {

/// Time series of a run.
struct Trace {
  std::vector<std::string> names;  ///< without "t"
  std::vector<std::string> units;  ///< by name; empty where not known
  std::vector<double> times;
  std::vector<std::vector<double>> columns;  ///< by name, each at all times

  /// The column of that name; valid as long as the trace is.
  /// @throws std::out_of_range if there is none.
  [[nodiscard]] std::span<const double> operator[](std::string_view name) const;
};

/// The terms of the energy balance over time: each the integral from the run's start to that time, in EnergyAudit's
/// sense; what events bring is among what is supplied. Vectors of one length.
struct EnergyCourse {
  std::vector<double> times, supplied, stored, dissipated, exchanged, residual;
};

/// The energy balance of a run: supplied = change of stored + dissipated + residual. Every term is an integral over the
/// run (docs/theory.md). In joules if the model is in SI units.
struct EnergyAudit {
  bool done = false;  ///< false if switched off or not possible; `why_not` says why
  std::string why_not;
  double supplied = 0.0;           ///< by sources
  double stored = 0.0;             ///< change of stored energy
  double dissipated = 0.0;         ///< by R and RR
  double exchanged = 0.0;          ///< through modulated stores, whose energy is no function of their state alone
  double switching = 0.0;          ///< lost in jumps, where switches tie stores to each other or cut them off
  double impacts = 0.0;            ///< lost in impacts of contacts
  double events = 0.0;             ///< brought to the stores by events that set them; negative: taken
  double residual = 0.0;           ///< supplied + events - stored - dissipated - exchanged - switching - impacts
  double turnover = 0.0;           ///< largest of the terms' magnitudes and of the gross energy turned over
  double relative = 0.0;           ///< |residual| / turnover
  double least_dissipation = 0.0;  ///< smallest power of a single R or RR met; negative: an active element
  std::string least_dissipation_element;
  std::vector<double> activity;  ///< by EquationSystem::energy: integral of |power|; see activities()
  EnergyCourse course;           ///< empty unless asked for (SimulateOptions::energy_course)
};

/// What the outputs of a run are estimated to be wrong by, by output: the largest over the recorded times.
struct OutputErrors {
  /// Errors above this part of an output's range are noted.
  static constexpr double kLarge = 1e-4;
  bool done = false;     ///< false if switched off or not possible; `why_not` says why
  bool possible = true;  ///< false for systems of a kind for which there is none
  std::string why_not;
  std::vector<double> estimate, range, magnitude;  ///< error; largest less least value; largest magnitude
  std::vector<double>
      beyond_rounding;  ///< of the errors above kLarge, the largest to a factor of 2 that is no rounding
  /// Where no estimate can follow a run (switches, diodes, contacts, events, delays, errors that to first order come to
  /// more than an output varies by) the estimate is what a second run differs by, and this says how that was made: "at
  /// a tenth of the tolerance". At the times between the two runs' instants of one event the outputs are not compared.
  std::string second_run;
  /// Outputs whose errors, to first order, come to more than they vary by: `estimate` is what the second run differs
  /// by.
  std::vector<std::size_t> beyond_first_order;
  std::optional<double> instants;  ///< by how much the instants of events differ; none if there are no events
  std::string instants_of;         ///< the event that differs most

  /// Whether an output varies by no more than ten tolerances: it has no range that an error could be a part of.
  [[nodiscard]] bool is_still(std::size_t output, double relative) const {
    constexpr double kStill = 10.0;
    return !(range[output] > kStill * relative * magnitude[output]);
  }
};

/// What an output is over the whole run, measured on the dense output of every step and not at the output times. All in
/// the output's own unit, integrals in that (or its square) times t.
struct OutputMeasure {
  double initial = 0.0, final = 0.0;
  double least = 0.0, least_at = 0.0, most = 0.0, most_at = 0.0;  ///< the first time where it is reached
  double integral = 0.0, square = 0.0;                            ///< over time; of the square
  std::optional<double>
      nonzero_at;  ///< first time from which on it is not 0: of if(condition, 1, 0) the first that holds
};

/// What a run took. Machine-readable form: report_json.
struct RunReport {
  std::string model, scene;
  std::string method;         ///< "CVODE BDF, dense", "IDA, KLU", "none (no states)", ...
  std::string method_reason;  ///< why the engine chose it
  std::size_t states = 0, algebraic = 0, loops = 0;
  double step = 0.0;  ///< length of the steps of a fixed-step method, at most; else 0
  double relative = 0.0;
  std::vector<std::pair<std::string, double>> absolute;  ///< by state; as used at the end of the run
  double start = 0.0, stop = 0.0, reached = 0.0;
  std::uint64_t steps = 0, rate_evaluations = 0, jacobian_evaluations = 0, factorizations = 0, nonlinear_iterations = 0,
                error_test_failures = 0, convergence_failures = 0, loop_iterations = 0;
  std::uint64_t time_events = 0, state_events = 0;
  /// By event of the model: how often it took place, and the energy that it brought to the stores.
  struct SetEvent {
    std::string name;
    std::uint64_t count = 0;
    double energy = 0.0;
  };
  std::vector<SetEvent> set_events;
  bool switches = false;                      ///< the model has ideal switches
  bool contacts = false;                      ///< the model has contacts
  std::size_t accumulations = 0;              ///< how often one closed where infinitely many impacts add up
  std::uint64_t impacts = 0;                  ///< impulses that contacts took
  std::uint64_t mode_changes = 0, modes = 0;  ///< how often they changed sides; how many modes were met
  std::vector<std::pair<std::string, double>> stage_seconds;  ///< wall time by stage, in order
  EnergyAudit energy;
  OutputErrors errors;
  std::vector<OutputMeasure> measures;  ///< by output; empty unless asked for (SimulateOptions::measures), or lost
  std::string why_not_measured;         ///< the value that an output does not have within the run
  std::string energy_unit;              ///< what efforts times flows times t are in, if that is one unit and known
  LeftOut left_out;                     ///< what slice() took away before the run
  std::vector<std::string> notes;       ///< loops' starts and solutions, states never above their tolerance, ...
  /// Of the notes, those of what may have changed within steps without being seen: a smaller tolerance decides it.
  std::vector<std::string> undecided;
};

/// What the stores of a run hold at one time, by element and port, and the values of integrals. It means the same in
/// every program of the model, whatever the causality there.
struct Stored {
  double t = 0.0;
  std::vector<RunInputs::Initial>
      values;  ///< by element and port, then signal; empty if there is nothing to go on from
};

enum class StopReason { completed, interrupted, failed };

/// The other side of an event at the end of a run, whose instant moves with what is varied.
struct BesideEnd {
  std::vector<double> outputs;  ///< NaN: not known, in another mode or where the equations have no value
  bool sets = false;            ///< an event of the model would set states there, and what comes behind is not known
};

struct RunResult {
  Trace trace;             ///< names and units alone if the rows went to SimulateOptions::rows
  std::uint64_t rows = 0;  ///< times recorded
  RunReport report;
  StopReason stop = StopReason::completed;
  std::optional<Diagnostic> failure;  ///< BG6xx, set if stop is not completed
  Stored stored;                      ///< where the run ended: after its last accepted step
  Mode mode;                          ///< in which it ended; empty without switches
  /// Of a run with sensitivities; and when conditions, events and modes changed: outputs are smooth between these.
  std::vector<BesideEnd> beside_end;
  std::vector<double> instants;
};

/// Something that happened at one instant of a run.
struct RunEvent {
  enum class Kind : std::uint8_t {
    time,       ///< a condition on time alone changed
    condition,  ///< another condition changed
    event,      ///< an event of the model set a store or integral
    sample,     ///< a sampled signal took over its value
    latch,      ///< a latch changed
    switching,  ///< a switch changed its side
    diode,      ///< a diode began to conduct or to block
    contact,    ///< a contact opened or closed
    impact,     ///< a contact took an impulse
    jump,       ///< switches made a store jump
    start,      ///< not an event: the side `to` that a switch, diode or contact is on as the run begins
  };
  Kind kind = Kind::time;
  double t = 0.0;
  std::string name;      ///< of the condition (its text), event, signal, element, or store ("cap.q")
  std::string quantity;  ///< event: what it set, "mass.p"; start: "switch", "diode" or "contact"; else empty
  std::string from, to;  ///< sides ("open", "true"), or numbers that read back the same; impact: closing speeds
  std::optional<double> impulse;  ///< impact
  /// event: brought to the stores; impact, jump: lost. What several rows of one instant share stands in the first.
  /// None without an energy audit.
  std::optional<double> energy;
};

/// Takes each event as it happens. What it throws ends simulate().
using EventSink = std::function<void(const RunEvent&)>;

/// Called now and then with the simulated time; returns false to interrupt the run. Also called within a step that
/// takes long.
using Progress = std::function<bool(double time)>;

/// Takes a row of the trace as soon as it is known: the time and the outputs. What it throws ends simulate().
using RowSink = std::function<void(double time, std::span<const double> values)>;

class Trajectory;

struct SimulateOptions {
  bool energy_audit = true;
  bool error_estimate = true;
  /// Whether a Simulation makes a second run for it, where there are switches, events or delays, or where errors come
  /// to more than an output varies by. Without, errors are carried along to first order, but not over contacts and
  /// delays.
  bool second_run = true;
  bool measures = false;          ///< of the outputs over time; not of a run that is continued
  std::size_t energy_course = 0;  ///< also the audit's terms at about that many of the output times; 0: at none
  std::uint64_t max_steps = 0;    ///< 0: no limit
  double time_limit = 0.0;        ///< seconds of wall time; 0: no limit
  /// Seconds of wall time: a run whose headway says that it takes longer ends with BG617 (docs/design/simulate.md); 0:
  /// none does. Without effect if there is a time limit.
  double longest_run = 86400.0;
  Progress progress;
  RowSink rows;                                   ///< if given, the trace is not kept in memory
  EventSink events;                               ///< if given, takes what happens at single instants, in order
  std::function<void(const Diagnostic&)> remark;  ///< what is to be known while the run goes on: BG616
  /// Continues a run from a snapshot (see below) instead of starting one; empty: starts. The trace holds the rows after
  /// it; the report counts from the start of the first run.
  std::string resume;
  /// Takes snapshots, JSON texts from which the run can be continued: every snapshot_steps steps (0: none), and the
  /// last when the run is completed, was interrupted, or has reached its limit of steps or time (not within an event).
  /// The integrator restarts after each, so that a run goes on exactly as it does when resumed from there.
  std::function<void(double t, const std::string& snapshot)> snapshot;
  std::uint64_t snapshot_steps = 0;
  /// If given, takes the whole solution, for a run back over it (see sensitivities by the adjoint equations). What has
  /// no derivatives ends the run with BG414.
  Trajectory* trajectory = nullptr;
};

/// Integrates one scene. Radau IIA up to 50 states, else BDF with an analytic, sparse Jacobian, or an explicit method
/// where these are not stiff, unless the scene says otherwise; IDA where a loop is too large to be solved inside the
/// right-hand side. Known times end the step; conditions on states are located by root finding and the integration
/// restarts there. Dense output on the given times.
///
/// Memory does not grow with the number of output times if the rows go to a sink.
///
/// Never throws for numerical failure: the trace up to there is in the result, with a BG6xx failure that names element,
/// expression and time.
/// @throws ModelError BG405 (see initial_states); BG171 resume is no snapshot, or one of another model, scene or
/// method. std::invalid_argument for a program with diodes or contacts, whose sides Simulation::simulate finds, and for
/// an output time before the start.
RunResult simulate(const Program& program, const RunInputs& inputs, const SimulateOptions& options = {});

/// The inputs with which @p to, another program of the same model (other strokes, other outputs), goes on from where a
/// run ended: its states are what the stores hold there, and the first @p recorded output times are left out.
/// Conditions and loops follow from the states, as at any start; the integrator begins with short steps.
/// @throws std::invalid_argument if a state of @p to is none of those stored, as where the first program left it out;
/// if the first output time that is left is before the time of @p stored, as where @p recorded counts other times.
RunInputs continued(const RunInputs& inputs, const Stored& stored, std::size_t recorded, const Program& to);

/// Activity of an element: integral of |power| over the scene, a measure of what it contributes to the motion.
/// @cite louca2010 (activity index)
struct ElementActivity {
  ElementId element;
  double activity = 0.0;    ///< in joules if the model is in SI units
  double share = 0.0;       ///< of the sum over all elements
  double cumulative = 0.0;  ///< share of this element and all more active ones
};

/// Activities of all R, C, I and fields, the largest first; ties in model order. Sources are what the scene does to the
/// model and have none. The activity of a field is that of its whole power: what one port hands on to another does not
/// count.
/// @param result  of a run of @p program with its energy audit; empty if that was not done.
std::vector<ElementActivity> activities(const Program& program, const RunResult& result);

/// The report as JSON (stable keys; docs/reports.md) and as the lines printed after a run.
std::string report_json(const RunResult& result);
std::string report_text(const RunResult& result);

}  // namespace bgsim
