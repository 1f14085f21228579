/// Undoing one operator after the other.
#pragma once

#include <functional>
#include <optional>

#include "bgsim/expression.hpp"

namespace bgsim {

/// u with op(u) = y, for an operator of one argument that maps its whole real domain one to one; else none.
ExprId undone(ExprPool& pool, Op op, ExprId y);
/// u with op(u, other) = y (@p x_first) or op(other, u) = y; none if it does not exist for all numbers.
ExprId undone(ExprPool& pool, Op op, ExprId other, bool x_first, ExprId y);

/// What solves y = part for x where no operator can be undone any more.
using InvertRest = std::function<std::optional<ExprId>(ExprId part, ExprId y)>;
/// As invert(); where the chain of invertible operators ends, @p rest is asked, if there is one.
std::optional<ExprId> invert(ExprPool& pool, ExprId expression, SymbolId x, ExprId y, const InvertRest& rest);

}  // namespace bgsim
