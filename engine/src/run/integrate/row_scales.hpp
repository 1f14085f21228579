/// What the rows of Newton's matrices are compared by where a pivot is chosen.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// Pivots by the size of numbers compare rows in different units. A momentum at rest whose tolerance is 1e-56 N s then
/// takes on the rounding of a displacement that is subtracted from it and added again. Here row i of shift M - h J is
/// compared by 1/s_i, with s_i the most that a column contributes where each unknown is at its tolerance,
///
///     s_i = max(shift M_i / w_i, max_j h |J_ij| / w_j),
///
/// w the weights (one over the tolerances). The backward error of the elimination is then small in the norm of the
/// error test.
namespace row_scales {

inline double larger(double a, double b) { return b > a ? b : a; }
/// 1 for a row of nothing.
inline double inverse(double size) {
  const double scale = 1.0 / size;
  return scale > 0.0 && std::isfinite(scale) ? scale : 1.0;
}

/// @param n, states     unknowns, the first of which have a mass
/// @param jacobian      full, column by column
/// @param[out] scales   by row
inline void of_full(std::size_t n, std::size_t states, double shift, double h, const double* jacobian,
                    const double* weight, double* scales) {
  for (std::size_t i = 0; i < n; ++i) scales[i] = i < states ? shift / weight[i] : 0.0;
  for (std::size_t j = 0; j < n; ++j) {
    const double by = h / weight[j];
    for (std::size_t i = 0; i < n; ++i) scales[i] = larger(scales[i], std::fabs(jacobian[j * n + i]) * by);
  }
  for (std::size_t i = 0; i < n; ++i) scales[i] = inverse(scales[i]);
}

/// The same of entries by @p pattern, to the next power of two: rows that are multiplied by it keep their digits.
inline void of_entries(const Sparsity& pattern, std::size_t states, double shift, double h, const double* entries,
                       const double* weight, std::vector<double>& scales) {
  for (std::size_t i = 0; i < pattern.size; ++i) scales[i] = i < states ? shift / weight[i] : 0.0;
  for (std::size_t j = 0; j < pattern.size; ++j) {
    const double by = h / weight[j];
    for (auto k = static_cast<std::size_t>(pattern.column_start[j]);
         k < static_cast<std::size_t>(pattern.column_start[j + 1]); ++k) {
      double& scale = scales[static_cast<std::size_t>(pattern.row[k])];
      scale = larger(scale, std::fabs(entries[k]) * by);
    }
  }
  for (double& scale : scales) scale = std::exp2(std::ilogb(inverse(scale)));
}

}  // namespace row_scales

}  // namespace bgsim
