#include "expression/solutions.hpp"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <limits>

#include "expression/interval.hpp"
#include "expression/rounded.hpp"

namespace bgsim {
namespace {

/// Between the ends: by orders of magnitude where they are some apart.
double divide(double from, double to) {
  constexpr double kFar = 4.0, kNear = 1e-3;
  if (from < 0.0 && to > 0.0) return 0.0;
  if (from < 0.0) return -divide(-to, -from);
  if (from == 0.0) return to > std::numeric_limits<double>::min() / kNear ? kNear * to : to / 2;
  return to > kFar * from ? std::sqrt(from) * std::sqrt(to) : from + (to - from) / 2;
}

/// Where a monotone function passes 0, of which the values at the ends are on both sides: to its last bits.
template <class F>
double root_of(const F& distance, double from, double to, double left, double right) {
  constexpr int kAllBits = std::numeric_limits<double>::digits;
  // First to a stretch that is no longer than its distance from 0: beyond that, interpolation gains nothing.
  while (to - from > std::max(std::abs(from), std::abs(to)) / 2) {
    const double middle = divide(from, to);
    if (!(from < middle && middle < to)) break;
    const double here = distance(middle);
    if (here == 0.0) return middle;
    ((here < 0.0) == (left < 0.0) ? from : to) = middle;
    ((here < 0.0) == (left < 0.0) ? left : right) = here;
  }
  std::uintmax_t evaluations = 200;
  const auto ends = boost::math::tools::toms748_solve(distance, from, to, left, right,
                                                      boost::math::tools::eps_tolerance<double>(kAllBits), evaluations);
  return std::abs(distance(ends.first)) < std::abs(distance(ends.second)) ? ends.first : ends.second;
}

}  // namespace

Solutions solutions(ExprPool& pool, ExprId expression, SymbolId x, double value, std::vector<double>& values) {
  constexpr double kLargest = 1e150;  // squares are finite
  constexpr int kWork = 5000;
  Solutions result;
  const auto slope = gradient(pool, expression, [x](SymbolId s) { return s == x; });
  if (slope.empty()) return result;
  TimeRelation enclosure(pool, expression, x, values, false), of_slope(pool, slope[0].second, x, values, false);
  const auto distance = [&](double at) {
    values[x.index()] = at;
    return evaluate(pool, expression, values) - value;
  };
  struct Stretch {
    double from, to;
  };
  std::vector<Stretch> open{{-kLargest, kLargest}};
  for (int work = 0; !open.empty(); ++work) {
    if (work == kWork) return result;
    const auto [from, to] = open.back();
    open.pop_back();
    const Range range = enclosure.range_on(from, to);
    if (is_empty(range) || range.lower() > value || range.upper() < value) continue;
    const Range way = of_slope.range_on(from, to);
    const double left = distance(from), right = distance(to);
    if (!(way.lower() > 0.0 || way.upper() < 0.0) || !std::isfinite(left) || !std::isfinite(right)) {
      const double middle = divide(from, to);
      if (from < middle && middle < to) {
        open.push_back({middle, to});
        open.push_back({from, middle});
        continue;
      }
      // Neighbouring doubles: at the end of a root's domain one of them has no value. Else a jump.
      if (left * right < 0.0) return result;
      if (left != 0.0 && right != 0.0) continue;
    }
    if (left * right > 0.0) continue;
    const double at = left == 0.0 ? from : right == 0.0 ? to : root_of(distance, from, to, left, right);
    if (result.at.empty() || at > result.at.back()) result.at.push_back(at);  // not twice where two stretches meet
  }
  result.all = true;
  return result;
}

}  // namespace bgsim
