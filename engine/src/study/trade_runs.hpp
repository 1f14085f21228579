/// Single runs of the trade: timed, cut when they cost too much, and judged against a reference.
#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

#include "bgsim/trade.hpp"
#include "study/event_times.hpp"

namespace bgsim {

/// Processor time of this thread in seconds.
double thread_seconds();

/// A scene, and how it is run.
struct TradeScene {
  const Program& program;  ///< of a model with switches: of the mode in which the scene begins
  const RunInputs& inputs;
  std::function<RunResult(const RunInputs&, const SimulateOptions&)> run;
};
TradeScene trade_scene(const Simulation& scene);
/// @throws TradeFailure BG610 of a model with switches.
TradeScene trade_scene(const Program& program, const RunInputs& inputs);

struct TimedRun {
  RunResult result;
  EventTimes events;
  double cpu_seconds = 0.0;
  bool cut = false;  ///< by the limit
  [[nodiscard]] bool completed() const { return result.stop == StopReason::completed; }
};

/// The scene, run with one setting or another, on the output times or on these and the times midway between them.
class TradeRuns {
 public:
  TradeRuns(const TradeScene& scene, const TradeOptions& options);

  /// On output times and midway between them, with audit.
  TimedRun judge(const TradeSetting& setting, double limit_seconds) { return run(setting, true, limit_seconds); }
  /// As a user would run it, without audit, and without a look at events.
  TimedRun plain(const TradeSetting& setting, double limit_seconds) { return run(setting, false, limit_seconds); }
  /// On output times and midway between them, without audit.
  TimedRun between(const TradeSetting& setting, double limit_seconds);
  /// Median processor time of several plain runs; the first one's counts go to @p first.
  double median_seconds(const TradeSetting& setting, double limit_seconds, int& repeats, RunResult& first);

  /// Settings for the reference ignore absolute tolerances that the scene gives.
  TimedRun exact(const TradeSetting& setting, double limit_seconds);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const RunInputs& inputs() const { return inputs_; }
  [[nodiscard]] const Program& program() const { return scene_.program; }
  /// Whether the model has what happens at instants that a run finds.
  [[nodiscard]] bool events() const { return events_; }
  /// True if the user has ended the whole, or its time is over.
  [[nodiscard]] bool ended() const { return ended_; }
  [[nodiscard]] bool out_of_time() const {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin_;
    return options_.time_limit > 0.0 && passed.count() >= options_.time_limit;
  }
  /// Tells the user what comes next.
  void tell(const std::string& what);

 private:
  TimedRun run(const TradeSetting& setting, bool judged, double limit_seconds);
  TimedRun simulate_within(const RunInputs& inputs, bool audit, bool look, double limit_seconds);

  TradeScene scene_;
  RunInputs inputs_;
  bool events_;
  std::vector<double> judged_times_;
  const TradeOptions& options_;
  std::size_t count_ = 0;
  bool ended_ = false;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// The reference's trace at output times (even rows) and midway between them (odd rows), and what is known of it.
struct ReferenceTrace {
  Trace trace;
  EventTimes events;
  TradeReference facts;
  std::vector<TradeOutput> outputs;
};

/// Finds a reference: several methods at @p relative and, if their agreement is above @p wanted, tighter ones.
/// @throws TradeFailure BG611.
ReferenceTrace find_reference(TradeRuns& runs, double relative, double wanted, double budget);

/// At this tolerance and below, an output that is not above the noise is taken for zero. At a looser one it may as well
/// be an output that the runs are far from.
inline constexpr double kTellsZero = 1.1e-11;

/// By output: a run to its end gave zero at all times. Methods that keep a symmetry exactly prove it so.
using Zeros = std::vector<bool>;
void mark_zeros(const Trace& trace, Zeros& zeros);

/// What two runs are compared by.
struct TradeCourse {
  const Trace& trace;
  const EventTimes& events;
};

/// What is known of the outputs from two tight runs, and of the instants of events; returns the largest relative
/// difference.
double compare(const TradeCourse& first, const TradeCourse& other, const Zeros& zeros,
               std::vector<TradeOutput>& outputs);

/// @throws TradeFailure BG611 where there is nothing to run or to judge.
void require_measurable(const TradeRuns& runs);

struct Judgement {
  std::vector<ErrorOfOutput> errors;
  double max_error = 0.0, rms_error = 0.0, check_error = 0.0;
  [[nodiscard]] double largest() const { return std::max(max_error, check_error); }
};
/// Errors of a judged run relative to the outputs' ranges.
Judgement judge(const TradeCourse& run, const ReferenceTrace& reference);

/// Largest magnitude of the Jacobian's eigenvalues at the start; 0 where it is not known (or for more than 200 states),
/// or where a model has modes.
double fastest_rate(const Program& program, const RunInputs& inputs);

}  // namespace bgsim
