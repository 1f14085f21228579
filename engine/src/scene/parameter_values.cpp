#include "scene/parameter_values.hpp"

#include <stdexcept>

#include "bgsim/text.hpp"
#include "expression/graph.hpp"

namespace bgsim {

ParameterValues::ParameterValues(const Model& model, const ExprPool& pool, std::span<const double> symbol_values)
    : values_(pool.size()), known_(pool.size(), false) {
  for (std::size_t i = 0; i < pool.size(); ++i) {
    const ExprNode& node = pool[ExprId(i)];
    if (node.op == Op::constant || node.op == Op::symbol) {
      known_[i] = node.op == Op::constant || model.symbols[node.a].kind == ModelSymbol::Kind::parameter;
      values_[i] = node.op == Op::constant ? node.constant : symbol_values[node.a];
      continue;
    }
    std::array<double, 3> x{};
    std::size_t n = 0;
    bool known = node.op != Op::der;
    for_each_argument(node, [&](ExprId argument) {
      known = known && known_[argument.index()];
      x[n++] = values_[argument.index()];
    });
    if (!known) continue;
    known_[i] = true;
    if (node.op == Op::table)
      values_[i] = table_value(pool.table(TableId(node.b)), x[0]);
    else
      values_[i] = apply(node.op, x[0], x[1], x[2]);
  }
}

std::optional<double> ParameterValues::of(ExprId expression) const {
  return known_[expression.index()] ? std::optional(values_[expression.index()]) : std::nullopt;
}

std::string with_operands(const Model& model, const ExprPool& pool, ExprId expression,
                          std::span<const double> symbol_values) {
  std::string text = readable_text(pool, expression, [&](SymbolId s) { return symbol_name(model, s); });
  constexpr std::size_t kMostShown = 6;
  std::size_t shown = 0;
  for (const SymbolId id : symbols_in(pool, std::array{expression})) {
    if (shown == kMostShown) return text + ", ...";
    text +=
        (shown++ == 0 ? " with " : ", ") + symbol_name(model, id) + " = " + number_text(symbol_values[id.index()], 6);
  }
  return text;
}

}  // namespace bgsim
