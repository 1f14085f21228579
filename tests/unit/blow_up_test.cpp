// What grows without bound in a finite time, among what grows.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "run/failures.hpp"

using namespace bgsim;

namespace {

/// Where a run from 0 to @p t, in which y was small, came to a stop.
StuckPoint point_of(double t, const std::function<double(double)>& y, const std::function<double(double)>& rate) {
  StuckPoint point;
  point.t = t;
  point.names = {"c.q"};
  point.y = {y(t)};
  point.rate = {rate(t)};
  point.largest_early = {1e-6 * std::abs(y(t))};
  point.rate_before = [t, rate](double by) { return std::vector<double>{rate(t - by)}; };
  return point;
}

}  // namespace

TEST_CASE("what has a pole ahead is said to grow without bound, and dated") {
  constexpr double kPole = 2.0, kLeft = 1e-6;
  for (const double p : {0.5, 1.0, 2.0, 10.0, 30.0})
    for (const double sign : {1.0, -1.0}) {
      CAPTURE(p, sign);
      const auto found = recognise_blow_up(point_of(
          kPole - kLeft, [&](double t) { return sign * std::pow(kPole - t, -p); },
          [&](double t) { return sign * p * std::pow(kPole - t, -p - 1.0); }));
      REQUIRE(found);
      CHECK_FALSE(found->overflow);
      CHECK(std::abs(found->time - (kPole - kLeft + kLeft / p)) < 1e-12);  // y/y'; rounding of times of 2
    }
}

TEST_CASE("what a source has just begun to fill does not grow without bound, nor does an exponential") {
  constexpr double kBegin = 1.0, kSince = 1e-6;
  for (const double n : {0.5, 1.0, 2.0, 5.0}) {
    CAPTURE(n);
    CHECK_FALSE(recognise_blow_up(point_of(
        kBegin + kSince, [&](double t) { return std::pow(t - kBegin, n); },
        [&](double t) { return n * std::pow(t - kBegin, n - 1.0); })));
  }
  CHECK_FALSE(recognise_blow_up(point_of(
      1.0, [](double t) { return std::exp(1e5 * (t - 1.0)); },
      [](double t) { return 1e5 * std::exp(1e5 * (t - 1.0)); })));
}
