/// Which stores are independent, and what the others depend on.
#pragma once

#include <set>
#include <span>
#include <unordered_map>
#include <vector>

#include "bgsim/causality.hpp"

namespace bgsim {

/// Fills CausalGraph::integral and CausalGraph::dependent.
/// @param trail       bonds in the order in which they got their strokes.
/// @param eliminated  what each choice gave way to that was taken back.
void list_stores(const Model& model, const BondGraph& graph, std::span<const Stroke> strokes,
                 std::span<const BondId> trail, const std::unordered_map<BondId, std::set<BondId>>& eliminated,
                 CausalGraph& causal);

}  // namespace bgsim
