#include "expression/cancel.hpp"

#include <cmath>
#include <cstdlib>
#include <optional>

#include "expression/graph.hpp"

namespace bgsim {
namespace {

constexpr std::size_t kMostFactors = 32;  ///< a longer product is a factor as a whole, so that lists stay short
constexpr int kMostEqualFactors = 8;
constexpr double kLargestDivisor = 1e6;

/// One half and one third are divided by 2 and 3, not multiplied by a decimal fraction.
bool is_reciprocal(double number) {
  const double inverse = 1.0 / number;
  return std::abs(inverse) < kLargestDivisor && inverse == std::round(inverse);
}
/// Two thirds are not: they stay 2 above the line and 3 below.
bool is_short(double number) { return number == std::round(number) || is_reciprocal(number); }

}  // namespace

ExprId Canceller::operator()(ExprId root) {
  arguments_first(
      pool_, root, [this](ExprId e) { return known_.contains(e); },
      [this](ExprId e) {
        const ExprNode node = pool_[e];  // a copy: the pool grows
        if (node.op == Op::symbol)
          known_.emplace(e, atom(e));
        else if (node.op == Op::constant)
          known_.emplace(e, std::isnormal(node.constant) ? Known{e, {node.constant, {}}} : atom(e));
        else
          known_.emplace(e, rewritten(node));
      });
  return known_.at(root).image;
}

Canceller::Known Canceller::rewritten(const ExprNode& node) {
  const ExprId image = rebuilt(pool_, node, [this](ExprId a) { return known(a.value).image; });
  switch (node.op) {
    case Op::neg: {
      Product product = known(node.a).product;
      product.coefficient = -product.coefficient;
      return {image, std::move(product)};
    }
    case Op::mul:
    case Op::div: {
      const Product &a = known(node.a).product, &b = known(node.b).product;
      Product product = times(a, b, node.op == Op::mul ? 1 : -1);
      if (!std::isnormal(product.coefficient) || product.factors.size() > kMostFactors) return atom(image);
      const bool shorter =
          product.factors.size() < a.factors.size() + b.factors.size() || is_short(product.coefficient);
      if (!shorter || size(product) == size(a) + size(b)) return {image, std::move(product)};
      return {write(product), std::move(product)};
    }
    case Op::pow:
      return rewritten_power(node, image);
    default:
      return atom(image);
  }
}

/// A single factor to a small whole power may cancel; a power of a product is not taken apart, for the powers of its
/// factors may leave the range of numbers where that of the product does not.
Canceller::Known Canceller::rewritten_power(const ExprNode& node, ExprId image) const {
  const Product &base = known(node.a).product, &exponent = known(node.b).product;
  const double n = exponent.coefficient;
  const bool whole = exponent.factors.empty() && n == std::round(n) && std::abs(n) <= kMostEqualFactors;
  if (!whole || base.coefficient != 1.0 || base.factors.size() != 1) return atom(image);
  const auto [factor, power] = base.factors.front();
  const int raised = power * static_cast<int>(n);
  return raised == 0 || std::abs(raised) > kMostEqualFactors ? atom(image) : Known{image, {1.0, {{factor, raised}}}};
}

std::size_t Canceller::size(const Product& product) {
  std::size_t size = std::abs(product.coefficient) == 1.0 ? 0 : 1;
  for (const auto& [factor, power] : product.factors) size += static_cast<std::size_t>(std::abs(power));
  return size;
}

Canceller::Product Canceller::times(const Product& a, const Product& b, int power_of_b) {
  Product product;
  product.coefficient = power_of_b > 0 ? a.coefficient * b.coefficient : a.coefficient / b.coefficient;
  auto left = a.factors.begin();
  auto right = b.factors.begin();
  while (left != a.factors.end() || right != b.factors.end()) {
    if (right == b.factors.end() || (left != a.factors.end() && left->first < right->first)) {
      product.factors.push_back(*left++);
    } else if (left == a.factors.end() || right->first < left->first) {
      product.factors.emplace_back(right->first, power_of_b * right->second);
      ++right;
    } else {
      if (const int power = left->second + power_of_b * right->second; power != 0)
        product.factors.emplace_back(left->first, power);
      ++left;
      ++right;
    }
  }
  return product;
}

/// The factors above the line (sign 1) or below (sign -1); none if there are none.
ExprId Canceller::write_side(const Product& product, int sign) {
  ExprId side;
  const auto multiply = [&](ExprId factor) { side = side.valid() ? pool_.mul(side, factor) : factor; };
  for (const auto& [factor, power] : product.factors) {
    const int raised = power * sign;
    if (raised == 2) multiply(factor);  // x*x costs less than x^2
    if (raised == 1 || raised == 2) multiply(factor);
    if (raised > 2) multiply(pool_.pow(factor, pool_.constant(raised)));
  }
  return side;
}

ExprId Canceller::write(const Product& product) {
  const double number = std::abs(product.coefficient);
  const bool below = number < 1.0 && is_reciprocal(number);
  ExprId top = write_side(product, 1), bottom = write_side(product, -1);
  if (!top.valid()) top = pool_.constant(1.0);
  if (below)
    bottom = bottom.valid() ? pool_.mul(pool_.constant(1.0 / number), bottom) : pool_.constant(1.0 / number);
  else
    top = pool_.mul(pool_.constant(number), top);
  const ExprId quotient = bottom.valid() ? pool_.div(top, bottom) : top;
  return product.coefficient < 0.0 ? pool_.neg(quotient) : quotient;
}

}  // namespace bgsim
