#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "support/approx.hpp"
#include "support/expression_world.hpp"

using bgsim::evaluate;
using bgsim::ExprId;
using bgsim::Op;
using bgsim::SymbolId;
using bgsim::test::RandomExpressions;
using bgsim::test::World;

namespace {

/// Derivative by Richardson extrapolation of central differences: error about 1e-9 for functions of order 1.
double numeric(const World& w, ExprId e, std::vector<double> at, std::size_t i) {
  const double h = 1e-3 * std::max(0.1, std::fabs(at[i])), x = at[i];
  const auto central = [&](double step) {
    at[i] = x + step;
    const double up = evaluate(w.pool, e, at);
    at[i] = x - step;
    return (up - evaluate(w.pool, e, at)) / (2 * step);
  };
  const double d1 = central(h), d2 = central(h / 2), d4 = central(h / 4);
  const double r1 = (4 * d2 - d1) / 3, r2 = (4 * d4 - d2) / 3;
  return (16 * r2 - r1) / 15;
}

}  // namespace

TEST_CASE("derivatives of every operator agree with difference quotients") {
  World w;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.1, 0.9);
  for (const char* text : {"-x",
                           "x + y",
                           "x - y",
                           "x*y",
                           "x/y",
                           "y/x",
                           "x^3",
                           "x^-2",
                           "x^0.5",
                           "x^y",
                           "2^x",
                           "abs(x - 2)",
                           "sqrt(x)",
                           "cbrt(x)",
                           "cbrt(-x)",
                           "exp(x)",
                           "log(x)",
                           "log10(x)",
                           "sin(x)",
                           "cos(x)",
                           "tan(x)",
                           "asin(x)",
                           "acos(x)",
                           "atan(x)",
                           "sinh(x)",
                           "cosh(x)",
                           "tanh(x)",
                           "asinh(3*x)",
                           "acosh(x + 3)",
                           "acosh(1/x)",
                           "atanh(x/3)",
                           "log1p(x*y)",
                           "expm1(x)",
                           "mod(x, 40)*y + ceil(0.01*x)*y + round(0.01*x)",
                           "min(x, y + 2)",
                           "max(x, y + 2)",
                           "atan2(x, y)",
                           "atan2(y, -x)",
                           "hypot(x, y)",
                           "ssqrt(x, y)",
                           "ssqrt(-y, x)",
                           "if(x < 2, x^2, y)",
                           "table('data.csv', 'u', x)",
                           "table('data.csv', 'u', 3*x + 2, spline)",
                           "x*sin(x*y)*exp(-x) + x^2/(1 + y^2)",
                           "sin(cos(sin(cos(x*y))))",
                           "x + x*x + x*x*x",
                           "floor(x)*y + step(x)*x + sign(x)*x*y"}) {
    const ExprId e = w.parse(text);
    const ExprId dx = w.derivative(e, "x"), dy = w.derivative(e, "y");
    for (int i = 0; i < 20; ++i) {
      const std::vector<double> at{0.0, uniform(random), uniform(random), 0.0};
      CAPTURE(text, at[1], at[2]);
      // the quotient's own error; near the ends of asin's domain it is larger
      CHECK(w.value(dx, at) == Approx(numeric(w, e, at, 1)).epsilon(1e-5).margin(1e-7));
      CHECK(w.value(dy, at) == Approx(numeric(w, e, at, 2)).epsilon(1e-5).margin(1e-7));
    }
  }
}

TEST_CASE("the slope of the signed square root is the closed form, also where squares would overflow") {
  World w;
  const ExprId slope = w.derivative(w.parse("ssqrt(x, y)"), "x"), by_width = w.derivative(w.parse("ssqrt(x, y)"), "y");
  for (const double x : {-3.0, -1e-4, 0.0, 1e-9, 0.2, 1e5})
    for (const double d : {1e-3, 0.5, 20.0}) {
      const double s = x * x + d * d;
      const std::vector<double> at{0.0, x, d};
      CHECK(w.value(slope, at) == Approx((x * x / 2 + d * d) / std::pow(s, 1.25)).epsilon(1e-14));
      CHECK(w.value(by_width, at) == Approx(-x * d / (2 * std::pow(s, 1.25))).epsilon(1e-14));
    }
  CHECK(w.value(slope, std::vector<double>{0.0, 1e200, 1.0}) == Approx(0.5e-100).epsilon(1e-14));
}

TEST_CASE("the slopes of inverse hyperbolic functions are exact at both ends of their range") {
  World w;
  const auto slope = [&w](const char* text, double x) {
    return w.value(w.derivative(w.parse(text), "x"), std::vector<double>{0.0, x});
  };
  CHECK(slope("asinh(x)", 0.0) == 1.0);
  CHECK(slope("asinh(x)", 1e200) == Approx(1e-200).epsilon(1e-15));
  CHECK(slope("atanh(x)", 1e-20) == 1.0);
  CHECK(slope("atanh(x)", 1.0 - 0x1p-50) == Approx(0x1p49).epsilon(1e-14));
  CHECK(slope("acosh(x)", 1.0 + 0x1p-50) == Approx(1.0 / std::sqrt(0x1p-49)).epsilon(1e-14));
  CHECK(slope("acosh(x)", 1e200) == Approx(1e-200).epsilon(1e-15));
  CHECK(slope("log1p(x)", 1e-20) == 1.0);
  CHECK(slope("expm1(x)", 0.0) == 1.0);
  CHECK(w.text(w.derivative(w.parse("mod(t, x)"), "x")) == "-floor(t/x)");
  CHECK(w.text(w.derivative(w.parse("mod(x, 3)"), "x")) == "1");
}

TEST_CASE("derivatives of random smooth expressions agree with difference quotients") {
  World w;
  int compared = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    RandomExpressions random(w, seed, true);
    const ExprId e = random.number(8);
    bool smooth = !jumps_with(w.pool, e, [](SymbolId) { return true; });
    for (const ExprId id : reachable(w.pool, {&e, 1})) smooth = smooth && w.pool[id].op != Op::der;
    if (!smooth) continue;
    const std::vector<double> at{0.31, 0.47, 0.59, 0.83, 1.21, 0.67, 0.39};
    for (std::size_t i = 0; i < at.size(); ++i) {
      const double expected = numeric(w, e, at, i), value = w.value(w.derivative(e, w.names[i]), at);
      // difference quotients of steep or huge functions say nothing; kinks closer than 1e-3 cannot be separated
      if (!std::isfinite(expected) || std::fabs(expected) > 1e3 || std::fabs(w.value(e, at)) > 1e3) continue;
      CAPTURE(seed, w.text(e), w.names[i]);
      CHECK(value == Approx(expected).epsilon(1e-4).margin(1e-5));
      ++compared;
    }
  }
  CHECK(compared > 300);
}

TEST_CASE("a constant exponent needs no logarithm, so a negative base has a slope") {
  World w;
  CHECK(w.derivative(w.parse("x^3"), "x") == w.parse("3*x^2"));
  CHECK(w.derivative(w.parse("x^2"), "x") == w.parse("2*x"));
  CHECK(w.value(w.derivative(w.parse("x^5"), "x"), std::vector<double>{0, -2}) == 80.0);
}

TEST_CASE("the logarithm of an amount that is 0 has a finite exponential and slope") {
  World w;
  const ExprId rate = w.parse("y*exp(log(x) + z)");
  const std::vector<double> at{0.0, 0.0, 2.0, 0.5};
  CHECK(w.value(rate, at) == 0.0);
  CHECK(w.value(w.derivative(rate, "x"), at) == bgsim::test::same_to_rounding(2.0 * std::exp(0.5)));
}

TEST_CASE("the gradient of a long sum costs as much as the sum, not its square") {
  World w;
  ExprId sum = w.pool.constant(0.0);
  for (std::size_t i = 0; i < 20000; ++i) {
    const ExprId x = w.pool.symbol(SymbolId(i));
    sum = w.pool.add(sum, w.pool.mul(x, w.pool.make(Op::sin, x)));
  }
  const std::size_t before = w.pool.size();
  const auto g = gradient(w.pool, sum, [](SymbolId) { return true; });
  CHECK(g.size() == 20000);
  // sin x + x cos x: at most five new expressions a term
  CHECK(w.pool.size() - before <= 5 * 20000);
  for (std::size_t i = 1; i < g.size(); ++i) CHECK(g[i - 1].first < g[i].first);
}

TEST_CASE("splines have three derivatives that vary, and an unresolved der has none") {
  World w;
  const ExprId curve = w.parse("table('data.csv', 'u', x, spline)");
  const ExprId slope = w.derivative(curve, "x"), curvature = w.derivative(slope, "x");
  const std::vector<double> at{0.0, 4.0};
  CHECK(w.value(curvature, at) == Approx(numeric(w, slope, at, 1)).epsilon(1e-7));
  CHECK(w.pool.is_constant(w.derivative(w.derivative(w.parse("table('data.csv', 'u', x)"), "x"), "x"), 0.0));
  const ExprId third = w.derivative(curvature, "x");
  CHECK(w.value(third, at) == Approx(numeric(w, curvature, at, 1)).epsilon(1e-7));
  CHECK(w.pool.is_constant(w.derivative(third, "x"), 0.0));  // between its knots, at which it jumps
  CHECK_THROWS_AS(w.derivative(w.parse("der(x)"), "x"), std::invalid_argument);
  CHECK(w.pool.is_constant(w.derivative(w.parse("der(x) + y"), "y"), 1.0));
}

TEST_CASE("jumps are distinguished from kinks") {
  World w;
  const auto jumps = [&](const char* text) {
    return jumps_with(w.pool, w.parse(text), [&](SymbolId s) { return s == w.id("x"); });
  };
  CHECK(jumps("sign(x)*y"));
  CHECK(jumps("if(x < 0, 0, y)"));
  CHECK(jumps("y + floor(2*x)"));
  CHECK(jumps("y*ceil(x)"));
  CHECK(jumps("round(x + y)"));
  CHECK(jumps("mod(x, y)"));
  CHECK(jumps("mod(y, 2*x)"));
  CHECK(jumps("step(sin(x))"));
  CHECK_FALSE(jumps("if(y < 0, x, 2*x)"));
  CHECK_FALSE(jumps("abs(x) + min(x, y)"));
  CHECK_FALSE(jumps("table('data.csv', 'u', x)"));
  const ExprId line = w.parse("table('data.csv', 'u', x)");
  CHECK(jumps_with(w.pool, w.derivative(line, "x"), [](SymbolId) { return true; }));
}

TEST_CASE("a root beside a product of more factors than can be counted is differentiated all the same") {
  World w;
  ExprId power = w.parse("x + y"), chain = w.parse("sqrt(abs(x))");
  for (int k = 0; k < 40; ++k) power = w.pool.mul(power, power);
  for (int k = 0; k < 100000; ++k) chain = w.pool.mul(chain, w.pool.add(w.symbol("y"), w.pool.constant(k)));
  const std::vector<double> at{0.0, 0.5, 0.5};
  CHECK(w.value(w.derivative(w.pool.mul(power, w.parse("sqrt(abs(x))")), "x"), at) ==
        Approx(0x1p40 * std::sqrt(0.5) + 0.5 / std::sqrt(0.5)).epsilon(1e-12));
  CHECK(w.derivative(w.pool.mul(w.symbol("x"), chain), "x").valid());
}

TEST_CASE("a root beside a factor that vanishes with it has the slope of their product, at 0, too") {
  World w;
  const auto slope = [&w](const std::string& text, double x) {
    return w.value(w.derivative(w.parse(text), "x"), std::vector<double>{0.0, x, 0.75});
  };
  struct Case {
    const char* law;
    double at_zero;
  };
  for (const Case& each :
       {Case{"x*abs(x)^0.75", 0.0}, Case{"x*(3 + abs(x)^0.75)", 3.0}, Case{"x*abs(x)^y", 0.0},
        Case{"2*x*sqrt(abs(x)/7)", 0.0}, Case{"x*(3 + cbrt(x^2))", 3.0}, Case{"x*(3 + sqrt(x*x))", 3.0},
        Case{"x*(3 + sqrt(sqrt(x^2)))", 3.0}, Case{"-x/5*(3 + (x^2)^0.3)", -0.6},
        Case{"x*(3 + abs(x)^0.5)*(1 + abs(x)^0.25)", 3.0}, Case{"x*abs(2*x)^0.5 + x", 1.0}}) {
    INFO(each.law);
    CHECK(slope(each.law, 0.0) == each.at_zero);
    for (const double x : {-1.7, -0.3, 0.2, 2.6})
      CHECK(slope(each.law, x) == Approx(numeric(w, w.parse(each.law), {0.0, x, 0.75}, 1)).epsilon(1e-7));
  }
}
