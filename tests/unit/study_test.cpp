// The way in: stages on demand, scenes with other values, runs from many threads.
#include "bgsim/study.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <thread>

namespace {

using namespace bgsim;

// A spring on a mass, k derived from its natural frequency; a store beside it that no output depends on and that
// follows the mass through a lever.
const char* const kText = R"({ "bgsim": 1, "name": "swing",
  "parameters": { "m": 2, "w": 3, "k": "m*w^2" },
  "elements": {
    "speed": { "kind": "1" },
    "mass": { "kind": "I", "inertance": "m", "initial": { "p": 1 } },
    "spring": { "kind": "C", "law": "e = k*q" },
    "push": { "kind": "Se", "effort": 1 }, "line": { "kind": "1" },
    "far": { "kind": "I", "inertance": 2, "initial": { "p": 0 } }, "lever": { "kind": "TF", "modulus": 0.5 },
    "end": { "kind": "I", "inertance": 3, "initial": { "p": 0 } } },
  "bonds": [ { "from": "speed", "to": "mass" }, { "from": "speed", "to": "spring" },
    { "from": "push", "to": "line" }, { "from": "line", "to": "far" }, { "from": "line", "to": "lever" },
    { "from": "lever", "to": "end" } ],
  "outputs": { "x": "spring.q", "v": "mass.f" },
  "scenes": { "run": { "stop": 2, "samples": 21 }, "other": { "stop": 1, "samples": 3, "outputs": ["x"] } } })";

std::string code_of(const ModelError& error) { return error.diagnostics.at(0).code; }

template <class Work>
std::string fault_of(const Work& work) {
  try {
    work();
  } catch (const ModelError& error) {
    return code_of(error);
  }
  return "none";
}

TEST_CASE("a study runs each stage once, when it is asked for") {
  const Study study = Study::from_text(kText);
  CHECK(study.seconds().empty());
  const BondGraph& graph = study.graph();
  CHECK(study.seconds().size() == 1);
  CHECK(&study.graph() == &graph);
  const Study copy = study;
  const BlockOrder& order = copy.order();
  CHECK(&study.order() == &order);
  std::vector<std::string> stages;
  for (const auto& [stage, seconds] : study.seconds()) stages.push_back(stage);
  CHECK(stages == std::vector<std::string>{"graph", "causality", "equations", "order"});
}

TEST_CASE("a scene is run with other values, and what is computed from them follows") {
  const Simulation scene = Study::from_text(kText).scene();
  for (const double w : {3.0, 5.0}) {
    const RunResult result = scene.with("w", 7.0).with("w", w).with("m", 4.0).simulate();
    REQUIRE(result.stop == StopReason::completed);
    const auto x = result.trace["x"];
    REQUIRE(x.size() == 21);
    // x = p0/(m w) sin(w t): within a hundred times the tolerance of 1e-6, of an amplitude of at most 1/12
    for (std::size_t i = 0; i < x.size(); ++i)
      CHECK(x[i] == Approx(std::sin(w * result.trace.times[i]) / (4.0 * w)).margin(1e-5));
  }
  CHECK(scene.with("mass.p", -1.0).simulate().trace["v"].front() == -0.5);
  CHECK(scene.simulate().trace["v"].front() == 0.5);  // the scene itself stays as it was
}

TEST_CASE("a scene with another value is the scene prepared with it, bit for bit") {
  const Study study = Study::from_text(kText);
  SceneOverrides overrides;
  overrides.set = {"m=0.1"};
  overrides.relative = 1e-9;
  const RunResult there = study.scene("run", overrides).simulate();
  SceneOverrides tight;
  tight.relative = 1e-9;
  CHECK(study.scene("run", tight).with("m", 0.1).simulate().trace.columns == there.trace.columns);
}

TEST_CASE("values that a scene cannot have are refused with their codes") {
  const Simulation scene = Study::from_text(kText).scene();
  CHECK(fault_of([&] { static_cast<void>(scene.with("ww", 1.0)); }) == "BG141");
  CHECK(fault_of([&] { static_cast<void>(scene.with("m", 0.0)); }) == "BG145");
  CHECK(fault_of([&] { static_cast<void>(scene.with("m", std::nan(""))); }) != "none");
  // of a store that is left out of the run, and determined by another
  CHECK(fault_of([&] { static_cast<void>(scene.with("end.p", 1.0)); }) == "BG405");
  CHECK(fault_of([&] { static_cast<void>(Study::from_text(kText).scene("nowhere")); }) == "BG140");
}

TEST_CASE("a compiled scene runs with other times, not with other outputs") {
  const Study study = Study::from_text(kText);
  const Simulation scene = study.scene("run");
  RunInputs inputs = scene.inputs();
  inputs.output_times = {0.0, 0.5};
  inputs.stop = 0.5;
  CHECK(scene.simulate(inputs).trace["x"].size() == 2);
  inputs.outputs = {0};
  CHECK_THROWS_AS(scene.simulate(inputs), std::invalid_argument);
  CHECK_THROWS_AS(study.scene(scene.inputs()).with("m", 1.0), std::logic_error);
}

TEST_CASE("a column that a trace does not have is named, with the nearest one") {
  const RunResult result = Study::from_text(kText).scene("other").simulate();
  CHECK(result.trace["x"].size() == 3);
  CHECK_THROWS_WITH(result.trace["v"], R"(the trace has no column "v")");
  const Trace trace{{"speed"}, {""}, {}, {{}}};
  CHECK_THROWS_WITH(trace["sped"], R"(the trace has no column "sped"; did you mean "speed"?)");
}

TEST_CASE("many threads use one study and one program, and get what one thread gets") {
  const Study study = Study::from_text(kText);
  constexpr std::size_t kThreads = 8;
  const auto mass = [](std::size_t i) { return 1.0 + static_cast<double>(i); };
  std::vector<Trace> traces(kThreads);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < kThreads; ++i)
      threads.emplace_back([&, i] { traces[i] = study.scene("run").with("m", mass(i)).simulate().trace; });
  }
  const Simulation scene = Study::from_text(kText).scene("run");
  std::vector<Trace> shared(kThreads);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < kThreads; ++i)
      threads.emplace_back([&, i] { shared[i] = scene.with("m", mass(i)).simulate().trace; });
  }
  for (std::size_t i = 0; i < kThreads; ++i) {
    const Trace alone = scene.with("m", mass(i)).simulate().trace;
    CHECK(traces[i].columns == alone.columns);
    CHECK(shared[i].columns == alone.columns);
  }
}

}  // namespace
