/// The constructors of ExprPool and their local simplifications.
///
/// Every rule looks at most two levels down, so that a constructor costs a constant. A node that is kept is one to
/// which no rule applies; building it again from its arguments therefore gives the same node (to_text and
/// parse_expression rely on it). Constants are folded only to finite values: 1/0 stays, so that its fault can be named.
/// Two rules go across a domain, on purpose: 0*x is 0 (derivatives would be full of such terms), and exp(log(u)) is u,
/// exp(log(u) + v) is u*exp(v): chemical potentials are logarithms of amounts, and without this rule an amount of
/// exactly 0 gives 0*inf in derivatives.
#include <cmath>
#include <stdexcept>
#include <utility>

#include "bgsim/expression.hpp"
#include "expression/graph.hpp"
#include "expression/rounded.hpp"

namespace bgsim {

namespace {

ExprNode node_of(Op op, ExprId a, ExprId b = ExprId(std::size_t{0}), ExprId c = ExprId(std::size_t{0})) {
  return {op, a.value, b.value, c.value, 0.0};
}

/// Read access with short names for the rules.
struct Look {
  const ExprPool& pool;

  [[nodiscard]] Op op(ExprId id) const { return pool[id].op; }
  [[nodiscard]] ExprId a(ExprId id) const { return ExprId(pool[id].a); }
  [[nodiscard]] ExprId b(ExprId id) const { return ExprId(pool[id].b); }
  [[nodiscard]] double value(ExprId id) const { return pool[id].constant; }
  [[nodiscard]] bool constant(ExprId id) const { return pool.is_constant(id); }
  [[nodiscard]] bool constant(ExprId id, double v) const { return pool.is_constant(id, v); }
  [[nodiscard]] bool negative(ExprId id) const { return constant(id) && value(id) < 0.0; }
  /// c*x with a constant c.
  [[nodiscard]] bool scaled(ExprId id) const { return op(id) == Op::mul && constant(a(id)); }
  /// c*x with a negative constant c.
  [[nodiscard]] bool scaled_negative(ExprId id) const { return scaled(id) && value(a(id)) < 0.0; }
  /// 0 or 1 whatever its arguments are.
  [[nodiscard]] bool truth_value(ExprId id) const {
    return is_logical(op(id)) || constant(id, 0.0) || constant(id, 1.0);
  }
};

/// The value of an operator on constants if it may be folded. What roundings leave of a difference (0.1 + 0.2 - 0.3) or
/// of a zero (sin(pi)) stays written as one, so that it can be distinguished from a small number.
std::optional<double> folded(Op op, double a, double b = 0.0) {
  constexpr double kCancelled = 1e-12, kMostlyRounding = 1e-4;
  const double value = apply(op, a, b);
  if (!std::isfinite(value)) return std::nullopt;
  const bool sum = op == Op::add || op == Op::sub;
  if (sum && value != 0.0 && std::abs(value) < kCancelled * std::abs(a)) return std::nullopt;
  const bool passes_zero = op == Op::sin || op == Op::cos || op == Op::tan || op == Op::log || op == Op::log10;
  if (passes_zero && value != 0.0 &&
      apply_rounded(op, {rounded_constant(a), {}, {}}, 1).error > kMostlyRounding * std::abs(value))
    return std::nullopt;
  return value;
}

/// -x at no cost: a negated constant, factor, or negation; else none.
ExprId cheap_negation(ExprPool& pool, ExprId x) {
  const Look look{pool};
  if (look.constant(x)) return pool.constant(-look.value(x));
  switch (look.op(x)) {
    case Op::neg:
      return look.a(x);
    case Op::sub:
      return pool.sub(look.b(x), look.a(x));
    case Op::mul:
      if (look.scaled(x)) return pool.mul(pool.constant(-look.value(look.a(x))), look.b(x));
      return {};
    case Op::div: {
      const ExprId top = look.a(x), bottom = look.b(x);
      if (look.constant(top)) return pool.div(pool.constant(-look.value(top)), bottom);
      if (look.scaled(top)) {
        const ExprId factor = pool.constant(-look.value(look.a(top)));
        return pool.div(pool.mul(factor, look.b(top)), bottom);
      }
      return {};
    }
    default:
      return {};
  }
}

/// Expression equal to op(a), or none if it is to be kept.
ExprId simplify(ExprPool& pool, Op op, ExprId a) {
  const Look look{pool};
  if (look.constant(a) && op != Op::der)
    if (const auto value = folded(op, look.value(a))) return pool.constant(*value);
  switch (op) {
    case Op::neg:
      return cheap_negation(pool, a);
    case Op::abs:
      if (look.op(a) == Op::abs) return a;
      if (look.op(a) == Op::neg) return pool.make(Op::abs, look.a(a));
      return {};
    case Op::floor:
    case Op::ceil:
    case Op::round:
      return is_rounding(look.op(a)) ? a : ExprId();
    case Op::logical_not:
      if (look.op(a) == Op::logical_not && look.truth_value(look.a(a))) return look.a(a);
      return {};
    case Op::der:
      return look.constant(a) ? pool.constant(0.0) : ExprId();
    case Op::exp: {
      if (look.op(a) == Op::log) return look.a(a);
      if (look.op(a) != Op::add && look.op(a) != Op::sub) return {};
      const ExprId left = look.a(a), right = look.b(a);
      if (look.op(left) == Op::log) {
        const ExprId rest = look.op(a) == Op::add ? right : pool.neg(right);
        const ExprId amount = Look{pool}.a(left);
        return pool.mul(amount, pool.make(Op::exp, rest));
      }
      if (look.op(right) == Op::log) {
        const ExprId amount = look.a(right);
        const bool sum = look.op(a) == Op::add;
        const ExprId rest = pool.make(Op::exp, left);
        return sum ? pool.mul(amount, rest) : pool.div(rest, amount);
      }
      return {};
    }
    default:
      return {};
  }
}

ExprId simplify_add(ExprPool& pool, ExprId a, ExprId b) {
  const Look look{pool};
  if (look.constant(a, 0.0)) return b;
  if (look.constant(b, 0.0)) return a;
  if (a == b) return pool.mul(pool.constant(2.0), a);
  if (look.constant(a)) std::swap(a, b);
  if (look.op(b) == Op::neg) return pool.sub(a, look.a(b));
  if (look.op(a) == Op::neg) return pool.sub(b, look.a(a));
  if (look.negative(b) || look.scaled_negative(b)) return pool.sub(a, cheap_negation(pool, b));
  if (look.scaled_negative(a)) return pool.sub(b, cheap_negation(pool, a));
  return {};
}

ExprId simplify_sub(ExprPool& pool, ExprId a, ExprId b) {
  const Look look{pool};
  if (look.constant(b, 0.0)) return a;
  if (look.constant(a, 0.0)) return pool.neg(b);
  if (a == b) return pool.constant(0.0);
  if (look.op(b) == Op::neg) return pool.add(a, look.a(b));
  if (look.op(a) == Op::neg) return pool.neg(pool.add(look.a(a), b));
  if (look.negative(b) || look.scaled_negative(b)) return pool.add(a, cheap_negation(pool, b));
  return {};
}

ExprId simplify_mul(ExprPool& pool, ExprId a, ExprId b) {
  const Look look{pool};
  if (look.constant(b)) std::swap(a, b);
  if (look.constant(a, 0.0)) return a;
  if (look.constant(a, 1.0)) return b;
  if (look.constant(a, -1.0)) return pool.neg(b);
  if (look.op(a) == Op::neg) return pool.neg(pool.mul(look.a(a), b));
  if (look.op(b) == Op::neg) {
    if (look.constant(a)) return pool.mul(cheap_negation(pool, a), look.a(b));
    return pool.neg(pool.mul(a, look.a(b)));
  }
  // Constant factors are gathered and stand outside.
  if (look.constant(a)) {
    if (!look.scaled(b)) return {};
    const double product = look.value(a) * look.value(look.a(b));
    if (!std::isnormal(product)) return {};
    return pool.mul(pool.constant(product), look.b(b));
  }
  if (look.scaled(b) && !look.scaled(a)) std::swap(a, b);
  if (!look.scaled(a) || look.scaled(look.b(a))) return {};
  if (look.scaled(b)) {
    if (look.scaled(look.b(b))) return {};
    const double product = look.value(look.a(a)) * look.value(look.a(b));
    if (!std::isnormal(product)) return {};
    const ExprId rest = pool.mul(look.b(a), look.b(b));
    return pool.mul(pool.constant(product), rest);
  }
  const ExprId factor = look.a(a);
  return pool.mul(factor, pool.mul(look.b(a), b));
}

ExprId simplify_div(ExprPool& pool, ExprId a, ExprId b) {
  const Look look{pool};
  if (look.constant(a, 0.0)) return look.constant(b, 0.0) ? ExprId() : a;
  if (look.constant(b, 1.0)) return a;
  if (look.constant(b, -1.0)) return pool.neg(a);
  if (look.op(b) == Op::neg) return pool.neg(pool.div(a, look.a(b)));
  if (look.op(a) == Op::neg) return pool.neg(pool.div(look.a(a), b));
  return {};
}

ExprId simplify_logic(const ExprPool& pool, Op op, ExprId a, ExprId b) {
  const Look look{pool};
  if (look.constant(b)) std::swap(a, b);
  const double neutral = op == Op::logical_and ? 1.0 : 0.0;
  if (look.constant(a, 1.0 - neutral)) return a;
  if (look.constant(a, neutral) && look.truth_value(b)) return b;
  return a == b && look.truth_value(a) ? a : ExprId();
}

/// Expression equal to op(a, b), or none if it is to be kept.
ExprId simplify(ExprPool& pool, Op op, ExprId a, ExprId b) {
  const Look look{pool};
  if (look.constant(a) && look.constant(b))
    if (const auto value = folded(op, look.value(a), look.value(b))) return pool.constant(*value);
  switch (op) {
    case Op::add:
      return simplify_add(pool, a, b);
    case Op::sub:
      return simplify_sub(pool, a, b);
    case Op::mul:
      return simplify_mul(pool, a, b);
    case Op::div:
      return simplify_div(pool, a, b);
    case Op::pow:
      if (look.constant(b, 1.0)) return a;
      if (look.constant(b, 0.0) || look.constant(a, 1.0)) return pool.constant(1.0);
      return {};
    case Op::min:
    case Op::max:
      return a == b ? a : ExprId();
    case Op::logical_and:
    case Op::logical_or:
      return simplify_logic(pool, op, a, b);
    default:
      return {};
  }
}

}  // namespace

ExprId ExprPool::constant(double value) {
  ExprNode node;
  node.constant = value == 0.0 ? 0.0 : value;  // -0 and 0 are one constant
  return intern(node);
}

ExprId ExprPool::symbol(SymbolId symbol) { return intern({Op::symbol, symbol.value, 0, 0, 0.0}); }

ExprId ExprPool::make(Op op, ExprId a) {
  if (arity(op) != 1 || is_table(op)) throw std::logic_error("ExprPool: not an operator of one argument");
  const ExprId simpler = simplify(*this, op, a);
  return simpler.valid() ? simpler : intern(node_of(op, a));
}

ExprId ExprPool::make(Op op, ExprId a, ExprId b) {
  if (arity(op) != 2) throw std::logic_error("ExprPool: not an operator of two arguments");
  const ExprId simpler = simplify(*this, op, a, b);
  if (simpler.valid()) return simpler;
  if (is_commutative(op)) {
    // One order for equal meanings: x*y and y*x are one node. Constants come first in products and last elsewhere.
    const bool constant_a = is_constant(a), constant_b = is_constant(b);
    const bool swap = constant_a == constant_b ? b < a : (op == Op::mul) == constant_b;
    if (swap) std::swap(a, b);
  }
  return intern(node_of(op, a, b));
}

ExprId ExprPool::select(ExprId condition, ExprId then, ExprId otherwise) {
  if (is_constant(condition) && !std::isnan(nodes_[condition.index()].constant))
    return nodes_[condition.index()].constant != 0.0 ? then : otherwise;
  if (then == otherwise) return then;
  if (nodes_[condition.index()].op == Op::logical_not)
    return select(ExprId(nodes_[condition.index()].a), otherwise, then);
  return intern(node_of(Op::select, condition, then, otherwise));
}

ExprId ExprPool::table(Op op, ExprId argument, TableId table) {
  if (!is_table(op)) throw std::logic_error("ExprPool: not a table operator");
  const Table& data = *tables_.at(table.index());
  if ((op == Op::table_curvature || op == Op::table_third) && data.interpolation == Interpolation::linear)
    return constant(0.0);
  if (is_constant(argument)) {
    const double x = nodes_[argument.index()].constant;
    const double value = apply_table(op, data, x);
    if (std::isfinite(value)) return constant(value);
  }
  return intern({op, argument.value, table.value, 0, 0.0});
}

}  // namespace bgsim
