#include "expression/power_sum.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

#include "expression/graph.hpp"
#include "expression/signed_power.hpp"

namespace bgsim {
namespace {

constexpr std::size_t kMostTerms = 16;
constexpr double kHighestPower = 4.0;  ///< of a sum

using Sum = std::vector<PowerTerm>;  ///< of powers, one of each degree

void add(ExprPool& pool, Sum& sum, const PowerTerm& term) {
  const auto same = std::find_if(sum.begin(), sum.end(), [&](const PowerTerm& t) { return t.power == term.power; });
  if (same == sum.end())
    sum.push_back(term);
  else
    *same = added(pool, *same, term);
}

std::optional<Sum> product(ExprPool& pool, Op op, const Sum& a, const Sum& b) {
  if (a.size() * b.size() > kMostTerms || (op == Op::div && b.size() != 1)) return std::nullopt;
  Sum result;
  for (const PowerTerm& x : a)
    for (const PowerTerm& y : b) {
      const PowerTerm term = multiplied(pool, op, x, y);
      if (!term.is_power()) return std::nullopt;
      add(pool, result, term);
    }
  return result;
}

/// What is known of a part as one power, or one beside what is free of x.
Sum sum_of(const PowerTerm& term) {
  Sum sum{term};
  if (!term.offset.valid()) return sum;
  sum.front().offset = {};
  sum.push_back({{}, term.offset, 1.0, {}});
  return sum;
}

/// One side of a law as a sum of powers, with products and powers of sums written out; none if it is no such sum.
std::optional<Sum> expanded(ExprPool& pool, const Sides& sides, std::size_t side) {
  std::unordered_map<ExprId, std::optional<Sum>> sums;
  for (const ExprId e : reachable(pool, {&sides.expressions[side], 1})) {
    const ExprNode node = pool[e];  // a copy: the pool grows
    std::optional<Sum>& sum = sums[e];
    if (const PowerTerm& term = sides.terms[side].at(e); term.known()) {
      sum = sum_of(term);
      continue;
    }
    if (node.op == Op::symbol || node.op == Op::constant || is_table(node.op)) continue;
    const std::optional<Sum> a = sums.at(ExprId(node.a));
    const std::optional<Sum> b = arity(node.op) == 2 ? sums.at(ExprId(node.b)) : a;
    if (!a || !b) continue;
    if (node.op == Op::neg || node.op == Op::add || node.op == Op::sub) {
      sum = node.op == Op::neg ? Sum{} : *a;
      for (const PowerTerm& term : *b) add(pool, *sum, node.op == Op::add ? term : negated(pool, term));
    } else if (node.op == Op::mul || node.op == Op::div) {
      sum = product(pool, node.op, *a, *b);
    } else if (node.op == Op::pow && pool.is_constant(ExprId(node.b))) {
      const double n = pool[ExprId(node.b)].constant;
      if (!(n >= 2.0 && n <= kHighestPower && n == std::floor(n))) continue;
      sum = a;
      for (int k = 1; sum && k < static_cast<int>(n); ++k) sum = product(pool, Op::mul, *sum, *a);
    }
  }
  return sums.at(sides.expressions[side]);
}

/// Whether there is a product or power that is no power of x: of sums.
bool has_product_of_sums(const ExprPool& pool, const Sides& sides) {
  for (const auto& terms : sides.terms)
    for (const auto& [e, term] : terms) {
      const Op op = pool[e].op;
      if (!term.known() && (op == Op::mul || op == Op::div || op == Op::pow)) return true;
    }
  return false;
}

/// @p sum as odd powers of x; none where one has no slope at 0. @p free  what is free of x, invalid: 0
ExprId as_odd_powers(ExprPool& pool, const Sides& sides, const Sum& sum, bool above, ExprId& free) {
  ExprId whole;
  for (const PowerTerm& term : sum) {
    const bool is_free = term.power.is(0.0);
    if (!is_free && !(term.power.is_number() && term.power.number >= 1.0)) return {};
    ExprId part = term.factor;
    if (!is_free) part = pool.mul(part, odd_power(pool, pool.symbol(sides.x), term.power.number));
    if ((term.sign < 0.0) != (!above && !is_free)) part = pool.neg(part);
    if (is_free) free = part;
    whole = whole.valid() ? pool.add(whole, part) : part;
  }
  return whole;
}

bool has_condition(const ExprPool& pool, ExprId law) {
  const std::vector<ExprId> nodes = reachable(pool, {&law, 1});
  return std::any_of(nodes.begin(), nodes.end(), [&](ExprId e) {
    const Op op = pool[e].op;
    return op == Op::select || op == Op::sign || op == Op::step || is_comparison(op);
  });
}

}  // namespace

ExprId odd_power_sum(ExprPool& pool, ExprId law, const Sides& sides) {
  if (!sides.above_zero.empty() || (!has_product_of_sums(pool, sides) && !has_condition(pool, law))) return {};
  const std::optional<Sum> above = expanded(pool, sides, 0), below = above ? expanded(pool, sides, 1) : std::nullopt;
  if (!above || !below || (above->size() < 2 && below->size() < 2)) return {};
  ExprId free_above, free_below;
  const ExprId right = as_odd_powers(pool, sides, *above, true, free_above);
  const ExprId left = as_odd_powers(pool, sides, *below, false, free_below);
  if (!right.valid() || !left.valid() || free_above != free_below) return {};
  if (sides.at_zero != (free_above.valid() ? free_above : pool.constant(0.0))) return {};
  if (right == left) return right;
  return pool.select(pool.make(Op::ge, pool.symbol(sides.x), pool.constant(0.0)), right, left);
}

}  // namespace bgsim
