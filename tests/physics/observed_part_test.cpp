/// Models with switches, events and delays: what shares no bond and no signal with the outputs is left out, and the
/// outputs are those of a model without it.
#include <algorithm>
#include <catch2/catch.hpp>

#include "support/run.hpp"

namespace {

using namespace bgsim;

/// A shipped model, quantities of it, and a time within which it switches.
struct Source {
  std::string file, quantity;
  double stop;
};
const std::vector<Source> kSources{{"buck", "coil.f", 2e-4},         {"bouncing_ball", "height", 2.0},
                                   {"thermostat", "room.e", 4000.0}, {"heated_loop", "T_back", 4000.0},
                                   {"sampled_servo", "angle", 0.5},  {"ball_contact", "ground.q", 2.0},
                                   {"half_wave", "l.f", 9.0}};

/// The first as "first", and others beside it, recorded are quantities of the first.
std::string beside(const std::vector<Source>& parts) {
  std::string types, elements;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string name = i == 0 ? "first" : "other" + std::to_string(i), comma = i == 0 ? "" : ", ";
    types += comma + '"' + parts[i].file + "\": \"" + parts[i].file + ".json\"";
    elements += comma + '"' + name + "\": { \"kind\": \"" + parts[i].file + "\" }";
  }
  return R"x({ "bgsim": 1, "name": "beside", "types": { )x" + types + R"x( }, "elements": { )x" + elements +
         R"x( }, "outputs": { "y": "first.)x" + parts.front().quantity + R"x(" },
           "scenes": { "s": { "stop": )x" +
         std::to_string(parts.front().stop) + R"x(, "relative": 1e-8 } } })x";
}

Simulation scene_of(const std::vector<Source>& parts, bool keep_all = false) {
  return Study::from_text(beside(parts), test::in_project("models/beside.json")).scene("s", {}, {.keep_all = keep_all});
}

RunResult completed(const Simulation& scene) {
  RunResult result = scene.simulate(test::untimed());
  INFO((result.failure ? result.failure->situation : ""));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

TEST_CASE("a switched model beside others runs as it does alone, bit for bit") {
  for (std::size_t i = 0; i < kSources.size(); ++i) {
    const std::vector<Source> both{kSources[i], kSources[(i + 1) % kSources.size()],
                                   kSources[(i + 3) % kSources.size()]};
    INFO(both[0].file << " beside " << both[1].file << " and " << both[2].file);
    const RunResult alone = completed(scene_of({kSources[i]}));
    const RunResult part = completed(scene_of(both));
    CHECK(alone.report.mode_changes + alone.report.time_events + alone.report.state_events > 0);
    // What is compiled is the same model under the same names: every operation is.
    CHECK(part.trace.columns == alone.trace.columns);
    CHECK(part.report.steps == alone.report.steps);
    CHECK(part.report.mode_changes == alone.report.mode_changes);
    CHECK(part.report.left_out.elements.size() > 1);
    for (const std::string& name : part.report.left_out.elements) CHECK(name.starts_with("other"));
    CHECK(part.report.left_out.states.size() > alone.report.left_out.states.size());
  }
}

TEST_CASE("what a switched model leaves out does not change its outputs") {
  // Steps end at the other parts' events, too, so only the tolerance holds: a hundredfold of it, which errors of single
  // steps add up to.
  constexpr double kTolerance = 1e-8, kAddedUp = 100.0;
  for (const std::size_t i : {0U, 1U, 5U}) {
    std::vector<Source> both{kSources[i], kSources[(i + 1) % kSources.size()]};
    both.front().stop = std::min(both.front().stop, 1.0);
    INFO(both[0].file << " beside " << both[1].file);
    const RunResult part = completed(scene_of(both)), whole = completed(scene_of(both, true));
    CHECK(whole.report.left_out.nothing());
    const std::vector<double> expected = test::column(whole, "y");
    CHECK(test::largest_difference(expected, test::column(part, "y")) <=
          kAddedUp * kTolerance * test::largest_magnitude(expected));
  }
}

constexpr const char* kBall = R"x({ "bgsim": 1, "name": "ball",
  "parameters": { "e": 0.7 },
  "signals": { "height": { "integral": "ball.f", "initial": 1 }, "hits": { "integral": 0 }, "hops": { "integral": 0 },
    "seen": { "value": "height", "every": 0.1 }, "late": { "delay": "seen", "by": 0.25 },
    "high": { "set": "height > 0.3", "reset": "height < 0.1" }, "bright": "high and t < 1.2" },
  "elements": { "ball": { "kind": "1" }, "mass": { "kind": "I", "inertance": 1 },
    "weight": { "kind": "Se", "effort": -9.81 }, "lamp": { "kind": "Se", "effort": 1 },
    "wire": { "kind": "1" }, "bulb": { "kind": "R", "resistance": 1 }, "press": { "kind": "Sw", "closed": "bright" } },
  "bonds": [ { "from": "weight", "to": "ball" }, { "from": "ball", "to": "mass" },
    { "from": "lamp", "to": "wire" }, { "from": "wire", "to": "bulb" }, { "from": "wire", "to": "press" } ],
  "events": {
    "bounce": { "when": "height <= 0", "set": { "mass.p": "-e*pre(mass.p)", "hits": "pre(hits) + 1" } },
    "hop": { "when": "ball.f > 0", "set": { "hops": "pre(hops) + 1" } } },
  "outputs": { "h": "height", "hits": "hits", "hops": "hops", "seen": "seen", "late": "late", "on": "if(high, 1, 0)",
    "current": "bulb.f", "pressed": "if(mode('press'), 1, 0)" },
  "scenes": { "h": { "stop": 1.5, "outputs": ["h"] }, "hits": { "stop": 1.5, "outputs": ["hits"] },
    "hops": { "stop": 1.5, "outputs": ["hops"] }, "seen": { "stop": 1.5, "outputs": ["seen"] },
    "late": { "stop": 1.5, "outputs": ["late"] }, "on": { "stop": 1.5, "outputs": ["on"] },
    "current": { "stop": 1.5, "outputs": ["current"] }, "pressed": { "stop": 1.5, "outputs": ["pressed"] } } })x";

TEST_CASE("outputs keep the events, memories, delays and switches that they depend on") {
  using Names = std::vector<std::string>;
  const Names lamp{"lamp", "bulb", "press"};
  struct Case {
    const char* scene;
    Names states, elements, signals;
  };
  const Study study = Study::from_text(kBall);
  for (const Case& c : {
           // "hits" is set by the event that the ball needs.
           Case{"h", {"hops", "seen", "high"}, lamp, {"late"}},
           Case{"hits", {"hops", "seen", "high"}, lamp, {"late"}},
           Case{"hops", {"seen", "high"}, lamp, {"late"}},
           Case{"seen", {"hops", "high"}, lamp, {"late"}},
           Case{"late", {"hops", "high"}, lamp, {}},
           Case{"on", {"hops", "seen"}, lamp, {"late"}},
           Case{"current", {"hops", "seen"}, {}, {"late"}},
           Case{"pressed", {"hops", "seen"}, {}, {"late"}},
       }) {
    INFO(c.scene);
    const RunResult part = completed(study.scene(c.scene));
    CHECK(part.report.left_out.states == c.states);
    CHECK(part.report.left_out.elements == c.elements);
    CHECK(part.report.left_out.signals == c.signals);
    const RunResult whole = completed(study.scene(c.scene, {}, {.keep_all = true}));
    CHECK(whole.report.left_out.nothing());
    // Between bounces all is a polynomial of the second degree, which every method integrates to rounding; what is left
    // is the instants', some 1e-12 s of them, times speeds below 5.
    CHECK(test::largest_difference(test::column(whole, c.scene), test::column(part, c.scene)) < 1e-10);
  }
}

TEST_CASE("values for what is left out are taken, and have no effect") {
  const Study study = Study::from_text(kBall);
  const Simulation scene = study.scene("h");
  const RunResult before = completed(scene);
  SceneOverrides overrides;
  overrides.set = {"hops=3", "height=1"};
  CHECK(completed(study.scene("h", overrides)).trace.columns == before.trace.columns);
  CHECK(completed(scene.with("hops", 7.0)).trace.columns == before.trace.columns);
  const RunResult other = completed(scene.with("height", 2.0));
  CHECK(other.trace.columns.front().front() == 2.0);
  CHECK(completed(scene.with("e", 0.6)).trace.columns != before.trace.columns);
}

TEST_CASE("what is stored at the end goes by the elements and signals of the whole model") {
  const Study study = Study::from_text(kBall);
  SceneOverrides overrides;
  overrides.set = {"hops=3"};
  const RunResult part = completed(study.scene("current", overrides));
  const RunResult whole = completed(study.scene("current", overrides, {.keep_all = true}));
  REQUIRE(!part.stored.values.empty());
  CHECK(part.stored.values.size() < whole.stored.values.size());
  for (const RunInputs::Initial& value : part.stored.values) {
    const auto same = std::find_if(whole.stored.values.begin(), whole.stored.values.end(), [&](const auto& other) {
      return other.element == value.element && other.port == value.port && other.signal == value.signal;
    });
    REQUIRE(same != whole.stored.values.end());
    CHECK(value.value == Approx(same->value).margin(1e-10));  // as above
  }
}

TEST_CASE("the mode at the end is one of the whole model") {
  const Study study = Study::from_text(kBall);
  CHECK(completed(study.scene("current")).mode == completed(study.scene("current", {}, {.keep_all = true})).mode);
  // The switch is left out: it is where the model as read has it, open.
  CHECK(completed(study.scene("h")).mode == Mode{false});
}

TEST_CASE("conditions, events, samples and delays connect the parts of a graph") {
  // Two stores that discharge, and what the second one reads of the first.
  const auto parts = [](const std::string& second, const std::string& signals = "", const std::string& more = "") {
    const Study study = Study::from_text(R"x({ "bgsim": 1, "name": "parts", "signals": { )x" + signals + R"x( },
      "elements": { "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "r": { "kind": "R", "resistance": 1 },
        "C": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "J": { "kind": "1" },
        "R": { "kind": "R", "resistance": 1 }, "X": )x" +
                                         second + R"x( },
      "bonds": [ { "from": "c", "to": "r" }, { "from": "C", "to": "J" }, { "from": "J", "to": "R" },
        { "from": "J", "to": "X" } ], )x" +
                                         more + R"x( "outputs": { "q": "C.q" }, "scenes": { "s": { "stop": 1 } } })x");
    const std::vector<Diagnostic>& warnings = study.causality().warnings;
    const bool apart = std::any_of(warnings.begin(), warnings.end(), [](const auto& w) { return w.code == "BG206"; });
    // What is left out is what is not connected.
    CHECK(completed(study.scene("s", {}, {.keep_all = false})).report.left_out.nothing() == !apart);
    return apart ? 2 : 1;
  };
  const std::string sw = R"x({ "kind": "Sw", "closed": )x", diode = R"x({ "kind": "D", "threshold": )x";
  CHECK(parts(sw + R"x("t > 0.5" })x") == 2);
  CHECK(parts(sw + R"x("c.q < 0.5" })x") == 1);
  CHECK(parts(R"x({ "kind": "Sw", "close": "c.q < 0.5", "open": "t > 0.9" })x") == 1);
  CHECK(parts(R"x({ "kind": "Sw", "close": "t > 0.5", "open": "c.q < 0.2" })x") == 1);
  CHECK(parts(diode + "0 }") == 2);
  CHECK(parts(diode + R"x(0, "fire": "c.q < 0.5" })x") == 1);
  const std::string source = R"x({ "kind": "MSe", "effort": )x";
  CHECK(parts(source + R"x("u" })x", R"x("u": { "value": "t", "every": 0.1 })x") == 2);
  CHECK(parts(source + R"x("u" })x", R"x("u": { "value": "c.q", "every": 0.1 })x") == 1);
  CHECK(parts(source + R"x("if(u, 1, 0)" })x", R"x("u": { "set": "c.q < 0.5", "reset": "t < 0" })x") == 1);
  CHECK(parts(source + R"x("u" })x", R"x("u": { "delay": "c.q", "by": 0.1 })x") == 1);
  CHECK(parts(source + R"x("u" })x", R"x("u": { "integral": 0 })x",
              R"x("events": { "e": { "when": "c.q < 0.5", "set": { "u": 1 } } },)x") == 1);
  CHECK(parts(source + R"x("u" })x", R"x("u": { "integral": 0 })x",
              R"x("events": { "e": { "when": "t > 0.5", "set": { "u": "c.q" } } },)x") == 1);
  CHECK(parts(source + R"x("u" })x", R"x("u": { "integral": 0 })x",
              R"x("events": { "e": { "when": "t > 0.5", "set": { "u": 1 } } },)x") == 2);
}

TEST_CASE("a fault that all modes share is found in what is left out, too") {
  const auto text = [](const char* store) {
    return std::string(R"x({ "bgsim": 1, "name": "faulty",
      "signals": { "n": { "integral": 0 } },
      "elements": { "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
        "c": { "kind": "C", "capacitance": 1 }, "a": { "kind": "Se", "effort": 1 }, "b": { "kind": ")x") +
           store + R"x( } },
      "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "c" },
        { "from": "a", "to": "b" } ],
      "events": { "late": { "when": "c.q > 0.5", "set": { "n": 1 } } },
      "outputs": { "q": "c.q" }, "scenes": { "s": { "stop": 1 } } })x";
  };
  CHECK_NOTHROW(Study::from_text(text(R"(R", "resistance": 1)")).scene("s"));
  CHECK_THROWS_AS(Study::from_text(text(R"(Se", "effort": 1)")).scene("s"), ModelError);
}

TEST_CASE("a run that ends in a mode without states does so beside what is left out") {
  // Locked from t = 1 on, nothing is stored: the clock of that mode was taken for a signal of the model, which the part
  // that runs does not have.
  const RunResult run = Study::from_text(R"x({"bgsim": 1, "name": "brake", "signals": {"angle": {"integral": "w.f"}},
      "elements": {"T": {"kind": "Se", "effort": 1}, "w": {"kind": "1"},
        "J": {"kind": "I", "inertance": 0.2, "initial": {"f": 3}}, "b": {"kind": "Sw", "locked": "t >= 1"}},
      "bonds": [{"from": "T", "to": "w"}, {"from": "w", "to": "J"}, {"from": "w", "to": "b"}],
      "outputs": {"w": "w.f"}, "scenes": {"s": {"stop": 2, "samples": 5}}})x")
                            .scene("s")
                            .simulate(SimulateOptions{});
  REQUIRE(run.stop == StopReason::completed);
  CHECK(std::abs(run.trace["w"][1] - 5.5) < 1e-5);  // a tolerance
  CHECK(run.trace["w"].back() == 0.0);
  for (const RunInputs::Initial& value : run.stored.values) CHECK(value.element.valid());
}

}  // namespace
