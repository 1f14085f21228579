/// How small an error must be, state by state, when the model does not say.
#pragma once

#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "program/proportional.hpp"
#include "run/integrate/sundials.hpp"

namespace bgsim {

/// Error weights that know no unit: the absolute tolerance of a state is the relative one times the state's own scale,
/// which is the largest magnitude it had lately, and before it had any, what implicit Euler steps from here predict
/// (docs/theory.md). Values given by the scene are used as they are.
class Tolerances {
 public:
  /// @param implicit  the unknowns are states and tear variables (IDA), else states only.
  Tolerances(const Program& program, const RunInputs& inputs, bool implicit);

  /// Estimates the scales that are not known yet, from the point (t, x); @p times are further times at which sources
  /// may act, up to inputs.stop.
  void estimate(Evaluator& evaluator, double t, const double* x, const Branch& branch,
                const std::vector<double>& times);
  /// Times, in order, at which sources set in or end without a jump: what acts before them says nothing about later.
  void know_edges(std::vector<double> edges) { edges_ = std::move(edges); }
  /// At such a time: what rounding did to the rates before says nothing about them behind.
  void forget_noise();

  /// The first scale of a state that nothing was known to move. False: its tolerance is less than a double can hold.
  bool begin_with(std::size_t state, double scale);

  /// States that may shrink and grow again: the error of these is relative to what they are now.
  void know_proportional(Proportional states);

  /// From here on the unknowns are states and tear variables, or states only.
  void use_tears(bool use) {
    implicit_ = use;
    size_ = use ? floor_.size() : states_;
  }

  /// An accepted point: @p y are all unknowns, or the states. Scales are learnt from such points alone, not from the
  /// end of a step that is made again.
  void accept(double t, std::span<const double> y);
  /// Weights for the error test of a step from @p y, made with steps of about @p step.
  void weights(double t, double step, const double* y, double* weight);
  /// Where a new Jacobian is taken.
  struct Point {
    double t = 0.0;
    const double* y = nullptr;  ///< unknowns
    const Sparsity& pattern;    ///< of the Jacobian: of the rates by the states, or of residuals by all unknowns
    const double* entries = nullptr;
    const std::vector<double>& rounding;  ///< of the rates there; empty: it is measured by shaking the unknowns
    const double* slopes = nullptr;       ///< rates of the unknowns where what is evaluated are residuals
  };
  /// How fast each unknown forgets, by the Jacobian's diagonal; what rounding makes of the rates: a rate that is the
  /// difference of large terms is no better known than these, and no step size makes it so; and what rounding in others
  /// makes of them: a store fed by rounding need not be followed as if it were signal.
  /// @param evaluate  rates or residuals.
  void see(const Point& at, const std::function<bool(double t, const double* y, double* rates)>& evaluate);

  /// What a rounding of the states changes the loops' solutions by, by tear variable: a difference of large terms is no
  /// better known than these.
  void see_loops(std::span<const double> changes);

  /// Of a snapshot. Given tolerances and edges follow from the scene.
  template <class Archive>
  void carry(Archive& archive) {
    archive("reach", reach_);
    archive("step", step_);
    archive("largest", largest_);
    archive("recent", recent_);
    archive("earlier", earlier_);
    archive("window start", window_start_);
    archive("floor", floor_);
    archive("noise", noise_);
    archive("time noise", time_noise_);
    archive("shift", shift_);
    archive("damping", damping_);
    archive("inherited noise", inherited_noise_);
    archive("stages", stages_);
    archive("caps", cap_);
  }

  [[nodiscard]] double relative() const { return relative_; }
  /// Of the linear systems of the last estimate(); zero for few states, and where none was needed.
  [[nodiscard]] const SolverCost& solver_cost() const { return solver_cost_; }
  [[nodiscard]] double absolute(std::size_t unknown) const;
  /// The same without what rounding leaves open, where that was last seen: a step may have seen it beyond an event.
  [[nodiscard]] double resolved(std::size_t unknown) const;
  /// Whether the error test of the last step took notice of an unknown: not of one that is 0 and has no scale.
  [[nodiscard]] bool watched(std::size_t unknown) const { return watches_all_ || watched_[unknown]; }
  [[nodiscard]] bool watches_all() const { return watches_all_; }
  [[nodiscard]] double largest(std::size_t unknown) const { return largest_[unknown]; }
  [[nodiscard]] bool given(std::size_t state) const { return given_[state] >= 0.0; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  void add_estimate(std::size_t stage, const std::vector<double>& magnitude);
  void reach(double elapsed);
  void cap_proportional(const double* y);
  [[nodiscard]] double resolved(std::size_t unknown, double size) const;
  [[nodiscard]] double absolute(std::size_t unknown, double size) const;
  [[nodiscard]] double unknowable(std::size_t unknown) const;
  using Evaluate = std::function<bool(double t, const double* y, double* rates)>;
  void bound_noise(const Point& at);
  void shake(const Point& at, const Evaluate& evaluate);
  void see_time(const Point& at, const Evaluate& evaluate);
  void pass_on(const Point& at);

  const Program& program_;
  bool implicit_;
  std::size_t states_, size_;
  double relative_, start_, span_;
  double reach_ = 0.0;  ///< the floor holds for this distance from the start
  double step_ = 0.0;   ///< latest step
  std::vector<double> edges_;
  std::vector<double> given_;             ///< by unknown; negative: not given
  std::vector<double> largest_;           ///< magnitudes so far
  std::vector<double> recent_, earlier_;  ///< magnitudes since window_start_, and in the window before it
  double window_start_ = 0.0;             ///< elapsed time
  Proportional proportional_;
  std::vector<std::uint32_t> capped_;                  ///< the states that are among them
  std::vector<double> floor_;                          ///< scale for unknowns that were smaller so far
  std::vector<double> shaken_, rates_, shaken_rates_;  ///< scratch
  std::vector<double> noise_;       ///< rounding errors of the rates per unit of time; of loops' variables: their own
  std::vector<double> time_noise_;  ///< the same by rounding of time
  std::vector<double> shift_;       ///< what a rounding of time does to the unknown at most
  std::vector<double> damping_;     ///< rate at which the unknown forgets
  std::vector<double> inherited_noise_, next_inherited_noise_;  ///< rounding of others, passed on, per unit of time
  std::vector<std::vector<double>> stages_;                     ///< predicted magnitudes by length of the Euler step
  std::vector<double> cap_;                                     ///< by unknown: its scale is not above this
  std::vector<double> size_of_group_;
  bool watches_all_ = true;
  std::vector<bool> watched_;  ///< by unknown, at the beginning of the last step, if not all are
  SolverCost solver_cost_;
};

}  // namespace bgsim
