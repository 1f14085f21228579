/// Conditions that a run just misses, and the exact solution perhaps does not.
#pragma once

#include <optional>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "run/integrate/step_polynomial.hpp"
#include "run/tolerances.hpp"

namespace bgsim {

/// A guard that comes near its border and turns back within a step, by less than what the run is wrong by: whether its
/// condition changes there is open, and no estimate that follows the run's own events knows of it. What the change
/// would add to a state is the jump of its rate over the time that the guard would be beyond: of a parabola with the
/// bend c that is beyond by d, 2 sqrt(2 d/c). What is nothing beside a state's largest value is passed over.
class NearMisses {
 public:
  NearMisses(const Program& program, Evaluator& evaluator, const Tolerances& tolerances);

  /// The step from @p from to @p to, in which no guard has crossed.
  /// @param begin, end  what the states are wrong by there.
  /// @note  Cost: the guards at two points, and at one more where one of them turns back.
  void look(const StepPolynomial& polynomial, double from, double to, const Branch& branch,
            const std::vector<double>& begin, const std::vector<double>& end);

  struct Miss {
    std::size_t relation = 0;
    double t = 0.0;
  };
  /// The first of the run.
  [[nodiscard]] const std::vector<Miss>& first() const { return first_; }

  template <class Archive>
  void carry(Archive& archive) {
    std::vector<std::size_t> relation;
    std::vector<double> t;
    for (const Miss& miss : first_) {
      relation.push_back(miss.relation);
      t.push_back(miss.t);
    }
    archive("relation", relation);
    archive("t", t);
    for (const std::size_t r : relation) archive.check(r < program_.relations.size());
    archive.check(relation.size() == t.size());
    first_.clear();
    for (std::size_t i = 0; i < relation.size(); ++i) first_.push_back({relation[i], t[i]});
  }

 private:
  bool guards_at(const StepPolynomial& polynomial, double t, std::vector<double>& guards);
  [[nodiscard]] bool matters(std::size_t guard, double t, double bend, double beyond, double longest);

  const Program& program_;
  Evaluator& evaluator_;
  const Tolerances& tolerances_;
  std::vector<std::size_t> relation_;  ///< by guard
  std::vector<Miss> first_;
  // Scratch
  Branch branch_, other_;
  std::vector<double> y_, moved_, left_, middle_, right_, low_, off_, rates_, there_;
  std::vector<int> direction_;
};

}  // namespace bgsim
