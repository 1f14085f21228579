#include <arkode/arkode_arkstep.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "run/integrate/butcher_tables.hpp"
#include "run/integrate/ode.hpp"

namespace bgsim {

double even_step(double from, double to, double longest) {
  // A quotient that is whole but for its rounding does not ask for one step more.
  constexpr double kRounding = 1e-9;
  const double steps = std::max(1.0, std::ceil((to - from) / longest * (1.0 - kRounding)));
  return (to - from) / steps;
}

namespace {

class ArkodeIntegrator final : public OdeIntegrator {
 public:
  ArkodeIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs)
      : OdeIntegrator(program, evaluator, tolerances, inputs.stop - inputs.start),
        facts_(facts_of(inputs.method)),
        fixed_step_(inputs.step),
        table_(butcher_table(inputs.method)),
        begin_(make_vector(context_.get(), size_)) {}

  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    std::copy(x, x + size_, values(y_.get()));
    branch_ = branch;
    time_ = previous_ = t;
    limit_ = limit;
    if (!rates(t, x, values(scratch_.get()))) return fault(t);
    if (!facts_.implicit() && !facts_.fixed_step()) look(t);
    begin_anew();
    if (facts_.fixed_step()) {
      const double length = even_step(t, limit, fixed_step_);
      left_ = static_cast<std::uint64_t>(std::llround((limit - t) / length));
      ARKStepSetFixedStep(arkode_.get(), length / unit_);
    }
    failure_ = {};
    return true;
  }

  bool advance() override {
    constexpr int kMostRetries = 60;
    failure_ = {};
    faulted_ = false;
    if (limit_is_at_hand()) return creep();
    previous_ = time_;
    N_VScale(1.0, y_.get(), begin_.get());
    // Roundings of the steps before go into the last one, instead of into one more.
    if (facts_.fixed_step() && left_-- == 1) ARKStepSetFixedStep(arkode_.get(), (limit_ - time_) / unit_);
    for (int attempt = 0;; ++attempt) {
      double reached = time_ / unit_;
      const int flag = ARKStepEvolve(arkode_.get(), limit_ / unit_, y_.get(), &reached, ARK_ONE_STEP);
      if (flag >= 0) {
        crept_ = false;
        time_ = flag == ARK_TSTOP_RETURN ? limit_ : reached * unit_;
        order_ = degree();
        if (!facts_.implicit() && !facts_.fixed_step() && ++steps_since_look_ >= kStepsBetweenLooks) look(time_);
        return true;
      }
      // ARKODE's explicit stages do not try again with a shorter step where the equations have no value.
      const bool retry = faulted_ && !facts_.implicit() && !facts_.fixed_step() && attempt < kMostRetries;
      if (!retry || !shorten()) return failed(flag);
    }
  }

  void interpolate(double t, double* y) override {
    const bool inside = !crept_ && t != time_;
    if (!inside || ARKStepGetDky(arkode_.get(), t / unit_, 0, scratch_.get()) != ARK_SUCCESS) {
      std::copy(values(y_), values(y_) + size_, y);
      return;
    }
    std::copy(values(scratch_), values(scratch_) + size_, y);
  }

  [[nodiscard]] std::string method() const override {
    std::string text = facts_.words;
    if (facts_.fixed_step()) text += ", steps of one length";
    if (facts_.implicit()) text += algebra_.pattern == nullptr ? ", dense" : ", KLU";
    return text;
  }

  [[nodiscard]] Counts counts() const override {
    Counts counts = total_;
    return counts += since_restart();
  }

  void weighted_errors(double* error) override {
    const VectorHandle weight = make_vector(context_.get(), size_);
    ARKStepGetEstLocalErrors(arkode_.get(), scratch_.get());
    ARKStepGetErrWeights(arkode_.get(), weight.get());
    for (std::size_t i = 0; i < size_; ++i) error[i] = std::abs(values(scratch_)[i] * values(weight)[i]);
  }

 private:
  static constexpr int kStepsBetweenLooks = 50, kPredictorOfFullOrder = 1, kMostIterations = 6, kCubic = 3;

  /// ARKODE with the state as it is in y_, at time_.
  void begin_anew() {
    const double s = time_ / unit_;
    void* memory = arkode_.get();
    if (memory == nullptr) {
      create(s);
      memory = arkode_.get();
    } else {
      total_ += since_restart();
      ARKStepReInit(memory, facts_.implicit() ? nullptr : &on_rates, facts_.implicit() ? &on_rates : nullptr, s,
                    y_.get());
    }
    ARKStepSetStopTime(memory, limit_ / unit_);
    if (!facts_.fixed_step()) ARKStepSetInitStep(memory, first_step_ / unit_);
    first_step_ = 0.0;
  }

  void create(double s) {
    const bool implicit = facts_.implicit();
    arkode_ = make_arkode(context_.get(), implicit ? nullptr : &on_rates, implicit ? &on_rates : nullptr, s, y_.get());
    void* memory = arkode_.get();
    ARKStepSetErrHandlerFn(memory, &SolverMessages::capture, &messages_);
    ARKStepSetUserData(memory, this);
    ARKStepWFtolerances(memory, &on_weights);
    // ARKODE uses the order for nothing but the degree of the polynomial between the steps, one below it. With a
    // straight line for a method of order two, the state at an event would be wrong by what no error control has seen.
    if (facts_.order > 1) table_->q = std::max(facts_.order, kCubic + 1);
    ARKStepSetTables(memory, table_->q, table_->p, implicit ? table_.get() : nullptr,
                     implicit ? nullptr : table_.get());
    ARKStepSetMaxNumSteps(memory, std::numeric_limits<long>::max());
    ARKStepSetMaxErrTestFails(memory, kMostErrorTestFailures);
    ARKStepSetMaxHnilWarns(memory, -1);
    if (longest_ > 0.0 && !facts_.fixed_step()) ARKStepSetMaxStep(memory, longest_ / unit_);
    if (implicit) {
      ARKStepSetLinearSolver(memory, algebra_.solver.get(), algebra_.matrix.get());
      ARKStepSetJacFn(memory, &on_jacobian);
      // Hermite's polynomial takes the rates at the step's ends, and evaluated there they would magnify every error of
      // a stiff system: they are taken from the stages instead, and none is evaluated in between (degrees 4 and 5).
      ARKStepSetDeduceImplicitRhs(memory, 1);
      ARKStepSetInterpolantDegree(memory, kCubic);
      // Stages that begin from the polynomial through past steps, and a few iterations more than ARKODE's three: with
      // its trivial predictor the bellow's orifice costs eight times the steps at 1e-6.
      ARKStepSetPredictorMethod(memory, kPredictorOfFullOrder);
      ARKStepSetMaxNonlinIters(memory, kMostIterations);
    }
    initialized_ = true;
  }

  bool failed(int flag) {
    failure_.words = arkode_words(flag, messages_.last_error);
    failure_.too_accurate = flag == ARK_TOO_MUCH_ACC;
    failure_.fault = faulted_;
    return false;
  }

  /// Degree of the polynomial between the steps' ends.
  [[nodiscard]] int degree() const {
    if (facts_.order == 1) return 1;
    return facts_.implicit() ? kCubic : std::clamp(facts_.order - 1, kCubic, ARK_INTERP_MAX_DEGREE);
  }

  /// From the step's beginning again, with a quarter of the step. False when there is nothing left to be shortened.
  bool shorten() {
    double tried = 0.0;
    ARKStepGetCurrentStep(arkode_.get(), &tried);
    const double step = std::min(tried * unit_, limit_ - time_) / 4.0;
    if (!(step > std::numeric_limits<double>::epsilon() * std::abs(time_))) return false;
    N_VScale(1.0, begin_.get(), y_.get());
    begin_anew();
    ARKStepSetInitStep(arkode_.get(), step / unit_);
    return true;
  }

  /// Explicit methods have no use for the Jacobian, but the tolerances have: it tells what rounding leaves unknowable.
  void look(double t) {
    steps_since_look_ = 0;
    const double* x = values(y_);
    if (special_rates_ || !evaluator_.jacobian(t, x, branch_, entries_.data())) return;
    tolerances_.see_jacobian(program_.jacobian_pattern, entries_.data());
    tolerances_.see_noise([this](double at, const double* y, double* f) { return evaluator_.rates(at, y, branch_, f); },
                          t, x);
  }

  static int on_rates(double s, N_Vector y, N_Vector rates, void* self) {
    return static_cast<ArkodeIntegrator*>(self)->scaled_rates(s, y, rates);
  }
  static int on_jacobian(double s, N_Vector y, N_Vector rates, SUNMatrix matrix, void* self, N_Vector moved, N_Vector,
                         N_Vector) {
    return static_cast<ArkodeIntegrator*>(self)->scaled_jacobian(s, y, rates, matrix, moved);
  }
  static int on_weights(N_Vector y, N_Vector weight, void* self) {
    auto& me = *static_cast<ArkodeIntegrator*>(self);
    double now = me.time_ / me.unit_, step = 0.0;
    if (me.arkode_) {
      ARKStepGetCurrentTime(me.arkode_.get(), &now);
      ARKStepGetCurrentStep(me.arkode_.get(), &step);
    }
    me.weights(now, step, y, weight);
    return 0;
  }

  [[nodiscard]] Counts since_restart() const {
    Counts counts;
    if (!initialized_) return counts;
    void* memory = arkode_.get();
    long expl = 0, impl = 0;
    ARKStepGetNumSteps(memory, &counts.steps);
    ARKStepGetNumRhsEvals(memory, &expl, &impl);
    counts.rates = expl + impl;
    ARKStepGetNumErrTestFails(memory, &counts.error_failures);
    if (facts_.implicit()) {
      ARKStepGetNumLinSolvSetups(memory, &counts.factorizations);
      ARKStepGetNumJacEvals(memory, &counts.jacobians);
      ARKStepGetNumNonlinSolvIters(memory, &counts.iterations);
      ARKStepGetNumStepSolveFails(memory, &counts.convergence_failures);
    }
    return counts;
  }

  MethodFacts facts_;
  double fixed_step_;  ///< step of a fixed-step method
  ButcherTableHandle table_;
  VectorHandle begin_;  ///< state at the step's beginning
  ArkodeHandle arkode_;
  int steps_since_look_ = 0;
  std::uint64_t left_ = 0;  ///< steps of one length to the limit
};

}  // namespace

std::unique_ptr<Integrator> make_arkode_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                   const RunInputs& inputs) {
  return std::make_unique<ArkodeIntegrator>(program, evaluator, tolerances, inputs);
}

}  // namespace bgsim
