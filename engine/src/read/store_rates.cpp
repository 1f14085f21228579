#include "read/store_rates.hpp"

#include <algorithm>
#include <array>
#include <boost/pending/disjoint_sets.hpp>
#include <unordered_set>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "expression/graph.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {
namespace {

/// Which variables of the bonds are the same but for a sign or a factor. Two for each bond: its effort and its flow.
class SameVariables {
 public:
  /// @param with_resistors  the effort of a resistor is as good as its flow, being a function of it alone.
  SameVariables(const Model& model, bool with_resistors)
      : model_(model), with_resistors_(with_resistors), ends_(model.elements.size()), sets_(2 * model.bonds.size()) {
    for (std::size_t i = 0; i < model.bonds.size(); ++i) {
      attach(i, model.bonds[i].from, 1);
      attach(i, model.bonds[i].to, 0);
    }
    for (std::size_t i = 0; i < model.elements.size(); ++i) join_at(ElementId(i));
  }

  /// The class of an effort or flow; none for other symbols.
  std::optional<std::size_t> of(const ModelSymbol& symbol) {
    if (symbol.variable != Variable::effort && symbol.variable != Variable::flow) return std::nullopt;
    if (symbol.kind == ModelSymbol::Kind::bond_variable) return node(symbol.bond.index(), symbol.variable);
    if (symbol.kind != ModelSymbol::Kind::port_variable) return std::nullopt;
    return at_port(symbol.element, symbol.port, symbol.variable);
  }
  std::optional<std::size_t> at_port(ElementId element, std::uint32_t port, Variable variable) {
    for (const End& end : ends_[element.index()])
      if (end.port == port || is_junction(model_.elements[element.index()].kind)) return node(end.bond, variable);
    return std::nullopt;
  }

 private:
  struct End {
    std::size_t bond;
    std::uint32_t port;
  };

  void attach(std::size_t bond, const BondEndText& end, std::uint32_t by_arrow) {
    if (!end.element.valid()) return;  // what is wrong with the graph is found later
    const Element& element = model_.elements[end.element.index()];
    ends_[end.element.index()].push_back({bond, end.port.value_or(is_two_port(element.kind) ? by_arrow : 0)});
  }
  std::size_t node(std::size_t bond, Variable variable) {
    return sets_.find_set(2 * bond + (variable == Variable::flow ? 1U : 0U));
  }
  void join(std::size_t bond, Variable variable, std::size_t other, Variable other_variable) {
    sets_.union_set(node(bond, variable), node(other, other_variable));
  }

  void join_at(ElementId id) {
    const Element& element = model_.elements[id.index()];
    const std::vector<End>& ends = ends_[id.index()];
    if (ends.empty()) return;
    if (const auto shared = shared_variable(element.kind)) {
      const Variable other = other_of(*shared);
      for (std::size_t i = 1; i < ends.size(); ++i) join(ends[0].bond, *shared, ends[i].bond, *shared);
      if (ends.size() == 2) join(ends[0].bond, other, ends[1].bond, other);
    } else if (is_two_port(element.kind) && ends.size() == 2) {
      const Variable across = kind_row(element.kind).crosses ? Variable::flow : Variable::effort;
      join(ends[0].bond, Variable::effort, ends[1].bond, across);
      join(ends[0].bond, Variable::flow, ends[1].bond, other_of(across));
    } else if (with_resistors_ && is_resistor(element.kind) && !element.modulated) {
      join(ends[0].bond, Variable::effort, ends[0].bond,
           Variable::flow);  // a function of each other, and of nothing else
    }
  }

  const Model& model_;
  bool with_resistors_;
  std::vector<std::vector<End>> ends_;  // by element
  boost::disjoint_sets_with_storage<> sets_;
};

/// Looks through the laws of stores, and through the signals that they use.
class RateSearch {
 public:
  explicit RateSearch(const Model& model) : model_(model) {}

  std::vector<Diagnostic> all() {
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      const Element& element = model_.elements[i];
      if (!is_store(element.kind)) continue;
      if (element.laws.empty()) {
        look(ElementId(i), element.energy.valid() ? element.energy : element.coefficient, element.coefficient_place);
      } else {
        for (const Law& law : element.laws)
          if (look(ElementId(i), law.right, law.place)) break;
      }
    }
    return std::move(problems_);
  }

 private:
  /// Whether the expression contains a rate, which is then reported.
  bool look(ElementId id, ExprId root, const Place& place) {
    if (!root.valid() || model_.pool.is_constant(root)) return false;
    std::vector<std::pair<ExprId, std::string>> open{{root, ""}};  // expressions, with the signal they come from
    std::unordered_set<std::uint32_t> seen;
    while (!open.empty()) {
      const auto [expression, signal] = open.back();
      open.pop_back();
      for (const SymbolId symbol : symbols_in(model_.pool, std::array{expression})) {
        const ModelSymbol& meaning = model_.symbols[symbol.index()];
        if (meaning.kind == ModelSymbol::Kind::signal) {
          const Signal& next = model_.signals[meaning.signal.index()];
          if (next.is_state()) continue;  // what has been summed up is no rate
          if (next.value.valid() && seen.insert(meaning.signal.value).second) open.emplace_back(next.value, next.name);
        } else if (is_rate(id, meaning)) {
          report(id, symbol_name(model_, symbol), signal, place);
          return true;
        }
      }
      if (const auto name = differentiated(id, expression)) {
        report(id, "der(" + *name + ")", signal, place);
        return true;
      }
    }
    return false;
  }

  /// Whether an effort or flow is, but for a factor, the rate of what a port of the element holds.
  bool is_rate(ElementId id, const ModelSymbol& symbol) {
    if (symbol.kind != ModelSymbol::Kind::port_variable && symbol.kind != ModelSymbol::Kind::bond_variable)
      return false;
    if (!same_) {
      same_.emplace(model_, true);
      exactly_.emplace(model_, false);
    }
    const Element& element = model_.elements[id.index()];
    // What the law of another port gives is no rate, although at an IC's port of momentum it may be the flow that fills
    // a port of displacement.
    if (symbol.kind == ModelSymbol::Kind::port_variable && symbol.element == id &&
        symbol.variable == conjugate_variable(element, symbol.port))
      return false;
    enum class Of : std::uint8_t { rate, given };
    // Beside a single resistor the store's effort is a function of its flow, too, and is yet what the law gives.
    const auto is = [&](SameVariables& same, Of of) {
      const auto node = same.of(symbol);
      for (std::uint32_t port = 0; node && port < element.ports.size(); ++port) {
        const Variable given = conjugate_variable(element, port);
        if (same.at_port(id, port, of == Of::given ? given : other_of(given)) == node) return true;
      }
      return false;
    };
    return is(*same_, Of::rate) && (is(*exactly_, Of::rate) || !is(*exactly_, Of::given));
  }

  /// Whether a rate of the element occurs in an expression itself.
  bool holds_rate(ElementId id, ExprId expression) {
    const std::vector<SymbolId> symbols = symbols_in(model_.pool, std::array{expression});
    return std::any_of(symbols.begin(), symbols.end(),
                       [&](SymbolId symbol) { return is_rate(id, model_.symbols[symbol.index()]); });
  }

  /// The q or p under a der(...) whose rate is the element's own; signals under a der are followed.
  std::optional<std::string> differentiated(ElementId id, ExprId root) {
    std::vector<ExprId> open;
    for (const ExprId e : reachable(model_.pool, std::array{root}))
      if (model_.pool[e].op == Op::der) open.push_back(e);
    std::unordered_set<std::uint32_t> seen;
    while (!open.empty()) {
      const ExprId e = open.back();
      open.pop_back();
      for (const SymbolId symbol : symbols_in(model_.pool, std::array{e})) {
        const ModelSymbol& meaning = model_.symbols[symbol.index()];
        if (meaning.kind == ModelSymbol::Kind::signal && seen.insert(meaning.signal.value).second &&
            model_.signals[meaning.signal.index()].value.valid()) {
          const Signal& signal = model_.signals[meaning.signal.index()];
          if (!signal.is_state()) open.push_back(signal.value);
          if (signal.is_state() && holds_rate(id, signal.value)) return signal.name;
        }
        if (meaning.kind != ModelSymbol::Kind::port_variable ||
            (meaning.variable != Variable::displacement && meaning.variable != Variable::momentum))
          continue;
        ModelSymbol rate = meaning;
        rate.variable = meaning.variable == Variable::displacement ? Variable::flow : Variable::effort;
        if (is_rate(id, rate)) return symbol_name(model_, symbol);
      }
    }
    return std::nullopt;
  }

  void report(ElementId id, const std::string& what, const std::string& signal, const Place& place) {
    const Element& element = model_.elements[id.index()];
    const bool mixed = !element.stored.empty(), q = !mixed && stores_displacement(element, 0);
    Diagnostic problem = diagnostic_of("BG117", {}, place);
    problem.situation = "the " + std::string(element.energy.valid() ? "energy" : "law") + " of " +
                        in_quotes(element.name) + " contains " + what +
                        (signal.empty() ? "" : " through the signal " + in_quotes(signal)) +
                        ", which is the rate of what it stores";
    if (!signal.empty())
      for (const Signal& candidate : model_.signals)
        if (candidate.name == signal)
          problem.notes.push_back({candidate.place, in_quotes(signal) + " is computed here"});
    problem.rule = "the law of a store is a function of what it stores, its " +
                   std::string(mixed ? "q and p"
                               : q   ? "q"
                                     : "p") +
                   "; a part that depends on the rate dissipates";
    problem.help = std::string("put that part into a separate R, at a ") +
                   (mixed ? ""
                    : q   ? "1-"
                          : "0-") +
                   "junction with " + in_quotes(element.name);
    problems_.push_back(std::move(problem));
  }

  const Model& model_;
  std::optional<SameVariables> same_, exactly_;  // only where a law uses variables of others
  std::vector<Diagnostic> problems_;
};

}  // namespace

std::vector<Diagnostic> store_rate_faults(const Model& model) { return RateSearch(model).all(); }

}  // namespace bgsim
