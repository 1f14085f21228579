/// Tearing: a small set of unknowns that cuts every cycle of an algebraic loop.
#pragma once

#include <cstdint>
#include <vector>

namespace bgsim {

/// The dependence among the unknowns of one loop.
struct LoopGraph {
  std::vector<std::vector<std::uint32_t>> depends_on;  ///< by member
  std::vector<bool> must_tear;                         ///< unknowns of implicit equations
  /// By member: the only other one that it depends on, as a multiple of that; else the member itself. (May be empty
  /// where there are no rates.)
  std::vector<std::uint32_t> multiple_of;
  std::vector<std::uint32_t> rates;            ///< members that the rates of states are multiples of
  std::vector<std::uint32_t> dependent_rates;  ///< the same of dependent stores
  bool far_apart = true;  ///< by orders of magnitude, these stores; with the rate of one state that has no say
};

struct Tearing {
  std::vector<std::uint32_t> tears;     ///< increasing
  std::vector<std::uint32_t> sequence;  ///< the others, each after those it depends on
  bool by_rates = false;                ///< all rates are tears, which may be small differences of others
};

/// Cuts the loop. Loops of up to a few hundred members are torn greedily, the member with the most paths through it
/// first; larger ones at the targets of a depth-first search's back arcs, in linear time. Loops through the rates of
/// stores are then cut so that no digits are lost where these differ by orders of magnitude. As what is left of a force
/// once a large mass has taken its part, the rate of a small one that is tied to it would have lost as many digits as
/// the masses differ by. So where the loop has the rate of one state it is torn there. With several that are far apart,
/// the rates of all states and dependent stores become tears, so that each coefficient belongs to one of them; unless
/// these are too many to be solved within the right-hand side.
/// @note Finding the fewest tears is NP-complete; the result is a small set, not the smallest.
Tearing tear(const LoopGraph& loop);

/// True if every row can be given a column of its own out of its pattern (structural rank is full).
bool has_full_matching(const std::vector<std::vector<std::uint32_t>>& pattern);

}  // namespace bgsim
