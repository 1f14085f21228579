#include "equations/idle_switches.hpp"

#include <algorithm>

#include "bgsim/modes.hpp"
#include "bgsim/ordering.hpp"
#include "equations/random_point.hpp"
#include "equations/solvable_causality.hpp"

namespace bgsim {

namespace {

std::vector<ElementId> plain_switches(const Model& model) {
  std::vector<ElementId> result;
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    if (model.elements[i].switches && is_switch(model.elements[i].kind)) result.emplace_back(i);
  return result;
}

bool is_allowed(const Model& model) {
  try {
    const BondGraph graph = build_bond_graph(model);
    order_equations(model, derive_equations(model, graph, solvable_causality(model, graph), true));
    return true;
  } catch (const ModelError&) {
    return false;
  }
}

/// With the first so many switches only; a resistor, which every graph allows, stands for each of the others.
bool is_allowed(const Model& model, const std::vector<ElementId>& switches, std::size_t first) {
  Model some = model;
  for (std::size_t i = first; i < switches.size(); ++i) {
    Element& element = some.elements[switches[i].index()];
    element.stands_in = mode_holds(element);
    element.kind = ElementKind::resistor;
    element.coefficient = some.pool.constant(1.0);
    element.switches.reset();
  }
  return is_allowed(some);
}

void make_idle(Element& element) {
  const bool closed = is_closed(element);
  element.kind = closed ? ElementKind::open_switch : ElementKind::closed_switch;
  element.idle = true;
}

/// Whether idle switches have the 0 that they would set, and only outputs and powers depend on what is indefinite.
bool are_idle(const Model& model) {
  const BondGraph graph = build_bond_graph(model);
  const EquationSystem system = derive_equations(model, graph, solvable_causality(model, graph), true);
  std::vector<SymbolId> imposed, zero;
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    if (!model.elements[i].idle) continue;
    imposed.push_back(side_variable(model, graph, system, ElementId(i), true));
    zero.push_back(side_variable(model, graph, system, ElementId(i), false));
  }
  const RandomPoint point(system, imposed);
  if (!std::all_of(zero.begin(), zero.end(), [&point](SymbolId symbol) { return point.is_zero(symbol); })) return false;
  std::vector<ExprId> roots;
  for (const State& state : system.states) roots.push_back(state.rate);
  for (const DependentStore& store : system.dependent)
    roots.push_back(system.equations[system.symbols[store.symbol.index()].index].expression);
  for (const SwitchEquation& at : system.switches) roots.push_back(at.leaves);
  for (const DiodeEquation& at : system.diodes) roots.insert(roots.end(), {at.effort, at.flow, at.threshold, at.fires});
  for (const EventEquation& event : system.events) {
    roots.push_back(event.when);
    for (const EventEquation::Set& set : event.sets) roots.push_back(set.value);
  }
  for (const EquationSystem::Delay& delay : system.delays)
    roots.insert(roots.end(), {delay.value, delay.by, delay.initial});
  for (const ImpulseTerm& term : system.jump.terms) roots.push_back(term.factor);
  return std::none_of(roots.begin(), roots.end(), [&point](ExprId root) { return point.depends(root); });
}

}  // namespace

Model with_idle_switches(Model model) {
  const std::vector<ElementId> switches = plain_switches(model);
  if (switches.empty() || is_allowed(model)) return model;
  Model result = model;
  std::size_t kept = 0;
  if (!is_allowed(result, switches, 0)) return model;
  while (!is_allowed(result, switches, switches.size())) {
    std::size_t refused = switches.size();
    while (refused - kept > 1) {
      const std::size_t middle = kept + (refused - kept) / 2;
      (is_allowed(result, switches, middle) ? kept : refused) = middle;
    }
    make_idle(result.elements[switches[refused - 1].index()]);
    if (!is_allowed(result, switches, refused)) return model;
    kept = refused;
  }
  try {
    return are_idle(result) ? result : model;
  } catch (const ModelError&) {
    return model;
  }
}

bool has_idle_switches(const Model& model) {
  return std::any_of(model.elements.begin(), model.elements.end(), [](const Element& element) { return element.idle; });
}

SymbolId side_variable(const Model& model, const BondGraph& graph, const EquationSystem& system, ElementId id,
                       bool imposed) {
  const bool effort = (imposed_variable(model.elements[id.index()].kind) == Variable::effort) == imposed;
  return (effort ? system.efforts : system.flows)[graph[graph.port(id, 0)].bond.index()];
}

}  // namespace bgsim
