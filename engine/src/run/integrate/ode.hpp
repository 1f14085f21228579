/// What the integrators of x' = f(t, x) by SUNDIALS share: rates, Jacobian, weights and faults.
#pragma once

#include <vector>

#include "run/integrate/integrator.hpp"
#include "run/integrate/sundials.hpp"

namespace bgsim {

class OdeIntegrator : public Integrator {
 public:
  [[nodiscard]] const double* end() const override { return values(y_); }

 protected:
  OdeIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, double span);

  bool rates(double t, const double* x, double* out) {
    return special_rates_ ? special_rates_(t, x, branch_, out) : evaluator_.rates(t, x, branch_, out);
  }

  // What SUNDIALS calls, in the integrator's own time s. Returns 0, or 1 for a point that cannot be evaluated.
  int scaled_rates(double s, N_Vector y, N_Vector rates);
  /// @param rates  at (s, y); @param moved  scratch.
  int scaled_jacobian(double s, N_Vector y, N_Vector rates, SUNMatrix matrix, N_Vector moved);
  /// @param now, step  in the integrator's own time.
  void weights(double now, double step, N_Vector y, N_Vector weight) {
    tolerances_.weights(now * unit_, step * unit_, values(y), values(weight));
  }

  /// The equations could not be evaluated where a stretch begins.
  bool fault(double t);
  /// Notes why a point was refused.
  int recoverable(double t);

  [[nodiscard]] bool fresh() const { return time_ == previous_; }
  /// Too near for an integrator that measures time in roundings: the change is one of roundings, too.
  [[nodiscard]] bool limit_is_at_hand() const;
  /// An explicit step over a stretch of a few roundings of the time.
  bool creep();

  const Program& program_;
  Evaluator& evaluator_;
  Tolerances& tolerances_;
  SolverMessages messages_;
  // freed in reverse order: the integrator, a member of the derived class, before what it uses
  ContextHandle context_;
  VectorHandle y_, scratch_;
  std::vector<double> entries_;
  LinearAlgebra algebra_;
  bool initialized_ = false, faulted_ = false, crept_ = false;
  double limit_ = 0.0;
  Counts total_;

 private:
  bool difference_jacobian(double t, const double* x, const double* at_x, SUNMatrix matrix);
};

}  // namespace bgsim
