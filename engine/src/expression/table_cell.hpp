/// Linear tables read in a given cell, so that a table is smooth between events.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>

#include "bgsim/expression.hpp"
#include "expression/table_formula.hpp"

namespace bgsim {

/// The cell [x[k], x[k+1]) that holds @p x; the first or last one outside the data.
inline std::size_t cell_of(const Table& table, double x) {
  const auto after = std::upper_bound(table.x.begin(), table.x.end(), x);
  const auto k = static_cast<std::size_t>(after - table.x.begin());
  return k == 0 ? 0 : std::min(k - 1, table.x.size() - 2);
}

/// Within rounding of the data's ends: the integrator ends a step on a knot only to the last bit.
inline bool covers(const Table& table, double x) {
  const double slack = 1e-12 * (table.x.back() - table.x.front());
  return x >= table.x.front() - slack && x <= table.x.back() + slack;
}

/// Value (slope) of the line through cell @p cell's knots; by look-up if cell is negative; NaN outside the data.
inline double value_in_cell(const Table& table, double x, double cell) {
  if (cell < 0.0) return table_value(table, x);
  if (!covers(table, x)) return std::numeric_limits<double>::quiet_NaN();
  return value_on_line(table, static_cast<std::size_t>(cell), x);
}
inline double slope_in_cell(const Table& table, double x, double cell) {
  if (cell < 0.0) return table_slope(table, x);
  const auto k = static_cast<std::size_t>(cell);
  return (table.y[k + 1] - table.y[k]) / (table.x[k + 1] - table.x[k]);
}

}  // namespace bgsim
