#include "program/known_times.hpp"

#include "expression/graph.hpp"

namespace bgsim {

namespace {

template <class Value>
void append(std::string& key, const Value& value) {
  key.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

KnownTime* KnownTimes::of(const ExprPool& pool, ExprId relation, SymbolId time, std::span<const double> symbol_values) {
  // Arguments first, so that the order is that of the expression, and not that in which the pool came to it.
  std::string key;
  IdMap<std::uint32_t> place;
  std::uint32_t count = 0;
  bool tables = false;
  arguments_first(
      pool, relation, [&](ExprId e) { return place.find(e) != nullptr; },
      [&](ExprId e) {
        const ExprNode& node = pool[e];
        place.insert(e, count++);
        tables = tables || is_table(node.op);
        if (node.op == Op::constant || (node.op == Op::symbol && pool.symbol_of(e) != time)) {
          append(key, Op::constant);
          append(key, node.op == Op::constant ? node.constant : symbol_values[pool.symbol_of(e).index()]);
          return;
        }
        append(key, node.op);
        for_each_argument(node, [&](ExprId a) { append(key, *place.find(a)); });
      });
  return tables ? nullptr : &known_[key];
}

}  // namespace bgsim
