// Runs of models with switches, diodes and contacts that are continued from snapshots.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "bgsim/modes.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

struct Taken {
  double t;
  std::string text;
  std::size_t rows, events;  ///< given before
};

struct Whole {
  RunResult result;
  std::vector<RunEvent> events;
  std::vector<Taken> taken;
};

SimulateOptions options_of(std::uint64_t every) {
  SimulateOptions options = untimed();
  options.second_run = false;  // a run that goes on from a snapshot has none
  options.energy_course = 20;
  options.snapshot_steps = every;
  return options;
}

Whole run_whole(const Simulation& model, std::uint64_t every, std::uint64_t max_steps = 0) {
  Whole whole;
  SimulateOptions options = options_of(every);
  options.max_steps = max_steps;
  Trace trace;
  options.rows = [&](double t, std::span<const double> row) {
    trace.times.push_back(t);
    trace.columns.resize(row.size());
    for (std::size_t c = 0; c < row.size(); ++c) trace.columns[c].push_back(row[c]);
  };
  options.events = [&](const RunEvent& event) { whole.events.push_back(event); };
  options.snapshot = [&](double t, const std::string& text) {
    whole.taken.push_back({t, text, trace.times.size(), whole.events.size()});
  };
  whole.result = model.simulate(options);
  whole.result.trace.times = std::move(trace.times);
  whole.result.trace.columns = std::move(trace.columns);
  return whole;
}

bool same(const RunEvent& a, const RunEvent& b) {
  return a.kind == b.kind && a.t == b.t && a.name == b.name && a.quantity == b.quantity && a.from == b.from &&
         a.to == b.to && a.impulse == b.impulse && a.energy == b.energy;
}

/// The rest of the run from a snapshot: the same bits as in the whole.
void check_rest(const Simulation& model, const Whole& whole, const Taken& from, std::uint64_t every) {
  INFO("from t = " << from.t);
  SimulateOptions options = options_of(every);
  options.resume = from.text;
  options.snapshot = [](double, const std::string&) {};
  std::vector<RunEvent> events;
  options.events = [&](const RunEvent& event) { events.push_back(event); };
  const RunResult part = model.simulate(options);
  if (part.failure) UNSCOPED_INFO(part.failure->situation);
  REQUIRE(part.stop == StopReason::completed);
  const Trace &all = whole.result.trace, &rest = part.trace;
  REQUIRE(rest.times.size() == all.times.size() - from.rows);
  bool rows = true;
  for (std::size_t i = 0; i < rest.times.size(); ++i) {
    rows = rows && rest.times[i] == all.times[from.rows + i];
    for (std::size_t c = 0; c < rest.columns.size(); ++c)
      rows = rows && rest.columns[c][i] == all.columns[c][from.rows + i];
  }
  CHECK(rows);
  REQUIRE(events.size() == whole.events.size() - from.events);
  bool same_events = true;
  for (std::size_t i = 0; i < events.size(); ++i)
    same_events = same_events && same(events[i], whole.events[from.events + i]);
  CHECK(same_events);
  const RunReport &a = part.report, &b = whole.result.report;
  CHECK(a.steps == b.steps);
  CHECK(a.rate_evaluations == b.rate_evaluations);
  CHECK(a.jacobian_evaluations == b.jacobian_evaluations);
  // Not the iterations of loops: an evaluator that has solved a loop at a point does not solve it there again.
  CHECK(a.time_events == b.time_events);
  CHECK(a.state_events == b.state_events);
  CHECK(a.mode_changes == b.mode_changes);
  CHECK(a.modes == b.modes);
  CHECK(a.impacts == b.impacts);
  CHECK(a.absolute == b.absolute);
  CHECK(a.notes == b.notes);
  CHECK(a.method == b.method);
  CHECK(a.energy.residual == b.energy.residual);
  CHECK(a.energy.switching == b.energy.switching);
  CHECK(a.energy.impacts == b.energy.impacts);
  CHECK(a.energy.events == b.energy.events);
  CHECK(a.energy.activity == b.energy.activity);
  CHECK(a.energy.course.residual == b.energy.course.residual);
  CHECK(a.errors.done == b.errors.done);
  CHECK(a.errors.estimate == b.errors.estimate);
  CHECK(a.set_events.size() == b.set_events.size());
  CHECK(part.stored.values.size() == whole.result.stored.values.size());
}

/// From @p count snapshots spread over the run, the last included, and from those at the instant of an event.
void check_all(const Simulation& model, std::uint64_t every, std::size_t count) {
  const Whole whole = run_whole(model, every);
  if (whole.result.failure) UNSCOPED_INFO(whole.result.failure->situation);
  REQUIRE(whole.result.stop == StopReason::completed);
  REQUIRE(whole.taken.size() > 2);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(i * (whole.taken.size() - 1) / count);
  std::size_t at_events = 0;
  for (std::size_t i = 0; i < whole.taken.size() && at_events < count; ++i) {
    const std::size_t before = whole.taken[i].events;
    if (before == 0 || whole.events[before - 1].t != whole.taken[i].t) continue;
    chosen.push_back(i);
    ++at_events;
  }
  chosen.push_back(whole.taken.size() - 1);
  for (const std::size_t i : chosen) check_rest(model, whole, whole.taken[i], every);
}

/// A chopper with a freewheel diode whose switch follows the current, and a relay with memory beside it.
const char* const kChopper = R"json({ "bgsim": 1, "name": "chopper",
  "parameters": { "V": 24, "L": 0.1, "R": 2 },
  "signals": { "hot": { "set": "coil.f > 4", "reset": "coil.f < 3", "initial": false },
               "charge": { "integral": "coil.f", "initial": 0 },
               "seen": { "value": "coil.f", "every": 0.013, "initial": 0 } },
  "elements": {
    "source": { "kind": "Se", "effort": "V" }, "chop": { "kind": "Sw", "closed": "not hot" },
    "in": { "kind": "1" }, "node": { "kind": "0" }, "free": { "kind": "D", "passes": "out" }, "loop": { "kind": "1" },
    "coil": { "kind": "I", "inertance": "L" }, "load": { "kind": "R", "resistance": "R" } },
  "bonds": [ { "from": "source", "to": "in" }, { "from": "in", "to": "chop" }, { "from": "in", "to": "node" },
             { "from": "node", "to": "free" }, { "from": "node", "to": "loop" }, { "from": "loop", "to": "coil" },
             { "from": "loop", "to": "load" } ],
  "outputs": { "i": "coil.f", "q": "charge", "s": "seen", "d": "free.f" },
  "scenes": { "main": { "stop": 0.2, "samples": 101 } } })json";

/// A chopper whose switch follows the current of a while ago, with what was before the start, and a load that is
/// sampled.
const char* const kLate = R"json({ "bgsim": 1, "name": "late",
  "signals": { "late": { "delay": "coil.f", "by": 0.017, "initial": "2*step(t + 0.01)" },
               "later": { "delay": "late + abs(mod(90*t, 2) - 1)", "by": 0.029 } },
  "elements": {
    "source": { "kind": "MSe", "effort": "24 + later" }, "chop": { "kind": "Sw", "open": "late > 4", "close": "late < 3" },
    "in": { "kind": "1" }, "node": { "kind": "0" }, "free": { "kind": "D", "passes": "out" }, "loop": { "kind": "1" },
    "coil": { "kind": "I", "inertance": 0.1 }, "load": { "kind": "R", "resistance": 2 } },
  "bonds": [ { "from": "source", "to": "in" }, { "from": "in", "to": "chop" }, { "from": "in", "to": "node" },
             { "from": "node", "to": "free" }, { "from": "node", "to": "loop" }, { "from": "loop", "to": "coil" },
             { "from": "loop", "to": "load" } ],
  "outputs": { "i": "coil.f", "y": "late", "z": "later" },
  "scenes": { "main": { "stop": 0.3, "samples": 101 }, "short": { "stop": 0.15, "samples": 51 } } })json";

/// The same without switches: a loop with dead time and a source that jumps.
const char* const kLateLoop = R"json({ "bgsim": 1, "name": "late_loop",
  "signals": { "late": { "delay": "cap.e", "by": 0.31 } },
  "elements": {
    "source": { "kind": "MSf", "flow": "step(t - 0.2) - 2*late" }, "node": { "kind": "0" },
    "cap": { "kind": "C", "capacitance": 1, "initial": { "e": 1 } }, "load": { "kind": "R", "resistance": 3 } },
  "bonds": [ { "from": "source", "to": "node" }, { "from": "node", "to": "cap" }, { "from": "node", "to": "load" } ],
  "outputs": { "u": "cap.e", "y": "late" },
  "scenes": { "main": { "stop": 5, "samples": 101 } } })json";

/// A ball under gravity over a floor, and a source that is switched off where the scene ends.
const char* const kAtTheEnd = R"json({ "bgsim": 1, "name": "at_the_end",
  "elements": {
    "source": { "kind": "Se", "effort": 1 }, "chop": { "kind": "Sw", "closed": "t < 1" }, "node": { "kind": "1" },
    "cap": { "kind": "C", "capacitance": 1 }, "load": { "kind": "R", "resistance": 1 } },
  "bonds": [ { "from": "source", "to": "node" }, { "from": "node", "to": "chop" }, { "from": "node", "to": "cap" },
             { "from": "node", "to": "load" } ],
  "outputs": { "v": "cap.e", "i": "load.f" },
  "scenes": { "main": { "stop": 1, "samples": 11 } } })json";

}  // namespace

TEST_CASE("a switched run continues from any snapshot bit for bit: methods", "[long]") {
  for (const Method method : {Method::automatic, Method::bdf, Method::adams, Method::erk5, Method::dirk4, Method::radau,
                              Method::radau9, Method::radau13, Method::ida, Method::rk4, Method::implicit_euler}) {
    INFO(facts_of(method).name);
    SceneOverrides overrides = with_method(method);
    if (facts_of(method).fixed_step()) overrides.step = 0.001;
    const Study study = Study::from_text(kChopper, "chopper.json");
    check_all(study.scene("main", overrides), method == Method::ida ? 100 : 12, 3);
  }
}

TEST_CASE("a switched run goes on from where the caller or a limit ended it") {
  const Study study = Study::from_text(kChopper, "chopper.json");
  const Simulation model = study.scene("main");
  const RunResult whole = model.simulate(options_of(0));
  REQUIRE(whole.stop == StopReason::completed);
  for (const std::uint64_t most : {5U, 17U, 40U}) {
    INFO("after " << most << " steps");
    std::uint64_t limit = most;
    std::string text;
    RunResult part;
    std::size_t rows = 0, parts = 0;
    do {  // in parts, to the end
      SimulateOptions options = options_of(0);
      options.max_steps = limit;
      options.resume = text;
      options.snapshot = [&](double, const std::string& snapshot) { text = snapshot; };
      part = model.simulate(options);
      rows += part.trace.times.size();
      limit += most;
      REQUIRE((part.stop == StopReason::completed || part.failure->code == "BG607"));
      REQUIRE(++parts < 1000);
    } while (part.stop != StopReason::completed);
    CHECK(parts > 1);
    CHECK(rows == whole.trace.times.size());
    CHECK(part.report.mode_changes == whole.report.mode_changes);
    // A restart costs steps and moves the end by about the tolerance, 1e-6; so do some hundred of them by 1e-4.
    for (const char* name : {"i", "q", "s"}) CHECK(last(part, name) == Approx(last(whole, name)).epsilon(1e-4));
  }
  // Wherever the caller ends it, there is a snapshot, and all rows are in one part or the other.
  for (int answers = 0; answers < 60; answers += 7) {
    INFO("after " << answers << " answers");
    SimulateOptions options = options_of(0);
    std::string text;
    int asked = 0;
    options.progress = [&](double) { return ++asked <= answers; };
    options.snapshot = [&](double, const std::string& snapshot) { text = snapshot; };
    const RunResult begun = model.simulate(options);
    if (begun.stop == StopReason::completed) continue;
    REQUIRE(begun.stop == StopReason::interrupted);
    REQUIRE_FALSE(text.empty());
    SimulateOptions rest = options_of(0);
    rest.resume = text;
    const RunResult ended = model.simulate(rest);
    REQUIRE(ended.stop == StopReason::completed);
    CHECK(begun.trace.times.size() + ended.trace.times.size() == whole.trace.times.size());
    CHECK(ended.report.mode_changes == whole.report.mode_changes);
    CHECK(last(ended, "i") == Approx(last(whole, "i")).epsilon(1e-4));  // one restart, as above
  }
}

namespace {

/// From a height of 1.
Study bouncing_ball(const std::string& signals, const std::string& scene) {
  return Study::from_text(R"json({ "bgsim": 1, "name": "ball", "signals": { )json" + signals + R"json( },
    "elements": { "fall": { "kind": "1" }, "ball": { "kind": "I", "inertance": 1 }, "weight": { "kind": "Se", "effort": 10 },
      "ground": { "kind": "contact", "gap": 0, "initial": { "q": -1 }, "restitution": 0.4 } },
    "bonds": [ { "from": "weight", "to": "fall" }, { "from": "fall", "to": "ball" }, { "from": "fall", "to": "ground" } ],
    "outputs": { "y": "y", "q": "ground.q" }, "scenes": { "main": { "stop": 2, "samples": 11, )json" +
                          scene + " } } }");
}
const double kRest = std::sqrt(0.2) * 1.4 / 0.6;  ///< where its impacts end

}  // namespace

TEST_CASE("a run continues from between the last impact and the end of the impacts") {
  const Study study =
      bouncing_ball(R"json("y": { "integral": "if(mode('ground'), 1, 0)" })json", R"("method": "radau")");
  const Simulation model = study.scene("main");
  const Whole whole = run_whole(model, 5);
  // A run begins again at each of its snapshots, with steps that suit the tolerance: some are between the two.
  REQUIRE(whole.result.stop == StopReason::completed);
  REQUIRE(whole.events.size() > 2);
  const double rest = whole.events.back().t, impact = whole.events[whole.events.size() - 2].t;
  REQUIRE(whole.events.back().kind == RunEvent::Kind::contact);
  CHECK(rest == Approx(kRest).epsilon(1e-10));  // parabolas
  std::size_t between = 0;
  for (const Taken& taken : whole.taken) {
    if (!(taken.t > impact) || !(taken.t < rest)) continue;
    ++between;
    check_rest(model, whole, taken, 5);
  }
  CHECK(between > 0);
}

TEST_CASE("the end of impacts is an event of one part of a run, whichever ends behind it") {
  // Nothing asks for the contact's mode, so no stretch begins at that end: it is known when the run has gone past it.
  const Study study = bouncing_ball(R"json("y": { "integral": "cos(20*t)" })json", R"("method": "auto")");
  const Simulation model = study.scene("main");
  const Whole whole = run_whole(model, 0);
  REQUIRE(whole.result.stop == StopReason::completed);
  CHECK(whole.events.back().kind == RunEvent::Kind::contact);
  std::size_t behind = 0;
  for (std::uint64_t less = 1; less <= 8; ++less) {
    const Whole first = run_whole(model, 0, whole.result.report.steps - less);
    REQUIRE(first.result.failure);
    CHECK(first.result.failure->code == "BG607");
    REQUIRE_FALSE(first.taken.empty());
    std::vector<RunEvent> events = first.events;
    behind += first.taken.back().t > kRest ? 1U : 0U;
    SimulateOptions options = options_of(0);
    options.resume = first.taken.back().text;
    options.events = [&](const RunEvent& event) { events.push_back(event); };
    REQUIRE(model.simulate(options).stop == StopReason::completed);
    std::size_t closings = 0;
    for (const RunEvent& event : events) closings += event.kind == RunEvent::Kind::contact ? 1U : 0U;
    CHECK(closings == 1);
    CHECK(events.size() == whole.events.size());
  }
  CHECK(behind > 2);
}

TEST_CASE("a run with delayed signals continues from any snapshot bit for bit", "[long]") {
  // A snapshot has the whole of the delays' memory: one every hundred steps, not every few.
  for (const Method method : {Method::automatic, Method::bdf, Method::erk5, Method::radau, Method::rodas5p}) {
    INFO(facts_of(method).name);
    check_all(Study::from_text(kLate, "late.json").scene("main", with_method(method)), 100, 4);
    check_all(Study::from_text(kLateLoop, "late_loop.json").scene("main", with_method(method)), 20, 4);
  }
}

TEST_CASE("a run with delayed signals that a switch ended on the last instant goes on beyond it") {
  // Long enough after the first change of the mode; the scene ends exactly at the next one.
  const Study study = Study::from_text(kLate, "late.json");
  const Whole whole = run_whole(study.scene("main"), 0);
  std::vector<double> changes;
  for (const RunEvent& event : whole.events)
    if (event.kind == RunEvent::Kind::switching) changes.push_back(event.t);
  REQUIRE(changes.size() > 3);
  RunInputs inputs = prepare_scene(study.model(), "main");
  inputs.stop = changes[2];
  inputs.output_times = OutputTimes::equidistant(0.0, inputs.stop, 21);
  const Whole half = run_whole(study.scene(inputs), 0);
  REQUIRE(half.taken.size() == 1);
  inputs.stop = 0.3;
  inputs.output_times = OutputTimes::equidistant(0.0, 0.3, 101);
  SimulateOptions options = options_of(0);
  options.resume = half.taken.front().text;
  const RunResult rest = study.scene(inputs).simulate(options);
  REQUIRE(rest.stop == StopReason::completed);
  // The end of the scene is part of no tolerance, but of the steps: as after any restart, some tens of tolerances.
  for (const char* name : {"i", "y", "z"}) CHECK(last(rest, name) == Approx(last(whole.result, name)).epsilon(1e-4));
}

TEST_CASE("a snapshot whose delayed signals do not fit is refused") {
  const Simulation model = Study::from_text(kLateLoop, "late_loop.json").scene("main");
  const Whole whole = run_whole(model, 0, 10);
  REQUIRE(whole.taken.size() == 1);
  const auto json = nlohmann::ordered_json::parse(whole.taken.front().text);
  REQUIRE(json["state"].contains("delays"));
  const auto refused = [&](const char* key, const nlohmann::ordered_json& value) {
    INFO(key);
    auto other = json;
    other["state"]["delays"][key] = value;
    SimulateOptions options = options_of(0);
    options.resume = other.dump();
    CHECK_THROWS_AS(model.simulate(options), ModelError);
  };
  refused("lines", nlohmann::ordered_json::array());
  refused("times", nlohmann::ordered_json::array({nlohmann::ordered_json::array({0.0, 1.0, 0.5, 2.0})}));
  refused("values", nlohmann::ordered_json::array({nlohmann::ordered_json::array({0.0})}));
  refused("first", nlohmann::ordered_json::array({1000000}));
  refused("last", nlohmann::ordered_json::array({1000000}));
}

TEST_CASE("a limit of steps is one of all modes together") {
  const Simulation model = Study::from_text(kChopper, "chopper.json").scene("main");
  const RunResult whole = model.simulate(options_of(0));
  for (std::uint64_t most = 1; most < 60; ++most) {
    INFO(most);
    SimulateOptions options = options_of(0);
    options.max_steps = most;
    const RunResult part = model.simulate(options);
    REQUIRE(part.failure);
    CHECK(part.failure->code == "BG607");
    CHECK_THAT(part.failure->situation, Contains(std::to_string(most) + " step"));
    CHECK(part.report.steps <= most + 1);
  }
  CHECK(whole.report.steps > 60);
}

TEST_CASE("a run whose mode changes where the scene ends is continued beyond it") {
  const Study study = Study::from_text(kAtTheEnd, "at_the_end.json");
  const Whole half = run_whole(study.scene("main"), 0);
  REQUIRE(half.result.stop == StopReason::completed);
  REQUIRE(half.taken.size() == 1);
  REQUIRE(half.events.size() == 3);  // the side at the start, the condition, the switch
  check_rest(study.scene("main"), half, half.taken.front(), 0);
  RunInputs longer = prepare_scene(study.model(), "main");
  longer.stop = 2.0;
  longer.output_times = OutputTimes::equidistant(0.0, 2.0, 21);
  const Simulation model = study.scene(longer);
  SimulateOptions options = options_of(0);
  options.resume = half.taken.front().text;
  std::vector<RunEvent> events;
  options.events = [&](const RunEvent& event) { events.push_back(event); };
  const RunResult rest = model.simulate(options);
  REQUIRE(rest.stop == StopReason::completed);
  CHECK(events.empty());
  CHECK(rest.trace.times.size() == 10);
  CHECK(rest.trace.times.front() == longer.output_times[11]);
  // Charged for one time constant to 1 - 1/e, within some tolerances of 1e-6; then nothing flows.
  CHECK(last(rest, "v") == Approx(1.0 - std::exp(-1.0)).epsilon(1e-5));
  CHECK(last(rest, "i") == 0.0);
}

TEST_CASE("a run that ends beside a change of the mode is continued over it", "[long]") {
  for (const char* name : {"models/half_wave.json", "models/rectifier_b6.json", "models/ball_contact.json"})
    for (const Method method : {Method::automatic, Method::bdf, Method::radau, Method::erk5}) {
      INFO(name << " by " << facts_of(method).name);
      const Study study = study_of(name);
      RunInputs inputs = prepare_scene(study.model(), "", with_method(method));
      inputs.stop = 7.0;
      inputs.output_times = OutputTimes::equidistant(0.0, inputs.stop, 71);
      const Simulation model = study.scene(inputs);
      const Whole whole = run_whole(model, 0);
      REQUIRE(whole.result.stop == StopReason::completed);
      std::vector<double> changes;
      for (const RunEvent& event : whole.events)
        if (event.t > 0.0 && (changes.empty() || event.t > changes.back())) changes.push_back(event.t);
      REQUIRE(changes.size() > 1);
      constexpr std::size_t kMost = 4;
      changes.resize(std::min(changes.size(), kMost));
      for (const double t : changes)
        for (const double stop : {std::nextafter(t, 0.0), t, std::nextafter(t, 8.0), t * (1.0 + inputs.relative)}) {
          CAPTURE(t, stop - t);
          RunInputs shorter = inputs;
          shorter.stop = stop;
          shorter.output_times = OutputTimes::equidistant(0.0, stop, 2);
          const Whole part = run_whole(study.scene(shorter), 0);
          REQUIRE(part.result.stop == StopReason::completed);
          REQUIRE(part.taken.size() == 1);
          SimulateOptions options = options_of(0);
          options.resume = part.taken.front().text;
          options.time_limit = 60.0;  // of some milliseconds
          const RunResult rest = model.simulate(options);
          REQUIRE(rest.stop == StopReason::completed);
          // A restart moves what follows by about the tolerance, 1e-6. What a mode that is never left makes of it is
          // off by tenths.
          const std::vector<std::string>& names = whole.result.trace.names;
          for (std::size_t c = 0; c < names.size(); ++c) {
            INFO(names[c]);
            const std::vector<double>& all = whole.result.trace.columns[c];
            const double size = largest_magnitude(all);
            const std::size_t first = all.size() - rest.trace.times.size();
            for (std::size_t i = first; i < all.size(); ++i) {
              CAPTURE(whole.result.trace.times[i]);
              CHECK(rest.trace.columns[c][i - first] == Approx(all[i]).margin(1e-4 * size));
            }
          }
          const EnergyAudit &a = rest.report.energy, &b = whole.result.report.energy;
          REQUIRE(a.done);
          for (const auto& [one, other] : {std::pair(a.supplied, b.supplied), std::pair(a.dissipated, b.dissipated),
                                           std::pair(a.stored, b.stored), std::pair(a.impacts, b.impacts)})
            CHECK(one == Approx(other).margin(1e-4 * b.turnover));
        }
    }
}

TEST_CASE("what is no snapshot of this switched run is refused") {
  const Simulation model = Study::from_text(kChopper, "chopper.json").scene("main");
  const Whole whole = run_whole(model, 0, 20);
  REQUIRE(whole.taken.size() == 1);
  const auto refused = [](const Simulation& of, const std::string& text, const char* why) {
    SimulateOptions options = options_of(0);
    options.resume = text;
    try {
      (void)of.simulate(options);
      FAIL("it was taken");
    } catch (const ModelError& error) {
      CHECK(error.diagnostics.front().code == "BG171");
      CHECK_THAT(error.diagnostics.front().situation, Contains(why));
    }
  };
  const std::string& text = whole.taken.front().text;
  refused(model, "{}", "is no snapshot");
  refused(model, text.substr(0, text.size() / 2), "is no snapshot");
  refused(Study::from_text(kAtTheEnd, "at_the_end.json").scene("main"), text, "another model, scene");
  refused(Study::from_text(kChopper, "chopper.json").scene("main", with_relative(1e-7)), text, "another model, scene");
  refused(Study::from_text(kChopper, "chopper.json").scene("main", with_parameters({"V=23"})), text, "another model");
  RunInputs shorter = prepare_scene(model.model(), "main");
  shorter.stop = whole.taken.front().t / 2;
  refused(Study::from_text(kChopper, "chopper.json").scene(shorter), text, "after the end of the scene");
  const auto json = nlohmann::ordered_json::parse(text);
  for (const auto& [key, value] : json["state"].items()) {
    INFO(key);
    auto without = json;
    without["state"].erase(key);
    refused(model, without.dump(), "not as it was written");
    auto other = json;
    other["state"][key] = "nonsense";
    refused(model, other.dump(), "not as it was written");
  }
  auto longer = json;
  longer["state"]["mode"].push_back(true);
  refused(model, longer.dump(), "not as it was written");
  auto wider = json;
  wider["state"]["x"].push_back(1.0);
  refused(model, wider.dump(), "not as it was written");
  auto banded = json;
  banded["state"]["bands"].push_back(1.0);
  refused(model, banded.dump(), "not as it was written");
}

TEST_CASE("a switched run continues from any snapshot bit for bit: models", "[long]") {
  for (const std::string& path : runnable_models_in("models")) {
    const Study study(in_project(path));
    if (switches_of(study.model()).empty()) continue;
    INFO(path);
    const Simulation model = study.scene();
    // Not too often: steps are short after each.
    check_all(model, std::max<std::uint64_t>(5, model.simulate(options_of(0)).report.steps / 20), 2);
  }
}
