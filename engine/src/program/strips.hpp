/// Instructions as loops.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// @param depths  by instruction, not falling: none depends on another of its depth. Empty: nothing is known.
std::vector<Strip> strips_of(std::span<const Instruction> code, std::span<const std::uint32_t> depths);

}  // namespace bgsim
