#include "graph/solved_laws.hpp"

#include <utility>

#include "base/codes.hpp"
#include "graph/causal_explanation.hpp"
#include "model/constitutive.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

SolvedLaws::SolvedLaws(const Model& model, const BondGraph& graph, NumberOf number_of)
    : model_(model),
      graph_(graph),
      number_(std::move(number_of)),
      pool_(model.pool),
      laws_(graph.ports.size()),
      solved_(graph.ports.size()) {
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    const std::vector<Law> laws = port_laws(model, pool_, ElementId(i));
    for (std::size_t number = 0; number < model.elements[i].ports.size(); ++number) {
      const std::size_t port = graph.port(ElementId(i), number).index();
      if (number < laws.size()) laws_[port] = laws[number];
      for (const Gives gives : {Gives::effort, Gives::flow})
        solved_[port][static_cast<std::size_t>(gives)] = solve(ElementId(i), number, laws, gives);
    }
  }
}

SolvedLaw SolvedLaws::solved(const Element& element, const Law& law, Gives gives) {
  const SolvedLaw smooth = solve_law(pool_, element, law, gives);
  if (!number_ || smooth.use != LawUse::impossible) return smooth;
  const SolvedLaw result = solve_law(pool_, element, law, gives, number_);
  by_pieces_ = by_pieces_ || result.use != LawUse::impossible;
  return result;
}

/// A law that is given by a coefficient is solved when the strokes are known: its use needs no solution.
SolvedLaw SolvedLaws::solve(ElementId id, std::size_t number, const std::vector<Law>& laws, Gives gives) {
  const Element& at = model_.elements[id.index()];
  if (at.energy.valid() || !at.laws.empty()) return solved(at, laws[number], gives);
  SolvedLaw coefficient;
  coefficient.use = law_use(model_, pool_, id, number, gives);
  // A resistance that depends on the flow that it is to give.
  if (coefficient.use == LawUse::impossible && number < laws.size()) return solved(at, laws[number], gives);
  return coefficient;
}

PortLaw SolvedLaws::used(std::span<const Stroke> strokes, PortId port) {
  const Law& law = laws_[port.index()];
  if (!law.right.valid()) return {};
  const Element& element = model_.elements[graph_[port].element.index()];
  const auto solution = [&](Gives gives) {
    const SolvedLaw& known = solved_[port.index()][static_cast<std::size_t>(gives)];
    return element.coefficient.valid() ? solved(element, law, gives) : known;
  };
  PortLaw used{law, solution(stroke_at(graph_, strokes, port) ? Gives::flow : Gives::effort), {}};
  if (is_store(element.kind))
    used.conjugate = solution(stores_displacement(element, graph_[port].number) ? Gives::effort : Gives::flow).solution;
  return used;
}

void SolvedLaws::test_field(ElementId id, CausalGraph& causal) {
  const Element& field = model_.elements[id.index()];
  if (!is_field(field.kind) || !is_store(field.kind)) return;
  causal.fields.push_back({id, test_reciprocity(model_, pool_, id)});
  const Reciprocity& test = causal.fields.back().reciprocity;
  if (test.verdict != Reciprocity::Verdict::violated) return;
  causal.warnings.push_back(diagnostic_of(
      "BG306",
      "the laws of field \"" + field.name + "\" are not reciprocal between ports \"" + field.ports[test.port_a] +
          "\" and \"" + field.ports[test.port_b] + "\"",
      field.laws.front().place,
      "laws that come from one stored energy have equal cross derivatives (Maxwell reciprocity); others "
      "create energy on a closed path",
      "give the field its \"energy\" instead of laws, or check the cross terms", {{std::nullopt, test.text}}));
}

void SolvedLaws::hand_over(std::span<const Stroke> strokes, CausalGraph& causal) && {
  for (std::size_t i = 0; i < model_.elements.size(); ++i) test_field(ElementId(i), causal);
  for (std::size_t i = 0; i < graph_.ports.size(); ++i) causal.laws.push_back(used(strokes, PortId(i)));
  causal.pool = std::move(pool_);
}

}  // namespace bgsim
