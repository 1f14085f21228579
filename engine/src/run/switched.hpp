/// The run of a model with ideal switches: runs of plain programs, one after the other.
#pragma once

#include <functional>

#include "bgsim/modes.hpp"
#include "bgsim/simulate.hpp"
#include "run/clock.hpp"
#include "run/diodes.hpp"

namespace bgsim {

/// The program of a mode; the same object whenever the same mode is asked for.
/// @throws ModelError where the graph does not allow the mode.
using ProgramOfMode = std::function<const Program&(const Mode&)>;

/// What the diodes see of the rest in a mode of the other switches.
/// @throws ModelError where the graph does not allow it.
using NetworkOfMode = std::function<const DiodeNetwork&(const Mode&)>;

/// Name of the state of a mode in which nothing is stored: the time, so that the run looks for events.
inline constexpr const char* kModeClock = "(clock)";

/// Where a switched run begins.
struct SwitchedStart {
  Mode mode;
  std::vector<bool> diodes;  ///< by switch: it is a diode
  Stored stored;             ///< of every store and integral, before the first mode ties any of them to each other
  std::optional<Diagnostic> failure = {};  ///< BG622: the diodes have no sides
};

/// Runs a scene from mode to mode. Within a mode this is simulate() of that mode's program. Where a switch leaves its
/// side, what stores hold goes on to the program of the next mode, after a jump where that ties stores to each other
/// (see jump_into). At one instant this is repeated until no switch leaves its side. Diodes are then on the sides that
/// the circuit makes them (see diode_sides).
///
/// Fails with BG604 where modes repeat within an instant or change without end, BG619 where the graph does not allow a
/// mode, BG620 and BG621 where a jump has no result or creates energy, BG622 where diodes have no sides that are
/// possible; else as simulate().
/// @param network_of  asked for models with diodes only
RunResult simulate_switched(const ProgramOfMode& program_of, const NetworkOfMode& network_of,
                            const SwitchedStart& start, const RunInputs& inputs, const SimulateOptions& options,
                            const Clock& clock);

}  // namespace bgsim
