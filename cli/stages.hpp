/// The engine's stages one after the other, as far as a subcommand needs them, with the time each took.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/bgsim.hpp"

namespace bgsim::cli {

/// The stages' values in order; those after Stages::last are not there.
struct Stages {
  std::shared_ptr<const Model> model;
  std::optional<BondGraph> graph;
  std::optional<CausalGraph> causal;
  std::optional<EquationSystem> system;
  std::optional<BlockOrder> order;
  std::vector<std::pair<std::string, double>> seconds;  ///< wall time by stage
};

enum class Stage { model, graph, causality, equations, order };

/// Runs the stages up to @p last and prints their warnings.
/// @throws ModelError as the stages do.
Stages run_stages(const std::string& path, Stage last);

/// Runs those of the stages up to @p last that have not been run yet.
void advance(Stages& stages, Stage last);

/// Prints warnings on standard error.
void print_warnings(const std::vector<Diagnostic>& warnings, const Model& model);

/// Calls @p work and adds its wall time to @p seconds.
template <class Work>
auto timed(std::vector<std::pair<std::string, double>>& seconds, const std::string& stage, const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  auto value = work();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  seconds.emplace_back(stage, took.count());
  return value;
}

}  // namespace bgsim::cli
