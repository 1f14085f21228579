#include "study/second_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "bgsim/text.hpp"
#include "run/notes.hpp"

namespace bgsim {

namespace {

/// Rows that are compared at most: they stay in memory.
constexpr std::size_t kMostComparedRows = 20'000;
/// Seconds: a longer run is not made a second time unasked.
constexpr double kLongestRepeated = 10.0;
/// The second run may take that and so many times the first one.
constexpr double kTimesTheFirst = 4.0;
/// Tolerances below this have none of a tenth that rounding allows: the second run has a looser one.
constexpr double kLoosensBelow = 1e-12;
constexpr double kSecondTolerance = 0.1;

/// The scene as the second run makes it, and what is said of that.
RunInputs second_inputs(const RunInputs& inputs, std::string& words) {
  RunInputs second = inputs;
  if (facts_of(inputs.method).fixed_step()) {
    second.step /= 2.0;
    words = "with half the step";
    return second;
  }
  const bool tighter = inputs.relative > kLoosensBelow;
  const double factor = tighter ? kSecondTolerance : 1.0 / kSecondTolerance;
  words = tighter ? "at a tenth of the tolerance" : "at ten times the tolerance";
  second.relative *= factor;
  if (second.absolute) *second.absolute *= factor;
  for (auto& state : second.absolute_by_state) state.second *= factor;
  return second;
}

}  // namespace

bool exceeds_range(const OutputErrors& errors, std::size_t output, double relative) {
  return errors.done && !errors.is_still(output, relative) && errors.estimate[output] > errors.range[output];
}

SecondRun::SecondRun(const RunInputs& inputs, const SimulateOptions& options, bool events)
    : inputs_(inputs), options_(options), kept_options_(options) {
  every_ = 1 + (inputs.output_times.size() - std::min<std::size_t>(inputs.output_times.size(), 1)) / kMostComparedRows;
  if (options.rows)
    kept_options_.rows = [this](double t, std::span<const double> row) {
      keep(t, row);
      options_.rows(t, row);
    };
  if (!events) return;
  kept_options_.events = [this](const RunEvent& event) {
    events_.take(event);
    if (options_.events) options_.events(event);
  };
}

double SecondRun::values_kept(const RunInputs& inputs) {
  return static_cast<double>(std::min(inputs.output_times.size(), kMostComparedRows)) *
         static_cast<double>(inputs.outputs.size());
}

void SecondRun::keep(double t, std::span<const double> row) {
  if (row_ == 0) {
    kept_.columns.resize(row.size());
    least_.assign(row.size(), std::numeric_limits<double>::infinity());
    most_.assign(row.size(), -std::numeric_limits<double>::infinity());
  }
  const bool kept = row_ % every_ == 0 || row_ + 1 == inputs_.output_times.size();
  ++row_;
  if (kept) kept_.times.push_back(t);
  for (std::size_t c = 0; c < row.size(); ++c) {
    least_[c] = std::min(least_[c], row[c]);
    most_[c] = std::max(most_[c], row[c]);
    if (kept) kept_.columns[c].push_back(row[c]);
  }
}

void SecondRun::estimate(RunResult& result, double seconds, const Runner& run) {
  OutputErrors& errors = result.report.errors;
  const auto give_up = [&](const std::string& why) {
    if (errors.done) return;  // the run's own estimate stands
    errors = {};
    errors.possible = false;
    errors.why_not = why;
  };
  if (result.stop != StopReason::completed) return give_up("the run did not complete");
  if (!options_.resume.empty()) return give_up("the run goes on from a snapshot");
  if (seconds > kLongestRepeated)
    return give_up("it takes a second run, and this one took " + number_text(seconds, 2) + " s");
  if (!options_.rows) {
    std::vector<double> row(result.trace.columns.size());
    for (std::size_t i = 0; i < result.trace.times.size(); ++i) {
      for (std::size_t c = 0; c < row.size(); ++c) row[c] = result.trace.columns[c][i];
      keep(result.trace.times[i], row);
    }
  }
  std::string words;
  RunInputs inputs = second_inputs(inputs_, words);
  inputs.output_times = kept_.times;
  SimulateOptions how;
  how.energy_audit = how.error_estimate = false;
  how.longest_run = options_.longest_run;
  if (options_.time_limit > 0.0) how.time_limit = std::max(1e-9, options_.time_limit - seconds);
  // Impacts that come to rest in one run may go on in the other, and that was not asked for.
  const double worth = kLongestRepeated + kTimesTheFirst * seconds;
  if (options_.longest_run > 0.0 && !(how.time_limit > 0.0 && how.time_limit < worth)) how.time_limit = worth;
  how.progress = options_.progress;
  EventTimes events;
  how.events = [&events](const RunEvent& event) { events.take(event); };
  const RunResult second = run(inputs, how);
  if (second.stop == StopReason::interrupted) return give_up("the second run, " + words + ", was interrupted");
  if (second.stop != StopReason::completed)
    return give_up("the second run, " + words + ", did not complete: " + second.failure.value().situation);
  compare(result, second.trace, events, words);
}

void SecondRun::compare(RunResult& result, const Trace& second, const EventTimes& events, const std::string& words) {
  const double span = inputs_.stop - inputs_.start;
  const EventDistance instants = event_distance(events_, events, span);
  OutputErrors& errors = result.report.errors;
  // What the run itself has noted is said again, with what is found here.
  if (const auto own = output_errors_note(errors, result.trace.names, inputs_.relative))
    std::erase(result.report.notes, *own);
  std::erase(result.report.notes, lost_errors_note(errors.why_not));
  const OutputErrors carried = std::exchange(errors, {});
  errors.done = true;
  errors.second_run = words;
  const std::size_t outputs = kept_.columns.size();
  errors.estimate.assign(outputs, 0.0);
  for (std::size_t c = 0; c < outputs; ++c) {
    for (std::size_t i = 0; i < kept_.times.size(); ++i)
      if (!instants.parted(kept_.times[i]))
        errors.estimate[c] = std::max(errors.estimate[c], std::abs(kept_.columns[c][i] - second.columns[c][i]));
    errors.range.push_back(most_[c] - least_[c]);
    errors.magnitude.push_back(std::max(std::abs(most_[c]), std::abs(least_[c])));
  }
  // Errors are as large as the tolerance: what the second run is wrong by, too, is missing from the difference.
  if (inputs_.relative > kLoosensBelow)
    for (double& estimate : errors.estimate) estimate /= 1.0 - kSecondTolerance;
  errors.beyond_rounding = errors.estimate;
  // The second run is wrong, too, often to the same side: where the estimate that was carried along is larger, it
  // stands; but not one of first order that has come to more than an output varies by, which is no size of an error.
  for (std::size_t c = 0; carried.done && c < outputs; ++c)
    if (exceeds_range(carried, c, inputs_.relative)) errors.beyond_first_order.push_back(c);
  for (std::size_t c = 0; carried.done && errors.beyond_first_order.empty() && c < outputs; ++c) {
    errors.estimate[c] = std::max(errors.estimate[c], carried.estimate[c]);
    errors.beyond_rounding[c] = std::max(errors.beyond_rounding[c], carried.beyond_rounding[c]);
  }
  if (!events_.all().empty() || !events.all().empty()) {
    errors.instants = instants.largest;
    errors.instants_of = instants.what;
  }
  const auto note = [&](const std::optional<std::string>& text) {
    if (text) result.report.notes.push_back(*text);
  };
  note(output_errors_note(errors, result.trace.names, inputs_.relative));
  note(beyond_first_order_note(errors, result.trace.names));
  if (errors.instants.value_or(0.0) > OutputErrors::kLarge * span)
    note("the instants of events are estimated to be wrong by up to " + number_text(*errors.instants, 2) + ": " +
         errors.instants_of);
}

}  // namespace bgsim
