#include "linear/variations.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <unordered_map>

#include "base/codes.hpp"
#include "base/dependence.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "expression/graph.hpp"
#include "model/add_symbols.hpp"
#include "model/constitutive.hpp"
#include "model/element_kinds.hpp"
#include "scene/set_target.hpp"

namespace bgsim {
namespace {

using Changes = std::unordered_map<SymbolId, ExprId>;

/// The sum of the partials times what changes; none: 0.
ExprId total(ExprPool& pool, ExprId root, const Changes& changes) {
  ExprId sum;
  for (const auto& [symbol, partial] : gradient(pool, root, [&](SymbolId s) { return changes.contains(s); })) {
    const ExprId term = pool.mul(partial, changes.at(symbol));
    sum = sum.valid() ? pool.add(sum, term) : term;
  }
  return sum;
}

/// Whether anything but time decides a condition in these expressions.
bool has_conditions(const ExprPool& pool, const std::vector<ExprId>& roots) {
  const std::vector<ExprId> nodes = reachable(pool, roots);
  return std::any_of(nodes.begin(), nodes.end(), [&](ExprId e) {
    const Op op = pool[e].op;
    return is_comparison(op) || op == Op::sign || op == Op::step || is_rounding(op) || op == Op::mod || is_table(op);
  });
}

/// Adds derivatives to a system.
class Varying {
 public:
  Varying(const Model& model, const EquationSystem& system, const BlockOrder& order,
          const std::vector<std::size_t>& outputs)
      : model_(model), asked_(outputs) {
    made_.system = system;
    made_.order = order;
    made_.outputs = outputs;
  }

  VariedSystem run(GivenValues& given, const Seed& seed, const VariedParts& parts) {
    made_.own_states = order().rates.size();
    signals_ = parts.signals;
    if (parts.squares || parts.integrals) add_integrals(parts.squares);
    const std::size_t n = order().rates.size();
    made_.variations.states = n;
    take_parameters(given, seed);
    std::vector<SymbolId> varied;
    for (std::size_t i = 0; i < n; ++i) {
      varied.push_back(add_symbol(derivative_name(system().states[i].name, seed), SystemSymbol::Kind::state, n + i));
      by_parameter_[system().states[i].symbol] = pool().symbol(varied.back());
    }
    const std::vector<Block> loops = order().blocks;  // without those that are added
    add_loops(loops, by_parameter_, [&](const std::string& name) { return derivative_name(name, seed); });
    std::vector<ExprId> roots = order().rates;
    for (const Block& block : loops) roots.insert(roots.end(), block.residuals.begin(), block.residuals.end());
    by_time_[system().time] = pool().constant(1.0);
    for (std::size_t i = 0; i < n; ++i) by_time_[system().states[i].symbol] = order().rates[i];
    if (parts.slopes || !system().events.empty() || !system().switches.empty() || has_conditions(pool(), roots))
      add_loops(loops, by_time_, [](const std::string& name) { return "d(" + name + ")/dt"; });
    for (std::size_t i = 0; i < n; ++i) {
      const ExprId rate = change(order().rates[i], by_parameter_);
      const State& state = system().states[i];
      SignalId declared;
      if (signals_ != nullptr)
        if (const auto at = signals_->derivatives.find({state.element, state.port, state.signal});
            at != signals_->derivatives.end())
          declared = at->second;
      add_state(varied[i], rate, declared);
    }
    const std::vector<ExprId> sets = order().event_values;
    for (const ExprId value : sets)
      for (const Changes* changes : {&by_parameter_, &by_time_})
        order().event_values.push_back(change(value, *changes));
    const std::size_t count = asked_.size();
    for (std::size_t i = 0; i < count; ++i) {
      const OutputEquation output = system().outputs[asked_[i]];
      add_output(derivative_name(output.name, seed), change(order().outputs[asked_[i]], by_parameter_));
    }
    for (std::size_t i = 0; i < count && parts.slopes; ++i)
      add_output("d(" + system().outputs[asked_[i]].name + ")/dt", change(order().outputs[asked_[i]], by_time_));
    for (const std::size_t state : integrals_)
      add_output(system().states[state].name, pool().symbol(system().states[state].symbol));
    for (const std::size_t state : integrals_)
      add_output(system().states[n + state].name, pool().symbol(system().states[n + state].symbol));
    made_.variations.by_parameter.assign(by_parameter_.begin(), by_parameter_.end());
    made_.variations.by_time.assign(by_time_.begin(), by_time_.end());
    made_.model = std::make_shared<const Model>(std::move(model_));
    order().origins.resize(pool().size());  // what was added last belongs to no law
    return std::move(made_);
  }

 private:
  EquationSystem& system() { return made_.system; }
  BlockOrder& order() { return made_.order; }
  ExprPool& pool() { return made_.order.pool; }

  static std::string derivative_name(const std::string& name, const Seed& seed) {
    return "d(" + name + ")/d(" + seed.name + ")";
  }

  SymbolId add_symbol(std::string name, SystemSymbol::Kind kind, std::size_t index) {
    system().symbols.push_back({kind, static_cast<std::uint32_t>(index), std::move(name)});
    order().resolved.emplace_back();
    return SymbolId(system().symbols.size() - 1);
  }

  /// An integral of the model stands for a state that is added: it has a name, a place and an initial value.
  void add_state(SymbolId symbol, ExprId rate, SignalId declared) {
    const std::string name = system().symbols[symbol.index()].name;
    const SignalId id = declared.valid() ? declared : add_signal(model_, name, Signal::Kind::integral);
    model_.signals[id.index()].name = name;
    model_.signals[id.index()].kind = Signal::Kind::integral;
    State state;
    state.name = name;
    state.symbol = symbol;
    state.rate = rate;
    state.signal = id;
    system().states.push_back(std::move(state));
    system().signals.resize(std::max(system().signals.size(), id.index() + 1));
    system().signals[id.index()] = symbol;
    order().rates.push_back(rate);
  }

  void add_output(const std::string& name, ExprId value) {
    Output output;
    output.name = name;
    output.value = model_.pool.constant(0.0);
    made_.outputs.push_back(model_.outputs.size());
    model_.outputs.push_back(std::move(output));
    system().outputs.push_back({name, value, ""});
    order().outputs.push_back(value);
  }

  void add_integrals(bool of_squares) {
    for (std::size_t k = 0; k < asked_.size(); ++k) {
      const std::size_t i = asked_[k];
      const ExprId value = order().outputs[i];
      integrals_.push_back(system().states.size());
      const SymbolId symbol = add_symbol("integral of " + system().outputs[i].name + (of_squares ? "^2" : ""),
                                         SystemSymbol::Kind::state, system().states.size());
      add_state(symbol, of_squares ? pool().mul(value, value) : value,
                signals_ != nullptr ? signals_->integrals[k] : SignalId());
      fill_origins(value);
    }
  }

  /// Parameters of the system by those of the model.
  void take_parameters(GivenValues& given, const Seed& seed) {
    const std::vector<ExprId> changes = parameter_variations(model_, given, seed);
    Translator translate(given.pool, pool(), [this](SymbolId symbol) {
      return pool().symbol(system().parameters[model_.symbols[symbol.index()].parameter.index()]);
    });
    for (std::size_t i = 0; i < changes.size(); ++i)
      if (changes[i].valid()) by_parameter_[system().parameters[i]] = translate(changes[i]);
    for (const Element& element : model_.elements)
      if (element.contact && element.contact->settling)
        by_parameter_[system().parameters[element.contact->rest.index()]] =
            pool().symbol(system().parameters[element.contact->rest_moves.index()]);
    order().origins.resize(pool().size());
  }

  ExprId change(ExprId root, const Changes& changes) {
    const ExprId sum = total(pool(), root, changes);
    const ExprId result = sum.valid() ? sum : pool().constant(0.0);
    fill_origins(root);
    return result;
  }

  void fill_origins(ExprId of) {
    const Origin origin = of.index() < order().origins.size() ? order().origins[of.index()] : Origin{};
    order().origins.resize(pool().size(), origin);
  }

  /// What the loops' variables change by is linear in it: the derivative of each residual is 0.
  template <class NameOf>
  void add_loops(const std::vector<Block>& loops, Changes& changes, const NameOf& name_of) {
    for (const Block& loop : loops) {
      Block block;
      block.linear = true;
      block.refined = loop.refined;  // its matrix is that of the loop
      block.elements = loop.elements;
      for (const SymbolId tear : loop.tears) {
        const std::string name = name_of(system().symbols[tear.index()].name);
        const SymbolId symbol = add_symbol(name, SystemSymbol::Kind::unknown, system().equations.size());
        Equation equation;
        equation.unknown = symbol;
        equation.expression = pool().symbol(symbol);
        equation.implicit = true;
        if (!loop.elements.empty()) equation.element = loop.elements.front();
        system().equations.push_back(equation);
        block.tears.push_back(symbol);
        block.members.push_back(symbol);
        changes[tear] = pool().symbol(symbol);
        order().resolved[symbol.index()] = pool().symbol(symbol);
      }
      for (const ExprId residual : loop.residuals) block.residuals.push_back(change(residual, changes));
      order().blocks.push_back(std::move(block));
    }
  }

  Model model_;
  const std::vector<std::size_t>& asked_;
  const VariationSignals* signals_ = nullptr;
  VariedSystem made_;
  Changes by_parameter_, by_time_;
  std::vector<std::size_t> integrals_;  ///< the states that are integrals of outputs, or of squares
};

/// Values of the model's symbols at a scene's start: parameters, the time, what stores hold.
std::vector<double> symbol_values(const Model& model, const RunInputs& inputs) {
  std::vector<double> values(model.symbols.size(), 0.0);
  for (std::size_t i = 0; i < model.parameters.size(); ++i)
    values[model.parameters[i].symbol.index()] = inputs.parameters[i];
  values[model.time.index()] = inputs.start;
  for (const RunInputs::Initial& initial : inputs.initial) {
    const SymbolId symbol = initial.signal.valid()
                                ? model.signals[initial.signal.index()].symbol
                                : port_variable(model.elements[initial.element.index()], initial.port,
                                                stored_variable(model.elements[initial.element.index()], initial.port));
    values[symbol.index()] = initial.value;
  }
  return values;
}

/// Signals by what they are computed from.
ExprId without_signals(const Model& model, ExprPool& pool, ExprId expression) {
  while (true) {
    Changes values;
    for (const SymbolId symbol : symbols_in(pool, {&expression, 1})) {
      const ModelSymbol& meaning = model.symbols[symbol.index()];
      if (meaning.kind == ModelSymbol::Kind::signal && !model.signals[meaning.signal.index()].is_state())
        values[symbol] = model.signals[meaning.signal.index()].value;
    }
    if (values.empty()) return expression;
    expression = substitute(pool, expression, values);
  }
}

/// What initial values change by, by state.
class StartChanges {
 public:
  StartChanges(const Model& model, GivenValues& given, const Seed& seed, const RunInputs& inputs)
      : model_(model), given_(given), seed_(seed), values_(symbol_values(model, inputs)) {
    const std::vector<ExprId> parameters = parameter_variations(model, given, seed);
    slopes_.assign(model.symbols.size(), 0.0);
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (parameters[i].valid())
        slopes_[model.parameters[i].symbol.index()] = evaluate(given.pool, parameters[i], values_);
  }

  [[nodiscard]] std::vector<double> parameters() const {
    std::vector<double> result;
    for (const Parameter& parameter : model_.parameters) result.push_back(slopes_[parameter.symbol.index()]);
    return result;
  }

  std::map<StateKey, double> run() {
    std::map<ElementId, std::vector<std::pair<StateKey, GivenValue>>> by_laws;
    std::map<StateKey, GivenValue> initial = given_.initial;
    if (!seed_.parameter.valid()) {
      GivenValue& value = initial[seed_.state];
      if (!value.value.valid()) value.value = given_.pool.constant(0.0);
      value.conjugate = seed_.conjugate;
    }
    for (const auto& [key, value] : initial)
      if (value.conjugate) by_laws[key.element];
    for (const auto& [key, value] : initial) {
      if (const auto at = by_laws.find(key.element); key.element.valid() && at != by_laws.end())
        at->second.emplace_back(key, value);
      else
        result_[key] = given_slope(key, value);
    }
    for (const auto& [element, given] : by_laws) solve(element, given);
    return std::move(result_);
  }

 private:
  double given_slope(const StateKey& key, const GivenValue& value) {
    if (!seed_.parameter.valid() && key == seed_.state) return 1.0;
    return slope_of(value.value, [this](SymbolId s) { return slopes_[s.index()]; });
  }

  template <class SlopeOf>
  double slope_of(ExprId expression, const SlopeOf& of) {
    double sum = 0.0;
    const auto wanted = [&](SymbolId s) { return of(s) != 0.0; };
    for (const auto& [symbol, partial] : gradient(given_.pool, expression, wanted))
      sum += evaluate(given_.pool, partial, values_) * of(symbol);
    return sum;
  }

  /// Ports of which the effort (of a C) or flow (of an I) is given: their laws hold.
  void solve(ElementId id, const std::vector<std::pair<StateKey, GivenValue>>& given) {
    const Element& element = model_.elements[id.index()];
    const auto stored = [&](std::uint32_t port) {
      return port_variable(element, port, stored_variable(element, port));
    };
    const auto conjugate = [&](std::uint32_t port) {
      return port_variable(element, port, conjugate_variable(element, port));
    };
    std::vector<Law> laws = port_laws(model_, given_.pool, id);
    std::vector<double> slopes = slopes_;
    std::vector<std::uint32_t> sought;
    for (const auto& [key, value] : given) {
      const double slope = given_slope(key, value);
      if (!value.conjugate) result_[key] = slope;
      slopes[(value.conjugate ? conjugate(key.port) : stored(key.port)).index()] = slope;
      if (value.conjugate) {
        sought.push_back(key.port);
        values_[conjugate(key.port).index()] = evaluate(given_.pool, value.value, values_);
      }
    }
    const auto n = static_cast<Eigen::Index>(sought.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (Eigen::Index row = 0; row < n; ++row) {
      const Law& law = laws[sought[static_cast<std::size_t>(row)]];
      const ExprId expression = without_signals(model_, given_.pool, law.right);
      const bool gives_stored = law.variable == stored_variable(element, law.port);
      right[row] = slope_of(expression, [&](SymbolId s) { return slopes[s.index()]; });
      if (gives_stored) {
        matrix(row, row) = 1.0;
        continue;
      }
      right[row] = slopes[conjugate(law.port).index()] - right[row];
      for (Eigen::Index column = 0; column < n; ++column) {
        const SymbolId symbol = stored(sought[static_cast<std::size_t>(column)]);
        matrix(row, column) = slope_of(expression, [&](SymbolId s) { return s == symbol ? 1.0 : 0.0; });
      }
    }
    const Eigen::VectorXd found = matrix.fullPivLu().solve(right);
    for (Eigen::Index i = 0; i < n; ++i) {
      const std::uint32_t port = sought[static_cast<std::size_t>(i)];
      const bool fits = (matrix * found - right).norm() <= 1e-9 * (right.norm() + 1e-300);
      if (!std::isfinite(found[i]) || !fits)
        throw ModelError(
            {diagnostic_of("BG414",
                           "what " + in_quotes(port_name(element, port)) + " holds at the start has no derivative by " +
                               in_quotes(short_name(seed_.name)),
                           element.place, "the law that gives it has a slope of 0, or none, at the initial value",
                           "begin with another value")},
            model_.sources);
      result_[{id, port, {}}] = found[i];
    }
  }

  const Model& model_;
  GivenValues& given_;
  const Seed& seed_;
  std::vector<double> values_, slopes_;  ///< by SymbolId
  std::map<StateKey, double> result_;
};

}  // namespace

Seed find_seed(const Model& model, const std::string& name) {
  for (std::size_t i = 0; i < model.parameters.size(); ++i)
    if (model.parameters[i].name == name) return {name, ParameterId(i), {}, false};
  if (const auto state = StateNames(model).find(name)) return {name, {}, state->key, state->conjugate};
  const UnknownTarget unknown = unknown_target_words(model, name);
  throw ModelError({diagnostic_of("BG413", unknown.situation, {},
                                  "sensitivities are those to parameters and to initial values of stores and integrals",
                                  unknown.help)},
                   model.sources);
}

std::vector<ExprId> parameter_variations(const Model& model, GivenValues& given, const Seed& seed) {
  std::vector<ExprId> changes(given.parameters.size());
  if (!seed.parameter.valid()) return changes;
  const auto refers_to = [&](std::size_t i) {
    std::vector<std::size_t> others;
    if (i == seed.parameter.index()) return others;
    for (const SymbolId symbol : symbols_in(given.pool, {&given.parameters[i].value, 1}))
      others.push_back(model.symbols[symbol.index()].parameter.index());
    return others;
  };
  Changes known;
  for (const std::size_t i : order_by_dependence(given.parameters.size(), refers_to).order) {
    changes[i] =
        i == seed.parameter.index() ? given.pool.constant(1.0) : total(given.pool, given.parameters[i].value, known);
    if (changes[i].valid() && given.pool.is_constant(changes[i], 0.0)) changes[i] = {};
    if (changes[i].valid()) known[model.parameters[i].symbol] = changes[i];
  }
  return changes;
}

Model with_variation_signals(Model model, std::size_t outputs, const VariedParts& parts, VariationSignals& signals) {
  signals = {};
  const std::size_t own = model.signals.size();
  const auto add = [&](const StateKey& key, const std::string& of) {
    signals.derivatives[key] = add_signal(model, "(derivative of " + of + ")", Signal::Kind::value);
  };
  for (std::size_t k = 0; k < outputs && (parts.squares || parts.integrals); ++k) {
    signals.integrals.push_back(
        add_signal(model, "(integral of output " + std::to_string(k + 1) + ")", Signal::Kind::value));
  }
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    for (std::size_t port = 0; is_store(model.elements[i].kind) && port < port_count(model.elements[i]); ++port)
      add({ElementId(i), static_cast<std::uint32_t>(port), {}}, port_name(model.elements[i], port));
  for (std::size_t s = 0; s < own; ++s)
    if (model.signals[s].is_state()) add({{}, 0, SignalId(s)}, model.signals[s].name);
  for (const SignalId integral : signals.integrals) add({{}, 0, integral}, model.signals[integral.index()].name);
  return model;
}

VariedSystem with_variations(const Model& model, const EquationSystem& system, const BlockOrder& order,
                             GivenValues& given, const Seed& seed, const std::vector<std::size_t>& outputs,
                             const VariedParts& parts) {
  return Varying(model, system, order, outputs).run(given, seed, parts);
}

SeedSlopes seed_slopes(const Model& model, GivenValues& given, const Seed& seed, const RunInputs& inputs) {
  StartChanges changes(model, given, seed, inputs);
  return {changes.parameters(), changes.run()};
}

RunInputs with_varied_outputs(RunInputs inputs, const std::vector<std::size_t>& outputs,
                              const std::vector<std::string>& own_states) {
  inputs.outputs = outputs;
  // An absolute tolerance in the units of the states says nothing of their derivatives.
  if (inputs.absolute) {
    for (const std::string& state : own_states) inputs.absolute_by_state.try_emplace(state, *inputs.absolute);
    inputs.absolute.reset();
  }
  return inputs;
}

RunInputs varied_inputs(const Model& model, const VariedSystem& varied, GivenValues& given, const Seed& seed,
                        const RunInputs& inputs) {
  refuse_kinks(model, varied.system, varied.order, varied.variations.states, varied.outputs, given, seed, inputs);
  const std::map<StateKey, double> changes = StartChanges(model, given, seed, inputs).run();
  const std::vector<State>& states = varied.system.states;
  std::vector<std::string> own;
  for (std::size_t i = 0; i < varied.own_states; ++i) own.push_back(states[i].name);
  RunInputs result = with_varied_outputs(inputs, varied.outputs, own);
  const std::size_t n = varied.variations.states;
  for (std::size_t i = 0; i < n; ++i) {
    const auto change = changes.find({states[i].element, states[i].port, states[i].signal});
    if (change == changes.end() || change->second == 0.0) continue;
    RunInputs::Initial initial;
    initial.signal = states[n + i].signal;
    initial.value = change->second;
    result.initial.push_back(initial);
  }
  const auto key = [](const RunInputs::Initial& i) { return std::tuple(i.element, i.port, i.signal); };
  std::sort(result.initial.begin(), result.initial.end(),
            [&](const auto& a, const auto& b) { return key(a) < key(b); });
  return result;
}

double value_of(const Model& model, GivenValues& given, const Seed& seed, const RunInputs& inputs) {
  if (seed.parameter.valid()) return inputs.parameters[seed.parameter.index()];
  std::vector<double> values = symbol_values(model, inputs);
  if (seed.state.signal.valid()) return values[model.signals[seed.state.signal.index()].symbol.index()];
  const Element& element = model.elements[seed.state.element.index()];
  const std::uint32_t port = seed.state.port;
  if (!seed.conjugate) return values[port_variable(element, port, stored_variable(element, port)).index()];
  if (const auto at = given.initial.find(seed.state); at != given.initial.end() && at->second.conjugate)
    return evaluate(given.pool, at->second.value, values);
  const Law law = port_laws(model, given.pool, seed.state.element)[port];
  if (law.variable == stored_variable(element, port)) return std::numeric_limits<double>::quiet_NaN();
  return evaluate(given.pool, without_signals(model, given.pool, law.right), values);
}

}  // namespace bgsim
