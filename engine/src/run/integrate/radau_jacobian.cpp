#include "run/integrate/radau_jacobian.hpp"

#include <cmath>

#include "bgsim/evaluator.hpp"
#include "run/integrate/dense_jacobian.hpp"
#include "run/tolerances.hpp"

namespace bgsim {

RadauJacobian::RadauJacobian(const Program& program, Evaluator& evaluator, Tolerances& tolerances, bool dense)
    : program_(program),
      evaluator_(evaluator),
      tolerances_(tolerances),
      dense_(dense),
      border_(program.state_names.size(), program.jacobian_pattern.row.size()),
      entries_(program.jacobian_pattern.row.size()),
      at_(program.state_names.size()) {
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

bool RadauJacobian::see(const Beginning& at, const Rates& rates, bool derived) {
  as_before_ = false;
  if (!derived && dense_) return by_differences(at, rates);
  const bool look = derived && steps_since_look_ >= kStepsBetweenLooks;
  const auto evaluate = [&](const double* x) {
    return look ? evaluator_.jacobian(at.t, x, at.branch, entries_.data(), rounding_)
                : evaluator_.jacobian(at.t, x, at.branch, entries_.data());
  };
  if (!evaluate(at.x.data())) {
    // A slope without bound at a point that the solution only passes (sqrt at 0): take it a little further on.
    for (std::size_t i = 0; i < at_.size(); ++i) at_[i] = at.x[i] + at.ahead * at.rate[i];
    // One where it rests (sqrt(max(q, 0)) of an empty tank): by differences.
    if (!evaluate(at_.data())) return dense_ && by_differences(at, rates);
  }
  if (look) {
    steps_since_look_ = 0;
    tolerances_.see({at.t, at.x.data(), program_.jacobian_pattern, entries_.data(), rounding_},
                    [&](double t, const double* x, double* out) { return evaluator_.rates(t, x, at.branch, out); });
  }
  if (derived) slopes_beside_border(at.t, at.x.data(), at.branch);
  as_before_ = entries_ == seen_;
  seen_ = entries_;
  if (dense_) spread_entries(program_.jacobian_pattern, entries_.data(), full_.data());
  return true;
}

bool RadauJacobian::by_differences(const Beginning& at, const Rates& rates) {
  seen_.clear();
  return difference_jacobian(
      at.x, at.rate, [this](std::size_t j) { return tolerances_.absolute(j); }, rates, at_, full_.data());
}

bool RadauJacobian::see_stage(double t, const double* x, Branch& branch, double* full) {
  if (!evaluator_.jacobian(t, x, branch, entries_.data())) return false;
  slopes_beside_border(t, x, branch);
  spread_entries(program_.jacobian_pattern, entries_.data(), full);
  return true;
}

/// In entries_.
void RadauJacobian::slopes_beside_border(double t, const double* x, const Branch& branch) {
  border_.replace(
      x, [&](std::size_t j) { return tolerances_.relative() * std::abs(x[j]) + tolerances_.absolute(j); },
      [&](const double* at, double* out) {
        aside_ = branch;
        return evaluator_.jacobian(t, at, aside_, out);
      },
      entries_.data());
}

}  // namespace bgsim
