/// Which ideal diodes conduct, found by trying.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "bgsim/simulate.hpp"
#include "run/switched.hpp"

namespace bgsim {

struct TriedSides {
  std::vector<bool> conducts;                    ///< by diode
  std::vector<double> flow_error, effort_error;  ///< by diode: what the resolution of states and time makes of them
};

/// The sides of all diodes an instant after stored.t, for laws that have no slope there (an orifice at rest,
/// f = k*sqrt(e) at 0), where diode_sides() has no linear problem to solve, or of those that it cannot decide. Each
/// mode of the diodes is entered, with its jump, and followed over small times, ever longer ones: of all modes the one
/// in which no flow and no effort goes beyond its border for longest, and of equal ones that nearest to the present
/// sides. The nearest come first, so a mode that holds for all of these times and loses no energy ends the search.
///
/// Cost: at most 256 modes, each derived once; ten steps of two evaluations in each, and as many as it has states to
/// know what rounding makes of the borders, where something is beyond one.
/// @param mode        of all switches; that of the diodes is the present one
/// @param is_diode    by switch
/// @param before      by diode: those that may not begin to conduct stay as they are
/// @param free        by diode: those that are tried on both sides; the others stay as they are
/// @param resolution  of a state: by how much it may be off
/// @param at_border   laws that are at their borders, and may be held there
/// @return  none if no mode is possible at all
std::optional<TriedSides> tried_sides(const ProgramOfMode& program_of, const Mode& mode,
                                      const std::vector<bool>& is_diode, const std::vector<DiodeState>& before,
                                      const std::vector<bool>& free, const RunInputs& inputs, const Stored& stored,
                                      const std::function<double(const StateInfo&)>& resolution,
                                      const std::vector<AtBorder>& at_border);

}  // namespace bgsim
