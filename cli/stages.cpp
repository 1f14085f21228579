#include "stages.hpp"

#include <algorithm>
#include <iostream>

#include "command.hpp"

namespace bgsim::cli {

void print_warnings(const std::vector<Diagnostic>& warnings, const Model& model) {
  for (const Diagnostic& warning : warnings) std::cerr << render(warning, *model.sources);
}

bool is_wrong_usage(const ModelError& error) {
  return std::all_of(error.diagnostics.begin(), error.diagnostics.end(), [&](const Diagnostic& problem) {
    if (!problem.place || problem.place->document.index() >= error.sources->size()) return problem.code != "BG100";
    return (*error.sources)[problem.place->document.index()].path() == kCommandLine;
  });
}

Stages run_stages(const std::string& path, const ReadOptions& reading, Stage last) {
  Stages stages;
  try {
    stages.model =
        timed(stages.seconds, "read", [&] { return std::make_shared<const Model>(read_model(path, reading)); });
  } catch (const ModelError& error) {
    if (!is_wrong_usage(error)) throw;
    throw UsageError(render(error));
  }
  print_warnings(stages.model->warnings, *stages.model);
  advance(stages, last);
  return stages;
}

void advance(Stages& stages, Stage last) {
  const Model& model = *stages.model;
  auto& seconds = stages.seconds;
  if (last >= Stage::graph && !stages.graph) {
    stages.graph = timed(seconds, "graph", [&] { return build_bond_graph(model); });
  }
  if (last >= Stage::causality && !stages.causal) {
    stages.causal = timed(seconds, "causality", [&] { return assign_causality(model, *stages.graph); });
    print_warnings(stages.causal->warnings, model);
  }
  if (last >= Stage::equations && !stages.system) {
    stages.system = timed(seconds, "equations", [&] { return derive_equations(model, *stages.graph, *stages.causal); });
    print_warnings(stages.system->warnings, model);
  }
  if (last >= Stage::order && !stages.order) {
    stages.order = timed(seconds, "order", [&] { return order_equations(model, *stages.system); });
  }
}

SceneProgram compile_scene(const Stages& stages, const RunInputs& inputs, bool audit, bool keep_all,
                           StageSeconds& seconds) {
  const Model& model = *stages.model;
  SceneProgram scene;
  scene.whole = &*stages.system;
  if (!keep_all) {
    scene.cut = timed(seconds, "slice", [&] {
      return slice(model, *stages.graph, *stages.system, *stages.order, inputs.outputs, audit);
    });
    if (scene.cut) check_start(stages.model, *stages.system, *stages.order, *scene.cut, inputs);
  }
  const BlockOrder& order = scene.cut ? scene.cut->order : *stages.order;
  scene.program = timed(seconds, "compile", [&] {
    return compile(stages.model, scene.system(), order, {inputs.outputs, audit});
  });
  return scene;
}

}  // namespace bgsim::cli
