/// How fast states move, beside a scene and beside the pace of a run.
#pragma once

#include <optional>

#include "bgsim/evaluator.hpp"

namespace bgsim {

/// BG614: what is wrong with a state whose time constant at the start is so far below the scene that the integrator's
/// squares overflow; none if there is no such state.
std::optional<Diagnostic> too_fast_state(Evaluator& evaluator, const RunInputs& inputs, const double* x, Branch branch);

/// The fastest that a state moves by itself, or two states move each other, as the Jacobian at (t, x) says.
struct FastestMotion {
  std::size_t state = 0, other = 0;  ///< equal if it is one state
  double rate = 0.0;                 ///< per unit of t
};
/// None if nothing moves or the Jacobian cannot be evaluated. Cost: that of the Jacobian.
std::optional<FastestMotion> fastest_motion(const Program& program, Evaluator& evaluator, double t, const double* x,
                                            Branch branch);

/// Whether the steps may become longer by themselves before @p reach of simulated time is over: a mode that they
/// follow will have died out by then, and had not yet.
/// @param elapsed  simulated time since the start or the last jump.
/// Cost: that of eigenvalues (spectrum.hpp); false for systems too large for that.
bool may_pick_up(const Program& program, Evaluator& evaluator, double t, const double* x, const Branch& branch,
                 double step, double elapsed, double reach);

}  // namespace bgsim
