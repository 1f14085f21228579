/// From a model file to a trace, as tests need it.
#pragma once

#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "bgsim/bgsim.hpp"

namespace bgsim::test {

/// The stages' values of one model.
struct Stages {
  std::shared_ptr<const Model> model;
  BondGraph graph;
  CausalGraph causal;
  EquationSystem system;
  BlockOrder order;
};

/// Runs the stages up to ordering. @param path  relative to the project's folder.
Stages read_stages(const std::string& path);

/// Runs a scene to its end; fails the test if the run does not complete. @param set  "NAME=VALUE" overrides.
RunResult run(const Stages& stages, const std::string& scene = {}, const std::vector<std::string>& set = {});
RunResult run(const Stages& stages, const RunInputs& inputs);

/// An output's values, row by row.
std::vector<double> column(const RunResult& result, const std::string& name);
/// An output's value at the record nearest to @p time; fails the test if that is further off than 1e-9 of the run.
double at(const RunResult& result, const std::string& name, double time);
double largest_magnitude(const std::vector<double>& values);
/// Largest distance of two columns of the same length.
double largest_difference(const std::vector<double>& a, const std::vector<double>& b);

/// A, B, C, D at a scene's start (or at states @p x, time @p t), inputs being the named parameters.
Linearization linear(const Stages& stages, const std::string& scene = {}, const std::vector<std::string>& inputs = {},
                     const std::vector<std::string>& set = {});
Linearization linear_at(const Stages& stages, const RunInputs& run, double t, const std::vector<double>& x,
                        const std::vector<std::string>& inputs = {});
/// Eigenvalues of A, by real part, then imaginary part.
std::vector<std::complex<double>> poles(const Linearization& linearization);

/// The model files of a folder that have scenes, by name.
std::vector<std::string> models_in(const std::string& folder);

}  // namespace bgsim::test
