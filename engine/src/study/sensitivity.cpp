#include "bgsim/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"
#include "linear/variations.hpp"
#include "run/clock.hpp"
#include "run/stored.hpp"
#include "run/variation.hpp"
#include "study/mode_programs.hpp"
#include "study/peak_top.hpp"
#include "study/sensitivity_parts.hpp"

namespace bgsim {
namespace {

[[noreturn]] void refuse_derivatives(const Model& model, const std::string& why) {
  refuse_sensitivity(model, "the equations cannot be derived as often as sensitivities ask for: " + why,
                     "implicit integration takes second derivatives of the laws",
                     "fit a formula to the data, or use spline data where the store is in integral causality");
}

CompileOptions options_of(const VariedSystem& varied) {
  CompileOptions options;
  options.outputs = varied.outputs;
  options.energies = false;
  options.variations = &varied.variations;
  return options;
}

}  // namespace

struct SensitivityScene::Inside {
  std::shared_ptr<const Model> model;
  SceneOverrides overrides;
  RunInputs inputs;
  Seed seed;
  double value = 0.0;
  std::string unit;
  // Without switches: one system.
  VariedSystem varied;
  Program program;
  // With switches: one for each mode, of the model with signals for the derivatives.
  VariationSignals signals;
  std::unique_ptr<ModePrograms> modes;
  std::vector<std::size_t> outputs;      ///< VariedSystem::outputs, in all modes
  std::vector<std::string> state_names;  ///< of all stores and integrals

  [[nodiscard]] RunResult run(const RunInputs& own, const SceneOverrides& values, const SimulateOptions& how) const {
    GivenValues given = given_of(*model, own.scene, values);
    if (!modes) return simulate(program, varied_inputs(*model, varied, given, seed, own), how);
    const SeedSlopes slopes = seed_slopes(*model, given, seed, own);
    const auto start_at = [&](double h) { return modes->start(moved_start(own, slopes, h)); };
    const SwitchedStart start = start_at(0.0);
    SwitchedVariation variation;
    variation.parameters = slopes.parameters;
    variation.size = std::abs(value_of(*model, given, seed, own));
    variation.start = [&](double h) -> std::optional<Stored> {
      SwitchedStart moved = start_at(h);
      // Diodes that carry nothing may be on either side.
      for (std::size_t i = 0; i < start.mode.size(); ++i)
        if (!start.diodes[i] && moved.mode[i] != start.mode[i]) return std::nullopt;
      return std::move(moved.stored);
    };
    const auto program_of = [&](const Mode& mode, const Mode& settling) -> const Program& {
      return modes->at(mode, own.parameters, settling);
    };
    const auto network_of = [&](const Mode& mode) -> const DiodeNetwork& { return modes->network(mode); };
    const auto impact_of = [&](const Mode& mode) -> const ImpactProgram& { return modes->impact(mode); };
    return simulate_switched({program_of, network_of, impact_of, {}, &variation}, start,
                             with_varied_outputs(own, outputs, state_names), how, wall_seconds);
  }

  static RunInputs moved_start(RunInputs inputs, const SeedSlopes& slopes, double h) {
    for (std::size_t i = 0; i < slopes.parameters.size(); ++i) inputs.parameters[i] += h * slopes.parameters[i];
    for (const auto& [key, slope] : slopes.states) {
      const auto same = [&of = key](const RunInputs::Initial& i) {
        return StateKey{i.element, i.port, i.signal} == of;
      };
      auto at = std::find_if(inputs.initial.begin(), inputs.initial.end(), same);
      if (at == inputs.initial.end()) at = inputs.initial.insert(at, {key.element, key.port, 0.0, {}, key.signal});
      at->value += h * slope;
    }
    sort_stored(inputs.initial);
    return inputs;
  }

  void vary(const Study& study, const VariedParts& parts) {
    GivenValues given = given_of(*model, inputs.scene, overrides);
    // An event acts on what it sets, whatever the outputs depend on.
    const auto cut = model->events.empty()
                         ? slice(*model, study.graph(), study.equations(), study.order(), inputs.outputs, false)
                         : std::nullopt;
    const EquationSystem& system = cut ? cut->system : study.equations();
    const BlockOrder& order = cut ? cut->order : study.order();
    try {
      varied = with_variations(*model, system, order, given, seed, inputs.outputs, parts);
      program = compile(varied.model, varied.system, varied.order, options_of(varied));
    } catch (const std::invalid_argument& error) {
      refuse_derivatives(*model, error.what());
    }
  }

  void vary_modes(VariedParts parts) {
    for (const Element& element : model->elements)
      for (std::uint32_t port = 0; is_store(element.kind) && port < element.ports.size(); ++port)
        state_names.push_back(initial_name(element, port, false));
    for (const Signal& signal : model->signals)
      if (signal.is_state()) state_names.push_back(signal.name);
    const auto declared =
        std::make_shared<const Model>(with_variation_signals(*model, inputs.outputs.size(), parts, signals));
    parts.signals = &signals;
    modes = std::make_unique<ModePrograms>(
        declared, CompileOptions{{}, false},
        [this, parts](const std::shared_ptr<const Model>& of, const EquationSystem& system, const BlockOrder& order) {
          try {
            GivenValues given = given_of(*model, inputs.scene, overrides);
            const VariedSystem made = with_variations(*of, system, order, given, seed, inputs.outputs, parts);
            RunInputs point = inputs;
            point.parameters.resize(of->parameters.size(), 0.0);  // with the bands of diodes
            refuse_kinks(*of, made.system, made.order, made.variations.states, made.outputs, given, seed, point);
            if (outputs.empty()) outputs = made.outputs;  // the same in all modes
            return compile(made.model, made.system, made.order, options_of(made));
          } catch (const std::invalid_argument& error) {
            refuse_derivatives(*of, error.what());
          }
        });
    static_cast<void>(
        modes->at(modes->start(inputs).mode, inputs.parameters));  // what cannot be derived is refused here
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
  refuse_delayed(model);
  GivenValues given = given_of(model, made->inputs.scene, overrides);
  made->value = value_of(model, given, made->seed, made->inputs);
  if (made->seed.parameter.valid()) made->unit = model.parameters[made->seed.parameter.index()].unit;
  const VariedParts varied{parts.squares, parts.slopes, parts.integrals};
  if (switches_of(model).empty())
    made->vary(study, varied);
  else
    made->vary_modes(varied);
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

/// One parameter of a table.
struct Derived {
  std::vector<double> values, times, derivatives;  ///< by output
  std::vector<double> errors;                      ///< of the derivatives; empty: not asked for
  std::optional<std::string> unknown;              ///< why the errors are not known
  RunResult run;
  double value = 0.0;
  std::string unit;
};

/// @throws ModelError BG414 there is an event at the end of the run, and the derivative of output @p i, which is output
/// @p of of the run, is another one on its other side.
/// @param factor  of that derivative in the number's
void refuse_ends(const Model& model, const RunResult& run, const std::string& parameter, std::size_t i, std::size_t of,
                 double factor, bool at_end) {
  const OutputMeasure& own = run.report.measures[i];
  for (const BesideEnd& beside : run.beside_end) {
    if (at_end)
      refuse_end_jump(model, run.trace.names[i], parameter, own.final, beside.outputs[i],
                      std::max(std::abs(own.most), std::abs(own.least)));
    // What takes place in another mode at the end alone changes no integral.
    if (at_end || beside.sets || !std::isnan(beside.outputs[of]))
      refuse_end(model, run.trace.names[i], parameter, factor * run.report.measures[of].final,
                 factor * beside.outputs[of]);
  }
}

/// Derivatives where the outputs are largest: of runs that are recorded around these times.
/// @param made  whose run has found the peaks
void derive_peaks(const SensitivityScene& varied, const Model& model, const SceneOverrides& overrides,
                  SimulateOptions how, const std::vector<Peak>& peaks, Derived& made) {
  how.rows = {};
  how.measures = false;
  RunInputs inputs = varied.inputs();
  inputs.relative = overrides.relative.value_or(inputs.relative);
  const std::size_t n = inputs.outputs.size();
  std::vector<double> all;
  for (const Peak& each : peaks)
    for (const std::optional<double>& at : {std::optional(each.time), each.opposite})
      if (at) {
        const std::vector<double> around = times_around(*at, inputs);
        all.insert(all.end(), around.begin(), around.end());
      }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  const auto run_at = [&](const std::vector<double>& times) {
    RunResult run = varied.run(overrides, times, how);
    throw_failure(run, model);
    return run;
  };
  const RunResult first = run_at(all);
  RunResult second;
  struct Found {
    double time = 0.0, derivative = 0.0;
  };
  const auto top = [&](std::size_t i, const Peak& peak) {
    const Trace* trace = &first.trace;
    const auto rows_at = [&](double t) {
      if (!std::binary_search(all.begin(), all.end(), t)) {
        second = run_at(times_around(t, inputs));
        trace = &second.trace;
      }
      std::vector<PeakRow> rows;
      for (std::size_t k = 0; k < trace->times.size(); ++k)
        rows.push_back({trace->times[k], trace->columns[i][k], trace->columns[2 * n + i][k]});
      return rows;
    };
    const PeakTop at = top_of(model, inputs, made.run.trace.names[i], peak, first.instants, rows_at);
    const std::vector<double>& derivative = trace->columns[n + i];
    return Found{at.time,
                 at.share > 0.0 ? std::lerp(derivative[at.row], derivative[at.row + 1], at.share) : derivative[at.row]};
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Found found = top(i, peaks[i]);
    if (peaks[i].opposite) {
      Peak other = peaks[i];
      other.time = *peaks[i].opposite;
      other.value = -peaks[i].value;
      const OutputMeasure& all_times = made.run.report.measures[n + i];
      refuse_two_sides(model, inputs, i, peaks[i], found.derivative, top(i, other).derivative,
                       std::max(std::abs(all_times.most), std::abs(all_times.least)), varied.parameter());
    }
    if (is_end(peaks[i].time, inputs.start, inputs.stop))
      refuse_ends(model, made.run, varied.parameter(), i, n + i, 1.0, true);
    made.times.push_back(found.time);
    made.values.push_back(peaks[i].value);
    made.derivatives.push_back(found.derivative);
  }
}

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
  const double span = inputs.stop - inputs.start;
  if (!peak) {
    for (std::size_t i = 0; i < n; ++i) {
      made.times.push_back(inputs.stop);
      if (norm == SensitivityNorm::final) {
        refuse_ends(model, made.run, varied.parameter(), i, n + i, 1.0, true);
        made.values.push_back(measures[i].final);
        made.derivatives.push_back(measures[n + i].final);
        continue;
      }
      const double integral = measures[2 * n + i].final, derivative = measures[3 * n + i].final;
      const bool root = norm == SensitivityNorm::rms;
      const double rms = root ? root_mean_square(model, inputs, i, integral) : 0.0;
      const double over = root ? 2.0 * span * rms : norm == SensitivityNorm::mean ? span : 1.0;
      refuse_ends(model, made.run, varied.parameter(), i, 3 * n + i, 1.0 / over, false);
      made.values.push_back(root ? rms : integral / over);
      made.derivatives.push_back(derivative / over);
    }
    return made;
  }
  derive_peaks(varied, model, overrides, how, peaks, made);
  return made;
}

}  // namespace

namespace {

/// The same, and how far it is off at ten times the tolerance.
Derived derive_and_compare(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                           const std::string& to, SensitivityNorm norm, const SimulateOptions& how, bool errors) {
  const SensitivityScene varied(study, scene, overrides, to,
                                {norm == SensitivityNorm::rms, norm == SensitivityNorm::peak,
                                 norm == SensitivityNorm::integral || norm == SensitivityNorm::mean});
  Derived made = derive(varied, study.model(), overrides, norm, how);
  if (!errors) return made;
  made.errors.assign(made.values.size(), std::numeric_limits<double>::quiet_NaN());
  try {
    const Derived other = derive(varied, study.model(), looser(overrides, varied.inputs()), norm, how);
    for (std::size_t i = 0; i < made.errors.size(); ++i)
      made.errors[i] = std::abs(other.derivatives[i] - made.derivatives[i]);
  } catch (const ModelError& error) {
    if (error.diagnostics.front().code == "BG606") throw;
    made.unknown = error.diagnostics.front().situation;
  }
  return made;
}

}  // namespace

SensitivityTable sensitivities(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                               const std::vector<std::string>& to, SensitivityNorm norm, const SimulateOptions& how,
                               unsigned threads, bool errors, RefusedParameters* refused) {
  const Model& model = study.model();
  for (const std::string& name : to) find_seed(model, name);
  std::vector<Derived> derived(to.size());
  const std::vector<std::size_t> known = derive_each(
      to, threads,
      [&](std::size_t i) { derived[i] = derive_and_compare(study, scene, overrides, to[i], norm, how, errors); },
      refused);

  SensitivityTable table;
  const RunInputs inputs = prepare_scene(model, scene, overrides);
  const std::size_t n = inputs.outputs.size();
  table.scene = inputs.scene;
  for (const std::size_t i : inputs.outputs) {
    table.outputs.push_back(model.outputs[i].name);
    table.output_units.push_back(model.outputs[i].unit);
  }
  table.of.resize(n);
  UnknownErrors unknown;
  for (const std::size_t p : known) {
    Derived& each = derived[p];
    table.parameters.push_back(to[p]);
    table.parameter_units.push_back(each.unit);
    table.parameter_values.push_back(each.value);
    if (each.unknown) unknown.emplace_back(to[p], *each.unknown);
    const Trace& trace = each.run.trace;
    if (p == known.front()) {
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
      table.of[i].push_back({each.derivatives[i], relative_sensitivity(each.derivatives[i], each.value, each.values[i]),
                             errors ? each.errors[i] : std::numeric_limits<double>::quiet_NaN()});
      table.trace.names.push_back(trace.names[n + i]);
      table.trace.units.emplace_back();
      table.trace.columns.push_back(trace.columns[n + i]);
    }
    for (const std::string& note : each.run.report.notes)
      if (std::find(table.notes.begin(), table.notes.end(), note) == table.notes.end()) table.notes.push_back(note);
  }
  note_unknown(unknown, table.notes);
  return table;
}

}  // namespace bgsim
