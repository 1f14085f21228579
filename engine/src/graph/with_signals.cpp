#include "graph/with_signals.hpp"

#include <unordered_set>

#include "expression/graph.hpp"

namespace bgsim {

ExprId signal_behind(const Model& model, ExprId expression) {
  if (!model.pool.is_symbol(expression)) return {};
  const ModelSymbol& symbol = model.symbols[model.pool.symbol_of(expression).index()];
  if (symbol.kind != ModelSymbol::Kind::signal || model.signals[symbol.signal.index()].is_state()) return {};
  return model.signals[symbol.signal.index()].value;
}

std::vector<ExprId> in_order(const ExprPool& pool, ExprId root, std::vector<bool>& known,
                             const std::function<ExprId(ExprId)>& behind) {
  std::vector<ExprId> order, open{root};
  std::unordered_set<ExprId> entered;
  while (!open.empty()) {
    const ExprId top = open.back();
    if (!known[top.index()] && entered.insert(top).second) {
      const auto need = [&](ExprId e) {
        if (e.valid() && !known[e.index()] && !entered.contains(e)) open.push_back(e);
      };
      if (pool.is_symbol(top))
        need(behind(top));
      else if (!pool.is_constant(top))
        for_each_argument(pool[top], need);
      continue;
    }
    open.pop_back();
    if (known[top.index()]) continue;
    known[top.index()] = true;
    order.push_back(top);
  }
  return order;
}

}  // namespace bgsim
