// Runs that are continued from snapshots.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

struct Taken {
  double t;
  std::string text;
};

/// A run with snapshots every so many steps, and at its end. Not too often: steps are short after each.
RunResult run_with_snapshots(const CompiledModel& model, std::uint64_t every, std::vector<Taken>& taken,
                             std::uint64_t max_steps = 0) {
  SimulateOptions options;
  options.energy_course = 20;
  options.max_steps = max_steps;
  options.snapshot_steps = every;
  options.snapshot = [&taken](double t, const std::string& text) { taken.push_back({t, text}); };
  return model.run(options);
}

RunResult resumed(const CompiledModel& model, const Taken& from, std::uint64_t every) {
  SimulateOptions options;
  options.energy_course = 20;
  options.resume = from.text;
  options.snapshot_steps = every;
  options.snapshot = [](double /*t*/, const std::string& /*text*/) {};
  return model.run(options);
}

/// Rows of @p whole from the first one that @p part has: the same bits, and all of those after the snapshot.
void check_tail(const RunResult& whole, const RunResult& part, double t) {
  const std::size_t count = part.trace.times.size(), all = whole.trace.times.size();
  REQUIRE(count <= all);
  const std::size_t first = all - count;
  CHECK((first == 0 || whole.trace.times[first - 1] <= t));
  CHECK((count == 0 || whole.trace.times[first] >= t));
  bool same = true;
  for (std::size_t i = 0; i < count; ++i) {
    same = same && part.trace.times[i] == whole.trace.times[first + i];
    for (std::size_t c = 0; c < part.trace.columns.size(); ++c)
      same = same && part.trace.columns[c][i] == whole.trace.columns[c][first + i];
  }
  CHECK(same);
  CHECK(part.report.steps == whole.report.steps);
  CHECK(part.report.rate_evaluations == whole.report.rate_evaluations);
  CHECK(part.report.jacobian_evaluations == whole.report.jacobian_evaluations);
  CHECK(part.report.loop_iterations == whole.report.loop_iterations);
  CHECK(part.report.state_events == whole.report.state_events);
  CHECK(part.report.time_events == whole.report.time_events);
  CHECK(part.report.absolute == whole.report.absolute);
  CHECK(part.report.notes == whole.report.notes);
  CHECK(part.report.energy.residual == whole.report.energy.residual);
  CHECK(part.report.energy.activity == whole.report.energy.activity);
  CHECK(part.report.energy.course.residual == whole.report.energy.course.residual);
  CHECK(part.report.method == whole.report.method);
}

/// From every snapshot, or some thirty of them.
void check_all(const CompiledModel& model, std::uint64_t every) {
  std::vector<Taken> taken;
  const RunResult whole = run_with_snapshots(model, every, taken);
  REQUIRE(whole.stop == StopReason::completed);
  REQUIRE(taken.size() > 2);
  const std::size_t stride = 1 + taken.size() / 30;
  for (std::size_t i = 0; i < taken.size(); i += stride) {
    INFO("from t = " << taken[i].t);
    const RunResult part = resumed(model, taken[i], every);
    REQUIRE(part.stop == StopReason::completed);
    check_tail(whole, part, taken[i].t);
  }
}

/// Dry friction that sticks and slips, a relay with hysteresis by a store, a table, a pulse of time.
const char* const kEvents = R"json({ "bgsim": 1, "name": "events",
  "elements": {
    "belt": { "kind": "Sf", "flow": "0.1 + 0.4*step(t - 3) + 2*exp(-((t - 6)*50)^2)" }, "spring_end": { "kind": "0" },
    "spring": { "kind": "C", "capacitance": 0.5 }, "body": { "kind": "1" }, "mass": { "kind": "I", "inertance": 1 },
    "dry": { "kind": "R", "law": "e = 0.4*sign(f) + 0.05*f" },
    "brake": { "kind": "R", "law": "e = if(f > 0.3, 0.2*(f - 0.3)^2, 0)" }
  },
  "bonds": [ { "from": "belt", "to": "spring_end" }, { "from": "spring_end", "to": "spring" },
             { "from": "spring_end", "to": "body" }, { "from": "body", "to": "mass" }, { "from": "body", "to": "dry" },
             { "from": "body", "to": "brake" } ],
  "outputs": { "x": "spring.q", "v": "mass.f", "d": "dry.e" },
  "scenes": { "main": { "stop": 12, "samples": 121 } } })json";

const char* const kOscillator = R"json({ "bgsim": 1, "name": "oscillator",
  "elements": { "loop": { "kind": "1" }, "l": { "kind": "I", "law": "f = p + 0.1*p^3" },
                "c": { "kind": "C", "capacitance": 0.25, "initial": { "q": 0.25 } } },
  "bonds": [ { "from": "loop", "to": "l" }, { "from": "loop", "to": "c" } ],
  "outputs": { "q": "c.q", "p": "l.p" },
  "scenes": { "main": { "stop": 10, "samples": 101 } } })json";

}  // namespace

TEST_CASE("a run continues from any snapshot bit for bit: models", "[long]") {
  struct Case {
    const char *model, *scene;
    std::uint64_t every;
  };
  for (const Case& c : {Case{"models/bellow.json", "step", 60}, Case{"models/actuator.json", "bending", 400},
                        Case{"models/amplifier.json", "", 1000}, Case{"models/tanks.json", "", 5},
                        Case{"models/quarter_car.json", "", 60}, Case{"models/thermal_chain.json", "", 40}}) {
    INFO(c.model << ' ' << c.scene);
    check_all(compile_file(c.model, {}, c.scene), c.every);
  }
}

TEST_CASE("a run continues from any snapshot bit for bit: methods, with events and friction that sticks", "[long]") {
  for (const Method method : {Method::bdf, Method::adams, Method::erk5, Method::dirk4, Method::radau, Method::radau9,
                              Method::radau13, Method::rodas5p}) {
    INFO(facts_of(method).name);
    check_all(compile_text(kEvents, with_method(method)), 40);
  }
  check_all(compile_file("models/amplifier.json", with_method(Method::ida)), 1000);
  check_all(compile_file("models/wheatstone.json", with_method(Method::ida)), 20);
  SceneOverrides verlet = with_method(Method::verlet);
  verlet.step = 0.01;
  check_all(compile_text(kOscillator, verlet), 100);
  for (const Method method : {Method::rk4, Method::implicit_euler}) {
    INFO(facts_of(method).name);
    SceneOverrides overrides = with_method(method);
    overrides.step = 0.01;
    check_all(compile_text(kEvents, overrides), 17);
  }
}

TEST_CASE("a run that a limit has ended is continued from its last snapshot") {
  const CompiledModel model = compile_file("models/bellow.json", {}, "step");
  std::vector<Taken> taken;
  const RunResult begun = run_with_snapshots(model, 0, taken, 20);
  REQUIRE(begun.failure);
  CHECK(begun.failure->code == "BG607");
  REQUIRE(taken.size() == 1);
  const RunResult rest = resumed(model, taken.back(), 0);
  REQUIRE(rest.stop == StopReason::completed);
  const RunResult whole = model.run();
  CHECK(begun.trace.times.size() + rest.trace.times.size() == whole.trace.times.size());
  // The restart costs steps and moves the end by about the tolerance, 1e-6 of each state.
  for (const char* name : {"P2", "x"}) CHECK(last(rest, name) == Approx(last(whole, name)).epsilon(1e-4));
}

TEST_CASE("a completed run is continued beyond its end") {
  CompiledModel model = compile_file("models/rlc.json");
  const double stop = model.inputs.stop;
  CompiledModel half = model;
  half.inputs.stop = stop / 2;
  half.inputs.output_times = {0.0, stop / 2};
  std::vector<Taken> taken;
  REQUIRE(run_with_snapshots(half, 0, taken).stop == StopReason::completed);
  REQUIRE(taken.size() == 1);
  model.inputs.output_times = {stop};
  const RunResult rest = resumed(model, taken.back(), 0);
  REQUIRE(rest.stop == StopReason::completed);
  const RunResult whole = model.run();
  for (std::size_t c = 0; c < whole.trace.columns.size(); ++c) {
    // Both are within some hundred tolerances of 1e-6 of the exact solution.
    CHECK(rest.trace.columns[c].back() == Approx(whole.trace.columns[c].back()).epsilon(1e-4).margin(1e-4));
  }
}

TEST_CASE("a run that ends beside a known time is continued over it", "[long]") {
  const char* const text = R"json({ "bgsim": 1, "name": "known_times",
    "signals": { "late": { "delay": "cap.e", "by": 0.25 }, "seen": { "value": "cap.e", "every": 0.3, "initial": 0 } },
    "elements": {
      "source": { "kind": "MSe", "effort": "step(t - 1) + if(mod(t, 0.7) < 0.2, 1, 0) - 2*late + seen" },
      "loop": { "kind": "1" }, "load": { "kind": "R", "resistance": 1 },
      "cap": { "kind": "C", "capacitance": 1, "initial": { "e": 1 } } },
    "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "load" }, { "from": "loop", "to": "cap" } ],
    "outputs": { "u": "cap.e", "i": "load.f", "y": "late", "s": "seen" },
    "scenes": { "main": { "stop": 2, "samples": 21 } } })json";
  for (const Method method : {Method::automatic, Method::bdf, Method::radau, Method::erk5}) {
    INFO(facts_of(method).name);
    const CompiledModel model = compile_text(text, with_method(method));
    std::vector<double> known;
    SimulateOptions options = one_run();
    options.events = [&](const RunEvent& event) {
      if (event.t == 0.0) return;
      known.push_back(event.t);
      known.push_back(event.t + 0.25);  // where it comes out of the delay
    };
    const RunResult whole = model.run(options);
    REQUIRE(whole.stop == StopReason::completed);
    REQUIRE(known.size() > 10);
    for (const double t : known)
      for (const double stop : {std::nextafter(t, 0.0), t, std::nextafter(t, 3.0)}) {
        if (!(stop < model.inputs.stop)) continue;
        CAPTURE(t, stop - t);
        CompiledModel part = model;
        part.inputs.stop = stop;
        part.inputs.output_times = {0.0, stop};
        std::vector<Taken> taken;
        REQUIRE(run_with_snapshots(part, 0, taken).stop == StopReason::completed);
        REQUIRE(taken.size() == 1);
        const RunResult rest = resumed(model, taken.back(), 0);
        REQUIRE(rest.stop == StopReason::completed);
        // Known times that are nearer to each other than roundings of the scene are one, but two where it is cut there.
        CHECK(rest.report.time_events >= whole.report.time_events);
        // A restart moves what follows by about the tolerance, 1e-6; a jump that is left out by 0.1 and more.
        for (std::size_t c = 0; c < whole.trace.columns.size(); ++c)
          CHECK(rest.trace.columns[c].back() == Approx(whole.trace.columns[c].back()).margin(1e-4));
      }
  }
}

TEST_CASE("what is no snapshot of this run is refused") {
  const CompiledModel model = compile_file("models/bellow.json", {}, "step");
  std::vector<Taken> taken;
  run_with_snapshots(model, 0, taken, 20);
  REQUIRE(taken.size() == 1);
  const auto refused = [](const CompiledModel& of, const std::string& text, const char* why) {
    SimulateOptions options;
    options.resume = text;
    try {
      (void)of.run(options);
      FAIL("it was taken");
    } catch (const ModelError& error) {
      CHECK(error.diagnostics.front().code == "BG171");
      CHECK_THAT(error.diagnostics.front().situation, Contains(why));
    }
  };
  refused(model, "{}", "is no snapshot");
  refused(model, "t,x\n", "is no snapshot");
  refused(model, taken.back().text.substr(0, taken.back().text.size() / 2), "is no snapshot");
  refused(compile_file("models/bellow.json", {}, "literal"), taken.back().text, "another model, scene");
  refused(compile_file("models/bellow.json", with_relative(1e-7), "step"), taken.back().text, "another model, scene");
  refused(compile_file("models/rlc.json"), taken.back().text, "another model, scene");
  CompiledModel shorter = model;
  shorter.inputs.stop = taken.back().t / 2;
  refused(shorter, taken.back().text, "after the end of the scene");

  // Whatever is changed in what the run is to go on from, however little.
  const auto whole = nlohmann::ordered_json::parse(taken.back().text);
  constexpr const char* kChanged = "not as it was written";
  for (const auto& [key, value] : whole["state"].items()) {
    INFO(key);
    auto without = whole;
    without["state"].erase(key);
    refused(model, without.dump(), kChanged);
    auto other = whole;
    other["state"][key] = "nonsense";
    refused(model, other.dump(), kChanged);
  }
  auto moved = whole;
  moved["state"]["x"][0] = std::nextafter(moved["state"]["x"][0].get<double>(), 1.0);
  refused(model, moved.dump(), kChanged);
  auto far = whole;
  far["state"]["events"]["stiction"]["held"] = {1000000};
  refused(model, far.dump(), kChanged);
  auto unsigned_one = whole;
  unsigned_one.erase("digest");
  refused(model, unsigned_one.dump(), kChanged);
  // As a text it may be written otherwise.
  SimulateOptions options;
  options.resume = whole.dump();
  CHECK(model.run(options).stop == StopReason::completed);
  // A run that keeps something else beside its solution.
  for (const bool audit : {true, false}) {
    SimulateOptions less;
    (audit ? less.energy_audit : less.error_estimate) = false;
    less.resume = taken.back().text;
    try {
      (void)model.run(less);
      FAIL("it was taken");
    } catch (const ModelError& error) {
      CHECK_THAT(error.diagnostics.front().situation, Contains(audit ? "an energy audit" : "an estimate of errors"));
    }
  }
}
