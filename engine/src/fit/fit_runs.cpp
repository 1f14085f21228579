#include "fit/fit_runs.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "base/codes.hpp"
#include "base/in_threads.hpp"
#include "base/text.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"
#include "linear/variations.hpp"

namespace bgsim {
namespace {

std::string set_text(const std::string& name, double value) { return name + "=" + shortest_number(value); }

const Scene& scene_named(const Model& model, const std::string& name) {
  return *std::find_if(model.scenes.begin(), model.scenes.end(), [&](const Scene& s) { return s.name == name; });
}

/// "t = 0 to 0.3"
std::string interval_text(double from, double to) { return "t = " + number_text(from) + " to " + number_text(to); }

}  // namespace

FitRuns::FitRuns(const Study& study, const FitPlan& plan, const SceneOverrides& overrides, const SimulateOptions& how,
                 unsigned threads)
    : study_(study), plan_(plan), overrides_(overrides), how_(how), threads_(std::max(threads, 1U)) {
  how_.energy_audit = how_.error_estimate = how_.measures = false;
  how_.rows = {};
  how_.remark = {};
  check_variations(overrides);
  take_data(overrides);
  compile_scenes();
}

void FitRuns::refuse(const char* code, std::string situation, std::string rule, std::string help,
                     std::optional<Place> place) const {
  throw ModelError({diagnostic_of(code, std::move(situation), place, std::move(rule), std::move(help))},
                   study_.model().sources);
}

void FitRuns::note(const std::string& text) {
  if (std::find(notes.begin(), notes.end(), text) == notes.end()) notes.push_back(text);
}

void FitRuns::check_variations(const SceneOverrides& overrides) {
  const Model& model = study_.model();
  if (plan_.vary.empty())
    refuse("BG415", "nothing is varied", "a fit looks for values of parameters", "write --vary k=300:400,m");
  std::map<StateKey, std::string> states;
  std::set<std::string> names;
  for (const FitVariation& variation : plan_.vary) {
    const Seed seed = find_seed(model, variation.name);
    if (!names.insert(variation.name).second)
      refuse("BG415", in_quotes(variation.name) + " is varied twice", {}, "keep one of the two ranges");
    if (seed.parameter.valid()) continue;
    const auto [first, is_new] = states.emplace(seed.state, variation.name);
    if (!is_new)
      refuse("BG415",
             in_quotes(first->second) + " and " + in_quotes(variation.name) + " are initial values of one store",
             "what a store begins with is one value", "vary one of them");
  }
  // What is varied begins with what --set says, and is then no matter of --set.
  std::erase_if(overrides_.set, [&](const std::string& text) {
    const auto equals = text.find('=');
    return equals != std::string::npos &&
           names.contains(std::string(trimmed(std::string_view(text).substr(0, equals))));
  });
  std::set<std::string> scenes;
  for (const FitData& data : plan_.data) {
    const RunInputs inputs = prepare_scene(model, data.scene, overrides);
    if (!scenes.insert(inputs.scene).second) continue;
    GivenValues given = given_values(model, scene_named(model, inputs.scene), overrides);
    for (std::size_t i = 0; i < plan_.vary.size(); ++i) {
      const FitVariation& variation = plan_.vary[i];
      const Seed seed = find_seed(model, variation.name);
      if (seed.parameter.valid()) {
        const GivenValue& value = given.parameters[seed.parameter.index()];
        if (!given.pool.is_constant(value.value))
          refuse("BG415", in_quotes(variation.name) + " is computed from other parameters",
                 "a fit varies numbers, and what is computed from them follows",
                 "vary the parameters in its expression, or make it a number: --set " + variation.name + "=VALUE",
                 value.place);
      }
      const double start = value_of(model, given, seed, inputs);
      if (scenes.size() > 1) {
        if (start != start_[i])
          note(in_quotes(variation.name) + " is " + number_text(start) + " in the scene " + in_quotes(inputs.scene) +
               "; the fit has one value for all scenes, and begins with " + number_text(start_[i]));
        continue;
      }
      const std::string from = "the fit begins with " + variation.name + " = " + number_text(start);
      if (!std::isfinite(start))
        refuse("BG416", in_quotes(variation.name) + " has no value to begin with", {},
               "give one: --set " + variation.name + "=VALUE");
      if (start < variation.lower || start > variation.upper)
        refuse("BG416",
               from + ", which is outside of its range " + number_text(variation.lower) + ":" +
                   number_text(variation.upper),
               "the search begins with the value of the scene, or of --set, and stays in the range",
               "widen the range, or begin within it: --set " + variation.name + "=VALUE");
      const bool bounded = std::isfinite(variation.lower) && std::isfinite(variation.upper);
      if ((plan_.global_runs > 0 || plan_.starts > 0) && !bounded)
        refuse("BG416", in_quotes(variation.name) + " has no range to be searched",
               "a global search, and further starts, try points all over the ranges",
               "write --vary " + variation.name + "=LOWER:UPPER");
      start_.push_back(start);
      units_.push_back(seed.parameter.valid() ? model.parameters[seed.parameter.index()].unit : std::string());
      const double range = bounded ? variation.upper - variation.lower : 1.0;
      scales_.push_back(start != 0.0 ? std::abs(start) : range);
    }
  }
}

void FitRuns::take_data(const SceneOverrides& overrides) {
  const Model& model = study_.model();
  if (plan_.matches.empty())
    refuse("BG418", "no output is matched with a column of the data", "a fit makes outputs follow columns",
           "write --match x=COLUMN, where x is an output");
  if (plan_.data.empty()) refuse("BG417", "there are no data", {}, "name a CSV file");
  for (std::size_t m = 0; m < plan_.matches.size(); ++m) {
    const FitMatch& match = plan_.matches[m];
    if (match.has_sigma() != plan_.matches.front().has_sigma())
      refuse("BG418",
             "some matches have a standard deviation, and " +
                 in_quotes(match.has_sigma() ? plan_.matches.front().output : match.output) + " has none",
             "residuals of several outputs are added in parts of their standard deviations",
             "give --sigma for all matches, or for none");
    for (std::size_t other = 0; other < m; ++other)
      if (plan_.matches[other].output == match.output && plan_.matches[other].column == match.column)
        refuse("BG418", in_quotes(match.output) + " is matched with " + in_quotes(match.column) + " twice", {},
               "keep one of the two");
  }
  known_sigma_ = plan_.matches.front().has_sigma();
  if (plan_.loss != FitLoss::squares && !known_sigma_)
    refuse("BG418", "the loss has no scale", "a loss says beyond how many standard deviations a residual is an outlier",
           "give --sigma NAME=VALUE for each match");
  for (const FitData& data : plan_.data) {
    FitScene scene;
    const RunInputs inputs = prepare_scene(model, data.scene, overrides);
    scene.name = inputs.scene;
    take_rows(data, scene, inputs);
    residuals_ += scene.cells.size();
    scenes_.push_back(std::move(scene));
  }
  for (const FitMatch& match : plan_.matches) {
    const bool found = std::any_of(pairs_.begin(), pairs_.end(),
                                   [&](const FitPair& pair) { return &plan_.matches[pair.match] == &match; });
    if (found) continue;
    std::vector<std::string> names;
    for (const FitData& data : plan_.data)
      names.insert(names.end(), data.cells.table.names.begin(), data.cells.table.names.end());
    const std::string near = nearest_name(match.column, names);
    refuse("BG418",
           short_path(plan_.data.front().name) + (plan_.data.size() > 1 ? " and the other data have" : " has") +
               " no column " + in_quotes(match.column),
           "--match OUTPUT=COLUMN names a column of the data",
           near.empty() ? "its columns: " + list_of(names, " and ") : "did you mean " + in_quotes(near) + "?");
  }
  if (residuals_ < plan_.vary.size())
    refuse("BG417",
           "the data have " + std::to_string(residuals_) + " values to compare with, for " +
               std::to_string(plan_.vary.size()) + " that are varied",
           "a fit needs at least as many measurements as there are values to be found",
           "vary fewer, or give more data");
  // Without standard deviations several matches are compared in parts of what each varies by.
  if (!known_sigma_ && plan_.matches.size() > 1)
    for (std::size_t m = 0; m < plan_.matches.size(); ++m) {
      double count = 0.0, mean = 0.0, square = 0.0;
      const auto each = [&](const auto& take) {
        for (FitScene& scene : scenes_)
          for (FitCell& cell : scene.cells)
            if (pairs_[cell.match].match == m) take(cell);
      };
      each([&](const FitCell& cell) { mean += cell.value, count += 1.0; });
      mean /= std::max(count, 1.0);
      each([&](const FitCell& cell) { square += (cell.value - mean) * (cell.value - mean); });
      double deviation = std::sqrt(square / std::max(count, 1.0));
      if (deviation == 0.0) {
        deviation = mean == 0.0 ? 1.0 : std::abs(mean);
        note("the data of " + in_quotes(plan_.matches[m].output) + " are constant, and have no spread to compare in: " +
             (mean == 0.0 ? "their errors are taken as they are" : "their errors are taken in parts of their value") +
             "; --sigma says what an error counts");
      }
      each([&](FitCell& cell) { cell.weight = 1.0 / deviation; });
    }
}

void FitRuns::take_rows(const FitData& data, FitScene& scene, const RunInputs& inputs) {
  const Model& model = study_.model();
  const CsvTable& table = data.cells.table;
  const std::string file = short_path(data.name);
  const auto column_of = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(table.names.begin(), table.names.end(), name) - table.names.begin());
  };
  const auto check_column = [&](std::size_t column) {
    if (const auto& fault = data.cells.faults[column])
      refuse("BG417", file + ":" + std::to_string(fault->line) + ": " + fault->what(),
             "a cell is a number, or empty where none was measured", "correct it, or leave the cell empty");
  };
  std::size_t time = column_of(plan_.time.empty() ? "t" : plan_.time);
  if (time == table.names.size()) {
    if (!plan_.time.empty()) {
      const std::string near = nearest_name(plan_.time, table.names);
      refuse("BG418", file + " has no column " + in_quotes(plan_.time), "--time names the column of the times",
             near.empty() ? "its columns: " + list_of(table.names, " and ") : "did you mean " + in_quotes(near) + "?");
    }
    time = 0;
  }
  check_column(time);
  std::vector<std::size_t> columns, sigmas;  // table.names.size(): one number for all rows
  for (std::size_t m = 0; m < plan_.matches.size(); ++m) {
    const FitMatch& match = plan_.matches[m];
    std::vector<std::string> outputs;
    for (const std::size_t each : inputs.outputs) outputs.push_back(model.outputs[each].name);
    const auto output = std::find(outputs.begin(), outputs.end(), match.output);
    const std::size_t column = column_of(match.column);
    if (column == table.names.size()) continue;
    if (output == outputs.end()) {
      const std::string near = nearest_name(match.output, outputs);
      refuse("BG418", "the scene " + in_quotes(scene.name) + " has no output " + in_quotes(match.output),
             "--match OUTPUT=COLUMN names an output of the scene",
             near.empty() ? "its outputs: " + list_of(outputs, " and ") : "did you mean " + in_quotes(near) + "?");
    }
    check_column(column);
    columns.push_back(column);
    sigmas.push_back(match.sigma_column.empty() ? table.names.size() : column_of(match.sigma_column));
    if (!match.sigma_column.empty() && sigmas.back() == table.names.size()) {
      const std::string near = nearest_name(match.sigma_column, table.names);
      refuse("BG418", file + " has no column " + in_quotes(match.sigma_column),
             "--sigma OUTPUT=COLUMN names a column of the data, or is a number",
             near.empty() ? "its columns: " + list_of(table.names, " and ") : "did you mean " + in_quotes(near) + "?");
    }
    if (sigmas.back() < table.names.size()) check_column(sigmas.back());
    scene.pairs.push_back(pairs_.size());
    pairs_.push_back({scenes_.size(), m, static_cast<std::size_t>(output - outputs.begin()), 0});
  }
  if (columns.empty() && plan_.data.size() > 1)
    refuse("BG418", file + " has none of the columns that are matched", "--match OUTPUT=COLUMN names a column",
           "its columns: " + list_of(table.names, " and "));

  const std::vector<double>& times = table.columns[time];
  const double span = inputs.stop - inputs.start, rounding = 1e-9 * span;
  std::size_t outside = 0;
  for (std::size_t row = 0; row < times.size(); ++row) {
    const std::string line = file + ":" + std::to_string(data.cells.lines[row]) + ": ";
    if (std::isnan(times[row]))
      refuse("BG417", line + "no time in column " + in_quotes(table.names[time]), "each row is measured at a time",
             "give the time, or remove the row");
    if (row > 0 && !(times[row] > times[row - 1]))
      refuse("BG417", line + "the time " + number_text(times[row]) + " follows " + number_text(times[row - 1]),
             "times increase from row to row",
             plan_.time.empty() ? "sort the rows, keep one of each time; --time NAME says which column the time is"
                                : "sort the rows, keep one of each time");
    if (times[row] < inputs.start - rounding || times[row] > inputs.stop + rounding) {
      ++outside;
      continue;
    }
    const double t = std::clamp(times[row], inputs.start, inputs.stop);
    for (std::size_t each = 0; each < columns.size(); ++each) {
      const double value = table.columns[columns[each]][row];
      FitPair& pair = pairs_[scene.pairs[each]];
      if (std::isnan(value)) {
        ++pair.missing;
        continue;
      }
      if (scene.times.empty() || t > scene.times.back()) scene.times.push_back(t);
      const bool by_row = sigmas[each] < table.names.size();
      const double sigma = by_row ? table.columns[sigmas[each]][row] : plan_.matches[pair.match].sigma;
      if (by_row && !(sigma > 0.0 && std::isfinite(sigma)))
        refuse("BG417",
               line + "the standard deviation in column " + in_quotes(table.names[sigmas[each]]) +
                   (std::isnan(sigma) ? " is missing" : " is " + number_text(sigma)),
               "each value that is compared has a standard deviation above 0",
               "give it, or leave the value of " + in_quotes(table.names[columns[each]]) + " empty");
      scene.cells.push_back({scene.pairs[each], scene.times.size() - 1, value, sigma > 0.0 ? 1.0 / sigma : 1.0});
    }
  }
  if (columns.empty()) return;  // which is refused when all data are read
  if (times.empty()) refuse("BG417", file + " has no rows", {}, "a row for each time follows the columns' names");
  if (outside == times.size())
    refuse("BG417",
           file + " is of " + interval_text(times.front(), times.back()) + ", and the scene " + in_quotes(scene.name) +
               " of " + interval_text(inputs.start, inputs.stop),
           "data are compared at times within the scene, in its unit of time",
           "give the scene these times with --start and --stop, or convert the column " + in_quotes(table.names[time]));
  if (scene.cells.empty())
    refuse("BG417", file + " has no number to compare with in the scene's " + interval_text(inputs.start, inputs.stop),
           {}, "check the columns that --match names");
  if (outside > 0)
    note(file + ": " + std::to_string(outside) + " of " + std::to_string(times.size()) +
         " rows are outside of the scene's " + interval_text(inputs.start, inputs.stop) + " and are not used");
}

SceneOverrides FitRuns::with(const std::vector<double>& values) const {
  SceneOverrides overrides = overrides_;
  for (std::size_t i = 0; i < values.size(); ++i) overrides.set.push_back(set_text(plan_.vary[i].name, values[i]));
  return overrides;
}

namespace {

/// The equations of derivatives hold the times of a scene.
/// @throws ModelError BG414 its start moves with a value
void refuse_moving_start(const Simulation& scene, const std::string& name, double value, double scale) {
  constexpr double kPart = 1e-3;
  for (const double side : {kPart, -kPart}) try {
      if (scene.with(name, value + side * scale).inputs().start != scene.inputs().start)
        throw ModelError({diagnostic_of("BG414", "the start of scene " + in_quotes(short_name(scene.inputs().scene)) +
                                                     " moves with " + in_quotes(short_name(name)))},
                         scene.model().sources);
      return;
    } catch (const ModelError& error) {
      if (error.diagnostics.front().code == "BG414") throw;  // else the other side may have a scene
    }
}

}  // namespace

void FitRuns::compile_scenes() {
  const SceneOverrides overrides = with(start_);
  std::map<std::string, std::size_t> compiled;  // several data may be of one scene
  for (std::size_t s = 0; s < scenes_.size(); ++s) {
    FitScene& scene = scenes_[s];
    const auto [same, is_new] = compiled.emplace(scene.name, s);
    if (!is_new) {
      scene.simulation = scenes_[same->second].simulation;
      scene.varied = scenes_[same->second].varied;
      continue;
    }
    scene.simulation = std::make_shared<const Simulation>(study_.scene(scene.name, overrides, {false, false}));
    scene.varied.resize(plan_.vary.size());
    // Where impacts accumulate or a diode touches its border there is no derivative, at one of the points of a fit.
    if (!switches_of(study_.model()).empty()) {
      note("derivatives by differences of runs: the model has ideal switches, diodes or contacts");
      continue;
    }
    std::vector<std::string> refusals(plan_.vary.size());
    work(plan_.vary.size(), [&](std::size_t i) {
      try {
        refuse_moving_start(*scene.simulation, plan_.vary[i].name, start_[i], scales_[i]);
        scene.varied[i] = std::make_shared<const SensitivityScene>(study_, scene.name, overrides, plan_.vary[i].name);
      } catch (const ModelError& error) {
        if (error.diagnostics.front().code != "BG414") throw;
        refusals[i] = error.diagnostics.front().situation;
      }
    });
    for (const std::string& why : refusals)
      if (!why.empty()) note("derivatives by differences of runs: " + why);
  }
}

void FitRuns::work(std::size_t count, const std::function<void(std::size_t)>& task) const {
  in_threads(count, threads_, task);
}

namespace {

/// A run that was interrupted ends the fit; one that failed is a point without a value.
bool completed(const RunResult& result, const Model& model) {
  if (result.stop == StopReason::interrupted) throw ModelError({*result.failure}, model.sources);
  return result.stop == StopReason::completed;
}

/// Whether a run has come to all rows of the data: its end may depend on what is varied.
bool has_all_rows(const Trace& trace, const FitScene& scene) { return trace.times.size() == scene.times.size(); }

bool is_finite(const Trace& trace, std::size_t columns) {
  for (std::size_t i = 0; i < columns; ++i)
    for (const double value : trace.columns[i])
      if (!std::isfinite(value)) return false;
  return true;
}

}  // namespace

std::optional<Trace> FitRuns::run(const FitScene& scene, const std::vector<double>& values,
                                  std::optional<ModelError>* why) {
  const Model& model = study_.model();
  ++runs_;
  try {
    RunInputs inputs = prepare_scene(model, scene.name, with(values));
    inputs.output_times = scene.times;
    RunResult result = scene.simulation->simulate(inputs, how_);
    const bool whole = has_all_rows(result.trace, scene);
    if (completed(result, model) && whole && is_finite(result.trace, result.trace.columns.size())) return result.trace;
    if (why != nullptr && !whole && !result.failure)
      *why = ModelError(
          {diagnostic_of("BG417",
                         "the scene " + in_quotes(short_name(scene.name)) + " ends at t = " + number_text(inputs.stop) +
                             " with these values, before the last row at t = " + number_text(scene.times.back()),
                         {}, "a run has all times of the data, whatever is varied",
                         "give the scene another end: --stop T")},
          model.sources);
    if (why != nullptr && result.failure) *why = ModelError({*result.failure}, model.sources);
  } catch (const ModelError& error) {
    if (error.diagnostics.front().code == "BG606") throw;
    if (why != nullptr) *why = error;
  }
  return std::nullopt;
}

std::vector<Trace> FitRuns::outputs(const std::vector<double>& values, std::optional<ModelError>* why) {
  if (values == last_values_) return last_;
  std::vector<std::optional<Trace>> found(scenes_.size());
  std::vector<std::optional<ModelError>> faults(scenes_.size());
  work(scenes_.size(), [&](std::size_t s) { found[s] = run(scenes_[s], values, &faults[s]); });
  std::vector<Trace> traces;
  for (std::size_t s = 0; s < scenes_.size(); ++s) {
    if (!found[s]) {
      if (faults[s])
        last_fault_ = faults[s]->diagnostics.front().code + ", " + faults[s]->diagnostics.front().situation;
      if (why != nullptr) *why = std::move(faults[s]);
      return {};
    }
    traces.push_back(std::move(*found[s]));
  }
  last_values_ = values;
  last_ = traces;
  return traces;
}

std::vector<double> FitRuns::residuals_of(const std::vector<Trace>& outputs) const {
  std::vector<double> residuals;
  residuals.reserve(residuals_);
  for (std::size_t s = 0; s < scenes_.size(); ++s)
    for (const FitCell& cell : scenes_[s].cells)
      residuals.push_back((outputs[s].columns[pairs_[cell.match].output][cell.row] - cell.value) * cell.weight);
  return residuals;
}

bool FitRuns::derivatives(const std::vector<double>& values, double* rows, const std::vector<std::size_t>& only) {
  std::vector<std::size_t> first_rows;
  for (std::size_t row = 0; const FitScene& scene : scenes_) {
    first_rows.push_back(row);
    row += scene.cells.size();
  }
  const std::size_t n = only.empty() ? plan_.vary.size() : only.size();
  std::atomic<bool> all = true;
  std::vector<std::string> by_differences(scenes_.size() * n);
  work(scenes_.size() * n, [&](std::size_t task) {
    const FitScene& scene = scenes_[task / n];
    const std::size_t variation = only.empty() ? task % n : only[task % n];
    if (derive(scene, first_rows[task / n], variation, values, rows)) return;
    if (scene.varied[variation])
      by_differences[task] = "at some points the derivatives by " + in_quotes(plan_.vary[variation].name) +
                             " do not exist or are not found; differences of runs stand in their place";
    if (!differ(scene, first_rows[task / n], variation, values, rows)) all = false;
  });
  for (const std::string& each : by_differences)
    if (!each.empty()) note(each);
  return all;
}

bool FitRuns::derive(const FitScene& scene, std::size_t first_row, std::size_t variation,
                     const std::vector<double>& values, double* rows) {
  if (!scene.varied[variation]) return false;
  const Model& model = study_.model();
  try {
    ++runs_;
    const RunResult result = scene.varied[variation]->run(with(values), scene.times, how_);
    const std::size_t outputs = scene.simulation->inputs().outputs.size();
    if (!completed(result, model) || !has_all_rows(result.trace, scene) || !is_finite(result.trace, 2 * outputs))
      return false;
    for (std::size_t i = 0; i < scene.cells.size(); ++i) {
      const FitCell& cell = scene.cells[i];
      rows[(first_row + i) * values.size() + variation] =
          result.trace.columns[outputs + pairs_[cell.match].output][cell.row] * cell.weight;
    }
    return true;
  } catch (const ModelError& error) {
    if (error.diagnostics.front().code == "BG606") throw;
    return false;
  }
}

bool FitRuns::differ(const FitScene& scene, std::size_t first_row, std::size_t variation,
                     const std::vector<double>& values, double* rows) {
  // Errors of the runs over the step, and the step's square, are least together at the third root.
  const double part = std::cbrt(std::max(scene.simulation->inputs().relative, 1e-15));
  const double at = values[variation];
  const double step = part * (at != 0.0 ? std::abs(at) : scales_[variation]);
  const FitVariation& range = plan_.vary[variation];
  const auto shifted = [&](double to) {
    std::vector<double> other = values;
    other[variation] = std::clamp(to, range.lower, range.upper);
    return other;
  };
  const std::vector<double> below = shifted(at - step), above = shifted(at + step);
  std::optional<Trace> low = run(scene, below, nullptr), high = run(scene, above, nullptr);
  double from = below[variation], to = above[variation];
  if (!low || !high) {
    const std::optional<Trace> here = run(scene, values, nullptr);
    if (!here || (!low && !high)) return false;
    if (!low) {
      low = here;
      from = at;
    } else {
      high = here;
      to = at;
    }
  }
  if (!(to > from)) return false;
  for (std::size_t i = 0; i < scene.cells.size(); ++i) {
    const FitCell& cell = scene.cells[i];
    const std::size_t output = pairs_[cell.match].output;
    rows[(first_row + i) * values.size() + variation] =
        (high->columns[output][cell.row] - low->columns[output][cell.row]) / (to - from) * cell.weight;
  }
  return true;
}

}  // namespace bgsim
