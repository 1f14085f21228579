/// Scenes as the command line names them.
#pragma once

#include <string>

#include "bgsim/model.hpp"

namespace bgsim::cli {

/// The scene's numbers. A name or a value that came from the command line and is wrong is wrong usage, not the model's
/// fault: such a problem has no place in a file.
/// @throws UsageError, ModelError
RunInputs prepare(const Model& model, const std::string& scene, const SceneOverrides& overrides);

/// "bellow.tracking": what a run's files are named after.
std::string run_name(const Model& model, const std::string& file, const std::string& scene);

}  // namespace bgsim::cli
