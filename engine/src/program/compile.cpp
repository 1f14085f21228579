#include <algorithm>
#include <limits>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "bgsim/program.hpp"
#include "program/freeze.hpp"
#include "program/implicit.hpp"
#include "program/joined_laws.hpp"
#include "program/one_border.hpp"
#include "program/partial_lists.hpp"
#include "program/patterns.hpp"
#include "program/strips.hpp"

namespace bgsim {
namespace {

constexpr std::int32_t kOnce = -2;    ///< level of what depends on parameters only
constexpr std::int32_t kNoLoop = -1;  ///< level of what varies but on no tear

class Compiler {
 public:
  /// @param plain  partials of what is not frozen yet, where a TransposedPlan is wanted; else null
  Compiler(std::shared_ptr<const Model> model, const EquationSystem& system, const BlockOrder& order,
           const CompileOptions& options, const SystemPartials* plain)
      : system_(system), order_(order), options_(options), plain_(plain), freeze_(system, order, program_) {
    program_.model = std::move(model);
  }

  Program run() {
    program_.time = system_.time;
    program_.parameters = system_.parameters;
    program_.system_class = order_.system_class;
    name_things();
    freeze_all();
    if (plain_ == nullptr) {
      partials_ =
          take_partials(program_.pool, program_.origins, system_, order_.blocks, rates_, residuals_, {}, nullptr);
    } else {
      partials_.guards = take_guard_partials(program_, system_, order_.blocks, *options_.columns);
      partials_.sets = take_set_partials(program_, system_, order_.blocks, event_values_, *options_.columns);
    }
    assign_slots();
    write_routines();
    make_patterns(program_, system_.states.size(), tears_.size());
    add_implicit_equations(program_, rates_, residuals_);
    return std::move(program_);
  }

 private:
  using Roots = std::vector<ExprId>;

  void name_things() {
    for (const State& state : system_.states) {
      program_.state_names.push_back(state.name);
      program_.states.push_back({place_of(*program_.model, state), state.element, state.port, state.signal});
    }
    for (const DependentStore& store : system_.dependent) {
      program_.dependent_names.push_back(store.name);
      program_.dependent.push_back(
          {program_.model->elements[store.element.index()].place, store.element, store.port, {}});
    }
    program_.left_out = system_.left_out;
    for (const std::size_t i : options_.outputs) {
      program_.output_names.push_back(system_.outputs[i].name);
      program_.output_units.push_back(system_.outputs[i].unit);
    }
    const Model& model = *program_.model;
    for (const Block& block : order_.blocks) {
      ProgramBlock compiled;
      compiled.first_tear = static_cast<std::uint32_t>(tears_.size());
      compiled.size = static_cast<std::uint32_t>(block.tears.size());
      compiled.linear = block.linear;
      compiled.refined = block.refined;
      for (const SymbolId tear : block.tears) {
        const SystemSymbol& symbol = system_.symbols[tear.index()];
        tears_.push_back(tear);
        block_of_tear_.push_back(static_cast<std::uint32_t>(program_.blocks.size()));
        compiled.tears.push_back(symbol.name);
        program_.tear_names.push_back(symbol.name);
        const Equation& equation = system_.equations[symbol.index];
        compiled.explicit_row.push_back(!equation.implicit && !equation.loop_form.valid());
      }
      for (const ElementId id : block.elements)
        if (!is_junction(model.elements[id.index()].kind)) compiled.elements.push_back(model.elements[id.index()].name);
      if (!block.elements.empty()) compiled.place = model.elements[block.elements.front().index()].place;
      program_.blocks.push_back(std::move(compiled));
    }
  }

  void freeze_all() {
    std::uint32_t values_of_events = 0;
    const auto freeze_list = [this](const std::vector<ExprId>& from) {
      Roots result;
      for (const ExprId e : from) result.push_back(e.valid() ? freeze_(e) : ExprId{});
      return result;
    };
    rates_ = freeze_list(order_.rates);
    for (const std::size_t i : options_.outputs) outputs_.push_back(freeze_(order_.outputs[i]));
    for (const Block& block : order_.blocks) residuals_.push_back(freeze_list(block.residuals));
    if (plain_ != nullptr) partials_ = changed(*plain_, [this](ExprId e) { return freeze_(e); });
    for (const DependentStore& store : system_.dependent)
      dependents_.push_back(freeze_(order_.resolved[store.symbol.index()]));
    for (std::size_t i = 0; i < system_.continuous.size(); ++i) {
      if (!order_.continuous[i].valid()) continue;
      continuous_.push_back(freeze_(order_.continuous[i]));
      program_.must_not_jump.push_back(system_.continuous[i].fault);
      program_.jumps_if_set.push_back(system_.continuous[i].is_set);
    }
    if (options_.energies) freeze_energies(freeze_list);
    switches_ = freeze_list(order_.switches);
    for (const SwitchEquation& at : system_.switches) program_.switch_elements.push_back(at.element);
    diodes_ = freeze_list(order_.diodes);
    for (const DiodeEquation& at : system_.diodes) program_.diode_elements.push_back(at.element);
    event_conditions_ = freeze_list(order_.event_conditions);
    event_values_ = freeze_list(order_.event_values);
    delayed_ = freeze_list(order_.delayed);
    delayed_before_ = freeze_list(order_.delayed_before);
    for (std::size_t i = 0; i < system_.events.size(); ++i) {
      const ModelEvent& event = program_.model->events[i];
      ProgramEvent compiled{event.name, event.priority, event.place, {}, values_of_events, event.at_start};
      for (std::size_t k = 0; k < event.sets.size(); ++k) {
        const EventEquation::Set& set = system_.events[i].sets[k];
        compiled.sets.push_back({set.state, set.name, event.sets[k].place});
      }
      values_of_events += static_cast<std::uint32_t>(event.sets.size());
      program_.events.push_back(std::move(compiled));
    }
    jump_ = freeze_list(order_.impulses);
    for (const ImpulseTerm& term : system_.jump.terms) program_.jump.terms.push_back({term.state, term.dependent});
    for (const ExprId e : freeze_list(order_.conjugates)) jump_.push_back(e);
    watch_denominators();
    for (std::uint32_t i = 0; i < program_.relations.size(); ++i) {
      if (program_.relations[i].time_only) continue;
      program_.guarded.push_back(i);
      guards_.push_back(program_.relations[i].guard);
    }
    if (options_.variations != nullptr) vary_guards(*options_.variations);
  }

  /// Total derivatives of all guards: when their conditions change, and how that depends on the parameter.
  void vary_guards(const Variations& variations) {
    program_.varied_states = variations.states;
    std::unordered_map<SymbolId, ExprId> changes[2];
    for (const auto& [symbol, change] : variations.by_parameter) changes[0][symbol] = freeze_(change);
    for (const auto& [symbol, change] : variations.by_time) changes[1][symbol] = freeze_(change);
    for (const Relation& relation : program_.relations)
      for (const auto& change : changes) {
        ExprId total = program_.pool.constant(0.0);
        // Those of denominators are not asked for: no law changes where they do.
        if (relation.kind != Relation::Kind::denominator)
          for (const auto& [symbol, partial] :
               gradient(program_.pool, relation.guard, [&](SymbolId s) { return change.contains(s); }))
            total = program_.pool.add(total, program_.pool.mul(partial, change.at(symbol)));
        program_.origins.resize(program_.pool.size(), relation.where);
        crossings_.push_back(total);
      }
  }

  /// Whatever the rates and the loops divide by.
  void watch_denominators() {
    std::vector<bool> varies;
    for (const SystemSymbol& symbol : system_.symbols) varies.push_back(symbol.kind != SystemSymbol::Kind::parameter);
    Roots roots = order_.rates;
    for (const Block& block : order_.blocks) roots.insert(roots.end(), block.residuals.begin(), block.residuals.end());
    for (const DenominatorFactor& factor : denominator_factors(*program_.model, order_, roots, varies))
      freeze_.watch(factor);
    roots.insert(roots.end(), order_.delayed.begin(), order_.delayed.end());  // their records are made of the steps
    find_sources(roots);
  }

  /// Expressions of time alone that stand in others, or alone.
  void find_sources(const Roots& roots) {
    const std::vector<ExprId> nodes = reachable(order_.pool, roots);
    std::vector<char> inner(order_.pool.size(), 0);
    const auto is_source = [this](ExprId e) { return order_.pool[e].op != Op::symbol && freeze_.follows_time(e); };
    for (const ExprId e : nodes) {
      if (is_leaf(order_.pool, e) || is_source(e)) continue;
      const ExprNode& node = order_.pool[e];
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) inner[children[k]] = 1;
    }
    for (const ExprId root : roots) inner[root.index()] = 1;
    for (const ExprId e : nodes)
      if (inner[e.index()] != 0 && is_source(e)) program_.sources.push_back(freeze_.plain(e));
  }

  template <class FreezeList>
  void freeze_energies(const FreezeList& freeze_list) {
    powers_ = freeze_list(order_.powers);
    for (const std::vector<ExprId>& at_ports : order_.port_powers) {
      program_.first_port_power.push_back(static_cast<std::uint32_t>(powers_.size()));
      for (const ExprId power : freeze_list(at_ports)) powers_.push_back(power);
    }
    program_.first_port_power.push_back(static_cast<std::uint32_t>(powers_.size()));
    stored_ = freeze_list(order_.stored);
    for (const EnergyPart& part : system_.energy) {
      program_.energy_names.push_back(program_.model->elements[part.element.index()].name);
      program_.energy_elements.push_back(part.element);
      program_.energy_roles.push_back(part.role);
      program_.energy_modulated.push_back(part.modulated);
      LawsOfStore laws{part.displacements, {}};
      // What a jump turns into heat is found from laws, also where the energy has a closed form.
      const bool needs_laws =
          !part.energy.valid() || !system_.switches.empty() || !system_.diodes.empty() || !system_.events.empty();
      if (part.role == EnergyPart::Role::store && !part.modulated && needs_laws)
        for (const ExprId e : part.conjugates) laws.conjugates.push_back(freeze_.plain(e));
      program_.store_laws.push_back(std::move(laws));
      program_.first_displacement.push_back(static_cast<std::uint32_t>(displacements_.size()));
      for (const SymbolId symbol : part.displacements) {
        const ExprId resolved = order_.resolved[symbol.index()];
        displacements_.push_back(resolved.valid() ? freeze_(resolved) : program_.pool.symbol(symbol));
      }
    }
    program_.first_displacement.push_back(static_cast<std::uint32_t>(displacements_.size()));
  }

  // --- slots

  void assign_slots() {
    const auto next = [this] { return static_cast<std::uint32_t>(program_.slot_expression.size()); };
    slot_of_.assign(program_.pool.size(), kNoSlot);
    const auto give = [&](SymbolId symbol) {
      // A symbol that no expression mentions still has its slot.
      const ExprId expression = program_.pool.symbol(symbol);
      if (expression.index() >= slot_of_.size()) slot_of_.resize(expression.index() + 1, kNoSlot);
      slot_of_[expression.index()] = next();
      program_.slot_expression.push_back(expression);
    };
    program_.time_slot = next();
    give(system_.time);
    program_.first_state = next();
    for (const State& state : system_.states) give(state.symbol);
    program_.first_tear = next();
    for (const SymbolId tear : tears_) give(tear);
    program_.first_mode = next();
    for (const SymbolId mode : freeze_.modes()) give(mode);
    program_.first_parameter = next();
    for (const SymbolId parameter : system_.parameters) give(parameter);
    program_.origins.resize(program_.pool.size());
    find_levels();
  }

  /// Level of every node: kOnce, kNoLoop, or the last loop whose tears it depends on.
  void find_levels() {
    const ExprPool& pool = program_.pool;
    std::vector<std::int32_t> of_symbol(program_.symbol_names.size(), kNoLoop);
    for (const SymbolId parameter : system_.parameters) of_symbol[parameter.index()] = kOnce;
    for (std::uint32_t i = 0; i < tears_.size(); ++i)
      of_symbol[tears_[i].index()] = static_cast<std::int32_t>(block_of_tear_[i]);
    level_.assign(pool.size(), kOnce);
    for (std::size_t i = 0; i < pool.size(); ++i) {
      const ExprNode& node = pool[ExprId(i)];
      if (node.op == Op::constant) continue;
      if (node.op == Op::symbol) {
        level_[i] = of_symbol[node.a];
        continue;
      }
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) level_[i] = std::max(level_[i], level_[children[k]]);
    }
  }

  std::uint32_t slot(ExprId expression) {
    std::uint32_t& result = slot_of_[expression.index()];
    if (result == kNoSlot) {
      result = static_cast<std::uint32_t>(program_.slot_expression.size());
      program_.slot_expression.push_back(expression);
    }
    return result;
  }

  // --- routines

  /// Appends the instructions that @p roots need of levels in [lowest, highest] and that this routine does not have
  /// yet. What lies below is taken as done; constants and the parameters' part go to `once`.
  void emit(const Roots& roots, std::int32_t lowest, std::int32_t highest, CodeList& code) {
    ++stamp_;
    Roots stack, found, fixed;
    const auto visit = [&](ExprId e) {
      const std::int32_t level = level_[e.index()];
      if (is_leaf(e) || seen_[e.index()] == stamp_) return;
      const bool above = level > highest;
      if (level != kOnce && (level < lowest || (!above && done_[e.index()] == routine_))) return;
      seen_[e.index()] = stamp_;
      if (level == kOnce)
        fixed.push_back(e);
      else
        stack.push_back(e);
    };
    for (const ExprId root : roots)
      if (root.valid()) visit(root);
    while (!stack.empty()) {
      const ExprId e = stack.back();
      stack.pop_back();
      if (level_[e.index()] <= highest) found.push_back(e);
      const ExprNode& node = program_.pool[e];
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) visit(ExprId(children[k]));
    }
    emit_once(std::move(fixed));
    std::sort(found.begin(), found.end());
    for (const ExprId e : found) done_[e.index()] = routine_;
    write(std::move(found), code);
  }

  /// What does not depend on each other side by side, by operator, where there is enough of it for loops.
  void write(Roots found, CodeList& code) {
    code.number = program_.code_lists++;
    constexpr std::size_t kWorthLoops = 64;
    const bool by_depth = found.size() >= kWorthLoops;
    if (by_depth) {
      depth_.resize(program_.pool.size(), 0);
      for (const ExprId e : found) {
        const ExprNode& node = program_.pool[e];
        const std::uint32_t children[] = {node.a, node.b, node.c};
        std::uint32_t below = 0;
        for (int k = 0; k < arity(node.op); ++k) below = std::max(below, depth_[children[k]]);
        depth_[e.index()] = below + 1;
      }
      const auto place = [this](ExprId e) { return std::tuple(depth_[e.index()], program_.pool[e].op, e); };
      std::sort(found.begin(), found.end(), [&](ExprId a, ExprId b) { return place(a) < place(b); });
    }
    std::vector<std::uint32_t> depths;
    for (const ExprId e : found) {
      code.instructions.push_back(instruction(e));
      if (by_depth) depths.push_back(std::exchange(depth_[e.index()], 0));
    }
    code.strips = strips_of(code.instructions, depths);
  }

  void emit_once(Roots stack) {
    Roots found;
    while (!stack.empty()) {
      const ExprId e = stack.back();
      stack.pop_back();
      if (is_leaf(e) || once_done_[e.index()] != 0) continue;
      once_done_[e.index()] = 1;
      found.push_back(e);
      const ExprNode& node = program_.pool[e];
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) stack.emplace_back(children[k]);
    }
    std::sort(found.begin(), found.end());
    for (const ExprId e : found) program_.once.code[0].instructions.push_back(instruction(e));
  }

  [[nodiscard]] static bool is_leaf(const ExprPool& pool, ExprId e) {
    return pool[e].op == Op::constant || pool[e].op == Op::symbol;
  }
  [[nodiscard]] bool is_leaf(ExprId e) const { return is_leaf(program_.pool, e); }

  Instruction instruction(ExprId e) {
    const ExprNode node = program_.pool[e];
    Instruction result{node.op, 0, 0, 0, 0};
    result.a = slot(ExprId(node.a));
    if (is_table(node.op)) {
      result.b = node.b;
      const std::uint32_t relation = freeze_.cell_relation(ExprId(node.a), TableId(node.b));
      result.c = relation == kNoSlot ? kNoSlot : program_.first_mode + relation;
    } else {
      if (arity(node.op) > 1) result.b = slot(ExprId(node.b));
      if (arity(node.op) > 2) result.c = slot(ExprId(node.c));
    }
    result.out = slot(e);
    return result;
  }

  /// The loops that @p roots depend on, and those that these depend on, increasing.
  std::vector<std::uint32_t> loops_below(const Roots& roots) {
    std::vector<bool> needed(program_.blocks.size(), false);
    ++stamp_;
    Roots stack;
    const auto push = [&](ExprId e) {
      if (!e.valid() || level_[e.index()] < 0 || seen_[e.index()] == stamp_) return;
      seen_[e.index()] = stamp_;
      stack.push_back(e);
    };
    for (const ExprId root : roots) push(root);
    while (!stack.empty()) {
      const ExprId e = stack.back();
      stack.pop_back();
      const ExprNode& node = program_.pool[e];
      if (node.op == Op::symbol) {
        const auto block = static_cast<std::size_t>(level_[e.index()]);
        if (needed[block]) continue;
        needed[block] = true;
        for (const ExprId residual : residuals_[block]) push(residual);
        continue;
      }
      if (node.op == Op::constant) continue;
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) push(ExprId(children[k]));
    }
    std::vector<std::uint32_t> result;
    for (std::uint32_t b = 0; b < needed.size(); ++b)
      if (needed[b]) result.push_back(b);
    return result;
  }

  Roots block_roots(std::uint32_t b) const {
    Roots roots = residuals_[b];
    for (const Partial& partial : partials_.blocks[b].by_own_tears) roots.push_back(partial.value);
    return roots;
  }

  Routine routine(const Roots& roots, bool solve_loops = true) {
    Routine result;
    ++routine_;
    const auto all_levels = static_cast<std::int32_t>(program_.blocks.size());
    if (solve_loops)
      for (const std::uint32_t b : loops_below(roots)) {
        emit(block_roots(b), kNoLoop, static_cast<std::int32_t>(b) - 1, result.code.emplace_back());
        result.solves.push_back(b);
      }
    emit(roots, kNoLoop, all_levels, result.code.emplace_back());
    for (const ExprId root : roots) result.results.push_back(root.valid() ? slot(root) : kNoSlot);
    return result;
  }

  void find_delays() {
    for (const EquationSystem::Delay& delay : system_.delays) {
      const Model& model = *program_.model;
      const Signal& signal = model.signals[delay.signal.index()];
      const auto is_clock = [&](const State& state) { return state.signal == signal.delay->clock; };
      const auto clock = std::find_if(system_.states.begin(), system_.states.end(), is_clock) - system_.states.begin();
      program_.delays.push_back({signal.name, program_.pool.add_table(model.pool.tables()[signal.delay->table.index()]),
                                 static_cast<std::uint32_t>(clock), delay.initial.valid(), signal.place});
    }
  }

  void write_routines() {
    once_done_.assign(program_.pool.size(), 0);
    done_.assign(program_.pool.size(), 0);
    seen_.assign(program_.pool.size(), 0);
    program_.once.code.emplace_back();
    for (std::uint32_t b = 0; b < program_.blocks.size(); ++b) write_block(b);
    program_.rates = routine(rates_);
    program_.outputs = routine(outputs_);
    program_.guards = routine(guards_);
    program_.dependents = routine(dependents_);
    program_.continuous = routine(continuous_);
    program_.crossings = routine(crossings_);
    program_.switches = routine(switches_);
    program_.diodes = routine(diodes_);
    program_.event_conditions = routine(event_conditions_);
    program_.event_values = routine(event_values_);
    program_.delayed = routine(delayed_);
    program_.delayed_before = routine(delayed_before_);
    find_delays();
    program_.jump.routine = routine(jump_);
    if (options_.energies) {
      program_.powers = routine(powers_);
      program_.stored = routine(stored_);
      program_.displacements = routine(displacements_);
    }
    Roots implicit = rates_;
    for (const Roots& residuals : residuals_) implicit.insert(implicit.end(), residuals.begin(), residuals.end());
    if (!program_.blocks.empty())
      program_.implicit_residual = routine(implicit, false);
    else
      program_.implicit_residual = program_.rates;
    write_plan();
    finish_slots();
  }

  void write_block(std::uint32_t b) {
    ProgramBlock& block = program_.blocks[b];
    const auto level = static_cast<std::int32_t>(b);
    ++routine_;
    emit(residuals_[b], level, level, block.residual.code.emplace_back());
    for (const ExprId e : residuals_[b]) block.residual.results.push_back(slot(e));
    Roots partials;
    for (const Partial& partial : partials_.blocks[b].by_own_tears) {
      partials.push_back(partial.value);
      block.entries.emplace_back(partial.row, partial.column);
    }
    emit(partials, level, level, block.jacobian.code.emplace_back());
    for (const ExprId e : partials) block.jacobian.results.push_back(slot(e));
  }

  std::vector<JacobianPlan::Entry> entries(const Partials& partials, Roots& roots) {
    std::vector<JacobianPlan::Entry> result;
    for (const Partial& partial : partials) {
      roots.push_back(partial.value);
      result.push_back({partial.row, partial.column, slot(partial.value)});
    }
    return result;
  }

  void write_plan() {
    JacobianPlan& plan = program_.plan;
    Roots roots;
    plan.rates_by_states = entries(partials_.rates_by_states, roots);
    plan.rates_by_tears = entries(partials_.rates_by_tears, roots);
    plan.block_of_tear = block_of_tear_;
    for (const BlockPartials& block : partials_.blocks)
      plan.blocks.push_back({entries(block.by_states, roots),
                             entries(block.by_earlier_tears, roots),
                             entries(block.by_own_tears, roots),
                             {}});
    for (const Roots& residuals : residuals_) roots.insert(roots.end(), residuals.begin(), residuals.end());
    plan.routine = routine(roots);
    plan.implicit_routine = program_.blocks.empty() ? plan.routine : routine(roots, false);
    find_supports(program_, order_.system_class);
    if (options_.columns != nullptr) write_transposed(std::move(roots));
  }

  /// @param roots  of the Jacobian's plan
  void write_transposed(Roots roots) {
    TransposedPlan& plan = program_.transposed;
    plan.columns = *options_.columns;
    plan.rates = entries(partials_.rates_by_columns, roots);
    for (const BlockPartials& block : partials_.blocks) plan.blocks.push_back(entries(block.by_columns, roots));
    Roots of_events = roots;
    const auto rows = [this](const RowPartials& from, Roots& to) {
      TransposedPlan::Rows result;
      result.by_states = entries(from.by_states, to);
      result.by_tears = entries(from.by_tears, to);
      result.by_columns = entries(from.by_columns, to);
      return result;
    };
    plan.outputs = rows(partials_.outputs, roots);
    plan.guards = rows(partials_.guards, of_events);
    plan.sets = rows(partials_.sets, of_events);
    plan.routine = routine(roots);
    plan.events_routine = routine(of_events);
  }

  void finish_slots() {
    program_.once.code[0].strips = strips_of(program_.once.code[0].instructions, {});
    program_.slots = program_.slot_expression.size();
    program_.initial_slots.assign(program_.slots, 0.0);
    for (std::size_t i = 0; i < program_.slots; ++i) {
      const ExprNode& node = program_.pool[program_.slot_expression[i]];
      if (node.op == Op::constant) program_.initial_slots[i] = node.constant;
    }
  }

  const EquationSystem& system_;
  const BlockOrder& order_;
  const CompileOptions& options_;
  const SystemPartials* plain_;
  Program program_;
  Freezer freeze_;
  std::vector<SymbolId> tears_;
  std::vector<std::uint32_t> block_of_tear_;
  Roots rates_, outputs_, guards_, dependents_, continuous_, powers_, stored_, displacements_, switches_, diodes_,
      event_conditions_, event_values_, delayed_, delayed_before_, jump_, crossings_;
  std::vector<Roots> residuals_;  ///< by block
  SystemPartials partials_;
  std::vector<std::int32_t> level_;     ///< by ExprId
  std::vector<std::uint32_t> slot_of_;  ///< by ExprId
  std::vector<std::uint32_t> seen_, once_done_, done_;
  std::vector<std::uint32_t> depth_;       ///< by ExprId: of what is being written
  std::uint32_t stamp_ = 0, routine_ = 0;  ///< marks in seen_ and done_
};

}  // namespace

Program compile(std::shared_ptr<const Model> model, const EquationSystem& system, const BlockOrder& order,
                const CompileOptions& options) {
  const std::optional<BlockOrder> joined = with_joined_laws(system, order);
  const std::optional<BlockOrder> one_border = with_one_border(*model, system, joined ? *joined : order);
  const BlockOrder& of = one_border ? *one_border : joined ? *joined : order;
  if (options.columns == nullptr) return Compiler(std::move(model), system, of, options, nullptr).run();
  BlockOrder with = of;
  const SystemPartials plain = take_plain_partials(system, with, options);
  return Compiler(std::move(model), system, with, options, &plain).run();
}

}  // namespace bgsim
