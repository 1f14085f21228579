/// What guards are shortly after an instant: power series of the time that passes, along the solution.
#pragma once

#include <span>
#include <vector>

#include "base/power_series.hpp"
#include "bgsim/evaluator.hpp"

namespace bgsim {

struct GuardAtBorder {
  std::size_t position = 0;  ///< in Program::guarded
  double border = 0.0;       ///< is taken off the guard
};

/// Series of guards in the time after (t, x), on a branch: the states' own series follow from the equations, term by
/// term, and the guards' from these. A guard whose value is exactly 0 is given by its first coefficient that is beyond
/// its rounding; no step of a method is exact enough to tell its sign there.
/// @param guards  whose series are asked for.
/// @return by @p guards; a series that is zero is not known beyond its `known`. Loops are solved term by term.
/// @note Costs some ten to some hundred evaluations of the rates, of what the guards depend on.
std::vector<PowerSeries> guard_series(const Program& program, std::span<const double> constants, double t,
                                      const double* x, const Branch& branch, std::span<const GuardAtBorder> guards);

}  // namespace bgsim
