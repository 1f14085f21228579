#include "study/trade_runs.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "base/codes.hpp"
#include "bgsim/study.hpp"
#include "run/failures.hpp"

namespace bgsim {

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::string setting_flags(const TradeSetting& setting) {
  std::string text = "--method " + method_name(setting.method);
  if (setting.max_order > 0) text += " --max-order " + std::to_string(setting.max_order);
  if (setting.relative > 0.0) text += " --relative " + number_text(setting.relative, 3);
  if (setting.step > 0.0) text += " --step " + number_text(setting.step, 6);
  return text;
}

std::string curve_name(const TradeSetting& setting) {
  return method_name(setting.method) +
         (setting.max_order > 0 ? " of order up to " + std::to_string(setting.max_order) : "");
}

RunInputs with_setting(const RunInputs& inputs, const TradeSetting& setting) {
  RunInputs changed = inputs;
  changed.method = setting.method;
  changed.max_order = setting.max_order;
  changed.step = setting.step;
  if (setting.relative > 0.0) changed.relative = setting.relative;
  return changed;
}

TradeScene trade_scene(const Simulation& scene) {
  return {scene.program(), scene.inputs(),
          [&scene](const RunInputs& inputs, const SimulateOptions& how) { return scene.simulate(inputs, how); }};
}

TradeScene trade_scene(const Program& program, const RunInputs& inputs) {
  if (!program.switch_elements.empty())
    throw TradeFailure(diagnostic_of("BG610", "methods cannot be compared on one program of a model with switches", {},
                                     "a program is that of one mode of the switches",
                                     "give the scene, a Simulation, which has the programs of all modes"));
  return {program, inputs,
          [&program](const RunInputs& changed, const SimulateOptions& how) { return simulate(program, changed, how); }};
}

TradeRuns::TradeRuns(const TradeScene& scene, const TradeOptions& options)
    : scene_(scene), inputs_(scene.inputs), events_(has_events(*scene.program.model)), options_(options) {
  const OutputTimes& times = inputs_.output_times;
  for (std::size_t i = 0; i < times.size(); ++i) {
    judged_times_.push_back(times[i]);
    if (i + 1 < times.size()) judged_times_.push_back(times[i] + (times[i + 1] - times[i]) / 2.0);
  }
}

void TradeRuns::tell(const std::string& what) {
  if (options_.tell) options_.tell(what);
}

TimedRun TradeRuns::simulate_within(const RunInputs& inputs, bool audit, bool look, double limit_seconds) {
  ++count_;
  TimedRun run;
  const double begin = thread_seconds();
  SimulateOptions how;
  how.energy_audit = audit;
  how.error_estimate = false;
  how.max_steps = options_.max_steps;
  how.progress = [&](double) {
    run.cut = thread_seconds() - begin > limit_seconds;
    ended_ = ended_ || (options_.goes_on && !options_.goes_on()) || out_of_time();
    return !run.cut && !ended_;
  };
  if (look && events_) how.events = [&run](const RunEvent& event) { run.events.take(event); };
  run.result = scene_.run(inputs, how);
  run.cpu_seconds = thread_seconds() - begin;
  return run;
}

TimedRun TradeRuns::run(const TradeSetting& setting, bool judged, double limit_seconds) {
  RunInputs inputs = with_setting(inputs_, setting);
  if (judged) inputs.output_times = judged_times_;
  return simulate_within(inputs, judged, judged, limit_seconds);
}

TimedRun TradeRuns::between(const TradeSetting& setting, double limit_seconds) {
  RunInputs inputs = with_setting(inputs_, setting);
  inputs.output_times = judged_times_;
  return simulate_within(inputs, false, true, limit_seconds);
}

TimedRun TradeRuns::exact(const TradeSetting& setting, double limit_seconds) {
  RunInputs inputs = with_setting(inputs_, setting);
  inputs.output_times = judged_times_;
  inputs.absolute.reset();
  inputs.absolute_by_state.clear();
  return simulate_within(inputs, false, true, limit_seconds);
}

double TradeRuns::median_seconds(const TradeSetting& setting, double limit_seconds, int& repeats, RunResult& first) {
  // Short runs are repeated more often: their times scatter more, and cost less.
  constexpr double kEnough = 0.05;
  constexpr std::size_t kLeast = 3, kMost = 15;
  std::vector<double> seconds;
  double total = 0.0;
  while (seconds.size() < kLeast || (total < kEnough && seconds.size() < kMost)) {
    TimedRun run = plain(setting, limit_seconds);
    if (ended_) break;
    seconds.push_back(run.cpu_seconds);
    total += run.cpu_seconds;
    if (seconds.size() == 1) first = std::move(run.result);
  }
  repeats = static_cast<int>(seconds.size());
  if (seconds.empty()) return 0.0;
  const auto middle = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
  std::nth_element(seconds.begin(), middle, seconds.end());
  return *middle;
}

Judgement judge(const TradeCourse& run, const ReferenceTrace& reference) {
  const Trace& trace = run.trace;
  const std::size_t columns = trace.columns.size();
  Judgement judgement;
  judgement.errors.resize(reference.outputs.size());
  EventDistance instants;
  if (columns < reference.outputs.size()) {
    const double range = reference.outputs.back().range;
    instants = event_distance(reference.events, run.events, range);
    if (reference.outputs.back().judged()) {
      judgement.max_error = judgement.rms_error = instants.largest / range;
      judgement.errors.back() = {judgement.max_error, judgement.rms_error};
    }
  } else if (!run.events.all().empty()) {
    judgement.max_error = judgement.rms_error = 1.0;  // the reference has no events
  }
  const std::size_t rows = std::min(trace.times.size(), reference.trace.times.size());
  const std::size_t outputs_rows = (rows + 1) / 2;
  for (std::size_t c = 0; c < columns; ++c) {
    if (!reference.outputs[c].judged()) continue;
    ErrorOfOutput& error = judgement.errors[c];
    double root = 0.0;
    for (std::size_t row = 0; row < rows; ++row) {
      if (instants.parted(trace.times[row])) continue;
      const double difference =
          std::abs(trace.columns[c][row] - reference.trace.columns[c][row]) / reference.outputs[c].range;
      if (row % 2 == 1) {
        judgement.check_error = std::max(judgement.check_error, difference);
        continue;
      }
      error.max = std::max(error.max, difference);
      // An unstable method gives errors whose squares are beyond the range of double precision.
      root = std::hypot(root, difference);
    }
    error.rms = root / std::sqrt(static_cast<double>(std::max<std::size_t>(outputs_rows, 1)));
    judgement.max_error = std::max(judgement.max_error, error.max);
    judgement.rms_error = std::max(judgement.rms_error, error.rms);
  }
  // The reference itself, run again: what is known of its error is the reference's own.
  if (judgement.max_error == 0.0) judgement.max_error = judgement.rms_error = reference.facts.error;
  return judgement;
}

}  // namespace bgsim
