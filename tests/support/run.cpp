#include "support/run.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

namespace bgsim::test {

Stages read_stages(const std::string& path) {
  Stages stages;
  try {
    const Study study(std::string(BGSIM_SOURCE_DIR) + "/" + path);
    stages.model = study.shared_model();
    stages.graph = study.graph();
    stages.causal = study.causality();
    stages.system = study.equations();
    stages.order = study.order();
  } catch (const ModelError& error) {
    FAIL(render(error));
  }
  return stages;
}

RunResult run(const Stages& stages, const RunInputs& inputs) {
  CompileOptions options;
  options.outputs = inputs.outputs;
  const Program program = compile(stages.model, stages.system, stages.order, options);
  RunResult result = simulate(program, inputs);
  if (result.failure) FAIL(render(*result.failure, *stages.model->sources));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

RunResult run(const Stages& stages, const std::string& scene, const std::vector<std::string>& set) {
  SceneOverrides overrides;
  overrides.set = set;
  return run(stages, prepare_scene(*stages.model, scene, overrides));
}

std::vector<double> column(const RunResult& result, const std::string& name) {
  const std::span<const double> values = result.trace[name];
  return {values.begin(), values.end()};
}

double at(const RunResult& result, const std::string& name, double time) {
  const auto& times = result.trace.times;
  std::size_t best = 0;
  for (std::size_t row = 1; row < times.size(); ++row)
    if (std::abs(times[row] - time) < std::abs(times[best] - time)) best = row;
  REQUIRE(std::abs(times[best] - time) <= 1e-9 * (times.back() - times.front()));
  return result.trace[name][best];
}

double largest_magnitude(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  REQUIRE(a.size() == b.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

Linearization linear_at(const Stages& stages, const RunInputs& inputs, double t, const std::vector<double>& x,
                        const std::vector<std::string>& parameters) {
  return linearize(stages.model, stages.system, stages.order, inputs, t, x, parameters);
}

Linearization linear(const Stages& stages, const std::string& scene, const std::vector<std::string>& inputs,
                     const std::vector<std::string>& set) {
  SceneOverrides overrides;
  overrides.set = set;
  const RunInputs at_start = prepare_scene(*stages.model, scene, overrides);
  const Program program = compile(stages.model, stages.system, stages.order, {});
  Evaluator evaluator(program, at_start.parameters);
  const std::vector<double> x = initial_states(evaluator, at_start);
  return linear_at(stages, at_start, at_start.start, x, inputs);
}

std::vector<std::complex<double>> poles(const Linearization& linearization) {
  const auto n = static_cast<Eigen::Index>(linearization.states);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> a(linearization.a.data(), n, n);
  const Eigen::VectorXcd values = Eigen::MatrixXd(a).eigenvalues();
  std::vector<std::complex<double>> sorted(values.data(), values.data() + n);
  std::sort(sorted.begin(), sorted.end(),
            [](const auto& p, const auto& q) { return std::pair(p.real(), p.imag()) < std::pair(q.real(), q.imag()); });
  return sorted;
}

std::vector<std::string> models_in(const std::string& folder) {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(BGSIM_SOURCE_DIR) + "/" + folder))
    if (entry.path().extension() == ".json") paths.push_back(folder + "/" + entry.path().filename().string());
  std::sort(paths.begin(), paths.end());
  std::vector<std::string> with_scenes;
  for (const std::string& path : paths)
    if (!read_model(std::string(BGSIM_SOURCE_DIR) + "/" + path).scenes.empty()) with_scenes.push_back(path);
  return with_scenes;
}

}  // namespace bgsim::test
