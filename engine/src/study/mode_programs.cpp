#include "study/mode_programs.hpp"

#include <algorithm>

#include "bgsim/evaluator.hpp"
#include "equations/idle_switches.hpp"
#include "equations/indefinite.hpp"
#include "equations/solvable_causality.hpp"
#include "graph/law_numbers.hpp"
#include "model/add_symbols.hpp"
#include "run/stored.hpp"
#include "run/tried_sides.hpp"
#include "run/watch/event_jumps.hpp"
#include "study/network_borders.hpp"

namespace bgsim {

namespace {

/// A model in which nothing is stored, with the time as a state.
Model with_clock(Model model) {
  const SignalId clock = add_signal(model, kModeClock, Signal::Kind::integral);
  model.signals[clock.index()].value = model.pool.constant(1.0);
  return model;
}

Model with_resistors(Model model) {
  for (Element& element : model.elements)
    if (is_switch(element.kind)) {
      element.stands_in = mode_holds(element);
      element.kind = ElementKind::resistor;
      element.coefficient = model.pool.constant(1.0);
    }
  return model;
}

/// An integral, from 0, with a rate that is written later.
SignalId add_integral(Model& model, std::string name) {
  return add_signal(model, std::move(name), Signal::Kind::integral);
}

/// With a parameter for each diode's band, one for the flow below which a thyristor's has ended, and one for the
/// instant at which a contact comes to rest whose mode is asked for; and those of laws that may hold their borders.
std::shared_ptr<const Model> with_bands(std::shared_ptr<const Model> model) {
  if (std::none_of(model->elements.begin(), model->elements.end(), [](const Element& e) { return e.diode; }))
    return model;
  Model result = *model;
  for (std::size_t i = 0; i < result.elements.size(); ++i) {
    if (!result.elements[i].diode) continue;
    const ParameterId band = add_parameter(result, kBandParameter + result.elements[i].name + ")");
    result.elements[i].diode->band = band;
    if (result.elements[i].diode->fire.valid())
      result.elements[i].diode->holding = add_parameter(result, kHoldingParameter + result.elements[i].name + ")");
  }
  for (const ModelSymbol& symbol : model->symbols) {
    if (symbol.kind != ModelSymbol::Kind::mode) continue;
    Element& element = result.elements[symbol.element.index()];
    if (!element.contact || element.contact->rest.valid()) continue;
    element.contact->rest = add_parameter(result, kRestParameter + element.name + ")");
    element.contact->rest_moves = add_parameter(result, "(how the rest of " + element.name + " moves)");
  }
  add_own_borders(result);
  return std::make_shared<const Model>(std::move(result));
}

/// Those of @p settling whose mode some expression asks for; empty: none.
Mode seen_settling(const Model& model, const Mode& settling) {
  const std::vector<ElementId> switches = switches_of(model);
  Mode seen = settling;
  for (std::size_t i = 0; i < seen.size(); ++i)
    seen[i] = seen[i] && model.elements[switches[i].index()].contact->rest.valid();
  return std::find(seen.begin(), seen.end(), true) == seen.end() ? Mode() : seen;
}

Model with_settling(Model model, const Mode& settling) {
  const std::vector<ElementId> switches = switches_of(model);
  for (std::size_t i = 0; i < settling.size(); ++i)
    if (settling[i]) model.elements[switches[i].index()].contact->settling = true;
  return model;
}

/// The model with each diode as a resistor in series with a source, e = r f + s, so that its graph is the same whatever
/// they do; and what diode_sides() asks for: the flow of each, and its first two derivatives in time, as rates.
/// @param borders  with those that laws of resistors may hold
Model as_network(Model model, DiodeNetwork& network, bool borders) {
  ExprPool& pool = model.pool;
  std::vector<ExprId> flows, gaps;  // gaps: of contacts alone
  network.first_signal = model.signals.size();
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    if (!model.elements[i].diode) continue;
    const std::string name = model.elements[i].name;
    const ParameterId resistance = add_parameter(model, "(resistance of " + name + ")");
    const SignalId source = add_integral(model, "(source of " + name + ")");
    network.resistances.push_back(resistance);
    network.out.push_back(model.elements[i].diode->out);
    network.names.push_back(name);
    Element& element = model.elements[i];
    ExprId flow = pool.symbol(port_variable(element, 0, Variable::flow));
    network.displacements.push_back(element.contact ? element.contact->displacement : SignalId());
    if (element.contact) {
      flow = pool.sub(flow, element.contact->speed);
      gaps.push_back(element.coefficient);
    }
    flows.push_back(flow);
    Law law;
    law.variable = Variable::effort;
    law.right = pool.add(pool.mul(pool.symbol(model.parameters[resistance.index()].symbol), flow),
                         pool.symbol(model.signals[source.index()].symbol));
    law.place = element.place;
    element.kind = ElementKind::resistor;
    element.modulated = true;
    element.coefficient = {};
    element.laws = {law};
  }
  std::vector<std::string> names = network.names;
  for (TakenBorder& taken : borders ? take_borders(model) : std::vector<TakenBorder>{}) {
    flows.push_back(taken.guard);
    names.push_back(taken.border.name);
    network.borders.push_back(std::move(taken.border));
  }
  for (std::size_t i = 0; i < flows.size(); ++i) {
    ExprId value = flows[i];
    for (int k = 0; k < 3; ++k) {
      const SignalId id = add_integral(model, "(flow of " + names[i] + ", " + std::to_string(k) + ")");
      model.signals[id.index()].value = value;
      value = pool.make(Op::der, value);
    }
  }
  for (std::size_t i = 0, next = 0; i < model.elements.size(); ++i) {
    if (!model.elements[i].diode) continue;
    const ExprId closing = flows[next++];
    if (!model.elements[i].contact) continue;
    ++network.contacts;
    const ContactLaw law = *model.elements[i].contact;
    const std::string name = model.elements[i].name;
    const SignalId room = add_integral(model, "(room of " + name + ")");
    const SignalId restitution = add_integral(model, "(restitution of " + name + ")");
    model.signals[room.index()].value =
        pool.sub(gaps[network.contacts - 1], pool.symbol(model.signals[law.displacement.index()].symbol));
    model.signals[restitution.index()].value =
        pool.select(pool.make(Op::gt, closing, pool.constant(0.0)),
                    substitute(pool, law.restitution, {{port_variable(model.elements[i], 0, Variable::flow), closing}}),
                    pool.constant(0.0));
  }
  return model;
}

/// The model with a speed of separation for each contact that is closed, and its impulse as an integral.
Model with_impacts(Model model, ImpactProgram& impact) {
  impact.first_signal = model.signals.size();
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    if (!model.elements[i].contact) continue;
    const std::string name = model.elements[i].name;
    const ParameterId kick = add_parameter(model, "(kick of " + name + ")");
    impact.kicks.push_back(kick);
    model.elements[i].contact->kick = kick;
    const SignalId impulse = add_integral(model, "(impulse of " + name + ")");
    model.signals[impulse.index()].value = model.pool.symbol(port_variable(model.elements[i], 0, Variable::effort));
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
    if (is_table(node.op))
      for (const EquationSystem::Delay& delay : system.delays)
        if (model.signals[delay.signal.index()].delay->table == TableId(node.b) && !delay.initial.valid())
          open.push_back(delay.value);
    if (node.op != Op::symbol) {
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) open.emplace_back(children[k]);
      continue;
    }
    const SystemSymbol& symbol = system.symbols[node.a];
    if (symbol.kind != SystemSymbol::Kind::unknown) continue;
    const Equation& equation = system.equations[symbol.index];
    if (equation.element.valid()) {
      const Element& element = model.elements[equation.element.index()];
      if (element.switches || element.diode) return false;
    }
    open.push_back(equation.expression);
  }
  return true;
}

template <class Make>
bool is_possible(const Make& make) {
  try {
    make();
    return true;
  } catch (const ModelError&) {
    return false;
  }
}

Model without_outputs(Model model) {
  model.outputs.clear();
  return model;
}

/// What @p make makes of the model, or, where the graph refuses it, of the same with idle switches.
template <class Make>
auto allowed(const std::shared_ptr<const Model>& model, const Make& make) {
  try {
    return make(model);
  } catch (const ModelError&) {
    auto idle = std::make_shared<const Model>(with_idle_switches(*model));
    if (!has_idle_switches(*idle)) throw;
    return make(std::shared_ptr<const Model>(std::move(idle)));
  }
}

}  // namespace

ModePrograms::ModePrograms(std::shared_ptr<const Model> model, CompileOptions options, Compile of_mode)
    : model_(with_bands(std::move(model))),
      options_(std::move(options)),
      of_mode_(of_mode ? std::move(of_mode) : plain(options_)) {}

ModePrograms::Compile ModePrograms::plain(CompileOptions options) {
  return [options = std::move(options)](const std::shared_ptr<const Model>& model, const EquationSystem& system,
                                        const BlockOrder& order) { return compile(model, system, order, options); };
}

Model ModePrograms::in_mode(const Mode& mode) const {
  Model model = bgsim::in_mode(*model_, mode);
  use_own_borders(model);
  return model;
}

std::vector<double> ModePrograms::completed(std::vector<double> parameters) const {
  parameters.resize(model_->parameters.size(), 0.0);
  return parameters;
}

std::unique_ptr<ModePrograms::Made> ModePrograms::make(const std::shared_ptr<const Model>& model,
                                                       const Compile& compile) {
  return allowed(model, [&compile](std::shared_ptr<const Model> of) {
    auto made = std::make_unique<Made>();
    made->model = std::move(of);
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
    made->program = compile(made->model, system, order);
    Indefinite indefinite = indefinite_outputs(*made->model, made->graph, system);
    made->program.indefinite_outputs = std::move(indefinite.outputs);
    made->program.indefinite_diodes = std::move(indefinite.diodes);
    return made;
  });
}

const Program& ModePrograms::at(const Mode& mode, const std::vector<double>& parameters, const Mode& settling) {
  const std::scoped_lock lock(mutex_);
  const Mode seen = seen_settling(*model_, settling);
  std::unique_ptr<Made>& made = made_[{mode, seen}];
  if (!made) made = make(std::make_shared<const Model>(with_settling(in_mode(mode), seen)), of_mode_);
  check_laws(*made->model, made->graph, made->causal, completed(parameters));
  return made->program;
}

const DiodeNetwork& ModePrograms::network(const Mode& mode) {
  const std::scoped_lock lock(mutex_);
  Mode key = mode;
  std::size_t next = 0;
  for (const Element& element : model_->elements) {
    if (!is_switch(element.kind)) continue;
    if (element.diode) key[next] = false;
    ++next;
  }
  std::unique_ptr<DiodeNetwork>& network = networks_[key];
  if (network) return *network;
  const auto made_with = [&](bool borders) {
    auto made = std::make_unique<DiodeNetwork>();
    const auto model = std::make_shared<const Model>(as_network(bgsim::in_mode(*model_, key), *made, borders));
    made->program = allowed(model, [](const std::shared_ptr<const Model>& of) {
      const BondGraph graph = build_bond_graph(*of);
      const EquationSystem system = derive_equations(*of, graph, solvable_causality(*of, graph), true);
      return compile(of, system, order_equations(*of, system), {{}, false});
    });
    return made;
  };
  try {
    network = made_with(true);
  } catch (const ModelError&) {
    network = made_with(false);  // a guard that has no two derivatives, say
  }
  return *network;
}

const ImpactProgram& ModePrograms::impact(const Mode& mode) {
  const std::scoped_lock lock(mutex_);
  std::unique_ptr<ImpactProgram>& impact = impacts_[mode];
  if (impact) return *impact;
  auto made = std::make_unique<ImpactProgram>();
  const auto model = std::make_shared<const Model>(with_impacts(bgsim::in_mode(*model_, mode), *made));
  made->program = std::move(make(model, plain(options_))->program);
  impact = std::move(made);
  return *impact;
}

SwitchedStart ModePrograms::start(const RunInputs& inputs) {
  const std::vector<Signal>& signals = model_->signals;
  const bool delays = std::any_of(signals.begin(), signals.end(), [](const Signal& s) { return s.delay.has_value(); });
  DelayedPrograms own(delays ? at(mode_of(*model_), inputs.parameters) : Program{});
  return start(inputs, own);
}

SwitchedStart ModePrograms::start(const RunInputs& inputs, DelayedPrograms& own) {
  SwitchedStart start{mode_of(*model_), {}, {inputs.start, inputs.initial}, {}};
  for (const ElementId element : switches_of(*model_))
    start.diodes.push_back(model_->elements[element.index()].diode.has_value());
  {
    const std::scoped_lock lock(mutex_);
    if (!looked_without_) {
      const auto with_these = [](Model model) {
        return make(std::make_shared<const Model>(with_resistors(std::move(model))), plain({{}, false}));
      };
      try {
        without_switches_ = with_these(*model_);
      } catch (const ModelError& error) {
        // Resistors connect what any mode connects: what outputs alone ask for and nothing determines (BG411), no mode
        // does. Else the graph does not allow resistors there, and the run finds its first mode from that of the model
        // as read.
        const auto undetermined = [](const Diagnostic& diagnostic) { return diagnostic.code == "BG411"; };
        if (std::all_of(error.diagnostics.begin(), error.diagnostics.end(), undetermined) &&
            is_possible([&] { with_these(without_outputs(*model_)); }))
          throw;
      }
      looked_without_ = true;
    }
  }
  if (without_switches_) begin_without_switches(*without_switches_, inputs, own, start);
  put_diodes(inputs, own, start);
  return start;
}

/// On the sides that the circuit makes them, where it says so; else the run reports why not.
void ModePrograms::put_diodes(const RunInputs& inputs, DelayedPrograms& own, SwitchedStart& start) {
  const auto count = static_cast<std::size_t>(std::count(start.diodes.begin(), start.diodes.end(), true));
  if (count == 0) return;
  const auto put = [&](const auto& conducts) {
    std::size_t next = 0;
    for (std::size_t i = 0; i < start.mode.size(); ++i)
      if (start.diodes[i]) start.mode[i] = conducts(next++);
  };
  const auto exact = [](const StateInfo&) { return 0.0; };
  try {
    const std::vector<DiodeState> before(count);
    KeptEvaluators evaluators;
    const DiodeSides sides = diode_sides(own.of(network(start.mode)), inputs.parameters, inputs.start, start.stored,
                                         exact, before, evaluators, start.sight, inputs.stop - inputs.start);
    if (!sides.failure) {
      put([&](std::size_t diode) { return sides.diodes[diode].conducts; });
      return;
    }
    const auto program_of = [&](const Mode& mode, const Mode& settling) -> const Program& {
      return own.of(at(mode, inputs.parameters, settling));
    };
    std::vector<bool> all;  // that are tried: a contact that touches is looked at by the run
    for (const SignalId displacement : network(start.mode).displacements) all.push_back(!displacement.valid());
    if (sides.final) {
      start.failure = sides.failure;
      return;
    }
    if (const auto tried = tried_sides(program_of, start.mode, start.diodes, before, all, inputs, start.stored, exact,
                                       sides.at_border))
      put([&](std::size_t diode) { return tried->conducts[diode]; });
    else
      start.failure = sides.failure;
  } catch (const ModelError&) {
    // The graph does not allow the mode of the other switches.
  }
}

/// The mode of switches whose conditions know no switch, and what all stores hold.
void ModePrograms::begin_without_switches(const Made& without, const RunInputs& inputs, DelayedPrograms& own,
                                          SwitchedStart& start) {
  const Program& program = own.of(without.program);
  Evaluator evaluator(program, completed(inputs.parameters));
  const std::vector<double> x = initial_states(evaluator, inputs);
  Branch branch = first_branch(program);
  std::vector<double> dependent(program.dependent.size());
  DelayLines delays(program, evaluator, inputs, own.tables());
  delays.clear();
  if (!evaluator.initialize_modes(inputs.start, x.data(), branch)) return;
  if (delays.any() &&
      (!delays.begin(inputs.start, x.data(), branch) || !evaluator.initialize_modes(inputs.start, x.data(), branch)))
    return;
  if (evaluator.dependents(inputs.start, x.data(), branch, dependent.data())) {
    start.stored.values.clear();
    const auto keep = [&](const StateInfo& state, double value) {
      start.stored.values.push_back({state.element, state.port, value, state.place, state.signal});
    };
    for (std::size_t i = 0; i < x.size(); ++i) keep(program.states[i], x[i]);
    for (std::size_t i = 0; i < dependent.size(); ++i) keep(program.dependent[i], dependent[i]);
    sort_stored(start.stored.values);
  }
  // Conditions that ask for modes follow those that these depend on, one after the other.
  put_switches(without, inputs, own, start);
  const bool ask = std::any_of(model_->symbols.begin(), model_->symbols.end(),
                               [](const ModelSymbol& symbol) { return symbol.kind == ModelSymbol::Kind::mode; });
  for (std::size_t i = 0; ask && i < start.mode.size(); ++i) {
    const Mode before = start.mode;
    const std::shared_ptr<const Model> model =
        std::make_shared<const Model>(with_resistors(bgsim::in_mode(*model_, start.mode)));
    const std::unique_ptr<Made> made = make(model, plain({{}, false}));
    put_switches(*made, inputs, own, start);
    if (start.mode == before) return;
  }
}

namespace {

/// What is sampled or latched at the start is so from the start on: taken as the run takes it.
bool take_memory(Evaluator& evaluator, const RunInputs& inputs, std::vector<double>& x, Branch& branch) {
  EventJumps jumps(evaluator.program(), evaluator, inputs);
  if (!jumps.begin(inputs.start, x.data(), branch)) return false;
  while (jumps.look(inputs.start, x.data(), branch, true)) {
    if (jumps.due().empty()) return true;
    for (const std::size_t event : jumps.due()) jumps.set(event, x);
    if (!jumps.taken(inputs.start) || !evaluator.initialize_modes(inputs.start, x.data(), branch)) return false;
  }
  return false;
}

}  // namespace

/// On the sides that their conditions say, where these know no switch.
void ModePrograms::put_switches(const Made& without, const RunInputs& inputs, DelayedPrograms& own,
                                SwitchedStart& start) const {
  const Program& program = own.of(without.program);
  Evaluator evaluator(program, completed(inputs.parameters));
  std::vector<double> x = initial_states(evaluator, inputs);
  Branch branch = first_branch(program);
  std::vector<double> closes(program.switch_elements.size());
  if (!evaluator.initialize_modes(inputs.start, x.data(), branch) || !take_memory(evaluator, inputs, x, branch) ||
      !evaluator.switches(inputs.start, x.data(), branch, closes.data()))
    return;
  const std::vector<ElementId> all = switches_of(*model_);
  for (std::size_t i = 0; i < closes.size(); ++i) {
    const ElementId element = program.switch_elements[i];
    const auto at = static_cast<std::size_t>(std::find(all.begin(), all.end(), element) - all.begin());
    const bool holds = without.certain[i] && closes[i] != 0.0;
    // One with hysteresis leaves the side that it begins on where it is to; the others close.
    if (!model_->elements[element.index()].switches->remembers)
      start.mode[at] = holds;
    else if (holds)
      start.mode[at] = !without.model->elements[element.index()].stands_in;
  }
}

}  // namespace bgsim
