/// What the steps of Radau IIA and Rodas5P share: errors that are filtered by a linear system, and slopes that let go.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "run/integrate/own_steps.hpp"
#include "run/integrate/radau_formula.hpp"

namespace bgsim {

class ImplicitSteps : public OwnSteps {
 public:
  void weighted_errors(double* error) override {
    for (std::size_t i = 0; i < size_; ++i) error[i] = std::abs(error_[i] * weight_[i]);
  }

 protected:
  ImplicitSteps(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs,
                Loops loops)
      : OwnSteps(program, evaluator, tolerances, inputs, loops) {
    for (std::vector<double>* const vector : {&rate_, &rate_at_begin_, &error_, &raw_, &increment_})
      vector->assign(size_, 0.0);
  }

  [[nodiscard]] double norm(const std::vector<double>& x) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < size_; ++i) sum += (x[i] * weight_[i]) * (x[i] * weight_[i]);
    return std::sqrt(sum / static_cast<double>(size_));
  }

  /// Time that no longer advances by the step is the run's matter as long as there is a step. One to the limit needs no
  /// resolution.
  [[nodiscard]] bool is_lost(double h) const { return h < limit_ - time_ && !(time_ + 0.1 * h > time_); }
  /// False, with the failure, where the tolerances are below the rounding of the states.
  bool is_resolved() {
    if (!(kEps * norm(y_) > 1.0)) return true;
    failure_.too_accurate = true;
    return fail(kTooAccurateText);
  }

  /// @return  the next length to try.
  double shorten(double h, double factor, const char* why) {
    ++counts_.convergence_failures;
    words_ = why;
    rejected_ = true;
    if (loops_) branch_ = branch_at_begin_;
    return factor * h;
  }

  /// From the rates and how fast they change.
  /// @param exponent  one over the order of the error that is held, and one
  /// @param looser    than the tolerance, which that error may be
  double first_step(double exponent, double looser) {
    const double left = limit_ - time_;
    tolerances_.weights(time_, left, y_.data(), weight_.data());
    std::fill(weight_.begin() + static_cast<std::ptrdiff_t>(states_), weight_.end(), 0.0);  // loops have no rates
    const double size = norm(y_) / looser, speed = norm(rate_) / looser;
    double probe = speed > 0.0 && size > 0.0 ? 0.01 * size / speed : 1e-6 * left;
    probe = std::min(probe, 1e-3 * left);
    probe_ = branch_;
    probe_.given = false;
    for (std::size_t i = 0; i < states_; ++i) at_[i] = y_[i] + probe * rate_[i];
    const bool known = tears_ > 0 ? evaluator_.rates(time_ + probe, at_.data(), probe_, error_.data())
                                  : rates(time_ + probe, at_.data(), probe_, error_.data());
    if (!known) return 1e-3 * probe;
    for (std::size_t i = 0; i < states_; ++i) error_[i] = (error_[i] - rate_[i]) / probe;
    const double bend = norm(error_) / looser;
    std::fill(error_.begin(), error_.end(), 0.0);
    const double h = radau::first_length(exponent, speed, bend, left);
    return longest_ > 0.0 ? std::min(h, longest_) : h;
  }

  /// The end of a step of length @p h that moves the states by @p increment; the loops are as the last stage left them.
  /// False if there are no rates.
  bool accept(double h, const std::vector<double>& increment, const Branch& last) {
    rate_at_begin_ = rate_;
    for (std::size_t i = 0; i < size_; ++i) y_[i] = begin_[i] + increment[i];
    const double end = h >= limit_ - time_ ? limit_ : time_ + h;
    if (loops_) branch_ = last;
    // Loops that are unknowns are solved once more, by what notices that a solution ends there.
    if (!(tears_ > 0 && !given_ ? solve_loops(end, rate_.data()) : rates_at_end(end))) {
      note_fault(end);
      y_ = begin_;
      rate_ = rate_at_begin_;
      know_loops();
      return false;
    }
    time_ = end;
    return true;
  }
  bool rates_at_end(double t) {
    know_loops();
    return rates(t, y_.data(), branch_, rate_.data());
  }
  void take_back() {
    y_ = begin_;
    rate_ = rate_at_begin_;
    time_ = previous_;
    if (loops_) branch_ = branch_at_begin_;
    know_loops();
  }

  /// Whether the slopes at an accepted step's end no longer damp what those at its beginning did: a filter as stiff as
  /// the beginning hides by how much the step missed the instant at which a fast state is let go (friction that breaks
  /// loose). The slopes along the error say so for one evaluation of the rates.
  /// @param shift  the linear system is shift M - h J (see RadauSystems)
  /// @param least  what the error may be before it is filtered
  bool lets_go(double h, double shift, double least) {
    constexpr double kDamped = 0.5;
    if (!(norm(raw_) > least)) return false;  // it would have passed without damping
    for (std::size_t i = 0; i < size_; ++i) at_[i] = y_[i] + error_[i];
    if (loops_) probe_ = branch_;
    if (!rates(time_, at_.data(), loops_ ? probe_ : branch_, increment_.data())) return false;
    for (std::size_t i = 0; i < states_; ++i) {
      const double damped = shift * error_[i] - h * (increment_[i] - rate_[i]);
      if (std::abs(raw_[i] * weight_[i]) > least && std::abs(damped) < kDamped * std::abs(raw_[i])) return true;
    }
    return false;
  }

  std::vector<double> rate_, rate_at_begin_;  ///< at the step's end and beginning
  std::vector<double> error_, raw_;           ///< its error, filtered and not
  double factored_ = 0.0;                     ///< step that the linear system is for; 0: none
  const char* words_ = kErrorTestText;        ///< of the last attempt that failed
  Branch probe_;                              ///< scratch
  std::vector<double> increment_;             ///< scratch
};

}  // namespace bgsim
