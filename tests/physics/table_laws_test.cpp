// Laws that are measured, where causality asks for the variable that the table does not give.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "support/circuit.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

std::string read(const std::string& file, const std::string& column, const std::string& at) {
  return "table('" + in_project("tests/data/tables/" + file) + "', '" + column + "', " + at + ")";
}
std::string valve(const std::string& at) { return read("valve.csv", "e", at); }
std::string law(const std::string& text) { return "\"law\": \"" + text + "\""; }

/// A source through what is looked at into a capacitor.
std::string charged(const std::string& part) {
  return circuit({{"s", "Se", "x", "0", R"x("effort": "6*sin(1.7*t)")x"},
                  {"r", "R", "x", "y", part},
                  {"c", "C", "y", "0", "\"capacitance\": 0.4"}},
                 R"("u": "c.e", "f": "r.f")", R"("stop": 8, "samples": 81)");
}

const std::vector<Method> kMethods{Method::automatic, Method::bdf,   Method::radau,
                                   Method::rodas5p,   Method::dirk5, Method::ida};

}  // namespace

TEST_CASE("a linear table that rises is inverted, which is the table with its columns exchanged") {
  const std::string exchanged = law("f = " + read("valve_exchanged.csv", "f", "e"));
  for (const Method method : kMethods) {
    INFO(facts_of(method).name);
    const RunResult as_written = run_text(charged(exchanged), with_method(method));
    const RunResult inverted = run_text(charged(law("e = " + valve("f"))), with_method(method));
    REQUIRE_FALSE(as_written.failure);
    REQUIRE_FALSE(inverted.failure);
    // The program is the same, with the same numbers.
    CHECK(inverted.trace.columns == as_written.trace.columns);
  }
}

TEST_CASE("measured laws are inverted through what stands around the table") {
  // Each is the law e = valve(f) or two of them, in other words.
  const RunResult expected = run_text(charged(law("e = " + valve("f"))), with_relative(1e-9));
  REQUIRE_FALSE(expected.failure);
  // 1e-6 is asked for; kinks in a trace leave some tens of it. dirk5's own error at 1e-6 is up to 1e-4 of a range.
  const std::vector<std::string> texts{"e = -(" + valve("-(-f)") + ")*(0 - 1)", "e = 2*(" + valve("f/1") + ")/2",
                                       "e = if(f > 0, " + valve("f") + ", " + valve("f") + ")",
                                       "e = 0.25*f + (" + valve("f") + " - f/4)"};
  for (const std::string& text : texts) {
    CAPTURE(text);
    for (const Method method : kMethods) {
      INFO(facts_of(method).name);
      const RunResult run = run_text(charged(law(text)), with_method(method));
      REQUIRE_FALSE(run.failure);
      const double tolerance = method == Method::dirk5 ? 1e-4 : 3e-5;
      CHECK(largest_difference(run, expected) < tolerance);
    }
  }
}

TEST_CASE("a spline that rises is solved for its argument in a loop") {
  // A cubic spline through points of a cubic is that cubic (not-a-knot, de Boor 1978).
  const std::string cubic = charged(law("e = f + 0.1*f^3"));
  const RunResult expected = run_text(cubic, with_relative(1e-9));
  REQUIRE_FALSE(expected.failure);
  const std::string spline = "table('" + in_project("tests/data/tables/cubic.csv") + "', 'e', f, spline)";
  for (const Method method : kMethods) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(charged(law("e = " + spline)), with_method(method));
    const RunResult formula = run_text(cubic, with_method(method));
    REQUIRE_FALSE(run.failure);
    REQUIRE_FALSE(formula.failure);
    // The methods' own errors at 1e-6, once in each run.
    CHECK(largest_difference(run, expected) < 1e-6 + 2.0 * largest_difference(formula, expected));
  }
}

TEST_CASE("two measured springs beside each other share what they store") {
  const auto springs = [](bool two) {
    std::vector<Part> parts{{"s", "Se", "x", "0", R"x("effort": "4*sin(1.3*t)")x"},
                            {"r", "R", "x", "y", resistor("0.7")},
                            {"c", "C", "y", "0", law("e = " + valve(two ? "q" : "q/2"))}};
    if (two) parts.push_back({"d", "C", "y", "0", law("e = " + valve("q"))});
    return circuit(parts, R"("u": "c.e", "f": "r.f")", R"("stop": 8, "samples": 81)");
  };
  const RunResult one = run_text(springs(false), with_relative(1e-9));
  REQUIRE_FALSE(one.failure);
  for (const Method method : kMethods) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(springs(true), with_method(method));
    REQUIRE_FALSE(run.failure);
    CHECK(largest_difference(run, one) < (method == Method::dirk5 ? 1e-4 : 3e-5));
  }
}

TEST_CASE("a knot of a table on a loop is passed, whatever rounding makes of it") {
  // Two straight lines that meet in knot.csv, whose numbers do not meet to the last digit, as a table and as an if.
  const std::string table = "table('" + in_project("tests/data/tables/knot.csv") + "', 'y', e)";
  const std::string lines =
      "(1.13 + (e - 0.88)*if(e < 0.88, (1.13 + 17.01826488840715)/(0.88 + 9.719999999999999), "
      "(18.121396279532355 - 1.13)/(20.22 - 0.88)))";
  const auto passed = [](const std::string& part) {
    return circuit({{"s", "Se", "x", "0", R"x("effort": "2.4*cos(1.1*t)")x"},
                    {"r", "R", "x", "y", part},
                    {"b", "R", "y", "z", "\"resistance\": 0.7"},
                    {"c", "C", "z", "0", "\"capacitance\": 1"}},
                   R"("f": "r.f", "u": "c.e")", R"("stop": 6, "samples": 61)");
  };
  for (const char* const factor : {"", " + 0.5*e"}) {
    CAPTURE(factor);
    const RunResult expected = run_text(passed(law("f = " + lines + factor)), with_relative(1e-9));
    REQUIRE_FALSE(expected.failure);
    for (const Method method : kMethods) {
      INFO(facts_of(method).name);
      const RunResult run = run_text(passed(law("f = " + table + factor)), with_method(method));
      const RunResult same = run_text(passed(law("f = " + lines + factor)), with_method(method));
      REQUIRE_FALSE(run.failure);
      REQUIRE_FALSE(same.failure);
      // The methods' own errors at 1e-6, once in each run.
      CHECK(largest_difference(run, expected) < 1e-6 + 2.0 * largest_difference(same, expected));
    }
  }
}

TEST_CASE("a spline that begins in one of its points has a solution beside it") {
  // The force falls below that of the start at once, by no more than the first steps are long.
  const std::string text = circuit(
      {{"s", "Se", "x", "0", R"("effort": "-1")"},
       {"c", "C", "x", "y", R"("capacitance": 1, "initial": {"q": -0.8})"},
       {"m", "I", "y", "z", R"("inertance": 1)"},
       {"r", "R", "z", "0", law("f = table('" + in_project("tests/data/tables/bent.csv") + "', 'y', e, spline)")}},
      R"("v": "m.f")", R"("stop": 2, "samples": 3)");
  for (const Method method : kMethods) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(text, with_method(method));
    REQUIRE_FALSE(run.failure);
    // f = spline(e) inverted by brentq, m f' by SciPy's DOP853 at 1e-10; bdf is wrong by 1e-6.
    CHECK(run.trace.columns[0].back() == Approx(-0.1028343877).epsilon(2e-5));
  }
}

TEST_CASE("what lies beyond the data of a table that is inverted is refused") {
  const std::string strong = circuit({{"s", "Se", "x", "0", R"("effort": "9.5*t")"},
                                      {"r", "R", "x", "y", law("e = " + valve("f"))},
                                      {"c", "C", "y", "0", "\"capacitance\": 1000"}},
                                     R"("u": "c.e")", R"("stop": 1, "samples": 11)");
  const RunResult run = run_text(strong, with_method(Method::radau));
  REQUIRE(run.failure);
  CHECK(run.failure->code == "BG608");
  CHECK_THAT(run.failure->situation, Catch::Contains("inverse_table"));
}
