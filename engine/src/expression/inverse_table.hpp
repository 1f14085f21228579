/// Which way a table goes, and the table that undoes it.
#pragma once

#include <optional>

#include "bgsim/expression.hpp"
#include "expression/monotone.hpp"

namespace bgsim {

/// Rising or falling where it is strictly so over all of its data. Cost: one look at each cell.
Way way_of(const Table& table);

/// Of a linear table that rises or falls: the one with x and y exchanged, which is exact; none for others. The inverse
/// of a spline is none, and is left to a loop.
std::optional<TableId> inverse_table(ExprPool& pool, TableId id);

/// The value at @p x, that at the end of the data where @p x is beside it by rounding, NaN outside.
double value_within(Op op, const Table& table, double x);

}  // namespace bgsim
