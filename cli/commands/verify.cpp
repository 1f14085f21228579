// bgsim verify: scenes that name a reference, held against it.
#include "bgsim/verify.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <sstream>

#include "bgsim/text.hpp"
#include "command.hpp"
#include "exit_code.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "stages.hpp"

namespace bgsim::cli {

namespace fs = std::filesystem;

namespace {

std::vector<std::string> all_models() {
  std::error_code fault;
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator("models", fault)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path().string());
  }
  if (fault) throw UsageError("there is no folder \"models\" here; name the models to verify");
  std::sort(files.begin(), files.end());
  return files;
}

/// One line of the table: columns of fixed width, the last one free.
void print_line(const std::string& model, const std::string& scene, const std::string& column, const std::string& error,
                const std::string& where, const std::string& limit, const std::string& verdict) {
  const auto padded = [](const std::string& name, std::size_t width) {
    const std::string text = short_name(name);
    const std::size_t length = character_count(text);
    return text + std::string(length < width ? width - length : 0, ' ');
  };
  std::cout << std::left << padded(model, 24) << ' ' << padded(scene, 16) << ' ' << padded(column, 20) << ' '
            << std::setw(10) << error << ' ' << std::setw(12) << where << ' ' << std::setw(10) << limit << ' '
            << verdict << '\n';
}

void print_check(const std::string& model, const std::string& scene, const ReferenceCheck& check) {
  for (const ColumnCheck& column : check.columns) {
    print_line(model, scene, column.output, number_text(column.error, 3), number_text(column.time, 6),
               number_text(column.limit, 3), column.ok() ? "ok" : "MISSED");
    if (column.ok()) continue;
    std::cout << "    at t = " << number_text(column.time, 17) << ": " << short_name(column.output) << " = "
              << number_text(column.value, 17) << ", the reference has ";
    if (column.low == column.high) {
      std::cout << number_text(column.low, 17) << '\n';
    } else {
      std::cout << number_text(column.low, 17) << " to " << number_text(column.high, 17) << " within the tube\n";
    }
  }
  for (const std::string& name : check.unused)
    std::cout << "    column " << short_name(name) << " of the reference: no output\n";
  for (const std::string& name : check.unheld)
    std::cout << "    output " << short_name(name) << ": no column of the reference, not compared\n";
}

/// Runs one scene at its reference's times and compares.
Exit verify_scene(const Study& study, const std::string& file, const ReadOptions& reading, const RunLimits& limits,
                  const RunInputs& inputs) {
  const Model& model = study.model();
  const std::string label = fs::path(file).stem().string();
  print_warnings(inputs.warnings, model);
  const Reference& reference = inputs.reference.value();
  check_reference(model, file, reference, reading);
  const CsvTable table = read_reference(model, reference);
  const RunInputs adapted = at_reference_times(model, inputs, table);
  const Simulation scene = study.scene(adapted, {.energy_audit = false});
  RunWatch watch(adapted.start, adapted.stop, false);
  SimulateOptions how;
  how.energy_audit = false;
  how.error_estimate = false;
  limits.apply(how);
  how.progress = watch.progress();
  const RunResult result = scene.simulate(how);
  if (result.stop != StopReason::completed) {
    print_line(label, inputs.scene, "", "", number_text(result.report.reached, 6), "", "STOPPED");
    if (result.failure) std::cerr << render(*result.failure, *model.sources);
    return Exit::numerics_failed;
  }
  const ReferenceCheck check = hold_against(model, result.trace, table, reference);
  print_check(label, inputs.scene, check);
  if (adapted.stop < inputs.stop)
    std::cout << "    the reference ends at t = " << number_text(adapted.stop, 6) << ", the scene at "
              << number_text(inputs.stop, 6) << '\n';
  return check.ok() ? Exit::done : Exit::model_at_fault;
}

struct Tally {
  std::size_t held = 0, missed = 0;
  std::vector<std::string> without_reference;
};

Exit verify_file(const std::string& file, const ReadOptions& reading, const RunLimits& limits, Tally& tally) {
  // A model without references is only read: it may be a submodel, which does not stand alone.
  const Study study = read_study(file, reading);
  const std::vector<Scene>& scenes = study.model().scenes;
  if (std::none_of(scenes.begin(), scenes.end(), [](const Scene& scene) { return scene.reference.has_value(); })) {
    tally.without_reference.push_back(file);
    return Exit::done;
  }
  assign_causality(study);
  derive_equations(study);
  Exit outcome = Exit::done;
  for (const Scene& scene : scenes) {
    if (!scene.reference) continue;
    const Exit one = verify_scene(study, file, reading, limits, prepare_scene(study.model(), scene.name));
    ++(one == Exit::done ? tally.held : tally.missed);
    outcome = worse(outcome, one);
    if (was_interrupted()) break;
  }
  return outcome;
}

/// A model that cannot be read or built counts as missed; the others are still verified.
Exit verify_file_guarded(const std::string& file, const ReadOptions& reading, const RunLimits& limits, Tally& tally) {
  try {
    return verify_file(file, reading, limits, tally);
  } catch (const ModelError& error) {
    std::cerr << render(error);
    ++tally.missed;
    return exit_of(error);
  }
}

}  // namespace

Exit verify_command(const Arguments& arguments) {
  std::vector<std::string> files;
  ReadOptions reading;
  CLI::App app("Runs every scene that names a reference trace and holds it against it.", "bgsim verify");
  app.add_option("models", files, "models (default: models/*.json)");
  add_read_options(app, reading);
  RunLimits limits;
  add_limit_options(app, limits);
  app.footer(
      "Examples:\n  bgsim verify                       every model under models/\n  bgsim verify models/bellow.json");
  parse_arguments(app, arguments);
  if (files.empty()) files = all_models();

  print_line("model", "scene", "column", "max error", "at t", "limit", "");
  Tally tally;
  Exit outcome = Exit::done;
  for (const std::string& file : files) {
    outcome = worse(outcome, verify_file_guarded(file, reading, limits, tally));
    if (was_interrupted()) throw Interrupted("interrupted; the results so far are above");
  }
  for (const std::string& file : tally.without_reference)
    std::cout << short_path(file) << ": no scene names a reference\n";
  std::cout << tally.held << " held, " << tally.missed << " missed, " << tally.without_reference.size()
            << " without a reference\n";
  return outcome;
}

}  // namespace bgsim::cli
