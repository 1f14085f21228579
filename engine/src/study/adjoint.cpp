// Sensitivities to many parameters, by one run back over a run.
#include "run/adjoint.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "bgsim/sensitivity.hpp"
#include "linear/variations.hpp"
#include "run/outputs_along.hpp"
#include "run/variation.hpp"
#include "study/peak_top.hpp"
#include "study/sensitivity_parts.hpp"

namespace bgsim {
namespace {

/// A scene whose outputs' numbers are derived by many seeds; compiled once.
class AdjointScene {
 public:
  AdjointScene(const Study& study, const std::string& scene, const SceneOverrides& overrides,
               const std::vector<std::string>& to)
      : model_(study.model()), overrides_(overrides), inputs_(study.scene(scene, overrides).inputs()) {
    refuse_jumps(model_);
    for (const std::string& name : to) seeds_.push_back(find_seed(model_, name));
    // An event acts on what it sets, whatever the outputs depend on.
    const auto cut = model_.events.empty()
                         ? slice(model_, study.graph(), study.equations(), study.order(), inputs_.outputs, false)
                         : std::nullopt;
    const EquationSystem& system = cut ? cut->system : study.equations();
    const BlockOrder& order = cut ? cut->order : study.order();
    if (order.rates.empty())
      refuse_sensitivity(model_, "nothing that the outputs depend on is stored",
                         "the adjoint equations are those of states", "ask for --method forward");
    GivenValues given = given_of(model_, inputs_.scene, overrides);
    std::vector<SeedSlopes> slopes;
    std::vector<char> moves(model_.parameters.size(), 0);
    refused_.resize(seeds_.size());
    for (std::size_t s = 0; s < seeds_.size(); ++s) {
      const Seed& seed = seeds_[s];
      try_seed(refused_, s,
               [&] { refuse_kinks(model_, system, order, order.rates.size(), inputs_.outputs, given, seed, inputs_); });
      slopes.push_back(seed_slopes(model_, given, seed, inputs_));
      for (std::size_t i = 0; i < moves.size(); ++i)
        if (slopes.back().parameters[i] != 0.0) moves[i] = 1;
    }
    std::vector<std::uint32_t> columns;
    for (std::uint32_t i = 0; i < moves.size(); ++i)
      if (moves[i] != 0) columns.push_back(i);
    for (const SeedSlopes& each : slopes) {
      AdjointSeed seed;
      for (const std::uint32_t i : columns) seed.columns.push_back(each.parameters[i]);
      for (const State& state : system.states) {
        const auto at = each.states.find({state.element, state.port, state.signal});
        seed.states.push_back(at == each.states.end() ? 0.0 : at->second);
      }
      directions_.push_back(std::move(seed));
    }
    for (const Seed& seed : seeds_) values_.push_back(value_of(model_, given, seed, inputs_));
    CompileOptions options;
    options.outputs = inputs_.outputs;
    options.energies = false;
    options.columns = &columns;
    try {
      program_ = compile(study.shared_model(), system, order, options);
    } catch (const std::invalid_argument& error) {
      refuse_sensitivity(
          model_, std::string("the equations cannot be derived as often as sensitivities ask for: ") + error.what(),
          "the adjoint equations take derivatives of the laws by their parameters",
          "fit a formula to the data, or use spline data");
    }
    if (!program_.plan.explicit_form)
      refuse_sensitivity(model_, "the loops of the equations are too large to be eliminated",
                         "the adjoint equations are those of the states alone", "ask for --method forward");
  }

  /// By seed: why there is no derivative.
  using Refused = std::vector<std::optional<ModelError>>;
  struct Derived {
    std::vector<double> values, times;             ///< by output
    std::vector<std::vector<double>> derivatives;  ///< by output, then seed
    Refused refused;
    RunResult run;
  };

  /// @param looser_run  at ten times the tolerance.
  [[nodiscard]] Derived derive(bool looser_run, SensitivityNorm norm, SimulateOptions how) const {
    RunInputs inputs = inputs_;
    if (looser_run) {
      inputs = prepare_scene(model_, inputs_.scene, looser(overrides_, inputs_));
      inputs.output_times = inputs_.output_times;
    }
    Trajectory trajectory;
    how.measures = true;
    how.error_estimate = false;
    how.energy_audit = false;
    how.trajectory = &trajectory;
    Derived made;
    made.refused = refused_;
    made.run = simulate(program_, inputs, how);
    throw_failure(made.run, model_);
    const std::size_t n = inputs.outputs.size();
    const std::vector<Peak> peaks = peaks_of(made.run, n, inputs.relative, model_);
    std::vector<AdjointFigure> figures;
    std::vector<std::size_t> opposite(n, 0);  // figure of the peak to the other side; 0: none
    std::vector<double> instants;
    for (const Trajectory::Event& event : trajectory.events()) instants.push_back(event.t);
    const auto top = [&](std::size_t i, const Peak& peak) {
      const auto rows_at = [&](double t) {
        std::vector<PeakRow> rows;
        const std::vector<double> times = times_around(t, inputs);
        const OutputsAlong along = output_along(program_, inputs, trajectory, i, times);
        if (along.failure) throw ModelError({*along.failure}, model_.sources);
        for (std::size_t k = 0; k < times.size(); ++k) rows.push_back({times[k], along.values[k], along.slopes[k]});
        return rows;
      };
      return top_of(model_, inputs, model_.outputs[inputs.outputs[i]].name, peak, instants, rows_at).time;
    };
    for (std::size_t i = 0; i < n; ++i)
      figures.push_back(norm == SensitivityNorm::final  ? AdjointFigure{i, AdjointFigure::Kind::value, inputs.stop}
                        : norm == SensitivityNorm::peak ? AdjointFigure{i, AdjointFigure::Kind::value, top(i, peaks[i])}
                        : norm == SensitivityNorm::rms  ? AdjointFigure{i, AdjointFigure::Kind::square, 0.0}
                                                        : AdjointFigure{i, AdjointFigure::Kind::integral, 0.0});
    for (std::size_t i = 0; i < n && norm == SensitivityNorm::peak; ++i) {
      if (!peaks[i].opposite) continue;
      Peak other = peaks[i];
      other.time = *peaks[i].opposite;
      other.value = -peaks[i].value;
      opposite[i] = figures.size();
      figures.push_back({i, AdjointFigure::Kind::value, top(i, other)});
    }
    AdjointResult back = run_back(program_, inputs, trajectory, figures, directions_, how);
    if (back.failure) throw ModelError({*back.failure}, model_.sources);
    constexpr double kRoundings = 64.0 * std::numeric_limits<double>::epsilon();
    const double span = inputs.stop - inputs.start;
    for (std::size_t i = 0; i < n; ++i) {
      const OutputMeasure& measured = made.run.report.measures[i];
      std::vector<double> derivatives = back.gradient[i];
      double value = measured.final, time = inputs.stop, factor = 1.0;
      if (norm == SensitivityNorm::rms) {
        value = root_mean_square(model_, inputs, i, measured.square);
        factor = 1.0 / (2.0 * span * value);
      } else if (norm == SensitivityNorm::mean || norm == SensitivityNorm::integral) {
        factor = norm == SensitivityNorm::mean ? 1.0 / span : 1.0;
        value = measured.integral * factor;
      } else if (norm == SensitivityNorm::peak) {
        value = peaks[i].value;
        time = figures[i].time;
        for (std::size_t s = 0; s < seeds_.size() && opposite[i] > 0; ++s) {
          const double one = derivatives[s], other = back.gradient[opposite[i]][s];
          try_seed(made.refused, s, [&] {
            refuse_two_sides(model_, inputs, i, peaks[i], one, other, std::max(std::abs(one), std::abs(other)),
                             seeds_[s].name);
          });
        }
      }
      const bool at_end = figures[i].kind == AdjointFigure::Kind::value && figures[i].time == inputs.stop;
      for (const AdjointBeside& beside : back.beside)
        for (std::size_t s = 0; s < seeds_.size(); ++s) {
          if (!beside.moves[s]) continue;
          try_seed(made.refused, s, [&] {
            const std::string& name = model_.outputs[inputs.outputs[i]].name;
            const double difference =
                beside.difference.empty() ? std::numeric_limits<double>::quiet_NaN() : beside.difference[i][s];
            if (at_end)
              refuse_end_jump(model_, name, seeds_[s].name, back.value[i], beside.values[i],
                              std::max(std::abs(measured.least), std::abs(measured.most)));
            refuse_end(model_, name, seeds_[s].name, factor * derivatives[s], factor * (derivatives[s] - difference),
                       factor * kRoundings * back.terms[i][s]);
          });
        }
      for (double& derivative : derivatives) derivative *= factor;
      made.values.push_back(value);
      made.times.push_back(time);
      made.derivatives.push_back(std::move(derivatives));
    }
    return made;
  }

  [[nodiscard]] const RunInputs& inputs() const { return inputs_; }
  [[nodiscard]] double value(std::size_t seed) const { return values_[seed]; }
  [[nodiscard]] std::string unit(std::size_t seed) const {
    const ParameterId parameter = seeds_[seed].parameter;
    return parameter.valid() ? model_.parameters[parameter.index()].unit : "";
  }

 private:
  static void try_seed(Refused& refused, std::size_t seed, const std::function<void()>& work) {
    if (refused[seed]) return;
    try {
      work();
    } catch (const ModelError& error) {
      if (error.diagnostics.front().code != "BG414") throw;
      refused[seed] = error;
    }
  }

  const Model& model_;
  SceneOverrides overrides_;
  RunInputs inputs_;
  std::vector<Seed> seeds_;
  Refused refused_;  ///< at the start already
  std::vector<double> values_;
  std::vector<AdjointSeed> directions_;
  Program program_;
};

}  // namespace

SensitivityTable adjoint_sensitivities(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                                       const std::vector<std::string>& to, SensitivityNorm norm,
                                       const SimulateOptions& how, bool errors, RefusedParameters* refused) {
  const Model& model = study.model();
  const AdjointScene varied(study, scene, overrides, to);
  AdjointScene::Derived derived = varied.derive(false, norm, how);
  const std::vector<std::size_t> known = derive_each(
      to, 1,
      [&](std::size_t s) {
        if (derived.refused[s]) throw ModelError(*derived.refused[s]);
      },
      refused);
  std::optional<AdjointScene::Derived> other;
  UnknownErrors not_known;
  if (errors) try {
      other = varied.derive(true, norm, how);
    } catch (const ModelError& error) {
      if (error.diagnostics.front().code == "BG606") throw;
      for (const std::size_t s : known) not_known.emplace_back(to[s], error.diagnostics.front().situation);
    }
  for (const std::size_t s : known)
    if (other && other->refused[s]) not_known.emplace_back(to[s], other->refused[s]->diagnostics.front().situation);
  SensitivityTable table;
  table.scene = varied.inputs().scene;
  table.values = derived.values;
  table.times = derived.times;
  table.notes = derived.run.report.notes;
  note_unknown(not_known, table.notes);
  table.trace = std::move(derived.run.trace);
  for (const std::size_t s : known) {
    table.parameters.push_back(to[s]);
    table.parameter_units.push_back(varied.unit(s));
    table.parameter_values.push_back(varied.value(s));
  }
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < derived.values.size(); ++i) {
    const Output& output = model.outputs[varied.inputs().outputs[i]];
    table.outputs.push_back(output.name);
    table.output_units.push_back(output.unit);
    std::vector<OutputSensitivity>& row = table.of.emplace_back();
    for (const std::size_t s : known) {
      const double derivative = derived.derivatives[i][s];
      const bool compared = other && !other->refused[s];
      row.push_back({derivative, relative_sensitivity(derivative, varied.value(s), derived.values[i]),
                     compared ? std::abs(other->derivatives[i][s] - derivative) : unknown});
    }
  }
  return table;
}

}  // namespace bgsim
