#include "support/run.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "bgsim/modes.hpp"
#include "support/algebra.hpp"
#include "support/files.hpp"

namespace bgsim::test {

std::string in_project(const std::string& path) { return BGSIM_SOURCE_DIR "/" + path; }

namespace {

/// "NAME=VALUE" overrides in a scene.
RunInputs inputs_with(const Study& study, const std::string& scene, const std::vector<std::string>& set) {
  return prepare_scene(study.model(), scene, with_parameters(set));
}

}  // namespace

CompiledModel compile_study(const Study& study, RunInputs inputs) {
  Program program = study.scene(inputs, {.keep_all = true}).program();
  return {study, std::move(inputs), std::move(program)};
}

CompiledModel compile_model(std::shared_ptr<const Model> model, const SceneOverrides& overrides,
                            const std::string& scene) {
  RunInputs inputs = prepare_scene(*model, scene, overrides);
  return compile_study(Study(std::move(model)), std::move(inputs));
}

CompiledModel compile_text(const std::string& text, const SceneOverrides& overrides, const std::string& scene) {
  return compile_model(std::make_shared<const Model>(read_model_text("model.json", text)), overrides, scene);
}

CompiledModel compile_file(const std::string& path, const SceneOverrides& overrides, const std::string& scene) {
  return compile_model(std::make_shared<const Model>(read_model(in_project(path))), overrides, scene);
}

SimulateOptions untimed() {
  SimulateOptions options;
  options.longest_run = 0.0;
  return options;
}

SimulateOptions one_run() {
  SimulateOptions options = untimed();
  options.error_estimate = false;
  return options;
}

RunResult run_text(const std::string& text, const SceneOverrides& overrides, const SimulateOptions& options) {
  return compile_text(text, overrides).run(options);
}

Study study_of(const std::string& path) {
  try {
    Study study(in_project(path));
    static_cast<void>(study.at_start().order());
    return study;
  } catch (const ModelError& error) {
    FAIL(render(error));
    throw;
  }
}

RunResult run(const Study& study, const RunInputs& inputs) {
  const SimulateOptions options = one_run();  // estimates have tests of their own, and are slow under the sanitizers
  const bool switches = !switches_of(study.model()).empty();
  RunResult result = switches ? study.scene(inputs).simulate(options) : compile_study(study, inputs).run(options);
  if (result.failure) FAIL(render(*result.failure, *study.model().sources));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

RunResult run(const Study& study, const std::string& scene, const std::vector<std::string>& set) {
  return run(study, inputs_with(study, scene, set));
}

SceneOverrides with_relative(double relative) {
  SceneOverrides overrides;
  overrides.relative = relative;
  return overrides;
}

SceneOverrides with_method(Method method, double relative) {
  SceneOverrides overrides = with_relative(relative);
  overrides.method = method;
  return overrides;
}

SceneOverrides with_parameters(std::vector<std::string> set) {
  SceneOverrides overrides;
  overrides.set = std::move(set);
  return overrides;
}

std::vector<double> column(const RunResult& result, const std::string& name) {
  const std::span<const double> values = result.trace[name];
  return {values.begin(), values.end()};
}

double last(const RunResult& result, const std::string& name) { return result.trace[name].back(); }

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

double largest_difference(const RunResult& a, const RunResult& b) {
  REQUIRE(a.trace.times == b.trace.times);
  double largest = 0.0;
  for (std::size_t i = 0; i < a.trace.names.size(); ++i) {
    const std::vector<double>& exact = a.trace.columns[i];
    largest = std::max(largest, largest_difference(exact, b.trace.columns[i]) / largest_magnitude(exact));
  }
  return largest;
}

CsvTable reference_trace(const std::string& name) {
  const std::string text = file_text(in_project("tests/data/traces/" + name + ".csv"));
  if (text.empty()) throw std::runtime_error("no reference trace " + name);
  return parse_csv(text);
}

double largest_error(CompiledModel compiled, const CsvTable& reference, const std::vector<std::string>& names) {
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
    largest = std::max(largest, largest_difference(exact, column(result, name)) / largest_magnitude(exact));
  }
  return largest;
}

Linearization linear_at(const Study& study, const RunInputs& inputs, double t, const std::vector<double>& x,
                        const std::vector<std::string>& names) {
  RunInputs point = inputs;
  point.start = t;
  point.initial.clear();
  const std::vector<State>& states = study.equations().states;
  for (std::size_t i = 0; i < states.size(); ++i)
    point.initial.push_back({states[i].element, states[i].port, x[i], {}, states[i].signal, 0.0});
  // Elements first, by number and port, then integrals: those have no element.
  std::sort(point.initial.begin(), point.initial.end(), [](const RunInputs::Initial& p, const RunInputs::Initial& q) {
    const auto key = [](const RunInputs::Initial& one) {
      return std::tuple(!one.element.valid(), one.element.valid() ? one.element.index() : one.signal.index(), one.port);
    };
    return key(p) < key(q);
  });
  const LinearSystem system = study.linearized(point, names);
  const auto dense = [](const LinearMatrix& matrix) {
    std::vector<double> values(matrix.rows * matrix.columns, 0.0);
    for (const auto& e : matrix.entries) values[e.row * matrix.columns + e.column] = e.value;
    return values;
  };
  return {dense(system.a),      dense(system.b[0]),   dense(system.c),      dense(system.d[0]),
          system.states.size(), system.inputs.size(), system.outputs.size()};
}

Linearization linear(const Study& study, const std::string& scene, const std::vector<std::string>& inputs,
                     const std::vector<std::string>& set) {
  const RunInputs at_start = inputs_with(study, scene, set);
  const CompiledModel compiled = compile_study(study, at_start);
  Evaluator evaluator(compiled.program, at_start.parameters);
  const std::vector<double> x = initial_states(evaluator, at_start);
  return linear_at(study, at_start, at_start.start, x, inputs);
}

std::vector<std::complex<double>> poles(const Linearization& linearization) {
  const auto n = static_cast<Eigen::Index>(linearization.states);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> a(linearization.a.data(), n, n);
  const Eigen::VectorXcd values = eigenvalues(a);
  std::vector<std::complex<double>> sorted(values.data(), values.data() + n);
  std::sort(sorted.begin(), sorted.end(),
            [](const auto& p, const auto& q) { return std::pair(p.real(), p.imag()) < std::pair(q.real(), q.imag()); });
  return sorted;
}

std::vector<std::string> models_in(const std::string& folder) {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::directory_iterator(in_project(folder)))
    if (entry.path().extension() == ".json") paths.push_back(folder + "/" + entry.path().filename().string());
  REQUIRE_FALSE(paths.empty());
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::vector<std::string> runnable_models_in(const std::string& folder) {
  std::vector<std::string> with_scenes;
  for (const std::string& path : models_in(folder))
    if (!read_model(in_project(path)).scenes.empty()) with_scenes.push_back(path);
  return with_scenes;
}

}  // namespace bgsim::test
