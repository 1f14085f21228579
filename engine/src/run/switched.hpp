/// The run of a model with ideal switches: runs of plain programs, one after the other.
#pragma once

#include <functional>

#include "bgsim/modes.hpp"
#include "bgsim/simulate.hpp"
#include "run/clock.hpp"

namespace bgsim {

/// The program of a mode; the same object whenever the same mode is asked for.
/// @throws ModelError where the graph does not allow the mode.
using ProgramOfMode = std::function<const Program&(const Mode&)>;

/// Name of the state of a mode in which nothing is stored: the time, so that the run looks for events.
inline constexpr const char* kModeClock = "(clock)";

/// Where a switched run begins.
struct SwitchedStart {
  Mode mode;
  Stored stored;  ///< of every store and integral, before the first mode ties any of them to each other
};

/// Runs a scene from mode to mode. Within a mode this is simulate() of that mode's program. Where a switch leaves its
/// side, what stores hold goes on to the program of the next mode, after a jump where that ties stores to each other
/// (see jump_into). At one instant this is repeated until no switch leaves its side.
///
/// Fails with BG604 where modes repeat within an instant or change without end, BG619 where the graph does not allow a
/// mode, BG620 and BG621 where a jump has no result or creates energy; else as simulate().
RunResult simulate_switched(const ProgramOfMode& program_of, const SwitchedStart& start, const RunInputs& inputs,
                            const SimulateOptions& options, const Clock& clock);

}  // namespace bgsim
