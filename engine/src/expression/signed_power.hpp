/// Laws of turbulent flow: c x |x|^(n-1), however they are written.
#pragma once

#include <optional>

#include "bgsim/expression.hpp"
#include "expression/sides.hpp"

namespace bgsim {

/// factor * sign(x) * |x|^power, where the factor is free of x.
struct SignedPower {
  ExprId factor;
  Degree power;
};

/// @p expression as a signed power of @p x, if it is one with a power above 0, or one that is no number (where its
/// value is not above 0 the law has none at x = 0, or jumps there): `k*x*abs(x)`, `k*sign(x)*x^2`,
/// `sign(x)*sqrt(abs(x)/k)`, a sum of such of one degree, and each of these by parts:
/// `if(x > 0, k*sqrt(x), -k*sqrt(-x))`. New expressions go to @p pool.
std::optional<SignedPower> signed_power(ExprPool& pool, ExprId expression, SymbolId x);
/// The same of an expression @p of; @p x stands for it meanwhile.
std::optional<SignedPower> signed_power(ExprPool& pool, ExprId expression, ExprId of, SymbolId x);

/// What does not name x, and a signed power of it.
struct OffsetPower {
  ExprId offset;  ///< invalid: 0
  SignedPower power;
};

/// @p expression as a sum of what is free of @p x and of signed powers of @p x, all of one degree: the efforts of
/// orifices in series behind a source. New expressions go to @p pool.
std::optional<OffsetPower> offset_power(ExprPool& pool, ExprId expression, SymbolId x);

/// u with sign(u) |u|^power = y, for power > 0: defined everywhere, 0 at 0.
ExprId odd_root(ExprPool& pool, ExprId y, double power);
ExprId odd_root(ExprPool& pool, ExprId y, ExprId power);

/// x where y = offset + factor * sign(x) * |x|^power: not where the factor is 0.
ExprId solution_of(ExprPool& pool, const OffsetPower& law, ExprId y);

/// sign(u) * |u|^power for power >= 1, as u |u|^(power-1): no condition, and a slope at 0.
ExprId odd_power(ExprPool& pool, ExprId u, double power);
ExprId odd_power(ExprPool& pool, ExprId u, ExprId power);

}  // namespace bgsim
