// How long the rest of a run takes, by clocks that the tests set.
#include "run/watch/headway.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "support/approx.hpp"

using bgsim::Headway;

namespace {

/// A run whose time is @p t at each second of the clock, with @p work done by then.
std::optional<Headway::Pace> pace_after(double seconds, double stop, const std::function<double(double)>& t,
                                        const std::function<double(double)>& work, double stretch) {
  Headway headway(stop);
  for (double now = 0.0; now <= seconds; now += 0.125) headway.add(now, t(now), static_cast<std::uint64_t>(work(now)));
  return headway.pace(stretch);
}

double thousand_a_second(double s) { return 1000.0 * s; }

}  // namespace

TEST_CASE("a steady run takes as long as what is left of its time by its pace") {
  const auto pace = pace_after(
      10.0, 1000.0, [](double s) { return 0.5 * s; }, thousand_a_second, 4.0);
  REQUIRE(pace);
  CHECK(pace->rest == bgsim::test::same_to_rounding((1000.0 - 5.0) / 0.5));
  CHECK(pace->progress == bgsim::test::same_to_rounding(0.5e-3));
  CHECK(pace->stretch == bgsim::test::same_to_rounding(2.0));
  CHECK(pace->seconds == bgsim::test::same_to_rounding(4.0));
}

TEST_CASE("a run that picks up has no pace yet, and a slow start is forgotten") {
  CHECK_FALSE(pace_after(
      10.0, 1e9, [](double s) { return std::exp(s); }, thousand_a_second, 8.0));
  // The steps grow by a tenth a second: far from steady.
  CHECK_FALSE(pace_after(
      10.0, 1e9, [](double s) { return std::exp(0.1 * s); }, thousand_a_second, 8.0));
  // Two seconds in which next to nothing happened, then a steady run.
  const auto pace = pace_after(
      10.0, 100.0, [](double s) { return s < 2.0 ? 1e-9 * s : s - 2.0; }, thousand_a_second, 4.0);
  REQUIRE(pace);
  CHECK(pace->rest == bgsim::test::same_to_rounding(92.0));
}

TEST_CASE("a pace that is fast now and then is judged by its best stretch") {
  // One second in four is ten times as fast; what the work brings is the same.
  const auto t = [](double s) {
    return 13.0 * std::floor(s / 4.0) + std::min(std::fmod(s, 4.0), 3.0) +
           10.0 * std::max(std::fmod(s, 4.0) - 3.0, 0.0);
  };
  const auto pace = pace_after(
      16.0, 1e6, t, [&](double s) { return 100.0 * t(s); }, 4.0);
  REQUIRE(pace);
  CHECK(pace->rest == bgsim::test::same_to_rounding((1e6 - 52.0) / 10.0));
}

TEST_CASE("a run with little work is judged over a longer stretch, and not before there is one") {
  const auto one_a_second = [](double s) { return std::floor(s); };
  CHECK_FALSE(pace_after(50.0, 1e6, one_a_second, one_a_second, 4.0));
  const auto pace = pace_after(300.0, 1e6, one_a_second, one_a_second, 4.0);
  REQUIRE(pace);
  CHECK(pace->seconds >= 100.0);
  CHECK_FALSE(Headway(1.0).pace(4.0));
}

TEST_CASE("a run that comes nowhere at all takes for ever") {
  const auto pace = pace_after(
      10.0, 1.0, [](double) { return 0.25; }, thousand_a_second, 4.0);
  REQUIRE(pace);
  CHECK(std::isinf(pace->rest));
}
