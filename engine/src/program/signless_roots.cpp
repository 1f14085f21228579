#include "program/signless_roots.hpp"

#include <cmath>
#include <limits>
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
      if (const ExprId x = argument_of(e); image == e && x.valid()) image = root_of(e, x);
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
    if (!law || !law->power.is_number()) return e;
    const double power = law->power.number;
    if (!(power < 1.0) || !(3.0 * power >= 1.0)) return e;
    const ExprId size = pool.make(Op::abs, x);
    const auto to = [&](double degree) {
      return degree == 0.5 ? pool.make(Op::sqrt, size) : pool.pow(size, pool.constant(degree));
    };
    const ExprId root = follows_[x.index()] != kSeveral ? pool.mul(pool.make(Op::sign, x), to(power))
                        : 3.0 * power == 1.0            ? pool.make(Op::cbrt, x)
                                                        : pool.make(Op::cbrt, pool.mul(x, to(3.0 * power - 1.0)));
    return pool.mul(law->factor, root);
  }

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
