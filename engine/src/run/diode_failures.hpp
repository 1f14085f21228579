/// Why no sides of diodes and contacts were found (BG622).
#pragma once

#include <vector>

#include "bgsim/diagnostic.hpp"
#include "run/diodes.hpp"

namespace bgsim {

/// Nothing determines the speed of a contact that is free: one in series with another, without a mass between them.
Diagnostic free_contact_failure(const DiodeNetwork& network, std::size_t contact, double t);

/// @param unbounded  the diodes and contacts for which no side is possible
Diagnostic no_sides_failure(const DiodeNetwork& network, const std::vector<std::size_t>& unbounded, double t);

}  // namespace bgsim
