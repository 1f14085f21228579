/// What the outputs are over a run, measured between its records.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "support/rounds.hpp"
#include "support/run.hpp"

namespace {

using namespace bgsim;

SimulateOptions measured() {
  SimulateOptions options = test::untimed();
  options.measures = true;
  return options;
}

std::string swing(const std::string &scene) {
  return R"x({ "bgsim": 1, "name": "swing", "elements": {
    "speed": { "kind": "1" }, "mass": { "kind": "I", "inertance": 2 },
    "spring": { "kind": "C", "capacitance": 0.125, "initial": { "q": 1 } } },
  "bonds": [ { "from": "speed", "to": "mass" }, { "from": "speed", "to": "spring" } ],
  "outputs": { "x": "spring.q", "square": "spring.q^2", "low": "if(spring.q < 0, 1, 0)" },
  "scenes": { "run": { "stop": 4, )x" +
         scene + " } } }";
}

}  // namespace

TEST_CASE("extremes and integrals of outputs are those between the records, by every kind of method") {
  // x = cos(2 t); the records at 0, 2 and 4 show no extreme.
  constexpr double kTolerance = 1e-9, kError = 2e-6;  // phases and amplitudes drift by some thousand tolerances (BDF)
  for (const Method method : {Method::bdf, Method::adams, Method::ida, Method::erk5, Method::erk8, Method::dirk5,
                              Method::radau, Method::rodas5p}) {
    INFO(facts_of(method).name);
    const auto compiled = test::compile_text(swing("\"samples\": 3"), test::with_method(method, kTolerance));
    const RunResult run = compiled.run(measured());
    REQUIRE(run.stop == StopReason::completed);
    REQUIRE(run.report.measures.size() == 3);
    const OutputMeasure &x = run.report.measures[0], &square = run.report.measures[1], &low = run.report.measures[2];
    CHECK(x.initial == 1.0);
    CHECK(x.final == run.trace["x"].back());
    CHECK(std::abs(x.least + 1.0) < kError);
    CHECK(std::abs(x.most - 1.0) < kError);
    // Of equal extremes the errors choose one.
    const double half = std::numbers::pi / 2.0;
    CHECK(std::min(std::abs(x.least_at - half), std::abs(x.least_at - half - std::numbers::pi)) < 1e-3);
    CHECK(std::abs(x.integral - std::sin(8.0) / 2.0) < kError);
    CHECK(std::abs(x.square - (2.0 + std::sin(16.0) / 8.0)) < kError);
    CHECK(std::abs(square.integral - x.square) < 1e-9);
    CHECK(std::abs(square.most - 1.0) < kError);
    CHECK(std::abs(square.least) < 1e-9);
    REQUIRE(low.nonzero_at);
    CHECK(std::abs(*low.nonzero_at - std::numbers::pi / 4.0) < kError);
    CHECK(std::abs(low.integral - std::numbers::pi / 2.0 - (4.0 - 1.25 * std::numbers::pi)) < 3.0 * kError);
    CHECK((low.least == 0.0 && low.most == 1.0));
  }
}

TEST_CASE("integrals of outputs that vary faster than the states are those of the outputs") {
  const auto with_outputs = [](const std::string &outputs) {
    std::string text = swing("\"samples\": 3");
    const std::size_t from = text.find("\"x\": \"spring.q\"");
    return text.replace(from, text.find('}', from) - from, outputs);
  };
  // Integrals over each part agree with those over its halves to the tolerance, so the sums are better than that.
  constexpr double kTolerance = 1e-8;
  for (const Method method : {Method::bdf, Method::erk5, Method::radau, Method::rodas5p}) {
    INFO(facts_of(method).name);
    const auto measures = [&](const std::string &outputs) {
      const RunResult run =
          test::compile_text(with_outputs(outputs), test::with_method(method, kTolerance)).run(measured());
      REQUIRE(run.stop == StopReason::completed);
      for (const std::string &note : run.report.notes) CHECK_THAT(note, !Catch::Contains("too fast"));
      return run.report.measures.front();
    };
    const OutputMeasure wave = measures(R"x("wave": "sin(200*t)")x");
    CHECK(std::abs(wave.integral - (1.0 - std::cos(800.0)) / 200.0) < 4.0 * kTolerance);
    CHECK(std::abs(wave.square - (2.0 - std::sin(1600.0) / 800.0)) < 4.0 * kTolerance);
    const OutputMeasure pulse = measures(R"x("pulse": "exp(-((t - 3.3)/0.05)^2)")x");
    CHECK(std::abs(pulse.integral - 0.05 * std::sqrt(std::numbers::pi)) < 4.0 * kTolerance);
    const OutputMeasure root = measures(R"x("root": "sqrt(t)")x");
    CHECK(std::abs(root.integral - 16.0 / 3.0) < 6.0 * kTolerance);
  }
  // What would take millions of parts is left, and named.
  const auto fast = test::compile_text(with_outputs(R"x("x": "spring.q", "buzz": "sin(1e7*t)")x"));
  const RunResult run = fast.run(measured());
  REQUIRE(run.stop == StopReason::completed);
  std::vector<std::string> named;
  for (const std::string &note : run.report.notes)
    if (note.find("too fast") != std::string::npos) named.push_back(note);
  REQUIRE(named.size() == 1);
  CHECK_THAT(named.front(),
             Catch::Contains("the integral and the extremes of \"buzz\" are less accurate than the tolerance"));
}

TEST_CASE("measures are the same however many times are recorded") {
  for (const Method method : {Method::bdf, Method::radau, Method::rk4}) {
    const std::string step = method == Method::rk4 ? ", \"method\": \"rk4\", \"step\": 0.01" : "";
    const SceneOverrides overrides = step.empty() ? test::with_method(method) : SceneOverrides{};
    const RunResult few = test::run_text(swing("\"samples\": 2" + step), overrides, measured()),
                    many = test::run_text(swing("\"samples\": 5000" + step), overrides, measured());
    CHECK(few.report.measures[0].least == many.report.measures[0].least);
    CHECK(few.report.measures[0].integral == many.report.measures[0].integral);
  }
}

TEST_CASE("jumps of sources are measured from their edges, with states and without") {
  const double pi = std::numbers::pi;
  for (const bool states : {true, false}) {
    const std::string mass = states ? R"x(, "m": { "kind": "I", "inertance": 1 })x" : "";
    const std::string bond = states ? R"x(, { "from": "loop", "to": "m" })x" : "";
    const RunResult run = test::run_text(R"x({ "bgsim": 1, "name": "jumps", "elements": {
      "push": { "kind": "MSe", "effort": "if(t >= 0.3 and t < 0.4, 5, sin(pi*t))" }, "loop": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1 } )x" +
                                             mass +
                                             R"x( },
      "bonds": [ { "from": "push", "to": "loop" }, { "from": "loop", "to": "r" } )x" +
                                             bond + R"x( ],
      "outputs": { "u": "push.e", "f": "r.f", "on": "if(push.e > 4, 1, 0)" },
      "scenes": { "run": { "stop": 1, "samples": 2 } } })x",
                                         {}, measured());
    REQUIRE(run.stop == StopReason::completed);
    const OutputMeasure &u = run.report.measures[0], &on = run.report.measures[2];
    CHECK(u.most == 5.0);
    CHECK(u.most_at == 0.3);
    // The sine less its part under the pulse; in steps as long as a mass of 1 allows the rules are right to 1e-9.
    const double rest = (2.0 - (std::cos(0.3 * pi) - std::cos(0.4 * pi))) / pi;
    CHECK(std::abs(u.integral - (0.5 + rest)) < 1e-9);
    REQUIRE(on.nonzero_at);
    CHECK(*on.nonzero_at == 0.3);
    CHECK(std::abs(on.integral - 0.1) < 1e-15);
  }
}

TEST_CASE("of peaks that are equal but for rounding the first gives the time") {
  // A saw tooth of height 0.8: its peaks are what rounding makes of 0.8, and the third is the largest.
  const RunResult run = test::run_text(R"x({ "bgsim": 1, "name": "saw", "signals": { "x": { "integral": "1" } },
      "elements": { "cap": { "kind": "C", "capacitance": 1 }, "res": { "kind": "R", "resistance": 1 } },
      "bonds": [ { "from": "cap", "to": "res" } ], "events": { "back": { "when": "x >= 0.8", "set": { "x": "0" } } },
      "outputs": { "x": "x", "down": "-x" }, "scenes": { "run": { "stop": 3.25, "samples": 2 } } })x",
                                       {}, measured());
  REQUIRE(run.stop == StopReason::completed);
  const OutputMeasure &x = run.report.measures[0], &down = run.report.measures[1];
  // Straight lines: exact but for roundings of the states and of events.
  CHECK(std::abs(x.most - 0.8) < 1e-14);
  CHECK(std::abs(x.most_at - 0.8) < 1e-14);
  CHECK(std::abs(down.least_at - 0.8) < 1e-14);
  CHECK(x.least_at == 0.0);
}

TEST_CASE("measures go on over changes of switches") {
  // A capacitor of 1 F behind 1 ohm at 1 V; after 1 s the switch opens and it keeps its voltage.
  const Study study = Study::from_text(R"x({ "bgsim": 1, "name": "held", "elements": {
    "s": { "kind": "Se", "effort": 1 }, "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
    "k": { "kind": "Sw", "closed": "t < 1" }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "k" },
      { "from": "loop", "to": "c" } ],
    "outputs": { "u": "c.e", "i": "r.f" }, "scenes": { "run": { "stop": 2, "samples": 2, "relative": 1e-9 } } })x");
  const RunResult switched = study.scene().simulate(measured());
  REQUIRE(switched.stop == StopReason::completed);
  REQUIRE(switched.report.measures.size() == 2);
  const OutputMeasure &u = switched.report.measures[0], &i = switched.report.measures[1];
  const double held = 1.0 - std::exp(-1.0);
  constexpr double kError = 1e-8;  // ten tolerances
  CHECK(std::abs(u.final - held) < kError);
  CHECK(std::abs(u.integral - (std::exp(-1.0) + held)) < kError);
  CHECK(std::abs(i.most - 1.0) < kError);
  CHECK(std::abs(i.integral - held) < kError);
  CHECK(i.final == 0.0);
}

TEST_CASE("an output without a value on the way leaves a run without measures, and snapshots have none") {
  const RunResult run = test::run_text(R"x({ "bgsim": 1, "name": "root", "elements": {
    "s": { "kind": "Se", "effort": -1 }, "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
    "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } } },
    "bonds": [ { "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "c" } ],
    "outputs": { "y": "sqrt(c.q)" }, "scenes": { "run": { "stop": 2, "times": [0] } } })x",
                                       {}, measured());
  CHECK(run.stop == StopReason::completed);
  CHECK(run.report.measures.empty());
  CHECK(!run.report.why_not_measured.empty());
  SimulateOptions options = measured();
  options.snapshot = [](double, const std::string &) {};
  const auto compiled = test::compile_text(swing("\"samples\": 2"));
  CHECK_THROWS_AS(compiled.run(options), std::invalid_argument);
}

TEST_CASE("integrals of outputs with kinks are those of the kinked output, wherever the kinks are") {
  // A kink between the end of a part and its outermost points is seen by no rule alone: 1.27724087 for |sin(50 t)|
  // over 2 s instead of 1.27724638, at every tolerance.
  const auto exact = [](double w) {
    const double halves = std::floor(2.0 * w / std::numbers::pi);
    return (2.0 * halves + 1.0 - std::cos(2.0 * w - halves * std::numbers::pi)) / w;
  };
  for (const double relative : {1e-6, 1e-10})
    for (const double w : {3.0, 7.7, 12.1, 20.0, 33.3, 50.0, 71.0, 88.8, 124.0, 500.0}) {
      CAPTURE(relative, w);
      const auto compiled = test::compile_text(
          R"x({ "bgsim": 1, "name": "kinks", "elements": { "s": { "kind": "Se", "effort": 5 }, "l": { "kind": "1" },
            "r": { "kind": "R", "resistance": 1 }, "c": { "kind": "C", "capacitance": 0.3 } },
          "bonds": [ { "from": "s", "to": "l" }, { "from": "l", "to": "r" }, { "from": "l", "to": "c" } ],
          "outputs": { "size": "abs(sin()x" +
              std::to_string(w) + R"x(*t))" }, "scenes": { "run": { "stop": 2, "samples": 3 } } })x",
          test::with_method(Method::automatic, relative));
      const RunResult run = compiled.run(measured());
      REQUIRE(run.stop == StopReason::completed);
      // Each part within the tolerance; and what rounding leaves of a sum of some thousand.
      CHECK(std::abs(run.report.measures[0].integral - exact(w)) < 4.0 * relative * exact(w) + 1e-12);
    }
}

TEST_CASE("pulses of outputs between the points of a step are found, of time and of states") {
  // Of u = (x - at)/width with x' = 1, or x = t: no step knows of it, since it drives nothing.
  struct Shape {
    std::string begin, end;
    double area;
  };
  for (const Shape &shape : {Shape{"exp(-", "^2)", std::sqrt(std::numbers::pi)}, Shape{"max(0, 1 - ", "^2)", 4.0 / 3.0},
                             Shape{"1/cosh(", ")^2", 2.0}})
    for (const char *x : {"t", "clock"})
      for (const double width : {1e-3, 1e-5})
        for (const double at : {0.5, 0.4321, 0.9137}) {
          CAPTURE(shape.begin, x, width, at);
          const std::string u = "((" + std::string(x) + " - " + std::to_string(at) + ")/" + std::to_string(width) + ")";
          const auto compiled = test::compile_text(
              R"x({ "bgsim": 1, "name": "pulse", "signals": { "clock": { "integral": "1" } },
                "elements": { "s": { "kind": "Se", "effort": 1 }, "r": { "kind": "R", "resistance": 1 } },
                "bonds": [ { "from": "s", "to": "r" } ], "outputs": { "z": ")x" +
                  shape.begin + u + shape.end + R"x(", "clock": "clock" },
                "scenes": { "run": { "stop": 1, "samples": 11 } } })x",
              test::with_method(Method::automatic, 1e-6));
          const RunResult run = compiled.run(measured());
          REQUIRE(run.stop == StopReason::completed);
          const OutputMeasure &z = run.report.measures[0];
          // At the top, where the search ends within half the digits of the time: (1e-8/width)^2.
          CHECK(std::abs(z.most - 1.0) < 1e-5);
          CHECK(std::abs(z.most_at - at) < 1e-2 * width);
          // The time's own rounding moves the pulse by 1e-16/width of itself.
          CHECK(std::abs(z.integral / (width * shape.area) - 1.0) < 1e-5);
          for (const std::string &note : run.report.notes) CHECK(note.find("less accurate") == std::string::npos);
        }
}

TEST_CASE("extremes have their digits in any unit of time") {
  for (const double unit : {1e-12, 1e-9, 1e-6, 1.0, 1e6}) {
    std::ostringstream text;
    text.precision(17);
    text << R"x({ "bgsim": 1, "name": "wave", "elements": { "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
      "l": { "kind": "I", "inertance": )x"
         << unit << R"x( }, "v": { "kind": "Se", "effort": "sin(t/)x" << unit << R"x()" } },
      "bonds": [ { "from": "v", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "l" } ],
      "outputs": { "v": "v.e" }, "scenes": { "run": { "stop": )x"
         << 20.0 * unit << ", \"samples\": 11 } } }";
    const RunResult run = test::compile_text(text.str()).run(measured());
    INFO(unit);
    REQUIRE(run.stop == StopReason::completed);
    const OutputMeasure &v = run.report.measures.front();
    CHECK(std::abs(v.most - 1.0) < 1e-12);
    CHECK(std::abs(v.least + 1.0) < 1e-12);
    // Half the digits: a sine is flat at its top. The first of the three peaks.
    CHECK(std::abs(v.most_at / unit - std::numbers::pi / 2.0) < 1e-7);
    CHECK(std::abs(v.least_at / unit - 3.0 * std::numbers::pi / 2.0) < 1e-7);
  }
}

TEST_CASE("the time of an extreme is that of the extreme, wherever the steps end beside it") {
  // Where a step ended just before the top, a lower value of the same step was taken for a valley behind it, and the
  // top for a second peak of the same height: 1e-3 late or early, the root of the tolerance.
  for (const Method method : {Method::automatic, Method::bdf, Method::erk5, Method::rodas5p})
    for (std::uint64_t k = 0; k < test::share_of(200); ++k) {
      const double w = 0.4 + 0.0065 * static_cast<double>(k % 200);
      std::ostringstream text;
      text << R"x({ "bgsim": 1, "name": "osc", "elements": { "v": { "kind": "1" },
        "i": { "kind": "I", "inertance": 1, "initial": { "p": 1 } }, "c": { "kind": "C", "capacitance": "1/)x"
           << w << R"x(^2" } }, "bonds": [ { "from": "v", "to": "i" }, { "from": "v", "to": "c" } ],
        "outputs": { "x": "c.q" }, "scenes": { "run": { "stop": 6 } } })x";
      const RunResult run = test::compile_text(text.str(), test::with_method(method)).run(measured());
      INFO(w << " by " << method_name(method));
      REQUIRE(run.stop == StopReason::completed);
      // The phase is off by no more at 1e-6: 2.6e-5 by bdf.
      CHECK(std::abs(run.report.measures.front().most_at - std::numbers::pi / 2.0 / w) < 1e-4);
    }
}
