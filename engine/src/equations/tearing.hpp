/// Tearing: a small set of unknowns that cuts every cycle of an algebraic loop.
#pragma once

#include <cstdint>
#include <vector>

namespace bgsim {

/// The dependence among the unknowns of one loop.
struct LoopGraph {
  std::vector<std::vector<std::uint32_t>> depends_on;  ///< by member
  std::vector<bool> must_tear;                         ///< unknowns of implicit equations
};

struct Tearing {
  std::vector<std::uint32_t> tears;     ///< increasing
  std::vector<std::uint32_t> sequence;  ///< the others, each after those it depends on
};

/// Cuts the loop. Loops of up to a few hundred members are torn greedily, the member with the most paths through it
/// first; larger ones at the targets of a depth-first search's back arcs, in linear time.
/// @note Finding the fewest tears is NP-complete; the result is a small set, not the smallest.
Tearing tear(const LoopGraph& loop);

/// True if every row can be given a column of its own out of its pattern (structural rank is full).
bool has_full_matching(const std::vector<std::vector<std::uint32_t>>& pattern);

}  // namespace bgsim
