// bgsim show: a stage's value as text.
#include <CLI/CLI.hpp>
#include <iostream>
#include <numeric>

#include "bgsim/describe.hpp"
#include "bgsim/infer_units.hpp"
#include "command.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "stages.hpp"

namespace bgsim::cli {

namespace {

const std::vector<std::string> kStages = {"model", "graph", "units", "causality", "equations", "order", "program"};

/// A program that computes every output.
Program whole_program(const Study& study) {
  std::vector<std::size_t> outputs(study.model().outputs.size());
  std::iota(outputs.begin(), outputs.end(), std::size_t{0});
  return compile(study.shared_model(), study.equations(), study.order(), {outputs, true});
}

std::string stage_text(const std::string& file, const ReadOptions& reading, const std::string& stage,
                       const std::string& mode) {
  const Study study = read_study(file, reading, mode);
  const Model& model = study.model();
  if (stage == "model") return show_model(model);
  if (stage == "graph") return show_graph(model, study.graph());
  if (stage == "units") return show_units(model, study.graph(), infer_units(model, study.graph()));
  assign_causality(study);
  if (stage == "causality") return show_causality(model, study.graph(), study.causality());
  if (stage == "equations") {
    print_warnings(study.equations().warnings, model);
    return show_equations(model, study.equations());
  }
  derive_equations(study);
  if (stage == "order") return show_order(model, study.equations(), study.order());
  return show_program(whole_program(study));
}

}  // namespace

Exit show_command(const Arguments& arguments) {
  std::string file, stage, mode;
  ReadOptions reading;
  CLI::App app("Prints the value of a stage of the pipeline for a model.", "bgsim show");
  app.add_option("model.json", file, "the model")->required();
  add_read_options(app, reading);
  app.add_option("--stage", stage, "model, graph, units, causality, equations, order or program")
      ->type_name("NAME")
      ->required()
      ->check(CLI::IsMember(kStages));
  add_mode_option(app, mode);
  app.footer("Example: bgsim show models/bellow.json --stage causality");
  parse_arguments(app, arguments);
  std::cout << stage_text(file, reading, stage, mode);
  return Exit::done;
}

}  // namespace bgsim::cli
