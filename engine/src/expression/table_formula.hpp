/// The interpolation formulas within one cell, for numbers and for intervals.
#pragma once

#include <algorithm>

#include "bgsim/expression.hpp"
#include "expression/interval.hpp"

namespace bgsim {

/// Of a delayed signal's table: the first knot of the cubic for x.
inline std::size_t delayed_cell(const Table& table, double x) {
  const auto first = table.x.begin() + static_cast<std::ptrdiff_t>(table.first);
  const auto last = table.x.begin() + static_cast<std::ptrdiff_t>(table.last);
  const auto after = std::upper_bound(first, last, x);
  const auto found = table.first + static_cast<std::size_t>(after == first ? 0 : after - first - 1);
  return found - (found - table.first) % 2;
}

/// On the line through both knots of a cell, from the nearer one: exact at both, and beside a knot of 0 as fine as x.
inline double value_on_line(const Table& table, std::size_t i, double x) {
  const double slope = (table.y[i + 1] - table.y[i]) / (table.x[i + 1] - table.x[i]);
  const double left = x - table.x[i], right = table.x[i + 1] - x;
  return left <= right ? table.y[i] + slope * left : table.y[i + 1] - slope * right;
}
inline Range value_on_line(const Table& table, std::size_t i, const Range& x) {
  return table.y[i] + (table.y[i + 1] - table.y[i]) / (table.x[i + 1] - table.x[i]) * (x - table.x[i]);
}

/// Value in the cell [x[i], x[i+1]].
template <class Number>
Number cell_value(const Table& table, std::size_t i, const Number& x) {
  const Number linear = value_on_line(table, i, x);
  if (table.interpolation == Interpolation::linear) return linear;
  const double h = table.x[i + 1] - table.x[i];
  const Number left = x - table.x[i], right = table.x[i + 1] - x;
  const double m0 = table.slope2[i], m1 = table.slope2[i + 1];
  return linear - left * right / (6.0 * h) * (m0 * (h + right) + m1 * (h + left));
}

template <class Number>
Number cell_slope(const Table& table, std::size_t i, const Number& x) {
  const double h = table.x[i + 1] - table.x[i];
  const double linear = (table.y[i + 1] - table.y[i]) / h;
  if (table.interpolation == Interpolation::linear) return Number(linear);
  const Number left = x - table.x[i], right = table.x[i + 1] - x;
  const double m0 = table.slope2[i], m1 = table.slope2[i + 1];
  return linear + (m1 * (3.0 * left * left - h * h) - m0 * (3.0 * right * right - h * h)) / (6.0 * h);
}

template <class Number>
Number cell_curvature(const Table& table, std::size_t i, const Number& x) {
  if (table.interpolation == Interpolation::linear) return Number(0.0);
  const double h = table.x[i + 1] - table.x[i];
  return ((table.x[i + 1] - x) * table.slope2[i] + (x - table.x[i]) * table.slope2[i + 1]) / h;
}

inline double cell_third(const Table& table, std::size_t i) {
  if (table.interpolation == Interpolation::linear) return 0.0;
  return (table.slope2[i + 1] - table.slope2[i]) / (table.x[i + 1] - table.x[i]);
}

}  // namespace bgsim
