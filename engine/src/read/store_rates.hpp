/// Laws of stores that contain the rate of what is stored: these dissipate, whatever they are called.
#pragma once

#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// BG117 for each C or CC whose law, capacitance or energy depends on its own flow, and each I or II that depends on
/// its own effort: named so, or as der(q), or as another variable that is the same but for its sign or a factor (the
/// flow of its 1-junction, of a bond, of a resistor in series), also through signals.
/// @param model  as read; bonds' ends are known.
std::vector<Diagnostic> store_rate_faults(const Model& model);

}  // namespace bgsim
