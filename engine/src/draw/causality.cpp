// What a drawing shows of the causality of a model, whole or faulty.
#include "bgsim/drawing.hpp"
#include "equations/solvable_causality.hpp"
#include "graph/causal_explanation.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

/// Elements with another number of bonds than ports, and two-ports whose half-arrows do not tell their ports apart.
std::vector<ElementId> wrongly_bonded(const Model& model) {
  struct Bonded {
    std::size_t entering = 0, leaving = 0, named = 0;
  };
  std::vector<Bonded> bonded(model.elements.size());
  std::vector<bool> wrong(model.elements.size(), false);
  for (const ModelBond& bond : model.bonds) {
    ++bonded[bond.from.element.index()].leaving;
    ++bonded[bond.to.element.index()].entering;
    for (const BondEndText* end : {&bond.from, &bond.to})
      if (end->port) ++bonded[end->element.index()].named;
    if (bond.from.element == bond.to.element) wrong[bond.from.element.index()] = true;
  }
  std::vector<ElementId> elements;
  for (std::size_t i = 0; i < bonded.size(); ++i) {
    const Element& element = model.elements[i];
    const auto [entering, leaving, named] = bonded[i];
    const bool count = is_junction(element.kind) ? entering + leaving == 0 : entering + leaving != port_count(element);
    if (wrong[i] || count || (is_two_port(element.kind) && entering != leaving && named == 0))
      elements.push_back(ElementId(i));
  }
  return elements;
}

void add_strokes(DrawnCausality& drawn, const Model& model, const BondGraph& graph, const CausalAttempt& attempt) {
  std::vector<Stroke> strokes;
  for (const auto& stroke : attempt.strokes) strokes.push_back(stroke.value_or(Stroke{}));
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    if (!attempt.strokes[i]) continue;
    const Stroke& stroke = strokes[i];
    drawn.strokes[i] = stroke.end;
    drawn.reasons[i] = stroke_reason_text(model, graph, strokes, BondId(i));
    if (stroke.reason == StrokeReason::free_choice || stroke.reason == StrokeReason::law_as_written)
      drawn.free.push_back(BondId(i));
  }
  for (std::size_t i = 0; i < graph.ports.size(); ++i) {
    const Port& port = graph.ports[i];
    const ElementKind kind = graph.kinds[port.element.index()];
    if (!is_store(kind) || !drawn.strokes[port.bond.index()]) continue;
    if (stroke_at(graph, strokes, PortId(i)) == stores_displacement(model.elements[port.element.index()], port.number))
      drawn.dependent.push_back(port.bond);
  }
}

}  // namespace

DrawnCausality drawn_causality(const Model& model) {
  DrawnCausality drawn;
  drawn.strokes.resize(model.bonds.size());
  drawn.reasons.resize(model.bonds.size());
  try {
    const BondGraph graph = build_bond_graph(model);
    CausalAttempt attempt = attempt_causality(model, graph);
    if (attempt.problems.empty()) {
      const CausalGraph causal = solvable_causality(model, graph);
      attempt.strokes.assign(causal.strokes.begin(), causal.strokes.end());
    }
    add_strokes(drawn, model, graph, attempt);
    drawn.faulty = std::move(attempt.conflicts);
    drawn.problems = std::move(attempt.problems);
  } catch (const ModelError& error) {
    drawn.problems = error.diagnostics;
    drawn.faulty = wrongly_bonded(model);
  }
  return drawn;
}

}  // namespace bgsim
