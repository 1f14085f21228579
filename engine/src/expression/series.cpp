#include "expression/series.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "expression/apply.hpp"
#include "expression/table_cell.hpp"

namespace bgsim {
namespace {

constexpr std::size_t kTerms = PowerSeries::kTerms;
constexpr double kRoundings = 4.0 * std::numeric_limits<double>::epsilon();
using Coefficients = std::array<double, kTerms>;  ///< of a function around a point

/// Around a point of h alone: the point, plus h.
PowerSeries moving(double point) { return PowerSeries::of<2>({point, 1.0}, {0.0, 0.0}, true); }

/// exp, sin, cos, sinh or cosh: each derivative is one of two values, with a sign.
PowerSeries cyclic(double value, double slope, double turn) {
  Coefficients c{}, r{};
  double factorial = 1.0, sign = 1.0;
  for (std::size_t k = 0; k < kTerms; ++k) {
    if (k > 0) factorial *= static_cast<double>(k);
    c[k] = sign * (k % 2 == 0 ? value : slope) / factorial;
    r[k] = kRoundings * std::abs(c[k]);
    if (k % 2 == 1) sign *= turn;
  }
  return PowerSeries::of<kTerms>(c, r, false);
}

/// (point + h)^power, of a point that is not 0.
PowerSeries binomial(double point, double power) {
  Coefficients c{}, r{};
  c[0] = std::pow(point, power);
  for (std::size_t k = 1; k < kTerms; ++k)
    c[k] = c[k - 1] * (power - static_cast<double>(k) + 1.0) / (static_cast<double>(k) * point);
  for (std::size_t k = 0; k < kTerms; ++k) r[k] = 2.0 * static_cast<double>(k + 1) * kRoundings * std::abs(c[k]);
  return PowerSeries::of<kTerms>(c, r, false);
}

/// The integral of a slope by h, from a value on.
PowerSeries integral(double value, const PowerSeries& slope) {
  Coefficients c{}, r{};
  for (int k = 0; k + 1 < PowerSeries::kTerms; ++k) {
    const auto [at, rounding] = slope.term(k);
    c[static_cast<std::size_t>(k) + 1] = at / (k + 1);
    r[static_cast<std::size_t>(k) + 1] = rounding / (k + 1);
  }
  c[0] = value;
  r[0] = kRoundings * std::abs(value);
  return PowerSeries::of<kTerms>(c, r, false)
      .known_below(slope.known == PowerSeries::kExact ? PowerSeries::kExact : slope.known + 1);
}

/// A function of one argument around a point; none where it has no derivatives.
std::optional<PowerSeries> around(Op op, double at) {
  const PowerSeries x = moving(at), one = PowerSeries::number(1.0);
  const double value = apply_now(op, at, 0.0, 0.0);
  switch (op) {
    case Op::exp:
      return cyclic(value, value, 1.0);
    case Op::expm1:
      return cyclic(value + 1.0, value + 1.0, 1.0) - one;
    case Op::sin:
      return cyclic(value, std::cos(at), -1.0);
    case Op::cos:
      return cyclic(value, -std::sin(at), -1.0);
    case Op::sinh:
      return cyclic(value, std::cosh(at), 1.0);
    case Op::cosh:
      return cyclic(value, std::sinh(at), 1.0);
    case Op::tan:
      return cyclic(std::sin(at), std::cos(at), -1.0) / cyclic(std::cos(at), -std::sin(at), -1.0);
    case Op::tanh:
      return cyclic(std::sinh(at), std::cosh(at), 1.0) / cyclic(std::cosh(at), std::sinh(at), 1.0);
    case Op::log:
      return at > 0.0 ? std::optional(integral(value, binomial(at, -1.0))) : std::nullopt;
    case Op::log10:
      if (!(at > 0.0)) return std::nullopt;
      return integral(value, binomial(at, -1.0) * PowerSeries::number(1.0 / std::numbers::ln10));
    case Op::log1p:
      return 1.0 + at > 0.0 ? std::optional(integral(value, binomial(1.0 + at, -1.0))) : std::nullopt;
    case Op::atan:
      return integral(value, one / (one + x * x));
    case Op::atanh:
      return std::abs(at) < 1.0 ? std::optional(integral(value, one / (one - x * x))) : std::nullopt;
    case Op::asin:
    case Op::acos:
    case Op::asinh:
    case Op::acosh: {
      const double root = op == Op::asinh ? 1.0 + at * at : op == Op::acosh ? at * at - 1.0 : 1.0 - at * at;
      if (!(root > 0.0)) return std::nullopt;
      const PowerSeries square = op == Op::asinh ? x * x + one : op == Op::acosh ? x * x - one : one - x * x;
      const PowerSeries slope = compose(binomial(root, -0.5), square - PowerSeries::number(root));
      return integral(value, op == Op::acos ? -slope : slope);
    }
    default:
      return std::nullopt;
  }
}

/// a^power of a number that does not move.
PowerSeries power_of(const PowerSeries& a, double power) {
  constexpr double kMostProducts = 64.0;
  if (power == std::floor(power) && std::abs(power) <= kMostProducts) {
    PowerSeries result = PowerSeries::number(1.0);
    for (int k = 0; k < static_cast<int>(std::abs(power)); ++k) result = result * a;
    if (power >= 0.0) return result;
    return result.zero ? PowerSeries::unknown() : PowerSeries::number(1.0) / result;
  }
  // h^order times what is not 0 at h = 0
  const double order = power * a.order;
  if (a.zero || !(a.sign() > 0) || order != std::floor(order)) return PowerSeries::unknown();
  const PowerSeries scaled = a.times_power(-a.order);
  const double lead = scaled.coefficient[0];
  return compose(binomial(lead, power), scaled - PowerSeries::number(lead)).times_power(static_cast<int>(order));
}

/// Of a number that does not move: its value.
std::optional<double> still(const PowerSeries& a) {
  if (a.known != PowerSeries::kExact) return std::nullopt;
  if (a.zero) return 0.0;
  const bool moves = std::any_of(a.coefficient.begin() + 1, a.coefficient.end(), [](double c) { return c != 0.0; });
  return a.order == 0 && !moves ? std::optional(a.coefficient[0]) : std::nullopt;
}

PowerSeries smaller(const PowerSeries& a, const PowerSeries& b, bool least) {
  const PowerSeries difference = a - b;
  if (difference.zero && difference.known != PowerSeries::kExact) return a.known_below(difference.known);
  return (difference.sign() <= 0) == least ? a : b;
}

PowerSeries quotient(const PowerSeries& a, const PowerSeries& b) { return b.zero ? PowerSeries::unknown() : a / b; }

}  // namespace

PowerSeries apply(Op op, const PowerSeries& a, const PowerSeries& b, const PowerSeries& c) {
  const std::optional<double> by = still(b);
  switch (op) {
    case Op::neg:
      return -a;
    case Op::add:
      return a + b;
    case Op::sub:
      return a - b;
    case Op::mul:
      return a * b;
    case Op::div:
      return quotient(a, b);
    case Op::abs:
      return a.sign() < 0 ? -a : a;
    case Op::min:
    case Op::max:
      return smaller(a, b, op == Op::min);
    case Op::select: {
      const std::optional<double> which = still(a);
      if (!which) return PowerSeries::unknown();
      if (!operators::is_held(*which)) return *which != 0.0 ? b : c;
      return PowerSeries::number(*which) * b + PowerSeries::number(1.0 - *which) * c;
    }
    case Op::pow:
      if (by) return power_of(a, *by);
      return apply(Op::exp, b * apply(Op::log, a, b, c), b, c);
    case Op::hypot:
      return power_of(a * a + b * b, 0.5);
    case Op::ssqrt:
      return quotient(a, power_of(a * a + b * b, 0.25));
    case Op::atan2: {
      const double at = std::atan2(a.finite_part(), b.finite_part());
      const PowerSeries size = a * a + b * b;
      if (a.order < 0 || b.order < 0 || size.order > 0 || size.zero) return PowerSeries::unknown();
      return integral(at, (b * slope_of(a) - a * slope_of(b)) / size);
    }
    default:
      break;
  }
  const std::optional<double> of = still(a);
  if (of && (arity(op) < 2 || by)) return PowerSeries::of<1>({apply_now(op, *of, by.value_or(0.0), 0.0)}, {0.0}, true);
  if (op == Op::sqrt) return power_of(a, 0.5);
  if (op == Op::cbrt) return a.sign() < 0 ? -power_of(-a, 1.0 / 3.0) : power_of(a, 1.0 / 3.0);
  if (a.order < 0) return PowerSeries::unknown();
  const double at = a.finite_part();
  const std::optional<PowerSeries> function = around(op, at);
  return function ? compose(*function, a - PowerSeries::number(at)) : PowerSeries::unknown();
}

PowerSeries table_series(const Table& table, const PowerSeries& a, double cell) {
  if (a.order < 0) return PowerSeries::unknown();
  const double at = a.finite_part();
  const PowerSeries moves = a - PowerSeries::number(at);
  const bool knot = std::binary_search(table.x.begin(), table.x.end(), at);
  const auto coefficient = [&](Op op, double factor) { return factor * apply_table(op, table, at); };
  const std::array<double, 4> c =
      cell >= 0.0
          ? std::array<double, 4>{value_in_cell(table, at, cell), slope_in_cell(table, at, cell), 0.0, 0.0}
          : std::array<double, 4>{coefficient(Op::table, 1.0), coefficient(Op::table_slope, 1.0),
                                  coefficient(Op::table_curvature, 0.5), coefficient(Op::table_third, 1.0 / 6.0)};
  std::array<double, 4> r{};
  for (std::size_t k = 0; k < c.size(); ++k)
    r[k] = kRoundings * (std::abs(c[k]) + (k == 0 ? std::abs(c[1] * at) : 0.0));
  const PowerSeries function = PowerSeries::of<4>(c, r, true);
  return compose(cell < 0.0 && knot ? function.known_below(2) : function, moves);
}

}  // namespace bgsim
