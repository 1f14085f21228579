/// Expressions with kinks that rise, or fall, over all numbers: cut into smooth parts, and inverted part by part.
#pragma once

#include <functional>
#include <optional>

#include "bgsim/expression.hpp"

namespace bgsim {

/// The value of a symbol; NaN if it varies.
using NumberOf = std::function<double(SymbolId)>;

/// What is known of the solution of y = expression(x) for x.
struct PieceInverse {
  /// The expression is continuous and strictly monotone in x, so that there is at most one solution. By proof with the
  /// given numbers. Where it contains what varies: there are values of these with which it is.
  bool monotone = false;
  ExprId solution;  ///< x by y; none if a part has no closed form, or contains what varies
};

/// Cuts @p expression where a comparison, sign, step, abs, min or max changes with @p x, proves that the parts are
/// monotone in the same direction and meet, and inverts each. New expressions go to @p pool.
/// @note The solution compares y with the values at the cuts: it holds for other numbers only if the parts come in the
///       same order there, and are monotone in the same direction.
PieceInverse invert_in_pieces(ExprPool& pool, ExprId expression, SymbolId x, ExprId y, const NumberOf& number);

}  // namespace bgsim
