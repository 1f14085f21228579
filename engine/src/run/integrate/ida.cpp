#include <ida/ida.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "run/integrate/integrator.hpp"
#include "run/integrate/sundials.hpp"

namespace bgsim {

namespace {

class IdaIntegrator final : public Integrator {
 public:
  IdaIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs)
      : Integrator(inputs.stop - inputs.start),
        program_(program),
        evaluator_(evaluator),
        tolerances_(tolerances),
        states_(program.state_names.size()),
        context_(make_context()),
        y_(make_vector(context_.get(), states_ + program.tear_names.size())),
        rate_(make_vector(context_.get(), states_ + program.tear_names.size())),
        scratch_(make_vector(context_.get(), states_ + program.tear_names.size())),
        entries_(program.implicit_pattern.row.size()),
        algebra_(states_ + program.tear_names.size() <= kDenseStates
                     ? make_dense(context_.get(), y_.get())
                     : make_sparse(context_.get(), y_.get(), program.implicit_pattern)),
        ida_(make_ida(context_.get())),
        max_order_(inputs.max_order) {
    size_ = states_ + program.tear_names.size();
  }

  /// Consistent from the first: the loops are solved for these states, and x' follows from them. z' is the loops'
  /// answer to a small move along x', which spares IDA a first step full of surprises.
  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    double* y = values(y_.get());
    double* rate = values(rate_.get());
    std::copy(x, x + states_, y);
    time_ = previous_ = t;
    limit_ = limit;
    branch_ = branch;
    branch_.given = false;
    std::fill(rate, rate + size_, 0.0);
    if (!evaluator_.rates(t, x, branch_, rate)) return fault(t);
    std::copy(branch_.tears.begin(), branch_.tears.end(), y + states_);
    follow_tears(t);
    if (unit_ != 1.0) N_VScale(unit_, rate_.get(), rate_.get());
    branch_.given = true;
    if (!initialized_) {
      initialize(t);
    } else {
      total_ += since_restart();
      IDAReInit(ida_.get(), t / unit_, y_.get(), rate_.get());
    }
    IDASetStopTime(ida_.get(), limit / unit_);
    IDASetInitStep(ida_.get(), first_step_ / unit_);
    first_step_ = 0.0;
    failure_ = {};
    return true;
  }

  bool advance() override {
    failure_ = {};
    faulted_ = false;
    const double resolution =
        4.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(time_), std::abs(limit_));
    if (limit_ - time_ <= resolution && time_ == previous_) return creep();
    previous_ = time_;
    double reached = time_ / unit_;
    const int flag = IDASolve(ida_.get(), limit_ / unit_, &reached, y_.get(), rate_.get(), IDA_ONE_STEP);
    if (flag < 0) {
      failure_.words = ida_words(flag, messages_.last_error);
      failure_.too_accurate = flag == IDA_TOO_MUCH_ACC;
      failure_.fault = faulted_;
      return false;
    }
    crept_ = false;
    time_ = flag == IDA_TSTOP_RETURN ? limit_ : reached * unit_;
    IDAGetLastOrder(ida_.get(), &order_);
    std::copy(values(y_) + states_, values(y_) + size_, branch_.tears.begin());
    return true;
  }

  void interpolate(double t, double* y) override {
    if (crept_ || IDAGetDky(ida_.get(), t / unit_, 0, scratch_.get()) != IDA_SUCCESS) {
      std::copy(values(y_), values(y_) + size_, y);
      return;
    }
    std::copy(values(scratch_), values(scratch_) + size_, y);
  }

  [[nodiscard]] const double* end() const override { return values(y_); }
  [[nodiscard]] std::string method() const override {
    return std::string("IDA") + (max_order_ > 0 ? " of order up to " + std::to_string(max_order_) : "") +
           (algebra_.pattern == nullptr ? ", dense" : ", KLU");
  }

  [[nodiscard]] Counts counts() const override {
    Counts counts = total_;
    return counts += since_restart();
  }

  void weighted_errors(double* error) override {
    const VectorHandle weight = make_vector(context_.get(), size_);
    IDAGetEstLocalErrors(ida_.get(), scratch_.get());
    IDAGetErrWeights(ida_.get(), weight.get());
    for (std::size_t i = 0; i < size_; ++i) error[i] = std::abs(values(scratch_)[i] * values(weight)[i]);
  }

 private:
  void initialize(double t) {
    void* memory = ida_.get();
    IDASetErrHandlerFn(memory, &SolverMessages::capture, &messages_);
    IDAInit(memory, &on_residual, t / unit_, y_.get(), rate_.get());
    IDASetUserData(memory, this);
    IDAWFtolerances(memory, &on_weights);
    IDASetLinearSolver(memory, algebra_.solver.get(), algebra_.matrix.get());
    IDASetJacFn(memory, &on_jacobian);
    IDASetMaxErrTestFails(memory, kMostErrorTestFailures);
    IDASetMaxNumSteps(memory, std::numeric_limits<long>::max());
    if (longest_ > 0.0) IDASetMaxStep(memory, longest_ / unit_);
    if (max_order_ > 0) IDASetMaxOrd(memory, max_order_);
    initialized_ = true;
  }

  void follow_tears(double t) {
    if (size_ == states_) return;
    const double move = 1e-7 * (limit_ - t);
    double* y = values(y_.get());
    double* rate = values(rate_.get());
    double* moved = values(scratch_.get());
    std::vector<double> rates(states_);
    Branch there = branch_;
    for (std::size_t i = 0; i < states_; ++i) moved[i] = y[i] + move * rate[i];
    if (!evaluator_.rates(t + move, moved, there, rates.data())) return;
    for (std::size_t i = states_; i < size_; ++i) rate[i] = (there.tears[i - states_] - y[i]) / move;
  }

  bool creep() {
    double* y = values(y_.get());
    for (std::size_t i = 0; i < size_; ++i) y[i] += (limit_ - time_) / unit_ * values(rate_)[i];
    std::copy(y + states_, y + size_, branch_.tears.begin());
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
    failure_.words = "the equations could not be evaluated";
    return false;
  }

  int recoverable(double t) {
    faulted_ = true;
    last_fault_ = evaluator_.fault();
    last_fault_.time = t;
    return 1;
  }

  static int on_residual(double s, N_Vector y, N_Vector rate, N_Vector residual, void* self) {
    auto& me = *static_cast<IdaIntegrator*>(self);
    const double t = s * me.unit_;
    N_Vector real_rate = rate;
    if (me.unit_ != 1.0) {
      real_rate = me.scratch_.get();
      N_VScale(1.0 / me.unit_, rate, real_rate);
    }
    return me.evaluator_.residual(t, values(y), me.branch_, values(real_rate), values(residual)) ? 0
                                                                                                 : me.recoverable(t);
  }

  static int on_jacobian(double s, double cj, N_Vector y, N_Vector, N_Vector, SUNMatrix matrix, void* self, N_Vector,
                         N_Vector, N_Vector) {
    auto& me = *static_cast<IdaIntegrator*>(self);
    const Sparsity& pattern = me.program_.implicit_pattern;
    const bool dense = me.algebra_.pattern == nullptr;
    const double t = s * me.unit_;
    double* entries = dense ? me.entries_.data() : sparse_values(matrix, pattern);
    if (!me.evaluator_.residual_jacobian(t, cj / me.unit_, values(y), me.branch_, entries)) return me.recoverable(t);
    me.tolerances_.see_jacobian(pattern, entries);
    const double* rate = values(me.rate_);
    me.tolerances_.see_noise(
        [&](double at, const double* x, double* r) { return me.evaluator_.residual(at, x, me.branch_, rate, r); }, t,
        values(y), rate);
    if (dense) scatter(matrix, pattern, entries);
    return 0;
  }

  static int on_weights(N_Vector y, N_Vector weight, void* self) {
    auto& me = *static_cast<IdaIntegrator*>(self);
    double now = me.time_ / me.unit_, step = 0.0;
    IDAGetCurrentTime(me.ida_.get(), &now);
    IDAGetCurrentStep(me.ida_.get(), &step);
    me.tolerances_.weights(now * me.unit_, step * me.unit_, values(y), values(weight));
    return 0;
  }

  [[nodiscard]] Counts since_restart() const {
    Counts counts;
    if (!initialized_) return counts;
    void* memory = ida_.get();
    IDAGetNumSteps(memory, &counts.steps);
    IDAGetNumResEvals(memory, &counts.rates);
    IDAGetNumLinSolvSetups(memory, &counts.factorizations);
    IDAGetNumErrTestFails(memory, &counts.error_failures);
    IDAGetNumJacEvals(memory, &counts.jacobians);
    IDAGetNumNonlinSolvIters(memory, &counts.iterations);
    IDAGetNumStepSolveFails(memory, &counts.convergence_failures);
    return counts;
  }

  const Program& program_;
  Evaluator& evaluator_;
  Tolerances& tolerances_;
  std::size_t states_;
  SolverMessages messages_;
  // freed in reverse order: the integrator before what it uses
  ContextHandle context_;
  VectorHandle y_, rate_, scratch_;
  std::vector<double> entries_;
  LinearAlgebra algebra_;
  IdaHandle ida_;
  int max_order_;
  bool initialized_ = false, faulted_ = false, crept_ = false;
  double limit_ = 0.0;
  Counts total_;
};

}  // namespace

std::unique_ptr<Integrator> make_ida_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                const RunInputs& inputs) {
  return std::make_unique<IdaIntegrator>(program, evaluator, tolerances, inputs);
}

}  // namespace bgsim
