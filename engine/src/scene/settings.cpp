#include "scene/settings.hpp"

#include <cmath>
#include <numeric>
#include <unordered_map>

#include "base/codes.hpp"
#include "base/text.hpp"

namespace bgsim {

void choose_tolerances(const Scene& scene, const SceneOverrides& overrides, RunInputs& inputs,
                       std::vector<Diagnostic>& problems) {
  inputs.relative = overrides.relative.value_or(scene.relative.value_or(1e-6));
  inputs.absolute = overrides.absolute ? overrides.absolute : scene.absolute;
  if (!overrides.absolute) inputs.absolute_by_state = scene.absolute_by_state;
  if (!(inputs.relative > 0.0 && inputs.relative < 1.0))
    problems.push_back(
        diagnostic_of("BG146", "the relative tolerance must lie between 0 and 1", {}, {}, "write 1e-6, say"));
  if (inputs.absolute && !(*inputs.absolute > 0.0 && std::isfinite(*inputs.absolute)))
    problems.push_back(diagnostic_of("BG146", "the absolute tolerance must be a finite number greater than 0", {}, {},
                                     "leave it out: it then follows each state's own size"));
}

void choose_method(const Scene& scene, const SceneOverrides& overrides, RunInputs& inputs,
                   std::vector<Diagnostic>& problems) {
  inputs.method = overrides.method.value_or(scene.method);
  const bool of_scene = inputs.method == scene.method;
  const auto step = overrides.step || !of_scene ? overrides.step : scene.step;
  const auto max_order = overrides.max_order || !of_scene ? overrides.max_order : scene.max_order;
  const MethodFacts& facts = facts_of(inputs.method);
  const std::string method = "the method " + in_quotes(facts.name);
  // What was asked for beside the scene has no place in it.
  const bool asked = overrides.method || overrides.step || overrides.max_order;
  const std::optional<Place> place = asked ? std::nullopt : std::optional(scene.method_place);
  const auto refuse = [&](std::string situation, std::string help = {}) {
    problems.push_back(diagnostic_of("BG146", std::move(situation), place, {}, std::move(help)));
  };
  if (facts.fixed_step() && !step)
    refuse(method + " needs a fixed step, which is not given",
           "give the step in units of t: \"step\": 1e-3 in the scene, or --step 1e-3");
  if (!facts.fixed_step() && step)
    refuse(method + " chooses its steps by the tolerances; a step cannot be given",
           "remove the step, or use euler, implicit_euler, rk4 or verlet");
  if (step && !(*step > 0.0 && std::isfinite(*step))) refuse("the step must be a finite number greater than 0");
  if (max_order && facts.most_order == 0)
    refuse(method + " has a fixed order, which cannot be limited", "remove the limit of the order");
  else if (max_order && (*max_order < 1 || *max_order > facts.most_order))
    refuse("the order of " + method + " is limited to 1 to " + std::to_string(facts.most_order));
  inputs.step = step.value_or(0.0);
  inputs.max_order = max_order.value_or(0);
}

std::vector<std::size_t> chosen_outputs(const Model& model, const Scene& scene) {
  std::vector<std::size_t> chosen;
  if (scene.outputs.empty()) {
    chosen.resize(model.outputs.size());
    std::iota(chosen.begin(), chosen.end(), std::size_t{0});
    return chosen;
  }
  std::unordered_map<std::string_view, std::size_t> positions;
  for (std::size_t i = 0; i < model.outputs.size(); ++i) positions.emplace(model.outputs[i].name, i);
  for (const std::string& name : scene.outputs) chosen.push_back(positions.at(name));
  return chosen;
}

}  // namespace bgsim
