/// Where an expression of one symbol has a value: all such places, with a proof.
#pragma once

#include <vector>

#include "bgsim/expression.hpp"

namespace bgsim {

struct Solutions {
  std::vector<double> at;  ///< increasing
  bool all = false;        ///< there is no other of a magnitude below 1e150; else nothing is known
};

/// @param values  of all symbols, by SymbolId; that of @p x is changed.
/// @note Stretches are divided until the expression's enclosure on each excludes the value, or its slope's has a sign;
///       gives up after some thousands.
Solutions solutions(ExprPool& pool, ExprId expression, SymbolId x, double value, std::vector<double>& values);

}  // namespace bgsim
