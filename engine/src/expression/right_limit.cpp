#include "expression/right_limit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "expression/graph.hpp"
#include "expression/rounded.hpp"

namespace bgsim {

namespace {

constexpr double kUnit = std::numeric_limits<double>::epsilon() / 2;

/// What decides a relation: zero at its border.
struct Guard {
  ExprId expression;
  double magnitude = 0.0;  ///< of what is subtracted in it
};

struct Side {
  int sign = 0;
  double hidden = 0.0;
};

class Limit {
 public:
  Limit(const ExprPool& from, SymbolId time, std::span<const double> symbol_values, double after)
      : from_(from), time_(time), after_(after), values_(symbol_values.begin(), symbol_values.end()) {
    if (values_.size() <= time.index()) values_.resize(time.index() + 1, 0.0);
  }

  std::optional<RightLimit> of(ExprId relation) {
    const std::vector<ExprId> nodes = reachable(from_, {&relation, 1});
    // measured data have no derivatives of higher order
    if (std::any_of(nodes.begin(), nodes.end(), [this](ExprId e) { return is_table(from_[e].op); }))
      return std::nullopt;
    const IdMap<std::uint32_t> position = positions(nodes);
    if (!hides(nodes, position)) return std::nullopt;
    pool_.emplace();
    copy_.emplace(from_, *pool_, [this](SymbolId s) { return pool_->symbol(s); });
    const std::vector<char> depends = depends_on(from_, nodes, position, [this](SymbolId s) { return s == time_; });
    std::vector<double> limit(nodes.size());
    RightLimit result;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const ExprNode& node = from_[nodes[i]];
      std::array<double, 3> x{};
      std::size_t n = 0;
      if (node.op != Op::constant && node.op != Op::symbol)
        for_each_argument(node, [&](ExprId a) { x[n++] = limit[*position.find(a)]; });
      limit[i] = value_at(nodes[i], node, x);
      if (depends[i] == 0 || !at_border(node.op, x[0], x[1])) continue;
      const auto side = side_of(node, x);
      if (!side) return std::nullopt;
      result.hidden = std::max(result.hidden, side->hidden);
      limit[i] = beyond(node.op, x, side->sign);
    }
    result.value = limit.back();
    return std::isnan(result.value) ? std::nullopt : std::optional(result);
  }

 private:
  /// Whether something is exactly at its border at the instant and at the next double, too.
  [[nodiscard]] bool hides(const std::vector<ExprId>& nodes, const IdMap<std::uint32_t>& position) {
    std::vector<double> now(nodes.size()), next(nodes.size());
    bool found = false;
    const double following = std::nextafter(after_, std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const ExprNode& node = from_[nodes[i]];
      std::array<double, 3> x{}, y{};
      std::size_t n = 0;
      if (node.op != Op::constant && node.op != Op::symbol)
        for_each_argument(node, [&](ExprId a) {
          x[n] = now[*position.find(a)];
          y[n++] = next[*position.find(a)];
        });
      values_[time_.index()] = following;
      next[i] = value_at(nodes[i], node, y);
      values_[time_.index()] = after_;
      now[i] = value_at(nodes[i], node, x);
      found = found || (at_border(node.op, x[0], x[1]) && at_border(node.op, y[0], y[1]) && varies(nodes[i]));
    }
    return found;
  }

  [[nodiscard]] bool varies(ExprId e) const {
    const std::vector<SymbolId> symbols = symbols_in(from_, {&e, 1});
    return std::binary_search(symbols.begin(), symbols.end(), time_);
  }

  [[nodiscard]] double value_at(ExprId e, const ExprNode& node, const std::array<double, 3>& x) const {
    if (node.op == Op::constant) return node.constant;
    if (node.op == Op::symbol) return values_[from_.symbol_of(e).index()];
    return apply(node.op, x[0], x[1], x[2]);
  }

  static bool at_border(Op op, double a, double b) {
    if (is_comparison(op)) return a == b;
    if (op == Op::sign || op == Op::step) return a == 0.0;
    if (op == Op::floor || op == Op::ceil) return a == std::floor(a);
    if (op == Op::round) return a + 0.5 == std::floor(a + 0.5);
    if (op == Op::mod) return a / b == std::floor(a / b);
    return false;
  }

  /// The value on one side of the border.
  static double beyond(Op op, const std::array<double, 3>& x, int side) {
    if (is_comparison(op)) return apply(op, side, 0.0);
    if (op == Op::sign || op == Op::step) return apply(op, side);
    if (op == Op::floor) return side < 0 ? x[0] - 1.0 : x[0];
    if (op == Op::ceil) return side > 0 ? x[0] + 1.0 : x[0];
    if (op == Op::round) return side == 0 ? std::round(x[0]) : std::round(x[0] + 0.25 * side);
    return side < 0 ? x[1] : 0.0;  // mod
  }

  [[nodiscard]] Guard guard_of(const ExprNode& node, const std::array<double, 3>& x) {
    const ExprId a = (*copy_)(ExprId(node.a));
    if (is_comparison(node.op)) return {pool_->sub(a, (*copy_)(ExprId(node.b))), std::abs(x[0])};
    if (node.op == Op::mod) {
      const ExprId turns = pool_->div(a, (*copy_)(ExprId(node.b)));
      return {pool_->sub(turns, pool_->constant(x[0] / x[1])), std::abs(x[0] / x[1])};
    }
    return {pool_->sub(a, pool_->constant(x[0])), std::abs(x[0])};
  }

  /// To which side the guard goes: the sign of its first derivative that is not 0, if that lasts and shows in the
  /// values as soon as rounding lets it. No side if all vanish, as for what is the same on both sides.
  std::optional<Side> side_of(const ExprNode& node, const std::array<double, 3>& x) {
    constexpr int kHighest = 4;
    constexpr double kBeyond = 8.0;
    const Guard guard = guard_of(node, x);
    const auto at = [this](ExprId e, double t) {
      values_[time_.index()] = t;
      const double value = evaluate(*pool_, e, values_);
      values_[time_.index()] = after_;
      return value;
    };
    const std::vector<double> exact(values_.size(), 0.0);
    const double noise = std::max(rounding_of(*pool_, guard.expression, values_, exact), kUnit * guard.magnitude);
    ExprId derivative = guard.expression;
    double factorial = 1.0;
    for (int order = 1; order <= kHighest; ++order) {
      factorial *= order;
      const auto partials = gradient(*pool_, derivative, [this](SymbolId s) { return s == time_; });
      if (partials.empty()) return Side{0, 0.0};
      derivative = partials.front().second;
      const double slope = at(derivative, after_);
      if (!std::isfinite(slope)) return std::nullopt;
      if (slope == 0.0) continue;
      const double hidden = std::pow(8.0 * noise * factorial / std::abs(slope), 1.0 / order);
      const double later = after_ + kBeyond * std::max(hidden, kUnit * std::abs(after_));
      const int sign = slope > 0.0 ? 1 : -1;
      if (!(at(derivative, later) * sign >= 0.5 * std::abs(slope))) return std::nullopt;
      if (!(at(guard.expression, later) * sign > 0.0)) return std::nullopt;
      return Side{sign, hidden};
    }
    return std::nullopt;
  }

  const ExprPool& from_;
  SymbolId time_;
  double after_;
  std::vector<double> values_;
  std::optional<ExprPool> pool_;
  std::optional<Translator> copy_;
};

}  // namespace

std::optional<RightLimit> right_limit(const ExprPool& pool, ExprId relation, SymbolId time,
                                      std::span<const double> symbol_values, double after) {
  return Limit(pool, time, symbol_values, after).of(relation);
}

}  // namespace bgsim
