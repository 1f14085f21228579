#include <cvode/cvode.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "integrator.hpp"
#include "sundials.hpp"

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
  if (std::abs(exponent) > kOrdinary) unit_ = std::ldexp(1.0, exponent);
}

namespace {

class CvodeIntegrator final : public Integrator {
 public:
  CvodeIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, Method method, double span)
      : Integrator(span),
        program_(program),
        evaluator_(evaluator),
        tolerances_(tolerances),
        adams_(method == Method::adams),
        context_(make_context()),
        y_(make_vector(context_.get(), program.state_names.size())),
        scratch_(make_vector(context_.get(), program.state_names.size())),
        entries_(program.jacobian_pattern.row.size()),
        algebra_(program.state_names.size() <= kDenseStates
                     ? make_dense(context_.get(), y_.get())
                     : make_sparse(context_.get(), y_.get(), program.jacobian_pattern)),
        cvode_(make_cvode(context_.get(), adams_ ? CV_ADAMS : CV_BDF)) {
    size_ = program.state_names.size();
  }

  bool restart(double t, const double* x, double limit) override {
    std::copy(x, x + size_, values(y_.get()));
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
    failure_ = {};
    return true;
  }

  bool advance() override {
    failure_ = {};
    faulted_ = false;
    // Too near for an integrator that measures time in roundings: the change is one of roundings, too.
    const double resolution =
        4.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(time_), std::abs(limit_));
    if (limit_ - time_ <= resolution && fresh()) return creep();
    previous_ = time_;
    double reached = time_ / unit_;
    const int flag = CVode(cvode_.get(), limit_ / unit_, y_.get(), &reached, CV_ONE_STEP);
    if (flag < 0) {
      failure_.flag = flag;
      failure_.words = cvode_words(flag);
      failure_.too_accurate = flag == CV_TOO_MUCH_ACC;
      failure_.fault = faulted_;
      return false;
    }
    crept_ = false;
    time_ = flag == CV_TSTOP_RETURN ? limit_ : reached * unit_;
    CVodeGetLastOrder(cvode_.get(), &order_);
    return true;
  }

  void interpolate(double t, double* y) override {
    if (crept_ || CVodeGetDky(cvode_.get(), t / unit_, 0, scratch_.get()) != CV_SUCCESS) {
      std::copy(values(y_), values(y_) + size_, y);
      return;
    }
    std::copy(values(scratch_), values(scratch_) + size_, y);
  }

  [[nodiscard]] std::string method() const override {
    return std::string("CVODE ") + (adams_ ? "Adams" : "BDF") + (algebra_.pattern == nullptr ? ", dense" : ", KLU");
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
    initialized_ = true;
  }

  [[nodiscard]] bool fresh() const { return time_ == previous_; }

  /// An explicit step over a stretch of a few roundings of the time.
  bool creep() {
    if (!rates(time_, values(y_), values(scratch_.get()))) return fault(time_);
    for (std::size_t i = 0; i < size_; ++i) values(y_.get())[i] += (limit_ - time_) * values(scratch_)[i];
    previous_ = time_;
    time_ = limit_;
    order_ = 1;
    crept_ = true;
    return true;
  }

  bool fault(double t) {
    failure_.fault = true;
    last_fault_ = evaluator_.fault();
    last_fault_.time = t;
    failure_.words = "the state equations could not be evaluated";
    return false;
  }

  int recoverable(double t) {
    faulted_ = true;
    last_fault_ = evaluator_.fault();
    last_fault_.time = t;
    return 1;
  }

  bool rates(double t, const double* x, double* out) {
    return special_rates_ ? special_rates_(t, x, out) : evaluator_.rates(t, x, out);
  }

  /// The Jacobian of special rates, by differences.
  bool difference_jacobian(double t, const double* x, const double* at_x, SUNMatrix matrix) {
    const double root = std::sqrt(std::numeric_limits<double>::epsilon());
    std::vector<double> moved(x, x + size_);
    for (std::size_t j = 0; j < size_; ++j) {
      const double move = std::max(root * std::abs(x[j]), tolerances_.absolute(j));
      double* column = dense_column(matrix, j);
      std::fill(column, column + size_, 0.0);
      if (move == 0.0) continue;
      moved[j] = x[j] + move;
      if (!rates(t, moved.data(), column)) return false;
      for (std::size_t i = 0; i < size_; ++i) column[i] = (column[i] * unit_ - at_x[i]) / move;
      moved[j] = x[j];
    }
    return true;
  }

  static int on_rates(double s, N_Vector y, N_Vector rates, void* self) {
    auto& me = *static_cast<CvodeIntegrator*>(self);
    if (!me.rates(s * me.unit_, values(y), values(rates))) return me.recoverable(s * me.unit_);
    if (me.unit_ != 1.0) N_VScale(me.unit_, rates, rates);
    return 0;
  }

  static int on_jacobian(double s, N_Vector y, N_Vector rates, SUNMatrix matrix, void* self, N_Vector moved, N_Vector,
                         N_Vector) {
    auto& me = *static_cast<CvodeIntegrator*>(self);
    const Sparsity& pattern = me.program_.jacobian_pattern;
    const bool dense = me.algebra_.pattern == nullptr;
    const double t = s * me.unit_;
    if (me.special_rates_ && dense)
      return me.difference_jacobian(t, values(y), values(rates), matrix) ? 0 : me.recoverable(t);
    double* entries = dense ? me.entries_.data() : sparse_values(matrix, pattern);
    if (!me.evaluator_.jacobian(t, values(y), entries)) {
      // A slope without bound at a point that the solution only passes (sqrt at 0): take it a little further on.
      const double step = std::max(me.step(), 1e-9 * (me.limit_ - me.time_));
      N_VLinearSum(1.0, y, step / me.unit_, rates, moved);
      if (!me.evaluator_.jacobian(t, values(moved), entries)) return me.recoverable(t);
    }
    me.tolerances_.see_jacobian(pattern, entries);
    me.tolerances_.see_noise([&me](double at, const double* x, double* f) { return me.evaluator_.rates(at, x, f); }, t,
                             values(y));
    if (me.unit_ != 1.0)
      for (std::size_t i = 0; i < pattern.row.size(); ++i) entries[i] *= me.unit_;
    if (dense) scatter(matrix, pattern, entries);
    return 0;
  }

  static int on_weights(N_Vector y, N_Vector weight, void* self) {
    auto& me = *static_cast<CvodeIntegrator*>(self);
    double now = me.time_ / me.unit_, step = 0.0;
    CVodeGetCurrentTime(me.cvode_.get(), &now);
    CVodeGetCurrentStep(me.cvode_.get(), &step);
    me.tolerances_.weights(now * me.unit_, step * me.unit_, values(y), values(weight));
    return 0;
  }

  [[nodiscard]] Counts since_restart() const {
    Counts counts;
    if (!initialized_) return counts;
    long steps = 0, rates = 0, setups = 0, error_failures = 0, jacobians = 0, iterations = 0, failures = 0;
    CVodeGetNumSteps(cvode_.get(), &steps);
    CVodeGetNumRhsEvals(cvode_.get(), &rates);
    CVodeGetNumLinSolvSetups(cvode_.get(), &setups);
    CVodeGetNumErrTestFails(cvode_.get(), &error_failures);
    CVodeGetNumJacEvals(cvode_.get(), &jacobians);
    CVodeGetNumNonlinSolvIters(cvode_.get(), &iterations);
    CVodeGetNumStepSolveFails(cvode_.get(), &failures);
    const auto count = [](long n) { return static_cast<std::uint64_t>(n); };
    counts.steps = count(steps);
    counts.rates = count(rates);
    counts.jacobians = count(jacobians);
    counts.factorizations = count(setups);
    counts.iterations = count(iterations);
    counts.error_failures = count(error_failures);
    counts.convergence_failures = count(failures);
    return counts;
  }

  const Program& program_;
  Evaluator& evaluator_;
  Tolerances& tolerances_;
  bool adams_;
  SolverMessages messages_;
  // freed in reverse order: the integrator before what it uses
  ContextHandle context_;
  VectorHandle y_, scratch_;
  std::vector<double> entries_;
  LinearAlgebra algebra_;
  CvodeHandle cvode_;
  bool initialized_ = false, faulted_ = false, crept_ = false;
  double limit_ = 0.0;
  Counts total_;
};

}  // namespace

std::unique_ptr<Integrator> make_cvode_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                  Method method, double span) {
  return std::make_unique<CvodeIntegrator>(program, evaluator, tolerances, method, span);
}

}  // namespace bgsim
