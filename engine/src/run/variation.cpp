#include "run/variation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/codes.hpp"
#include "bgsim/text.hpp"
#include "run/failures.hpp"
#include "run/run.hpp"

namespace bgsim {
namespace {

/// Rates that differ by less are the same: laws by parts that meet where their condition changes.
constexpr double kSame = 1e-9;
/// Of the run's length: conditions that come to their borders within this time of the event begin it, others follow.
constexpr double kAtOnce = 1e-9;
/// Instants of one event whose derivatives differ by less are the same condition written in two ways.
constexpr double kSameInstant = 1e-6;

Diagnostic failure(const Program& program, std::optional<std::size_t> relation, double t, const std::string& what,
                   std::string rule, std::string help) {
  std::optional<Place> place;
  std::string where;
  if (relation) {
    const RelationFacts facts = relation_facts(program, *relation);
    place = facts.place;
    where = facts.text + " changes" + (facts.where.empty() ? "" : " (" + facts.where + ")") + ", ";
  }
  return diagnostic_of("BG414", "at t = " + number_text(t) + ": " + where + what, place, std::move(rule),
                       std::move(help));
}

/// How far the quantity that a relation depends on is from its border.
double off_border(const Evaluator& evaluator, const Relation& relation, double t, const std::vector<double>& x,
                  const Branch& branch) {
  const Program& program = evaluator.program();
  std::vector<double> values(program.symbol_names.size(), 0.0);
  const auto take = [&](std::uint32_t first, std::span<const double> from) {
    for (std::size_t i = 0; i < from.size(); ++i)
      values[program.pool.symbol_of(program.slot_expression[first + i]).index()] = from[i];
  };
  values[program.time.index()] = t;
  take(program.first_state, x);
  take(program.first_tear, branch.tears);
  take(program.first_mode, branch.modes);
  take(program.first_parameter, evaluator.constants().subspan(program.first_parameter, program.parameters.size()));
  const double value = evaluate(program.pool, relation.guard, values);
  switch (relation.kind) {
    case Relation::Kind::floor:
      return std::abs(value - std::round(value));
    case Relation::Kind::round:
      return std::abs(value + 0.5 - std::round(value + 0.5));
    case Relation::Kind::cell: {
      double nearest = std::numeric_limits<double>::infinity();
      for (const double knot : program.pool.table(relation.table).x)
        nearest = std::min(nearest, std::abs(value - knot));
      return nearest;
    }
    default:
      return std::abs(value);
  }
}

/// The same as a time, by the rate at which it changes.
bool at_border(const Evaluator& evaluator, const Relation& relation, double t, const std::vector<double>& x,
               const Branch& branch, double by_time, double within) {
  return off_border(evaluator, relation, t, x, branch) <= within * std::abs(by_time);
}

bool same_instant(double one, double other) {
  return std::abs(one - other) <= kSameInstant * std::max(std::abs(one), std::abs(other));
}

bool same_rates(const std::vector<double>& one, const std::vector<double>& other, std::size_t states) {
  for (std::size_t i = 0; i < states; ++i)
    if (!(std::abs(one[i] - other[i]) <= kSame * std::max(std::abs(one[i]), std::abs(other[i])))) return false;
  return true;
}

}  // namespace

/// Whether the conditions of one instant change any rate, alone or beside all others.
bool VariationEvents::matters(Evaluator& evaluator, double t, const std::vector<double>& x, const Branch& after,
                              double instant) const {
  const std::size_t n = evaluator.program().varied_states;
  std::vector<double> rates(x.size()), others(x.size());
  for (const bool first : {true, false}) {
    Branch without = first ? *start_ : after, with = without;
    for (const Change& change : changes_)
      if (same_instant(change.instant, instant)) with.modes[change.relation] = first ? change.after : change.before;
    if (!evaluator.rates(t, x.data(), without, rates.data()) || !evaluator.rates(t, x.data(), with, others.data()) ||
        !same_rates(rates, others, n))
      return true;
  }
  return false;
}

std::optional<Diagnostic> VariationEvents::begin(Evaluator& evaluator, double t, double span,
                                                 const std::vector<double>& x, const Branch& branch) {
  const Program& program = evaluator.program();
  std::vector<double> rates(x.size()), others(x.size()), crossings(2 * program.relations.size());
  Branch here = branch;
  if (!evaluator.rates(t, x.data(), here, rates.data()) || !evaluator.crossings(t, x.data(), here, crossings.data()))
    return std::nullopt;  // the run says what is wrong
  for (std::size_t r = 0; r < program.relations.size(); ++r) {
    const Relation& relation = program.relations[r];
    if (relation.kind == Relation::Kind::denominator || crossings[2 * r] == 0.0) continue;
    if (!at_border(evaluator, relation, t, x, here, crossings[2 * r + 1], kAtOnce * span)) continue;
    bool jumps = false;
    for (const double side : {-1.0, 1.0}) {
      Branch other = branch;
      double& mode = other.modes[r];
      if (relation.kind == Relation::Kind::sign)
        mode = side;
      else if (relation.kind == Relation::Kind::condition || relation.kind == Relation::Kind::step)
        mode = side > 0.0 ? 1.0 : 0.0;
      else if (relation.kind == Relation::Kind::cell)
        continue;  // its slope alone is another one
      else
        mode += side;
      jumps = jumps || !evaluator.rates(t, x.data(), other, others.data()) ||
              !same_rates(rates, others, program.varied_states);
    }
    if (jumps)
      return failure(program, r, t, "which is the start, and moves away from it with the parameter",
                     "what lies before the start has no part in the run, so the derivatives of both sides differ",
                     "begin on one side of the condition");
  }
  return std::nullopt;
}

std::optional<Diagnostic> VariationEvents::take(Evaluator& evaluator, double t, double span, std::vector<double>& x,
                                                const Branch& before, const Branch& after,
                                                std::optional<std::size_t> crossed) {
  const Program& program = evaluator.program();
  const std::size_t n = program.varied_states;
  std::vector<std::size_t> changed;
  for (std::size_t r = 0; r < program.relations.size(); ++r)
    if (program.relations[r].kind != Relation::Kind::denominator && before.modes[r] != after.modes[r])
      changed.push_back(r);
  if (changed.empty()) return std::nullopt;

  std::vector<double> left(x.size()), right(x.size()), crossings(2 * program.relations.size());
  Branch one = before, other = after;
  const bool known =
      evaluator.rates(t, x.data(), other, right.data()) && evaluator.rates(t, x.data(), one, left.data());
  if (!known || !evaluator.crossings(t, x.data(), one, crossings.data()))
    return failure(program, changed.front(), t, "and the equations have no value on one of its sides",
                   "sensitivities cross an event by the rates on both of its sides",
                   "write laws that have a value, and a slope, at the border of their condition");
  const bool jumps = !same_rates(left, right, n);
  if (!start_ || t - time_ > kAtOnce * span) {
    start_ = before;
    changes_.clear();
  }
  time_ = t;
  // What begins the event; conditions that change because rates have jumped follow it.
  std::vector<double> instants;
  for (const std::size_t r : changed) {
    const double by_parameter = crossings[2 * r], by_time = crossings[2 * r + 1];
    const bool begins = r == crossed || program.relations[r].time_only ||
                        at_border(evaluator, program.relations[r], t, x, one, by_time, kAtOnce * span);
    if (!begins) continue;
    const double moved = by_parameter == 0.0 && by_time == 0.0 ? std::nan("") : -by_parameter / by_time;
    if (std::isfinite(moved)) {
      changes_.push_back({r, moved, before.modes[r], after.modes[r]});
      instants.push_back(moved);
    } else if (jumps) {
      return failure(program, r, t, "its border is touched and not passed, and the rates jump there",
                     "the instant of such an event has no derivative", "ask for the sensitivity of a run without it");
    }
  }
  // Where conditions change together that another value of the parameter would part, all but one must be of no
  // consequence.
  std::optional<double> instant;
  if (!instants.empty()) instant = instants.front();
  const bool apart = std::any_of(changes_.begin(), changes_.end(), [&](const Change& change) {
    return !same_instant(change.instant, changes_.front().instant);
  });
  if (apart) {
    std::optional<Change> decides;
    for (const Change& change : changes_) {
      if (decides && same_instant(decides->instant, change.instant)) continue;
      if (!matters(evaluator, t, x, after, change.instant)) continue;
      if (decides)
        return failure(program, change.relation, t,
                       "and so does " + relation_facts(program, decides->relation).text +
                           " at the same time, but not with another value of the parameter",
                       "there is no derivative where the order of two events changes",
                       "ask for it at a slightly different value, at which the two are apart");
      decides = change;
    }
    if (decides) instant = decides->instant;
  }
  if (!jumps) return std::nullopt;
  if (!instant)
    return failure(program, changed.front(), t, "and it is not known what set it off",
                   "sensitivities cross an event by the instant of its condition",
                   "write the condition over quantities that do not jump");
  for (std::size_t i = 0; i < n; ++i) x[n + i] += (left[i] - right[i]) * *instant;
  return std::nullopt;
}

Diagnostic held_variation_failure(const Program& program, double t) {
  return failure(program, {}, t, "dry friction holds, and sensitivities are not found while it does",
                 "a sign that is held at zero is no expression of the states",
                 "write the friction with tanh(f/f0), whose sensitivities are found");
}

Diagnostic ended_law_failure(double t) {
  return diagnostic_of("BG414", "at t = " + number_text(t) + ": a law ends where its own condition changes", {},
                       "there its slope has no bound, and sensitivities are not found",
                       "write a law with a bounded slope (ssqrt(x, d))");
}

bool Run::vary_event(const Branch& before, std::optional<std::size_t> crossed) {
  std::optional<std::size_t> relation;
  if (crossed) relation = evaluator_.guard_relation(*crossed);
  auto refused = variations_.take(evaluator_, t_, inputs_.stop - inputs_.start, x_, before, branch_, relation);
  return !refused || fail(std::move(*refused));
}

}  // namespace bgsim
