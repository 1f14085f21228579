/// Exit codes of faults.
#pragma once

#include "bgsim/diagnostic.hpp"
#include "command.hpp"

namespace bgsim::cli {

/// A run that fails or is interrupted within a command (BG6xx) is no fault of the model.
inline Exit exit_of(const ModelError& error) {
  const auto& problems = error.diagnostics;
  const bool numerical = !problems.empty() && problems.front().code.starts_with("BG6");
  return numerical ? Exit::numerics_failed : Exit::model_at_fault;
}

}  // namespace bgsim::cli
