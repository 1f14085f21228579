#include <algorithm>
#include <cmath>

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

Integrator::Integrator(double span) : span_(span) {
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

class CvodeIntegrator final : public OdeBy<Cvode> {
 public:
  CvodeIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs)
      : OdeBy(program, evaluator, tolerances, inputs.stop - inputs.start),
        adams_(inputs.method == Method::adams),
        max_order_(inputs.max_order) {
    memory_ = make_cvode(context_.get(), adams_ ? CV_ADAMS : CV_BDF);
  }

  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    if (!begin(t, x, branch, limit)) return fault(t);
    if (!initialized_) {
      initialize(t);
    } else {
      total_ += since_restart();
      CVodeReInit(memory(), t / unit_, y_.get());
    }
    set_limit();
    set_first_step();
    failure_ = {};
    return true;
  }

  bool advance() override {
    failure_ = {};
    faulted_ = false;
    if (limit_is_at_hand()) return step_by_hand() || fault(time_);
    previous_ = time_;
    double reached = time_ / unit_;
    const int flag = CVode(memory(), limit_ / unit_, y_.get(), &reached, CV_ONE_STEP);
    return stepped(flag, reached);
  }

  void limit_order(int order) override {
    max_order_ = order;
    if (initialized_) Cvode::set_order(memory(), max_order_);
  }

  [[nodiscard]] std::string method() const override {
    const std::string order = max_order_ > 0 ? " of order up to " + std::to_string(max_order_) : "";
    return std::string("CVODE ") + (adams_ ? "Adams" : "BDF") + order + linear_algebra();
  }

 private:
  void initialize(double t) {
    CVodeInit(memory(), &on_rates, t / unit_, y_.get());
    set_up();
    set_newton(&on_jacobian);
    CVodeSetNonlinConvCoef(memory(), kNewtonPart);
    set_longest_step();
    if (max_order_ > 0) Cvode::set_order(memory(), max_order_);
  }

  bool adams_;
  int max_order_;
};

}  // namespace

std::unique_ptr<Integrator> make_cvode_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                  const RunInputs& inputs) {
  return std::make_unique<CvodeIntegrator>(program, evaluator, tolerances, inputs);
}

}  // namespace bgsim
