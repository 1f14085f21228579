/// Strokes for which there are equations.
#pragma once

#include "bgsim/causality.hpp"

namespace bgsim {

/// As assign_causality. A law with kinks that fixes a store's causality may leave it without equations of index 1
/// (BG402, BG403): a damper by flow beside a mass. Then such laws are solved for what the stores need. Models that have
/// equations keep their strokes.
/// @throws ModelError as assign_causality does.
CausalGraph solvable_causality(const Model& model, const BondGraph& graph);

}  // namespace bgsim
