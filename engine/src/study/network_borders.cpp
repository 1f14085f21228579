#include "study/network_borders.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "expression/graph.hpp"
#include "expression/partial.hpp"
#include "model/add_symbols.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {
namespace {

/// A guard, and the side of it on which a sign, step or comparison is as written: -1 where that has the guard the other
/// way round.
struct Guard {
  ExprId at;
  int way = 1;
};

bool is_border(Op op) { return op == Op::sign || op == Op::step || is_comparison(op); }

Guard guard_of(ExprPool& pool, const ExprNode& node) {
  const ExprId at = is_comparison(node.op) ? pool.sub(ExprId(node.a), ExprId(node.b)) : ExprId(node.a);
  if (pool[at].op == Op::neg) return {ExprId(pool[at].a), -1};
  const ExprId other = is_comparison(node.op) ? pool.sub(ExprId(node.b), ExprId(node.a)) : pool.neg(at);
  return other < at ? Guard{other, -1} : Guard{at, 1};
}

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

/// Whether both sides are the same at the border, as far as that can be seen: a kink holds nothing.
bool meet(ExprPool& pool, ExprId below, ExprId above, ExprId guard) {
  if (below == above) return true;
  if (!pool.is_symbol(guard)) return false;
  const std::unordered_map<SymbolId, ExprId> at_border{{pool.symbol_of(guard), pool.constant(0.0)}};
  return substitute(pool, below, at_border) == substitute(pool, above, at_border);
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

/// The law where the guard has this sign.
ExprId on_side(ExprPool& pool, ExprId root, int side) {
  IdMap<ExprId> images;
  arguments_first(
      pool, root, [&images](ExprId e) { return images.find(e) != nullptr; },
      [&](ExprId e) {
        const ExprNode node = pool[e];  // a copy: the pool grows
        if (is_border(node.op)) {
          const double value = guard_of(pool, node).way * side;
          images.insert(e, pool.constant(apply(node.op, value, 0.0)));
        } else {
          images.insert(e, rebuilt(pool, node, [&images](ExprId a) { return *images.find(a); }));
        }
      });
  return *images.find(root);
}

}  // namespace

std::vector<TakenBorder> take_borders(Model& model) {
  std::vector<TakenBorder> borders;
  ExprPool& pool = model.pool;
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    Element& element = model.elements[i];
    if (!is_resistor(element.kind) || element.laws.empty()) continue;
    std::vector<ExprId> roots;
    for (const Law& law : element.laws) roots.push_back(law.right);
    const std::optional<ExprId> guard = only_guard(model, reachable(pool, roots));
    if (!guard) continue;
    std::vector<ExprId> below, above;
    bool has_slopes = true, jumps = false, as_below = true, as_above = true;
    for (const ExprId root : roots) {
      below.push_back(on_side(pool, root, -1));
      above.push_back(on_side(pool, root, 1));
      const ExprId at = on_side(pool, root, 0);
      as_below = as_below && at == below.back();
      as_above = as_above && at == above.back();
      has_slopes = has_slopes && !may_have_no_slope(pool, below.back()) && !may_have_no_slope(pool, above.back());
      jumps = jumps || !meet(pool, below.back(), above.back(), *guard);
    }
    if (!has_slopes || !jumps) continue;
    TakenBorder taken;
    taken.guard = *guard;
    taken.border = {ElementId(static_cast<std::uint32_t>(i)), element.name, as_below ? 0.0 : as_above ? 1.0 : 0.5};
    const SignalId place = add_signal(model, "(place of " + taken.border.name + ")", Signal::Kind::integral);
    const ExprId symbol = pool.symbol(model.signals[place.index()].symbol);
    Element& changed = model.elements[i];
    for (std::size_t k = 0; k < below.size(); ++k)
      changed.laws[k].right = pool.add(below[k], pool.mul(symbol, pool.sub(above[k], below[k])));
    changed.modulated = true;
    borders.push_back(std::move(taken));
  }
  return borders;
}

}  // namespace bgsim
