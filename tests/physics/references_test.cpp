/// Every scene that names a reference is held against it, in models/ and among the tests' own models; and the energy
/// balance of every shipped scene closes.
#include <catch2/catch.hpp>

#include "bgsim/verify.hpp"
#include "support/run.hpp"

namespace {

using namespace bgsim;

// The audit is integrated with the run, at its tolerance of 1e-8 or less; what BDF leaves of the stiffest scenes is
// 1e-5.
constexpr double kEnergyResidual = 1e-4;

void hold_scene(const Study& study, const std::string& path, const Scene& scene, std::optional<Method> method) {
  INFO(path << " " << scene.name);
  RunInputs inputs = prepare_scene(study.model(), scene.name);
  if (method) {
    inputs.method = *method;
    // Their limits allow for what BDF makes of the scenes' tolerances; Radau takes tolerances more loosely (theory.md).
    inputs.relative *= 1e-2;
    inputs.max_order = 0;
    inputs.step = 0.0;
  }
  const CsvTable table = read_reference(study.model(), *inputs.reference);
  const RunResult result = test::run(study, at_reference_times(study.model(), inputs, table));
  const ReferenceCheck check = hold_against(study.model(), result.trace, table, *inputs.reference);
  CHECK(!check.columns.empty());
  for (const ColumnCheck& column : check.columns) {
    INFO(column.output << " at t = " << column.time << ": " << column.value << ", reference " << column.low);
    CHECK(column.error <= column.limit);
  }
  REQUIRE(result.report.energy.done);
  CHECK(result.report.energy.relative < kEnergyResidual);
}

void hold_folder(const std::string& folder, std::optional<Method> method = {}) {
  std::size_t scenes = 0;
  for (const std::string& path : test::runnable_models_in(folder)) {
    const Study study = test::study_of(path);
    for (const Scene& scene : study.model().scenes) {
      if (!scene.reference) continue;
      hold_scene(study, path, scene, method);
      ++scenes;
    }
  }
  CHECK(scenes > 20);
}

TEST_CASE(
    "the shipped models agree with their references as closely as their scenes state, and their energy balances "
    "close",
    "[long]") {
  hold_folder("models");
}

// For the sanitizers, which the tests above take minutes with.
TEST_CASE("every scene of the shipped models makes its first steps") {
  SimulateOptions options = test::untimed();
  options.max_steps = 100;
  for (const std::string& path : test::runnable_models_in("models")) {
    const Study study = test::study_of(path);
    for (const Scene& scene : study.model().scenes) {
      INFO(path << " " << scene.name);
      const RunResult result = study.scene(scene.name).simulate(options);
      const bool at_the_limit = result.failure && result.failure->code == "BG607";
      CHECK((result.stop == StopReason::completed || at_the_limit));
      CHECK(result.report.reached > result.report.start);
    }
  }
}

TEST_CASE("the shipped models agree with their references by Radau, too", "[long]") {
  hold_folder("models", Method::radau);
}

TEST_CASE("the shipped models agree with their references by Rodas5P, too", "[long]") {
  hold_folder("models", Method::rodas5p);
}

TEST_CASE("known traces are reproduced as closely as the scenes state, and energy balances close", "[long]") {
  hold_folder("tests/data/models");
}

}  // namespace
