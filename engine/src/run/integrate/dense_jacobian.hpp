/// Jacobians as dense matrices, column by column.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// The entries of a pattern at their places; 0 elsewhere.
/// @param full  of pattern.size squared
inline void spread_entries(const Sparsity& pattern, const double* entries, double* full) {
  std::fill(full, full + pattern.size * pattern.size, 0.0);
  for (std::size_t column = 0; column < pattern.size; ++column)
    for (auto k = static_cast<std::size_t>(pattern.column_start[column]);
         k < static_cast<std::size_t>(pattern.column_start[column + 1]); ++k)
      full[column * pattern.size + static_cast<std::size_t>(pattern.row[k])] = entries[k];
}

/// By differences over a root of the rounding of each state, or its tolerance if that is more: of rates that have no
/// slopes, and where a law has none.
/// @param y,rate     where the rates are known
/// @param tolerance  tolerance(j) of state j; a state for which it is 0 and that is 0 gets a column of 0
/// @param rates      rates(x, out): false where there are none
/// @param moved      scratch
template <class Tolerance, class Rates>
bool difference_jacobian(const std::vector<double>& y, const std::vector<double>& rate, Tolerance tolerance,
                         Rates rates, std::vector<double>& moved, double* full) {
  const double root = std::sqrt(std::numeric_limits<double>::epsilon());
  const std::size_t size = y.size();
  moved = y;
  for (std::size_t j = 0; j < size; ++j) {
    const double move = std::max(root * std::abs(y[j]), tolerance(j));
    double* column = full + j * size;
    std::fill(column, column + size, 0.0);
    if (move == 0.0) continue;
    moved[j] = y[j] + move;
    if (!rates(moved.data(), column)) return false;
    for (std::size_t i = 0; i < size; ++i) column[i] = (column[i] - rate[i]) / move;
    moved[j] = y[j];
  }
  return true;
}

}  // namespace bgsim
