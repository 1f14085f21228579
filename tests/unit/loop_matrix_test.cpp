// The matrices of large loops: with pivots of their own, and with those of the matrix before.
#include "program/loop_matrix.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace bgsim;

namespace {

constexpr std::size_t kSize = 100;  // more than 64: sparse

/// A ring in which each variable is tied to its neighbours by 1, and to itself by @p own.
struct Ring {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> entries;
  std::vector<double> values;

  explicit Ring(double own) {
    for (std::uint32_t i = 0; i < kSize; ++i)
      for (const auto& [column, value] : {std::pair{i, own},
                                          {(i + 1) % std::uint32_t{kSize}, 1.0},
                                          {(i + std::uint32_t{kSize} - 1) % std::uint32_t{kSize}, 1.0 + 1e-3 * i}}) {
        entries.emplace_back(i, column);
        values.push_back(value);
      }
  }
};

/// The largest error of a solution that is known.
double error_of(const LoopMatrix& matrix, const Ring& ring) {
  Eigen::VectorXd right = Eigen::VectorXd::Zero(kSize), solution(kSize), found;
  for (Eigen::Index i = 0; i < solution.size(); ++i) solution[i] = std::sin(1.0 + static_cast<double>(i));
  for (std::size_t k = 0; k < ring.entries.size(); ++k)
    right[ring.entries[k].first] += ring.values[k] * solution[ring.entries[k].second];
  matrix.solve(right.cwiseQuotient(matrix.row_scale), found);
  return (found.cwiseQuotient(matrix.column_scale) - solution).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("a loop's matrix keeps pivots while they serve, and takes others where they do not") {
  const std::vector<bool> explicit_row(kSize, false);
  const Ring heavy(10.0), light(9.0), empty(1e-6);
  LoopMatrix matrix(kSize, heavy.entries), fresh(kSize, heavy.entries);
  std::vector<double> values = heavy.values;
  REQUIRE(matrix.factorize(values, explicit_row, 1e-14) == LoopOutcome::solved);
  // With pivots of 1e-6 digits are lost, and none of them is rounding beside the largest.
  for (const Ring* const ring : {&light, &empty, &heavy}) {
    values = ring->values;
    REQUIRE(matrix.factorize(values, explicit_row, 1e-14, LoopMatrix::Pivots::kept) == LoopOutcome::solved);
    values = ring->values;
    REQUIRE(fresh.factorize(values, explicit_row, 1e-14) == LoopOutcome::solved);
    CHECK(error_of(matrix, *ring) < 1e-12);  // the ring's condition times rounding
    CHECK(matrix.orientation() == fresh.orientation());
  }
}

TEST_CASE("a loop's matrix that is singular is so with kept pivots, and the next one is not") {
  const std::vector<bool> explicit_row(kSize, false);
  const Ring regular(10.0);
  Ring singular(10.0);
  // Rows 0 and 1 are the same.
  for (std::size_t k = 0; k < singular.entries.size(); ++k)
    if (singular.entries[k].first <= 1) singular.values[k] = singular.entries[k].second <= 1 ? 1.0 : 0.0;
  LoopMatrix matrix(kSize, regular.entries);
  for (const bool fails : {false, true, false, true}) {
    std::vector<double> values = fails ? singular.values : regular.values;
    const LoopOutcome outcome = matrix.factorize(values, explicit_row, 1e-14, LoopMatrix::Pivots::kept);
    CHECK(outcome == (fails ? LoopOutcome::singular : LoopOutcome::solved));
  }
}
