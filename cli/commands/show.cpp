// bgsim show: a stage's value as text.
#include <CLI/CLI.hpp>
#include <iostream>
#include <numeric>

#include "command.hpp"
#include "options.hpp"
#include "stages.hpp"

namespace bgsim::cli {

namespace {

const std::vector<std::string> kStages = {"model", "graph", "units", "causality", "equations", "order", "program"};

/// A program that computes every output.
Program whole_program(const Stages& stages) {
  std::vector<std::size_t> outputs(stages.model->outputs.size());
  std::iota(outputs.begin(), outputs.end(), std::size_t{0});
  return compile(stages.model, *stages.system, *stages.order, {outputs, true});
}

std::string stage_text(const std::string& file, const ReadOptions& reading, const std::string& stage) {
  if (stage == "model") return show_model(*run_stages(file, reading, Stage::model).model);
  if (stage == "graph") {
    const Stages stages = run_stages(file, reading, Stage::graph);
    return show_graph(*stages.model, *stages.graph);
  }
  if (stage == "units") {
    const Stages stages = run_stages(file, reading, Stage::graph);
    return show_units(*stages.model, *stages.graph, infer_units(*stages.model, *stages.graph));
  }
  if (stage == "causality") {
    const Stages stages = run_stages(file, reading, Stage::causality);
    return show_causality(*stages.model, *stages.graph, *stages.causal);
  }
  if (stage == "equations") {
    const Stages stages = run_stages(file, reading, Stage::equations);
    return show_equations(*stages.model, *stages.system);
  }
  const Stages stages = run_stages(file, reading, Stage::order);
  if (stage == "order") return show_order(*stages.model, *stages.system, *stages.order);
  return show_program(whole_program(stages));
}

}  // namespace

Exit show_command(const Arguments& arguments) {
  std::string file, stage;
  ReadOptions reading;
  CLI::App app("Prints what a stage of the pipeline makes of a model.", "bgsim show");
  app.add_option("model.json", file, "the model")->required();
  add_read_options(app, reading);
  app.add_option("--stage", stage, "model, graph, units, causality, equations, order or program")
      ->type_name("NAME")
      ->required()
      ->check(CLI::IsMember(kStages));
  app.footer("Example: bgsim show models/bellow.json --stage causality");
  parse_arguments(app, arguments);
  std::cout << stage_text(file, reading, stage);
  return Exit::done;
}

}  // namespace bgsim::cli
