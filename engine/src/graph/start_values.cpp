#include "graph/start_values.hpp"

#include <algorithm>
#include <array>

#include "expression/graph.hpp"
#include "graph/with_signals.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

Rounded StartValues::operator()(ExprId expression) {
  const auto behind = [this](ExprId e) {
    const ExprId signal = signal_behind(model_, e);
    return signal.valid() ? signal : behind_symbol(e);
  };
  for (const ExprId e : in_order(model_.pool, expression, known_, behind)) values_[e.index()] = value_of(e);
  return values_[expression.index()];
}

/// The expression that gives the start value of a parameter, an integral or a store; none for other symbols.
ExprId StartValues::behind_symbol(ExprId e) const {
  if (!model_.pool.is_symbol(e)) return {};
  const SymbolId id = model_.pool.symbol_of(e);
  const ModelSymbol& symbol = model_.symbols[id.index()];
  if (symbol.kind == ModelSymbol::Kind::parameter && !parameters_.empty()) return {};
  if (symbol.kind == ModelSymbol::Kind::parameter) {
    const Parameter& parameter = model_.parameters[symbol.parameter.index()];
    if (scene_ != nullptr)
      if (const auto given = scene_->parameters.find(parameter.name); given != scene_->parameters.end())
        return given->second.first;
    return parameter.value;
  }
  if (symbol.kind == ModelSymbol::Kind::time) return scene_ != nullptr ? scene_->start : ExprId();
  if (scene_ != nullptr)
    if (const auto given = scene_->initial.find(symbol_name(model_, id)); given != scene_->initial.end())
      return given->second.first;
  if (symbol.kind == ModelSymbol::Kind::signal) return model_.signals[symbol.signal.index()].initial;
  if (symbol.kind != ModelSymbol::Kind::port_variable) return {};
  for (const InitialValue& initial : model_.elements[symbol.element.index()].initial)
    if (initial.port == symbol.port && !initial.conjugate) return initial.value;
  return {};
}

/// Whether a store's port has an initial effort (of a C) or flow (of an I), from which its law gives what it holds.
bool StartValues::starts_from_law(const ModelSymbol& symbol) const {
  const Element& element = model_.elements[symbol.element.index()];
  const std::string conjugate =
      port_name(element, symbol.port) + (stores_displacement(element, symbol.port) ? ".e" : ".f");
  if (scene_ != nullptr && scene_->initial.contains(conjugate)) return true;
  return std::any_of(element.initial.begin(), element.initial.end(),
                     [&](const InitialValue& initial) { return initial.port == symbol.port && initial.conjugate; });
}

Rounded StartValues::value_of(ExprId e) const {
  const ExprNode& node = model_.pool[e];
  if (node.op == Op::constant) return rounded_constant(node.constant);
  if (node.op == Op::symbol) return value_of_symbol(e);
  if (node.op == Op::der || is_table(node.op)) return {};
  std::array<Rounded, 3> x{};
  std::size_t n = 0;
  for_each_argument(node, [&](ExprId argument) { x[n++] = at(argument.value); });
  return apply_rounded(node.op, x, n);
}

Rounded StartValues::value_of_symbol(ExprId e) const {
  if (const ExprId signal = signal_behind(model_, e); signal.valid()) return at(signal.value);
  const ModelSymbol& symbol = model_.symbols[model_.pool.symbol_of(e).index()];
  if (symbol.kind == ModelSymbol::Kind::parameter && !parameters_.empty())
    return {parameters_[symbol.parameter.index()], 0.0};
  if (const ExprId behind = behind_symbol(e); behind.valid()) return at(behind.value);
  const bool stored = symbol.kind == ModelSymbol::Kind::port_variable &&
                      (symbol.variable == Variable::displacement || symbol.variable == Variable::momentum);
  if (stored && !starts_from_law(symbol)) return {0.0, 0.0};
  if (symbol.kind == ModelSymbol::Kind::time || symbol.kind == ModelSymbol::Kind::signal) return {0.0, 0.0};
  return {};
}

bool varies(const Model& model, ExprId expression) {
  std::vector<bool> seen(model.pool.size(), false);
  const auto behind = [&](ExprId e) { return signal_behind(model, e); };
  const std::vector<ExprId> nodes = in_order(model.pool, expression, seen, behind);
  return std::any_of(nodes.begin(), nodes.end(), [&](ExprId e) {
    return model.pool.is_symbol(e) &&
           model.symbols[model.pool.symbol_of(e).index()].kind != ModelSymbol::Kind::parameter;
  });
}

}  // namespace bgsim
