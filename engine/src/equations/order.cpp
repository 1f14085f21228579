#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "base/codes.hpp"
#include "base/strong_parts.hpp"
#include "bgsim/ordering.hpp"
#include "equations/loops.hpp"
#include "equations/tearing.hpp"
#include "expression/monotone.hpp"
#include "expression/signed_power.hpp"
#include "graph/law_numbers.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {
namespace {

/// Orders the unknowns that something needs depends on, loop by loop.
class Ordering {
 public:
  Ordering(const Model& model, const EquationSystem& system) : model_(model), system_(system) {
    order_.pool = system.pool;
    order_.origins = system.origins;
    order_.resolved.resize(system.symbols.size());
  }

  BlockOrder run() {
    find_needed();
    find_components();
    if (!system_.dependent.empty()) find_rates();
    for (const std::vector<std::uint32_t>& component : components_) resolve_component(component);
    for (const State& state : system_.states) order_.rates.push_back(resolve(state.rate));
    for (const OutputEquation& output : system_.outputs) order_.outputs.push_back(resolve(output.value));
    for (const EnergyPart& part : system_.energy) {
      order_.powers.push_back(resolve(part.power));
      order_.port_powers.emplace_back();
      for (const ExprId power : part.port_powers) order_.port_powers.back().push_back(resolve(power));
      order_.stored.push_back(part.energy.valid() && !part.modulated ? resolve(part.energy) : ExprId{});
    }
    for (const SwitchEquation& at : system_.switches) order_.switches.push_back(resolve(at.leaves));
    for (const DiodeEquation& at : system_.diodes)
      for (const ExprId e : {at.effort, at.flow, at.threshold, at.fires}) order_.diodes.push_back(resolve(e));
    for (const EventEquation& event : system_.events) {
      order_.event_conditions.push_back(resolve(event.when));
      for (const EventEquation::Set& set : event.sets) order_.event_values.push_back(resolve(set.value));
    }
    for (const EquationSystem::Delay& delay : system_.delays) {
      for (const ExprId e : {delay.value, delay.by}) order_.delayed.push_back(resolve(e));
      order_.delayed_before.push_back(delay.initial.valid() ? resolve(delay.initial) : order_.pool.constant(0.0));
    }
    for (const ImpulseTerm& term : system_.jump.terms) order_.impulses.push_back(resolve(term.factor));
    for (const ExprId e : system_.jump.conjugates) order_.conjugates.push_back(resolve(e));
    for (const Continuous& quantity : system_.continuous)
      order_.continuous.push_back(needed_[equation_of(quantity.derivative)] ? resolve(quantity.value) : ExprId{});
    order_.origins.resize(order_.pool.size());
    if (!problems_.empty()) throw ModelError(std::move(problems_), model_.sources);
    classify();
    return std::move(order_);
  }

 private:
  [[nodiscard]] std::uint32_t equation_of(SymbolId symbol) const { return system_.symbols[symbol.index()].index; }

  /// Unknowns on which an equation's right-hand side depends (itself among them if the equation is implicit).
  [[nodiscard]] std::vector<std::uint32_t> dependencies(ExprId expression) const {
    return equations_in(system_, expression);
  }

  /// Marks the equations that rates, outputs, powers, dependent stores need.
  void find_needed() {
    needed_.assign(system_.equations.size(), false);
    depends_on_.resize(system_.equations.size());
    std::vector<std::uint32_t> open;
    const auto need = [&](std::uint32_t equation) {
      if (needed_[equation]) return;
      needed_[equation] = true;
      open.push_back(equation);
    };
    const auto need_all = [&](ExprId root) {
      for (const std::uint32_t equation : dependencies(root)) need(equation);
    };
    for (const State& state : system_.states) need_all(state.rate);
    for (const OutputEquation& output : system_.outputs) need_all(output.value);
    for (const EnergyPart& part : system_.energy) need_all(part.power);
    for (const DependentStore& store : system_.dependent) need(equation_of(store.symbol));
    for (const SwitchEquation& at : system_.switches) need_all(at.leaves);
    for (const DiodeEquation& at : system_.diodes)
      for (const ExprId e : {at.effort, at.flow, at.threshold, at.fires}) need_all(e);
    for (const EventEquation& event : system_.events) {
      need_all(event.when);
      for (const EventEquation::Set& set : event.sets) need_all(set.value);
    }
    for (const EquationSystem::Delay& delay : system_.delays)
      for (const ExprId e : {delay.value, delay.by, delay.initial})
        if (e.valid()) need_all(e);
    for (const ImpulseTerm& term : system_.jump.terms) need_all(term.factor);
    for (const ExprId e : system_.jump.conjugates) need_all(e);
    while (!open.empty()) {
      const std::uint32_t equation = open.back();
      open.pop_back();
      depends_on_[equation] = dependencies(system_.equations[equation].expression);
      if (const ExprId whole = system_.equations[equation].whole; whole.valid()) need_all(whole);
      for (const std::uint32_t other : depends_on_[equation]) need(other);
    }
  }

  void find_components() {
    const StrongParts parts = strong_parts(depends_on_);
    std::vector<std::vector<std::uint32_t>> all(parts.count);
    for (std::uint32_t i = 0; i < parts.part_of.size(); ++i)
      if (needed_[i]) all[parts.part_of[i]].push_back(i);
    for (auto& members : all)
      if (!members.empty()) components_.push_back(std::move(members));
  }

  void find_rates() {
    for (const State& state : system_.states)
      if (const auto equation = multiple_of(state.rate)) state_of_rate_.emplace(*equation, state.element);
    for (const DependentStore& store : system_.dependent)
      if (const auto equation = multiple_of(store.rate)) dependent_of_rate_.emplace(*equation, store.element);
  }

  /// Whether rates by differences would have lost more digits than a tolerance leaves: as many as the stores of the
  /// loop differ by, with each modulus squared that may be between them. Those of states' signals count as 1, and so do
  /// moduli that states have a say in; a store without one number may be of any size.
  [[nodiscard]] bool far_apart(const std::vector<std::uint32_t>& component) const {
    constexpr double kFar = 1e6;  // of sixteen digits ten are left
    const NumberOf number = numbers_at_start(model_);
    const auto size_of = [&](ElementId id) {
      const ExprId coefficient = model_.elements[id.index()].coefficient;
      return coefficient.valid() ? std::abs(value_of(model_.pool, coefficient, number)) : 0.0;
    };
    double least = std::numeric_limits<double>::infinity(), most = 0.0, moduli = 1.0;
    std::set<ElementId> met;
    for (const std::uint32_t i : component) {
      const ElementId element = system_.equations[i].element;
      if (element.valid() && kind_row(model_.elements[element.index()].kind).family == Family::two_port &&
          met.insert(element).second)
        if (const double modulus = size_of(element); modulus > 0.0) moduli *= std::max(modulus, 1.0 / modulus);
      for (const auto* stores : {&state_of_rate_, &dependent_of_rate_}) {
        const auto store = stores->find(i);
        if (store == stores->end()) continue;
        const double size = store->second.valid() ? size_of(store->second) : 1.0;
        if (!(size > 0.0)) return true;
        least = std::min(least, size);
        most = std::max(most, size);
      }
    }
    return !(most / least * moduli * moduli <= kFar);
  }

  /// The equation of the unknown that an expression is a multiple of.
  [[nodiscard]] std::optional<std::uint32_t> multiple_of(ExprId expression) const {
    const ExprPool& pool = system_.pool;
    for (;;) {
      const ExprNode& node = pool[expression];
      if (node.op == Op::symbol) {
        const SystemSymbol& meant = system_.symbols[pool.symbol_of(expression).index()];
        return meant.kind == SystemSymbol::Kind::unknown ? std::optional(meant.index) : std::nullopt;
      }
      if (node.op == Op::neg || (node.op == Op::div && equations_in(system_, ExprId(node.b)).empty()) ||
          (node.op == Op::mul && equations_in(system_, ExprId(node.b)).empty()))
        expression = ExprId(node.a);
      else if (node.op == Op::mul && equations_in(system_, ExprId(node.a)).empty())
        expression = ExprId(node.b);
      else
        return std::nullopt;
    }
  }

  /// @param local  members by equation.
  void find_rates_in(const std::vector<std::uint32_t>& component,
                     const std::unordered_map<std::uint32_t, std::uint32_t>& local, LoopGraph& loop) const {
    for (std::uint32_t i = 0; i < component.size(); ++i) {
      if (state_of_rate_.contains(component[i])) loop.rates.push_back(i);
      if (dependent_of_rate_.contains(component[i])) loop.dependent_rates.push_back(i);
    }
    if (loop.rates.empty()) return;
    loop.far_apart = loop.rates.size() > 1 && far_apart(component);
    for (std::uint32_t i = 0; i < component.size(); ++i) {
      const auto of = loop.must_tear[i] ? std::nullopt : multiple_of(system_.equations[component[i]].expression);
      const auto found = of ? local.find(*of) : local.end();
      loop.multiple_of.push_back(found == local.end() ? i : found->second);
    }
  }

  ExprId resolve(ExprId expression) { return substitute(order_.pool, expression, replacement_); }

  /// Substitutes known unknowns into an equation; what is new in the pool belongs to the equation's element.
  ExprId resolve_equation(const Equation& equation) {
    const ExprId result = resolve(equation.expression);
    order_.origins.resize(order_.pool.size(), origin_of(system_, equation));
    return result;
  }

  void set_resolved(const Equation& equation, ExprId expression) {
    order_.resolved[equation.unknown.index()] = expression;
    replacement_[equation.unknown] = expression;
  }

  void resolve_component(const std::vector<std::uint32_t>& component) {
    const Equation& first = system_.equations[component.front()];
    const auto& own = depends_on_[component.front()];
    const bool alone =
        component.size() == 1 && !first.implicit && std::find(own.begin(), own.end(), component.front()) == own.end();
    if (alone) return set_resolved(first, resolve_equation(first));
    resolve_loop(component);
  }

  void resolve_loop(const std::vector<std::uint32_t>& component) {
    std::unordered_map<std::uint32_t, std::uint32_t> local;
    for (std::uint32_t i = 0; i < component.size(); ++i) local[component[i]] = i;
    LoopGraph loop;
    loop.depends_on.resize(component.size());
    for (std::uint32_t i = 0; i < component.size(); ++i) {
      loop.must_tear.push_back(system_.equations[component[i]].implicit ||
                               system_.equations[component[i]].loop_form.valid());
      for (const std::uint32_t other : depends_on_[component[i]])
        if (const auto found = local.find(other); found != local.end()) loop.depends_on[i].push_back(found->second);
    }
    find_rates_in(component, local, loop);
    const Tearing tearing = tear(loop);

    Block block;
    block.refined = tearing.by_rates;
    for (const std::uint32_t i : component) block.members.push_back(system_.equations[i].unknown);
    for (const std::uint32_t i : tearing.tears) {
      const Equation& equation = system_.equations[component[i]];
      block.tears.push_back(equation.unknown);
      set_resolved(equation, order_.pool.symbol(equation.unknown));
    }
    for (const std::uint32_t i : tearing.sequence) {
      const Equation& equation = system_.equations[component[i]];
      set_resolved(equation, resolve_equation(equation));
    }
    for (const std::uint32_t i : tearing.tears) {
      const Equation& equation = system_.equations[component[i]];
      ExprId residual = equation.loop_form.valid() ? resolve(equation.loop_form) : resolve_equation(equation);
      if (!equation.implicit && !equation.loop_form.valid())
        residual = order_.pool.sub(order_.pool.symbol(equation.unknown), residual);
      order_.origins.resize(order_.pool.size(), Origin{equation.element, {}});
      block.residuals.push_back(residual);
    }
    name_elements(component, block);
    examine(block);
    if (!block.linear && solve_by_root(component, tearing, block)) return;
    order_.blocks.push_back(std::move(block));
  }

  [[nodiscard]] bool is_of_parameters(ExprId expression) const {
    const std::vector<SymbolId> named = symbols_in(order_.pool, {&expression, 1});
    return std::all_of(named.begin(), named.end(), [&](SymbolId symbol) {
      return system_.symbols[symbol.index()].kind == SystemSymbol::Kind::parameter;
    });
  }

  /// A loop of one unknown whose laws are powers of it of one degree has a closed form: orifices in series are one.
  /// Unknowns that these laws give are put in before. What varies may come to 0, where such a loop has no solution
  /// of this form.
  bool solve_by_root(const std::vector<std::uint32_t>& component, const Tearing& tearing, const Block& block) {
    constexpr std::size_t kMost = 16;  // each that is put in is looked for among all
    if (block.tears.size() > kMost) return false;
    ExprPool& pool = order_.pool;
    std::vector<ExprId> residuals = block.residuals;
    std::vector<std::size_t> left(residuals.size());
    std::iota(left.begin(), left.end(), std::size_t{0});
    std::vector<std::pair<std::size_t, ExprId>> solutions;  // each in terms of those after it
    while (!left.empty()) {
      const auto next = std::find_if(left.begin(), left.end(), [&](std::size_t i) {
        const auto law = offset_power(pool, residuals[i], block.tears[i]);
        if (!law || law->power.power.is(1.0) == (left.size() == 1) || !is_of_parameters(law->power.factor))
          return false;
        solutions.emplace_back(i, solution_of(pool, *law, pool.constant(0.0)));
        return true;
      });
      if (next == left.end()) return false;
      const std::unordered_map<SymbolId, ExprId> known{{block.tears[*next], solutions.back().second}};
      left.erase(next);
      for (const std::size_t i : left) residuals[i] = substitute(pool, residuals[i], known);
    }
    for (auto at = solutions.rbegin(); at != solutions.rend(); ++at) {
      const Equation& equation = system_.equations[component[tearing.tears[at->first]]];
      const ExprId solution = resolve(at->second);
      order_.origins.resize(pool.size(), Origin{equation.element, {}});
      set_resolved(equation, solution);
    }
    for (const std::uint32_t i : tearing.sequence) {
      const Equation& equation = system_.equations[component[i]];
      set_resolved(equation, resolve_equation(equation));
    }
    return true;
  }

  void name_elements(const std::vector<std::uint32_t>& component, Block& block) const {
    for (const std::uint32_t i : component)
      if (const ElementId id = system_.equations[i].element; id.valid()) block.elements.push_back(id);
    std::sort(block.elements.begin(), block.elements.end());
    block.elements.erase(std::unique(block.elements.begin(), block.elements.end()), block.elements.end());
  }

  /// Linear or not; and whether the residuals can be matched with the tears at all.
  void examine(Block& block) {
    std::unordered_map<SymbolId, std::uint32_t> position;
    for (std::uint32_t i = 0; i < block.tears.size(); ++i) position[block.tears[i]] = i;
    const auto own = [&](SymbolId symbol) { return position.contains(symbol); };
    std::vector<std::vector<std::uint32_t>> pattern(block.tears.size());
    std::vector<ExprId> all_partials;
    for (std::size_t r = 0; r < block.residuals.size(); ++r)
      for (const auto& [symbol, partial] : gradient(order_.pool, block.residuals[r], own)) {
        pattern[r].push_back(position[symbol]);
        all_partials.push_back(partial);
      }
    const std::vector<SymbolId> inside = symbols_in(order_.pool, all_partials);
    block.linear = std::none_of(inside.begin(), inside.end(), own);
    if (!has_full_matching(pattern)) report_singular(block);
  }

  void report_singular(const Block& block) {
    std::string through;
    Diagnostic problem =
        diagnostic_of("BG411", {}, {}, "a loop can be solved only if its equations contain its unknowns",
                      "the elements on the loop contradict or repeat each other: give one of them a resistance or a "
                      "storage of its own, or correct its modulus");
    const auto junction = [this](ElementId id) { return is_junction(model_.elements[id.index()].kind); };
    const bool only_junctions = std::all_of(block.elements.begin(), block.elements.end(), junction);
    for (const ElementId id : block.elements) {
      const Element& element = model_.elements[id.index()];
      if (junction(id) && !only_junctions) continue;
      through += (through.empty() ? "\"" : ", \"") + element.name + "\"";
      problem.notes.push_back({element.place, "the loop runs through \"" + element.name + "\""});
    }
    if (problem.notes.size() == 1) problem.notes.clear();  // the place itself says as much
    if (!singular_.insert(through).second) return;         // its efforts or its flows have been reported
    problem.situation = "the algebraic loop through " + through + " is structurally singular";
    if (!block.elements.empty()) problem.place = model_.elements[block.elements.front().index()].place;
    problems_.push_back(std::move(problem));
  }

  void classify() {
    std::size_t largest = 0;
    for (const Block& block : order_.blocks) largest = std::max(largest, block.tears.size());
    order_.system_class = order_.blocks.empty()           ? SystemClass::explicit_ode
                          : largest <= kLargestLocalBlock ? SystemClass::local_blocks
                                                          : SystemClass::implicit_dae;
  }

  const Model& model_;
  const EquationSystem& system_;
  BlockOrder order_;
  std::vector<bool> needed_;                            ///< by equation
  std::vector<std::vector<std::uint32_t>> depends_on_;  ///< by equation
  /// By equation: the store whose rate is a multiple of its unknown; none: an integral among the signals.
  std::unordered_map<std::uint32_t, ElementId> state_of_rate_, dependent_of_rate_;
  std::vector<std::vector<std::uint32_t>> components_;  ///< in order of evaluation
  std::unordered_map<SymbolId, ExprId> replacement_;
  std::vector<Diagnostic> problems_;
  std::set<std::string> singular_;  ///< loops that have been reported, by their elements
};

}  // namespace

BlockOrder order_equations(const Model& model, const EquationSystem& system) { return Ordering(model, system).run(); }

}  // namespace bgsim
