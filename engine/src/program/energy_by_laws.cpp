// The energy of a store whose laws are written, as their work on the straight way between two contents.
#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <vector>

#include "expression/graph.hpp"
#include "expression/time_event.hpp"
#include "program/evaluator_impl.hpp"

namespace bgsim {
namespace {

/// The laws of one store along x = from + s (to - from), 0 <= s <= 1.
class AlongTheWay {
 public:
  AlongTheWay(const Program& program, const LawsOfStore& laws, std::span<const double> symbol_values,
              std::span<const double> from, std::span<const double> to)
      : pool_(program.pool),
        laws_(laws),
        symbol_values_(symbol_values),
        from_(from),
        to_(to),
        nodes_(reachable(pool_, laws.conjugates)),
        position_(positions(nodes_)),
        values_(nodes_.size()) {}

  /// What the store takes up by s.
  double power(double s) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const ExprNode& node = pool_[nodes_[i]];
      if (node.op == Op::constant) {
        values_[i] = node.constant;
      } else if (node.op == Op::symbol) {
        values_[i] = symbol_values_[node.a];
        for (std::size_t k = 0; k < laws_.displacements.size(); ++k)
          if (laws_.displacements[k] == SymbolId(node.a)) values_[i] = from_[k] + s * (to_[k] - from_[k]);
      } else if (is_table(node.op)) {
        values_[i] = apply_table(node.op, pool_.table(TableId(node.b)), value(node.a));
      } else {
        values_[i] = apply(node.op, value(node.a), arity(node.op) > 1 ? value(node.b) : 0.0,
                           arity(node.op) > 2 ? value(node.c) : 0.0);
      }
    }
    double sum = 0.0, sizes = 0.0;
    for (std::size_t k = 0; k < laws_.conjugates.size(); ++k) {
      const double part = value(laws_.conjugates[k].value) * (to_[k] - from_[k]);
      sum += part;
      sizes += std::abs(part);
    }
    most_ = std::max(most_, sizes);
    return sum;
  }

  /// Of the terms that the power has been the sum of.
  [[nodiscard]] double most() const { return most_; }

  /// 0, where the laws may jump on the way, and 1.
  [[nodiscard]] std::vector<double> jumps() const {
    constexpr std::size_t kMost = 1000;
    const auto may_jump = [this](ExprId e) { return is_step(pool_[e].op); };
    if (std::none_of(nodes_.begin(), nodes_.end(), may_jump)) return {0.0, 1.0};
    ExprPool pool = pool_;
    std::vector<double> values(symbol_values_.begin(), symbol_values_.end());
    const SymbolId s(values.size());
    values.push_back(0.0);
    std::unordered_map<SymbolId, ExprId> way;
    for (std::size_t k = 0; k < laws_.displacements.size(); ++k)
      way[laws_.displacements[k]] =
          pool.add(pool.constant(from_[k]), pool.mul(pool.symbol(s), pool.constant(to_[k] - from_[k])));
    std::vector<double> all{0.0, 1.0};
    for (const ExprId e : nodes_) {
      const ExprNode node = pool[e];  // a copy: the pool grows
      if (!is_step(node.op)) continue;
      const ExprId turns = node.op == Op::mod ? pool.make(Op::floor, pool.div(ExprId(node.a), ExprId(node.b))) : e;
      const ExprId step = substitute(pool, turns, way);
      if (pool.is_constant(step)) continue;
      RelationOfTime relation(pool, step, s, values);
      for (auto at = relation.next_change(0.0, 1.0); at && all.size() < kMost; at = relation.next_change(*at, 1.0))
        all.push_back(*at);
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }

 private:
  static bool is_step(Op op) {
    return is_comparison(op) || op == Op::sign || op == Op::step || is_rounding(op) || op == Op::mod;
  }
  [[nodiscard]] double value(std::uint32_t e) const { return values_[*position_.find(ExprId(e))]; }

  const ExprPool& pool_;
  const LawsOfStore& laws_;
  std::span<const double> symbol_values_, from_, to_;
  std::vector<ExprId> nodes_;
  IdMap<std::uint32_t> position_;
  std::vector<double> values_;
  double most_ = 0.0;
};

}  // namespace

double Evaluator::energy_by_laws(std::size_t part, std::span<const double> from, std::span<const double> to) const {
  const Program& program = impl_->program;
  const LawsOfStore& laws = program.store_laws[part];
  if (laws.conjugates.empty()) return std::numeric_limits<double>::quiet_NaN();
  AlongTheWay way(program, laws, impl_->symbol_values, from, to);
  constexpr unsigned kDeepest = 12, kDeepEnough = 4;
  constexpr double kTolerance = 1e-13, kNoLess = 0.25;
  const auto power = [&way](double s) { return way.power(s); };
  const auto integral = [&](double begin, double end, unsigned deepest, double& off) {
    return boost::math::quadrature::gauss_kronrod<double, 31>::integrate(power, begin, end, deepest, kTolerance, &off);
  };
  double first = 0.0;
  const double whole = integral(0.0, 1.0, 0, first);
  if (first <= kTolerance * way.most()) return whole;
  const std::vector<double> jumps = way.jumps();
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < jumps.size(); ++i) {
    const bool is_whole = jumps.size() == 2;
    double alone = first, error = 0.0;
    double piece = is_whole ? whole : integral(jumps[i], jumps[i + 1], 0, alone);
    if (alone > kTolerance * way.most()) {
      // Of coupled windings nothing but rounding may be left, which shorter parts do not make less.
      piece = integral(jumps[i], jumps[i + 1], kDeepEnough, error);
      if (!(error > kNoLess * alone)) piece = integral(jumps[i], jumps[i + 1], kDeepest, error);
    }
    sum += piece;
  }
  return sum;
}

}  // namespace bgsim
