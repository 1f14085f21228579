#include "run/watch/stiction.hpp"

#include <algorithm>
#include <cmath>

#include "base/lu.hpp"
#include "expression/apply.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

Stiction::Stiction(const Program& program, Evaluator& evaluator, const Tolerances& tolerances, double span)
    : program_(program),
      evaluator_(evaluator),
      tolerances_(tolerances),
      span_(span),
      rates_(evaluator.states()),
      moved_(evaluator.states()),
      guards_(evaluator.guard_count()),
      moved_guards_(evaluator.guard_count()) {}

bool Stiction::possible(std::size_t guard) const {
  const Relation& at = relation(guard);
  const bool two_sided = at.kind == Relation::Kind::sign || at.kind == Relation::Kind::step ||
                         (at.kind == Relation::Kind::condition && !at.time_only);
  if (!two_sided || !at.where.element.valid()) return false;
  return is_resistor(program_.model->elements[at.where.element.index()].kind);
}

bool Stiction::held(std::size_t guard) const { return std::find(held_.begin(), held_.end(), guard) != held_.end(); }

bool Stiction::try_hold(std::size_t guard, double t, const double* x, Branch& branch) {
  Branch held = branch;
  held_.push_back(guard);
  const Relation& at = relation(guard);
  // A comparison may be true below its border.
  const bool falls = at.kind == Relation::Kind::condition && (at.comparison == Op::lt || at.comparison == Op::le);
  if (balance(t, x, held) && (falls ? -1.0 : 1.0) * slopes_(slopes_.rows() - 1, slopes_.cols() - 1) < 0.0) {
    const bool all_within =
        std::all_of(held_.begin(), held_.end(), [&](std::size_t g) { return margin(g, held) >= 0.0; });
    if (all_within && (at.kind == Relation::Kind::sign || stays(t, x, held))) {
      branch = std::move(held);
      return true;
    }
  }
  held_.pop_back();
  return false;
}

/// Whether the guards stay where they are with these modes: not if rates are no straight line between the two sides (a
/// condition within others, a law on a nonlinear loop).
bool Stiction::stays(double t, const double* x, Branch& branch) {
  constexpr double kOfSides = 1e-6;
  if (!guard_rates(t, x, branch, 0.0, other_)) return false;
  for (Eigen::Index k = 0; k < other_.size(); ++k)
    if (!(std::abs(other_[k]) <= kOfSides * (std::abs(base_[k]) + slopes_.row(k).cwiseAbs().sum()))) return false;
  return true;
}

void Stiction::release(std::size_t guard) { std::erase(held_, guard); }

double Stiction::margin(std::size_t guard, const Branch& branch) const {
  const double mode = branch.modes[evaluator_.guard_relation(guard)];
  return relation(guard).kind == Relation::Kind::sign ? 1.0 - std::abs(mode) : std::min(mode, 1.0 - mode);
}

int Stiction::side_of(std::size_t guard, double mode) const {
  const Relation& at = relation(guard);
  if (at.kind == Relation::Kind::sign) return (mode > 0.0) - (mode < 0.0);
  const bool above = apply(at.kind == Relation::Kind::step ? Op::step : at.comparison, 1.0, 0.0) != 0.0;
  return (mode > 0.5) == above ? 1 : -1;
}

/// How fast the held guards move with the modes as they are, by a small step along the flow. Guards are linear in the
/// states as a rule, and the step is then of no consequence.
bool Stiction::guard_rates(double t, const double* x, Branch& branch, double step, Eigen::VectorXd& out) {
  if (!evaluator_.rates(t, x, branch, rates_.data()) || !evaluator_.guards(t, x, branch, guards_.data())) return false;
  if (step <= 0.0) {
    constexpr double kTolerances = 1e3;
    step = 1e-3 * span_;
    for (std::size_t i = 0; i < rates_.size(); ++i) {
      const double tolerance = tolerances_.absolute(i);
      if (rates_[i] != 0.0 && tolerance > 0.0) step = std::min(step, kTolerances * tolerance / std::abs(rates_[i]));
    }
  }
  for (std::size_t i = 0; i < rates_.size(); ++i) moved_[i] = x[i] + step * rates_[i];
  if (!evaluator_.guards(t + step, moved_.data(), branch, moved_guards_.data())) return false;
  for (std::size_t k = 0; k < held_.size(); ++k)
    out[static_cast<Eigen::Index>(k)] = (moved_guards_[held_[k]] - guards_[held_[k]]) / step;
  return true;
}

/// The guards' rates are linear in the modes (a sign is a factor of a force or a flow): measured at 0 and at each
/// mode's 1, solved for 0.
bool Stiction::balance(double t, const double* x, Branch& branch) {
  const auto count = static_cast<Eigen::Index>(held_.size());
  slopes_.resize(count, count);
  base_.resize(count);
  other_.resize(count);
  const auto mode = [&](Eigen::Index k) -> double& {
    return branch.modes[evaluator_.guard_relation(held_[static_cast<std::size_t>(k)])];
  };
  for (Eigen::Index k = 0; k < count; ++k) mode(k) = 0.0;
  if (!guard_rates(t, x, branch, 0.0, base_)) return false;
  for (Eigen::Index k = 0; k < count; ++k) {
    mode(k) = 1.0;
    if (!guard_rates(t, x, branch, 0.0, other_)) return false;
    slopes_.col(k) = other_ - base_;
    mode(k) = 0.0;
  }
  modes_ = solve_with_full_pivots(slopes_, -base_);
  for (Eigen::Index k = 0; k < count; ++k) {
    if (!std::isfinite(modes_[k])) return false;
    mode(k) = modes_[k];
  }
  return true;
}

}  // namespace bgsim
