/// Laws that are sums of powers on each side of 0, however they are written: f (K + |f|^0.75), by parts, with signs.
#pragma once

#include "bgsim/expression.hpp"
#include "expression/sides.hpp"

namespace bgsim {

/// The law of @p sides as a sum of c sign(x) |x|^p with p >= 1 beside what is free of x, which has a slope at x = 0, no
/// condition, and goes on beyond 0 as it came: `sign(x)*(K*abs(x) + x^2)` and `if(x > 0, x^1.75, -(-x)^1.75)` have not.
/// By parts with a condition on x where both sides differ. None where it is no such sum, jumps at 0, or is one already.
/// New expressions go to @p pool.
ExprId odd_power_sum(ExprPool& pool, ExprId law, const Sides& sides);

}  // namespace bgsim
