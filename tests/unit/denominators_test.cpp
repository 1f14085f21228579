// Rates on the way to a zero of their denominator.
#include "run/watch/denominators.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace bgsim;

namespace {

/// x goes to 0 at t = 1 with slope -1.
bool unbounded(double (*rate)(double x)) {
  const Approach approach{1.0, 1e-12, {0.0}, {-1.0}};
  return grows_without_bound(approach, 1, [rate](double, const double* x, double* rates) {
    rates[0] = rate(x[0]);
    return std::isfinite(rates[0]);
  });
}

}  // namespace

TEST_CASE("rates with a singularity grow without bound on the way to it") {
  CHECK(unbounded([](double x) { return 1.0 / x; }));
  CHECK(unbounded([](double x) { return -1e-9 / x; }));
  CHECK(unbounded([](double x) { return 1.0 / (x * x); }));
  CHECK(unbounded([](double x) { return 1.0 / std::sqrt(std::abs(x)); }));
  CHECK(unbounded([](double x) { return std::cos(x) / std::sin(x); }));
  CHECK(unbounded([](double) { return std::nan(""); }));
}

TEST_CASE("quotients that stay finite do not") {
  CHECK(!unbounded([](double x) { return std::sin(x) / x; }));
  CHECK(!unbounded([](double x) { return (std::exp(x) - 1.0) / x; }));
  CHECK(!unbounded([](double x) { return x * x / x; }));
  CHECK(!unbounded([](double x) { return (1.0 - std::cos(x)) / (x * x); }));
  CHECK(!unbounded([](double x) { return 3.0 + x; }));
}
