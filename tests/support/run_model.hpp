/// From a model's text to a run, in one call.
#pragma once

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/bgsim.hpp"

namespace bgsim::test {

struct CompiledModel {
  std::shared_ptr<const Model> model;
  RunInputs inputs;
  EquationSystem system;
  Program program;

  [[nodiscard]] RunResult run(const SimulateOptions& options = {}) const { return simulate(program, inputs, options); }
};

inline CompiledModel compile_model(std::shared_ptr<const Model> model, const SceneOverrides& overrides = {},
                                   const std::string& scene = "") {
  const Study study(std::move(model));
  RunInputs inputs = prepare_scene(study.model(), scene, overrides);
  const Simulation compiled = study.scene(inputs, {.keep_all = true});
  return {study.shared_model(), std::move(inputs), study.equations(), compiled.program()};
}

inline CompiledModel compile_text(const std::string& text, const SceneOverrides& overrides = {},
                                  const std::string& scene = "") {
  return compile_model(std::make_shared<const Model>(read_model_text("model.json", text)), overrides, scene);
}
/// @param name  relative to the project, "models/bellow.json".
inline CompiledModel compile_file(const std::string& name, const SceneOverrides& overrides = {},
                                  const std::string& scene = "") {
  return compile_model(std::make_shared<const Model>(read_model(BGSIM_SOURCE_DIR "/" + name)), overrides, scene);
}

inline RunResult run_text(const std::string& text, const SceneOverrides& overrides = {},
                          const SimulateOptions& options = {}) {
  return compile_text(text, overrides).run(options);
}

inline SceneOverrides with_relative(double relative) {
  SceneOverrides overrides;
  overrides.relative = relative;
  return overrides;
}
inline SceneOverrides with_method(Method method, double relative = 1e-6) {
  SceneOverrides overrides = with_relative(relative);
  overrides.method = method;
  return overrides;
}
inline SceneOverrides with_parameters(std::vector<std::string> set) {
  SceneOverrides overrides;
  overrides.set = std::move(set);
  return overrides;
}

inline std::vector<double> column(const RunResult& result, const std::string& name) {
  const std::span<const double> values = result.trace[name];
  return {values.begin(), values.end()};
}

inline double last(const RunResult& result, const std::string& name) { return column(result, name).back(); }

/// A reference trace of tests/data/traces.
inline CsvTable reference_trace(const std::string& name) {
  std::ifstream file(std::string(BGSIM_SOURCE_DIR) + "/tests/data/traces/" + name + ".csv", std::ios::binary);
  if (!file) throw std::runtime_error("no reference trace " + name);
  return parse_csv(std::string(std::istreambuf_iterator<char>(file), {}));
}

/// A compiled model run at the times of a reference, and its largest error in @p names, each relative to the largest
/// magnitude of the reference's column.
inline double largest_error(CompiledModel compiled, const CsvTable& reference, const std::vector<std::string>& names) {
  const auto reference_column = [&](const std::string& name) -> const std::vector<double>& {
    const auto found = std::find(reference.names.begin(), reference.names.end(), name);
    if (found == reference.names.end()) throw std::invalid_argument("the reference has no column " + name);
    return reference.columns[static_cast<std::size_t>(found - reference.names.begin())];
  };
  compiled.inputs.output_times = reference_column("t");
  compiled.inputs.start = compiled.inputs.output_times.front();
  compiled.inputs.stop = compiled.inputs.output_times.back();
  const RunResult result = compiled.run();
  if (result.stop != StopReason::completed) throw std::runtime_error("the run failed: " + result.failure->situation);
  double largest = 0.0;
  for (const std::string& name : names) {
    const std::vector<double>& exact = reference_column(name);
    const std::vector<double> ours = column(result, name);
    double scale = 0.0, error = 0.0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      scale = std::max(scale, std::abs(exact[i]));
      error = std::max(error, std::abs(ours[i] - exact[i]));
    }
    largest = std::max(largest, error / scale);
  }
  return largest;
}

}  // namespace bgsim::test
