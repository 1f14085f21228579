/// Helpers for loops over a part of an ExprPool that cost what the part costs, however large the pool is.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "bgsim/expression.hpp"

namespace bgsim {

/// Map from expression ids to values; open addressing, no order.
template <class Value>
class IdMap {
 public:
  IdMap() : keys_(64, ExprId::kNone), values_(64) {}

  /// The value of @p key, or nullptr.
  [[nodiscard]] const Value* find(ExprId key) const {
    const std::size_t at = slot(key.value);
    return keys_[at] == key.value ? &values_[at] : nullptr;
  }
  /// Inserts unless the key is there.
  /// @return true if it was inserted.
  bool insert(ExprId key, Value value) {
    std::size_t at = slot(key.value);
    if (keys_[at] == key.value) return false;
    if (2 * (count_ + 1) > keys_.size()) {
      grow();
      at = slot(key.value);
    }
    keys_[at] = key.value;
    values_[at] = std::move(value);
    ++count_;
    return true;
  }

 private:
  [[nodiscard]] std::size_t slot(std::uint32_t key) const {
    const std::size_t mask = keys_.size() - 1;
    std::size_t at = (key * std::size_t{0x9E3779B97F4A7C15U} >> 29U) & mask;
    while (keys_[at] != ExprId::kNone && keys_[at] != key) at = (at + 1) & mask;
    return at;
  }
  void grow() {
    std::vector<std::uint32_t> keys(2 * keys_.size(), ExprId::kNone);
    std::vector<Value> values(keys.size());
    keys.swap(keys_);
    values.swap(values_);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (keys[i] == ExprId::kNone) continue;
      const std::size_t at = slot(keys[i]);
      keys_[at] = keys[i];
      values_[at] = std::move(values[i]);
    }
  }

  std::vector<std::uint32_t> keys_;
  std::vector<Value> values_;
  std::size_t count_ = 0;
};

/// Calls @p f with the id of each argument, first to last; an argument that occurs twice is given twice.
template <class F>
void for_each_argument(const ExprNode& node, F&& f) {
  const int n = arity(node.op);
  if (n > 0) f(ExprId(node.a));
  if (n > 1) f(ExprId(node.b));
  if (n > 2) f(ExprId(node.c));
}

[[nodiscard]] constexpr bool is_comparison(Op op) { return op >= Op::lt && op <= Op::ne; }
[[nodiscard]] constexpr bool is_inequality(Op op) { return op >= Op::lt && op <= Op::ge; }
[[nodiscard]] constexpr bool is_logical(Op op) { return op >= Op::lt && op <= Op::logical_not; }
/// Steps at whole numbers, or at the middles between them.
[[nodiscard]] constexpr bool is_rounding(Op op) { return op == Op::floor || op == Op::ceil || op == Op::round; }
[[nodiscard]] constexpr bool is_commutative(Op op) {
  return op == Op::add || op == Op::mul || op == Op::min || op == Op::max || op == Op::hypot || op == Op::eq ||
         op == Op::ne || op == Op::logical_and || op == Op::logical_or;
}

/// The node with its arguments replaced, built again so that it simplifies.
template <class Argument>
ExprId rebuilt(ExprPool& pool, const ExprNode& node, const Argument& argument) {
  switch (arity(node.op)) {
    case 1:
      if (is_table(node.op)) return pool.table(node.op, argument(ExprId(node.a)), TableId(node.b));
      return pool.make(node.op, argument(ExprId(node.a)));
    case 2:
      return pool.make(node.op, argument(ExprId(node.a)), argument(ExprId(node.b)));
    case 3:
      return pool.select(argument(ExprId(node.a)), argument(ExprId(node.b)), argument(ExprId(node.c)));
    default:
      return node.op == Op::constant ? pool.constant(node.constant) : pool.symbol(SymbolId(node.a));
  }
}

/// Calls @p finish for @p root and all below it for which @p known is false, each once and after its arguments; what is
/// known is not entered. Depth first with a stack of its own: chains may be long. @p finish makes its expression known,
/// and may let the pool grow.
template <class Known, class Finish>
void arguments_first(const ExprPool& pool, ExprId root, const Known& known, const Finish& finish) {
  std::vector<ExprId> open{root};
  while (!open.empty()) {
    const ExprId top = open.back();
    if (known(top)) {
      open.pop_back();
      continue;
    }
    const std::size_t before = open.size();
    for_each_argument(pool[top], [&](ExprId a) {
      if (!known(a)) open.push_back(a);
    });
    if (open.size() > before) continue;
    open.pop_back();
    finish(top);
  }
}

/// The expressions of @p nodes (as from reachable()) that depend on a symbol for which @p x is true, by position.
template <class Predicate>
std::vector<char> depends_on(const ExprPool& pool, const std::vector<ExprId>& nodes,
                             const IdMap<std::uint32_t>& position, const Predicate& x) {
  std::vector<char> depends(nodes.size(), 0);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode& node = pool[nodes[i]];
    if (node.op == Op::symbol)
      depends[i] = x(pool.symbol_of(nodes[i])) ? 1 : 0;
    else
      for_each_argument(node, [&](ExprId a) { depends[i] |= depends[*position.find(a)]; });
  }
  return depends;
}

/// Position of each expression in @p nodes.
inline IdMap<std::uint32_t> positions(const std::vector<ExprId>& nodes) {
  IdMap<std::uint32_t> position;
  for (std::size_t i = 0; i < nodes.size(); ++i) position.insert(nodes[i], static_cast<std::uint32_t>(i));
  return position;
}

}  // namespace bgsim
