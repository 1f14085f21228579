#include "expression/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <unordered_map>
#include <vector>

#include "expression/inverse_table.hpp"
#include "expression/inverter.hpp"
#include "expression/monotone.hpp"

namespace bgsim {

namespace {

/// Inverts parts of an expression of x.
class PartInverter {
 public:
  PartInverter(ExprPool& pool, SymbolId x, const NumberOf& number)
      : pool_(pool), x_(x), number_(number), cutter_(pool, x, number) {}

  /// The inverse of the parts; none if one of them has none.
  ExprId inverse(const std::vector<Part>& parts, Way way, ExprId y) {
    ExprId solution;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const ExprId here = inverse_of(parts[i], y);
      if (!here.valid()) return {};
      if (i == 0) {
        solution = here;
        continue;
      }
      const ExprId border = simpler(value_at(parts[i - 1].expression, parts[i].low_border),
                                    value_at(parts[i].expression, parts[i].low_border));
      solution = pool_.select(pool_.make(way == Way::rising ? Op::gt : Op::lt, y, border), here, solution);
    }
    return solution;
  }

  /// Whether @p solution by @p y gives back x wherever it is tried: what was proven, seen from the other side.
  bool gives_back(const std::vector<Part>& parts, ExprId solution, SymbolId y) {
    constexpr double kNear = 1e-6;
    for (const Part& part : parts)
      for (const double share : {0.1, 0.55, 0.9}) {
        const double x = Cutter::inside(part, share);
        const double value = cutter_.at(part.expression, x);
        if (!std::isfinite(value) || std::abs(value) > 1e100) continue;
        const double back = value_of(pool_, solution, [&](SymbolId s) { return s == y ? value : number_(s); });
        if (!(std::abs(back - x) <= kNear * std::abs(x))) return false;
      }
    return true;
  }

 private:
  ExprId value_at(ExprId root, ExprId x) { return substitute(pool_, root, {{x_, x}}); }

  [[nodiscard]] ExprId simpler(ExprId a, ExprId b) const {
    return reachable(pool_, {&b, 1}).size() < reachable(pool_, {&a, 1}).size() ? b : a;
  }

  /// c w^n, where w is an expression of one sign; without a factor if there is no such form.
  struct Monomial {
    ExprId factor;
    double power = 0.0;
  };

  /// By |w| where w is of the given sign.
  Monomial monomial(ExprId root, ExprId w, double sign) {
    std::unordered_map<ExprId, Monomial> known;
    known[w] = {pool_.constant(sign), 1.0};
    const std::vector<ExprId> nodes = reachable(pool_, {&root, 1});
    const std::vector<char> depends = cutter_.with_x(nodes);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i] == w) continue;
      const ExprNode node = pool_[nodes[i]];
      if (depends[i] == 0)
        known[nodes[i]] = {nodes[i], 0.0};
      else if (node.op != Op::symbol)
        known[nodes[i]] =
            combined(node, known[ExprId(node.a)], arity(node.op) > 1 ? known[ExprId(node.b)] : Monomial{});
    }
    return known[root];
  }

  Monomial combined(const ExprNode& node, const Monomial& a, const Monomial& b) {
    if (!a.factor.valid() || (arity(node.op) > 1 && !b.factor.valid())) return {};
    const auto raised = [&](double n) -> Monomial {
      const double size = cutter_.at(a.factor, std::numeric_limits<double>::quiet_NaN());
      if (!(size > 0.0) && !(size < 0.0 && n == std::floor(n))) return {};
      const ExprId factor = n == 0.5 ? pool_.make(Op::sqrt, a.factor) : pool_.pow(a.factor, pool_.constant(n));
      return {factor, a.power * n};
    };
    switch (node.op) {
      case Op::neg:
        return {pool_.neg(a.factor), a.power};
      case Op::mul:
        return {pool_.mul(a.factor, b.factor), a.power + b.power};
      case Op::div:
        return {pool_.div(a.factor, b.factor), a.power - b.power};
      case Op::sqrt:
        return raised(0.5);
      case Op::cbrt:
        return raised(1.0 / 3.0);
      case Op::pow:
        return b.power == 0.0 && pool_.is_constant(b.factor) ? raised(pool_[b.factor].constant) : Monomial{};
      default:
        return {};
    }
  }

  /// |u| with u^n = y, for y and u not negative.
  ExprId root_of(ExprId y, double n) {
    if (n == 1.0) return y;
    if (n == 2.0) return pool_.make(Op::sqrt, y);
    if (n == 3.0) return pool_.make(Op::cbrt, y);
    return pool_.pow(y, pool_.constant(1.0 / n));
  }

  /// The sign that @p w keeps over a part; 0 if it does not.
  double sign_over(ExprId w, const Part& part) {
    const Way way = cutter_.way_of({w, part.low, part.high, {}, {}});
    if (way == Way::unknown || way == Way::constant) return 0.0;
    const double low = cutter_.at(w, part.low), high = cutter_.at(w, part.high),
                 size = std::abs(cutter_.at(w, Cutter::inside(part, 0.5)));
    constexpr double kRounding = 1e-12;
    if (std::isnan(low) || std::isnan(high)) return 0.0;
    if (std::min(low, high) >= -kRounding * size) return 1.0;
    return std::max(low, high) <= kRounding * size ? -1.0 : 0.0;
  }

  ExprId inverse_of(const Part& part, ExprId y) {
    ExprId solution;
    ExprId target = part.expression;
    // Each round undoes a power; the chain of operators below and above it is that of any law.
    for (int round = 0; round < 8; ++round) {
      ExprId next;
      const auto rest = [&](ExprId where, ExprId value) -> std::optional<ExprId> {
        if (pool_[where].op == Op::table) {
          next = ExprId(pool_[where].a);
          const auto inverse = inverse_table(pool_, TableId(pool_[where].b));
          return inverse ? std::optional(pool_.table(Op::table, value, *inverse)) : std::nullopt;
        }
        const std::vector<ExprId> below = reachable(pool_, {&where, 1});
        const std::vector<char> depends = cutter_.with_x(below);
        for (std::size_t i = below.size() - 1; i-- > 0;) {
          if (depends[i] == 0) continue;
          const double sign = sign_over(below[i], part);
          if (sign == 0.0) continue;
          const Monomial form = monomial(where, below[i], sign);
          if (!form.factor.valid() || form.power == 0.0) continue;
          next = below[i];
          const ExprId size = root_of(pool_.div(value, form.factor), form.power);
          return sign > 0.0 ? size : pool_.neg(size);
        }
        return std::nullopt;
      };
      const auto found = invert(pool_, target, x_, y, rest);
      if (!found) return {};
      if (!next.valid()) return *found;
      y = *found;
      target = next;
      if (pool_.is_symbol(target)) return y;
    }
    return solution;
  }

  ExprPool& pool_;
  SymbolId x_;
  const NumberOf& number_;
  Cutter cutter_;
};

/// Values for what varies, of any size and both signs; the first ones are all 1.
class AnyNumbers {
 public:
  AnyNumbers(const std::vector<SymbolId>& varying, const NumberOf& number) : number_(number) {
    for (const SymbolId s : varying) values_[s] = 1.0;
  }
  void draw() {
    for (auto& [symbol, value] : values_) {
      const double size = std::pow(10.0, chance(-3.0, 3.0));
      value = chance(-1.0, 1.0) < -0.5 ? -size : size;
    }
  }
  double operator()(SymbolId symbol) const {
    const auto found = values_.find(symbol);
    return found != values_.end() ? found->second : number_(symbol);
  }

 private:
  double chance(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11U) * 0x1.0p-53;
  }
  const NumberOf& number_;
  std::unordered_map<SymbolId, double> values_;
  std::mt19937_64 random_{20261122};
};

}  // namespace

PieceInverse invert_in_pieces(ExprPool& pool, ExprId expression, SymbolId x, ExprId y, const NumberOf& number) {
  PieceInverse result;
  const auto rest = [&](ExprId at, ExprId value) -> std::optional<ExprId> {
    Cutter cutter(pool, x, number);
    const std::vector<SymbolId> varying = cutter.varying(at);
    if (!varying.empty()) {
      constexpr int kTrials = 32;
      AnyNumbers any(varying, number);
      const NumberOf drawn = [&any](SymbolId s) { return any(s); };
      for (int trial = 0; trial < kTrials && !result.monotone; ++trial) {
        Cutter tried(pool, x, drawn);
        const Way way = tried.way(tried.cut(at));
        result.monotone = way == Way::rising || way == Way::falling;
        any.draw();
      }
      return std::nullopt;
    }
    const std::vector<Part> parts = cutter.cut(at);
    const Way way = cutter.way(parts);
    if (parts.empty() || (way != Way::rising && way != Way::falling)) return std::nullopt;
    result.monotone = true;
    PartInverter inverter(pool, x, number);
    const ExprId solution = inverter.inverse(parts, way, pool.symbol(x));
    if (!solution.valid() || !inverter.gives_back(parts, solution, x)) return std::nullopt;
    return substitute(pool, solution, {{x, value}});
  };
  if (const auto solution = invert(pool, expression, x, y, rest)) result.solution = *solution;
  return result;
}

}  // namespace bgsim
