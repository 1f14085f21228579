#include "equations/impulses.hpp"

#include <algorithm>
#include <map>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "base/codes.hpp"
#include "expression/graph.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {
namespace {

using Row = std::map<std::uint32_t, ExprId>;  ///< by dependent store

class Impulses {
 public:
  Impulses(const Model& model, const BondGraph& graph, EquationSystem& system) : model_(model), system_(system) {
    for (std::uint32_t d = 0; d < system.dependent.size(); ++d) {
      const DependentStore& store = system.dependent[d];
      const bool displacement = stores_displacement(model.elements[store.element.index()], store.port);
      const PortId port = graph.port(store.element, store.port);
      const std::size_t bond = graph[port].bond.index();
      // A flow counts into the store; the bond's may count the other way.
      const bool against = displacement && !graph[port].head;
      rows_[displacement ? system.flows[bond] : system.efforts[bond]] = {
          {d, system.pool.constant(against ? -1.0 : 1.0)}};
    }
    if (!rows_.empty()) find_moved();
  }

  std::vector<ImpulseTerm> run() {
    std::vector<ImpulseTerm> terms;
    if (system_.dependent.empty()) return terms;
    for (std::uint32_t i = 0; i < system_.states.size(); ++i) {
      through_signals_ = system_.states[i].signal.valid();
      for (const auto& [dependent, factor] : row_of(system_.states[i].rate)) terms.push_back({i, dependent, factor});
    }
    return terms;
  }

 private:
  /// What depends on the input of a dependent store. All else takes no part, and may depend on itself (a beam without
  /// mass on dampers).
  void find_moved() {
    std::unordered_map<SymbolId, std::vector<SymbolId>> users;
    for (std::uint32_t i = 0; i < system_.symbols.size(); ++i) {
      const SymbolId symbol(i);
      if (system_.symbols[i].kind != SystemSymbol::Kind::unknown || !equation_of(symbol).expression.valid()) continue;
      for (const SymbolId need : symbols_in(system_.pool, std::vector{equation_of(symbol).expression}))
        users[need].push_back(symbol);
    }
    std::vector<SymbolId> open;
    for (const auto& [symbol, row] : rows_) open.push_back(symbol);
    while (!open.empty()) {
      const SymbolId symbol = open.back();
      open.pop_back();
      for (const SymbolId user : users[symbol])
        if (moved_.insert(user).second) open.push_back(user);
    }
  }

  /// Whether impulses pass through the equation of an unknown: those of junctions, TF and GY; and of signals on the way
  /// to an integral, but not to a modulus, which a flow without bound would leave undefined.
  [[nodiscard]] bool passes(SymbolId symbol, bool from_signal) const {
    if (system_.symbols[symbol.index()].kind != SystemSymbol::Kind::unknown || rows_.contains(symbol)) return false;
    if (!moved_.contains(symbol)) return false;
    const Equation& equation = equation_of(symbol);
    if (equation.implicit || !equation.expression.valid()) return false;
    if (!equation.element.valid()) return through_signals_ && from_signal;
    return passes_power(model_.elements[equation.element.index()].kind);
  }
  [[nodiscard]] bool is_signal(SymbolId symbol) const { return !equation_of(symbol).element.valid(); }

  [[nodiscard]] const Equation& equation_of(SymbolId symbol) const {
    return system_.equations[system_.symbols[symbol.index()].index];
  }

  /// What an impulse does in a loop of junctions follows from a system of equations, which is not solved here.
  [[noreturn]] void refuse_ring(const std::vector<SymbolId>& ring) const {
    std::vector<std::string> names;
    Place place;
    for (const SymbolId symbol : ring) {
      const ElementId id = equation_of(symbol).element;
      if (!id.valid()) continue;
      const Element& element = model_.elements[id.index()];
      if (names.empty()) place = element.place;
      if (std::find(names.begin(), names.end(), element.name) == names.end()) names.push_back(element.name);
    }
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "\"" : ", \"") + name + "\"";
    throw ModelError(
        {diagnostic_of(
            "BG620", "an impulse would go round in a loop of junctions, TF and GY: " + list, place,
            "where stores move at once, what they do is found along junctions, TF and GY that do not depend on "
            "each other",
            "an inertia at one of its 1-junctions, or a compliance at one of its 0-junctions, that is a state in this "
            "mode breaks it")},
        model_.sources);
  }

  Row row_of(ExprId root) {
    struct Level {
      SymbolId symbol;
      bool signal = false;
      std::vector<SymbolId> needs;
      std::size_t next = 0;
    };
    const auto needs_of = [this](ExprId e) { return symbols_in(system_.pool, std::vector{e}); };
    std::vector<Level> stack{{SymbolId{}, true, needs_of(root), 0}};
    while (stack.size() > 1 || stack.back().next < stack.back().needs.size()) {
      Level& top = stack.back();
      if (top.next < top.needs.size()) {
        const SymbolId symbol = top.needs[top.next++];
        if (!passes(symbol, top.signal)) continue;
        const auto on_the_way = [symbol](const Level& level) { return level.symbol == symbol; };
        if (const auto first = std::find_if(stack.begin(), stack.end(), on_the_way); first != stack.end()) {
          std::vector<SymbolId> ring;
          for (auto level = first; level != stack.end(); ++level) ring.push_back(level->symbol);
          refuse_ring(ring);
        }
        stack.push_back({symbol, is_signal(symbol), needs_of(equation_of(symbol).expression), 0});
        continue;
      }
      const Level done = std::move(top);
      stack.pop_back();
      rows_[done.symbol] = sum(equation_of(done.symbol).expression, done.signal);
    }
    return sum(root, true);
  }

  /// The row of an expression, with those of its unknowns known.
  Row sum(ExprId e, bool from_signal) {
    ExprPool& pool = system_.pool;
    const auto moves = [&](SymbolId symbol) {
      const auto found = rows_.find(symbol);
      return found != rows_.end() && !found->second.empty() && (from_signal || !is_signal(symbol));
    };
    Row row;
    for (const auto& [symbol, partial] : gradient(pool, e, moves))
      for (const auto& [dependent, factor] : rows_.at(symbol)) {
        const ExprId term = pool.mul(partial, factor);
        const auto [entry, is_new] = row.emplace(dependent, term);
        if (!is_new) entry->second = pool.add(entry->second, term);
      }
    std::erase_if(row, [&](const auto& entry) { return pool.is_constant(entry.second, 0.0); });
    return row;
  }

  const Model& model_;
  EquationSystem& system_;
  std::unordered_map<SymbolId, Row> rows_;
  std::unordered_set<SymbolId> moved_;
  bool through_signals_ = false;
};

}  // namespace

std::vector<ImpulseTerm> impulse_terms(const Model& model, const BondGraph& graph, EquationSystem& system) {
  return Impulses(model, graph, system).run();
}

}  // namespace bgsim
