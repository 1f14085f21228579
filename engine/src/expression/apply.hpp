/// What operators make of numbers: apply(), where it is called so often that it has to be inlined.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "bgsim/expression.hpp"
#include "expression/power.hpp"

namespace bgsim {

namespace operators {

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

inline double truth(bool value) { return value ? 1.0 : 0.0; }

inline double compare(Op op, double a, double b) {
  if (std::isnan(a) || std::isnan(b)) return kNoNumber;
  switch (op) {
    case Op::lt:
      return truth(a < b);
    case Op::le:
      return truth(a <= b);
    case Op::gt:
      return truth(a > b);
    case Op::ge:
      return truth(a >= b);
    case Op::eq:
      return truth(a == b);
    default:
      return truth(a != b);
  }
}

/// Neither false nor true is a condition that is held at its border (run/watch/stiction.hpp): between the two, or, at
/// points that a step tries, beyond them, where laws go on as straight lines.
inline bool is_held(double a) { return a != 0.0 && a != 1.0; }
inline double opposite(double a) { return std::isnan(a) ? kNoNumber : is_held(a) ? 1.0 - a : truth(a == 0.0); }

/// False wins over a fault in the other operand, as it would from left to right: `x > 0 and log(x) > 1`.
inline double both(double a, double b) {
  if (a == 0.0 || b == 0.0) return 0.0;
  if (std::isnan(a) || std::isnan(b)) return kNoNumber;
  return is_held(a) || is_held(b) ? a * b : 1.0;
}

/// Right to an ulp, as std::hypot is, and three times as fast where no square is out of range.
inline double hypotenuse(double a, double b) {
  constexpr double kLeast = 1e-290, kMost = 1e300;
  const double square = a * a + b * b;
  return square > kLeast && square < kMost ? std::sqrt(square) : std::hypot(a, b);
}

inline double signed_root(double a, double b) {
  const double h = hypotenuse(a, b);
  return h == 0.0 ? 0.0 : a / std::sqrt(h);
}

/// a - b*floor(a/b). Where a is so near to a multiple of b that the quotient rounds to it, the difference may come out
/// on the other side of zero: it is then zero.
inline double floored_remainder(double a, double b) {
  const double r = a - b * std::floor(a / b);
  return (b > 0.0 && r < 0.0) || (b < 0.0 && r > 0.0) ? 0.0 : r;
}

}  // namespace operators

/// As apply(), which see.
inline double apply_now(Op op, double a, double b, double c) {
  using namespace operators;  // NOLINT(google-build-using-namespace): all of them, in this function alone
  switch (op) {
    case Op::constant:
      return a;
    case Op::neg:
      return -a;
    case Op::add:
      return a + b;
    case Op::sub:
      return a - b;
    case Op::mul:
      return a * b;
    case Op::div:
      return a / b;
    case Op::pow:
      return power(a, b);
    case Op::abs:
      return std::fabs(a);
    case Op::sign:
      return std::isnan(a) ? kNoNumber : truth(a > 0.0) - truth(a < 0.0);
    case Op::sqrt:
      return std::sqrt(a);
    case Op::cbrt:
      return std::cbrt(a);
    case Op::exp:
      return std::exp(a);
    case Op::log:
      return std::log(a);
    case Op::log10:
      return std::log10(a);
    case Op::sin:
      return std::sin(a);
    case Op::cos:
      return std::cos(a);
    case Op::tan:
      return std::tan(a);
    case Op::asin:
      return std::asin(a);
    case Op::acos:
      return std::acos(a);
    case Op::atan:
      return std::atan(a);
    case Op::sinh:
      return std::sinh(a);
    case Op::cosh:
      return std::cosh(a);
    case Op::tanh:
      return std::tanh(a);
    case Op::asinh:
      return std::asinh(a);
    case Op::acosh:
      return std::acosh(a);
    case Op::atanh:
      return std::atanh(a);
    case Op::log1p:
      return std::log1p(a);
    case Op::expm1:
      return std::expm1(a);
    case Op::floor:
      return std::floor(a);
    case Op::ceil:
      return std::ceil(a);
    case Op::round:
      return std::round(a);
    case Op::step:
      return std::isnan(a) ? kNoNumber : truth(a >= 0.0);
    case Op::min:
      return std::isnan(a) || std::isnan(b) ? kNoNumber : std::min(a, b);
    case Op::max:
      return std::isnan(a) || std::isnan(b) ? kNoNumber : std::max(a, b);
    case Op::atan2:
      return std::atan2(a, b);
    case Op::hypot:
      return hypotenuse(a, b);
    case Op::ssqrt:
      return signed_root(a, b);
    case Op::mod:
      return floored_remainder(a, b);
    case Op::lt:
    case Op::le:
    case Op::gt:
    case Op::ge:
    case Op::eq:
    case Op::ne:
      return compare(op, a, b);
    case Op::logical_and:
      return both(a, b);
    case Op::logical_or:
      return opposite(both(opposite(a), opposite(b)));
    case Op::logical_not:
      return opposite(a);
    case Op::select:
      return std::isnan(a) ? kNoNumber : is_held(a) ? c + a * (b - c) : a != 0.0 ? b : c;
    case Op::symbol:
    case Op::table:
    case Op::table_slope:
    case Op::table_curvature:
    case Op::table_third:
    case Op::der:
      return kNoNumber;
  }
  return kNoNumber;
}

/// The same, with a short way to the operators that most laws are made of.
inline double apply_often(Op op, double a, double b, double c) {
  switch (op) {
    case Op::add:
      return a + b;
    case Op::sub:
      return a - b;
    case Op::mul:
      return a * b;
    case Op::div:
      return a / b;
    case Op::neg:
      return -a;
    case Op::pow:
      return power(a, b);
    case Op::abs:
      return std::fabs(a);
    case Op::sqrt:
      return std::sqrt(a);
    case Op::sin:
      return std::sin(a);
    case Op::cos:
      return std::cos(a);
    case Op::hypot:
      return operators::hypotenuse(a, b);
    case Op::ssqrt:
      return operators::signed_root(a, b);
    default:
      return apply_now(op, a, b, c);
  }
}

}  // namespace bgsim
