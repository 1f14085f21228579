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

/// The pulses of all smooth sources of a program: bells, ramps, bursts that fill half of the scene at most,
/// however narrow they are. Interval arithmetic proves the sources still (to a thousandth of their range) everywhere
/// else, unless there are more pulses than some hundreds. Jumps are not among them: they are known times of their own.
/// @param parameters  by ParameterId.
/// @note At most 4096 interval evaluations a source, 64 for one that never rests.
std::vector<Pulse> find_pulses(const Program& program, std::span<const double> parameters, double start, double stop);

/// About how many times in a unit of time the fastest source goes up and down, 0 if all are slower than the scene.
double source_frequency(const Program& program, std::span<const double> parameters, double start, double stop);

}  // namespace bgsim
