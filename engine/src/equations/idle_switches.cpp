#include "equations/idle_switches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/lu.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/ordering.hpp"
#include "equations/solvable_causality.hpp"

namespace bgsim {

namespace {

std::vector<ElementId> plain_switches(const Model& model) {
  std::vector<ElementId> result;
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    if (model.elements[i].switches && is_switch(model.elements[i].kind)) result.emplace_back(i);
  return result;
}

bool is_allowed(const Model& model) {
  try {
    const BondGraph graph = build_bond_graph(model);
    order_equations(model, derive_equations(model, graph, solvable_causality(model, graph), true));
    return true;
  } catch (const ModelError&) {
    return false;
  }
}

/// With the first so many switches only; a resistor, which every graph allows, stands for each of the others.
bool is_allowed(const Model& model, const std::vector<ElementId>& switches, std::size_t first) {
  Model some = model;
  for (std::size_t i = first; i < switches.size(); ++i) {
    Element& element = some.elements[switches[i].index()];
    element.stands_in = mode_holds(element);
    element.kind = ElementKind::resistor;
    element.coefficient = some.pool.constant(1.0);
    element.switches.reset();
  }
  return is_allowed(some);
}

void make_idle(Element& element) {
  const bool closed = is_closed(element);
  element.kind = closed ? ElementKind::open_switch : ElementKind::closed_switch;
  element.idle = true;
}

SymbolId variable_of(const Model& model, const BondGraph& graph, const EquationSystem& system, ElementId id,
                     bool imposed) {
  const bool effort = (imposed_variable(model.elements[id.index()].kind) == Variable::effort) == imposed;
  return (effort ? system.efforts : system.flows)[graph[graph.port(id, 0)].bond.index()];
}

/// Values and slopes of expressions at random values of states, parameters, time and all that is no sum, product or
/// quotient. The slopes are those along a random direction of what is indefinite. What cancels for such values cancels
/// for all. Rings of equations ask for values and slopes before they are known: these are found so that they come out
/// as they were taken, by one step of Newton's method each, since what is linear needs no more. Where slopes do not,
/// all depends on all that it is connected with.
class RandomPoint {
 public:
  RandomPoint(const Model& model, const BondGraph& graph, const EquationSystem& system)
      : system_(system), at_(system.pool.size()), indefinite_(system.symbols.size(), false) {
    for (std::size_t i = 0; i < model.elements.size(); ++i)
      if (model.elements[i].idle) indefinite_[variable_of(model, graph, system, ElementId(i), true).index()] = true;
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

  [[nodiscard]] bool is_zero(SymbolId unknown) const {
    const Point& point = at_[system_.equations[system_.symbols[unknown.index()].index].expression.index()];
    return nothing(point.value, point.size);
  }
  [[nodiscard]] bool depends(ExprId e) const {
    if (!e.valid()) return false;
    const Point& point = at_[e.index()];
    return !nothing(point.slope, point.slope_size);
  }

 private:
  struct Point {
    double value = 0.0, slope = 0.0;
    double size = 0.0, slope_size = 0.0;  ///< sums of the magnitudes of all terms
  };
  enum class State : std::uint8_t { unknown, looked_for, known };

  /// Random values are of magnitude 1, so what is left of terms that cancel is rounding.
  static bool nothing(double value, double size) { return std::abs(value) <= 1e-9 * size; }

  /// Between 0.5 and 2, the same each time. (splitmix64)
  static double number(std::size_t index, std::uint64_t which) {
    std::uint64_t z = 0x9e3779b97f4a7c15U * (8 * index + which + 1);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    z ^= z >> 31U;
    return 0.5 + 1.5 * static_cast<double>(z >> 11U) * 0x1p-53;
  }

  /// Expressions that a chain of arguments leads from to something indefinite.
  void find_reaching() {
    reaches_.assign(system_.pool.size(), false);
    std::vector<std::vector<ExprId>> users(system_.pool.size());
    std::vector<ExprId> open;
    for (std::size_t i = 0; i < system_.pool.size(); ++i) {
      const ExprId e(i);
      for (const ExprId argument : arguments(e)) users[argument.index()].push_back(e);
      const ExprNode& node = system_.pool[e];
      if (node.op == Op::symbol && indefinite_[node.a]) open.push_back(e);
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
  void solve_rings(double Point::*what, std::vector<double>& guess) {
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

  [[nodiscard]] bool slopes_agree() const {
    return std::all_of(asked_.begin(), asked_.end(), [this](ExprId e) {
      const double taken = guess_slope_[e.index()];
      return nothing(at_[e.index()].slope - taken, at_[e.index()].slope_size + std::abs(taken));
    });
  }

  /// With guess_ and guess_slope_ for what rings ask for before it is known (asked_).
  void evaluate_all() {
    std::vector<State> state(at_.size(), State::unknown);
    std::vector<ExprId> open;
    asked_.clear();
    for (std::size_t root = 0; root < at_.size(); ++root) {
      open.emplace_back(root);
      while (!open.empty()) {
        const ExprId e = open.back();
        State& here = state[e.index()];
        if (here == State::unknown) {
          here = State::looked_for;
          const double value = guess_[e.index()], slope = guess_slope_[e.index()];
          at_[e.index()] = {value, slope, std::abs(value), std::abs(slope)};
          for (const ExprId argument : arguments(e)) {
            if (state[argument.index()] == State::unknown) open.push_back(argument);
            if (state[argument.index()] == State::looked_for) asked_.push_back(argument);
          }
          continue;
        }
        open.pop_back();
        if (here == State::known) continue;
        at_[e.index()] = evaluated(e);
        here = State::known;
      }
    }
    std::sort(asked_.begin(), asked_.end(), [](ExprId a, ExprId b) { return a.index() < b.index(); });
    asked_.erase(std::unique(asked_.begin(), asked_.end()), asked_.end());
  }

  [[nodiscard]] const Equation* equation(const ExprNode& node) const {
    const SystemSymbol& symbol = system_.symbols[node.a];
    return symbol.kind == SystemSymbol::Kind::unknown ? &system_.equations[symbol.index] : nullptr;
  }

  [[nodiscard]] std::vector<ExprId> arguments(ExprId e) const {
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

  [[nodiscard]] Point evaluated(ExprId e) const {
    const ExprNode& node = system_.pool[e];
    const Point zero;
    const Point& a = arity(node.op) > 0 ? at_[node.a] : zero;
    const Point& b = arity(node.op) > 1 ? at_[node.b] : zero;
    switch (node.op) {
      case Op::constant:
        return {node.constant, 0.0, std::abs(node.constant), 0.0};
      case Op::symbol: {
        if (indefinite_[node.a]) return {number(e.index(), 0), number(e.index(), 1), 1.0, 1.0};
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
  [[nodiscard]] Point anything(ExprId e) const {
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

  const EquationSystem& system_;
  std::vector<Point> at_;                    ///< by ExprId
  std::vector<bool> indefinite_;             ///< by SymbolId
  std::vector<bool> reaches_;                ///< by ExprId
  std::vector<double> guess_, guess_slope_;  ///< by ExprId
  std::vector<ExprId> asked_;
};

/// Whether idle switches have the 0 that they would set, and only outputs and powers depend on what is indefinite.
bool are_idle(const Model& model) {
  const BondGraph graph = build_bond_graph(model);
  const EquationSystem system = derive_equations(model, graph, solvable_causality(model, graph), true);
  const RandomPoint point(model, graph, system);
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    if (model.elements[i].idle && !point.is_zero(variable_of(model, graph, system, ElementId(i), false))) return false;
  std::vector<ExprId> roots;
  for (const State& state : system.states) roots.push_back(state.rate);
  for (const DependentStore& store : system.dependent)
    roots.push_back(system.equations[system.symbols[store.symbol.index()].index].expression);
  for (const SwitchEquation& at : system.switches) roots.push_back(at.leaves);
  for (const DiodeEquation& at : system.diodes) roots.insert(roots.end(), {at.effort, at.flow, at.threshold, at.fires});
  for (const EventEquation& event : system.events) {
    roots.push_back(event.when);
    for (const EventEquation::Set& set : event.sets) roots.push_back(set.value);
  }
  for (const EquationSystem::Delay& delay : system.delays)
    roots.insert(roots.end(), {delay.value, delay.by, delay.initial});
  for (const ImpulseTerm& term : system.jump.terms) roots.push_back(term.factor);
  return std::none_of(roots.begin(), roots.end(), [&point](ExprId root) { return point.depends(root); });
}

}  // namespace

Model with_idle_switches(Model model) {
  const std::vector<ElementId> switches = plain_switches(model);
  if (switches.empty() || is_allowed(model)) return model;
  Model result = model;
  std::size_t kept = 0;
  if (!is_allowed(result, switches, 0)) return model;
  while (!is_allowed(result, switches, switches.size())) {
    std::size_t refused = switches.size();
    while (refused - kept > 1) {
      const std::size_t middle = kept + (refused - kept) / 2;
      (is_allowed(result, switches, middle) ? kept : refused) = middle;
    }
    make_idle(result.elements[switches[refused - 1].index()]);
    if (!is_allowed(result, switches, refused)) return model;
    kept = refused;
  }
  try {
    return are_idle(result) ? result : model;
  } catch (const ModelError&) {
    return model;
  }
}

bool has_idle_switches(const Model& model) {
  return std::any_of(model.elements.begin(), model.elements.end(), [](const Element& element) { return element.idle; });
}

std::vector<std::string> indefinite_outputs(const Model& model, const BondGraph& graph, const EquationSystem& system) {
  std::vector<std::string> outputs;
  if (!has_idle_switches(model)) return outputs;
  const RandomPoint point(model, graph, system);
  for (const OutputEquation& output : system.outputs)
    if (point.depends(output.value)) outputs.push_back(output.name);
  return outputs;
}

}  // namespace bgsim
