// Laws on each side of a border, against the laws themselves.
#include "expression/sides.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"
#include "expression/power_sum.hpp"
#include "expression/signed_power.hpp"
#include "support/expression_world.hpp"

using namespace bgsim;
using bgsim::test::World;

namespace {

/// A random law of x, y and z: conditions, signs, sizes, roots and powers of x and of what is like x.
std::string random_law(std::mt19937& random, int depth) {
  const auto one_of = [&](const auto& list) { return std::string(list[random() % list.size()]); };
  static constexpr std::array kLeaves{"x", "x", "x", "-x", "2*x", "y", "z", "3", "0", "-1.5", "(x - y)", "(y - x)"};
  static constexpr std::array kBinary{"+", "-", "*", "/"};
  static constexpr std::array kUnary{"abs", "sign", "sqrt", "cbrt", "step", "sin", "exp"};
  static constexpr std::array kPowers{"0.5", "0.3", "2", "3", "1.75", "-1", "y", "y - 1", "1/y", "1 - 2*y", "z"};
  static constexpr std::array kTwo{"min", "max"};
  static constexpr std::array kComparisons{"<", "<=", ">", ">="};
  const auto part = [&] { return random_law(random, depth - 1); };
  if (depth == 0) return one_of(kLeaves);
  switch (random() % 7) {
    case 0:
    case 1:
      return "(" + part() + one_of(kBinary) + "(" + part() + "))";
    case 2:
    case 3:
      return one_of(kUnary) + "(" + part() + ")";
    case 4:
      return "(" + part() + ")^" + "(" + one_of(kPowers) + ")";
    case 5:
      return one_of(kTwo) + "(" + part() + ", " + part() + ")";
    default:
      return "if(" + part() + one_of(kComparisons) + part() + ", " + part() + ", " + part() + ")";
  }
}

/// To a few roundings of terms that may cancel; only where the law is a number, since 0 times what is none may be 0.
bool same(double found, double law) {
  return !std::isfinite(law) || std::abs(law) > 1e6 || std::abs(found - law) <= 1e-9 * (1.0 + std::abs(law));
}

}  // namespace

TEST_CASE("a law on each side of a border is the law there, and its powers are") {
  std::mt19937 random(7);
  int decided = 0, powers = 0;
  for (int i = 0; i < 4000; ++i) {
    World w;
    const std::string text = random_law(random, 1 + i % 3);
    CAPTURE(i, text);
    const ExprId law = w.parse(text);
    const Sides sides = sides_of(w.pool, law, w.symbol("x"), w.id("x"));
    const auto value = [&](ExprId e, double x) { return w.value(e, std::vector{0.0, x, 0.7, -1.3, 0.0, 0.0, 0.0}); };
    const auto power_of = [&](const Degree& power) { return value(expression_of(w.pool, power), 0.0); };
    decided += sides.expressions[0] != law || sides.expressions[1] != law ? 1 : 0;
    // 1/0 or 1/-0, or a power that is no number and taken for one above 0
    const bool divides = text.find('/') != std::string::npos || text.find("^(-1)") != std::string::npos ||
                         text.find("^(z)") != std::string::npos || text.find("y - 1)") != std::string::npos ||
                         text.find("2*y)") != std::string::npos;
    if (!divides) CHECK(same(value(sides.at_zero, 0.0), value(law, 0.0)));
    const bool holds = std::all_of(sides.above_zero.begin(), sides.above_zero.end(),
                                   [&](ExprId exponent) { return value(exponent, 0.0) > 0.0; });
    for (const double x : {0.02, 0.9, 3.4})
      for (const std::size_t side : {0U, 1U}) {
        if (!holds) continue;
        const double at = side == 0 ? x : -x;
        CAPTURE(at);
        CHECK(same(value(sides.expressions[side], at), value(law, at)));
        const PowerTerm& term = sides.terms[side].at(sides.expressions[side]);
        if (!term.known()) continue;
        const double offset = term.offset.valid() ? value(term.offset, at) : 0.0;
        CHECK(same(offset + term.sign * value(term.factor, at) * std::pow(x, power_of(term.power)), value(law, at)));
      }
    const auto whole = offset_power(w.pool, law, w.id("x"));
    if (!whole) continue;
    ++powers;
    for (const double x : {-3.4, -0.9, -0.02, 0.0, 0.02, 0.9, 3.4}) {
      const double offset = whole->offset.valid() ? value(whole->offset, x) : 0.0;
      const double power = std::copysign(std::pow(std::abs(x), power_of(whole->power.power)), x);
      CHECK(same(offset + value(whole->power.factor, x) * power, value(law, x)));
    }
  }
  CHECK(decided > 500);
  CHECK(powers > 300);
}

TEST_CASE("a law by the root of a loop's unknown is the law") {
  std::mt19937 random(11);
  int named = 0;
  for (int i = 0; i < 2200; ++i) {
    std::string law = random_law(random, 2 + i % 2);
    for (std::size_t at = law.find('x'); at != std::string::npos; at = law.find('x', at + 1))
      if (law.compare(at == 0 ? 0 : at - 1, 3, "max") != 0 && law.compare(at == 0 ? 0 : at - 1, 3, "exp") != 0)
        law[at] = 'e';
    CAPTURE(i, law);
    try {
      const Study study = Study::from_text(
          R"x({"bgsim": 1, "name": "loop", "parameters": {"y": 0.7, "z": -1.3}, "elements": {"u": {"kind": "Se", "effort": 2},
              "j": {"kind": "1"}, "a": {"kind": "R", "law": "f = )x" +
          law +
          R"x("}, "b": {"kind": "R", "law": "e = f + f^3"}}, "bonds": [{"from": "u", "to": "j"}, {"from": "j", "to": "a"},
              {"from": "j", "to": "b"}], "outputs": {"f": "a.f"}, "scenes": {"s": {"stop": 1}}})x");
      const EquationSystem& system = study.equations();
      const auto symbol = [&](const std::string& name) {
        for (std::size_t k = 0; k < system.symbols.size(); ++k)
          if (system.symbols[k].name == name) return SymbolId(k);
        return SymbolId();
      };
      const SymbolId w = symbol("a.e.root"), e = symbol("a.e"), f = symbol("a.f");
      if (!w.valid()) continue;
      ++named;
      const auto value = [&](SymbolId of, const std::vector<double>& values) {
        return evaluate(system.pool, system.equations[system.symbols[of.index()].index].expression, values);
      };
      World world;
      const ExprId text = world.parse([&] {
        std::string named_x = law;
        for (std::size_t at = named_x.find('e'); at != std::string::npos; at = named_x.find('e', at + 1))
          if (named_x.compare(at, 3, "exp") != 0 && named_x.compare(at == 0 ? 0 : at - 1, 3, "tep") != 0)
            named_x[at] = 'x';
        return named_x;
      }());
      for (const double at : {-1.4, -0.3, -0.01, 0.0, 0.01, 0.3, 1.4}) {
        std::vector<double> values(system.symbols.size(), 0.0);
        values[symbol("y").index()] = 0.7;
        values[symbol("z").index()] = -1.3;
        values[w.index()] = at;
        values[e.index()] = value(e, values);
        CAPTURE(at, values[e.index()]);
        // A root of z e with z < 0 has a value below 0 alone, and none by w at 0.
        if (at == 0.0 && std::isnan(value(f, values))) continue;
        CHECK(same(value(f, values), world.value(text, std::vector{0.0, values[e.index()], 0.7, -1.3, 0.0, 0.0, 0.0})));
      }
    } catch (const ModelError&) {  // a law that jumps, or has no other side
    }
  }
  CHECK(named > 100);
}

TEST_CASE("a law that is a sum of powers on both sides is the same law written with odd ones") {
  const auto written = [](World& w, const std::string& text) {
    const ExprId law = w.parse(text);
    return odd_power_sum(w.pool, law, sides_of(w.pool, law, w.symbol("x"), w.id("x")));
  };
  World w;
  for (const char* text :
       {"x*(3 + abs(x)^0.75)", "sign(x)*(3*abs(x) + abs(x)^1.75)", "if(x > 0, 3*x + x^1.75, 3*x - (-x)^1.75)",
        "if(x >= 0, 1, -1)*abs(x)*(3 + abs(x)^0.75)", "x*(4 + abs(x)^0.75) - x",
        "max(x, 0)*(3 + abs(x)^0.75) + "
        "min(x, 0)*(3 + (-x)^0.75)"})
    CHECK(w.text(written(w, text)) == w.text(written(w, "x*(3 + abs(x)^0.75)")));
  // By parts: both go on beyond 0. A jump, a root, and what is one already: none.
  CHECK(w.pool[written(w, "if(x > 0, 2*x + x^2, x - y*x^2)")].op == Op::select);
  for (const char* text : {"if(x > 0, 1 + 2*x, 2*x - 1)", "x*(1 + abs(x)^-0.5)", "3*x + x*abs(x)^0.75", "sign(x)*x^2",
                           "x*(1 + exp(x))", "x*(1 + abs(x)^y)"})
    CHECK_FALSE(written(w, text).valid());

  std::mt19937 random(11);
  int sums = 0;
  for (int i = 0; i < 20000; ++i) {
    World own;
    const std::string text = i % 2 == 0 ? random_law(random, 2 + i % 3)
                                        : "x*(" + random_law(random, 2) + ") + sign(x)*(" + random_law(random, 2) + ")";
    const ExprId law = own.parse(text), sum = written(own, text);
    if (!sum.valid()) continue;
    ++sums;
    CAPTURE(text, own.text(sum));
    for (const double x : {-2.3, -0.7, -1e-3, 0.0, 1e-3, 0.4, 1.9}) {
      const std::vector<double> at{0.0, x, 0.6, 1.3};
      REQUIRE(same(own.value(sum, at), own.value(law, at)));
    }
  }
  CHECK(sums > 100);  // most random laws are no sums
}
