/// Roots that keep the sign of a difference between stores, written without a condition on that sign.
#pragma once

#include <optional>

#include "bgsim/ordering.hpp"

namespace bgsim {

/// The system with c sign(x) |x|^n, 1/3 <= n < 1, as c cbrt(x |x|^(3n-1)), from n = 1/5 on as a cubic root of a cubic
/// root, however it is written (`if`, `max`), where x follows more than one state: the flow of an orifice between two
/// tanks. Both are the same numbers; but the sign is a condition, and where levels are equal, in a chain of tanks that
/// are all empty, those of all orifices are at their borders at once. One that follows a single state keeps the sign,
/// and no other condition: its border is where a tank that runs empty rests.
/// @return  none where there is no such root
/// @note    Time linear in the pool, and in what is below each root.
std::optional<BlockOrder> with_signless_roots(const EquationSystem& system, const BlockOrder& order);

}  // namespace bgsim
