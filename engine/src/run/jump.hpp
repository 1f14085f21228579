/// What stores hold after a jump into another mode.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"

namespace bgsim {

/// A store that jumped with no other store taking up the impulse.
struct LoneJump {
  std::string name;  ///< "coil.p"
  StateInfo store;
  double before = 0.0, after = 0.0;
};

struct Jump {
  std::vector<double> x;   ///< by state of the program
  double supplied = 0.0;   ///< by sources, in the instant
  double stored = 0.0;     ///< change of the stored energy
  double exchanged = 0.0;  ///< through modulated stores
  double loss = 0.0;       ///< supplied - stored - exchanged
  double scale = 0.0;      ///< magnitude of the terms that the loss is a difference of
  bool moved = false;      ///< any store has jumped
  std::vector<LoneJump> lone;
  std::optional<Diagnostic> failure;
};

/// Where the mode of @p evaluator's program begins, stores that were independent may be tied to each other. The
/// impulses that bring them together act along the new ties only, so that what is conserved there (charge, momentum)
/// stays: z+ = z- + (W, 1) U with the dependent stores' values in z+ what the states determine. With linear stores this
/// is the projection in the norm of energy; the loss is half that norm of the step (Carnot), and never negative where
/// energies are convex.
/// @param before  of every store of the model.
Jump jump_into(Evaluator& evaluator, double t, const Stored& before);

/// BG620.
Diagnostic no_jump_failure(const std::string& why, double t);

/// Value of a store or integral in @p stored; 0 if it is not among them.
double value_of(const Stored& stored, const StateInfo& state);

}  // namespace bgsim
