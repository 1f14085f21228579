// bgsim check: what the engine makes of a model, without running it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

#include "bgsim/describe.hpp"
#include "bgsim/infer_units.hpp"
#include "bgsim/passivity.hpp"
#include "bgsim/text.hpp"
#include "command.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "scenes.hpp"
#include "stages.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace {

std::string proof_text(Proof proof) {
  return proof == Proof::proved ? "proved" : proof == Proof::refuted ? "refuted" : "not proven";
}

Exit print_passivity(const Passivity& found) {
  TextTable table({"element", "", "", "where"});
  for (const auto* group : {&found.resistors, &found.stores, &found.others})
    for (const PassivityFinding& each : *group) {
      std::string where;
      if (!each.variable.empty())
        where = each.variable + (std::isinf(each.from) ? " below " + number_text(each.to, 6)
                                 : std::isinf(each.to)
                                     ? " above " + number_text(each.from, 6)
                                     : " from " + number_text(each.from, 6) + " to " + number_text(each.to, 6));
      table.add({each.element, proof_text(each.proof), each.reason, where});
    }
  std::cout << table.text();
  for (const std::string& source : found.driven)
    std::cout << short_name(source) << " is driven by signals of the model's states, and may add energy.\n";
  if (found.holds())
    std::cout
        << "Passive: with all sources at zero the stored energy never grows. Where it has a strict minimum, that is "
           "a stable state, and the energy is its Lyapunov function.\n";
  else
    std::cout << "Passivity is not proven.\n";
  return found.holds() ? Exit::done : Exit::model_at_fault;
}

}  // namespace

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
  bool passive = false;
  app.add_flag("--passive", passive, "prove that the stored energy falls when the sources are at zero, or say why not");
  std::string of_scene;
  app.add_option("--scene", of_scene, "of --passive: whose parameters hold (default: the model's first)")
      ->type_name("NAME");
  app.footer("Example: bgsim check models/actuator.json");
  parse_arguments(app, arguments);

  const Study study = read_study(file, reading, mode);
  const Model& model = study.model();
  if (passive) {
    static_cast<void>(study.graph());  // for its faults
    return print_passivity(passivity(model, prepare(model, of_scene, overrides)));
  }
  if (!of_scene.empty()) throw UsageError("--scene belongs to --passive\nbgsim check looks at all scenes");
  std::cout << describe_modes(model, study.graph());
  print_mode(study);
  assign_causality(study);
  // Results are printed before the next stage may refuse the model: the strokes help to understand why.
  std::cout << describe_causality(model, study.graph(), study.causality()) << std::endl;
  derive_equations(study);
  std::cout << describe_loops(model, study.equations(), study.order());
  // A scene that cannot be prepared is as much a fault of the model as a stroke that cannot be placed.
  for (const Scene& scene : model.scenes) print_warnings(prepare(model, scene.name, overrides).warnings, model);
  std::optional<Model> as_set;
  for (const Scene& scene : model.scenes)
    if (!overrides.set.empty()) as_set = with_overrides(as_set ? *as_set : model, scene.name, overrides);
  const Model& with_values = as_set ? *as_set : model;
  std::cout << describe_units(with_values, infer_units(with_values, study.graph()));
  const std::vector<Diagnostic> problems = unit_problems(with_values, study.graph());
  print_warnings(problems, model);
  const bool contradicts = std::any_of(problems.begin(), problems.end(),
                                       [](const Diagnostic& problem) { return problem.severity == Severity::error; });
  return contradicts ? Exit::model_at_fault : Exit::done;
}

}  // namespace bgsim::cli
