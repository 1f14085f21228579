// bgsim run: a scene of a model, from the file to the trace.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>

#include "bgsim/infer_units.hpp"
#include "bgsim/text.hpp"
#include "bgsim/trace_csv.hpp"
#include "command.hpp"
#include "files.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "output_file.hpp"
#include "progress.hpp"
#include "run_search.hpp"
#include "scenes.hpp"
#include "shell_word.hpp"
#include "stages.hpp"
#include "trace_file.hpp"

namespace bgsim::cli {

namespace {

struct RunOptions {
  std::string file;
  std::string scene;
  ReadOptions reading;
  SceneOverrides overrides;
  std::string output;
  std::string report_json;
  std::string events;
  std::string snapshot, resume;
  std::uint64_t snapshot_steps = 0;
  std::optional<double> accuracy;
  RunLimits limits;
  bool quiet = false;
  bool no_audit = false, no_error_estimate = false;
  bool keep_all = false;
  bool units = false;
  bool all_scenes = false;
};

constexpr const char* kExamples =
    "Examples:\n"
    "  bgsim bellow.json                            first scene, trace in bellow.tracking.csv\n"
    "  bgsim bellow.json --scene literal -o x.csv   another scene, trace in x.csv\n"
    "  bgsim bellow.json --set m=0.02 --set 'C2=2*A*X/(rho*R_gas*T)'\n"
    "  bgsim bellow.json --stop 1 --output 'power=body.f*mass.e'   ends earlier, one more column\n"
    "  bgsim bellow.json --record all               every effort, flow, state and signal\n"
    "  bgsim bellow.json -o - --quiet | head        trace on standard output\n"
    "  bgsim bellow.json --stop 1 --snapshot s.json, then --resume s.json -o rest.csv   in two parts\n"
    "\n"
    "Exit codes: 0 done, 1 error in the model, 2 wrong usage, 3 numerical failure (or the run was\n"
    "interrupted; the trace up to there is kept), 4 a defect of bgsim.\n"
    "\n"
    "Further commands: bgsim --help";

RunOptions parse_run(const Arguments& arguments) {
  RunOptions options;
  CLI::App app("Simulates a scene of a model and writes its trace as CSV.", "bgsim");
  app.footer(kExamples);
  app.add_option("model.json", options.file, "the model")->required();
  add_read_options(app, options.reading);
  app.add_option("--scene", options.scene, "scene to run (default: the model's first)")->type_name("NAME");
  add_set_option(app, options.overrides);
  add_parameters_option(app, options.reading);
  add_time_options(app, options.reading);
  add_solver_options(app, options.overrides);
  app.add_option("--accuracy", options.accuracy,
                 "error wanted in the outputs, relative to their ranges: the cheapest setting is found, then run")
      ->type_name("X")
      ->check(positive_number());
  add_limit_options(app, options.limits);
  RecordOptions record;
  add_record_options(app, record, options.reading,
                     "file for the trace, - for standard output (default: NAME.SCENE.csv)");
  app.add_option("--report-json", options.report_json, "also write the report as JSON, - for standard output")
      ->type_name("FILE");
  app.add_option("--events", options.events,
                 "also write what happens at single instants as CSV: switches, impacts, conditions, ...; - for "
                 "standard output")
      ->type_name("FILE");
  app.add_option("--snapshot", options.snapshot,
                 "also write the state at the end of the run, for --resume; where a limit or Ctrl-C ends it, too")
      ->type_name("FILE");
  app.add_option("--snapshot-steps", options.snapshot_steps, "write it every N steps as well")
      ->type_name("N")
      ->check(positive_number());
  app.add_option("--resume", options.resume,
                 "continue the run that wrote this snapshot; the trace has the rows after it")
      ->type_name("FILE");
  app.add_flag("--units", options.units,
               "also write the columns' units, to NAME.SCENE.units.json or FILE with that ending");
  app.add_flag("--all-scenes", options.all_scenes, "run every scene, each to its own NAME.SCENE.csv");
  app.add_flag("--no-audit", options.no_audit, "leave out the energy audit");
  app.add_flag("--no-error-estimate", options.no_error_estimate, "leave out the estimate of the outputs' errors");
  app.add_flag("--keep-all", options.keep_all, "also integrate what no recorded output depends on");
  app.add_flag("--quiet", options.quiet, "print warnings and errors only");
  parse_arguments(app, arguments);
  take_columns(record, options.reading);
  options.output = record.file;

  if (options.all_scenes &&
      !(options.scene.empty() && options.output.empty() && options.report_json.empty() && options.events.empty())) {
    throw UsageError("--all-scenes goes with none of --scene, --output, --report-json and --events");
  }
  const SceneOverrides& set = options.overrides;
  if (options.accuracy && (set.method || set.relative || set.absolute || set.step || set.max_order)) {
    throw UsageError(
        "--accuracy finds method and tolerance; it goes with none of --method, --relative, --absolute, "
        "--step and --max-order");
  }
  if (options.snapshot_steps > 0 && options.snapshot.empty())
    throw UsageError("--snapshot-steps needs --snapshot FILE, the file to write");
  if (options.all_scenes && !(options.snapshot.empty() && options.resume.empty()))
    throw UsageError("a snapshot is of one scene: --all-scenes goes with neither --snapshot nor --resume");
  if (options.snapshot == "-") throw UsageError("--snapshot needs the name of a file: a later snapshot replaces it");
  if (options.output == "-" && options.report_json == "-") {
    throw UsageError("the trace and the report cannot both go to standard output");
  }
  if (options.events == "-" && (options.output == "-" || options.report_json == "-"))
    throw UsageError("the events go to standard output alone: give a file for the trace or the report");
  return options;
}

/// What contradicts in units, a line each: a run uses the numbers as they stand, whatever their units.
void warn_of_units(const Model& model, const UnitReport& units, const RunOptions& options) {
  for (Diagnostic problem : units.problems) {
    problem.severity = Severity::warning;
    std::cerr << headline(problem, *model.sources);
  }
  if (units.problems.empty()) return;
  std::string command = "bgsim check " + short_path(shell_word(options.file));
  for (const std::string& set : options.overrides.set) command += " --set " + shell_word(set);
  std::cerr << "  " << command << " explains them\n";
}

/// Columns without a unit in the model get the one that was inferred.
void add_units(RunResult& result, const UnitReport& units, const std::vector<std::size_t>& outputs) {
  for (std::size_t column = 0; column < outputs.size(); ++column)
    if (result.trace.units[column].empty()) result.trace.units[column] = units.outputs[outputs[column]].text;
  result.report.energy_unit = units.energy;
}

/// Stores that have no state of their own, and why: they show as loops in the report.
void note_dependent_stores(RunResult& result, const Study& study, const Program& program, const std::string& file) {
  constexpr std::size_t kListed = 3;
  std::string text;
  for (std::size_t i = 0; i < program.dependent.size() && i < kListed; ++i) {
    const auto& ports = study.causality().dependent;
    const auto port = std::find_if(ports.begin(), ports.end(), [&](const DependentPort& p) {
      const Element& store = study.model().elements[p.element.index()];
      return port_name(store, p.port) ==
             port_name(program.model->elements[program.dependent[i].element.index()], program.dependent[i].port);
    });
    std::string because;
    for (std::size_t k = 0; port != ports.end() && k < port->because.size(); ++k)
      because +=
          (k == 0 ? " is determined by \"" : ", \"") + study.model().elements[port->because[k].index()].name + '"';
    text += (text.empty() ? "" : "; ") + program.dependent_names[i] + because;
  }
  if (text.empty()) return;
  if (program.dependent.size() > kListed)
    text += "; and " + std::to_string(program.dependent.size() - kListed) + " more";
  result.report.notes.insert(
      result.report.notes.begin(),
      "dependent stores (derivative causality), without states of their own: " + text + "; see bgsim check " + file);
}

/// Where the results of a scene go; "" for what is not asked for.
struct ResultFiles {
  std::string trace, report, events, units;

  ResultFiles(const Model& model, const std::string& scene, const RunOptions& options)
      : report(options.report_json), events(options.events) {
    const std::string name = run_name(model, options.file, scene);
    trace = options.output.empty() ? name + ".csv" : options.output;
    if (!options.units) return;
    // Beside the trace, where bgsim plot looks for it.
    const std::filesystem::path beside = trace == "-" ? name + ".csv" : trace;
    units = std::filesystem::path(beside).replace_extension(".units.json").string();
  }
  void add_to(std::vector<NamedFile>& files, const std::string& scene) const {
    files.push_back({trace, "the trace of scene " + scene});
    if (!report.empty()) files.push_back({report, "the report"});
    if (!events.empty()) files.push_back({events, "the events"});
    if (!units.empty()) files.push_back({units, "the units of scene " + scene});
  }
};

/// The results of a scene on their way to disk: the trace row by row while it runs, the others at its end.
class Results {
 public:
  explicit Results(const ResultFiles& files) : trace_(files.trace) {
    if (!files.events.empty()) events_.emplace(files.events);
    if (!files.report.empty()) report_.emplace(files.report);
    if (!files.units.empty()) units_.emplace(files.units);
  }
  TraceFile& trace() { return trace_; }
  TraceFile* events() { return events_ ? &*events_ : nullptr; }
  void finish(const RunResult& result) {
    trace_.finish();
    if (events_) events_->finish();
    if (report_) report_->stream() << report_json(result);
    if (units_) units_->stream() << trace_units_json(result.trace);
    commit_all({report_ ? &*report_ : nullptr, units_ ? &*units_ : nullptr});
  }

 private:
  TraceFile trace_;
  std::optional<TraceFile> events_;
  std::optional<OutputFile> report_, units_;
};

std::string counted(std::uint64_t count, const char* what) {
  return std::to_string(count) + ' ' + what + (count == 1 ? "" : "s");
}

void tell(const RunResult& result, const std::string& output) {
  std::cerr << report_text(result);
  std::cerr << (result.stop == StopReason::completed ? "trace: " : "trace up to there: ")
            << (output == "-" ? "standard output" : short_path(output)) << " (" << counted(result.rows, "time") << ", "
            << counted(result.trace.names.size(), "column") << ")\n";
}

/// Refuses what would be overwritten, before any scene runs.
void check_results(const Model& model, const std::vector<std::string>& scenes, const RunOptions& options) {
  std::vector<NamedFile> outputs;
  for (const std::string& scene : scenes) ResultFiles(model, scene, options).add_to(outputs, scene);
  // A snapshot may replace the one that the run continues.
  if (!options.resume.empty()) check_outputs(outputs, {{options.resume, "the snapshot to be continued"}});
  if (!options.snapshot.empty()) outputs.push_back({options.snapshot, "the snapshot"});
  check_outputs(outputs, files_of(model));
}

/// Runs the scene, its rows going to the trace's file, and its events to theirs.
/// @throws UsageError if they cannot be written; the run has ended then.
RunResult simulate_into(TraceFile& trace, TraceFile* events, const Simulation& compiled, const RunInputs& inputs,
                        const RunOptions& options, const std::string& resume) {
  const Model& model = compiled.model();
  RunWatch watch(inputs.start, inputs.stop, options.quiet);
  trace.begin(compiled.program().output_names);
  if (events != nullptr) events->begin_events();
  SimulateOptions how;
  how.energy_audit = !options.no_audit;
  how.error_estimate = !options.no_error_estimate;
  options.limits.apply(how);
  how.progress = [&trace, events, ask = watch.progress()](double t) {
    trace.look();
    if (events != nullptr) events->look();
    return !trace.failed() && !(events != nullptr && events->failed()) && ask(t);
  };
  how.rows = [&trace](double t, std::span<const double> values) { trace.take(t, values); };
  if (events != nullptr) how.events = [events](const RunEvent& event) { events->take(event); };
  how.resume = resume;
  how.snapshot_steps = options.snapshot_steps;
  bool stored = false;
  if (!options.snapshot.empty())
    how.snapshot = [&](double /*t*/, const std::string& snapshot) {
      OutputFile file(options.snapshot);
      file.stream() << snapshot;
      file.commit();
      stored = true;
    };
  how.remark = [&](const Diagnostic& remark) {
    watch.clear();
    std::cerr << render(remark, *model.sources);
  };
  try {
    RunResult result = compiled.simulate(inputs, how);
    if (!options.snapshot.empty() && !stored) {
      watch.clear();
      std::cerr << "bgsim: no snapshot was written: "
                << (compiled.program().state_names.empty() ? "the run has no states" : "the run failed") << '\n';
    }
    return result;
  } catch (const UsageError&) {
    throw;
  } catch (const ModelError&) {
    throw;  // before the first step
  } catch (...) {
    const std::string partial = trace.keep_partial();
    if (!partial.empty()) std::cerr << "bgsim: the trace up to there is in \"" << partial << "\"\n";
    if (events != nullptr) events->keep_partial();
    throw;
  }
}

/// @param search  null without --accuracy.
Exit run_scene(const Study& study, const RunOptions& options, const std::string& scene, AccuracySearch search) {
  const Model& model = study.model();
  RunInputs inputs = prepare(model, scene, options.overrides);
  print_warnings(inputs.warnings, model);
  const ResultFiles files(model, inputs.scene, options);
  check_results(model, {inputs.scene}, options);
  InputText resume;
  if (!options.resume.empty()) resume = read_input(options.resume, NamedBy::user);
  if (!resume.fault.empty())
    throw UsageError("cannot read the snapshot \"" + short_path(options.resume) + "\": " + resume.fault);
  if (!options.resume.empty() && resume.text.empty())
    throw UsageError("the snapshot \"" + short_path(options.resume) + "\" is empty");
  Results results(files);

  StageSeconds seconds = study.seconds();
  const std::optional<Model> as_set = options.overrides.set.empty()
                                          ? std::nullopt
                                          : std::optional(with_overrides(model, inputs.scene, options.overrides));
  const UnitReport units =
      timed(seconds, "units", [&] { return infer_units(as_set ? *as_set : model, study.graph(), inputs.scene); });
  warn_of_units(model, units, options);
  // The table of events is a result of the run as much as its outputs are.
  const bool keep_all = options.keep_all || !options.events.empty();
  const Simulation compiled = study.scene(inputs, {.energy_audit = !options.no_audit, .keep_all = keep_all});
  seconds.insert(seconds.end(), compiled.seconds().begin(), compiled.seconds().end());
  if (search != nullptr) {
    std::optional<RunInputs> found = search(compiled, *options.accuracy, options.limits, options.quiet);
    if (!found) return Exit::numerics_failed;
    inputs = std::move(*found);
  }
  const InterruptionsNoted until_all_is_written;
  RunResult result = simulate_into(results.trace(), results.events(), compiled, inputs, options, resume.text);
  result.report.stage_seconds.insert(result.report.stage_seconds.begin(), seconds.begin(), seconds.end());

  add_units(result, units, inputs.outputs);
  note_dependent_stores(result, study, compiled.program(), options.file);
  results.finish(result);
  if (result.failure) std::cerr << render(*result.failure, *model.sources);
  if (!options.quiet) tell(result, files.trace);
  return result.stop == StopReason::completed ? Exit::done : Exit::numerics_failed;
}

}  // namespace

Exit run_command(const Arguments& arguments) {
  const RunOptions options = parse_run(arguments);
  const AccuracySearch search = options.accuracy ? accuracy_search(arguments) : nullptr;
  const Study study = study_of(options.file, options.reading);
  if (!options.all_scenes) return run_scene(study, options, options.scene, search);
  std::vector<std::string> scenes;
  for (const Scene& scene : study.model().scenes) scenes.push_back(scene.name);
  check_results(study.model(), scenes, options);
  Exit outcome = Exit::done;
  for (const std::string& scene : scenes) {
    outcome = worse(outcome, run_scene(study, options, scene, search));
    if (was_interrupted()) break;
  }
  return outcome;
}

}  // namespace bgsim::cli
