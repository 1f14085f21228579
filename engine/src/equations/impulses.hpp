/// What moves at once where a store moves at once.
#pragma once

#include <vector>

#include "bgsim/equations.hpp"

namespace bgsim {

/// The states that an impulse into a dependent store moves, and how far. With u the input of a store (the flow of a C,
/// the effort of an I), the junctions make u_state = W u_dependent + what stays finite; the terms are the entries of W,
/// which is minus the transpose of what makes the dependent store's effort or flow from those of the states.
/// @note Time linear in the equations of junctions times the dependent stores that each depends on.
std::vector<ImpulseTerm> impulse_terms(const Model& model, const BondGraph& graph, EquationSystem& system);

}  // namespace bgsim
