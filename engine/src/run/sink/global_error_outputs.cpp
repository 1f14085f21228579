// What the error makes of the outputs, and what rounding may have made of them.
#include <algorithm>
#include <cmath>
#include <limits>

#include "run/sink/global_error.hpp"

namespace bgsim {

void GlobalError::add_row(double t, const double* y, const Branch& branch, const std::vector<double>& row) {
  if (!measuring_) return;
  const Stopwatch watch(seconds_);
  for (std::size_t k = 0; k < row.size(); ++k) {
    sums_.least_value[k] = std::min(sums_.least_value[k], row[k]);
    sums_.most_value[k] = std::max(sums_.most_value[k], row[k]);
  }
  // Between the ends of a part: a straight line, and what bends it.
  std::size_t at = 0;
  while (at + 1 < parts_ && t > part_begin(at + 1)) ++at;
  const double *const left = error_at(at), *const right = error_at(at + 1);
  const double a = part_begin(at), b = part_begin(at + 1);
  const double part = b > a ? std::clamp((t - a) / (b - a), 0.0, 1.0) : 1.0;
  for (std::size_t i = 0; i < error_.size(); ++i) y_[i] = y[i] - (left[i] + part * (right[i] - left[i]));
  if (part < 1.0) add_bend(within_[at], part);
  branch_ = branch;
  branch_.given = false;
  if (!evaluator_.outputs(t, y_.data(), branch_, row_.data())) return;
  for (std::size_t k = 0; k < row.size(); ++k)
    if (const double size = std::abs(row[k] - row_[k]); std::isfinite(size))
      sums_.largest[k] = std::max(sums_.largest[k], size);
  hold_against_rounding(t, y, branch, row);
}

void GlobalError::hold_against_rounding(double t, const double* y, const Branch& branch,
                                        const std::vector<double>& row) {
  constexpr double kUnitsOfStep = 8.0 * std::numeric_limits<double>::epsilon();
  const auto size = [&](std::size_t k) { return std::abs(row[k] - row_[k]); };
  const auto due = [&](std::size_t k) {
    return std::isfinite(size(k)) && size(k) > 2.0 * sums_.bounded[k] &&
           size(k) > OutputErrors::kLarge * (sums_.most_value[k] - sums_.least_value[k]);
  };
  bool any = false;
  for (std::size_t k = 0; k < row.size() && !any; ++k) any = due(k);
  if (!any) return;
  // Both what was recorded and what it is compared with are rounded. Each step rounds the states by some units, which
  // add up like a random walk; what rounding makes of the rates (a balance of forces at rest) at most all of the time.
  branch_ = branch;
  branch_.given = false;
  if (!evaluator_.jacobian(t, y, branch_, entries_.data(), rate_rounding_)) rate_rounding_.clear();
  for (std::size_t i = 0; i < state_rounding_.size(); ++i)
    state_rounding_[i] = kUnitsOfStep * std::sqrt(sums_.steps + 1.0) * std::abs(y[i]) +
                         (rate_rounding_.empty() ? 0.0 : (t - sums_.start) * rate_rounding_[i]);
  if (!rate_rounding_.empty() && holds(branch_)) {
    // A block at rest drifts by the rounding of the forces that hold it.
    const std::vector<double> momenta = state_rounding_;
    const Sparsity& pattern = program_.jacobian_pattern;
    for (std::size_t column = 0; column < momenta.size(); ++column)
      for (auto k = static_cast<std::size_t>(pattern.column_start[column]);
           k < static_cast<std::size_t>(pattern.column_start[column + 1]); ++k)
        state_rounding_[static_cast<std::size_t>(pattern.row[k])] +=
            (t - sums_.start) * std::abs(entries_[k]) * momenta[column];
  }
  branch_ = branch;
  branch_.given = false;
  evaluator_.output_rounding(t, y, branch_, state_rounding_, rounding_.data());
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (!due(k)) continue;
    sums_.bounded[k] = size(k);
    if (size(k) > 2.0 * rounding_[k]) sums_.beyond[k] = size(k);
  }
}

OutputErrors GlobalError::finish(bool completed) {
  OutputErrors errors;
  if (measuring_ && !completed) give_up("the run did not come to its end");
  errors.why_not = why_not_;
  errors.possible = possible_;
  if (!measuring_) return errors;
  errors.done = true;
  errors.estimate = sums_.largest;
  errors.beyond_rounding = sums_.beyond;
  for (std::size_t k = 0; k < sums_.largest.size(); ++k) {
    errors.range.push_back(std::max(0.0, sums_.most_value[k] - sums_.least_value[k]));
    errors.magnitude.push_back(std::max(std::abs(sums_.most_value[k]), std::abs(sums_.least_value[k])));
  }
  return errors;
}

}  // namespace bgsim
