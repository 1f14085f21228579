#include <algorithm>
#include <cmath>

#include "run/integrate/residual_rounding.hpp"
#include "run/integrate/sundials_integrator.hpp"

namespace bgsim {

namespace {

class IdaIntegrator final : public SundialsIntegrator<Ida, SundialsObjects> {
 public:
  IdaIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs)
      : SundialsIntegrator(program, evaluator, tolerances, inputs.stop - inputs.start,
                           program.state_names.size() + program.tear_names.size(), program.implicit_pattern),
        states_(program.state_names.size()),
        rate_(make_vector(context_.get(), size_)),
        rounding_of_residuals_(program, evaluator, tolerances),
        max_order_(inputs.max_order) {
    tears_ = size_ - states_;
    memory_ = make_ida(context_.get());
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
    border_.begin();
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
      IDAReInit(memory(), t / unit_, y_.get(), rate_.get());
    }
    set_limit();
    set_first_step();
    failure_ = {};
    return true;
  }

  bool advance() override {
    failure_ = {};
    faulted_ = false;
    if (limit_is_at_hand()) return step_by_hand();
    previous_ = time_;
    double reached = time_ / unit_;
    const int flag = IDASolve(memory(), limit_ / unit_, &reached, y_.get(), rate_.get(), IDA_ONE_STEP);
    if (!stepped(flag, reached)) return false;
    std::copy(values(y_) + states_, values(y_) + size_, branch_.tears.begin());
    return true;
  }

  [[nodiscard]] std::string method() const override {
    return std::string("IDA") + (max_order_ > 0 ? " of order up to " + std::to_string(max_order_) : "") +
           linear_algebra();
  }

 private:
  void initialize(double t) {
    IDAInit(memory(), &on_residual, t / unit_, y_.get(), rate_.get());
    set_up();
    set_newton(&on_jacobian);
    set_longest_step();
    if (max_order_ > 0) Ida::set_order(memory(), max_order_);
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

  bool step_by_hand() {
    double* y = values(y_.get());
    for (std::size_t i = 0; i < size_; ++i) y[i] += (limit_ - time_) / unit_ * values(rate_)[i];
    std::copy(y + states_, y + size_, branch_.tears.begin());
    moved_to_limit();
    return true;
  }

  static int on_residual(double s, N_Vector y, N_Vector rate, N_Vector residual, void* self) {
    auto& me = of<IdaIntegrator>(self);
    const double t = s * me.unit_;
    N_Vector real_rate = rate;
    if (me.unit_ != 1.0) {
      real_rate = me.scratch_.get();
      N_VScale(1.0 / me.unit_, rate, real_rate);
    }
    return me.evaluator_.residual(t, values(y), me.branch_, values(real_rate), values(residual)) ? 0
                                                                                                 : me.recoverable(t);
  }

  static int on_jacobian(double s, double cj, N_Vector y, N_Vector yp, N_Vector residual, SUNMatrix matrix, void* self,
                         N_Vector, N_Vector, N_Vector) {
    auto& me = of<IdaIntegrator>(self);
    const Sparsity& pattern = me.program_.implicit_pattern;
    const bool dense = me.algebra_.pattern == nullptr;
    const double t = s * me.unit_;
    double* entries = dense ? me.entries_.data() : sparse_values(matrix, pattern);
    const auto evaluate = [&](const double* x, double* out) {
      return me.evaluator_.residual_jacobian(t, cj / me.unit_, x, me.branch_, out);
    };
    const bool known = evaluate(values(y), entries);
    if (known) me.rounding_of_residuals_.show(t, values(y), me.branch_, values(me.rate_), entries);
    // A state that is 0 and has no scale yet has that of what its rate moves it by within the step.
    const auto tolerance = [&](std::size_t j) {
      const double scale = j < me.states_ ? std::abs(values(yp)[j] - values(residual)[j]) / cj : 0.0;
      return std::max(me.tolerance_at(values(y), j), me.tolerances_.relative() * scale);
    };
    const bool replaced = me.border_.replace(values(y), tolerance, evaluate, entries, known);
    if (!known && !replaced) return me.recoverable(t);
    if (dense) scatter(matrix, pattern, entries);
    return 0;
  }

  std::size_t states_;
  VectorHandle rate_;
  ResidualRounding rounding_of_residuals_;
  int max_order_;
};

}  // namespace

std::unique_ptr<Integrator> make_ida_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                const RunInputs& inputs) {
  return std::make_unique<IdaIntegrator>(program, evaluator, tolerances, inputs);
}

}  // namespace bgsim
