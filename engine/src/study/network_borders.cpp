#include "study/network_borders.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "expression/border.hpp"
#include "expression/graph.hpp"
#include "expression/partial.hpp"
#include "model/add_symbols.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {
namespace {

/// Whether it may have no value where its condition would not ask for it, or no slope at its border.
bool may_have_no_slope(const ExprPool& pool, ExprId root) {
  const std::vector<ExprId> nodes = reachable(pool, {&root, 1});
  return std::any_of(nodes.begin(), nodes.end(), [&pool](ExprId e) {
    const ExprNode& node = pool[e];
    if (node.op == Op::sqrt || node.op == Op::cbrt || node.op == Op::ssqrt) return true;
    if (node.op == Op::pow) {
      const ExprId by(node.b);
      return !pool.is_constant(by) || pool[by].constant != std::floor(pool[by].constant);
    }
    return node.op != Op::div && node.op != Op::mod && is_partial(pool, e);
  });
}

/// The guard of all signs, steps and comparisons; none where there are several, or none that varies.
std::optional<ExprId> only_guard(Model& model, const std::vector<ExprId>& nodes) {
  std::optional<ExprId> found;
  for (const ExprId e : nodes) {
    const ExprNode node = model.pool[e];  // a copy: the pool grows
    if (!is_border(node.op)) continue;
    const ExprId at = guard_of(model.pool, node).at;
    if (found && *found != at) return std::nullopt;
    found = at;
  }
  if (!found) return std::nullopt;
  const std::vector<SymbolId> symbols = symbols_in(model.pool, {&*found, 1});
  const auto varies = [&model](SymbolId symbol) {
    using Kind = ModelSymbol::Kind;
    const Kind kind = model.symbols[symbol.index()].kind;
    return kind == Kind::port_variable || kind == Kind::bond_variable || kind == Kind::signal;
  };
  return std::any_of(symbols.begin(), symbols.end(), varies) ? found : std::nullopt;
}

struct LawSides {
  ExprId guard;
  std::vector<ExprId> below, above;  ///< by law
};

/// Of the laws of a resistor that may hold its border; else none.
std::optional<LawSides> sides_of(Model& model, const Element& element) {
  if (!is_resistor(element.kind) || element.laws.empty()) return std::nullopt;
  ExprPool& pool = model.pool;
  std::vector<ExprId> roots;
  for (const Law& law : element.laws) roots.push_back(law.right);
  const std::optional<ExprId> guard = only_guard(model, reachable(pool, roots));
  if (!guard) return std::nullopt;
  LawSides sides{*guard, {}, {}};
  bool has_slopes = true, jumps = false;
  for (const ExprId root : roots) {
    const ExprId below = on_side(pool, root, *guard, -1), above = on_side(pool, root, *guard, 1);
    has_slopes = has_slopes && !may_have_no_slope(pool, below) && !may_have_no_slope(pool, above);
    jumps = jumps || !meet(pool, below, above, *guard);
    sides.below.push_back(below);
    sides.above.push_back(above);
  }
  return has_slopes && jumps ? std::optional(std::move(sides)) : std::nullopt;
}

}  // namespace

std::vector<TakenBorder> take_borders(Model& model) {
  std::vector<TakenBorder> borders;
  ExprPool& pool = model.pool;
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    const std::optional<LawSides> sides = sides_of(model, model.elements[i]);
    if (!sides) continue;
    Element& element = model.elements[i];
    const SignalId place = add_signal(model, "(place of " + element.name + ")", Signal::Kind::integral);
    const ExprId symbol = pool.symbol(model.signals[place.index()].symbol);
    for (std::size_t k = 0; k < element.laws.size(); ++k)
      element.laws[k].right = pool.add(sides->below[k], pool.mul(symbol, pool.sub(sides->above[k], sides->below[k])));
    element.modulated = true;
    borders.push_back({{ElementId(static_cast<std::uint32_t>(i)), element.name}, sides->guard});
  }
  return borders;
}

void add_own_borders(Model& model) {
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    if (!sides_of(model, model.elements[i])) continue;
    const std::string name = model.elements[i].name;
    model.elements[i].own_border = add_parameter(model, "(border of " + name + ")");
    model.elements[i].share = add_parameter(model, "(share of " + name + ")");
  }
}

void use_own_borders(Model& model) {
  ExprPool& pool = model.pool;
  const ExprId zero = pool.constant(0.0), one = pool.constant(1.0), half = pool.constant(0.5);
  const auto symbol_of = [&](ParameterId parameter) { return pool.symbol(model.parameters[parameter.index()].symbol); };
  for (Element& element : model.elements) {
    if (!element.own_border.valid()) continue;
    const LawSides sides = *sides_of(model, element);
    const ExprId guard = pool.add(sides.guard, symbol_of(element.own_border)), share = symbol_of(element.share);
    for (std::size_t k = 0; k < element.laws.size(); ++k) {
      const ExprId below = sides.below[k], above = sides.above[k];
      if (below == pool.neg(above)) {
        element.laws[k].right = pool.mul(above, pool.add(pool.make(Op::sign, guard), share));
        continue;
      }
      // Neither side is evaluated on the other one, where it may be much larger, or have no value.
      const ExprId place = pool.mul(half, pool.add(one, share));
      const ExprId at_border = pool.add(below, pool.mul(place, pool.sub(above, below)));
      element.laws[k].right = pool.select(pool.make(Op::gt, guard, zero), above,
                                          pool.select(pool.make(Op::lt, guard, zero), below, at_border));
    }
  }
}

}  // namespace bgsim
