#include "program/known_times.hpp"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "support/expression_world.hpp"

using namespace bgsim;
using bgsim::test::World;

TEST_CASE("a condition on time has one place in all pools, whatever else they hold") {
  KnownTimes times;
  const auto place = [&](World& world, const std::string& text, const std::vector<double>& values) {
    const ExprId e = world.parse("if(" + text + ", 1, 0)");
    return times.of(world.pool, ExprId(world.pool[e].a), World::id(0), values);
  };
  World one, other;
  // In the other pool the parts come in another order, so their ids do too.
  other.parse("x + floor(t/y)");
  other.parse("y*3");
  std::vector<double> values(8, 2.0);
  KnownTime* first = place(one, "t/x - floor(t/y) < 0.5", values);
  REQUIRE(first != nullptr);
  values[0] = 7.0;  // the time is no parameter
  CHECK(place(other, "t/x - floor(t/y) < 0.5", values) == first);
  CHECK(place(other, "t/x - floor(t/y) < 0.25", values) != first);
  CHECK(place(other, "t/x - floor(t/y) <= 0.5", values) != first);
  CHECK(place(other, "floor(t/y) - t/x < 0.5", values) != first);
  // Measured data are each pool's own.
  CHECK(place(one, "table('data.csv', 'u', t) < 0.5", values) == nullptr);
  values[1] = 3.0;
  CHECK(place(other, "t/x - floor(t/y) < 0.5", values) != first);
}
