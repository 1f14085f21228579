#include "study/mode_programs.hpp"

#include <algorithm>
#include <tuple>

#include "bgsim/evaluator.hpp"
#include "equations/solvable_causality.hpp"
#include "graph/law_numbers.hpp"

namespace bgsim {

namespace {

/// A model in which nothing is stored, with the time as a state.
Model with_clock(Model model) {
  Signal clock;
  clock.name = kModeClock;
  clock.kind = Signal::Kind::integral;
  clock.value = model.pool.constant(1.0);
  ModelSymbol meaning;
  meaning.kind = ModelSymbol::Kind::signal;
  meaning.signal = SignalId(model.signals.size());
  clock.symbol = SymbolId(model.symbols.size());
  model.symbols.push_back(meaning);
  model.signals.push_back(std::move(clock));
  return model;
}

Model with_resistors(Model model) {
  for (Element& element : model.elements)
    if (is_switch(element.kind)) {
      element.kind = ElementKind::resistor;
      element.coefficient = model.pool.constant(1.0);
    }
  return model;
}

/// Whether an expression follows from states, time and parameters without the law of any switch.
bool free_of_switches(const Model& model, const EquationSystem& system, ExprId root) {
  std::vector<ExprId> open{root};
  std::vector<bool> seen(system.pool.size(), false);
  while (!open.empty()) {
    const ExprId e = open.back();
    open.pop_back();
    if (!e.valid() || seen[e.index()]) continue;
    seen[e.index()] = true;
    const ExprNode& node = system.pool[e];
    if (node.op == Op::constant) continue;
    if (node.op != Op::symbol) {
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) open.emplace_back(children[k]);
      continue;
    }
    const SystemSymbol& symbol = system.symbols[node.a];
    if (symbol.kind != SystemSymbol::Kind::unknown) continue;
    const Equation& equation = system.equations[symbol.index];
    if (equation.element.valid() && model.elements[equation.element.index()].switches) return false;
    open.push_back(equation.expression);
  }
  return true;
}

void sort_by_key(std::vector<RunInputs::Initial>& values) {
  std::sort(values.begin(), values.end(), [](const auto& a, const auto& b) {
    return std::tuple(a.element, a.port, a.signal) < std::tuple(b.element, b.port, b.signal);
  });
}

}  // namespace

std::unique_ptr<ModePrograms::Made> ModePrograms::make(std::shared_ptr<const Model> model,
                                                       const CompileOptions& options) {
  auto made = std::make_unique<Made>();
  made->model = std::move(model);
  made->graph = build_bond_graph(*made->model);
  made->causal = solvable_causality(*made->model, made->graph);
  EquationSystem system = derive_equations(*made->model, made->graph, made->causal);
  if (system.states.empty()) {
    made->model = std::make_shared<const Model>(with_clock(*made->model));
    made->causal = solvable_causality(*made->model, made->graph);
    system = derive_equations(*made->model, made->graph, made->causal);
  }
  for (const SwitchEquation& at : system.switches)
    made->certain.push_back(free_of_switches(*made->model, system, at.leaves));
  const BlockOrder order = order_equations(*made->model, system);
  made->program = compile(made->model, system, order, options);
  return made;
}

const Program& ModePrograms::at(const Mode& mode, const std::vector<double>& parameters) {
  const std::scoped_lock lock(mutex_);
  std::unique_ptr<Made>& made = made_[mode];
  if (!made) made = make(std::make_shared<const Model>(in_mode(*model_, mode)), options_);
  check_laws(*made->model, made->graph, made->causal, parameters);
  return made->program;
}

SwitchedStart ModePrograms::start(const RunInputs& inputs) {
  SwitchedStart start{mode_of(*model_), {inputs.start, inputs.initial}};
  const std::scoped_lock lock(mutex_);
  if (!looked_without_) {
    looked_without_ = true;
    try {
      without_switches_ = make(std::make_shared<const Model>(with_resistors(*model_)), {{}, false});
    } catch (const ModelError&) {
      // The graph does not allow resistors there. The run finds its first mode from that of the model as read.
    }
  }
  if (!without_switches_) return start;
  const Program& program = without_switches_->program;
  Evaluator evaluator(program, inputs.parameters);
  const std::vector<double> x = initial_states(evaluator, inputs);
  Branch branch = first_branch(program);
  std::vector<double> dependent(program.dependent.size()), closes(program.switch_elements.size());
  if (!evaluator.initialize_modes(inputs.start, x.data(), branch)) return start;
  if (evaluator.dependents(inputs.start, x.data(), branch, dependent.data())) {
    start.stored.values.clear();
    const auto keep = [&](const StateInfo& state, double value) {
      start.stored.values.push_back({state.element, state.port, value, state.place, state.signal});
    };
    for (std::size_t i = 0; i < x.size(); ++i) keep(program.states[i], x[i]);
    for (std::size_t i = 0; i < dependent.size(); ++i) keep(program.dependent[i], dependent[i]);
    sort_by_key(start.stored.values);
  }
  if (!evaluator.switches(inputs.start, x.data(), branch, closes.data())) return start;
  for (std::size_t i = 0; i < closes.size(); ++i)
    if (!model_->elements[program.switch_elements[i].index()].switches->remembers)
      start.mode[i] = without_switches_->certain[i] && closes[i] != 0.0;
  return start;
}

}  // namespace bgsim
