#include "equations/solvable_causality.hpp"

#include <optional>
#include <utility>

#include "bgsim/equations.hpp"
#include "graph/law_numbers.hpp"

namespace bgsim {

CausalGraph solvable_causality(const Model& model, const BondGraph& graph) {
  CausalGraph causal = assign_causality(model, graph);
  if (causal.dependent.empty()) return causal;
  std::optional<CausalGraph> other = assign_causality_by_pieces(model, graph);
  if (!other || other->dependent.size() >= causal.dependent.size()) return causal;
  try {
    derive_equations(model, graph, causal);
  } catch (const ModelError&) {
    return *std::move(other);
  }
  return causal;
}

}  // namespace bgsim
