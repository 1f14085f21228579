/// What a run has to say beyond its numbers, for RunReport::notes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/simulate.hpp"
#include "run/integrate/spectrum.hpp"
#include "run/tolerances.hpp"

namespace bgsim {

/// States that never rose above the absolute tolerance given for them.
std::optional<std::string> quiet_states_note(const Tolerances& tolerances, const std::vector<std::string>& names);

/// A source that goes up and down within a step was sampled here and there, not followed.
/// @param frequency  of the fastest source; @param span  of the scene, in which @p steps were made.
std::optional<std::string> fast_sources_note(double frequency, double span, std::uint64_t steps);

/// Outputs of forces that several frictions at rest share in any way. @param outputs  positions in @p names
std::optional<std::string> indefinite_shares_note(const std::vector<std::size_t>& outputs,
                                                  const std::vector<std::string>& names);
/// The energy balance is off by more than the tolerance explains.
std::optional<std::string> open_balance_note(const EnergyAudit& energy, double relative);

std::string lost_errors_note(const std::string& why);

/// Outputs whose estimated error is not small compared with their range.
std::optional<std::string> output_errors_note(const OutputErrors& errors, const std::vector<std::string>& names,
                                              double relative);

/// Outputs whose errors to first order come to more than they vary by, where a second run does not show such errors.
std::optional<std::string> beyond_first_order_note(const OutputErrors& errors, const std::vector<std::string>& names);

/// A relation of time alone whose changes could not all be found.
/// @param since  from when on.
std::string undecided_note(const Relation& relation, double since);

/// A law that divides by a state which is negative at the start: a volume or a distance had better not be.
std::optional<std::string> negative_start_note(const Program& program, const std::vector<double>& x);

/// Why BDF was limited to low orders.
std::string spent_mode_words(const SpentMode& mode);

/// A condition of which no proof was found that it did not change within a step.
std::string unproven_note(const Relation& relation, double time);

/// What an event, or a sample, sets a state to is as near to a border of its law as the run is wrong.
std::string doubtful_set_note(const std::string& state, double time);

/// A condition that comes as near to its border as the run is wrong.
std::string near_miss_note(const Relation& relation, double time);
/// A step that its rates do not add up to, however short it was made.
std::string unseen_law_note(const std::string& state, double time);
/// A delayed signal whose record is less accurate than the tolerance.
std::string coarse_delay_note(const std::string& signal, double time);

}  // namespace bgsim
