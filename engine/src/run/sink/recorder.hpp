/// The rows of the trace.
#pragma once

#include <array>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"
#include "run/clock.hpp"
#include "run/integrate/integrator.hpp"
#include "run/sink/global_error.hpp"
#include "run/watch/events.hpp"

namespace bgsim {

/// Evaluates the outputs at the output times: on the dense output within a step, on the run's own point at its end.
/// With a branch of its own, so that the number of rows changes nothing in the run.
class Recorder {
 public:
  Recorder(const Program& program, Evaluator& evaluator, EventWatch& events, GlobalError& errors, RunClock& clock,
           const RunInputs& inputs, const SimulateOptions& options, RunResult& result);

  enum class Outcome { recorded, fault, ended };
  /// All rows before @p t, within the integrator's last step.
  Outcome before(double t, Integrator& integrator);
  /// All rows up to @p t, where the run is.
  Outcome at(double t, const std::vector<double>& x, const Branch& branch);
  [[nodiscard]] double seconds() const { return seconds_; }

  /// The rows themselves are not carried: a run that goes on records those that follow.
  template <class Archive>
  void carry(Archive& archive) {
    archive("recorded", recorded_);
    archive("last row", last_row_);
    next_ = recorded_ > 0 ? inputs_.output_times.first_after(last_row_) : 0;
  }

 private:
  [[nodiscard]] bool due(double t, bool inclusive) const {
    return next_ < inputs_.output_times.size() &&
           (inclusive ? inputs_.output_times[next_] <= t : inputs_.output_times[next_] < t);
  }
  Outcome record_some(double t, Integrator& integrator);
  Outcome record(double t, const double* y, std::vector<double>& row);
  Outcome keep(double t, const double* y, const std::vector<double>& row);

  Evaluator& evaluator_;
  EventWatch& events_;
  GlobalError& errors_;
  RunClock& clock_;
  const RunInputs& inputs_;
  const SimulateOptions& options_;
  RunResult& result_;
  std::size_t next_ = 0;        ///< output time
  std::uint64_t recorded_ = 0;  ///< rows, before a snapshot included
  double last_row_ = 0.0;
  Branch branch_;
  std::array<std::vector<double>, Evaluator::Points::kMost> y_, row_;
  double seconds_ = 0.0;
};

}  // namespace bgsim
