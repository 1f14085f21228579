#include "expression/write/tidy.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace bgsim {
namespace {

constexpr std::size_t kMostTerms = 10'000;
constexpr int kLargestPower = 8;

bool is_sum(Op op) { return op == Op::add || op == Op::sub; }

}  // namespace

Tidier::Tidier(const ExprPool& from, std::span<const SymbolId> order) : from_(from) {
  for (const auto& table : from.tables()) to_.add_table(table);
  for (const SymbolId symbol : order) to_.symbol(symbol);  // smaller ids stand first in a product
}

ExprId Tidier::operator()(ExprId root) {
  const std::vector<ExprId> roots{root};
  const std::vector<ExprId> nodes = reachable(from_, roots);
  // What is only part of longer sums needs no form of its own.
  std::unordered_map<ExprId, bool> inside_sum;
  for (const ExprId e : nodes) {
    const ExprNode& node = from_[e];
    if (node.op == Op::constant || node.op == Op::symbol) continue;
    const std::uint32_t children[] = {node.a, node.b, node.c};
    for (int k = 0; k < arity(node.op); ++k) {
      const auto [entry, is_new] = inside_sum.try_emplace(ExprId(children[k]), is_sum(node.op));
      if (!is_new) entry->second = entry->second && is_sum(node.op);
    }
  }
  for (const ExprId e : nodes) {
    if (known_.contains(e)) continue;
    const bool sum = is_sum(from_[e].op);
    if (sum && e != root && inside_sum[e]) continue;
    known_[e] = sum ? read_sum(e) : read(e);
  }
  return write(known_.at(root));
}

Tidier::Monomial Tidier::multiply(const Monomial& a, const Monomial& b, int power_of_b) {
  Monomial result;
  result.coefficient = a.coefficient * std::pow(b.coefficient, power_of_b);
  std::map<ExprId, int> powers(a.factors.begin(), a.factors.end());
  for (const auto& [factor, power] : b.factors) powers[factor] += power * power_of_b;
  for (const auto& [factor, power] : powers)
    if (power != 0) result.factors.emplace_back(factor, power);
  return result;
}

Tidier::Monomial Tidier::read(ExprId expression) {
  const ExprNode& node = from_[expression];
  const auto child = [this](std::uint32_t index) -> const Monomial& { return known_.at(ExprId(index)); };
  const auto text = [&](std::uint32_t index) { return write(child(index)); };
  switch (node.op) {
    case Op::constant:
      return {node.constant, {}};
    case Op::symbol:
      return atom(to_.symbol(SymbolId(node.a)));
    case Op::neg: {
      Monomial result = child(node.a);
      result.coefficient = -result.coefficient;
      return result;
    }
    case Op::mul:
      return multiply(child(node.a), child(node.b), 1);
    case Op::div:
      if (child(node.b).coefficient == 0.0) break;
      return multiply(child(node.a), child(node.b), -1);
    case Op::pow: {
      const Monomial& exponent = child(node.b);
      const double n = exponent.coefficient;
      if (!exponent.factors.empty() || n != std::round(n) || std::abs(n) > kLargestPower ||
          child(node.a).coefficient == 0.0)
        break;
      return multiply({}, child(node.a), static_cast<int>(n));
    }
    case Op::table:
    case Op::table_slope:
      return atom(to_.table(node.op, text(node.a), TableId(node.b)));
    default:
      break;
  }
  switch (arity(node.op)) {
    case 1:
      return atom(to_.make(node.op, text(node.a)));
    case 2:
      return atom(to_.make(node.op, text(node.a), text(node.b)));
    default:
      return atom(to_.select(text(node.a), text(node.b), text(node.c)));
  }
}

/// Terms of a sum in order of appearance, like terms collected, those with a positive coefficient first.
Tidier::Monomial Tidier::read_sum(ExprId expression) {
  std::vector<std::pair<ExprId, double>> open{{expression, 1.0}};
  std::vector<Monomial> terms;
  std::map<std::vector<std::pair<ExprId, int>>, std::size_t> position;
  std::size_t visited = 0;
  while (!open.empty()) {
    const auto [e, sign] = open.back();
    open.pop_back();
    const ExprNode& node = from_[e];
    if (is_sum(node.op) && (visited++ < kMostTerms || !known_.contains(e))) {
      open.emplace_back(node.b, node.op == Op::add ? sign : -sign);
      open.emplace_back(node.a, sign);
      continue;
    }
    if (node.op == Op::neg) {
      open.emplace_back(node.a, -sign);
      continue;
    }
    Monomial term = known_.at(e);
    term.coefficient *= sign;
    const auto [entry, is_new] = position.try_emplace(term.factors, terms.size());
    if (is_new)
      terms.push_back(std::move(term));
    else
      terms[entry->second].coefficient += term.coefficient;
  }
  std::erase_if(terms, [](const Monomial& term) { return term.coefficient == 0.0; });
  if (terms.empty()) return {0.0, {}};
  if (terms.size() == 1) return terms.front();
  std::stable_partition(terms.begin(), terms.end(), [](const Monomial& term) { return term.coefficient > 0.0; });
  const bool all_negative = terms.front().coefficient < 0.0;
  ExprId sum;
  for (Monomial term : terms) {
    if (all_negative) term.coefficient = -term.coefficient;
    const bool subtract = term.coefficient < 0.0;
    if (subtract) term.coefficient = -term.coefficient;
    const ExprId written = write(term);
    sum = !sum.valid() ? written : subtract ? to_.sub(sum, written) : to_.add(sum, written);
  }
  Monomial result = atom(sum);
  if (all_negative) result.coefficient = -1.0;
  return result;
}

ExprId Tidier::write_factors(const Monomial& monomial, double coefficient, int sign) {
  ExprId product = coefficient == 1.0 ? ExprId{} : to_.constant(coefficient);
  for (const auto& [factor, power] : monomial.factors) {
    if (power * sign <= 0) continue;
    const ExprId raised = power * sign == 1 ? factor : to_.pow(factor, to_.constant(power * sign));
    product = product.valid() ? to_.mul(product, raised) : raised;
  }
  return product;
}

/// The terms of a sum that has been written, with their signs.
std::vector<std::pair<ExprId, bool>> Tidier::terms_of(ExprId sum) const {
  std::vector<std::pair<ExprId, bool>> terms, open{{sum, true}};
  while (!open.empty()) {
    const auto [e, positive] = open.back();
    open.pop_back();
    const ExprNode& node = to_[e];
    if (is_sum(node.op)) {
      open.emplace_back(node.b, node.op == Op::add ? positive : !positive);
      open.emplace_back(node.a, positive);
    } else if (node.op == Op::neg) {
      open.emplace_back(node.a, !positive);
    } else {
      terms.emplace_back(e, positive);
    }
  }
  return terms;
}

/// Minus a sum: every sign turned, a positive term first. None if the sum has no negative term to begin with.
ExprId Tidier::turned(ExprId sum) {
  std::vector<std::pair<ExprId, bool>> terms = terms_of(sum);
  std::stable_partition(terms.begin(), terms.end(), [](const auto& term) { return !term.second; });
  if (terms.front().second) return {};
  ExprId result;
  for (const auto& [term, positive] : terms)
    result = !result.valid() ? term : positive ? to_.sub(result, term) : to_.add(result, term);
  return result;
}

ExprId Tidier::write(const Monomial& monomial) {
  if (monomial.coefficient == 0.0) return to_.constant(0.0);
  if (monomial.coefficient < 0.0)
    for (std::size_t i = 0; i < monomial.factors.size(); ++i) {
      const auto [factor, power] = monomial.factors[i];
      if (power != 1 || !is_sum(to_[factor].op)) continue;
      const ExprId other = turned(factor);
      if (!other.valid()) continue;
      Monomial positive = monomial;
      positive.coefficient = -monomial.coefficient;
      positive.factors[i].first = other;
      std::sort(positive.factors.begin(), positive.factors.end());
      return write(positive);
    }
  const bool negative = monomial.coefficient < 0.0;
  const double size = std::abs(monomial.coefficient);
  // 1/2 is better written below the line.
  const double inverse = 1.0 / size;
  const bool below = size < 1.0 && inverse == std::round(inverse) && inverse < 1e6;
  ExprId numerator = write_factors(monomial, below ? 1.0 : size, 1);
  const ExprId denominator = write_factors(monomial, below ? inverse : 1.0, -1);
  if (!numerator.valid()) numerator = to_.constant(1.0);
  const ExprId result = denominator.valid() ? to_.div(numerator, denominator) : numerator;
  return negative ? to_.neg(result) : result;
}

}  // namespace bgsim
