#include "equations/slice_energy.hpp"

#include <algorithm>

namespace bgsim {
namespace {

/// Marks the equations that depend on states or loops that are left out.
std::vector<bool> lost_equations(const EquationSystem& system, const BlockOrder& order, const Needs& needs,
                                 const std::vector<std::uint32_t>& block_of_equation) {
  std::vector<bool> block_kept(order.blocks.size(), false);
  for (std::size_t i = 0; i < needs.equations.size(); ++i)
    if (needs.equations[i] && block_of_equation[i] != kNoBlock) block_kept[block_of_equation[i]] = true;

  std::vector<bool> lost(system.equations.size(), false);
  std::vector<std::uint32_t> open;
  std::vector<std::vector<std::uint32_t>> dependents(system.equations.size());
  const auto lose = [&](std::uint32_t equation) {
    if (lost[equation]) return;
    lost[equation] = true;
    open.push_back(equation);
  };
  for (std::uint32_t i = 0; i < system.equations.size(); ++i) {
    if (block_of_equation[i] != kNoBlock && !block_kept[block_of_equation[i]]) lose(i);
    const std::vector<ExprId> roots{system.equations[i].expression};
    for (const SymbolId s : symbols_in(system.pool, roots)) {
      const SystemSymbol& symbol = system.symbols[s.index()];
      if (symbol.kind == SystemSymbol::Kind::state && !needs.states[symbol.index]) lose(i);
      if (symbol.kind == SystemSymbol::Kind::unknown) dependents[symbol.index].push_back(i);
    }
  }
  while (!open.empty()) {
    const std::uint32_t equation = open.back();
    open.pop_back();
    for (const std::uint32_t dependent : dependents[equation]) lose(dependent);
  }
  return lost;
}

}  // namespace

AuditedPart audited_part(const BondGraph& graph, const EquationSystem& system, const BlockOrder& order,
                         const Needs& needs, const std::vector<std::uint32_t>& block_of_equation) {
  const std::vector<bool> lost = lost_equations(system, order, needs, block_of_equation);
  const auto is_lost = [&](SymbolId s) {
    const SystemSymbol& symbol = system.symbols[s.index()];
    return symbol.kind == SystemSymbol::Kind::state ? !needs.states[symbol.index] : bool(lost[symbol.index]);
  };
  const auto known = [&](SymbolId s) { return order.resolved[s.index()].valid(); };

  AuditedPart part;
  part.elements.assign(graph.kinds.size(), true);
  std::vector<bool> clear(graph.bonds.size());
  for (std::size_t b = 0; b < graph.bonds.size(); ++b) {
    clear[b] = !is_lost(system.efforts[b]) && !is_lost(system.flows[b]);
    if (clear[b]) continue;
    part.elements[graph[graph.bonds[b].tail].element.index()] = false;
    part.elements[graph[graph.bonds[b].head].element.index()] = false;
  }
  for (const EnergyPart& energy : system.energy)
    if (std::any_of(energy.displacements.begin(), energy.displacements.end(), is_lost))
      part.elements[energy.element.index()] = false;

  // A border whose power nothing else needs has no resolved form: the element before it is given up, and the border
  // moves on.
  std::vector<ElementId> given_up;
  const auto border_of = [&](std::size_t b, PortId near, PortId far) {
    const ElementId inside = graph[near].element, beyond = graph[far].element;
    if (!part.elements[inside.index()] || part.elements[beyond.index()]) return;
    if (known(system.efforts[b]) && known(system.flows[b])) {
      part.borders.push_back({beyond, BondId(b), graph.bonds[b].head == near});
      return;
    }
    given_up.push_back(inside);
  };
  do {
    given_up.clear();
    part.borders.clear();
    for (std::size_t b = 0; b < graph.bonds.size(); ++b) {
      border_of(b, graph.bonds[b].tail, graph.bonds[b].head);
      border_of(b, graph.bonds[b].head, graph.bonds[b].tail);
    }
    for (const ElementId element : given_up) part.elements[element.index()] = false;
  } while (!given_up.empty());
  return part;
}

void keep_energies(const AuditedPart& part, const EquationSystem& system, const BlockOrder& order,
                   EquationSystem& sliced, BlockOrder& sliced_order) {
  sliced.energy.clear();
  sliced_order.powers.clear();
  sliced_order.port_powers.clear();
  sliced_order.stored.clear();
  for (std::size_t i = 0; i < system.energy.size(); ++i) {
    if (!part.elements[system.energy[i].element.index()]) continue;
    sliced.energy.push_back(system.energy[i]);
    sliced_order.powers.push_back(order.powers[i]);
    sliced_order.port_powers.push_back(order.port_powers[i]);
    sliced_order.stored.push_back(order.stored[i]);
  }
  ExprPool& pool = sliced_order.pool;
  for (const AuditedPart::Border& border : part.borders) {
    const ExprId effort = order.resolved[system.efforts[border.bond.index()].index()];
    const ExprId flow = order.resolved[system.flows[border.bond.index()].index()];
    const ExprId power = pool.mul(effort, flow);
    sliced.energy.push_back({EnergyPart::Role::source, border.beyond, {}, {}, {}, {}, {}, false});
    sliced_order.powers.push_back(border.inward ? power : pool.neg(power));
    sliced_order.port_powers.emplace_back();
    sliced_order.stored.emplace_back();
    sliced_order.origins.resize(pool.size(), Origin{border.beyond, {}});
  }
}

}  // namespace bgsim
