/// Options that several subcommands share.
#pragma once

#include <CLI/CLI.hpp>

#include "bgsim/model.hpp"

namespace bgsim::cli {

/// Accepts finite numbers above zero.
CLI::Validator positive_number();

/// --set, may be given again.
void add_set_option(CLI::App& app, SceneOverrides& overrides);

/// --relative, --absolute, --method, --step and --max-order.
void add_solver_options(CLI::App& app, SceneOverrides& overrides);

}  // namespace bgsim::cli
