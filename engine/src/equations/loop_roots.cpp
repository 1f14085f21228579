#include "equations/loop_roots.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "equations/loops.hpp"
#include "equations/unknowns.hpp"
#include "expression/graph.hpp"
#include "expression/signed_power.hpp"

namespace bgsim {
namespace {

using Images = std::unordered_map<ExprId, ExprId>;

bool is_root(const ExprPool& pool, const ExprNode& node) {
  if (node.op == Op::sqrt || node.op == Op::cbrt) return true;
  if (node.op != Op::pow || !pool.is_constant(ExprId(node.b))) return false;
  const double power = pool[ExprId(node.b)].constant;
  return power > 0.0 && power < 1.0;
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

/// What roots are taken of, as far as it is a sum of the loop's unknowns.
std::set<ExprId> arguments_of_roots(const ExprPool& pool, ExprId expression, const std::vector<bool>& in_loop) {
  std::unordered_map<ExprId, Of> kinds;
  std::set<ExprId> arguments;
  for (const ExprId e : reachable(pool, {&expression, 1})) {
    const ExprNode& node = pool[e];
    kinds[e] = node.op != Op::symbol                ? combined(node, kinds)
               : in_loop[pool.symbol_of(e).index()] ? Of::affine
                                                    : Of::none;
    if (!is_root(pool, node) || kinds.at(ExprId(node.a)) == Of::none) continue;
    const ExprId of = without_sign_and_factor(pool, ExprId(node.a), kinds);
    if (kinds.at(of) == Of::affine) arguments.insert(of);
  }
  return arguments;
}

/// 1 or -1 where @p e is x or -x, or one of these times a number above 0; else 0.
int multiple_of(ExprPool& pool, ExprId e, ExprId x) {
  if (e == x) return 1;
  const ExprNode node = pool[e];
  if (node.op == Op::mul && pool.is_constant(ExprId(node.a)))
    return multiple_of(pool, ExprId(node.b), x) * (pool[ExprId(node.a)].constant > 0.0 ? 1 : -1);
  if (node.op == Op::div && pool.is_constant(ExprId(node.b)))
    return multiple_of(pool, ExprId(node.a), x) * (pool[ExprId(node.b)].constant > 0.0 ? 1 : -1);
  if (node.op == Op::neg) return -multiple_of(pool, ExprId(node.a), x);
  return node.op == Op::sub && pool.sub(ExprId(node.b), ExprId(node.a)) == x ? -1 : 0;
}

/// A comparison, sign, abs, min or max by which side of 0 a multiple of x is on; none for what this does not decide.
ExprId decided(ExprPool& pool, const ExprNode& node, ExprId x, bool positive, const Images& images) {
  const bool two = is_comparison(node.op) || node.op == Op::min || node.op == Op::max;
  if (!two && node.op != Op::sign && node.op != Op::abs && node.op != Op::step) return {};
  const ExprId a(node.a), b(node.b);
  const int multiple = multiple_of(pool, two ? pool.sub(a, b) : a, x);
  if (multiple == 0) return {};
  const bool above = (multiple > 0) == positive;
  switch (node.op) {
    case Op::sign:
      return pool.constant(above ? 1.0 : -1.0);
    case Op::step:
      return pool.constant(above ? 1.0 : 0.0);
    case Op::abs:
      return above ? images.at(a) : pool.neg(images.at(a));
    case Op::max:
      return images.at(above ? a : b);
    case Op::min:
      return images.at(above ? b : a);
    case Op::eq:
    case Op::ne:
      return pool.constant(node.op == Op::ne ? 1.0 : 0.0);
    default:
      return pool.constant((node.op == Op::gt || node.op == Op::ge) == above ? 1.0 : 0.0);
  }
}

/// @p expression on one side of x = 0, with @p w for x.
ExprId on_side(ExprPool& pool, ExprId expression, ExprId x, SymbolId w, bool positive) {
  Images images;
  for (const ExprId e : reachable(pool, {&expression, 1})) {
    const ExprNode node = pool[e];  // a copy: the pool grows
    ExprId image = e == x ? pool.symbol(w) : decided(pool, node, x, positive, images);
    if (!image.valid() && node.op == Op::sub && pool.sub(ExprId(node.b), ExprId(node.a)) == x)
      image = pool.neg(pool.symbol(w));
    images[e] = image.valid() ? image : rebuilt(pool, node, [&](ExprId a) { return images.at(a); });
  }
  return images.at(expression);
}

/// factor |x|^power, on one side of x = 0; no factor: something else.
struct Term {
  ExprId factor;
  double power = 0.0;
};
using Terms = std::unordered_map<ExprId, Term>;

Term raised(ExprPool& pool, Op op, const Term& a, double power) {
  const bool constant = pool.is_constant(a.factor);
  if (op != Op::cbrt && power != std::floor(power) && constant && pool[a.factor].constant < 0.0) return {};
  const ExprId factor = op == Op::pow ? pool.pow(a.factor, pool.constant(power)) : pool.make(op, a.factor);
  return {factor, a.power * power};
}

Term combined(ExprPool& pool, const ExprNode& node, const Term& a, const Term& b) {
  switch (node.op) {
    case Op::neg:
    case Op::abs:
      return {pool.make(node.op, a.factor), a.power};
    case Op::sqrt:
      return raised(pool, node.op, a, 0.5);
    case Op::cbrt:
      return raised(pool, node.op, a, 1.0 / 3.0);
    case Op::pow:
      return pool.is_constant(ExprId(node.b)) ? raised(pool, node.op, a, pool[ExprId(node.b)].constant) : Term{};
    case Op::mul:
      return {pool.mul(a.factor, b.factor), a.power + b.power};
    case Op::div:
      return {pool.div(a.factor, b.factor), a.power - b.power};
    case Op::add:
    case Op::sub:
      return a.power == b.power ? Term{pool.make(node.op, a.factor, b.factor), a.power} : Term{};
    default:
      return {};
  }
}

/// Of all parts of @p expression, in which @p x is the symbol of x.
Terms terms_of(ExprPool& pool, ExprId expression, SymbolId x, bool positive) {
  const std::vector<ExprId> nodes = reachable(pool, {&expression, 1});
  const std::vector<char> depends =
      depends_on(pool, nodes, positions(nodes), [x](SymbolId symbol) { return symbol == x; });
  Terms terms;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode node = pool[nodes[i]];  // a copy: the pool grows
    Term& term = terms[nodes[i]];
    if (depends[i] == 0) {
      term = {nodes[i], 0.0};
    } else if (node.op == Op::symbol) {
      term = {pool.constant(positive ? 1.0 : -1.0), 1.0};
    } else if (arity(node.op) < 3 && !is_table(node.op)) {
      const Term a = terms.at(ExprId(node.a)), b = arity(node.op) > 1 ? terms.at(ExprId(node.b)) : a;
      if (a.factor.valid() && b.factor.valid()) term = combined(pool, node, a, b);
    }
  }
  return terms;
}

/// The least power below 1 of a term that is no factor of another one: that of x |x|^0.3 has a slope at 0. 1 if none.
double least_power(const ExprPool& pool, ExprId expression, const Terms& terms) {
  double least = 1.0;
  const auto look_at = [&](ExprId e) {
    const Term& term = terms.at(e);
    if (term.factor.valid() && term.power > 0.0) least = std::min(least, term.power);
  };
  look_at(expression);
  for (const auto& [e, term] : terms)
    if (!term.factor.valid()) for_each_argument(pool[e], look_at);
  return least;
}

/// A law on both sides of x = 0.
struct Sides {
  SymbolId x;                         ///< what is there for x
  std::array<ExprId, 2> expressions;  ///< above and below 0
  std::array<Terms, 2> terms;
  double power = 1.0;  ///< the least of which the law takes a root of x; 1 if none

  Sides(ExprPool& pool, ExprId law, ExprId of, SymbolId symbol) : x(symbol) {
    for (const std::size_t side : {0U, 1U}) {
      expressions[side] = on_side(pool, law, of, symbol, side == 0);
      terms[side] = terms_of(pool, expressions[side], symbol, side == 0);
      power = std::min(power, least_power(pool, expressions[side], terms[side]));
    }
  }
};

/// One side of a law by w, where x = sign(w) |w|^(1/power): a power of x is one of w, continued beyond 0 as an odd one.
ExprId with_root(ExprPool& pool, const Sides& sides, std::size_t side, SymbolId w) {
  Images images;
  for (const ExprId e : reachable(pool, {&sides.expressions[side], 1})) {
    const ExprNode node = pool[e];
    const Term& term = sides.terms[side].at(e);
    if (node.op == Op::symbol && pool.symbol_of(e) == sides.x) {
      images[e] = odd_power(pool, pool.symbol(w), 1.0 / sides.power);
    } else if (term.factor.valid() && term.power >= sides.power && term.power != std::floor(term.power)) {
      const ExprId image = pool.mul(term.factor, odd_power(pool, pool.symbol(w), term.power / sides.power));
      images[e] = side == 0 ? image : pool.neg(image);
    } else {
      images[e] = rebuilt(pool, node, [&](ExprId a) { return images.at(a); });
    }
  }
  return images.at(sides.expressions[side]);
}

/// The law by w. None where it jumps at x = 0.
ExprId by_root(ExprPool& pool, const Sides& sides, SymbolId w) {
  const ExprId above = with_root(pool, sides, 0, w), below = with_root(pool, sides, 1, w);
  if (above == below) return above;
  const ExprId zero = pool.constant(0.0);
  const std::unordered_map<SymbolId, ExprId> rest{{w, zero}};
  if (substitute(pool, above, rest) != substitute(pool, below, rest)) return {};
  return pool.select(pool.make(Op::ge, pool.symbol(w), zero), above, below);
}

bool has_root(const ExprPool& pool) {
  for (std::size_t i = 0; i < pool.size(); ++i)
    if (is_root(pool, pool[ExprId(i)])) return true;
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
    for (const ExprId x : arguments_of_roots(system_.pool, solved_form(system_.equations[index]), looked_at_))
      name_root_of(x, index);
  }

  /// The root that the equation at @p index takes of @p x.
  void name_root_of(ExprId x, std::uint32_t index) {
    SymbolId w(system_.symbols.size());  // a new one, unless the loop has it
    const Sides sides(system_.pool, solved_form(system_.equations[index]), x, w);
    if (sides.power == 1.0) return;
    const auto known = names_.find({x, sides.power});
    if (known != names_.end()) w = known->second;
    const ExprId law = by_root(system_.pool, sides, w);
    if (!law.valid()) return;
    Equation& equation = system_.equations[index];
    if (equation.loop_form.valid()) equation.implicit = true;
    equation.loop_form = {};
    equation.expression = law;
    if (known != names_.end()) return;
    names_.emplace(std::pair(x, sides.power), w);
    add_root(x, sides.power, equation);
  }

  /// w for a root of @p x. Where x is an unknown itself, it is given by w, and w has its equation: as a difference of
  /// large terms x would be known to their rounding only, which a power of w is not.
  void add_root(ExprId x, double power, const Equation& law) {
    ExprPool& pool = system_.pool;
    const ElementId element = law.element;
    const Place place = law.place;
    const SymbolId w = add_unknown(system_, name_of(pool.is_symbol(x) ? pool.symbol_of(x) : law.unknown));
    looked_at_.push_back(true);
    const ExprId by_w = odd_power(pool, pool.symbol(w), 1.0 / power);
    const bool is_unknown = pool.is_symbol(x);
    const Equation solved =
        is_unknown ? equation_of(pool.symbol_of(x)) : Equation{{}, x, false, element, place, {}, {}};
    if (solved.implicit || solved.loop_form.valid()) {
      const ExprId form = substitute(pool, solved_form(solved), {{solved.unknown, by_w}});
      define(system_, w, form, solved.element, solved.place, true);
    } else {
      define(system_, w, odd_root(pool, solved.expression, 1.0 / power), solved.element, solved.place);
      equation_of(w).loop_form = pool.sub(solved.expression, by_w);
    }
    if (is_unknown) {
      Equation& given = equation_of(solved.unknown);
      given.expression = by_w;
      given.implicit = false;
      given.loop_form = {};
    }
    system_.origins.resize(pool.size(), Origin{element, {}});
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
  std::map<std::pair<ExprId, double>, SymbolId> names_;  ///< by what the root is of, and its power
};

}  // namespace

void name_roots_in_loops(EquationSystem& system) {
  if (has_root(system.pool)) LoopRoots(system).name();
}

}  // namespace bgsim
