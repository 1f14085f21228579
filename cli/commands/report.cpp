// bgsim report: a model and runs of its scenes on one page.
#include <CLI/CLI.hpp>
#include <ctime>
#include <iostream>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "drawing.hpp"
#include "files.hpp"
#include "interruption.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "output_file.hpp"
#include "report/assets.hpp"
#include "report/content.hpp"
#include "scenes.hpp"
#include "shell_word.hpp"

namespace bgsim::cli {

namespace {

struct ReportArguments {
  std::string file, output;
  std::vector<std::string> scenes, studies;
  ReadOptions reading;
  SceneOverrides overrides;
  std::size_t points = 20000;
  bool all = false, quiet = false;
  RunLimits limits;
};

ReportArguments parse_report(const Arguments& arguments) {
  ReportArguments options;
  CLI::App app(
      "Runs scenes and writes one HTML page that needs nothing else: drawing, causality, equations, plots, "
      "energy audit, activity, statistics.",
      "bgsim report");
  app.footer(
      "Examples:\n"
      "  bgsim report models/bellow.json                    first scene, page in bellow.tracking.report.html\n"
      "  bgsim report models/bellow.json --all -o b.html    every scene, over each other in the plots\n"
      "  bgsim report models/rlc.json --scene under --scene over\n"
      "  bgsim report models/rlc.json --study poles --study 'bode --impedance battery'\n\n"
      "A scene whose run fails is on the page up to there; the exit code is then 3.");
  app.add_option("model.json", options.file, "the model")->required();
  add_read_options(app, options.reading);
  app.add_option("--scene", options.scenes, "a scene to run; may be given again (default: the model's first)")
      ->type_name("NAME")
      ->allow_extra_args(false);
  app.add_flag("--all", options.all, "every scene");
  app.add_option("--study", options.studies,
                 "another command and its options, as one word: what it prints and draws is on the page; may be given "
                 "again (bode, check, control, linearize, poles, sensitivity, steady, step, sweep, trade, transfer, "
                 "zeros)")
      ->type_name("WORDS")
      ->allow_extra_args(false);
  add_set_option(app, options.overrides);
  add_parameters_option(app, options.reading);
  add_time_options(app, options.reading);
  add_solver_options(app, options.overrides);
  add_limit_options(app, options.limits);
  app.add_option("--points", options.points, "samples of a curve to keep for drawing, at most (default: 20000)")
      ->type_name("N")
      ->check(CLI::Range(std::size_t{100}, std::size_t{100'000'000}));
  RecordOptions record;
  add_record_options(app, record, options.reading, "the page, - for standard output (default: NAME.SCENE.report.html)");
  app.add_flag("--quiet", options.quiet, "print warnings and errors only");
  parse_arguments(app, arguments);
  take_columns(record, options.reading);
  options.output = record.file;
  for (const std::string& words : options.studies) check_study(words);
  if (options.all && !options.scenes.empty()) throw UsageError("--all and --scene do not go together");
  return options;
}

/// What was given beside model, scenes and page: the options that a run of one scene takes as well.
std::vector<std::string> settings_of(const SceneOverrides& overrides, const ReadOptions& reading) {
  std::vector<std::string> words = words_of(reading);
  const auto add = [&](const char* option, const std::string& value) { words.insert(words.end(), {option, value}); };
  for (const std::string& set : overrides.set) add("--set", set);
  if (overrides.relative) add("--relative", short_number(*overrides.relative, 17));
  if (overrides.absolute) add("--absolute", short_number(*overrides.absolute, 17));
  if (overrides.method) add("--method", method_name(*overrides.method));
  if (overrides.step) add("--step", short_number(*overrides.step, 17));
  if (overrides.max_order) add("--max-order", std::to_string(*overrides.max_order));
  return words;
}

std::string now() {
  const std::time_t seconds = std::time(nullptr);
  std::tm time{};
  gmtime_r(&seconds, &time);
  std::array<char, 40> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M UTC", &time);
  return text.data();
}

/// Of these options, those that every study takes, too: where files are, and values.
std::vector<std::string> settings_of_studies(const SceneOverrides& overrides, const ReadOptions& reading) {
  ReadOptions files;
  files.allow_outside = reading.allow_outside;
  files.path = reading.path;
  files.parameter_files = reading.parameter_files;
  std::vector<std::string> words = words_of(files);
  for (const std::string& set : overrides.set) words.insert(words.end(), {"--set", set});
  return words;
}

/// The scenes asked for, each once; "" for the model's first, which it may not have.
std::vector<std::string> chosen_scenes(const Model& model, const ReportArguments& options) {
  if (!options.all) return options.scenes.empty() ? std::vector<std::string>{""} : options.scenes;
  std::vector<std::string> names;
  for (const Scene& scene : model.scenes) names.push_back(scene.name);
  return names.empty() ? std::vector<std::string>{""} : names;
}

std::string page_name(const Model& model, const ReportArguments& options, const std::vector<std::string>& scenes) {
  if (!options.output.empty()) return options.output;
  std::string first = scenes.front();
  if (first.empty() && !model.scenes.empty()) first = model.scenes.front().name;
  return (scenes.size() > 1 ? file_name(model.name) : run_name(model, options.file, first)) + ".report.html";
}

}  // namespace

Exit report_command(const Arguments& arguments) {
  const ReportArguments options = parse_report(arguments);
  if (kUplotScript.empty())
    throw UsageError(
        "this bgsim was built without uPlot, which draws the plots of the page: npm could not fetch it. Build it again "
        "where npm reaches its registry, or give cmake uPlot's unpacked package as -DBGSIM_UPLOT_DIR=FOLDER; bgsim run "
        "and bgsim plot do without");
  ReportContent content(study_of(options.file, options.reading));
  const Model& model = content.study.model();
  const std::vector<std::string> scenes = chosen_scenes(model, options);
  const std::string output = page_name(model, options, scenes);
  for (const Scene& scene : model.scenes) {
    const bool runs = std::find(scenes.begin(), scenes.end(), scene.name) != scenes.end() ||
                      (scenes.front().empty() && &scene == &model.scenes.front());
    if (runs && scene.reference) check_reference(model, options.file, *scene.reference, options.reading);
  }
  check_outputs({{output, "the page"}}, files_of(model));
  OutputFile page(output);
  content.file = options.file;
  content.command = {"bgsim", "report"};
  content.command.insert(content.command.end(), arguments.begin(), arguments.end());
  content.settings = settings_of(options.overrides, options.reading);
  content.version = BGSIM_VERSION;
  content.date = now();
  content.points = options.points;
  try {
    content.svg = drawn_svg(model);
  } catch (const UsageError& error) {  // Graphviz is missing: the rest of the page is worth having
    content.why_no_drawing = error.what();
  }

  Exit outcome = Exit::done;
  for (const std::string& name : scenes) {
    content.scenes.push_back(run_for_report(content.study, name, options.overrides, options.limits, options.quiet));
    const RunResult& result = content.scenes.back().result;
    if (result.failure) {
      std::cerr << render(*result.failure, *model.sources);
      outcome = Exit::numerics_failed;
    }
    if (was_interrupted()) break;
  }
  for (const std::string& words : options.studies) {
    if (was_interrupted()) break;
    content.studies.push_back(run_study(content.study, options.file, words,
                                        settings_of_studies(options.overrides, options.reading),
                                        options.scenes.empty() ? "" : options.scenes.front()));
    const ReportedStudy& study = content.studies.back();
    if (study.outcome != Exit::done) std::cerr << "--study " << shell_word(words) << ":\n" << study.text;
    outcome = worse(outcome, study.outcome);
  }
  page.stream() << report_page(content);
  page.commit();
  if (!options.quiet) std::cerr << "report: " << (output == "-" ? "standard output" : short_path(output)) << '\n';
  return outcome;
}

}  // namespace bgsim::cli
