#include "expression/monotone.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "expression/inverse_table.hpp"
#include "expression/rounded.hpp"

namespace bgsim {

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostParts = 32;

Way reversed(Way way) { return way == Way::rising ? Way::falling : way == Way::falling ? Way::rising : way; }
/// Of a sum.
Way together(Way a, Way b) {
  if (a == Way::constant) return b;
  return b == Way::constant || a == b ? a : Way::unknown;
}

bool decides(Op op) {
  return (is_comparison(op) && op != Op::eq && op != Op::ne) || op == Op::sign || op == Op::step || op == Op::abs ||
         op == Op::min || op == Op::max;
}

bool has_domain(Op op) {
  return op == Op::sqrt || op == Op::log || op == Op::log10 || op == Op::log1p || op == Op::pow || op == Op::asin ||
         op == Op::acos || op == Op::acosh || op == Op::atanh;
}

Way way_of_result(const ExprNode& node, const Table* table, const std::array<Course, 3>& a) {
  const auto way_of_size = [](const Course& c) {  // of |c|
    if (c.range.lower() >= 0.0) return c.way;
    return c.range.upper() <= 0.0 ? reversed(c.way) : Way::unknown;
  };
  const auto product = [&](Way left, Way right, double sign) {
    const Way way = together(left, right);
    return sign < 0.0 ? reversed(way) : way;
  };
  const auto sign_of = [](const Course& c) { return c.range.upper() <= 0.0 ? -1.0 : 1.0; };
  const auto zero = [](const Course& c) { return c.way == Way::constant && c.low == 0.0; };
  switch (node.op) {
    case Op::neg:
    case Op::acos:
      return reversed(a[0].way);
    case Op::add:
      return together(a[0].way, a[1].way);
    case Op::sub:
      return together(a[0].way, reversed(a[1].way));
    case Op::mul:
      if (zero(a[0]) || zero(a[1])) return Way::unknown;
      if (a[0].way == Way::constant) return a[0].low < 0.0 ? reversed(a[1].way) : a[1].way;
      if (a[1].way == Way::constant) return a[1].low < 0.0 ? reversed(a[0].way) : a[0].way;
      return product(way_of_size(a[0]), way_of_size(a[1]), sign_of(a[0]) * sign_of(a[1]));
    case Op::div:
      if (zero(a[0])) return Way::unknown;
      if (a[1].way == Way::constant) return a[1].low < 0.0 ? reversed(a[0].way) : a[0].way;
      return product(way_of_size(a[0]), reversed(way_of_size(a[1])), sign_of(a[0]) * sign_of(a[1]));
    case Op::pow: {
      if (a[0].way == Way::constant)
        return a[0].low > 1.0 ? a[1].way : a[0].low > 0.0 && a[0].low < 1.0 ? reversed(a[1].way) : Way::unknown;
      if (a[1].way != Way::constant || a[1].low == 0.0) return Way::unknown;
      const double n = a[1].low;
      const bool odd = std::fabs(std::fmod(n, 2.0)) == 1.0, whole = n == std::floor(n);
      if (a[0].range.lower() >= 0.0) return n > 0.0 ? a[0].way : reversed(a[0].way);
      if (odd && n > 0.0) return a[0].way;
      if (!whole || a[0].range.upper() > 0.0) return Way::unknown;
      return odd == (n > 0.0) ? a[0].way : reversed(a[0].way);
    }
    case Op::cosh:
      return way_of_size(a[0]);
    case Op::hypot:
      return together(way_of_size(a[0]), way_of_size(a[1]));
    case Op::ssqrt:
      return a[1].way == Way::constant ? a[0].way : Way::unknown;
    case Op::table: {
      const Way way = way_of(*table);
      return way == Way::falling ? reversed(a[0].way) : way == Way::rising ? a[0].way : Way::unknown;
    }
    case Op::sqrt:
    case Op::cbrt:
    case Op::exp:
    case Op::log:
    case Op::log10:
    case Op::asin:
    case Op::atan:
    case Op::sinh:
    case Op::tanh:
    case Op::asinh:
    case Op::acosh:
    case Op::atanh:
    case Op::log1p:
    case Op::expm1:
      return a[0].way;
    default:
      return Way::unknown;
  }
}

double middle_of(const Range& x) {
  if (std::isinf(x.lower()) && std::isinf(x.upper())) return 0.0;
  if (std::isinf(x.upper())) return x.lower() > 0.0 ? 4.0 * x.lower() : 1.0;
  if (std::isinf(x.lower())) return x.upper() < 0.0 ? 4.0 * x.upper() : -1.0;
  return x.lower() + (x.upper() - x.lower()) / 2;
}

}  // namespace

double value_of(const ExprPool& pool, ExprId root, const NumberOf& number) {
  const std::vector<ExprId> nodes = reachable(pool, {&root, 1});
  const IdMap<std::uint32_t> position = positions(nodes);
  std::vector<double> value(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode& node = pool[nodes[i]];
    std::array<double, 3> a{};
    std::size_t n = 0;
    for_each_argument(node, [&](ExprId argument) { a[n++] = value[*position.find(argument)]; });
    value[i] = node.op == Op::constant ? node.constant
               : node.op == Op::symbol ? number(SymbolId(node.a))
               : is_table(node.op)     ? apply_table(node.op, *pool.tables()[node.b], a[0])
                                       : apply(node.op, a[0], a[1], a[2]);
  }
  return value.back();
}

double Cutter::at(ExprId root, double x) const {
  return value_of(pool_, root, [&](SymbolId s) { return s == x_ ? x : number_(s); });
}

std::vector<char> Cutter::with_x(const std::vector<ExprId>& nodes) const {
  return depends_on(pool_, nodes, positions(nodes), [this](SymbolId s) { return s == x_; });
}

std::vector<Part> Cutter::cut(ExprId expression) {
  Part whole;
  whole.expression = expression;
  std::vector<Part> open{whole}, done;
  for (std::size_t work = 0; !open.empty(); ++work) {
    if (work > 8 * kMostParts || done.size() > kMostParts) return {};
    const Part part = open.back();
    open.pop_back();
    const auto decision = first_decision(part.expression);
    if (!decision) {
      Part inside_data = part;
      if (hidden_kink(part.expression) || !limit_to_data(inside_data)) return {};
      if (inside_data.low < inside_data.high) done.push_back(inside_data);
      continue;
    }
    if (!divide(part, *decision, open)) return {};
  }
  return done;  // the upper half is put off first
}

Way Cutter::way(const std::vector<Part>& parts) {
  Way result = Way::constant;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Way here = way_of(parts[i]);
    if (here == Way::constant || (i > 0 && (here != result || !meet(parts[i - 1], parts[i])))) return Way::unknown;
    result = here;
  }
  return result;
}

Way Cutter::way_of(const Part& part) {
  // A root at a border that is rounded would end beyond its domain.
  constexpr double kBeside = 1e-12;
  const double low = part.low + kBeside * (std::isinf(part.low) ? 0.0 : std::abs(part.low));
  const double high = part.high - kBeside * (std::isinf(part.high) ? 0.0 : std::abs(part.high));
  const std::vector<ExprId> nodes = reachable(pool_, {&part.expression, 1});
  const IdMap<std::uint32_t> position = positions(nodes);
  std::vector<Course> courses(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode& node = pool_[nodes[i]];
    std::array<Course, 3> a{};
    std::size_t n = 0;
    for_each_argument(node, [&](ExprId argument) { a[n++] = courses[*position.find(argument)]; });
    const Table* const table = is_table(node.op) ? pool_.tables()[node.b].get() : nullptr;
    Course& course = courses[i];
    if (node.op == Op::constant || (node.op == Op::symbol && SymbolId(node.a) != x_)) {
      course.low = course.high = node.op == Op::constant ? node.constant : number_(SymbolId(node.a));
      course.way = Way::constant;
    } else if (node.op == Op::symbol) {
      course = {low, high, Way::rising, {}};
    } else {
      course.low =
          table != nullptr ? value_within(node.op, *table, a[0].low) : apply(node.op, a[0].low, a[1].low, a[2].low);
      course.high =
          table != nullptr ? value_within(node.op, *table, a[0].high) : apply(node.op, a[0].high, a[1].high, a[2].high);
      const bool fixed = std::all_of(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(n),
                                     [](const Course& c) { return c.way == Way::constant; });
      course.way = fixed ? Way::constant : way_of_result(node, table, a);
      // Beyond its domain a root has no values, and nothing that its inverse could give back.
      if (has_domain(node.op) && (std::isnan(course.low) || std::isnan(course.high))) course.way = Way::unknown;
    }
    if (course.way != Way::unknown && !std::isnan(course.low) && !std::isnan(course.high))
      course.range = {std::min(course.low, course.high), std::max(course.low, course.high)};
    else if (course.way == Way::unknown)
      course.range = range_of(node.op, table, a[0].range, a[1].range, a[2].range);
    if (course.way == Way::constant && std::isnan(course.low)) course.way = Way::unknown;
  }
  if (courses.back().way != Way::unknown) return courses.back().way;
  if (std::isnan(at(part.expression, inside(part, 0.05))) || std::isnan(at(part.expression, inside(part, 0.95))))
    return Way::unknown;
  return way_by_slope(part.expression, low, high);
}

double Cutter::inside(const Part& part, double share) {
  if (std::isinf(part.low) && std::isinf(part.high)) return std::tan((share - 0.45) * 3.0);
  const double far = std::tan(share * 1.5);
  if (std::isinf(part.high)) return part.low + far * (part.low == 0.0 ? 1.0 : std::abs(part.low));
  if (std::isinf(part.low)) return part.high - far * (part.high == 0.0 ? 1.0 : std::abs(part.high));
  return part.low + share * (part.high - part.low);
}

std::vector<SymbolId> Cutter::varying(ExprId expression) const {
  std::vector<SymbolId> result;
  for (const SymbolId s : symbols_in(pool_, std::array{expression}))
    if (s != x_ && std::isnan(number_(s))) result.push_back(s);
  return result;
}

/// The first operator that changes with x abruptly, and none of whose arguments does; or an `if` with a condition
/// that does not depend on x at all.
std::optional<ExprId> Cutter::first_decision(ExprId root) const {
  const std::vector<ExprId> nodes = reachable(pool_, {&root, 1});
  const IdMap<std::uint32_t> position = positions(nodes);
  const std::vector<char> depends = with_x(nodes);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode& node = pool_[nodes[i]];
    if (depends[i] == 0) continue;
    if (decides(node.op)) return nodes[i];
    if (node.op == Op::select && depends[*position.find(ExprId(node.a))] == 0) return nodes[i];
  }
  return std::nullopt;
}

/// Takes from a part what its tables have no data for. False if that is not known. Inner tables come first, so that
/// those around them have an argument throughout.
bool Cutter::limit_to_data(Part& part) {
  const std::vector<ExprId> nodes = reachable(pool_, {&part.expression, 1});
  const std::vector<char> depends = with_x(nodes);
  for (std::size_t i = 0; i < nodes.size() && part.low < part.high; ++i) {
    const ExprNode node = pool_[nodes[i]];
    if (depends[i] == 0 || node.op != Op::table) continue;
    const ExprId argument(node.a);
    const Way way = way_of({argument, part.low, part.high, {}, {}});
    if (way != Way::rising && way != Way::falling) return false;
    const std::vector<double>& x = pool_.table(TableId(node.b)).x;
    const auto limit = [&](double end, bool low) {
      ExprId border;
      double root = kNothing;
      if (!zero_of(pool_.sub(argument, pool_.constant(end)), border, root)) return false;
      if (low ? root > part.low : root < part.high) {
        (low ? part.low : part.high) = root;
        (low ? part.low_border : part.high_border) = border;
      }
      return true;
    };
    const double first = x.front(), last = x.back();  // the pool grows
    if (!limit(first, way == Way::rising) || !limit(last, way == Way::falling)) return false;
  }
  return true;
}

/// What cannot be cut.
bool Cutter::hidden_kink(ExprId root) const {
  const std::vector<ExprId> nodes = reachable(pool_, {&root, 1});
  const std::vector<char> depends = with_x(nodes);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Op op = pool_[nodes[i]].op;
    if (depends[i] == 0) continue;
    if (is_rounding(op) || op == Op::mod || op == Op::der || is_logical(op) || (is_table(op) && op != Op::table))
      return true;
  }
  return false;
}

/// Puts both results of a part, cut at its decision, on @p open: the upper half first, so that the lower one is
/// taken up before it.
bool Cutter::divide(const Part& part, ExprId decision, std::vector<Part>& open) {
  const ExprNode node = pool_[decision];
  if (node.op == Op::select) {
    const double condition = at(ExprId(node.a), kNothing);
    if (std::isnan(condition)) return false;
    open.push_back(with_branch(part, decision, ExprId(condition != 0.0 ? node.b : node.c)));
    return true;
  }
  const ExprId guard = arity(node.op) == 2 ? pool_.sub(ExprId(node.a), ExprId(node.b)) : ExprId(node.a);
  ExprId border;
  double root = kNothing;
  if (!zero_of(guard, border, root)) return false;
  if (!(root > part.low && root < part.high)) {
    const ExprId branch = branch_of(node, at(guard, inside(part, 0.5)));
    if (branch.valid()) open.push_back(with_branch(part, decision, branch));
    return branch.valid();
  }
  Part lower = part, upper = part;
  lower.high = upper.low = root;
  lower.high_border = upper.low_border = border;
  const ExprId below = branch_of(node, at(guard, inside(lower, 0.5)));
  const ExprId above = branch_of(node, at(guard, inside(upper, 0.5)));
  if (!below.valid() || !above.valid()) return false;
  open.push_back(with_branch(upper, decision, above));
  open.push_back(with_branch(lower, decision, below));
  return true;
}

/// Where a guard changes its sign; NaN if it does not. False if that is not known.
bool Cutter::zero_of(ExprId guard, ExprId& border, double& root) {
  if (const auto form = linear_in(pool_, guard, x_)) {
    if (at(form->slope, kNothing) == 0.0) return true;
    border = pool_.neg(pool_.div(form->offset, form->slope));
    root = at(border, kNothing);
    return std::isfinite(root);
  }
  const auto inverse = invert(pool_, guard, x_, pool_.constant(0.0));
  if (!inverse) return false;
  border = *inverse;
  root = at(border, kNothing);  // NaN: beyond what the guard can be
  return true;
}

ExprId Cutter::branch_of(const ExprNode& node, double guard) {
  if (!(guard != 0.0) || std::isnan(guard)) return {};
  switch (node.op) {
    case Op::abs:
      return guard > 0.0 ? ExprId(node.a) : pool_.neg(ExprId(node.a));
    case Op::min:
      return ExprId(guard < 0.0 ? node.a : node.b);
    case Op::max:
      return ExprId(guard > 0.0 ? node.a : node.b);
    case Op::sign:
    case Op::step:
      return pool_.constant(apply(node.op, guard));
    default:
      return pool_.constant(apply(node.op, guard, 0.0));
  }
}

Part Cutter::with_branch(const Part& part, ExprId decision, ExprId branch) {
  std::unordered_map<ExprId, ExprId> now{{decision, branch}};
  arguments_first(
      pool_, part.expression, [&](ExprId e) { return now.contains(e); },
      [&](ExprId e) {
        const ExprNode node = pool_[e];
        now[e] = rebuilt(pool_, node, [&](ExprId a) { return now.at(a); });
      });
  Part result = part;
  result.expression = now.at(part.expression);
  return result;
}

bool Cutter::meet(const Part& lower, const Part& upper) const {
  constexpr double kSame = 1e-9;  // numbers of a law that are written with ten digits
  const auto value = [&](const Part& part) {
    const std::vector<ExprId> nodes = reachable(pool_, {&part.expression, 1});
    const IdMap<std::uint32_t> position = positions(nodes);
    std::vector<Rounded> values(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const ExprNode& node = pool_[nodes[i]];
      std::array<Rounded, 3> a{};
      std::size_t n = 0;
      for_each_argument(node, [&](ExprId argument) { a[n++] = values[*position.find(argument)]; });
      if (node.op == Op::constant)
        values[i] = rounded_constant(node.constant);
      else if (node.op == Op::symbol)
        values[i] = {SymbolId(node.a) == x_ ? upper.low : number_(SymbolId(node.a)), 0.0};
      else if (is_table(node.op))
        values[i] = apply_rounded(node.op, *pool_.tables()[node.b], a[0]);
      else
        values[i] = apply_rounded(node.op, a, n);
      if (node.op == Op::symbol) values[i].error = std::numeric_limits<double>::epsilon() * std::abs(values[i].value);
    }
    return values.back();
  };
  const Rounded a = value(lower), b = value(upper);
  return std::abs(a.value - b.value) <=
         4.0 * (a.error + b.error) + kSame * std::max(std::abs(a.value), std::abs(b.value));
}

/// By bounds of the slope over ever shorter stretches of x.
Way Cutter::way_by_slope(ExprId expression, double low, double high) {
  constexpr int kWork = 400;
  const auto partials = gradient(pool_, expression, [this](SymbolId s) { return s == x_; });
  if (partials.empty()) return Way::unknown;
  const ExprId slope = partials.front().second;
  const std::vector<ExprId> nodes = reachable(pool_, {&slope, 1});
  const IdMap<std::uint32_t> position = positions(nodes);
  std::vector<Range> values(nodes.size());
  std::vector<Range> open{{low, high}};
  Way result = Way::constant;
  for (int work = 0; !open.empty(); ++work) {
    if (work >= kWork) return Way::unknown;
    const Range x = open.back();
    open.pop_back();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const ExprNode& node = pool_[nodes[i]];
      std::array<Range, 3> a{};
      std::size_t n = 0;
      for_each_argument(node, [&](ExprId argument) { a[n++] = values[*position.find(argument)]; });
      const double fixed = node.op == Op::constant ? node.constant
                           : node.op == Op::symbol ? number_(SymbolId(node.a))
                                                   : 0.0;
      values[i] = node.op == Op::symbol && SymbolId(node.a) == x_ ? x
                  : node.op == Op::constant || node.op == Op::symbol
                      ? Range(fixed, fixed)
                      : range_of(node.op, is_table(node.op) ? pool_.tables()[node.b].get() : nullptr, a[0], a[1], a[2]);
    }
    const Range& s = values.back();
    const Way here = s.lower() > 0.0 ? Way::rising : s.upper() < 0.0 ? Way::falling : Way::unknown;
    if (here != Way::unknown) {
      if (result != Way::constant && here != result) return Way::unknown;
      result = here;
      continue;
    }
    const double middle = middle_of(x);
    if (!(middle > x.lower() && middle < x.upper())) return Way::unknown;
    open.emplace_back(x.lower(), middle);
    open.emplace_back(middle, x.upper());
  }
  return result;
}

}  // namespace bgsim
