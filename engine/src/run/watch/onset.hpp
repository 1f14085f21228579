/// States that were at rest at zero, without a tolerance, and begin to move.
#pragma once

#include <vector>

#include "run/tolerances.hpp"

namespace bgsim {

/// A state that is 0 and that nothing is known to move has no scale, so the error test takes no notice of it: the step
/// in which it begins to move may be wrong by any amount. A thousandth of what it moves becomes its first scale. Needed
/// by: a pulse that a state opens, whose first step ends just inside it ("narrow smooth laws of states").
/// @param begin  states at the beginning of a step in which no condition changes.
/// @param end    at its end.
/// @return       whether there is such a state; then the step is to be made again.
bool take_first_scales(const std::vector<double>& begin, const double* end, Tolerances& tolerances);

}  // namespace bgsim
