// Dry friction written as what it is, sign(f): it holds what it can hold.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A mass on a spring with dry friction 0.1, pushed.
std::string block(const std::string& push, double q, double stop, std::size_t samples) {
  return R"json({ "bgsim": 1, "name": "block",
  "elements": {
    "push": { "kind": "Se", "effort": ")json" +
         push + R"json(" }, "v": { "kind": "1" }, "m": { "kind": "I", "inertance": 1 },
    "spring": { "kind": "C", "capacitance": 1, "initial": { "q": )json" +
         std::to_string(q) + R"json( } },
    "friction": { "kind": "R", "law": "e = 0.1*sign(f)" }
  },
  "bonds": [ { "from": "push", "to": "v" }, { "from": "v", "to": "m" }, { "from": "v", "to": "spring" },
    { "from": "v", "to": "friction" } ],
  "outputs": { "x": "spring.q", "v": "m.f", "F": "friction.e" },
  "scenes": { "main": { "stop": )json" +
         std::to_string(stop) + ", \"samples\": " + std::to_string(samples) + " } } }";
}

}  // namespace

TEST_CASE("an oscillation with dry friction comes to rest where it is held") {
  // each half period, pi long, the amplitude falls by twice 0.1: 0.55 -> -0.35 -> 0.15 -> 0.05, which friction holds
  const RunResult result = run_text(block("0", 0.55, 1000, 5), with_relative(1e-8));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(run_text(block("0", 0.55, 1000, 5), with_method(Method::bdf, 1e-8)).report.state_events ==
        3);  // it turns twice, and is held
  CHECK(last(result, "x") == Approx(0.05).margin(2e-7));
  CHECK(std::abs(last(result, "v")) < 1e-12);
  CHECK(last(result, "F") == Approx(-0.05).margin(2e-7));  // friction takes what the spring gives
  CHECK(result.report.energy.relative < 1e-5);
  CHECK(result.report.steps < 1500);
}

TEST_CASE("a block at rest stays there under any force that friction can take") {
  const RunResult result = run_text(block("0.09*sin(t)", 0, 20, 21));
  REQUIRE(result.stop == StopReason::completed);
  const std::vector<double> v = column(result, "v"), force = column(result, "F");
  for (std::size_t i = 0; i < v.size(); ++i) {
    CHECK(std::abs(v[i]) < 1e-12);
    CHECK(force[i] == Approx(0.09 * std::sin(result.trace.times[i])).margin(1e-9));
  }
}

TEST_CASE("a block breaks away when the force exceeds friction") {
  // from t = 1 on: v' = 0.1 t - 0.1 - x; x = 0.1 ((t - 1) - sin(t - 1))
  const RunResult result = run_text(block("0.1*t", 0, 3, 31), with_relative(1e-8));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.state_events == 1);
  const std::vector<double> x = column(result, "x");
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double s = std::max(0.0, result.trace.times[i] - 1.0);
    CHECK(x[i] == Approx(0.1 * (s - std::sin(s))).margin(1e-6));
  }
}

TEST_CASE("a jump of the force breaks a block away at once") {
  const RunResult result = run_text(block("if(t < 1, 0.05, 0.3)", 0, 2, 21), with_relative(1e-8));
  REQUIRE(result.stop == StopReason::completed);
  const std::vector<double> x = column(result, "x");
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double s = std::max(0.0, result.trace.times[i] - 1.0);
    CHECK(x[i] == Approx(0.2 * (1.0 - std::cos(s))).margin(1e-6));
  }
}

TEST_CASE("a block on a moving belt moves with it until its spring pulls it off") {
  const std::string direct = R"json({ "bgsim": 1, "name": "belt",
    "elements": {
      "v": { "kind": "1" }, "m": { "kind": "I", "inertance": 1, "initial": { "p": 0.2 } },
      "spring": { "kind": "C", "capacitance": 1 }, "friction": { "kind": "R", "law": "e = 0.5*sign(f - 0.2)" }
    },
    "bonds": [ { "from": "v", "to": "m" }, { "from": "v", "to": "spring" }, { "from": "v", "to": "friction" } ],
    "outputs": { "x": "spring.q", "v": "m.f" },
    "scenes": { "main": { "stop": 2.4, "samples": 13 } } })json";
  const RunResult result = run_text(direct);
  REQUIRE(result.stop == StopReason::completed);
  for (const double v : column(result, "v")) CHECK(v == Approx(0.2).epsilon(1e-9));
  CHECK(last(result, "x") == Approx(0.48).epsilon(1e-9));
  CompiledModel longer = compile_text(direct);
  longer.inputs.stop = 3.0;
  longer.inputs.output_times = {0.0, 2.5, 3.0};
  const RunResult pulled_off = longer.run();  // x = 0.5 at t = 2.5, then x = 0.5 + 0.2 sin(t - 2.5)
  REQUIRE(pulled_off.stop == StopReason::completed);
  CHECK(last(pulled_off, "x") == Approx(0.5 + 0.2 * std::sin(0.5)).epsilon(1e-5));
}

TEST_CASE("a jump of the speed of the belt lets a block slide that friction held, by every method") {
  // The force is 2 and the mass 4: dv/dt is 0.5 until the block has the belt's speed.
  const std::pair<const char*, double> belts[] = {{"if(t < 2, 0, 1)", 1.0},
                                                  {"if(t < 2, 0, -1)", -1.0},
                                                  {"if(t < 1, 0.2*t, 0.2) + if(t < 2, 0, 0.5)", 0.7},
                                                  {"if(t < 1, 0.2*t, 0.2) + if(t < 2, 0, 1e-4)", 0.2001},
                                                  {"if(t < 2, 0, if(t < 3, 0.3, 0.1))", 0.1},
                                                  {"if(t < 2, 0, 100)", 2.0}};
  for (const auto& [speed, reached] : belts)
    for (const Method method :
         {Method::automatic, Method::bdf, Method::erk5, Method::ida, Method::dirk3, Method::erk4}) {
      CAPTURE(speed, method_name(method));
      const RunResult run = run_text(R"x({"bgsim": 1, "name": "belt", "elements": {
          "belt": {"kind": "MSf", "flow": ")x" +
                                         std::string(speed) +
                                         R"x("}, "z": {"kind": "0"}, "b": {"kind": "1"},
          "rub": {"kind": "R", "law": "e = 2*sign(f)"}, "m": {"kind": "I", "inertance": 4}},
        "bonds": [{"from": "belt", "to": "z"}, {"from": "z", "to": "rub"}, {"from": "z", "to": "b"}, {"from": "b", "to": "m"}],
        "outputs": {"v": "m.f"}, "scenes": {"s": {"stop": 6, "samples": 61}}})x",
                                     with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      CHECK(std::abs(last(run, "v") - reached) < 1e-6 * std::max(1.0, std::abs(reached)));  // a tolerance
    }
}

TEST_CASE("two blocks are held at once and let go one after the other") {
  // a spring between them is stretched by a slow pull on the second: it slips at 0.1, the first when the spring does
  // 0.1
  const std::string text = R"json({ "bgsim": 1, "name": "two blocks",
    "elements": {
      "pull": { "kind": "Se", "effort": "0.1*t" },
      "v1": { "kind": "1" }, "m1": { "kind": "I", "inertance": 1 }, "f1": { "kind": "R", "law": "e = 0.1*sign(f)" },
      "v2": { "kind": "1" }, "m2": { "kind": "I", "inertance": 1 }, "f2": { "kind": "R", "law": "e = 0.1*sign(f)" },
      "between": { "kind": "0" }, "spring": { "kind": "C", "capacitance": 1 }
    },
    "bonds": [ { "from": "pull", "to": "v2" }, { "from": "v2", "to": "m2" }, { "from": "v2", "to": "f2" },
      { "from": "v2", "to": "between" }, { "from": "between", "to": "spring" }, { "from": "between", "to": "v1" },
      { "from": "v1", "to": "m1" }, { "from": "v1", "to": "f1" } ],
    "outputs": { "s": "spring.q", "p1": "m1.p", "p2": "m2.p", "F1": "f1.e", "F2": "f2.e" },
    "scenes": { "main": { "stop": 0.9, "samples": 4 } } })json";
  const RunResult held = run_text(text);
  REQUIRE(held.stop == StopReason::completed);
  CHECK(last(held, "F2") == Approx(0.09).epsilon(1e-9));
  CHECK(std::abs(last(held, "F1")) < 1e-9);
  CHECK(std::abs(last(held, "p2")) < 1e-12);
  CompiledModel longer = compile_text(text, with_relative(1e-8));
  longer.inputs.stop = 2.0;
  longer.inputs.output_times = {0.0, 1.5, 2.0};
  const RunResult one = longer.run();  // the second alone, as in the test above: s = 0.1 ((t - 1) - sin(t - 1))
  REQUIRE(one.stop == StopReason::completed);
  CHECK(one.report.state_events == 1);
  CHECK(last(one, "s") == Approx(0.1 * (1.0 - std::sin(1.0))).margin(1e-7));
  CHECK(last(one, "F1") == Approx(last(one, "s")).epsilon(1e-9));
}

TEST_CASE("friction that holds stays where it is beside stores of any law", "[long]") {
  // Of the flow sin t two momenta take what the friction does not, which holds: sin t = p + f(p) for both have one
  // effort.
  struct Law {
    std::string text;
    double (*flow)(double);
  };
  for (const Law& law : {Law{"asinh(p)", [](double p) { return std::asinh(p); }},
                         Law{"p + 0.1*p^3", [](double p) { return p + 0.1 * p * p * p; }},
                         Law{"p/sqrt(1 + p^2)", [](double p) { return p / std::sqrt(1.0 + p * p); }},
                         Law{"tanh(p)", [](double p) { return std::tanh(p); }}})
    for (const std::string friction : {"sign(f)", "sign(f) + 0.3*f"})
      for (const Method method : {Method::automatic, Method::bdf, Method::erk5, Method::rodas5p, Method::ida})
        for (const double relative : {1e-6, 1e-9}) {
          INFO(law.text << ", " << friction << ", " << facts_of(method).name << ", " << relative);
          const RunResult result = run_text(
              R"x({"bgsim": 1, "name": "held", "elements": {"z": {"kind": "0"}, "s": {"kind": "Sf", "flow": "sin(t)"},
                "r": {"kind": "R", "law": "e = )x" +
                  friction + R"x("}, "i1": {"kind": "I", "inertance": 1},
                "i2": {"kind": "I", "law": "f = )x" +
                  law.text + R"x("}},
                "bonds": [{"from": "s", "to": "z"}, {"from": "z", "to": "r"}, {"from": "z", "to": "i1"}, {"from": "z", "to": "i2"}],
                "outputs": {"p": "i1.p", "f": "r.f"}, "scenes": {"run": {"stop": 10, "samples": 11}}})x",
              with_method(method, relative));
          REQUIRE(result.stop == StopReason::completed);
          double p = -0.3;  // at t = 10, by Newton's method with the slope 1 + f'(0) = 2, which no law exceeds by half
          for (int k = 0; k < 200; ++k) p += (std::sin(10.0) - p - law.flow(p)) / 2.0;
          // A thousand tolerances: nothing draws f back, so that the errors of all steps add up. (It was 0.9 % at every
          // tolerance.)
          CHECK(last(result, "p") == Approx(p).margin(1000.0 * relative));
          CHECK(std::abs(last(result, "f")) < 1000.0 * relative);
        }
}

TEST_CASE("a condition on what friction holds changes where it does, however long the steps are") {
  // Nothing moves: the block is pushed by 1 and holds up to 2, so that the condition is sin(3 t) > 0.3, and true again
  // from each (2 pi k + asin(0.3))/3 on, 48 times in 100 s. Looked at in single points of a step, 3 to 11 were seen.
  for (const Method method : {Method::automatic, Method::bdf, Method::erk5, Method::dirk5, Method::radau}) {
    INFO(method_name(method));
    const RunResult result = run_text(R"x({"bgsim": 1, "name": "held", "elements": {"j": {"kind": "1"},
      "m": {"kind": "I", "inertance": 1}, "fr": {"kind": "R", "law": "e = 2*sign(f)"}, "F": {"kind": "Se", "effort": 1},
      "n": {"kind": "0"}, "c": {"kind": "C", "capacitance": 1}},
      "bonds": [{"from": "F", "to": "j"}, {"from": "j", "to": "m"}, {"from": "j", "to": "fr"}, {"from": "n", "to": "c"}],
      "events": {"e": {"when": "sin(3*t) + 0.2*fr.e > 0.5", "set": {"c.q": "pre(c.q) + 1"}}},
      "outputs": {"n": "c.q", "v": "m.f"}, "scenes": {"s": {"stop": 100, "samples": 11}}})x",
                                      with_method(method));
    REQUIRE(result.stop == StopReason::completed);
    CHECK(last(result, "n") == Approx(48.0).epsilon(1e-9));  // a sum of ones, but for what the store adds in each step
    CHECK(last(result, "v") == 0.0);
  }
}

TEST_CASE("friction lets go where the push exceeds it for a part of a step only") {
  // The push is beyond the limit of 2 for 0.06 s about each 2 pi k + pi/2; each time the block is moved a little. It is
  // seen by the mode's own margin.
  for (const Method method : {Method::automatic, Method::bdf, Method::erk5, Method::radau}) {
    INFO(method_name(method));
    const RunResult result = run_text(R"x({"bgsim": 1, "name": "creep", "elements": {"j": {"kind": "1"},
      "m": {"kind": "I", "inertance": 1}, "fr": {"kind": "R", "law": "e = 2*sign(f)"},
      "F": {"kind": "Se", "effort": "1 + 1.0005*sin(t)"}},
      "bonds": [{"from": "F", "to": "j"}, {"from": "j", "to": "m"}, {"from": "j", "to": "fr"}],
      "signals": {"x": {"integral": "m.f"}},
      "outputs": {"x": "x"}, "scenes": {"s": {"stop": 62.8, "samples": 11}}})x",
                                      with_method(method, 1e-8));
    REQUIRE(result.stop == StopReason::completed);
    // Of one of the ten, from where sin t = 1/1.0005 on: v(s) = int (1.0005 sin t - 1) dt until it is 0 again.
    const double begin = std::asin(1.0 / 1.0005);
    const auto speed = [&](double t) { return 1.0005 * (std::cos(begin) - std::cos(t)) - (t - begin); };
    double moved = 0.0, v = 0.0;
    constexpr double h = 1e-6;  // the midpoint rule: its error is below 1e-9 of what is moved
    for (double t = begin; v >= 0.0; t += h) {
      v = speed(t + h / 2);
      if (v > 0.0) moved += v * h;
    }
    CHECK(last(result, "x") == Approx(10.0 * moved).epsilon(1e-4));
  }
}
