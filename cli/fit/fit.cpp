// bgsim fit: parameters and initial values found from measured data. Of the program bgsim-fit, which is linked with
// Ceres and NLopt.
#include "bgsim/fit.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <thread>

#include "bgsim/text.hpp"
#include "bgsim/trace_csv.hpp"
#include "files.hpp"
#include "linear_options.hpp"
#include "model_options.hpp"
#include "names.hpp"
#include "options.hpp"
#include "output_file.hpp"
#include "progress.hpp"
#include "scenes.hpp"
#include "stages.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace {

struct FitArguments {
  LinearArguments model;  ///< file, scene, outputs, reading, overrides, the file to write
  std::string csv;
  std::vector<std::string> data, matches, vary, sigmas;
  std::string loss, write;
  FitPlan plan;
  bool global = false;
  std::uint64_t global_runs = 0;
  RunLimits limits;
  unsigned threads = std::max(1U, std::thread::hardware_concurrency());
};

/// "NAME=VALUE" in two.
std::pair<std::string, std::string> split_pair(const std::string& text, const char* option, const char* form) {
  const auto equals = end_of_name(text);
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw UsageError(std::string(option) + " \"" + short_name(text) + "\" is not of the form " + form);
  return {name_of(text.substr(0, equals)), name_of(text.substr(equals + 1))};
}

bool is_number(const std::string& text) {
  std::size_t read = 0;
  try {
    static_cast<void>(std::stod(text, &read));
  } catch (const std::exception&) {
    return false;
  }
  return read == text.size();
}

double positive_of(const std::string& text, const std::string& option) {
  std::size_t read = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &read);
  } catch (const std::exception&) {
    read = 0;
  }
  if (read == 0 || read != text.size() || !std::isfinite(value) || !(value > 0.0))
    throw UsageError(option + ": \"" + short_name(text) + "\" is no number above 0");
  return value;
}

void take_loss(FitArguments& options) {
  const std::string& text = options.loss;
  if (text.empty()) return;
  const auto colon = text.find(':');
  const std::string name = text.substr(0, colon);
  if ((name != "huber" && name != "cauchy") || colon == std::string::npos)
    throw UsageError("--loss " + short_name(text) + " is neither huber:D nor cauchy:D\nwrite --loss huber:1.5, say");
  options.plan.loss = name == "huber" ? FitLoss::huber : FitLoss::cauchy;
  options.plan.loss_at = positive_of(text.substr(colon + 1), "--loss " + name);
}

void take_matches(FitArguments& options) {
  for (const std::string& text : options.matches) {
    const auto [output, column] = split_pair(text, "--match", "OUTPUT=COLUMN");
    options.plan.matches.push_back({output, column, 0.0, {}});
    std::vector<std::string>& record = options.model.reading.record;
    if (std::find(record.begin(), record.end(), output) == record.end()) record.push_back(output);
  }
  for (const std::string& text : options.sigmas) {
    const auto [output, value] = split_pair(text, "--sigma", "OUTPUT=VALUE");
    // A number, or else a column.
    const bool number = is_number(value);
    const double sigma = number ? positive_of(value, "--sigma " + short_name(output)) : 0.0;
    bool found = false;
    for (FitMatch& match : options.plan.matches)
      if (match.output == output) {
        if (match.sigma > 0.0 || !match.sigma_column.empty())
          throw UsageError("--sigma is given twice for \"" + short_name(output) + "\"");
        found = true;
        match.sigma = sigma;
        if (!number) match.sigma_column = value;
      }
    if (!found) throw UsageError("--sigma names \"" + short_name(output) + "\", which no --match does");
  }
}

FitArguments parse(const Arguments& arguments) {
  FitArguments options;
  LinearArguments& model = options.model;
  CLI::App app(
      "Finds the values of parameters and initial values with which a scene comes nearest to measured data (least "
      "squares, Levenberg-Marquardt).",
      "bgsim fit");
  app.footer("Example: bgsim fit model.json measured.csv --match x=position --vary k=300:400,m --write fitted.json");
  app.add_option("model.json", model.file, "the model")->required();
  app.add_option("data.csv", options.csv, "the data: a column of times, and one for each output that was measured");
  add_read_options(app, model.reading);
  app.add_option("--scene", model.scene, "scene in which data.csv was measured (default: the model's first)")
      ->type_name("NAME");
  app.add_option("--data", options.data, "data of a scene, in place of data.csv; may be repeated, for several scenes")
      ->type_name("SCENE=FILE")
      ->allow_extra_args(false);
  app.add_option("--match", options.matches, "an output or quantity, and its column in the data; may be repeated")
      ->type_name("OUTPUT=COLUMN")
      ->allow_extra_args(false);
  app.add_option("--time", options.plan.time, "the column of times (default: t, or else the first)")
      ->type_name("COLUMN");
  app.add_option("--vary", options.vary,
                 "parameters and initial values (mass.p) that are looked for, with commas, each with its range if it "
                 "has one; may be repeated")
      ->type_name("NAME[=LOWER:UPPER]")
      ->allow_extra_args(false);
  app.add_option(
         "--sigma", options.sigmas,
         "standard deviation of the measurement of an output: a number, or a column of the data with one for each "
         "row; may be repeated")
      ->type_name("OUTPUT=VALUE|COLUMN")
      ->allow_extra_args(false);
  app.add_option("--loss", options.loss,
                 "lets outliers beyond D standard deviations pull less: huber:D or cauchy:D (default: squares)")
      ->type_name("LOSS:D");
  app.add_flag("--global", options.global, "searches the ranges as a whole before");
  app.add_option("--global-runs", options.global_runs, "points that --global tries (default: 200 for each value)")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100000000}));
  app.add_option("--starts", options.plan.starts,
                 "searches from so many further points of the ranges, and takes the best end")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100000}));
  app.add_option("--iterations", options.plan.iterations, "at most so many (default: 100)")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1000000}));
  app.add_option("--write", options.write, "writes the model with the values that were found")
      ->type_name("FITTED.json");
  app.add_option("-o", model.output, "writes outputs and data over time, as CSV")->type_name("FILE");
  app.add_option("-j,--jobs", options.threads, "number of threads (default: one for each processor)")
      ->type_name("N")
      ->check(CLI::Range(1U, 4096U));
  add_set_option(app, model.overrides);
  add_parameters_option(app, model.reading);
  add_time_options(app, model.reading);
  add_solver_options(app, model.overrides);
  add_limit_options(app, options.limits);
  app.add_flag("--quiet", model.quiet, "print warnings and errors only, beside the result");
  parse_arguments(app, arguments);
  take_matches(options);
  take_loss(options);
  for (const std::string& list : split_names(options.vary)) options.plan.vary.push_back(parse_fit_variation(list));
  if (options.global || options.global_runs > 0)
    options.plan.global_runs = options.global_runs > 0 ? options.global_runs : 200 * options.plan.vary.size();
  if (!options.csv.empty() && !options.data.empty())
    throw UsageError("data.csv and --data are given\nwrite --data SCENE=" + short_path(options.csv) +
                     " for the first, too");
  if (options.csv.empty() && options.data.empty())
    throw UsageError("which data? bgsim fit model.json data.csv, or --data SCENE=FILE for several scenes");
  if (!options.data.empty() && !model.scene.empty())
    throw UsageError("--scene and --data name scenes\nleave --scene out");
  return options;
}

void read_data(FitArguments& options, std::vector<NamedFile>& inputs) {
  const auto read = [&](const std::string& scene, const std::string& file) {
    const InputText text = read_input(file, NamedBy::user);
    if (!text.fault.empty()) throw UsageError("the data " + short_path(file) + ": " + text.fault);
    inputs.push_back({file, "the data"});
    options.plan.data.push_back(fit_data(scene, file, text.text));
  };
  if (!options.csv.empty()) read(options.model.scene, options.csv);
  for (const std::string& text : options.data) {
    const auto [scene, file] = split_pair(text, "--data", "SCENE=FILE");
    read(scene, file);
  }
}

std::string number_or_none(double value, int digits) { return std::isfinite(value) ? number_text(value, digits) : ""; }

/// "k by 1 %, m by -0.5 %"
std::string direction_text(const FitDirection& direction) {
  std::string text;
  for (std::size_t i = 0; i < direction.names.size(); ++i)
    text += (i == 0 ? "" : ", ") + short_name(direction.names[i]) + " by " + number_text(direction.shares[i], 3) + " %";
  return text;
}

void print_words(const FitResult& result) {
  for (const FittedValue& value : result.values)
    if (value.bound != 0)
      std::cout << short_name(value.name) << " sits on its " << (value.bound < 0 ? "lower" : "upper")
                << " bound; the standard errors are those of the others at that value.\n";
  for (const FitDirection& direction : result.undetermined) {
    if (direction.names.size() == 1)
      std::cout << "The data do not determine " << short_name(direction.names[0])
                << ": a change of it changes nothing that is compared.\n";
    else
      std::cout << "The data do not tell " << short_name(direction.names[0]) << " and the others apart: a change of "
                << direction_text(direction) << " changes nothing that is compared.\n";
  }
  if (result.residuals <= result.values.size() && !result.known_sigma)
    std::cout
        << "There are as many measurements as values: nothing is left that standard errors could be taken from.\n";
  constexpr double kClose = 0.95;
  for (std::size_t i = 0; i < result.values.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double both = result.correlation[i][j];
      if (!(std::abs(both) > kClose)) continue;
      std::cout << short_name(result.values[j].name) << " and " << short_name(result.values[i].name)
                << " are hard to tell apart (correlation " << number_text(both, 6) << "): what one is too "
                << (both > 0.0 ? "large, the other is too large" : "large, the other is too small") << ".\n";
    }
}

void print(const FitResult& result, const FitPlan& plan) {
  TextTable values({"p", "value", "std error", "95 % from", "to", "unit", "start"});
  for (const FittedValue& value : result.values)
    values.add({value.name, number_text(value.value, 9), number_or_none(value.error, 3), number_or_none(value.low, 6),
                number_or_none(value.high, 6), value.unit, number_text(value.start, 6)});
  std::cout << values.text() << '\n';
  TextTable matches({"output", "column", "scene", "rows", "rms", "at start", "largest", "at t", "unit"});
  for (const FittedMatch& match : result.matches)
    matches.add({match.output, match.column, match.scene, std::to_string(match.rows), number_text(match.rms, 4),
                 number_text(match.start_rms, 4), number_text(match.largest, 4), number_text(match.largest_at, 4),
                 match.unit});
  std::cout << matches.text() << '\n';
  if (result.values.size() > 1) {
    std::vector<std::string> head{"correlation"};
    for (const FittedValue& value : result.values) head.push_back(value.name);
    TextTable correlation(head);
    for (std::size_t i = 0; i < result.values.size(); ++i) {
      std::vector<std::string> row{result.values[i].name};
      for (std::size_t j = 0; j <= i; ++j) row.push_back(number_or_none(result.correlation[i][j], 4));
      row.resize(head.size());
      correlation.add(row);
    }
    std::cout << correlation.text() << '\n';
  }
  print_words(result);
  if (result.known_sigma && plan.loss == FitLoss::squares && std::isfinite(result.deviation))
    std::cout << "Residuals are " << number_text(result.deviation, 4)
              << " times as large as the standard deviations say (1 if model and --sigma are right).\n";
  if (result.starts > 1) std::cout << result.same << " of " << result.starts << " starts came to these values.\n";
  std::cout << result.residuals << " values compared, " << result.iterations << " iterations, " << result.runs
            << " runs.\n";
}

}  // namespace

Exit fit_command(const Arguments& arguments) {
  FitArguments options = [&] {
    try {
      return parse(arguments);
    } catch (const ModelError& error) {
      throw UsageError(render(error));  // a range of --vary
    }
  }();
  LinearArguments& given = options.model;
  if (!given.output.empty() && !given.output.ends_with(".csv"))
    throw UsageError("-o " + short_path(given.output) + ": the file is to end in .csv");
  if (!options.write.empty() && !options.write.ends_with(".json"))
    throw UsageError("--write " + short_path(options.write) + ": the file is to end in .json");
  const Study study = study_of(given.file, given.reading);
  const Model& model = study.model();
  std::vector<NamedFile> inputs;
  try {
    read_data(options, inputs);
  } catch (const ModelError& error) {
    throw UsageError(render(error));
  }
  for (const FitData& data : options.plan.data)
    print_warnings(prepare(model, data.scene, given.overrides).warnings, model);
  for (const NamedFile& file : files_of(model)) inputs.push_back(file);
  std::vector<NamedFile> outputs;
  if (!given.output.empty()) outputs.push_back({given.output, "-o"});
  if (!options.write.empty()) outputs.push_back({options.write, "--write"});
  check_outputs(outputs, inputs);

  FitResult result;
  {
    const RunWatch watch(0.0, 1.0, true);
    SimulateOptions how;
    how.progress = [](double) { return !was_interrupted(); };
    options.limits.apply(how);
    try {
      result = fit(study, options.plan, given.overrides, how, options.threads);
    } catch (const ModelError& error) {
      // Of the command line and the data, not of the model.
      const std::string& code = error.diagnostics.front().code;
      if (code == "BG413" || (code >= "BG415" && code <= "BG419")) throw UsageError(render(error));
      throw;
    }
  }
  for (const std::string& note : result.notes)
    if (!given.quiet) std::cerr << "note: " << visible_line(note) << '\n';
  print(result, options.plan);
  if (!result.converged) {
    std::cerr << "bgsim: the fit has not converged: " << result.stopped
              << "; the values are the best so far, and no file is written\n";
    return Exit::numerics_failed;
  }
  const std::string text =
      options.write.empty() ? ""
                            : fitted_text(study, options.plan, result, given.overrides, given.reading, options.write);
  std::optional<OutputFile> trace, fitted;
  if (!given.output.empty()) write_trace_csv(trace.emplace(given.output).stream(), result.trace);
  if (!options.write.empty()) fitted.emplace(options.write).stream() << text;
  if (trace && fitted)
    commit_all({&*trace, &*fitted});
  else if (trace)
    trace->commit();
  else if (fitted)
    fitted->commit();
  return Exit::done;
}

}  // namespace bgsim::cli
