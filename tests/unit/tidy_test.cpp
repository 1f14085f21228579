#include "expression/write/tidy.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "expression/parse.hpp"

using namespace bgsim;

namespace {

const std::array<std::string, 6> kNames{"k", "m", "n", "x", "y", "z"};  // parameters k, m, n; states x, y, z

std::string name_of_symbol(SymbolId symbol) { return kNames[symbol.index()]; }

ExprId parse(ExprPool& pool, const std::string& text) {
  ExpressionScope scope;
  scope.name = [&](std::string_view name) -> std::optional<ExprId> {
    for (std::size_t i = 0; i < kNames.size(); ++i)
      if (kNames[i] == name) return pool.symbol(SymbolId(i));
    return std::nullopt;
  };
  return parse_expression(text, pool, scope);
}

std::string tidied(const std::string& text) {
  ExprPool pool;
  const ExprId expression = parse(pool, text);
  const std::array<SymbolId, 3> parameters{SymbolId(0), SymbolId(1), SymbolId(2)};
  Tidier tidy(pool, parameters);
  const ExprId result = tidy(expression);
  // Whatever the form, the value is the same up to rounding: a few operations are done in another order.
  const std::array<double, 6> point{1.3, 0.7, 2.1, -0.4, 1.9, 0.2};
  CHECK(evaluate(tidy.pool(), result, point) == Approx(evaluate(pool, expression, point)).epsilon(1e-13).margin(1e-15));
  return to_text(tidy.pool(), result, name_of_symbol);
}

}  // namespace

TEST_CASE("a product shows its number, then parameters, then what varies, over one denominator") {
  CHECK(tidied("x*k*2") == "2*k*x");
  CHECK(tidied("2*(1/(2*k)*x)") == "x/k");
  CHECK(tidied("x/m*k/n") == "k*x/(m*n)");
  CHECK(tidied("x/(1/k)") == "k*x");
  CHECK(tidied("x*x*k") == "k*x^2");
  CHECK(tidied("x/4") == "x/4");
  CHECK(tidied("0.3*x") == "0.3*x");
  CHECK(tidied("-x*-k") == "k*x");
}

TEST_CASE("a sum collects like terms and begins with a positive one") {
  CHECK(tidied("-x + y") == "y - x");
  CHECK(tidied("-(k*x - (y - z))") == "y - z - k*x");
  CHECK(tidied("x + y - x") == "y");
  CHECK(tidied("x + x") == "2*x");
  CHECK(tidied("-x - k*y") == "-(x + k*y)");
  CHECK(tidied("-((x - y)/m)") == "(y - x)/m");
}

TEST_CASE("functions, conditions and powers keep their arguments, tidied") {
  CHECK(tidied("sin(x*k)^2") == "sin(k*x)^2");
  CHECK(tidied("if(x*k > 0, -x + y, x)") == "if(k*x > 0, y - x, x)");
  CHECK(tidied("(y*k)^0.5") == "(k*y)^0.5");
  CHECK(tidied("ssqrt(-x + y, k)") == "ssqrt(y - x, k)");
}
