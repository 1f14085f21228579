#include "run/euler_steps.hpp"

#include <algorithm>
#include <cmath>

#include "base/unequal.hpp"
#include "run/integrate/sweeps.hpp"

namespace bgsim {

namespace {

constexpr std::size_t kDenseUpTo = 50;
/// A line of so many stores is followed from end to end; of more, as much is done as takes the same time.
constexpr std::size_t kLine = 1000;

}  // namespace

EulerSystems::EulerSystems(const Program& program, bool implicit)
    : program_(program),
      pattern_(implicit ? program.implicit_pattern : program.jacobian_pattern),
      implicit_(implicit),
      entries_(pattern_.row.size()) {
  right_ = make_vector(context_.get(), pattern_.size);
  change_ = make_vector(context_.get(), pattern_.size);
  algebra_ = pattern_.size <= kDenseUpTo ? make_dense(context_.get(), right_.get())
                                         : make_sparse(context_.get(), right_.get(), pattern_);
  SUNLinSolInitialize(algebra_.solver.get());
}

bool EulerSystems::see(Evaluator& evaluator, double t, const double* y, Branch branch,
                       std::vector<double>& jacobian) const {
  jacobian.resize(pattern_.row.size());
  return implicit_ ? evaluator.residual_jacobian(t, 0.0, y, branch, jacobian.data())
                   : evaluator.jacobian(t, y, branch, jacobian.data());
}

bool EulerSystems::factor(double h, const std::vector<double>& jacobian) {
  for (std::size_t column = 0; column < pattern_.size; ++column)
    for (auto k = static_cast<std::size_t>(pattern_.column_start[column]);
         k < static_cast<std::size_t>(pattern_.column_start[column + 1]); ++k) {
      const bool state = static_cast<std::size_t>(pattern_.row[k]) == column && column < program_.state_names.size();
      entries_[k] = implicit_ ? jacobian[k] + (state ? 1.0 / h : 0.0) : (state ? 1.0 : 0.0) - h * jacobian[k];
    }
  sweeps_ = algebra_.pattern != nullptr && !algebra_.along_trees && !implicit_;
  return sweeps_ || factor_now();
}

bool EulerSystems::factor_now() {
  if (algebra_.pattern == nullptr)
    scatter(algebra_.matrix.get(), pattern_, entries_.data());
  else
    std::copy(entries_.begin(), entries_.end(), sparse_values(algebra_.matrix.get(), pattern_));
  sweeps_ = false;
  return SUNLinSolSetup(algebra_.solver.get(), algebra_.matrix.get()) == 0;
}

const double* EulerSystems::solve(double h, const std::vector<double>& rates) {
  double* b = values(right_.get());
  std::fill(b, b + pattern_.size, 0.0);
  for (std::size_t i = 0; i < rates.size(); ++i) b[i] = implicit_ ? rates[i] : h * rates[i];
  if (sweeps_ && solve_by_sweeps(pattern_, entries_, b, swept_)) return swept_.data();
  if (sweeps_ && !factor_now()) return nullptr;
  if (SUNLinSolSolve(algebra_.solver.get(), algebra_.matrix.get(), change_.get(), right_.get(), 0.0) != 0)
    return nullptr;
  return values(change_.get());
}

SolverCost EulerSystems::cost() const { return algebra_.pattern != nullptr ? solver_cost(algebra_) : SolverCost{}; }

EulerFromRest::EulerFromRest(const Program& program, Evaluator& evaluator)
    : program_(program),
      evaluator_(evaluator),
      systems_(program, false),
      end_(program.state_names.size()),
      rates_(end_.size()),
      residual_(end_.size()),
      jacobian_(program.jacobian_pattern.row.size()),
      change_(end_.size()) {}

bool EulerFromRest::rates_at_end(double t) {
  branch_ = here_;
  return evaluator_.initialize_modes(t, end_.data(), branch_) &&
         evaluator_.rates(t, end_.data(), branch_, rates_.data());
}

void EulerFromRest::hold_clocks(const double* x) {
  for (const ProgramDelay& delay : program_.delays) end_[delay.clock] = x[delay.clock];
}

/// A store that nothing has reached yet is a point without slopes for the next one in line: each is moved by what flows
/// into it as soon as those before it have moved.
void EulerFromRest::spread(double t, double h, const double* x) {
  constexpr double kPart = 1e-3;  // of what it would come to: the iteration comes to a root's solution from below
  std::copy_n(x, end_.size(), end_.begin());
  if (!rates_at_end(t)) return;
  const std::size_t links = std::max<std::size_t>(10, kLine * kLine / std::max<std::size_t>(1, end_.size()));
  double part = kPart;
  for (std::size_t link = 0; link < links; ++link, part *= 0.8) {
    bool moved = false;
    for (std::size_t i = 0; i < end_.size(); ++i)
      if (end_[i] == x[i] && std::isfinite(h * rates_[i])) {
        // By unequal parts, so that no two come to be level.
        end_[i] += part * (0.9 + 0.1 * unequal_part(i + 1)) * h * rates_[i];
        moved = moved || end_[i] != x[i];
      }
    hold_clocks(x);
    if (!moved || !rates_at_end(t)) return;
  }
}

bool EulerFromRest::step(double t, double h, const double* x, const Branch& here) {
  // From below, the logarithm of what is left of the way to the solution of a root falls by half in each iteration.
  constexpr std::size_t kMost = 30;
  const std::size_t most = std::clamp<std::size_t>(kMost * kLine / std::max<std::size_t>(1, end_.size()), 3, kMost);
  constexpr double kNear = 0.1, kBack = 1e-4, kOtherWay = 1e3;
  here_ = here;
  spread(t, h, x);
  for (std::size_t iteration = 0; iteration < most; ++iteration) {
    if (!rates_at_end(t) || !evaluator_.slopes(t, end_.data(), branch_, jacobian_.data(), rounding_)) return false;
    // What is still at rest stays there.
    for (double& slope : jacobian_)
      if (!std::isfinite(slope)) slope = 0.0;
    if (!systems_.factor(h, jacobian_)) return false;
    for (std::size_t i = 0; i < end_.size(); ++i) residual_[i] = rates_[i] - (end_[i] - x[i]) / h;
    for (const ProgramDelay& delay : program_.delays) residual_[delay.clock] = 0.0;
    const double* const change = systems_.solve(h, residual_);
    if (change == nullptr) return false;
    bool near = true;
    for (std::size_t i = 0; i < end_.size(); ++i) {
      if (!std::isfinite(change[i])) return false;
      const double before = end_[i] - x[i], after = before + change[i];
      // The tangent of a root leads from beyond the solution to the other side of the rest, as far away again.
      const bool turns = std::signbit(after) != std::signbit(before) && std::abs(after) < kOtherWay * std::abs(before);
      end_[i] = turns ? x[i] + kBack * before : end_[i] + change[i];
      near = near && !turns && std::abs(change[i]) <= kNear * std::abs(end_[i] - x[i]);
    }
    if (near) break;
  }
  for (std::size_t i = 0; i < end_.size(); ++i) change_[i] = end_[i] - x[i];
  for (const ProgramDelay& delay : program_.delays) change_[delay.clock] = h;
  return rates_at_end(t);
}

}  // namespace bgsim
