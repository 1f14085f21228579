// bgsim trade: what accuracy costs on a scene, measured.
#include "bgsim/trade.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "files.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "output_file.hpp"
#include "programs.hpp"
#include "progress.hpp"
#include "scenes.hpp"
#include "stages.hpp"
#include "trade_picture.hpp"

namespace bgsim::cli {

namespace {

struct TradeArguments {
  std::string file, scene, base;
  ReadOptions reading;
  SceneOverrides overrides;
  TradeOptions how;
  std::optional<double> accuracy;
  bool no_picture = false, quiet = false;
};

TradeArguments parse_trade(const Arguments& arguments) {
  TradeArguments options;
  options.how.budget = 120.0;  // what a whole table of a seed model takes
  CLI::App app("Runs a scene with every method over its tolerances or steps, and reports error and cost of each.",
               "bgsim trade");
  app.footer(
      "Writes NAME.SCENE.trade.csv, .json, .svg and .html (docs/performance.md).\n"
      "Example: bgsim trade models/bellow.json --scene tracking --accuracy 1e-4");
  app.add_option("model.json", options.file, "the model")->required();
  add_read_options(app, options.reading);
  app.add_option("--scene", options.scene, "scene to measure (default: the model's first)")->type_name("NAME");
  add_set_option(app, options.overrides);
  add_parameters_option(app, options.reading);
  add_time_options(app, options.reading);
  app.add_option(
         "--accuracy", options.accuracy,
         "required error of the outputs, relative to their ranges: reports the cheapest setting that achieves it")
      ->type_name("X")
      ->check(positive_number());
  app.add_option("--budget", options.how.budget, "approximate total processor time in seconds (default: 120)")
      ->type_name("S")
      ->check(positive_number());
  RecordOptions record;
  add_record_options(app, record, options.reading, "what the files are named after (default: NAME.SCENE.trade)",
                     "BASE");
  app.add_flag("--no-picture", options.no_picture, "leave out the picture; gnuplot is then not needed");
  app.add_flag("--quiet", options.quiet, "print warnings and errors only");
  parse_arguments(app, arguments);
  take_columns(record, options.reading);
  options.base = record.file;
  return options;
}

std::string text(double value, const char* format = "%.2e") {
  std::array<char, 40> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

void print_rows(const Trade& trade) {
  std::array<char, 240> line{};
  std::snprintf(line.data(), line.size(), "%-44s %9s %9s %10s %9s %9s %9s  \n", "setting", "max error", "RMS",
                "time in s", "steps", "rates", "residual");
  std::cout << line.data();
  for (const TradeRow& row : trade.rows) {
    const bool known = !row.errors.empty();
    std::snprintf(line.data(), line.size(), "%-44s %9s %9s %10s %9llu %9llu %9s  ", setting_flags(row.setting).c_str(),
                  known ? text(row.max_error).c_str() : "", known ? text(row.rms_error).c_str() : "",
                  text(row.cpu_seconds).c_str(), static_cast<unsigned long long>(row.steps),
                  static_cast<unsigned long long>(row.rates),
                  row.energy_residual ? text(*row.energy_residual).c_str() : "");
    std::cout << line.data() << (row.pareto ? "* " : "")
              << (row.verdict == TradeVerdict::stable ? "" : std::string(verdict_text(row.verdict)) + ": ")
              << visible_line(row.why) << '\n';
  }
}

void print_reference(const Trade& trade) {
  std::cout << "reference: " << setting_flags(trade.reference.setting) << "; its own error, by "
            << setting_flags(trade.reference.second) << ": " << text(trade.reference.error) << '\n';
  for (const TradeOutput& output : trade.outputs)
    if (!output.judged())
      std::cout << "not judged: " << short_name(output.name) << ", " << visible_line(output.why_not) << '\n';
  for (const std::string& note : trade.notes) std::cout << "note: " << visible_line(note) << '\n';
  std::cout << "* is on the Pareto front: no setting is both cheaper and more exact\n";
}

/// The setting picked from the table, with the check at times that took no part in picking.
std::optional<std::size_t> tell_pick(const Trade& trade, double accuracy) {
  const auto row = pick_row(trade, accuracy);
  if (!row) {
    std::cerr << "bgsim: no setting of the table reaches the accuracy " << text(accuracy, "%.3g")
              << (trade.reference.tells(accuracy, 3.0) ? "" : ": the reference itself is not that exact") << '\n';
    return row;
  }
  const TradeRow& picked = trade.rows[*row];
  std::cout << "accuracy " << text(accuracy, "%.3g") << ": " << setting_flags(picked.setting) << "\n  error "
            << text(picked.max_error) << ", between the output times " << text(picked.check_error) << ", "
            << text(picked.cpu_seconds) << " s\n";
  return row;
}

}  // namespace

Exit trade_command(const Arguments& arguments) {
  TradeArguments options = parse_trade(arguments);
  if (!options.no_picture) require_program(kGnuplot, "--no-picture leaves it out");
  const Study study = study_of(options.file, options.reading);
  const Model& model = study.model();
  const RunInputs inputs = prepare(model, options.scene, options.overrides);
  print_warnings(inputs.warnings, model);
  const std::string base = options.base.empty() ? run_name(model, options.file, inputs.scene) + ".trade" : options.base;
  std::vector<NamedFile> outputs;
  for (const char* kind : {".csv", ".json", ".html", ".svg"}) outputs.push_back({base + kind, "the table or picture"});
  if (options.no_picture) outputs.pop_back();
  check_outputs(outputs, files_of(model));
  OutputFile csv(base + ".csv"), json(base + ".json"), html(base + ".html");
  std::optional<OutputFile> picture;
  if (!options.no_picture) picture.emplace(base + ".svg");

  const Simulation scene = study.scene(inputs);
  SettingWatch watch(options.quiet);
  options.how.tell = [&](const std::string& what) { watch.show(what); };
  options.how.goes_on = [] { return !was_interrupted(); };
  try {
    const Trade trade = measure_trade(scene, options.how);
    watch.clear();
    if (!options.quiet) {
      print_rows(trade);
      print_reference(trade);
    }
    const auto picked = options.accuracy ? tell_pick(trade, *options.accuracy) : std::nullopt;
    csv.stream() << trade_csv(trade);
    json.stream() << trade_json(trade);
    std::string svg;
    if (!options.no_picture) {
      svg = trade_svg(trade, picked);
      picture->stream() << svg;
    }
    html.stream() << trade_html(trade, svg);
    commit_all({&csv, &json, &html, picture ? &*picture : nullptr});
    if (was_interrupted()) std::cerr << "bgsim: interrupted; the table has the measurements so far\n";
    if (!options.quiet) std::cerr << "table and picture: " << short_path(base) << ".csv, .json, .svg, .html\n";
    return was_interrupted() || (options.accuracy && !picked) ? Exit::numerics_failed : Exit::done;
  } catch (const TradeFailure& failure) {
    watch.clear();
    if (was_interrupted()) throw Interrupted("the measurement was interrupted before anything was measured");
    std::cerr << render(failure.diagnostic, *model.sources);
    return Exit::numerics_failed;
  }
}

}  // namespace bgsim::cli
