// Laws that end where floor, ceil, round, mod or the cell of a table that they read has its border.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "support/run.hpp"

namespace bgsim {
namespace {

using namespace test;

const std::vector<Method> kMethods = {Method::automatic, Method::bdf,     Method::adams, Method::ida,  Method::radau,
                                      Method::radau9,    Method::rodas5p, Method::erk5,  Method::erk8, Method::dirk5};

/// A mass of 1 kg at speed w, the angle that it covers, and the integral of a law of that.
std::string turning(double w, const std::string& law, const std::string& effort = "0") {
  return R"x({"bgsim": 1, "name": "turning",
    "signals": {"th": {"integral": "m.f"}, "y": {"integral": ")x" +
         law + R"x("}},
    "elements": {"j": {"kind": "1"}, "m": {"kind": "I", "inertance": 1, "initial": {"f": )x" +
         std::to_string(w) + R"x(}},
                 "s": {"kind": "MSe", "effort": ")x" +
         effort + R"x("}},
    "bonds": [{"from": "j", "to": "m"}, {"from": "s", "to": "j"}],
    "outputs": {"th": "th", "w": "m.f", "y": "y"}, "scenes": {"s": {"stop": 5, "samples": 11}}})x";
}

double part(double x) { return x - std::floor(x); }

/// The integral over x of a law of period 1 whose integral over a part of it is @p within.
template <class Within>
double over_turns(double x, const Within& within) {
  return std::floor(x) * within(1.0) + within(part(x));
}

}  // namespace

TEST_CASE("laws that end where a rounding has its border are integrated across it, by every method") {
  const auto root = [](double x) { return 2.0 / 3.0 * (1.0 - std::pow(1.0 - x, 1.5)); };
  const auto power = [](double x) { return 0.4 * (1.0 - std::pow(1.0 - x, 2.5)); };
  const auto arc = [](double x) { return x * std::asin(x) + std::sqrt(1.0 - x * x) - 1.0; };
  struct Law {
    std::string text;
    double (*integral)(double);
  };
  const std::vector<Law> laws = {{"sqrt(1 - mod(th, 1))", root},
                                 {"sqrt(1 - (th - floor(th)))", root},
                                 {"(1 - mod(th, 1))^1.5", power},
                                 {"asin(mod(th, 1))", arc}};
  for (const Law& law : laws)
    for (const double w : {1.0, -1.0, 1.7})
      for (const Method method : kMethods) {
        INFO(law.text << ' ' << w << ' ' << method_name(method));
        const RunResult result = run_text(turning(w, law.text), with_method(method));
        REQUIRE(result.stop == StopReason::completed);
        for (std::size_t k = 0; k < result.trace.times.size(); ++k) {
          const double x = w * result.trace.times[k], right = over_turns(x, law.integral) / w;
          // A slope without bound at the end of each of up to nine turns; the same laws with max(0, ...), which have no
          // end, are wrong by up to 9e-4 by BDF.
          CHECK(std::abs(result.trace["y"][k] - right) < 3e-3);
        }
      }
}

TEST_CASE("a torque from a table of one turn at the angle's remainder does no work in a turn, by every method") {
  // T(x) = x (1 - x) (1 - 2x), which the spline through its values is: w^2 + x^2 (1 - x)^2/2 stays for -T/2.
  for (const std::string angle : {"mod(th, 1)", "th - floor(th)", "mod(0.3*th, 0.3)/0.3"})
    for (const double w : {1.0, -1.7})
      for (const Method method : kMethods) {
        INFO(angle << ' ' << w << ' ' << method_name(method));
        const RunResult result = run_text(
            turning(w, "1",
                    "-0.5*table('" + in_project("tests/data/tables/cogging.csv") + "', 'T', " + angle + ", spline)"),
            with_method(method));
        REQUIRE(result.stop == StopReason::completed);
        for (std::size_t k = 0; k < result.trace.times.size(); ++k) {
          const double x = part(result.trace["th"][k]), v = result.trace["w"][k];
          // Some hundred tolerances, of a square, in nine turns.
          CHECK(std::abs(v * v + x * x * (1.0 - x) * (1.0 - x) / 2.0 - w * w) < 1e-3);
        }
      }
}

TEST_CASE("a law ends where a linear table has its peak, by every method") {
  // table = 1 - abs(1 - 2x): the root is that of abs(1 - 2x), and its integral over a turn is 2/3.
  for (const double w : {1.0, -1.0})
    for (const Method method : kMethods) {
      INFO(w << ' ' << method_name(method));
      const RunResult result =
          run_text(turning(w, "sqrt(1 - table('" + in_project("tests/data/tables/tent.csv") + "', 'y', mod(th, 1)))"),
                   with_method(method));
      REQUIRE(result.stop == StopReason::completed);
      CHECK(std::abs(last(result, "y") - 10.0 / 3.0) < 3e-3);  // as above
    }
}

TEST_CASE("what is read outside of a law where the modes hold is an error still") {
  const std::string table = "table('" + in_project("tests/data/tables/tent.csv") + "', 'y', ";
  for (const std::string& law :
       {table + "2*mod(th, 1), spline)", table + "2*mod(th, 1))", table + "mod(th, 1) - 0.1, spline)"}) {
    INFO(law);
    const RunResult result = run_text(turning(1.0, law));
    REQUIRE(result.stop == StopReason::failed);
    CHECK(result.failure->code == "BG608");
  }
  CHECK(run_text(turning(1.0, "sqrt(0.5 - mod(th, 1))")).failure->code == "BG601");
}

TEST_CASE("a period of time that rounding makes late leaves no read outside of a table, by every method") {
  // mod(t, 0.1) is below 0 by a rounding where t/0.1 rounds to a whole number: at 1.7. The integral of a tent is a
  // half.
  const std::string table = "table('" + in_project("tests/data/tables/tent.csv") + "', 'y', mod(t, 0.1)/0.1, spline)";
  for (const Method method : kMethods) {
    INFO(method_name(method));
    CHECK(run_text(turning(1.0, table), with_method(method)).stop == StopReason::completed);
  }
}

}  // namespace bgsim
