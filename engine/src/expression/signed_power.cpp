#include "expression/signed_power.hpp"

#include <cmath>
#include <unordered_map>
#include <vector>

#include "expression/graph.hpp"

namespace bgsim {

namespace {

/// factor * |x|^power, times sign(x) if it is odd; nothing else of an expression if the factor is none.
struct Term {
  ExprId factor;
  double power = 0.0;
  bool odd = false;
};

Term without_sign(ExprPool& pool, const Term& a, Op op, double power) {
  if (a.odd) return {};
  return {pool.make(op, a.factor), a.power * power, false};
}

Term raised(ExprPool& pool, const Term& a, ExprId exponent) {
  if (!pool.is_constant(exponent)) return {};
  const double n = pool[exponent].constant;
  if (a.odd && n != std::floor(n)) return {};
  return {pool.pow(a.factor, exponent), a.power * n, a.odd && std::fmod(n, 2.0) != 0.0};
}

Term combined(ExprPool& pool, const ExprNode& node, const Term& a, const Term& b) {
  if (!a.factor.valid() || (arity(node.op) > 1 && !b.factor.valid())) return {};
  switch (node.op) {
    case Op::neg:
      return {pool.neg(a.factor), a.power, a.odd};
    case Op::abs:
      return {pool.make(Op::abs, a.factor), a.power, false};
    case Op::sign:
      return {pool.make(Op::sign, a.factor), 0.0, a.odd};
    case Op::sqrt:
      return without_sign(pool, a, Op::sqrt, 0.5);
    case Op::cbrt:
      return {pool.make(Op::cbrt, a.factor), a.power / 3.0, a.odd};
    case Op::mul:
      return {pool.mul(a.factor, b.factor), a.power + b.power, a.odd != b.odd};
    case Op::div:
      return {pool.div(a.factor, b.factor), a.power - b.power, a.odd != b.odd};
    case Op::pow:
      return raised(pool, a, b.factor);
    default:
      return {};
  }
}

/// offset + factor * sign(x) * |x|^power; no factor: nothing of x is in it.
struct Sum {
  ExprId offset, factor;
  double power = 0.0;
};

/// @return  nothing where these are powers of two kinds.
std::optional<Sum> added(ExprPool& pool, const Sum& a, const Sum& b, bool minus) {
  const auto plus = [&](ExprId x, ExprId y) {
    if (!y.valid()) return x;
    if (!x.valid()) return minus ? pool.neg(y) : y;
    return minus ? pool.sub(x, y) : pool.add(x, y);
  };
  if (a.factor.valid() && b.factor.valid() && a.power != b.power) return std::nullopt;
  return Sum{plus(a.offset, b.offset), plus(a.factor, b.factor), a.factor.valid() ? a.power : b.power};
}

/// a * b or a / b, where one of both is free of x.
std::optional<Sum> scaled(ExprPool& pool, Op op, const Sum& a, const Sum& b) {
  const bool divided = op == Op::div;
  if (b.factor.valid() && (a.factor.valid() || divided)) return std::nullopt;
  const Sum& sum = b.factor.valid() ? b : a;
  const ExprId by = b.factor.valid() ? a.offset : b.offset;
  const auto times = [&](ExprId x) { return !x.valid() ? x : divided ? pool.div(x, by) : pool.mul(by, x); };
  return Sum{times(sum.offset), times(sum.factor), sum.power};
}

}  // namespace

std::optional<OffsetPower> offset_power(ExprPool& pool, ExprId expression, SymbolId x) {
  const std::vector<ExprId> nodes = reachable(pool, {&expression, 1});
  const std::vector<char> depends =
      depends_on(pool, nodes, positions(nodes), [x](SymbolId symbol) { return symbol == x; });
  std::unordered_map<ExprId, Term> terms;
  std::unordered_map<ExprId, std::optional<Sum>> sums;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode node = pool[nodes[i]];  // a copy: the pool grows
    Term& term = terms[nodes[i]];
    std::optional<Sum>& sum = sums[nodes[i]];
    if (depends[i] == 0) {
      term = {nodes[i], 0.0, false};
      sum = Sum{nodes[i], {}, 0.0};
      continue;
    }
    if (node.op == Op::symbol) {
      term = {pool.constant(1.0), 1.0, true};
    } else if (node.op == Op::add || node.op == Op::sub) {
      const std::optional<Sum> left = sums[ExprId(node.a)], right = sums[ExprId(node.b)];
      if (left && right) sum = added(pool, *left, *right, node.op == Op::sub);
      if (sum && !sum->offset.valid()) term = {sum->factor, sum->power, true};
      continue;
    } else if (arity(node.op) == 1 || arity(node.op) == 2) {
      term = combined(pool, node, terms[ExprId(node.a)], arity(node.op) > 1 ? terms[ExprId(node.b)] : Term{});
    }
    if (node.op == Op::neg && sums[ExprId(node.a)])
      sum = added(pool, {}, *sums[ExprId(node.a)], true);
    else if ((node.op == Op::mul || node.op == Op::div) && sums[ExprId(node.a)] && sums[ExprId(node.b)])
      sum = scaled(pool, node.op, *sums[ExprId(node.a)], *sums[ExprId(node.b)]);
    if (sum) continue;
    if (term.factor.valid() && term.odd && term.power > 0.0) sum = Sum{{}, term.factor, term.power};
  }
  const std::optional<Sum>& whole = sums[expression];
  if (!whole || !whole->factor.valid()) return std::nullopt;
  return OffsetPower{whole->offset, {whole->factor, whole->power}};
}

std::optional<SignedPower> signed_power(ExprPool& pool, ExprId expression, SymbolId x) {
  const std::optional<OffsetPower> whole = offset_power(pool, expression, x);
  return whole && !whole->offset.valid() ? std::optional(whole->power) : std::nullopt;
}

ExprId odd_root(ExprPool& pool, ExprId y, double power) {
  if (power <= 1.0) return odd_power(pool, y, 1.0 / power);
  if (power == 3.0) return pool.make(Op::cbrt, y);
  const ExprId size = pool.make(Op::abs, y);
  const ExprId root = power == 2.0 ? pool.make(Op::sqrt, size) : pool.pow(size, pool.constant(1.0 / power));
  return pool.mul(pool.make(Op::sign, y), root);
}

ExprId solution_of(ExprPool& pool, const OffsetPower& law, ExprId y) {
  const ExprId rest = law.offset.valid() ? pool.sub(y, law.offset) : y;
  return odd_root(pool, pool.div(rest, law.power.factor), law.power.power);
}

ExprId odd_power(ExprPool& pool, ExprId u, double power) {
  if (power == 1.0) return u;
  const ExprId size = pool.make(Op::abs, u);
  if (power == 2.0) return pool.mul(u, size);
  if (power == 3.0) return pool.pow(u, pool.constant(3.0));
  return pool.mul(u, pool.pow(size, pool.constant(power - 1.0)));
}

}  // namespace bgsim
