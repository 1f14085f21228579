// Laws of resistors that are held at the border of their own condition: both sides push back to it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "support/run.hpp"

namespace bgsim {
namespace {

using namespace test;

/// A tank of 1 that is empty and filled, with a valve that opens at the level 1.
std::string tank(const std::string& law, const std::string& inflow) {
  return R"x({"bgsim": 1, "name": "tank", "parameters": {"h": 1, "k": 10},
    "elements": {"n": {"kind": "0"}, "in": {"kind": "Sf", "flow": ")x" +
         inflow + R"x("}, "c": {"kind": "C", "capacitance": 1, "initial": {"q": 0}},
                 "valve": {"kind": "R", "law": "f = )x" +
         law + R"x("}},
    "bonds": [{"from": "in", "to": "n"}, {"from": "n", "to": "c"}, {"from": "n", "to": "valve"}],
    "scenes": {"s": {"stop": 4, "samples": 81}}, "outputs": {"e": "c.e", "f": "valve.f"}})x";
}

/// A capacitor of 1 behind a resistor with @p law, which follows the effort of a source.
RunResult follower(const std::string& effort, const std::string& law, double q, const std::string& scene,
                   Method method) {
  const RunResult run =
      run_text(R"x({"bgsim": 1, "name": "follower", "elements": {
      "s": {"kind": "MSe", "effort": ")x" +
                   effort + R"x("}, "j": {"kind": "1"}, "r": {"kind": "R", "law": ")x" + law +
                   R"x("}, "c": {"kind": "C", "capacitance": 1, "initial": {"q": )x" + std::to_string(q) + R"x(}}},
    "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "r"}, {"from": "j", "to": "c"}],
    "outputs": {"q": "c.q"}, "scenes": {"s": )x" +
                   scene + "}}",
               with_method(method));
  REQUIRE(run.stop == StopReason::completed);
  return run;
}

const std::vector<Method> kMethods{Method::bdf,   Method::adams, Method::ida,   Method::erk5,    Method::dirk3,
                                   Method::dirk4, Method::dirk5, Method::radau, Method::rodas5p, Method::automatic};

}  // namespace

TEST_CASE("a relief valve that its inflow holds at the level at which it opens lets out the inflow") {
  for (const std::string law :
       {"if(e >= h, k*(e - 0.9*h), 0)", "if(e < h, 0, k*(e - 0.9*h))", "step(e - h)*k*(e - 0.9*h)",
        "if(not(e < h) and e < 5, k*(e - 0.9*h), 0)", "if(e > h or e < -5, k*(e - 0.9*h), 0)"})
    for (const Method method : kMethods) {
      CAPTURE(law, method_name(method));
      const RunResult run = run_text(tank(law, "0.5"), with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
        const double t = run.trace.times[k];
        CHECK(std::abs(run.trace["e"][k] - std::min(0.5 * t, 1.0)) < 1e-6);
        if (std::abs(t - 2.0) > 0.01) CHECK(std::abs(run.trace["f"][k] - (t < 2.0 ? 0.0 : 0.5)) < 1e-6);
      }
    }
}

TEST_CASE("a relief valve leaves its level when the inflow is more than it lets out there") {
  // e = 0.2 t^2 up to 1; held while 0.4 t < 1; then (e - 0.9)' = 0.4 t - 10 (e - 0.9).
  const auto level = [](double t) {
    return t < std::sqrt(5.0) ? 0.2 * t * t
           : t < 2.5          ? 1.0
                              : 0.9 + 0.04 * t - 0.004 + 0.004 * std::exp(-10.0 * (t - 2.5));
  };
  for (const Method method : kMethods) {
    CAPTURE(method_name(method));
    const RunResult run = run_text(tank("if(e >= h, k*(e - 0.9*h), 0)", "0.4*t"), with_method(method));
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t k = 0; k < run.trace.times.size(); ++k)
      CHECK(std::abs(run.trace["e"][k] - level(run.trace.times[k])) < 2e-5);  // twenty tolerances
    CHECK(run.report.energy.relative < 1e-4);
  }
}

TEST_CASE("two levels of one law hold, one after the other") {
  // 0.3 at most at the level 1, 1.3 at most at 2; an inflow of 0.2 is held at the first, one of 0.6 at the second.
  const std::string law = "if(e >= h, 0.3, 0) + if(e >= 2*h, 1, 0)";
  const RunResult first = run_text(tank(law, "if(t < 2, 0.5, 0.2)"));
  REQUIRE(first.stop == StopReason::completed);
  const RunResult second = run_text(tank(law, "2*if(t < 2, 0.5, 0.3) + 0.01*t"));
  REQUIRE(second.stop == StopReason::completed);
  CHECK(std::abs(last(first, "f") - 0.2) < 1e-6);
  CHECK(std::abs(last(first, "e") - 1.0) < 1e-6);
  CHECK(std::abs(last(second, "f") - 0.64) < 1e-6);
  CHECK(std::abs(last(second, "e") - 2.0) < 1e-6);
}

TEST_CASE("a mass whose drag jumps at a speed keeps that speed") {
  const RunResult run = run_text(R"x({"bgsim": 1, "name": "mass", "elements": {"j": {"kind": "1"},
      "m": {"kind": "I", "inertance": 1, "initial": {"p": 0}}, "drag": {"kind": "R", "law": "e = if(f > 1, 3, 1)"},
      "s": {"kind": "Se", "effort": "2"}}, "bonds": [{"from": "j", "to": "m"}, {"from": "j", "to": "drag"},
      {"from": "s", "to": "j"}], "outputs": {"v": "m.f", "e": "drag.e"}, "scenes": {"s": {"stop": 5, "samples": 51}}})x");
  REQUIRE(run.stop == StopReason::completed);
  CHECK(std::abs(last(run, "v") - 1.0) < 1e-6);
  CHECK(std::abs(last(run, "e") - 2.0) < 1e-6);
  CHECK(std::abs(run.trace["v"][5] - 0.5) < 1e-6);
}

TEST_CASE("a valve is held at its border beside a nonlinear loop, which IDA finds inside the rates from there on") {
  // 2 - e = 3 f + 2 f^3 behind two resistances: what flows in while the level is 1.
  double inflow = 0.3;
  for (int k = 0; k < 50; ++k)
    inflow -= (3.0 * inflow + 2.0 * std::pow(inflow, 3) - 1.0) / (3.0 + 6.0 * inflow * inflow);
  for (const Method method : {Method::ida, Method::bdf}) {
    CAPTURE(method_name(method));
    const RunResult run = run_text(R"x({"bgsim": 1, "name": "tank", "elements": {"n": {"kind": "0"}, "j": {"kind": "1"},
        "s": {"kind": "Se", "effort": 2}, "a": {"kind": "R", "law": "e = f + f^3"}, "b": {"kind": "R", "law": "e = 2*f + f^3"},
        "c": {"kind": "C", "capacitance": 0.2}, "valve": {"kind": "R", "law": "f = if(e >= 1, 10*(e - 0.9), 0)"}},
      "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "a"}, {"from": "j", "to": "b"}, {"from": "j", "to": "n"},
                {"from": "n", "to": "c"}, {"from": "n", "to": "valve"}],
      "outputs": {"e": "c.e", "f": "valve.f"}, "scenes": {"s": {"stop": 4, "samples": 41}}})x",
                                   with_method(method));
    REQUIRE(run.stop == StopReason::completed);
    CHECK(std::abs(last(run, "e") - 1.0) < 1e-6);
    CHECK(std::abs(last(run, "f") - inflow) < 1e-6);
  }
}

TEST_CASE("two rotors that a dry torque brings to one speed go on together, by every method") {
  // 5 and -1 at first; (0.2 - 2)/1 and 2/2 while their speeds differ: equal at t = 6/2.8, then 0.2/3.
  const double together = 6.0 / 2.8;
  for (const Method method : kMethods) {
    CAPTURE(method_name(method));
    const RunResult run =
        run_text(R"x({"bgsim": 1, "name": "clutch", "elements": {"a": {"kind": "1"}, "b": {"kind": "1"},
        "between": {"kind": "1"}, "z": {"kind": "0"}, "u": {"kind": "Se", "effort": 0.2},
        "i1": {"kind": "I", "inertance": 1, "initial": {"f": 5}}, "i2": {"kind": "I", "inertance": 2, "initial": {"f": -1}},
        "plates": {"kind": "R", "law": "e = 2*sign(f)"}},
      "bonds": [{"from": "u", "to": "a"}, {"from": "a", "to": "i1"}, {"from": "a", "to": "z"}, {"from": "z", "to": "between"},
                {"from": "between", "to": "plates"}, {"from": "z", "to": "b"}, {"from": "b", "to": "i2"}],
      "outputs": {"w1": "i1.f", "w2": "i2.f"}, "scenes": {"s": {"stop": 5, "samples": 51}}})x",
                 with_method(method));
    REQUIRE(run.stop == StopReason::completed);
    const double w = 5.0 - 1.8 * together + (5.0 - together) * 0.2 / 3.0;
    CHECK(std::abs(last(run, "w1") - w) < 2e-5);  // some tolerances of a range of 6
    CHECK(std::abs(last(run, "w2") - w) < 2e-5);
  }
}

TEST_CASE("friction that holds does so while what its force is divided by grows by a million") {
  // A dashpot of limit 2 that follows its source, whose speed is below 1.7: e = 0 once it is caught, at t = 0.14.
  const std::string k = "(1 + 1e6*(1 + cos(3*t)))";
  for (const std::string& law : {"2*sign(e/" + k + ")", "2*sign(-3*e/" + k + "/4)*(-1)", "if(e/" + k + " > 0, 2, -2)",
                                 "if(0 < e/" + k + ", 2, -2)", "4*step(e/" + k + ") - 2"})
    for (const Method method : kMethods) {
      CAPTURE(law, method_name(method));
      const RunResult run = follower("sin(0.7*t) + t", "f = " + law, 0.5, R"({"stop": 12, "samples": 121})", method);
      for (std::size_t n = 5; n < run.trace.times.size(); ++n) {
        const double t = run.trace.times[n];
        // 1e-4 of the range, from which on a run has to note its errors
        CHECK(std::abs(run.trace["q"][n] - std::sin(0.7 * t) - t) < 1.2e-3);
      }
    }
}

TEST_CASE("the sign of a quotient is right behind a time at which its denominator is next to nothing") {
  // By SciPy's Radau at 1e-10 with steps of at most 0.01.
  const std::vector<std::pair<std::size_t, double>> known{
      {40, 1.0746652}, {60, -1.46665252}, {100, 0.15657497}, {120, 1.79785846}};
  for (const Method method : {Method::automatic, Method::bdf, Method::erk5, Method::ida, Method::radau9}) {
    CAPTURE(method_name(method));
    const RunResult run = follower("2*sin(0.7*t)", "f = sign(e/(1.0000001 + sin(t)))*sqrt(abs(e/(1.0000001 + sin(t))))",
                                   0.5, R"({"stop": 12, "samples": 121})", method);
    // 1e-4 of the range, from which on a run has to note its errors
    for (const auto& [n, q] : known) CHECK(std::abs(run.trace["q"][n] - q) < 4e-4);
  }
}

TEST_CASE("a small jump between levels that were equal lets an orifice flow") {
  // d' = -sqrt(d) for the difference d: (1 - t/2)^2 until t = 2, and (sqrt(J) - (t - 5)/2)^2 behind the jump J at 5.
  for (const double jump : {1e-5, 1e-4, 5e-4, 2e-3, 0.3})
    for (const Method method : {Method::automatic, Method::bdf, Method::erk5, Method::dirk5, Method::rodas5p}) {
      CAPTURE(jump, method_name(method));
      const RunResult run = follower("if(t < 5, 1, 1 + " + std::to_string(jump) + ")", "f = sign(e)*sqrt(abs(e))", 0.0,
                                     R"({"stop": 8, "samples": 801})", method);
      for (std::size_t n = 0; n < run.trace.times.size(); ++n) {
        const double t = run.trace.times[n];
        const double root = t < 5.0 ? 1.0 - t / 2.0 : std::sqrt(jump) - (t - 5.0) / 2.0;
        const double level = (t < 5.0 ? 1.0 : 1.0 + jump) - std::pow(std::max(0.0, root), 2);
        CHECK(std::abs(run.trace["q"][n] - level) < 5e-5);  // half of what a run has to note
      }
    }
}

TEST_CASE("a law that follows a condition by more than a straight line is held by its values on both sides") {
  const RunResult root = run_text(tank("sqrt(4*if(e >= h, 1, 0.01))", "0.5"));
  const RunResult plain = run_text(tank("if(e >= h, 2, 0.2)", "0.5"));
  REQUIRE(root.stop == StopReason::completed);
  REQUIRE(plain.stop == StopReason::completed);
  CHECK(root.trace.times == plain.trace.times);
  for (const std::string name : {"e", "f"}) CHECK(column(root, name) == column(plain, name));
}

}  // namespace bgsim
