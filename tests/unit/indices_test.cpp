// Indices of sensitivity against closed forms: Ishigami's function, the g-function of Sobol.
#include "bgsim/indices.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

namespace {

using namespace bgsim;

constexpr double kPi = 3.14159265358979323846;

SweepPlan plan_for(const std::vector<std::string>& vary, const std::string& sample, std::uint64_t seed = 1) {
  SweepPlan plan;
  for (const std::string& text : vary) plan.variations.push_back(parse_variation(text));
  parse_sampling(sample, plan);
  plan.seed = seed;
  return plan;
}

using Function = std::function<double(const std::vector<double>&)>;

std::vector<double> results_of(const SweepPoints& points, const Function& f) {
  std::vector<double> results;
  for (std::uint64_t run = 0; run < points.size(); ++run) results.push_back(f(points.at(run)));
  return results;
}

/// Ishigami and Homma 1990, with a = 7, b = 0.1, and a quantity that does nothing.
double ishigami(const std::vector<double>& x) {
  return std::sin(x[0]) + 7.0 * std::sin(x[1]) * std::sin(x[1]) + 0.1 * std::pow(x[2], 4) * std::sin(x[0]);
}
const std::vector<std::string> kIshigami{"a=-3.141592653589793:3.141592653589793",
                                         "b=-3.141592653589793:3.141592653589793",
                                         "c=-3.141592653589793:3.141592653589793", "idle=0:1"};
struct Exact {
  double variance;
  std::vector<double> first, total;
};
Exact ishigami_exact() {
  const double pi4 = std::pow(kPi, 4), b = 0.1;
  const double alone1 = 0.5 * (1.0 + b * pi4 / 5.0) * (1.0 + b * pi4 / 5.0), alone2 = 49.0 / 8.0;
  const double pair13 = b * b * pi4 * pi4 * (1.0 / 18.0 - 1.0 / 50.0), all = alone1 + alone2 + pair13;
  return {all, {alone1 / all, alone2 / all, 0.0, 0.0}, {(alone1 + pair13) / all, alone2 / all, pair13 / all, 0.0}};
}

/// The g-function over (0, 1): product of (|4 x - 2| + a)/(1 + a).
const std::vector<double> kG{0.0, 0.5, 3.0, 9.0, 99.0, 99.0};
const std::vector<std::string> kGQuantities{"a=0:1", "b=0:1", "c=0:1", "d=0:1", "e=0:1", "f=0:1"};
double g_function(const std::vector<double>& x) {
  double product = 1.0;
  for (std::size_t i = 0; i < x.size(); ++i) product *= (std::abs(4.0 * x[i] - 2.0) + kG[i]) / (1.0 + kG[i]);
  return product;
}

bool within(double value, double exact, double by) { return std::abs(value - exact) <= by; }

}  // namespace

TEST_CASE("indices of the variance of Ishigami's function are those of the closed form") {
  const Exact exact = ishigami_exact();
  const SweepPoints points(plan_for(kIshigami, "saltelli:8192"));
  REQUIRE(points.size() == 8192U * 6U);
  const VarianceShares shares = variance_shares(points, results_of(points, ishigami));
  CHECK(shares.points == 8192);
  // Sobol's points: errors some 1/N, of which these are ten times as much.
  CHECK(within(shares.mean, 3.5, 2e-3));
  CHECK(within(shares.deviation, std::sqrt(exact.variance), 2e-3));
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(i, shares.of[i].first, shares.of[i].first_within, shares.of[i].total, shares.of[i].total_within);
    CHECK(within(shares.of[i].first, exact.first[i], 5e-3));
    CHECK(within(shares.of[i].total, exact.total[i], 5e-3));
    CHECK(within(shares.of[i].first, exact.first[i], shares.of[i].first_within));
    CHECK(within(shares.of[i].total, exact.total[i], shares.of[i].total_within));
  }
  CHECK(shares.of[3].first == 0.0);
  CHECK(shares.of[3].total == 0.0);
}

TEST_CASE("indices of the variance of the g-function are those of the closed form") {
  const SweepPoints points(plan_for(kGQuantities, "saltelli:8192", 5));
  const VarianceShares shares = variance_shares(points, results_of(points, g_function));
  double product = 1.0;
  for (const double a : kG) product *= 1.0 + 1.0 / (3.0 * (1.0 + a) * (1.0 + a));
  CHECK(within(shares.mean, 1.0, 2e-3));
  for (std::size_t i = 0; i < kG.size(); ++i) {
    const double alone = 1.0 / (3.0 * (1.0 + kG[i]) * (1.0 + kG[i]));
    const double first = alone / (product - 1.0), total = alone * product / (1.0 + alone) / (product - 1.0);
    CAPTURE(i, first, total, shares.of[i].first, shares.of[i].total);
    CHECK(within(shares.of[i].first, first, 5e-3));
    CHECK(within(shares.of[i].total, total, 5e-3));
  }
}

TEST_CASE("intervals of the indices hold the exact ones in 95 of 100 samples") {
  const Exact exact = ishigami_exact();
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const SweepPoints points(plan_for(kIshigami, "saltelli:128", seed));
    const VarianceShares shares = variance_shares(points, results_of(points, ishigami));
    for (std::size_t i = 0; i < 3; ++i) {
      inside += within(shares.of[i].first, exact.first[i], shares.of[i].first_within) ? 1 : 0;
      inside += within(shares.of[i].total, exact.total[i], shares.of[i].total_within) ? 1 : 0;
      all += 2;
    }
  }
  CAPTURE(inside, all);
  // The intervals are those of random points; Sobol's are nearer, so that more than 95 % hold it.
  CHECK(inside >= 0.95 * all);
}

TEST_CASE("a result that does not vary has no indices, and runs without a value leave those of the others") {
  const SweepPoints points(plan_for(kIshigami, "saltelli:1024"));
  const VarianceShares constant = variance_shares(points, std::vector<double>(points.size(), 0.1));
  CHECK(constant.mean == 0.1);
  CHECK(constant.deviation == 0.0);
  CHECK(std::isnan(constant.of[0].first));
  CHECK(std::isnan(constant.of[0].total_within));

  std::vector<double> results = results_of(points, ishigami);
  for (std::size_t run = 0; run < results.size(); run += 7) results[run] = std::numeric_limits<double>::quiet_NaN();
  const VarianceShares shares = variance_shares(points, results);
  CHECK(shares.points < 1024);
  const Exact exact = ishigami_exact();
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(shares.of[i].points < shares.points);
    CHECK(within(shares.of[i].total, exact.total[i], 1.5 * shares.of[i].total_within));
  }
  const VarianceShares none =
      variance_shares(points, std::vector<double>(points.size(), std::numeric_limits<double>::quiet_NaN()));
  CHECK(none.points == 0);
  CHECK(std::isnan(none.mean));
  CHECK(std::isnan(none.of[0].total));
}

TEST_CASE("large offsets do not spoil indices") {
  const SweepPoints points(plan_for(kIshigami, "saltelli:1024"));
  std::vector<double> results = results_of(points, ishigami);
  const VarianceShares before = variance_shares(points, results);
  for (double& result : results) result += 1e6;
  const VarianceShares after = variance_shares(points, results);
  // Adding 1e6 rounds by 1e-10.
  for (std::size_t i = 0; i < 4; ++i) CHECK(within(after.of[i].first, before.of[i].first, 1e-9));
  CHECK(after.of[3].first == 0.0);
}

TEST_CASE("the paths of Morris move each quantity once, within its distribution") {
  const SweepPoints points(plan_for({"a=0:8", "b=normal(0,1)", "c=1,2", "d=log(1:100)"}, "morris:50", 3));
  REQUIRE(points.size() == 250);
  std::set<double> levels;
  for (std::uint64_t path = 0; path < 50; ++path) {
    std::set<std::size_t> moved;
    for (std::uint64_t run = 5 * path; run < 5 * path + 4; ++run) {
      const std::vector<double> here = points.at(run), next = points.at(run + 1);
      const SweepPoints::Move move = points.move_after(run);
      moved.insert(move.variation);
      for (std::size_t i = 0; i < 4; ++i) {
        CHECK(std::isfinite(next[i]));
        CHECK((here[i] == next[i]) == (i != move.variation));
        if (i == move.variation) CHECK((next[i] > here[i]) == (move.share > 0.0));
      }
      levels.insert(here[0]);
    }
    CHECK(moved.size() == 4);
  }
  CHECK(levels == std::set<double>{1.0, 3.0, 5.0, 7.0});
}

TEST_CASE("elementary effects of a line are its slopes times the ranges, and do not spread") {
  const SweepPoints points(plan_for({"a=0:2", "b=-1:3", "idle=0:1"}, "morris:10"));
  const auto effects =
      elementary_effects(points, results_of(points, [](const auto& x) { return 4.0 * x[0] - 0.5 * x[1]; }));
  // Sums of doubles of the size of 10.
  CHECK(within(effects[0].mean, 8.0, 1e-13));
  CHECK(within(effects[1].mean, -2.0, 1e-13));
  CHECK(within(effects[1].magnitude, 2.0, 1e-13));
  CHECK(effects[0].deviation < 1e-13);
  CHECK(effects[0].effects == 10);
  CHECK(effects[2].magnitude == 0.0);
  CHECK(effects[2].within == 0.0);
}

TEST_CASE("elementary effects of the g-function are those of all its steps") {
  // On the four levels |4 x - 2| is 1.5, 0.5, 0.5, 1.5: a step changes it by 1, and the mean of each factor is 1.
  const SweepPoints points(plan_for(kGQuantities, "morris:4000", 2));
  const auto effects = elementary_effects(points, results_of(points, g_function));
  for (std::size_t i = 0; i < kG.size(); ++i) {
    double squares = 4.0 / ((1.0 + kG[i]) * (1.0 + kG[i]));
    for (std::size_t j = 0; j < kG.size(); ++j)
      if (j != i) squares *= 1.0 + 0.25 / ((1.0 + kG[j]) * (1.0 + kG[j]));
    CAPTURE(i, effects[i].magnitude, effects[i].within);
    // Twice the interval of 95 %: one in ten thousand.
    CHECK(within(effects[i].magnitude, 2.0 / (1.0 + kG[i]), 2.0 * effects[i].within));
    CHECK(within(effects[i].mean, 0.0, 4.0 * effects[i].deviation / std::sqrt(4000.0)));
    CHECK(effects[i].deviation == Approx(std::sqrt(squares)).epsilon(0.05));
  }
}

TEST_CASE("effects need both ends, and two of them") {
  const SweepPoints points(plan_for({"a=0:1", "b=0:1"}, "morris:2"));
  std::vector<double> results(6, 1.0);
  results[1] = std::numeric_limits<double>::infinity();
  const auto effects = elementary_effects(points, results);
  CHECK(effects[0].effects == 1);
  CHECK(std::isnan(effects[0].magnitude));
}

TEST_CASE("samples for indices that cannot be are refused") {
  const auto fault = [](const std::vector<std::string>& vary, const std::string& sample) -> std::string {
    try {
      const SweepPoints points(plan_for(vary, sample));
    } catch (const SweepError& error) {
      return error.what();
    }
    return {};
  };
  using Catch::Contains;
  CHECK_THAT(fault({"a=0:1"}, "saltelli:1"), Contains("take at least two"));
  CHECK_THAT(fault({"a=0:1"}, "morris:1"), Contains("take at least two"));
  CHECK_THAT(fault({"a=0:1"}, "saltelli:0"), Contains("no runs"));
  CHECK_THAT(fault({"a=0:1", "b=0:1"}, "morris:100000000"), !Contains("1e9"));
  std::vector<std::string> many;
  for (int i = 0; i < 20; ++i) many.push_back("a" + std::to_string(i) + "=0:1");
  CHECK_THAT(fault(many, "saltelli:100000000"), Contains("more than 1e9"));
  for (int i = 20; i < 2000; ++i) many.push_back("a" + std::to_string(i) + "=0:1");
  CHECK_THAT(fault(many, "saltelli:2"), Contains("at most 3667 dimensions"));
}
