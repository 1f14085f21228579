/// What the integrators of x' = f(t, x) by SUNDIALS share: rates and Jacobian.
#pragma once

#include "run/integrate/sundials_integrator.hpp"

namespace bgsim {

class OdeIntegrator : public SundialsObjects {
 protected:
  OdeIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, double span)
      : SundialsObjects(program, evaluator, tolerances, span, program.state_names.size(), program.jacobian_pattern) {}

  /// Sets y_ and the branch; the rates there go to scratch_. False if they cannot be evaluated.
  bool begin(double t, const double* x, const Branch& branch, double limit);

  bool rates(double t, const double* x, double* out) {
    return special_rates_ ? special_rates_(t, x, branch_, out) : evaluator_.rates(t, x, branch_, out);
  }

  // What SUNDIALS calls, in the integrator's own time s. Returns 0, or 1 for a point that cannot be evaluated.
  int scaled_rates(double s, N_Vector y, N_Vector rates);
  /// @param rates  at (s, y); @param moved  scratch.
  int scaled_jacobian(double s, N_Vector y, N_Vector rates, SUNMatrix matrix, N_Vector moved);

  /// A new Jacobian.
  void see(const Tolerances::Point& at) {
    tolerances_.see(at, [this](double t, const double* x, double* f) { return evaluator_.rates(t, x, branch_, f); });
  }

  /// An explicit step to the limit, over a stretch of a few roundings of the time. False if the rates cannot be
  /// evaluated.
  bool step_by_hand();

 private:
  Branch aside_;  ///< scratch

  bool difference_jacobian(double t, const double* x, const double* at_x, SUNMatrix matrix);
};

/// With SUNDIALS' callbacks for @p Package (Cvode, Arkode).
template <class Package>
class OdeBy : public SundialsIntegrator<Package, OdeIntegrator> {
 protected:
  using By = SundialsIntegrator<Package, OdeIntegrator>;
  using By::By;

  static int on_rates(double s, N_Vector y, N_Vector rates, void* self) {
    return By::template of<OdeBy>(self).scaled_rates(s, y, rates);
  }
  static int on_jacobian(double s, N_Vector y, N_Vector rates, SUNMatrix matrix, void* self, N_Vector moved, N_Vector,
                         N_Vector) {
    return By::template of<OdeBy>(self).scaled_jacobian(s, y, rates, matrix, moved);
  }
};

}  // namespace bgsim
