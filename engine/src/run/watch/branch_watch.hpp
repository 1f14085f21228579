/// Whether nonlinear loops stay on the solution that they started from.
#pragma once

#include <optional>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "run/integrate/integrator.hpp"

namespace bgsim {

/// Where a law folds back, the solution of its loop ends, and the iteration finds another one, far away: a jump that no
/// law of the model speaks of. Only the change over an accepted step shows it.
class BranchWatch {
 public:
  BranchWatch(const Program& program, Evaluator& evaluator, double start, double stop);

  /// From here on: the solution of the loops after a restart, which a change of modes may have put anywhere.
  void begin(const Integrator& integrator);
  /// The integrator's last step. To be called before anything else is evaluated: its last evaluation is that of the
  /// step's end, or nearly so.
  ///
  /// @return  the jump in it, if there is one: to a solution on the other side of a fold, where the determinant of the
  ///          loop's equations has the other sign, or a change that stays however short the time in which it happens.
  ///          What rounding of the loop's terms can have moved is no change, and what goes on changing as fast after it
  ///          is no jump: the first step of a motion from rest may have the length of a rounding of the time.
  /// @note  Cost: a comparison for each loop variable; some ten solutions of the loops where one changes by a tenth or
  ///        more within a step.
  std::optional<Diagnostic> check(Integrator& integrator);

  /// Of a snapshot, after which begin() is called.
  template <class Archive>
  void carry(Archive& archive) {
    archive("largest", largest_);
  }

 private:
  struct Change {
    double size = 0.0;  ///< as a part of the loop variable's largest magnitude
    std::size_t tear = 0;
  };
  /// @param rounding  by tear; empty: none
  [[nodiscard]] Change change(const std::vector<double>& from, const std::vector<double>& to,
                              const std::vector<double>& rounding) const;
  [[nodiscard]] std::vector<double> rounding_at(double t);
  bool goes_on(Integrator& integrator, double from, double to, std::size_t tear);
  bool solve(Integrator& integrator, double t, const std::vector<double>& start, std::vector<double>& solution);
  bool solve_at(Integrator& integrator, double t, const std::vector<double>& start, std::vector<double>& solution);
  template <class SolveAt>
  std::optional<Change> narrow(double& from, double& to, const std::vector<double>& rounding, SolveAt solve_in_between);
  std::optional<Diagnostic> look_between(Integrator& integrator);
  [[nodiscard]] const ProgramBlock& block_of(std::size_t tear) const;

  const Program& program_;
  Evaluator& evaluator_;
  bool any_ = false;
  double ripe_;                   ///< time from which it is known what is large
  std::vector<bool> watched_;     ///< by tear: of a nonlinear loop
  std::vector<int> orientation_;  ///< by block
  std::vector<double> last_states_;
  std::vector<double> last_, now_, low_, high_, middle_, largest_, y_;
  Branch probe_;
};

}  // namespace bgsim
