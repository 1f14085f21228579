/// What most laws are made of, over a stretch of time: sums, products and quotients by what stands still. The same
/// jets as Enclosure's general rules give, to the bit but for signs of zero, in a tenth of the time.
#pragma once

#include <algorithm>
#include <cmath>

#include "program/enclosure.hpp"

namespace bgsim::often {

/// How an operator's jet follows.
enum class Rule : std::uint8_t {
  general,
  negative,
  sum,  ///< both move
  difference,
  sum_right_still,  ///< a moves; the other way round is the same sum
  difference_right_still,
  difference_left_still,
  product,
  scaled,   ///< a moves, b is a number
  divided,  ///< a moves, b is a number
};

[[nodiscard]] inline bool is_zero(const Range& x) { return x.lower() == 0.0 && x.upper() == 0.0; }
[[nodiscard]] inline bool is_bounded(const Range& x) { return std::isfinite(x.lower()) && std::isfinite(x.upper()); }
[[nodiscard]] inline double largest(const Range& x) { return std::max(std::fabs(x.lower()), std::fabs(x.upper())); }
/// Of two ranges that hold the same.
[[nodiscard]] inline Range both(const Range& a, const Range& b) {
  const double low = std::max(a.lower(), b.lower()), high = std::min(a.upper(), b.upper());
  return low <= high ? Range(low, high) : a;
}
[[nodiscard]] inline Range scaled(const Range& x, double by) {
  return by < 0.0 ? Range(x.upper() * by, x.lower() * by) : Range(x.lower() * by, x.upper() * by);
}
[[nodiscard]] inline Range divided(const Range& x, double by) {
  return by < 0.0 ? Range(x.upper() / by, x.lower() / by) : Range(x.lower() / by, x.upper() / by);
}

/// Taylor's formula for values and slopes, from the middle: terms that nearly cancel (the pressures on both sides of a
/// valve) leave as much excess as their third derivatives, not their second.
inline void tighten(const Jet& a, const Jet& b, double half, Jet& out) {
  const double curve = largest(out.curve);
  if (!std::isfinite(curve) || !std::isfinite(out.middle_slope)) return;
  constexpr double kRounding = 1e-15;
  const double slope_room = kRounding * (std::fabs(out.middle_slope) + std::fabs(a.middle_slope) +
                                         std::fabs(b.middle_slope) + largest(out.slope));
  const double bends = half * curve + slope_room;
  out.slope = both(out.slope, {out.middle_slope - bends, out.middle_slope + bends});
  const double room = kRounding * (std::fabs(out.middle) + std::fabs(a.middle) + std::fabs(b.middle));
  const double moves = half * (std::fabs(out.middle_slope) + slope_room) + 0.5 * half * half * curve + room;
  out.value = both(out.value, {out.middle - moves, out.middle + moves});
}

/// Of an operator of two arguments that both move: Taylor's formula, then the mean value form, with room for the
/// roundings of the middle.
inline void narrow(const Jet& a, const Jet& b, double half, Jet& out) {
  if (is_zero(a.slope) || is_zero(b.slope)) return;
  tighten(a, b, half, out);
  constexpr double kRounding = 1e-15;
  const double room = kRounding * (std::fabs(out.middle) + std::fabs(a.middle) + std::fabs(b.middle));
  const double low = out.middle + half * std::min(out.slope.lower(), -out.slope.upper()) - room;
  const double high = out.middle + half * std::max(out.slope.upper(), -out.slope.lower()) + room;
  const double least = std::max(out.value.lower(), low), most = std::min(out.value.upper(), high);
  if (least <= most) out.value = Range(least, most);
}

/// The jet of an operator by its rule.
/// @return  false, with @p out undefined, where a range has no bound: the general rules know what follows then.
inline bool run(Rule rule, const Jet& a, const Jet& b, double half, Jet& out) {
  const auto unknown_curve = [&out] {
    out.middle_slope = 0.0;
    out.curve = kAllNumbers;
  };
  switch (rule) {
    case Rule::general:
      return false;
    case Rule::negative:
      out.middle = -a.middle;
      out.value = Range(-a.value.upper(), -a.value.lower());
      out.slope = Range(-a.slope.upper(), -a.slope.lower());
      out.middle_slope = -a.middle_slope;
      out.curve = Range(-a.curve.upper(), -a.curve.lower());
      if (!is_bounded(a.curve)) unknown_curve();
      break;
    case Rule::sum:
    case Rule::sum_right_still:
      out.middle = a.middle + b.middle;
      out.value = Range(a.value.lower() + b.value.lower(), a.value.upper() + b.value.upper());
      out.slope = Range(a.slope.lower() + b.slope.lower(), a.slope.upper() + b.slope.upper());
      out.middle_slope = a.middle_slope + b.middle_slope;
      out.curve = Range(a.curve.lower() + b.curve.lower(), a.curve.upper() + b.curve.upper());
      if (!is_bounded(a.curve)) unknown_curve();
      if (rule == Rule::sum) narrow(a, b, half, out);
      break;
    case Rule::difference:
    case Rule::difference_right_still:
    case Rule::difference_left_still:
      out.middle = a.middle - b.middle;
      out.value = Range(a.value.lower() - b.value.upper(), a.value.upper() - b.value.lower());
      out.slope = Range(a.slope.lower() - b.slope.upper(), a.slope.upper() - b.slope.lower());
      out.middle_slope = a.middle_slope - b.middle_slope;
      out.curve = Range(a.curve.lower() - b.curve.upper(), a.curve.upper() - b.curve.lower());
      if (!is_bounded(a.curve)) unknown_curve();
      if (rule == Rule::difference) narrow(a, b, half, out);
      break;
    case Rule::product: {
      const auto times = [](const Range& x, const Range& y) {
        return is_zero(x) || is_zero(y) ? Range(0.0, 0.0) : x * y;
      };
      out.middle = a.middle * b.middle;
      out.value = a.value * b.value;
      out.slope = times(b.value, a.slope);
      if (!is_zero(b.slope)) out.slope = out.slope + times(a.value, b.slope);
      if (is_bounded(a.curve) && is_bounded(b.curve)) {
        out.middle_slope = a.middle_slope * b.middle + a.middle * b.middle_slope;
        out.curve = times(a.curve, b.value) + times(a.value, b.curve) + 2.0 * times(a.slope, b.slope);
        if (!is_bounded(out.curve)) return false;
      } else {
        unknown_curve();
      }
      narrow(a, b, half, out);
      break;
    }
    case Rule::scaled: {
      const double by = b.middle;
      out.middle = a.middle * by;
      out.value = scaled(a.value, by);
      out.slope = scaled(a.slope, by);
      out.middle_slope = a.middle_slope * by;
      out.curve = scaled(a.curve, by);
      if (!is_bounded(a.curve))
        unknown_curve();
      else if (!is_bounded(out.curve))
        return false;
      break;
    }
    case Rule::divided: {
      const double by = b.middle;
      out.middle = a.middle / by;
      out.value = divided(a.value, by);
      out.slope = scaled(a.slope, 1.0 / by);
      out.middle_slope = a.middle_slope / by;
      out.curve = divided(a.curve, by);
      if (!is_bounded(a.curve))
        unknown_curve();
      else if (!is_bounded(out.curve))
        return false;
      break;
    }
  }
  // Neither infinite nor NaN: the differences are finite.
  return std::isfinite((out.value.upper() - out.value.lower()) + (out.slope.upper() - out.slope.lower()));
}

}  // namespace bgsim::often
