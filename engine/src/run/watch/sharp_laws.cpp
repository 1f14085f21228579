#include "run/watch/sharp_laws.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "expression/graph.hpp"

namespace bgsim {

namespace {

/// A defect of so many tolerances is no error of the method that its own estimate could have let pass.
constexpr double kTolerances = 30.0;
/// Of the steps through a force that is narrower than its state is known, whose errors all go the same way.
constexpr double kNarrow = 3.0;
/// A state that nothing has moved yet: part of what the refused steps would have missed, in place of a tolerance.
constexpr double kUnseen = 1e-3;
/// What a rate is off when the states are off by their tolerances: so many times this is no part of the defect.
constexpr double kShaken = 3.0;
/// A defect of so many times what is allowed that is allowed for this reason alone, and is no small part of it, is
/// named in the report: a pulse narrower than its state is known. A small part is what cancels between large rates.
constexpr double kMuch = 100.0, kPart = 0.1;
/// So is one of this part of the state's own size: with a loose tolerance a hundred times what is allowed is more than
/// the state itself (a mass that passes a magnet, at 1e-3).
constexpr double kOfState = 0.1;
/// Where the work allowed runs out: the least part of a step, decided so far, that the step is cut to.
constexpr double kPrefix = 1.0 / 16.0;
/// Of a step of one length: part of the change of the rates from end to end that its error may be.
constexpr double kVisible = 1.0;

/// States off by their tolerances: all to one side, or in turn to either.
constexpr std::array<int, 4> kPatterns{0, 1, 2, 3};
double side_of(int pattern, std::size_t state) {
  if (pattern < 2) return pattern == 0 ? 1.0 : -1.0;
  return (pattern == 2) == (state % 2 == 0) ? 1.0 : -1.0;
}

double width(const Range& range) { return range.upper() - range.lower(); }

}  // namespace

bool may_be_sharp(const ExprPool& pool, const ExprNode& node) {
  switch (node.op) {
    case Op::constant:
    case Op::symbol:
    case Op::neg:
    case Op::add:
    case Op::sub:
    case Op::mul:
    case Op::select:
      return false;
    case Op::pow: {
      const double exponent = pool.is_constant(ExprId(node.b)) ? pool[ExprId(node.b)].constant : 0.0;
      return !(exponent == 2.0 || exponent == 3.0);
    }
    default:
      return !is_logical(node.op);
  }
}

VaryingSymbols varying_symbols(const Program& program) {
  VaryingSymbols varying{std::vector<char>(program.symbol_names.size(), 0), {}};
  varying.tears = varying.any;
  for (std::uint32_t slot = program.time_slot; slot < program.first_mode; ++slot) {
    const std::size_t symbol = program.pool.symbol_of(program.slot_expression[slot]).index();
    varying.any[symbol] = 1;
    if (slot >= program.first_tear) varying.tears[symbol] = 1;
  }
  return varying;
}

SharpLaws::SharpLaws(const Program& program, std::span<const double> parameters)
    : program_(program), largest_(program.state_names.size(), 0.0) {
  const ExprPool& pool = program.pool;
  const std::size_t states = program.state_names.size();
  std::vector<ExprId> roots;
  for (const std::uint32_t slot : program.rates.results) roots.push_back(program.slot_expression[slot]);
  for (const ProgramBlock& block : program.blocks)
    for (const std::uint32_t slot : block.residual.results) roots.push_back(program.slot_expression[slot]);
  const std::vector<ExprId> nodes = reachable(pool, roots);
  const IdMap<std::uint32_t> position = positions(nodes);
  const VaryingSymbols varying = varying_symbols(program);
  const std::vector<char> moves =
      depends_on(pool, nodes, position, [&](SymbolId symbol) { return varying.any[symbol.index()] != 0; });
  std::vector<char> sharp(nodes.size(), 0);
  bool in_loops = false;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ExprNode& node = pool[nodes[i]];
    if (node.op == Op::constant || node.op == Op::symbol || moves[i] == 0) continue;
    for_each_argument(node, [&](ExprId a) { sharp[i] |= sharp[*position.find(a)]; });
    const auto is_sharp = [&](std::uint32_t argument) { return sharp[*position.find(ExprId(argument))] != 0; };
    // What a sharp operator is multiplied by itself turns where that one only rises: 1 - tanh(x)^2.
    const bool turns =
        node.op == Op::pow ? is_sharp(node.a) : node.op == Op::mul && is_sharp(node.a) && is_sharp(node.b);
    // A quotient by what stands still is a product, which never bends: its powers are those of its dividend.
    const bool product = node.op == Op::div && moves[*position.find(ExprId(node.b))] == 0;
    if (product || (!may_be_sharp(pool, node) && !turns)) continue;
    sharp[i] = 1;
    sharp_.push_back(nodes[i]);
  }
  if (sharp_.empty()) return;
  for (std::size_t i = states; i < roots.size(); ++i) in_loops = in_loops || sharp[*position.find(roots[i])] != 0;
  const std::vector<char> by_loops =
      depends_on(pool, nodes, position, [&](SymbolId symbol) { return varying.tears[symbol.index()] != 0; });
  std::vector<ExprId> both = sharp_;
  for (std::uint32_t i = 0; i < states; ++i) {
    const std::uint32_t root = *position.find(roots[i]);
    if (sharp[root] == 0 && !(in_loops && by_loops[root] != 0)) continue;
    affected_.push_back(i);
    both.push_back(roots[i]);
  }
  find_operators_of_rates(roots, by_loops, position);
  // What turns within the arguments of sharp operators is watched with them: a square may be the same at both ends of a
  // step, and less between.
  std::vector<ExprId> watched = sharp_;
  for (const ExprId e : reachable(pool, sharp_)) {
    const ExprNode& node = pool[e];
    const auto varies_here = [&](std::uint32_t argument) { return moves[*position.find(ExprId(argument))] != 0; };
    const bool product = node.op == Op::mul && varies_here(node.a) && varies_here(node.b);
    const bool power = node.op == Op::pow && varies_here(node.a) && !may_be_sharp(pool, node);
    if (product || power) watched.push_back(e);
  }
  operators_.emplace(program, parameters, watched);
  screen_.emplace(*operators_);
  rates_too_.emplace(program, parameters, both);
  bends_.resize(sharp_.size());
}

/// By affected state: the sharp operators that its rate follows, those of all loops among them if it depends on a loop.
void SharpLaws::find_operators_of_rates(const std::vector<ExprId>& roots, const std::vector<char>& by_loops,
                                        const IdMap<std::uint32_t>& position) {
  constexpr std::size_t kMost = 1'000'000;  // pairs in all; beyond them every step is judged by its defect
  IdMap<std::uint32_t> which;
  for (std::uint32_t k = 0; k < sharp_.size(); ++k) which.insert(sharp_[k], k);
  const auto operators = [&](std::span<const ExprId> of) {
    std::vector<std::uint32_t> list;
    for (const ExprId e : reachable(program_.pool, of))
      if (const std::uint32_t* k = which.find(e)) list.push_back(*k);
    return list;
  };
  const std::size_t states = program_.state_names.size();
  const std::vector<std::uint32_t> in_loops = operators(std::span(roots).subspan(states));
  std::size_t pairs = 0;
  for (const std::uint32_t state : affected_) {
    std::vector<std::uint32_t> list = operators(std::span(&roots[state], 1));
    if (by_loops[*position.find(roots[state])] != 0) list.insert(list.end(), in_loops.begin(), in_loops.end());
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    pairs += list.size();
    operators_of_rate_.push_back(std::move(list));
    if (pairs <= kMost) continue;
    operators_of_rate_.clear();
    return;
  }
}

void SharpLaws::set_modes(std::span<const double> modes) {
  if (!any()) return;
  screen_->clear();
  operators_->set_modes(modes);
  rates_too_->set_modes(modes);
}

SharpLaws::Point SharpLaws::point_at(const SharpStep& step, double t) {
  Point point;
  point.t = t;
  y_.resize(step.unknowns);
  slopes_.resize(step.states);
  point.tears.resize(program_.tear_names.size());
  step.at(t, y_.data());
  point.good = step.rates(t, y_.data(), slopes_.data(), point.tears.data());
  if (!point.good) return point;
  point.rate = point.defect = slopes_;
  for (std::size_t i = 0; i < step.states; ++i) point.defect[i] -= polynomial_.at(i, t).second;
  return point;
}

/// Loops' variables that are no unknowns of the integrator are taken to lie between their values at the ends and in the
/// middle, and some way beyond: a quarter of the ends' difference, and twice as far as they are beside the mean.
void SharpLaws::enclose(const SharpStep& step, const Point& a, const Point& middle, const Point& b) {
  const std::vector<std::uint32_t>& states = rates_too_->states();
  const std::vector<std::uint32_t>& tears = rates_too_->tears();
  const bool given = step.unknowns > step.states;
  states_.resize(states.size());
  tears_.resize(tears.size());
  for (std::size_t k = 0; k < states.size(); ++k) states_[k] = polynomial_.over(states[k], a.t, b.t);
  for (std::size_t k = 0; k < tears.size(); ++k) {
    if (given) {
      tears_[k] = polynomial_.over(step.states + tears[k], a.t, b.t);
      continue;
    }
    const double left = a.tears[tears[k]], right = b.tears[tears[k]], at = middle.tears[tears[k]];
    const double beside = std::fabs(at - 0.5 * (left + right)), slope = (right - left) / (b.t - a.t);
    const double room = 0.25 * std::fabs(right - left) + 2.0 * beside;
    const double bent = std::fabs(slope) + 4.0 * beside / (b.t - a.t);
    tears_[k].middle = at;
    tears_[k].value = Range(std::min({left, at, right}) - room, std::max({left, at, right}) + room);
    tears_[k].slope = Range(slope - bent, slope + bent);
  }
  rates_too_->evaluate(a.t, b.t, states_, tears_);
}

/// Whether an operator bends over what was last enclosed.
bool SharpLaws::is_sharp() const {
  for (std::size_t k = 0; k < sharp_.size(); ++k)
    if (rates_too_->bends(k)) return true;
  return false;
}

/// Whether the ends of the step show what the operators make of it: none is sharp, or a rate follows one alone that is,
/// and that one only rises or only falls. Then the rate lies between its values at the ends as far as this operator
/// goes, and the integrator's own error test has seen these.
bool SharpLaws::ends_show_it(const SharpStep& step, double until) {
  const bool given = step.unknowns > step.states;
  if (!given && !operators_->tears().empty()) return false;
  unknowns_ = operators_->states();
  for (const std::uint32_t tear : operators_->tears())
    unknowns_.push_back(static_cast<std::uint32_t>(step.states) + tear);
  states_.resize(unknowns_.size());
  if (!unknowns_.empty()) polynomial_.take(step.begin, step.end, step.degree, unknowns_, step.unknowns, step.at);
  for (std::size_t k = 0; k < states_.size(); ++k) states_[k] = polynomial_.over(k, step.begin, until);
  const std::size_t count = operators_->states().size();
  operators_->evaluate(step.begin, until, std::span(states_).first(count), std::span(states_).subspan(count));
  std::fill(bends_.begin(), bends_.end(), 0);
  bool any_bends = false;
  for (std::size_t k = 0; k < sharp_.size(); ++k) {
    if (!operators_->bends(k)) continue;
    bends_[k] = is_monotone((*operators_)[k]) ? 1 : 2;
    any_bends = true;
  }
  if (!any_bends) return true;
  if (operators_of_rate_.empty()) return false;
  return std::all_of(operators_of_rate_.begin(), operators_of_rate_.end(), [this](const auto& operators) {
    int sum = 0;
    for (const std::uint32_t k : operators) sum += bends_[k];
    return sum <= 1;
  });
}

double SharpLaws::allowed(const SharpStep& step, std::size_t state, const Point& first, const Point& last) const {
  const double tolerances = step.begin < narrow_until_ ? kNarrow : kTolerances;
  double limit = tolerances * std::max(step.tolerance(state), kUnseen * step.relative * largest_[state]);
  if (step.fixed) {
    const double a = first.defect[state], b = last.defect[state];
    limit += kVisible * (last.t - first.t) *
             std::max({std::fabs(a), std::fabs(b), std::fabs(last.rate[state] - first.rate[state])});
  }
  return limit;
}

/// What the rates along a part of the step, of which the integrator knows the states to their tolerances only, may add
/// up to beyond what they do: a stiff rate is no better known than that.
void SharpLaws::add_error_of_states(const SharpStep& step, double from, double to, std::vector<double>& of_states) {
  const double t = from + (to - from) / 2;
  std::vector<double> moved(step.unknowns), rates(step.states), other(step.states), tears(program_.tear_names.size());
  y_.resize(step.unknowns);
  step.at(t, y_.data());
  if (!step.rates(t, y_.data(), rates.data(), tears.data())) return;
  std::vector<double> most(step.states, 0.0);
  for (const int pattern : kPatterns) {
    moved = y_;
    for (std::size_t i = 0; i < step.states; ++i) moved[i] += side_of(pattern, i) * step.tolerance(i);
    if (!step.rates(t, moved.data(), other.data(), tears.data())) continue;
    for (std::size_t i = 0; i < step.states; ++i) most[i] = std::max(most[i], std::fabs(other[i] - rates[i]));
  }
  for (std::size_t i = 0; i < step.states; ++i) of_states[i] += (to - from) * most[i];
}

/// The length of the step in units of the time in which the state forgets what it was wrong by.
double SharpLaws::forgetting(const SharpStep& step, double until, std::size_t state) {
  const double t = step.begin + (until - step.begin) / 2, change = step.tolerance(state);
  std::vector<double> y(step.unknowns), rates(step.states), other(step.states), tears(program_.tear_names.size());
  step.at(t, y.data());
  if (!step.rates(t, y.data(), rates.data(), tears.data())) return 0.0;
  y[state] += change;
  if (!(change > 0.0) || !step.rates(t, y.data(), other.data(), tears.data())) return 0.0;
  return (until - step.begin) * std::fabs(other[state] - rates[state]) / change;
}

/// In parts within which no operator is sharp; where the points run out, up to there.
SharpLaws::Sums SharpLaws::add_up(const SharpStep& step, Point first, Point last, std::span<const double> limit) {
  constexpr int kMostPoints = 400;
  constexpr double kSmall = 0.1;
  const double begin = first.t, end = last.t;
  Sums sums;
  sums.most.assign(affected_.size(), 0.0);
  std::vector<double> sum(affected_.size(), 0.0);
  std::vector<std::pair<Point, Point>> stack;
  stack.emplace_back(std::move(first), std::move(last));
  int points = 2;
  while (!stack.empty()) {
    auto [a, b] = std::move(stack.back());
    stack.pop_back();
    const double length = b.t - a.t, at = a.t + length / 2;
    const bool divisible = at > a.t && at < b.t;
    Point middle;
    const bool loops = step.unknowns == step.states && !rates_too_->tears().empty();
    if (loops && divisible) middle = point_at(step, at);
    if (loops && !middle.good) continue;
    enclose(step, a, middle, b);
    bool smooth = !is_sharp();
    if (!smooth) {
      smooth = true;
      for (std::size_t i = 0; i < affected_.size() && smooth; ++i)
        smooth = length * width((*rates_too_)[sharp_.size() + i].value) <= kSmall * limit[i];
      if (smooth && sums.parts.empty() && stack.empty()) return sums;  // the whole step
    }
    if (divisible && !loops) middle = point_at(step, at);
    ++points;
    if (!divisible || !middle.good) continue;
    const bool shortest = length <= 1e-13 * std::max(std::fabs(a.t), std::fabs(b.t));
    if (!smooth && !shortest) {
      if (points < kMostPoints) {
        stack.emplace_back(middle, std::move(b));
        stack.emplace_back(std::move(a), std::move(middle));
        continue;
      }
      if (!sums.undecided && a.t - begin >= kPrefix * (end - begin)) {
        sums.cut = true;
        break;
      }
    }
    // Over a few roundings of the time a range may be unknown because a difference is known to its roundings only (a
    // level that has just passed the crest, to the power of 1.5). What the rates are there is nothing.
    if (!smooth && shortest) {
      smooth = true;
      for (std::size_t i = 0; i < affected_.size() && smooth; ++i) {
        const std::uint32_t state = affected_[i];
        const double rate =
            std::max({std::fabs(a.rate[state]), std::fabs(middle.rate[state]), std::fabs(b.rate[state])});
        smooth = length * rate <= kSmall * limit[i];
      }
    }
    sums.undecided = sums.undecided || !smooth;
    for (std::size_t i = 0; i < affected_.size(); ++i) {
      const std::uint32_t state = affected_[i];
      sum[i] += length / 6.0 * (a.defect[state] + 4.0 * middle.defect[state] + b.defect[state]);
      sums.most[i] = std::max(sums.most[i], std::fabs(sum[i]));
    }
    sums.parts.push_back({a.t, b.t, sum});
  }
  return sums;
}

/// By affected state: by how much the defect of the whole step is larger when the states are off by their tolerances
/// all along. That of a stiff rate is, to one side; a force that is narrower than the tolerance of its state acts at
/// another time, and adds up to the same.
/// @return  infinity where that cannot be computed.
std::vector<double> SharpLaws::change_by_states(const SharpStep& step, double until, const Sums& sums,
                                                std::span<const double> limit) {
  std::vector<double> change(affected_.size(), 0.0), shift(step.states);
  std::vector<double> unknown(affected_.size(), std::numeric_limits<double>::infinity());
  SharpStep moved = step;
  moved.at = [&](double t, double* y) {
    step.at(t, y);
    for (std::size_t i = 0; i < step.states; ++i) y[i] += shift[i];
  };
  for (const int pattern : kPatterns) {
    for (std::size_t i = 0; i < step.states; ++i) shift[i] = side_of(pattern, i) * step.tolerance(i);
    polynomial_.take(step.begin, step.end, step.degree, all_, step.unknowns, moved.at);
    Point first = point_at(moved, step.begin), last = point_at(moved, until);
    if (!first.good || !last.good) return unknown;
    const Sums other = add_up(moved, std::move(first), std::move(last), limit);
    if (other.undecided || other.cut) return unknown;
    for (std::size_t i = 0; i < affected_.size(); ++i) change[i] = std::max(change[i], other.most[i] - sums.most[i]);
  }
  return change;
}

SharpLaws::Verdict SharpLaws::look(const SharpStep& step, double until) {
  constexpr double kStarts = 0.25;
  Verdict verdict;
  if (!any() || !(until > step.begin)) return verdict;
  if (!screen_->any_bends(step.ends) || ends_show_it(step, until)) return verdict;
  all_.resize(step.unknowns);
  std::iota(all_.begin(), all_.end(), 0U);
  polynomial_.take(step.begin, step.end, step.degree, all_, step.unknowns, step.at);
  Point first = point_at(step, step.begin), last = point_at(step, until);
  if (!first.good || !last.good) return verdict;

  std::vector<double> limit;
  for (const std::uint32_t state : affected_) limit.push_back(allowed(step, state, first, last));
  const Sums sums = add_up(step, std::move(first), std::move(last), limit);
  verdict.undecided = sums.undecided;
  const std::vector<double>& most = sums.most;
  const auto visible = [&](std::size_t i) { return kOfState * step.tolerance(affected_[i]) / step.relative; };
  bool large = false;
  for (std::size_t i = 0; i < affected_.size(); ++i) large = large || most[i] > std::min(limit[i], visible(i));
  std::vector<double> of_states(step.states, 0.0);
  if (large)
    for (const Sums::Part& part : sums.parts) add_error_of_states(step, part.from, part.to, of_states);
  const auto lets_pass = [&](std::size_t i) {
    return most[i] > limit[i] && !(most[i] > limit[i] + kShaken * of_states[affected_[i]]);
  };
  bool let_pass = false;
  for (std::size_t i = 0; i < affected_.size(); ++i) let_pass = let_pass || lets_pass(i);
  bool narrow = false;
  if (let_pass) {
    const std::vector<double> change = change_by_states(step, until, sums, limit);
    for (std::size_t i = 0; i < affected_.size(); ++i) {
      of_states[affected_[i]] = std::min(of_states[affected_[i]], change[i]);
      narrow = narrow || most[i] > limit[i] + kShaken * of_states[affected_[i]];
    }
  }
  double worst = 1.0;
  std::size_t which = 0;
  for (std::size_t i = 0; i < affected_.size(); ++i) {
    const std::uint32_t state = affected_[i];
    const double without = limit[i];
    if (!(most[i] > std::min(without, visible(i)))) continue;
    limit[i] += kShaken * of_states[state];
    if (most[i] > worst * limit[i]) {
      worst = most[i] / limit[i];
      which = i;
      verdict.state = state;
    } else if (!(worst > 1.0) && most[i] > kPart * of_states[state] &&
               most[i] > std::min(kMuch * without, visible(i)) * (1.0 + forgetting(step, until, state))) {
      verdict.undecided = true;
      verdict.state = state;
    }
  }
  if (!(worst > 1.0)) {
    if (sums.cut) verdict.shorter = sums.parts.back().to - step.begin;
    return verdict;
  }
  if (narrow) narrow_until_ = std::max(narrow_until_, until);
  for (std::size_t i = 0; i < affected_.size(); ++i)
    if (std::isfinite(most[i])) largest_[affected_[i]] = std::max(largest_[affected_[i]], most[i]);
  // Up to where it begins to matter; or, where it does from the beginning, as far as nothing is sharp.
  const double scale = kTolerances * kUnseen * step.relative * largest_[verdict.state];
  const double matters = kStarts * std::max(limit[which], scale);
  const double half = 0.5 * (until - step.begin);
  verdict.shorter = half;
  for (const Sums::Part& part : sums.parts) {
    if (!(std::fabs(part.sum[which]) > matters)) continue;
    const double before = part.from - step.begin;
    verdict.shorter = std::min(half, before > 0.0 ? before : part.to - step.begin);
    break;
  }
  return verdict;
}

bool SharpLaws::holds_until(const SharpStep& step, double end) {
  constexpr int kParts = 4;
  if (!(end > step.begin)) return true;
  all_.resize(step.unknowns);
  std::iota(all_.begin(), all_.end(), 0U);
  polynomial_.take(step.begin, step.end, step.degree, all_, step.unknowns, step.at);
  std::vector<double> sum(step.states, 0.0), of_states(step.states, 0.0);
  for (int k = 0; k <= 2 * kParts; ++k) {
    const double t = k == 2 * kParts ? end : step.begin + (end - step.begin) * k / (2 * kParts);
    const Point point = point_at(step, t);
    if (!point.good) return true;  // the search for events has its own words for that
    const double weight = (k == 0 || k == 2 * kParts ? 1.0
                           : k % 2 == 1              ? 4.0
                                                     : 2.0) *
                          (end - step.begin) / (6.0 * kParts);
    for (std::size_t i = 0; i < step.states; ++i) sum[i] += weight * point.defect[i];
  }
  const auto beyond = [&](std::size_t i) {
    return std::fabs(sum[i]) > kTolerances * step.tolerance(i) + kShaken * of_states[i];
  };
  bool holds = true;
  for (std::size_t i = 0; i < step.states; ++i) holds = holds && !beyond(i);
  if (holds) return true;
  for (int k = 0; k < kParts; ++k)
    add_error_of_states(step, step.begin + (end - step.begin) * k / kParts,
                        step.begin + (end - step.begin) * (k + 1) / kParts, of_states);
  for (std::size_t i = 0; i < step.states; ++i)
    if (beyond(i)) return false;
  return true;
}

}  // namespace bgsim
