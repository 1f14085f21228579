/// The engine's stages one after the other, as far as a subcommand needs them, with the time each took.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/bgsim.hpp"
#include "bgsim/input_file.hpp"

namespace bgsim::cli {

/// Wall time by stage, in the order in which they ran.
using StageSeconds = std::vector<std::pair<std::string, double>>;

/// The stages' values in order; those after Stages::last are not there.
struct Stages {
  std::shared_ptr<const Model> model;
  std::optional<BondGraph> graph;
  std::optional<CausalGraph> causal;
  std::optional<EquationSystem> system;
  std::optional<BlockOrder> order;
  StageSeconds seconds;
};

enum class Stage { model, graph, causality, equations, order };

/// Runs the stages up to @p last and prints their warnings.
/// @throws ModelError as the stages do; UsageError for faults of what @p reading says alone.
Stages run_stages(const std::string& path, const ReadOptions& reading, Stage last);

/// Whether nothing but the command line is at fault.
bool is_wrong_usage(const ModelError& error);

/// Runs those of the stages up to @p last that have not been run yet.
void advance(Stages& stages, Stage last);

/// What a run of a scene integrates: what its outputs depend on, compiled.
struct SceneProgram {
  std::optional<Slice> cut;  ///< none if nothing was left out
  const EquationSystem* whole = nullptr;
  Program program;
  [[nodiscard]] const EquationSystem& system() const { return cut ? cut->system : *whole; }
};

/// @param stages  up to Stage::order; must outlive the result.
/// @param audit  whether the energy audit is asked for.
/// @param keep_all  nothing is left out.
/// @throws ModelError BG405 (see check_start).
SceneProgram compile_scene(const Stages& stages, const RunInputs& inputs, bool audit, bool keep_all,
                           StageSeconds& seconds);

/// Prints warnings on standard error.
void print_warnings(const std::vector<Diagnostic>& warnings, const Model& model);

/// Calls @p work and adds its wall time to @p seconds.
template <class Work>
auto timed(StageSeconds& seconds, const std::string& stage, const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  auto value = work();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  seconds.emplace_back(stage, took.count());
  return value;
}

}  // namespace bgsim::cli
