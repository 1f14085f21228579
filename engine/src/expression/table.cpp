#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/lu.hpp"
#include "bgsim/expression.hpp"
#include "expression/table_formula.hpp"

namespace bgsim {

namespace {

/// The cell around x: i with x[i] <= x < x[i+1] (the last cell is closed); none outside the data or for NaN.
std::optional<std::size_t> cell_around(const Table& table, double x) {
  if (table.delayed) return std::isfinite(x) ? std::optional(delayed_cell(table, x)) : std::nullopt;
  if (table.x.size() < 2 || !(x >= table.x.front()) || !(x <= table.x.back())) return std::nullopt;
  const auto after = std::upper_bound(table.x.begin(), table.x.end() - 1, x);
  return static_cast<std::size_t>(after - table.x.begin()) - 1;
}

}  // namespace

double table_value(const Table& table, double x) {
  if (table.x.size() == 1 && x == table.x.front()) return table.y.front();
  const auto cell = cell_around(table, x);
  return cell ? cell_value(table, *cell, x) : std::numeric_limits<double>::quiet_NaN();
}

double table_slope(const Table& table, double x) {
  const auto cell = cell_around(table, x);
  return cell ? cell_slope(table, *cell, x) : std::numeric_limits<double>::quiet_NaN();
}

double table_curvature(const Table& table, double x) {
  const auto cell = cell_around(table, x);
  return cell ? cell_curvature(table, *cell, x) : std::numeric_limits<double>::quiet_NaN();
}

double table_third(const Table& table, double x) {
  const auto cell = cell_around(table, x);
  return cell ? cell_third(table, *cell) : std::numeric_limits<double>::quiet_NaN();
}

double apply_table(Op op, const Table& table, double x) {
  if (op == Op::table) return table_value(table, x);
  if (op == Op::table_third) return table_third(table, x);
  return op == Op::table_slope ? table_slope(table, x) : table_curvature(table, x);
}

void prepare_spline(Table& table) {
  const std::size_t n = table.x.size();
  table.slope2.assign(n, 0.0);
  if (n < 3) return;
  const auto h = [&](std::size_t i) { return table.x[i + 1] - table.x[i]; };
  const auto slope = [&](std::size_t i) { return (table.y[i + 1] - table.y[i]) / h(i); };

  // One equation a knot for the second derivatives: the first derivative is continuous inside; at the ends the third
  // derivative is continuous across the last knot but one (not-a-knot), or the second is zero (natural).
  const auto size = static_cast<Eigen::Index>(n);
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  const auto put = [&](std::size_t row, std::size_t column, double value) {
    entries.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
  };
  const auto not_a_knot = [&](std::size_t row, std::size_t i) {
    const double scale = 1.0 / (h(i) + h(i + 1));
    put(row, i, h(i + 1) * scale);
    put(row, i + 1, -1.0);
    put(row, i + 2, h(i) * scale);
  };
  if (n < 4) {
    put(0, 0, 1.0);
    put(n - 1, n - 1, 1.0);
  } else {
    not_a_knot(0, 0);
    not_a_knot(n - 1, n - 3);
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double scale = 1.0 / (h(i - 1) + h(i));
    put(i, i - 1, h(i - 1) * scale);
    put(i, i, 2.0);
    put(i, i + 1, h(i) * scale);
    right[static_cast<Eigen::Index>(i)] = 6.0 * (slope(i) - slope(i - 1)) * scale;
  }
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  SparseLu<double> lu;
  lu.analyze(matrix);
  lu.factorize(matrix);
  const Eigen::VectorXd solution = lu.solve(right);
  for (std::size_t i = 0; i < n; ++i) table.slope2[i] = solution[static_cast<Eigen::Index>(i)];
}

}  // namespace bgsim
