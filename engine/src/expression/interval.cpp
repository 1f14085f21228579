#include "expression/interval.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "expression/graph.hpp"
#include "expression/table_formula.hpp"

namespace bgsim {

namespace {

/// Cells of a table that are looked at one by one; over more of them the range is taken to be unknown.
constexpr std::size_t kMostCells = 64;

Range thin_or_empty(double value) { return std::isnan(value) ? Range::empty() : Range(value, value); }

/// Two units in the last place outwards: what a function of the mathematical library may be off by, and more.
double below(double x) { return std::isinf(x) ? x : x - std::fabs(x) * 0x1p-51 - 5e-324; }
double above(double x) { return -below(-x); }
Range widened(double a, double b) { return {below(std::min(a, b)), above(std::max(a, b))}; }

/// A monotone function.
Range monotone(Op op, const Range& x) { return widened(apply(op, x.lower()), apply(op, x.upper())); }
/// A monotone function with the domain [least, most]. Ranges are wider than their values by roundings: what these add
/// beyond the domain (-1e-20 of a level from 0 to 1e-5, under a root) is not taken for values there.
Range monotone(Op op, const Range& x, double least, double most) {
  constexpr double kRoundings = 0x1p-44;
  if (x.upper() < least || x.lower() > most) return Range::empty();
  const double room = kRoundings * std::max(std::fabs(x.lower()), std::fabs(x.upper()));
  if (x.lower() < least - room || x.upper() > most + room) return kAllNumbers;
  return monotone(op, Range(std::max(x.lower(), least), std::min(x.upper(), most)));
}
/// A monotone step function, whose values are exact.
Range stepping(Op op, const Range& x) { return {apply(op, x.lower()), apply(op, x.upper())}; }

/// A function of two arguments that is monotone in each of them: its extremes are at the corners.
Range corners(Op op, const Range& x, const Range& y) {
  const std::array<double, 4> at{apply(op, x.lower(), y.lower()), apply(op, x.lower(), y.upper()),
                                 apply(op, x.upper(), y.lower()), apply(op, x.upper(), y.upper())};
  if (std::any_of(at.begin(), at.end(), [](double v) { return std::isnan(v); })) return kAllNumbers;
  return widened(*std::min_element(at.begin(), at.end()), *std::max_element(at.begin(), at.end()));
}

/// True unless x certainly contains no point offset + k*period.
bool may_contain(const Range& x, double offset, double period) {
  const double first = (x.lower() - offset) / period, last = (x.upper() - offset) / period;
  const double slack = 1e-15 * (1.0 + std::max(std::fabs(first), std::fabs(last)));
  return slack > 0.1 || std::floor(last + slack) >= std::ceil(first - slack);
}

Range sine_like(Op op, const Range& x, double maximum) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  if (!std::isfinite(x.lower()) || !std::isfinite(x.upper()) || x.upper() - x.lower() >= kTurn) return {-1.0, 1.0};
  const Range ends = monotone(op, x);
  const double low = may_contain(x, maximum + std::numbers::pi, kTurn) ? -1.0 : std::max(-1.0, ends.lower());
  const double high = may_contain(x, maximum, kTurn) ? 1.0 : std::min(1.0, ends.upper());
  return {low, high};
}

Range tangent(const Range& x) {
  if (!std::isfinite(x.lower()) || !std::isfinite(x.upper()) || x.upper() - x.lower() >= std::numbers::pi)
    return kAllNumbers;
  return may_contain(x, 0.5 * std::numbers::pi, std::numbers::pi) ? kAllNumbers : monotone(Op::tan, x);
}

/// What rounding outwards adds beyond 0 of values that have one sign (l^3 of a tiny l) is no value.
Range of_sign(const Range& y, bool positive) {
  if (y.lower() == -kInfinity && y.upper() == kInfinity) return y;
  return positive ? Range(std::max(y.lower(), 0.0), std::max(y.upper(), 0.0))
                  : Range(std::min(y.lower(), 0.0), std::min(y.upper(), 0.0));
}

Range power(const Range& x, const Range& y) {
  if (x.lower() >= 0.0) return of_sign(corners(Op::pow, x, y), true);
  if (!is_thin(y)) return kAllNumbers;
  const double n = y.lower();
  if (n != std::floor(n)) return x.upper() < 0.0 ? Range::empty() : kAllNumbers;
  if (n < 0.0 && x.upper() >= 0.0) return kAllNumbers;
  const Range ends = widened(apply(Op::pow, x.lower(), n), apply(Op::pow, x.upper(), n));
  const bool even = std::fmod(n, 2.0) == 0.0;
  if (even) return x.upper() > 0.0 ? Range(0.0, ends.upper()) : of_sign(ends, true);
  return x.upper() <= 0.0 ? of_sign(ends, false) : ends;
}

Range arc(const Range& y, const Range& x) {
  if (x.lower() <= 0.0 && y.lower() <= 0.0 && y.upper() >= 0.0) return {-4.0, 4.0};  // the cut, or the origin
  return corners(Op::atan2, y, x);
}

/// a - b*floor(a/b): between its jumps as far as they are known, else anything from 0 to b.
Range remainder(const Range& a, const Range& b) {
  const Range quotient = a / b;
  const Range turns = stepping(Op::floor, quotient);
  if (!std::isfinite(turns.lower()) || !std::isfinite(turns.upper())) return hull(Range(0.0, 0.0), b);
  if (is_thin(turns)) return a - b * turns;
  return hull(Range(0.0, 0.0), b);
}

Range decided(bool yes, bool no) { return yes ? Range(1.0, 1.0) : no ? Range(0.0, 0.0) : Range(0.0, 1.0); }

Range comparison(Op op, const Range& a, const Range& b) {
  switch (op) {
    case Op::lt:
      return decided(a.upper() < b.lower(), a.lower() >= b.upper());
    case Op::le:
      return decided(a.upper() <= b.lower(), a.lower() > b.upper());
    case Op::gt:
      return decided(a.lower() > b.upper(), a.upper() <= b.lower());
    case Op::ge:
      return decided(a.lower() >= b.upper(), a.upper() < b.lower());
    case Op::eq:
      return decided(is_thin(a) && is_thin(b) && a.lower() == b.lower(),
                     a.upper() < b.lower() || a.lower() > b.upper());
    default:
      return decided(a.upper() < b.lower() || a.lower() > b.upper(),
                     is_thin(a) && is_thin(b) && a.lower() == b.lower());
  }
}

/// Of a delayed signal, whose cubics go on beyond the ends.
Range delayed_range(Op op, const Table& table, const Range& x) {
  const std::size_t first = delayed_cell(table, x.lower()), last = delayed_cell(table, x.upper());
  if (!std::isfinite(x.lower()) || !std::isfinite(x.upper()) || last - first >= 2 * kMostCells) return kAllNumbers;
  Range result = Range::empty();
  for (std::size_t i = first; i <= last; i += 2) {
    const Range part(i == first ? x.lower() : table.x[i], i == last ? x.upper() : table.x[i + 1]);
    const Range values = op == Op::table         ? cell_value(table, i, part)
                         : op == Op::table_slope ? cell_slope(table, i, part)
                         : op == Op::table_third ? Range(cell_third(table, i))
                                                 : cell_curvature(table, i, part);
    result = i == first ? values : hull(result, values);
  }
  return result;
}

Range table_range(Op op, const Table& table, const Range& x) {
  if (table.delayed) return delayed_range(op, table, x);
  if (table.x.size() < 2 || x.upper() < table.x.front() || x.lower() > table.x.back()) return Range::empty();
  if (x.lower() < table.x.front() || x.upper() > table.x.back()) return kAllNumbers;
  const std::size_t first = nearest_cell(table, x.lower()), last = nearest_cell(table, x.upper());
  if (last - first >= kMostCells) return kAllNumbers;
  Range result = Range::empty();
  for (std::size_t i = first; i <= last; ++i) {
    const Range part(std::max(x.lower(), table.x[i]), std::min(x.upper(), table.x[i + 1]));
    const Range values = op == Op::table         ? cell_value(table, i, part)
                         : op == Op::table_slope ? cell_slope(table, i, part)
                         : op == Op::table_third ? Range(cell_third(table, i))
                                                 : cell_curvature(table, i, part);
    result = i == first ? values : hull(result, values);
  }
  return result;
}

Range range_of(Op op, const Range& a) {
  switch (op) {
    case Op::neg:
      return -a;
    case Op::abs:
      return boost::numeric::abs(a);
    case Op::sign:
    case Op::step:
    case Op::floor:
    case Op::ceil:
    case Op::round:
      return stepping(op, a);
    case Op::logical_not:
      return 1.0 - a;
    case Op::sqrt:
    case Op::log:
    case Op::log10:
      return monotone(op, a, 0.0, kInfinity);
    case Op::asin:
    case Op::acos:
      return monotone(op, a, -1.0, 1.0);
    case Op::acosh:
      return monotone(op, a, 1.0, kInfinity);
    case Op::atanh:
      return monotone(op, a, -1.0, 1.0);
    case Op::log1p:
      return monotone(op, a, -1.0, kInfinity);
    case Op::sin:
      return sine_like(op, a, 0.5 * std::numbers::pi);
    case Op::cos:
      return sine_like(op, a, 0.0);
    case Op::tan:
      return tangent(a);
    case Op::cosh:
      return monotone(op, boost::numeric::abs(a));
    case Op::der:
      return Range::empty();
    default:
      return monotone(op, a);  // cbrt, exp, expm1, atan, sinh, tanh, asinh
  }
}

Range range_of(Op op, const Range& a, const Range& b) {
  switch (op) {
    case Op::add:
      return a + b;
    case Op::sub:
      return a - b;
    case Op::mul:
      return a * b;
    case Op::div:
      return a / b;
    case Op::pow:
      return power(a, b);
    case Op::min:
      return boost::numeric::min(a, b);
    case Op::max:
      return boost::numeric::max(a, b);
    case Op::atan2:
      return arc(a, b);
    case Op::hypot:
      return corners(op, boost::numeric::abs(a), boost::numeric::abs(b));
    case Op::ssqrt:
      return corners(op, a, boost::numeric::abs(b));
    case Op::mod:
      return remainder(a, b);
    default:
      return comparison(op, a, b);
  }
}

/// Truth values, of which an empty one is a fault: false wins in `and`, true in `or`, as in apply().
Range logic(Op op, const Range& a, const Range& b) {
  const double strong = op == Op::logical_and ? 0.0 : 1.0;
  const auto settles = [strong](const Range& x) { return is_thin(x) && x.lower() == strong; };
  if (settles(a) || settles(b)) return {strong, strong};
  if (is_empty(a) || is_empty(b))
    return is_thin(a) || is_thin(b) || (is_empty(a) && is_empty(b)) ? Range::empty() : kAllNumbers;
  return op == Op::logical_and ? boost::numeric::min(a, b) : boost::numeric::max(a, b);
}

}  // namespace

Range range_of(Op op, const Table* table, const Range& a, const Range& b, const Range& c) {
  const int n = arity(op);
  if (op == Op::logical_and || op == Op::logical_or) return logic(op, a, b);
  if (is_empty(a) || (n == 2 && is_empty(b))) return Range::empty();
  if (op == Op::select) {
    if (is_thin(a)) return a.lower() != 0.0 ? b : c;
    return is_empty(b) != is_empty(c) ? kAllNumbers : hull(b, c);
  }
  if (table != nullptr)
    return is_thin(a) ? thin_or_empty(apply_table(op, *table, a.lower())) : table_range(op, *table, a);
  if (n == 1) return is_thin(a) ? thin_or_empty(apply(op, a.lower())) : range_of(op, a);
  return is_thin(a) && is_thin(b) ? thin_or_empty(apply(op, a.lower(), b.lower())) : range_of(op, a, b);
}

std::size_t nearest_cell(const Table& table, double x) {
  if (table.x.size() < 2) return 0;
  const auto after = std::upper_bound(table.x.begin() + 1, table.x.end() - 1, x);
  return static_cast<std::size_t>(after - table.x.begin()) - 1;
}

TimeRelation::TimeRelation(const ExprPool& pool, ExprId relation, SymbolId time, std::span<const double> symbol_values,
                           bool cells) {
  const ExprNode& top = pool[relation];
  if (cells && is_table(top.op)) {
    cells_ = &pool.table(TableId(top.b));
    relation = ExprId(top.a);
  }
  const std::vector<ExprId> nodes = reachable(pool, {&relation, 1});
  const IdMap<std::uint32_t> position = positions(nodes);
  const std::vector<char> depends = depends_on(pool, nodes, position, [time](SymbolId s) { return s == time; });
  values_.resize(nodes.size());
  same_.resize(nodes.size());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    same_[i] = i;
    const ExprNode& node = pool[nodes[i]];
    Step step{node.op, 0, 0, 0, i, is_table(node.op) ? &pool.table(TableId(node.b)) : nullptr, arity(node.op)};
    std::array<std::uint32_t*, 3> places{&step.a, &step.b, &step.c};
    std::size_t n = 0;
    for_each_argument(node, [&](ExprId a) { *places[n++] = *position.find(a); });
    if (node.op == Op::constant)
      values_[i] = thin_or_empty(node.constant);
    else if (node.op == Op::symbol && depends[i] == 0)
      values_[i] = node.a < symbol_values.size() ? thin_or_empty(symbol_values[node.a]) : Range::empty();
    else if (node.op == Op::symbol)
      time_.push_back(i);
    else if (depends[i] == 0)
      run(step);
    else
      steps_.push_back(step);
  }
}

/// Which of the values before it the result is on the whole stretch.
void TimeRelation::follow(const Step& step) {
  const Range& a = values_[step.a];
  const Range& b = values_[step.b];
  std::uint32_t& same = same_[step.out];
  same = step.out;
  if (is_empty(a)) return;
  if (step.op == Op::min || step.op == Op::max) {
    if (is_empty(b)) return;
    const bool first_below = a.upper() <= b.lower(), first_above = a.lower() >= b.upper();
    if (same_[step.a] == same_[step.b] || (step.op == Op::min ? first_below : first_above))
      same = same_[step.a];
    else if (step.op == Op::min ? first_above : first_below)
      same = same_[step.b];
  } else if (step.op == Op::abs) {
    if (a.lower() >= 0.0) same = same_[step.a];
  } else if (step.op == Op::mod) {
    if (!is_empty(b) && a.lower() >= 0.0 && a.upper() < b.lower()) same = same_[step.a];
  } else if (step.op == Op::select) {
    if (is_thin(a)) same = same_[a.lower() != 0.0 ? step.b : step.c];
  } else {
    if (same_[step.a] != step.a || (step.arity > 1 && same_[step.b] != step.b)) same = twin_of(step);
  }
}

/// A value that is computed in the same way from the same ones.
std::uint32_t TimeRelation::twin_of(const Step& step) {
  const auto key = [](const Step& s, std::uint32_t a, std::uint32_t b) {
    const bool two = arity(s.op) > 1;
    return std::array<std::uint32_t, 4>{static_cast<std::uint32_t>(s.op), a, two ? b : 0, 0};
  };
  if (step.table != nullptr) return step.out;
  if (twins_.empty())
    for (const Step& other : steps_)
      if (other.table == nullptr && arity(other.op) < 3) twins_.emplace(key(other, other.a, other.b), other.out);
  const auto found = twins_.find(key(step, same_[step.a], same_[step.b]));
  // what is computed later has not got this stretch's range yet
  return found != twins_.end() && found->second < step.out ? found->second : step.out;
}

/// What an operator makes of two values that are the same.
std::optional<Range> TimeRelation::of_equals(const Step& step) const {
  if (same_[step.a] != same_[step.b] || step.arity != 2 || step.table != nullptr) return std::nullopt;
  const Range& a = values_[step.a];
  if (is_empty(a) || !std::isfinite(a.lower()) || !std::isfinite(a.upper())) return std::nullopt;
  if (step.op == Op::sub) return Range(0.0, 0.0);
  if (is_comparison(step.op)) {
    const double yes = apply(step.op, 0.0, 0.0);
    return Range(yes, yes);
  }
  return std::nullopt;
}

void TimeRelation::run(const Step& step) {
  follow(step);
  if (const auto known = of_equals(step)) {
    values_[step.out] = *known;
    return;
  }
  values_[step.out] = range_of(step.op, step.table, values_[step.a], values_[step.b], values_[step.c]);
}

Range TimeRelation::range_on(double begin, double end) {
  for (const std::uint32_t i : time_) values_[i] = Range(begin, end);
  for (const Step& step : steps_) run(step);
  return values_.back();
}

double TimeRelation::distance(double whole) const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (steps_.empty() || cells_ != nullptr) return kNone;
  const Step& top = steps_.back();
  const double a = values_[top.a].lower();
  if (is_comparison(top.op)) return a - values_[top.b].lower();
  if (top.op == Op::sign || top.op == Op::step) return a;
  return top.op == Op::floor ? a - whole : kNone;
}

std::optional<double> TimeRelation::value_on(double begin, double end) {
  const Range x = range_on(begin, end);
  if (is_empty(x)) return std::numeric_limits<double>::quiet_NaN();
  if (cells_ != nullptr) {
    const std::size_t first = nearest_cell(*cells_, x.lower());
    if (first != nearest_cell(*cells_, x.upper())) return std::nullopt;
    return static_cast<double>(first);
  }
  if (!is_thin(x)) return std::nullopt;
  return x.lower();
}

}  // namespace bgsim
