/// What outputs are wrong by where no estimate can follow the run across its events: a second run tells.
#pragma once

#include <functional>
#include <vector>

#include "bgsim/simulate.hpp"
#include "study/event_times.hpp"

namespace bgsim {

/// Whether what was carried along is more than the output varies by: to first order errors may grow without bound where
/// the equations do not let them (tanks at rest, whose orifices have no slope there).
/// @param relative  tolerance of the run
bool exceeds_range(const OutputErrors& errors, std::size_t output, double relative);

/// Keeps what a run is compared by while it goes on, then makes the second one: at a tenth of the tolerance, or with
/// half the step. What both differ by is the error of the first, to within that of the second.
class SecondRun {
 public:
  /// @param options  of the first run; they must outlive this.
  /// @param events   whether something can happen at instants that the runs find by themselves (EventTimes)
  SecondRun(const RunInputs& inputs, const SimulateOptions& options, bool events);

  /// How many numbers are kept of the first run.
  static double values_kept(const RunInputs& inputs);

  /// The first run's options, with sinks that also keep what it is compared by.
  [[nodiscard]] const SimulateOptions& options() const { return kept_options_; }

  using Runner = std::function<RunResult(const RunInputs&, const SimulateOptions&)>;
  /// Makes the second run and sets `errors` of the report of @p result, the first one. Not where the first was longer
  /// than a second run is worth, where it did not complete, or where it goes on from a snapshot: `why_not` says so.
  /// @param seconds  wall time of the first.
  void estimate(RunResult& result, double seconds, const Runner& run);

 private:
  void keep(double t, std::span<const double> row);
  void compare(RunResult& result, const Trace& second, const EventTimes& events, const std::string& words);

  const RunInputs& inputs_;
  const SimulateOptions& options_;
  SimulateOptions kept_options_;
  std::size_t every_ = 1, row_ = 0;  ///< of so many rows one is kept
  Trace kept_;
  std::vector<double> least_, most_;
  EventTimes events_;
};

}  // namespace bgsim
