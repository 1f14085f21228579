#include "linear_options.hpp"

#include <cmath>
#include <iostream>

#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"
#include "model_options.hpp"
#include "names.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "scenes.hpp"
#include "stages.hpp"

namespace bgsim::cli {

void add_linear_options(CLI::App& app, LinearArguments& arguments, const std::string& file) {
  app.add_option("model.json", arguments.file, "the model")->required();
  add_read_options(app, arguments.reading);
  app.add_option("--scene", arguments.scene, "the scene (default: the model's first)")->type_name("NAME");
  add_set_option(app, arguments.overrides);
  add_parameters_option(app, arguments.reading);
  app.add_option("--at", arguments.at,
                 "the point: start of the scene, a steady state near it, or a time of its run (default: start)")
      ->type_name("start|steady|T");
  add_mode_option(app, arguments.mode);
  if (!file.empty()) app.add_option("-o", arguments.output, file)->type_name("FILE");
  app.add_flag("--quiet", arguments.quiet, "print warnings and errors only, beside the result");
}

void add_path_options(CLI::App& app, LinearArguments& arguments, bool several) {
  app.add_option("--in", arguments.inputs,
                 several ? "inputs: sources (pump or pump.e), parameters, signals, with commas (default: all sources)"
                         : "the input: a source (pump or pump.e), a parameter or a signal")
      ->type_name(several ? "LIST" : "NAME")
      ->allow_extra_args(false);
  app.add_option("--out", arguments.outputs,
                 several ? "outputs: names of outputs and quantities, with commas, or NAME=EXPR (default: the scene's)"
                         : "the output: an output or quantity of the model, or NAME=EXPR")
      ->type_name(several ? "LIST" : "NAME")
      ->allow_extra_args(false);
}

std::vector<std::string> split_names(const std::vector<std::string>& lists) {
  std::vector<std::string> names;
  for (const std::string& list : lists) {
    if (list.empty()) throw UsageError("there is an empty list of names");
    for (const std::string& part : parts_of_list(list)) {
      names.push_back(name_of(part));
      if (names.back().empty()) throw UsageError("there is an empty name in the list \"" + list + "\"");
    }
  }
  return names;
}

void take_outputs(LinearArguments& arguments) {
  for (const std::string& given : arguments.outputs)
    for (const std::string& part : parts_of_list(given, true)) {
      const auto equals = end_of_name(part);
      std::string name = name_of(part.substr(0, equals));
      if (name.empty()) throw UsageError("there is an empty name in the list \"" + given + "\"");
      if (equals != std::string::npos) arguments.reading.outputs.emplace_back(name, part.substr(equals + 1));
      arguments.reading.record.push_back(std::move(name));
    }
}

Study linear_study(const LinearArguments& arguments) {
  Study study = read_study(arguments.file, arguments.reading, arguments.mode);
  if (arguments.mode.empty()) study = study.at_start(arguments.scene, arguments.overrides);
  assign_causality(study);
  derive_equations(study);
  return study;
}

namespace {

/// What a run holds at @p t. @param study  comes to be in the mode that the run has there.
RunInputs run_to(Study& study, const RunInputs& inputs, double t, bool quiet) {
  RunInputs run = inputs;
  run.stop = t;
  run.output_times = {t};
  const Simulation scene = study.scene(run, {false, true});
  SimulateOptions how;
  how.energy_audit = how.error_estimate = false;
  RunWatch watch(run.start, run.stop, quiet);
  how.progress = watch.progress();
  const RunResult result = scene.simulate(run, how);
  if (result.stop == StopReason::failed) throw ModelError({*result.failure}, study.model().sources);
  if (result.stop == StopReason::interrupted || result.stored.values.empty())
    throw UsageError("the run to t = " + number_text(t) + " was ended before");
  RunInputs point = inputs;
  if (t > inputs.start)
    point = point_after(study.model(), inputs, result);
  else
    point.initial = result.stored.values;
  if (!result.mode.empty()) study = study.in_mode(result.mode);
  return point;
}

RunInputs point_at(Study& study, const LinearArguments& arguments, double t, std::string& where) {
  const RunInputs inputs = prepare(study.model(), arguments.scene, arguments.overrides);
  if (!(t >= inputs.start))
    throw UsageError("--at " + arguments.at + " is before the scene's start, " + number_text(inputs.start));
  where = "at t = " + number_text(t) + " of the scene " + short_name(inputs.scene);
  if (t == inputs.start) return scene_begun(study, arguments);
  if (!arguments.mode.empty())
    throw UsageError("--mode and --at " + arguments.at +
                     " contradict each other: the run has a mode of its own there\nleave out --mode, or give the "
                     "values that the stores have there with --set");
  return run_to(study, inputs, t, arguments.quiet);
}

RunInputs point_asked_for(Study& study, const LinearArguments& arguments, std::string& where) {
  if (arguments.at == "start") {
    RunInputs inputs = scene_begun(study, arguments);
    where = "at the start of the scene " + short_name(inputs.scene) + ", t = " + number_text(inputs.start);
    return inputs;
  }
  if (arguments.at == "steady") {
    RunInputs inputs = scene_begun(study, arguments);
    const Equilibrium found = (arguments.mode.empty() ? steady_states(study, inputs, {false}).found
                                                      : equilibria(study.shared_model(), inputs, {false}))
                                  .front();
    if (!found.mode.empty()) study = study.in_mode(found.mode);
    where = "at rest, sources as at t = " + number_text(inputs.start) + " of the scene " + short_name(inputs.scene);
    if (!arguments.quiet)
      std::cerr << "note: steady state by " << found.found << ", residual " << number_text(found.residual, 2)
                << " of the rates' terms; bgsim steady looks for others\n";
    inputs.initial = found.values;
    return inputs;
  }
  std::size_t read = 0;
  double t = 0.0;
  try {
    t = std::stod(arguments.at, &read);
  } catch (const std::exception&) {
    read = 0;
  }
  if (read == 0 || read != arguments.at.size() || !std::isfinite(t))
    throw UsageError("--at " + short_name(arguments.at) + " is neither start, steady nor a time");
  return point_at(study, arguments, t, where);
}

/// Where --at says: the scene's start, a time of its run, or a steady state.
/// @param study  in the mode of the start; afterwards in that of the point.
/// @throws UsageError, ModelError
RunInputs point_of(Study& study, const LinearArguments& arguments, std::string& where) {
  RunInputs point = point_asked_for(study, arguments, where);
  const Mode mode = mode_of(study.model());
  if (!mode.empty()) where += ", in the mode " + mode_text(study.model(), mode);
  return point;
}

}  // namespace

RunInputs scene_begun(Study& study, const LinearArguments& arguments) {
  RunInputs inputs = prepare(study.model(), arguments.scene, arguments.overrides);
  return study.model().events.empty() ? inputs : run_to(study, inputs, inputs.start, arguments.quiet);
}

LinearStudy linearized(const LinearArguments& arguments, const std::vector<std::string>& inputs, bool outputs) {
  Study study = linear_study(arguments);
  std::string where;
  RunInputs point = point_of(study, arguments, where);
  print_warnings(point.warnings, study.model());
  if (!outputs) point.outputs.clear();
  LinearSystem system = linear_system(study.shared_model(), point, inputs);
  if (!arguments.quiet) {
    for (const std::string& note : system.notes) std::cerr << "note: " << visible_line(note) << '\n';
    std::string moving;
    std::size_t count = 0;
    for (const LinearVariable& state : system.states)
      if (state.rate != 0.0 && ++count <= 3)
        moving += (moving.empty() ? "" : ", ") + short_name(state.name) + "' = " + number_text(state.rate, 3);
    if (count > 0 && arguments.at != "steady")
      std::cerr << "note: the point is no equilibrium (" << moving << (count > 3 ? ", ..." : "")
                << "); --at steady looks for one\n";
  }
  return {std::move(study), std::move(point), std::move(where), std::move(system)};
}

std::vector<std::string> all_sources(const Model& model) {
  std::vector<std::string> names;
  for (const Element& element : model.elements)
    if (is_source(element.kind) && !is_switch(element.kind) && element.coefficient.valid())
      names.push_back(element.name + "." + letter(*imposed_variable(element.kind)));
  return names;
}

void require_one(const std::vector<std::string>& names, const char* option, const char* example) {
  if (names.size() == 1) return;
  throw UsageError(names.empty() ? std::string(option) + " is missing: " + option + " " + example
                                 : std::string(option) + " takes one name here, not " + std::to_string(names.size()));
}

std::string complex_text(std::complex<double> value, int digits) {
  if (value.imag() == 0.0) return number_text(value.real(), digits);
  return (value.real() == 0.0 ? std::string() : number_text(value.real(), digits) + " ") + "+- " +
         number_text(std::abs(value.imag()), digits) + "j";
}

std::string pole_remark(const Pole& pole) {
  std::string text;
  const double size = std::abs(pole.s);
  if (pole.s == 0.0)
    text = pole.error > 0.0 ? "0 within rounding, " + number_text(pole.error, 2) : "free";
  else if (pole.error > 1e-6 * size)
    text = "known to " + number_text(pole.error, 2);
  if (pole.multiple > 1)
    text += (text.empty() ? "" : "; ") + std::to_string(pole.multiple) + " that rounding does not tell apart";
  return text;
}

}  // namespace bgsim::cli
