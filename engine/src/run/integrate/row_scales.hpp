/// Rows of Newton's matrices, scaled so that pivots are compared by what the tolerances make of them.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// Pivots by the size of numbers compare rows in different units. A momentum at rest whose tolerance is 1e-56 N s then
/// takes on the rounding of a displacement that is subtracted from it and added again. Here row i of shift M - h J is
/// divided by the most that a column contributes where each unknown is at its tolerance,
///
///     s_i = max(shift M_i / w_i, max_j h |J_ij| / w_j),
///
/// w the weights (one over the tolerances), to the power of two below: where the pivots are the same as without, so is
/// every bit of the solution. The backward error of the elimination is then small in the norm of the error test.
namespace row_scales {

/// 1 over the power of two below @p size; 1 where there is none.
inline double reciprocal(double size) {
  constexpr std::uint64_t kExponent = 0x7FF0'0000'0000'0000U, kSum = 2046ULL << 52U, kOne = 1ULL << 52U;
  const std::uint64_t power = std::bit_cast<std::uint64_t>(size) & kExponent;
  return power < kOne || power >= kSum ? 1.0 : std::bit_cast<double>(kSum - power);
}

/// @param n, states     unknowns, the first of which have a mass
/// @param jacobian      full, column by column
/// @param[out] scales   by row, what it is to be multiplied by
inline void of_full(std::size_t n, std::size_t states, double shift, double h, const double* jacobian,
                    const double* weight, double* scales) {
  for (std::size_t i = 0; i < n; ++i) scales[i] = i < states ? shift / weight[i] : 0.0;
  for (std::size_t j = 0; j < n; ++j) {
    const double by = h / weight[j];
    for (std::size_t i = 0; i < n; ++i) {
      const double part = std::fabs(jacobian[j * n + i]) * by;
      scales[i] = part > scales[i] ? part : scales[i];
    }
  }
  for (std::size_t i = 0; i < n; ++i) scales[i] = reciprocal(scales[i]);
}

/// The same with the entries by @p pattern.
inline void of_entries(const Sparsity& pattern, std::size_t states, double shift, double h, const double* entries,
                       const double* weight, std::vector<double>& scales) {
  for (std::size_t i = 0; i < pattern.size; ++i) scales[i] = i < states ? shift / weight[i] : 0.0;
  for (std::size_t j = 0; j < pattern.size; ++j) {
    const double by = h / weight[j];
    for (auto k = static_cast<std::size_t>(pattern.column_start[j]);
         k < static_cast<std::size_t>(pattern.column_start[j + 1]); ++k) {
      const double part = std::fabs(entries[k]) * by;
      double& scale = scales[static_cast<std::size_t>(pattern.row[k])];
      scale = part > scale ? part : scale;
    }
  }
  for (double& scale : scales) scale = reciprocal(scale);
}

}  // namespace row_scales

}  // namespace bgsim
