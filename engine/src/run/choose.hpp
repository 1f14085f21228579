/// Which method `auto` means.
#pragma once

#include <optional>
#include <string>

#include "bgsim/program.hpp"
#include "run/watch/stiffness.hpp"

namespace bgsim {

/// A method, and why; the reason is a line of the report.
struct MethodChoice {
  Method method = Method::automatic;
  std::string reason;
};

/// For a system in explicit form: the method that the scene names, or for `auto` Radau IIA for systems of up to
/// kDenseStates states, BDF for those with nonlinear loops, and for larger ones what @p stiffness says (nothing known:
/// BDF): BDF, or Dormand and Prince's explicit method (Method::erk5). BDF from @p multistep_since on, if that is given:
/// the time from which on the other method did not get on. Reasons: docs/design/simulate.md; the table behind them:
/// scripts/bench methods.
MethodChoice choose_method(const Program& program, const RunInputs& inputs, std::optional<double> multistep_since,
                           const StiffnessWatch* stiffness = nullptr);

}  // namespace bgsim
