#include "graph/graph_faults.hpp"

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>

#include "base/codes.hpp"
#include "bgsim/causality.hpp"
#include "expression/graph.hpp"
#include "model/element_kinds.hpp"
#include "model/expressions_of.hpp"

namespace bgsim {
namespace {

/// A law that can be used in any causality, for an element that has none, and for a switch, whose side is the run's
/// matter.
void give_any_law(Model& model, std::size_t index) {
  Element& element = model.elements[index];
  const ExprId one = model.pool.constant(1.0);
  if (is_switch(element.kind)) {
    element.kind = ElementKind::resistor;
    element.coefficient = one;
    return;
  }
  if (is_junction(element.kind) || is_detector(element.kind)) return;
  if (!is_field(element.kind)) {
    if (!element.coefficient.valid() && element.laws.empty()) element.coefficient = one;
    return;
  }
  if (element.energy.valid() || element.laws.size() == element.ports.size()) return;
  const bool store = is_store(element.kind);
  element.laws.clear();
  for (std::uint32_t port = 0; port < element.ports.size(); ++port) {
    const Variable left = store ? conjugate_variable(element, port) : Variable::effort;
    const Variable given = store ? stored_variable(element, port) : Variable::flow;
    element.laws.push_back({port, left, model.pool.symbol(port_variable(element, port, given)), element.place});
  }
}

/// Elements and signals, joined by bonds and by what reads what.
class Parts {
 public:
  Parts(const Model& model, const BondGraph& graph)
      : model_(model), graph_(graph), sets_(model.elements.size() + model.signals.size()) {
    for (const Bond& bond : graph.bonds)
      sets_.union_set(graph[bond.tail].element.index(), graph[bond.head].element.index());
    for (std::size_t i = 0; i < model.signals.size(); ++i) join(node_of(SignalId(i)), expressions_of(model.signals[i]));
    for (std::size_t i = 0; i < model.elements.size(); ++i) {
      const Element& element = model.elements[i];
      join(i, expressions_of(element));
      if (element.contact) sets_.union_set(i, node_of(element.contact->displacement));
    }
    for (const ModelEvent& event : model.events) {
      const std::size_t first = node_of(event.sets.front());
      join(first, expressions_of(event));
      for (const ModelEvent::Set& set : event.sets) sets_.union_set(first, node_of(set));
    }
  }

  /// Elements by part, parts in the order of their first elements.
  std::vector<std::vector<ElementId>> lists() {
    std::vector<std::size_t> part_of(model_.elements.size() + model_.signals.size(), kNone);
    std::vector<std::vector<ElementId>> parts;
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      std::size_t& part = part_of[sets_.find_set(i)];
      if (part == kNone) {
        part = parts.size();
        parts.emplace_back();
      }
      parts[part].push_back(ElementId(i));
    }
    return parts;
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  [[nodiscard]] std::size_t node_of(SignalId signal) const { return model_.elements.size() + signal.index(); }
  [[nodiscard]] std::size_t node_of(const ModelEvent::Set& set) const {
    return set.element.valid() ? set.element.index() : node_of(set.signal);
  }

  void join(std::size_t reader, std::vector<ExprId> expressions) {
    std::erase_if(expressions, [&](ExprId e) { return !e.valid() || model_.pool.is_constant(e); });
    if (expressions.empty()) return;
    for (const SymbolId id : symbols_in(model_.pool, expressions)) {
      const ModelSymbol& symbol = model_.symbols[id.index()];
      if (symbol.kind == ModelSymbol::Kind::signal) sets_.union_set(reader, node_of(symbol.signal));
      if (symbol.kind == ModelSymbol::Kind::port_variable || symbol.kind == ModelSymbol::Kind::mode)
        sets_.union_set(reader, symbol.element.index());
      if (symbol.kind == ModelSymbol::Kind::bond_variable)
        sets_.union_set(reader, graph_[graph_.bonds[symbol.bond.index()].tail].element.index());
    }
  }

  const Model& model_;
  const BondGraph& graph_;
  boost::disjoint_sets_with_storage<> sets_;
};

std::string names_of(const Model& model, const std::vector<ElementId>& part) {
  constexpr std::size_t kListed = 5;
  std::string text;
  for (std::size_t i = 0; i < part.size() && i < kListed; ++i)
    text += (i == 0 ? "\"" : ", \"") + model.elements[part[i].index()].name + '"';
  if (part.size() > kListed) text += " and " + std::to_string(part.size() - kListed) + " more";
  return text;
}

}  // namespace

std::vector<Diagnostic> causal_faults(Model& model) {
  for (std::size_t i = 0; i < model.elements.size(); ++i) give_any_law(model, i);
  return attempt_causality(model, build_bond_graph(model)).problems;
}

std::vector<Diagnostic> part_warnings(const Model& model, const BondGraph& graph) {
  const auto parts = Parts(model, graph).lists();
  if (parts.size() < 2) return {};
  constexpr std::size_t kListed = 5;
  Diagnostic warning = diagnostic_of("BG206");
  warning.situation = "the graph falls into " + std::to_string(parts.size()) + " parts that no bond or signal connects";
  for (std::size_t i = 0; i < parts.size() && i < kListed; ++i)
    warning.notes.push_back({model.elements[parts[i].front().index()].place, "a part: " + names_of(model, parts[i])});
  if (parts.size() > kListed) warning.notes.push_back({{}, std::to_string(parts.size() - kListed) + " further parts"});
  warning.place = model.elements[parts[1].front().index()].place;
  warning.rule = "parts without a connection have no effect on each other";
  warning.help = "add the bond that is missing, or leave it so if they are meant to be separate";
  return {warning};
}

}  // namespace bgsim
