/// The wall time of a run: when the caller is asked whether it goes on, and when its time is over.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "bgsim/simulate.hpp"

namespace bgsim {

/// Seconds from any origin.
using Clock = std::function<double()>;

double wall_seconds();

/// simulate() by another clock than the wall's: so tests of limits of time do not depend on the machine's speed.
RunResult simulate(const Program& program, const RunInputs& inputs, const SimulateOptions& options, Clock clock);

class RunClock {
 public:
  enum class End : std::uint8_t { none, interrupted, time_over };

  RunClock(const SimulateOptions& options, Clock clock, double start);

  /// Looks at the clock, and asks the caller. For Evaluator::watch: the number of evaluations until the next look, so
  /// chosen that these are some hundredths of a second apart whatever an evaluation costs; 0, which makes all
  /// evaluations fail, when the run should have ended a while ago and is still within one step.
  std::uint64_t look();
  /// The run has come to @p t by another step or row.
  void reach(double t);

  /// Whether the run is to end here. Between steps and rows, where everything is in good order.
  [[nodiscard]] End end() const { return end_; }
  /// Seconds since the start, as of the last look.
  [[nodiscard]] double seconds() const { return now_ - begin_; }
  /// Whether there was a look since this was last asked.
  bool looked() { return std::exchange(looked_, false); }

 private:
  void ask();

  const SimulateOptions& options_;
  Clock clock_;
  double begin_, now_;
  double t_;  ///< reached
  double ended_at_ = 0.0;
  End end_ = End::none;
  std::uint64_t between_looks_ = 1;
  unsigned reached_ = 0;
  bool looked_ = false;
};

}  // namespace bgsim
