#include <algorithm>
#include <array>
#include <set>
#include <unordered_map>
#include <utility>

#include "bgsim/equations.hpp"
#include "bgsim/modes.hpp"
#include "equations/derivative_faults.hpp"
#include "equations/impulses.hpp"
#include "equations/junctions.hpp"
#include "equations/law_forms.hpp"
#include "equations/loop_roots.hpp"
#include "equations/one_way_laws.hpp"
#include "equations/total_derivatives.hpp"
#include "equations/unknowns.hpp"
#include "expression/graph.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {
namespace {

/// Builds the system: one table for each thing that a bond, a port or a signal turns into.
class Derivation {
 public:
  Derivation(const Model& model, const BondGraph& graph, const CausalGraph& causal, bool in_pieces)
      : model_(model), graph_(graph), causal_(causal), derivatives_(model, system_, problems_, in_pieces) {}

  EquationSystem run() {
    make_symbols();
    Translator translate(
        causal_.pool, system_.pool, [this](SymbolId symbol) { return meaning(symbol); },
        [this](ExprId argument) { return derivatives_.of(argument, wish_); });
    translate_ = &translate;
    write_ranked_parts();
    write_signals();
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      wish_ = Wish{line_of(model_.elements[i]), {}};
      write_element(ElementId(i));
      claim({ElementId(i), {}});
    }
    for (const Output& output : model_.outputs) {
      wish_ = Wish{output.place, {}};
      system_.outputs.push_back({output.name, translate(output.value), output.unit});
    }
    write_switches();
    write_events();
    write_delays();
    claim({});
    name_roots_in_loops(system_);  // before they are differentiated, since roots at rest have no derivative
    claim({});
    derivatives_.write_equations();
    claim({});
    if (!problems_.empty())
      throw ModelError(with_one_way_laws(model_, graph_, causal_, std::move(problems_)), model_.sources);
    if (!system_.switches.empty() || !system_.diodes.empty())
      system_.jump.terms = impulse_terms(model_, graph_, system_);
    claim({});
    return std::move(system_);
  }

 private:
  // --- symbols

  void make_symbols() {
    system_.time = add_symbol(system_, SystemSymbol::Kind::time, 0, "t");
    for (std::size_t i = 0; i < model_.parameters.size(); ++i)
      system_.parameters.push_back(add_symbol(system_, SystemSymbol::Kind::parameter, i, model_.parameters[i].name));
    for (std::size_t b = 0; b < graph_.bonds.size(); ++b) {
      system_.efforts.push_back(add_unknown(system_, bond_variable_name(BondId(b), Variable::effort)));
      system_.flows.push_back(add_unknown(system_, bond_variable_name(BondId(b), Variable::flow)));
    }
    for (const Signal& signal : model_.signals)
      system_.signals.push_back(signal.is_state() ? SymbolId() : add_unknown(system_, signal.name));
    stored_.resize(graph_.ports.size());
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      const Element& element = model_.elements[i];
      if (!is_store(element.kind)) continue;
      for (std::size_t k = 0; k < port_count(element); ++k) make_stored(ElementId(i), k);
    }
    for (std::size_t i = 0; i < model_.signals.size(); ++i)
      if (model_.signals[i].is_state()) make_integral(SignalId(i));
  }

  void make_integral(SignalId id) {
    const std::string& name = model_.signals[id.index()].name;
    const SymbolId symbol = add_symbol(system_, SystemSymbol::Kind::state, system_.states.size(), name);
    system_.signals[id.index()] = symbol;
    system_.states.push_back({name, symbol, {}, {}, 0, id});
  }

  [[nodiscard]] static std::string stored_name(const Element& element, std::size_t number) {
    return port_name(element, number) + (stores_displacement(element, number) ? ".q" : ".p");
  }

  void make_stored(ElementId id, std::size_t number) {
    const Element& element = model_.elements[id.index()];
    const bool displacement = stores_displacement(element, number);
    const PortId port = graph_.port(id, number);
    const bool integral = causal_.gives(graph_, port) == (displacement ? Gives::effort : Gives::flow);
    const std::string name = stored_name(element, number);
    if (integral) {
      stored_[port.index()] = add_symbol(system_, SystemSymbol::Kind::state, system_.states.size(), name);
      const ExprId rate = displacement ? into(port) : effort(port);
      system_.states.push_back({name, stored_[port.index()], rate, id, static_cast<std::uint32_t>(number), SignalId{}});
    } else {
      stored_[port.index()] = add_unknown(system_, name);
      system_.dependent.push_back({name, stored_[port.index()], id, static_cast<std::uint32_t>(number), {}});
    }
  }

  /// The name in the model's own language: that of a one-port or field at the bond's end if it counts the same way.
  [[nodiscard]] std::string bond_variable_name(BondId bond, Variable variable) const {
    for (const PortId end : {graph_[bond].head, graph_[bond].tail}) {
      const Port& port = graph_[end];
      const ElementKind kind = graph_.kinds[port.element.index()];
      if (passes_power(kind)) continue;
      if (variable == Variable::flow && is_passive(kind) && !port.head) continue;
      return port_name(model_.elements[port.element.index()], port.number) + "." + letter(variable);
    }
    return model_.bonds[bond.index()].name + "." + letter(variable);
  }

  [[nodiscard]] ExprId as_expression(SymbolId symbol) { return system_.pool.symbol(symbol); }
  [[nodiscard]] ExprId effort(PortId port) { return as_expression(system_.efforts[graph_[port].bond.index()]); }
  [[nodiscard]] ExprId flow(PortId port) { return as_expression(system_.flows[graph_[port].bond.index()]); }
  [[nodiscard]] ExprId signed_by(bool positive, ExprId value) { return positive ? value : system_.pool.neg(value); }
  /// The bond's flow counted into the element.
  [[nodiscard]] ExprId into(PortId port) { return signed_by(graph_[port].head, flow(port)); }
  /// Effort times @p flow, which is made before: a product is printed in the order in which its factors were made, and
  /// of two arguments that make them it is the compiler that chooses the first.
  [[nodiscard]] ExprId power_of(PortId port, ExprId flow) { return system_.pool.mul(effort(port), flow); }

  /// What a model's symbol means in the system.
  ExprId meaning(SymbolId symbol) {
    const ModelSymbol& s = model_.symbols[symbol.index()];
    refuse_undetermined(s);
    switch (s.kind) {
      case ModelSymbol::Kind::time:
        return as_expression(system_.time);
      case ModelSymbol::Kind::parameter:
        return as_expression(system_.parameters[s.parameter.index()]);
      case ModelSymbol::Kind::signal:
        return as_expression(system_.signals[s.signal.index()]);
      case ModelSymbol::Kind::bond_variable:
        return as_expression((s.variable == Variable::effort ? system_.efforts : system_.flows)[s.bond.index()]);
      case ModelSymbol::Kind::mode:
        return system_.pool.constant(mode_holds(model_.elements[s.element.index()]) ? 1.0 : 0.0);
      case ModelSymbol::Kind::port_variable:
        break;
    }
    const Element& element = model_.elements[s.element.index()];
    const PortId port = graph_.port(s.element, is_junction(element.kind) ? 0 : s.port);
    switch (s.variable) {
      case Variable::effort:
        return effort(port);
      case Variable::flow:
        return is_passive(element.kind) ? into(port) : flow(port);
      case Variable::displacement:
      case Variable::momentum:
        return as_expression(stored_[port.index()]);
    }
    return {};
  }

  /// What runs round a ring of junctions and comes out nowhere has no value that could be asked for.
  void refuse_undetermined(const ModelSymbol& s) {
    const bool of_bond = s.kind == ModelSymbol::Kind::bond_variable || s.kind == ModelSymbol::Kind::port_variable;
    if (undetermined_.empty() || !of_bond) return;
    const bool junction =
        s.kind == ModelSymbol::Kind::port_variable && is_junction(model_.elements[s.element.index()].kind);
    const BondId bond = s.kind == ModelSymbol::Kind::bond_variable
                            ? s.bond
                            : graph_[graph_.port(s.element, junction ? 0 : s.port)].bond;
    const SymbolId unknown = (s.variable == Variable::effort ? system_.efforts : system_.flows)[bond.index()];
    const auto found = undetermined_.find(unknown);
    if (found == undetermined_.end()) return;
    problems_.push_back(undetermined_fault(model_, found->second, system_.symbols[unknown.index()].name, wish_.place));
    undetermined_.erase(found);
  }

  // --- equations

  /// Expressions made since the last call are this element's or signal's.
  void claim(Origin origin) { system_.origins.resize(system_.pool.size(), origin); }

  void write_signals() {
    for (std::size_t i = 0; i < model_.signals.size(); ++i) {
      wish_ = Wish{model_.signals[i].place, {}};
      const ExprId value = (*translate_)(model_.signals[i].value);
      if (model_.signals[i].is_state())
        system_.states[system_.symbols[system_.signals[i].index()].index].rate = value;
      else
        define(system_, system_.signals[i], value, {}, model_.signals[i].place);
      claim({{}, SignalId(i)});
    }
  }

  /// Rings of junctions that are solved as a whole. What nothing determines there must not be asked for.
  void write_ranked_parts() {
    for (const JunctionPart& part : causal_.ranked) {
      const auto modulus = [this](ElementId id) { return (*translate_)(model_.elements[id.index()].coefficient); };
      const auto given = [this](BondId bond, Variable variable) {
        return as_expression((variable == Variable::effort ? system_.efforts : system_.flows)[bond.index()]);
      };
      for (const ElementId id : part.elements) solved_.insert(id);
      for (const JunctionSolution& solution :
           solve_junctions(model_, graph_, causal_, part, system_.pool, modulus, given)) {
        const bool effort = solution.variable == Variable::effort;
        const SymbolId unknown = (effort ? system_.efforts : system_.flows)[solution.bond.index()];
        const Place& place = model_.elements[solution.element.index()].place;
        if (!solution.value.valid()) undetermined_.emplace(unknown, solution.element);
        define(system_, unknown, solution.value.valid() ? solution.value : system_.pool.constant(0.0), solution.element,
               place);
      }
      claim({part.elements.front(), {}});
    }
    // The moduli were written before it was known what nothing determines.
    for (const ElementId id : solved_) {
      const Element& element = model_.elements[id.index()];
      if (!element.coefficient.valid()) continue;
      wish_ = Wish{line_of(element), {}};
      for (const SymbolId symbol : symbols_in(model_.pool, std::array{element.coefficient}))
        refuse_undetermined(model_.symbols[symbol.index()]);
    }
  }

  void write_element(ElementId id) {
    if (solved_.contains(id)) return;
    const Element& element = model_.elements[id.index()];
    switch (element.kind) {
      case ElementKind::effort_source:
      case ElementKind::flow_source:
      case ElementKind::open_switch:
      case ElementKind::closed_switch:
        return write_source(id);
      case ElementKind::blocking_diode:
      case ElementKind::conducting_diode:
        return write_diode(id);
      case ElementKind::free_contact:
      case ElementKind::closed_contact:
        return write_contact(id);
      case ElementKind::effort_detector:
      case ElementKind::flow_detector:
        return write_detector(id);
      case ElementKind::resistor:
      case ElementKind::r_field:
        return write_resistor(id);
      case ElementKind::capacitor:
      case ElementKind::inertia:
      case ElementKind::c_field:
      case ElementKind::i_field:
      case ElementKind::ic_field:
        return write_store(id);
      case ElementKind::transformer:
        return write_transformer(id);
      case ElementKind::gyrator:
        return write_gyrator(id);
      case ElementKind::zero_junction:
        return write_junction(id, system_.efforts, system_.flows, Gives::flow);
      case ElementKind::one_junction:
        return write_junction(id, system_.flows, system_.efforts, Gives::effort);
    }
  }

  void write_source(ElementId id) {
    const Element& element = model_.elements[id.index()];
    const PortId port = graph_.port(id, 0);
    const auto& variables = imposed_variable(element.kind) == Variable::effort ? system_.efforts : system_.flows;
    define(system_, variables[graph_[port].bond.index()], (*translate_)(element.coefficient), id, element.place);
    const ExprId power = power_of(port, flow(port));
    add_energy({EnergyPart::Role::source, id, signed_by(!graph_[port].head, power), {}, {}, {}, {}, false});
  }

  void write_diode(ElementId id) {
    const Element& element = model_.elements[id.index()];
    const PortId port = graph_.port(id, 0);
    const std::size_t bond = graph_[port].bond.index();
    const bool conducts = is_closed(element);
    const ExprId value =
        conducts ? signed_by(!element.diode->out, (*translate_)(element.diode->threshold)) : system_.pool.constant(0.0);
    define(system_, (conducts ? system_.efforts : system_.flows)[bond], value, id, element.place);
    const ExprId power = power_of(port, into(port));
    add_energy({EnergyPart::Role::dissipator, id, power, {}, {}, {}, {}, false});
  }

  /// Free it has no effort; closed the speed of its wall. The work that a moving wall takes is a source's.
  void write_contact(ElementId id) {
    const Element& element = model_.elements[id.index()];
    const ContactLaw& law = *element.contact;
    ExprPool& pool = system_.pool;
    const PortId port = graph_.port(id, 0);
    const std::size_t bond = graph_[port].bond.index();
    if (is_closed(element)) {
      define(system_, system_.efforts[bond], pool.constant(0.0), id, element.place);
    } else {
      wish_ = Wish{element.coefficient_place, {}};
      ExprId speed = (*translate_)(law.speed);
      if (law.kick.valid()) speed = pool.sub(speed, as_expression(system_.parameters[law.kick.index()]));
      define(system_, system_.flows[bond], signed_by(graph_[port].head, speed), id, element.place);
    }
    const ExprId power = pool.neg(power_of(port, into(port)));
    add_energy({EnergyPart::Role::source, id, power, {}, {}, {}, {}, false});
  }

  /// Conducting it leaves its side where the flow goes below 0, blocking where the effort goes beyond the threshold. A
  /// thyristor does where there is no flow while it is not fired, too: it has ended, and would need its fire again.
  void write_diode_side(ElementId id) {
    const Element& element = model_.elements[id.index()];
    const DiodeLaw& law = *element.diode;
    ExprPool& pool = system_.pool;
    const PortId port = graph_.port(id, 0);
    wish_ = Wish{law.fire.valid() ? law.fire_place : element.place, {}};
    const ExprId one = pool.constant(1.0), zero = pool.constant(0.0);
    DiodeEquation equation{id, signed_by(!law.out, effort(port)), signed_by(!law.out, into(port)),
                           (*translate_)(law.threshold), one};
    if (is_contact(element.kind)) {
      wish_ = Wish{element.coefficient_place, {}};
      equation.flow = pool.sub((*translate_)(element.coefficient),
                               as_expression(system_.signals[element.contact->displacement.index()]));
    }
    const ExprId fires = law.fire.valid() ? (*translate_)(law.fire) : ExprId();
    if (fires.valid()) equation.fires = pool.select(fires, one, zero);
    system_.diodes.push_back(equation);
    if (is_switch(element.kind)) {
      const ExprId band = law.band.valid() ? as_expression(system_.parameters[law.band.index()]) : zero;
      const bool conducts = is_closed(element);
      ExprId leaves = conducts ? pool.make(Op::lt, pool.add(equation.flow, band), zero)
                               : pool.make(Op::gt, pool.sub(pool.sub(equation.effort, equation.threshold), band), zero);
      if (!conducts && fires.valid()) leaves = pool.make(Op::logical_and, fires, leaves);
      if (conducts && law.holding.valid()) {
        const ExprId holding = as_expression(system_.parameters[law.holding.index()]);
        const ExprId ended =
            pool.make(Op::logical_and, pool.make(Op::logical_not, fires), pool.make(Op::le, equation.flow, holding));
        leaves = pool.make(Op::logical_or, leaves, ended);
      }
      if (element.contact && element.contact->settling) {
        const ExprId rest = as_expression(system_.parameters[element.contact->rest.index()]);
        leaves = pool.make(Op::logical_or, leaves, pool.make(Op::ge, as_expression(system_.time), rest));
      }
      system_.switches.push_back({id, pool.select(leaves, one, zero)});
    }
    claim({id, {}});
  }

  /// The condition under which each switch leaves the side that it is on.
  void write_switches() {
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      const Element& element = model_.elements[i];
      if (element.diode) write_diode_side(ElementId(i));
      if (!element.switches) continue;
      // Where a resistor stands for it, one with hysteresis has the side that it begins on, the others none: they
      // close.
      const bool closed =
          is_switch(element.kind) ? is_closed(element) : element.switches->remembers && element.stands_in;
      wish_ = Wish{closed ? element.switches->opens_place : element.switches->closes_place, {}};
      const ExprId leaves = (*translate_)(closed ? element.switches->opens : element.switches->closes);
      ExprPool& pool = system_.pool;
      system_.switches.push_back({ElementId(i), pool.select(leaves, pool.constant(1.0), pool.constant(0.0))});
      claim({ElementId(i), {}});
    }
    if (system_.switches.empty() && system_.diodes.empty()) return;
    for (const EnergyPart& part : system_.energy) {
      if (part.role != EnergyPart::Role::store) continue;
      for (std::size_t k = 0; k < graph_.port_count(part.element); ++k) {
        const PortId port = graph_.port(part.element, k);
        const bool displacement = stores_displacement(model_.elements[part.element.index()], k);
        system_.jump.conjugates.push_back(displacement ? effort(port) : into(port));
      }
    }
  }

  void write_delays() {
    for (std::size_t i = 0; i < model_.signals.size(); ++i) {
      const auto& delay = model_.signals[i].delay;
      if (!delay) continue;
      wish_ = Wish{model_.signals[i].place, {}};
      system_.delays.push_back({SignalId(i), (*translate_)(delay->value), (*translate_)(delay->by),
                                delay->initial.valid() ? (*translate_)(delay->initial) : ExprId{}});
    }
  }

  void write_events() {
    ExprPool& pool = system_.pool;
    for (const ModelEvent& event : model_.events) {
      wish_ = Wish{event.when_place, {}};
      const ExprId holds = (*translate_)(event.when);
      EventEquation equation{pool.select(holds, pool.constant(1.0), pool.constant(0.0)), {}};
      for (const ModelEvent::Set& set : event.sets) {
        wish_ = Wish{set.place, {}};
        const auto same = [&set](const State& state) {
          return state.element == set.element && state.port == set.port && state.signal == set.signal;
        };
        const auto state = std::find_if(system_.states.begin(), system_.states.end(), same);
        const std::string name = set.signal.valid() ? model_.signals[set.signal.index()].name
                                                    : stored_name(model_.elements[set.element.index()], set.port);
        equation.sets.push_back({{}, name, (*translate_)(set.value)});
        if (state != system_.states.end()) {
          equation.sets.back().state = static_cast<std::uint32_t>(state - system_.states.begin());
        } else if (switches_of(model_).empty()) {
          problems_.push_back(dependent_target(event.name, name, set.target_place));
        }
      }
      system_.events.push_back(std::move(equation));
    }
  }

  /// Takes no power, so it has no part in the energy audit.
  void write_detector(ElementId id) {
    const Element& element = model_.elements[id.index()];
    const auto& variables = imposed_variable(element.kind) == Variable::effort ? system_.efforts : system_.flows;
    define(system_, variables[graph_[graph_.port(id, 0)].bond.index()], system_.pool.constant(0.0), id, element.place);
  }

  void write_resistor(ElementId id) {
    ExprId power = system_.pool.constant(0.0);
    for (std::size_t k = 0; k < graph_.port_count(id); ++k) {
      const PortId port = graph_.port(id, k);
      const bool gives_effort = causal_.gives(graph_, port) == Gives::effort;
      apply_law(port, (gives_effort ? system_.efforts : system_.flows)[graph_[port].bond.index()]);
      power = system_.pool.add(power, power_of(port, into(port)));
    }
    add_energy({EnergyPart::Role::dissipator, id, power, {}, {}, {}, {}, false});
  }

  void write_store(ElementId id) {
    const Element& element = model_.elements[id.index()];
    for (std::size_t k = 0; k < graph_.port_count(id); ++k) {
      const bool displacement = stores_displacement(element, k);
      const PortId port = graph_.port(id, k);
      const std::size_t bond = graph_[port].bond.index();
      const SymbolId stored = stored_[port.index()];
      if (system_.symbols[stored.index()].kind == SystemSymbol::Kind::state) {
        apply_law(port, displacement ? system_.efforts[bond] : system_.flows[bond]);
        continue;
      }
      apply_law(port, stored);
      const Wish laws = std::exchange(wish_, Wish{element.place, system_.symbols[stored.index()].name});
      const ExprId rate = derivatives_.of(as_expression(stored), wish_);
      wish_ = laws;
      system_.dependent[written_++].rate = rate;
      if (displacement)
        define(system_, system_.flows[bond], signed_by(graph_[port].head, rate), id, element.place);
      else
        define(system_, system_.efforts[bond], rate, id, element.place);
    }
    add_store_energy(id);
  }

  /// Defines @p unknown, what the port's law is to yield, as the causality has solved it.
  void apply_law(PortId port, SymbolId unknown) {
    const auto& [law, solved, conjugate] = causal_.laws[port.index()];
    const Port& at = graph_[port];
    wish_ = Wish{law.place.document.valid() ? law.place : line_of(model_.elements[at.element.index()]), {}};
    const ExprId left = law.zero ? system_.pool.constant(0.0)
                                 : meaning(port_variable(model_.elements[at.element.index()], law.port, law.variable));
    if (solved.use == LawUse::implicit) {
      const ExprId right = (*translate_)(law.right);
      return define(system_, unknown, system_.pool.sub(left, right), at.element, law.place, true);
    }
    // A flow counted into an element from which the half-arrow leaves is minus the bond's.
    const bool negated = solved.wanted == Variable::flow && !at.head;
    define(system_, unknown, signed_by(!negated, (*translate_)(solved.solution)), at.element, law.place);
    set_loop_form(port, unknown, left);
  }

  /// The form of a law in which a loop is solved for @p unknown, where what defines it is not fit for that.
  void set_loop_form(PortId port, SymbolId unknown, ExprId left) {
    const auto& [law, solved, conjugate] = causal_.laws[port.index()];
    if (solved.wanted != Variable::effort && solved.wanted != Variable::flow) return;
    ExprPool& pool = system_.pool;
    const ExprId right = (*translate_)(law.right), solution = (*translate_)(solved.solution);
    ExprId form;
    if (solved.use == LawUse::inverted) {
      form = form_of_inverted(pool, left, right, unknown, solution);
    } else if (solved.use == LawUse::as_written) {
      const std::size_t bond = graph_[port].bond.index();
      form = form_of_written(pool, left, right,
                             (solved.wanted == Variable::effort ? system_.flows : system_.efforts)[bond]);
    }
    system_.equations[system_.symbols[unknown.index()].index].loop_form = form;
  }

  void write_transformer(ElementId id) {
    const Element& element = model_.elements[id.index()];
    ExprPool& pool = system_.pool;
    const PortId one = graph_.port(id, 0), two = graph_.port(id, 1);
    const ExprId n = (*translate_)(element.coefficient);
    const bool same = graph_[one].head == !graph_[two].head;  // both flows count the way of the law, or both against it
    const std::size_t b1 = graph_[one].bond.index(), b2 = graph_[two].bond.index();
    if (causal_.gives(graph_, one) == Gives::effort) {
      define(system_, system_.efforts[b1], pool.mul(n, effort(two)), id, element.place);
      define(system_, system_.flows[b2], signed_by(same, pool.mul(n, flow(one))), id, element.place);
    } else {
      define(system_, system_.efforts[b2], pool.div(effort(one), n), id, element.place);
      define(system_, system_.flows[b1], signed_by(same, pool.div(flow(two), n)), id, element.place);
    }
  }

  void write_gyrator(ElementId id) {
    const Element& element = model_.elements[id.index()];
    ExprPool& pool = system_.pool;
    const PortId one = graph_.port(id, 0), two = graph_.port(id, 1);
    const ExprId r = (*translate_)(element.coefficient);
    const bool one_in = graph_[one].head, two_out = !graph_[two].head;
    const std::size_t b1 = graph_[one].bond.index(), b2 = graph_[two].bond.index();
    if (causal_.gives(graph_, one) == Gives::effort) {
      define(system_, system_.efforts[b1], signed_by(two_out, pool.mul(r, flow(two))), id, element.place);
      define(system_, system_.efforts[b2], signed_by(one_in, pool.mul(r, flow(one))), id, element.place);
    } else {
      define(system_, system_.flows[b2], signed_by(two_out, pool.div(effort(one), r)), id, element.place);
      define(system_, system_.flows[b1], signed_by(one_in, pool.div(effort(two), r)), id, element.place);
    }
  }

  /// A junction shares one variable and balances the other; the bond at which it gives @p setter's opposite sets the
  /// shared one and takes the balance.
  void write_junction(ElementId id, const std::vector<SymbolId>& shared, const std::vector<SymbolId>& balanced,
                      Gives at_setter) {
    const Element& element = model_.elements[id.index()];
    ExprPool& pool = system_.pool;
    PortId setter;
    for (std::size_t k = 0; k < graph_.port_count(id); ++k)
      if (causal_.gives(graph_, graph_.port(id, k)) == at_setter) setter = graph_.port(id, k);
    ExprId sum = pool.constant(0.0);
    for (std::size_t k = 0; k < graph_.port_count(id); ++k) {
      const PortId port = graph_.port(id, k);
      if (port == setter) continue;
      const std::size_t bond = graph_[port].bond.index();
      define(system_, shared[bond], as_expression(shared[graph_[setter].bond.index()]), id, element.place);
      const ExprId term = as_expression(balanced[bond]);
      sum = graph_[port].head == graph_[setter].head ? pool.sub(sum, term) : pool.add(sum, term);
    }
    define(system_, balanced[graph_[setter].bond.index()], sum, id, element.place);
  }

  // --- energy

  void add_energy(EnergyPart part) { system_.energy.push_back(std::move(part)); }

  void add_store_energy(ElementId id) {
    const Element& element = model_.elements[id.index()];
    ExprPool& pool = system_.pool;
    EnergyPart part{EnergyPart::Role::store, id, pool.constant(0.0), {}, {}, {}, {}, false};
    for (std::size_t k = 0; k < graph_.port_count(id); ++k) {
      const PortId port = graph_.port(id, k);
      const ExprId power = power_of(port, into(port));
      part.power = pool.add(part.power, power);
      if (is_field(element.kind)) part.port_powers.push_back(power);
      part.displacements.push_back(stored_[port.index()]);
      const ExprId conjugate = causal_.laws[port.index()].conjugate;
      part.conjugates.push_back(conjugate.valid() ? (*translate_)(conjugate) : ExprId());
    }
    if (element.energy.valid()) {
      part.energy = (*translate_)(element.energy);
    } else if (element.coefficient.valid()) {
      // x/(2 c) first: the square of x may be beyond a double where the energy is not.
      const ExprId x = as_expression(part.displacements[0]);
      const ExprId twice = pool.mul(pool.constant(2.0), (*translate_)(element.coefficient));
      part.energy = pool.mul(x, pool.div(x, twice));
    }
    std::vector<ExprId> roots = part.conjugates;
    if (part.energy.valid()) roots.push_back(part.energy);
    part.modulated = std::any_of(part.conjugates.begin(), part.conjugates.end(), [](ExprId e) { return !e.valid(); });
    if (!part.modulated)
      for (const SymbolId symbol : symbols_in(pool, roots)) {
        const bool own =
            std::find(part.displacements.begin(), part.displacements.end(), symbol) != part.displacements.end();
        if (!own && system_.symbols[symbol.index()].kind != SystemSymbol::Kind::parameter) part.modulated = true;
      }
    add_energy(std::move(part));
  }

  const Model& model_;
  const BondGraph& graph_;
  const CausalGraph& causal_;
  Translator* translate_ = nullptr;
  EquationSystem system_;
  std::vector<SymbolId> stored_;  ///< by PortId (stores only)
  std::size_t written_ = 0;       ///< dependent stores, in their order
  Wish wish_;                     ///< of what is being written
  std::vector<Diagnostic> problems_;
  TotalDerivatives derivatives_;
  std::set<ElementId> solved_;                            ///< junctions, TF and GY whose equations are written
  std::unordered_map<SymbolId, ElementId> undetermined_;  ///< efforts and flows within rings
};

}  // namespace

Place place_of(const Model& model, const State& state) {
  return state.element.valid() ? model.elements[state.element.index()].place
                               : model.signals[state.signal.index()].place;
}

EquationSystem derive_equations(const Model& model, const BondGraph& graph, const CausalGraph& causal, bool in_pieces) {
  return Derivation(model, graph, causal, in_pieces).run();
}

}  // namespace bgsim
