/// Why no sides of diodes and contacts were found (BG622), and what contacts cannot be (BG625, BG626).
#pragma once

#include <vector>

#include "bgsim/diagnostic.hpp"
#include "run/diodes.hpp"

namespace bgsim {

/// Nothing determines the speed of a contact that is free: one in series with another, without a mass between them.
Diagnostic free_contact_failure(const DiodeNetwork& network, std::size_t contact, double t);

/// @param unbounded  the diodes and contacts for which no side is possible
Diagnostic no_sides_failure(const DiodeNetwork& network, const std::vector<std::size_t>& unbounded, double t);

/// A contact begins, or has come, beyond its @p gap.
Diagnostic beyond_gap_failure(const DiodeNetwork& network, std::size_t contact, double t, double q, double gap);

Diagnostic restitution_failure(const DiodeNetwork& network, std::size_t contact, double t, double restitution);

}  // namespace bgsim
