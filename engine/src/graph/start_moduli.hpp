/// Moduli that are 0 where a run starts: nothing can be divided by them.
#pragma once

#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// The TF and GY whose modulus varies and is 0, or what rounding leaves of 0, at the start of a scene, in model order:
/// with the model's and the scene's parameters and initial values. A modulus that depends on more than time and what is
/// stored is not looked at.
std::vector<ElementId> moduli_zero_at_start(const Model& model);

}  // namespace bgsim
