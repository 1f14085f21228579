#include "program/joined_laws.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "expression/graph.hpp"
#include "expression/partial.hpp"
#include "expression/sides.hpp"
#include "expression/signed_power.hpp"
#include "program/rewritten.hpp"

namespace bgsim {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max(), kSeveral = kNone - 1;

class Rewriting {
 public:
  Rewriting(const EquationSystem& system, const BlockOrder& order, bool joins_kinks)
      : system_(system), made_(order), stand_in_(system.symbols.size()), joins_kinks_(joins_kinks) {
    const std::size_t size = made_.pool.size();
    follows_.reserve(size);
    sign_of_.reserve(size);
    image_.reserve(size);
    for (std::size_t i = 0; i < size; ++i) {
      const ExprId e(i);
      note(e);
      ExprId image = with_images(made_, e, image_);
      // What such a law is a part of has been looked at with it.
      if (const auto border = image == e ? border_of(e) : std::nullopt) {
        image = without_condition(e, *border);
        made_.origins.resize(made_.pool.size(), Origin(made_.origins[border->said.index()]));  // whose law it is
      }
      changed_ = changed_ || image != e;
      made_.origins.resize(made_.pool.size(), Origin(made_.origins[i]));
      image_.push_back(image);
    }
  }

  [[nodiscard]] bool changed() const { return changed_; }
  /// Laws that meet in a kink between stores, left with their condition or not.
  [[nodiscard]] std::size_t kinks() const { return kinks_; }

  BlockOrder take() && {
    replace_by_images(made_, image_);
    return std::move(made_);
  }

 private:
  /// Which state @p e follows, and of what it has the sign or the step for a factor.
  void note(ExprId e) {
    const ExprNode& node = made_.pool[e];
    std::uint32_t of = kNone;
    bool loop = false;
    // What stood for an argument while a law was looked at is in the pool still, in no equation.
    if (node.op == Op::symbol && node.a < system_.symbols.size()) {
      const SystemSymbol& symbol = system_.symbols[node.a];
      if (symbol.kind == SystemSymbol::Kind::state) of = symbol.index;
      loop = symbol.kind == SystemSymbol::Kind::unknown;
      if (loop) of = kSeveral;
    }
    for_each_argument(node, [&](ExprId a) {
      const std::uint32_t other = follows_[a.index()];
      if (other != kNone) of = of == kNone || of == other ? other : kSeveral;
      loop = loop || of_loop_[a.index()];
    });
    follows_.push_back(of);
    of_loop_.push_back(loop);
    ExprId sign;
    if (node.op == Op::sign || node.op == Op::step) sign = ExprId(node.a);
    if (node.op == Op::neg || node.op == Op::mul || node.op == Op::div) sign = sign_of_[node.a];
    if (node.op == Op::mul && !sign.valid()) sign = sign_of_[node.b];
    sign_of_.push_back(sign);
  }

  /// Two sides of x = 0, where x is what a sign is of or the difference that a comparison is of.
  struct Border {
    ExprId x;
    ExprId above, below;  ///< what holds on either side; signs of x are still in them
    ExprId said;          ///< in the law whose border it is
    bool of_several = false, of_loop = false;
  };

  /// Where @p e has two sides: a product with sign(x) or step(x), or a choice by a comparison.
  std::optional<Border> border_of(ExprId e) {
    const ExprNode node = made_.pool[e];  // a copy: the pool grows
    if (node.op == Op::mul || node.op == Op::div) {
      const ExprId x = sign_of_[e.index()];
      if (!x.valid() || follows_[x.index()] == kNone) return std::nullopt;
      return Border{x, e, e, x, follows_[x.index()] == kSeveral, of_loop_[x.index()]};
    }
    if (node.op != Op::select || !is_inequality(made_.pool[ExprId(node.a)].op)) return std::nullopt;
    const ExprNode condition = made_.pool[ExprId(node.a)];
    const ExprId a(condition.a), b(condition.b);
    const std::uint32_t one = follows_[a.index()], other = follows_[b.index()];
    if (one == kNone ? !made_.pool.is_constant(a, 0.0) || other == kNone
                     : other == kNone && !made_.pool.is_constant(b, 0.0))
      return std::nullopt;
    Border border{one == kNone ? b : made_.pool.sub(a, b), ExprId(node.b), ExprId(node.c), ExprId(node.a)};
    border.of_several = one == kSeveral || other == kSeveral || (one != kNone && other != kNone && one != other);
    border.of_loop = of_loop_[a.index()] || of_loop_[b.index()];
    const bool greater = condition.op == Op::gt || condition.op == Op::ge;
    if (greater == (one == kNone)) std::swap(border.above, border.below);
    return border;
  }

  /// @p e without a condition; a root with a sign alone where it follows a single state; or as it is.
  ExprId without_condition(ExprId e, const Border& border) {
    ExprPool& pool = made_.pool;
    const ExprId x = border.x;
    const auto law = signed_power(pool, e, x, stand_in_);
    if (!law) return border.of_loop ? e : joined(e, border);
    if (!law->power.is_number()) return border.of_several && is_of_parameters(law->power.of) ? root_by(x, *law) : e;
    const double power = law->power.number;
    if (power >= 1.0) return pool.mul(law->factor, odd_power(pool, x, power));
    if (!border.of_several) return pool.mul(law->factor, pool.mul(pool.make(Op::sign, x), power_of_size(x, power)));
    if (power < kLeastPower) return e;
    const int roots = 3.0 * power < 1.0 ? 2 : 1;
    return pool.mul(law->factor, roots_of(x, pool.constant(std::pow(3.0, roots) * power), roots));
  }

  /// The same for a power that parameters are: how many roots it takes is their matter. The sign that is left for the
  /// least powers is one of 1 for others, so that nothing comes to its border.
  ExprId root_by(ExprId x, const SignedPower& law) {
    ExprPool& pool = made_.pool;
    const ExprId one = pool.constant(1.0), power = expression_of(pool, law.power);
    const auto cubed = [&](int times) { return pool.mul(pool.constant(std::pow(3.0, times)), power); };
    const ExprId is_covered = pool.make(Op::ge, power, pool.constant(kLeastPower));
    const ExprId sign = pool.make(Op::sign, pool.select(is_covered, one, x));
    ExprId root = pool.mul(sign, pool.pow(pool.make(Op::abs, x), power));
    for (const int roots : {2, 1, 0}) {
      const ExprId enough = roots == 2 ? is_covered : pool.make(Op::ge, cubed(roots), one);
      root = pool.select(enough, roots_of(x, cubed(roots), roots), root);
    }
    return pool.mul(law.factor, root);
  }

  /// Two sides that meet at the border, each evaluated on its side alone: above(max(x, 0)) + below(min(x, 0)), less
  /// their value at 0.
  ExprId joined(ExprId e, const Border& border) {
    ExprPool& pool = made_.pool;
    const Sides of_above = sides_of(pool, border.above, border.x, stand_in_);
    const Sides of_below = sides_of(pool, border.below, border.x, stand_in_);
    const ExprId above = of_above.expressions[0], below = of_below.expressions[1];
    if (!of_above.above_zero.empty() || !of_below.above_zero.empty() || !ends_by_x_alone(above) ||
        !ends_by_x_alone(below))
      return e;
    // 0 times what has no value has none: step(x) x^1.5 below 0.
    if (border.above == border.below && may_end(e) && !(may_end(above) && may_end(below))) return e;
    const std::optional<ExprId> meets = at_border(above), other = at_border(below);
    if (!meets || other != meets || of_above.at_zero != *meets || of_below.at_zero != *meets) return e;
    const bool ends = of_above.power.valid() || of_below.power.valid();
    if (ends && !border.of_several) return e;
    if (!ends && !is_smooth(above, below)) {
      kinks_ += border.of_several ? 1 : 0;
      if (!border.of_several || !joins_kinks_) return e;
    }
    const auto with = [&](ExprId side, Op op) {
      return substitute(pool, side, {{stand_in_, pool.make(op, border.x, pool.constant(0.0))}});
    };
    return pool.sub(pool.add(with(above, Op::max), with(below, Op::min)), *meets);
  }

  /// Whether both sides go on with one slope.
  bool is_smooth(ExprId above, ExprId below) {
    const auto slope = [&](ExprId side) {
      const auto by_x = gradient(made_.pool, side, [this](SymbolId symbol) { return symbol == stand_in_; });
      return at_border(by_x.empty() ? made_.pool.constant(0.0) : by_x.front().second);
    };
    const std::optional<ExprId> one = slope(above);
    return one && one == slope(below);
  }

  [[nodiscard]] bool may_end(ExprId side) const {
    const std::vector<ExprId> parts = reachable(made_.pool, {&side, 1});
    return std::any_of(parts.begin(), parts.end(), [this](ExprId part) { return is_partial(made_.pool, part); });
  }

  /// Whether what may have no value is of x and of parameters alone: a side is evaluated where it was not before.
  [[nodiscard]] bool ends_by_x_alone(ExprId side) const {
    const std::vector<ExprId> parts = reachable(made_.pool, {&side, 1});
    return std::all_of(parts.begin(), parts.end(),
                       [this](ExprId part) { return !is_partial(made_.pool, part) || is_of_parameters(part); });
  }

  /// A side at x = 0, where it will be for all x of the other; none where a part of it has no value there, or one that
  /// only a parameter knows (0^p).
  std::optional<ExprId> at_border(ExprId side) {
    std::unordered_map<ExprId, ExprId> images;
    for (const ExprId part : reachable(made_.pool, {&side, 1})) {
      const ExprNode node = made_.pool[part];  // a copy: the pool grows
      const ExprId image = node.op == Op::symbol && SymbolId(node.a) == stand_in_
                               ? made_.pool.constant(0.0)
                               : rebuilt(made_.pool, node, [&](ExprId a) { return images.at(a); });
      const ExprNode& there = made_.pool[image];
      const ExprId decides(there.op == Op::div || there.op == Op::mod ? there.b : there.a);
      if (is_partial(made_.pool, image) && made_.pool.is_constant(decides)) return std::nullopt;
      images[part] = image;
    }
    return images.at(side);
  }

  /// And of what stands for x.
  [[nodiscard]] bool is_of_parameters(ExprId e) const {
    const std::vector<SymbolId> symbols = symbols_in(made_.pool, std::span(&e, 1));
    return std::all_of(symbols.begin(), symbols.end(), [this](SymbolId symbol) {
      return symbol == stand_in_ || (symbol.index() < system_.symbols.size() &&
                                     system_.symbols[symbol.index()].kind == SystemSymbol::Kind::parameter);
    });
  }

  ExprId power_of_size(ExprId x, double power) {
    const ExprId size = made_.pool.make(Op::abs, x);
    return power == 0.5 ? made_.pool.make(Op::sqrt, size) : made_.pool.pow(size, made_.pool.constant(power));
  }
  /// sign(x) |x|^(cubed/3^roots), for cubed from 1 on.
  ExprId roots_of(ExprId x, ExprId cubed, int roots) {
    ExprPool& pool = made_.pool;
    ExprId root = x;
    if (!pool.is_constant(cubed))
      root = pool.mul(x, pool.pow(pool.make(Op::abs, x), pool.sub(cubed, pool.constant(1.0))));
    else if (pool[cubed].constant != 1.0)
      root = pool.mul(x, power_of_size(x, pool[cubed].constant - 1.0));
    for (; roots > 0; --roots) root = pool.make(Op::cbrt, root);
    return root;
  }

  /// Of a cubic root of a cubic root. Below, levels that are near each other are followed in no fewer steps than the
  /// sign's condition costs (16 tanks: 4,000 with a power of 1/5, as many as with the condition; 71,000 of 1/7,
  /// 39,000).
  static constexpr double kLeastPower = 0.2;

  const EquationSystem& system_;
  BlockOrder made_;
  SymbolId stand_in_;
  std::vector<std::uint32_t> follows_;  ///< by ExprId: a state, kNone or kSeveral
  std::vector<bool> of_loop_;           ///< by ExprId: follows an unknown of a loop
  std::vector<ExprId> sign_of_;         ///< by ExprId: what the sign or step is of that it has for a factor
  std::vector<ExprId> image_;           ///< by ExprId
  bool joins_kinks_, changed_ = false;
  std::size_t kinks_ = 0;
};

}  // namespace

std::optional<BlockOrder> with_joined_laws(const EquationSystem& system, const BlockOrder& order) {
  bool side = false;
  for (std::size_t i = 0; i < order.pool.size() && !side; ++i) {
    const Op op = order.pool[ExprId(i)].op;
    side = op == Op::sign || op == Op::step || op == Op::select;
  }
  if (!side) return std::nullopt;
  // An event takes a kink exactly, and one damper of two slopes is cheaper so. But of many, those of a row of empty
  // stores are at their borders at once: 25 diodes of two slopes between capacitors did not run (BG605).
  constexpr std::size_t kFew = 8;
  std::optional<Rewriting> rewriting(std::in_place, system, order, false);
  if (rewriting->kinks() > kFew) rewriting.emplace(system, order, true);
  if (!rewriting->changed()) return std::nullopt;
  return std::move(*rewriting).take();
}

}  // namespace bgsim
