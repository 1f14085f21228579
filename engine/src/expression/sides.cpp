#include "expression/sides.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <vector>

#include "expression/graph.hpp"

namespace bgsim {
namespace {

using Images = std::unordered_map<ExprId, ExprId>;

/// 1 or -1 where @p e is x or -x, or one of these times a number above 0; else 0.
int multiple_of(ExprPool& pool, ExprId e, ExprId x) {
  if (e == x) return 1;
  const ExprNode node = pool[e];
  const auto sign = [&](ExprId number) {
    const double value = pool[number].constant;
    return value > 0.0 ? 1 : value < 0.0 ? -1 : 0;
  };
  if (node.op == Op::mul && pool.is_constant(ExprId(node.a)))
    return multiple_of(pool, ExprId(node.b), x) * sign(ExprId(node.a));
  if (node.op == Op::div && pool.is_constant(ExprId(node.b)))
    return multiple_of(pool, ExprId(node.a), x) * sign(ExprId(node.b));
  if (node.op == Op::neg) return -multiple_of(pool, ExprId(node.a), x);
  return node.op == Op::sub && pool.sub(ExprId(node.b), ExprId(node.a)) == x ? -1 : 0;
}

/// What a comparison of a with b is where the sign of a - b is that.
bool holds(Op comparison, int sign) {
  switch (comparison) {
    case Op::lt:
      return sign < 0;
    case Op::le:
      return sign <= 0;
    case Op::gt:
      return sign > 0;
    case Op::ge:
      return sign >= 0;
    case Op::eq:
      return sign == 0;
    default:
      return sign != 0;
  }
}

/// A comparison, sign, abs, min or max by the sign of x; none for what this does not decide.
ExprId decided(ExprPool& pool, const ExprNode& node, ExprId x, int sign_of_x, const Images& images) {
  const bool two = is_comparison(node.op) || node.op == Op::min || node.op == Op::max;
  if (!two && node.op != Op::sign && node.op != Op::abs && node.op != Op::step) return {};
  const ExprId a(node.a), b(node.b);
  const int multiple = multiple_of(pool, two ? pool.sub(a, b) : a, x), sign = multiple * sign_of_x;
  if (multiple == 0) return {};
  switch (node.op) {
    case Op::sign:
      return pool.constant(sign);
    case Op::step:
      return pool.constant(sign >= 0 ? 1.0 : 0.0);
    case Op::abs:
      return sign >= 0 ? images.at(a) : pool.neg(images.at(a));
    case Op::max:
      return images.at(sign >= 0 ? a : b);
    case Op::min:
      return images.at(sign >= 0 ? b : a);
    default:
      return pool.constant(holds(node.op, sign) ? 1.0 : 0.0);
  }
}

/// @p expression where x has that sign, with @p symbol for it.
/// @param above_zero  gets the exponents that were taken to be above 0
ExprId where_sign_is(int sign, ExprPool& pool, ExprId expression, ExprId x, SymbolId symbol,
                     std::vector<ExprId>& above_zero) {
  const ExprId there = sign == 0 ? pool.constant(0.0) : pool.symbol(symbol);
  Images images;
  for (const ExprId e : reachable(pool, {&expression, 1})) {
    const ExprNode node = pool[e];  // a copy: the pool grows
    ExprId image = e == x ? there : decided(pool, node, x, sign, images);
    if (node.op == Op::pow && !pool.is_constant(ExprId(node.a)) && !pool.is_constant(ExprId(node.b)) &&
        pool.is_constant(images.at(ExprId(node.a)), 0.0)) {
      image = images.at(ExprId(node.a));
      above_zero.push_back(images.at(ExprId(node.b)));
    }
    if (!image.valid() && node.op == Op::sub && pool.sub(ExprId(node.b), ExprId(node.a)) == x) image = pool.neg(there);
    images[e] = image.valid() ? image : rebuilt(pool, node, [&](ExprId a) { return images.at(a); });
  }
  return images.at(expression);
}

using Terms = std::unordered_map<ExprId, PowerTerm>;

ExprId signed_by(ExprPool& pool, double sign, ExprId e) { return sign < 0.0 ? pool.neg(e) : e; }

Degree times(Degree a, double by) {
  if (by == 0.0) return {};
  return {a.number * by, a.times * by, a.of};
}

/// None if it is no sum of a number and a multiple of one expression.
std::optional<Degree> sum(const Degree& a, const Degree& b) {
  if (!a.is_number() && !b.is_number() && a.of != b.of) return std::nullopt;
  Degree result{a.number + b.number, a.times + b.times, a.is_number() ? b.of : a.of};
  if (result.times == 0.0) result.of = {};
  return result;
}

/// Of an exponent.
Degree degree_of(const ExprPool& pool, ExprId e) {
  const ExprNode& node = pool[e];
  const ExprId a(node.a), b(node.b);
  const auto number = [&](ExprId of) { return pool[of].constant; };
  std::optional<Degree> result;
  if (node.op == Op::constant) result = Degree{node.constant, 0.0, {}};
  if (node.op == Op::neg) result = times(degree_of(pool, a), -1.0);
  if (node.op == Op::add) result = sum(degree_of(pool, a), degree_of(pool, b));
  if (node.op == Op::sub) result = sum(degree_of(pool, a), times(degree_of(pool, b), -1.0));
  if (node.op == Op::mul && pool.is_constant(a)) result = times(degree_of(pool, b), number(a));
  if (node.op == Op::mul && pool.is_constant(b)) result = times(degree_of(pool, a), number(b));
  if (node.op == Op::div && pool.is_constant(b)) result = times(degree_of(pool, a), 1.0 / number(b));
  return result.value_or(Degree{0.0, 1.0, e});
}

/// What is free of x is of the power 0.
PowerTerm free_term(ExprPool& pool, ExprId e) {
  const bool negative = pool.is_constant(e) && pool[e].constant < 0.0;
  return {{}, negative ? pool.neg(e) : e, negative ? -1.0 : 1.0, {}};
}

/// What a root is taken of has to have a sign by which it is above 0: else it has a value on the other side alone.
PowerTerm raised(ExprPool& pool, const ExprNode& node, const PowerTerm& a, const Degree& by) {
  if (!a.power.is_number() && !by.is_number()) return {};
  const Degree power = by.is_number() ? times(a.power, by.number) : times(by, a.power.number);
  if (node.op == Op::cbrt) return {{}, pool.make(node.op, a.factor), a.sign, power};
  const bool is_root = !by.is_number() || by.number != std::floor(by.number);
  const bool odd = std::fmod(by.number, 2.0) != 0.0;
  if (is_root && a.sign < 0.0) return {};
  const ExprId factor = node.op == Op::sqrt ? pool.make(node.op, a.factor) : pool.pow(a.factor, ExprId(node.b));
  return {{}, factor, is_root || !odd ? 1.0 : a.sign, power};
}

}  // namespace

PowerTerm negated(ExprPool& pool, PowerTerm a) {
  if (a.offset.valid()) a.offset = pool.neg(a.offset);
  a.sign = -a.sign;
  return a;
}

PowerTerm added(ExprPool& pool, const PowerTerm& a, const PowerTerm& b) {
  if (a.is_power() && b.is_power() && a.power == b.power) {
    const ExprId factor = a.sign == b.sign ? pool.add(a.factor, b.factor) : pool.sub(a.factor, b.factor);
    return {{}, factor, a.sign, a.power};
  }
  const bool a_free = a.power.is(0.0), b_free = b.power.is(0.0);
  if (!a_free && !b_free && a.power != b.power) return {};
  const auto offset = [&](const PowerTerm& term) {
    return term.power.is(0.0) ? signed_by(pool, term.sign, term.factor) : term.offset;
  };
  const ExprId first = offset(a), second = offset(b);
  PowerTerm sum = a_free ? b : a;
  if (!a_free && !b_free) sum.factor = a.sign == b.sign ? pool.add(a.factor, b.factor) : pool.sub(a.factor, b.factor);
  sum.offset = !first.valid() ? second : !second.valid() ? first : pool.add(first, second);
  return sum;
}

PowerTerm multiplied(ExprPool& pool, Op op, const PowerTerm& a, const PowerTerm& b) {
  if (a.is_power() && b.is_power()) {
    const auto power = sum(a.power, op == Op::div ? times(b.power, -1.0) : b.power);
    if (!power) return {};
    return {{}, pool.make(op, a.factor, b.factor), a.sign * b.sign, *power};
  }
  // A sum: times what is free of x alone.
  const PowerTerm& by = a.is_power() ? a : b;
  if (!by.is_power() || !by.power.is(0.0) || (op == Op::div && a.is_power())) return {};
  PowerTerm product = a.is_power() ? b : a;
  product.offset = pool.make(op, product.offset, signed_by(pool, by.sign, by.factor));
  product.factor = pool.make(op, product.factor, by.factor);
  product.sign *= by.sign;
  return product;
}

namespace {

PowerTerm combined(ExprPool& pool, const ExprNode& node, const PowerTerm& a, const PowerTerm& b) {
  switch (node.op) {
    case Op::neg:
      return negated(pool, a);
    case Op::add:
      return added(pool, a, b);
    case Op::sub:
      return added(pool, a, negated(pool, b));
    case Op::mul:
    case Op::div:
      return multiplied(pool, node.op, a, b);
    default:
      break;
  }
  if (!a.is_power()) return {};
  switch (node.op) {
    case Op::abs:
      return {{}, pool.make(Op::abs, a.factor), 1.0, a.power};
    case Op::sign:
      return {{}, pool.make(Op::sign, a.factor), a.sign, {}};
    case Op::sqrt:
      return raised(pool, node, a, {0.5, 0.0, {}});
    case Op::cbrt:
      return raised(pool, node, a, {1.0 / 3.0, 0.0, {}});
    case Op::pow:
      return b.power.is(0.0) ? raised(pool, node, a, degree_of(pool, ExprId(node.b))) : PowerTerm{};
    default:
      return {};
  }
}

/// Of all parts of @p expression, in which @p x is the symbol of x.
Terms terms_of(ExprPool& pool, ExprId expression, SymbolId x, bool positive) {
  const std::vector<ExprId> nodes = reachable(pool, {&expression, 1});
  const std::vector<char> depends =
      depends_on(pool, nodes, positions(nodes), [x](SymbolId symbol) { return symbol == x; });
  Terms terms;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode node = pool[nodes[i]];                                                    // a copy: the pool grows
    const bool is_product = node.op == Op::mul || node.op == Op::div || node.op == Op::neg;  // whose sign may be seen
    PowerTerm term;
    if (depends[i] == 0 && !is_product) {
      term = free_term(pool, nodes[i]);
    } else if (node.op == Op::symbol) {
      term = {{}, pool.constant(1.0), positive ? 1.0 : -1.0, {1.0, 0.0, {}}};
    } else if (arity(node.op) < 3 && !is_table(node.op)) {
      const PowerTerm a = terms.at(ExprId(node.a)), b = arity(node.op) > 1 ? terms.at(ExprId(node.b)) : a;
      if (a.known() && b.known()) term = combined(pool, node, a, b);
    }
    terms[nodes[i]] = term;
  }
  return terms;
}

/// Powers that are below 1, or no numbers, of terms that are no factors of others: that of x |x|^0.3 has a slope at 0,
/// and so has that of x (K + |x|^0.3), which is no power.
void add_roots(const ExprPool& pool, ExprId expression, const Terms& terms, double& least,
               std::vector<Degree>& others) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const std::vector<ExprId> nodes = reachable(pool, {&expression, 1});
  const IdMap<std::uint32_t> position = positions(nodes);
  std::vector<double> beside(nodes.size(), kNone);  // by node: the least power of x that it is multiplied by
  std::vector<char> is_factor(nodes.size(), 1);     // by node: of a product that is no power, and nothing else
  beside.back() = 0.0;
  is_factor.back() = 0;
  const auto pass = [&](ExprId e, double power, bool in_product) {
    const std::uint32_t i = *position.find(e);
    beside[i] = std::min(beside[i], power);
    if (!in_product) is_factor[i] = 0;
  };
  const auto number = [&](ExprId e) {
    const PowerTerm& term = terms.at(e);
    return term.is_power() ? std::max(0.0, term.power.number) : 0.0;
  };
  for (std::size_t i = nodes.size(); i-- > 0;) {
    if (beside[i] == kNone) continue;
    const PowerTerm& term = terms.at(nodes[i]);
    if (term.known()) {
      Degree power = term.power;
      power.number += beside[i];
      if (term.power.is_number() && term.power.number > 0.0) least = std::min(least, power.number);
      // x^(1 + n) beside another factor: of n below 0 that has no value at 0 anyway.
      const bool has_slope = is_factor[i] != 0 && power.number >= 1.0;
      if (!power.is_number() && !has_slope && std::find(others.begin(), others.end(), power) == others.end())
        others.push_back(power);
      continue;
    }
    const ExprNode& node = pool[nodes[i]];
    const ExprId a(node.a), b(node.b);
    if (node.op == Op::mul) {
      pass(a, beside[i] + number(b), true);
      pass(b, beside[i] + number(a), true);
    } else if (node.op == Op::neg || node.op == Op::add || node.op == Op::sub) {
      for_each_argument(node, [&](ExprId argument) { pass(argument, beside[i], is_factor[i] != 0); });
    } else {
      for_each_argument(node, [&](ExprId argument) { pass(argument, 0.0, false); });
    }
  }
}

}  // namespace

ExprId expression_of(ExprPool& pool, const Degree& degree) {
  const ExprId number = pool.constant(degree.number);
  if (degree.is_number()) return number;
  const ExprId product = pool.mul(pool.constant(degree.times), degree.of);
  return degree.number == 0.0 ? product : pool.add(product, number);
}

Sides sides_of(ExprPool& pool, ExprId law, ExprId of, SymbolId x) {
  Sides sides;
  sides.x = x;
  std::vector<ExprId> at_zero;
  sides.at_zero = where_sign_is(0, pool, law, of, x, at_zero);
  double least = 1.0;
  std::vector<Degree> others;
  for (const std::size_t side : {0U, 1U}) {
    sides.expressions[side] = where_sign_is(side == 0 ? 1 : -1, pool, law, of, x, sides.above_zero);
    sides.terms[side] = terms_of(pool, sides.expressions[side], x, side == 0);
    add_roots(pool, sides.expressions[side], sides.terms[side], least, others);
  }
  if (least == 1.0 && others.empty()) return sides;
  const ExprId zero = pool.constant(0.0), one = pool.constant(1.0);
  // Most laws have one. Its border is where its value is 1, and not, as that of the least of it and 1, wherever it is
  // no root: there a derivative by it would be that of one side.
  if (least == 1.0 && others.size() == 1) {
    sides.power = expression_of(pool, others.front());
    sides.is_root =
        pool.make(Op::logical_and, pool.make(Op::gt, sides.power, zero), pool.make(Op::lt, sides.power, one));
    return sides;
  }
  sides.power = pool.constant(least);
  std::sort(others.begin(), others.end(), [](const Degree& a, const Degree& b) {
    return std::tie(a.of, a.times, a.number) < std::tie(b.of, b.times, b.number);
  });
  for (const Degree& other : others) {
    const ExprId power = expression_of(pool, other), is_power = pool.make(Op::gt, power, zero);
    sides.power = pool.make(Op::min, sides.power, pool.select(is_power, power, one));
  }
  return sides;
}

}  // namespace bgsim
