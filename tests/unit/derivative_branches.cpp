#include <catch2/catch.hpp>
#include <cmath>

#include "bgsim/expression.hpp"
#include "support/approx.hpp"

using namespace bgsim;

namespace {

const SymbolId kX(0);

double slope_at(ExprPool& pool, ExprId root, double x) {
  const auto slopes = gradient(pool, root, [](SymbolId) { return true; });
  if (slopes.empty()) return 0.0;
  const double values[] = {x};
  return evaluate(pool, slopes.front().second, values);
}

}  // namespace

TEST_CASE("a branch that is not taken has no part in the slope, even where its own slope does not exist") {
  ExprPool pool;
  const ExprId x = pool.symbol(kX), zero = pool.constant(0.0);
  const ExprId positive = pool.make(Op::gt, x, zero);
  const ExprId root = pool.make(Op::sqrt, x);

  SECTION("a square root behind a condition") {
    const ExprId law = pool.mul(pool.constant(3.0), pool.select(positive, root, zero));
    CHECK(slope_at(pool, law, 4.0) == test::same_to_rounding(0.75));
    CHECK(slope_at(pool, law, 0.0) == 0.0);
    CHECK(slope_at(pool, law, -1.0) == 0.0);
  }
  SECTION("the root used twice in the branch, and the condition turned around") {
    const ExprId twice = pool.add(root, pool.mul(x, root));
    const ExprId law = pool.select(pool.make(Op::le, x, zero), zero, twice);
    CHECK(slope_at(pool, law, 4.0) == test::same_to_rounding(0.25 + 3.0));
    CHECK(slope_at(pool, law, -1.0) == 0.0);
  }
  SECTION("a condition within a branch") {
    const ExprId near = pool.make(Op::lt, x, pool.constant(9.0));
    const ExprId law = pool.select(positive, pool.select(near, root, pool.constant(3.0)), zero);
    CHECK(slope_at(pool, law, 4.0) == test::same_to_rounding(0.25));
    CHECK(slope_at(pool, law, 16.0) == 0.0);
    CHECK(slope_at(pool, law, -1.0) == 0.0);
  }
}
