/// What the integrators with error-controlled steps of bgsim's own share.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "run/integrate/integrator.hpp"
#include "run/integrate/packages.hpp"
#include "run/tolerances.hpp"

namespace bgsim {

/// Steps that know nothing of the ones before, from y_ at time_ towards limit_.
class OwnSteps : public Integrator {
 public:
  [[nodiscard]] const double* end() const override { return y_.data(); }
  [[nodiscard]] Counts counts() const override { return counts_; }
  [[nodiscard]] bool one_step() const override { return true; }

 protected:
  static constexpr double kEps = std::numeric_limits<double>::epsilon();
  OwnSteps(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs,
           Loops loops = Loops::inside)
      : Integrator(inputs.stop - inputs.start),
        evaluator_(evaluator),
        tolerances_(tolerances),
        states_(program.state_names.size()),
        loops_(!program.blocks.empty() && loops == Loops::inside),
        given_(loops == Loops::unknowns && !program.tear_names.empty() && !program.plan.explicit_form) {
    tears_ = loops == Loops::unknowns ? program.tear_names.size() : 0;
    size_ = states_ + tears_;
    for (std::vector<double>* const vector : {&y_, &begin_, &weight_, &at_, &still_}) vector->assign(size_, 0.0);
  }

  /// What each restart begins with. False if loops that are unknowns have no solution.
  bool begin_at(double t, const double* x, const Branch& branch, double limit) {
    std::copy(x, x + states_, y_.begin());
    branch_ = branch;
    std::copy_n(branch.tears.begin(), tears_, y_.begin() + static_cast<std::ptrdiff_t>(states_));
    if (tears_ > 0 && !solve_loops(t, at_.data())) return false;
    begin_ = y_;
    time_ = previous_ = t;
    limit_ = limit;
    failure_ = {};
    faulted_ = by_hand_ = rejected_ = false;
    first_ = true;
    next_ = std::exchange(first_step_, 0.0);
    return true;
  }

  /// f, then -F where the loops are unknowns.
  bool rates(double t, const double* y, Branch& branch, double* out) {
    ++counts_.rates;
    if (tears_ == 0) return special_rates_ ? special_rates_(t, y, branch, out) : evaluator_.rates(t, y, branch, out);
    if (!evaluator_.residual(t, y, branch, still_.data(), out)) return false;
    for (std::size_t i = 0; i < size_; ++i) out[i] = -out[i];
    return true;
  }
  /// At y_: its loops' variables are where the search starts, and its result. F is 0 then.
  bool solve_loops(double t, double* out) {
    know_loops();
    branch_.given = false;
    const bool solved = evaluator_.rates(t, y_.data(), branch_, out);
    branch_.given = given_;
    if (!solved) return false;
    std::copy(branch_.tears.begin(), branch_.tears.end(), y_.begin() + static_cast<std::ptrdiff_t>(states_));
    std::fill_n(out + states_, tears_, 0.0);
    return true;
  }
  /// The branch at y_ where the loops are unknowns.
  void know_loops() {
    if (tears_ > 0) std::copy(y_.begin() + static_cast<std::ptrdiff_t>(states_), y_.end(), branch_.tears.begin());
  }
  /// The step fails where the equations have no value.
  void note_fault(double t) {
    faulted_ = true;
    last_fault_ = evaluator_.fault();
    last_fault_.time = t;
  }
  bool fault(double t) {
    note_fault(t);
    return fail(kStateEquationsText);
  }
  bool fail(const char* words) {
    failure_.words = words;
    failure_.fault = faulted_;
    return false;
  }

  /// Puts the solution into @p y if it is one that needs no dense output: an end of the last step, or of one by hand.
  bool is_end(double t, double* y) const {
    const bool at_end = by_hand_ || t == time_ || !(time_ > previous_);
    if (!at_end && t != previous_) return false;
    const std::vector<double>& from = at_end ? y_ : begin_;
    std::copy(from.begin(), from.end(), y);
    return true;
  }

  [[nodiscard]] bool limit_is_at_hand() const {
    const double resolution = 4.0 * kEps * std::max(std::abs(time_), std::abs(limit_));
    return limit_ - time_ <= resolution || is_nothing(limit_ - time_);
  }
  /// An explicit step over a stretch of a few roundings of the time.
  void step_by_hand(const std::vector<double>& rate) {
    begin_ = y_;
    for (std::size_t i = 0; i < states_; ++i) y_[i] += (limit_ - time_) * rate[i];
    previous_ = time_;
    time_ = limit_;
    order_ = 1;
    by_hand_ = true;
    ++counts_.steps;
  }

  /// Up to the limit in one step, or in two of one length, or what is wanted. A first step is no part of what time
  /// resolves: an event just before the limit may leave some roundings of the time.
  [[nodiscard]] double fit(double h) const {
    const double left = limit_ - time_, least = 16.0 * kEps * std::abs(time_);
    if (longest_ > 0.0) h = std::min(h, longest_);
    h = h >= left * (1.0 - 1e-10) ? left : 2.0 * h > left ? left / 2.0 : h;
    if (!first_ || h >= least) return h;
    return left <= 2.0 * least ? left : least;
  }

  Evaluator& evaluator_;
  Tolerances& tolerances_;
  std::size_t states_;  ///< of the unknowns, the first ones
  bool loops_;          ///< rates solve loops
  bool given_;          ///< no loop is solved but by the step's iteration
  double limit_ = 0.0;
  double next_ = 0.0;              ///< the next step, 0: not known
  std::vector<double> y_, begin_;  ///< at the end of the last step, and at its beginning
  std::vector<double> weight_;     ///< of errors, by state
  std::vector<double> at_;         ///< scratch
  std::vector<double> still_;      ///< zeros
  Branch branch_at_begin_;
  bool first_ = true;      ///< no step since the restart
  bool faulted_ = false;   ///< the latest evaluation failed: last_fault_
  bool by_hand_ = false;   ///< the last step was one
  bool rejected_ = false;  ///< a longer step was
  Counts counts_;
};

}  // namespace bgsim
