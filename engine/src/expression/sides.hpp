/// A law on each side of a border x = 0, where signs, sizes and comparisons of x are known.
#pragma once

#include <array>
#include <unordered_map>

#include "bgsim/expression.hpp"

namespace bgsim {

/// offset + sign factor |x|^power on one side of x = 0, where offset and factor are free of x, and sign is 1 or -1.
struct PowerTerm {
  ExprId offset;  ///< none: 0, as of all powers 0
  ExprId factor;  ///< none: it is something else
  double sign = 1.0;
  double power = 0.0;

  [[nodiscard]] bool known() const { return factor.valid(); }
  [[nodiscard]] bool is_power() const { return factor.valid() && !offset.valid(); }
};

struct Sides {
  SymbolId x;                         ///< what stands for x
  std::array<ExprId, 2> expressions;  ///< above and below 0
  ExprId at_zero;
  std::array<std::unordered_map<ExprId, PowerTerm>, 2> terms;  ///< of all their parts
  double power = 1.0;  ///< the least of a root that is taken of x; 1 if there is none
};

/// @p law with what is decided by the side of @p of = 0 left out, however it is written: sign, step, abs, min, max and
/// comparisons of it, of its negative, or of these times a number. New expressions go to @p pool.
/// @param x  stands for @p of; may be the symbol that @p of is.
Sides sides_of(ExprPool& pool, ExprId law, ExprId of, SymbolId x);

}  // namespace bgsim
