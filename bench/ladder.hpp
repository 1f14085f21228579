/// Generated models for timing.
#pragma once

#include <cstddef>
#include <string>

namespace bgsim::bench {

/// An RC ladder: a source, then @p sections of a 1-junction with a resistor and a 0-junction with a capacitor. Four
/// elements a section, one state each, no loops: what a long line, a bar in heat conduction or a chain of tanks looks
/// like. One scene of @p samples times up to one time constant of a section.
std::string ladder_json(std::size_t sections, std::size_t samples);

}  // namespace bgsim::bench
