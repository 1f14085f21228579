// Check valves (ideal diodes) beside orifices: laws that have no slope where the valve shuts.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A source, a valve (or none), an orifice and a store with an outlet, at one flow.
std::string filled(const std::string& source, const std::string& valve, const std::string& law,
                   const std::string& outlet, const std::string& start, const std::string& stop) {
  return R"x({"bgsim": 1, "name": "filled", "elements": {
    "p": {"kind": "Se", "effort": ")x" +
         source + R"x("}, "j": {"kind": "1"}, )x" +
         (valve.empty() ? std::string() : R"x("d": {"kind": "D", "passes": ")x" + valve + R"x("}, )x") +
         R"x("r": {"kind": "R", "law": ")x" + law +
         R"x("}, "n": {"kind": "0"}, "c": {"kind": "C", "capacitance": 1, "initial": {"e": )x" + start + "}}" +
         (outlet.empty() ? std::string() : R"x(, "out": {"kind": "R", "resistance": )x" + outlet + "}") +
         R"x(}, "bonds": [{"from": "p", "to": "j"}, )x" +
         (valve.empty() ? std::string() : R"x({"from": "j", "to": "d"}, )x") +
         R"x({"from": "j", "to": "r"}, {"from": "j", "to": "n"}, {"from": "n", "to": "c"})x" +
         (outlet.empty() ? std::string() : R"x(, {"from": "n", "to": "out"})x") +
         R"x(], "outputs": {"u": "c.e", "i": "r.f"}, "scenes": {"s": {"stop": )x" + stop + R"x(, "samples": 121}}})x";
}

/// As run_text, with valves that change the mode.
RunResult run_modes(const std::string& text, const SceneOverrides& overrides = {}) {
  return Study::from_text(text).scene("s", overrides).simulate(one_run());
}

}  // namespace

TEST_CASE("a check valve behind an orifice lets a store fill, come level and stay") {
  // With d = 4 - u, d' = -sqrt(d)/2: d = (2 - t/4)^2 until t = 8, then 0; at t = 10 the source falls and the valve
  // shuts.
  for (const std::string law : {"e = 4*f*abs(f)", "f = 0.5*sign(e)*sqrt(abs(e))", "f = 0.5*sqrt(max(e, 0))",
                                "f = if(e > 0, 0.5*sqrt(e), -0.5*sqrt(-e))"}) {
    INFO(law);
    const RunResult run = run_modes(filled("if(t < 10, 4, 1)", "in", law, "", "0", "12"));
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
      const double left = std::max(0.0, 2.0 - run.trace.times[k] / 4.0);
      CHECK(std::abs(run.trace["u"][k] - (4.0 - left * left)) < 1e-5);  // some tolerances of 4e-6
    }
  }
}

TEST_CASE("a check valve is the same as a law that is 0 the other way", "[long]") {
  const std::pair<const char*, const char*> laws[] = {
      {"f = 0.7*sign(e)*sqrt(abs(e))", "f = 0.7*sqrt(max(e, 0))"},
      {"f = 0.7*sign(e)*abs(e)^0.3", "f = 0.7*max(e, 0)^0.3"},
      {"f = 0.7*cbrt(e)", "f = 0.7*cbrt(max(e, 0))"},
      {"f = if(e > 0, 0.7*sqrt(e), -0.7*sqrt(-e))", "f = 0.7*sqrt(max(e, 0))"},
  };
  for (const auto& [law, one_way] : laws)
    for (const std::string source : {"2*cos(3*t)", "1 + 2*sin(2*t + 1)", "1e-3*(1 + 2*sin(2*t + 1))"}) {
      INFO(law << ' ' << source);
      RunResult with = run_modes(filled(source, "in", law, "3", "0.3", "12"), with_relative(1e-8));
      const RunResult without = run_modes(filled(source, "", one_way, "3", "0.3", "12"), with_relative(1e-8));
      REQUIRE(with.stop == StopReason::completed);
      REQUIRE(without.stop == StopReason::completed);
      // Both ends of each opening are at slopes without bound: errors of 1e-8 become some hundred times as large.
      for (std::size_t k = 0; k < with.trace.times.size(); ++k)
        CHECK(std::abs(with.trace["u"][k] - without.trace["u"][k]) < 3e-6);
    }
}

TEST_CASE("a check valve from rest begins to pass as the source rises") {
  for (const std::string law : {"f = 0.7*sign(e)*sqrt(abs(e))", "f = 0.7*cbrt(e)"})
    for (const double sign : {1.0, -1.0}) {
      INFO(law << ' ' << sign);
      const std::string source = sign > 0.0 ? "3*sin(t)" : "-3*sin(t)";
      const RunResult run =
          run_modes(filled(source, sign > 0.0 ? "in" : "out", law, "3", "0", "9"), with_relative(1e-8));
      const std::string one_way = law == "f = 0.7*cbrt(e)" ? "f = 0.7*cbrt(max(e, 0))" : "f = 0.7*sqrt(max(e, 0))";
      const RunResult other = run_modes(filled("3*sin(t)", "", one_way, "3", "0", "9"), with_relative(1e-8));
      REQUIRE(run.stop == StopReason::completed);
      REQUIRE(other.stop == StopReason::completed);
      for (std::size_t k = 0; k < run.trace.times.size(); ++k)
        CHECK(std::abs(sign * run.trace["u"][k] - other.trace["u"][k]) < 3e-6);
    }
}

TEST_CASE("conditions of time are seen while tanks that have come level are held there", "[long]") {
  // Once both are level nothing moves, and steps are as long as the scene; the valve opens with each stroke of the
  // source that is higher than what is there.
  const auto tanks = [](const std::string& law) {
    return Study::from_text(R"x({"bgsim": 1, "name": "tanks", "elements": {
      "s": {"kind": "Se", "effort": "7*sin(7.5*t) - 3"}, "j": {"kind": "1"}, "d": {"kind": "D"},
      "r": {"kind": "R", "resistance": 1}, "n0": {"kind": "0"}, "c0": {"kind": "C", "capacitance": 1}, "k": {"kind": "1"},
      "orifice": {"kind": "R", "law": ")x" +
                            law + R"x("}, "n1": {"kind": "0"}, "c1": {"kind": "C", "capacitance": 0.5}},
      "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "d"}, {"from": "j", "to": "r"}, {"from": "j", "to": "n0"},
                {"from": "n0", "to": "c0"}, {"from": "n0", "to": "k"}, {"from": "k", "to": "orifice"},
                {"from": "k", "to": "n1"}, {"from": "n1", "to": "c1"}],
      "outputs": {"q": "c0.q", "over": "s.e - c0.e"}, "scenes": {"run": {"stop": 6.6, "samples": 67}}})x");
  };
  const auto run = [](const Study& study, Method method) {
    SceneOverrides overrides;
    overrides.method = method;
    overrides.relative = 1e-8;
    return study.scene("run", overrides).simulate(one_run());
  };
  const RunResult other = run(tanks("e = f*abs(f)/9"), Method::automatic);
  const Study roots = tanks("f = 3*sign(e)*sqrt(abs(e))");
  for (const Method method : {Method::automatic, Method::bdf, Method::ida, Method::erk5, Method::dirk5, Method::erk8,
                              Method::radau, Method::radau9, Method::rodas5p}) {
    INFO("method " << static_cast<int>(method));
    const RunResult result = run(roots, method);
    REQUIRE(result.stop == StopReason::completed);
    CHECK(result.report.mode_changes == other.report.mode_changes);
    for (std::size_t k = 0; k < result.trace.times.size(); ++k)
      CHECK(std::abs(result.trace["q"][k] - other.trace["q"][k]) < 1e-5);  // some hundred tolerances each
  }
}

TEST_CASE("a stop is where it is although a law beside it has no slope at rest") {
  // Nothing of these laws has a second slope at 0; a contact was taken as closed, with its gap before it.
  const auto run = [](const std::string& law, const std::string& push, const std::string& gap, const std::string& speed,
                      const std::string& stop) {
    return run_modes(
        R"x({"bgsim": 1, "name": "stop", "elements": {"m": {"kind": "I", "inertance": 1, "initial": {"f": )x" + speed +
        R"x(}}, "f": {"kind": "Se", "effort": ")x" + push + R"x("}, "j": {"kind": "1"}, "x": )x" + law +
        R"x(, "stop": {"kind": "contact", "gap": )x" + gap + R"x(, "restitution": 0}}, "bonds": [
      {"from": "j", "to": "m"}, {"from": "f", "to": "j"}, {"from": "j", "to": "x"}, {"from": "j", "to": "stop"}],
      "outputs": {"v": "m.f", "q": "stop.q"}, "scenes": {"s": {"stop": )x" +
        stop + R"x(, "samples": 11, "relative": 1e-8}}})x");
  };
  const std::string spring = R"x({"kind": "C", "law": "e = 10*max(q, 0)^1.5", "initial": {"q": 0}})x";
  {
    INFO("Hertz's spring, thrown at 1 against a stop at 0.3, which takes what is left of its energy");
    const RunResult hertz = run(spring, "0", "0.3", "1", "2");
    REQUIRE(hertz.stop == StopReason::completed);
    // From the stop the spring gives back 4 q^2.5, and at q = 0 it lets go: v = -sqrt(8 0.3^2.5).
    CHECK(hertz.trace["v"].back() ==
          Approx(-std::sqrt(8.0 * std::pow(0.3, 2.5))).epsilon(1e-6));  // a hundred tolerances
    CHECK(hertz.report.energy.impacts == Approx(0.5 - 4.0 * std::pow(0.3, 2.5)).epsilon(1e-6));
  }
  {
    INFO("turbulent friction from rest, a constant force");
    // v' = 1 - v^1.75 from 0: whatever it is, the stop at 1 holds the mass there by t = 3.
    const RunResult friction = run(R"x({"kind": "R", "law": "e = sign(f)*abs(f)^1.75"})x", "1", "1", "0", "3");
    REQUIRE(friction.stop == StopReason::completed);
    CHECK(friction.trace["q"].back() == Approx(1.0).epsilon(1e-8));
    CHECK(friction.trace["q"][3] > 0.3);  // at t = 0.9, 0.4 without friction
  }
  {
    INFO("a relief valve with an orifice, not connected with the stop");
    const RunResult relief = run_modes(R"x({"bgsim": 1, "name": "relief", "elements": {
      "pump": {"kind": "Sf", "flow": 1}, "a": {"kind": "0"}, "c": {"kind": "C", "capacitance": 0.1}, "way": {"kind": "1"},
      "valve": {"kind": "D", "threshold": 5}, "o": {"kind": "R", "law": "f = 3*sign(e)*sqrt(abs(e))"},
      "rod": {"kind": "1"}, "m": {"kind": "I", "inertance": 1}, "stop": {"kind": "contact", "gap": 1, "restitution": 0},
      "f": {"kind": "Se", "effort": 1}}, "bonds": [{"from": "pump", "to": "a"}, {"from": "a", "to": "c"},
      {"from": "a", "to": "way"}, {"from": "way", "to": "valve"}, {"from": "way", "to": "o"}, {"from": "rod", "to": "m"},
      {"from": "rod", "to": "stop"}, {"from": "f", "to": "rod"}], "outputs": {"p": "c.e", "q": "stop.q"},
      "scenes": {"s": {"stop": 3, "samples": 11, "relative": 1e-8}}})x");
    REQUIRE(relief.stop == StopReason::completed);
    for (std::size_t k = 0; k < relief.trace.times.size(); ++k) {
      const double t = relief.trace.times[k];
      CHECK(relief.trace["q"][k] == Approx(std::min(1.0, 0.5 * t * t)).margin(1e-7));  // ten tolerances
    }
    CHECK(relief.trace["p"].back() == Approx(5.0 + 1.0 / 9.0).epsilon(1e-6));  // the pump's flow through the orifice
  }
}

TEST_CASE("a diode lets a mass go on beside an orifice at rest, and a contact takes its impact at its gap") {
  // m v' = -v from v = 1. Not connected with it: a pump, and a relief valve with an orifice through which nothing
  // flows.
  const auto run = [](const std::string& law, const std::string& beside) {
    return run_modes(R"x({"bgsim": 1, "name": "beside", "elements": {
      "pump": {"kind": "Sf", "flow": 1}, "a": {"kind": "0"}, "c": {"kind": "C", "capacitance": 0.1}, "way": {"kind": "1"},
      "valve": {"kind": "D", "threshold": 5}, "o": {"kind": "R", "law": ")x" +
                     law + R"x("}, "j": {"kind": "1"},
      "m": {"kind": "I", "inertance": 1, "initial": {"f": 1}}, "r": {"kind": "R", "resistance": 1}, "x": )x" +
                     beside +
                     R"x(}, "bonds": [{"from": "pump", "to": "a"}, {"from": "a", "to": "c"}, {"from": "a", "to": "way"},
      {"from": "way", "to": "valve"}, {"from": "way", "to": "o"}, {"from": "j", "to": "m"}, {"from": "j", "to": "r"},
      {"from": "j", "to": "x"}], "outputs": {"v": "m.f"}, "scenes": {"s": {"stop": 1, "samples": 11, "relative": 1e-8}}})x");
  };
  // The last one has no other form: its loop has no slope, and sides are tried one by one.
  for (const std::string law : {"f = 3*sign(e)*sqrt(abs(e))", "f = 2*sign(e)*abs(e)^0.6",
                                "f = if(e > 0, sqrt(e), -sqrt(-e))", "f = sign(e)*sqrt(abs(e)) + 0.01*e"}) {
    INFO(law);
    const RunResult passes = run(law, R"x({"kind": "D"})x");
    REQUIRE(passes.stop == StopReason::completed);
    CHECK(passes.trace["v"].back() == Approx(std::exp(-1.0)).epsilon(1e-7));  // a hundred tolerances
    const RunResult rebounds = run(law, R"x({"kind": "contact", "gap": 0, "restitution": 0.5})x");
    REQUIRE(rebounds.stop == StopReason::completed);
    CHECK(rebounds.trace["v"].back() == Approx(-0.5 * std::exp(-1.0)).epsilon(1e-7));
    const RunResult flies = run(law, R"x({"kind": "contact", "gap": 0.5, "restitution": 1})x");
    REQUIRE(flies.stop == StopReason::completed);
    // With x + v = 1 it comes to the stop at v = 1/2, t = log(2), and turns back.
    CHECK(flies.trace["v"].back() == Approx(-std::exp(-1.0)).epsilon(1e-7));
  }
}
