/// Complementarity problems of many pairs, by bases that are solved from the start each time.
#pragma once

#include <optional>
#include <vector>

#include "run/complementarity.hpp"

namespace bgsim {

/// Looks for the sides of solve_complementarity() by changing all pairs at once that are on a wrong side, and again,
/// until none is. What it returns is a solution: each value is compared with a bound of its own rounding, which does
/// not grow from one basis to the next. Nothing where it finds none: there may still be one.
///
/// A basis B = B_0 + h B_1 + ... is solved order by order with one factorization of B_0, once its rows have been
/// divided by powers of h and combined such that B_0 is regular.
/// @param first, held  as for solve_complementarity()
/// @note A basis costs a factorization of doubles, by parts that do not hang together. Ended after 60 of them.
std::optional<ComplementarySides> solve_by_blocks(const Complementarity& problem, const std::vector<bool>& first,
                                                  const std::vector<bool>& held);

}  // namespace bgsim
