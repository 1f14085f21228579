#include <cvode/cvode.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "run/integrate/ode.hpp"

namespace bgsim {

Integrator::Counts& Integrator::Counts::operator+=(const Counts& other) {
  steps += other.steps;
  rates += other.rates;
  jacobians += other.jacobians;
  factorizations += other.factorizations;
  iterations += other.iterations;
  error_failures += other.error_failures;
  convergence_failures += other.convergence_failures;
  return *this;
}

Integrator::Integrator(double span) {
  constexpr int kOrdinary = 160;
  int exponent = 0;
  std::frexp(span, &exponent);
  if (std::abs(exponent) > kOrdinary) unit_ = std::ldexp(1.0, exponent - 1);
}

namespace {

/// How far Newton's iteration may stay from its solution, as a part of what the error test allows. With CVODE's own 0.1
/// stiff systems drift: a velocity that a controller holds is off to the same side in each step. Linear models cost
/// nothing more (docs/design/simulate.md).
constexpr double kNewtonPart = 0.03;

class CvodeIntegrator final : public OdeIntegrator {
 public:
  CvodeIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs)
      : OdeIntegrator(program, evaluator, tolerances, inputs.stop - inputs.start),
        adams_(inputs.method == Method::adams),
        max_order_(inputs.max_order),
        cvode_(make_cvode(context_.get(), adams_ ? CV_ADAMS : CV_BDF)) {}

  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    std::copy(x, x + size_, values(y_.get()));
    branch_ = branch;
    time_ = previous_ = t;
    limit_ = limit;
    if (!rates(t, x, values(scratch_.get()))) return fault(t);
    if (!initialized_) {
      initialize(t);
    } else {
      total_ += since_restart();
      CVodeReInit(cvode_.get(), t / unit_, y_.get());
    }
    CVodeSetStopTime(cvode_.get(), limit / unit_);
    CVodeSetInitStep(cvode_.get(), first_step_ / unit_);
    first_step_ = 0.0;
    failure_ = {};
    return true;
  }

  bool advance() override {
    failure_ = {};
    faulted_ = false;
    if (limit_is_at_hand()) return creep();
    previous_ = time_;
    double reached = time_ / unit_;
    const int flag = CVode(cvode_.get(), limit_ / unit_, y_.get(), &reached, CV_ONE_STEP);
    if (flag < 0) {
      failure_.words = cvode_words(flag, messages_.last_error);
      failure_.too_accurate = flag == CV_TOO_MUCH_ACC;
      failure_.fault = faulted_;
      return false;
    }
    crept_ = false;
    time_ = flag == CV_TSTOP_RETURN ? limit_ : reached * unit_;
    CVodeGetLastOrder(cvode_.get(), &order_);
    return true;
  }

  void limit_order(int order) override {
    max_order_ = order;
    if (initialized_) CVodeSetMaxOrd(cvode_.get(), max_order_);
  }

  void interpolate(double t, double* y) override {
    if (crept_ || CVodeGetDky(cvode_.get(), t / unit_, 0, scratch_.get()) != CV_SUCCESS) {
      std::copy(values(y_), values(y_) + size_, y);
      return;
    }
    std::copy(values(scratch_), values(scratch_) + size_, y);
  }

  [[nodiscard]] std::string method() const override {
    const std::string order = max_order_ > 0 ? " of order up to " + std::to_string(max_order_) : "";
    return std::string("CVODE ") + (adams_ ? "Adams" : "BDF") + order +
           (algebra_.pattern == nullptr ? ", dense" : ", KLU");
  }

  [[nodiscard]] Counts counts() const override {
    Counts counts = total_;
    return counts += since_restart();
  }

  void weighted_errors(double* error) override {
    const VectorHandle weight = make_vector(context_.get(), size_);
    CVodeGetEstLocalErrors(cvode_.get(), scratch_.get());
    CVodeGetErrWeights(cvode_.get(), weight.get());
    for (std::size_t i = 0; i < size_; ++i) error[i] = std::abs(values(scratch_)[i] * values(weight)[i]);
  }

 private:
  void initialize(double t) {
    void* memory = cvode_.get();
    CVodeSetErrHandlerFn(memory, &SolverMessages::capture, &messages_);
    CVodeInit(memory, &on_rates, t / unit_, y_.get());
    CVodeSetUserData(memory, this);
    CVodeWFtolerances(memory, &on_weights);
    CVodeSetLinearSolver(memory, algebra_.solver.get(), algebra_.matrix.get());
    CVodeSetJacFn(memory, &on_jacobian);
    CVodeSetMaxNumSteps(memory, std::numeric_limits<long>::max());
    CVodeSetMaxErrTestFails(memory, kMostErrorTestFailures);
    CVodeSetMaxHnilWarns(memory, -1);
    CVodeSetNonlinConvCoef(memory, kNewtonPart);
    if (longest_ > 0.0) CVodeSetMaxStep(memory, longest_ / unit_);
    if (max_order_ > 0) CVodeSetMaxOrd(memory, max_order_);
    initialized_ = true;
  }

  static int on_rates(double s, N_Vector y, N_Vector rates, void* self) {
    return static_cast<CvodeIntegrator*>(self)->scaled_rates(s, y, rates);
  }
  static int on_jacobian(double s, N_Vector y, N_Vector rates, SUNMatrix matrix, void* self, N_Vector moved, N_Vector,
                         N_Vector) {
    return static_cast<CvodeIntegrator*>(self)->scaled_jacobian(s, y, rates, matrix, moved);
  }
  static int on_weights(N_Vector y, N_Vector weight, void* self) {
    auto& me = *static_cast<CvodeIntegrator*>(self);
    double now = me.time_ / me.unit_, step = 0.0;
    CVodeGetCurrentTime(me.cvode_.get(), &now);
    CVodeGetCurrentStep(me.cvode_.get(), &step);
    me.weights(now, step, y, weight);
    return 0;
  }

  [[nodiscard]] Counts since_restart() const {
    Counts counts;
    if (!initialized_) return counts;
    void* memory = cvode_.get();
    CVodeGetNumSteps(memory, &counts.steps);
    CVodeGetNumRhsEvals(memory, &counts.rates);
    CVodeGetNumLinSolvSetups(memory, &counts.factorizations);
    CVodeGetNumErrTestFails(memory, &counts.error_failures);
    CVodeGetNumJacEvals(memory, &counts.jacobians);
    CVodeGetNumNonlinSolvIters(memory, &counts.iterations);
    CVodeGetNumStepSolveFails(memory, &counts.convergence_failures);
    return counts;
  }

  bool adams_;
  int max_order_;
  CvodeHandle cvode_;
};

}  // namespace

std::unique_ptr<Integrator> make_cvode_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                  const RunInputs& inputs) {
  return std::make_unique<CvodeIntegrator>(program, evaluator, tolerances, inputs);
}

}  // namespace bgsim
