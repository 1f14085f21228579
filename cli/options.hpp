/// Options that several subcommands share.
#pragma once

#include <CLI/CLI.hpp>

#include "bgsim/model.hpp"

namespace bgsim::cli {

/// Accepts finite numbers above zero.
CLI::Validator positive_number();

/// --method, --step and --max-order.
void add_method_options(CLI::App& app, SceneOverrides& overrides);

}  // namespace bgsim::cli
