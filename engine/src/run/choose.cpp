#include "run/choose.hpp"

#include <algorithm>

#include "bgsim/text.hpp"
#include "run/integrate/integrator.hpp"

namespace bgsim {

namespace {

/// Of many states: what the run has found so far.
MethodChoice by_stiffness(const std::string& loops, const StiffnessWatch* stiffness_watch) {
  if (stiffness_watch == nullptr) return {Method::bdf, loops + "; many states"};
  const StiffnessWatch& stiffness = *stiffness_watch;
  const std::string since = " from t = " + number_text(stiffness.since()) + " on";
  if (stiffness.is_explicit())
    return {Method::erk5,
            loops + "; many states, and " + (stiffness.changes() > 0 ? "not stiff" + since : "not stiff") +
                ": an explicit step may be " + number_text(stiffness.stable_step(), 2) + " long for the fastest mode"};
  if (stiffness.changes() > 0)
    return {Method::bdf, loops + "; many states, and stiff" + since + ": the fastest mode held explicit steps to " +
                             number_text(stiffness.stable_step(), 2)};
  return {Method::bdf, loops + "; many states"};
}

/// Of the loops that rates need.
bool any_nonlinear(const Program& program) {
  return std::any_of(program.rates.solves.begin(), program.rates.solves.end(),
                     [&](std::uint32_t block) { return !program.blocks[block].linear; });
}

bool are_few(const Program& program) { return program.state_names.size() + program.tear_names.size() <= kDenseStates; }

}  // namespace

bool solves_for_loops(const MethodFacts& facts) {
  return facts.method == Method::ida || facts.family == MethodFamily::collocation ||
         facts.family == MethodFamily::rosenbrock;
}

bool begins_with_loops(const Program& program, const RunInputs& inputs) {
  if (program.state_names.empty() || program.blocks.empty()) return false;
  if (!program.plan.explicit_form) return true;
  // As unknowns that no rate needs, they are followed by nothing but an iteration that does not look at them.
  if (program.rates.solves.empty()) return false;
  if (inputs.method == Method::ida) return true;
  if (inputs.method == Method::automatic) return inputs.max_order == 0 && are_few(program) && any_nonlinear(program);
  return solves_for_loops(facts_of(inputs.method)) && any_nonlinear(program);
}

MethodChoice choose_method_with_loops(const Program& program, const RunInputs& inputs,
                                      std::optional<double> multistep_since) {
  if (solves_for_loops(facts_of(inputs.method))) return {inputs.method, "asked for"};
  if (inputs.method == Method::automatic && inputs.max_order == 0 && are_few(program)) {
    if (multistep_since)
      return {Method::ida, "loops are unknowns of the integrator, by IDA from t = " + number_text(*multistep_since) +
                               " on: Radau IIA did not get on"};
    return {Method::radau, "nonlinear loops are unknowns of the integrator; few of them and few states"};
  }
  return {Method::ida, program.plan.explicit_form ? "a loop is too large to be solved inside the state equations"
                                                  : "eliminating the loops would fill the Jacobian"};
}

MethodChoice choose_method(const Program& program, const RunInputs& inputs, std::optional<double> multistep_since,
                           const StiffnessWatch* stiffness) {
  if (inputs.method != Method::automatic) return {inputs.method, "asked for"};
  const bool many = program.state_names.size() > kDenseStates;
  const std::string loops =
      program.blocks.empty() ? "state equations without loops" : "loops are solved inside the state equations";
  if (multistep_since)
    return {Method::bdf, loops + ", by BDF from t = " + number_text(*multistep_since) +
                             " on: " + (many ? "the explicit method" : "Radau IIA") + " did not get on"};
  if (inputs.max_order > 0) return {Method::bdf, loops + "; an order can be limited in BDF"};
  // Up to here Radau is the cheapest at equal error, of stiff lines, oscillators and laws with events alike; above, the
  // matrices of BDF are sparse, and it takes a third to a half of the time on lines (bench methods --random).
  if (many) return by_stiffness(loops, stiffness);
  if (any_nonlinear(program)) return {Method::bdf, loops + ", which are nonlinear"};
  return {Method::radau, loops + "; few states"};
}

}  // namespace bgsim
