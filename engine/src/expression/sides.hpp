/// A law on each side of a border x = 0, where signs, sizes and comparisons of x are known.
#pragma once

#include <array>
#include <unordered_map>
#include <vector>

#include "bgsim/expression.hpp"

namespace bgsim {

/// A power: a number, or times an expression that is free of x more than that.
struct Degree {
  double number = 0.0, times = 0.0;
  ExprId of;  ///< none: a number

  [[nodiscard]] bool is_number() const { return !of.valid(); }
  [[nodiscard]] bool is(double value) const { return is_number() && number == value; }
  bool operator==(const Degree&) const = default;
};

/// @p degree as an expression.
ExprId expression_of(ExprPool& pool, const Degree& degree);

/// offset + sign factor |x|^power on one side of x = 0, where offset and factor are free of x, and sign is 1 or -1.
struct PowerTerm {
  ExprId offset;  ///< none: 0, as of all powers 0
  ExprId factor;  ///< none: it is something else
  double sign = 1.0;
  Degree power;

  [[nodiscard]] bool known() const { return factor.valid(); }
  [[nodiscard]] bool is_power() const { return factor.valid() && !offset.valid(); }
};

/// What is free of x with what is, powers of one degree with each other; none of others.
PowerTerm added(ExprPool& pool, const PowerTerm& a, const PowerTerm& b);
/// Product or quotient: of powers, and of a sum with what is free of x; none of others.
PowerTerm multiplied(ExprPool& pool, Op op, const PowerTerm& a, const PowerTerm& b);
PowerTerm negated(ExprPool& pool, PowerTerm a);

struct Sides {
  SymbolId x;                         ///< what stands for x
  std::array<ExprId, 2> expressions;  ///< above and below 0
  ExprId at_zero;
  std::array<std::unordered_map<ExprId, PowerTerm>, 2> terms;  ///< of all their parts
  std::vector<ExprId> above_zero;  ///< exponents n that are no numbers and hold only above 0: of 0^n, which is 0 then
  /// The least of the roots that are taken of x. None: no root is taken.
  ExprId power;
  /// Where it is one, if it is one power that is no number and may be anything; none: it is at most 1 whatever it is
  /// of.
  ExprId is_root;
};

/// @p law with what is decided by the side of @p of = 0 left out, however it is written: sign, step, abs, min, max and
/// comparisons of it, of its negative, or of these times a number. New expressions go to @p pool.
/// At x = 0 a power that is no number is taken for one above 0.
/// @param x  stands for @p of; may be the symbol that @p of is.
Sides sides_of(ExprPool& pool, ExprId law, ExprId of, SymbolId x);

}  // namespace bgsim
