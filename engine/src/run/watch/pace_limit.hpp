/// Whether a run comes to its end in the time that a person waits.
#pragma once

#include <optional>
#include <vector>

#include "bgsim/simulate.hpp"
#include "run/integrate/integrator.hpp"
#include "run/watch/headway.hpp"
#include "run/watch/pace_words.hpp"

namespace bgsim {

/// Where a run is, between two steps.
struct RunPosition {
  double seconds = 0.0;  ///< of wall time since the start
  double t = 0.0;
  const double* x = nullptr;  ///< states
  const Branch* branch = nullptr;
  std::uint64_t steps = 0, rows = 0, events = 0, jumps = 0;
  double jumped_at = 0.0;               ///< the start, or where a condition or a known time last changed something
  std::optional<double> next_known;     ///< time at which something will
  std::optional<std::size_t> relation;  ///< that changed last
  Integrator* integrator = nullptr;     ///< none without states
  bool explicit_form = true;            ///< the Jacobian of the states can be had
};

/// Says once that the end is out of sight, and when it is so far away that the run is of no use
/// (docs/design/simulate.md has the rule).
class PaceLimit {
 public:
  /// @param longest_step  set by the source with @p source_frequency; 0: no source limits the steps
  PaceLimit(const Program& program, Evaluator& evaluator, const RunInputs& inputs, const SimulateOptions& options);
  void know_sources(double longest_step, double frequency) {
    longest_step_ = longest_step;
    source_frequency_ = frequency;
  }

  /// Why the run is given up; none if it goes on. To be called after each look at the clock.
  std::optional<Diagnostic> check(const RunPosition& now);

 private:
  [[nodiscard]] bool pace_may_change(const RunPosition& now, const Headway::Pace& pace);
  [[nodiscard]] PaceFacts facts(const RunPosition& now, const Headway::Pace& pace);

  const Program& program_;
  Evaluator& evaluator_;
  const RunInputs& inputs_;
  const SimulateOptions& options_;
  Headway headway_;
  RunPosition before_, last_;  ///< some seconds ago: what has been done since tells what the run is busy with
  double longest_step_ = 0.0, source_frequency_ = 0.0;
  double checked_at_ = 0.0;
  bool remarked_ = false;
};

}  // namespace bgsim
