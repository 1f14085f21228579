/// An output along a run that is kept whole.
#pragma once

#include <vector>

#include "bgsim/simulate.hpp"
#include "run/sink/trajectory.hpp"

namespace bgsim {

/// Values and slopes by time of an output, by time.
struct OutputsAlong {
  std::vector<double> values, slopes;
  std::optional<Diagnostic> failure;
};

/// @param program     with a TransposedPlan
/// @param trajectory  of a completed run of it with @p inputs
/// @param times       within it; at an instant of events, behind these
OutputsAlong output_along(const Program& program, const RunInputs& inputs, const Trajectory& trajectory,
                          std::size_t output, const std::vector<double>& times);

}  // namespace bgsim
