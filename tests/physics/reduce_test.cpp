/// Activities against published numbers, and reductions that keep what they promise.
#include "bgsim/reduce.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "study/flat_model.hpp"
#include "support/approx.hpp"
#include "support/run.hpp"

namespace {

using namespace bgsim;

const std::string kTrap = "tests/data/models/pothole_linear.json";

std::shared_ptr<const Model> read(const std::string& path) {
  return std::make_shared<const Model>(read_model(test::in_project(path)));
}

Reduction reduce_to(const std::string& path, const std::string& scene, double error,
                    std::vector<std::string> keep = {}) {
  ReduceOptions options;
  options.scene = scene;
  options.error = error;
  options.keep = std::move(keep);
  options.file = "reduced.json";
  options.repetitions = 1;
  return reduce(Study(read(path)), options);
}

const CutTrial& trial_of(const Reduction& reduction, const Model& model, const std::string& element, CutKind kind) {
  const auto found = std::find_if(reduction.trials.begin(), reduction.trials.end(), [&](const CutTrial& trial) {
    return model.elements[trial.cut.element.index()].name == element && trial.cut.kind == kind;
  });
  REQUIRE(found != reduction.trials.end());
  return *found;
}

/// The reduced model, read from its text and run by itself, is as far from the full one as was said.
void check_by_itself(const Reduction& reduction, const std::string& scene) {
  const RunResult result = Study::from_text(reduction.text).scene(scene, {}, {.keep_all = true}).simulate();
  REQUIRE(result.stop == StopReason::completed);
  // Slicing and the audit change the integrator's steps, not the solution: both runs are within the tolerance's reach.
  constexpr double kReach = 1e-5;
  CHECK(worst(output_errors(reduction.reference, result.trace)).error ==
        Approx(worst(reduction.errors).error).margin(kReach));
}

// The tyre's flow jumps with the road: its published activity, 636.48442, is a quadrature across the jumps. The total
// variation of its stored energy, which is the same quantity, is 636.41675 on a grid of 2e-5 s.
TEST_CASE("activities of the quarter car over a pothole are the published ones") {
  const Simulation drive = Study(test::in_project(kTrap)).scene("drive", {}, {.keep_all = true});
  const std::vector<ElementActivity> table = activities(drive.program(), drive.simulate());
  const std::vector<std::pair<std::string, double>> expected{{"wheel_mass", 656.22926},
                                                             {"tyre", 636.41675},
                                                             {"damper", 469.71873},
                                                             {"spring", 106.73592},
                                                             {"body_mass", 50.350637}};
  REQUIRE(table.size() == expected.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < table.size(); ++i) {
    INFO(expected[i].first);
    CHECK(drive.model().elements[table[i].element.index()].name == expected[i].first);
    // Powers that change sign within a step are taken as straight lines over a sixteenth of it.
    CHECK(table[i].activity == Approx(expected[i].second).epsilon(1e-5));
    sum += table[i].activity;
  }
  CHECK(sum == Approx(1919.519 - 636.48442 + 636.41675).epsilon(1e-5));
  CHECK(table.back().share == Approx(0.0262309).epsilon(1e-4));
  CHECK(table.back().cumulative == test::same_to_rounding(1.0, 32));
}

TEST_CASE("the trap: the least active element must go without flow, not without effort") {
  const auto model = read(kTrap);
  const Reduction reduction = reduce_to(kTrap, "trap", 0.15);
  REQUIRE(!reduction.trials.empty());
  // The body is tried first, being the least active; its junctions speak for no flow.
  CHECK(model->elements[reduction.trials.front().cut.element.index()].name == "body_mass");
  CHECK(reduction.trials.front().cut.kind == CutKind::zero_flow);
  CHECK(reduction.trials.front().made);
  check_by_itself(reduction, "trap");

  const Reduction strict = reduce_to(kTrap, "trap", 0.01);
  CHECK(strict.cuts.empty());
  // The published errors are root mean squares relative to that of the deflection, ours relative to its range.
  REQUIRE(strict.reference.columns.size() == 1);
  const std::vector<double>& full = strict.reference.columns.front();
  double sum = 0.0;
  for (const double value : full) sum += value * value;
  const auto [least, most] = std::minmax_element(full.begin(), full.end());
  const double factor = (*most - *least) / std::sqrt(sum / static_cast<double>(full.size()));
  // Printed with three digits.
  CHECK(factor * trial_of(strict, *model, "body_mass", CutKind::zero_flow).error.rms == Approx(0.117).margin(0.0005));
  CHECK(factor * trial_of(strict, *model, "body_mass", CutKind::zero_effort).error.rms == Approx(2.39).margin(0.005));
}

/// A buck converter with two elements that hardly matter: the resistance of a wire, and the capacitance of a cable.
constexpr const char* kBuck = R"x({ "bgsim": 1, "name": "buck",
  "parameters": { "T": 2e-5, "duty": 0.5 },
  "elements": {
    "source": { "kind": "Se", "effort": 24 }, "in": { "kind": "1" }, "chop": { "kind": "Sw", "closed": "mod(t, T) < duty*T" },
    "node": { "kind": "0" }, "free": { "kind": "D", "passes": "out" }, "loop": { "kind": "1" },
    "wire": { "kind": "R", "resistance": 1e-6 }, "coil": { "kind": "I", "inertance": 1e-4 }, "out": { "kind": "0" },
    "cap": { "kind": "C", "capacitance": 1e-4 }, "load": { "kind": "R", "resistance": 5 },
    "cable": { "kind": "C", "capacitance": 1e-11 }, "lossy": { "kind": "R", "resistance": 1e3 }, "branch": { "kind": "1" } },
  "bonds": [
    { "from": "source", "to": "in" }, { "from": "in", "to": "chop" }, { "from": "in", "to": "node" },
    { "from": "node", "to": "free" }, { "from": "node", "to": "loop" }, { "from": "loop", "to": "wire" },
    { "from": "loop", "to": "coil" }, { "from": "loop", "to": "out" }, { "from": "out", "to": "cap" },
    { "from": "out", "to": "load" }, { "from": "out", "to": "branch" }, { "from": "branch", "to": "lossy" },
    { "from": "branch", "to": "cable" } ],
  "outputs": { "i": "coil.f", "u": "cap.e" },
  "scenes": { "start": { "stop": 4e-4, "samples": 201, "relative": 1e-7 } } })x";

/// A ball on a contact, with a drag that hardly matters.
constexpr const char* kBall = R"x({ "bgsim": 1, "name": "ball",
  "elements": {
    "ball": { "kind": "1" }, "mass": { "kind": "I", "inertance": 1 }, "weight": { "kind": "Se", "effort": 9.81 },
    "drag": { "kind": "R", "resistance": 1e-5 }, "ground": { "kind": "contact", "gap": 0, "restitution": 0.7, "initial": { "q": -1 } } },
  "bonds": [ { "from": "weight", "to": "ball" }, { "from": "ball", "to": "mass" }, { "from": "ball", "to": "drag" },
    { "from": "ball", "to": "ground" } ],
  "outputs": { "q": "ground.q" },
  "scenes": { "fall": { "stop": 3, "samples": 301, "relative": 1e-7, "max_events": 10000 } } })x";

Reduction reduce_text(const char* text, double error) {
  ReduceOptions options;
  options.error = error;
  options.file = "reduced.json";
  options.repetitions = 1;
  return reduce(Study::from_text(text), options);
}

TEST_CASE("models with switches and diodes are reduced, over all modes of their runs") {
  const Reduction reduction = reduce_text(kBuck, 1e-4);
  const Model reduced = read_model_text("reduced.json", reduction.text);
  const auto has = [&](const std::string& name) {
    return std::any_of(reduced.elements.begin(), reduced.elements.end(),
                       [&](const Element& element) { return element.name == name; });
  };
  CHECK(!has("wire"));
  CHECK((!has("cable") || !has("lossy")));
  for (const char* kept : {"chop", "free", "coil", "cap", "load"}) CHECK(has(kept));
  check_by_itself(reduction, "start");

  // The activity of a resistor is what it dissipates, in all modes together.
  const Model full = read_model_text("buck.json", kBuck);
  const RunResult run = Study::from_text(kBuck).scene("start", {}, {.keep_all = true}).simulate();
  REQUIRE(run.report.mode_changes > 30);
  double dissipated = 0.0;
  for (const ElementActivity& row : reduction.activity)
    if (full.elements[row.element.index()].kind == ElementKind::resistor) dissipated += row.activity;
  // Gauss' rule integrates both, over steps that the recording of further outputs does not change.
  CHECK(dissipated == Approx(run.report.energy.dissipated).epsilon(1e-6));
}

TEST_CASE("a model with a contact is reduced, and keeps its gap, its restitution and its limit of events") {
  const Reduction reduction = reduce_text(kBall, 1e-3);
  REQUIRE(reduction.cuts.size() == 1);
  const Model reduced = read_model_text("reduced.json", reduction.text);
  CHECK(reduced.elements.size() == 4);
  CHECK(reduced.scenes.front().max_events == 10000U);
  check_by_itself(reduction, "fall");
}

/// A sampled controller with memory, a latch, a delay and events of its own, on a spring and a mass; a wheel that
/// nothing looks at; a mass and a resistance that hardly matter.
constexpr const char* kSampled = R"x({ "bgsim": 1, "name": "sampled", "parameters": { "Ts": 0.05, "k": 100 },
  "signals": {
    "err": { "value": "1 - spring.q", "every": "Ts", "about": "error" },
    "sum": { "value": "previous(sum) + err*Ts", "every": "Ts", "offset": "Ts/2", "initial": 0.1 },
    "late": { "delay": "body.f", "by": 0.02, "initial": "0.1*t" },
    "on": { "set": "spring.q > 0.2", "reset": "spring.q < 0.1", "initial": true },
    "strong": "on and not spring.q > 0.9",
    "count": { "integral": 0, "initial": 1 }, "unused": { "integral": "sin(t)" } },
  "elements": {
    "drive": { "kind": "MSe", "effort": "50*err + 20*sum - 2*late + if(on, 3, 0) + if(strong, 1, 0)" },
    "body": { "kind": "1" }, "mass": { "kind": "I", "inertance": 1 }, "spring": { "kind": "C", "capacitance": "1/k" },
    "damper": { "kind": "R", "resistance": 4 }, "small": { "kind": "R", "resistance": 0.001 },
    "tiny": { "kind": "I", "inertance": 1e-4 },
    "wheel": { "kind": "I", "inertance": 2, "initial": { "p": 1 } }, "axle": { "kind": "1" },
    "rub": { "kind": "R", "resistance": 0.1 } },
  "bonds": [ { "from": "drive", "to": "body" }, { "from": "body", "to": "mass" }, { "from": "body", "to": "spring" },
    { "from": "body", "to": "damper" }, { "from": "body", "to": "small" }, { "from": "body", "to": "tiny" },
    { "from": "axle", "to": "wheel" }, { "from": "axle", "to": "rub" } ],
  "events": {
    "kick": { "when": "spring.q > 0.6", "set": { "count": "pre(count) + 1", "mass.p": "0.5*pre(mass.p)" }, "priority": 2 },
    "slow": { "when": "axle.f < 0.4", "set": { "wheel.p": 1 } } },
  "outputs": { "x": "spring.q", "n": "count", "p": "if(on, 1, 0)", "s": "sum" },
  "scenes": { "step": { "stop": 3, "samples": 301, "relative": 1e-8, "initial": { "count": 2 } } } })x";

TEST_CASE("events, delays and signals with memory are written as they were, and reduced around") {
  const Reduction reduction = reduce_text(kSampled, 1e-2);
  const Model reduced = read_model_text("reduced.json", reduction.text);
  INFO(reduction.text);
  std::vector<std::string> elements, events;
  for (const Element& element : reduced.elements) elements.push_back(element.name);
  for (const ModelEvent& event : reduced.events) events.push_back(event.name);
  CHECK(elements == std::vector<std::string>{"drive", "body", "mass", "spring", "damper"});
  CHECK(events == std::vector<std::string>{"kick", "err", "previous(sum)", "sum", "on (set)", "on (reset)"});
  CHECK(reduced.events.front().priority == 2.0);
  CHECK(reduction.text.find("unused") == std::string::npos);
  check_by_itself(reduction, "step");
  // What an event sets is there to be set.
  CHECK(trial_of(reduction, read_model_text("sampled.json", kSampled), "mass", CutKind::zero_effort).refusal ==
        "the event \"kick\" sets what \"mass\" holds");
}

TEST_CASE("with nothing cut the text is the model: events, delays and memory run as before, bit for bit") {
  for (const char* name :
       {"bouncing_ball", "heated_loop", "rimless_wheel", "sampled_servo", "shaken_ball", "thermostat"}) {
    INFO(name);
    const auto model = read("models/" + std::string(name) + ".json");
    const std::string& scene = model->scenes.front().name;
    FlatModelOptions how;
    how.file = "flat.json";
    how.scene = scene;
    how.name = model->name;
    const Study study(model);
    const Study flat = Study::from_text(flat_model_json(*model, study.graph(), how));
    const RunResult whole = study.scene(scene).simulate(test::untimed());
    REQUIRE(whole.stop == StopReason::completed);
    const RunResult again = flat.scene(scene).simulate(test::untimed());
    CHECK(again.report.steps == whole.report.steps);
    CHECK(again.trace.columns == whole.trace.columns);
  }
}

TEST_CASE("a cut that lets an impulse go round in a loop of junctions is refused", "[long]") {
  const auto model = read("models/actuator_object.json");
  const Reduction reduction = reduce_to("models/actuator_object.json", "press", 1e-2,
                                        {"body_mass", "body_inertia", "left.damping", "left.orifice", "right.orifice"});
  CHECK(trial_of(reduction, *model, "right.damping", CutKind::zero_flow).refusal.find("BG619") == 0);
  CHECK(reduction.cuts.empty());
}

TEST_CASE("what no output depends on is left away, and the text says so") {
  const Reduction reduction = reduce_to("tests/data/models/unobserved.json", "first", 1e-2);
  const Model reduced = read_model_text("reduced.json", reduction.text);
  CHECK(reduced.elements.size() == 5);  // battery, rail, first and what hangs on it
  CHECK(reduced.about.find("second_coil") != std::string::npos);
  CHECK(reduction.cuts.empty());
  CHECK(reduction.size_after.states == 1);
  check_by_itself(reduction, "first");
}

TEST_CASE("an element that an output names, or the bond of one, stays where its value is known without it") {
  // The load takes nothing from what it is tied to, an ideal source, and neither does the lamp.
  for (const char* value : {"wire.e", "load.e"}) {
    INFO(value);
    const std::string text = std::string(R"x({ "bgsim": 1, "name": "loaded", "elements": {
      "source": { "kind": "Se", "effort": "sin(3*t)" }, "rail": { "kind": "0" }, "loop": { "kind": "1" },
      "resistor": { "kind": "R", "resistance": 1 }, "store": { "kind": "C", "capacitance": 1 },
      "load": { "kind": "R", "resistance": 2 }, "lamp": { "kind": "R", "resistance": 5 } },
    "bonds": [ { "from": "source", "to": "rail" }, { "from": "rail", "to": "loop" }, { "from": "loop", "to": "resistor" },
      { "from": "loop", "to": "store" }, { "from": "rail", "to": "load", "name": "wire" }, { "from": "rail", "to": "lamp" } ],
    "outputs": { "u": "store.e", "supply": ")x") +
                             value + R"x(" }, "scenes": { "run": { "stop": 3, "samples": 31, "relative": 1e-7 } } })x";
    const Reduction reduction = reduce_text(text.c_str(), 1e-3);
    CHECK(reduction.unobserved == std::vector<ElementId>{ElementId(6)});
    // Without flow it leaves the effort at the rail as it is; so do cuts of nothing else.
    REQUIRE(reduction.cuts.size() == 1);
    CHECK(reduction.cuts[0].element == ElementId(5));
    CHECK(worst(reduction.errors).error == 0.0);
    check_by_itself(reduction, "run");
  }
}

TEST_CASE("the bellow's damping, air and orifice hardly matter when it follows slowly, all of them when it is pushed") {
  const auto model = read("models/bellow_parts.json");
  const Reduction step = reduce_to("models/bellow_parts.json", "step", 1e-2);
  CHECK(step.cuts.empty());
  CHECK(trial_of(step, *model, "mass", CutKind::zero_effort).error.error > 0.1);
  CHECK(trial_of(step, *model, "air", CutKind::zero_flow).error.error > 0.5);
  CHECK(trial_of(step, *model, "orifice", CutKind::zero_effort).error.error > 0.5);
}

TEST_CASE("a reduction refuses what fails and goes on with the next cut") {
  const auto model = read(kTrap);
  const Reduction reduction = reduce_to(kTrap, "trap", 0.15);
  // Without flow into the tyre the road's jumps would have to be differentiated; without effort nothing says how far it
  // is deflected.
  CHECK(trial_of(reduction, *model, "tyre", CutKind::zero_flow).refusal.find("BG") == 0);
  CHECK(trial_of(reduction, *model, "tyre", CutKind::zero_effort).refusal == "the output \"deflection\" needs tyre.q");
  CHECK(!reduction.trials.back().made);
  CHECK(worst(reduction.errors).error <= 0.15);
}

TEST_CASE("elements that are to be kept are not tried") {
  const auto model = read(kTrap);
  const Reduction reduction = reduce_to(kTrap, "trap", 0.15, {"body_mass"});
  for (const CutTrial& trial : reduction.trials) CHECK(model->elements[trial.cut.element.index()].name != "body_mass");
}

TEST_CASE("a model with submodels is written flat and means the same") {
  for (const char* path : {"models/bellow.json", "models/actuator_masses.json", "models/amplifier.json"}) {
    const auto model = read(path);
    const Scene& scene = model->scenes.front();
    FlatModelOptions options;
    options.file = "flat.json";
    options.scene = scene.name;
    options.name = model->name;
    const Model flat = read_model_text("flat.json", flat_model_json(*model, Study(model).graph(), options));
    CHECK(flat.elements.size() == model->elements.size());
    CHECK(flat.bonds.size() == model->bonds.size());
    const RunInputs expected = prepare_scene(*model, scene.name), found = prepare_scene(flat, scene.name);
    CHECK(found.output_times.list() == expected.output_times.list());
    CHECK(found.relative == expected.relative);
    // Same rates at a point that is none in particular.
    const auto rates = [](const Model& m, const RunInputs& inputs) {
      const Simulation compiled =
          Study(std::make_shared<const Model>(m)).scene(inputs, {.energy_audit = false, .keep_all = true});
      const Program& program = compiled.program();
      Evaluator evaluator(program, inputs.parameters);
      std::vector<double> x(evaluator.states()), f(evaluator.states());
      for (std::size_t i = 0; i < x.size(); ++i) x[i] = 1e-3 * static_cast<double>(i + 1);
      Branch branch = first_branch(program);
      REQUIRE(evaluator.initialize_modes(0.01, x.data(), branch));
      REQUIRE(evaluator.rates(0.01, x.data(), branch, f.data()));
      return f;
    };
    INFO(path);
    CHECK(rates(flat, found) == rates(*model, expected));
  }
}

}  // namespace
