/// The form of a law in which a loop through it is solved: an expression that is zero where the law holds. Invalid:
/// what defines the unknown serves as well.
#pragma once

#include "bgsim/expression.hpp"

namespace bgsim {

/// Of a law `left = right` that was inverted: @p unknown = @p solution. New expressions go to @p pool.
ExprId form_of_inverted(ExprPool& pool, ExprId left, ExprId right, SymbolId unknown, ExprId solution);

/// Of a law `left = right` that defines its left side as it is written; @p other is the variable on the right.
ExprId form_of_written(ExprPool& pool, ExprId left, ExprId right, SymbolId other);

}  // namespace bgsim
