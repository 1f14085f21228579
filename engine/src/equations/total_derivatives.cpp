#include "equations/total_derivatives.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "bgsim/modes.hpp"
#include "equations/borders.hpp"
#include "equations/unknowns.hpp"
#include "expression/graph.hpp"

namespace bgsim {
namespace {

/// Higher derivatives than this in a row come from a structure of higher index, not from a model of finite depth.
constexpr std::uint32_t kMostDerivatives = 8;

Place line_of(const Model& model, const Equation& equation) {
  if (!equation.element.valid()) return equation.place;
  const Element& element = model.elements[equation.element.index()];
  return equation.place.begin == element.place.begin ? line_of(element) : equation.place;
}

}  // namespace

bool TotalDerivatives::varies(SymbolId symbol) const {
  return system_.symbols[symbol.index()].kind != SystemSymbol::Kind::parameter;
}

ExprId TotalDerivatives::of(ExprId argument, const Wish& wish) {
  ExprPool& pool = system_.pool;
  const std::vector<SymbolId> symbols = symbols_in(pool, std::array{argument});
  if (std::none_of(symbols.begin(), symbols.end(), [this](SymbolId s) { return varies(s); })) return pool.constant(0.0);
  if (argument == pool.symbol(system_.time)) return pool.constant(1.0);
  const auto [entry, is_new] = derivatives_.try_emplace(argument, SymbolId{});
  if (is_new) {
    entry->second = add_unknown(system_, name_of(argument));
    pending_.push_back({argument, entry->second, wish});
  }
  return pool.symbol(entry->second);
}

std::string TotalDerivatives::name_of(ExprId argument) const {
  if (system_.pool.is_symbol(argument))
    return "der(" + system_.symbols[system_.pool.symbol_of(argument).index()].name + ")";
  return "der#" + std::to_string(pending_.size() + 1);
}

void TotalDerivatives::write_equations() {
  for (std::size_t next = 0; next < pending_.size(); ++next) {
    const Pending pending = pending_[next];  // a copy: more are added
    write_equation(pending);
  }
}

void TotalDerivatives::write_equation(const Pending& pending) {
  if (system_.pool.is_symbol(pending.argument)) return differentiate_symbol(pending);
  const Place place = pending.wish.place;
  define(system_, pending.unknown, total(pending.argument, place, pending), {}, place);
}

void TotalDerivatives::differentiate_symbol(const Pending& pending) {
  const SymbolId of_symbol = system_.pool.symbol_of(pending.argument), unknown = pending.unknown;
  const SystemSymbol symbol = system_.symbols[of_symbol.index()];
  if (symbol.kind == SystemSymbol::Kind::state) {
    const State& state = system_.states[symbol.index];
    look_at_sets(state, pending);
    return define(system_, unknown, state.rate, state.element, place_of(model_, state));
  }
  const Equation equation = system_.equations[symbol.index];
  if (!equation.expression.valid()) return;  // its own problem has been reported
  const auto before = depth_.find(of_symbol);
  const std::uint32_t level = (before == depth_.end() ? 0 : before->second) + 1;
  depth_[unknown] = level;
  if (level > kMostDerivatives) return report_index(equation, symbol.name);
  const Place line = line_of(model_, equation);
  look_at_source(equation, line, pending);
  if (!equation.implicit) {
    define(system_, unknown, total(equation.expression, line, pending), equation.element, equation.place);
    // A loop through the law is solved in its form, and one through its derivative in the derivative of that: at
    // e = 0 the derivative of sqrt(abs(e)) is 0/0, that of e - f abs(f) is not.
    if (equation.loop_form.valid()) {
      const ExprId form = chain_rule(equation.loop_form, pending);
      system_.equations[system_.symbols[unknown.index()].index].loop_form = form;
    }
    return;
  }
  // 0 = F(u, ...) gives F_u u' + sum F_o o' = 0
  ExprPool& pool = system_.pool;
  const auto is_variable = [this](SymbolId s) { return varies(s); };
  if (jumps_with(pool, equation.expression, is_variable)) look_at_borders(pending.argument, line, pending);
  ExprId own = pool.constant(0.0), others = pool.constant(0.0);
  for (const auto& [s, partial] : gradient(pool, equation.expression, is_variable)) {
    if (s == of_symbol)
      own = partial;
    else
      others = pool.add(others, pool.mul(partial, of(pool.symbol(s), pending.wish)));
  }
  define(system_, unknown, pool.neg(pool.div(others, own)), equation.element, equation.place);
}

/// @param place  the user's line that gives the expression.
ExprId TotalDerivatives::total(ExprId expression, Place place, const Pending& pending) {
  ExprPool& pool = system_.pool;
  const auto is_variable = [this](SymbolId s) { return varies(s); };
  if (jumps_with(pool, expression, is_variable) || follows_delay(expression))
    look_at_borders(expression, place, pending);
  return chain_rule(expression, pending);
}

ExprId TotalDerivatives::chain_rule(ExprId expression, const Pending& pending) {
  ExprPool& pool = system_.pool;
  ExprId sum = pool.constant(0.0);
  for (const auto& [symbol, partial] : gradient(pool, expression, [this](SymbolId s) { return varies(s); }))
    sum = pool.add(sum, pool.mul(partial, of(pool.symbol(symbol), pending.wish)));
  return sum;
}

void TotalDerivatives::report_index(const Equation& equation, const std::string& name) {
  if (!reported_) problems_.push_back(index_fault(name, kMostDerivatives, equation.place));
  reported_ = true;
}

/// Conditions do not make a jump: it is one if both sides differ where they meet. What differs wherever it was looked
/// at is refused; the run looks at the others where it comes by.
void TotalDerivatives::look_at_borders(ExprId expression, Place place, const Pending& pending) {
  if (in_pieces_) return;
  const auto name = [this](SymbolId s) { return system_.symbols[s.index()].name; };
  Diagnostic fault = jump_fault(readable_text(system_.pool, expression, name), place, pending.wish);
  if (certainly_jumps(model_, system_, expression)) {
    const bool known = std::any_of(problems_.begin(), problems_.end(), [&](const Diagnostic& problem) {
      return problem.code == fault.code && problem.place && fault.place &&
             problem.place->document == fault.place->document && problem.place->begin == fault.place->begin;
    });
    if (!known) problems_.push_back(std::move(fault));
    reported_ = true;
    return;
  }
  system_.equations[system_.symbols[pending.unknown.index()].index].whole = expression;
  system_.continuous.push_back({pending.unknown, expression, std::move(fault)});
}

/// What a dependent store holds follows a signal that events set: it would jump with it, by an impulse. Of a signal
/// with memory, whose rate is 0, the impulses are all that its derivative is.
void TotalDerivatives::look_at_sets(const State& state, const Pending& pending) {
  const bool memory = system_.pool.is_constant(state.rate, 0.0);
  if (in_pieces_ || !state.signal.valid() || (pending.wish.store.empty() && !memory)) return;
  const auto sets = [&](const ModelEvent& event) {
    return std::any_of(event.sets.begin(), event.sets.end(),
                       [&](const ModelEvent::Set& set) { return set.signal == state.signal; });
  };
  if (std::none_of(model_.events.begin(), model_.events.end(), sets)) return;
  system_.continuous.push_back({pending.unknown, system_.pool.symbol(state.symbol),
                                jump_fault(state.name, place_of(model_, state), pending.wish), true});
}

/// The same where a source follows a store that an event sets. (A dependent store that bonds tie to that store is set
/// with it.)
void TotalDerivatives::look_at_source(const Equation& equation, Place line, const Pending& pending) {
  if (in_pieces_ || pending.wish.store.empty() || model_.events.empty() || !equation.element.valid() ||
      !is_source(model_.elements[equation.element.index()].kind))
    return;
  const auto name = [this](SymbolId s) { return system_.symbols[s.index()].name; };
  system_.continuous.push_back({pending.unknown, equation.expression,
                                jump_fault(readable_text(system_.pool, equation.expression, name), line, pending.wish),
                                true});
}

/// A delayed signal has the jumps of what is delayed.
bool TotalDerivatives::follows_delay(ExprId expression) const {
  const std::vector<ExprId> nodes = reachable(system_.pool, {&expression, 1});
  return std::any_of(nodes.begin(), nodes.end(), [this](ExprId e) {
    const ExprNode& node = system_.pool[e];
    return node.op == Op::table && system_.pool.table(TableId(node.b)).delayed;
  });
}

}  // namespace bgsim
