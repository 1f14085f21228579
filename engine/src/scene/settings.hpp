/// What of a run depends on no number of the model: tolerances, method, outputs.
#pragma once

#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// Each fills its members of @p inputs; what is wrong goes to @p problems (BG146).
void choose_tolerances(const Scene& scene, const SceneOverrides& overrides, RunInputs& inputs,
                       std::vector<Diagnostic>& problems);
/// Step and order are part of the method: a method from the command line does not take over the scene's.
void choose_method(const Scene& scene, const SceneOverrides& overrides, RunInputs& inputs,
                   std::vector<Diagnostic>& problems);

/// The outputs that a scene records, as positions in Model::outputs.
std::vector<std::size_t> chosen_outputs(const Model& model, const Scene& scene);

}  // namespace bgsim
