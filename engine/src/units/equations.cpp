#include "units/equations.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <unordered_map>

#include "base/text.hpp"
#include "expression/graph.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

constexpr std::array kVariables{Variable::effort, Variable::flow, Variable::displacement, Variable::momentum};

UnitForm variable(std::uint32_t number) { return {{{number, 1.0}}, {}}; }
UnitForm seconds() { return {{}, second()}; }

UnitForm bond_form(const UnitEquations& equations, BondId bond, Variable wanted) {
  const std::uint32_t region = equations.regions.of_bond[bond.index()];
  const bool flow = wanted == Variable::flow || wanted == Variable::displacement;
  UnitForm form = variable(2 * region + (flow ? 1 : 0));
  if (wanted == Variable::displacement || wanted == Variable::momentum) form.constant = second();
  return form;
}

/// What is known of a part of an expression.
struct Part {
  UnitForm form;
  bool pure = false;      ///< a number or a function's value, whatever it is computed from
  bool number = false;    ///< it has a number as a factor, which may carry a unit
  bool nameless = false;  ///< made of numbers and t only
  bool adapts = false;    ///< takes the unit that is wanted
  bool free = false;      ///< has no unit of its own even as a factor
};

class UnitBuilder {
 public:
  UnitBuilder(const Model& model, const BondGraph& graph, const GivenUnits& given, const Scene* scene)
      : model_(model), graph_(graph), given_(given), scene_(scene), pool_(model.pool) {
    result_.regions = unit_regions(graph);
    for (std::uint32_t i = 0; i < 2 * result_.regions.count; ++i) system().add_variable();
    result_.first_parameter = 2 * result_.regions.count;
    for (std::size_t i = 0; i < model.parameters.size(); ++i) system().add_variable();
    result_.first_signal = result_.first_parameter + static_cast<std::uint32_t>(model.parameters.size());
    for (std::size_t i = 0; i < model.signals.size(); ++i) system().add_variable();
  }

  UnitEquations build() {
    given_units();
    for (std::uint32_t i = 0; i < model_.parameters.size(); ++i) parameter(i);
    for (std::uint32_t i = 0; i < model_.signals.size(); ++i) {
      const Signal& signal = model_.signals[i];
      const UnitSite site{UnitSite::Kind::signal, i};
      const UnitForm unit = variable(result_.first_signal + i);
      const std::string name = "signal \"" + signal.name + "\"";
      value(site, signal.is_state() ? "the rate of " + name : name, signal.is_state() ? unit / seconds() : unit,
            signal.value, signal.place);
      if (signal.delay) {
        value(site, "what " + name + " delays", unit, signal.delay->value, signal.place);
        if (signal.delay->initial.valid())
          value(site, "the initial value of " + name, unit, signal.delay->initial, signal.delay->initial_place);
        value(site, "the delay of " + name, seconds(), signal.delay->by, signal.delay->by_place);
        continue;
      }
      if (signal.initial.valid())
        value(site, "the initial value of " + name, unit, signal.initial, signal.initial_place, 1);
    }
    for (std::uint32_t i = 0; i < model_.elements.size(); ++i) element(i);
    for (std::uint32_t i = 0; i < model_.events.size(); ++i) event(i);
    outputs();
    if (scene_ != nullptr) scene();
    return std::move(result_);
  }

 private:
  UnitSystem& system() { return result_.system; }

  // --- forms

  [[nodiscard]] UnitForm port_form(ElementId element, std::size_t port, Variable variable) const {
    return bond_form(result_, graph_[graph_.port(element, port)].bond, variable);
  }
  [[nodiscard]] UnitForm symbol_form(SymbolId id) const { return unit_form(model_, graph_, result_, id); }

  // --- equations

  void add(UnitEquation equation, const UnitForm& right, std::uint32_t depth = 0) {
    system().add_equation(equation.left_form / right, depth);
    result_.equations.push_back(std::move(equation));
  }

  /// A quantity is what an expression gives. @p name is the quantity in words.
  void value(const UnitSite& site, std::string name, const UnitForm& left, ExprId right, const Place& place,
             std::uint32_t depth = 0) {
    const Part part = expression(site, right, place);
    if (part.adapts) return;
    add({UnitEquation::Kind::value, site, Op::add, {}, right, left, std::move(name), place}, part.form, depth);
  }

  void given_units() {
    const auto give = [&](UnitSite::Kind kind, std::uint32_t index, std::uint32_t number,
                          const std::optional<Unit>& unit, const Place& place) {
      if (unit)
        add({UnitEquation::Kind::given, {kind, index}, Op::add, {}, {}, variable(number), {}, place}, {{}, *unit});
    };
    for (std::uint32_t i = 0; i < model_.parameters.size(); ++i)
      give(UnitSite::Kind::parameter, i, result_.first_parameter + i, given_.parameters[i],
           model_.parameters[i].unit_place);
    for (std::uint32_t i = 0; i < model_.signals.size(); ++i)
      give(UnitSite::Kind::signal, i, result_.first_signal + i, given_.signals[i], model_.signals[i].unit_place);
  }

  [[nodiscard]] const std::pair<ExprId, Place>* scene_value(const std::string& parameter) const {
    if (scene_ == nullptr) return nullptr;
    const auto found = scene_->parameters.find(parameter);
    return found == scene_->parameters.end() ? nullptr : &found->second;
  }

  void parameter(std::uint32_t index) {
    const Parameter& parameter = model_.parameters[index];
    const auto* instead = scene_value(parameter.name);
    value({UnitSite::Kind::parameter, index}, "parameter \"" + parameter.name + "\"",
          variable(result_.first_parameter + index), instead != nullptr ? instead->first : parameter.value,
          instead != nullptr ? instead->second : parameter.place);
  }

  /// Outputs come last: where one contradicts what the model is made of, it is the one to be reported.
  void outputs() {
    for (std::uint32_t i = 0; i < model_.outputs.size(); ++i) {
      const Output& output = model_.outputs[i];
      const UnitSite site{UnitSite::Kind::output, i};
      const Part part = expression(site, output.value, output.place);
      result_.outputs.push_back(part.adapts ? std::nullopt : std::optional(part.form));
      if (!given_.outputs[i] || part.adapts) continue;
      add({UnitEquation::Kind::value,
           site,
           Op::add,
           {},
           output.value,
           {{}, *given_.outputs[i]},
           "output \"" + output.name + "\"",
           output.unit_place},
          part.form, same_unit({{}, given_.outputs[i]->log_scale}, {}) ? 1 : kScaled);
    }
  }

  void scene() {
    const UnitSite site{UnitSite::Kind::scene};
    const auto time = [&](const char* key, ExprId expression, const Place& place) {
      if (expression.valid()) value(site, std::string("\"") + key + "\" of the scene", seconds(), expression, place, 1);
    };
    time("start", scene_->start, scene_->start_place);
    time("stop", scene_->stop, scene_->stop_place);
    time("interval", scene_->interval, scene_->interval_place);
    time("from", scene_->log_from, scene_->log_from_place);
    for (const auto& [output_time, place] : scene_->times) time("times", output_time, place);
    for (std::uint32_t i = 0; i < model_.signals.size() && !scene_->initial.empty(); ++i) {
      const auto found = scene_->initial.find(model_.signals[i].name);
      if (model_.signals[i].is_state() && found != scene_->initial.end())
        value(site, model_.signals[i].name, variable(result_.first_signal + i), found->second.first,
              found->second.second, 1);
    }
    for (std::uint32_t i = 0; i < model_.elements.size() && !scene_->initial.empty(); ++i) {
      const Element& store = model_.elements[i];
      if (!is_store(store.kind)) continue;
      for (std::size_t port = 0; port < port_count(store); ++port)
        for (const Variable variable : {stored_variable(store, port), conjugate_variable(store, port)}) {
          const std::string name = port_name(store, port) + "." + letter(variable);
          const auto found = scene_->initial.find(name);
          if (found != scene_->initial.end())
            value(site, name, port_form(ElementId(i), port, variable), found->second.first, found->second.second, 1);
        }
    }
  }

  void event(std::uint32_t index) {
    const ModelEvent& at = model_.events[index];
    const UnitSite site{UnitSite::Kind::event, index};
    static_cast<void>(expression(site, at.when, at.when_place));
    for (const ModelEvent::Set& set : at.sets) {
      if (set.signal.valid()) {
        value(site, model_.signals[set.signal.index()].name, variable(result_.first_signal + set.signal.value),
              set.value, set.place, 1);
        continue;
      }
      const Element& store = model_.elements[set.element.index()];
      const Variable stored = stored_variable(store, set.port);
      value(site, port_name(store, set.port) + "." + letter(stored), port_form(set.element, set.port, stored),
            set.value, set.place, 1);
    }
  }

  // --- elements

  void element(std::uint32_t index) {
    const Element& e = model_.elements[index];
    if (is_junction(e.kind)) return;
    const ElementId id(index);
    if (e.coefficient.valid()) coefficient(id, e);
    if (e.switches) {
      static_cast<void>(expression({UnitSite::Kind::element, id.value}, e.switches->closes, e.switches->closes_place));
      if (e.switches->remembers)
        static_cast<void>(expression({UnitSite::Kind::element, id.value}, e.switches->opens, e.switches->opens_place));
    }
    if (e.diode && e.diode->fire.valid())
      static_cast<void>(expression({UnitSite::Kind::element, id.value}, e.diode->fire, e.diode->fire_place));
    if (e.contact && e.contact->displacement.valid()) {
      value({UnitSite::Kind::element, id.value}, "the displacement of " + in_quotes(e.name),
            variable(result_.first_signal + e.contact->displacement.value), e.coefficient, e.coefficient_place, 1);
      if (!pool_.is_constant(e.contact->restitution))
        value({UnitSite::Kind::element, id.value}, "the restitution of " + in_quotes(e.name), {},
              e.contact->restitution, e.contact->restitution_place, 1);
    }
    if (e.energy.valid()) energy(id, e);
    // Laws of resistors hold constants that are fitted, and are the last ones to be believed.
    const std::uint32_t depth = is_resistor(e.kind) ? kFitted : 0;
    for (const Law& law : e.laws) {
      if (law.zero) {
        expression({UnitSite::Kind::law, index, law.port}, law.right, law.place);
        continue;
      }
      const SymbolId left = port_variable(e, law.port, law.variable);
      value({UnitSite::Kind::law, index, law.port}, symbol_name(model_, left), symbol_form(left), law.right, law.place,
            depth);
    }
    const bool store = is_store(e.kind);
    if (store && !e.energy.valid())
      for (std::uint32_t port = 1; port < port_count(e); ++port)
        add({UnitEquation::Kind::one_energy,
             {UnitSite::Kind::element, index, port},
             Op::add,
             {},
             {},
             port_energy(id, 0),
             {},
             e.place},
            port_energy(id, port));
    for (std::uint32_t i = 0; i < e.initial.size(); ++i) {
      const std::size_t port = e.initial[i].port;
      const Variable variable = e.initial[i].conjugate ? conjugate_variable(e, port) : stored_variable(e, port);
      value({UnitSite::Kind::initial, index, i}, port_name(e, port) + "." + letter(variable),
            port_form(id, port, variable), e.initial[i].value, e.initial[i].place, 1);
    }
  }

  /// e q or f p at a port of a store.
  UnitForm port_energy(ElementId id, std::size_t port) const {
    const Element& store = model_.elements[id.index()];
    return port_form(id, port, stored_variable(store, port)) * port_form(id, port, conjugate_variable(store, port));
  }

  void energy(ElementId id, const Element& e) {
    const UnitSite site{UnitSite::Kind::energy, id.value};
    const Part part = expression(site, e.energy, e.coefficient_place);
    for (std::uint32_t port = 0; port < port_count(e) && !part.adapts; ++port)
      add({UnitEquation::Kind::energy,
           {UnitSite::Kind::energy, id.value, port},
           Op::add,
           {},
           e.energy,
           port_energy(id, port),
           {},
           e.coefficient_place},
          part.form);
  }

  void coefficient(ElementId id, const Element& e) {
    if (!e.coefficient.valid()) return;
    const UnitSite site{UnitSite::Kind::element, id.value};
    const Part part = expression(site, e.coefficient, e.coefficient_place);
    const auto at = [&](std::size_t port, Variable variable) { return port_form(id, port, variable); };
    if (is_two_port(e.kind) && part.adapts)
      add({UnitEquation::Kind::same_power,
           site,
           Op::add,
           {},
           {},
           at(0, Variable::effort) * at(0, Variable::flow),
           {},
           e.place},
          at(1, Variable::effort) * at(1, Variable::flow));
    if (part.adapts) return;
    for (const CoefficientUnit& unit : kind_row(e.kind).units) {
      UnitForm form;
      for (std::size_t i = 0; i < kVariables.size(); ++i) {
        if (unit.first[i] != 0) form = form * power(at(0, kVariables[i]), unit.first[i]);
        if (unit.second[i] != 0) form = form * power(at(1, kVariables[i]), unit.second[i]);
      }
      add({UnitEquation::Kind::quotient,
           site,
           Op::add,
           {},
           e.coefficient,
           form,
           std::string(unit.words),
           e.coefficient_place},
          part.form);
    }
  }

  // --- expressions

  /// What an expression's unit is, with equations for its parts.
  Part expression(const UnitSite& site, ExprId root, const Place& place) {
    if (!root.valid()) return {{}, false, false, false, true, true};
    const auto none = [](std::uint32_t) -> const Part& { throw std::logic_error("a name has no arguments"); };
    if (arity(pool_[root].op) == 0) return part_of(root, none);  // most of a large model
    const std::vector<ExprId> nodes = reachable(pool_, std::array{root});
    IdMap<std::uint32_t> position;
    std::vector<Part> parts;
    parts.reserve(nodes.size());
    site_ = site;
    place_ = place;
    for (const ExprId id : nodes) {
      const auto part = [&](std::uint32_t argument) -> const Part& { return parts[*position.find(ExprId(argument))]; };
      position.insert(id, static_cast<std::uint32_t>(parts.size()));
      Part made = part_of(id, part);
      if (made.form.terms.size() > kLongest) made.form = named(site, id, made.form);
      parts.push_back(std::move(made));
    }
    return std::move(parts.back());
  }

  /// A variable in place of a long product: forms stay short, and the whole linear.
  UnitForm named(const UnitSite& site, ExprId id, const UnitForm& form) {
    UnitForm whole = variable(system().add_variable());
    add({UnitEquation::Kind::value, site, Op::add, {}, id, whole, "a product", place_}, form);
    return whole;
  }

  static Part pure_number(bool nameless) { return {{}, true, false, nameless, nameless, false}; }

  template <class Parts>
  Part part_of(ExprId id, const Parts& part) {
    const ExprNode& node = pool_[id];
    const ExprId a(node.a), b(node.b);
    switch (node.op) {
      case Op::constant:
        return {{}, true, true, true, true, false};
      case Op::symbol: {
        const SymbolId symbol(node.a);
        return {symbol_form(symbol), false, false, symbol == model_.time, false, false};
      }
      case Op::neg:
      case Op::abs:
        return part(node.a);
      case Op::mul:
        return product(part(node.a), part(node.b), 1.0);
      case Op::div:
        return product(part(node.a), part(node.b), -1.0);
      case Op::sqrt:
        return raised(part(node.a), 0.5);
      case Op::cbrt:
        return raised(part(node.a), 1.0 / 3.0);
      case Op::pow:
        return powered(a, part(node.a), b, part(node.b));
      case Op::ssqrt:
        return raised(alike(node.op, a, part(node.a), b, part(node.b)), 0.5);
      case Op::add:
      case Op::sub:
      case Op::min:
      case Op::max:
      case Op::hypot:
      case Op::mod:
        return alike(node.op, a, part(node.a), b, part(node.b));
      case Op::select:
        return alike(node.op, b, part(node.b), ExprId(node.c), part(node.c));
      case Op::der: {
        Part rate = part(node.a);
        rate.form = rate.form / seconds();
        rate.pure = false;
        return rate;
      }
      case Op::lt:
      case Op::le:
      case Op::gt:
      case Op::ge:
      case Op::eq:
      case Op::ne:
      case Op::atan2: {
        const Part both = alike(node.op, a, part(node.a), b, part(node.b));
        return pure_number(both.nameless);
      }
      case Op::logical_and:
      case Op::logical_or:
      case Op::logical_not:
        return pure_number(false);
      case Op::sign:
      case Op::step:
        return pure_number(part(node.a).nameless);
      case Op::table:
      case Op::table_slope:
      case Op::table_curvature:
      case Op::table_third:
        return from_table(node, part(node.a));
      default:  // exp, sin, ...: of pure numbers
        must_be_pure(node.op, a, part(node.a));
        return pure_number(part(node.a).nameless);
    }
  }

  static Part product(const Part& a, const Part& b, double exponent) {
    Part result;
    result.form = exponent > 0.0 ? a.form * b.form : a.form / b.form;
    result.pure = a.pure && b.pure;
    result.nameless = a.nameless && b.nameless;
    result.number = (a.number || b.number) && (result.pure || result.nameless);
    result.free = a.free || b.free || (result.number && !result.pure);
    result.adapts = result.free || (result.pure && (result.number || result.nameless));
    return result;
  }

  static Part raised(Part part, double exponent) {
    part.form = power(part.form, exponent);
    return part;
  }

  /// Two parts that must have one unit; what has none of its own takes the other's.
  Part alike(Op op, ExprId a, const Part& left, ExprId b, const Part& right) {
    Part result = left.adapts ? right : left;
    result.pure = left.pure && right.pure;
    result.nameless = left.nameless && right.nameless;
    result.number = left.adapts && right.adapts && (left.number || right.number);
    if (left.adapts && right.adapts) {
      result.free = !result.pure;
      result.form = {};
    }
    if (!left.adapts && !right.adapts)
      add({UnitEquation::Kind::sum, site_, op, a, b, left.form, {}, place_}, right.form, kInside);
    return result;
  }

  void must_be_pure(Op op, ExprId argument, const Part& part) {
    if (!part.adapts && !part.pure)
      add({UnitEquation::Kind::pure, site_, op, {}, argument, {}, {}, place_}, part.form, kInside);
  }

  Part powered(ExprId base, const Part& of, ExprId exponent, const Part& by) {
    must_be_pure(Op::pow, exponent, by);
    if (of.pure) {
      Part result = of;
      result.nameless = of.nameless && by.nameless;
      return result;
    }
    if (const std::optional<double> number = constant_value(exponent)) return raised(of, *number);
    must_be_pure(Op::pow, base, of);
    return pure_number(of.nameless && by.nameless);
  }

  /// Each column of data has a unit of its own, and so has what it is tabulated over.
  Part from_table(const ExprNode& node, const Part& argument) {
    const auto column = [&](const std::string& key) {
      const auto [known, made] = tables_.try_emplace(key, 0);
      if (made) known->second = system().add_variable();
      return variable(known->second);
    };
    const Table& data = pool_.table(TableId(node.b));
    const UnitForm x = column(data.file), y = column(data.file + "\n" + data.column);
    if (!argument.adapts)
      add({UnitEquation::Kind::abscissa, site_, node.op, {}, ExprId(node.a), x, data.file, place_}, argument.form,
          kInside);
    const double slopes = node.op == Op::table         ? 0.0
                          : node.op == Op::table_slope ? 1.0
                          : node.op == Op::table_third ? 3.0
                                                       : 2.0;
    return {y / power(x, slopes), false, false, false, false, false};
  }

  // --- values of constants, for exponents

  /// The number that an expression of parameters gives, or none. One parameter after the other, on an own stack.
  std::optional<double> constant_value(ExprId expression) {
    std::vector<std::pair<ExprId, SymbolId>> open{{expression, SymbolId()}};
    while (open.size() <= model_.parameters.size() + 1) {  // else a circle, which another stage tells of
      const auto [next, defines] = open.back();
      const auto waits_for = unknown_parameter(next);
      if (!waits_for) return std::nullopt;
      if (waits_for->valid()) {
        const Parameter& parameter = model_.parameters[model_.symbols[waits_for->index()].parameter.index()];
        const auto* instead = scene_value(parameter.name);
        open.emplace_back(instead != nullptr ? instead->first : parameter.value, *waits_for);
        continue;
      }
      const double number = evaluate(pool_, next, numbers_);
      open.pop_back();
      if (open.empty()) return std::isfinite(number) ? std::optional(number) : std::nullopt;
      numbers_[defines.index()] = number;
      known_[defines.index()] = true;
    }
    return std::nullopt;
  }

  /// The first parameter in an expression whose number is not known yet: an invalid id if there is none, none if the
  /// expression varies.
  std::optional<SymbolId> unknown_parameter(ExprId expression) {
    numbers_.resize(model_.symbols.size());
    known_.resize(model_.symbols.size());
    for (const SymbolId symbol : symbols_in(pool_, std::array{expression})) {
      if (model_.symbols[symbol.index()].kind != ModelSymbol::Kind::parameter) return std::nullopt;
      if (!known_[symbol.index()]) return symbol;
    }
    return SymbolId();
  }

  static constexpr std::size_t kLongest = 12;
  // Steps that equations are put behind others: what says most of a quantity goes first, so that a contradiction shows
  // in what says least.
  static constexpr std::uint32_t kInside = 5;   ///< parts of an expression
  static constexpr std::uint32_t kFitted = 20;  ///< a resistor's law
  static constexpr std::uint32_t kScaled = 30;  ///< an output in mm or L/min, which wishes rather than knows

  const Model& model_;
  const BondGraph& graph_;
  const GivenUnits& given_;
  const Scene* scene_;
  const ExprPool& pool_;
  UnitEquations result_;
  UnitSite site_{UnitSite::Kind::parameter};
  Place place_;
  std::unordered_map<std::string, std::uint32_t> tables_;
  std::vector<double> numbers_;  ///< values of the parameters that are known_, by SymbolId
  std::vector<bool> known_;
};

}  // namespace

UnitRegions unit_regions(const BondGraph& graph) {
  std::vector<std::uint32_t> parent(graph.bonds.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto find = [&](std::uint32_t bond) {
    while (parent[bond] != bond) bond = parent[bond] = parent[parent[bond]];
    return bond;
  };
  for (std::size_t i = 0; i < graph.kinds.size(); ++i) {
    if (!is_junction(graph.kinds[i])) continue;
    const ElementId junction(i);
    for (std::size_t k = 1; k < graph.port_count(junction); ++k)
      parent[find(graph[graph.port(junction, k)].bond.value)] = find(graph[graph.port(junction, 0)].bond.value);
  }
  UnitRegions regions;
  std::vector<std::uint32_t> number(parent.size(), std::numeric_limits<std::uint32_t>::max());
  regions.of_bond.resize(parent.size());
  for (std::uint32_t bond = 0; bond < parent.size(); ++bond) {
    std::uint32_t& of_root = number[find(bond)];
    if (of_root == std::numeric_limits<std::uint32_t>::max()) of_root = regions.count++;
    regions.of_bond[bond] = of_root;
  }
  return regions;
}

UnitForm unit_form(const Model& model, const BondGraph& graph, const UnitEquations& equations, SymbolId symbol) {
  const ModelSymbol& s = model.symbols[symbol.index()];
  switch (s.kind) {
    case ModelSymbol::Kind::time:
      return seconds();
    case ModelSymbol::Kind::parameter:
      return variable(equations.first_parameter + s.parameter.value);
    case ModelSymbol::Kind::signal:
      return variable(equations.first_signal + s.signal.value);
    case ModelSymbol::Kind::port_variable:
      return bond_form(equations, graph[graph.port(s.element, s.port)].bond, s.variable);
    case ModelSymbol::Kind::bond_variable:
      return bond_form(equations, s.bond, s.variable);
    case ModelSymbol::Kind::mode:
      return {};
  }
  return {};
}

UnitEquations unit_equations(const Model& model, const BondGraph& graph, const GivenUnits& given, const Scene* scene) {
  return UnitBuilder(model, graph, given, scene).build();
}

}  // namespace bgsim
