// bgsim sweep: a scene with many values, and a table of what comes out.
#include "bgsim/sweep.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <thread>

#include "bands.hpp"
#include "bgsim/csv.hpp"
#include "bgsim/text.hpp"
#include "bgsim/trace_csv.hpp"
#include "command.hpp"
#include "files.hpp"
#include "model_options.hpp"
#include "options.hpp"
#include "output_file.hpp"
#include "programs.hpp"
#include "progress.hpp"
#include "scenes.hpp"
#include "stages.hpp"
#include "sweep_claims.hpp"
#include "sweep_folder.hpp"
#include "sweep_indices.hpp"
#include "sweep_picture.hpp"
#include "table.hpp"

namespace bgsim::cli {

namespace {

using Json = nlohmann::ordered_json;

struct SweepArguments {
  std::string file, scene, folder, sample, shard;
  std::vector<std::string> vary, results, merge;
  ReadOptions reading;
  SceneOverrides overrides;
  RunLimits limits;
  std::uint64_t seed = 1;
  unsigned threads = std::max(1U, std::thread::hardware_concurrency());
  bool traces = false, picture = false, share = false, no_audit = false, no_error_estimate = false, quiet = false;
};

SweepArguments parse_sweep(const Arguments& arguments) {
  SweepArguments options;
  CLI::App app(
      "Runs a scene with many values of parameters, initial values or settings, and writes a table of results.",
      "bgsim sweep");
  app.footer(
      "Writes results.csv, a row for each run, into a folder. Called again with the same arguments, a sweep that was\n"
      "ended goes on where it was (docs/sweep.md).\n"
      "Examples: bgsim sweep models/bellow.json --scene step --vary k=300:400:11 --result peak='max(x)'\n"
      "          bgsim sweep models/bellow.json --scene step --vary k=300:400 --vary 'm=normal(0.015,0.001)'\n"
      "              --sample sobol:1000 --picture");
  auto* const file = app.add_option("model.json", options.file, "the model");
  add_read_options(app, options.reading);
  app.add_option("--scene", options.scene, "scene to run (default: the model's first)")->type_name("NAME");
  const auto list = [&app](const char* name, std::vector<std::string>& target, const char* type, const char* about) {
    app.add_option(name, target, about)->type_name(type)->allow_extra_args(false);
  };
  list(
      "--vary", options.vary, "NAME=VALUES",
      "what differs from run to run: NAME=1,2,5 or 1:5:9 (nine values) or log(1:100:9); with --sample 1:5, log(1:100), "
      "normal(mean,sd), lognormal(median,s), uniform(a,b), triangular(a,mode,b); may be repeated");
  app.add_option("--sample", options.sample,
                 "instead of all combinations: sobol:N, lhs:N (Latin hypercube) or random:N; saltelli:N or morris:N "
                 "for indices of sensitivity: which quantities make the results differ")
      ->type_name("WAY:N");
  app.add_option("--seed", options.seed, "of the sample (default: 1)")->type_name("N");
  list("--result", options.results, "NAME=EXPR",
       "what is kept of each run: numbers, parameters and final(x), initial(x), min(x), max(x), mean(x), rms(x), "
       "integral(x), time_of_min(x), time_of_max(x), first(x > 1), duration(x > 1); may be repeated; by default final, "
       "min, max, mean and rms of each output");
  app.add_option("-j,--jobs", options.threads, "number of threads (default: one for each processor)")
      ->type_name("N")
      ->check(CLI::Range(1U, 4096U));
  app.add_option("-o", options.folder, "folder of the results (default: NAME.SCENE.sweep)")->type_name("DIR");
  app.add_option("--shard", options.shard, "makes only the runs of part I of N, for several machines; see --merge")
      ->type_name("I/N");
  app.add_flag(
         "--share", options.share,
         "works on the sweep together with other processes that are called in the same way on a common folder, as "
         "by mpirun or srun")
      ->excludes("--shard");
  app.add_option("--merge", options.merge, "joins the parts in these folders into results.csv in the first of them")
      ->type_name("DIR")
      ->excludes(file);
  app.add_flag("--traces", options.traces,
               "also writes the trace of each run, trace.RUN.csv, and between which values they lie, "
               "bands.csv; bgsim plot DIR draws these");
  app.add_flag("--picture", options.picture, "also draws the results: results.svg");
  add_set_option(app, options.overrides);
  add_parameters_option(app, options.reading);
  add_time_options(app, options.reading);
  add_solver_options(app, options.overrides);
  add_limit_options(app, options.limits);
  app.add_flag("--no-audit", options.no_audit, "no energy audit of the runs");
  app.add_flag("--no-error-estimate", options.no_error_estimate, "no estimate of the outputs' errors");
  app.add_flag("--quiet", options.quiet, "print warnings and errors only");
  parse_arguments(app, arguments);
  if (options.file.empty() && options.merge.empty()) throw UsageError("which model? bgsim sweep model.json --vary ...");
  return options;
}

std::pair<std::string, std::string> name_and_expression(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw UsageError("--result \"" + short_line(text, 200) + "\": write NAME=EXPR, as in peak=max(x)");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

Shard parse_shard(const std::string& text) {
  if (text.empty()) return {};
  const auto number = [](const std::string& digits) {
    const bool good =
        !digits.empty() && digits.size() < 10 && digits.find_first_not_of("0123456789") == std::string::npos;
    return good ? std::stoull(digits) : 0;
  };
  const auto slash = text.find('/');
  const std::uint64_t part = number(text.substr(0, slash)),
                      of = slash == std::string::npos ? 0 : number(text.substr(slash + 1));
  if (part == 0 || of == 0 || part > of)
    throw UsageError("--shard \"" + short_line(text, 40) + "\": write I/N with I from 1 to N, as in --shard 2/8");
  return {part - 1, of};
}

/// The options that decide what a run gives.
std::vector<std::string> deciding_words(const SweepArguments& options) {
  std::vector<std::string> words = words_of(options.reading);
  const auto add = [&](const char* option, const std::string& value) { words.insert(words.end(), {option, value}); };
  for (const std::string& set : options.overrides.set) add("--set", set);
  const auto number = [](double value) { return number_text(value, 17); };
  if (options.overrides.relative) add("--relative", number(*options.overrides.relative));
  if (options.overrides.absolute) add("--absolute", number(*options.overrides.absolute));
  if (options.overrides.method) add("--method", facts_of(*options.overrides.method).name);
  if (options.overrides.step) add("--step", number(*options.overrides.step));
  if (options.overrides.max_order) add("--max-order", std::to_string(*options.overrides.max_order));
  if (options.limits.max_steps > 0) add("--max-steps", std::to_string(options.limits.max_steps));
  if (options.limits.seconds > 0.0) add("--time-limit", number(options.limits.seconds));
  for (const std::string& result : options.results) add("--result", result);
  if (options.no_audit) words.emplace_back("--no-audit");
  if (options.no_error_estimate) words.emplace_back("--no-error-estimate");
  return words;
}

/// Names that the model does not have, and names that are set besides, are wrong in all runs.
void check_names(const Model& model, const SweepArguments& options, const SweepPoints& points) {
  for (const Variation& variation : points.plan().variations) {
    for (const std::string& set : options.overrides.set)
      if (set.substr(0, set.find('=')) == variation.name)
        throw UsageError("\"" + short_name(variation.name) + "\" is set by --set and varied by --vary");
    const bool setting = std::any_of(std::begin(kSceneSettings), std::end(kSceneSettings),
                                     [&](const char* known) { return variation.name == known; });
    if (setting) continue;
    SceneOverrides alone;
    alone.set = {variation.name + "=" + number_text(variation.numbers.front(), 17)};
    try {
      prepare_scene(model, options.scene, alone);
    } catch (const ModelError& error) {
      const std::string& code = error.diagnostics.front().code;
      if (code == "BG141" || code == "BG147" || code == "BG140") throw UsageError(render(error));
    }
  }
}

/// Least, mean and largest of each result, and in which run.
std::string summary(const std::vector<std::string>& names, const SweepTable& table) {
  TextTable text({"result", "least", "in run", "mean", "largest", "in run"});
  for (const std::string& name : names) {
    const std::vector<double>& values = table.column(name);
    std::size_t least = values.size(), most = values.size(), count = 0;
    double sum = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::isnan(values[i])) continue;
      if (least == values.size() || values[i] < values[least]) least = i;
      if (most == values.size() || values[i] > values[most]) most = i;
      sum += values[i];
      ++count;
    }
    if (count == 0) {
      text.add({name, "", "", "no value in any run", "", ""});
      continue;
    }
    text.add({name, number_text(values[least], 6), std::to_string(table.runs[least]),
              number_text(sum / static_cast<double>(count), 6), number_text(values[most], 6),
              std::to_string(table.runs[most])});
  }
  return text.text();
}

/// indices.csv and its picture, of a sample that is made for them; the table goes to standard output.
/// @return the names of the files, each behind a comma
std::string write_indices(const std::string& folder, const Json& identity, const SweepTable& table, bool picture,
                          bool quiet) {
  if (!SweepIndices::has(identity)) return {};
  const SweepIndices indices(identity, table);
  OutputFile file(folder + "/indices.csv");
  file.stream() << indices.csv();
  file.commit();
  if (picture) {
    OutputFile svg(folder + "/indices.svg");
    svg.stream() << indices.svg();
    svg.commit();
  }
  for (const std::string& note : indices.notes()) std::cerr << "note: " << visible_line(note) << '\n';
  if (!quiet) std::cout << indices.table();
  return std::string(", indices.csv") + (picture ? ", indices.svg" : "");
}

/// bands.csv, if there are traces.
std::string write_bands(const std::string& folder, const std::vector<std::string>& folders, std::size_t completed) {
  try {
    const Bands bands = bands_of(folders);
    if (bands.traces == 0) return {};
    if (bands.traces < completed)
      std::cerr << "note: bands.csv is of " << bands.traces << " traces; the other runs were made without --traces\n";
    OutputFile file(folder + "/bands.csv");
    file.stream() << bands_csv(bands);
    file.commit();
    return ", bands.csv";
  } catch (const UsageError& error) {
    std::cerr << "note: " << error.what() << '\n';
    return {};
  }
}

/// results.csv and the picture, of the records so far. False if runs are missing.
bool write_results(const std::string& folder, const std::vector<std::string>& folders, const Json& identity,
                   bool picture, bool quiet) {
  const std::string header = sweep_header(identity);
  const auto runs = identity["runs"].get<std::uint64_t>();
  const auto records = read_logs(folders, header, runs);
  OutputFile file(folder + "/results.csv");
  file.stream() << header;
  for (const auto& [run, record] : records) file.stream() << record;
  file.commit();
  const SweepTable table = sweep_table(identity, records);
  const auto names = identity["results"].get<std::vector<std::string>>();
  if (picture) {
    OutputFile svg(folder + "/results.svg");
    svg.stream() << sweep_svg(identity, table);
    svg.commit();
  }
  std::string files = picture ? ", results.svg" : "";
  files += write_indices(folder, identity, table, picture, quiet) + write_bands(folder, folders, table.runs.size());
  const bool complete = records.size() == runs;
  if (!quiet) {
    std::cerr << identity["model"].get<std::string>() << ", scene " << identity["scene"].get<std::string>() << ": "
              << records.size() << (complete ? "" : " of " + std::to_string(runs)) << " runs, " << table.failed
              << " failed, " << table.noted << " with notes\n";
    if (names.size() <= 40) std::cerr << summary(names, table);
    for (const auto& [message, count] : table.messages)
      std::cerr << (count > 1 ? std::to_string(count) + " runs: " : "a run: ") << visible_line(message) << '\n';
    std::cerr << "results: " << short_path(folder) << "/results.csv" << files << '\n';
  }
  return complete;
}

Exit merge(const SweepArguments& options) {
  const Json identity = sweep_in(options.merge.front());
  for (const std::string& folder : options.merge)
    if (sweep_in(folder) != identity)
      throw UsageError("\"" + short_path(folder) + "\" and \"" + short_path(options.merge.front()) +
                       "\" hold different sweeps");
  if (options.picture) require_program(kGnuplot, "without --picture it is not needed");
  if (write_results(options.merge.front(), options.merge, identity, options.picture, options.quiet)) return Exit::done;
  std::cerr << "bgsim: the sweep is not complete; results.csv has the runs so far\n";
  return Exit::numerics_failed;
}

void write_trace(const std::string& folder, std::uint64_t run, const Trace& trace) {
  OutputFile file(folder + "/trace." + std::to_string(run) + ".csv");
  write_trace_csv(file.stream(), trace);
  file.commit();
}

Exit run_sweep(SweepArguments options) {
  SweepPlan plan;
  plan.seed = options.seed;
  for (const std::string& text : options.vary) plan.variations.push_back(parse_variation(text));
  if (!options.sample.empty()) parse_sampling(options.sample, plan);
  const SweepPoints points(plan);
  const Shard shard = parse_shard(options.shard);
  if (options.picture) require_program(kGnuplot, "without --picture it is not needed");

  // What results are measured on are further outputs; their expressions need the model's names.
  const Study first = study_of(options.file, options.reading);
  std::vector<std::pair<std::string, std::string>> wanted;
  for (const std::string& text : options.results) wanted.push_back(name_and_expression(text));
  const SweepResults results(first.model(), options.scene, wanted);
  for (const std::string& name : results.names()) {
    const bool varied = std::any_of(plan.variations.begin(), plan.variations.end(),
                                    [&](const Variation& variation) { return variation.name == name; });
    if (varied || name == "run" || name == "status" || name == "notes" || name == "message")
      throw UsageError("--result \"" + name + "\": the table has a column of this name already; give it another name");
  }
  ReadOptions reading = options.reading;
  reading.outputs.insert(reading.outputs.end(), results.further_outputs().begin(), results.further_outputs().end());
  if (!options.traces) reading.record = results.outputs();
  const Study study = read_study(options.file, reading);
  const Model& model = study.model();
  check_names(model, options, points);
  // A step that varies is one for the scene as such, too.
  for (const Variation& variation : plan.variations)
    if (variation.name == "scene.step" && !options.overrides.step) options.overrides.step = variation.numbers.front();
  const RunInputs inputs = prepare(model, options.scene, options.overrides);
  const std::string folder =
      options.folder.empty() ? run_name(model, options.file, inputs.scene) + ".sweep" : options.folder;
  const Json identity = sweep_identity(model, inputs, deciding_words(options), points.plan(), points.size(), results);
  enter_sweep(folder, identity);
  const std::string header = sweep_header(identity);
  SweepLog log(folder, options.share ? std::nullopt : std::optional(shard), header);
  std::vector<bool> done(points.size(), false);
  std::uint64_t count = 0, mine = 0;
  for (const auto& [run, record] : read_logs({folder}, header, points.size())) done[run] = true;
  for (std::uint64_t run = shard.number; run < points.size(); run += shard.of) {
    ++mine;
    if (done[run]) ++count;
  }
  if (count > 0 && !options.quiet) std::cerr << "goes on: " << count << " of " << mine << " runs are done\n";

  const bool all_done = count == mine;
  std::optional<SweepClaims> claims;
  if (options.share) claims.emplace(folder, done);
  const Simulation scene = study.scene(options.scene, options.overrides, {.energy_audit = !options.no_audit});
  RunWatch watch(static_cast<double>(count), static_cast<double>(mine), options.quiet, "run ");
  const Progress show = watch.progress();
  SweepOptions how;
  how.threads = options.threads;
  how.how.energy_audit = !options.no_audit;
  how.how.error_estimate = !options.no_error_estimate;
  options.limits.apply(how.how);
  how.goes_on = [] { return !was_interrupted(); };
  if (claims)
    how.next = [&] { return claims->next(); };
  else
    how.next = [&, run = shard.number]() mutable -> std::optional<std::uint64_t> {
      while (run < points.size() && done[run]) run += shard.of;
      if (run >= points.size()) return std::nullopt;
      return std::exchange(run, run + shard.of);
    };
  how.done = [&](const SweepRun& run, const RunResult& result) {
    if (options.traces && !result.trace.times.empty()) write_trace(folder, run.index, result.trace);
    log.add(sweep_record(run, results.names().size()));
    log.flush();
    if (claims) claims->made(run.index);
    show(static_cast<double>(++count));
  };
  sweep(scene, options.scene, options.overrides, points, results, how);
  // What others were making is looked at until it is made, since one of them may have ended.
  while (claims && !was_interrupted() && !claims->complete()) {
    constexpr std::chrono::milliseconds kWait(100);
    std::this_thread::sleep_for(kWait);
    sweep(scene, options.scene, options.overrides, points, results, how);
  }
  watch.clear();
  if (was_interrupted()) {
    std::cerr << "bgsim: interrupted; " << count << " of " << mine
              << " runs are done. The same command goes on from there\n";
    return Exit::numerics_failed;
  }
  if (shard.of > 1) {
    if (!options.quiet)
      std::cerr << "part " << shard.number + 1 << " of " << shard.of << " is done: " << mine
                << " runs. When all parts are: bgsim sweep --merge " << short_path(folder) << '\n';
    return Exit::done;
  }
  if (claims && !claims->writes_results(all_done)) {
    if (!options.quiet) std::cerr << "all runs are done; another process writes the results\n";
    return Exit::done;
  }
  const bool complete = write_results(folder, {folder}, identity, options.picture, options.quiet);
  if (claims) claims->results_written();
  if (complete) return Exit::done;
  std::cerr << "bgsim: runs are missing, though " << short_path(folder)
            << "/claims says that they are made: a log was removed\n  remove claims, and call the same command again\n";
  return Exit::numerics_failed;
}

}  // namespace

Exit sweep_command(const Arguments& arguments) {
  const SweepArguments options = parse_sweep(arguments);
  try {
    return options.merge.empty() ? run_sweep(options) : merge(options);
  } catch (const SweepError& error) {
    throw UsageError(error.what() + (error.help.empty() ? std::string() : "\n  " + error.help));
  }
}

}  // namespace bgsim::cli
