// bgsim reduce: no more model than a scene requires.
#include "bgsim/reduce.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "bgsim/csv.hpp"
#include "bgsim/text.hpp"
#include "bgsim/trace_csv.hpp"
#include "command.hpp"
#include "files.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "output_file.hpp"
#include "progress.hpp"
#include "scenes.hpp"
#include "stages.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace fs = std::filesystem;

namespace {

struct ReduceArguments {
  std::string file, scene, output, csv, json;
  std::vector<std::string> keep;
  double error = 1e-2;
  SceneOverrides overrides;
  ReadOptions reading;
};

ReduceArguments parse_reduce(const Arguments& arguments) {
  ReduceArguments options;
  CLI::App app(
      "Removes elements that a scene does not require, the least active first, as long as the error of every output\n"
      "stays within --error. Writes the rest as an ordinary model, with the trace of the full model beside it as its\n"
      "reference.",
      "bgsim reduce");
  app.add_option("model.json", options.file, "the model")->required();
  add_read_options(app, options.reading);
  app.add_option("--scene", options.scene, "the scene (default: the model's first)")->type_name("NAME");
  app.add_option("--error", options.error,
                 "error allowed in the scene's outputs, relative to each one's range (default: 1e-2)")
      ->type_name("X")
      ->check(positive_number());
  app.add_option("--keep", options.keep, "an element that must stay; may be given again")
      ->type_name("NAME")
      ->allow_extra_args(false);
  add_set_option(app, options.overrides);
  add_parameters_option(app, options.reading);
  add_time_options(app, options.reading);
  add_solver_options(app, options.overrides);
  RecordOptions record;
  add_record_options(app, record, options.reading, "the reduced model's file (default: NAME.SCENE.reduced.json)");
  app.add_option("--csv", options.csv, "also write the activities as CSV, - for standard output")->type_name("FILE");
  app.add_option("--json", options.json, "also write all results as JSON, - for standard output")->type_name("FILE");
  app.footer("Example: bgsim reduce models/bellow.json --scene tracking --error 1e-2");
  parse_arguments(app, arguments);
  take_columns(record, options.reading);
  options.output = record.file;
  if (options.output == "-") throw UsageError("the reduced model refers to its trace beside it: -o needs a file");
  if (options.csv == "-" && options.json == "-")
    throw UsageError("the CSV and the JSON cannot both go to standard output");
  return options;
}

std::string element_name(const Model& model, ElementId id) { return model.elements[id.index()].name; }

std::string kind_of(const Model& model, ElementId id) {
  const Element& element = model.elements[id.index()];
  return kind_text(element.kind, element.modulated);
}

void print_activities(std::ostream& out, const Model& model, const std::vector<ElementActivity>& table) {
  constexpr double kBar = 40.0;
  TextTable text({"element", "kind", "activity", "share", "cumulative", ""});
  for (const ElementActivity& row : table)
    text.add({element_name(model, row.element), kind_of(model, row.element), number_text(row.activity, 5),
              percent_text(row.share), percent_text(row.cumulative),
              std::string(static_cast<std::size_t>(std::lround(kBar * row.share)), '#')});
  out << text.text();
}

void print_trials(std::ostream& out, const Model& model, const Reduction& reduction) {
  TextTable text({"element", "cut", "share", "error", "in", ""});
  for (const CutTrial& trial : reduction.trials) {
    const bool refused = !trial.refusal.empty();
    text.add({element_name(model, trial.cut.element), cut_text(trial.cut.kind), percent_text(trial.share),
              refused ? "" : number_text(trial.error.error, 3), refused ? "" : trial.error.output,
              refused      ? "refused: " + trial.refusal
              : trial.made ? "cut"
                           : "kept"});
  }
  out << text.text();
}

void print_sizes(std::ostream& out, const Reduction& r) {
  const auto count = [](std::size_t n) { return std::to_string(n); };
  TextTable text({"", "elements", "bonds", "states", "operations", "steps", "rate evaluations", "integration"});
  const auto row = [&](const char* name, const ModelSize& size, const ModelCost& cost) {
    text.add({name, count(size.elements), count(size.bonds), count(size.states), count(size.operations),
              count(cost.steps), count(cost.rate_evaluations), number_text(1e3 * cost.seconds, 3) + " ms"});
  };
  row("full", r.size_before, r.cost_before);
  row("reduced", r.size_after, r.cost_after);
  out << text.text();
}

void print_errors(std::ostream& out, const Reduction& reduction) {
  TextTable text({"output", "largest error", "root mean square", "largest at t"});
  for (const OutputError& error : reduction.errors)
    text.add({error.output, number_text(error.error, 3), number_text(error.rms, 3), number_text(error.time, 6)});
  out << text.text();
}

void write_csv(std::ostream& out, const Model& model, const std::vector<ElementActivity>& table) {
  out << "element,kind,activity,share,cumulative\r\n";
  for (const ElementActivity& row : table)
    out << csv_field(element_name(model, row.element)) << ',' << kind_of(model, row.element) << ','
        << number_text(row.activity, 17) << ',' << number_text(row.share, 17) << ',' << number_text(row.cumulative, 17)
        << "\r\n";
}

std::string to_json(const Model& model, const std::string& scene, double allowed, const Reduction& r) {
  using Json = nlohmann::ordered_json;
  Json json{{"model", model.name}, {"scene", scene}, {"allowed", allowed}};
  json["activity"] = Json::array();
  for (const ElementActivity& row : r.activity)
    json["activity"].push_back({{"element", element_name(model, row.element)},
                                {"kind", kind_of(model, row.element)},
                                {"activity", row.activity},
                                {"share", row.share},
                                {"cumulative", row.cumulative}});
  json["unobserved"] = Json::array();
  for (const ElementId id : r.unobserved) json["unobserved"].push_back(element_name(model, id));
  json["trials"] = Json::array();
  for (const CutTrial& trial : r.trials) {
    Json entry{{"element", element_name(model, trial.cut.element)},
               {"cut", cut_text(trial.cut.kind)},
               {"share", trial.share},
               {"made", trial.made}};
    if (!trial.refusal.empty())
      entry["refusal"] = trial.refusal;
    else
      entry["error"] = trial.error.error, entry["output"] = trial.error.output, entry["time"] = trial.error.time;
    json["trials"].push_back(std::move(entry));
  }
  json["errors"] = Json::array();
  for (const OutputError& error : r.errors)
    json["errors"].push_back(
        {{"output", error.output}, {"largest", error.error}, {"rms", error.rms}, {"time", error.time}});
  const auto side = [](const ModelSize& size, const ModelCost& cost) {
    return Json{{"elements", size.elements},     {"bonds", size.bonds}, {"states", size.states},
                {"operations", size.operations}, {"steps", cost.steps}, {"rate_evaluations", cost.rate_evaluations},
                {"seconds", cost.seconds}};
  };
  json["full"] = side(r.size_before, r.cost_before);
  json["reduced"] = side(r.size_after, r.cost_after);
  return json_text(json, 2) + "\n";
}

void tell(std::ostream& out, const Model& model, const std::string& scene, const ReduceArguments& options,
          const Reduction& reduction) {
  out << short_name(model.name) << ", scene " << short_name(scene) << ": activity, the integral of |power|\n";
  print_activities(out, model, reduction.activity);
  if (!reduction.unobserved.empty()) {
    out << "\nLeft away, since no output depends on them:";
    for (const ElementId id : reduction.unobserved) out << ' ' << element_name(model, id);
    out << '\n';
  }
  out << "\nCuts tried, with the largest error of an output relative to its range; allowed is "
      << number_text(options.error, 3) << "\n";
  print_trials(out, model, reduction);
  out << '\n';
  print_sizes(out, reduction);
  out << '\n';
  print_errors(out, reduction);
}

}  // namespace

Exit reduce_command(const Arguments& arguments) {
  const ReduceArguments options = parse_reduce(arguments);
  const Study study = study_of(options.file, options.reading);
  const RunInputs inputs = prepare(study.model(), options.scene, options.overrides);
  // What the command line sets becomes part of the scene, and so of the model that is written.
  const auto changed = std::make_shared<const Model>(with_overrides(study.model(), options.scene, options.overrides));
  const Model& model = *changed;
  print_warnings(inputs.warnings, model);
  const std::string output =
      options.output.empty() ? file_name(model.name + '.' + inputs.scene) + ".reduced.json" : options.output;
  const std::string trace = fs::path(output).replace_extension(".reference.csv").string();
  std::vector<NamedFile> outputs{{output, "the reduced model"}, {trace, "its reference trace"}};
  if (!options.csv.empty()) outputs.push_back({options.csv, "--csv"});
  if (!options.json.empty()) outputs.push_back({options.json, "--json"});
  check_outputs(outputs, files_of(model));
  OutputFile model_file(output), trace_file(trace);
  std::optional<OutputFile> csv, json;
  if (!options.csv.empty()) csv.emplace(options.csv);
  if (!options.json.empty()) json.emplace(options.json);

  ReduceOptions how;
  how.scene = inputs.scene;
  how.error = options.error;
  how.keep = options.keep;
  how.parent = options.file;
  how.file = output;
  how.reference = fs::path(trace).filename().string();
  const Reduction reduction = [&] {
    RunWatch watch(inputs.start, inputs.stop, false);
    how.progress = watch.progress();
    return reduce(Study(changed), how);
  }();

  // Data are named from the folder of the file, and are to lie in it. What the command line adds is in the text.
  ReadOptions again;
  again.roots = options.reading.roots;
  again.path = options.reading.path;
  again.allow_outside = options.reading.allow_outside;
  try {
    static_cast<void>(read_model_text(output, reduction.text, again));
  } catch (const ModelError& error) {
    throw UsageError("the reduced model could not be read as " + short_path(output) + ": " +
                     error.diagnostics.front().situation + "\nwrite it into the folder of " + short_path(options.file));
  }
  write_trace_csv(trace_file.stream(), reduction.reference);
  model_file.stream() << reduction.text;
  if (csv) write_csv(csv->stream(), model, reduction.activity);
  if (json) json->stream() << to_json(model, inputs.scene, options.error, reduction);
  commit_all({&trace_file, &model_file, csv ? &*csv : nullptr, json ? &*json : nullptr});
  const bool free = options.csv != "-" && options.json != "-";
  tell(free ? std::cout : std::cerr, model, inputs.scene, options, reduction);
  std::cerr << "model: " << short_path(output) << ", with the full model's trace in " << short_path(trace) << '\n';
  return Exit::done;
}

}  // namespace bgsim::cli
