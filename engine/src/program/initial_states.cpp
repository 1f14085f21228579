#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "base/codes.hpp"
#include "bgsim/evaluator.hpp"
#include "bgsim/text.hpp"

namespace bgsim {
namespace {

/// A given value of a dependent store may be rounded by hand, not wrong.
constexpr double kAgreement = 1e-9;

/// The states that a dependent store's value is computed from, through loops as well, and the time; loops' variables
/// where there are none.
std::string determining_states(const Program& program, std::size_t dependent) {
  std::vector<ExprId> open{program.slot_expression[program.dependents.results[dependent]]};
  std::vector<bool> taken(program.blocks.size(), false);
  std::vector<std::string> names, of_loops;
  while (!open.empty()) {
    const std::vector<ExprId> roots = std::exchange(open, {});
    for (const SymbolId symbol : symbols_in(program.pool, roots)) {
      const std::string& name = program.symbol_names[symbol.index()];
      const auto among = [&](const std::vector<std::string>& all) { return std::find(all.begin(), all.end(), name); };
      if (const auto tear = among(program.tear_names); tear != program.tear_names.end()) {
        if (std::find(of_loops.begin(), of_loops.end(), name) == of_loops.end()) of_loops.push_back(name);
        const auto which = static_cast<std::size_t>(tear - program.tear_names.begin());
        const std::uint32_t block = program.plan.block_of_tear[which];
        if (!taken[block])
          for (const std::uint32_t slot : program.blocks[block].residual.results)
            open.push_back(program.slot_expression[slot]);
        taken[block] = true;
      } else if ((symbol == program.time || among(program.state_names) != program.state_names.end()) &&
                 std::find(names.begin(), names.end(), name) == names.end()) {
        names.push_back(name);
      }
    }
  }
  std::string text;
  for (const std::string& name : names.empty() ? of_loops : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// How far the dependent stores' values can be off by rounding alone.
std::vector<double> bounds_of(Evaluator& evaluator, const RunInputs& inputs, const std::vector<double>& x,
                              const std::vector<double>& errors, Branch& branch) {
  std::vector<double> bounds(evaluator.program().dependent.size());
  evaluator.dependent_rounding(inputs.start, x.data(), branch, errors, inputs.rounding, bounds.data());
  for (double& bound : bounds)
    if (!std::isfinite(bound)) bound = 0.0;
  return bounds;
}

}  // namespace

std::vector<double> initial_states(Evaluator& evaluator, const RunInputs& inputs) {
  const Program& program = evaluator.program();
  std::vector<double> x(program.states.size(), 0.0), errors = x;
  const auto given = [&](ElementId element, std::uint32_t port, SignalId signal = {}) {
    const std::tuple key(element, port, signal);
    const auto key_of = [](const RunInputs::Initial& i) { return std::tuple(i.element, i.port, i.signal); };
    const auto at = std::lower_bound(inputs.initial.begin(), inputs.initial.end(), key,
                                     [&](const RunInputs::Initial& i, const auto& k) { return key_of(i) < k; });
    return at != inputs.initial.end() && key_of(*at) == key ? at : inputs.initial.end();
  };
  if (inputs.initial.empty()) return x;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (const auto it = given(program.states[i].element, program.states[i].port, program.states[i].signal);
        it != inputs.initial.end()) {
      x[i] = it->value;
      errors[i] = it->rounding;
    }
  const bool any_dependent = std::any_of(program.dependent.begin(), program.dependent.end(), [&](const auto& store) {
    return given(store.element, store.port) != inputs.initial.end();
  });
  if (!any_dependent) return x;

  std::vector<double> values(program.dependent.size());
  std::vector<Diagnostic> problems;
  Branch branch = first_branch(program);
  if (!evaluator.initialize_modes(inputs.start, x.data(), branch) ||
      !evaluator.dependents(inputs.start, x.data(), branch, values.data()))
    return x;  // the run itself reports the fault, with its time
  const std::vector<double> bounds = bounds_of(evaluator, inputs, x, errors, branch);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string& name = program.dependent_names[i];
    const auto it = given(program.dependent[i].element, program.dependent[i].port);
    if (it == inputs.initial.end()) continue;
    const double apart = std::abs(it->value - values[i]);
    if (apart <= kAgreement * std::max(std::abs(it->value), std::abs(values[i]))) continue;
    if (apart <= bounds[i] + it->rounding) continue;
    const std::string states = determining_states(program, i);
    Diagnostic problem = diagnostic_of("BG405", {}, it->place);
    problem.situation = "the initial value " + name + " = " + number_text(it->value) + " contradicts " +
                        (states.empty() ? "the sources" : states) + ", from which " + number_text(values[i] + 0.0) +
                        " follows";  // -0 is 0
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (states.find(program.state_names[k]) == std::string::npos) continue;
      const StateInfo& state = program.states[k];
      const auto of_state = given(state.element, state.port, state.signal);
      problem.notes.push_back({of_state != inputs.initial.end() && of_state->place ? of_state->place : state.place,
                               (state.element.valid() ? "independent store: " : "integral: ") + program.state_names[k] +
                                   " = " + number_text(x[k]) +
                                   (of_state == inputs.initial.end() ? " (by default)" : "")});
    }
    problem.rule =
        "only independent stores have initial values of their own; a store in derivative causality follows them";
    problem.help = "give the initial values of the independent stores, and leave out " + name;
    problems.push_back(std::move(problem));
  }
  if (!problems.empty()) throw ModelError(std::move(problems), program.model->sources);
  return x;
}

}  // namespace bgsim
