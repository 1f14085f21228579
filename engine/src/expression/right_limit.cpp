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

}  // namespace

struct RightLimits::Limit {
 public:
  Limit(const ExprPool& from, ExprId relation, SymbolId time, std::span<const double> symbol_values)
      : from_(from),
        time_(time),
        values_(symbol_values.begin(), symbol_values.end()),
        nodes_(reachable(from, {&relation, 1})) {
    if (values_.size() <= time.index()) values_.resize(time.index() + 1, 0.0);
    const IdMap<std::uint32_t> position = positions(nodes_);
    depends_ = depends_on(from_, nodes_, position, [this](SymbolId s) { return s == time_; });
    for (const ExprId e : nodes_) {
      const ExprNode& node = from_[e];
      // measured data have no derivatives of higher order
      tables_ = tables_ || is_table(node.op);
      std::array<std::uint32_t, 3>& places = arguments_.emplace_back();
      std::size_t n = 0;
      for_each_argument(node, [&](ExprId a) { places[n++] = *position.find(a); });
      count_.push_back(n);
    }
    now_.resize(nodes_.size());
    next_.resize(nodes_.size());
    continued_.resize(nodes_.size());
  }

  /// The next change after an instant and the value just after it are asked for one after the other.
  std::optional<RightLimit> at(double after) {
    if (after_ != after) latest_ = found_at(after);
    return latest_;
  }

 private:
  std::optional<RightLimit> found_at(double after) {
    after_ = after;
    if (tables_ || !hides()) return std::nullopt;
    pool_.emplace();
    std::vector<double>& limit = now_;
    RightLimit result;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const ExprNode& node = from_[nodes_[i]];
      const std::array<double, 3> x = arguments(i, limit);
      limit[i] = value_at(nodes_[i], node, x);
      if (depends_[i] != 0 && at_border(node.op, x[0], x[1])) {
        const auto side = side_of(i, x);
        if (!side) return std::nullopt;
        result.hidden = std::max(result.hidden, side->hidden);
        limit[i] = beyond(node.op, x, side->sign);
      }
      continued_[i] = continued(i, x, limit[i]);
    }
    result.value = limit.back();
    return std::isnan(result.value) ? std::nullopt : std::optional(result);
  }

  /// Whether something is exactly at its border at the instant and at the next double, too.
  [[nodiscard]] bool hides() {
    bool found = false;
    const double following = std::nextafter(after_, std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const ExprNode& node = from_[nodes_[i]];
      const std::array<double, 3> x = arguments(i, now_), y = arguments(i, next_);
      values_[time_.index()] = following;
      next_[i] = value_at(nodes_[i], node, y);
      values_[time_.index()] = after_;
      now_[i] = value_at(nodes_[i], node, x);
      found = found || (depends_[i] != 0 && at_border(node.op, x[0], x[1]) && at_border(node.op, y[0], y[1]));
    }
    return found;
  }

  [[nodiscard]] std::array<double, 3> arguments(std::size_t node, const std::vector<double>& values) const {
    std::array<double, 3> x{};
    for (std::size_t k = 0; k < count_[node]; ++k) x[k] = values[arguments_[node][k]];
    return x;
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

  /// What goes on as it is just after the instant: a step function is what it is there, and a sawtooth is its line.
  /// What they jump by at their own borders is no rounding of what follows from them: floor(mod(3*t, 1.7)).
  ExprId continued(std::size_t i, const std::array<double, 3>& x, double limit) {
    const ExprNode& node = from_[nodes_[i]];
    const auto argument = [&](std::size_t k) { return continued_[arguments_[i][k]]; };
    if (node.op == Op::constant) return pool_->constant(node.constant);
    if (node.op == Op::symbol) return pool_->symbol(from_.symbol_of(nodes_[i]));
    if (depends_[i] != 0 &&
        (is_comparison(node.op) || node.op == Op::sign || node.op == Op::step || is_rounding(node.op)))
      return pool_->constant(limit);
    if (depends_[i] != 0 && node.op == Op::mod)
      return pool_->sub(argument(0), pool_->mul(pool_->constant(std::round((x[0] - limit) / x[1])), argument(1)));
    return rebuilt(*pool_, node, [&](ExprId e) {
      std::size_t k = 0;
      while (nodes_[arguments_[i][k]] != e) ++k;
      return argument(k);
    });
  }

  [[nodiscard]] Guard guard_of(std::size_t i, const std::array<double, 3>& x) {
    const ExprNode& node = from_[nodes_[i]];
    const ExprId a = continued_[arguments_[i][0]];
    if (is_comparison(node.op)) return {pool_->sub(a, continued_[arguments_[i][1]]), std::abs(x[0])};
    if (node.op == Op::mod) {
      const ExprId turns = pool_->div(a, continued_[arguments_[i][1]]);
      return {pool_->sub(turns, pool_->constant(x[0] / x[1])), std::abs(x[0] / x[1])};
    }
    return {pool_->sub(a, pool_->constant(x[0])), std::abs(x[0])};
  }

  /// To which side the guard goes: the sign of its first derivative that is not 0, if that lasts and shows in the
  /// values as soon as rounding lets it. No side if all vanish, as for what is the same on both sides.
  std::optional<Side> side_of(std::size_t i, const std::array<double, 3>& x) {
    constexpr int kHighest = 4;
    constexpr double kBeyond = 8.0;
    const Guard guard = guard_of(i, x);
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
  double after_ = std::numeric_limits<double>::quiet_NaN();
  std::optional<RightLimit> latest_;  ///< at after_
  std::vector<double> values_;
  std::vector<ExprId> nodes_;                            ///< of the relation, arguments first
  std::vector<char> depends_;                            ///< by node: on time
  std::vector<std::array<std::uint32_t, 3>> arguments_;  ///< by node: where they are
  std::vector<std::size_t> count_;                       ///< by node: of arguments
  bool tables_ = false;
  std::vector<double> now_, next_;  ///< by node: at the instant and at the next double
  std::optional<ExprPool> pool_;
  std::vector<ExprId> continued_;  ///< by node, in pool_
};

RightLimits::RightLimits(const ExprPool& pool, ExprId relation, SymbolId time, std::span<const double> symbol_values)
    : limit_(std::make_unique<Limit>(pool, relation, time, symbol_values)) {}
RightLimits::~RightLimits() = default;
RightLimits::RightLimits(RightLimits&&) noexcept = default;

std::optional<RightLimit> RightLimits::at(double after) { return limit_->at(after); }

std::optional<RightLimit> right_limit(const ExprPool& pool, ExprId relation, SymbolId time,
                                      std::span<const double> symbol_values, double after) {
  return RightLimits(pool, relation, time, symbol_values).at(after);
}

}  // namespace bgsim
