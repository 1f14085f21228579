#include "graph/modulus_residues.hpp"

#include <cmath>
#include <limits>

#include "expression/graph.hpp"
#include "graph/residue.hpp"
#include "graph/with_signals.hpp"

namespace bgsim {

namespace {

/// A number of its own for each pair (splitmix64).
std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  std::uint64_t z = a * 0x9E3779B97F4A7C15U + b + 0x632BE59BD9B4E019U;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return (z ^ (z >> 31U)) % kPrime;
}

std::uint64_t whole(double n) {
  const std::uint64_t size = static_cast<std::uint64_t>(std::fabs(n)) % kPrime;
  return n < 0.0 ? minus(size) : size;
}

/// The fraction of small numbers that a double stands for (0.1, 1/3), or the double itself.
std::uint64_t residue_of(double c) {
  constexpr double kLargestBelow = 1e6, kUlps = 4.0 * std::numeric_limits<double>::epsilon();
  if (!std::isfinite(c)) return mixed(0, 1);
  // continued fraction: c is near p1/q1
  double p0 = 1.0, q0 = 0.0, p1 = std::floor(c), q1 = 1.0, rest = c - p1;
  while (std::fabs(p1 / q1 - c) > kUlps * std::fabs(c) && rest != 0.0) {
    const double a = std::floor(1.0 / rest);
    rest = 1.0 / rest - a;
    const double p = a * p1 + p0, q = a * q1 + q0;
    if (!(q <= kLargestBelow) || !(std::fabs(p) < 0x1p53)) break;
    p0 = p1, q0 = q1, p1 = p, q1 = q;
  }
  if (std::fabs(p1 / q1 - c) <= kUlps * std::fabs(c) && std::fabs(p1) < 0x1p53)
    return product_of(whole(p1), inverse_of(whole(q1)));
  int exponent = 0;
  const double mantissa = std::frexp(c, &exponent);
  const std::uint64_t two = exponent - 53 < 0 ? inverse_of(2) : 2;
  return product_of(whole(std::ldexp(mantissa, 53)),
                    power_of(two, static_cast<std::uint64_t>(std::abs(exponent - 53))));
}

}  // namespace

std::uint64_t ModulusResidues::operator()(ExprId expression) {
  const auto behind = [this](ExprId e) { return signal_behind(model_, e); };
  for (const ExprId e : in_order(model_.pool, expression, known_, behind)) values_[e.index()] = apply(e);
  return value(expression);
}

std::uint64_t ModulusResidues::apply(ExprId expression) const {
  const ExprNode& node = model_.pool[expression];
  const ExprId a(node.a), b(node.b);
  const auto any = [&] {
    std::uint64_t result = mixed(static_cast<std::uint64_t>(node.op) + 2, is_table(node.op) ? node.b : 0);
    for_each_argument(node, [&](ExprId argument) { result = mixed(result, value(argument)); });
    return result;
  };
  switch (node.op) {
    case Op::constant:
      return residue_of(node.constant);
    case Op::symbol: {
      const ExprId signal = signal_behind(model_, expression);
      return signal.valid() ? value(signal) : mixed(1, node.a);
    }
    case Op::neg:
      return minus(value(a));
    case Op::add:
      return sum_of(value(a), value(b));
    case Op::sub:
      return sum_of(value(a), minus(value(b)));
    case Op::mul:
      return product_of(value(a), value(b));
    case Op::div:
      return value(b) == 0 ? any() : product_of(value(a), inverse_of(value(b)));
    case Op::pow: {
      constexpr double kMost = 1e3;
      const double n = model_.pool.is_constant(b) ? model_.pool[b].constant : 0.5;
      if (n != std::floor(n) || std::fabs(n) > kMost || (n < 0.0 && value(a) == 0)) return any();
      const std::uint64_t power = power_of(value(a), static_cast<std::uint64_t>(std::fabs(n)));
      return n < 0.0 ? inverse_of(power) : power;
    }
    default:
      return any();
  }
}

}  // namespace bgsim
