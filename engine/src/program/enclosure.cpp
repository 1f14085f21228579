#include "program/enclosure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "expression/apply.hpp"
#include "expression/graph.hpp"
#include "expression/table_cell.hpp"
#include "program/enclosure_often.hpp"

namespace bgsim {

namespace {

constexpr std::uint32_t kNowhere = std::numeric_limits<std::uint32_t>::max();
const Range kZero(0.0, 0.0), kOne(1.0, 1.0);
using often::both;
using often::is_bounded;
using often::is_zero;

Range f(Op op, const Range& a) { return range_of(op, nullptr, a, kZero, kZero); }
Range f(Op op, const Range& a, const Range& b) { return range_of(op, nullptr, a, b, kZero); }

Jet constant_jet(double value) { return {value, {value, value}, kZero, 0.0, kZero}; }

/// All numbers for an empty range, or one with an end that is none.
Range or_unknown(const Range& x) { return is_empty(x) ? kAllNumbers : x; }
/// Zero times anything is zero: what stands still has no slope, however steep the operator is there.
Range product(const Range& a, const Range& b) { return is_zero(a) || is_zero(b) ? kZero : or_unknown(a * b); }
Range quotient(const Range& a, const Range& b) {
  if (is_zero(a)) return kZero;
  return b.lower() > 0.0 || b.upper() < 0.0 ? or_unknown(a / b) : kAllNumbers;
}
Range square(const Range& a) { return f(Op::pow, a, Range(2.0, 2.0)); }

/// Partial derivative of an operator of one argument; @p v are its own values.
Range partial(Op op, const Table* table, const Range& a, const Range& v) {
  switch (op) {
    case Op::neg:
      return {-1.0, -1.0};
    case Op::abs:
      return a.lower() >= 0.0 ? kOne : a.upper() <= 0.0 ? Range(-1.0, -1.0) : Range(-1.0, 1.0);
    case Op::sqrt:
      return quotient(kOne, 2.0 * v);
    case Op::cbrt:
      return quotient(kOne, 3.0 * square(v));
    case Op::exp:
      return v;
    case Op::log:
      return quotient(kOne, a);
    case Op::log10:
      return quotient(kOne, std::numbers::ln10 * a);
    case Op::sin:
      return f(Op::cos, a);
    case Op::cos:
      return -f(Op::sin, a);
    case Op::tan:
      return 1.0 + square(v);
    case Op::asin:
      return quotient(kOne, f(Op::sqrt, 1.0 - square(a)));
    case Op::acos:
      return quotient(Range(-1.0, -1.0), f(Op::sqrt, 1.0 - square(a)));
    case Op::atan:
      return quotient(kOne, 1.0 + square(a));
    case Op::sinh:
      return f(Op::cosh, a);
    case Op::cosh:
      return f(Op::sinh, a);
    case Op::tanh: {  // 1 - tanh^2, which would cancel far from zero
      const Range hyperbolic = f(Op::cosh, a);
      return quotient(kOne, square(hyperbolic));
    }
    case Op::asinh:
      return quotient(kOne, f(Op::hypot, a, kOne));
    case Op::acosh:
      return quotient(kOne, f(Op::sqrt, square(a) - 1.0));
    case Op::atanh:
      return quotient(kOne, 1.0 - square(a));
    case Op::log1p:
      return quotient(kOne, 1.0 + a);
    case Op::expm1:
      return f(Op::exp, a);
    case Op::table:
      return range_of(Op::table_slope, table, a, kZero, kZero);
    case Op::table_slope:
      return range_of(Op::table_curvature, table, a, kZero, kZero);
    case Op::table_curvature:
      return range_of(Op::table_third, table, a, kZero, kZero);
    default:
      return is_thin(v) ? kZero : kAllNumbers;  // steps, which are frozen wherever they vary
  }
}

/// Second derivative along the stretch, and slope in its middle, by the chain rule; @p by_a is the partial derivative
/// of an operator of one argument. Of other operators nothing is known.
void bend_along(Op op, const Jet& a, const Jet& b, const Range& by_a, Jet& out) {
  out.curve = kAllNumbers;
  out.middle_slope = 0.0;
  if (!is_bounded(a.curve)) return;
  const auto take = [&out](double slope, const Range& curve) {
    out.middle_slope = slope;
    out.curve = or_unknown(curve);
  };
  switch (op) {
    case Op::neg:
      return take(-a.middle_slope, -a.curve);
    case Op::add:
      return take(a.middle_slope + b.middle_slope, a.curve + b.curve);
    case Op::sub:
      return take(a.middle_slope - b.middle_slope, a.curve - b.curve);
    case Op::mul:
      if (!is_bounded(b.curve)) return;
      return take(a.middle_slope * b.middle + a.middle * b.middle_slope,
                  product(a.curve, b.value) + product(a.value, b.curve) + 2.0 * product(a.slope, b.slope));
    case Op::div:
      if (is_zero(b.slope) && is_thin(b.value)) take(a.middle_slope / b.middle, quotient(a.curve, b.value));
      return;
    case Op::sin:
      return take(std::cos(a.middle) * a.middle_slope, product(by_a, a.curve) - product(out.value, square(a.slope)));
    case Op::cos:
      return take(-std::sin(a.middle) * a.middle_slope, product(by_a, a.curve) - product(out.value, square(a.slope)));
    case Op::exp:
      return take(out.middle * a.middle_slope, product(out.value, a.curve + square(a.slope)));
    default:
      return;
  }
}

/// Of what an operator is, so much that it is not to be called linear.
bool is_much(double bend, const Range& value) {
  constexpr double kBends = 0.25;
  const double magnitude = std::max(std::fabs(value.lower()), std::fabs(value.upper()));
  return !(bend <= kBends * magnitude) || !std::isfinite(magnitude);
}

}  // namespace

Jet time_jet(double begin, double end) { return {begin + (end - begin) / 2, {begin, end}, kOne, 1.0, kZero}; }

Enclosure::Enclosure(const Program& program, std::span<const double> parameters, std::span<const ExprId> roots) {
  enum Level : char { fixed, by_modes, varying };
  const ExprPool& pool = program.pool;
  const std::vector<ExprId> nodes = reachable(pool, roots);
  std::vector<std::uint32_t> slot_of_symbol(program.symbol_names.size(), kNowhere);
  const std::size_t inputs = program.first_parameter + program.parameters.size();
  for (std::uint32_t slot = 0; slot < inputs; ++slot)
    slot_of_symbol[pool.symbol_of(program.slot_expression[slot]).index()] = slot;
  const auto cell_relation = [&](const ExprNode& node) {
    for (std::uint32_t i = 0; i < program.relations.size(); ++i)
      if (const Relation& r = program.relations[i];
          r.kind == Relation::Kind::cell && r.guard == ExprId(node.a) && r.table == TableId(node.b))
        return i;
    return kNowhere;
  };

  IdMap<std::uint32_t> at;  // by position in `nodes`
  for (std::uint32_t i = 0; i < nodes.size(); ++i) at.insert(nodes[i], i);
  std::vector<Level> level(nodes.size(), fixed);
  std::vector<std::uint32_t> cell(nodes.size(), kNowhere);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode& node = pool[nodes[i]];
    if (node.op == Op::symbol) {
      const std::uint32_t slot = slot_of_symbol[node.a];
      if (slot >= program.first_mode && slot < program.first_parameter)
        level[i] = by_modes;
      else if (slot < program.first_mode)
        level[i] = varying;
      continue;
    }
    if (node.op == Op::constant) continue;
    for_each_argument(node, [&](ExprId a) { level[i] = std::max(level[i], level[*at.find(a)]); });
    if (is_table(node.op)) cell[i] = cell_relation(node);
    if (cell[i] != kNowhere) level[i] = std::max(level[i], by_modes);
  }

  // Positions: by level, and within a level as in `nodes`, so that arguments come first.
  std::vector<std::uint32_t> position(nodes.size());
  std::uint32_t next = 0;
  const auto place = [&](Level which) {
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (level[i] == which) position[i] = next++;
  };
  place(fixed);
  std::vector<std::uint32_t> cell_position(program.relations.size(), kNowhere);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (cell[i] != kNowhere && cell_position[cell[i]] == kNowhere) {
      cell_position[cell[i]] = next++;
      modes_.emplace_back(cell_position[cell[i]], cell[i]);
    }
  place(by_modes);
  first_varying_ = next;
  place(varying);
  jets_.resize(next);

  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode& node = pool[nodes[i]];
    const std::uint32_t out = position[i];
    if (node.op == Op::constant || node.op == Op::symbol) {
      const std::uint32_t slot = node.op == Op::symbol ? slot_of_symbol[node.a] : kNowhere;
      if (node.op == Op::constant) {
        jets_[out] = constant_jet(node.constant);
      } else if (level[i] == fixed) {
        jets_[out] = constant_jet(slot == kNowhere ? 0.0 : parameters[slot - program.first_parameter]);
      } else if (level[i] == by_modes) {
        modes_.emplace_back(out, slot - program.first_mode);
      } else if (slot == program.time_slot) {
        at_time_ = out;
      } else if (slot >= program.first_tear) {
        tears_.push_back(slot - program.first_tear);
      } else {
        states_.push_back(slot - program.first_state);
      }
      continue;
    }
    Node step{node.op, 0, 0, 0, out, 0, nullptr, arity(node.op), 0, kNowhere};
    std::uint32_t* places[] = {&step.a, &step.b, &step.c};
    std::size_t n = 0;
    for_each_argument(node, [&](ExprId a) { *places[n++] = position[*at.find(a)]; });
    if (is_table(node.op)) step.table = &pool.table(TableId(node.b));
    reads_records_ = reads_records_ || (step.table != nullptr && step.table->delayed);
    step.cell = cell[i] == kNowhere ? kNowhere : cell_position[cell[i]];
    if (level[i] == fixed) {
      run(step, 0.0);
      continue;
    }
    if (level[i] == varying) take_rule(step);
    (level[i] == by_modes ? of_modes_ : varying_).push_back(step);
  }
  std::sort(states_.begin(), states_.end());
  std::sort(tears_.begin(), tears_.end());
  at_state_.resize(states_.size());
  at_tear_.resize(tears_.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode& node = pool[nodes[i]];
    if (node.op != Op::symbol || level[i] != varying) continue;
    const std::uint32_t slot = slot_of_symbol[node.a];
    if (slot == program.time_slot) continue;
    const bool tear = slot >= program.first_tear;
    const std::vector<std::uint32_t>& list = tear ? tears_ : states_;
    const std::uint32_t which = slot - (tear ? program.first_tear : program.first_state);
    const auto k = std::lower_bound(list.begin(), list.end(), which) - list.begin();
    (tear ? at_tear_ : at_state_)[static_cast<std::size_t>(k)] = position[i];
  }
  for (const ExprId root : roots) {
    const std::uint32_t out = position[*at.find(root)];
    position_of_root_.push_back(out);
    const auto node = std::lower_bound(varying_.begin(), varying_.end(), out,
                                       [](const Node& n, std::uint32_t which) { return n.out < which; });
    const bool found = node != varying_.end() && node->out == out;
    node_of_root_.push_back(found ? static_cast<std::uint32_t>(node - varying_.begin()) : kNowhere);
    if (!found || static_cast<often::Rule>(node->rule) != often::Rule::general) continue;
    varying_[node_of_root_.back()].kept = static_cast<std::uint32_t>(kept_.size());
    kept_.emplace_back();
  }
}

void Enclosure::set_modes(std::span<const double> modes) {
  for (const auto& [position, relation] : modes_) jets_[position] = constant_jet(modes[relation]);
  for (const Node& node : of_modes_) run(node, 0.0);
}

void Enclosure::put(double begin, double end, std::span<const Jet> states, std::span<const Jet> tears) {
  if (at_time_ != kNowhere) jets_[at_time_] = time_jet(begin, end);
  for (std::size_t i = 0; i < states.size(); ++i) jets_[at_state_[i]] = states[i];
  for (std::size_t i = 0; i < tears.size(); ++i) jets_[at_tear_[i]] = tears[i];
}

void Enclosure::move_modes(std::span<const MovingMode> modes, double half) {
  for (const auto& [position, relation] : modes_)
    for (const MovingMode& moving : modes)
      if (moving.relation == relation) jets_[position] = moving.over;
  for (const Node& node : of_modes_) run(node, half);
}

void Enclosure::evaluate_apart(double begin, double end, std::span<const Jet> states, std::span<const Jet> tears,
                               std::span<const MovingMode> modes) {
  put(begin, end, states, tears);
  move_modes(modes, kInfinity);
  for (const Node& node : varying_) run(node, kInfinity);
}

void Enclosure::evaluate(double begin, double end, std::span<const Jet> states, std::span<const Jet> tears,
                         std::span<const MovingMode> modes) {
  put(begin, end, states, tears);
  const double half = (end - begin) / 2;
  if (!modes.empty()) {
    move_modes(modes, half);
    for (const Node& node : varying_) run(node, half);  // the rules below are for modes that rest
    return;
  }
  for (const Node& node : varying_) {
    const auto rule = static_cast<often::Rule>(node.rule);
    const bool swapped = rule == often::Rule::scaled || rule == often::Rule::sum_right_still;
    const std::uint32_t moves = swapped && node.a < first_varying_ ? node.b : node.a;
    const std::uint32_t other = moves == node.a ? node.b : node.a;
    if (half == 0.0 || !often::run(rule, jets_[moves], jets_[other], half, jets_[node.out])) run(node, half);
  }
}

/// Which of the rules for what laws are mostly made of is the operator's.
void Enclosure::take_rule(Node& node) const {
  using often::Rule;
  const bool a_moves = node.a >= first_varying_, b_moves = node.b >= first_varying_;
  Rule rule = Rule::general;
  if (node.op == Op::neg)
    rule = Rule::negative;
  else if (node.op == Op::add)
    rule = a_moves && b_moves ? Rule::sum : Rule::sum_right_still;
  else if (node.op == Op::sub)
    rule = a_moves && b_moves ? Rule::difference : a_moves ? Rule::difference_right_still : Rule::difference_left_still;
  else if (node.op == Op::mul && node.a != node.b)
    rule = a_moves && b_moves ? Rule::product : Rule::scaled;
  else if (node.op == Op::div && !b_moves)
    rule = Rule::divided;
  node.rule = static_cast<std::uint8_t>(rule);
}

void Enclosure::evaluate_box(const Range& time, std::span<const Range> unknowns) {
  const auto jet = [](const Range& range) {
    Jet over;
    over.middle = range.lower() + (range.upper() - range.lower()) / 2;
    over.value = range;
    return over;
  };
  if (at_time_ != kNowhere) jets_[at_time_] = jet(time);
  std::size_t k = 0;
  for (const std::uint32_t at : at_state_) jets_[at] = jet(unknowns[k++]);
  for (const std::uint32_t at : at_tear_) jets_[at] = jet(unknowns[k++]);
  for (const Node& node : varying_) run(node, 0.0);
}

void Enclosure::evaluate_point(double t, std::span<const double> states, std::span<const double> tears) {
  if (at_time_ != kNowhere) jets_[at_time_].middle = t;
  for (std::size_t i = 0; i < states.size(); ++i) jets_[at_state_[i]].middle = states[i];
  for (std::size_t i = 0; i < tears.size(); ++i) jets_[at_tear_[i]].middle = tears[i];
  for (const Node& node : varying_) {
    const double a = jets_[node.a].middle;
    double& out = jets_[node.out].middle;
    if (node.op == Op::select)
      out = apply(Op::select, a, jets_[node.b].middle, jets_[node.c].middle);
    else if (node.table == nullptr)
      out = apply_often(node.op, a, jets_[node.b].middle, 0.0);
    else if (node.cell == kNowhere)
      out = apply_table(node.op, *node.table, a);
    else if (node.op == Op::table)
      out = value_in_cell(*node.table, a, jets_[node.cell].middle);
    else
      out = slope_in_cell(*node.table, a, jets_[node.cell].middle);
  }
}

Enclosure::Partials Enclosure::partials(const Node& node, const Range& a, const Range& b, const Range& v) const {
  if (node.table != nullptr && node.cell != kNowhere) {
    const double cell = jets_[node.cell].middle;
    if (node.op != Op::table) return {kZero, kZero};
    const double slope = slope_in_cell(*node.table, a.lower(), cell);
    return {Range(slope, slope), kZero};
  }
  if (node.arguments < 2) return {or_unknown(partial(node.op, node.table, a, v)), kZero};
  switch (node.op) {
    case Op::add:
      return {kOne, kOne};
    case Op::sub:
      return {kOne, Range(-1.0, -1.0)};
    case Op::mul:
      return {b, a};
    case Op::div:
      return {quotient(kOne, b), quotient(-v, b)};
    case Op::pow: {
      if (!is_thin(b)) return {quotient(product(b, v), a), product(v, f(Op::log, a))};
      const Range less(b.lower() - 1.0, b.lower() - 1.0);
      return {product(b, or_unknown(f(Op::pow, a, less))), kAllNumbers};
    }
    case Op::min:
    case Op::max: {
      const bool least = node.op == Op::min;
      if (a.upper() <= b.lower()) return least ? Partials{kOne, kZero} : Partials{kZero, kOne};
      if (b.upper() <= a.lower()) return least ? Partials{kZero, kOne} : Partials{kOne, kZero};
      return {Range(0.0, 1.0), Range(0.0, 1.0)};
    }
    case Op::atan2: {
      const Range size = square(a) + square(b);
      return {quotient(b, size), quotient(-a, size)};
    }
    case Op::hypot:
      return {quotient(a, v), quotient(b, v)};
    case Op::ssqrt: {
      const Range h = f(Op::hypot, a, b), root = f(Op::sqrt, h);
      // |a/h| and |b/h| are at most 1, which a quotient of intervals does not know
      const Range one(-1.0, 1.0);
      const Range sine = both(quotient(a, h), one), cosine = both(quotient(b, h), one);
      return {quotient(1.0 - 0.5 * square(sine), root), quotient(-0.5 * (sine * cosine), root)};
    }
    default:
      return is_thin(v) ? Partials{kZero, kZero} : Partials{kAllNumbers, kAllNumbers};
  }
}

void Enclosure::run(const Node& node, double half) {
  const Jet& a = jets_[node.a];
  Jet& out = jets_[node.out];
  const int n = node.arguments;
  if (node.op == Op::select) {
    const Jet &b = jets_[node.b], &c = jets_[node.c];
    if (is_thin(a.value) && !operators::is_held(a.value.lower())) {
      out = a.value.lower() != 0.0 ? b : c;
    } else {
      out = {apply(Op::select, a.middle, b.middle, c.middle), or_unknown(hull(b.value, c.value)), kAllNumbers, 0.0,
             kAllNumbers};
    }
    return;
  }
  if (node.table != nullptr && node.cell != kNowhere) {  // a straight line as far as the mode says, and beyond
    const double cell = jets_[node.cell].middle;
    if (node.op == Op::table) {
      const double left = value_in_cell(*node.table, a.value.lower(), cell);
      const double right = value_in_cell(*node.table, a.value.upper(), cell);
      out.middle = value_in_cell(*node.table, a.middle, cell);
      out.value =
          std::isnan(left) || std::isnan(right) ? kAllNumbers : Range(std::min(left, right), std::max(left, right));
    } else {
      out.middle = slope_in_cell(*node.table, a.middle, cell);
      out.value = Range(out.middle, out.middle);
    }
  } else {
    const Jet& b = jets_[node.b];
    out.middle = node.table != nullptr ? apply_table(node.op, *node.table, a.middle)
                                       : apply(node.op, a.middle, n > 1 ? b.middle : 0.0);
    const bool squared = node.op == Op::mul && node.a == node.b;
    out.value = squared ? square(a.value) : or_unknown(range_of(node.op, node.table, a.value, b.value, kZero));
  }
  if (node.kept != kNowhere) kept_[node.kept].known = false;
  if (half == 0.0) {  // over a box, or of what stands still, whose arguments have no slopes
    out.slope = kZero;
    out.middle_slope = 0.0;
    out.curve = kZero;
    return;
  }
  const Jet& b = jets_[node.b];
  Partials d;
  switch (node.op) {
    case Op::add:
      out.slope = a.slope + b.slope;
      break;
    case Op::sub:
      out.slope = a.slope - b.slope;
      break;
    default: {
      d = partials(node, a.value, b.value, out.value);
      out.slope = product(d.a, a.slope);
      if (n > 1 && !is_zero(b.slope)) out.slope = or_unknown(out.slope + product(d.b, b.slope));
    }
  }
  bend_along(node.op, a, b, d.a, out);
  const double low = out.value.lower(), high = out.value.upper();
  if (n > 1 && half != kInfinity) often::narrow(a, b, half, out);
  if (node.kept != kNowhere) kept_[node.kept] = {d, low == out.value.lower() && high == out.value.upper()};
}

bool Enclosure::is_record(std::size_t root) const {
  const Node* node = node_of(root);
  return node != nullptr && node->table != nullptr && node->table->delayed;
}

const Enclosure::Node* Enclosure::node_of(std::size_t root) const {
  const std::uint32_t which = node_of_root_[root];
  return which == kNowhere ? nullptr : &varying_[which];
}

double Enclosure::argument(std::size_t root, int which) const {
  const Node* node = node_of(root);
  if (node == nullptr || which >= node->arguments) return 0.0;
  return jets_[which == 0 ? node->a : node->b].middle;
}

double Enclosure::bend(const Node& node, const Range& a, const Range& b, const Range& v) const {
  if (node.op == Op::add || node.op == Op::sub || node.op == Op::select) return 0.0;
  return bend(node, a, b, partials(node, a, b, v));
}

double Enclosure::bend(const Node& node, const Range& a, const Range& b, const Partials& d) {
  const auto part = [](const Range& slope, const Range& argument) {
    const double moved = argument.upper() - argument.lower();
    return moved == 0.0 ? 0.0 : 0.25 * (slope.upper() - slope.lower()) * moved;
  };
  double sum = part(d.a, a);
  if (node.arguments > 1) sum += part(d.b, b);
  return std::isnan(sum) ? kInfinity : sum;
}

double Enclosure::bend(std::size_t root) const {
  const Node* node = node_of(root);
  if (node == nullptr) return 0.0;
  const Range &a = jets_[node->a].value, &b = jets_[node->b].value;
  const bool known = node->kept != kNowhere && kept_[node->kept].known;
  const bool has_partials = node->op != Op::add && node->op != Op::sub && node->op != Op::select;
  return known && has_partials ? bend(*node, a, b, kept_[node->kept].partials)
                               : bend(*node, a, b, jets_[node->out].value);
}

bool Enclosure::bends(std::size_t root) const { return is_much(bend(root), jets_[position_of_root_[root]].value); }

bool Enclosure::bends(std::size_t root, const Range& a, const Range& b) const {
  const Node* node = node_of(root);
  if (node == nullptr) return false;
  const Range& second = node->b < first_varying_ ? jets_[node->b].value : b;
  const Range v = or_unknown(range_of(node->op, node->table, a, second, kZero));
  return is_much(bend(*node, a, second, v), v);
}

}  // namespace bgsim
