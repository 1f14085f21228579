/// What a run knows of its contacts: their impacts so far, and where these have no end.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/diagnostic.hpp"
#include "bgsim/model.hpp"

namespace bgsim {

/// Of one contact.
struct ContactHistory {
  std::vector<double> times;  ///< the latest at which it came to its gap
  double longest = 0.0;       ///< interval between two of these
  double fastest = 0.0;       ///< closing speed
  double rebound = 0.0;       ///< the latest speed
  std::uint64_t impacts = 0;
};

/// Impacts whose intervals shrink in a steady ratio: infinitely many before one instant.
struct Accumulation {
  double ratio =
      0.0;  ///< of an interval to the one before; 0: the last flight was below what rounding leaves of its way
  double limit = 0.0;  ///< the time to which they add up
  /// The speeds fall as the intervals do. They need not where the way becomes shorter, too: of a light body between a
  /// heavy one that comes nearer and a wall.
  bool slows = true;
};

/// Notes that a contact has come to its gap at @p t. Where the intervals shrink in a steady ratio, the limit is before
/// @p stop and what is left is too short to be resolved, that series.
/// @param early  flights count as too short that are by this factor longer
std::optional<Accumulation> came_to_gap(ContactHistory& history, double t, double start, double stop, double early);

/// Whether the speeds of the contact have fallen as the last interval has, as those of a body under a force do.
bool slows_down(const ContactHistory& history);
/// The time at which a contact that has none now comes to the end of its series, if that is as good as @p limit.
bool ends_with(const ContactHistory& history, double limit);

/// A line for the report: the contact closes for good.
std::string accumulation_note(const Element& contact, const ContactHistory& history, const Accumulation& series);
/// BG627.
Diagnostic accumulation_failure(const Element& contact, const ContactHistory& history, const Accumulation& series);
/// A line for the report: several contacts have taken impulses in one instant.
std::string simultaneous_note(const std::vector<std::string>& contacts, double t);
/// A line for the report: impacts of one instant had no end.
std::string long_sequence_note(std::uint64_t impacts, double t);
/// BG621.
Diagnostic impact_failure(const std::vector<std::string>& contacts, double gained, double t);

}  // namespace bgsim
