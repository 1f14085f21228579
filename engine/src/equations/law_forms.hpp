/// The form of a law in which a loop through it is solved.
#pragma once

#include "bgsim/expression.hpp"

namespace bgsim {

/// An expression that is zero where the law holds.
struct LawForm {
  ExprId zero;          ///< invalid: what defines the unknown serves as well
  bool always = false;  ///< to be solved in this form even where nothing else makes a loop of it
};

/// Of a law `left = right` that was inverted: @p unknown = @p solution. New expressions go to @p pool.
LawForm form_of_inverted(ExprPool& pool, ExprId left, ExprId right, SymbolId unknown, ExprId solution);

/// Of a law `left = right` that defines its left side as it is written; @p other is the variable on the right.
LawForm form_of_written(ExprPool& pool, ExprId left, ExprId right, SymbolId other);

}  // namespace bgsim
