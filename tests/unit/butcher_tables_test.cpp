// The tables of the Runge-Kutta methods hold the conditions of their orders: one for each rooted tree.
#include "run/integrate/butcher_tables.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "bgsim/method.hpp"

using namespace bgsim;

namespace {

/// A rooted tree: its order, its density, and its stages' elementary weights (E. Hairer, S. P. Norsett, G. Wanner,
/// Solving Ordinary Differential Equations I, section II.2, from memory).
struct Tree {
  int order = 1;
  double density = 1.0;
  std::vector<double> weights;
};

/// All trees of up to @p order, by order: 1, 1, 2, 4, 9, 20, 48, 115, 286 of them.
std::vector<Tree> trees_up_to(int order, const ARKodeButcherTable table) {
  const auto stages = static_cast<std::size_t>(table->stages);
  std::vector<Tree> trees = {{1, 1.0, std::vector<double>(stages, 1.0)}};
  for (int n = 2; n <= order; ++n) {
    const std::size_t smaller = trees.size();
    // The root's branches are trees of fewer nodes, in the order in which they were found.
    const std::function<void(const Tree&, int, std::size_t)> grow = [&](const Tree& root, int left, std::size_t first) {
      if (left == 0) {
        trees.push_back({n, n * root.density, root.weights});
        return;
      }
      for (std::size_t k = first; k < smaller && trees[k].order <= left; ++k) {
        Tree more = {0, root.density * trees[k].density, root.weights};
        for (std::size_t i = 0; i < stages; ++i) {
          double sum = 0.0;
          for (std::size_t j = 0; j < stages; ++j) sum += table->A[i][j] * trees[k].weights[j];
          more.weights[i] *= sum;
        }
        grow(more, left - trees[k].order, k);
      }
    };
    grow({0, 1.0, std::vector<double>(stages, 1.0)}, n - 1, 0);
  }
  return trees;
}

double missed(const Tree& tree, const double* weights) {
  double sum = 0.0;
  for (std::size_t i = 0; i < tree.weights.size(); ++i) sum += weights[i] * tree.weights[i];
  return std::abs(sum - 1.0 / tree.density);
}

}  // namespace

TEST_CASE("Runge-Kutta methods have the orders that they are named for, and see errors of what time alone drives") {
  const auto [method, order, held] = GENERATE(table<Method, int, int>({{Method::erk2, 2, 1},
                                                                       {Method::erk3, 3, 2},
                                                                       {Method::erk4, 4, 3},
                                                                       {Method::erk5, 5, 4},
                                                                       {Method::erk6, 6, 5},
                                                                       {Method::erk8, 8, 7},
                                                                       {Method::dirk2, 2, 3},
                                                                       {Method::dirk3, 3, 2},
                                                                       {Method::dirk4, 4, 3},
                                                                       {Method::dirk5, 5, 4},
                                                                       {Method::rk4, 4, 0},
                                                                       {Method::euler, 1, 0},
                                                                       {Method::implicit_euler, 1, 0}}));
  CAPTURE(method_name(method));
  const ButcherTableHandle table = butcher_table(method);
  // The coefficients are rounded, and some are tens of times as large as their sums.
  constexpr double kRounding = 1e-14;
  // What is missed in the next order is no rounding: a thousandth of the smallest among these methods is 1e-8.
  constexpr double kMissed = 1e-7;
  const std::vector<Tree> trees = trees_up_to(order + 1, table.get());
  CHECK(trees.size() == std::vector<std::size_t>{1, 2, 4, 8, 17, 37, 85, 200, 486}[static_cast<std::size_t>(order)]);
  double most = 0.0;
  for (const Tree& tree : trees) {
    CAPTURE(tree.order, tree.density);
    if (tree.order <= order)
      CHECK(missed(tree, table->b) < kRounding);
    else
      most = std::max(most, missed(tree, table->b));
    if (tree.order <= std::min(held, order)) CHECK(missed(tree, table->d) < kRounding);
  }
  CHECK(most > kMissed);
  for (std::size_t i = 0; i < static_cast<std::size_t>(table->stages); ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j < static_cast<std::size_t>(table->stages); ++j) sum += table->A[i][j];
    CHECK(std::abs(sum - table->c[i]) < kRounding);
  }
  if (held == 0) return;
  // Both formulas of a pair integrate some power of time below twice the order differently.
  double seen = 0.0;
  for (int power = 0; power <= order; ++power) {
    double difference = 0.0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(table->stages); ++i)
      difference += (table->b[i] - table->d[i]) * std::pow(table->c[i], power);
    seen = std::max(seen, std::abs(difference));
  }
  CHECK(seen > kMissed);
}
