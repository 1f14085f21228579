/// The numbers with which laws with kinks are looked at.
#pragma once

#include <optional>
#include <span>

#include "bgsim/causality.hpp"
#include "expression/pieces.hpp"

namespace bgsim {

/// Of parameters, and of signals of parameters alone, in the first scene.
NumberOf numbers_at_start(const Model& model);

/// As assign_causality, with laws with kinks used in any direction in which they can be solved from the outset. None if
/// there are no such laws, or no strokes keep all rules.
std::optional<CausalGraph> assign_causality_by_pieces(const Model& model, const BondGraph& graph);

/// Laws with kinks that are solved for what they are not written for, with the parameters of a run, by ParameterId.
/// @throws ModelError BG305 one is no longer solved as the equations have it.
void check_laws(const Model& model, const BondGraph& graph, const CausalGraph& causal,
                std::span<const double> parameters);

}  // namespace bgsim
