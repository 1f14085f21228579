#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>
#include <optional>
#include <stdexcept>
#include <unordered_map>

#include "base/latex_text.hpp"
#include "bgsim/describe.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"
#include "bgsim/xml.hpp"
#include "expression/write/layout.hpp"
#include "expression/write/tidy.hpp"

namespace bgsim {
namespace {

enum class Notation : std::uint8_t { text, latex, mathml };

/// The equations to be shown: loops of one linear unknown are solved in closed form, signals keep their names, and
/// large shared parts get names of their own, so that the text stays as small as the model.
class ReadableEquations {
 public:
  ReadableEquations(const Model& model, const EquationSystem& system, const BlockOrder& order, Notation notation)
      : notation_(notation), system_(system), order_(order), pool_(order.pool) {
    for (const SystemSymbol& symbol : system.symbols) names_.push_back(symbol.name);
    solve_small_loops();
    for (const Signal& signal : model.signals) collect_signal(signal);
    for (const State& state : system.states) rates_.push_back(close(order.rates[index_of(state)]));
    for (const DependentStore& store : system.dependent)
      dependent_.push_back(close(order.resolved[store.symbol.index()]));
    for (const ExprId output : order.outputs) outputs_.push_back(close(output));
    for (const ExprId value : order.event_values) event_values_.push_back(close(value));
    // A condition was made a number, to be computed like one.
    for (const ExprId when : order.event_conditions)
      event_conditions_.push_back(pool_[close(when)].op == Op::select ? ExprId(pool_[close(when)].a) : close(when));
    name_signals();
    name_shared_parts();
    tell_names_apart();
    prepare_display();
  }

  /// The right side in the pieces between which it may be broken; text and LaTeX have one.
  using Line = EquationLine;

  std::vector<Line> states() {
    std::vector<Line> lines;
    for (std::size_t i = 0; i < rates_.size(); ++i) {
      const SymbolId symbol = system_.states[i].symbol;
      lines.push_back(line(rate_name(symbol), rates_[i]));
    }
    return lines;
  }
  std::vector<Line> where() {
    std::vector<Line> lines;
    for (const auto& [symbol, expression] : named_) lines.push_back(definition(symbol, expression));
    return lines;
  }
  std::vector<Line> loops() {
    std::vector<Line> lines;
    for (const Block& block : order_.blocks) {
      if (closed(block)) continue;
      for (const ExprId residual : block.residuals) lines.push_back(line(zero(), rename(close(residual))));
    }
    return lines;
  }
  std::vector<Line> dependent() {
    std::vector<Line> lines;
    for (std::size_t i = 0; i < dependent_.size(); ++i)
      lines.push_back(definition(system_.dependent[i].symbol, rename(dependent_[i])));
    return lines;
  }
  std::vector<Line> outputs() {
    std::vector<Line> lines;
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      lines.push_back(line(upright(system_.outputs[i].name), rename(outputs_[i])));
    }
    return lines;
  }
  /// What each event sets; the title says when.
  std::vector<EquationGroup> events(const Model& model) {
    std::vector<EquationGroup> groups;
    std::size_t value = 0;
    for (std::size_t i = 0; i < system_.events.size(); ++i) {
      const ModelEvent& event = model.events[i];
      const std::string name = short_name(event.name);
      EquationGroup group;
      if (event.sampled.valid()) {
        const auto symbol = [&model](SymbolId id) { return symbol_name(model, id); };
        group.title =
            "sample of " + name + ", each " + to_text(model.pool, model.signals[event.sampled.index()].every, symbol);
      } else {
        group.title = "event " + name + ", where " +
                      to_text(pool_, rename(event_conditions_[i]), [this](SymbolId s) { return names_[s.index()]; });
      }
      for (const EventEquation::Set& set : system_.events[i].sets)
        group.lines.push_back(line(upright(set.name), rename(event_values_[value++])));
      groups.push_back(std::move(group));
    }
    return groups;
  }
  [[nodiscard]] std::string loop_unknowns() const {
    std::string result;
    for (const Block& block : order_.blocks)
      if (!closed(block))
        for (const SymbolId tear : block.tears) result += (result.empty() ? "" : ", ") + names_[tear.index()];
    return result;
  }

 private:
  static constexpr std::size_t kLargestUnnamed = 60;  ///< nodes of a shared part that is still repeated in full

  [[nodiscard]] std::size_t index_of(const State& state) const {
    return static_cast<std::size_t>(&state - system_.states.data());
  }
  static bool closed(const Block& block) { return block.linear && block.tears.size() == 1; }

  /// Loops of one linear unknown in closed form: put in where the unknown is used once, named where it is used more
  /// often.
  void solve_small_loops() {
    const std::unordered_map<ExprId, std::size_t> uses = count_uses();
    for (const Block& block : order_.blocks) {
      if (!closed(block)) continue;
      const SymbolId tear = block.tears[0];
      const auto form = linear_in(pool_, close(block.residuals[0]), tear);
      if (!form) continue;
      const ExprId solution = pool_.neg(pool_.div(form->offset, form->slope));
      const auto used = uses.find(pool_.symbol(tear));
      if (used != uses.end() && used->second > 1)
        signals_.emplace_back(tear, solution);
      else
        solved_[tear] = solution;
    }
  }
  /// By how many operators each expression is used in what is shown.
  [[nodiscard]] std::unordered_map<ExprId, std::size_t> count_uses() const {
    std::vector<ExprId> roots = order_.rates;
    roots.insert(roots.end(), order_.outputs.begin(), order_.outputs.end());
    std::unordered_map<ExprId, std::size_t> uses;
    for (const ExprId e : reachable(order_.pool, roots)) {
      const ExprNode& node = order_.pool[e];
      if (node.op == Op::constant || node.op == Op::symbol) continue;
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) ++uses[ExprId(children[k])];
    }
    return uses;
  }
  ExprId close(ExprId expression) { return substitute(pool_, expression, solved_); }

  void collect_signal(const Signal& signal) {
    for (const Equation& equation : system_.equations) {
      const std::string& name = names_[equation.unknown.index()];
      if (name != signal.name || !order_.resolved[equation.unknown.index()].valid()) continue;
      const ExprId expression = close(order_.resolved[equation.unknown.index()]);
      if (pool_.is_symbol(expression) || pool_.is_constant(expression)) return;
      signals_.emplace_back(equation.unknown, expression);
      return;
    }
  }

  /// Copies a root with the named parts replaced by their names.
  ExprId rename(ExprId root) {
    std::unordered_map<ExprId, ExprId> copy;
    const std::vector<ExprId> roots{root};
    for (const ExprId e : reachable(pool_, roots)) {
      if (const auto named = name_of_part_.find(e); named != name_of_part_.end()) {
        copy[e] = pool_.symbol(named->second);
        continue;
      }
      copy[e] = rebuild(e, copy);
    }
    return copy[root];
  }
  ExprId rebuild(ExprId e, const std::unordered_map<ExprId, ExprId>& copy) {
    const ExprNode node = pool_[e];
    if (node.op == Op::constant || node.op == Op::symbol) return e;
    const auto at = [&](std::uint32_t child) { return copy.at(ExprId(child)); };
    if (node.op == Op::table || node.op == Op::table_slope) return pool_.table(node.op, at(node.a), TableId(node.b));
    switch (arity(node.op)) {
      case 1:
        return pool_.make(node.op, at(node.a));
      case 2:
        return pool_.make(node.op, at(node.a), at(node.b));
      default:
        return pool_.select(at(node.a), at(node.b), at(node.c));
    }
  }

  void name_signals() {
    // A signal's own definition may use other signals: the smaller ids are inside the larger ones.
    std::sort(signals_.begin(), signals_.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    for (const auto& [symbol, expression] : signals_) {
      const ExprId definition_text = rename(expression);
      name_of_part_.emplace(expression, symbol);
      named_.emplace_back(symbol, definition_text);
    }
    for (ExprId& rate : rates_) rate = rename(rate);
    drop_unused_names();
  }

  void drop_unused_names() {
    // Signals that no state equation mentions are left out.
    std::vector<ExprId> roots = rates_;
    for (const Block& block : order_.blocks)
      if (!closed(block))
        for (const ExprId residual : block.residuals) roots.push_back(rename(close(residual)));
    for (const ExprId e : dependent_) roots.push_back(rename(e));
    for (const ExprId e : outputs_) roots.push_back(rename(e));
    for (const ExprId e : event_values_) roots.push_back(rename(e));
    for (const ExprId e : event_conditions_) roots.push_back(rename(e));
    std::vector<std::pair<SymbolId, ExprId>> used;
    for (auto it = named_.rbegin(); it != named_.rend(); ++it) {
      const std::vector<SymbolId> inside = symbols_in(pool_, roots);
      if (!std::binary_search(inside.begin(), inside.end(), it->first)) continue;
      roots.push_back(it->second);
      used.push_back(*it);
    }
    named_.assign(used.rbegin(), used.rend());
  }

  /// Parts that occur more than once and would be long: named s1, s2, ... in order of dependence.
  void name_shared_parts() {
    const std::vector<ExprId> nodes = reachable(pool_, rates_);
    std::unordered_map<ExprId, std::size_t> uses, size;
    for (const ExprId e : nodes) {
      const ExprNode& node = pool_[e];
      size[e] = 1;
      if (node.op == Op::constant || node.op == Op::symbol) continue;
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) {
        ++uses[ExprId(children[k])];
        size[e] = std::min<std::size_t>(size[e] + size[ExprId(children[k])], 1'000'000);
      }
      if (size[e] > kLargestUnnamed) size[e] = 1;  // from here on it counts as one name
    }
    std::unordered_map<ExprId, ExprId> copy;
    std::size_t count = 0;
    for (const ExprId e : nodes) {
      const ExprId rebuilt = rebuild(e, copy);
      const ExprNode& node = pool_[e];
      const bool leaf = node.op == Op::constant || node.op == Op::symbol;
      if (!leaf && size[e] == 1 && uses[e] > 1) {
        const SymbolId symbol(names_.size());
        names_.push_back("s" + std::to_string(++count));
        named_.emplace_back(symbol, rebuilt);
        copy[e] = pool_.symbol(symbol);
      } else {
        copy[e] = rebuilt;
      }
    }
    for (ExprId& rate : rates_) rate = copy[rate];
  }

  [[nodiscard]] SymbolName name() const {
    return [this](SymbolId symbol) { return shown_[symbol.index()]; };
  }
  /// Names that would look alike where they are typeset (R1 and R_1, c.q and q_c) are written as they are.
  void tell_names_apart() {
    shown_ = names_;
    if (notation_ == Notation::text) return;
    std::vector<ExprId> roots = rates_;
    for (const auto& [symbol, expression] : named_) roots.push_back(expression);
    for (const std::vector<ExprId>* const some : {&dependent_, &outputs_, &event_values_, &event_conditions_})
      for (const ExprId e : *some) roots.push_back(rename(e));
    for (const Block& block : order_.blocks)
      if (!closed(block))
        for (const ExprId residual : block.residuals) roots.push_back(rename(close(residual)));
    std::vector<SymbolId> symbols = symbols_in(pool_, roots);
    for (const auto& [symbol, expression] : named_) symbols.push_back(symbol);
    for (const State& state : system_.states) symbols.push_back(state.symbol);
    for (const DependentStore& store : system_.dependent) symbols.push_back(store.symbol);
    std::sort(symbols.begin(), symbols.end());
    symbols.erase(std::unique(symbols.begin(), symbols.end()), symbols.end());
    std::map<std::pair<std::string, std::vector<std::string>>, std::vector<SymbolId>> alike;
    for (const SymbolId symbol : symbols) {
      const NameParts parts = name_parts(names_[symbol.index()]);
      alike[{parts.base, parts.indices}].push_back(symbol);
    }
    for (const auto& [parts, of] : alike)
      for (const SymbolId symbol : of)
        if (of.size() > 1) shown_[symbol.index()] = as_written(names_[symbol.index()]);
  }
  [[nodiscard]] std::vector<std::string> written(ExprId expression, const SymbolName& name) const {
    switch (notation_) {
      case Notation::text:
        return {to_text(display_->pool(), expression, name)};
      case Notation::latex:
        return {to_latex(display_->pool(), expression, name)};
      case Notation::mathml:
        return to_mathml(display_->pool(), expression, name);
    }
    return {};
  }
  std::string rate_name(SymbolId symbol) {
    const std::string& of = shown_[symbol.index()];
    const ExprId expression = display_->symbol(symbol);
    if (notation_ == Notation::text) return of + "'";
    return written(expression, [&](SymbolId) { return "der(" + of + ")"; }).front();
  }
  [[nodiscard]] std::string zero() const { return notation_ == Notation::mathml ? "<mn>0</mn>" : "0"; }
  [[nodiscard]] std::string upright(const std::string& text) const {
    if (notation_ == Notation::text) return short_name(text);
    return notation_ == Notation::latex ? latex_text(text) : xml_text_element("mtext", visible_line(text));
  }
  Line definition(SymbolId symbol, ExprId expression) {
    return line(written(display_->symbol(symbol), name()).front(), expression);
  }
  [[nodiscard]] Line line(std::string left, ExprId right) {
    try {
      return {std::move(left), written((*display_)(right), name())};
    } catch (const std::length_error&) {
      const std::string words = kTooLong;
      switch (notation_) {
        case Notation::text:
          return {std::move(left), {words}};
        case Notation::latex:
          return {std::move(left), {"\\text{" + words + "}"}};
        case Notation::mathml:
          return {std::move(left), {xml_element("mtext", words)}};
      }
      throw;
    }
  }

  /// In products, parameters stand before time, time before what varies.
  void prepare_display() {
    std::vector<SymbolId> symbols = system_.parameters;
    symbols.push_back(system_.time);
    display_.emplace(pool_, symbols);
  }

  Notation notation_;
  const EquationSystem& system_;
  const BlockOrder& order_;
  ExprPool pool_;
  std::optional<Tidier> display_;
  std::vector<std::string> names_, shown_;  ///< by symbol; as they are typeset
  std::unordered_map<SymbolId, ExprId> solved_;
  std::vector<std::pair<SymbolId, ExprId>> signals_, named_;
  std::unordered_map<ExprId, SymbolId> name_of_part_;
  std::vector<ExprId> rates_, dependent_, outputs_, event_values_, event_conditions_;
};

std::string count_text(std::size_t n, const std::string& one) {
  return std::to_string(n) + " " + one + (n == 1 ? "" : "s");
}

std::vector<EquationGroup> groups_of(const Model& model, const EquationSystem& system, const BlockOrder& order,
                                     Notation notation) {
  ReadableEquations equations(model, system, order, notation);
  // Symbols stand in products in the order in which they are first met: that of the outputs, which read most easily.
  std::vector<EquationGroup> groups;
  groups.push_back({"outputs", equations.outputs()});
  std::vector<EquationGroup> events = equations.events(model);
  std::move(events.rbegin(), events.rend(), std::back_inserter(groups));
  groups.push_back({"dependent stores", equations.dependent()});
  groups.push_back({"loops, to be solved for " + equations.loop_unknowns(), equations.loops()});
  groups.push_back({"where", equations.where()});
  groups.push_back({"state equations", equations.states()});
  std::reverse(groups.begin(), groups.end());
  std::erase_if(groups, [](const EquationGroup& group) { return group.lines.empty(); });
  return groups;
}

std::string group_text(const EquationGroup& group) {
  std::size_t width = 0;
  for (const auto& line : group.lines) width = std::max(width, line.left.size());
  std::string result = "\n" + group.title + "\n";
  for (const auto& line : group.lines)
    result +=
        visible_line("  " + line.left + std::string(width - line.left.size(), ' ') + " = " + line.right.front()) + "\n";
  return result;
}

std::string group_latex(const EquationGroup& group) {
  std::string result = "% " + group.title + "\n\\begin{align*}\n";
  for (std::size_t i = 0; i < group.lines.size(); ++i)
    result += "  " + group.lines[i].left + " &= " + group.lines[i].right.front() +
              (i + 1 < group.lines.size() ? " \\\\\n" : "\n");
  return result + "\\end{align*}\n";
}

}  // namespace

std::string equations_text(const Model& model, const EquationSystem& system, const BlockOrder& order) {
  std::string result = short_name(model.name) + ": " + count_text(system.states.size(), "state") + ", " +
                       count_text(order.blocks.size(), "algebraic loop") + "\n";
  if (const Mode mode = mode_of(model); !mode.empty()) result += "in the mode " + mode_text(model, mode) + "\n";
  for (const EquationGroup& group : groups_of(model, system, order, Notation::text)) result += group_text(group);
  return result;
}

std::string equations_latex(const Model& model, const EquationSystem& system, const BlockOrder& order) {
  std::string result = "% " + short_name(model.name) + "\n";
  if (const Mode mode = mode_of(model); !mode.empty()) result += "% in the mode " + mode_text(model, mode) + "\n";
  for (const EquationGroup& group : groups_of(model, system, order, Notation::latex)) result += group_latex(group);
  return result;
}

std::vector<EquationGroup> equations_mathml(const Model& model, const EquationSystem& system, const BlockOrder& order) {
  return groups_of(model, system, order, Notation::mathml);
}

std::string describe_loops(const Model& model, const EquationSystem& system, const BlockOrder& order) {
  if (order.blocks.empty()) return "no algebraic loops\n";
  std::string result = count_text(order.blocks.size(), "algebraic loop") + ":\n";
  for (const Block& block : order.blocks) {
    std::string through;
    for (const ElementId id : block.elements) {
      const Element& element = model.elements[id.index()];
      if (!is_junction(element.kind)) through += (through.empty() ? "" : ", ") + element.name;
    }
    std::string tears;
    for (const SymbolId tear : block.tears) tears += (tears.empty() ? "" : ", ") + system.symbols[tear.index()].name;
    result += "  " + std::string(block.linear ? "linear" : "nonlinear") + ", through " +
              (through.empty() ? "junctions and signals" : through) + "; solved for " + tears + "\n";
  }
  switch (order.system_class) {
    case SystemClass::explicit_ode:
      break;
    case SystemClass::local_blocks:
      result += "  solved inside the right-hand side\n";
      break;
    case SystemClass::implicit_dae:
      result += "  too large for that: left to IDA\n";
      break;
  }
  return result;
}

std::string show_equations(const Model& model, const EquationSystem& system) {
  const auto name = [&](SymbolId symbol) { return system.symbols[symbol.index()].name; };
  std::string result;
  const auto line = [&result](const std::string& raw) { result += visible_line(raw) + "\n"; };
  for (const State& state : system.states)
    line("state " + state.name + "' = " + readable_text(system.pool, state.rate, name));
  for (const DependentStore& store : system.dependent) result += "dependent " + store.name + "\n";
  for (const Equation& equation : system.equations) {
    const std::string text = readable_text(system.pool, equation.expression, name);
    std::string written = equation.implicit ? "0 = " : name(equation.unknown) + " = ";
    written += text;
    if (equation.implicit) written += "  for " + name(equation.unknown);
    if (equation.element.valid()) written += "  (" + model.elements[equation.element.index()].name + ")";
    line(written);
  }
  for (const OutputEquation& output : system.outputs)
    line("output " + output.name + " = " + readable_text(system.pool, output.value, name));
  return result;
}

std::string show_order(const Model& model, const EquationSystem& system, const BlockOrder& order) {
  const auto name = [&](SymbolId symbol) { return system.symbols[symbol.index()].name; };
  std::string result = describe_loops(model, system, order);
  const auto line = [&result](const std::string& raw) { result += visible_line(raw) + "\n"; };
  for (const Block& block : order.blocks) {
    result += "loop of " + count_text(block.members.size(), "unknown") + ":";
    for (const SymbolId member : block.members) result += " " + name(member);
    result += "\n";
    for (const ExprId residual : block.residuals) line("  0 = " + readable_text(order.pool, residual, name));
  }
  for (std::size_t i = 0; i < order.rates.size(); ++i)
    line("rate of " + system.states[i].name + " = " + readable_text(order.pool, order.rates[i], name));
  for (std::size_t i = 0; i < order.outputs.size(); ++i)
    line("output " + system.outputs[i].name + " = " + readable_text(order.pool, order.outputs[i], name));
  return result;
}

namespace {

std::string routine_text(const std::string& title, const Routine& routine) {
  std::string result = title + ":\n";
  for (std::size_t i = 0; i < routine.code.size(); ++i) {
    for (const Instruction& instruction : routine.code[i]) {
      result += "  s" + std::to_string(instruction.out) + " = " + std::string(name_of(instruction.op)) + " s" +
                std::to_string(instruction.a);
      if (arity(instruction.op) > 1) result += " s" + std::to_string(instruction.b);
      if (arity(instruction.op) > 2) result += " s" + std::to_string(instruction.c);
      result += "\n";
    }
    if (i < routine.solves.size()) result += "  solve loop " + std::to_string(routine.solves[i] + 1) + "\n";
  }
  if (routine.results.empty()) return result;
  result += "  results:";
  for (const std::uint32_t slot : routine.results) result += slot == kNoSlot ? " -" : " s" + std::to_string(slot);
  return result + "\n";
}

}  // namespace

std::string show_program(const Program& program) {
  std::string result = count_text(program.slots, "slot") + ": s" + std::to_string(program.time_slot) + " time";
  const auto range = [&](const char* what, std::uint32_t first, std::size_t count) {
    if (count > 0) result += ", s" + std::to_string(first) + "..s" + std::to_string(first + count - 1) + " " + what;
  };
  range("states", program.first_state, program.state_names.size());
  range("loop unknowns", program.first_tear, program.tear_names.size());
  range("modes", program.first_mode, program.relations.size());
  range("parameters", program.first_parameter, program.parameters.size());
  result += "\n";
  for (std::size_t i = 0; i < program.slots; ++i) {
    const ExprNode& node = program.pool[program.slot_expression[i]];
    if (node.op != Op::constant) continue;
    char number[40];
    std::snprintf(number, sizeof number, "%.17g", node.constant);
    result += "constant s" + std::to_string(i) + " = " + number + "\n";
  }
  for (std::size_t i = 0; i < program.relations.size(); ++i)
    result += "mode s" + std::to_string(program.first_mode + i) + ": " + visible_line(program.relations[i].text) +
              (program.relations[i].time_only ? "  (scheduled)\n" : "  (root function)\n");
  result += routine_text("once", program.once) + routine_text("rates", program.rates);
  for (std::size_t b = 0; b < program.blocks.size(); ++b)
    result += routine_text("loop " + std::to_string(b + 1) + " residuals", program.blocks[b].residual) +
              routine_text("loop " + std::to_string(b + 1) + " partials", program.blocks[b].jacobian);
  if (!program.guards.results.empty()) result += routine_text("guards", program.guards);
  result += routine_text("outputs", program.outputs) + routine_text("jacobian", program.plan.routine);
  return result;
}

}  // namespace bgsim
