#include "equations/indefinite.hpp"

#include <algorithm>

#include "bgsim/modes.hpp"
#include "equations/idle_switches.hpp"
#include "equations/random_point.hpp"
#include "expression/graph.hpp"

namespace bgsim {

namespace {

struct ImposedSides {
  std::vector<SymbolId> idle;                ///< what idle switches impose
  std::vector<SymbolId> conducting;          ///< what diodes that conduct impose: efforts
  std::vector<const DiodeEquation*> diodes;  ///< without contacts
};

ImposedSides imposed_sides(const Model& model, const BondGraph& graph, const EquationSystem& system) {
  ImposedSides sides;
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    if (model.elements[i].idle) sides.idle.push_back(side_variable(model, graph, system, ElementId(i), true));
  for (const DiodeEquation& at : system.diodes) {
    const Element& element = model.elements[at.element.index()];
    if (is_contact(element.kind)) continue;
    sides.diodes.push_back(&at);
    if (is_closed(element)) sides.conducting.push_back(side_variable(model, graph, system, at.element, true));
  }
  return sides;
}

/// Whether an output asks for something that a switch or diode imposes.
bool asks_for_sides(const EquationSystem& system, const std::vector<SymbolId>& imposed) {
  std::vector<char> wanted(system.symbols.size(), 0), seen(system.pool.size(), 0);
  for (const SymbolId symbol : imposed) wanted[symbol.index()] = 1;
  std::vector<ExprId> open;
  for (const OutputEquation& output : system.outputs) open.push_back(output.value);
  while (!open.empty()) {
    const ExprId e = open.back();
    open.pop_back();
    if (!e.valid() || seen[e.index()] != 0) continue;
    seen[e.index()] = 1;
    const ExprNode& node = system.pool[e];
    if (node.op != Op::symbol) {
      for_each_argument(node, [&](ExprId argument) { open.push_back(argument); });
      continue;
    }
    if (wanted[node.a] != 0) return true;
    const SystemSymbol& symbol = system.symbols[node.a];
    if (symbol.kind == SystemSymbol::Kind::unknown) open.push_back(system.equations[symbol.index].expression);
  }
  return false;
}

/// Whether a store follows what is indefinite at the point: then it is determined.
bool moves_stores(const EquationSystem& system, const RandomPoint& point) {
  return std::any_of(system.states.begin(), system.states.end(),
                     [&](const State& state) { return state.element.valid() && point.depends(state.rate); }) ||
         std::any_of(system.dependent.begin(), system.dependent.end(), [&](const DependentStore& store) {
           return point.depends(system.equations[system.symbols[store.symbol.index()].index].expression);
         });
}

}  // namespace

Indefinite indefinite_outputs(const Model& model, const BondGraph& graph, const EquationSystem& system) {
  Indefinite result;
  const ImposedSides sides = imposed_sides(model, graph, system);
  std::vector<SymbolId> imposed = sides.idle;
  for (const DiodeEquation* at : sides.diodes)
    imposed.push_back(side_variable(model, graph, system, at->element, true));
  if (imposed.empty() || !asks_for_sides(system, imposed)) return result;

  std::vector<SymbolId> free = sides.idle;
  if (!sides.diodes.empty()) {
    const RandomPoint as_it_is(system, {}), any_efforts(system, sides.conducting);
    for (const DiodeEquation* at : sides.diodes) {
      const bool conducts = is_closed(model.elements[at->element.index()]);
      const SymbolId other = side_variable(model, graph, system, at->element, false);
      const bool on_both = conducts ? any_efforts.is_zero(other)
                                    : system.pool.is_constant(at->threshold, 0.0) && as_it_is.is_zero(other) &&
                                          !any_efforts.is_zero(other);
      if (!on_both) continue;
      const SymbolId own = side_variable(model, graph, system, at->element, true);
      if (moves_stores(system, RandomPoint(system, {own}))) continue;
      free.push_back(own);
      result.diodes.push_back(at->element);
    }
  }
  if (free.empty()) return result;
  const RandomPoint point(system, free);
  for (const OutputEquation& output : system.outputs)
    if (point.depends(output.value)) result.outputs.push_back(output.name);
  return result;
}

}  // namespace bgsim
