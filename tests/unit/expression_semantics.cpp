#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "support/approx.hpp"
#include "support/expression_world.hpp"

using bgsim::apply;
using bgsim::ExpressionError;
using bgsim::ExprId;
using bgsim::Op;
using bgsim::test::World;

namespace {
const double kNaN = std::numeric_limits<double>::quiet_NaN();
}

TEST_CASE("every function of the language has the value of the mathematical library") {
  World w;
  const auto sign = [](double x) { return double(x > 0) - double(x < 0); };
  const std::vector<std::pair<const char*, std::function<double(double)>>> rows{
      {"abs(x)", [](double x) { return std::fabs(x); }},
      {"sign(x)", sign},
      {"sqrt(x)", [](double x) { return std::sqrt(x); }},
      {"cbrt(x)", [](double x) { return std::cbrt(x); }},
      {"exp(x)", [](double x) { return std::exp(x); }},
      {"log(x)", [](double x) { return std::log(x); }},
      {"log10(x)", [](double x) { return std::log10(x); }},
      {"sin(x)", [](double x) { return std::sin(x); }},
      {"cos(x)", [](double x) { return std::cos(x); }},
      {"tan(x)", [](double x) { return std::tan(x); }},
      {"asin(x)", [](double x) { return std::asin(x); }},
      {"acos(x)", [](double x) { return std::acos(x); }},
      {"atan(x)", [](double x) { return std::atan(x); }},
      {"sinh(x)", [](double x) { return std::sinh(x); }},
      {"cosh(x)", [](double x) { return std::cosh(x); }},
      {"tanh(x)", [](double x) { return std::tanh(x); }},
      {"asinh(x)", [](double x) { return std::asinh(x); }},
      {"acosh(x)", [](double x) { return std::acosh(x); }},
      {"atanh(x)", [](double x) { return std::atanh(x); }},
      {"log1p(x)", [](double x) { return std::log1p(x); }},
      {"expm1(x)", [](double x) { return std::expm1(x); }},
      {"floor(x)", [](double x) { return std::floor(x); }},
      {"ceil(x)", [](double x) { return std::ceil(x); }},
      {"round(x)", [](double x) { return std::round(x); }},
      {"mod(x, y)", [](double x) { return x - 0.75 * std::floor(x / 0.75); }},
      {"step(x)", [](double x) { return x < 0 ? 0.0 : 1.0; }},
      {"-x", [](double x) { return -x; }},
      {"min(x, y)", [](double x) { return std::min(x, 0.75); }},
      {"max(x, y, -2)", [](double x) { return std::max(x, 0.75); }},
      {"atan2(x, y)", [](double x) { return std::atan2(x, 0.75); }},
      {"hypot(x, y)", [](double x) { return std::hypot(x, 0.75); }},
      {"ssqrt(x, y)", [](double x) { return x / std::pow(x * x + 0.75 * 0.75, 0.25); }},
      {"x^y", [](double x) { return std::pow(x, 0.75); }},
      {"if(x < y, x, -x)", [](double x) { return x < 0.75 ? x : -x; }},
      {"if(x <= 0.5 or not (x != 3), 1, 2)", [](double x) { return x <= 0.5 || x == 3 ? 1.0 : 2.0; }},
      {"if(x > 0 and x >= 1, 1, 2)", [](double x) { return x >= 1 ? 1.0 : 2.0; }},
  };
  for (const auto& [text, f] : rows)
    for (const double x : {-3.25, -1.0, -0.3, 0.0, 0.5, 0.75, 1.0, 2.0, 3.0, 25.5}) {
      CAPTURE(text, x);
      const double expected = f(x), value = w.value(text, {0.0, x, 0.75, 0.0});
      if (std::isnan(expected))
        CHECK(std::isnan(value));
      else if (std::string(text) == "ssqrt(x, y)")  // another formula: to rounding
        CHECK(value == Approx(expected).epsilon(1e-15));
      else
        CHECK(value == expected);
    }
}

TEST_CASE("functions of small numbers keep every digit") {
  World w;
  for (const double x : {1e-20, -1e-20, 1e-300, 3e-17, -0.0}) {
    CAPTURE(x);
    CHECK(w.value("log1p(x)", {0.0, x}) == x);  // the square is below the last digit
    CHECK(w.value("expm1(x)", {0.0, x}) == x);
    CHECK(w.value("asinh(x)", {0.0, x}) == x);
    CHECK(w.value("atanh(x)", {0.0, x}) == x);
  }
  CHECK(w.value("log1p(1e-20)") == 1e-20);
  CHECK(w.value("acosh(1)") == 0.0);
  // acosh(1 + h) = sqrt(2 h) (1 - h/12 + ...), with an h that 1 + h holds exactly
  CHECK(w.value("acosh(1 + x)", {0.0, 0x1p-40}) == Approx(0x1p-39 * std::sqrt(0x1p39)).epsilon(1e-12));
}

TEST_CASE("mod has the sign of its second argument, round goes away from zero at halves, ceil goes up") {
  World w;
  CHECK(w.value("mod(7, 3)") == 1.0);
  CHECK(w.value("mod(-7, 3)") == 2.0);
  CHECK(w.value("mod(7, -3)") == -2.0);
  CHECK(w.value("mod(-7, -3)") == -1.0);
  CHECK(w.value("mod(6, 3)") == 0.0);
  CHECK(w.value("mod(-6, 3)") == 0.0);
  CHECK(w.value("mod(5.75, 0.5)") == 0.25);
  CHECK(w.value("round(2.5)") == 3.0);
  CHECK(w.value("round(-2.5)") == -3.0);
  CHECK(w.value("round(-0.5)") == -1.0);
  CHECK(w.value("round(0.49999999999999994)") == 0.0);
  CHECK(w.value("ceil(-0.5)") == 0.0);
  CHECK(w.value("ceil(2)") == 2.0);
  CHECK(w.value("ceil(2.000000001)") == 3.0);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-50.0, 50.0);
  for (int i = 0; i < 100'000; ++i) {
    const double b = std::round(uniform(random) * 10.0) / 100.0, a = b * std::round(uniform(random));
    if (b == 0.0) continue;
    const double r = apply(Op::mod, a, b);
    CAPTURE(a, b, r);
    CHECK(r * b >= 0.0);
    // a - b floor(a/b): the product is rounded
    CHECK(std::abs(r) <= std::abs(b) + std::numeric_limits<double>::epsilon() * std::abs(a));
  }
}

TEST_CASE("powers bind tightest, go from right to left, and are exact for integers") {
  World w;
  CHECK(w.value("-2^2") == -4.0);
  CHECK(w.value("2^3^2") == 512.0);
  CHECK(w.value("2^-1") == 0.5);
  CHECK(w.value("(-2)^3") == -8.0);
  CHECK(w.value("(-3)^4") == 81.0);
  CHECK(w.value("x^5", {0.0, -7.0}) == -16807.0);
  CHECK(w.value("2^-x^2*3", {0.0, 2.0}) == 3.0 / 16.0);
  CHECK(std::isnan(w.value("x^0.5", {0.0, -4.0})));
  CHECK(w.value("0^0") == 1.0);
  CHECK(std::isinf(w.value("0^-1")));
}

TEST_CASE("operators associate and bind as in writing") {
  World w;
  const std::vector<double> v{0.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0};
  CHECK(w.value("x - y - z", v) == -5.0);
  CHECK(w.value("x/y/z", v) == 2.0 / 3.0 / 4.0);
  CHECK(w.value("x + y*z^x", v) == 50.0);
  CHECK(w.value("x--y", v) == 5.0);
  CHECK(w.value("x*-y", v) == -6.0);
  CHECK(w.value("-x*y", v) == -6.0);
  CHECK(w.value("tf.1.e*t + packet.wall.q", v) == 8.0);
  CHECK(w.value("1e-3*.5 + 2.E+1", v) == 20.0005);
  CHECK(w.value("if(not x < y or x > 0 and y == 3, 1, 2)", v) == 1.0);
  CHECK(w.value(" ( (pi) ) ", v) == std::numbers::pi);
}

TEST_CASE("a fault is not hidden: not in min or max, comparisons, powers, or by folding constants") {
  CHECK(std::isnan(apply(Op::min, kNaN, 1.0)));
  CHECK(std::isnan(apply(Op::max, 1.0, kNaN)));
  CHECK(std::isnan(apply(Op::lt, kNaN, 1.0)));
  CHECK(std::isnan(apply(Op::ne, kNaN, 1.0)));
  CHECK(std::isnan(apply(Op::pow, kNaN, 0.0)));
  CHECK(std::isnan(apply(Op::sign, kNaN)));
  CHECK(std::isnan(apply(Op::step, kNaN)));
  CHECK(std::isnan(apply(Op::select, kNaN, 1.0, 1.0)));
  CHECK(std::isnan(apply(Op::logical_not, kNaN)));
  CHECK(std::isnan(apply(Op::logical_and, kNaN, 1.0)));
  CHECK(apply(Op::logical_and, 0.0, kNaN) == 0.0);
  CHECK(apply(Op::logical_or, kNaN, 1.0) == 1.0);
  CHECK(std::isnan(apply(Op::logical_or, kNaN, 0.0)));
  World w;
  for (const char* text : {"log(-1)", "sqrt(-2)", "1/0", "0/0", "asin(2)", "acosh(0.5)", "atanh(2)", "atanh(1)",
                           "log1p(-1)", "log1p(-2)", "mod(1, 0)", "mod(0, 0)", "(-8)^(1/3)", "exp(1000)"}) {
    CAPTURE(text);
    const ExprId e = w.parse(text);
    CHECK_FALSE(w.pool.is_constant(e));
    CHECK_FALSE(std::isfinite(w.value(e, {})));
    CHECK(w.text(e).find_first_of("(/") != std::string::npos);
  }
}

TEST_CASE("equal meanings are one expression") {
  World w;
  const std::vector<std::pair<const char*, const char*>> equal{
      {"x*y", "y*x"},
      {"x + y", "y + x"},
      {"x + 0", "x"},
      {"x - 0", "x"},
      {"0 - x", "-x"},
      {"x*1", "x"},
      {"0*x", "0"},
      {"x/1", "x"},
      {"0/x", "0"},
      {"--x", "x"},
      {"x - x", "0"},
      {"x^1", "x"},
      {"x^0", "1"},
      {"x + -y", "x - y"},
      {"-x + y", "y - x"},
      {"-x*y", "-(x*y)"},
      {"x*-y", "-(x*y)"},
      {"-x/y", "-(x/y)"},
      {"x/-y", "-(x/y)"},
      {"-x/-y", "x/y"},
      {"2*(3*x)", "6*x"},
      {"x*2*y*3", "6*(x*y)"},
      {"x + x", "2*x"},
      {"x - -2*y", "x + 2*y"},
      {"x + -2*y", "x - 2*y"},
      {"-(x - y)", "y - x"},
      {"if(1 < 2, x, y)", "x"},
      {"if(x < y, z, z)", "z"},
      {"if(not x < y, x, z)", "if(x < y, z, x)"},
      {"exp(log(x))", "x"},
      {"exp(log(x) + y)", "x*exp(y)"},
      {"exp(y - log(x))", "exp(y)/x"},
      {"min(x, x)", "x"},
      {"abs(-x)", "abs(x)"},
      {"if(x < y and 1 < 2, x, y)", "if(x < y, x, y)"},
      {"if(x < y or 1 < 2, x, y)", "x"},
      {"max(y, x)", "max(x, y)"},
      {"2*pi - 2*pi", "0"},
      {"der(3)", "0"},
  };
  for (const auto& [left, right] : equal) {
    CAPTURE(left, right);
    CHECK(w.parse(left) == w.parse(right));
  }
  CHECK(w.parse("x/x") != w.parse("1"));        // 0/0 is a fault
  CHECK(w.parse("sqrt(x)^2") != w.parse("x"));  // so is sqrt(-1)
  CHECK(w.parse("x/y") != w.parse("y/x"));
  CHECK(w.parse("if(x < y, 1, 2)") != w.parse("if(y < x, 1, 2)"));
}

TEST_CASE("substitution and translation replace symbols and keep the rest") {
  World w;
  const ExprId law = w.parse("x^2*y + sin(x)/table('data.csv', 'u', z)");
  const ExprId there = substitute(w.pool, law, {{w.id("x"), w.parse("2*z")}});
  CHECK(there == w.parse("(2*z)^2*y + sin(2*z)/table('data.csv', 'u', z)"));
  CHECK(substitute(w.pool, law, {{w.id("t"), w.parse("1")}}) == law);

  World other;
  const ExprId rate = other.symbol("R_b");
  bgsim::Translator translate(
      w.pool, other.pool, [&](bgsim::SymbolId s) { return other.pool.symbol(s); }, [&](ExprId) { return rate; });
  const ExprId image = translate(w.parse("x^2*y + sin(x)/table('data.csv', 'u', z) + der(x*y)"));
  CHECK(image == other.parse("x^2*y + sin(x)/table('data.csv', 'u', z) + R_b"));
  CHECK(other.pool.tables().size() == 2);
}

TEST_CASE("a chain of a hundred thousand operators is no trouble for any of the algorithms", "[long]") {
  World w;
  const ExprId x = w.symbol("x"), y = w.symbol("y");
  ExprId chain = x;
  for (int i = 0; i < 100000; ++i)
    chain = w.pool.make(i % 2 == 0 ? Op::add : Op::sub, chain, i % 3 == 0 ? y : w.symbol("z"));
  CHECK(w.value(chain, std::vector<double>{0, 1, 2, 3}) == Approx(1.0).margin(10.0));
  CHECK(w.pool.is_constant(w.derivative(chain, "x"), 1.0));
  const auto inverse = invert(w.pool, chain, w.id("x"), w.symbol("R_b"));
  REQUIRE(inverse);
  std::vector<double> v{0, 1.25, 2, 3, 0, 0, 0};
  v[6] = w.value(chain, v);
  CHECK(w.value(*inverse, v) == bgsim::test::same_to_rounding(1.25, 100000));
  const ExprId copy = substitute(w.pool, chain, {{w.id("x"), w.symbol("t")}});
  CHECK(symbols_in(w.pool, {&copy, 1}).size() == 3);
  bgsim::ExprPool target;
  bgsim::Translator translate(w.pool, target, [&](bgsim::SymbolId s) { return target.symbol(s); });
  CHECK(evaluate(target, translate(chain), v) == bgsim::test::same_to_rounding(v[6]));

  ExprId deep = x;
  for (int i = 0; i < 100000; ++i) deep = w.pool.make(Op::sin, deep);
  CHECK(std::isfinite(w.value(w.derivative(deep, "x"), std::vector<double>{0, 1})));
  CHECK_THROWS_AS(w.latex(chain), std::length_error);
}

TEST_CASE("hypot and ssqrt are right to an ulp or two over the whole range of numbers") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> mantissa(1.0, 2.0), exponent(-540.0, 500.0), apart(-30.0, 30.0);
  double worst = 0.0, worst_root = 0.0;
  for (int i = 0; i < 200000; ++i) {
    const double order = std::floor(exponent(random));
    const double a = std::ldexp(mantissa(random), static_cast<int>(order));
    const double b = std::ldexp(mantissa(random), static_cast<int>(order + std::floor(apart(random))));
    // Exponents of long double go far beyond the squares.
    const long double exact = std::sqrt(static_cast<long double>(a) * a + static_cast<long double>(b) * b);
    worst = std::max(worst, std::abs(static_cast<double>((apply(Op::hypot, a, b) - exact) / exact)));
    const long double root = a / std::sqrt(exact);
    worst_root = std::max(worst_root, std::abs(static_cast<double>((apply(Op::ssqrt, a, b) - root) / root)));
  }
  // An ulp is at most 2.2e-16 of a number. The sum of squares is off by one at most, its root by half of that and half
  // an ulp of its own.
  CHECK(worst < 2.3e-16);
  // Half of that again, and half an ulp each for a root and a division.
  CHECK(worst_root < 3.4e-16);
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  CHECK(apply(Op::hypot, 0.0, 0.0) == 0.0);
  CHECK(apply(Op::hypot, 3e200, 4e200) == Approx(5e200).epsilon(4e-16));
  CHECK(apply(Op::hypot, 3e-200, 4e-200) == Approx(5e-200).epsilon(4e-16));
  CHECK(apply(Op::hypot, kInfinite, 1.0) == kInfinite);
  CHECK(std::isnan(apply(Op::hypot, std::numeric_limits<double>::quiet_NaN(), 1.0)));
}
