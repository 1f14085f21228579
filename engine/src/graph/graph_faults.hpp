/// What is wrong with a graph of which not everything could be read, so that all faults are reported together.
#pragma once

#include <cstdint>
#include <unordered_set>
#include <vector>

#include "bgsim/bond_graph.hpp"

namespace bgsim {

/// Elements that are not missed a bond, since one that could not be read is likely to be theirs.
struct BondedElsewhere {
  std::unordered_set<std::uint32_t> elements;  ///< by index
  bool any = false;                            ///< whose it was is not known: it may be any element's
};

/// The faults BG2xx of a model whose bonds may have ends that are not known (an invalid element).
std::vector<Diagnostic> graph_faults(const Model& model, const BondedElsewhere& elsewhere);

/// The faults BG3xx of a model whose graph is complete, though its laws may not be. What a missing law would ask for,
/// and the side of a switch, is left open, so that a conflict that is found is there whatever the law.
/// @param model  gets a law where it has none, and is of no use for anything else afterwards.
std::vector<Diagnostic> causal_faults(Model& model);

/// BG206 (warning) if the graph falls into parts that no bond or signal connects. Linear in the model.
std::vector<Diagnostic> part_warnings(const Model& model, const BondGraph& graph);

}  // namespace bgsim
