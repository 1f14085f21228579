/// States whose rates have them as a factor: what is small now decides what is large later.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

inline constexpr std::uint32_t kNoGroup = std::numeric_limits<std::uint32_t>::max();

/// What may shrink and grow again in proportion to itself.
struct Proportional {
  /// By state: its rate is zero whenever it is zero, whatever the others are, and is not proved to shrink it for ever.
  std::vector<bool> alone;
  /// By state: states that depend on each other and whose rates are all zero when all of them are; kNoGroup: in none.
  std::vector<std::uint32_t> group;
  std::uint32_t groups = 0;
};

/// By the structure of the rates; a state that loops or tables lie between counts as in none. States and groups that
/// are linear with constant coefficients are left out: they shrink or grow by a law of their own, not now this and now
/// that.
/// @param start, stop  of the scene: what depends on time alone has the sign that it has between them.
/// @param slots  values of what depends on parameters alone (Evaluator::constants()).
/// @note Time and memory about linear in the instructions of the rates; for each state that is its own factor, as much
/// as
///       its rate takes.
Proportional proportional_states(const Program& program, std::span<const double> slots, double start, double stop);

}  // namespace bgsim
