#include "expression/inverse_table.hpp"

#include <algorithm>
#include <utility>

#include "expression/table_cell.hpp"
#include "expression/table_formula.hpp"

namespace bgsim {

namespace {

/// Of the cell from x[i] to x[i+1]. The slope of a cubic is a parabola: it is least or largest at the ends, or where
/// the curvature, a line, is 0.
Way way_of_cell(const Table& table, std::size_t i) {
  const double low = table.x[i], high = table.x[i + 1];
  double least = std::min(cell_slope(table, i, low), cell_slope(table, i, high));
  double most = std::max(cell_slope(table, i, low), cell_slope(table, i, high));
  const double a = cell_curvature(table, i, low), b = cell_curvature(table, i, high);
  if (a * b < 0.0) {
    const double middle = cell_slope(table, i, low + (high - low) * (a / (a - b)));
    least = std::min(least, middle);
    most = std::max(most, middle);
  }
  return least > 0.0 ? Way::rising : most < 0.0 ? Way::falling : Way::unknown;
}

}  // namespace

Way way_of(const Table& table) {
  if (table.delayed || table.x.size() < 2) return Way::unknown;
  const Way first = way_of_cell(table, 0);
  for (std::size_t i = 1; i + 1 < table.x.size(); ++i)
    if (way_of_cell(table, i) != first) return Way::unknown;
  return first;
}

std::optional<TableId> inverse_table(ExprPool& pool, TableId id) {
  const Table& table = pool.table(id);
  if (table.interpolation != Interpolation::linear) return std::nullopt;
  const Way way = way_of(table);
  if (way != Way::rising && way != Way::falling) return std::nullopt;
  Table inverse = table;
  inverse.inverse = !table.inverse;
  std::swap(inverse.x, inverse.y);
  if (way == Way::falling) {
    std::reverse(inverse.x.begin(), inverse.x.end());
    std::reverse(inverse.y.begin(), inverse.y.end());
  }
  return pool.add_table(std::move(inverse));
}

double value_within(Op op, const Table& table, double x) {
  if (table.x.empty() || !covers(table, x)) return apply_table(op, table, x);
  return apply_table(op, table, std::clamp(x, table.x.front(), table.x.back()));
}

}  // namespace bgsim
