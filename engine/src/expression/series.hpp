/// Operators on power series: what an expression is shortly after an instant.
#pragma once

#include "base/power_series.hpp"
#include "bgsim/expression.hpp"

namespace bgsim {

/// op(a, b, c) of numbers that move with h, as far as their coefficients tell. An operator that has no derivatives
/// there (a root at 0, a comparison of what moves, a spline beyond its second derivative at a knot) leaves the result
/// unknown.
/// @pre op is no table.
PowerSeries apply(Op op, const PowerSeries& a, const PowerSeries& b, const PowerSeries& c);

/// A table's value (Op::table) at @p a. @param cell  of a linear table, as in value_in_cell(); negative: a spline.
PowerSeries table_series(const Table& table, const PowerSeries& a, double cell);

}  // namespace bgsim
