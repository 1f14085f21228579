#include <catch2/catch.hpp>
#include <stdexcept>

#include "support/expression_world.hpp"
#include "support/rounds.hpp"

using bgsim::ExprId;
using bgsim::Op;
using bgsim::test::RandomExpressions;
using bgsim::test::World;

TEST_CASE("what is written reads back as the same expression") {
  World world;
  for (unsigned seed = 0; seed < bgsim::test::share_of(20); ++seed) {
    RandomExpressions random(world, seed);
    for (int i = 0; i < 500; ++i) {
      const ExprId e = random.number(1 + i % 40);
      const std::string text = world.text(e);
      CAPTURE(seed, i, text);
      const ExprId back = world.parse(text);
      INFO(world.text(back));
      REQUIRE(back == e);
    }
  }
}

TEST_CASE("text has the parentheses it needs and no others") {
  World w;
  for (const char* text : {"x + y - z",
                           "x - (y - z)",
                           "x - (y + z)",
                           "x*y/z",
                           "x/(y*z)",
                           "x/y/z",
                           "-x^2",
                           "(-x)^2",
                           "x^y^z",
                           "(x^y)^z",
                           "x^-y",
                           "2*x*y",
                           "-x*y",
                           "x^(y*z)",
                           "(x + y)*z",
                           "-(x + y)",
                           "x/(-2 - y)",
                           "1e-05*x",
                           "x < y",
                           "if(x < y and y < z, x, y)",
                           "if(x < y and (y < z or z > 1), x, y)",
                           "if(not (x < y and y < z), 1, 2)",
                           "min(x, y)",
                           "der(x + y)",
                           "table(\"data.csv\", \"u\", t)",
                           "table(\"data.csv\", \"u\", t, spline)",
                           "packet.wall.q + tf.1.e",
                           "x - y - 1"}) {
    CAPTURE(text);
    if (std::string(text) == "x < y") continue;
    // "if(not (a), 1, 2)" is stored as "if(a, 2, 1)"
    const std::string expected = std::string(text).rfind("if(not", 0) == 0 ? "if(x < y and y < z, 2, 1)" : text;
    CHECK(w.text(w.parse(text)) == expected);
  }
}

TEST_CASE("a sum of a hundred thousand terms is parsed and evaluated without deep recursion", "[long]") {
  World w;
  std::string text = "x";
  for (int i = 1; i < 100000; ++i) text += i % 2 == 0 ? " + sin(x)" : " - y*x";
  const ExprId sum = w.parse(text);
  const double expected = 0.5 + 49999 * std::sin(0.5) - 50000 * 0.25;
  CHECK(w.value(sum, std::vector<double>{0.0, 0.5, 0.5}) == Approx(expected).epsilon(1e-9));
  CHECK_THROWS_AS(w.text(sum), std::length_error);
  std::string shorter = "x";
  for (int i = 1; i < 20000; ++i) shorter += " + y^" + std::to_string(i);
  CHECK(w.text(w.parse(shorter)) == "x + y" + shorter.substr(std::string("x + y^1").size()));
}

TEST_CASE("an expression that shares much is refused as text, not written for ever") {
  World w;
  ExprId e = w.symbol("x");
  for (int i = 0; i < 200; ++i) e = w.pool.make(Op::hypot, w.pool.make(Op::sin, e), e);
  CHECK_THROWS_AS(w.text(e), std::length_error);
  CHECK_THROWS_AS(w.latex(e), std::length_error);
  CHECK(bgsim::readable_text(w.pool, e, [](bgsim::SymbolId) { return std::string("x"); }) == "(too long to print)");
}

TEST_CASE("LaTeX has fractions, roots, cases, indices and Greek letters") {
  World w;
  w.names = {"t", "x", "omega", "x_ref", "packet.wall.q", "C2", "R_b"};
  const auto latex = [&](const char* text) { return w.latex(w.parse(text)); };
  CHECK(latex("x/C2") == "\\frac{x}{C_{2}}");
  CHECK(latex("R_b*(x_ref - x)") == "R_{b} \\, \\left(x_{\\mathrm{ref}} - x\\right)");
  CHECK(latex("sqrt(1 + omega^2)") == "\\sqrt{\\omega^{2} + 1}");
  CHECK(latex("(x + 1)^2") == "\\left(x + 1\\right)^{2}");
  CHECK(latex("packet.wall.q") == "q_{\\mathrm{packet.wall}}");
  CHECK(latex("der(x)*2") == "2 \\, \\dot{x}");
  CHECK(latex("if(x < 0, 1e-5, abs(x))") ==
        "\\begin{cases} 10^{-5} & \\text{if } x < 0 \\\\ \\left|x\\right| & \\text{otherwise} \\end{cases}");
  CHECK(latex("ssqrt(x, omega)*1.5e-7") == "1.5 \\cdot 10^{-7} \\, \\operatorname{ssqrt}\\left(x, \\omega\\right)");
  CHECK(latex("table('data.csv', 'u', t)") == "u\\left(t\\right)");
}

TEST_CASE("MathML has the same layout as LaTeX, in the terms of the outermost sum") {
  World w;
  w.names.insert(w.names.end(), {"C2", "x_ref", "omega", "a<b"});
  const auto terms = [&](const char* text) { return w.mathml(w.parse(text)); };
  const auto one = [&](const char* text) {
    const std::vector<std::string> all = terms(text);
    return all.size() == 1 ? all.front() : "not one term";
  };
  using Terms = std::vector<std::string>;
  CHECK(one("x/C2") ==
        "<mrow><mfrac><mrow><mi>x</mi></mrow><mrow><msub><mi>C</mi><mrow><mn>2</mn></mrow></msub></mrow>"
        "</mfrac></mrow>");
  CHECK(terms("x - omega + 2") == Terms{"<mrow><mi>x</mi></mrow>",
                                        "<mrow><mo form=\"infix\">\u2212</mo><mi>\u03c9</mi></mrow>",
                                        "<mrow><mo form=\"infix\">+</mo><mn>2</mn></mrow>"});
  CHECK(one("sqrt(1 + omega^2)") ==
        "<mrow><msqrt><msup><mrow><mi>\u03c9</mi></mrow><mrow><mn>2</mn></mrow></msup>"
        "<mo form=\"infix\">+</mo><mn>1</mn></msqrt></mrow>");
  CHECK(one("(x + 1)^2") ==
        "<mrow><msup><mrow><mrow><mo>(</mo><mi>x</mi><mo form=\"infix\">+</mo><mn>1</mn><mo>)</mo>"
        "</mrow></mrow><mrow><mn>2</mn></mrow></msup></mrow>");
  CHECK(one("der(packet.wall.q)*2") ==
        "<mrow><mn>2</mn><mo>\u2062</mo><mspace width=\"0.17em\"/><msub><mover accent=\"true\"><mi>q</mi>"
        "<mo>\u02d9</mo></mover><mrow><mi>packet.wall</mi></mrow></msub></mrow>");
  CHECK(one("-1.5e-7*x") ==
        "<mrow><mrow><mrow><mo form=\"prefix\">\u2212</mo><mn>1.5</mn></mrow><mo>\u00b7</mo><msup><mn>10</mn>"
        "<mrow><mo form=\"prefix\">\u2212</mo><mn>7</mn></mrow></msup></mrow><mo>\u2062</mo><mspace width=\"0.17em\"/>"
        "<mi>x</mi></mrow>");
  CHECK(
      one("if(x < 0, 1, x)") ==
      "<mrow><mrow><mo form=\"prefix\" stretchy=\"true\">{</mo><mtable class=\"cases\"><mtr><mtd><mn>1</mn></mtd><mtd>"
      "<mtext>if\u00a0</mtext><mi>x</mi><mo>&lt;</mo><mn>0</mn></mtd></mtr><mtr><mtd><mi>x</mi></mtd><mtd>"
      "<mtext>otherwise</mtext></mtd></mtr></mtable></mrow></mrow>");
  CHECK(w.mathml(w.symbol("a<b")) == Terms{"<mrow><mi>a&lt;b</mi></mrow>"});  // names are text, never markup
}

TEST_CASE("elements of MathML are closed in order, whatever is written") {
  World w;
  RandomExpressions random(w, 7);
  for (int i = 0; i < 100; ++i) {
    for (const std::string& term : w.mathml(random.number(12))) {
      std::vector<std::string> open;
      for (std::size_t at = term.find('<'); at != std::string::npos; at = term.find('<', at + 1)) {
        const std::string tag = term.substr(at + 1, term.find('>', at) - at - 1);
        if (tag.front() == '/') {
          REQUIRE(!open.empty());
          REQUIRE(tag.substr(1) == open.back());
          open.pop_back();
        } else if (tag.back() != '/') {
          open.push_back(tag.substr(0, tag.find(' ')));
        }
      }
      CHECK(open.empty());
    }
  }
}
