#include "run/integrate/sweeps.hpp"

#include <algorithm>
#include <cmath>

namespace bgsim {

bool solve_by_sweeps(const Sparsity& pattern, const std::vector<double>& entries, const double* b,
                     std::vector<double>& x) {
  constexpr int kMostSweeps = 16;
  constexpr double kFastest = 0.7, kLeft = 0.1;
  const std::size_t size = pattern.size;
  const auto start = [&](std::size_t column) { return static_cast<std::size_t>(pattern.column_start[column]); };
  std::vector<double> diagonal(size, 0.0), rest(b, b + size), moved(size, 0.0);
  for (std::size_t j = 0; j < size; ++j)
    for (std::size_t k = start(j); k < start(j + 1); ++k)
      if (static_cast<std::size_t>(pattern.row[k]) == j) diagonal[j] = entries[k];
  for (const double entry : diagonal)
    if (!(std::abs(entry) > 0.0)) return false;
  x.assign(size, 0.0);
  const auto relax = [&](std::size_t j) {
    const double change = rest[j] / diagonal[j];
    if (change == 0.0) return;
    x[j] += change;
    moved[j] += change;
    for (std::size_t k = start(j); k < start(j + 1); ++k)
      rest[static_cast<std::size_t>(pattern.row[k])] -= entries[k] * change;
    rest[j] = 0.0;
  };
  double before = 0.0;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    std::fill(moved.begin(), moved.end(), 0.0);
    for (std::size_t j = 0; j < size; ++j) relax(j);
    for (std::size_t j = size; j > 0; --j) relax(j - 1);
    // Components that come to nothing by cancellation, beside what they are made of, are of no size to be known.
    double largest = 0.0;
    for (std::size_t i = 0; i < size; ++i)
      if (moved[i] != 0.0) largest = std::max(largest, std::abs(moved[i]) / std::abs(x[i]));
    if (!std::isfinite(largest)) return false;
    const double rate = sweep > 1 ? largest / before : 1.0;
    if (largest == 0.0 || (sweep > 1 && rate < kFastest && largest * rate / (1.0 - rate) < kLeft)) return true;
    if (sweep > 3 && !(rate < kFastest)) return false;
    before = largest;
  }
  return false;
}

}  // namespace bgsim
