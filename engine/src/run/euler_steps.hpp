/// Implicit Euler steps from a point, of lengths that span a scene: what they move a state by is a first idea of its
/// size (Tolerances).
#pragma once

#include <vector>

#include "bgsim/evaluator.hpp"
#include "run/integrate/sundials.hpp"

namespace bgsim {

/// Solves (I - h J) d = h f at one point for several h, with or without the loops as unknowns of their own.
class EulerSystems {
 public:
  EulerSystems(const Program& program, bool implicit);

  /// What the matrices of a point are made of: df/dx, or the residuals' partials by unknowns. False where it does
  /// not exist.
  bool see(Evaluator& evaluator, double t, const double* y, Branch branch, std::vector<double>& jacobian) const;
  /// Where elimination would fill in, only when solve() needs it.
  bool factor(double h, const std::vector<double>& jacobian);
  /// @return  the change of the unknowns, until the next call; nullptr where the matrix is singular.
  const double* solve(double h, const std::vector<double>& rates);

  /// Zero for few states, and where no system was solved.
  [[nodiscard]] SolverCost cost() const;

 private:
  bool factor_now();

  ContextHandle context_ = make_context();
  VectorHandle right_, change_;
  LinearAlgebra algebra_;
  const Program& program_;
  const Sparsity& pattern_;
  bool implicit_;
  bool sweeps_ = false;  ///< how systems are solved now
  std::vector<double> entries_, swept_;
};

/// One such step with the laws themselves, x = x0 + h f(x), from where they have no slopes: a root at rest. Delayed
/// signals stay what they are at its beginning: later they are not known yet.
class EulerFromRest {
 public:
  EulerFromRest(const Program& program, Evaluator& evaluator);

  /// From the sides that conditions have at (@p t, @p x): what is at rest on the branch @p here may be set in motion
  /// by a source at another time. change() and tears() are its solution, to a tenth; of what has not settled after
  /// thirty iterations, as far as these have come. @return  false: no rates or no matrix on the way.
  bool step(double t, double h, const double* x, const Branch& here);
  [[nodiscard]] const std::vector<double>& change() const { return change_; }       ///< by state
  [[nodiscard]] const std::vector<double>& tears() const { return branch_.tears; }  ///< of loops, at its end

 private:
  bool rates_at_end(double t);
  void hold_clocks(const double* x);
  void spread(double t, double h, const double* x);

  const Program& program_;
  Evaluator& evaluator_;
  EulerSystems systems_;
  Branch here_, branch_;
  std::vector<double> end_, rates_, residual_, jacobian_, rounding_, change_;
};

}  // namespace bgsim
