/// From a model, as file or as text, to a trace and its numbers.
#pragma once

#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"
#include "support/model_text.hpp"

namespace bgsim::test {

/// Without the limit of a day, whose verdict depends on how fast the machine is.
SimulateOptions untimed();
/// The same without the second run that estimates the errors, for tests that compare a trace with what it has to be.
SimulateOptions one_run();

/// A scene of a model, all of it compiled whatever its outputs depend on.
struct CompiledModel {
  Study study;
  RunInputs inputs;  ///< may be changed before a run
  Program program;

  [[nodiscard]] const Model& model() const { return study.model(); }
  [[nodiscard]] const EquationSystem& system() const { return study.equations(); }
  [[nodiscard]] RunResult run(const SimulateOptions& options = untimed()) const {
    return simulate(program, inputs, options);
  }
};

CompiledModel compile_study(const Study& study, RunInputs inputs);
CompiledModel compile_model(std::shared_ptr<const Model> model, const SceneOverrides& overrides = {},
                            const std::string& scene = {});
CompiledModel compile_text(const std::string& text, const SceneOverrides& overrides = {},
                           const std::string& scene = {});
/// @param path  relative to the project, "models/bellow.json".
CompiledModel compile_file(const std::string& path, const SceneOverrides& overrides = {},
                           const std::string& scene = {});
RunResult run_text(const std::string& text, const SceneOverrides& overrides = {},
                   const SimulateOptions& options = untimed());

/// The whole path of a file.
/// @param path  relative to the project.
std::string in_project(const std::string& path);

/// A model file whose equations are ordered already; fails the test with the message if it is refused.
/// @param path  relative to the project.
Study study_of(const std::string& path);
/// Runs a scene to its end; fails the test if the run does not complete. @param set  "NAME=VALUE" overrides.
RunResult run(const Study& study, const std::string& scene = {}, const std::vector<std::string>& set = {});
RunResult run(const Study& study, const RunInputs& inputs);

SceneOverrides with_relative(double relative);
SceneOverrides with_method(Method method, double relative = 1e-6);
SceneOverrides with_parameters(std::vector<std::string> set);

/// An output's values, row by row.
std::vector<double> column(const RunResult& result, const std::string& name);
double last(const RunResult& result, const std::string& name);
/// An output's value at the record nearest to @p time; fails the test if that is further off than 1e-9 of the run.
double at(const RunResult& result, const std::string& name, double time);
double largest_magnitude(const std::vector<double>& values);
/// Largest distance of two columns of the same length.
double largest_difference(const std::vector<double>& a, const std::vector<double>& b);
/// The same of all columns of two runs at the same times, each relative to the largest magnitude in @p a.
double largest_difference(const RunResult& a, const RunResult& b);

/// A reference trace of tests/data/traces.
CsvTable reference_trace(const std::string& name);
/// A compiled model run at the times of a reference, and its largest error in @p names, each relative to the largest
/// magnitude of the reference's column.
double largest_error(CompiledModel compiled, const CsvTable& reference, const std::vector<std::string>& names);

/// A linear system as dense matrices, row-major: x' = A x + B u, y = C x + D u. Derivatives of inputs are left out.
struct Linearization {
  std::vector<double> a, b, c, d;
  std::size_t states = 0, inputs = 0, outputs = 0;
};
/// At a scene's start (or at states @p x, time @p t).
Linearization linear(const Study& study, const std::string& scene = {}, const std::vector<std::string>& inputs = {},
                     const std::vector<std::string>& set = {});
Linearization linear_at(const Study& study, const RunInputs& run, double t, const std::vector<double>& x,
                        const std::vector<std::string>& names = {});
/// Eigenvalues of A, by real part, then imaginary part.
std::vector<std::complex<double>> poles(const Linearization& linearization);

/// The model files of a folder, by name.
std::vector<std::string> models_in(const std::string& folder);
/// Those that have scenes.
std::vector<std::string> runnable_models_in(const std::string& folder);

}  // namespace bgsim::test
