// Known times and conditions on states.
#include <catch2/catch.hpp>

#include "support/files.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// One store q' = flow.
std::string integrator(const std::string& flow, const std::string& initial, const std::string& scene,
                       const std::string& more_outputs = "") {
  return R"json({ "bgsim": 1, "name": "integrator",
    "parameters": { "width": 1e-3, "height": 1000 },
    "elements": {
      "source": { "kind": "MSf", "flow": ")json" +
         flow + R"json(" },
      "tank": { "kind": "0" },
      "store": { "kind": "C", "capacitance": 1, "initial": { "q": )json" +
         initial + R"json( } }
    },
    "bonds": [ { "from": "source", "to": "tank" }, { "from": "tank", "to": "store" } ],
    "outputs": { "q": "store.q", "rate": "source.f")json" +
         more_outputs + R"json( },
    "scenes": { "main": )json" +
         scene + " } }";
}

/// E in series with R and C.
std::string charging(const std::string& effort, const std::string& r, const std::string& c, const std::string& scene) {
  return R"json({ "bgsim": 1, "name": "charging", "parameters": { "width": 1e-3, "height": 1000 },
    "elements": {
      "source": { "kind": "Se", "effort": ")json" +
         effort + R"json(" }, "loop": { "kind": "1" },
      "r": { "kind": "R", "resistance": )json" +
         r + R"json( }, "c": { "kind": "C", "capacitance": )json" + c + R"json( }
    },
    "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "c" } ],
    "outputs": { "v": "c.e", "u": "source.e" },
    "scenes": { "main": )json" +
         scene + " } }";
}

}  // namespace

TEST_CASE("a known time may be as near to 0 as doubles are") {
  // ceil(t/2) changes two denormal numbers after 0, since half of one is rounded to 0. 1 - exp(-1) beside the errors
  // of runs at 1e-9: 2e-8 is ten times the largest of them.
  for (const std::string flow :
       {"ceil(t/2) - store.q", "if(t > 1e-310, 1, 2) - store.q", "if(t > 1e-200, 1, 2) - store.q"})
    for (const Method method : {Method::automatic, Method::bdf, Method::adams, Method::ida, Method::erk5, Method::dirk4,
                                Method::radau, Method::rodas5p}) {
      INFO(flow << ", " << method_name(method));
      const RunResult result =
          run_text(integrator(flow, "0", R"({ "stop": 1, "samples": 2 })"), with_method(method, 1e-9));
      REQUIRE(result.stop == StopReason::completed);
      CHECK(std::abs(last(result, "q") + std::expm1(-1.0)) < 2e-8);
    }
}

TEST_CASE("no pulse is too narrow to be seen") {
  const std::string pulse = "if(t >= 5 and t < 5 + width, height, 0)";
  const std::string text = charging(pulse, "1", "1", R"({ "stop": 10, "samples": 2 })");
  // v(10) = height (1 - exp(-w)) exp(-(10 - (5 + w))) with w the width in double precision
  for (const double width : {1.0, 1e-3, 1e-6, 1e-9, 1e-12}) {
    const double seen = (5.0 + width) - 5.0;
    const RunResult result =
        run_text(text, with_parameters({"width=" + std::to_string(width * 1e12) + "*1e-12", "height=1/width"}));
    REQUIRE(result.stop == StopReason::completed);
    CHECK(result.report.time_events == 2);
    const double exact = (-std::expm1(-seen)) / width * std::exp(-(5.0 - seen));
    CHECK(last(result, "v") == Approx(exact).epsilon(2e-3));  // the tail has decayed to 0.7 % of the peak: see below
    CHECK(std::abs(last(result, "v") - exact) < 1e-5);        // relative to the peak of 1
  }
}

TEST_CASE("a square wave is followed edge by edge") {
  CompiledModel square = compile_text(
      charging("if(1000*t - floor(1000*t) < 0.5, 1, 0)", "1000", "1e-6", R"({ "stop": 1, "samples": 2 })"));
  square.inputs.stop = 0.1;
  square.inputs.output_times = {0.0, 0.1};
  const RunResult result = square.run();
  REQUIRE(result.stop == StopReason::completed);
  // two edges a period, and the floor changes with one of them
  CHECK(result.report.time_events == 200);
  // after 100 periods of 1 ms the swing is steady: minimum 1/(1 + e^0.5)
  CHECK(last(result, "v") == Approx(1.0 / (1.0 + std::exp(0.5))).margin(1e-5));
}

TEST_CASE("an output at the moment of a jump shows what comes after it") {
  const RunResult result =
      run_text(charging("step(t) + step(t - 0.5) + step(t - 1)", "1", "1", R"({ "stop": 1, "samples": 5 })"));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(column(result, "u") == std::vector<double>{1.0, 1.0, 2.0, 2.0, 3.0});
  CHECK(result.trace.times == std::vector<double>{0.0, 0.25, 0.5, 0.75, 1.0});
}

TEST_CASE("a run of no length shows its first point") {
  CompiledModel model = compile_text(charging("step(t)", "1", "1", R"({ "stop": 1, "samples": 2 })"));
  model.inputs.stop = 0.0;
  model.inputs.output_times = {0.0};
  const RunResult result = model.run();
  CHECK(result.stop == StopReason::completed);
  CHECK(result.trace.times == std::vector<double>{0.0});
  CHECK(last(result, "u") == 1.0);
}

TEST_CASE("the trace has exactly the times asked for, however many fall into one step") {
  CompiledModel model = compile_text(charging("sin(t)", "1", "1", R"({ "stop": 1, "samples": 2 })"));
  model.inputs.output_times = OutputTimes::equidistant(0.0, 1.0, 20001);
  const RunResult result = model.run();
  REQUIRE(result.trace.times == model.inputs.output_times.list());
  CHECK(result.report.steps < 200);
  const std::vector<double> v = column(result, "v");
  double error = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const double t = model.inputs.output_times[i];
    error = std::max(error, std::abs(v[i] - (std::sin(t) - std::cos(t) + std::exp(-t)) / 2));
  }
  CHECK(error < 2e-5);
}

TEST_CASE("a condition on a state changes where it does, not where a step ends") {
  // q = 1 - t/2 down to 0.25 at t = 1.5, from there on with -1/8
  const std::string flow = "if(store.q > 0.25, -0.5, -0.125)";
  const RunResult result = run_text(integrator(flow, "1", R"({ "stop": 2, "samples": 5 })"));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.state_events == 1);
  CHECK(column(result, "rate") == std::vector<double>{-0.5, -0.5, -0.5, -0.125, -0.125});
  // piecewise linear: exact but for rounding
  CHECK(last(result, "q") == Approx(0.25 - 0.125 * 0.5).epsilon(1e-12));
}

TEST_CASE("a condition that holds for a moment within a step is seen") {
  // q = t^2 - t dips below -0.2499 around t = 0.5 for 0.02, and adds 1 to the rate meanwhile
  const std::string text = R"json({ "bgsim": 1, "name": "dip",
    "elements": {
      "force": { "kind": "Se", "effort": 2 }, "v": { "kind": "1" },
      "m": { "kind": "I", "inertance": 1, "initial": { "p": -1 } },
      "x": { "kind": "C", "law": "e = 0*q" },
      "count": { "kind": "MSf", "flow": "if(x.q < -0.2499, 1, 0)" }, "n": { "kind": "0" },
      "counter": { "kind": "C", "capacitance": 1 }
    },
    "bonds": [ { "from": "force", "to": "v" }, { "from": "v", "to": "m" }, { "from": "v", "to": "x" },
      { "from": "count", "to": "n" }, { "from": "n", "to": "counter" } ],
    "outputs": { "x": "x.q", "held": "counter.q" },
    "scenes": { "main": { "stop": 1, "samples": 2 } } })json";
  const RunResult result = run_text(text, with_relative(1e-9));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.state_events == 2);
  CHECK(last(result, "held") == Approx(0.02).epsilon(1e-4));
}

TEST_CASE("a sign that starts at zero goes the way it is pushed") {
  const RunResult up = run_text(integrator("1 + sign(store.q)", "0", R"({ "stop": 1, "samples": 2 })"));
  REQUIRE(up.stop == StopReason::completed);
  CHECK(last(up, "q") == Approx(2.0).epsilon(1e-9));
  const RunResult down = run_text(integrator("-1 + 0.5*sign(store.q)", "0", R"({ "stop": 1, "samples": 2 })"));
  REQUIRE(down.stop == StopReason::completed);
  CHECK(last(down, "q") == Approx(-1.5).epsilon(1e-9));
}

TEST_CASE("a sign that starts at zero and is not pushed stays there") {
  const RunResult result = run_text(integrator("-sign(store.q)", "0", R"({ "stop": 1, "samples": 3 })"));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(column(result, "q") == std::vector<double>{0.0, 0.0, 0.0});
  CHECK(result.report.state_events == 0);
}

TEST_CASE("a relation that starts exactly on its border is not lost") {
  // q < 0 is false at q = 0, and true at once afterwards
  const RunResult result = run_text(integrator("if(store.q < 0, -3, -1)", "0", R"({ "stop": 1, "samples": 2 })"));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(last(result, "q") == Approx(-3.0).epsilon(1e-9));
}

TEST_CASE("a jump that turns another relation takes it along in the same moment") {
  // the guard of the second condition contains the first: both change at t = 1
  const std::string flow = "if(if(store.q > 1, 5, 0) > 2, -1, 1)";
  const RunResult result = run_text(integrator(flow, "0.5", R"({ "stop": 0.4, "samples": 2 })"));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(last(result, "q") == Approx(0.9).epsilon(1e-9));
}

TEST_CASE("floor of a state steps through its integers") {
  // rate 1 + floor(q): 1 until q = 1 (t = 1), then 2 (t = 1.5), then 3 (t = 1.8333)
  const RunResult result = run_text(integrator("1 + floor(store.q)", "0", R"({ "stop": 1.75, "samples": 8 })"));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.state_events == 2);
  CHECK(last(result, "q") == Approx(2.0 + 3.0 * 0.25).epsilon(1e-9));
}

TEST_CASE("an event whose guard wavers by the tolerance of a loop's solution is located all the same") {
  // Whether ceil(b.e) <= b.e rests on roundings of the bridge's node, which a loop of diodes determines.
  std::string text = file_text(in_project("tests/data/models/diode_bridge.json"));
  const std::string outputs = "\"outputs\": {";
  text.insert(text.find(outputs) + outputs.size(), R"json("y": "if(ceil(b.e) <= b.e, 0.5, b.e)", )json");
  CHECK(run_text(text).stop == StopReason::completed);
}
