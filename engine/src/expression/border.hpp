/// Signs, steps and comparisons, and the guards whose sides they tell apart.
#pragma once

#include "bgsim/expression.hpp"

namespace bgsim {

[[nodiscard]] bool is_border(Op op);

/// What a sign, step or comparison is of, and the side of it on which that is as written: -1 where it has the guard the
/// other way round.
struct Guard {
  ExprId at;
  int way = 1;
};

/// Of a node for which is_border() is true. Those of one difference, or of numbers times it, have one guard.
Guard guard_of(ExprPool& pool, const ExprNode& node);

/// A law where this guard has that sign: -1, 0 or 1.
ExprId on_side(ExprPool& pool, ExprId law, ExprId guard, int side);

/// Whether what a law is below and above its border is the same there, as far as that can be seen: a kink.
bool meet(ExprPool& pool, ExprId below, ExprId above, ExprId guard);

}  // namespace bgsim
