/// When BDF has to stay below the orders in which eigenmodes that are over would live on.
#pragma once

#include <optional>

#include "run/integrate/spectrum.hpp"

namespace bgsim {

/// Looks at the eigenvalues now and then: seldom, so that the cost does not show in a run. For `actuator` (theory.md).
class ModeOrder {
 public:
  ModeOrder(const Program& program, Evaluator& evaluator, const RunInputs& inputs);

  void begin(double t) { looked_at_time_ = t; }
  /// At an accepted step. True if the order has to fall now: the integrator has to start again with order().
  bool look(double t, const double* x, const Branch& branch, std::uint64_t steps);
  [[nodiscard]] const std::optional<SpentMode>& spent() const { return spent_; }

  template <class Archive>
  void carry(Archive& archive) {
    archive("looked at step", looked_at_step_);
    archive("looked at time", looked_at_time_);
    archive("spent", spent_);
  }

 private:
  const Program& program_;
  Evaluator& evaluator_;
  double span_;
  bool possible_;
  std::uint64_t looked_at_step_ = 0;
  double looked_at_time_ = 0.0;
  std::optional<SpentMode> spent_;
};

}  // namespace bgsim
