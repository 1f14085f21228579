#include "linear/rate_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "base/lu.hpp"
#include "expression/graph.hpp"

namespace bgsim {
namespace {

/// Slopes of functions are those over this part of their arguments' sizes.
constexpr double kOfArgument = 0x1.0p-20;
/// Loops of more variables take their variables' sizes from one equation each.
constexpr std::size_t kMostInverted = 400;
/// A loop of which a slope is this much smaller than the terms of its slopes is near a pole of its variables.
constexpr double kPole = 1e-6;

double finite_or(double value, double other) { return std::isfinite(value) ? value : other; }

}  // namespace

RateTerms::RateTerms(const Model& model, const BondGraph& graph, const EquationSystem& system, const BlockOrder& order,
                     std::span<const double> parameters, double t)
    : pool_(order.pool), rates_(order.rates), symbols_(system.symbols.size()) {
  set_symbol(system.time, t, std::abs(t));
  for (std::size_t i = 0; i < parameters.size(); ++i)
    set_symbol(system.parameters[i], parameters[i], std::abs(parameters[i]));
  std::unordered_map<SymbolId, std::size_t> column;
  for (const State& state : system.states) {
    column[state.symbol] = states_.size();
    states_.push_back(state.symbol);
  }
  for (const DependentStore& store : system.dependent) {
    const PortId port = graph.port(store.element, store.port);
    const std::size_t bond = graph[port].bond.index();
    const bool charge = stores_displacement(model.elements[store.element.index()], store.port);
    const SymbolId rate = charge ? system.flows[bond] : system.efforts[bond];
    // Flows are counted along the half-arrow.
    dependent_.push_back(
        {order.resolved[store.symbol.index()], order.resolved[rate.index()], charge && !graph[port].head ? -1.0 : 1.0});
  }
  std::size_t tears = 0;
  for (const Block& block : order.blocks) tears += block.tears.size();
  column[system.time] = states_.size() + tears;
  const auto wanted = [&](SymbolId s) { return column.contains(s); };
  for (const Block& block : order.blocks) {
    Loop loop{tears_.size(), block.tears.size(), block.linear, block.residuals, {}, {}};
    const std::size_t first = states_.size() + loop.first;
    for (const SymbolId tear : block.tears) {
      column[tear] = states_.size() + tears_.size();
      tears_.push_back(tear);
    }
    const auto own = [&](SymbolId s) { return s != system.time && column.contains(s) && column.at(s) >= first; };
    for (std::size_t row = 0; row < block.residuals.size(); ++row)
      for (const auto& [symbol, slope] : dependent_.empty() ? gradient(pool_, block.residuals[row], own)
                                                            : gradient(pool_, block.residuals[row], wanted))
        if (own(symbol))
          loop.own.push_back({row, column.at(symbol) - first, slope});
        else
          loop.others.push_back({row, column.at(symbol), slope});
    loops_.push_back(std::move(loop));
  }
  for (std::size_t row = 0; row < dependent_.size(); ++row)
    for (const auto& [symbol, slope] : gradient(pool_, dependent_[row].stored, wanted))
      by_columns_.push_back({row, column.at(symbol), slope});
  known_.resize(pool_.size());
  known_since_.assign(pool_.size(), 0);
}

void RateTerms::set_symbol(SymbolId symbol, double value, double size) { symbols_[symbol.index()] = {value, size}; }

RateTerms::Sized RateTerms::computed(const ExprNode& node) const {
  if (node.op == Op::constant) return {node.constant, std::abs(node.constant)};
  if (node.op == Op::symbol) return symbols_[node.a];
  const int count = arity(node.op);
  const Sized a = known_[node.a], b = count > 1 ? known_[node.b] : Sized{}, c = count > 2 ? known_[node.c] : Sized{};
  const bool table = is_table(node.op);
  const auto value = [&](double x, double y) {
    return table ? apply_table(node.op, pool_.table(TableId(node.b)), x) : apply(node.op, x, y, c.value);
  };
  Sized result{value(a.value, b.value), 0.0};
  const double least = std::abs(result.value);
  switch (node.op) {
    case Op::neg:
    case Op::abs:
      result.size = a.size;
      break;
    case Op::add:
    case Op::sub:
      result.size = a.size + b.size;
      break;
    case Op::mul:
      result.size = a.size * std::abs(b.value) + std::abs(a.value) * b.size;
      break;
    case Op::div:
      // Zero where its numerator is: what its denominator is the difference of is large at a pole, where nothing rests.
      result.size = a.size / std::abs(b.value);
      break;
    case Op::select:
      result.size = a.value != 0.0 ? b.size : c.size;
      break;
    case Op::min:
    case Op::max:
      result.size = result.value == a.value ? a.size : b.size;
      break;
    default: {
      // Steps have no slope, and jumps are none.
      if (node.op == Op::sign || node.op == Op::step || is_rounding(node.op) || node.op == Op::mod ||
          is_logical(node.op) || node.op == Op::der)
        break;
      // Of an angle its part of a turn matters: the law of 1e15 rad is still of size 1.
      const bool angle = node.op == Op::sin || node.op == Op::cos || node.op == Op::tan;
      for (const double sign : {1.0, -1.0}) {
        const double h = sign * kOfArgument, da = h * (angle ? std::min(a.size, std::numbers::pi) : a.size);
        const double moved =
            std::abs(value(a.value + da, b.value) - result.value) +
            (count > 1 && !table ? std::abs(value(a.value, b.value + h * b.size) - result.value) : 0.0);
        result.size = std::max(result.size, finite_or(moved / kOfArgument, 0.0));
      }
    }
  }
  result.size = std::max(finite_or(result.size, 0.0), finite_or(least, 0.0));
  return result;
}

RateTerms::Sized RateTerms::at(ExprId root) {
  arguments_first(
      pool_, root, [this](ExprId e) { return known_since_[e.index()] == now_; },
      [this](ExprId e) {
        known_[e.index()] = computed(pool_[e]);
        known_since_[e.index()] = now_;
      });
  return known_[root.index()];
}

void RateTerms::set(const Eigen::VectorXd& x, std::span<const double> tears) {
  x_ = x;
  z_.assign(tears.begin(), tears.end());
}

Eigen::MatrixXd RateTerms::own_slopes(const Loop& loop, bool sizes) {
  const auto count = static_cast<Eigen::Index>(loop.count);
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(count, count);
  for (const Partial& partial : loop.own) {
    const Sized slope = at(partial.slope);
    slopes(static_cast<Eigen::Index>(partial.row), static_cast<Eigen::Index>(partial.column)) =
        sizes ? slope.size : slope.value;
  }
  return slopes;
}

/// What the terms of a loop's equations can make its variables, which count in these themselves as they are.
void RateTerms::size_loop(const Loop& loop) {
  const auto count = static_cast<Eigen::Index>(loop.count);
  const auto own = [&](Eigen::Index j) { return std::abs(z_[loop.first + static_cast<std::size_t>(j)]); };
  const auto terms_now = [&] {
    Eigen::VectorXd terms(count);
    for (Eigen::Index k = 0; k < count; ++k) terms(k) = at(loop.residuals[static_cast<std::size_t>(k)]).size;
    return terms;
  };
  const auto take = [&](const Eigen::VectorXd& made) {
    for (Eigen::Index j = 0; j < count; ++j) {
      const std::size_t i = loop.first + static_cast<std::size_t>(j);
      set_symbol(tears_[i], z_[i], std::max(own(j), finite_or(made(j), 0.0)));
    }
    ++now_;
  };
  const Eigen::MatrixXd slope_sizes = own_slopes(loop, true);
  Eigen::VectorXd made = Eigen::VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  bool singular = true;
  if (loop.count <= kMostInverted) {
    // Rows, then columns, of like size, by what the slopes are made of.
    const auto scale_of = [](const auto& most) {
      return Eigen::VectorXd(most.unaryExpr([](double m) { return m > 0.0 ? 1.0 / m : 1.0; }));
    };
    const Eigen::VectorXd row = scale_of(Eigen::VectorXd(slope_sizes.rowwise().maxCoeff()));
    const Eigen::VectorXd column =
        scale_of(Eigen::VectorXd((row.asDiagonal() * slope_sizes).colwise().maxCoeff().transpose()));
    const DenseLu lu(row.asDiagonal() * own_slopes(loop, false) * column.asDiagonal());
    const Eigen::MatrixXd inverse = lu.solve(Eigen::MatrixXd::Identity(count, count));
    if (inverse.allFinite()) {
      singular = inverse.cwiseAbs().maxCoeff() > 1.0 / kPole;
      made = column.asDiagonal() * (inverse.cwiseAbs() * row.cwiseProduct(terms_now()));
    }
  }
  if (loop.linear && !singular) {
    take(made);
    return;
  }
  // A loop of nonlinear laws is singular at a fold, and its inverse says nothing there, nor at a pole: its slopes are
  // small as the differences of terms, by which no variable is larger than one equation makes it. One that
  // is equal to another takes the size of that one in the next pass.
  constexpr int kPasses = 3;
  for (int pass = 0; pass < kPasses; ++pass) {
    const Eigen::VectorXd terms = terms_now();
    Eigen::VectorXd most = Eigen::VectorXd::Zero(count);
    for (Eigen::Index j = 0; j < count; ++j)
      for (Eigen::Index k = 0; k < count; ++k)
        if (slope_sizes(k, j) > 0.0) most(j) = std::max(most(j), terms(k) / slope_sizes(k, j));
    take(made.cwiseMin(most));
  }
}

Eigen::VectorXd RateTerms::of_rates(const Eigen::VectorXd& sizes) {
  sizes_ = sizes;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    set_symbol(states_[i], x_(k), sizes(k));
  }
  for (std::size_t i = 0; i < z_.size(); ++i) set_symbol(tears_[i], z_[i], std::abs(z_[i]));
  ++now_;
  for (const Loop& loop : loops_) size_loop(loop);
  Eigen::VectorXd terms(x_.size());
  for (Eigen::Index i = 0; i < x_.size(); ++i) terms(i) = at(rates_[static_cast<std::size_t>(i)]).size;
  return terms;
}

/// The loops' variables follow what moves: M z' = -(r_x x' + r_z z' + r_t), loop by loop.
void RateTerms::follow(std::vector<double>& moves) {
  for (const Loop& loop : loops_) {
    Eigen::VectorXd right = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(loop.count));
    for (const Partial& partial : loop.others)
      if (moves[partial.column] != 0.0)
        right(static_cast<Eigen::Index>(partial.row)) -= at(partial.slope).value * moves[partial.column];
    if (right.isZero(0.0)) continue;
    const Eigen::MatrixXd solved = DenseLu(own_slopes(loop, false)).solve(right);
    std::copy_n(solved.data(), loop.count, moves.begin() + static_cast<std::ptrdiff_t>(states_.size() + loop.first));
  }
}

std::vector<double> RateTerms::laws_follow(const std::vector<double>& moves) {
  std::vector<double> rates(dependent_.size(), 0.0);
  for (const Partial& partial : by_columns_)
    if (moves[partial.column] != 0.0) rates[partial.row] += at(partial.slope).value * moves[partial.column];
  return rates;
}

std::vector<double> RateTerms::dependents(const Eigen::VectorXd& rates, const Eigen::VectorXd& terms) {
  dependent_rates_.assign(dependent_.size(), 0.0);
  std::vector<double> relative(dependent_.size(), 0.0);
  if (dependent_.empty()) return relative;
  const std::size_t n = states_.size(), m = z_.size();
  std::vector<double> moves(n + m + 1, 0.0), in_time = moves;
  std::copy(rates.data(), rates.data() + rates.size(), moves.begin());
  in_time.back() = 1.0;
  follow(moves);
  follow(in_time);
  const std::vector<double> by_states = laws_follow(moves), by_time = laws_follow(in_time);
  // What would be fast: as the terms of the states' rates would move these for their size, in 1/s.
  double pace = 0.0;
  for (Eigen::Index i = 0; i < terms.size(); ++i)
    if (sizes_(i) > 0.0) pace = std::max(pace, terms(i) / sizes_(i));
  for (std::size_t i = 0; i < dependent_.size(); ++i) {
    const Dependent& store = dependent_[i];
    const bool held = by_time[i] != 0.0 || !store.rate.valid();
    const Sized rate = held ? Sized{by_states[i], pace * at(store.stored).size} : at(store.rate);
    dependent_rates_[i] = held ? rate.value : store.sign * rate.value;
    if (rate.value == 0.0) continue;
    relative[i] = std::abs(rate.value) / rate.size;
    if (!std::isfinite(relative[i])) relative[i] = std::numeric_limits<double>::infinity();
  }
  return relative;
}

}  // namespace bgsim
