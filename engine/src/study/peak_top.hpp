/// The top of a peak: where a smooth output is flat. A run finds the time of its largest value to the root of its
/// tolerance alone, and the derivative by a parameter goes on changing there.
#pragma once

#include <functional>
#include <vector>

#include "bgsim/simulate.hpp"
#include "study/sensitivity_parts.hpp"

namespace bgsim {

/// An output at one time, behind what happens then.
struct PeakRow {
  double t = 0.0, value = 0.0, slope = 0.0;
};

/// @p t and times around it, ever closer, within the run; in order.
std::vector<double> times_around(double t, const RunInputs& inputs);

/// Between two rows, or at the first of these.
struct PeakTop {
  std::size_t row = 0;
  double share = 0.0;  ///< of the way to the next row
  double time = 0.0;
};

/// The top near the time of @p peak, where the slope is 0. At a run's ends it may be where the output is not flat.
/// @param name      of the output
/// @param instants  of the run's events: an output is smooth between these
/// @param rows_at   rows at times_around() a time
/// @throws ModelError BG414 a corner: there is an event at the peak, and on no side of it the output is flat and as
///         large.
PeakTop top_of(const Model& model, const RunInputs& inputs, const std::string& name, const Peak& peak,
               const std::vector<double>& instants, const std::function<std::vector<PeakRow>(double)>& rows_at);

}  // namespace bgsim
