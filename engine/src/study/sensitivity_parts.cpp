#include "study/sensitivity_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/codes.hpp"
#include "base/in_threads.hpp"
#include "base/text.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"

namespace bgsim {

GivenValues given_of(const Model& model, const std::string& scene, const SceneOverrides& overrides) {
  for (const Scene& each : model.scenes)
    if (each.name == scene) return given_values(model, each, overrides);
  throw std::logic_error("a scene was prepared that the model does not have");
}

void refuse_sensitivity(const Model& model, std::string situation, std::string rule, std::string help,
                        std::optional<Place> place) {
  throw ModelError({diagnostic_of("BG414", std::move(situation), place, std::move(rule), std::move(help))},
                   model.sources);
}

void refuse_delayed(const Model& model) {
  for (const Signal& signal : model.signals)
    if (signal.delay)
      refuse_sensitivity(model, "the model has delayed signals (" + in_quotes(signal.name) + "), which are not derived",
                         "what a delayed signal was depends on parameters as well", "ask for --method differences",
                         signal.place);
}

void refuse_jumps(const Model& model) {
  refuse_delayed(model);
  const std::vector<ElementId> switches = switches_of(model);
  if (switches.empty()) return;
  const Element& first = model.elements[switches.front().index()];
  refuse_sensitivity(
      model, "the model has ideal switches or diodes (" + in_quotes(first.name) + "), whose jumps are not derived",
      "the adjoint equations cross events, not changes of the equations themselves",
      "ask for --method forward, or differences", first.place);
}

std::vector<std::size_t> derive_each(const std::vector<std::string>& to, unsigned threads,
                                     const std::function<void(std::size_t)>& work, RefusedParameters* refused) {
  std::vector<std::optional<ModelError>> errors(to.size());
  in_threads(to.size(), threads, [&](std::size_t i) {
    try {
      work(i);
    } catch (const ModelError& error) {
      if (refused == nullptr || error.diagnostics.front().code != "BG414") throw;
      errors[i] = error;
    }
  });
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < to.size(); ++i)
    if (errors[i])
      refused->emplace_back(to[i], errors[i]->diagnostics.front());
    else
      known.push_back(i);
  if (known.empty() && !to.empty()) throw *errors.front();
  return known;
}

void throw_failure(const RunResult& result, const Model& model) {
  if (result.stop == StopReason::completed) return;
  throw ModelError({*result.failure}, model.sources);
}

std::vector<Peak> peaks_of(const RunResult& run, std::size_t count, double relative, const Model& model) {
  if (run.report.measures.empty())
    refuse_sensitivity(model, "an output has no value within the run: " + run.report.why_not_measured, {},
                       "leave it out (--of)");
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

double relative_sensitivity(double derivative, double parameter, double value) {
  return value == 0.0 ? std::numeric_limits<double>::quiet_NaN() : derivative * parameter / value;
}

namespace {

constexpr double kFlat = 1e-3;

std::string output_name(const Model& model, const RunInputs& inputs, std::size_t output) {
  return in_quotes(model.outputs[inputs.outputs[output]].name);
}

}  // namespace

void refuse_two_sides(const Model& model, const RunInputs& inputs, std::size_t output, const Peak& peak, double one,
                      double other, double scale, const std::string& parameter) {
  // The magnitudes change by d and -d: apart from each other by their sum.
  if (std::abs(one + other) <= kFlat * scale) return;
  refuse_sensitivity(
      model,
      output_name(model, inputs, output) + " is as large to both sides, at t = " + number_text(peak.time, 6) +
          " and t = " + number_text(*peak.opposite, 6) + ", and the two change differently with " +
          in_quotes(parameter),
      "which of two peaks is the larger depends on whether a parameter grows or falls",
      "ask for other parameters (--to), or take the differences of max(...) and min(...) by bgsim sweep");
}

namespace {

/// Of a number: what lies on two sides of an event at the end of a run, found with the run's errors, is the same.
constexpr double kSame = 1e-6;

}  // namespace

void refuse_end_jump(const Model& model, const std::string& output, const std::string& parameter, double here,
                     double other, double largest) {
  if (std::isnan(other) || std::abs(other - here) <= kSame * largest) return;
  refuse_sensitivity(model,
                     "there is an event at the end of the run, whose instant changes with " +
                         in_quotes(short_name(parameter)) + ", and " + in_quotes(output) + " jumps there from " +
                         number_text(other, 6) + " to " + number_text(here, 6),
                     "a derivative exists where both sides have the same one", "let the run end at another time");
}

void refuse_end(const Model& model, const std::string& output, const std::string& parameter, double here, double other,
                double rounding) {
  if (std::abs(other - here) <= kSame * std::max(std::abs(other), std::abs(here)) + rounding) return;
  refuse_sensitivity(model,
                     "there is an event at the end of the run, and " + in_quotes(output) + " changes with " +
                         in_quotes(short_name(parameter)) + " by " + number_text(here) + " on one side of it" +
                         (std::isnan(other) ? ", and what it changes by on the other is not known"
                                            : " and by " + number_text(other) + " on the other"),
                     "a derivative exists where both sides have the same one", "let the run end at another time");
}

double root_mean_square(const Model& model, const RunInputs& inputs, std::size_t output, double square) {
  const double rms = std::sqrt(square / (inputs.stop - inputs.start));
  if (!(rms > 0.0))
    refuse_sensitivity(model, "the root of the mean square of " + output_name(model, inputs, output) + " is 0",
                       "a root has no derivative where it is 0",
                       "ask for --norm final, or leave the output out (--of)");
  return rms;
}

void note_unknown(const UnknownErrors& unknown, std::vector<std::string>& notes) {
  std::vector<std::pair<std::string, std::string>> names;  // by reason
  for (const auto& [name, why] : unknown) {
    const auto same = [&reason = why](const auto& each) { return each.first == reason; };
    const auto found = std::find_if(names.begin(), names.end(), same);
    if (found == names.end())
      names.emplace_back(why, in_quotes(short_name(name)));
    else
      found->second.append(", ").append(in_quotes(short_name(name)));
  }
  for (const auto& [why, of] : names) {
    std::string& note = notes.emplace_back("how far the derivatives by ");
    note.append(of).append(" are off (within) is not known: the second run, at ten times the tolerance, failed: ");
    note.append(why);
  }
}

SceneOverrides looser(const SceneOverrides& overrides, const RunInputs& inputs) {
  SceneOverrides result = overrides;
  result.relative = std::min(10.0 * inputs.relative, 0.1);
  if (inputs.absolute) result.absolute = 10.0 * *inputs.absolute;
  if (inputs.step > 0.0) {
    result.method = inputs.method;
    result.step = 2.0 * inputs.step;
  }
  return result;
}

}  // namespace bgsim
