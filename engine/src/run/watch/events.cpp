#include "run/watch/events.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "run/failures.hpp"

namespace bgsim {

namespace {

/// So many events in a row, on average nearer to each other than this part of the scene, are one that never ends.
constexpr std::size_t kEventsInARow = 100;
constexpr double kNear = 1e-9;
constexpr int kMostRounds = 100;

/// By guard: they come in the order of program.guarded, two for each floor, round and table.
std::vector<std::size_t> relations_of_guards(const Program& program) {
  std::vector<std::size_t> relations;
  for (const std::uint32_t relation : program.guarded)
    relations.insert(relations.end(), program.relations[relation].has_borders() ? 2 : 1, relation);
  return relations;
}

}  // namespace

EventWatch::EventWatch(const Program& program, const RunInputs& inputs, Evaluator& evaluator,
                       const Tolerances& tolerances, bool hold)
    : program_(program),
      evaluator_(evaluator),
      span_(inputs.stop - inputs.start),
      may_hold_(hold),
      fixed_steps_(facts_of(inputs.method).fixed_step()),
      tolerances_(tolerances),
      stiction_(program, inputs.parameters, evaluator, tolerances, span_),
      relation_(relations_of_guards(program)),
      denominators_(program, relation_),
      functions_(program, inputs.parameters,
                 {[this](double t) {
                    probed_at_ = t;
                    return evaluate(*searched_, t, at_probe_);
                  },
                  [this](std::size_t guard) { return crossed(guard, at_probe_[guard], probe_); },
                  [this](std::size_t guard, const Range& values, double at) { return stays(guard, values, at); },
                  [this]() -> const Branch& { return probe_; }}) {
  for (const std::size_t relation : relation_) border_.push_back(program.relations[relation].has_borders());
  const std::size_t count = relation_.size();
  side_.assign(count, 0);
  idle_.assign(count, false);
  followed_.assign(count, false);
  taken_.assign(count, 0);
  away_.assign(count, 0.0);
  just_crossed_.assign(count, false);
  changed_.assign(count, false);
  hold_.assign(count, 0.0);
  band_.assign(count, 0.0);
  rest_.assign(count, 0.0);
  returns_.assign(count, 0);
  turned_at_.assign(count, 0.0);
  turned_slope_ = turned_hold_ = within_way_ = turned_at_;
  within_.assign(count, 0);
  crossed_at_.assign(count, 0);
  excursion_.assign(count, 0.0);
  direction_.assign(count, 0);
  onsets_.side = direction_;
  onsets_.size = hold_;
  largest_.assign(count, 0.0);
  values_.assign(count, 0.0);
  middle_ = end_ = at_probe_ = values_;
}

bool EventWatch::start(double t, const double* x, Branch& branch) {
  if (!evaluator_.initialize_modes(t, x, branch)) return fail_with_fault();
  if (!any()) return true;
  if (!evaluator_.guards(t, x, branch, values_.data())) return fail_with_fault();
  for (std::size_t i = 0; i < side_.size(); ++i) side_[i] = border_[i] ? 1 : sign_of(values_[i]);
  end_ = values_;
  const std::vector<GuardMode> known = guards_of(evaluator_, known_at_border_);
  for (const GuardMode& at : known) just_crossed_[at.guard] = true;
  hold_what_rests(t, x, branch, Near::surely, known);
  for (std::size_t i = 0; i < side_.size(); ++i) just_crossed_[i] = side_[i] == 0 && !stiction_.held(i);
  hold_what_rests(t, x, branch, Near::here);
  return settle(t, x, branch);
}

bool EventWatch::jumped(double t, const double* x, const ProgramEvent& event, Branch& branch) {
  std::fill(returns_.begin(), returns_.end(), 0);
  forget_onsets(event);
  jumped_at_ = t;
  hold_what_rests(t, x, branch, Near::here);
  return settle(t, x, branch);
}

bool EventWatch::settle(double t, const double* x, Branch& branch) {
  if (!any()) return true;
  functions_.clear();
  onsets_.begins = true;
  onsets_.until = -std::numeric_limits<double>::infinity();
  std::size_t most = kMostRounds;
  for (std::size_t i = 0; i < border_.size(); ++i)
    if (border_[i] && program_.relations[relation_[i]].kind == Relation::Kind::cell)
      most += program_.pool.table(program_.relations[relation_[i]].table).x.size();
  release_what_jumped(t, x, branch);
  constexpr std::size_t kRoundsToHold = 50;
  bool searched = false;
  for (std::size_t round = 0; round < most; ++round) {
    if (!guards(t, x, branch, values_) && (std::exchange(searched, true) || !find_modes(t, x, branch)))
      return fail_with_fault();
    for (std::size_t i = 0; i < largest_.size(); ++i) largest_[i] = std::max(largest_[i], std::abs(values_[i]));
    for (std::size_t i = 0; i < hold_.size(); ++i)
      if (std::isinf(hold_[i])) hold_[i] = std::max(kSetOut, 4.0 * std::abs(values_[i]));
    keep_what_only_wavers(branch);
    if (round >= kRoundsToHold) keep_what_is_nothing(t, x, branch);
    if (!any_crossed(values_, branch) || !change(values_, branch)) {
      std::fill(changed_.begin(), changed_.end(), false);
      return true;
    }
    hold_what_rests(t, x, branch, Near::here);
  }
  failure_ = contradiction_failure(program_, recent_relations(), t);
  return false;
}

/// Where loops have no solution with the modes as they are (a source jumps, and the flow through f*abs(f) turns back),
/// takes the modes that the search at a start finds, with the guards in values_. False if it finds none, or where modes
/// depend on more than the point.
bool EventWatch::find_modes(double t, const double* x, Branch& branch) {
  if (holding()) return false;
  Branch found = branch;
  if (!evaluator_.initialize_modes(t, x, found) || !evaluator_.guards(t, x, found, values_.data())) return false;
  branch = std::move(found);
  for (std::size_t i = 0; i < side_.size(); ++i)
    if (!border_[i]) side_[i] = sign_of(values_[i]);
  return true;
}

/// A guard that has changed here and is back, by no more than what a loop's solution differs from solve to solve, has
/// crossed: it is held there until it has moved away. Of a cell, what has changed is the other border: that of the cell
/// before, at the same place.
void EventWatch::keep_what_only_wavers(const Branch& branch) {
  constexpr double kOfLoops = 1e-9;
  for (std::size_t i = 0; i < side_.size(); ++i) {
    const std::size_t before = !border_[i] ? i : is_upper(i) ? i - 1 : i + 1;
    if (changed_[before] && std::abs(values_[i]) <= kOfLoops * largest_[i] && crossed(i, values_[i], branch))
      hold_[i] = 4.0 * std::abs(values_[i]);
  }
}

/// The same of guards that go back and forth although they are next to nothing: less than the tolerances make of them,
/// or than they move by themselves in a moment. (A bridge of diodes with two slopes at rest, before anything has a
/// size.)
void EventWatch::keep_what_is_nothing(double t, const double* x, const Branch& branch) {
  constexpr double kMoment = 1e-9;  // of the scene
  const std::vector<double> error = guard_errors(t, x, branch);
  if (error.empty()) return;
  probe_ = branch;
  if (!evaluator_.guards(t + kMoment * span_, x, probe_, at_probe_.data())) at_probe_ = values_;
  for (std::size_t i = 0; i < side_.size(); ++i) {
    const double nothing = std::max(error[i], std::abs(at_probe_[i] - values_[i]));
    if (changed_[i] && !border_[i] && std::abs(values_[i]) <= nothing && crossed(i, values_[i], branch))
      hold_[i] = 4.0 * std::abs(values_[i]);
  }
}

bool EventWatch::crossed(std::size_t guard, double value, const Branch& branch) const {
  if (idle_[guard]) return false;
  if (followed_[guard]) return std::abs(value) > hold_[guard];
  if (side_[guard] != 0 && value == 0.0) return slack(guard) == 0.0 && changes_at_border(guard, branch);
  if (side_[guard] != 0) return value * side_[guard] < 0.0 && std::abs(value) > slack(guard);
  return std::abs(value) > rest_[guard] && changes_mode(guard, sign_of(value), branch);
}

bool EventWatch::any_crossed(const std::vector<double>& values, const Branch& branch) const {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (crossed(i, values[i], branch)) return true;
  return false;
}

/// Whether the mode of an undecided guard is another one on this side of zero.
bool EventWatch::changes_mode(std::size_t guard, int side, const Branch& branch) const {
  const Relation& relation = program_.relations[relation_[guard]];
  const double mode = branch.modes[relation_[guard]];
  if (relation.kind == Relation::Kind::condition) return apply(relation.comparison, side, 0.0) != mode;
  if (relation.kind == Relation::Kind::step) return apply(Op::step, side) != mode;
  return side != mode;  // sign
}

double EventWatch::mode_at_zero(std::size_t relation) const {
  const Relation& at = program_.relations[relation];
  return at.kind == Relation::Kind::condition ? apply(at.comparison, 0.0, 0.0) : apply(Op::step, 0.0);
}

/// Whether the mode is another one where the guard is exactly zero: there it may stay (min(q, 1) >= 1).
bool EventWatch::changes_at_border(std::size_t guard, const Branch& branch) const {
  const Relation& relation = program_.relations[relation_[guard]];
  const double mode = branch.modes[relation_[guard]];
  const bool upper = is_upper(guard);
  switch (relation.kind) {
    case Relation::Kind::floor:
      return upper;
    case Relation::Kind::round:
      return std::round(mode + (upper ? 0.5 : -0.5)) != mode;
    case Relation::Kind::condition:
    case Relation::Kind::step:
      return mode_at_zero(relation_[guard]) != mode;
    default:  // a sign that is 0 for an instant is no answer: a relay would seem to rest there
      return false;
  }
}

/// Undecided guards that moved to the side of their mode.
void EventWatch::decide(const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (side_[i] == 0 && std::abs(values[i]) > rest_[i]) side_[i] = sign_of(values[i]);
    if (idle_[i] && (values[i] > 0.0 || denominators_.has(i))) idle_[i] = false;
    if (denominators_.has(i)) side_[i] = sign_of(values[i]);
    if (std::abs(values[i]) > away_[i]) taken_[i] = 0;
    if (values[i] * side_[i] > 0.0 && !followed_[i]) hold_[i] = 0.0;
    if (std::abs(values[i]) > kClearlyOut * band_[i]) band_[i] = 0.0;
    largest_[i] = std::max(largest_[i], std::abs(values[i]));
  }
}

/// Changes the modes of all guards that have crossed. False if that changed nothing.
bool EventWatch::change(const std::vector<double>& values, Branch& branch) {
  bool changed = false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    direction_[i] = 0;
    if (!crossed(i, values[i], branch)) continue;
    const std::size_t relation = relation_[i];
    double& mode = branch.modes[relation];
    const double before = mode;
    relations_.push_back(relation);
    if (relations_.size() > 2 * kEventsInARow) relations_.pop_front();
    if (stiction_.held(i)) {  // beyond its limit: hold_what_rests() decides
      just_crossed_[i] = changed = true;
      continue;
    }
    if (followed_[i]) stop_following(i);
    just_crossed_[i] = changed_[i] = true;
    direction_[i] = sign_of(values[i]);
    const Relation::Kind kind = program_.relations[relation].kind;
    if (kind == Relation::Kind::floor || kind == Relation::Kind::round) {
      // distance to the lower border is the first guard of the pair, to the upper the second
      const bool lower = !is_upper(i);
      const double down = values[i] == 0.0 ? -1.0 : std::floor(values[i]);
      mode = before + (lower ? down : std::floor(-values[i]) + 1.0);
      direction_[i] = 0;
      changed = true;
    } else {
      if (values[i] == 0.0 && !border_[i])
        mode = mode_at_zero(relation);
      else
        evaluator_.cross(direction_, branch);
      direction_[i] = 0;
      if (!border_[i]) side_[i] = sign_of(values[i]);
      rest_[i] = 0.0;
      const bool moved = mode != before;
      idle_[i] = border_[i] && !moved;
      changed = changed || moved;
    }
  }
  return changed;
}

/// The guards; of those that are held, what they have left.
bool EventWatch::guards(double t, const double* x, Branch& branch, std::vector<double>& values) {
  if (!prepare(t, x, branch) || !evaluator_.guards(t, x, branch, values.data())) return false;
  keep_onsets(t, values);
  if (!stiction_.any()) return true;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (stiction_.held(i)) values[i] = stiction_.margin(i, branch);
  return true;
}

/// What has just reached its border in the law of a resistor and is pushed back to it from both sides stays there; a
/// condition at a kink is at no border, and neither is one that a jump has taken across, by more than its states are
/// known to.
void EventWatch::hold_what_rests(double t, const double* x, Branch& branch, Near near,
                                 const std::vector<GuardMode>& known) {
  std::vector<std::size_t> candidates, leaving;
  std::vector<double> error;
  const auto within = [&](double away, double errors, std::size_t guard) {
    if (error.empty()) error = guard_errors(t, x, branch);
    return !error.empty() && away <= errors * error[guard];
  };
  for (std::size_t i = 0; may_hold_ && i < side_.size(); ++i) {
    if (!just_crossed_[i]) continue;
    just_crossed_[i] = false;
    if (stiction_.held(i)) {
      leaving.push_back(i);
      continue;
    }
    if (!stiction_.possible(i) || followed_[i]) continue;
    constexpr double kFar = 1e-2, kNext = 1e-13;  // of what it has been: these spare two evaluations a state
    // Where a jump went far it is at no border. What was held there and has left is so again, unless it has drifted
    // far: the flow of sign(e)*sqrt(abs(e)) is wrong by as much as the root of that.
    constexpr double kDrift = 1e3;
    const double away = std::abs(near == Near::here ? values_[i] : end_[i]);
    if (near == Near::here && (away > kFar * largest_[i] || (away > 0.0 && !within(away, 1.0, i)))) continue;
    if (near == Near::crossed && away > kNext * largest_[i] && !within(away, kDrift, i)) continue;
    const bool is_sign = program_.relations[relation_[i]].kind == Relation::Kind::sign;
    if (is_sign || (both_go_on(i, t, x, branch) && !is_kink(i, t, x, branch))) candidates.push_back(i);
  }
  if (candidates.empty() && leaving.empty()) return;
  const auto leave = [&](std::size_t guard, int side) {
    side_[guard] = side;
    hold_[guard] = std::numeric_limits<double>::infinity();  // as far as it has drifted: settle() tells
  };
  const auto decided = stiction_.decide(candidates, leaving, t, x, branch, known);
  if (decided) {
    for (const Stiction::Left& left : *decided)
      if (side_[left.guard] != left.side ||
          std::find(candidates.begin(), candidates.end(), left.guard) == candidates.end())
        leave(left.guard, left.side);
  } else {
    for (const std::size_t guard : leaving) {
      const int side = stiction_.side_of(guard, branch.modes[relation_[guard]]);
      stiction_.release(guard);
      leave(guard, side);
      std::fill(direction_.begin(), direction_.end(), 0);
      direction_[guard] = side;
      evaluator_.cross(direction_, branch);
      direction_[guard] = 0;
    }
  }
  for (const std::size_t guard : candidates) {
    if (!stiction_.held(guard)) continue;
    side_[guard] = 1;  // the side of what it has left
    hold_[guard] = 0.0;
  }
  for (const std::size_t output : stiction_.indefinite_outputs(t, x, branch))
    if (std::find(indefinite_.begin(), indefinite_.end(), output) == indefinite_.end()) indefinite_.push_back(output);
}

/// What was held at a border that a jump has taken away from it is on the side where it is now.
void EventWatch::release_what_jumped(double t, const double* x, Branch& branch) {
  constexpr double kTolerances = 4.0;  // what a jump of less makes is less than what runs are wrong by
  if (!stiction_.any()) return;
  for (const Stiction::Left& left : stiction_.moved_by_jump(t, x, branch, kTolerances)) {
    stiction_.release(left.guard);
    side_[left.guard] = left.side;
    hold_[left.guard] = 0.0;
    std::fill(direction_.begin(), direction_.end(), 0);
    direction_[left.guard] = left.side;
    evaluator_.cross(direction_, branch);
    direction_[left.guard] = 0;
  }
}

void EventWatch::see_excursions() {
  for (std::size_t i = 0; i < excursion_.size(); ++i) excursion_[i] = std::max(excursion_[i], std::abs(end_[i]));
}

void EventWatch::pass() {
  crossed_here_.clear();
  unresolved_ = rests_ = false;
  ++passed_;
  if (!any() || screened_) return;
  see_excursions();
  decide(end_);
  values_ = end_;
}

/// Where a loop is solved, a second look may differ by its tolerance: f |f| = e leaves nothing of f below the root of a
/// rounding of e. Then what the search has seen beyond its border counts; else it would be found again an instant
/// later, without end.
void EventWatch::take_what_was_located(const Branch& branch) {
  if (!located_ || any_crossed(end_, branch)) return;
  double& value = end_[*located_];
  value = -side_[*located_] * std::max({std::abs(value), 2.0 * slack(*located_), std::numeric_limits<double>::min()});
}

bool EventWatch::cross(const double* y, Branch& branch) {
  if (!guards(event_time_, y, branch, end_)) return fail_with_fault();
  take_what_was_located(branch);
  crossed_guard_.reset();
  crossed_here_.clear();
  unresolved_ = false;
  bool returned = false;
  for (std::size_t i = 0; i < end_.size(); ++i) {
    if (!crossed(i, end_[i], branch)) continue;
    if (!crossed_guard_) crossed_guard_ = i;
    crossed_here_.push_back(i);
    if (lost_since_turned(i, event_time_, y, branch)) unresolved_ = true;
    if (passed_ > crossed_at_[i] + kStepsToReturn) returns_[i] = 0;
    if (++returns_[i] == 1) excursion_[i] = 0.0;
    crossed_at_[i] = passed_;
    returned = returned || returns_[i] >= kReturns;
  }
  changed_at_ = passed_;
  const std::vector<int> side = event_time_ == onsets_.from ? side_ : std::vector<int>{};
  change(end_, branch);
  for (std::size_t i = 0; i < side.size(); ++i)  // 0 as it is still, such a guard is on the side that it goes to
    if (side[i] == 0 && side_[i] != 0) hold_[i] = kSetOut;
  hold_what_rests(event_time_, y, branch, Near::crossed);
  ++count_;
  if (!settle(event_time_, y, branch)) return false;
  if (returned) widen_bands_of_returns(event_time_, y, branch);
  return check_for_chattering(event_time_, y, branch);
}

bool EventWatch::check_for_chattering(double t, const double* x, const Branch& branch) {
  times_.push_back(t);
  if (times_.size() <= kEventsInARow) return true;
  const double stretch = t - times_.front();
  const double second_half = t - times_[times_.size() / 2];
  times_.pop_front();
  const double gap = stretch / static_cast<double>(kEventsInARow);
  if (gap >= kNear * span_) return true;
  // Where an event of the model has set states, the sameness of the rates on both sides says nothing.
  if (!(jumped_at_ >= t - stretch) && rest_at_kinks(t, x, branch)) {
    times_.clear();
    return true;
  }
  failure_ = chattering_failure(program_, recent_relations(), t, kEventsInARow, gap, second_half < stretch / 10);
  return false;
}

std::vector<std::size_t> EventWatch::recent_relations() const {
  constexpr std::size_t kMost = 4;
  std::vector<std::size_t> result;
  for (auto r = relations_.rbegin(); r != relations_.rend() && result.size() < kMost; ++r)
    if (std::find(result.begin(), result.end(), *r) == result.end()) result.push_back(*r);
  std::sort(result.begin(), result.end());
  return result;
}

bool EventWatch::fail_with_fault() {
  failure_ = fault_failure(evaluator_.fault());
  return false;
}

}  // namespace bgsim
