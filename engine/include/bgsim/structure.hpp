/// What inputs reach and outputs see, for almost all values of the parameters.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bgsim/linear.hpp"

namespace bgsim {

/// A rank of the controllability, or of the observability matrix.
struct StructuralRank {
  std::size_t rank = 0;
  std::vector<std::string> without_path;  ///< states that no causal path connects with an input (output)
  /// Further combinations of states that no input moves (that no output sees): which states take part, each time.
  std::vector<std::vector<std::string>> combinations;
};

struct StructuralControl {
  std::vector<std::string> states, inputs, outputs;
  StructuralRank controllable, observable;
  std::vector<std::string> notes;
};

/// Ranks over the parameters: their values, and the slopes of nonlinear laws, are random numbers modulo a prime, and
/// sums are exact, so that a rank is never too large, and too small with a probability of some 1e-15. Numbers in the
/// model stay what they are; what is 0 at the point is 0; functions of parameters (sqrt(k)) count as parameters.
/// @param point  its outputs are those looked at
/// @param inputs  may be empty: then nothing is controllable
/// @throws ModelError as linear_system().
StructuralControl structural_control(const std::shared_ptr<const Model>& model, const RunInputs& point,
                                     const std::vector<std::string>& inputs);

}  // namespace bgsim
