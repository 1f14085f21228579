/// Options that several subcommands share.
#pragma once

#include <CLI/CLI.hpp>

#include "bgsim/input_file.hpp"
#include "bgsim/model.hpp"

namespace bgsim::cli {

/// Accepts finite numbers above zero.
CLI::Validator positive_number();

/// --allow-outside: which files a model may name. For every command that reads a model.
void add_read_options(CLI::App& app, ReadOptions& reading);

/// --set, may be given again.
void add_set_option(CLI::App& app, SceneOverrides& overrides);

/// --relative, --absolute, --method, --step and --max-order.
void add_solver_options(CLI::App& app, SceneOverrides& overrides);

}  // namespace bgsim::cli
