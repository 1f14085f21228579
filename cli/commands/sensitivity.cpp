// bgsim sensitivity: by how much outputs change with parameters.
#include "bgsim/sensitivity.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <thread>

#include "bars.hpp"
#include "bgsim/text.hpp"
#include "bgsim/trace_csv.hpp"
#include "command.hpp"
#include "files.hpp"
#include "linear_options.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "output_file.hpp"
#include "programs.hpp"
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
  bool forward = false, adjoint = false, differences = false;
  std::vector<std::string> files;
};

SensitivityArguments parse(const Arguments& arguments) {
  SensitivityArguments options;
  LinearArguments& model = options.model;
  CLI::App app(
      "By how much the outputs of a scene change with parameters and initial values: exact derivatives by the "
      "variational equations or the adjoint equations, or differences of runs.",
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
                 "which number of an output: final (its last value), rms (root of the mean square), peak (largest "
                 "magnitude), integral (over time) or mean; default: final")
      ->type_name("NORM")
      ->check(CLI::IsMember({"final", "rms", "peak", "integral", "mean"}));
  app.add_option("-o", options.files,
                 "writes the outputs and their derivatives over time (.csv), or draws what matters most (.svg); may be "
                 "repeated")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app.add_option("-j,--jobs", options.threads, "number of threads (default: one for each processor)")
      ->type_name("N")
      ->check(CLI::Range(1U, 4096U));
  add_set_option(app, model.overrides);
  add_parameters_option(app, model.reading);
  add_time_options(app, model.reading);
  add_tolerance_options(app, model.overrides);
  add_method_option(
      app, model.overrides,
      {{"forward", &options.forward}, {"adjoint", &options.adjoint}, {"differences", &options.differences}},
      "forward (a run for each parameter, the default), adjoint (one run back for all of them, each "
      "output by itself) or differences (of runs, also with switches, diodes, contacts and delays)");
  add_limit_options(app, options.limits);
  app.add_flag("--no-error-estimate", options.no_error_estimate,
               "no second run at ten times the tolerance, by which errors are estimated");
  app.add_flag("--quiet", model.quiet, "print warnings and errors only, beside the result");
  parse_arguments(app, arguments);
  if (options.forward + options.adjoint + options.differences > 1)
    throw UsageError("--method names more than one of forward, adjoint and differences");
  take_outputs(model);
  return options;
}

SensitivityNorm norm_of(const std::string& name) {
  if (name == "rms") return SensitivityNorm::rms;
  if (name == "peak") return SensitivityNorm::peak;
  if (name == "integral") return SensitivityNorm::integral;
  return name == "mean" ? SensitivityNorm::mean : SensitivityNorm::final;
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

/// The parameters of one output, the most important first: per cent by per cent, which can be compared; where the
/// output is 0, its change for a per cent of each.
struct Importance {
  bool relative = true;
  std::vector<double> size;        ///< by parameter
  std::vector<std::size_t> order;  ///< of parameters
};
Importance importance_of(const SensitivityTable& table, std::size_t output) {
  Importance result;
  const auto& own = table.of[output];
  result.relative = std::none_of(own.begin(), own.end(), [](const auto& each) { return std::isnan(each.relative); });
  for (std::size_t p = 0; p < own.size(); ++p) {
    result.size.push_back(result.relative ? own[p].relative : 0.01 * own[p].derivative * table.parameter_values[p]);
    result.order.push_back(p);
  }
  const auto size = [&](std::size_t p) { return std::isfinite(result.size[p]) ? std::abs(result.size[p]) : 0.0; };
  std::stable_sort(result.order.begin(), result.order.end(),
                   [&](std::size_t a, std::size_t b) { return size(a) > size(b); });
  return result;
}

/// Bars to both sides of 0: what a per cent more, and a per cent less, of each parameter does.
std::string tornado_svg(const SensitivityTable& table, const std::string& model, const std::string& norm) {
  constexpr std::size_t kMostPanels = 8, kMostRows = 30;
  std::vector<BarPanel> panels;
  for (std::size_t i = 0; i < std::min(table.outputs.size(), kMostPanels); ++i) {
    const Importance importance = importance_of(table, i);
    BarPanel panel;
    // What is a thousandth of the first cannot be seen beside it.
    std::size_t shown = importance.order.size();
    while (shown > 1 && std::abs(importance.size[importance.order[shown - 1]]) <=
                            1e-3 * std::abs(importance.size[importance.order[0]]))
      --shown;
    const std::string rest = std::to_string(importance.order.size() - shown) + " below a thousandth of the first";
    panel.title = norm + " of " + short_name(table.outputs[i]) + ": change" +
                  (importance.relative             ? " in %"
                   : table.output_units[i].empty() ? ""
                                                   : " in " + table.output_units[i]) +
                  " for 1 %" +
                  (shown > kMostRows                 ? ", the first " + std::to_string(kMostRows)
                   : shown < importance.order.size() ? "; " + rest
                                                     : "");
    panel.legend = {"1 % less", "", "1 % more"};
    for (std::size_t r = 0; r < std::min(shown, kMostRows); ++r) {
      const std::size_t p = importance.order[r];
      const double size = importance.size[p];
      const bool none = table.parameter_values[p] == 0.0;
      panel.rows.push_back({table.parameters[p] + (none ? " = 0" : ""), {{0.0, -size, 0.0, 0}, {0.0, size, 0.0, 2}}});
    }
    panels.push_back(std::move(panel));
  }
  return bars_svg(model + ", scene " + table.scene, panels);
}

std::string number_or_none(double value) { return std::isnan(value) ? "" : number_text(value + 0.0, 6); }  // -0 is 0

void print(const SensitivityTable& table, const std::string& norm) {
  std::cout << "scene " << short_name(table.scene) << '\n';
  for (std::size_t i = 0; i < table.outputs.size(); ++i) {
    const std::string unit = table.output_units[i].empty() ? "" : ' ' + visible_line(table.output_units[i]);
    std::cout << '\n'
              << (norm == "final" ? "" : norm + " of ") << short_name(table.outputs[i]) << " = "
              << number_text(table.values[i] + 0.0, 9) << unit;
    if (norm == "final" || norm == "peak") std::cout << " at t = " << number_text(table.times[i], 6);
    std::cout << '\n';
    const std::vector<std::size_t> order = importance_of(table, i).order;
    TextTable text({"p", "value", "d/dp", "within", "unit", "% by %"});
    for (const std::size_t p : order) {
      const OutputSensitivity& each = table.of[i][p];
      text.add({table.parameters[p], number_or_none(table.parameter_values[p]), number_text(each.derivative + 0.0, 9),
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
  for (const std::string& file : options.files) {
    if ((options.adjoint || options.differences) && file.ends_with(".csv"))
      throw UsageError("-o " + short_path(file) + ": derivatives over time are those of --method forward");
    if (!file.ends_with(".csv") && !file.ends_with(".svg"))
      throw UsageError("-o " + short_path(file) + ": the file is to end in .csv or .svg");
    if (file.ends_with(".svg")) require_program(kGnuplot, "-o FILE.csv writes the derivatives instead");
  }
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
  std::vector<NamedFile> outputs;
  for (const std::string& file : options.files) outputs.push_back({file, "-o"});
  check_outputs(outputs, files_of(model));

  const SensitivityNorm norm = norm_of(options.norm);
  SensitivityTable table;
  // By default all parameters are taken: some may have no derivative.
  RefusedParameters refused;
  RefusedParameters* const lenient = options.to.empty() ? &refused : nullptr;
  {
    const RunWatch watch(inputs.start, inputs.stop, true);
    SimulateOptions how;
    how.progress = [](double) { return !was_interrupted(); };
    options.limits.apply(how);
    try {
      const bool errors = !options.no_error_estimate;
      table = options.differences ? difference_sensitivities(study, given.scene, given.overrides, to, norm, how,
                                                             options.threads, lenient)
              : options.adjoint
                  ? adjoint_sensitivities(study, given.scene, given.overrides, to, norm, how, errors, lenient)
                  : sensitivities(study, given.scene, given.overrides, to, norm, how, options.threads, errors, lenient);
    } catch (const ModelError& error) {
      // A name of the command line.
      if (error.diagnostics.front().code == "BG413") throw UsageError(render(error));
      throw;
    }
  }
  if (norm == SensitivityNorm::integral) {
    for (std::string& unit : table.output_units)
      if (unit == "1")
        unit = "s";
      else if (!unit.empty())
        unit += "*s";
  }
  for (const std::string& note : table.notes)
    if (!given.quiet) std::cerr << "note: " << visible_line(note) << '\n';
  print(table, options.norm);
  for (const auto& [name, why] : refused)
    std::cout << "\nno derivative by " << short_name(name) << ": " << visible_line(why.situation) << '\n';
  for (const std::string& name : options.files) {
    OutputFile file(name);
    if (name.ends_with(".csv"))
      write_trace_csv(file.stream(), table.trace);
    else
      file.stream() << tornado_svg(table, model.name, options.norm);
    file.commit();
  }
  return Exit::done;
}

}  // namespace bgsim::cli
