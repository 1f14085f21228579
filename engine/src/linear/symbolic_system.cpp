#include "linear/symbolic_system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "equations/solvable_causality.hpp"
#include "graph/law_numbers.hpp"
#include "linear/partials.hpp"

namespace bgsim {

std::vector<std::pair<std::string, double>> SymbolicSystem::values_in(const std::vector<PowerSum>& sums) const {
  std::set<SymbolId> symbols;
  std::set<Atom> slopes;
  for (const PowerSum& sum : sums) ring->symbols_of(sum, symbols, slopes);
  std::vector<std::pair<std::string, double>> values;
  for (const SymbolId symbol : symbols)
    if (system.symbols[symbol.index()].kind != SystemSymbol::Kind::parameter)
      values.emplace_back(system.symbols[symbol.index()].name, numbers[symbol.index()]);
  for (const Atom slope : slopes) values.emplace_back(ring->text(slope, names()), ring->value(slope));
  return values;
}

namespace {

class FlowBuilder {
 public:
  using Node = SignalFlow::Node;

  explicit FlowBuilder(SymbolicSystem& symbolic) : symbolic_(symbolic) {
    const EquationSystem& system = symbolic.system;
    const std::size_t nodes = system.symbols.size() + 1;
    flow_.out.resize(nodes);
    flow_.in.resize(nodes);
    flow_.element_of.resize(nodes);
    flow_.output = static_cast<Node>(system.symbols.size());
    for (const auto& [symbol, order] : symbolic.deviation)
      if (order == 0) flow_.input = symbol.value;
    // What rests at 0 at the point, deviations among them, is 0 in all slopes.
    for (std::size_t s = 0; s < system.symbols.size(); ++s)
      if (system.symbols[s].kind != SystemSymbol::Kind::parameter && symbolic.numbers[s] == 0.0)
        zero_[SymbolId(s)] = symbolic.pool.constant(0.0);
    for (const Equation& equation : system.equations)
      if (symbolic.order.resolved[equation.unknown.index()].valid()) add_equation(equation);
    for (const std::uint32_t s : symbolic.states) {
      const State& state = system.states[s];
      for (const auto& [symbol, partial] : partials(state.rate)) add(symbol, state.symbol.value, partial, -1);
      if (state.element.valid())
        name(state.symbol.value, state.element);
      else
        flow_.element_of[state.symbol.index()] = state.name;
    }
    for (const auto& [symbol, partial] : partials(system.outputs.front().value)) add(symbol, flow_.output, partial, 0);
    for (const SymbolId signal : system.signals)
      if (flow_.element_of[signal.index()].empty() && !symbolic.deviation.contains(signal))
        flow_.element_of[signal.index()] = system.symbols[signal.index()].name;
  }
  SignalFlow result() { return std::move(flow_); }

 private:
  std::vector<std::pair<SymbolId, ExprId>> partials(ExprId value) {
    return gradient(symbolic_.pool, value, [&](SymbolId symbol) {
      const auto kind = symbolic_.system.symbols[symbol.index()].kind;
      return kind == SystemSymbol::Kind::state || kind == SystemSymbol::Kind::unknown;
    });
  }

  void add_equation(const Equation& equation) {
    const auto all = partials(equation.expression);
    name(equation.unknown.value, equation.element);
    ExprId own;
    for (const auto& [symbol, partial] : all)
      if (equation.implicit && symbol == equation.unknown) own = partial;
    for (const auto& [symbol, partial] : all) {
      if (!equation.implicit)
        add(symbol, equation.unknown.value, partial, 0);
      else if (symbol != equation.unknown && own.valid())
        add(symbol, equation.unknown.value, symbolic_.pool.neg(symbolic_.pool.div(partial, own)), 0);
    }
  }

  [[nodiscard]] std::string words(Node node, bool rate) const {
    const std::string own = node == flow_.output ? symbolic_.output : symbolic_.system.symbols[node].name;
    return rate ? own + "'" : own;
  }

  void add(SymbolId from, Node to, ExprId partial, int integrals) {
    partial = substitute(symbolic_.pool, partial, zero_);
    PowerSum gain = symbolic_.ring->sum_of(partial);
    std::set<SymbolId> symbols;
    std::set<Atom> slopes;
    symbolic_.ring->symbols_of(gain, symbols, slopes);
    const bool moves = std::any_of(symbols.begin(), symbols.end(), [&](SymbolId symbol) {
      return symbolic_.system.symbols[symbol.index()].kind != SystemSymbol::Kind::parameter;
    });
    if (moves && !symbolic_.ring->is_product(gain)) {
      const double value = evaluate(symbolic_.pool, partial, symbolic_.numbers);
      if (value == 0.0) return;
      gain = power_of(
          symbolic_.ring->slope("slope(" + words(to, integrals < 0) + ", " + words(from.value, false) + ")", value), 1);
    }
    gain = shifted(gain, kLaplace, integrals);
    Node node = from.value;
    if (const auto found = symbolic_.deviation.find(from); found != symbolic_.deviation.end()) {
      // The chain of the input's derivatives is the input times powers of s.
      gain = shifted(gain, kLaplace, found->second);
      node = flow_.input;
    }
    if (gain.empty()) return;
    for (const std::uint32_t edge : flow_.out[node])
      if (flow_.edges[edge].to == to) {
        add_to(flow_.edges[edge].gain, gain);
        return;
      }
    const auto number = static_cast<std::uint32_t>(flow_.edges.size());
    flow_.edges.push_back({node, to, std::move(gain)});
    flow_.out[node].push_back(number);
    flow_.in[to].push_back(number);
  }

  void name(Node node, ElementId element) {
    if (!element.valid()) return;
    const Element& own = symbolic_.model->elements[element.index()];
    if (!is_junction(own.kind)) flow_.element_of[node] = own.name;
  }

  SymbolicSystem& symbolic_;
  SignalFlow flow_;
  std::unordered_map<SymbolId, ExprId> zero_;
};

}  // namespace

SignalFlow signal_flow(SymbolicSystem& symbolic) { return FlowBuilder(symbolic).result(); }

std::unique_ptr<SymbolicSystem> symbolic_system(const std::shared_ptr<const Model>& model, const RunInputs& point,
                                                const std::string& input) {
  refuse_delays(*model);
  Model wanted = *model;
  wanted.events.clear();                                     // as linear_system() does
  for (Scene& scene : wanted.scenes) scene.outputs.clear();  // which may name others
  wanted.outputs = {model->outputs[point.outputs.front()]};
  const PerturbedModel perturbed = perturbed_model(wanted, point, {input});
  const BondGraph graph = build_bond_graph(*perturbed.model);
  const CausalGraph causal = solvable_causality(*perturbed.model, graph);
  check_laws(*perturbed.model, graph, causal, point.parameters);
  auto made = std::make_unique<SymbolicSystem>();
  made->model = perturbed.model;
  made->input = perturbed.inputs.front().name;
  made->output = wanted.outputs.front().name;
  made->system = derive_equations(*perturbed.model, graph, causal);
  made->order = order_equations(*perturbed.model, made->system);
  made->pool = made->order.pool;
  const EquationSystem& system = made->system;
  RunInputs at = point;
  at.outputs.clear();
  std::vector<double> x, tears;
  std::vector<double>& numbers = made->numbers;
  numbers.assign(system.symbols.size(), std::numeric_limits<double>::quiet_NaN());
  {
    const Program program = compile(perturbed.model, system, made->order, {{}, false});
    Evaluator evaluator(program, point.parameters);
    x = initial_states(evaluator, at);
    tears = partials_at(perturbed.model, system, made->order, {point.start, point.parameters, x, {}}, false).loop;
  }
  numbers[system.time.index()] = point.start;
  for (std::size_t i = 0; i < point.parameters.size(); ++i) numbers[system.parameters[i].index()] = point.parameters[i];
  for (std::size_t i = 0; i < x.size(); ++i) numbers[system.states[i].symbol.index()] = x[i];
  std::size_t tear = 0;
  for (const Block& block : made->order.blocks)
    for (const SymbolId symbol : block.tears) numbers[symbol.index()] = tears[tear++];
  // The other unknowns, from these.
  for (std::size_t s = 0; s < system.symbols.size(); ++s)
    if (std::isnan(numbers[s]) && s < made->order.resolved.size() && made->order.resolved[s].valid())
      numbers[s] = evaluate(made->order.pool, made->order.resolved[s], numbers);
  for (std::uint32_t s = 0; s < system.states.size(); ++s) {
    const SignalId signal = system.states[s].signal;
    const auto& chain = perturbed.inputs.front().chain;
    const auto found = std::find(chain.begin(), chain.end(), signal);
    if (signal.valid() && found != chain.end())
      made->deviation[system.states[s].symbol] = static_cast<int>(found - chain.begin());
    else
      made->states.push_back(s);
  }
  const std::vector<SystemSymbol>& symbols = system.symbols;
  made->ring.emplace(made->pool, numbers, [&symbols, &numbers](SymbolId symbol) {
    return symbols[symbol.index()].kind != SystemSymbol::Kind::parameter && numbers[symbol.index()] == 0.0;
  });
  return made;
}

}  // namespace bgsim
