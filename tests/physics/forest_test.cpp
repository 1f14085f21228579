// Elimination along trees against a dense factorization, and where it refuses.
#include "run/integrate/forest.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "support/algebra.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// By columns, with the whole diagonal, from (row, column) of what stands beside it.
Sparsity pattern_of(std::size_t n, const std::vector<std::pair<std::size_t, std::size_t>>& beside) {
  Sparsity pattern;
  pattern.size = n;
  pattern.column_start.push_back(0);
  for (std::size_t column = 0; column < n; ++column) {
    for (std::size_t row = 0; row < n; ++row) {
      const bool there =
          row == column || std::find(beside.begin(), beside.end(), std::pair(row, column)) != beside.end();
      if (there) pattern.row.push_back(static_cast<std::int64_t>(row));
    }
    pattern.column_start.push_back(static_cast<std::int64_t>(pattern.row.size()));
  }
  return pattern;
}

}  // namespace

TEST_CASE("elimination along trees solves what a dense one does") {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (int shape = 0; shape < 60; ++shape) {
    const std::size_t n = 3 + random() % 40;
    std::vector<std::size_t> name(n);
    for (std::size_t i = 0; i < n; ++i) name[i] = i;
    std::shuffle(name.begin(), name.end(), random);
    std::vector<std::pair<std::size_t, std::size_t>> beside;
    for (std::size_t i = 1; i < n; ++i) {
      if (shape % 5 == 4 && random() % 8 == 0) continue;  // a tree of its own
      const std::size_t parent = shape % 3 == 0 ? i - 1 : shape % 3 == 1 ? random() % i : (i - 1) / 2;
      if (random() % 10 != 0) beside.emplace_back(name[i], name[parent]);  // some in one direction only
      if (random() % 10 != 0) beside.emplace_back(name[parent], name[i]);
    }
    const Sparsity pattern = pattern_of(n, beside);
    auto forest = Forest::of(pattern);
    REQUIRE(forest);
    for (int round = 0; round < 3; ++round) {
      std::vector<double> entries(pattern.row.size()), right(n), solution(n);
      Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
      for (std::size_t column = 0; column < n; ++column)
        for (auto k = pattern.column_start[column]; k < pattern.column_start[column + 1]; ++k) {
          const auto row = pattern.row[static_cast<std::size_t>(k)];
          const bool diagonal = row == static_cast<std::int64_t>(column);
          entries[static_cast<std::size_t>(k)] = number(random) + (diagonal ? 8.0 : 0.0);
          dense(row, static_cast<Eigen::Index>(column)) = entries[static_cast<std::size_t>(k)];
        }
      for (double& value : right) value = number(random);
      REQUIRE(forest->factor(entries.data()));
      forest->solve(right.data(), solution.data());
      const Eigen::Map<const Eigen::VectorXd> b(right.data(), static_cast<Eigen::Index>(n)),
          x(solution.data(), static_cast<Eigen::Index>(n));
      // Diagonals of 8 beside some ones: a handful of roundings of b, however the sums are ordered.
      CHECK((dense * x - b).cwiseAbs().maxCoeff() < 1e-14);
      forest->solve(right.data(), right.data());
      CHECK(right == solution);
    }
  }
}

TEST_CASE("elimination along trees refuses rings, and pivots that should have been chosen") {
  CHECK_FALSE(Forest::of(pattern_of(3, {{0, 1}, {1, 2}, {2, 0}})));
  CHECK_FALSE(Forest::of(pattern_of(6, {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}})));
  const Sparsity two = pattern_of(2, {{0, 1}, {1, 0}});
  auto forest = Forest::of(two);
  REQUIRE(forest);
  const auto takes = [&](std::vector<double> entries) { return forest->factor(entries.data()); };  // by columns
  CHECK(takes({1.0, 0.5, 0.5, 1.0}));
  CHECK(takes({1e-200, 1e100, 5e-301, 1.0}));    // units far apart are no reason
  CHECK_FALSE(takes({0.0, 1.0, 1.0, 1e-20}));    // nothing on the diagonal
  CHECK_FALSE(takes({1e-20, 1.0, 1.0, 1e-20}));  // lost beside what the elimination adds
  CHECK_FALSE(takes({1.0, 1.0, 1.0, 1.0}));      // singular
  CHECK_FALSE(takes({1.0, 1.0, 1.0, std::nan("")}));
}

TEST_CASE("a line, a tree and a ring of capacitors by CVODE come to what Radau does") {
  const auto model = [](const std::string& bonds, const std::string& more) {
    return R"json({ "bgsim": 1, "name": "shape",
      "elements": { "source": { "kind": "Se", "effort": 1 },
        "link": { "kind": "1", "repeat": 64 }, "node": { "kind": "0", "repeat": 64 },
        "r": { "kind": "R", "resistance": 1, "repeat": 64 }, "c": { "kind": "C", "capacitance": 1, "repeat": 64 })json" +
           more + R"json( },
      "bonds": [ { "from": "source", "to": "link[1]" }, { "from": "link[i]", "to": "r[i]" },
        { "from": "link[i]", "to": "node[i]" }, { "from": "node[i]", "to": "c[i]" })json" +
           bonds + R"json( ],
      "outputs": { "first": "node[1].e", "last": "node[64].e" },
      "scenes": { "main": { "stop": 200, "samples": 11 } } })json";
  };
  std::string tree;
  for (int i = 2; i <= 64; ++i)
    tree += R"(, { "from": "node[)" + std::to_string(i / 2) + R"(]", "to": "link[)" + std::to_string(i) + "]\" }";
  const std::string line = R"(, { "from": "node[i]", "to": "link[i+1]" })";
  const std::string ring = line + R"(, { "from": "node[64]", "to": "closing" }, { "from": "closing", "to": "rest" },
    { "from": "closing", "to": "node[1]" })";
  const std::string closing = R"(, "closing": { "kind": "1" }, "rest": { "kind": "R", "resistance": 1 })";
  struct Shape {
    std::string bonds, more, by;
  };
  for (const Shape& shape : {Shape{line, "", "CVODE BDF, along trees"}, Shape{tree, "", "CVODE BDF, along trees"},
                             Shape{ring, closing, "CVODE BDF, KLU"}}) {
    const std::string text = model(shape.bonds, shape.more);
    const RunResult bdf = run_text(text, with_method(Method::bdf, 1e-8));
    const RunResult radau = run_text(text, with_method(Method::radau, 1e-8));
    CHECK(bdf.report.method == shape.by);
    for (const char* output : {"first", "last"})
      for (std::size_t i = 0; i < bdf.trace.times.size(); ++i)
        CHECK(std::abs(bdf.trace[output][i] - radau.trace[output][i]) < 1e-6);  // a hundred tolerances
  }
}
