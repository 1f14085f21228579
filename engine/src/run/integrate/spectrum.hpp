/// Eigenvalues of the state equations at a point, and what they mean for BDF.
#pragma once

#include <complex>
#include <optional>
#include <vector>

#include "bgsim/evaluator.hpp"

namespace bgsim {

/// Eigenvalues of the Jacobian at (t, x), after balancing; empty where it cannot be evaluated or is not finite.
/// Cost: some 10 n^3 operations for n states.
std::vector<std::complex<double>> eigenvalues(const Program& program, Evaluator& evaluator, double t, const double* x,
                                              const Branch& branch);

/// Half the opening, in degrees, of the sector about the negative real axis in which BDF of this order is stable
/// whatever the step: 90 for orders 1 and 2, then less and less.
/// @cite hairer1996 (A(alpha)-stability of BDF)
double stable_angle(int order);

/// A mode that is over, and in which BDF of high order would go on for ever, or grow.
struct SpentMode {
  int order = 0;           ///< the highest that is stable for it whatever the step
  double frequency = 0.0;  ///< rad per unit of time
  double damping = 0.0;    ///< rate at which it dies out, per unit of time
};

/// The mode that limits the order of BDF most; nothing where none does.
///
/// Of the modes that are followed no order is too high: the steps that their accuracy takes lie where every order is
/// stable, or nearly so. A weakly damped mode that dies out early in the scene, and that the steps do not resolve, is
/// no part of the solution any more. Yet orders 3 to 5 are unstable for it: they are then held by its period, and what
/// is worse, a tolerance that is loose lets it grow.
///
/// @param span  of the scene.
/// @param step  that the integrator makes now, on average.
/// Cost: that of a Jacobian where no mode can be that fast; else that of eigenvalues().
std::optional<SpentMode> spent_mode(const Program& program, Evaluator& evaluator, double t, const double* x,
                                    const Branch& branch, double span, double step);

}  // namespace bgsim
