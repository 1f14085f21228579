// Conditions on variables of loops.
#include <catch2/catch.hpp>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

TEST_CASE("a condition on a loop that no rate needs changes where it should") {
  // The lamp has 6/7 of the voltage t, and the state beside it knows nothing of either.
  const RunResult result = run_text(R"({"bgsim": 1, "name": "beside", "signals": {"x": {"integral": "1"}},
    "elements": {"v": {"kind": "Se", "effort": "t"}, "r": {"kind": "R", "resistance": 1}, "series": {"kind": "1"},
                 "lamp": {"kind": "R", "resistance": 6}},
    "bonds": [{"from": "v", "to": "series"}, {"from": "series", "to": "r"}, {"from": "series", "to": "lamp"}],
    "outputs": {"x": "x", "bright": "if(lamp.e < 1, 0, 1) + 0"},
    "scenes": {
  "run" : { "stop" : 2, "times" : [ 1.1666, 1.1667, 2 ] }
}
})");
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.state_events == 1);
  CHECK(result.trace["bright"][0] == 0.0);  // 7/6 is 1.16667
  CHECK(result.trace["bright"][1] == 1.0);
  CHECK(result.trace["bright"][2] == 1.0);
}

TEST_CASE("a loop at rest whose terms cancel but for rounding has no end there") {
  // p' = sin(2 t) - e, e + 0.2 e^3 = p. The two sources make steps of 2.8e-17 of the loop's residual, beside which the
  // solution is no larger at first: BG602, "from 0 to 2.8e-17 at once".
  const auto coil = [](const std::string& sources) {
    return R"x({"bgsim": 1, "name": "coil",
      "elements": {"u": {"kind": "Se", "effort": "sin(2*t)"}, "v": {"kind": "1"}, "r": {"kind": "R", "law": "f = e + 0.2*e^3"},
        "n": {"kind": "0"}, "l": {"kind": "I", "inertance": 1}, "a": {"kind": "Sf", "flow": )x" +
           sources + R"x(}, "b": {"kind": "Sf", "flow": )x" + sources + R"x(}},
      "bonds": [{"from": "u", "to": "v"}, {"from": "v", "to": "r"}, {"from": "v", "to": "n"}, {"from": "n", "to": "l"},
        {"from": "a", "to": "n"}, {"from": "n", "to": "b"}],
      "outputs": {"i": "l.f"}, "scenes": {"run": {"stop": 2, "samples": 5}}})x";
  };
  for (const double relative : {1e-6, 1e-7, 1e-8, 1e-9, 1e-10}) {
    INFO(relative);
    const RunResult cancelling = run_text(coil("0.2"), with_relative(relative));
    const RunResult without = run_text(coil("0"), with_relative(1e-11));
    REQUIRE(cancelling.stop == StopReason::completed);
    REQUIRE(without.stop == StopReason::completed);
    // A hundred tolerances: the current is below 0.7.
    CHECK(last(cancelling, "i") == Approx(last(without, "i")).margin(100.0 * relative));
  }
}

TEST_CASE("a loop at rest that a step sets in motion has no end there") {
  // Two capacitors of one effort, e = q1 and e = q2 + q2^3, behind a resistor of 1. As the step comes rounding alone is
  // in the loop: BG602, "from 0 to 1.1e-16 at once". The same of two coils of one flow behind a conductance.
  const auto stores = [](const std::string& start, bool coils) {
    const std::string kind = coils ? "I" : "C", law = coils ? "f = p" : "e = q", x = coils ? "p" : "q";
    return R"x({"bgsim": 1, "name": "step", "elements": {"s": {"kind": ")x" + std::string(coils ? "Sf" : "Se") +
           R"x(", ")x" + std::string(coils ? "flow" : "effort") + R"x(": ")x" + start + R"x("}, "j": {"kind": ")x" +
           std::string(coils ? "0" : "1") + R"x("}, "r": {"kind": "R", "resistance": 1}, "z": {"kind": ")x" +
           std::string(coils ? "1" : "0") + R"x("}, "c1": {"kind": ")x" + kind + R"x(", "law": ")x" + law +
           R"x("}, "c2": {"kind": ")x" + kind + R"x(", "law": ")x" + law + " + " + x + R"x(^3"}},
      "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "r"}, {"from": "j", "to": "z"}, {"from": "z", "to": "c1"}, {"from": "z", "to": "c2"}],
      "outputs": {"q2": "c2.)x" +
           x + R"x("}, "scenes": {"run": {"stop": 10, "samples": 11}}})x";
  };
  for (const bool coils : {false, true}) {
    const RunResult later = run_text(stores("1e-16 + step(t - 1)", coils), with_relative(1e-11));
    REQUIRE(later.stop == StopReason::completed);
    for (const Method method : {Method::automatic, Method::bdf, Method::adams, Method::erk5, Method::radau9})
      for (const double relative : {1e-4, 1e-6, 1e-9}) {
        INFO(facts_of(method).name << " at " << relative);
        const RunResult run = run_text(stores("step(t - 1)", coils), with_method(method, relative));
        REQUIRE(run.stop == StopReason::completed);
        CHECK(last(run, "q2") == Approx(last(later, "q2")).margin(100.0 * relative));  // a hundred tolerances
      }
  }
  // In small units a first step does not even move the time: c1 + c2 of 1e-6 s, with q^3 next to nothing.
  for (const Method method : {Method::automatic, Method::bdf, Method::erk5})
    for (const double relative : {1e-5, 1e-8, 1e-11}) {
      INFO(facts_of(method).name << " at " << relative);
      const RunResult run = run_text(R"x({"bgsim": 1, "name": "small", "elements": {
          "s": {"kind": "Se", "effort": "1e-6*step(t - 1)"}, "j": {"kind": "1"}, "r": {"kind": "R", "resistance": 1},
          "z": {"kind": "0"}, "c1": {"kind": "C", "law": "e = 1e6*q"}, "c2": {"kind": "C", "law": "e = 1e6*q + 1e18*q^3"}},
          "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "r"}, {"from": "j", "to": "z"},
                    {"from": "z", "to": "c1"}, {"from": "z", "to": "c2"}],
          "outputs": {"q2": "c2.q"}, "scenes": {"run": {"stop": 1.00005, "samples": 6}}})x",
                                     with_method(method, relative));
      REQUIRE(run.stop == StopReason::completed);
      // 1e6 q + 1e18 q^3 = 1e-6: q = 1e-12 (1 - 1e-12). A thousand tolerances: explicit steps go at the border of what
      // is stable.
      CHECK(last(run, "q2") == Approx(1e-12).epsilon(1000.0 * relative + 2e-12));
    }
}

TEST_CASE("a loop that comes to rest where its law has no slope is not taken for one that has left its solution") {
  // Behind the valves C e' = max(sin t, 0) - sqrt(e) in parts of E and F: empty at t = 4.27 and 10.56, not just nearly.
  const auto pump = [](const std::string& elements, const std::string& bonds) {
    return Study::from_text(R"x({"bgsim": 1, "name": "pump", "elements": {
      "o": {"kind": "0"}, "c": {"kind": "C", "capacitance": 1e-9}, "k": {"kind": "1"},
      "r": {"kind": "R", "law": "e = 1e13*f*abs(f)"}, )x" +
                            elements + R"x(}, "bonds": [{"from": "o", "to": "c"}, {"from": "o", "to": "k"},
      {"from": "k", "to": "r"}, )x" +
                            bonds +
                            R"x(], "outputs": {"e": "c.e/1e5"}, "scenes": {"run": {"stop": 15, "samples": 31}}})x");
  };
  const Study plain = pump(R"x("s": {"kind": "Sf", "flow": "1e-4*max(sin(t), 0)"})x", R"x({"from": "s", "to": "o"})x");
  SceneOverrides overrides;
  overrides.method = Method::bdf;
  overrides.relative = 1e-10;
  const RunResult exact = plain.scene("run", overrides).simulate(untimed());
  REQUIRE(exact.stop == StopReason::completed);
  const Study valves = pump(R"x("s": {"kind": "Sf", "flow": "1e-4*sin(t)"}, "n": {"kind": "0"},
      "in": {"kind": "D", "passes": "out"}, "j": {"kind": "1"}, "out": {"kind": "D"})x",
                            R"x({"from": "s", "to": "n"}, {"from": "n", "to": "in"}, {"from": "n", "to": "j"},
      {"from": "j", "to": "out"}, {"from": "j", "to": "o"})x");
  for (const double relative : {1e-5, 1e-6, 1e-7, 1e-8}) {
    INFO("relative " << relative);
    overrides.method = Method::automatic;
    overrides.relative = relative;
    SimulateOptions options = untimed();
    options.max_steps = 5'000;  // 225 to 404; 130,000 in 5 s where steps were made again and again
    const RunResult result = valves.scene("run", overrides).simulate(options);
    REQUIRE(result.stop == StopReason::completed);
    for (std::size_t k = 0; k < exact.trace.times.size(); ++k)
      CHECK(result.trace.columns[0][k] == Approx(exact.trace.columns[0][k]).margin(10 * relative));
  }
}
