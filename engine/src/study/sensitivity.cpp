#include "bgsim/sensitivity.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"
#include "linear/variations.hpp"

namespace bgsim {
namespace {

GivenValues given_of(const Model& model, const std::string& scene, const SceneOverrides& overrides) {
  for (const Scene& each : model.scenes)
    if (each.name == scene) return given_values(model, each, overrides);
  throw std::logic_error("a scene was prepared that the model does not have");
}

[[noreturn]] void refuse(const Model& model, std::string situation, std::string rule, std::string help,
                         std::optional<Place> place = {}) {
  throw ModelError({diagnostic_of("BG414", std::move(situation), place, std::move(rule), std::move(help))},
                   model.sources);
}

void refuse_jumps(const Model& model) {
  if (!model.events.empty())
    refuse(model,
           "the model has events that set stores (" + in_quotes(model.events.front().name) +
               "), whose jumps are not derived",
           "sensitivities cross the events of conditions in laws and signals, not jumps of the states",
           "take the difference of two runs, by bgsim sweep", model.events.front().place);
  for (const Signal& signal : model.signals)
    if (signal.delay)
      refuse(model, "the model has delayed signals (" + in_quotes(signal.name) + "), which are not derived",
             "what a delayed signal was depends on parameters as well",
             "take the difference of two runs, by bgsim sweep", signal.place);
  const std::vector<ElementId> switches = switches_of(model);
  if (switches.empty()) return;
  const Element& first = model.elements[switches.front().index()];
  refuse(model, "the model has ideal switches or diodes (" + in_quotes(first.name) + "), whose jumps are not derived",
         "sensitivities cross the events of conditions in laws and signals, not changes of the equations themselves",
         "write the switch as a resistor with if(..., r_closed, r_open), the diode as f = if(e > 0, e/ron, e/roff)",
         first.place);
}

}  // namespace

struct SensitivityScene::Inside {
  std::shared_ptr<const Model> model;
  SceneOverrides overrides;
  RunInputs inputs;
  Seed seed;
  double value = 0.0;
  std::string unit;
  VariedSystem varied;
  Program program;

  [[nodiscard]] RunResult run(const RunInputs& own, const SceneOverrides& values, const SimulateOptions& how) const {
    GivenValues given = given_of(*model, own.scene, values);
    return simulate(program, varied_inputs(*model, varied, given, seed, own), how);
  }
};

SensitivityScene::SensitivityScene(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                                   const std::string& to, const SensitivityParts& parts) {
  const auto made = std::make_shared<Inside>();
  const Model& model = study.model();
  made->model = study.shared_model();
  made->overrides = overrides;
  made->seed = find_seed(model, to);
  made->inputs = study.scene(scene, overrides).inputs();  // with all that is looked at before a run
  refuse_jumps(model);
  GivenValues given = given_of(model, made->inputs.scene, overrides);
  made->value = value_of(model, given, made->seed, made->inputs);
  if (made->seed.parameter.valid()) made->unit = model.parameters[made->seed.parameter.index()].unit;
  const auto cut = slice(model, study.graph(), study.equations(), study.order(), made->inputs.outputs, false);
  const EquationSystem& system = cut ? cut->system : study.equations();
  const BlockOrder& order = cut ? cut->order : study.order();
  try {
    made->varied =
        with_variations(model, system, order, given, made->seed, made->inputs.outputs, {parts.squares, parts.slopes});
    CompileOptions options;
    options.outputs = made->varied.outputs;
    options.energies = false;
    options.variations = &made->varied.variations;
    made->program = compile(made->varied.model, made->varied.system, made->varied.order, options);
  } catch (const std::invalid_argument& error) {
    refuse(model, std::string("the equations cannot be derived as often as sensitivities ask for: ") + error.what(),
           "implicit integration takes second derivatives of the laws",
           "fit a formula to the data, or use spline data where the store is in integral causality");
  }
  inside_ = made;
}

const RunInputs& SensitivityScene::inputs() const { return inside_->inputs; }
const std::string& SensitivityScene::parameter() const { return inside_->seed.name; }
double SensitivityScene::value() const { return inside_->value; }
const std::string& SensitivityScene::unit() const { return inside_->unit; }

RunResult SensitivityScene::run(const SimulateOptions& how) const {
  return inside_->run(inside_->inputs, inside_->overrides, how);
}

RunResult SensitivityScene::run(const SceneOverrides& overrides, const OutputTimes& times,
                                const SimulateOptions& how) const {
  RunInputs inputs = prepare_scene(*inside_->model, inside_->inputs.scene, overrides);
  inputs.output_times = times;
  return inside_->run(inputs, overrides, how);
}

namespace {

void throw_failure(const RunResult& result, const Model& model) {
  if (result.stop == StopReason::completed) return;
  throw ModelError({*result.failure}, model.sources);
}

/// When each output has its largest magnitude.
struct Peak {
  double time = 0.0, value = 0.0, range = 0.0;
  std::optional<double> opposite;  ///< when it is as large to the other side, as far as the run tells
};

std::vector<Peak> peaks_of(const RunResult& run, std::size_t count, double relative, const Model& model) {
  if (run.report.measures.empty())
    refuse(model, "an output has no value within the run: " + run.report.why_not_measured, {}, "leave it out (--of)");
  std::vector<Peak> peaks;
  for (std::size_t i = 0; i < count; ++i) {
    const OutputMeasure& m = run.report.measures[i];
    const bool most = std::abs(m.most) >= std::abs(m.least);
    Peak peak{most ? m.most_at : m.least_at, most ? m.most : m.least, m.most - m.least, {}};
    // At ten times the tolerance, by which the errors of the derivatives are judged, either of the two may be larger.
    if (m.least < 0.0 && m.most > 0.0 && std::abs(m.most + m.least) <= 10.0 * relative * peak.range)
      peak.opposite = most ? m.least_at : m.most_at;
    peaks.push_back(peak);
  }
  return peaks;
}

double relative_of(double derivative, double parameter, double value) {
  return value == 0.0 ? std::numeric_limits<double>::quiet_NaN() : derivative * parameter / value;
}

/// One parameter of a table.
struct Derived {
  std::vector<double> values, times, derivatives;  ///< by output
  std::vector<double> errors;                      ///< of the derivatives; empty: not asked for
  RunResult run;
  double value = 0.0;
  std::string unit;
};

Derived derive(const SensitivityScene& varied, const Model& model, const SceneOverrides& overrides,
               SensitivityNorm norm, SimulateOptions how) {
  const bool peak = norm == SensitivityNorm::peak;
  how.measures = true;
  // Estimates of errors by the slopes of the equations say little of quantities that are these slopes.
  how.error_estimate = false;
  Derived made;
  made.run = varied.run(overrides, varied.inputs().output_times, how);
  made.value = varied.value();
  made.unit = varied.unit();
  throw_failure(made.run, model);
  const RunInputs& inputs = varied.inputs();
  const std::size_t n = inputs.outputs.size();
  const std::vector<OutputMeasure>& measures = made.run.report.measures;
  const std::vector<Peak> peaks = peaks_of(made.run, n, inputs.relative, model);
  if (!peak) {
    for (std::size_t i = 0; i < n; ++i) {
      made.times.push_back(inputs.stop);
      if (norm == SensitivityNorm::final) {
        made.values.push_back(measures[i].final);
        made.derivatives.push_back(measures[n + i].final);
        continue;
      }
      const double span = inputs.stop - inputs.start;
      const double rms = std::sqrt(measures[2 * n + i].final / span);
      if (!(rms > 0.0))
        refuse(model, "the root of the mean square of " + in_quotes(model.outputs[inputs.outputs[i]].name) + " is 0",
               "a root has no derivative where it is 0", "ask for --norm final, or leave the output out (--of)");
      made.values.push_back(rms);
      made.derivatives.push_back(measures[3 * n + i].final / (2.0 * span * rms));
    }
    return made;
  }
  std::vector<double> times;
  for (const Peak& each : peaks) {
    times.push_back(each.time);
    if (each.opposite) times.push_back(*each.opposite);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  SimulateOptions again = how;
  again.rows = {};
  again.measures = false;
  const RunResult at = varied.run(overrides, times, again);
  throw_failure(at, model);
  const auto row_at = [&](double t) {
    return static_cast<std::size_t>(std::lower_bound(times.begin(), times.end(), t) - times.begin());
  };
  constexpr double kFlat = 1e-3;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t row = row_at(peaks[i].time);
    const double slope = at.trace.columns[2 * n + i][row];
    const bool inside = peaks[i].time > inputs.start && peaks[i].time < inputs.stop;
    if (inside && !(std::abs(slope) * (inputs.stop - inputs.start) <= kFlat * peaks[i].range))
      refuse(model,
             "the peak of " + in_quotes(model.outputs[inputs.outputs[i]].name) + " at t = " +
                 number_text(peaks[i].time, 6) + " is a corner: its slope there is " + number_text(slope, 3),
             "a peak changes with a parameter as the output does where it is flat",
             "ask for --norm final, with --stop at the corner");
    if (peaks[i].opposite) {
      // The magnitudes change by d and -d: apart from each other by their sum.
      const std::vector<double>& derivative = at.trace.columns[n + i];
      const OutputMeasure& all = measures[n + i];
      const double apart = std::abs(derivative[row] + derivative[row_at(*peaks[i].opposite)]);
      if (apart > kFlat * std::max(std::abs(all.most), std::abs(all.least)))
        refuse(model,
               in_quotes(model.outputs[inputs.outputs[i]].name) + " is as large to both sides, at t = " +
                   number_text(peaks[i].time, 6) + " and t = " + number_text(*peaks[i].opposite, 6) +
                   ", and the two change differently with " + in_quotes(varied.parameter()),
               "which of two peaks is the larger depends on whether a parameter grows or falls",
               "ask for other parameters (--to), or take the differences of max(...) and min(...) by bgsim sweep");
    }
    made.times.push_back(peaks[i].time);
    made.values.push_back(peaks[i].value);
    made.derivatives.push_back(at.trace.columns[n + i][row]);
  }
  return made;
}

}  // namespace

namespace {

/// The same, and how far it is off at ten times the tolerance.
Derived derive_and_compare(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                           const std::string& to, SensitivityNorm norm, const SimulateOptions& how, bool errors) {
  const SensitivityScene varied(study, scene, overrides, to,
                                {norm == SensitivityNorm::rms, norm == SensitivityNorm::peak});
  Derived made = derive(varied, study.model(), overrides, norm, how);
  if (!errors) return made;
  SceneOverrides looser = overrides;
  looser.relative = std::min(10.0 * varied.inputs().relative, 0.1);
  if (varied.inputs().absolute) looser.absolute = 10.0 * *varied.inputs().absolute;
  if (varied.inputs().step > 0.0) {
    looser.method = varied.inputs().method;
    looser.step = 2.0 * varied.inputs().step;
  }
  made.errors.assign(made.values.size(), std::numeric_limits<double>::quiet_NaN());
  try {
    const Derived other = derive(varied, study.model(), looser, norm, how);
    for (std::size_t i = 0; i < made.errors.size(); ++i)
      made.errors[i] = std::abs(other.derivatives[i] - made.derivatives[i]);
  } catch (const ModelError& error) {
    if (error.diagnostics.front().code == "BG606") throw;
  }
  return made;
}

}  // namespace

SensitivityTable sensitivities(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                               const std::vector<std::string>& to, SensitivityNorm norm, const SimulateOptions& how,
                               unsigned threads, bool errors) {
  const Model& model = study.model();
  for (const std::string& name : to) find_seed(model, name);
  std::vector<Derived> derived(to.size());
  std::vector<std::exception_ptr> faults(to.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < to.size(); i = next++) try {
        derived[i] = derive_and_compare(study, scene, overrides, to[i], norm, how, errors);
      } catch (...) {
        faults[i] = std::current_exception();
      }
  };
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < std::min<std::size_t>(threads, to.size()); ++i) others.emplace_back(work);
  work();
  for (std::thread& thread : others) thread.join();
  for (const std::exception_ptr& fault : faults)
    if (fault) std::rethrow_exception(fault);

  SensitivityTable table;
  const RunInputs inputs = prepare_scene(model, scene, overrides);
  const std::size_t n = inputs.outputs.size();
  table.scene = inputs.scene;
  for (const std::size_t i : inputs.outputs) {
    table.outputs.push_back(model.outputs[i].name);
    table.output_units.push_back(model.outputs[i].unit);
  }
  table.of.resize(n);
  for (std::size_t p = 0; p < to.size(); ++p) {
    Derived& each = derived[p];
    table.parameters.push_back(to[p]);
    table.parameter_units.push_back(each.unit);
    table.parameter_values.push_back(each.value);
    const Trace& trace = each.run.trace;
    if (p == 0) {
      table.values = each.values;
      table.times = each.times;
      table.trace.times = trace.times;
      for (std::size_t i = 0; i < n; ++i) {
        table.trace.names.push_back(trace.names[i]);
        table.trace.units.push_back(table.output_units[i]);
        table.trace.columns.push_back(trace.columns[i]);
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      table.of[i].push_back({each.derivatives[i], relative_of(each.derivatives[i], each.value, each.values[i]),
                             errors ? each.errors[i] : std::numeric_limits<double>::quiet_NaN()});
      table.trace.names.push_back(trace.names[n + i]);
      table.trace.units.emplace_back();
      table.trace.columns.push_back(trace.columns[n + i]);
    }
    for (const std::string& note : each.run.report.notes)
      if (std::find(table.notes.begin(), table.notes.end(), note) == table.notes.end()) table.notes.push_back(note);
  }
  return table;
}

}  // namespace bgsim
