#include <algorithm>
#include <array>

#include "base/dependence.hpp"
#include "read/reader.hpp"

namespace bgsim {

namespace {

/// An integral is known before its rate is: no circle runs through it.
bool is_state(const Parameter& /*unused*/) { return false; }
bool is_state(const Signal& signal) { return signal.is_state(); }

}  // namespace

void Reader::check_dependence() {
  check_cycles(model_.parameters, ModelSymbol::Kind::parameter, "parameters");
  check_cycles(model_.signals, ModelSymbol::Kind::signal, "signals");
  check_plain_kinds();
  check_modes();
  check_delays();
  check_equalities();
}

/// Names circles among quantities; on the way finds out how the signals vary.
template <class Quantity>
void Reader::check_cycles(const std::vector<Quantity>& quantities, ModelSymbol::Kind kind, const char* what) {
  const auto refers_to = [&](std::size_t i) {
    std::vector<std::size_t> others;
    if (!quantities[i].value.valid() || is_state(quantities[i])) return others;
    for (const SymbolId id : symbols_in(model_.pool, std::array{quantities[i].value})) {
      const ModelSymbol& symbol = model_.symbols[id.index()];
      if (symbol.kind == kind)
        others.push_back(kind == ModelSymbol::Kind::signal ? symbol.signal.index() : symbol.parameter.index());
    }
    return others;
  };
  const Dependence dependence = order_by_dependence(quantities.size(), refers_to);
  for (const std::vector<std::size_t>& cycle : dependence.cycles) {
    std::string chain;
    std::vector<Note> notes;
    for (const std::size_t i : cycle) {
      chain += quantities[i].name + " -> ";
      if (i != cycle.front() && notes.size() < 3)
        notes.push_back({quantities[i].place, in_quotes(quantities[i].name) + " is computed here"});
    }
    problem("BG132", std::string(what) + " depend on each other: " + chain + quantities[cycle.front()].name,
            quantities[cycle.front()].place, "give one of them a value that does not refer to the others",
            std::string(what) + " are computed one after the other", std::move(notes));
  }
  if (kind != ModelSymbol::Kind::signal) return;
  signal_varies_.assign(model_.signals.size(), Varies::never);
  for (const std::size_t i : dependence.order)
    if (is_state(quantities[i]))
      signal_varies_[i] = Varies::with_state;
    else if (quantities[i].value.valid())
      signal_varies_[i] = variation(quantities[i].value);
}

Reader::Varies Reader::variation(SymbolId id) const {
  const ModelSymbol& symbol = model_.symbols[id.index()];
  switch (symbol.kind) {
    case ModelSymbol::Kind::parameter:
      return Varies::never;
    case ModelSymbol::Kind::time:
      return Varies::with_time;
    case ModelSymbol::Kind::signal:
      return signal_varies_[symbol.signal.index()];
    default:
      return Varies::with_state;
  }
}

/// How an expression varies at most; signals are followed.
Reader::Varies Reader::variation(ExprId expression) const {
  Varies most = Varies::never;
  for (const SymbolId id : symbols_in(model_.pool, std::array{expression})) most = std::max(most, variation(id));
  return most;
}

/// The plain kinds may use t, parameters and signals of t, and in a law their own variables; the others anything.
void Reader::check_plain_kinds() {
  for (std::size_t i = 0; i < model_.elements.size(); ++i) {
    const Element& element = model_.elements[i];
    if (element.modulated || is_junction(element.kind)) continue;
    const ExprId value = !element.laws.empty() ? element.laws.front().right : element.coefficient;
    if (!value.valid() || model_.pool.is_constant(value)) continue;
    for (const SymbolId id : symbols_in(model_.pool, std::array{value})) {
      const ModelSymbol& symbol = model_.symbols[id.index()];
      const bool own = symbol.kind == ModelSymbol::Kind::port_variable && symbol.element == ElementId(i);
      if ((own && !element.laws.empty()) || variation(id) != Varies::with_state) continue;
      const std::string kind = kind_text(element.kind, false);
      const std::string& prefix = scopes_[element_text_[i].names].prefix;
      problem("BG118",
              "the " + kind + " " + in_quotes(element.name.substr(prefix.size())) + " is modulated by " +
                  in_quotes(symbol_name(model_, id).substr(prefix.size())),
              element.coefficient_place,
              element.contact ? "a wall that states move is a contact between two elements: its gap is then a constant"
              : own           ? "write a \"law\" if it is nonlinear"
                              : "make it of kind " + in_quotes("M" + kind),
              "the plain kinds may use t, parameters and signals of t only");
      break;
    }
  }
}

/// Two quantities that vary are equal for an instant only, which no integrator can be sure to meet.
void Reader::check_equalities() {
  const auto check = [this](ExprId root, const Place& place) {
    if (!root.valid() || model_.pool.is_constant(root)) return;
    for (const ExprId e : reachable(model_.pool, std::array{root})) {
      const Op op = model_.pool[e].op;
      if ((op != Op::eq && op != Op::ne) || variation(e) == Varies::never) continue;
      problem("BG119", "quantities that vary in time are compared by " + std::string(name_of(op)), place,
              "compare with < or >=", "two quantities that vary are equal for an instant only");
      return;
    }
  };
  for (const Signal& signal : model_.signals) {
    check(signal.value, signal.place);
    if (signal.delay) check(signal.delay->value, signal.place);
  }
  for (const Element& element : model_.elements) {
    check(element.coefficient, element.coefficient_place);
    check(element.energy, element.coefficient_place);
    if (element.switches) {
      check(element.switches->closes, element.switches->closes_place);
      check(element.switches->opens, element.switches->opens_place);
    }
    if (element.diode) check(element.diode->fire, element.diode->fire_place);
    if (element.contact) check(element.contact->restitution, element.contact->restitution_place);
    for (const Law& law : element.laws) check(law.right, law.place);
  }
  for (const ModelEvent& event : model_.events) {
    check(event.when, event.when_place);
    for (const ModelEvent::Set& set : event.sets) check(set.value, set.place);
  }
  for (const Output& output : model_.outputs) check(output.value, output.place);
}

}  // namespace bgsim
