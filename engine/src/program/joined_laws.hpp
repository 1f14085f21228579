/// Laws whose two sides meet at a border, written without a condition.
#pragma once

#include <optional>

#include "bgsim/ordering.hpp"

namespace bgsim {

/// The system with laws by sides of x = 0, however they are written (`sign`, `step`, `if`, `abs`), in one expression
/// where both sides meet: where they go on with one slope, and, if x follows more than one state (what flows between
/// two tanks), where one of them ends, or where there are many such laws and x follows no unknown of a loop. A
/// condition would be at its border wherever levels are equal; in a chain of tanks that are all empty, those of all
/// laws are at once.
///
/// c sign(x) |x|^n becomes c x |x|^(n-1) for n >= 1, c cbrt(x |x|^(3n-1)) for 1/3 <= n < 1, and from n = 1/5 on a cubic
/// root of a cubic root; all others become above(max(x, 0)) + below(min(x, 0)), less their value at 0: the same
/// numbers, but for roundings. A root of a single state keeps its sign, and no other condition: its border is where a
/// tank that runs empty rests.
/// @return  none where there is no such law
/// @note    Time linear in the pool, and in what is below each such law.
std::optional<BlockOrder> with_joined_laws(const EquationSystem& system, const BlockOrder& order);

}  // namespace bgsim
