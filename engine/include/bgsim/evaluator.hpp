/// Evaluator: runs a Program for one set of parameters.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

struct Slice;

/// Where in an evaluation things went wrong.
struct Fault {
  enum class Kind : std::uint8_t { none, not_finite, outside_table, loop_singular, loop_no_convergence };
  Kind kind = Kind::none;
  double time = 0.0;
  std::string what;    ///< "sqrt(h) with h = -0.012": the expression and its arguments' values
  std::string target;  ///< what was computed: "the rate of tank.q", "output Q", "the loop through R1, R2"
  std::vector<std::string> elements;  ///< names of elements or signals
  std::optional<Place> place;
};

/// The discrete state of a run: which side every relation is on, and which solution every loop is on. A value: to go
/// back is to assign an old one.
struct Branch {
  std::vector<double> modes;    ///< by Program::relations
  std::vector<double> tears;    ///< by tear: a solution of the loops, where the search for the next one starts
  std::vector<double> largest;  ///< by tear: its largest magnitude in a solution so far, which is its scale
  /// The tears are unknowns of the integrator (implicit form): outputs, guards, powers and energies take them as they
  /// are instead of solving the loops.
  bool given = false;
};

/// Before anything is known: all modes and tears are 0.
Branch first_branch(const Program& program);

class KnownTimes;

/// Scratch memory for evaluations, and nothing else: results depend on the arguments alone. One per thread. After
/// construction the evaluations allocate nothing unless they fail.
class Evaluator {
 public:
  /// @param program     must outlive the evaluator.
  /// @param parameters  by ParameterId.
  Evaluator(const Program& program, std::span<const double> parameters);
  ~Evaluator();
  Evaluator(Evaluator&&) noexcept;

  /// For the next run with the same parameters: without faults, counts and what watch() was given. Known times that
  /// were found stay.
  void begin_again();

  /// From here on known times are looked for and kept in @p times, which must outlive the evaluator: together with
  /// other programs of the same model. Values of parameters are compared, and what has other ones is looked for by
  /// itself.
  void share_known_times(KnownTimes& times);

  [[nodiscard]] const Program& program() const;
  [[nodiscard]] std::size_t states() const;
  [[nodiscard]] std::size_t tears() const;

  // All evaluations return false at a fault (a result that is not finite, a loop without solution); fault() then tells.
  // They solve the loops from the branch's tears and leave the solution there; where there is none the branch is as
  // before.
  bool rates(double t, const double* x, Branch& branch, double* dxdt);
  /// Values by Program::jacobian_pattern.
  bool jacobian(double t, const double* x, Branch& branch, double* values);
  /// The same, and by state a bound of what rounding makes of the rate at this point, time, states and parameters being
  /// exact (running error analysis); none where the loops have too many tears for it. Some three evaluations more, and
  /// the square of the tears times the largest loop.
  bool jacobian(double t, const double* x, Branch& branch, double* values, std::vector<double>& rounding);
  /// The same, without a fault where a law has no slope, such as a root at 0: such values are no finite numbers.
  bool slopes(double t, const double* x, Branch& branch, double* values, std::vector<double>& rounding);
  /// By state what its rate changes by with time alone, the states being held and the loops solved. Its code is made
  /// when it is first asked for, and allocates then; nothing is evaluated where no rate names the time.
  bool time_slopes(double t, const double* x, Branch& branch, double* values);
  /// Whether any of them can be other than 0.
  [[nodiscard]] bool names_time();
  bool outputs(double t, const double* x, Branch& branch, double* values);

  /// Several points at once, on one branch: stages of a step, rows of a trace.
  struct Points {
    static constexpr std::size_t kMost = 4;
    std::size_t count = 0;  ///< 1 to kMost
    std::array<double, kMost> t{};
    std::array<const double*, kMost> x{};
    std::array<double*, kMost> values{};
  };
  /// The same values, in a third of the time for short routines. False, without a fault, if they have to be asked for
  /// one by one: there are loops to solve, the routine is long, a value is not finite, or the run is to end.
  bool rates(const Points& points, const Branch& branch);
  bool outputs(const Points& points, const Branch& branch);
  bool powers(const Points& points, const Branch& branch);
  /// Whether powers() may take several points at once, which does not change during a run.
  [[nodiscard]] bool powers_together() const;

  // Implicit form: y holds states, then tears; yp their derivatives. Of the branch, the modes alone matter.
  bool residual(double t, const double* y, const Branch& branch, const double* yp, double* r);
  /// dr/dy + cj dr/dyp by Program::implicit_pattern.
  bool residual_jacobian(double t, double cj, const double* y, const Branch& branch, double* values);

  /// Sign of the determinant of a loop's equations where they were last solved; 0 before. On the way along one solution
  /// it changes only at a fold.
  [[nodiscard]] int orientation(std::size_t block) const;
  /// Solves the loops from several starts and tells what was found: one line for each nonlinear loop. For the initial
  /// point. False if a loop has no solution from any start.
  bool explore_loops(double t, const double* x, Branch& branch, std::vector<std::string>& found);

  // Modes
  /// Number of root functions: one for each condition, sign and step, two for each floor and cell (time_only ones
  /// excluded).
  [[nodiscard]] std::size_t guard_count() const;
  /// Root functions at the branch's modes. Conditions, sign, step: the guard itself; floor and cell: distance to the
  /// lower, then to the upper border, positive inside.
  bool guards(double t, const double* x, Branch& branch, double* values);
  [[nodiscard]] std::size_t guard_relation(std::size_t guard) const;  ///< index into Program::relations
  /// Sets all modes by the point (t, x). False at a fault, or if the modes contradict each other.
  bool initialize_modes(double t, const double* x, Branch& branch);
  /// After root functions crossed zero: direction +1 rising, -1 falling, 0 not crossed, by guard.
  void cross(std::span<const int> direction, Branch& branch) const;
  /// Sets the time-only modes to their values at @p t (right-continuous). True if any changed.
  bool set_time_modes(double t, Branch& branch);
  /// Where a run goes on at @p t with the modes of @p branch: a time-only relation that has another one from the next
  /// double on has not changed yet, and is to be found by next_time_event(t, @p until).
  void go_on(double t, const Branch& branch, double until);
  /// The first time in (after, until] at which a time-only relation changes. None, too, when evaluations were ended.
  [[nodiscard]] std::optional<double> next_time_event(double after, double until);
  /// Time-only relations (indices into Program::relations) whose changes could not all be found, and from when on.
  [[nodiscard]] std::vector<std::pair<std::size_t, double>> undecided_relations() const;

  // Energy audit
  [[nodiscard]] std::size_t energy_parts() const;
  /// By energy part: power supplied by sources, taken in by the others; then what fields take in at each port
  /// (Program::first_port_power).
  bool powers(double t, const double* x, Branch& branch, double* values);
  /// How much of each of powers() at this point rounding can have made, by energy part: a bound to first order, loops
  /// and what is left of their residuals included. Costs some ten times as much, and a factorization of each loop.
  void power_rounding(double t, const double* x, Branch& branch, double* bounds);
  /// Energy of each store that has it in closed form, NaN for the other parts.
  bool stored(double t, const double* x, Branch& branch, double* energy);
  /// q or p of every store port: part i's are [first_displacement[i], first_displacement[i+1]).
  bool displacements(double t, const double* x, Branch& branch, double* values);
  /// Energy of a store that is given by laws: line integral of its efforts (flows) from one displacement to another.
  double energy_by_laws(std::size_t part, std::span<const double> from, std::span<const double> to) const;

  /// Values of the dependent stores, by EquationSystem::dependent.
  bool dependents(double t, const double* x, Branch& branch, double* values);
  /// How far each can be off where states and parameters are off by so much, and all operations are rounded.
  void dependent_rounding(double t, const double* x, Branch& branch, std::span<const double> state_errors,
                          std::span<const double> parameter_errors, double* bounds);

  /// How far the solution of each loop variable can be off where the states are rounded, and all operations are, as
  /// rates solve the loops; infinite where there is no solution, 0 of loops that no rate needs.
  void tear_rounding(double t, const double* x, Branch& branch, double* bounds);
  /// How far each output can be off at this point where the states are off by so much, and all operations are rounded.
  void output_rounding(double t, const double* x, Branch& branch, std::span<const double> state_errors, double* bounds);
  /// How far each of the values of diodes() can be off at this point where states and time are off by so much, and all
  /// operations are rounded.
  void diode_rounding(double t, const double* x, Branch& branch, std::span<const double> state_errors,
                      double time_error, double* bounds);
  /// By Program::switch_elements: 1 where a switch leaves the side that it is on in this program, else 0.
  bool switches(double t, const double* x, Branch& branch, double* values);
  /// Four values by Program::diode_elements: effort and flow, counted the way that it passes, threshold, and 1 where it
  /// may begin to conduct, else 0.
  bool diodes(double t, const double* x, Branch& branch, double* values);
  /// By Program::events: 1 where the condition holds, else 0.
  bool event_conditions(double t, const double* x, Branch& branch, double* values);
  /// What the events would set now, event by event.
  bool event_values(double t, const double* x, Branch& branch, double* values);
  /// By Program::delays: what is delayed now, and by how much.
  bool delayed(double t, const double* x, Branch& branch, double* values);
  /// By Program::delays: what the model says of a time before the start.
  bool delayed_before(double t, const double* x, Branch& branch, double* values);
  /// By Program::jump: the factors of its terms, then the effort of each C and the flow of each I.
  bool jump(double t, const double* x, Branch& branch, double* values);

  /// By Program::crossings: two values for each relation, which may be infinite or NaN.
  bool crossings(double t, const double* x, Branch& branch, double* values);

  // Transposed derivatives, of a program with a TransposedPlan.
  /// Takes the partials of rates, loops and outputs (or guards, or what events set) at a point, for the calls of
  /// pull_back that follow.
  enum class Rows : std::uint8_t { outputs, guards, sets };
  bool take_partials(double t, const double* x, Branch& branch, Rows rows);
  /// The gradient of a sum of rates and outputs (or guards) by states, parameters and time, with the loops' variables
  /// as functions of these: one pass backward, whatever the number of parameters. After take_partials.
  /// @param of_rates   weights by state; empty: all 0
  /// @param of_rows    weights by output, by relation, or by result of Program::event_values
  /// @param by_states  the gradient by state
  /// @param by_columns by TransposedPlan::columns, then by time
  void pull_back(std::span<const double> of_rates, std::span<const double> of_rows, std::span<double> by_states,
                 std::span<double> by_columns);

  /// The quantities of Program::must_not_jump, and how far each can be off if the time is off by @p time_error and all
  /// operations are rounded.
  bool continuous(double t, const double* x, Branch& branch, double time_error, double* values, double* bounds);

  /// By slot: values of what depends on parameters alone; the other slots hold anything.
  [[nodiscard]] std::span<const double> constants() const;

  /// Lets @p look be called now and then during the evaluations: it returns how many may pass until it is asked again.
  /// 0 ends them: each one fails from then on, without a fault, until watch() is called again. It must not evaluate.
  void watch(std::function<std::uint64_t()> look);

  [[nodiscard]] const Fault& fault() const;
  struct Counts {
    std::uint64_t rates = 0, jacobians = 0, loop_solves = 0, loop_iterations = 0;
  };
  [[nodiscard]] const Counts& counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Initial states of a run: independent stores as given (0 by default); given values of dependent stores are checked
/// against what the states determine.
/// @throws ModelError BG405 a dependent store's initial value contradicts the states that determine it (both named).
std::vector<double> initial_states(Evaluator& evaluator, const RunInputs& inputs);

/// Holds given initial values of dependent stores that @p slice leaves out against the states that determine them: the
/// run itself checks only those that it keeps.
/// @throws ModelError BG405 (see initial_states).
/// @note Free of cost where no such value is given.
void check_start(const std::shared_ptr<const Model>& model, const EquationSystem& system, const BlockOrder& order,
                 const Slice& slice, const RunInputs& inputs);

}  // namespace bgsim
