/// Whether `auto` goes on with an explicit method, in large systems: while the run goes on, by what steps cost.
#pragma once

#include <cstdint>

#include "bgsim/evaluator.hpp"
#include "run/integrate/fastest_mode.hpp"
#include "run/integrate/integrator.hpp"

namespace bgsim {

/// Takes the explicit method where its steps, held by the fastest mode, cost no more than BDF's. What a step costs is
/// counted in operations, not measured, so that a run is the same on each machine. Reasons: docs/design/simulate.md.
class StiffnessWatch {
 public:
  StiffnessWatch(const Program& program, Evaluator& evaluator, const RunInputs& inputs, bool implicit);

  /// At the start, after the tolerances were estimated. True if the explicit method begins.
  bool begin(double t, const double* x, const Branch& branch, const SolverCost& solver);
  /// At an accepted step, with the counts of the run so far. True if the run should change to the other method.
  bool look(double t, const double* x, const Branch& branch, const Integrator::Counts& counts);
  /// The explicit method has failed: never again.
  void give_up() { possible_ = is_explicit_ = false; }

  [[nodiscard]] bool is_explicit() const { return is_explicit_; }
  /// When the method now in use was taken; the start if it was at the start.
  [[nodiscard]] double since() const { return since_; }
  [[nodiscard]] int changes() const { return changes_; }
  /// The longest step in which the fastest mode is stable by the explicit method, where it was last looked at.
  [[nodiscard]] double stable_step() const { return stable_step_; }

  template <class Archive>
  void carry(Archive& archive) {
    archive("possible", possible_);
    archive("explicit", is_explicit_);
    archive("since", since_);
    archive("changes", changes_);
    archive("stable step", stable_step_);
    archive("solve", solver_.solve);
    archive("factor", solver_.factor);
    archive("phase", phase_);
    archive("next look", next_look_);
    archive("looked at step", looked_at_step_);
    archive("next sight", next_sight_);
    archive("looked at time", looked_at_time_);
    archive("step before", step_before_);
    archive("multistep cost", multistep_cost_);
    archive("multistep pace", multistep_pace_);
    archive("bound", bound_);
    archive("held", held_);
    archive("penalty", penalty_);
    archive("longest", longest_);
  }

 private:
  [[nodiscard]] double cost_of(const Integrator::Counts& counts) const;
  bool see_fastest_mode(double t, const double* x, const Branch& branch);
  bool look_at_multistep(double t, const double* x, const Branch& branch, double step, double cost);
  bool look_at_explicit(double t, const double* x, const Branch& branch, double step, double steps);
  void change(double t, const Integrator::Counts& counts);

  const Program& program_;
  Evaluator& evaluator_;
  double stop_;
  bool possible_;
  bool is_explicit_ = false;
  double since_ = 0.0;
  int changes_ = 0;
  double stable_step_ = 0.0;
  // Costs, in additions of numbers in a row
  double rates_cost_ = 0.0, explicit_step_ = 0.0;
  SolverCost solver_;
  Integrator::Counts phase_;  ///< of the run when the method was taken
  std::int64_t next_look_ = 0, looked_at_step_ = 0, next_sight_ = 0;
  double looked_at_time_ = 0.0, step_before_ = 0.0;
  double multistep_cost_ = 0.0;  ///< of a step by BDF
  double multistep_pace_ = 0.0;  ///< by BDF, per unit of time, where it was left; 0: never taken
  double bound_ = 0.0;           ///< of what the explicit method costs to the end, where it was taken; 0: none
  bool rings_ = false;           ///< the fastest mode, where it was last looked at
  double held_ = 0.0;            ///< what steps held by the fastest mode have cost since then
  double longest_ = 0.0;         ///< step of the explicit method so far
  double penalty_ = 1.0;         ///< grows with each change back to BDF
};

}  // namespace bgsim
