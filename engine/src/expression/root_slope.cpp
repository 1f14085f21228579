#include "expression/root_slope.hpp"

namespace bgsim {
namespace {

bool is_root(const ExprPool& pool, const ExprNode& node) {
  if (node.op == Op::sqrt || node.op == Op::cbrt) return true;
  if (node.op != Op::pow) return false;
  const ExprNode& power = pool[ExprId(node.b)];
  return power.op != Op::constant || (power.constant > 0.0 && power.constant < 1.0);
}

ExprId power_of(ExprPool& pool, const ExprNode& root) {
  if (root.op == Op::pow) return ExprId(root.b);
  return pool.constant(root.op == Op::sqrt ? 0.5 : 1.0 / 3.0);
}

/// @p product without its factor @p u; none if that is not among its factors.
/// @param looks  so many parts are looked at: squares of squares have more than can be counted
ExprId without_factor(ExprPool& pool, ExprId product, ExprId u, int& looks) {
  if (product == u) return pool.constant(1.0);
  if (looks-- <= 0) return {};
  const ExprNode node = pool[product];  // a copy: the pool grows
  const ExprId a(node.a), b(node.b);
  if (node.op != Op::neg && node.op != Op::mul && node.op != Op::div) return {};
  if (const ExprId rest = without_factor(pool, a, u, looks); rest.valid())
    return node.op == Op::neg ? pool.neg(rest) : pool.make(node.op, rest, b);
  if (node.op != Op::mul) return {};
  const ExprId rest = without_factor(pool, b, u, looks);
  return rest.valid() ? pool.mul(a, rest) : rest;
}

/// Of u^k with k > 0, |u|^k, a root of u, c u or u/c, where c does not vary: u, and k.
struct Inner {
  ExprId of;
  double power = 1.0;
};
Inner inner(const ExprPool& pool, ExprId e, const std::function<bool(ExprId)>& varies) {
  const ExprNode& node = pool[e];
  const ExprId a(node.a), b(node.b);
  switch (node.op) {
    case Op::abs:
    case Op::neg:
      return {a, 1.0};
    case Op::sqrt:
      return {a, 0.5};
    case Op::cbrt:
      return {a, 1.0 / 3.0};
    case Op::pow:
      return pool.is_constant(b) && pool[b].constant > 0.0 ? Inner{a, pool[b].constant} : Inner{{}, 1.0};
    case Op::mul:
      if (a == b) return {a, 2.0};
      return !varies(a) ? Inner{b, 1.0} : !varies(b) ? Inner{a, 1.0} : Inner{{}, 1.0};
    case Op::div:
      return !varies(b) ? Inner{a, 1.0} : Inner{{}, 1.0};
    default:
      return {{}, 1.0};
  }
}

}  // namespace

std::optional<RootSlope> root_slope(ExprPool& pool, ExprId root, ExprId factor,
                                    const std::function<bool(ExprId)>& varies) {
  constexpr int kMostLooks = 100;
  const ExprNode node = pool[root];  // a copy: the pool grows
  int looks = kMostLooks;
  if (node.op == Op::abs) {
    const ExprId rest = without_factor(pool, factor, pool.make(Op::sign, ExprId(node.a)), looks);
    return rest.valid() ? std::optional(RootSlope{ExprId(node.a), rest}) : std::nullopt;
  }
  if (!is_root(pool, node)) return std::nullopt;
  double more = 1.0;
  for (ExprId u(node.a); u.valid() && varies(u) && looks > 0;) {
    if (const ExprId rest = without_factor(pool, factor, u, looks); rest.valid()) {
      const ExprId n = pool.mul(pool.constant(more), power_of(pool, node));
      return RootSlope{u, pool.mul(pool.mul(n, rest), root)};
    }
    const Inner next = inner(pool, u, varies);
    more *= next.power;
    u = next.of;
  }
  return std::nullopt;
}

}  // namespace bgsim
