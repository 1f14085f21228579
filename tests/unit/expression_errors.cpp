#include <catch2/catch.hpp>

#include "expression/text_form.hpp"
#include "support/expression_world.hpp"

using bgsim::ExpressionError;
using bgsim::test::World;

namespace {

/// "CODE [faulty text] message; help"
std::string fault(const std::string& text) {
  World w;
  try {
    w.parse(text);
  } catch (const ExpressionError& e) {
    const std::string help = e.help.empty() ? "" : "; " + e.help;
    return e.code + " [" + text.substr(e.begin, e.end - e.begin) + "] " + e.what() + help;
  }
  return "none";
}

}  // namespace

TEST_CASE("errors of syntax are shown where they are, with a fix") {
  CHECK(fault("") == "BG120 [] the expression is empty; write a number or an expression");
  CHECK(fault("x +") == "BG120 [] a number, a name or \"(\" is expected here, not the end of the text");
  CHECK(fault("x * / y") == "BG120 [/] a number, a name or \"(\" is expected here, not \"/\"");
  CHECK(fault("(x + y") == "BG120 [(] this parenthesis is not closed; add \")\"");
  CHECK(fault("sin(x") == "BG120 [sin] this parenthesis is not closed; add \")\"");
  CHECK(fault("x + y)") == "BG120 [)] \")\" without \"(\"; take it out, or open a parenthesis before it");
  CHECK(fault("2x") == "BG120 [2x] no operator between 2 and x; write 2*x if a product is meant");
  CHECK(fault("x y") == "BG120 [y] an operator is expected here, not \"y\"; write * if a product is meant");
  CHECK(fault("(x)(y)") == "BG120 [(] an operator is expected here, not \"(\"; write * if a product is meant");
  CHECK(fault("x ** 2") == "BG120 [**] unknown operator \"**\"; write ^ for a power");
  CHECK(fault("+x") == "BG120 [+] \"+\" before a value; remove it: only the minus sign may be used alone");
  CHECK(fault("if(x < y < z, 1, 2)") ==
        "BG120 [< y <] comparisons cannot be chained; join two comparisons with and: a < b and b < c");
  CHECK(fault("if(x = y, 1, 2)") ==
        "BG120 [=] \"=\" is not part of the language; write == to compare; a value is the right side of an equation "
        "alone");
  CHECK(fault("if(x > 1 && y > 1, 1, 2)") == "BG120 [&&] \"&&\" is not part of the language; write and");
  CHECK(fault("if(!x, 1, 2)") == "BG120 [!] \"!\" is not part of the language; write not");
  CHECK(fault("1,5") == "BG120 [,] a comma outside a function's arguments; the decimal sign is a point");
  CHECK(fault("x × y") == "BG120 [×] \"×\" is not part of the language; write *");
  CHECK(fault("sin") == "BG120 [sin] sin is a function and needs arguments; write sin(x)");
  CHECK(fault("table('data.csv") == "BG120 ['data.csv] this text is not closed; add '");
  CHECK(fault("'x' + 1") == "BG120 ['x'] a text is allowed only in table(...) and mode(...)");
}

TEST_CASE("unknown names and functions come with the nearest known one") {
  CHECK(fault("packet.wal.q") == "BG121 [packet.wal.q] unknown name \"packet.wal.q\"; did you mean \"packet.wall.q\"?");
  CHECK(fault("R_B*x") == "BG121 [R_B] unknown name \"R_B\"; did you mean \"R_b\"?");
  CHECK(fault("1 + something_else") == "BG121 [something_else] unknown name \"something_else\"");
  CHECK(fault("sine(x)") == "BG121 [sine] unknown function sine(...); did you mean sin?");
  CHECK(fault("x*y(z)") == "BG121 [y] unknown function y(...); if a product is meant, write y*(...)");
}

TEST_CASE("wrong arguments, numbers out of range and mixed types are distinguished") {
  CHECK(fault("sin(x, y)") == "BG122 [sin(x, y)] sin takes 1 argument, not 2; write sin(x)");
  CHECK(fault("sin()") == "BG122 [sin()] sin takes 1 argument, not 0; write sin(x)");
  CHECK(fault("min(x)") == "BG122 [min(x)] min takes 2 or more arguments, not 1; write min(x, y, ...)");
  CHECK(fault("if(x > 0, 1)") ==
        "BG122 [if(x > 0, 1)] if takes 3 arguments, not 2; write if(condition, then, otherwise)");
  CHECK(fault("table('a', 'b', t, cubic)").substr(0, 12) == "BG121 [cubic");
  CHECK(fault("table('a', 'b', t, 'cubic')") ==
        "BG122 ['cubic'] argument 4 of table is neither linear nor spline; leave it out for linear interpolation");
  CHECK(fault("table(x, 'b', t)") ==
        "BG122 [x] argument 1 of table is a number where a text is meant; write it in quotes");
  CHECK(fault("1 + 1e999") ==
        "BG123 [1e999] the number 1e999 is out of range; numbers go from about 5e-324 to 1.8e308 in magnitude");
  CHECK(fault("1e-999").substr(0, 14) == "BG123 [1e-999]");
  CHECK(fault("0." + std::string(400, '0') + "1").substr(0, 5) == "BG123");
  CHECK(fault("1e-310 + 0e-999 + 0e999") == "none");  // the first is subnormal, the others are 0
  CHECK(
      fault("1 + (x < y)") ==
      "BG124 [(x < y)] the right operand of \"+\" is a condition where a number is meant; if(condition, 1, 0) makes a "
      "number of a condition");
  CHECK(fault("if(x, 1, 2)") ==
        "BG124 [x] argument 1 of if is a number where a condition is meant; compare it, as in x > 0");
  CHECK(fault("if(x and y > 0, 1, 2)") ==
        "BG124 [x] the left operand of \"and\" is a number where a condition is meant; compare it, as in x > 0");
  CHECK(fault("x < y").substr(0, 27) == "BG124 [x < y] the expressio");
  CHECK(fault("-(x < y)").substr(0, 47) == "BG124 [(x < y)] the operand of the minus sign i");
}

TEST_CASE("nesting has a limit, well within what is read without trouble") {
  const auto nested = [](int n) {
    return std::string(static_cast<std::size_t>(n), '(') + "x" + std::string(static_cast<std::size_t>(n), ')');
  };
  CHECK(fault(nested(1000)) == "none");
  CHECK(fault(nested(1001)) ==
        "BG125 [(] parentheses are nested more than 1000 deep; give parts of the expression names as signals");
  CHECK(fault(std::string(100000, '-') + "x") == "none");
  std::string tower = "x";
  for (int i = 0; i < 50000; ++i) tower += "^x";
  CHECK(fault(tower) == "none");
}

TEST_CASE("a law splits at its one equals sign") {
  const auto law = bgsim::split_law("  f = if(e == 0, 1, table('a=b', 'c', e)) ");
  CHECK(law.left == "f");
  CHECK(law.left_begin == 2);
  CHECK(law.right == "if(e == 0, 1, table('a=b', 'c', e))");
  CHECK(law.right_begin == 6);
  CHECK_THROWS_AS(bgsim::split_law("e <= R*f"), ExpressionError);
  CHECK_THROWS_AS(bgsim::split_law("R*f"), ExpressionError);
  CHECK_THROWS_AS(bgsim::split_law("e = R*f = 3"), ExpressionError);
}

namespace {

/// The text that is said to leave something out, and what: "TEXT: LOST", one after the other.
std::string left_out(const std::string& text) {
  World w;
  std::string found;
  bgsim::ExpressionScope scope = w.scope();
  scope.leaves_out = [&](std::size_t begin, std::size_t end, bgsim::ExprId, bgsim::ExprId lost) {
    found += (found.empty() ? "" : "; ") + text.substr(begin, end - begin) + ": " + w.text(lost);
  };
  parse_expression(text, w.pool, scope);
  return found;
}

}  // namespace

TEST_CASE("what is left out although it has no value everywhere is found, and nothing else is") {
  CHECK(left_out("0*log(x)") == "0*log(x): log(x)");
  CHECK(left_out("1 + 2*(sqrt(x) - sqrt(x))") == "sqrt(x) - sqrt(x): sqrt(x)");
  CHECK(left_out("exp(log(x))") == "exp(log(x)): log(x)");
  CHECK(left_out("exp(y - log(x))") == "exp(y - log(x)): log(x)");
  CHECK(left_out("asin(x)^0") == "asin(x)^0: asin(x)");
  CHECK(left_out("1^(x/y)") == "1^(x/y): x/y");
  CHECK(left_out("0/x") == "0/x: x");
  CHECK(left_out("0/log(x)") == "0/log(x): log(x)");
  CHECK(left_out("0/(2*x)*y") == "0/(2*x): 2*x");
  CHECK(left_out("0*log(x) + sqrt(y)*0") == "0*log(x): log(x); sqrt(y)*0: sqrt(y)");
  CHECK(left_out("x - x + 0*sin(y) + 0/2 + abs(y)^0*x^2").empty());
  // Written otherwise, with all that may fail.
  for (const char* const text :
       {"-(x/y)*3", "-2*(x/(-y))/4", "3*(2*sqrt(x))*y", "x/(2*y) + x/(2*y)", "-log(x) + y", "if(x > 0, log(x), 0)",
        "2 - sqrt(x)", "max(sqrt(x), sqrt(x))", "abs(-sqrt(x))", "floor(round(1/x))", "if(x > 0, log(x), 0)*0",
        "0*sqrt(abs(x))", "x^0.5*2*3", "y^-1*0.5*4"}) {
    INFO(text);
    CHECK(left_out(text).empty());
  }
}
