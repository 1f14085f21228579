#include "expression/signed_power.hpp"

namespace bgsim {
namespace {

std::optional<OffsetPower> offset_power(ExprPool& pool, ExprId expression, ExprId of, SymbolId x) {
  const Sides sides = sides_of(pool, expression, of, x);
  if (!sides.above_zero.empty()) return std::nullopt;
  const PowerTerm above = sides.terms[0].at(sides.expressions[0]), below = sides.terms[1].at(sides.expressions[1]);
  if (!above.factor.valid() || above.factor != below.factor || above.sign == below.sign ||
      (above.power.is_number() && !(above.power.number > 0.0)) || above.power != below.power ||
      above.offset != below.offset)
    return std::nullopt;
  // if(x == 0, 1, ...) is another one there.
  if (sides.at_zero != (above.offset.valid() ? above.offset : pool.constant(0.0))) return std::nullopt;
  return OffsetPower{above.offset, {above.sign < 0.0 ? pool.neg(above.factor) : above.factor, above.power}};
}

}  // namespace

std::optional<OffsetPower> offset_power(ExprPool& pool, ExprId expression, SymbolId x) {
  return offset_power(pool, expression, pool.symbol(x), x);
}

std::optional<SignedPower> signed_power(ExprPool& pool, ExprId expression, SymbolId x) {
  return signed_power(pool, expression, pool.symbol(x), x);
}

std::optional<SignedPower> signed_power(ExprPool& pool, ExprId expression, ExprId of, SymbolId x) {
  const std::optional<OffsetPower> whole = offset_power(pool, expression, of, x);
  return whole && !whole->offset.valid() ? std::optional(whole->power) : std::nullopt;
}

ExprId odd_root(ExprPool& pool, ExprId y, double power) {
  if (power <= 1.0) return odd_power(pool, y, 1.0 / power);
  if (power == 3.0) return pool.make(Op::cbrt, y);
  const ExprId size = pool.make(Op::abs, y);
  const ExprId root = power == 2.0 ? pool.make(Op::sqrt, size) : pool.pow(size, pool.constant(1.0 / power));
  return pool.mul(pool.make(Op::sign, y), root);
}

ExprId odd_root(ExprPool& pool, ExprId y, ExprId power) {
  const ExprId one = pool.constant(1.0);
  if (pool.is_constant(power)) return odd_root(pool, y, pool[power].constant);
  const ExprId inverse = pool.div(one, power);
  const ExprId root = pool.mul(pool.make(Op::sign, y), pool.pow(pool.make(Op::abs, y), inverse));
  return pool.select(pool.make(Op::le, power, one), odd_power(pool, y, inverse), root);
}

ExprId solution_of(ExprPool& pool, const OffsetPower& law, ExprId y) {
  const ExprId rest = law.offset.valid() ? pool.sub(y, law.offset) : y;
  return odd_root(pool, pool.div(rest, law.power.factor), expression_of(pool, law.power.power));
}

ExprId odd_power(ExprPool& pool, ExprId u, double power) {
  if (power == 1.0) return u;
  const ExprId size = pool.make(Op::abs, u);
  if (power == 2.0) return pool.mul(u, size);
  if (power == 3.0) return pool.pow(u, pool.constant(3.0));
  return pool.mul(u, pool.pow(size, pool.constant(power - 1.0)));
}

ExprId odd_power(ExprPool& pool, ExprId u, ExprId power) {
  if (pool.is_constant(power)) return odd_power(pool, u, pool[power].constant);
  const ExprId one = pool.constant(1.0);
  const ExprId product = pool.mul(u, pool.pow(pool.make(Op::abs, u), pool.sub(power, one)));
  return pool.select(pool.make(Op::eq, power, one), u, product);  // |u|^0 has no slope at 0
}

}  // namespace bgsim
