#include "equations/borders.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "expression/graph.hpp"
#include "expression/interval.hpp"
#include "graph/with_signals.hpp"

namespace bgsim {

namespace {

constexpr int kPoints = 8;           ///< on each border, if they are found
constexpr int kTrials = 64;          ///< to find them
constexpr double kDifferent = 1e-5;  ///< of the magnitude near the border; a square root there differs by less

bool decides(const ExprPool& pool, const ExprNode& node) {
  return is_comparison(node.op) || node.op == Op::sign || node.op == Op::step || is_rounding(node.op) ||
         node.op == Op::mod || jumps_at_knots(pool, node);
}

/// An expression and all that its unknowns are computed from, evaluated at points of choice.
class Borders {
 public:
  Borders(const Model& model, const EquationSystem& system, ExprId root) : system_(system), pool_(system.pool) {
    std::vector<bool> known(pool_.size(), false);
    nodes_ = in_order(pool_, root, known, [this](ExprId e) { return behind(e); });
    position_ = positions(nodes_);
    values_.resize(nodes_.size());
    set_parameters(model);
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      if (!pool_.is_symbol(nodes_[i])) continue;
      const SystemSymbol& symbol = system_.symbols[pool_.symbol_of(nodes_[i]).index()];
      if (symbol.kind == SystemSymbol::Kind::parameter) continue;
      const ExprId expression = behind(nodes_[i]);
      const bool computed = expression.valid() && *position_.find(expression) < i;
      if (computed) continue;
      free_.push_back(i);
      loop_ = loop_ || symbol.kind == SystemSymbol::Kind::unknown;
    }
    for (const ExprId e : reachable(pool_, {&root, 1}))
      if (decides(pool_, pool_[e])) relations_.push_back(*position_.find(e));
  }

  /// Whether both sides of some border differ at all its points that were found.
  [[nodiscard]] bool differ_everywhere() {
    if (loop_ || free_.empty()) return false;
    return std::any_of(relations_.begin(), relations_.end(), [this](std::uint32_t relation) {
      int found = 0, different = 0;
      for (int trial = 0; trial < kTrials && found < kPoints; ++trial) {
        const auto differs = look(relation, free_[static_cast<std::size_t>(trial) % free_.size()]);
        if (!differs) continue;
        ++found;
        different += *differs ? 1 : 0;
      }
      return found > 0 && different == found;
    });
  }

 private:
  /// What an unknown is computed from; none for others, and for those that only a loop gives.
  [[nodiscard]] ExprId behind(ExprId e) const {
    const SystemSymbol& symbol = system_.symbols[pool_.symbol_of(e).index()];
    if (symbol.kind != SystemSymbol::Kind::unknown || system_.equations[symbol.index].implicit) return {};
    return system_.equations[symbol.index].expression;
  }

  void set_parameters(const Model& model) {
    parameters_.assign(model.parameters.size(), 1.0);
    try {
      const RunInputs inputs = prepare_scene(model, "");
      parameters_ = inputs.parameters;
      start_ = inputs.start;
      stop_ = inputs.stop;
    } catch (const ModelError&) {  // there is no scene, or it is at fault: said where it is run
    }
  }

  /// With the free symbols' values in place. The root's value.
  double evaluate() {
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      const ExprNode& node = pool_[nodes_[i]];
      if (node.op == Op::constant) {
        values_[i] = node.constant;
      } else if (node.op == Op::symbol) {
        const SystemSymbol& symbol = system_.symbols[node.a];
        if (symbol.kind == SystemSymbol::Kind::parameter)
          values_[i] = parameters_[symbol.index];
        else if (!std::binary_search(free_.begin(), free_.end(), i))
          values_[i] = values_[*position_.find(behind(nodes_[i]))];
      } else {
        std::array<double, 3> x{};
        std::size_t n = 0;
        for_each_argument(node, [&](ExprId a) { x[n++] = values_[*position_.find(a)]; });
        values_[i] =
            is_table(node.op) ? apply_table(node.op, *pool_.tables()[node.b], x[0]) : apply(node.op, x[0], x[1], x[2]);
      }
    }
    return values_.back();
  }

  double evaluate_at(std::uint32_t variable, double value) {
    values_[variable] = value;
    return evaluate();
  }

  /// What changes where the border is crossed.
  [[nodiscard]] double side(std::uint32_t relation) const {
    const ExprNode& node = pool_[nodes_[relation]];
    const double a = values_[*position_.find(ExprId(node.a))];
    if (node.op == Op::mod) return std::floor(a / values_[*position_.find(ExprId(node.b))]);
    if (is_table(node.op)) return static_cast<double>(nearest_cell(*pool_.tables()[node.b], a));
    return values_[relation];
  }

  [[nodiscard]] bool is_time(std::uint32_t variable) const {
    return system_.symbols[pool_.symbol_of(nodes_[variable]).index()].kind == SystemSymbol::Kind::time;
  }

  double chance(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11U) * 0x1.0p-53;
  }
  double any_value(std::uint32_t variable) {
    if (is_time(variable) && chance(0.0, 1.0) < 0.7) return chance(start_, stop_);
    const double anywhere = std::pow(10.0, chance(-3.0, 3.0)) * (chance(-1.0, 1.0) < 0.0 ? -1.0 : 1.0);
    return is_time(variable) ? start_ + (stop_ - start_) * anywhere : anywhere;
  }

  /// Crosses a border along one variable, the others being anywhere; none if there is none on the way.
  std::optional<bool> look(std::uint32_t relation, std::uint32_t variable) {
    for (const std::uint32_t other : free_) values_[other] = any_value(other);
    std::vector<double> grid;
    constexpr int kGrid = 48;
    for (int i = 0; i < kGrid; ++i) grid.push_back(any_value(variable));
    std::sort(grid.begin(), grid.end());
    double last = std::numeric_limits<double>::quiet_NaN(), low = 0.0, magnitude = 0.0;
    for (const double at : grid) {
      const double value = evaluate_at(variable, at), now = side(relation);
      if (!std::isfinite(value) || std::isnan(now)) {
        last = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      if (!std::isnan(last) && now != last) return differs(relation, variable, low, at, magnitude + std::abs(value));
      last = now;
      low = at;
      magnitude = std::abs(value);
    }
    return std::nullopt;
  }

  /// @param low, high  values of the variable on the two sides of one border or more.
  std::optional<bool> differs(std::uint32_t relation, std::uint32_t variable, double low, double high,
                              double magnitude) {
    constexpr int kHalvings = 2000;
    evaluate_at(variable, low);
    const double below = side(relation);
    for (int i = 0; i < kHalvings && std::nextafter(low, high) < high; ++i) {
      const double middle = low + (high - low) / 2;
      if (!(middle > low && middle < high)) break;
      evaluate_at(variable, middle);
      (side(relation) == below ? low : high) = middle;
    }
    // Exactly at the border a quotient may be 0/0: a little beside it then.
    const auto beside = [&](double at, double towards) {
      double value = evaluate_at(variable, at);
      for (int i = 0; i < 40 && !std::isfinite(value); ++i)
        value = evaluate_at(variable, at = std::nextafter(at, towards));
      return value;
    };
    constexpr double kFar = std::numeric_limits<double>::infinity();
    const double one = beside(low, -kFar), two = beside(high, kFar);
    if (!std::isfinite(one) || !std::isfinite(two)) return std::nullopt;
    return std::abs(two - one) > kDifferent * std::max({magnitude, std::abs(one), std::abs(two)});
  }

  const EquationSystem& system_;
  const ExprPool& pool_;
  std::vector<ExprId> nodes_;
  IdMap<std::uint32_t> position_;
  std::vector<double> values_, parameters_;
  std::vector<std::uint32_t> free_, relations_;  ///< positions
  bool loop_ = false;                            ///< something free is none of the model's states
  double start_ = 0.0, stop_ = 1.0;
  std::mt19937_64 random_{20261122};
};

/// Whether something that @p root is computed from is given by a loop alone, or not yet. A search in depth finds that
/// soon where there is one; what is computed from all of a long chain is looked through once a law.
bool needs_a_loop(const EquationSystem& system, ExprId root) {
  std::vector<bool> seen(system.pool.size(), false);
  std::vector<ExprId> left{root};
  while (!left.empty()) {
    const ExprId e = left.back();
    left.pop_back();
    if (seen[e.index()]) continue;
    seen[e.index()] = true;
    for_each_argument(system.pool[e], [&](ExprId a) { left.push_back(a); });
    if (!system.pool.is_symbol(e)) continue;
    const SystemSymbol& symbol = system.symbols[system.pool.symbol_of(e).index()];
    if (symbol.kind != SystemSymbol::Kind::unknown) continue;
    const Equation& equation = system.equations[symbol.index];
    if (equation.implicit || !equation.expression.valid()) return true;
    left.push_back(equation.expression);
  }
  return false;
}

}  // namespace

bool certainly_jumps(const Model& model, const EquationSystem& system, ExprId expression) {
  const std::vector<ExprId> nodes = reachable(system.pool, {&expression, 1});
  const auto slope = [&](ExprId e) { return jumps_at_knots(system.pool, system.pool[e]); };
  if (std::any_of(nodes.begin(), nodes.end(), slope)) return true;
  return !needs_a_loop(system, expression) && Borders(model, system, expression).differ_everywhere();
}

}  // namespace bgsim
