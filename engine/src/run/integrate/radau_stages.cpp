#include "run/integrate/radau_stages.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "run/integrate/row_scales.hpp"

namespace bgsim {

RadauStages::RadauStages(std::size_t size, std::size_t states, std::size_t stages, const double* inverse, AtStage rates,
                         AtStage jacobian)
    : size_(size),
      states_(states),
      stages_(stages),
      inverse_(inverse),
      rates_(std::move(rates)),
      jacobian_(std::move(jacobian)),
      lu_(stages * size),
      scales_(stages * size),
      at_(size),
      rate_(size),
      full_(size * size) {
  for (auto* const vector : {&now_, &trial_, &defect_, &step_, &next_, &simplified_}) vector->resize(stages * size);
}

double RadauStages::norm(const std::vector<double>& x, const double* weight) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < stages_; ++k)
    for (std::size_t i = 0; i < size_; ++i) {
      const double part = x[k * size_ + i] * weight[i];
      sum += part * part;
    }
  return std::sqrt(sum / static_cast<double>(stages_ * size_));
}

/// h F - (A^-1 x M) Z
bool RadauStages::defects(double h, const double* y, const std::vector<double>& z, std::vector<double>& out) {
  for (std::size_t k = 0; k < stages_; ++k) {
    for (std::size_t i = 0; i < size_; ++i) at_[i] = y[i] + z[k * size_ + i];
    if (!rates_(k, at_.data(), rate_.data())) return false;
    for (std::size_t i = 0; i < size_; ++i) {
      double defect = h * rate_[i];
      for (std::size_t l = 0; i < states_ && l < stages_; ++l) defect -= inverse_[k * stages_ + l] * z[l * size_ + i];
      out[k * size_ + i] = defect;
    }
  }
  return true;
}

/// The matrix at @p z, factored, with pivots by the weights.
bool RadauStages::see(double h, const double* y, const std::vector<double>& z, const double* weight) {
  const std::size_t all = stages_ * size_;
  double* const matrix = lu_.real();
  std::fill_n(matrix, all * all, 0.0);
  for (std::size_t k = 0; k < stages_; ++k) {
    for (std::size_t i = 0; i < size_; ++i) at_[i] = y[i] + z[k * size_ + i];
    if (!jacobian_(k, at_.data(), full_.data())) return false;
    double largest = 0.0;  // of the coefficients of a stage
    for (std::size_t l = 0; l < stages_; ++l) {
      const double coefficient = inverse_[k * stages_ + l];
      largest = std::max(largest, std::abs(coefficient));
      for (std::size_t i = 0; i < states_; ++i) matrix[(l * size_ + i) * all + k * size_ + i] = coefficient;
    }
    for (std::size_t j = 0; j < size_; ++j)
      for (std::size_t i = 0; i < size_; ++i) matrix[(k * size_ + j) * all + k * size_ + i] -= h * full_[j * size_ + i];
    row_scales::of_full(size_, states_, largest, h, full_.data(), weight, scales_.data() + k * size_);
  }
  return std::all_of(matrix, matrix + all * all, [](double entry) { return std::isfinite(entry); }) &&
         lu_.factor(scales_.data());
}

bool RadauStages::solve(double h, const double* y, Stages z, const double* weight, double reached) {
  constexpr int kMost = 12;
  constexpr double kLeastDamping = 0.05, kFast = 0.5;
  const std::size_t all = now_.size();
  for (std::size_t k = 0; k < stages_; ++k)
    std::copy(z[k].begin(), z[k].end(), now_.begin() + static_cast<std::ptrdiff_t>(k * size_));
  if (!defects(h, y, now_, defect_)) return false;
  double damping = 1.0, size_before = 0.0, simplified_before = 0.0;
  for (iterations_ = 1; iterations_ <= kMost; ++iterations_) {
    if (!see(h, y, now_, weight)) return false;
    step_ = defect_;
    lu_.solve(step_.data());
    const double size = norm(step_, weight);
    if (!std::isfinite(size)) return false;
    if (iterations_ > 1) {
      for (std::size_t i = 0; i < all; ++i) simplified_[i] -= step_[i];
      const double bent = norm(simplified_, weight) * size;
      damping = bent > 0.0 ? std::min(1.0, damping * size_before * simplified_before / bent) : 1.0;
    }
    double simplified = 0.0;
    while (true) {
      if (damping < kLeastDamping) return false;
      for (std::size_t i = 0; i < all; ++i) trial_[i] = now_[i] + damping * step_[i];
      if (!defects(h, y, trial_, next_)) {
        damping *= kFast;
        continue;
      }
      simplified_ = next_;
      lu_.solve(simplified_.data());
      simplified = norm(simplified_, weight);
      if (simplified <= (1.0 - 0.25 * damping) * size) break;
      if (damping == 1.0 && simplified <= reached * kFast) break;  // where rounding begins nothing falls any more
      for (std::size_t i = 0; i < all; ++i) next_[i] = simplified_[i] - (1.0 - damping) * step_[i];
      damping = std::min(0.5 * size * damping * damping / norm(next_, weight), kFast * damping);
      if (!(damping > 0.0)) return false;
    }
    const double rate = simplified / size;
    if (damping == 1.0 &&
        (simplified <= kFast * reached || (rate < kFast && rate / (1.0 - rate) * simplified <= reached))) {
      for (std::size_t k = 0; k < stages_; ++k)
        for (std::size_t i = 0; i < size_; ++i) z[k][i] = trial_[k * size_ + i] + simplified_[k * size_ + i];
      return true;
    }
    std::swap(now_, trial_);
    std::swap(defect_, next_);
    size_before = size;
    simplified_before = simplified;
  }
  return false;
}

}  // namespace bgsim
