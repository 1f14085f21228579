#include "scenes.hpp"

#include <filesystem>

#include "command.hpp"
#include "files.hpp"
#include "stages.hpp"

namespace bgsim::cli {

RunInputs prepare(const Model& model, const std::string& scene, const SceneOverrides& overrides) {
  try {
    return prepare_scene(model, scene, overrides);
  } catch (const ModelError& error) {
    if (!is_wrong_usage(error) || model.scenes.empty()) throw;
    throw UsageError(render(error));
  }
}

std::string run_name(const Model& model, const std::string& file, const std::string& scene) {
  const std::string name = model.name.empty() ? std::filesystem::path(file).stem().string() : model.name;
  return file_name(name + '.' + scene);
}

}  // namespace bgsim::cli
