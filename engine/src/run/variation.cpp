#include "run/variation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "base/codes.hpp"
#include "bgsim/text.hpp"
#include "run/failures.hpp"
#include "run/run.hpp"
#include "run/sink/trajectory.hpp"

namespace bgsim {
namespace {

/// Rates that differ by less are the same: laws by parts that meet where their condition changes.
constexpr double kSame = 1e-9;
/// Of the run's length: conditions that come to their borders within this time of the event begin it, others follow.
constexpr double kAtOnce = 1e-9;
/// Of the time: what rounding leaves of a known one, and samples are taken early by.
constexpr double kLocated = 1e-12;
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

/// Derivatives of two instants by the same: how far they are apart, in all, is nothing beside what they are.
bool same_instant(const GuardSlopes& guards, const std::vector<double>& one, const std::vector<double>& other) {
  double apart = 0.0, size = 0.0;
  const auto at = [](const std::vector<double>& instant, std::size_t i) { return instant.empty() ? 0.0 : instant[i]; };
  for (std::size_t i = 0; i < std::max(one.size(), other.size()); ++i) {
    apart += guards.unit(i) * std::abs(at(one, i) - at(other, i));
    size += guards.unit(i) * std::max(std::abs(at(one, i)), std::abs(at(other, i)));
  }
  return apart <= kSameInstant * size;
}

/// The branch with one relation on its other side, or on the next ones below and above. A cell of a table has none: its
/// slope alone is another one.
std::vector<Branch> other_sides(const Relation& relation, std::size_t r, const Branch& branch) {
  using Kind = Relation::Kind;
  std::vector<Branch> result;
  if (relation.kind == Kind::cell) return result;
  const double mode = branch.modes[r];
  const bool two = relation.kind == Kind::condition || relation.kind == Kind::step;
  for (const double other : two                           ? std::array{0.0, 1.0}
                            : relation.kind == Kind::sign ? std::array{-1.0, 1.0}
                                                          : std::array{mode - 1.0, mode + 1.0}) {
    if (other == mode) continue;
    result.push_back(branch);
    result.back().modes[r] = other;
  }
  return result;
}

/// A difference that moves a state by as little of itself over the whole scene is none, either: where a flow turns back
/// its rate is 0 on both sides, and what is left of it rounding.
bool same_rates(const std::vector<double>& one, const std::vector<double>& other, std::span<const double> x,
                double span) {
  for (std::size_t i = 0; i < one.size(); ++i) {
    const double least = i < x.size() && span > 0.0 ? std::abs(x[i]) / span : 0.0;
    if (!(std::abs(one[i] - other[i]) <= kSame * std::max({std::abs(one[i]), std::abs(other[i]), least}))) return false;
  }
  return true;
}

}  // namespace

/// Of all states, the first of which are looked at, and of outputs.
bool VariationEvents::rates(Evaluator& evaluator, double t, const std::vector<double>& x, Branch& branch,
                            std::vector<double>& values) const {
  values.resize(x.size());
  if (!evaluator.rates(t, x.data(), branch, values.data())) return false;
  values.resize(states_ + (with_outputs_ ? evaluator.program().output_names.size() : 0));
  return !with_outputs_ || evaluator.outputs(t, x.data(), branch, values.data() + states_);
}

/// Whether the conditions of one instant change any rate, alone or beside all others.
bool VariationEvents::matters(Evaluator& evaluator, const GuardSlopes& guards, double t, const std::vector<double>& x,
                              const Branch& after, const std::vector<double>& instant) const {
  std::vector<double> own, others;
  for (const bool first : {true, false}) {
    Branch without = first ? *start_ : after, with = without;
    for (const Change& change : changes_)
      if (same_instant(guards, change.instant, instant))
        with.modes[change.relation] = first ? change.after : change.before;
    if (!rates(evaluator, t, x, without, own) || !rates(evaluator, t, x, with, others) ||
        !same_rates(own, others, std::span(x).first(states_), span_))
      return true;
  }
  return false;
}

std::optional<Diagnostic> VariationEvents::begin(Evaluator& evaluator, GuardSlopes& guards, double t,
                                                 const std::vector<double>& x, const Branch& branch, bool sets) {
  const Program& program = evaluator.program();
  std::vector<double> own, others;
  Branch here = branch;
  time_ = t;
  if (sets) changes_.push_back({0, {}, 0.0, 0.0});                                        // the start does not move
  if (!rates(evaluator, t, x, here, own) || !guards.at(t, x, here)) return std::nullopt;  // the run says what is wrong
  for (std::size_t r = 0; r < program.relations.size(); ++r) {
    const Relation& relation = program.relations[r];
    if (relation.kind == Relation::Kind::denominator) continue;
    if (!at_border(evaluator, relation, t, x, here, guards.by_time(r), kAtOnce * span_)) continue;
    const std::vector<double> moves = guards.by_variation(r);
    if (std::all_of(moves.begin(), moves.end(), [](double by) { return by == 0.0; })) continue;
    bool jumps = sets;
    for (Branch& other : other_sides(relation, r, branch))
      jumps = jumps || !rates(evaluator, t, x, other, others) ||
              !same_rates(own, others, std::span(x).first(states_), span_);
    if (jumps)
      return failure(program, r, t, "which is the start, and moves away from it with the parameter",
                     "what lies before the start has no part in the run, so the derivatives of both sides differ",
                     "begin on one side of the condition");
  }
  return std::nullopt;
}

std::optional<VariationEvents::Jump> VariationEvents::take(Evaluator& evaluator, GuardSlopes& guards, double t,
                                                           const std::vector<double>& x, const Branch& before,
                                                           const Branch& after, std::optional<std::size_t> crossed,
                                                           std::optional<Diagnostic>& refused) {
  const Program& program = evaluator.program();
  std::vector<std::size_t> changed;
  for (std::size_t r = 0; r < program.relations.size(); ++r)
    if (program.relations[r].kind != Relation::Kind::denominator && before.modes[r] != after.modes[r])
      changed.push_back(r);
  if (changed.empty()) return std::nullopt;

  std::vector<double> left, right;
  Branch one = before, other = after;
  const bool known = rates(evaluator, t, x, other, right) && rates(evaluator, t, x, one, left);
  if (!known || !guards.at(t, x, one)) {
    refused = failure(program, changed.front(), t, "and the equations have no value on one of its sides",
                      "sensitivities cross an event by the rates on both of its sides",
                      "write laws that have a value, and a slope, at the border of their condition");
    return std::nullopt;
  }
  const bool jumps = !same_rates(left, right, std::span(x).first(states_), span_);
  if (!start_ || t - time_ > kAtOnce * span_) {
    start_ = before;
    changes_.clear();
    touched_ = false;
  }
  time_ = t;
  // What begins the event; conditions that change because rates have jumped follow it.
  std::optional<std::vector<double>> instant;
  for (const std::size_t r : changed) {
    const double by_time = guards.by_time(r);
    // A known time may be of another condition of time: where mod(t, T) falls to 0, mod(t, T) < d T changes far from
    // its border. It is known to the roundings of the time.
    const double within = kAtOnce * span_ + kLocated * std::abs(t);
    const bool begins = r == crossed || at_border(evaluator, program.relations[r], t, x, one, by_time, within);
    if (!begins) continue;
    std::vector<double> moved = guards.by_variation(r);
    for (double& by : moved) by = by_time == 0.0 ? std::nan("") : -by / by_time;
    if (std::all_of(moved.begin(), moved.end(), [](double by) { return std::isfinite(by); })) {
      if (!instant) instant = moved;
      changes_.push_back({r, std::move(moved), before.modes[r], after.modes[r]});
      continue;
    }
    touched_ = true;
    if (jumps) {
      refused =
          failure(program, r, t, "its border is touched and not passed, and the rates jump there",
                  "the instant of such an event has no derivative", "ask for the sensitivity of a run without it");
      return std::nullopt;
    }
  }
  // Where conditions change together that another value of the parameter would part, all but one must be of no
  // consequence.
  const bool apart = std::any_of(changes_.begin(), changes_.end(), [&](const Change& change) {
    return !same_instant(guards, change.instant, changes_.front().instant);
  });
  if (apart) {
    const Change* decides = nullptr;
    for (const Change& change : changes_) {
      if (decides != nullptr && same_instant(guards, decides->instant, change.instant)) continue;
      if (!matters(evaluator, guards, t, x, after, change.instant)) continue;
      if (decides != nullptr) {
        refused = failure(program, change.relation, t,
                          "and so does " + relation_facts(program, decides->relation).text +
                              " at the same time, but not with another value of the parameter",
                          "there is no derivative where the order of two events changes",
                          "ask for it at a slightly different value, at which the two are apart");
        return std::nullopt;
      }
      decides = &change;
    }
    if (decides != nullptr) instant = decides->instant;
  }
  if (!jumps) return std::nullopt;
  if (!instant) {
    refused = failure(program, changed.front(), t, "and it is not known what set it off",
                      "sensitivities cross an event by the instant of its condition",
                      "write the condition over quantities that do not jump");
    return std::nullopt;
  }
  for (std::size_t i = 0; i < left.size(); ++i) left[i] -= right[i];
  return Jump{std::move(*instant), std::move(left)};
}

std::optional<std::vector<double>> VariationEvents::instant_at(const GuardSlopes& guards, double t,
                                                               const Decides& decides) const {
  if (t != time_ || touched_) return std::nullopt;
  const Change* first = nullptr;
  for (const Change& change : changes_) {
    if (!decides(change.relation, change.before)) continue;
    if (first != nullptr && !same_instant(guards, change.instant, first->instant)) return std::nullopt;
    if (first == nullptr) first = &change;
  }
  return first == nullptr ? std::nullopt : std::optional(first->instant);
}

std::optional<std::vector<double>> VariationEvents::instant(const GuardSlopes& guards, double t) const {
  if (t != time_ || changes_.empty())
    return touched_ && t == time_ ? std::nullopt : std::optional(std::vector<double>{});
  return instant_at(guards, t, [](std::size_t, double) { return true; });
}

Diagnostic VariationEvents::no_instant(const std::string& what, double t, std::optional<Place> place,
                                       std::string rule) const {
  const bool apart = t == time_ && !changes_.empty();
  return diagnostic_of("BG414",
                       "at t = " + number_text(t) + " " + what + ", " +
                           (!apart     ? "and it is not known what set it off"
                            : touched_ ? "and a border is touched there, not passed"
                                       : "where conditions change that another value of the parameter parts"),
                       place, std::move(rule),
                       apart ? "ask for it at a slightly different value of the parameter"
                             : "write the condition over quantities that do not jump");
}

std::optional<std::vector<double>> VariationEvents::instant_of_set(const GuardSlopes& guards, const ProgramEvent& event,
                                                                   double t, std::optional<Diagnostic>& refused) const {
  auto found = instant_at(guards, t, [](std::size_t, double) { return true; });
  if (!found)
    refused =
        no_instant("the event \"" + event.name + "\" takes place", t, event.place,
                   "what is set depends on the instant of the event, and so on how that changes with the parameter");
  return found;
}

std::optional<std::vector<double>> VariationEvents::instant_of_leaving(const GuardSlopes& guards, double t,
                                                                       const Decides& decides,
                                                                       std::optional<Diagnostic>& refused) const {
  auto found = instant_at(guards, t, [](std::size_t, double) { return true; });
  if (!found) found = instant_at(guards, t, decides);
  if (!found)
    refused = no_instant("the mode of the switches changes", t, {},
                         "what the stores hold after that depends on its instant, and so on how that changes with the "
                         "parameter");
  return found;
}

Diagnostic held_variation_failure(const Program& program, double t) {
  return failure(
      program, {}, t,
      "dry friction or a condition of a resistor is held at its border, and sensitivities are not found while it is",
      "what holds a sign or condition at its border is no expression of the states",
      "write the law with tanh(f/f0) for the sign or condition: its sensitivities are found");
}

Diagnostic accumulation_variation_failure(const Element& contact, double t) {
  return diagnostic_of(
      "BG414", "at t = " + number_text(t) + " the impacts of \"" + contact.name + "\" accumulate, and it closes",
      contact.place,
      "of infinitely many impacts the derivatives are found where each follows from those before by one ratio",
      "ask for --method differences, or end the scene before");
}

Diagnostic ended_law_failure(double t) {
  return diagnostic_of("BG414", "at t = " + number_text(t) + ": a law ends where its own condition changes", {},
                       "there its slope has no bound, and sensitivities are not found",
                       "write a law with a bounded slope (ssqrt(x, d))");
}

bool is_end(double t, double start, double stop) {
  return stop - t <= kAtOnce * (stop - start) + kLocated * std::abs(t);
}

bool Run::at_end() const { return is_end(t_, inputs_.start, inputs_.stop); }

std::vector<VariationEvents::Ahead> VariationEvents::ahead(Evaluator& evaluator, GuardSlopes& guards, double t,
                                                           const std::vector<double>& x, const Branch& branch) const {
  const Program& program = evaluator.program();
  std::vector<Ahead> result;
  Branch here = branch;
  std::vector<double> own, others;
  if (!guards.at(t, x, here) || !rates(evaluator, t, x, here, own)) return result;
  const double within = kAtOnce * span_ + kLocated * std::abs(t);
  for (std::size_t r = 0; r < program.relations.size(); ++r) {
    const Relation& relation = program.relations[r];
    if (relation.kind == Relation::Kind::denominator) continue;
    const double by_time = guards.by_time(r);
    std::vector<double> instant = guards.by_variation(r);
    if (by_time == 0.0 || std::all_of(instant.begin(), instant.end(), [](double by) { return by == 0.0; }) ||
        !at_border(evaluator, relation, t, x, here, by_time, within))
      continue;
    for (double& by : instant) by = -by / by_time;
    for (Branch& other : other_sides(relation, r, branch)) {
      std::vector<double> jump;
      if (rates(evaluator, t, x, other, others))
        for (std::size_t i = 0; i < own.size(); ++i) jump.push_back(own[i] - others[i]);
      std::vector<double> holds(program.events.size()), behind(holds.size());
      const bool sets = !holds.empty() && evaluator.event_conditions(t, x.data(), here, holds.data()) &&
                        evaluator.event_conditions(t, x.data(), other, behind.data()) &&
                        !std::equal(holds.begin(), holds.end(), behind.begin(),
                                    [](double one, double two) { return one != 0.0 || two == 0.0; });
      result.push_back({std::move(other), {instant, std::move(jump)}, sets});
    }
  }
  return result;
}

/// An event at the end of the run, which has just been taken: the derivatives before it may be others than those after
/// it.
bool Run::look_before_end(const GuardSlopes& guards, const Branch& before) {
  if (!at_end()) return true;
  const auto instant = variations_.instant(guards, t_);
  if (instant && (instant->empty() || instant->front() == 0.0)) return true;
  std::vector<double> outputs(program_.output_names.size());
  Branch branch = before;
  if (!evaluator_.outputs(t_, x_.data(), branch, outputs.data())) return fail_with_fault();
  result_.beside_end.push_back({std::move(outputs)});
  return true;
}

/// Conditions at their borders as the run ends, which have not changed yet (t > stop), are such events as well.
void Run::look_beyond_end() {
  if (program_.varied_states == 0 || !at_end()) return;
  if (follows_another_ && !(t_ > inputs_.start)) return;  // conditions at their borders have just been passed
  const std::size_t n = program_.varied_states;
  VariedGuards guards(evaluator_);
  std::vector<double> outputs(program_.output_names.size()), leaves(program_.switch_elements.size());
  for (VariationEvents::Ahead& each : variations_.ahead(evaluator_, guards, t_, x_, branch_)) {
    bool known = !each.jump.rates.empty() && !each.sets;
    std::vector<double> x = x_;
    for (std::size_t i = 0; known && i < n; ++i) x[n + i] += each.jump.rates[i] * each.jump.instant.front();
    known = known && evaluator_.outputs(t_, x.data(), each.behind, outputs.data()) &&
            (leaves.empty() || evaluator_.switches(t_, x.data(), each.behind, leaves.data()));
    // Of another mode of the switches the derivatives are not known here.
    if (!known || std::any_of(leaves.begin(), leaves.end(), [](double l) { return l != 0.0; }))
      std::fill(outputs.begin(), outputs.end(), std::nan(""));
    result_.beside_end.push_back({outputs, each.sets});
  }
}

/// The sensitivities of a system with Variations cross an event; of a run that is recorded, the event is recorded.
bool Run::vary_event(const Branch& before, std::optional<std::size_t> crossed) {
  std::optional<std::size_t> relation;
  if (crossed) relation = evaluator_.guard_relation(*crossed);
  if (options_.trajectory != nullptr) options_.trajectory->event(t_, x_, before, branch_, relation);
  if (program_.varied_states == 0) return true;
  result_.instants.push_back(t_);
  std::optional<Diagnostic> refused;
  VariedGuards guards(evaluator_);
  const auto jump = variations_.take(evaluator_, guards, t_, x_, before, branch_, relation, refused);
  if (refused) return fail(std::move(*refused));
  if (!look_before_end(guards, before)) return false;
  if (!jump) return true;
  const std::size_t n = program_.varied_states;
  for (std::size_t i = 0; i < n; ++i) x_[n + i] += jump->rates[i] * jump->instant.front();
  return true;
}

std::optional<Departure> Run::departure(std::optional<Diagnostic>& refused) {
  Departure result{x_, std::vector<double>(x_.size()), branch_, {}};
  if (!evaluator_.rates(t_, x_.data(), branch_, result.rates.data())) {
    refused = fault_failure(evaluator_.fault());
    return std::nullopt;
  }
  if (t_ > inputs_.start) {
    const VariedGuards guards(evaluator_);
    // Of conditions that another value of the parameter parts those without which a switch would not leave its side.
    const auto decides = [&](std::size_t relation, double mode_before) {
      Branch without = branch_;
      without.modes[relation] = mode_before;
      std::vector<double> leaves(leaves_.size());
      if (!evaluator_.switches(t_, x_.data(), without, leaves.data())) return true;
      for (std::size_t i = 0; i < leaves.size(); ++i)
        if (leaves_[i] != 0.0 && leaves[i] == 0.0) return true;
      return false;
    };
    const auto found = variations_.instant_of_leaving(guards, t_, decides, refused);
    if (!found) return std::nullopt;
    result.instant = found->front();
  }
  return result;
}

/// The sensitivities where events have set states. @param before  the rates before.
bool Run::vary_sets(const std::vector<double>& before) {
  result_.instants.push_back(t_);
  std::optional<Diagnostic> refused;
  const VariedGuards guards(evaluator_);
  const auto found = variations_.instant_of_set(guards, program_.events[jumps_.due().front()], t_, refused);
  if (!found) return fail(std::move(*refused));
  const double instant = found->empty() ? 0.0 : found->front();
  // By the parameter, at an instant that follows it.
  const std::size_t n = program_.varied_states;
  for (std::size_t i = 0; i < n; ++i) x_[n + i] += before[i] * instant;
  for (const EventJumps::SetSlope& slope : jumps_.set_slopes())
    x_[n + slope.state] = slope.by_parameter + slope.by_time * instant;
  std::vector<double> after(x_.size());
  if (!evaluator_.rates(t_, x_.data(), branch_, after.data())) return fail_with_fault();
  for (std::size_t i = 0; i < n; ++i) x_[n + i] -= after[i] * instant;
  return true;
}

}  // namespace bgsim
