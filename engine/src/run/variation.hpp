/// Sensitivities at events: what the run of a system with Variations does where a condition changes.
#pragma once

#include <optional>
#include <vector>

#include "bgsim/evaluator.hpp"

namespace bgsim {

/// Where conditions change, the instant of the event depends on the parameter, too: with t' its derivative, the
/// sensitivities of the states jump by (f- - f+) t', f- and f+ being the rates before and after.
class VariationEvents {
 public:
  /// @return BG414 if a condition that decides rates is at its border at the start of the run, and moves away from it.
  static std::optional<Diagnostic> begin(Evaluator& evaluator, double t, double span, const std::vector<double>& x,
                                         const Branch& branch);
  /// Takes the sensitivities in @p x across an event.
  /// @param x        the states and their sensitivities, which jump
  /// @param before, after  the event
  /// @param crossed  the relation whose guard was found at its border; none at a known time
  /// @param span     length of the run
  /// @return BG414 where the derivative does not exist or cannot be found.
  std::optional<Diagnostic> take(Evaluator& evaluator, double t, double span, std::vector<double>& x,
                                 const Branch& before, const Branch& after, std::optional<std::size_t> crossed);

 private:
  /// A condition that has changed, and what its instant changes by with the parameter.
  struct Change {
    std::size_t relation = 0;
    double instant = 0.0;
    double before = 0.0, after = 0.0;  ///< its mode
  };
  [[nodiscard]] bool matters(Evaluator& evaluator, double t, const std::vector<double>& x, const Branch& after,
                             double instant) const;

  // What has changed at one time, maybe by several events of the run.
  double time_ = 0.0;
  std::optional<Branch> start_;
  std::vector<Change> changes_;
};

/// BG414: signs of resistors are held at their border, where rates are no expressions of the states.
Diagnostic held_variation_failure(const Program& program, double t);
/// BG414: a law ends at the border of its own condition.
Diagnostic ended_law_failure(double t);

}  // namespace bgsim
