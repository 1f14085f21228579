/// The evaluator's memory and the solving of loops; shared by evaluator.cpp, loops.cpp and modes.cpp.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "expression/time_event.hpp"
#include "program/known_times.hpp"
#include "program/lanes.hpp"
#include "program/loop_matrix.hpp"
#include "program/time_code.hpp"

namespace bgsim {

/// A pivot this much smaller than the largest one of the equilibrated matrix is rounding: the loop is singular.
inline constexpr double kSingularLoop = 1e-13;

/// Elements and variables of a loop that a message names; the rest is counted.
inline constexpr std::size_t kMostLoopNames = 8;
/// "the loop through a, b and 3 more"
std::string loop_words(const ProgramBlock& block);
/// "a.e = 1, b.f = 2 and 3 more", of the variables @p which
std::string tear_words(const ProgramBlock& block, std::span<const double> tears, std::span<const std::size_t> which);

/// Where a loop is looked for when nothing is known of its solution, all tears alike: 0, then both signs over many
/// decades (loops of any unit). Of a large loop only the first, if it leads somewhere.
std::vector<double> loop_starts();

/// Scratch memory of one loop.
struct LoopScratch {
  explicit LoopScratch(const ProgramBlock& block);
  LoopMatrix matrix;
  std::vector<double> partials;  ///< by entry
  Eigen::VectorXd residual, scaled, step, next_step, base, scale;
  std::vector<double> start, failed;  ///< tears before an iteration, and where it failed
  Eigen::MatrixXd by_states;          ///< d tears / d states, columns as in JacobianPlan::BlockPart::columns
};

struct Evaluator::Impl {
  Impl(const Program& p, std::span<const double> parameters);

  const Program& program;
  std::vector<double> slots;
  std::vector<double> symbol_values;  ///< by SymbolId: parameters and time, for relations of time alone
  std::vector<LoopScratch> loops;     ///< by block
  std::vector<double> largest;        ///< by tear: Branch::largest of the present evaluation
  Fault fault;
  Counts counts;
  std::vector<KnownTime> own_times;  ///< by relation
  std::vector<std::optional<RelationOfTime>>
      of_time;                          ///< by relation of time alone that reads no tables: once asked for
  std::vector<KnownTime*> known_times;  ///< by relation of time alone: its own, or one that several programs share
  // Where the plan's entries go in jacobian_pattern and implicit_pattern, and where tears' columns go
  std::vector<std::int64_t> explicit_rates, implicit_entries;
  std::vector<std::vector<std::int64_t>>
      explicit_tears;  ///< by entry of rates_by_tears: positions of the block's columns
  std::vector<std::vector<std::vector<std::uint32_t>>>
      earlier_columns;                                  ///< by block and entry: positions in own columns
  std::vector<std::vector<std::uint32_t>> own_columns;  ///< by block and entry of by_states: position in own columns
  std::vector<std::int64_t> implicit_diagonal;          ///< by state
  std::vector<double> guard_values;                     ///< by guarded relation
  std::function<std::uint64_t()> look;                  ///< see Evaluator::watch
  std::uint64_t until_look = std::numeric_limits<std::uint64_t>::max();

  /// Before evaluations at so many points. False when they were ended (Evaluator::watch).
  bool goes_on(std::uint64_t points = 1) {
    if (until_look <= points) return ask();
    until_look -= points;
    return true;
  }
  bool ask();

  /// That of a time-only relation.
  double mode_just_after(std::size_t relation, double t);
  /// False when evaluations were ended.
  /// @param held  its mode at @p after, where that is not the one just after it
  bool look_for_change(std::size_t relation, double after, double until, std::optional<double> held = {});
  /// Of what tables hold nothing may be kept: it may change with the run.
  RelationOfTime* relation_of_time(std::size_t relation);

  /// One after the other.
  void run(std::span<const Instruction> code);
  /// In strips, with the same values. (strips.cpp)
  void run(const CodeList& code);
  /// At several points at once; false if they are to be taken one by one.
  bool run(const Routine& routine, const Points& points, const Branch& branch);
  std::optional<Lanes> lanes;
  MachineCode made;
  /// Runs a routine at (t, x) on the branch, with its loops' tears as they are.
  bool run_given(const Routine& routine, double t, const double* x, const Branch& branch);
  /// The same with loops solved, and the solution left in the branch; false at a fault in a loop.
  bool run(const Routine& routine, double t, const double* x, Branch& branch);
  /// The implicit form: y holds states, then tears.
  bool run_implicit(const Routine& routine, double t, const double* y, const Branch& branch);
  /// As the branch says.
  bool run_or_given(const Routine& routine, double t, const double* x, Branch& branch) {
    return branch.given ? run_given(routine, t, x, branch) : run(routine, t, x, branch);
  }
  void set_point(double t, const double* x, const Branch& branch);
  /// Leaves the loops' solutions in the branch.
  void keep(Branch& branch) const;
  /// Copies results; false (and a fault worded with @p what) if one is not finite.
  bool take(const Routine& routine, double* values, const char* what, const std::vector<std::string>& names);

  enum class From : std::uint8_t { last_solution, guess };
  LoopOutcome solve(std::size_t block, From from = From::last_solution);
  LoopOutcome solve_linear(std::size_t block);
  enum class Steps : std::uint8_t { relative, resolved };
  static constexpr int kMostIterations = 300;  ///< an exponential law gives up one decade of its argument at a time
  LoopOutcome solve_newton(std::size_t block, Steps steps = Steps::relative, int most = kMostIterations);
  Eigen::VectorXd resolution(std::size_t block);
  [[nodiscard]] bool has_exponentials(std::size_t block) const;
  LoopOutcome solve_limited(std::size_t block, bool from_zero);
  LoopOutcome solve_smoothed(std::size_t block);
  LoopOutcome solve_bracketed(std::size_t block);
  LoopOutcome solve_downhill(std::size_t block);
  double residual_at(std::size_t block, double at);
  LoopOutcome bisect(std::size_t block, double low, double high);
  LoopOutcome factorize_smoothed(std::size_t block);
  /// The code of a loop, with rounded kinks where `smoothing` is set.
  void run_loop(const Routine& routine) {
    if (smoothing == 0.0)
      for (const auto& code : routine.code) run(code);
    else
      run_smoothed(routine);
  }
  void run_smoothed(const Routine& routine);
  double smoothing = 0.0;  ///< sqrt(x^2 + smoothing^2) stands for |x|
  LoopOutcome accept_by_rounding(std::size_t block);
  LoopOutcome factorize(std::size_t block, LoopMatrix::Pivots pivots = LoopMatrix::Pivots::new_ones);
  LoopOutcome factorize_partials(std::size_t block, double singular,
                                 LoopMatrix::Pivots pivots = LoopMatrix::Pivots::new_ones);
  LoopOutcome factorize_where_blocked(std::size_t block);
  LoopOutcome factorize_with_slopes(std::size_t block, double least, double singular);
  double residual_over_rounding(std::size_t block);
  [[nodiscard]] std::span<double> tears_of(std::size_t block) {
    const ProgramBlock& b = program.blocks[block];
    return {slots.data() + program.first_tear + b.first_tear, b.size};
  }
  /// Scaled size of a step of a loop's tears.
  static double scaled_norm(const Eigen::VectorXd& step, const Eigen::VectorXd& scale);
  bool load_residual(std::size_t block);
  struct Conditions {
    bool changed = false;
    bool open = false;  ///< one has no value
  };
  /// Sets modes, by relation, as the guards that have just run have it.
  Conditions take_conditions(double* modes) const;
  /// Conditions by loops and loops by conditions, in turn. (modes.cpp)
  bool settle_modes(double t, const double* x, Branch& branch);
  /// Loops and conditions at once; both are left in the branch. (free_modes.cpp)
  bool solve_with_conditions(double t, const double* x, Branch& branch);
  void follow_conditions();
  bool free_modes = false;  ///< each residual with the modes that hold where it is evaluated

  /// Bounds of what rounding has made of each slot: of what is computed once, of code that has just run, and of the
  /// tears of a block that has just been solved. What states, time and parameters are is exact. (rounding.cpp)
  std::vector<double> errors;
  void begin_errors(std::span<const double> of_parameters = {});
  void carry_errors(const CodeList& code);
  void carry_errors_through(std::size_t block);
  /// |inverse| of a loop's matrix, which is factorized, times bounds of its residuals.
  [[nodiscard]] Eigen::VectorXd pass_through(std::size_t block, const Eigen::VectorXd& of_residuals) const;
  /// Carries errors through a routine from where they are now; infinite ones if a loop has no solution.
  void carry_errors_of(const Routine& routine, Branch& branch, double* bounds);
  /// Bounds of the rates' and the tears' errors at the point that the plan's routine has just run at (loops solved and
  /// factorized).
  void bound_rates(std::vector<double>& bounds);
  bool pass_errors_through_loops(std::span<const double> of_residuals);
  Eigen::MatrixXd tears_by_residuals;  ///< d tears / d residuals, times the residuals' errors

  [[nodiscard]] bool of_parameters(ExprId expression) const;
  [[nodiscard]] std::string dependent_ports_words(ExprId quotient) const;
  void fail_at(std::uint32_t slot, const std::string& target);
  void fail_loop(std::size_t block, LoopOutcome outcome);
  [[nodiscard]] std::string text(ExprId expression) const;
  [[nodiscard]] int digits_without_value(ExprId expression) const;
  [[nodiscard]] std::uint32_t slot_of(ExprId expression) const;
  void describe_origin(ExprId expression);

  [[nodiscard]] double mode_for(const Relation& relation, double guard) const;
  Evaluator::Rows taken = Evaluator::Rows::outputs;  ///< of which partials were taken last
  std::vector<double> back_to_tears;                 ///< of pull_back
  std::unique_ptr<const TimeCode> time_code;         ///< once time_slopes was asked for
  std::vector<double> tears_by_time;                 ///< of time_slopes
  void begin_time_code();

  void prepare_positions();
  bool eliminate(double* values);
  bool slopes(double t, const double* x, Branch& branch, double* values);
  bool all_finite(double t, const double* values);
};

}  // namespace bgsim
