#include "expression/rounded.hpp"

#include <algorithm>
#include <cmath>

#include "expression/graph.hpp"
#include "expression/inverse_table.hpp"
#include "expression/table_cell.hpp"

namespace bgsim {

namespace {

constexpr double kHalfUlp = std::numeric_limits<double>::epsilon() / 2;

}  // namespace

Rounded rounded_constant(double value) {
  return {value, value == std::floor(value) ? 0.0 : kHalfUlp * std::abs(value)};
}

Rounded apply_rounded(Op op, const std::array<Rounded, 3>& x, std::size_t count) {
  const auto shifted = [&](double shift) {
    return apply(op, x[0].value + shift * x[0].error, count > 1 ? x[1].value + shift * x[1].error : 0.0,
                 count > 2 ? x[2].value + shift * x[2].error : 0.0);
  };
  Rounded result{apply(op, x[0].value, count > 1 ? x[1].value : 0.0, count > 2 ? x[2].value : 0.0), 0.0};
  double moved = 0.0;
  if (op == Op::add || op == Op::sub) {
    moved = x[0].error + x[1].error;
  } else if (op == Op::mul || op == Op::div) {
    const double second = op == Op::mul ? std::abs(x[0].value) : std::abs(result.value);
    moved = x[0].error * (op == Op::mul ? std::abs(x[1].value) : 1.0) + second * x[1].error;
    if (op == Op::div) moved /= std::max(std::abs(x[1].value) - x[1].error, std::numeric_limits<double>::min());
  } else {
    moved = std::max(std::abs(shifted(1.0) - result.value), std::abs(shifted(-1.0) - result.value));
  }
  result.error = (std::isfinite(moved) ? moved : 0.0) + 2.0 * kHalfUlp * std::abs(result.value);
  return result;
}

Rounded apply_rounded(Op op, const Table& table, const Rounded& x) {
  const double value = value_within(op, table, x.value);
  double moved = 0.0;
  for (const double shift : {-x.error, x.error}) {
    const double there = std::abs(value_within(op, table, x.value + shift) - value);
    if (std::isfinite(there)) moved = std::max(moved, there);
  }
  double size = std::abs(value);
  if (op == Op::table && !table.delayed && table.x.size() > 1) {
    const std::size_t k = cell_of(table, x.value);
    size = std::max({size, std::abs(table.y[k]), std::abs(table.y[k + 1])});
  }
  return {value, moved + 4.0 * kHalfUlp * size};
}

double rounding_of(const ExprPool& pool, ExprId root, std::span<const double> symbol_values,
                   std::span<const double> symbol_errors) {
  const std::vector<ExprId> nodes = reachable(pool, {&root, 1});
  const IdMap<std::uint32_t> position = positions(nodes);
  std::vector<Rounded> values(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode& node = pool[nodes[i]];
    if (node.op == Op::constant) {
      values[i] = rounded_constant(node.constant);
    } else if (node.op == Op::symbol) {
      values[i] = {symbol_values[node.a], symbol_errors[node.a]};
    } else {
      std::array<Rounded, 3> x{};
      std::size_t n = 0;
      for_each_argument(node, [&](ExprId a) { x[n++] = values[*position.find(a)]; });
      if (is_table(node.op))
        values[i] = apply_rounded(node.op, *pool.tables()[node.b], x[0]);
      else if (node.op != Op::der)
        values[i] = apply_rounded(node.op, x, n);
    }
  }
  const double error = values.back().error;
  return std::isfinite(error) ? error : 0.0;
}

}  // namespace bgsim
