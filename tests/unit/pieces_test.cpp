// Laws with kinks: which are one to one, and what their inverses are.
#include "expression/pieces.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <utility>

#include "expression/signed_power.hpp"
#include "support/approx.hpp"
#include "support/expression_world.hpp"

using namespace bgsim;
using bgsim::test::World;

namespace {

/// y = 1.25 and z = 3.5; all else varies but what is looked at.
NumberOf numbers(const World& w) {
  const SymbolId y = w.id("y"), z = w.id("z");
  return [y, z](SymbolId s) { return s == y ? 1.25 : s == z ? 3.5 : std::nan(""); };
}

}  // namespace

TEST_CASE("laws with kinks that are continuous and strictly monotone are inverted part by part") {
  World w;
  for (const char* text :
       {"if(x > 0, x/y, x/z)", "if(x < 0, 2*x, 1e7*x)", "if(-x < 2, y*x, -((-x - 2)/z + y*2))",
        "if(x >= y, 3*x - 3*y, x - y)", "max(x, 0)/y + min(x, 0)/z", "min(x, 2*x) - z", "abs(x) + 2*x", "-y*x*abs(x)",
        "x*abs(x)^0.75/y", "x*sqrt(abs(x))", "if(x > 0, y*sqrt(x), -y*sqrt(-x))", "if(x > 0, exp(x/y) - 1, x/y)",
        "if(abs(x) < 1, x, 2*x - sign(x))", "(if(x > 0, x, x/1000) + y)*z", "sinh(if(x > 0.5, x, 0.25 + x/2))",
        "if(x > 1, 4*x - 2, if(x > -1, 2*x, x - 1))"}) {
    CAPTURE(text);
    const PieceInverse inverse = invert_in_pieces(w.pool, w.parse(text), w.id("x"), w.symbol("R_b"), numbers(w));
    CHECK(inverse.monotone);
    REQUIRE(inverse.solution.valid());
    for (const double x : {-3.1, -1.3, -0.4, 0.2, 0.9, 1.7}) {
      std::vector<double> v{0.0, x, 1.25, 3.5, 0.0, 0.0, 0.0};
      v[6] = w.value(w.parse(text), v);
      CAPTURE(x, w.text(inverse.solution));
      CHECK(w.value(inverse.solution, v) == Approx(x).epsilon(1e-12));  // a few roundings, and a root
    }
  }
}

TEST_CASE("powers that keep the sign are solved whole, without conditions, and so are sums of one degree") {
  World w;
  for (const char* text : {"-y*x*abs(x)", "x*abs(x)^0.75/y", "x*sqrt(abs(x))", "z*sign(x)*abs(x)^1.75", "y + x*abs(x)",
                           "(z - y*x*abs(x) - x*abs(x))/y - y*(z - sign(x)*x^2)", "3*x - (y - x)"}) {
    CAPTURE(text);
    const auto law = offset_power(w.pool, w.parse(text), w.id("x"));
    REQUIRE(law);
    const ExprId solution = solution_of(w.pool, *law, w.symbol("R_b"));
    for (const double x : {-3.1, -0.4, 0.0, 0.2, 1.7}) {
      std::vector<double> v{0.0, x, 1.25, 3.5, 0.0, 0.0, 0.0};
      v[6] = w.value(w.parse(text), v);
      CAPTURE(x, w.text(solution));
      // A few roundings, of terms that cancel at 0, and a root.
      CHECK(std::abs(w.value(solution, v) - x) < (x == 0.0 ? 1e-7 : 1e-12 * std::abs(x)));
    }
  }
  for (const char* text : {"x^2", "x*abs(x) + x", "x/y + y/x", "x*(y - x)", "abs(x)*x^2", "y"}) {
    CAPTURE(text);
    CHECK_FALSE(offset_power(w.pool, w.parse(text), w.id("x")));
  }
}

TEST_CASE("a law with kinks that is one to one may have no closed form, or contain what varies") {
  World w;
  for (const char* text :
       {"if(x > 0, x + x^3, x)", "x + x*abs(x)", "z*(x - y)*abs(x - y)", "if(x > 0, x + sin(x)/2, x)"}) {
    CAPTURE(text);
    const PieceInverse inverse = invert_in_pieces(w.pool, w.parse(text), w.id("x"), w.symbol("R_b"), numbers(w));
    CHECK(inverse.monotone);
    CHECK_FALSE(inverse.solution.valid());
  }
  const auto nothing = [](SymbolId) { return std::nan(""); };
  for (const char* text : {"if(x > 0, x/y, x/z)", "y*max(x, 0) + z*min(x, 0)"}) {
    CAPTURE(text);
    const PieceInverse inverse = invert_in_pieces(w.pool, w.parse(text), w.id("x"), w.symbol("R_b"), nothing);
    CHECK(inverse.monotone);
    CHECK_FALSE(inverse.solution.valid());
  }
  // What varies outside of the kinks is no hindrance.
  CHECK(invert_in_pieces(w.pool, w.parse("y*if(x > 0, x, x/9)"), w.id("x"), w.symbol("R_b"), nothing).solution.valid());
}

TEST_CASE("laws that jump, turn back, or are level somewhere are not one to one") {
  World w;
  for (const char* text :
       {"abs(x)", "max(x, 0)", "min(x, y)", "if(x > 0, x, -x)", "if(x > 0, x + 1, x)", "sign(x) + x",
        "if(x > 1, x, 2*x)", "x - 2*abs(x)", "floor(x) + x", "if(x > 0, x, 0)", "if(x > 0, sin(x), x)", "x*abs(x) - x",
        "if(x > 0, x/y, -x/z)", "sqrt(max(x, -1))", "if(x > 1, sqrt(x), sqrt(x))*abs(x)"}) {
    CAPTURE(text);
    const PieceInverse inverse = invert_in_pieces(w.pool, w.parse(text), w.id("x"), w.symbol("R_b"), numbers(w));
    CHECK_FALSE(inverse.monotone);
    CHECK_FALSE(inverse.solution.valid());
  }
}

TEST_CASE("tables that rise or fall are inverted where they are linear, within their data") {
  World w;
  Table table;
  table.file = "measured.csv";
  table.column = "u";
  table.x = {-4.0, -1.0, 0.5, 2.0, 5.0};
  table.y = {-7.0, -6.5, -1.0, 0.25, 9.0};
  const auto look = [&](const Table& data, const std::function<ExprId(ExprId)>& law) {
    const TableId id = w.pool.add_table(data);
    const ExprId x = w.symbol("x"), read = w.pool.table(Op::table, w.pool.mul(x, w.symbol("y")), id);
    return std::pair(law(read), invert_in_pieces(w.pool, law(read), w.id("x"), w.symbol("R_b"), numbers(w)));
  };
  const auto alone = [](ExprId read) { return read; };
  Table falling = table, inverse = table, level = table, turning = table, spline = table, over = table;
  for (double& y : falling.y) y = -y;
  std::swap(inverse.x, inverse.y);
  inverse.inverse = true;
  level.y[2] = level.y[1];
  turning.y[2] = -8.0;
  spline.interpolation = over.interpolation = Interpolation::spline;
  spline.y = {-8.0, -1.1, 0.5, 2.8, 17.5};  // a little more than x, and x^3/10
  over.y = {-7.0, -6.9, -6.8, 9.0, 9.1};    // rises from point to point, and swings between them

  for (const Table* data : {&table, &falling, &inverse}) {
    const auto [law, found] = look(*data, alone);
    CHECK(found.monotone);
    REQUIRE(found.solution.valid());
    const double least = data->x.front() / 1.25, most = data->x.back() / 1.25;  // y = 1.25
    for (const double x : {least, 0.7 * least, 0.0, 0.3 * most, most}) {
      std::vector<double> v{0.0, x, 1.25, 3.5, 0.0, 0.0, 0.0};
      v[6] = w.value(law, v);
      CAPTURE(x, v[6], w.text(found.solution));
      CHECK(w.value(found.solution, v) == Approx(x).epsilon(1e-12).margin(1e-15));  // a few roundings
    }
    std::vector<double> beyond{0.0, 0.0, 1.25, 3.5, 0.0, 0.0, 50.0};
    CHECK(std::isnan(w.value(found.solution, beyond)));
  }
  // In a sum with what rises, too, or as a spline: one to one, without a closed form.
  const auto beside = [&](ExprId read) { return w.pool.add(read, w.pool.mul(w.symbol("x"), w.symbol("z"))); };
  for (const auto& found : {look(table, beside).second, look(spline, alone).second}) {
    CHECK(found.monotone);
    CHECK_FALSE(found.solution.valid());
  }
  for (const Table* data : {&level, &turning, &over}) CHECK_FALSE(look(*data, alone).second.monotone);
}
