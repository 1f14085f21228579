// What holds an explicit method's steps.
#include "run/integrate/fastest_mode.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "run/integrate/butcher_tables.hpp"
#include "run/integrate/dormand_prince_formula.hpp"

using namespace bgsim;

namespace {

struct Matrix {
  Sparsity pattern;
  std::vector<double> entries;
};

/// With @p below, @p diagonal and @p above on three diagonals; by k of the entry (k, k).
template <class Below, class Diagonal, class Above>
Matrix three_diagonals(std::size_t size, Below below, Diagonal diagonal, Above above) {
  Matrix matrix;
  matrix.pattern.size = size;
  matrix.pattern.column_start.push_back(0);
  for (std::size_t j = 0; j < size; ++j) {
    const auto add = [&](std::size_t row, double value) {
      matrix.pattern.row.push_back(static_cast<std::int64_t>(row));
      matrix.entries.push_back(value);
    };
    if (j > 0) add(j - 1, above(j - 1));
    add(j, diagonal(j));
    if (j + 1 < size) add(j + 1, below(j));
    matrix.pattern.column_start.push_back(static_cast<std::int64_t>(matrix.entries.size()));
  }
  return matrix;
}

constexpr double kPi = std::numbers::pi;

}  // namespace

TEST_CASE("the fastest mode of lines that decay and of chains that ring") {
  // q' = second differences: eigenvalues down to -4.
  const auto one = [](std::size_t) { return 1.0; };
  const Matrix decays = three_diagonals(
      300, one, [](std::size_t) { return -2.0; }, one);
  const FastestMode slow = fastest_mode(decays.pattern, decays.entries);
  // Power iteration is within some tenths after a few tens of products.
  CHECK(slow.rate == Approx(4.0).epsilon(0.15));
  CHECK(slow.angle < 0.1);

  // Springs of 1e6 and masses of 1e-2 in turn, displacement and momentum in turn: eigenvalues up to 2e4 i. The norms of
  // both kinds differ by 1e4, which a single product shows, and the mean of some does not.
  const Matrix rings = three_diagonals(
      400, [](std::size_t j) { return j % 2 == 0 ? -1e6 : 100.0; }, [](std::size_t) { return 0.0; },
      [](std::size_t j) { return j % 2 == 0 ? 100.0 : -1e6; });
  Matrix signs = rings;  // q' = (p before - p)/m, p' = k (q - q next): of opposite signs
  for (std::size_t j = 0; j < 400; ++j)
    for (auto k = static_cast<std::size_t>(signs.pattern.column_start[j]);
         k < static_cast<std::size_t>(signs.pattern.column_start[j + 1]); ++k) {
      const auto i = static_cast<std::size_t>(signs.pattern.row[k]);
      if (i != j) signs.entries[k] = (j % 2 == 0 ? 1e6 : 100.0) * (i > j ? 1.0 : -1.0);
    }
  const FastestMode fast = fastest_mode(signs.pattern, signs.entries);
  CHECK(fast.rate == Approx(2e4).epsilon(0.15));
  CHECK(std::abs(fast.angle - kPi / 2.0) < 0.1);
}

TEST_CASE("the fastest mode of matrices that have none, and of entries without bound") {
  const auto zero = [](std::size_t) { return 0.0; };
  const Matrix nothing = three_diagonals(60, zero, zero, zero);
  CHECK(fastest_mode(nothing.pattern, nothing.entries).rate == 0.0);
  Matrix broken = nothing;
  broken.entries[10] = std::numeric_limits<double>::infinity();
  CHECK(fastest_mode(broken.pattern, broken.entries).rate == std::numeric_limits<double>::infinity());
  const Matrix grows = three_diagonals(
      60, zero, [](std::size_t) { return 3.0; }, zero);
  CHECK(fastest_mode(grows.pattern, grows.entries).rate == Approx(3.0).epsilon(1e-12));
  CHECK(fastest_mode(grows.pattern, grows.entries).angle == Approx(kPi).epsilon(1e-6));
}

TEST_CASE("the explicit method is stable up to 3.3 on the real axis and 1 on the imaginary one") {
  // Of the scan, which goes in steps of 0.02 [hairer1996, IV.2, fig. 2.1].
  CHECK(dormand_prince::stable_reach(0.0) == Approx(3.3).margin(0.03));
  CHECK(dormand_prince::stable_reach(kPi / 2.0) == Approx(1.0).margin(0.03));
  CHECK(dormand_prince::stable_reach(kPi) == 0.0);
}

TEST_CASE("the explicit method's dense output meets all conditions of order four") {
  const ButcherTableHandle table = butcher_table(Method::erk5);
  constexpr std::size_t kStages = 7;
  for (const double u : {0.1, 0.37, 0.5, 0.8, 1.0}) {
    // By stage: what multiplies h k[i] in the output at u.
    std::array<double, kStages> b{};
    for (std::size_t i = 0; i < kStages; ++i) {
      const double first = i == 0 ? 1.0 : 0.0, last = i + 1 == kStages ? 1.0 : 0.0, change = table->b[i];
      const double left = first - change, right = change - last - left, v = 1.0 - u;
      b[i] = u * (change + v * (left + u * (right + v * dormand_prince::kBend[i])));
    }
    const auto sum = [&](const auto& term) {
      double total = 0.0;
      for (std::size_t i = 0; i < kStages; ++i) total += b[i] * term(i);
      return total;
    };
    const auto c = [&](std::size_t i) { return table->c[i]; };
    const auto inner = [&](std::size_t i, const auto& term) {
      double total = 0.0;
      for (std::size_t j = 0; j < i; ++j) total += table->A[i][j] * term(j);
      return total;
    };
    const auto ac = [&](std::size_t i) { return inner(i, c); };
    const double u2 = u * u, u3 = u2 * u, u4 = u3 * u;
    constexpr double kRounding = 1e-13;  // coefficients of up to 50, thirty terms
    CHECK(std::abs(sum([](std::size_t) { return 1.0; }) - u) < kRounding);
    CHECK(std::abs(sum(c) - u2 / 2.0) < kRounding);
    CHECK(std::abs(sum([&](std::size_t i) { return c(i) * c(i); }) - u3 / 3.0) < kRounding);
    CHECK(std::abs(sum(ac) - u3 / 6.0) < kRounding);
    CHECK(std::abs(sum([&](std::size_t i) { return c(i) * c(i) * c(i); }) - u4 / 4.0) < kRounding);
    CHECK(std::abs(sum([&](std::size_t i) { return c(i) * ac(i); }) - u4 / 8.0) < kRounding);
    CHECK(std::abs(sum([&](std::size_t i) { return inner(i, [&](std::size_t j) { return c(j) * c(j); }); }) -
                   u4 / 12.0) < kRounding);
    CHECK(std::abs(sum([&](std::size_t i) { return inner(i, ac); }) - u4 / 24.0) < kRounding);
  }
}
