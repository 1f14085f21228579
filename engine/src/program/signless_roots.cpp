#include "program/signless_roots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "expression/graph.hpp"
#include "expression/signed_power.hpp"

namespace bgsim {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max(), kSeveral = kNone - 1;

bool is_whole(const ExprPool& pool, ExprId e) {
  return pool.is_constant(e) && pool[e].constant == std::floor(pool[e].constant);
}

class Rewriting {
 public:
  Rewriting(const EquationSystem& system, const BlockOrder& order)
      : system_(system), made_(order), stand_in_(system.symbols.size()) {
    const std::size_t size = made_.pool.size();
    follows_.reserve(size);
    sign_of_.reserve(size);
    image_.reserve(size);
    for (std::size_t i = 0; i < size; ++i) {
      const ExprId e(i);
      note(e);
      ExprId image = rebuilt_of(e);
      // What a root is a part of has been looked at with it.
      if (const ExprId x = argument_of(e); image == e && x.valid()) {
        image = root_of(e, x);
        made_.origins.resize(made_.pool.size(), Origin(made_.origins[x.index()]));  // whose law it is
      }
      changed_ = changed_ || image != e;
      made_.origins.resize(made_.pool.size(), Origin(made_.origins[i]));
      image_.push_back(image);
    }
  }

  [[nodiscard]] bool changed() const { return changed_; }

  BlockOrder take() && {
    const auto replace = [this](std::vector<ExprId>& list) {
      for (ExprId& e : list)
        if (e.valid()) e = image_[e.index()];
    };
    for (std::vector<ExprId>* list :
         {&made_.resolved, &made_.rates, &made_.outputs, &made_.powers, &made_.stored, &made_.continuous,
          &made_.switches, &made_.event_conditions, &made_.event_values, &made_.delayed, &made_.delayed_before,
          &made_.diodes, &made_.impulses, &made_.conjugates})
      replace(*list);
    for (std::vector<ExprId>& list : made_.port_powers) replace(list);
    for (Block& block : made_.blocks) replace(block.residuals);
    return std::move(made_);
  }

 private:
  ExprId rebuilt_of(ExprId e) {
    const ExprNode node = made_.pool[e];  // a copy: the pool grows
    bool same = true;
    for_each_argument(node, [&](ExprId a) { same = same && image_[a.index()] == a; });
    return same ? e : rebuilt(made_.pool, node, [this](ExprId a) { return image_[a.index()]; });
  }

  /// Which state @p e follows, and of what it has the sign for a factor.
  void note(ExprId e) {
    const ExprNode& node = made_.pool[e];
    std::uint32_t of = kNone;
    // What stood for an argument while a law was looked at is in the pool still, in no equation.
    if (node.op == Op::symbol && node.a < system_.symbols.size()) {
      const SystemSymbol& symbol = system_.symbols[node.a];
      if (symbol.kind == SystemSymbol::Kind::state) of = symbol.index;
      if (symbol.kind == SystemSymbol::Kind::unknown) of = kSeveral;
    }
    for_each_argument(node, [&](ExprId a) {
      const std::uint32_t other = follows_[a.index()];
      if (other != kNone) of = of == kNone || of == other ? other : kSeveral;
    });
    follows_.push_back(of);
    ExprId sign;
    if (node.op == Op::sign) sign = ExprId(node.a);
    if (node.op == Op::neg || node.op == Op::mul || node.op == Op::div) sign = sign_of_[node.a];
    if (node.op == Op::mul && !sign.valid()) sign = sign_of_[node.b];
    sign_of_.push_back(sign);
  }

  /// x, where @p e may be a root that keeps the sign of x: a product with sign(x), or a choice by a comparison of x
  /// with 0.
  [[nodiscard]] ExprId argument_of(ExprId e) const {
    const ExprNode& node = made_.pool[e];
    ExprId x;
    if (node.op == Op::select) {
      const ExprNode& condition = made_.pool[ExprId(node.a)];
      if (!is_inequality(condition.op)) return {};
      if (made_.pool.is_constant(ExprId(condition.b), 0.0)) x = ExprId(condition.a);
      if (made_.pool.is_constant(ExprId(condition.a), 0.0)) x = ExprId(condition.b);
    } else if (node.op == Op::mul || node.op == Op::div) {
      x = sign_of_[e.index()];
    }
    const bool changes =
        x.valid() && (follows_[x.index()] == kSeveral || (node.op == Op::select && follows_[x.index()] != kNone));
    return changes ? x : ExprId{};
  }

  /// @p e without a condition; with a sign alone where it follows a single state; or as it is.
  ExprId root_of(ExprId e, ExprId x) {
    ExprPool& pool = made_.pool;
    const auto law = signed_power(pool, e, x, stand_in_);
    if (!law) return e;
    if (!law->power.is_number()) return is_of_parameters(law->power.of) ? root_by(e, x, *law) : e;
    const double power = law->power.number;
    if (!(power < 1.0)) return e;
    if (follows_[x.index()] != kSeveral)
      return pool.mul(law->factor, pool.mul(pool.make(Op::sign, x), power_of_size(x, power)));
    if (power < kLeastPower) return e;
    const int roots = 3.0 * power < 1.0 ? 2 : 1;
    return pool.mul(law->factor, roots_of(x, pool.constant(std::pow(3.0, roots) * power), roots));
  }

  /// The same for a power that parameters are: how many roots it takes is their matter. The sign that is left for the
  /// least powers is one of 1 for others, so that nothing comes to its border.
  ExprId root_by(ExprId e, ExprId x, const SignedPower& law) {
    if (follows_[x.index()] != kSeveral) return e;
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

  [[nodiscard]] bool is_of_parameters(ExprId e) const {
    const std::vector<SymbolId> symbols = symbols_in(made_.pool, std::span(&e, 1));
    return std::all_of(symbols.begin(), symbols.end(), [this](SymbolId symbol) {
      return symbol.index() < system_.symbols.size() &&
             system_.symbols[symbol.index()].kind == SystemSymbol::Kind::parameter;
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
  std::vector<std::uint32_t> follows_;   ///< by ExprId: a state, kNone or kSeveral
  std::vector<ExprId> sign_of_, image_;  ///< by ExprId
  bool changed_ = false;
};

}  // namespace

std::optional<BlockOrder> with_signless_roots(const EquationSystem& system, const BlockOrder& order) {
  bool root = false, side = false;  // of these a root that keeps a sign is made
  for (std::size_t i = 0; i < order.pool.size(); ++i) {
    const ExprNode& node = order.pool[ExprId(i)];
    const bool power = node.op == Op::pow && !is_whole(order.pool, ExprId(node.b));
    root = root || power || node.op == Op::sqrt || node.op == Op::cbrt;
    side = side || node.op == Op::sign || node.op == Op::select;
  }
  if (!root || !side) return std::nullopt;
  Rewriting rewriting(system, order);
  if (!rewriting.changed()) return std::nullopt;
  return std::move(rewriting).take();
}

}  // namespace bgsim
