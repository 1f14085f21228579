/// Equilibria of a mode that is entered with what stores hold in another.
#pragma once

#include <string>
#include <vector>

#include "bgsim/linear.hpp"
#include "bgsim/simulate.hpp"

namespace bgsim {

/// Where a search begins, if not at the start of a scene.
struct SteadyStart {
  Stored stored;      ///< of all stores, in whatever mode: they jump into that of the model (jump_into)
  std::string where;  ///< in words
  /// Whether others are looked for where the first one leaves its mode.
  bool beside_left = true;
};

/// The same as equilibria().
/// @throws ModelError as equilibria; BG620 no jump leads into the mode.
std::vector<Equilibrium> equilibria_from(const std::shared_ptr<const Model>& model, const RunInputs& scene,
                                         const SteadyStart& from, const SteadyOptions& options);

}  // namespace bgsim
