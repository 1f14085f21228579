/// What no output depends on is left out, and the outputs that remain do not notice.
#include <algorithm>
#include <catch2/catch.hpp>

#include "bgsim/modes.hpp"
#include "support/run.hpp"

namespace {

using namespace bgsim;

std::optional<Slice> slice_of(const Study& s, const std::vector<std::size_t>& outputs, bool audit = true) {
  return slice(s.model(), s.graph(), s.equations(), s.order(), outputs, audit);
}

RunResult run_slice(const Study& study, const RunInputs& inputs) {
  RunResult result = study.scene(inputs).simulate();
  INFO((result.failure ? result.failure->situation : ""));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

/// The first tenth of a scene, at a tolerance that leaves nothing to argue about. What BDF adds up of the errors in its
/// steps over a run is 5 to 1000 times the tolerance (models/README.md).
constexpr double kTolerance = 1e-9, kAddedUp = 1000.0;
RunInputs begin_of(const Study& study, const std::string& scene) {
  SceneOverrides overrides;
  overrides.relative = kTolerance;
  RunInputs inputs = prepare_scene(study.model(), scene, overrides);
  std::vector<double> times = inputs.output_times.list();
  times.resize(std::max<std::size_t>(2, times.size() / 10));
  inputs.stop = times.back();
  inputs.output_times = std::move(times);
  return inputs;
}

/// Records each output alone and holds what comes out against the run of everything.
/// @return how many runs had states or loops left out.
std::size_t hold_each_output(const std::string& path) {
  const Study study = test::study_of(path);
  if (study.model().outputs.empty() || !switches_of(study.model()).empty()) return 0;
  RunInputs inputs = begin_of(study, study.model().scenes.front().name);
  std::optional<RunResult> whole;
  std::size_t cut_runs = 0;
  for (std::size_t i = 0; i < study.model().outputs.size(); ++i) {
    const std::string& name = study.model().outputs[i].name;
    const auto cut = slice_of(study, {i});
    if (!cut || (cut->system.left_out.states.empty() && cut->system.left_out.loops == 0)) continue;
    ++cut_runs;
    if (!whole) {
      inputs.outputs.clear();
      for (std::size_t k = 0; k < study.model().outputs.size(); ++k) inputs.outputs.push_back(k);
      whole = test::run(study, inputs);
    }
    RunInputs alone = inputs;
    alone.outputs = {i};
    const std::vector<double> expected = test::column(*whole, name);
    const std::vector<double> found = test::column(run_slice(study, alone), name);
    INFO(path << ", output " << name);
    CHECK(test::largest_difference(expected, found) <= kAddedUp * kTolerance * test::largest_magnitude(expected));
  }
  return cut_runs;
}

std::size_t hold_folder(const std::string& folder) {
  std::size_t cut_runs = 0;
  for (const std::string& path : test::runnable_models_in(folder)) cut_runs += hold_each_output(path);
  return cut_runs;
}

TEST_CASE("each output of each shipped model is the same when what it does not depend on is left out", "[long]") {
  CHECK(hold_folder("models") > 5);
}

TEST_CASE("each output of each test model is the same when what it does not depend on is left out", "[long]") {
  CHECK(hold_folder("tests/data/models") > 5);
}

TEST_CASE("branches that nobody looks at are left out by name, with their loops and signals") {
  const Study study = test::study_of("tests/data/models/unobserved.json");
  const RunInputs inputs = prepare_scene(study.model(), "first");
  const auto cut = slice_of(study, inputs.outputs);
  REQUIRE(cut);
  const LeftOut& left_out = cut->system.left_out;
  CHECK(left_out.states == std::vector<std::string>{"second_coil.p", "second_store.q", "body_heat.q"});
  CHECK(left_out.signals == std::vector<std::string>{"heat"});
  CHECK(left_out.loops == 2);
  CHECK(cut->system.states.size() == 1);
  CHECK(cut->order.blocks.empty());
  CHECK(cut->system.dependent.empty());
  // The battery feeds branches that are left out, so its own power is not known.
  CHECK(std::find(left_out.elements.begin(), left_out.elements.end(), "battery") == left_out.elements.end());
  CHECK(std::find(left_out.not_audited.begin(), left_out.not_audited.end(), "battery") != left_out.not_audited.end());
}

TEST_CASE("a condition keeps what it depends on") {
  const Study study = test::study_of("tests/data/models/unobserved.json");
  const RunInputs inputs = prepare_scene(study.model(), "fourth");
  const auto cut = slice_of(study, inputs.outputs);
  REQUIRE(cut);
  CHECK(cut->system.left_out.states == std::vector<std::string>{"first_store.q"});
  CHECK(cut->order.blocks.size() == 1);  // the loop of the dependent store
}

TEST_CASE("the energy balance of what is kept closes, what flows to the rest counting as supplied") {
  const Study study = test::study_of("tests/data/models/unobserved.json");
  for (const char* scene : {"first", "second", "third", "fourth"}) {
    const RunInputs inputs = prepare_scene(study.model(), scene);
    const RunResult result = run_slice(study, inputs);
    INFO(scene);
    REQUIRE(result.report.energy.done);
    CHECK(result.report.energy.supplied > 0.0);
    // The runs' relative tolerance is 1e-8; what BDF adds up stays below a hundred times that.
    CHECK(result.report.energy.relative < 1e-6);
  }
}

TEST_CASE("nothing is left out where all outputs are recorded and all elements act on them") {
  const Study study = test::study_of("models/quarter_car.json");
  for (std::size_t i = 0; i < study.model().outputs.size(); ++i) CHECK(!slice_of(study, {i}));
}

TEST_CASE("a start that contradicts itself is found in what is left out, too") {
  Study study = test::study_of("tests/data/models/unobserved.json");
  SceneOverrides overrides;
  overrides.set = {"far_heat.q=1e-6", "body_heat.q=0"};
  const RunInputs askew = prepare_scene(study.model(), "first", overrides);
  const auto cut = slice_of(study, askew.outputs);
  REQUIRE(cut);
  try {
    check_start(study.shared_model(), study.equations(), study.order(), *cut, askew);
    FAIL("the contradiction was not found");
  } catch (const ModelError& error) {
    CHECK(error.diagnostics.front().code == "BG405");
  }
  overrides.set = {"far_heat.q=0", "body_heat.q=0"};
  CHECK_NOTHROW(check_start(study.shared_model(), study.equations(), study.order(), *cut,
                            prepare_scene(study.model(), "first", overrides)));
}

}  // namespace
