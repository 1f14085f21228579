// bgsim check: what the engine makes of a model, without running it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "bgsim/describe.hpp"
#include "bgsim/infer_units.hpp"
#include "command.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "scenes.hpp"
#include "stages.hpp"

namespace bgsim::cli {

Exit check_command(const Arguments& arguments) {
  std::string file;
  ReadOptions reading;
  CLI::App app("Reports causal strokes with reasons, states, dependent stores, loops and units.", "bgsim check");
  app.add_option("model.json", file, "the model")->required();
  SceneOverrides overrides;
  add_read_options(app, reading);
  add_set_option(app, overrides);
  add_parameters_option(app, reading);
  std::string mode;
  add_mode_option(app, mode);
  app.footer("Example: bgsim check models/actuator.json");
  parse_arguments(app, arguments);

  const Study study = read_study(file, reading, mode);
  const Model& model = study.model();
  std::cout << describe_modes(model, study.graph());
  print_mode(study);
  assign_causality(study);
  // Results are printed before the next stage may refuse the model: the strokes help to understand why.
  std::cout << describe_causality(model, study.graph(), study.causality()) << std::endl;
  derive_equations(study);
  std::cout << describe_loops(model, study.equations(), study.order());
  // A scene that cannot be prepared is as much a fault of the model as a stroke that cannot be placed.
  for (const Scene& scene : model.scenes) print_warnings(prepare(model, scene.name, overrides).warnings, model);
  std::cout << describe_units(model, infer_units(model, study.graph()));
  const std::vector<Diagnostic> problems = unit_problems(model, study.graph());
  print_warnings(problems, model);
  const bool contradicts = std::any_of(problems.begin(), problems.end(),
                                       [](const Diagnostic& problem) { return problem.severity == Severity::error; });
  return contradicts ? Exit::model_at_fault : Exit::done;
}

}  // namespace bgsim::cli
