/// The run of a model with ideal switches: runs of plain programs, one after the other.
#pragma once

#include <functional>

#include "bgsim/modes.hpp"
#include "bgsim/simulate.hpp"
#include "run/clock.hpp"
#include "run/diodes.hpp"
#include "run/watch/delay_lines.hpp"

namespace bgsim {

/// The program of a mode; the same object whenever the same mode is asked for.
/// @param settling  by switch: a closed contact that comes to rest at its parameter ContactLaw::rest; empty: none
/// @throws ModelError where the graph does not allow the mode.
using ProgramOfMode = std::function<const Program&(const Mode&, const Mode& settling)>;

/// What the diodes see of the rest in a mode of the other switches.
/// @throws ModelError where the graph does not allow it.
using NetworkOfMode = std::function<const DiodeNetwork&(const Mode&)>;

/// For the jump of an impact, with the mode that it leads to.
/// @throws ModelError where the graph does not allow it.
using ImpactOfMode = std::function<const ImpactProgram&(const Mode&)>;

/// What the programs of a switched run with variations have in common: how its start moves with what is varied.
struct SwitchedVariation {
  std::vector<double> parameters;                      ///< by ParameterId: slopes
  std::function<std::optional<Stored>(double)> start;  ///< what stores hold there, moved by so much; none: no value
  double size = 0.0;                                   ///< magnitude of what is varied
};

/// What a switched run takes its programs from.
struct SwitchedPrograms {
  ProgramOfMode program_of;
  NetworkOfMode network_of;                      ///< asked for models with diodes or contacts only
  ImpactOfMode impact_of;                        ///< asked for models with contacts only
  DelayTables delayed = {};                      ///< those of all these programs
  const SwitchedVariation* variation = nullptr;  ///< of programs with variations
};

/// Name of the state of a mode in which nothing is stored: the time, so that the run looks for events.
inline constexpr const char* kModeClock = "(clock)";
inline bool has_only_clock(const Program& program) {
  const bool varied = program.varied_states == 1;  // with its derivative
  return program.state_names.size() == (varied ? 2 : 1) && program.state_names.front() == kModeClock;
}

/// Where a switched run begins.
struct SwitchedStart {
  Mode mode;
  std::vector<bool> diodes;  ///< by switch: it is a diode
  Stored stored;             ///< of every store and integral, before the first mode ties any of them to each other
  std::optional<Diagnostic> failure = {};  ///< BG622: the diodes have no sides
  DiodeSight sight = {};                   ///< of the network of the first mode
};

/// Runs a scene from mode to mode. Within a mode this is simulate() of that mode's program. Where a switch leaves its
/// side, what stores hold goes on to the program of the next mode, after a jump where that ties stores to each other
/// (see jump_into). At one instant this is repeated until no switch leaves its side. Diodes are then on the sides that
/// the circuit makes them (see diode_sides). Contacts that close take impulses, with their restitution. Where their
/// impacts accumulate, a contact stays closed; see came_to_gap().
///
/// Fails with BG604 where modes repeat within an instant or change without end, BG619 where the graph does not allow a
/// mode, BG620 and BG621 where a jump has no result or creates energy, BG622 where diodes have no sides that are
/// possible, BG625, BG626 and BG627 of contacts; else as simulate().
RunResult simulate_switched(const SwitchedPrograms& programs, const SwitchedStart& start, const RunInputs& inputs,
                            const SimulateOptions& options, const Clock& clock);

}  // namespace bgsim
