// Where what is computed from parameters has no derivative.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "expression/graph.hpp"
#include "linear/variations.hpp"

namespace bgsim {
namespace {

/// Kinks and jumps in what is computed from parameters alone: no event of a run, and without a derivative.
class ParameterKinks {
 public:
  /// @param values  by SymbolId; NaN for what is no parameter
  /// @param moves   by SymbolId: changes with the seed
  ParameterKinks(const Model& model, const Seed& seed, const ExprPool& pool, const std::vector<double>& values,
                 const std::vector<char>& moves)
      : model_(model), seed_(seed), pool_(pool), values_(pool.size()), moves_(pool.size(), 0) {
    for (std::size_t i = 0; i < pool.size(); ++i) {
      const ExprId e(i);
      const ExprNode& node = pool[e];
      double& value = values_[i];
      value = std::numeric_limits<double>::quiet_NaN();
      if (node.op == Op::constant) value = node.constant;
      if (node.op == Op::symbol && node.a < values.size()) {
        value = values[node.a];
        moves_[i] = moves[node.a];
      }
      if (node.op == Op::constant || node.op == Op::symbol || node.op == Op::der) continue;
      for_each_argument(node, [&](ExprId a) { moves_[i] = static_cast<char>(moves_[i] | moves_[a.index()]); });
      const int n = arity(node.op);
      value = is_table(node.op)
                  ? apply_table(node.op, pool.table(TableId(node.b)), values_[node.a])
                  : apply(node.op, values_[node.a], n > 1 ? values_[node.b] : 0.0, n > 2 ? values_[node.c] : 0.0);
    }
  }

  /// @throws ModelError BG414.
  template <class NameOf>
  void look(ExprId root, const NameOf& name_of) const {
    for (const ExprId e : reachable(pool_, {&root, 1})) {
      if (moves_[e.index()] == 0 || !at_kink(e)) continue;
      throw ModelError({diagnostic_of("BG414",
                                      readable_text(pool_, e, name_of) + " has a kink or a jump at this value of " +
                                          in_quotes(short_name(seed_.name)),
                                      {}, "a derivative exists where both sides have the same one",
                                      "ask for it at a value on one side")},
                       model_.sources);
    }
  }

 private:
  [[nodiscard]] bool at_kink(ExprId e) const {
    constexpr double kRoundings = 8.0 * std::numeric_limits<double>::epsilon();
    const ExprNode& node = pool_[e];
    const double a = values_[node.a], b = arity(node.op) > 1 ? values_[node.b] : 0.0;
    if (std::isnan(a) || std::isnan(b)) return false;
    const auto near = [&](double one, double other) {
      return std::abs(one - other) <= kRoundings * std::max(std::abs(one), std::abs(other));
    };
    if (is_comparison(node.op) || node.op == Op::min || node.op == Op::max) return near(a, b);
    if (node.op == Op::abs || node.op == Op::sign || node.op == Op::step) return a == 0.0;
    if (node.op == Op::floor || node.op == Op::ceil) return near(a, std::round(a));
    if (node.op == Op::round) return near(a + 0.5, std::round(a + 0.5));
    if (node.op == Op::mod) return near(a / b, std::round(a / b));
    if (!is_table(node.op) || pool_.table(TableId(node.b)).interpolation != Interpolation::linear) return false;
    const std::vector<double>& knots = pool_.table(TableId(node.b)).x;
    return std::any_of(knots.begin(), knots.end(), [&](double knot) { return near(a, knot); });
  }

  const Model& model_;
  const Seed& seed_;
  const ExprPool& pool_;
  std::vector<double> values_;  ///< by ExprId
  std::vector<char> moves_;
};

}  // namespace

void refuse_kinks(const Model& model, const EquationSystem& system, const BlockOrder& order, std::size_t rates,
                  const std::vector<std::size_t>& outputs, GivenValues& given, const Seed& seed,
                  const RunInputs& inputs) {
  if (!seed.parameter.valid()) return;
  std::vector<char> moves(given.parameters.size(), 0);
  // What depends on the seed, whatever its derivative seems to be.
  moves[seed.parameter.index()] = 1;
  const auto hangs = [&](std::size_t i) {
    for (const SymbolId symbol : symbols_in(given.pool, {&given.parameters[i].value, 1}))
      if (moves[model.symbols[symbol.index()].parameter.index()] != 0) return true;
    return false;
  };
  for (bool more = true; more;) {
    more = false;
    for (std::size_t i = 0; i < moves.size(); ++i)
      if (moves[i] == 0 && hangs(i)) {
        moves[i] = 1;
        more = true;
      }
  }
  const auto look = [&](const ExprPool& pool, std::size_t symbols, const auto& symbol_of, const auto& roots,
                        const auto& name_of) {
    std::vector<double> values(symbols, std::numeric_limits<double>::quiet_NaN());
    std::vector<char> moving(symbols, 0);
    for (std::size_t i = 0; i < moves.size(); ++i) {
      values[symbol_of(i).index()] = inputs.parameters[i];
      moving[symbol_of(i).index()] = moves[i];
    }
    const ParameterKinks kinks(model, seed, pool, values, moving);
    for (const ExprId root : roots) kinks.look(root, name_of);
  };
  std::vector<ExprId> roots;
  for (std::size_t i = 0; i < moves.size(); ++i)
    if (i != seed.parameter.index()) roots.push_back(given.parameters[i].value);
  for (const auto& [key, value] : given.initial) roots.push_back(value.value);
  look(
      given.pool, model.symbols.size(), [&](std::size_t i) { return model.parameters[i].symbol; }, roots,
      [&](SymbolId s) { return symbol_name(model, s); });
  roots.assign(order.rates.begin(), order.rates.begin() + static_cast<std::ptrdiff_t>(rates));
  for (const Block& block : order.blocks) roots.insert(roots.end(), block.residuals.begin(), block.residuals.end());
  for (const std::size_t i : outputs) roots.push_back(order.outputs[i]);
  std::size_t sets = 0;
  for (const EventEquation& event : system.events) sets += event.sets.size();
  roots.insert(roots.end(), order.event_values.begin(), order.event_values.begin() + static_cast<std::ptrdiff_t>(sets));
  roots.insert(roots.end(), order.event_conditions.begin(), order.event_conditions.end());
  look(
      order.pool, system.symbols.size(), [&](std::size_t i) { return system.parameters[i]; }, roots,
      [&](SymbolId s) { return system.symbols[s.index()].name; });
}

}  // namespace bgsim
