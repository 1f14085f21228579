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

/// Whether the method has a form in which the loops' variables are unknowns of the integrator (IDA, Radau IIA,
/// Rodas5P).
bool solves_for_loops(const MethodFacts& facts);

/// Whether a run begins in that form: by IDA always, where the rates cannot be had otherwise, and by Radau IIA and
/// Rodas5P where a loop is nonlinear; `auto` is Radau IIA there for up to kDenseStates unknowns.
bool begins_with_loops(const Program& program, const RunInputs& inputs);

/// In that form: the method that the scene names, or for `auto` Radau IIA for up to kDenseStates unknowns, and IDA
/// for more of them and from @p multistep_since on, the time from which on Radau IIA did not get on, if that is given.
MethodChoice choose_method_with_loops(const Program& program, const RunInputs& inputs,
                                      std::optional<double> multistep_since);

/// With the loops solved inside the rates: the method that the scene names, or for `auto` Radau IIA for systems of up
/// to kDenseStates states, BDF for those with nonlinear loops, and for larger ones what @p stiffness says (nothing
/// known: BDF): BDF, or Dormand and Prince's explicit method (Method::erk5). BDF from @p multistep_since on, if that is
/// given: the time from which on the other method did not get on. Reasons: docs/design/simulate.md; the table behind
/// them: scripts/bench methods.
MethodChoice choose_method(const Program& program, const RunInputs& inputs, std::optional<double> multistep_since,
                           const StiffnessWatch* stiffness = nullptr);

}  // namespace bgsim
