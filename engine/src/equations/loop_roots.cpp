#include "equations/loop_roots.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/strong_parts.hpp"
#include "equations/loops.hpp"
#include "equations/unknowns.hpp"
#include "expression/graph.hpp"
#include "expression/power_sum.hpp"
#include "expression/sides.hpp"
#include "expression/signed_power.hpp"

namespace bgsim {
namespace {

using Images = std::unordered_map<ExprId, ExprId>;

/// A root or another power. One that is no number may be a root.
bool is_power(const ExprPool& pool, const ExprNode& node) {
  if (node.op == Op::sqrt || node.op == Op::cbrt) return true;
  return node.op == Op::pow && (!pool.is_constant(ExprId(node.b)) || pool[ExprId(node.b)].constant > 0.0);
}

/// What an expression is of the loops' unknowns.
enum class Of : std::uint8_t { none, affine, other };

Of combined(const ExprNode& node, const std::unordered_map<ExprId, Of>& kinds) {
  Of a = Of::none, b = Of::none;
  if (arity(node.op) > 0) a = kinds.at(ExprId(node.a));
  if (arity(node.op) > 1) b = kinds.at(ExprId(node.b));
  switch (node.op) {
    case Op::neg:
      return a;
    case Op::add:
    case Op::sub:
      return std::max(a, b);
    case Op::mul:
      return a == Of::none || b == Of::none ? std::max(a, b) : Of::other;
    case Op::div:
      return b == Of::none ? a : Of::other;
    case Op::select:
      return std::max({a, b, kinds.at(ExprId(node.c))}) == Of::none ? Of::none : Of::other;
    default:
      return std::max(a, b) == Of::none ? Of::none : Of::other;
  }
}

/// x where a root takes c |x|, c max(x, 0) and the like.
ExprId without_sign_and_factor(const ExprPool& pool, ExprId argument, const std::unordered_map<ExprId, Of>& kinds) {
  for (;;) {
    const ExprNode& node = pool[argument];
    const ExprId a(node.a), b(node.b);
    switch (node.op) {
      case Op::abs:
      case Op::neg:
        argument = a;
        continue;
      case Op::max:
      case Op::min:
        if (!pool.is_constant(a, 0.0) && !pool.is_constant(b, 0.0)) return argument;
        argument = pool.is_constant(a) ? b : a;
        continue;
      case Op::mul:
        if (kinds.at(a) != Of::none && kinds.at(b) != Of::none) return argument;
        argument = kinds.at(a) == Of::none ? b : a;
        continue;
      case Op::div:
        if (kinds.at(b) != Of::none) return argument;
        argument = a;
        continue;
      default:
        return argument;
    }
  }
}

/// What roots and other powers are taken of, as far as it is a sum of the loop's unknowns.
std::set<ExprId> arguments_of_powers(const ExprPool& pool, ExprId expression, const std::vector<bool>& in_loop) {
  std::unordered_map<ExprId, Of> kinds;
  std::set<ExprId> arguments;
  for (const ExprId e : reachable(pool, {&expression, 1})) {
    const ExprNode& node = pool[e];
    kinds[e] = node.op != Op::symbol                ? combined(node, kinds)
               : in_loop[pool.symbol_of(e).index()] ? Of::affine
                                                    : Of::none;
    if (!is_power(pool, node) || kinds.at(ExprId(node.a)) == Of::none) continue;
    const ExprId of = without_sign_and_factor(pool, ExprId(node.a), kinds);
    if (kinds.at(of) == Of::affine) arguments.insert(of);
  }
  return arguments;
}

/// sign(x) |x|^degree by w.
ExprId power_by_root(ExprPool& pool, const Sides& sides, const Degree& degree, ExprId w) {
  const ExprId power = expression_of(pool, degree);
  if (!sides.is_root.valid()) return odd_power(pool, w, pool.div(power, sides.power));
  const ExprId more = pool.sub(pool.div(power, sides.power), pool.constant(1.0));
  const ExprId below_1 = power == sides.power ? w : pool.mul(w, pool.pow(pool.make(Op::abs, w), more));
  return pool.select(sides.is_root, below_1, odd_power(pool, w, power));
}

/// One side of a law by w, where x = sign(w) |w|^(1/power): a power of x is one of w, continued beyond 0 as an odd one.
ExprId with_root(ExprPool& pool, const Sides& sides, std::size_t side, SymbolId w) {
  Images images;
  const auto power_of_w = [&](const Degree& degree) { return power_by_root(pool, sides, degree, pool.symbol(w)); };
  const auto is_power_of_w = [&](const PowerTerm& term) {
    if (!term.is_power() || !term.power.is_number()) return term.is_power();
    const bool at_least = !pool.is_constant(sides.power) || term.power.number >= pool[sides.power].constant;
    return at_least && term.power.number > 0.0 && term.power.number != std::floor(term.power.number);
  };
  for (const ExprId e : reachable(pool, {&sides.expressions[side], 1})) {
    const ExprNode node = pool[e];
    const PowerTerm& term = sides.terms[side].at(e);
    if (node.op == Op::symbol && pool.symbol_of(e) == sides.x) {
      images[e] = power_of_w({1.0, 0.0, {}});
    } else if (is_power_of_w(term)) {
      const ExprId image = pool.mul(term.factor, power_of_w(term.power));
      images[e] = (side == 0) == (term.sign > 0.0) ? image : pool.neg(image);
    } else {
      images[e] = rebuilt(pool, node, [&](ExprId a) { return images.at(a); });
    }
  }
  return images.at(sides.expressions[side]);
}

/// @p law by w. None where it jumps at x = 0, or is another one there.
ExprId by_root(ExprPool& pool, const Sides& sides, ExprId law, SymbolId w) {
  const ExprId above = with_root(pool, sides, 0, w), below = with_root(pool, sides, 1, w);
  const ExprId zero = pool.constant(0.0);
  for (const ExprId side : {above, below})
    if (substitute(pool, side, {{w, zero}}) != sides.at_zero) return {};
  ExprId by_w = above == below ? above : pool.select(pool.make(Op::ge, pool.symbol(w), zero), above, below);
  for (const ExprId exponent : sides.above_zero) by_w = pool.select(pool.make(Op::gt, exponent, zero), by_w, law);
  return by_w;
}

/// Whether a power is taken of what depends on an unknown.
bool has_power(const EquationSystem& system) {
  std::vector<bool> depends(system.pool.size(), false);
  for (std::size_t i = 0; i < depends.size(); ++i) {  // arguments come before what they are in
    const ExprNode& node = system.pool[ExprId(i)];
    if (node.op == Op::symbol)
      depends[i] = system.symbols[node.a].kind == SystemSymbol::Kind::unknown;
    else
      for_each_argument(node, [&](ExprId a) { depends[i] = depends[i] || depends[a.index()]; });
    if (depends[i] && is_power(system.pool, node)) return true;
  }
  return false;
}

/// What the loops are solved by: the form of a law for that, or the law.
ExprId solved_form(const Equation& equation) {
  return equation.loop_form.valid() ? equation.loop_form : equation.expression;
}

class LoopRoots {
 public:
  explicit LoopRoots(EquationSystem& system) : system_(system), looked_at_(system.symbols.size(), false) {}

  void name() {
    for (std::vector<std::uint32_t> loop : loops_of()) {
      for (const std::uint32_t i : loop) look_at(i, true);
      for (std::size_t at = 0; at < loop.size(); ++at) {  // the equations of new unknowns come to the loop
        const auto before = static_cast<std::uint32_t>(system_.equations.size());
        name_in(loop[at]);
        for (std::uint32_t i = before; i < system_.equations.size(); ++i) loop.push_back(i);
      }
      for (const std::uint32_t i : loop) look_at(i, false);
    }
  }

 private:
  void look_at(std::uint32_t equation, bool yes) { looked_at_[system_.equations[equation].unknown.index()] = yes; }

  [[nodiscard]] std::vector<std::vector<std::uint32_t>> loops_of() const {
    std::vector<std::vector<std::uint32_t>> depends_on;
    for (const Equation& equation : system_.equations)
      depends_on.push_back(equation.expression.valid() ? equations_in(system_, equation.expression)
                                                       : std::vector<std::uint32_t>());
    const StrongParts parts = strong_parts(depends_on);
    std::vector<std::vector<std::uint32_t>> loops(parts.count);
    for (std::uint32_t i = 0; i < depends_on.size(); ++i) loops[parts.part_of[i]].push_back(i);
    std::erase_if(loops, [&](const std::vector<std::uint32_t>& loop) {
      const std::vector<std::uint32_t>& own = depends_on[loop.front()];
      return loop.size() == 1 && std::find(own.begin(), own.end(), loop.front()) == own.end();
    });
    return loops;
  }

  void name_in(std::uint32_t index) {
    for (const ExprId x : arguments_of_powers(system_.pool, solved_form(system_.equations[index]), looked_at_)) {
      const SymbolId w(system_.symbols.size());  // a new one
      Sides sides = sides_of(system_.pool, solved_form(system_.equations[index]), x, w);
      if (write_as_sum(x, index, sides)) sides = sides_of(system_.pool, solved_form(system_.equations[index]), x, w);
      name_root_of(x, index, sides);
    }
  }

  /// A law that is a sum of powers of @p x on both sides of 0, as one that goes on beyond 0. False if it stays.
  bool write_as_sum(ExprId x, std::uint32_t index, const Sides& sides) {
    const ExprId sum = odd_power_sum(system_.pool, solved_form(system_.equations[index]), sides);
    if (!sum.valid()) return false;
    Equation& equation = system_.equations[index];
    const Origin origin = origin_of(system_, equation);
    (equation.loop_form.valid() ? equation.loop_form : equation.expression) =
        substitute(system_.pool, sum, {{sides.x, x}});
    system_.origins.resize(system_.pool.size(), origin);
    return true;
  }

  /// The root that the equation at @p index takes of @p x.
  void name_root_of(ExprId x, std::uint32_t index, const Sides& sides) {
    SymbolId w = sides.x;  // unless the loop has it
    if (!sides.power.valid()) return;
    const auto known = names_.find({x, sides.power});
    if (known != names_.end()) w = known->second;
    const ExprId law = by_root(system_.pool, sides, solved_form(system_.equations[index]), w);
    if (!law.valid()) return;
    Equation& equation = system_.equations[index];
    const Origin origin = origin_of(system_, equation);
    if (equation.loop_form.valid()) equation.implicit = true;
    equation.loop_form = {};
    equation.expression = law;
    if (known == names_.end()) {
      names_.emplace(std::pair(x, sides.power), w);
      add_root(x, sides, equation);
    }
    system_.origins.resize(system_.pool.size(), origin);
  }

  /// w for a root of @p x. Where x is an unknown itself, it is given by w, and w has its equation: as a difference of
  /// large terms x would be known to their rounding only, which a power of w is not.
  void add_root(ExprId x, const Sides& sides, const Equation& law) {
    ExprPool& pool = system_.pool;
    const ElementId element = law.element;
    const Place place = law.place;
    const SymbolId w = add_unknown(system_, name_of(pool.is_symbol(x) ? pool.symbol_of(x) : law.unknown));
    // Of a power that is no number w has no root: that is what it is for.
    looked_at_.push_back(pool.is_constant(sides.power));
    const ExprId by_w = power_by_root(pool, sides, {1.0, 0.0, {}}, pool.symbol(w));
    const bool is_unknown = pool.is_symbol(x);
    const Equation solved =
        is_unknown ? equation_of(pool.symbol_of(x)) : Equation{{}, x, false, element, place, {}, {}};
    if (solved.implicit || solved.loop_form.valid()) {
      const ExprId form = substitute(pool, solved_form(solved), {{solved.unknown, by_w}});
      define(system_, w, form, solved.element, solved.place, true);
    } else {
      const ExprId root = odd_root(pool, solved.expression, pool.div(pool.constant(1.0), sides.power));
      const ExprId given = sides.is_root.valid() ? pool.select(sides.is_root, root, solved.expression) : root;
      define(system_, w, given, solved.element, solved.place);
      equation_of(w).loop_form = pool.sub(solved.expression, by_w);
    }
    if (is_unknown) {
      Equation& given = equation_of(solved.unknown);
      given.expression = by_w;
      given.implicit = false;
      given.loop_form = {};
    }
  }

  /// "r.e.root"; the next one "r.e.root2".
  std::string name_of(SymbolId of) {
    const std::string& name = system_.symbols[of.index()].name;
    const std::size_t number = ++counts_[of];
    return name + ".root" + (number > 1 ? std::to_string(number) : "");
  }

  Equation& equation_of(SymbolId unknown) { return system_.equations[system_.symbols[unknown.index()].index]; }

  EquationSystem& system_;
  std::map<SymbolId, std::size_t> counts_;               ///< of roots, by what they are named after
  std::vector<bool> looked_at_;                          ///< by symbol: unknowns of which roots count
  std::map<std::pair<ExprId, ExprId>, SymbolId> names_;  ///< by what the root is of, and its power
};

}  // namespace

void name_roots_in_loops(EquationSystem& system) {
  if (has_power(system)) LoopRoots(system).name();
}

}  // namespace bgsim
