/// How fast sources vary: what an adaptive step could pass over without seeing it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// A stretch of time on which a source moves that is still before and behind.
struct Pulse {
  double begin, end;
};

/// A pulse that lasts no longer than a hundred thousand neighbouring doubles, or a thousand between two jumps: no
/// integrator can follow it.
struct NarrowPulse {
  ExprId source;
  Pulse when;
  double wide_enough;  ///< in time
};

/// What an integrator is to mind of the sources of a scene.
struct SourcePlan {
  std::optional<NarrowPulse> too_narrow;  ///< the first one; a run would pass over it, or get it wrong
  /// Of all smooth sources: bells, ramps, bursts that fill half of the scene at most, however narrow they are. Interval
  /// arithmetic proves the sources still (to a thousandth of their range) everywhere else, unless there are more pulses
  /// than some hundreds. Jumps are not among them: they are known times of their own. Nor are flanks as narrow as
  /// NarrowPulse, which are as good as jumps.
  std::vector<Pulse> pulses;
  /// Times within the scene, in order, that no step may pass: pulses' ends and the eighths between, and when their
  /// flank has died away.
  std::vector<double> edges;
  /// About how many times in a unit of time the fastest source goes up and down; 0 if all are slower than the scene.
  double frequency = 0.0;
  /// No longer step may be made, so that it cannot pass over the part of a period in which something happens; 0: any. A
  /// source that would take more than a million steps that way is sampled, and a note says so.
  double longest_step = 0.0;

  [[nodiscard]] std::optional<double> next_edge(double t) const;
};

/// The place of the one coefficient that follows time, or of the one element whose laws do; none if there are several.
std::optional<Place> only_element_of_time(const Model& model);

/// A source is followed by steps of no more than so many of its periods.
inline constexpr double kFollowedPeriods = 0.2;

/// @param parameters  by ParameterId.
/// @note At most some 9000 interval evaluations a source, some hundred for one that never rests.
SourcePlan plan_sources(const Program& program, std::span<const double> parameters, double start, double stop);

}  // namespace bgsim
