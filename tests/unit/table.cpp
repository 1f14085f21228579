#include <catch2/catch.hpp>
#include <cmath>

#include "bgsim/expression.hpp"

using bgsim::Interpolation;
using bgsim::Table;

namespace {
template <class F>
Table tabulated(const F& f, std::vector<double> x, Interpolation interpolation) {
  Table table;
  table.interpolation = interpolation;
  table.x = std::move(x);
  for (const double v : table.x) table.y.push_back(f(v));
  if (interpolation == Interpolation::spline) prepare_spline(table);
  return table;
}
}  // namespace

TEST_CASE("a spline without a knot at the last points but one is exact for cubics") {
  const auto cubic = [](double x) { return 2.0 - x + 0.5 * x * x - 0.25 * x * x * x; };
  const Table table = tabulated(cubic, {-2.0, -1.5, 0.1, 0.2, 3.0, 4.5}, Interpolation::spline);
  for (double x = -2.0; x <= 4.5; x += 0.01) {
    // values up to 15: a few rounding errors
    CHECK(table_value(table, x) == Approx(cubic(x)).epsilon(0).margin(2e-14));
    CHECK(table_slope(table, x) == Approx(-1.0 + x - 0.75 * x * x).epsilon(0).margin(1e-13));
    CHECK(table_curvature(table, x) == Approx(1.0 - 1.5 * x).epsilon(0).margin(1e-12));
    CHECK(table_third(table, x) == Approx(-1.5).epsilon(0).margin(1e-10));  // curvatures over a tenth
  }
}

TEST_CASE("a spline converges with the fourth power of the spacing") {
  const auto error = [](int n) {
    std::vector<double> x;
    for (int i = 0; i <= n; ++i) x.push_back(3.0 * i / n);
    const Table table = tabulated([](double v) { return std::sin(v); }, x, Interpolation::spline);
    double worst = 0.0;
    for (double v = 0.0; v < 3.0; v += 1e-3) worst = std::max(worst, std::fabs(table_value(table, v) - std::sin(v)));
    return worst;
  };
  CHECK(error(160) / error(320) == Approx(16.0).epsilon(0.1));
}

TEST_CASE("interpolation goes through the data, and outside them there is no value") {
  for (const Interpolation interpolation : {Interpolation::linear, Interpolation::spline}) {
    const Table table = tabulated([](double v) { return 1.0 / (1.0 + v * v); }, {-3, -1, 0, 0.5, 2}, interpolation);
    for (std::size_t i = 0; i + 1 < table.x.size(); ++i) CHECK(table_value(table, table.x[i]) == table.y[i]);
    CHECK(table_value(table, table.x.back()) == Approx(table.y.back()).epsilon(1e-15));
    for (const double outside : {-3.0000001, 2.0000001, 1e300, std::nan("")}) {
      CHECK(std::isnan(table_value(table, outside)));
      CHECK(std::isnan(table_slope(table, outside)));
    }
  }
  const Table line = tabulated([](double v) { return 2.0 * v; }, {0, 1, 4}, Interpolation::linear);
  CHECK(table_value(line, 2.5) == 5.0);
  CHECK(table_slope(line, 2.5) == 2.0);
}

TEST_CASE("few points: a parabola's knots make a natural spline, two make a line") {
  const Table two = tabulated([](double v) { return 3.0 * v; }, {0, 2}, Interpolation::spline);
  CHECK(table_value(two, 0.5) == 1.5);
  // natural spline through (0,0), (1,1), (2,0): S'' = -3 at the middle, so S(1/2) = 1/2 + 3/16
  Table three;
  three.interpolation = Interpolation::spline;
  three.x = {0, 1, 2};
  three.y = {0, 1, 0};
  prepare_spline(three);
  CHECK(table_value(three, 0.5) == Approx(0.6875).epsilon(1e-15));
}

TEST_CASE("a hundred thousand points are no trouble") {
  std::vector<double> x;
  for (int i = 0; i < 100000; ++i) x.push_back(1e-3 * i);
  const Table table = tabulated([](double v) { return std::cos(v); }, x, Interpolation::spline);
  CHECK(table_value(table, 50.0005) == Approx(std::cos(50.0005)).epsilon(1e-12));
}
