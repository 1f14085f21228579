#include "run/integrate/ode.hpp"

namespace bgsim {

namespace {

/// x' - f(t, x) = 0.
class IdaExplicitIntegrator final : public SundialsIntegrator<Ida, OdeIntegrator> {
 public:
  IdaExplicitIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs)
      : SundialsIntegrator(program, evaluator, tolerances, inputs.stop - inputs.start),
        rate_(make_vector(context_.get(), size_)),
        max_order_(inputs.max_order) {
    memory_ = make_ida(context_.get());
  }

  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    if (!begin(t, x, branch, limit)) return fault(t);
    N_VScale(unit_, scratch_.get(), rate_.get());
    if (!initialized_) {
      IDAInit(memory(), &on_residual, t / unit_, y_.get(), rate_.get());
      set_up();
      set_newton(&on_jacobian);
      set_longest_step();
      if (max_order_ > 0) Ida::set_order(memory(), max_order_);
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
    if (limit_is_at_hand()) return step_by_hand() || fault(time_);
    previous_ = time_;
    double reached = time_ / unit_;
    const int flag = IDASolve(memory(), limit_ / unit_, &reached, y_.get(), rate_.get(), IDA_ONE_STEP);
    return stepped(flag, reached);
  }

  [[nodiscard]] std::string method() const override {
    return std::string("IDA") + (max_order_ > 0 ? " of order up to " + std::to_string(max_order_) : "") +
           linear_algebra();
  }

 private:
  static int on_residual(double s, N_Vector y, N_Vector rate, N_Vector residual, void* self) {
    const int flag = of<IdaExplicitIntegrator>(self).scaled_rates(s, y, residual);
    if (flag == 0) N_VLinearSum(1.0, rate, -1.0, residual, residual);
    return flag;
  }

  static int on_jacobian(double s, double cj, N_Vector y, N_Vector rate, N_Vector, SUNMatrix matrix, void* self,
                         N_Vector moved, N_Vector rates, N_Vector) {
    auto& me = of<IdaExplicitIntegrator>(self);
    N_Vector at_y = rate;  // the rates at y, as far as the iteration has come
    if (me.special_rates_) {
      if (const int flag = me.scaled_rates(s, y, rates); flag != 0) return flag;
      at_y = rates;
    }
    if (const int flag = me.scaled_jacobian(s, y, at_y, matrix, moved); flag != 0) return flag;
    me.subtract_from(cj, matrix);
    return 0;
  }

  /// cj I - J, where the matrix holds J.
  void subtract_from(double cj, SUNMatrix matrix) const {
    const Sparsity& pattern = program_.jacobian_pattern;
    if (algebra_.pattern == nullptr) {
      for (std::size_t j = 0; j < size_; ++j) {
        double* column = dense_column(matrix, j);
        for (std::size_t i = 0; i < size_; ++i) column[i] = (i == j ? cj : 0.0) - column[i];
      }
      return;
    }
    double* entries = sparse_values(matrix, pattern);
    for (std::size_t j = 0; j < size_; ++j)
      for (auto k = static_cast<std::size_t>(pattern.column_start[j]);
           k < static_cast<std::size_t>(pattern.column_start[j + 1]); ++k)
        entries[k] = (static_cast<std::size_t>(pattern.row[k]) == j ? cj : 0.0) - entries[k];
  }

  VectorHandle rate_;
  int max_order_;
};

}  // namespace

std::unique_ptr<Integrator> make_ida_explicit_integrator(const Program& program, Evaluator& evaluator,
                                                         Tolerances& tolerances, const RunInputs& inputs) {
  return std::make_unique<IdaExplicitIntegrator>(program, evaluator, tolerances, inputs);
}

}  // namespace bgsim
