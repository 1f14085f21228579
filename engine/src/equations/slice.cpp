#include "bgsim/slice.hpp"

#include <algorithm>
#include <utility>

#include "equations/slice_energy.hpp"
#include "equations/slice_needs.hpp"

namespace bgsim {
namespace {

/// The same positions of a vector, kept where @p keep says so.
template <class T, class Keep>
std::vector<T> kept(const std::vector<T>& all, const Keep& keep) {
  std::vector<T> result;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (keep(i)) result.push_back(all[i]);
  return result;
}

std::vector<std::uint32_t> block_of_equation(const EquationSystem& system, const BlockOrder& order) {
  std::vector<std::uint32_t> result(system.equations.size(), kNoBlock);
  for (std::uint32_t b = 0; b < order.blocks.size(); ++b)
    for (const SymbolId member : order.blocks[b].members) result[system.symbols[member.index()].index] = b;
  return result;
}

bool keeps_block(const EquationSystem& system, const Block& block, const Needs& needs) {
  return std::any_of(block.members.begin(), block.members.end(),
                     [&](SymbolId member) { return needs.equations[system.symbols[member.index()].index]; });
}

/// By ElementId: whether any equation or state of it is needed.
std::vector<bool> needed_elements(const Model& model, const EquationSystem& system, const Needs& needs) {
  std::vector<bool> needed(model.elements.size(), false);
  for (std::size_t i = 0; i < system.equations.size(); ++i)
    if (const ElementId element = system.equations[i].element; needs.equations[i] && element.valid())
      needed[element.index()] = true;
  for (std::size_t i = 0; i < system.states.size(); ++i)
    if (needs.states[i] && system.states[i].element.valid()) needed[system.states[i].element.index()] = true;
  return needed;
}

Needs needs_of_outputs(const EquationSystem& system, const std::vector<std::size_t>& outputs) {
  std::vector<ExprId> roots;
  for (const std::size_t i : outputs) roots.push_back(system.outputs[i].value);
  return needs_of(system, roots);
}

/// Elements and signals without any equation or state that is kept.
void name_left_out(const Model& model, const EquationSystem& system, const Needs& needs,
                   const std::vector<bool>& audited, LeftOut& left_out) {
  const std::vector<bool> kept_element = needed_elements(model, system, needs);
  for (std::size_t i = 0; i < system.states.size(); ++i)
    if (!needs.states[i]) left_out.states.push_back(system.states[i].name);
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    if (!kept_element[i] && !audited[i] && !is_junction(model.elements[i].kind))
      left_out.elements.push_back(model.elements[i].name);
  for (std::size_t i = 0; i < model.signals.size(); ++i)
    if (!model.signals[i].is_state() && !needs.equations[system.symbols[system.signals[i].index()].index])
      left_out.signals.push_back(model.signals[i].name);
}

}  // namespace

Slice take(const EquationSystem& system, const BlockOrder& order, const Needs& needs) {
  Slice result{system, order};
  const auto state = [&](std::size_t i) { return needs.states[i]; };
  result.system.states = kept(system.states, state);
  result.order.rates = kept(order.rates, state);
  for (std::uint32_t i = 0; i < result.system.states.size(); ++i)
    result.system.symbols[result.system.states[i].symbol.index()].index = i;
  result.system.dependent = kept(system.dependent, [&](std::size_t i) {
    return needs.equations[system.symbols[system.dependent[i].symbol.index()].index];
  });
  const auto differentiated = [&](std::size_t i) {
    return needs.equations[system.symbols[system.continuous[i].derivative.index()].index];
  };
  result.system.continuous = kept(system.continuous, differentiated);
  result.order.continuous = kept(order.continuous, differentiated);
  result.order.blocks = kept(order.blocks, [&](std::size_t b) { return keeps_block(system, order.blocks[b], needs); });
  std::size_t largest = 0;
  for (const Block& block : result.order.blocks) largest = std::max(largest, block.tears.size());
  result.order.system_class = result.order.blocks.empty()     ? SystemClass::explicit_ode
                              : largest <= kLargestLocalBlock ? SystemClass::local_blocks
                                                              : SystemClass::implicit_dae;
  return result;
}

Needs needs_of(const EquationSystem& system, std::span<const ExprId> roots) {
  Needs needs;
  needs.states.assign(system.states.size(), false);
  needs.equations.assign(system.equations.size(), false);
  std::vector<bool> seen(system.pool.size(), false);
  std::vector<ExprId> open(roots.begin(), roots.end());
  while (!open.empty()) {
    const ExprId e = open.back();
    open.pop_back();
    if (!e.valid() || seen[e.index()]) continue;
    seen[e.index()] = true;
    const ExprNode& node = system.pool[e];
    if (node.op == Op::symbol) {
      const SystemSymbol& symbol = system.symbols[node.a];
      if (symbol.kind == SystemSymbol::Kind::state) {
        needs.states[symbol.index] = true;
        open.push_back(system.states[symbol.index].rate);
      } else if (symbol.kind == SystemSymbol::Kind::unknown) {
        needs.equations[symbol.index] = true;
        open.push_back(system.equations[symbol.index].expression);
        open.push_back(system.equations[symbol.index].whole);
      }
    } else if (node.op != Op::constant) {
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) open.emplace_back(children[k]);
    }
  }
  return needs;
}

std::optional<Slice> slice(const Model& model, const BondGraph& graph, const EquationSystem& system,
                           const BlockOrder& order, const std::vector<std::size_t>& outputs, bool audit) {
  const Needs needs = needs_of_outputs(system, outputs);
  const bool all_states = std::find(needs.states.begin(), needs.states.end(), false) == needs.states.end();
  const auto needed_block = [&](const Block& block) { return keeps_block(system, block, needs); };
  const bool all_blocks = std::all_of(order.blocks.begin(), order.blocks.end(), needed_block);
  AuditedPart part;
  part.elements.assign(model.elements.size(), audit && all_states && all_blocks);
  if (audit && !(all_states && all_blocks))
    part = audited_part(graph, system, order, needs, block_of_equation(system, order));

  LeftOut left_out;
  name_left_out(model, system, needs, part.elements, left_out);
  for (const Block& block : order.blocks) left_out.loops += needed_block(block) ? 0U : 1U;
  if (left_out.nothing()) return std::nullopt;

  Slice result = take(system, order, needs);
  if (!all_states || !all_blocks) keep_energies(part, system, order, result.system, result.order);
  if (audit)
    for (const EnergyPart& energy : system.energy)
      if (!part.elements[energy.element.index()])
        left_out.not_audited.push_back(model.elements[energy.element.index()].name);
  result.system.left_out = std::move(left_out);
  return result;
}

std::vector<ElementId> unobserved_elements(const Model& model, const EquationSystem& system,
                                           const std::vector<std::size_t>& outputs) {
  const std::vector<bool> needed = needed_elements(model, system, needs_of_outputs(system, outputs));
  std::vector<ElementId> result;
  for (std::size_t i = 0; i < needed.size(); ++i)
    if (!needed[i]) result.emplace_back(i);
  return result;
}

}  // namespace bgsim
