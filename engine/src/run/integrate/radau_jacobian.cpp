#include "run/integrate/radau_jacobian.hpp"

#include <cmath>

#include "bgsim/evaluator.hpp"
#include "run/integrate/dense_jacobian.hpp"
#include "run/tolerances.hpp"

namespace bgsim {

RadauJacobian::RadauJacobian(const Program& program, Evaluator& evaluator, Tolerances& tolerances, bool dense,
                             Loops loops)
    : evaluator_(evaluator),
      tolerances_(tolerances),
      pattern_(pattern_of(program, loops)),
      loops_(loops),
      dense_(dense),
      residuals_(program, evaluator, tolerances),
      border_(pattern_.size, pattern_.row.size()),
      entries_(pattern_.row.size()),
      at_(pattern_.size) {
  if (dense_) full_.assign(at_.size() * at_.size(), 0.0);
}

void RadauJacobian::begin() {
  border_.begin();
  steps_since_look_ = kStepsBetweenLooks;
}

void RadauJacobian::stepped() {
  border_.stepped();
  ++steps_since_look_;
}

/// By the pattern.
bool RadauJacobian::slopes(double t, const double* y, Branch& branch, double* entries) {
  if (loops_ == Loops::inside) return evaluator_.jacobian(t, y, branch, entries);
  if (!evaluator_.residual_jacobian(t, 0.0, y, branch, entries)) return false;
  for (std::size_t k = 0; k < entries_.size(); ++k) entries[k] = -entries[k];
  return true;
}

bool RadauJacobian::see(const Beginning& at, const Rates& rates, bool derived) {
  as_before_ = false;
  if (!derived && dense_) {
    look(at);
    return by_differences(at, rates);
  }
  const bool look = derived && steps_since_look_ >= kStepsBetweenLooks;
  const auto evaluate = [&](const double* x) {
    return look && loops_ == Loops::inside ? evaluator_.jacobian(at.t, x, at.branch, entries_.data(), rounding_)
                                           : slopes(at.t, x, at.branch, entries_.data());
  };
  bool known = evaluate(at.x.data());
  if (!known) {
    // A slope without bound at a point that the solution only passes (sqrt at 0): take it a little further on.
    for (std::size_t i = 0; i < at_.size(); ++i) at_[i] = at.x[i] + at.ahead * at.rate[i];
    // One where it rests (sqrt(max(q, 0)) of an empty tank): over what the tolerance leaves open there is a slope.
    known = evaluate(at_.data());
    if (!known && dense_) return by_differences(at, rates);
    if (!known && !take_beside(at.t, at.x.data(), at.branch)) return false;
  }
  if (look && known) {
    steps_since_look_ = 0;
    show_tolerances(at);
  }
  if (derived && known) slopes_beside_border(at.t, at.x.data(), at.branch);
  as_before_ = entries_ == seen_;
  seen_ = entries_;
  if (dense_) spread_entries(pattern_, entries_.data(), full_.data());
  return true;
}

void RadauJacobian::show_tolerances(const Beginning& at) {
  if (loops_ == Loops::unknowns) {
    residuals_.show(at.t, at.x.data(), at.branch, at.rate.data(), entries_.data());
    residuals_.see_loops(at.t, at.x.data(), at.branch);
    return;
  }
  tolerances_.see({at.t, at.x.data(), pattern_, entries_.data(), rounding_},
                  [&](double t, const double* x, double* out) { return evaluator_.rates(t, x, at.branch, out); });
}

void RadauJacobian::look(const Beginning& at) {
  if (steps_since_look_ < kStepsBetweenLooks || loops_ == Loops::unknowns) return;
  aside_ = at.branch;
  if (!evaluator_.jacobian(at.t, at.x.data(), aside_, entries_.data(), rounding_)) return;
  steps_since_look_ = 0;
  show_tolerances(at);
}

bool RadauJacobian::by_differences(const Beginning& at, const Rates& rates) {
  seen_.clear();
  return difference_jacobian(
      at.x, at.rate, [this](std::size_t j) { return tolerances_.absolute(j); }, rates, at_, full_.data());
}

bool RadauJacobian::see_stage(double t, const double* x, Branch& branch, double* full) {
  if (!slopes(t, x, branch, entries_.data())) return false;
  slopes_beside_border(t, x, branch);
  spread_entries(pattern_, entries_.data(), full);
  return true;
}

/// In entries_.
void RadauJacobian::slopes_beside_border(double t, const double* x, const Branch& branch) {
  border_.replace(
      x, [&](std::size_t j) { return tolerance_at(x, j); },
      [&](const double* at, double* out) { return slopes_aside(t, at, branch, out); }, entries_.data());
}

/// In entries_, where there are none at @p x.
bool RadauJacobian::take_beside(double t, const double* x, const Branch& branch) {
  return border_.take_beside(
      x, [&](std::size_t j) { return tolerance_at(x, j); },
      [&](const double* at, double* out) { return slopes_aside(t, at, branch, out); }, entries_.data());
}

double RadauJacobian::tolerance_at(const double* x, std::size_t j) const {
  return tolerances_.relative() * std::abs(x[j]) + tolerances_.absolute(j);
}

bool RadauJacobian::slopes_aside(double t, const double* x, const Branch& branch, double* entries) {
  aside_ = branch;
  return slopes(t, x, aside_, entries);
}

}  // namespace bgsim
