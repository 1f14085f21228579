#include "run/integrate/ode.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bgsim {

bool OdeIntegrator::begin(double t, const double* x, const Branch& branch, double limit) {
  std::copy(x, x + size_, values(y_.get()));
  branch_ = branch;
  time_ = previous_ = t;
  limit_ = limit;
  border_.begin();
  return rates(t, x, values(scratch_.get()));
}

int OdeIntegrator::scaled_rates(double s, N_Vector y, N_Vector rates) {
  if (!this->rates(s * unit_, values(y), values(rates))) return recoverable(s * unit_);
  if (unit_ != 1.0) N_VScale(unit_, rates, rates);
  return 0;
}

int OdeIntegrator::scaled_jacobian(double s, N_Vector y, N_Vector rates, SUNMatrix matrix, N_Vector moved) {
  const Sparsity& pattern = program_.jacobian_pattern;
  const bool dense = algebra_.pattern == nullptr;
  const double t = s * unit_;
  if (special_rates_ && dense) {
    // What rounding makes of the rates is found by the program's slopes all the same.
    aside_ = branch_;
    if (evaluator_.jacobian(t, values(y), aside_, entries_.data(), rounding_))
      see({t, values(y), pattern, entries_.data(), rounding_});
    return difference_jacobian(t, values(y), values(rates), matrix) ? 0 : recoverable(t);
  }
  double* entries = dense ? entries_.data() : sparse_values(matrix, pattern);
  const auto tolerance = [&](std::size_t j) { return tolerance_at(values(y), j); };
  const auto slopes = [&](const double* x, double* out) {
    aside_ = branch_;
    return evaluator_.jacobian(t, x, aside_, out);
  };
  bool known = evaluator_.jacobian(t, values(y), branch_, entries, rounding_);
  if (!known) {
    // A slope without bound at a point that the solution only passes (sqrt at 0): take it a little further on.
    const double step = std::max(this->step(), 1e-9 * (limit_ - time_));
    N_VLinearSum(1.0, y, step / unit_, rates, moved);
    known = evaluator_.jacobian(t, values(moved), branch_, entries, rounding_);
  }
  if (known) {
    see({t, values(y), pattern, entries, rounding_});
    if (!special_rates_) border_.replace(values(y), tolerance, slopes, entries);
  } else {
    // One where it rests (sqrt(max(q, 0)) of an empty tank): over what the tolerance leaves open there is a slope.
    if (dense && difference_jacobian(t, values(y), values(rates), matrix)) return 0;
    if (dense || !border_.take_beside(values(y), tolerance, slopes, entries)) return recoverable(t);
  }
  if (unit_ != 1.0)
    for (std::size_t i = 0; i < pattern.row.size(); ++i) entries[i] *= unit_;
  if (dense) scatter(matrix, pattern, entries);
  return 0;
}

/// The Jacobian by differences over the tolerances: of special rates, and where a law has no slope.
bool OdeIntegrator::difference_jacobian(double t, const double* x, const double* at_x, SUNMatrix matrix) {
  const double root = std::sqrt(std::numeric_limits<double>::epsilon());
  std::vector<double> moved(x, x + size_);
  for (std::size_t j = 0; j < size_; ++j) {
    const double move = std::max(root * std::abs(x[j]), tolerances_.absolute(j));
    double* column = dense_column(matrix, j);
    std::fill(column, column + size_, 0.0);
    if (move == 0.0) continue;
    moved[j] = x[j] + move;
    if (!rates(t, moved.data(), column)) return false;
    for (std::size_t i = 0; i < size_; ++i) column[i] = (column[i] * unit_ - at_x[i]) / move;
    moved[j] = x[j];
  }
  return true;
}

bool OdeIntegrator::step_by_hand() {
  if (!rates(time_, values(y_), values(scratch_.get()))) return false;
  for (std::size_t i = 0; i < size_; ++i) values(y_.get())[i] += (limit_ - time_) * values(scratch_)[i];
  moved_to_limit();
  return true;
}

}  // namespace bgsim
