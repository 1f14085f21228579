#include <cmath>

#include "expression/graph.hpp"
#include "expression/inverter.hpp"
#include "expression/signed_power.hpp"

namespace bgsim {

namespace {

bool is_odd_integer(double n) { return std::fabs(std::fmod(n, 2.0)) == 1.0; }

/// u with u^n = y for odd n.
ExprId root(ExprPool& pool, ExprId y, double n) {
  if (!is_odd_integer(n)) return {};
  if (n == -1.0) return pool.div(pool.constant(1.0), y);
  const ExprId u = odd_root(pool, y, std::fabs(n));
  return n < 0.0 ? pool.div(pool.constant(1.0), u) : u;
}

/// u with base^u = y.
ExprId logarithm(ExprPool& pool, ExprId y, double base) {
  if (!(base > 0.0) || base == 1.0) return {};
  if (base == 10.0) return pool.make(Op::log10, y);
  return pool.div(pool.make(Op::log, y), pool.constant(std::log(base)));
}

}  // namespace

ExprId undone(ExprPool& pool, Op op, ExprId y) {
  switch (op) {
    case Op::neg:
      return pool.neg(y);
    case Op::exp:
      return pool.make(Op::log, y);
    case Op::log:
      return pool.make(Op::exp, y);
    case Op::log10:
      return pool.pow(pool.constant(10.0), y);
    case Op::cbrt:
      return pool.pow(y, pool.constant(3.0));
    case Op::tanh:
      return pool.make(Op::atanh, y);
    case Op::atanh:
      return pool.make(Op::tanh, y);
    case Op::sinh:
      return pool.make(Op::asinh, y);
    case Op::asinh:
      return pool.make(Op::sinh, y);
    case Op::expm1:
      return pool.make(Op::log1p, y);
    case Op::log1p:
      return pool.make(Op::expm1, y);
    default:
      return {};  // even, periodic, bounded by a kink, or without a closed form among the operators
  }
}

ExprId undone(ExprPool& pool, Op op, ExprId other, bool x_first, ExprId y) {
  switch (op) {
    case Op::add:
      return pool.sub(y, other);
    case Op::sub:
      return x_first ? pool.add(y, other) : pool.sub(other, y);
    case Op::mul:
      return pool.div(y, other);
    case Op::div:
      if (x_first) return pool.mul(y, other);
      return pool.is_constant(other, 0.0) ? ExprId() : pool.div(other, y);
    case Op::pow:
      if (!pool.is_constant(other)) return {};
      return x_first ? root(pool, y, pool[other].constant) : logarithm(pool, y, pool[other].constant);
    default:
      return {};
  }
}

std::optional<LinearForm> linear_in(ExprPool& pool, ExprId expression, SymbolId x) {
  const auto is_x = [x](SymbolId s) { return s == x; };
  const std::vector<ExprId> nodes = reachable(pool, {&expression, 1});
  const std::vector<char> depends = depends_on(pool, nodes, positions(nodes), is_x);
  if (depends.back() == 0) return LinearForm{pool.constant(0.0), expression};
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (depends[i] != 0 && pool[nodes[i]].op == Op::der) return std::nullopt;
  if (jumps_with(pool, expression, is_x)) return std::nullopt;
  const auto partials = gradient(pool, expression, is_x);
  if (partials.empty()) return LinearForm{pool.constant(0.0), substitute(pool, expression, {{x, pool.constant(0.0)}})};
  const ExprId slope = partials.front().second;
  for (const SymbolId s : symbols_in(pool, {&slope, 1}))
    if (s == x) return std::nullopt;
  return LinearForm{slope, substitute(pool, expression, {{x, pool.constant(0.0)}})};
}

std::optional<ExprId> invert(ExprPool& pool, ExprId expression, SymbolId x, ExprId y) {
  return invert(pool, expression, x, y, {});
}

std::optional<ExprId> invert(ExprPool& pool, ExprId expression, SymbolId x, ExprId y, const InvertRest& rest) {
  const std::vector<ExprId> nodes = reachable(pool, {&expression, 1});
  const IdMap<std::uint32_t> position = positions(nodes);
  const std::vector<char> depends = depends_on(pool, nodes, position, [x](SymbolId s) { return s == x; });
  const auto has_x = [&](std::uint32_t id) { return depends[*position.find(ExprId(id))] != 0; };
  if (depends.back() == 0) return std::nullopt;

  ExprId at = expression;
  while (!pool.is_symbol(at)) {
    const ExprNode node = pool[at];  // a copy: the pool grows
    const int n = arity(node.op);
    const ExprId before = y;
    ExprId next;
    y = ExprId();
    if (n == 1) {
      y = undone(pool, node.op, before);
      next = ExprId(node.a);
    } else if (n == 2 && has_x(node.a) && has_x(node.b)) {
      const auto form = linear_in(pool, at, x);
      if (form && !pool.is_constant(form->slope, 0.0)) return pool.div(pool.sub(before, form->offset), form->slope);
    } else if (n == 2) {
      const bool first = has_x(node.a);
      y = undone(pool, node.op, ExprId(first ? node.b : node.a), first, before);
      next = ExprId(first ? node.a : node.b);
    }
    if (!y.valid()) return rest ? rest(at, before) : std::nullopt;
    at = next;
  }
  return y;
}

}  // namespace bgsim
