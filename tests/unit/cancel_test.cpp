#include "expression/cancel.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>

#include "support/expression_world.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

struct Cancelling : World {
  std::string of(const std::string& expression) { return text(Canceller(pool)(parse(expression))); }
};

/// Operators of the expression written out in full.
double operators(const ExprPool& pool, ExprId root) {
  std::map<ExprId, double> count;
  for (const ExprId e : reachable(pool, std::array{root})) {
    const ExprNode& node = pool[e];
    double& own = count[e];
    own = arity(node.op) > 0 ? 1.0 : 0.0;
    const std::uint32_t children[] = {node.a, node.b, node.c};
    for (int k = 0; k < arity(node.op); ++k) own += count[ExprId(children[k])];
  }
  return count[root];
}

}  // namespace

TEST_CASE("numbers and factors that stand above and below the line cancel") {
  Cancelling w;
  CHECK(w.of("2*(1/(2*z)*(x - y))") == "(x - y)/z");
  CHECK(w.of("x*y/x") == "y");
  CHECK(w.of("x^3*y/x^2") == "x*y");
  CHECK(w.of("x/(2*y)*2*y") == "x");
  CHECK(w.of("(x/2)*(y/2)") == "x*y/4");
  CHECK(w.of("-x/(2*z)*2") == "-x/z");
  CHECK(w.of("1/(2*x)*2") == "1/x");
  CHECK(w.of("sin(2*x/(2*z))*y") == "y*sin(x/z)");
}

TEST_CASE("where nothing cancels an expression stays as it is") {
  Cancelling w;
  for (const char* text : {"x*y*z", "x/y/z", "(x - y) - (y - z)", "x*x*x", "2*x/(3*y)", "(x + y)*(x - y)", "x^2*y",
                           "(x*y)^3", "if(x > y, 2*x, y)", "x*(y/z)"}) {
    const ExprId before = w.parse(text);
    CHECK(Canceller(w.pool)(before) == before);
  }
  // The sixth power of a product of 1e-60 and 1e80 is a number, those of its factors are not.
  CHECK(w.of("(x*y)^6/x") == w.text(w.parse("(x*y)^6/x")));
}

TEST_CASE("cancelling keeps the value and never costs an operator") {
  World w;
  RandomExpressions random(w, 11, true);
  std::mt19937_64 numbers(3);
  std::size_t shorter = 0, compared = 0;
  for (int i = 0; i < 2000; ++i) {
    const ExprId before = random.number(12);
    const ExprId after = Canceller(w.pool)(before);
    REQUIRE(operators(w.pool, after) <= operators(w.pool, before));
    shorter += operators(w.pool, after) < operators(w.pool, before) ? 1U : 0U;
    std::vector<double> values(w.names.size());
    for (double& value : values) value = 0.5 + static_cast<double>(numbers() % 1000) * 1e-3;
    const double a = evaluate(w.pool, before, values), b = evaluate(w.pool, after, values);
    if (!std::isfinite(a) || std::abs(a) > 1e6) continue;
    ++compared;
    INFO(w.text(before) << " is " << a << "; " << w.text(after) << " is " << b);
    // Twelve operators, each good to 1e-16; a difference of two of them may lose a thousand times that.
    CHECK(std::abs(a - b) <= 1e-12 * std::max(1.0, std::abs(a)));
  }
  CHECK(shorter > 20);
  CHECK(compared > 500);
}

TEST_CASE("the short gradient is the gradient, written with less") {
  World w;
  const auto all = [](SymbolId) { return true; };
  for (const char* energy : {"(x - y)^2/(2*z)", "x^2/(2*z) + y*x/z", "x*log(x/y) - x", "z*x^4/4 + x^2*y^2/2",
                             "sqrt(x^2 + y^2)*z", "(x^3/3 - y*x)/z"}) {
    INFO(energy);
    const ExprId root = w.parse(energy);
    const auto plain = gradient(w.pool, root, all), brief = short_gradient(w.pool, root, all);
    REQUIRE(plain.size() == brief.size());
    const std::vector<double> values{0.1, 1.3, 0.7, 2.1, 1.0, 1.0, 1.0};
    for (std::size_t i = 0; i < plain.size(); ++i) {
      CHECK(plain[i].first == brief[i].first);
      // Two forms of one number, of a few operations each.
      CHECK(evaluate(w.pool, brief[i].second, values) ==
            Approx(evaluate(w.pool, plain[i].second, values)).epsilon(1e-14));
      CHECK(operators(w.pool, brief[i].second) <= operators(w.pool, plain[i].second));
    }
  }
  const ExprId root = w.parse("(x - y)^2/(2*z)");
  const auto brief = short_gradient(w.pool, root, [&](SymbolId s) { return s == w.id("x") || s == w.id("y"); });
  CHECK(w.text(brief[0].second) == "(x - y)/z");
  CHECK(w.text(brief[1].second) == "-((x - y)/z)");
}
