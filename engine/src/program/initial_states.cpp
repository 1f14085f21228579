#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "bgsim/evaluator.hpp"

namespace bgsim {
namespace {

/// A given value of a dependent store may be rounded by hand, not wrong.
constexpr double kAgreement = 1e-9;

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

/// The states that a dependent store's value is computed from.
std::string determining_states(const EquationSystem& system, std::size_t dependent, const Program& program) {
  const ExprId root = program.slot_expression[program.dependents.results[dependent]];
  const std::vector<ExprId> roots{root};
  std::string names;
  for (const SymbolId symbol : symbols_in(program.pool, roots)) {
    if (symbol.index() >= system.symbols.size()) continue;
    const SystemSymbol::Kind kind = system.symbols[symbol.index()].kind;
    if (kind == SystemSymbol::Kind::state || kind == SystemSymbol::Kind::unknown || kind == SystemSymbol::Kind::time)
      names += (names.empty() ? "" : ", ") + system.symbols[symbol.index()].name;
  }
  return names;
}

}  // namespace

std::vector<double> initial_states(const Model& model, const EquationSystem& system, Evaluator& evaluator,
                                   const RunInputs& inputs) {
  std::vector<double> x(system.states.size(), 0.0);
  const auto given = [&](ElementId element, std::uint32_t port, SignalId signal = {}) {
    const std::tuple key(element, port, signal);
    const auto key_of = [](const RunInputs::Initial& i) { return std::tuple(i.element, i.port, i.signal); };
    const auto at = std::lower_bound(inputs.initial.begin(), inputs.initial.end(), key,
                                     [&](const RunInputs::Initial& i, const auto& k) { return key_of(i) < k; });
    return at != inputs.initial.end() && key_of(*at) == key ? at : inputs.initial.end();
  };
  if (inputs.initial.empty()) return x;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (const auto it = given(system.states[i].element, system.states[i].port, system.states[i].signal);
        it != inputs.initial.end())
      x[i] = it->value;
  const bool any_dependent = std::any_of(system.dependent.begin(), system.dependent.end(), [&](const auto& store) {
    return given(store.element, store.port) != inputs.initial.end();
  });
  if (!any_dependent) return x;

  std::vector<double> values(system.dependent.size());
  std::vector<Diagnostic> problems;
  if (!evaluator.initialize_modes(inputs.start, x.data()) ||
      !evaluator.dependents(inputs.start, x.data(), values.data()))
    return x;  // the run itself reports the fault, with its time
  for (std::size_t i = 0; i < values.size(); ++i) {
    const DependentStore& store = system.dependent[i];
    const auto it = given(store.element, store.port);
    if (it == inputs.initial.end()) continue;
    if (std::abs(it->value - values[i]) <= kAgreement * std::max(std::abs(it->value), std::abs(values[i]))) continue;
    const std::string states = determining_states(system, i, evaluator.program());
    Diagnostic problem{Severity::error, "BG405", {}, it->place, {}, {}, {}};
    problem.situation = "the initial value " + store.name + " = " + number(it->value) + " contradicts " +
                        (states.empty() ? "the sources" : states) + ", from which it is " + number(values[i]);
    for (const State& state : system.states) {
      if (states.find(state.name) == std::string::npos) continue;
      const auto of_state = given(state.element, state.port, state.signal);
      const std::size_t k = static_cast<std::size_t>(&state - system.states.data());
      problem.notes.push_back({of_state != inputs.initial.end() && of_state->place
                                   ? of_state->place
                                   : std::optional<Place>(place_of(model, state)),
                               std::string(state.element.valid() ? "independent store: " : "integral: ") + state.name +
                                   " = " + number(x[k]) + (of_state == inputs.initial.end() ? " (by default)" : "")});
    }
    problem.rule =
        "only independent stores have initial values of their own; a store in derivative causality follows them";
    problem.help = "give the initial values of the independent stores, and leave out " + store.name;
    problems.push_back(std::move(problem));
  }
  if (!problems.empty()) throw ModelError(std::move(problems), model.sources);
  return x;
}

}  // namespace bgsim
