#include <cmath>

#include "bgsim/expression.hpp"
#include "expression/graph.hpp"

namespace bgsim {

namespace {

bool is_odd_integer(double n) { return std::fabs(std::fmod(n, 2.0)) == 1.0; }

/// Undoes one operator after the other along the only path from the root to x.
class Inverter {
 public:
  explicit Inverter(ExprPool& pool) : pool_(pool) {}

  /// u with op(u) = y, for an operator of one argument that maps its whole real domain one to one.
  ExprId undo(Op op, ExprId y) {
    switch (op) {
      case Op::neg:
        return pool_.neg(y);
      case Op::exp:
        return pool_.make(Op::log, y);
      case Op::log:
        return pool_.make(Op::exp, y);
      case Op::log10:
        return pool_.pow(pool_.constant(10.0), y);
      case Op::cbrt:
        return pool_.pow(y, pool_.constant(3.0));
      case Op::tanh:
        return pool_.make(Op::atanh, y);
      case Op::atanh:
        return pool_.make(Op::tanh, y);
      case Op::sinh:
        return pool_.make(Op::asinh, y);
      case Op::asinh:
        return pool_.make(Op::sinh, y);
      case Op::expm1:
        return pool_.make(Op::log1p, y);
      case Op::log1p:
        return pool_.make(Op::expm1, y);
      default:
        return {};  // even, periodic, bounded by a kink, or without a closed form among the operators
    }
  }

  /// u with op(u, other) = y (x_first) or op(other, u) = y.
  ExprId undo(Op op, ExprId other, bool x_first, ExprId y) {
    switch (op) {
      case Op::add:
        return pool_.sub(y, other);
      case Op::sub:
        return x_first ? pool_.add(y, other) : pool_.sub(other, y);
      case Op::mul:
        return pool_.div(y, other);
      case Op::div:
        if (x_first) return pool_.mul(y, other);
        return pool_.is_constant(other, 0.0) ? ExprId() : pool_.div(other, y);
      case Op::pow:
        if (!pool_.is_constant(other)) return {};
        return x_first ? root(y, pool_[other].constant) : logarithm(y, pool_[other].constant);
      default:
        return {};
    }
  }

 private:
  /// u with u^n = y for odd n.
  ExprId root(ExprId y, double n) {
    if (!is_odd_integer(n)) return {};
    if (n == -1.0) return pool_.div(pool_.constant(1.0), y);
    const double m = std::fabs(n);
    ExprId u = m == 3.0
                   ? pool_.make(Op::cbrt, y)
                   : pool_.mul(pool_.make(Op::sign, y), pool_.pow(pool_.make(Op::abs, y), pool_.constant(1.0 / m)));
    if (n < 0.0) u = pool_.div(pool_.constant(1.0), u);
    return u;
  }
  /// u with base^u = y.
  ExprId logarithm(ExprId y, double base) {
    if (!(base > 0.0) || base == 1.0) return {};
    if (base == 10.0) return pool_.make(Op::log10, y);
    return pool_.div(pool_.make(Op::log, y), pool_.constant(std::log(base)));
  }

  ExprPool& pool_;
};

}  // namespace

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
  const std::vector<ExprId> nodes = reachable(pool, {&expression, 1});
  const IdMap<std::uint32_t> position = positions(nodes);
  const std::vector<char> depends = depends_on(pool, nodes, position, [x](SymbolId s) { return s == x; });
  const auto has_x = [&](std::uint32_t id) { return depends[*position.find(ExprId(id))] != 0; };
  if (depends.back() == 0) return std::nullopt;

  Inverter inverter(pool);
  ExprId at = expression;
  while (!pool.is_symbol(at)) {
    const ExprNode node = pool[at];  // a copy: the pool grows
    const int n = arity(node.op);
    if (n == 3) return std::nullopt;
    if (n == 1) {
      y = inverter.undo(node.op, y);
      at = ExprId(node.a);
    } else if (has_x(node.a) && has_x(node.b)) {
      const auto form = linear_in(pool, at, x);
      if (!form || pool.is_constant(form->slope, 0.0)) return std::nullopt;
      return pool.div(pool.sub(y, form->offset), form->slope);
    } else {
      const bool first = has_x(node.a);
      y = inverter.undo(node.op, ExprId(first ? node.b : node.a), first, y);
      at = ExprId(first ? node.a : node.b);
    }
    if (!y.valid()) return std::nullopt;
  }
  return y;
}

}  // namespace bgsim
