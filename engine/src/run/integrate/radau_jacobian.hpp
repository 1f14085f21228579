/// The Jacobians that Newton's iteration of a step by Radau IIA is made with.
#pragma once

#include <functional>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "run/integrate/border_slopes.hpp"
#include "run/integrate/integrator.hpp"
#include "run/integrate/residual_rounding.hpp"

namespace bgsim {

class Tolerances;

/// Unknowns of an integrator that has the loops where @p loops says.
inline const Sparsity& pattern_of(const Program& program, Loops loops) {
  return loops == Loops::inside ? program.jacobian_pattern : program.implicit_pattern;
}

/// At the beginning of a step for all stages, or at each stage.
class RadauJacobian {
 public:
  /// Of the rates by the states, or of f and -F by all unknowns (see Loops).
  /// @param dense  full matrices, column by column, else the entries by the pattern
  RadauJacobian(const Program& program, Evaluator& evaluator, Tolerances& tolerances, bool dense, Loops loops);

  /// Where a step begins.
  struct Beginning {
    double t;
    double ahead;  ///< how far on a slope without bound is taken instead
    const std::vector<double>& x;
    const std::vector<double>& rate;
    Branch& branch;
  };
  using Rates = std::function<bool(const double* x, double* out)>;

  /// A new stretch, which may begin beside a border of a law.
  void begin();
  /// After a step that was accepted.
  void stepped();

  /// @param rates    at the beginning's time, for columns by differences
  /// @param derived  whether the program's own slopes are those of these rates
  /// @return  false where there are no slopes
  bool see(const Beginning& at, const Rates& rates, bool derived);
  /// At the rounding of the rates, which the tolerances are shown: by the program's slopes, also where these are not
  /// those of the rates (which hold a friction).
  void look(const Beginning& at);
  /// Whether the last see() found what the one before it had found.
  [[nodiscard]] bool is_as_before() const { return as_before_; }
  /// What the last see() found.
  [[nodiscard]] const double* values() const { return dense_ ? full_.data() : entries_.data(); }

  /// At a stage, as a full matrix. Changes nothing that values() gives.
  bool see_stage(double t, const double* x, Branch& branch, double* full);

 private:
  static constexpr int kStepsBetweenLooks = 20;
  bool slopes(double t, const double* y, Branch& branch, double* entries);
  bool by_differences(const Beginning& at, const Rates& rates);
  void show_tolerances(const Beginning& at);
  void slopes_beside_border(double t, const double* x, const Branch& branch);
  bool take_beside(double t, const double* x, const Branch& branch);
  [[nodiscard]] double tolerance_at(const double* x, std::size_t j) const;
  bool slopes_aside(double t, const double* x, const Branch& branch, double* entries);

  Evaluator& evaluator_;
  Tolerances& tolerances_;
  const Sparsity& pattern_;
  Loops loops_;
  bool dense_, as_before_ = false;
  int steps_since_look_ = kStepsBetweenLooks;  ///< at the rounding of the rates, which Tolerances are shown
  ResidualRounding residuals_;
  BorderSlopes border_;
  std::vector<double> entries_, seen_, full_, rounding_;  ///< seen_: what values() was made of; empty: of differences
  // Scratch
  Branch aside_;
  std::vector<double> at_;
};

}  // namespace bgsim
