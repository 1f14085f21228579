#include "equations/random_point.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/lu.hpp"

namespace bgsim {

namespace {

enum class Visit : std::uint8_t { no, looked_for, yes };

/// Random values are of magnitude 1, so what is left of terms that cancel is rounding.
bool nothing(double value, double size) { return std::abs(value) <= 1e-9 * size; }

/// Between 0.5 and 2, the same each time. (splitmix64)
double number(std::size_t index, std::uint64_t which) {
  std::uint64_t z = 0x9e3779b97f4a7c15U * (8 * index + which + 1);
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  z ^= z >> 31U;
  return 0.5 + 1.5 * static_cast<double>(z >> 11U) * 0x1p-53;
}

}  // namespace

RandomPoint::RandomPoint(const EquationSystem& system, const std::vector<SymbolId>& indefinite)
    : system_(system), at_(system.pool.size()), indefinite_(system.symbols.size(), false) {
  for (const SymbolId symbol : indefinite) indefinite_[symbol.index()] = true;
  find_reaching();
  for (std::size_t i = 0; i < at_.size(); ++i) guess_.push_back(number(i, 0));
  guess_slope_.assign(at_.size(), 0.0);
  evaluate_all();
  solve_rings(&Point::value, guess_);
  solve_rings(&Point::slope, guess_slope_);
  if (slopes_agree()) return;
  for (std::size_t i = 0; i < at_.size(); ++i) guess_slope_[i] = reaches_[i] ? number(i, 1) : 0.0;
  evaluate_all();
}

bool RandomPoint::is_zero(SymbolId unknown) const {
  const Point& point = at_[system_.equations[system_.symbols[unknown.index()].index].expression.index()];
  return nothing(point.value, point.size);
}

bool RandomPoint::depends(ExprId e) const {
  if (!e.valid()) return false;
  const Point& point = at_[e.index()];
  return !nothing(point.slope, point.slope_size);
}

/// Expressions that a chain of arguments leads from to something indefinite.
void RandomPoint::find_reaching() {
  reaches_.assign(system_.pool.size(), false);
  std::vector<std::vector<ExprId>> users(system_.pool.size());
  std::vector<ExprId> open;
  for (std::size_t i = 0; i < system_.pool.size(); ++i) {
    const ExprId e(i);
    for (const ExprId argument : arguments(e)) users[argument.index()].push_back(e);
    const ExprNode& node = system_.pool[e];
    if (is_indefinite(node)) open.push_back(e);
  }
  while (!open.empty()) {
    const ExprId e = open.back();
    open.pop_back();
    if (reaches_[e.index()]) continue;
    reaches_[e.index()] = true;
    open.insert(open.end(), users[e.index()].begin(), users[e.index()].end());
  }
}

/// Rings that ask for more than kMost values keep what they have.
void RandomPoint::solve_rings(double Point::*what, std::vector<double>& guess) {
  constexpr std::size_t kMost = 60;
  if (asked_.empty() || asked_.size() > kMost) return;
  const auto n = static_cast<Eigen::Index>(asked_.size());
  const auto at = [this](Eigen::Index i) { return asked_[static_cast<std::size_t>(i)].index(); };
  const auto differences = [&] {
    Eigen::VectorXd off(n);
    for (Eigen::Index i = 0; i < n; ++i) off[i] = at_[at(i)].*what - guess[at(i)];
    return off;
  };
  const Eigen::VectorXd off = differences();
  Eigen::MatrixXd slopes(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const double before = std::exchange(guess[at(j)], guess[at(j)] + 1.0);
    evaluate_all();
    slopes.col(j) = differences() - off;
    guess[at(j)] = before;
  }
  const Eigen::VectorXd step = solve_with_full_pivots(slopes, -off);
  if (step.allFinite())
    for (Eigen::Index i = 0; i < n; ++i) guess[at(i)] += step[i];
  evaluate_all();
}

bool RandomPoint::slopes_agree() const {
  return std::all_of(asked_.begin(), asked_.end(), [this](ExprId e) {
    const double taken = guess_slope_[e.index()];
    return nothing(at_[e.index()].slope - taken, at_[e.index()].slope_size + std::abs(taken));
  });
}

/// With guess_ and guess_slope_ for what rings ask for before it is known (asked_).
void RandomPoint::evaluate_all() {
  std::vector<Visit> known(at_.size(), Visit::no);
  std::vector<ExprId> open;
  asked_.clear();
  for (std::size_t root = 0; root < at_.size(); ++root) {
    open.emplace_back(root);
    while (!open.empty()) {
      const ExprId e = open.back();
      Visit& here = known[e.index()];
      if (here == Visit::no) {
        here = Visit::looked_for;
        const double value = guess_[e.index()], slope = guess_slope_[e.index()];
        at_[e.index()] = {value, slope, std::abs(value), std::abs(slope)};
        for (const ExprId argument : arguments(e)) {
          if (known[argument.index()] == Visit::no) open.push_back(argument);
          if (known[argument.index()] == Visit::looked_for) asked_.push_back(argument);
        }
        continue;
      }
      open.pop_back();
      if (here == Visit::yes) continue;
      at_[e.index()] = evaluated(e);
      here = Visit::yes;
    }
  }
  std::sort(asked_.begin(), asked_.end(), [](ExprId a, ExprId b) { return a.index() < b.index(); });
  asked_.erase(std::unique(asked_.begin(), asked_.end()), asked_.end());
}

bool RandomPoint::is_indefinite(const ExprNode& node) const {
  return node.op == Op::symbol && node.a < indefinite_.size() && indefinite_[node.a];
}

/// None of symbols that are not the system's: what searches try an unknown with (loop_roots) stays in the pool.
const Equation* RandomPoint::equation(const ExprNode& node) const {
  if (node.a >= system_.symbols.size()) return nullptr;
  const SystemSymbol& symbol = system_.symbols[node.a];
  return symbol.kind == SystemSymbol::Kind::unknown ? &system_.equations[symbol.index] : nullptr;
}

std::vector<ExprId> RandomPoint::arguments(ExprId e) const {
  const ExprNode& node = system_.pool[e];
  if (node.op == Op::symbol) {
    const Equation* const defines = equation(node);
    return defines == nullptr ? std::vector<ExprId>{} : std::vector{defines->expression};
  }
  const std::array children{node.a, node.b, node.c};
  std::vector<ExprId> result;
  for (int k = 0; k < arity(node.op); ++k) result.emplace_back(children[static_cast<std::size_t>(k)]);
  return result;
}

RandomPoint::Point RandomPoint::evaluated(ExprId e) const {
  const ExprNode& node = system_.pool[e];
  const Point zero;
  const Point& a = arity(node.op) > 0 ? at_[node.a] : zero;
  const Point& b = arity(node.op) > 1 ? at_[node.b] : zero;
  switch (node.op) {
    case Op::constant:
      return {node.constant, 0.0, std::abs(node.constant), 0.0};
    case Op::symbol: {
      if (is_indefinite(node)) return {number(e.index(), 0), number(e.index(), 1), 1.0, 1.0};
      const Equation* const defines = equation(node);
      return defines != nullptr && !defines->implicit ? at_[defines->expression.index()] : anything(e);
    }
    case Op::neg:
      return {-a.value, -a.slope, a.size, a.slope_size};
    case Op::add:
      return {a.value + b.value, a.slope + b.slope, a.size + b.size, a.slope_size + b.slope_size};
    case Op::sub:
      return {a.value - b.value, a.slope - b.slope, a.size + b.size, a.slope_size + b.slope_size};
    case Op::mul:
      return {a.value * b.value, a.slope * b.value + a.value * b.slope, a.size * b.size,
              a.slope_size * b.size + a.size * b.slope_size};
    case Op::div: {
      if (nothing(b.value, b.size)) return anything(e);
      const double by = std::abs(b.value);
      return {a.value / b.value, (a.slope - a.value * b.slope / b.value) / b.value, a.size / by,
              (a.slope_size + a.size * b.slope_size / by) / by};
    }
    default:
      return anything(e);
  }
}

/// A value of its own, with a random slope by each argument.
RandomPoint::Point RandomPoint::anything(ExprId e) const {
  Point point{number(e.index(), 0), 0.0, 1.0, 0.0};
  std::uint64_t which = 2;
  for (const ExprId argument : arguments(e)) {
    const Point& other = at_[argument.index()];
    const double by = number(e.index(), which++);
    if (nothing(other.slope, other.slope_size)) continue;
    point.slope += by * other.slope;
    point.slope_size += by * other.slope_size;
  }
  return point;
}

}  // namespace bgsim
