// Sensitivities by differences of runs: of whatever runs.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "base/text.hpp"
#include "bgsim/sensitivity.hpp"
#include "bgsim/text.hpp"
#include "linear/variations.hpp"
#include "study/sensitivity_parts.hpp"

namespace bgsim {
namespace {

/// The tolerance of the runs, if none is given: what they are wrong by is divided by the steps below.
constexpr double kRelative = 1e-10;

/// How much longer the last flights are, of impacts that accumulate, that looser runs leave out: as their tolerances.
constexpr double kEarlier = 10.0;

/// The numbers of one run's outputs, and when the peaks are.
struct RunNumbers {
  std::vector<double> values, times;
  RunResult run;
};

/// @param times  inputs whose times are taken: a scene's times do not follow the parameter, even where they are
///               expressions of it
RunNumbers numbers_of(const Simulation& simulation, const RunInputs& times, SensitivityNorm norm, SimulateOptions how) {
  how.measures = true;
  how.error_estimate = false;
  how.energy_audit = false;
  const Model& model = simulation.model();
  RunInputs inputs = simulation.inputs();
  inputs.start = times.start;
  inputs.stop = times.stop;
  inputs.output_times = times.output_times;
  inputs.early_closing = times.early_closing;
  RunNumbers made;
  made.run = simulation.simulate(inputs, how);
  throw_failure(made.run, model);
  const std::size_t n = inputs.outputs.size();
  const std::vector<Peak> peaks = peaks_of(made.run, n, inputs.relative, model);
  const double span = inputs.stop - inputs.start;
  for (std::size_t i = 0; i < n; ++i) {
    const OutputMeasure& m = made.run.report.measures[i];
    made.times.push_back(norm == SensitivityNorm::peak ? peaks[i].time : inputs.stop);
    made.values.push_back(norm == SensitivityNorm::final      ? m.final
                          : norm == SensitivityNorm::rms      ? root_mean_square(model, inputs, i, m.square)
                          : norm == SensitivityNorm::peak     ? peaks[i].value
                          : norm == SensitivityNorm::integral ? m.integral
                                                              : m.integral / span);
  }
  return made;
}

/// The slopes to smaller and to larger values.
using Sides = std::array<double, 2>;

/// A derivative, and by how much what it was extrapolated from disagrees.
struct Extrapolated {
  double derivative = 0.0, error = std::numeric_limits<double>::infinity();
  double h = 0.0;                ///< the largest step taken
  std::array<Sides, 3> sides{};  ///< over h, h/2 and h/4
};

/// Of one output, from its numbers at -h, h, -h/2, h/2, -h/4, h/4 beside the middle.
Extrapolated extrapolate(double middle, const std::array<double, 6>& around, double h) {
  Extrapolated made;
  made.h = h;
  std::array<double, 3> slope{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double step = std::ldexp(h, -static_cast<int>(k)), below = around[2 * k], above = around[2 * k + 1];
    slope[k] = (above - below) / (2.0 * step);
    made.sides[k] = {(middle - below) / step, (above - middle) / step};
  }
  const double coarse = (4.0 * slope[1] - slope[0]) / 3.0;
  made.derivative = (4.0 * slope[2] - slope[1]) / 3.0;
  made.error = std::abs(made.derivative - coarse);
  return made;
}

/// The slopes to both sides of the value itself, from those over one step and over its half.
Sides at_value(const Sides& step, const Sides& half) { return {2.0 * half[0] - step[0], 2.0 * half[1] - step[1]}; }

/// Slopes to both sides that are not the same. What they differ by, extrapolated, falls to an eighth from one pair of
/// steps to the next for a smooth output, to a quarter where third derivatives differ; at a corner it stays, at a jump
/// it grows.
/// @param looser  of runs at ten times the tolerance: what both differ by, in each of the slopes, is not known
/// @param wrong   of a number of a run: what is more than that, and clear beside the slope, is no error of the runs.
///                Near a jump looser runs may be on its other side
/// @param jumps   by which numbers of runs may jump with the parameter, rounding among it
std::optional<Sides> corner_of(const Extrapolated& found, const std::array<Sides, 3>& looser, double wrong,
                               double jumps) {
  constexpr double kStays = 0.5, kSame = 1e-6, kClearly = 0.01;
  const auto apart = [](const Sides& sides) { return sides[1] - sides[0]; };
  const Sides coarse = at_value(found.sides[0], found.sides[1]), fine = at_value(found.sides[1], found.sides[2]);
  const auto unknown = [&](std::size_t k) { return std::abs(apart(looser[k]) - apart(found.sides[k])); };
  const double seen = 2.0 * unknown(2) + unknown(1), step = 0.25 * found.h,
               clear = std::max(wrong / step, kClearly * std::abs(found.derivative));
  const double by = std::abs(apart(fine));
  const bool corner = by > kStays * std::abs(apart(coarse)) &&
                      by > std::max(kSame * std::max(std::abs(fine[0]), std::abs(fine[1])), jumps / step) &&
                      by > std::min(seen, clear);
  return corner ? std::optional(fine) : std::nullopt;
}

/// One parameter of a table.
struct Difference {
  double value = 0.0;
  std::vector<Extrapolated> of;  ///< by output
};

/// A scene's runs at a looser tolerance, that leave out the last flights of impacts that accumulate from longer ones
/// on.
struct LooserRuns {
  const Simulation& simulation;
  const RunInputs& inputs;
  const RunNumbers& middle;
};

/// What runs are wrong by moves with the parameter, too, and as smoothly: no extrapolation shows it. What the
/// derivatives of looser runs differ by is some times as much.
/// @param middle  the run at the value itself
/// @throws ModelError BG414 where the slopes to both sides differ by more than what runs are wrong by
void compare_with_looser(const LooserRuns& looser, const RunNumbers& middle, const Seed& seed, SensitivityNorm norm,
                         const SimulateOptions& how, Difference& made) {
  constexpr double kRoundings = 64.0 * std::numeric_limits<double>::epsilon();
  constexpr double kWrong = 100.0;  // tolerances
  const double tight = middle.run.report.relative;
  const RunInputs& inputs = looser.inputs;
  const Model& model = looser.simulation.model();
  std::map<double, std::array<std::vector<double>, 4>> runs;  // by h: the numbers at -h/2, h/2, -h/4, h/4
  for (Extrapolated& of : made.of) {
    auto& around = runs[of.h];
    for (std::size_t k = 0; k < 4 && around[3].empty(); ++k) {
      const double step = std::ldexp(of.h, -1 - static_cast<int>(k / 2));
      around[k] = numbers_of(looser.simulation.with(seed.name, k % 2 == 0 ? made.value - step : made.value + step),
                             inputs, norm, how)
                      .values;
    }
    const auto i = static_cast<std::size_t>(&of - made.of.data());
    const Extrapolated other =
        extrapolate(looser.middle.values[i],
                    {around[0][i], around[1][i], around[0][i], around[1][i], around[2][i], around[3][i]}, of.h);
    const OutputMeasure& m = middle.run.report.measures[i];
    const double largest = std::max(std::abs(m.least), std::abs(m.most)),
                 length = norm == SensitivityNorm::integral ? inputs.stop - inputs.start : 1.0;
    const double size = largest * length;
    // How many impacts are made before a contact closes goes by whole numbers.
    const double closing =
        middle.run.report.accumulations > 0 ? 2.0 * std::abs(looser.middle.values[i] - middle.values[i]) : 0.0;
    if (const auto sides = corner_of(of, other.sides, kWrong * tight * size, kRoundings * size + closing))
      refuse_sensitivity(model,
                         in_quotes(model.outputs[inputs.outputs[i]].name) + " changes with " +
                             in_quotes(short_name(seed.name)) + " by " + number_text((*sides)[0], 6) +
                             " to smaller values and by " + number_text((*sides)[1], 6) + " to larger ones",
                         "a derivative exists where both sides have the same one",
                         "ask for it at a slightly different value");
    of.error += std::abs(other.derivative - of.derivative);
  }
}

Difference difference_by(const Simulation& simulation, const LooserRuns& looser, const Seed& seed, double value,
                         const RunNumbers& middle, SensitivityNorm norm, const SimulateOptions& how) {
  constexpr std::array<double, 3> kSteps = {1e-3, 1e-4, 1e-5};  // of the parameter
  constexpr double kEnough = 1e-6;                              // of a derivative
  const Model& model = simulation.model();
  if (!(std::abs(value) > 0.0))
    refuse_sensitivity(model, in_quotes(short_name(seed.name)) + " is 0, or not known, at the start",
                       "differences are taken over a part of the value", "give it a value near 0, with --set");
  SimulateOptions alone = how;
  alone.rows = {};
  Difference made;
  made.value = value;
  made.of.resize(middle.values.size());
  for (const double part : kSteps) {
    const double h = part * std::abs(value);
    std::vector<std::array<double, 6>> around(middle.values.size());
    for (std::size_t k = 0; k < 6; ++k) {
      const double step = std::ldexp(h, -static_cast<int>(k / 2));
      const RunNumbers at = numbers_of(simulation.with(seed.name, k % 2 == 0 ? value - step : value + step),
                                       simulation.inputs(), norm, alone);
      for (std::size_t i = 0; i < around.size(); ++i) around[i][k] = at.values[i];
    }
    bool enough = true;
    for (std::size_t i = 0; i < around.size(); ++i) {
      const Extrapolated found = extrapolate(middle.values[i], around[i], h);
      if (found.error < made.of[i].error) made.of[i] = found;
      enough = enough && made.of[i].error <= kEnough * std::abs(made.of[i].derivative);
    }
    if (enough) break;
  }
  compare_with_looser(looser, middle, seed, norm, alone, made);
  return made;
}

}  // namespace

SensitivityTable difference_sensitivities(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                                          const std::vector<std::string>& to, SensitivityNorm norm,
                                          const SimulateOptions& how, unsigned threads, RefusedParameters* refused) {
  const Model& model = study.model();
  std::vector<Seed> seeds;
  for (const std::string& name : to) seeds.push_back(find_seed(model, name));
  SceneOverrides tight = overrides;
  if (!tight.relative) tight.relative = std::min(prepare_scene(model, scene, overrides).relative, kRelative);
  const Simulation simulation = study.scene(scene, tight, {false, false});
  const RunInputs& inputs = simulation.inputs();
  const Simulation other = study.scene(scene, looser(tight, inputs), {false, false});
  RunNumbers middle = numbers_of(simulation, inputs, norm, how);
  SimulateOptions alone = how;
  alone.rows = {};
  RunInputs looser_inputs = other.inputs();
  looser_inputs.early_closing = kEarlier;
  const RunNumbers looser_middle = numbers_of(other, looser_inputs, norm, alone);

  std::vector<Difference> derived(to.size());
  const std::vector<std::size_t> known = derive_each(
      to, threads,
      [&](std::size_t i) {
        GivenValues given = given_of(model, inputs.scene, tight);
        derived[i] = difference_by(simulation, {other, looser_inputs, looser_middle}, seeds[i],
                                   value_of(model, given, seeds[i], inputs), middle, norm, how);
      },
      refused);

  SensitivityTable table;
  table.scene = inputs.scene;
  table.values = middle.values;
  table.times = middle.times;
  table.notes = middle.run.report.notes;
  table.trace = std::move(middle.run.trace);
  for (const std::size_t p : known) {
    const ParameterId parameter = seeds[p].parameter;
    table.parameters.push_back(to[p]);
    table.parameter_units.push_back(parameter.valid() ? model.parameters[parameter.index()].unit : "");
    table.parameter_values.push_back(derived[p].value);
  }
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    const Output& output = model.outputs[inputs.outputs[i]];
    table.outputs.push_back(output.name);
    table.output_units.push_back(output.unit);
    std::vector<OutputSensitivity>& row = table.of.emplace_back();
    for (const std::size_t p : known) {
      const Difference& each = derived[p];
      row.push_back({each.of[i].derivative, relative_sensitivity(each.of[i].derivative, each.value, table.values[i]),
                     each.of[i].error});
    }
  }
  return table;
}

}  // namespace bgsim
