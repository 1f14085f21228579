#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "bgsim/expression.hpp"
#include "expression/cancel.hpp"
#include "expression/graph.hpp"
#include "expression/root_slope.hpp"

namespace bgsim {

namespace {

/// A partial derivative as a fraction, so that g*(u/v) can be written (g*u)/v.
struct Partial {
  ExprId over;   ///< none: 1
  ExprId under;  ///< none: 1
};

/// Partial derivative of one operator by its argument @p k (0, 1); none if it vanishes almost everywhere.
class Partials {
 public:
  explicit Partials(ExprPool& pool) : pool_(pool) {}

  std::optional<Partial> of_one(const ExprNode& node, ExprId self) {
    const ExprId a(node.a);
    switch (node.op) {
      case Op::neg:
        return Partial{c(-1.0), {}};
      case Op::abs:
        return Partial{f(Op::sign, a), {}};
      case Op::sqrt:
        return Partial{{}, pool_.mul(c(2.0), self)};
      case Op::cbrt:
        return Partial{{}, pool_.mul(c(3.0), pool_.mul(self, self))};
      case Op::exp:
        return Partial{self, {}};
      case Op::log:
        return Partial{{}, a};
      case Op::log10:
        return Partial{{}, pool_.mul(c(std::numbers::ln10), a)};
      case Op::sin:
        return Partial{f(Op::cos, a), {}};
      case Op::cos:
        return Partial{pool_.neg(f(Op::sin, a)), {}};
      case Op::tan:
        return Partial{pool_.add(pool_.mul(self, self), c(1.0)), {}};
      case Op::asin:
        return Partial{{}, f(Op::sqrt, one_minus_square(a))};
      case Op::acos:
        return Partial{c(-1.0), f(Op::sqrt, one_minus_square(a))};
      case Op::atan:
        return Partial{{}, pool_.add(pool_.mul(a, a), c(1.0))};
      case Op::sinh:
        return Partial{f(Op::cosh, a), {}};
      case Op::cosh:
        return Partial{f(Op::sinh, a), {}};
      case Op::tanh:
        return Partial{one_minus_square(self), {}};
      case Op::asinh:
        return Partial{{}, pool_.make(Op::hypot, a, c(1.0))};
      case Op::acosh:  // sqrt(a^2 - 1) would cancel near 1 and overflow far from it
        return Partial{{}, pool_.mul(f(Op::sqrt, pool_.sub(a, c(1.0))), f(Op::sqrt, pool_.add(a, c(1.0))))};
      case Op::atanh:
        return Partial{{}, pool_.mul(pool_.sub(c(1.0), a), pool_.add(a, c(1.0)))};
      case Op::log1p:
        return Partial{{}, pool_.add(a, c(1.0))};
      case Op::expm1:
        return Partial{f(Op::exp, a), {}};
      case Op::table:
        return Partial{pool_.table(Op::table_slope, a, TableId(node.b)), {}};
      case Op::table_slope:
        return Partial{pool_.table(Op::table_curvature, a, TableId(node.b)), {}};
      case Op::table_curvature:
        return Partial{pool_.table(Op::table_third, a, TableId(node.b)), {}};
      case Op::table_third:
        return std::nullopt;  // constant between two knots
      case Op::der:
        throw std::invalid_argument("der(...) must be resolved before an expression is differentiated");
      default:
        return std::nullopt;  // sign, step, floor, ceil, round
    }
  }

  std::optional<Partial> of_two(const ExprNode& node, ExprId self, int k) {
    const ExprId a(node.a), b(node.b);
    const bool first = k == 0;
    switch (node.op) {
      case Op::add:
        return Partial{};
      case Op::sub:
        return first ? Partial{} : Partial{c(-1.0), {}};
      case Op::mul:
        return Partial{first ? b : a, {}};
      case Op::div:
        return first ? Partial{{}, b} : Partial{pool_.neg(self), b};
      case Op::pow:
        if (first) return Partial{pool_.mul(b, pool_.pow(a, pool_.sub(b, c(1.0)))), {}};
        if (pool_.is_constant(a, 0.0)) return std::nullopt;  // 0^b is 0, whatever b > 0 is
        return Partial{pool_.mul(self, f(Op::log, a)), {}};
      case Op::atan2: {
        const ExprId square = pool_.add(pool_.mul(a, a), pool_.mul(b, b));
        return first ? Partial{b, square} : Partial{pool_.neg(a), square};
      }
      case Op::hypot:
        return Partial{first ? a : b, self};
      case Op::ssqrt:
        return signed_root(a, b, first);
      case Op::mod:
        return first ? Partial{} : Partial{pool_.neg(f(Op::floor, pool_.div(a, b))), {}};
      default:
        return std::nullopt;  // comparisons, logic; min and max are branches
    }
  }

 private:
  ExprId c(double value) { return pool_.constant(value); }
  ExprId f(Op op, ExprId a) { return pool_.make(op, a); }
  ExprId one_minus_square(ExprId a) { return pool_.sub(c(1.0), pool_.mul(a, a)); }

  /// a/sqrt(h) with h = hypot(a, b): (1 - (a/h)^2/2)/sqrt(h) by a, -(a/h)(b/h)/(2 sqrt(h)) by b; neither overflows.
  Partial signed_root(ExprId a, ExprId b, bool first) {
    const ExprId h = pool_.make(Op::hypot, a, b);
    const ExprId sine = pool_.div(a, h);
    const ExprId other = first ? sine : pool_.div(b, h);
    const ExprId half = pool_.mul(c(0.5), pool_.mul(sine, other));
    return {first ? pool_.sub(c(1.0), half) : pool_.neg(half), f(Op::sqrt, h)};
  }

  ExprPool& pool_;
};

/// Reverse accumulation: what the root changes by, for a change of each expression.
class Reverse {
 public:
  /// @p cancel  what makes products shorter as they come up; none: they stay as they come.
  Reverse(ExprPool& pool, ExprId root, const std::function<bool(SymbolId)>& wanted, Canceller* cancel = nullptr)
      : pool_(pool),
        cancel_(cancel),
        nodes_(reachable(pool, {&root, 1})),
        position_(positions(nodes_)),
        active_(depends_on(pool, nodes_, position_, wanted)),
        adjoint_(nodes_.size()) {
    adjoint_.back() = pool.constant(1.0);  // the root is the last: it depends on all others
  }

  std::vector<std::pair<SymbolId, ExprId>> run() {
    std::vector<std::pair<SymbolId, ExprId>> result;
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      const ExprId g = adjoint_[i];
      if (active_[i] == 0 || !g.valid() || pool_.is_constant(g, 0.0)) continue;
      const ExprNode node = pool_[nodes_[i]];  // a copy: the pool grows
      if (node.op == Op::symbol)
        result.emplace_back(SymbolId(node.a), g);
      else
        spread(node, nodes_[i], g);
    }
    std::sort(result.begin(), result.end());
    return result;
  }

 private:
  void spread(const ExprNode& node, ExprId self, ExprId g) {
    Partials partials(pool_);
    switch (arity(node.op)) {
      case 1:
        if (active(node.a)) give(node.a, g, partials.of_one(node, self), self);
        return;
      case 2:
        if (node.op == Op::min || node.op == Op::max) {
          const ExprId takes_a = pool_.make(node.op == Op::min ? Op::le : Op::ge, ExprId(node.a), ExprId(node.b));
          return choose(takes_a, node.a, node.b, g);
        }
        if (active(node.a)) give(node.a, g, partials.of_two(node, self, 0), self);
        if (active(node.b)) give(node.b, g, partials.of_two(node, self, 1));
        return;
      default:
        choose(ExprId(node.a), node.b, node.c, g);
    }
  }
  /// The branch that is not taken gets 0, even where g has no value: sqrt(max(x, 0)) for x < 0.
  void choose(ExprId condition, std::uint32_t then, std::uint32_t otherwise, ExprId g) {
    const ExprId zero = pool_.constant(0.0);
    if (active(then)) accumulate(then, pool_.select(condition, g, zero));
    if (active(otherwise)) accumulate(otherwise, pool_.select(condition, zero, g));
  }
  /// @param self  of the first argument's partial: a root has no slope at 0, and what it is multiplied by may be 0
  /// there
  void give(std::uint32_t argument, ExprId g, const std::optional<Partial>& partial, ExprId self = {}) {
    if (!partial) return;
    // An adjoint that is 0 in one branch stays 0 there whatever the partial is: the square root of a branch not taken
    // may have no slope, and 0 times that is not 0. Hence the product goes into the branch.
    std::vector<ExprNode> branches;
    while (one_sided(g)) {
      branches.push_back(pool_[g]);
      g = pool_.is_constant(ExprId(branches.back().c), 0.0) ? ExprId(branches.back().b) : ExprId(branches.back().c);
    }
    ExprId term;
    const auto varies = [this](ExprId e) { return active(e.value); };
    if (const auto slope = self.valid() ? root_slope(pool_, self, g, varies) : std::nullopt) {
      argument = slope->by.value;
      term = slope->value;
    } else {
      term = partial->over.valid() ? pool_.mul(g, partial->over) : g;
      if (partial->under.valid()) term = pool_.div(term, partial->under);
    }
    if (cancel_ != nullptr) term = (*cancel_)(term);
    for (auto branch = branches.rbegin(); branch != branches.rend(); ++branch) {
      const bool then = pool_.is_constant(ExprId(branch->c), 0.0);
      term = pool_.select(ExprId(branch->a), then ? term : ExprId(branch->b), then ? ExprId(branch->c) : term);
    }
    accumulate(argument, term);
  }
  void accumulate(std::uint32_t argument, ExprId term) {
    ExprId& sum = adjoint_[*position_.find(ExprId(argument))];
    sum = sum.valid() ? sum_of(sum, term) : term;
  }
  [[nodiscard]] bool one_sided(ExprId g) const {
    const ExprNode& node = pool_[g];
    return node.op == Op::select && (pool_.is_constant(ExprId(node.b), 0.0) || pool_.is_constant(ExprId(node.c), 0.0));
  }
  /// Sums within the same branch stay in it.
  ExprId sum_of(ExprId left, ExprId right) {
    const ExprNode a = pool_[left], b = pool_[right];
    if (a.op != Op::select || b.op != Op::select || a.a != b.a) return pool_.add(left, right);
    return pool_.select(ExprId(a.a), pool_.add(ExprId(a.b), ExprId(b.b)), pool_.add(ExprId(a.c), ExprId(b.c)));
  }
  [[nodiscard]] bool active(std::uint32_t argument) const { return active_[*position_.find(ExprId(argument))] != 0; }

  ExprPool& pool_;
  Canceller* cancel_;
  std::vector<ExprId> nodes_;
  IdMap<std::uint32_t> position_;
  std::vector<char> active_;
  std::vector<ExprId> adjoint_;
};

}  // namespace

std::vector<std::pair<SymbolId, ExprId>> gradient(ExprPool& pool, ExprId root,
                                                  const std::function<bool(SymbolId)>& wanted) {
  return Reverse(pool, root, wanted).run();
}

std::vector<std::pair<SymbolId, ExprId>> short_gradient(ExprPool& pool, ExprId root,
                                                        const std::function<bool(SymbolId)>& wanted) {
  Canceller cancel(pool);
  return Reverse(pool, root, wanted, &cancel).run();
}

bool jumps_at_knots(const ExprPool& pool, const ExprNode& node) {
  if (!is_table(node.op) || pool.table(TableId(node.b)).delayed) return false;
  const bool line = pool.table(TableId(node.b)).interpolation == Interpolation::linear;
  return node.op == (line ? Op::table_slope : Op::table_third);
}

bool jumps_with(const ExprPool& pool, ExprId root, const std::function<bool(SymbolId)>& x) {
  const std::vector<ExprId> nodes = reachable(pool, {&root, 1});
  const std::vector<char> depends = depends_on(pool, nodes, positions(nodes), x);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (depends[i] == 0) continue;
    const ExprNode& node = pool[nodes[i]];
    if (node.op == Op::sign || node.op == Op::step || is_rounding(node.op) || node.op == Op::mod ||
        is_comparison(node.op))
      return true;
    if (jumps_at_knots(pool, node)) return true;
  }
  return false;
}

}  // namespace bgsim
