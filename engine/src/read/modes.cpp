/// mode("name") in expressions: which side a switch, diode or contact is on. In a mode of the switches it is a number,
/// so no stage but the reader has to follow it.
#include "bgsim/modes.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "base/dependence.hpp"
#include "read/reader.hpp"

namespace bgsim {

/// The condition. None if there is nothing of that name; refusal_ if it has no mode.
std::optional<ExprId> Reader::mode_named(const Context& context, std::string_view name) {
  if (context.constant != nullptr)
    return refuse("BG118", "mode(...) cannot be used in " + std::string(context.constant) + ": it varies",
                  std::string(context.constant) + " is computed from numbers and parameters only");
  const auto numbered = with_indices(context, name);
  if (!numbered) return std::nullopt;
  const auto found = names_.find(scopes_[context.scope].prefix + *numbered);
  if (found == names_.end() || found->second.kind == Entity::Kind::repeated) {
    const std::string advice = index_advice(context.scope, *numbered);
    return advice.empty() ? std::nullopt : refuse("BG121", "there is no " + in_quotes(name), advice);
  }
  const bool element = found->second.kind == Entity::Kind::element;
  std::size_t index = found->second.index;
  bool contrary = false;  // off, a 0-junction is one whose switch is closed
  for (const auto& [own, junction] : junction_switches_)
    if (element && junction == index) {
      contrary = shared_variable(model_.elements[index].kind) == Variable::effort;
      index = own;
      break;
    }
  if (!element || !is_switch(model_.elements[index].kind))
    return refuse(
        "BG121",
        in_quotes(name) + " has no mode" +
            (element ? ": it is of kind " + kind_text(model_.elements[index].kind, model_.elements[index].modulated)
                     : ""),
        "Sw, D, contact and junctions with \"on\" have modes");
  const auto [at, added] = mode_symbols_.try_emplace(index);
  if (added) {
    ModelSymbol symbol;
    symbol.kind = ModelSymbol::Kind::mode;
    symbol.element = ElementId(index);
    at->second = add_symbol(symbol);
  }
  ExprPool& pool = model_.pool;
  return pool.make(contrary ? Op::lt : Op::gt, pool.symbol(at->second), pool.constant(0.5));
}

std::vector<std::string> Reader::mode_names(const Context& context) const {
  std::vector<std::string> result;
  const std::string& prefix = scopes_[context.scope].prefix;
  for (const Element& element : model_.elements)
    if (is_switch(element.kind) && element.name.starts_with(prefix))
      result.push_back(element.name.substr(prefix.size()));
  return result;
}

/// The elements whose modes some expressions depend on at the same instant, directly or through signals.
std::vector<ElementId> Reader::modes_in(std::initializer_list<ExprId> expressions) const {
  std::vector<ElementId> found;
  std::set<SignalId> seen;
  std::vector<ExprId> open;
  for (const ExprId id : expressions)
    if (id.valid() && !model_.pool.is_constant(id)) open.push_back(id);
  while (!open.empty()) {
    const ExprId id = open.back();
    open.pop_back();
    for (const SymbolId symbol : symbols_in(model_.pool, std::array{id})) {
      const ModelSymbol& meaning = model_.symbols[symbol.index()];
      if (meaning.kind == ModelSymbol::Kind::mode) found.push_back(meaning.element);
      if (meaning.kind != ModelSymbol::Kind::signal || !seen.insert(meaning.signal).second) continue;
      const Signal& signal = model_.signals[meaning.signal.index()];
      if (!signal.is_state() && signal.value.valid()) open.push_back(signal.value);
    }
  }
  return found;
}

void Reader::check_modes() {
  if (mode_symbols_.empty()) return;
  check_laws_of_modes();
  check_circles_of_modes();
}

/// What breaks a circle through a mode.
static std::string latch_of(const std::string& mode) {
  std::string help = R"(a latch breaks the circle: "touch": { "set": ")";
  help.append(mode).append(R"(", "reset": "not )").append(mode).append(R"(" })");
  return help;
}

/// Which side a diode is on follows from all laws, so no law may depend on it.
void Reader::check_laws_of_modes() {
  for (std::size_t i = 0; i < model_.elements.size(); ++i) {
    const Element& element = model_.elements[i];
    std::vector<ElementId> read = modes_in({element.coefficient, element.energy});
    for (const Law& law : element.laws) {
      const std::vector<ElementId> more = modes_in({law.right});
      read.insert(read.end(), more.begin(), more.end());
    }
    const std::string& prefix = scopes_[element_text_[i].names].prefix;
    const std::string own = in_quotes(element.name.substr(prefix.size()));
    const Place& place = element.laws.empty() ? element.coefficient_place : element.laws.front().place;
    for (const ElementId id : read) {
      const Element& other = model_.elements[id.index()];
      const std::string mode = "mode('" + other.name.substr(prefix.size()) + "')";
      std::string depends = own;
      depends.append(" depends on ").append(mode);
      if (is_diode(other.kind)) {
        problem("BG132", "the law of " + depends + ", which follows from that law", place, latch_of(mode),
                "which side a diode or contact is on follows from the laws of all elements",
                {{other.place, in_quotes(other.name) + " is declared here"}});
      } else if (is_store(element.kind)) {
        problem("BG118", "the law of the store " + depends, place, "connect two stores by the switch",
                "a store whose law changes with a switch would gain or lose energy unseen");
      } else {
        continue;
      }
      break;
    }
  }
}

/// Switches whose conditions depend on each other. One with "close" and "open" remembers its side, and breaks a circle.
void Reader::check_circles_of_modes() {
  const auto remembers = [this](std::size_t i) {
    const Element& element = model_.elements[i];
    return !element.switches || element.switches->remembers;
  };
  const auto refers_to = [&](std::size_t i) {
    std::vector<std::size_t> others;
    const Element& element = model_.elements[i];
    if (!element.switches || remembers(i)) return others;
    for (const ElementId id : modes_in({element.switches->closes, element.switches->opens}))
      if (!remembers(id.index())) others.push_back(id.index());
    return others;
  };
  for (const std::vector<std::size_t>& cycle : order_by_dependence(model_.elements.size(), refers_to).cycles) {
    std::string chain;
    for (const std::size_t i : cycle) chain += model_.elements[i].name + " -> ";
    const Element& first = model_.elements[cycle.front()];
    problem("BG132", "the conditions of switches depend on each other's modes: " + chain + first.name,
            first.switches->closes_place,
            "one with \"close\" and \"open\" remembers its side, and may know its own mode",
            "the side of a switch follows from its condition");
  }
  for (const Element& element : model_.elements) {
    if (!element.diode || !element.diode->fire.valid()) continue;
    for (const ElementId id : modes_in({element.diode->fire}))
      if (&model_.elements[id.index()] == &element)
        problem("BG132", "the \"fire\" of " + in_quotes(element.name) + " depends on its own mode",
                element.diode->fire_place, "leave it out: \"fire\" matters only until the diode conducts",
                "a thyristor begins to conduct where \"fire\" holds");
  }
}

}  // namespace bgsim
