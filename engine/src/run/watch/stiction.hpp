/// Set-valued laws: dry friction at rest takes whatever force keeps it at rest, up to its limit; a relief valve that
/// its inflow holds at the level at which it opens lets out just that.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "run/tolerances.hpp"

namespace bgsim {

/// Holds signs, steps and comparisons in laws of resistors at their border: while both sides push back to it, the mode
/// takes the value between those of the sides that keeps the guard where it is (Filippov's sliding mode; for dry
/// friction, sticking). Resistors only: there the law between the two sides is physics. A relay in a source that does
/// this is a question that the model leaves open.
class Stiction {
 public:
  Stiction(const Program& program, Evaluator& evaluator, const Tolerances& tolerances, double span);

  /// Whether the relation behind a guard is of the kind that can be held.
  [[nodiscard]] bool possible(std::size_t guard) const;
  [[nodiscard]] bool any() const { return !held_.empty(); }
  [[nodiscard]] bool held(std::size_t guard) const;
  /// Holds the guard's relation if both of its sides push back here; otherwise leaves everything as it was.
  bool try_hold(std::size_t guard, double t, const double* x, Branch& branch);
  void release(std::size_t guard);
  /// Gives the held modes the values that keep their guards in place. False at a fault.
  bool balance(double t, const double* x, Branch& branch);
  /// How far the mode is from the nearer one of its sides: negative when it is beyond.
  [[nodiscard]] double margin(std::size_t guard, const Branch& branch) const;
  /// The side of the guard that a mode beyond its limit belongs to.
  [[nodiscard]] int side_of(std::size_t guard, double mode) const;

  template <class Archive>
  void carry(Archive& archive) {
    archive("held", held_);
    for (const std::size_t guard : held_) archive.check(guard < guards_.size());
  }

 private:
  [[nodiscard]] const Relation& relation(std::size_t guard) const {
    return program_.relations[evaluator_.guard_relation(guard)];
  }
  bool stays(double t, const double* x, Branch& branch);
  bool guard_rates(double t, const double* x, Branch& branch, double step, Eigen::VectorXd& out);

  const Program& program_;
  Evaluator& evaluator_;
  const Tolerances& tolerances_;
  double span_;
  std::vector<std::size_t> held_;  ///< guards
  std::vector<double> rates_, moved_, guards_, moved_guards_;
  Eigen::MatrixXd slopes_;
  Eigen::VectorXd base_, other_, modes_;
};

}  // namespace bgsim
