#include "program/proportional.hpp"

#include <algorithm>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/graph/strong_components.hpp>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "expression/interval.hpp"

namespace bgsim {

namespace {

/// Of what a value is zero: whenever one of these (states, or groups) is.
struct Annihilators {
  bool always = false;  ///< it is zero
  std::vector<std::uint32_t> by;
};

constexpr std::size_t kMostFactors = 8;  // more are forgotten, which makes the statement weaker and not wrong

Annihilators either(const Annihilators& a, const Annihilators& b) {
  if (a.always || b.always) return {true, {}};
  Annihilators result;
  std::set_union(a.by.begin(), a.by.end(), b.by.begin(), b.by.end(), std::back_inserter(result.by));
  if (result.by.size() > kMostFactors) result.by.resize(kMostFactors);
  return result;
}

Annihilators both(const Annihilators& a, const Annihilators& b) {
  if (a.always) return b;
  if (b.always) return a;
  Annihilators result;
  std::set_intersection(a.by.begin(), a.by.end(), b.by.begin(), b.by.end(), std::back_inserter(result.by));
  return result;
}

/// Zero at zero, with a bounded slope there. Not roots: what falls by the root of itself is empty in finite time, and
/// to be followed relative to what is left it would take ever shorter steps.
bool is_zero_at_zero(Op op) {
  switch (op) {
    case Op::neg:
    case Op::abs:
    case Op::sin:
    case Op::tan:
    case Op::asin:
    case Op::atan:
    case Op::sinh:
    case Op::tanh:
    case Op::asinh:
    case Op::atanh:
    case Op::log1p:
    case Op::expm1:
      return true;
    default:
      return false;
  }
}

/// The annihilators of all slots of the rates, where a state's slot has the number @p number_of(state).
template <class NumberOf>
std::vector<Annihilators> annihilators(const Program& program, std::span<const double> slots,
                                       const std::vector<bool>& fixed, NumberOf&& number_of) {
  std::vector<Annihilators> of(program.slots);
  for (std::size_t s = 0; s < program.slots; ++s)
    if (fixed[s]) of[s].always = slots[s] == 0.0;
  for (std::uint32_t i = 0; i < program.state_names.size(); ++i)
    if (const std::uint32_t number = number_of(i); number != kNoGroup) of[program.first_state + i].by = {number};
  for (const auto& code : program.rates.code)
    for (const Instruction& i : code) {
      switch (i.op) {
        case Op::mul:
          of[i.out] = either(of[i.a], of[i.b]);
          break;
        case Op::add:
        case Op::sub:
        case Op::min:
        case Op::max:
        case Op::hypot:
          of[i.out] = both(of[i.a], of[i.b]);
          break;
        case Op::select:
          of[i.out] = both(of[i.b], of[i.c]);
          break;
        case Op::div:
          of[i.out] = of[i.a];
          break;
        case Op::pow:
          if (fixed[i.b] && slots[i.b] >= 1.0) of[i.out] = of[i.a];
          break;
        default:
          if (is_zero_at_zero(i.op)) of[i.out] = of[i.a];
      }
    }
  return of;
}

/// What is known of a value's sign, as bits: not negative, not positive, that of the state, that of its negative.
enum Sign : std::uint8_t { none = 0, up = 1, down = 2, same = 4, opposite = 8, all = 15 };

std::uint8_t negated(std::uint8_t s) {
  return static_cast<std::uint8_t>((s & up) << 1 | (s & down) >> 1 | (s & same) << 1 | (s & opposite) >> 1);
}

std::uint8_t product(std::uint8_t a, std::uint8_t b) {
  const auto has = [](std::uint8_t s, Sign sign) { return (s & sign) != 0; };
  std::uint8_t result = none;
  if ((has(a, up) && has(b, up)) || (has(a, down) && has(b, down)) || (has(a, same) && has(b, same)) ||
      (has(a, opposite) && has(b, opposite)))
    result |= up;
  if ((has(a, up) && has(b, down)) || (has(a, down) && has(b, up)) || (has(a, same) && has(b, opposite)) ||
      (has(a, opposite) && has(b, same)))
    result |= down;
  if ((has(a, up) && has(b, same)) || (has(a, same) && has(b, up)) || (has(a, down) && has(b, opposite)) ||
      (has(a, opposite) && has(b, down)))
    result |= same;
  if ((has(a, up) && has(b, opposite)) || (has(a, opposite) && has(b, up)) || (has(a, down) && has(b, same)) ||
      (has(a, same) && has(b, down)))
    result |= opposite;
  return result;
}

/// Whether the rate of a state never has the state's own sign: it only shrinks.
class Shrinks {
 public:
  Shrinks(const Program& program, std::span<const double> slots, double start, double stop)
      : program_(program), start_(start), stop_(stop), values_(program.symbol_names.size(), 0.0) {
    const ExprPool& pool = program.pool;
    of_time_.assign(pool.size(), true);
    std::vector<bool> is_parameter(program.symbol_names.size(), false);
    for (const SymbolId parameter : program.parameters) is_parameter[parameter.index()] = true;
    for (std::uint32_t e = 0; e < pool.size(); ++e) {
      const ExprNode& node = pool[ExprId(e)];
      if (node.op == Op::symbol) of_time_[e] = SymbolId(node.a) == program.time || is_parameter[node.a];
      if (node.op == Op::constant || node.op == Op::symbol) continue;
      const std::uint32_t arguments[] = {node.a, node.b, node.c};
      const int count = is_table(node.op) ? 1 : arity(node.op);
      for (int k = 0; k < count; ++k) of_time_[e] = of_time_[e] && of_time_[arguments[k]];
    }
    of_symbol_.assign(program.symbol_names.size(), none);
    const auto symbol_at = [&](std::size_t slot) { return pool[program.slot_expression[slot]].a; };
    for (std::size_t i = 0; i < program.parameters.size(); ++i) {
      const SymbolId parameter = program.parameters[i];
      values_[parameter.index()] = slots[program.first_parameter + i];
      of_symbol_[parameter.index()] = sign_of(values_[parameter.index()]);
    }
    guard_.resize(program.symbol_names.size());
    for (std::size_t r = 0; r < program.relations.size(); ++r) {
      const Relation& relation = program.relations[r];
      const std::uint32_t symbol = symbol_at(program.first_mode + r);
      if (relation.kind == Relation::Kind::condition || relation.kind == Relation::Kind::step) of_symbol_[symbol] = up;
      if (relation.kind == Relation::Kind::sign) guard_[symbol] = relation.guard;
    }
  }

  bool operator()(std::uint32_t state) {
    const ExprPool& pool = program_.pool;
    const std::uint32_t symbol = pool[program_.slot_expression[program_.first_state + state]].a;
    const ExprId root = program_.slot_expression[program_.rates.results[state]];
    std::unordered_map<std::uint32_t, std::uint8_t> known;
    std::vector<std::pair<ExprId, bool>> stack{{root, false}};
    while (!stack.empty()) {
      const auto [e, done] = stack.back();
      stack.pop_back();
      if (done) {
        known[e.value] = sign_of(e, symbol, known);
        continue;
      }
      if (!known.emplace(e.value, none).second) continue;
      stack.emplace_back(e, true);
      const ExprNode& node = pool[e];
      if (node.op == Op::symbol && guard_[node.a].valid()) stack.emplace_back(guard_[node.a], false);
      if (node.op == Op::constant || node.op == Op::symbol || is_table(node.op) || of_time_[e.index()]) continue;
      const std::uint32_t arguments[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) stack.emplace_back(ExprId(arguments[k]), false);
    }
    return (known[root.value] & opposite) != 0;
  }

 private:
  static std::uint8_t sign_of(double value) {
    return value > 0.0 ? up : value < 0.0 ? down : value == 0.0 ? all : none;
  }

  [[nodiscard]] std::uint8_t sign_of(ExprId e, std::uint32_t state,
                                     const std::unordered_map<std::uint32_t, std::uint8_t>& known) const {
    const ExprNode& node = program_.pool[e];
    if (node.op == Op::constant) return sign_of(node.constant);
    if (of_time_[e.index()]) {
      const Range range = TimeRelation(program_.pool, e, program_.time, values_, false).range_on(start_, stop_);
      if (boost::numeric::empty(range)) return none;
      return static_cast<std::uint8_t>((range.lower() >= 0.0 ? up : none) | (range.upper() <= 0.0 ? down : none));
    }
    if (node.op == Op::symbol) {
      if (node.a == state) return same;
      return guard_[node.a].valid() ? known.at(guard_[node.a].value) : of_symbol_[node.a];
    }
    if (is_table(node.op)) return none;
    const auto at = [&](int k, std::uint32_t of) { return arity(node.op) > k ? known.at(of) : std::uint8_t{none}; };
    const std::uint8_t a = at(0, node.a), b = at(1, node.b), c = at(2, node.c);
    switch (node.op) {
      case Op::neg:
        return negated(a);
      case Op::add:
        return a & b;
      case Op::sub:
        return a & negated(b);
      case Op::mul:
      case Op::div:
        return product(a, b);
      case Op::pow: {
        const ExprId exponent(node.b);
        if ((a & up) != 0) return up;
        if (!program_.pool.is_constant(exponent)) return none;
        const double n = program_.pool[exponent].constant;
        // A root or another broken power says that its argument is not negative; so then is the state, or is not
        // positive.
        if (n != std::floor(n)) return up | (a & (same | opposite));
        return std::fmod(n, 2.0) == 0.0 ? std::uint8_t{up} : a;
      }
      case Op::sqrt:
        return up | (a & (same | opposite));
      case Op::abs:
      case Op::exp:
      case Op::cosh:
      case Op::hypot:
      case Op::step:
        return up;
      case Op::sign:
      case Op::cbrt:
      case Op::asin:
      case Op::atan:
      case Op::sinh:
      case Op::tanh:
      case Op::asinh:
      case Op::atanh:
      case Op::log1p:
      case Op::expm1:
        return a;
      case Op::min:
        return static_cast<std::uint8_t>((a & b) | ((a | b) & down));
      case Op::max:
        return static_cast<std::uint8_t>((a & b) | ((a | b) & up));
      case Op::select:
        return b & c;
      default:
        return none;
    }
  }

  const Program& program_;
  double start_, stop_;
  std::vector<double> values_;           ///< of parameters, by symbol
  std::vector<bool> of_time_;            ///< by expression: of time and parameters alone
  std::vector<std::uint8_t> of_symbol_;  ///< parameters and modes
  std::vector<ExprId> guard_;            ///< by symbol: of a frozen sign, what it is the sign of; else none
};

/// Slots that depend on parameters alone.
std::vector<bool> fixed_slots(const Program& program) {
  std::vector<bool> fixed(program.slots, false);
  for (std::size_t i = 0; i < program.parameters.size(); ++i) fixed[program.first_parameter + i] = true;
  for (std::size_t s = program.first_parameter + program.parameters.size(); s < program.slots; ++s)
    fixed[s] = program.pool[program.slot_expression[s]].op == Op::constant;
  for (const auto& code : program.once.code)
    for (const Instruction& i : code) fixed[i.out] = true;
  return fixed;
}

/// Strongly connected parts of the states' dependences.
std::pair<std::vector<std::uint32_t>, std::uint32_t> components(const Sparsity& pattern) {
  using Graph = boost::compressed_sparse_row_graph<boost::directedS>;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> arcs;
  for (std::uint32_t column = 0; column < pattern.size; ++column)
    for (auto k = pattern.column_start[column]; k < pattern.column_start[column + 1]; ++k)
      arcs.emplace_back(column, static_cast<std::uint32_t>(pattern.row[static_cast<std::size_t>(k)]));
  const Graph graph(boost::edges_are_sorted, arcs.begin(), arcs.end(), pattern.size);
  std::vector<std::uint32_t> component(pattern.size);
  const std::uint32_t count = boost::strong_components(
      graph, boost::make_iterator_property_map(component.begin(), get(boost::vertex_index, graph)));
  return {std::move(component), count};
}

}  // namespace

Proportional proportional_states(const Program& program, std::span<const double> slots, double start, double stop) {
  const std::size_t n = program.state_names.size();
  Proportional result{std::vector<bool>(n, false), std::vector<std::uint32_t>(n, kNoGroup), 0};
  if (n == 0 || !program.plan.explicit_form) return result;
  const std::vector<bool> fixed = fixed_slots(program);

  std::vector<bool> linear(n, true);
  for (const auto& e : program.plan.rates_by_states)
    if (!fixed[e.slot]) linear[e.row] = false;
  for (const auto& e : program.plan.rates_by_tears) linear[e.row] = false;

  // Neither a state nor a group counts without a law that varies, and a converter's modes have none.
  if (std::find(linear.begin(), linear.end(), false) == linear.end()) return result;

  const auto by_state = annihilators(program, slots, fixed, [](std::uint32_t i) { return i; });
  Shrinks shrinks(program, slots, start, stop);
  for (std::uint32_t i = 0; i < n; ++i) {
    const Annihilators& of = by_state[program.rates.results[i]];
    result.alone[i] = !linear[i] && !of.always && std::binary_search(of.by.begin(), of.by.end(), i) && !shrinks(i);
  }

  const auto [component, count] = components(program.jacobian_pattern);
  const auto by_component = annihilators(program, slots, fixed, [&c = component](std::uint32_t i) { return c[i]; });
  std::vector<std::uint32_t> size(count, 0);
  std::vector<bool> vanishes(count, true), varies(count, false);
  for (std::uint32_t i = 0; i < n; ++i) {
    const Annihilators& of = by_component[program.rates.results[i]];
    ++size[component[i]];
    if (!linear[i]) varies[component[i]] = true;
    if (!of.always && !std::binary_search(of.by.begin(), of.by.end(), component[i])) vanishes[component[i]] = false;
  }
  std::vector<std::uint32_t> number(count, kNoGroup);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t c = component[i];
    if (size[c] < 2 || !vanishes[c] || !varies[c]) continue;
    if (number[c] == kNoGroup) number[c] = result.groups++;
    result.group[i] = number[c];
  }
  return result;
}

}  // namespace bgsim
