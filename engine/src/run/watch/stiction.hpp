/// Set-valued laws: dry friction at rest takes whatever force keeps it at rest, up to its limit; a relief valve that
/// its inflow holds at the level at which it opens lets out just that.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "program/enclosure.hpp"
#include "run/at_border.hpp"
#include "run/complementarity.hpp"
#include "run/tolerances.hpp"

namespace bgsim {

/// A guard of the law of a resistor, with its mode where that is known (see AtBorder).
struct GuardMode {
  std::size_t guard;
  double mode;
};

/// Holds signs, steps and comparisons in laws of resistors at their border: while both sides push back to it, the mode
/// takes the value between those of the sides that keeps the guard where it is (Filippov's sliding mode; for dry
/// friction, sticking). Resistors only: there the law between the two sides is physics. A relay in a source that does
/// this is a question that the model leaves open.
///
/// Which of several borders hold, and to which side the others are left, is decided for all of them at once: the modes
/// and the guards' rates are complementary, as forces and accelerations of dry friction are (docs/theory.md).
/// Where more borders hold than the states have ways to move, the modes are not unique, and the rates are: modes of the
/// surplus rest where that decision has them.
class Stiction {
 public:
  Stiction(const Program& program, std::span<const double> parameters, Evaluator& evaluator,
           const Tolerances& tolerances, double span);

  /// Whether the relation behind a guard is of the kind that can be held.
  [[nodiscard]] bool possible(std::size_t guard) const;
  [[nodiscard]] bool any() const { return !held_.empty(); }
  [[nodiscard]] bool held(std::size_t guard) const;
  /// The laws that are held.
  [[nodiscard]] std::vector<AtBorder> laws() const;

  struct Left {
    std::size_t guard;
    int side;
  };
  /// Decides which guards are held from here on: of those that are now, and of @p candidates, which are at their
  /// borders. The modes of all of them follow, those of candidates that no border attracts aside.
  /// @param leaving  those of the held ones whose modes have just gone beyond a side, by rounding: where that is still
  ///                 their side they leave, though nothing moves them yet
  /// @param known    where the modes are not unique, those that they are to have: what decided about the diodes beside
  ///                 them took these
  /// @return those that move away from their border; none if nothing was decided, and all is as before
  std::optional<std::vector<Left>> decide(std::vector<std::size_t> candidates, const std::vector<std::size_t>& leaving,
                                          double t, const double* x, Branch& branch,
                                          const std::vector<GuardMode>& known = {});
  /// Of a guard that is held: it is not any more. The surplus are balanced with the others until the next decision.
  void release(std::size_t guard);
  /// Gives the held modes the values that keep their guards in place. False at a fault.
  bool balance(double t, const double* x, Branch& branch);
  /// Of rates with these values, those that are no more than what rounding leaves of a balance are 0: what is held at
  /// rest does not move, whatever its tolerance.
  void still(double* rates) const;
  /// Of those that are held, the guards that a jump has moved since they were last looked at, by more than what holds
  /// them would bring back with a move of the states of @p least tolerances: a belt whose speed jumps, a source between
  /// levels that were equal. What has drifted since the hold began is no jump.
  std::vector<Left> moved_by_jump(double t, const double* x, const Branch& branch, double least);
  /// Brings states back that have left the borders at which they are held: by an impulse of what holds them, which
  /// keeps what that keeps (the momentum of two masses that rub on each other). Rates that keep a guard where it is do
  /// not keep the states there to more than the integrator's errors, and these grow as fast as the guard's slope falls
  /// (Hairer and Wanner, Solving ODEs II, VII.2, on the drift of invariants).
  /// Here the guards are looked at.
  /// @param least  states are brought back when one is off by more than so many of its tolerances
  /// @return whether they were
  bool bring_back(double t, std::vector<double>& x, Branch& branch, double least);
  /// Positions of the outputs that depend on how the surplus and the others share what holds them, which nothing
  /// determines.
  /// @note  Cost: the outputs for each guard that is held, and a balance for each of the surplus.
  [[nodiscard]] std::vector<std::size_t> indefinite_outputs(double t, const double* x, const Branch& branch);
  /// How far the mode is from the nearer one of its sides: negative when it is beyond. Of one of the surplus: 1.
  [[nodiscard]] double margin(std::size_t guard, const Branch& branch) const;
  /// Whether it is one of the surplus.
  [[nodiscard]] bool rests(std::size_t guard) const;
  /// The side of the guard that a mode beyond its limit belongs to.
  [[nodiscard]] int side_of(std::size_t guard, double mode) const;

  template <class Archive>
  void carry(Archive& archive) {
    archive("held", held_);
    archive("surplus", surplus_);
    archive("seen", seen_);
    archive.check(seen_.size() == guards_.size());
    for (const std::size_t guard : held_) archive.check(guard < guards_.size());
    for (const std::size_t guard : surplus_) archive.check(guard < guards_.size());
  }

 private:
  [[nodiscard]] const Relation& relation(std::size_t guard) const {
    return program_.relations[evaluator_.guard_relation(guard)];
  }
  [[nodiscard]] double& mode(std::size_t guard, Branch& branch) const {
    return branch.modes[evaluator_.guard_relation(guard)];
  }
  [[nodiscard]] double mode_on(std::size_t guard, int side) const;
  bool measure(const std::vector<std::size_t>& guards, double t, const double* x, Branch& branch);
  [[nodiscard]] Eigen::MatrixXd falls(const std::vector<std::size_t>& guards) const;
  [[nodiscard]] ComplementarySides sides(const std::vector<std::size_t>& guards, const Eigen::MatrixXd& q,
                                         std::size_t before) const;
  void prefer(const std::vector<GuardMode>& known, const std::vector<std::size_t>& guards, const Eigen::MatrixXd& q,
              std::vector<double>& found) const;
  bool border(const std::vector<std::size_t>& guards, const std::vector<double>& values, const double* x,
              std::vector<double>& at) const;
  [[nodiscard]] double tolerances_between(const double* x, const std::vector<double>& other) const;
  bool same_force(const std::vector<std::size_t>& guards, double t, const std::vector<double>& at,
                  const Branch& branch);
  void hold(const std::vector<std::size_t>& guards, const std::vector<std::size_t>& positions, Eigen::MatrixXd q);
  bool stays(double t, const double* x, Branch& branch);
  bool guard_rates(const std::vector<std::size_t>& guards, double t, const double* x, Branch& branch,
                   Eigen::VectorXd& out);
  bool along_flow(const std::vector<std::size_t>& guards, double t, const double* x, const Branch& branch,
                  Eigen::VectorXd& out);
  bool differences(const std::vector<std::size_t>& guards, double t, const double* x, Branch& branch,
                   Eigen::VectorXd& out);

  const Program& program_;
  Evaluator& evaluator_;
  const Tolerances& tolerances_;
  double span_;
  std::span<const double> parameters_;
  std::optional<Enclosure> enclosure_;  ///< of the guards that can be held, made when one is
  std::vector<std::size_t> root_;       ///< by guard, in the enclosure
  std::vector<Jet> jets_;
  std::vector<double> widths_;        ///< scratch
  std::vector<std::size_t> held_;     ///< guards whose modes balance() finds
  std::vector<std::size_t> surplus_;  ///< guards that stay where they are if those do; their modes rest
  std::vector<double> rates_, moved_, guards_, moved_guards_;
  std::vector<double> seen_;                   ///< by guard: of those that are held, where it was when last looked at
  std::vector<double> base_rates_, rounding_;  ///< with modes of 0; how far the balanced rates can be off
  Eigen::MatrixXd rate_slopes_;                ///< by state, then mode
  Eigen::MatrixXd slopes_;                     ///< of the guards' rates, by guard, then mode
  Eigen::VectorXd base_, other_;
};

/// The guards of these laws that can be held. The modes of laws with a sign are known, those of others are not.
std::vector<GuardMode> guards_of(const Evaluator& evaluator, const std::vector<AtBorder>& laws);

/// Decides once which of these laws are held.
/// @param parameters  of the evaluator
void hold_at_border(Evaluator& evaluator, std::span<const double> parameters, const RunInputs& inputs,
                    const std::vector<AtBorder>& laws, double t, const double* x, Branch& branch);

}  // namespace bgsim
