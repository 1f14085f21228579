#include "run/sink/near_misses.hpp"

#include <algorithm>
#include <cmath>

#include "bgsim/simulate.hpp"

namespace bgsim {

NearMisses::NearMisses(const Program& program, Evaluator& evaluator, const Tolerances& tolerances)
    : program_(program), evaluator_(evaluator), tolerances_(tolerances) {
  for (const std::uint32_t relation : program.guarded)
    relation_.insert(relation_.end(), program.relations[relation].has_borders() ? 2 : 1, relation);
  const std::size_t states = program.state_names.size();
  for (auto* const values : {&left_, &middle_, &right_, &low_, &off_}) values->resize(relation_.size());
  y_.resize(states + program.tear_names.size());
  moved_.resize(y_.size());
  rates_.resize(states);
  there_.resize(states);
}

bool NearMisses::guards_at(const StepPolynomial& polynomial, double t, std::vector<double>& guards) {
  for (std::size_t i = 0; i < rates_.size(); ++i) y_[i] = polynomial.at(i, t).first;
  return evaluator_.guards(t, y_.data(), branch_, guards.data());
}

void NearMisses::look(const StepPolynomial& polynomial, double from, double to, const Branch& branch,
                      const std::vector<double>& begin, const std::vector<double>& end) {
  constexpr double kTrusted = 2.0;  // times the error: the estimate is mostly right to within this factor
  if (relation_.empty() || !first_.empty()) return;
  branch_ = branch;
  branch_.given = false;
  for (const std::size_t relation : relation_)
    if (program_.relations[relation].is_between(branch_.modes[relation])) return;
  const double length = to - from;
  if (!guards_at(polynomial, from, left_) || !guards_at(polynomial, from + 0.5 * length, middle_) ||
      !guards_at(polynomial, to, right_))
    return;
  for (std::size_t i = 0; i < relation_.size(); ++i) {
    if (program_.relations[relation_[i]].kind == Relation::Kind::denominator) continue;
    // The parabola through the three turns back from zero within the step.
    const double side = middle_[i] < 0.0 ? -1.0 : 1.0;
    const double a = side * left_[i], m = side * middle_[i], b = side * right_[i];
    const double bend = 2.0 * (a - m - m + b), slope = 4.0 * m - 3.0 * a - b;
    if (!(a > 0.0 && b > 0.0) || !(bend > 0.0) || !(slope < 0.0) || !(-slope < 2.0 * bend)) continue;
    const double part = -slope / (2.0 * bend), t = from + part * length;
    // What sets off from its border turns back in the parabola alone.
    if (!guards_at(polynomial, t, low_) || !(side * low_[i] < a)) continue;
    moved_ = y_;
    for (std::size_t k = 0; k < rates_.size(); ++k) moved_[k] -= begin[k] + part * (end[k] - begin[k]);
    if (!evaluator_.guards(t, moved_.data(), branch_, off_.data())) continue;
    const double beyond = kTrusted * std::abs(off_[i] - low_[i]) - side * low_[i];
    if (beyond > 0.0 && matters(i, t, 2.0 * bend / (length * length), beyond, length)) {
      first_.push_back({relation_[i], t});
      return;
    }
  }
}

/// At the point in y_.
bool NearMisses::matters(std::size_t guard, double t, double bend, double beyond, double longest) {
  const std::size_t relation = relation_[guard];
  other_ = branch_;
  if (program_.relations[relation].has_borders()) {
    const bool upper = guard > 0 && relation_[guard - 1] == relation;
    if (program_.relations[relation].kind == Relation::Kind::cell) return false;  // a table is continuous
    other_.modes[relation] += upper ? 1.0 : -1.0;
  } else {
    direction_.assign(relation_.size(), 0);
    direction_[guard] = low_[guard] < 0.0 ? 1 : -1;
    evaluator_.cross(direction_, other_);
  }
  if (other_.modes == branch_.modes) return false;
  if (!evaluator_.rates(t, y_.data(), branch_, rates_.data()) || !evaluator_.rates(t, y_.data(), other_, there_.data()))
    return false;
  const double time = std::min(longest, 2.0 * std::sqrt(2.0 * beyond / bend));
  for (std::size_t k = 0; k < rates_.size(); ++k)
    if (time * std::abs(there_[k] - rates_[k]) > OutputErrors::kLarge * tolerances_.largest(k)) return true;
  return false;
}

}  // namespace bgsim
