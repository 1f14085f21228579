/// An integrator by one of SUNDIALS' packages: what does not depend on the equations, nor on how a step is taken.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "run/integrate/border_slopes.hpp"
#include "run/integrate/integrator.hpp"
#include "run/integrate/packages.hpp"

namespace bgsim {

/// What it works with, by any package.
class SundialsObjects : public Integrator {
 public:
  [[nodiscard]] const double* end() const override { return values(y_); }

 protected:
  /// @param size  number of unknowns; @param pattern  of their Jacobian.
  SundialsObjects(const Program& program, Evaluator& evaluator, Tolerances& tolerances, double span, std::size_t size,
                  const Sparsity& pattern);

  /// Notes why a point was refused; SUNDIALS then tries a shorter step.
  int recoverable(double t);
  void note_fault(double t);
  /// The limit is too near for an integrator that measures time in roundings: the change is one of roundings, too.
  [[nodiscard]] bool limit_is_at_hand() const;
  /// Of unknown @p j at @p y, as the error test has it.
  [[nodiscard]] double tolerance_at(const double* y, std::size_t j) const {
    return tolerances_.relative() * std::abs(y[j]) + tolerances_.absolute(j);
  }
  /// The unknowns are moved to the limit without SUNDIALS.
  void moved_to_limit();
  [[nodiscard]] std::string linear_algebra() const {
    return algebra_.pattern == nullptr ? ", dense" : algebra_.along_trees ? ", along trees" : ", KLU";
  }

  const Program& program_;
  Evaluator& evaluator_;
  Tolerances& tolerances_;
  SolverMessages messages_;
  // freed in reverse order: SUNDIALS' memory, a member of the derived class, before what it uses
  ContextHandle context_;
  VectorHandle y_, scratch_;
  std::vector<double> entries_;
  std::vector<double> rounding_;  ///< of the rates, where the Jacobian was taken
  LinearAlgebra algebra_;
  BorderSlopes border_;
  bool initialized_ = false;
  bool faulted_ = false;  ///< a point within the step could not be evaluated
  bool by_hand_ = false;  ///< the last step was not SUNDIALS'
  double limit_ = 0.0;
  Counts total_;  ///< of all stretches before the last restart
};

/// The same with its memory in @p Package (Cvode, Arkode, Ida); @p Base is SundialsObjects or derived from it.
template <class Package, class Base>
class SundialsIntegrator : public Base {
 public:
  using Counts = Integrator::Counts;

  void interpolate(double t, double* y) override {
    const bool inside = !by_hand_ && t != time_;
    const bool known = inside && Package::interpolate(memory(), t / unit_, 0, scratch_.get()) == Package::kSuccess;
    const double* from = values(known ? scratch_ : y_);
    std::copy(from, from + size_, y);
  }

  [[nodiscard]] Counts counts() const override {
    Counts counts = total_;
    return counts += since_restart();
  }

  void weighted_errors(double* error) override {
    const VectorHandle weight = make_vector(context_.get(), size_);
    Package::local_errors(memory(), scratch_.get());
    Package::weights(memory(), weight.get());
    for (std::size_t i = 0; i < size_; ++i) error[i] = std::abs(values(scratch_)[i] * values(weight)[i]);
  }

 protected:
  using Base::algebra_, Base::border_, Base::by_hand_, Base::context_, Base::failure_, Base::faulted_,
      Base::first_step_, Base::initialized_, Base::limit_, Base::longest_, Base::messages_, Base::order_,
      Base::scratch_, Base::size_, Base::time_, Base::tolerances_, Base::total_, Base::unit_, Base::y_;
  using Base::Base;

  [[nodiscard]] void* memory() const { return memory_.get(); }
  /// The integrator that SUNDIALS hands to the functions that it calls.
  template <class Self>
  static Self& of(void* user) {
    return *static_cast<Self*>(static_cast<Integrator*>(user));
  }

  /// Once, after the package's own Init.
  void set_up() {
    Package::capture_errors(memory(), &SolverMessages::capture, &messages_);
    Package::set_user(memory(), static_cast<Integrator*>(this));
    Package::set_weights(memory(), &on_weights);
    Package::set_most_steps(memory(), std::numeric_limits<long>::max());
    Package::set_most_error_failures(memory(), kMostErrorTestFailures);
    if constexpr (requires { Package::set_most_warnings; }) Package::set_most_warnings(memory(), -1);
    initialized_ = true;
  }
  void set_longest_step() {
    if (longest_ > 0.0) Package::set_longest_step(memory(), longest_ / unit_);
  }
  template <class Jacobian>
  void set_newton(Jacobian* jacobian) {
    Package::set_linear_solver(memory(), algebra_.solver.get(), algebra_.matrix.get());
    Package::set_jacobian(memory(), jacobian);
  }

  /// Of a new stretch, after Init or ReInit.
  void set_limit() { Package::set_limit(memory(), limit_ / unit_); }
  void set_first_step() { Package::set_first_step(memory(), std::exchange(first_step_, 0.0) / unit_); }

  /// Takes what a step came to. False, with failure(), if there was none.
  bool stepped(int flag, double reached) {
    if (flag < 0) {
      failure_.words = flag_words<Package>(flag, messages_.last_error);
      failure_.too_accurate = flag == Package::kTooAccurate;
      failure_.fault = faulted_;
      return false;
    }
    by_hand_ = false;
    border_.stepped();
    time_ = flag == Package::kAtLimit ? limit_ : reached * unit_;
    if constexpr (requires { Package::last_order; }) Package::last_order(memory(), &order_);
    return true;
  }
  /// The equations could not be evaluated where a stretch begins.
  bool fault(double t) {
    Base::note_fault(t);
    failure_.fault = true;
    failure_.words = Package::kNoStart;
    return false;
  }

  [[nodiscard]] Counts since_restart() const {
    Counts counts;
    if (!initialized_) return counts;
    Package::steps(memory(), &counts.steps);
    Package::rates(memory(), &counts.rates);
    Package::error_failures(memory(), &counts.error_failures);
    if (!newton_) return counts;
    Package::factorizations(memory(), &counts.factorizations);
    Package::jacobians(memory(), &counts.jacobians);
    Package::iterations(memory(), &counts.iterations);
    Package::convergence_failures(memory(), &counts.convergence_failures);
    return counts;
  }

  typename Package::Handle memory_;
  bool newton_ = true;  ///< linear systems are solved

 private:
  static int on_weights(N_Vector y, N_Vector weight, void* self) {
    auto& me = of<SundialsIntegrator>(self);
    double now = me.time_ / me.unit_, step = 0.0;
    Package::current_time(me.memory(), &now);
    Package::current_step(me.memory(), &step);
    me.tolerances_.weights(now * me.unit_, step * me.unit_, values(y), values(weight));
    if (me.algebra_.weight) std::copy_n(values(weight), me.size_, me.algebra_.weight->begin());
    return 0;
  }
};

}  // namespace bgsim
