/// Values with bounds of what rounding can have made of them (running error analysis).
#pragma once

#include <array>
#include <limits>
#include <span>

#include "bgsim/expression.hpp"

namespace bgsim {

struct Rounded {
  double value = std::numeric_limits<double>::quiet_NaN();
  double error = 0.0;
};

/// A number as it is written: whole ones are exact, others are the nearest doubles.
Rounded rounded_constant(double value);
/// An operator on rounded values; not for der and tables.
Rounded apply_rounded(Op op, const std::array<Rounded, 3>& x, std::size_t count);

/// A table, or a derivative of it, at a rounded argument: its knots are exact, the sum between them is rounded.
Rounded apply_rounded(Op op, const Table& table, const Rounded& x);

/// How far the value of @p root can be off if its numbers are rounded and the symbols are off by @p symbol_errors.
double rounding_of(const ExprPool& pool, ExprId root, std::span<const double> symbol_values,
                   std::span<const double> symbol_errors);

}  // namespace bgsim
