#include "equations/one_way_laws.hpp"

#include <algorithm>
#include <set>

#include "base/text.hpp"
#include "graph/causal_explanation.hpp"

namespace bgsim {

std::vector<Diagnostic> with_one_way_laws(const Model& model, const BondGraph& graph, const CausalGraph& causal,
                                          std::vector<Diagnostic> problems) {
  const auto asks = [](const Diagnostic& problem) { return problem.code == "BG402" || problem.code == "BG403"; };
  if (std::none_of(problems.begin(), problems.end(), asks)) return problems;
  std::vector<Note> notes;
  std::set<BondId> known;
  for (const DependentPort& dependent : causal.dependent) {
    const std::string store = in_quotes(model.elements[dependent.element.index()].name);
    const BondId own = graph[graph.port(dependent.element, dependent.port)].bond;
    for (const BondId bond : strokes_behind(graph, causal.strokes, {own})) {
      const Stroke& stroke = causal.strokes[bond.index()];
      if (stroke.reason != StrokeReason::one_way_law || !known.insert(bond).second) continue;
      notes.push_back({model.elements[stroke.element.index()].place,
                       stroke_reason_text(model, graph, causal.strokes, bond) + ", which makes " + store +
                           " dependent: a law that is continuous and strictly monotone can be solved for the other "
                           "variable"});
    }
  }
  for (Diagnostic& problem : problems)
    if (asks(problem)) problem.notes.insert(problem.notes.end(), notes.begin(), notes.end());
  return problems;
}

}  // namespace bgsim
