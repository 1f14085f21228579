// bgsim sensitivity: by how much outputs change with parameters.
#include "bgsim/sensitivity.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <thread>

#include "bgsim/text.hpp"
#include "bgsim/trace_csv.hpp"
#include "command.hpp"
#include "files.hpp"
#include "linear_options.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "output_file.hpp"
#include "progress.hpp"
#include "scenes.hpp"
#include "stages.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace {

struct SensitivityArguments {
  LinearArguments model;  ///< file, scene, outputs, reading, overrides, the file to write
  std::vector<std::string> to;
  std::string norm = "final";
  RunLimits limits;
  unsigned threads = std::max(1U, std::thread::hardware_concurrency());
  bool no_error_estimate = false;
};

SensitivityArguments parse(const Arguments& arguments) {
  SensitivityArguments options;
  LinearArguments& model = options.model;
  CLI::App app(
      "By how much the outputs of a scene change with parameters and initial values: exact derivatives by the "
      "variational equations.",
      "bgsim sensitivity");
  app.footer(
      "Example: bgsim sensitivity models/bellow.json --scene step --of x --to k,m --norm peak\n"
      "Over whole ranges of parameters: bgsim sweep --sample saltelli:N or morris:N (docs/sweep.md).");
  app.add_option("model.json", model.file, "the model")->required();
  add_read_options(app, model.reading);
  app.add_option("--scene", model.scene, "scene to run (default: the model's first)")->type_name("NAME");
  app.add_option("--of", model.outputs,
                 "outputs or quantities, with commas, or NAME=EXPR; may be repeated (default: the scene's outputs)")
      ->type_name("LIST")
      ->allow_extra_args(false);
  app.add_option("--to", options.to,
                 "parameters and initial values (mass.p), with commas; may be repeated (default: all parameters that "
                 "are numbers)")
      ->type_name("LIST")
      ->allow_extra_args(false);
  app.add_option("--norm", options.norm,
                 "which number of an output: final (its last value), rms (root of the mean square) or peak (largest "
                 "magnitude); default: final")
      ->type_name("NORM")
      ->check(CLI::IsMember({"final", "rms", "peak"}));
  app.add_option("-o", model.output, "writes the outputs and their derivatives over time, as CSV")->type_name("FILE");
  app.add_option("-j,--jobs", options.threads, "number of threads (default: one for each processor)")
      ->type_name("N")
      ->check(CLI::Range(1U, 4096U));
  add_set_option(app, model.overrides);
  add_parameters_option(app, model.reading);
  add_time_options(app, model.reading);
  add_solver_options(app, model.overrides);
  add_limit_options(app, options.limits);
  app.add_flag("--no-error-estimate", options.no_error_estimate,
               "no second run at ten times the tolerance, by which errors are estimated");
  app.add_flag("--quiet", model.quiet, "print warnings and errors only, beside the result");
  parse_arguments(app, arguments);
  take_outputs(model);
  return options;
}

/// Parameters that the model, not another parameter, gives a value.
std::vector<std::string> numbers_of(const Model& model) {
  std::vector<std::string> names;
  for (const Parameter& parameter : model.parameters)
    if (model.pool.is_constant(parameter.value)) names.push_back(parameter.name);
  return names;
}

/// "m/(N/m)"; empty if one of them is not known.
std::string derivative_unit(const std::string& of, const std::string& by) {
  if (of.empty() || by.empty() || of == "1" || by == "1") return by == "1" ? of : std::string();
  const auto in_parentheses = [](const std::string& unit) {
    return unit.find_first_of("*/ ") == std::string::npos ? unit : '(' + unit + ')';
  };
  return of + '/' + in_parentheses(by);
}

std::string number_or_none(double value) { return std::isnan(value) ? "" : number_text(value, 6); }

void print(const SensitivityTable& table, const std::string& norm) {
  std::cout << "scene " << short_name(table.scene) << '\n';
  for (std::size_t i = 0; i < table.outputs.size(); ++i) {
    const std::string unit = table.output_units[i].empty() ? "" : ' ' + visible_line(table.output_units[i]);
    std::cout << '\n'
              << (norm == "final" ? "" : norm + " of ") << short_name(table.outputs[i]) << " = "
              << number_text(table.values[i], 9) << unit;
    if (norm == "rms")
      std::cout << '\n';
    else
      std::cout << " at t = " << number_text(table.times[i], 6) << '\n';
    // The most important first: per cent by per cent, which can be compared.
    std::vector<std::size_t> order(table.parameters.size());
    for (std::size_t p = 0; p < order.size(); ++p) order[p] = p;
    const auto size = [&](std::size_t p) {
      const double relative = table.of[i][p].relative;
      return std::isfinite(relative) ? std::abs(relative) : 0.0;
    };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size(a) > size(b); });
    TextTable text({"p", "value", "d/dp", "within", "unit", "% by %"});
    for (const std::size_t p : order) {
      const OutputSensitivity& each = table.of[i][p];
      text.add({table.parameters[p], number_or_none(table.parameter_values[p]), number_text(each.derivative, 9),
                std::isnan(each.error) ? "" : number_text(each.error, 2),
                derivative_unit(table.output_units[i], table.parameter_units[p]), number_or_none(each.relative)});
    }
    std::cout << text.text();
  }
}

}  // namespace

Exit sensitivity_command(const Arguments& arguments) {
  SensitivityArguments options = parse(arguments);
  LinearArguments& given = options.model;
  if (!given.output.empty() && !given.output.ends_with(".csv"))
    throw UsageError("-o " + short_path(given.output) + ": the file is to end in .csv");
  const Study study = study_of(given.file, given.reading);
  const Model& model = study.model();
  const RunInputs inputs = prepare(model, given.scene, given.overrides);
  print_warnings(inputs.warnings, model);
  std::vector<std::string> to = split_names(options.to);
  if (to.empty()) to = numbers_of(model);
  if (to.empty()) throw UsageError("which parameters? --to NAME,NAME (initial values, too: --to mass.p)");
  for (std::size_t i = 0; i < to.size(); ++i)
    if (std::find(to.begin(), to.begin() + static_cast<std::ptrdiff_t>(i), to[i]) !=
        to.begin() + static_cast<std::ptrdiff_t>(i))
      throw UsageError("--to names \"" + short_name(to[i]) + "\" twice");
  if (inputs.outputs.empty()) throw UsageError("which outputs? --of NAME,NAME");
  if (!given.output.empty()) check_outputs({{given.output, "-o"}}, files_of(model));

  const SensitivityNorm norm = options.norm == "rms"    ? SensitivityNorm::rms
                               : options.norm == "peak" ? SensitivityNorm::peak
                                                        : SensitivityNorm::final;
  SensitivityTable table;
  {
    const RunWatch watch(inputs.start, inputs.stop, true);
    SimulateOptions how;
    how.progress = [](double) { return !was_interrupted(); };
    options.limits.apply(how);
    try {
      table = sensitivities(study, given.scene, given.overrides, to, norm, how, options.threads,
                            !options.no_error_estimate);
    } catch (const ModelError& error) {
      // A name of the command line.
      if (error.diagnostics.front().code == "BG413") throw UsageError(render(error));
      throw;
    }
  }
  for (const std::string& note : table.notes)
    if (!given.quiet) std::cerr << "note: " << visible_line(note) << '\n';
  print(table, options.norm);
  if (given.output.empty()) return Exit::done;
  OutputFile file(given.output);
  write_trace_csv(file.stream(), table.trace);
  commit_all({&file});
  return Exit::done;
}

}  // namespace bgsim::cli
