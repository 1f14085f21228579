#include "equations/law_forms.hpp"

#include <algorithm>
#include <vector>

#include "expression/graph.hpp"
#include "expression/signed_power.hpp"

namespace bgsim {
namespace {

/// y = c sign(x) |x|^n for n < 1, solved for x. A valve that is shut (c = 0) lets nothing through, whatever x is.
ExprId root_form(ExprPool& pool, ExprId y, const SignedPower& law, ExprId x) {
  const bool never_shut = pool.is_constant(law.factor) && !pool.is_constant(law.factor, 0.0);
  const ExprId shut = pool.make(Op::eq, law.factor, pool.constant(0.0));
  const ExprId factor = never_shut ? law.factor : pool.select(shut, pool.constant(1.0), law.factor);
  const ExprId inverse = pool.div(pool.constant(1.0), expression_of(pool, law.power));
  const ExprId form = pool.sub(x, odd_power(pool, pool.div(y, factor), inverse));
  return never_shut ? form : pool.select(shut, y, form);
}

/// y = c sign(x) |x|^n without a root: its slope has a bound at 0, where that of the root has none.
/// @param right  the law, as it is for n <= 0
ExprId power_form(ExprPool& pool, ExprId y, ExprId right, const SignedPower& law, ExprId x) {
  const auto form_above_1 = [&] {
    return pool.sub(y, pool.mul(law.factor, odd_power(pool, x, expression_of(pool, law.power))));
  };
  if (law.power.is_number()) return law.power.number >= 1.0 ? form_above_1() : root_form(pool, y, law, x);
  const ExprId power = expression_of(pool, law.power);
  const auto is = [&](Op comparison, double value) { return pool.make(comparison, power, pool.constant(value)); };
  return pool.select(is(Op::ge, 1.0), form_above_1(),
                     pool.select(is(Op::gt, 0.0), root_form(pool, y, law, x), pool.sub(y, right)));
}

/// Whether there are conditions in it that the run watches.
bool has_conditions(const ExprPool& pool, ExprId root) {
  const std::vector<ExprId> nodes = reachable(pool, {&root, 1});
  return std::any_of(nodes.begin(), nodes.end(), [&](ExprId e) {
    const Op op = pool[e].op;
    return op == Op::select || op == Op::sign || op == Op::step || is_comparison(op);
  });
}

/// Whether the inverse of a law is defined over a part of the numbers only: the law goes towards a limit, where the
/// inverse has no digits left (the voltage of a diode that blocks).
bool levels_off(const ExprPool& pool, ExprId inverse, ExprId law) {
  const auto count = [&](ExprId root) {
    const std::vector<ExprId> nodes = reachable(pool, {&root, 1});
    return std::count_if(nodes.begin(), nodes.end(), [&](ExprId e) {
      const Op op = pool[e].op;
      return op == Op::log || op == Op::log1p || op == Op::log10 || op == Op::atanh;
    });
  };
  return count(inverse) > count(law);
}

}  // namespace

ExprId form_of_inverted(ExprPool& pool, ExprId left, ExprId right, SymbolId unknown, ExprId solution) {
  const bool conditions = has_conditions(pool, solution);
  const auto power = signed_power(pool, right, unknown);
  if (power && !power->power.is(1.0)) return power_form(pool, left, right, *power, pool.symbol(unknown));
  if (levels_off(pool, solution, right) || (conditions && !has_conditions(pool, right))) return pool.sub(left, right);
  return {};
}

ExprId form_of_written(ExprPool& pool, ExprId left, ExprId right, SymbolId other) {
  const auto power = signed_power(pool, right, other);
  if (power && (!power->power.is_number() || power->power.number < 1.0 || has_conditions(pool, right)))
    return power_form(pool, left, right, *power, pool.symbol(other));
  const auto inverse = invert(pool, right, other, left);
  if (inverse && levels_off(pool, right, *inverse)) return pool.sub(pool.symbol(other), *inverse);
  return {};
}

}  // namespace bgsim
