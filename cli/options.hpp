/// Options that several subcommands share.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>

#include "bgsim/input_file.hpp"
#include "bgsim/model.hpp"
#include "bgsim/simulate.hpp"

namespace bgsim::cli {

/// Accepts finite numbers above zero.
CLI::Validator positive_number();

/// --allow-outside and --path, with BGSIM_PATH of the environment: which files a model may name, and where. For every
/// command that reads a model.
void add_read_options(CLI::App& app, ReadOptions& reading);

/// --set, may be given again.
void add_set_option(CLI::App& app, SceneOverrides& overrides);

/// --relative, --absolute, --method, --step and --max-order.
void add_solver_options(CLI::App& app, SceneOverrides& overrides);
/// All of these but --method.
void add_tolerance_options(CLI::App& app, SceneOverrides& overrides);
/// --method of commands that have others beside those of integration.
/// @param others  by name: what is set to true by it
/// @param words   what is said of them
void add_method_option(CLI::App& app, SceneOverrides& overrides, const std::map<std::string, bool*>& others,
                       const std::string& words);

/// What ends a run that goes on for too long.
struct RunLimits {
  std::uint64_t max_steps = 0;  ///< 0: none
  double seconds = 0.0;         ///< 0: none
  bool endless = false;         ///< nothing else does either

  void apply(SimulateOptions& how) const;
};

/// --max-steps, --time-limit and --no-time-limit.
void add_limit_options(CLI::App& app, RunLimits& limits);

}  // namespace bgsim::cli
