// Where in a step a guard crosses first, and what denominators that come to zero there mean.
#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <limits>
#include <utility>

#include "run/failures.hpp"
#include "run/watch/events.hpp"

namespace bgsim {
namespace {

constexpr double kNextToNothing = 1e-13;  ///< of the largest magnitude that something has had

}  // namespace

bool EventWatch::evaluate(Integrator& integrator, double t, std::vector<double>& values) {
  y_.resize(integrator.size());
  integrator.interpolate(t, y_.data(), probe_);
  return guards(t, y_.data(), probe_, values);
}

/// Where a guard that is on its side at both ends and in the middle may have been on the other one in between: at the
/// lowest point of the parabola through the three, if that is near zero.
std::optional<double> EventWatch::dip(double from, double to, const std::vector<double>& middle,
                                      const std::vector<double>& end) const {
  constexpr double kLow = 0.1;
  for (std::size_t i = 0; i < side_.size(); ++i) {
    if (side_[i] == 0 || idle_[i] || followed_[i]) continue;
    const double a = side_[i] * values_[i], m = side_[i] * middle[i], b = side_[i] * end[i];
    const double bend = 2.0 * (a - m - m + b), slope = 4.0 * m - 3.0 * a - b;
    if (!(bend > 0.0) || !(slope < 0.0) || !(-slope < 2.0 * bend)) continue;
    if (a - slope * slope / (4.0 * bend) < kLow * std::max(a, b)) return from - slope / (2.0 * bend) * (to - from);
  }
  return std::nullopt;
}

EventWatch::Search EventWatch::search(Integrator& integrator, const StepEnds& ends) {
  located_.reset();
  if (!any()) return Search::none;
  if (onsets_.begins) keep_start(ends, integrator.branch());
  candidates_.clear();
  bool decided = !holding();
  for (std::size_t i = 0; i < side_.size(); ++i) {
    if (!idle_[i]) candidates_.push_back(i);
    decided = decided && !idle_[i] && side_[i] != 0 && slack(i) == 0.0;
  }
  if (probe_.modes != integrator.branch().modes) probe_ = integrator.branch();
  if (sets_out_in_rounding(ends, integrator.branch()) && find_onsets(integrator, ends) &&
      crosses_at_once(ends.begin, integrator.branch())) {
    probe_ = integrator.branch();
    event_time_ = ends.begin;
    screened_ = false;
    return Search::found;
  }
  setting_out_ = ends.end <= onsets_.until;
  screened_ = decided && functions_.screened(ends, integrator.branch(), candidates_);
  const bool watched = passed_ <= changed_at_ + kStepsToReturn;
  if (screened_ && !(watched && evaluate(integrator, ends.end, end_))) return Search::none;
  if (screened_) {
    see_excursions();
    return Search::none;
  }
  probe_ = integrator.branch();
  const double from = integrator.previous(), to = integrator.time();
  // Where a denominator passes zero without consequence, the step is searched again without it.
  for (std::size_t round = 0; round <= side_.size(); ++round) {
    const auto begin_and_end = bracket(integrator, from, to);
    if (failure_) return Search::failed;
    if (!begin_and_end) break;
    if (find_onsets(integrator, ends)) continue;
    if (crosses_at_once(from, probe_)) {
      event_time_ = from;
      return Search::found;
    }
    if (!locate(integrator, begin_and_end->first, begin_and_end->second)) return Search::failed;
    const Search outcome = check_denominators(integrator);
    if (outcome != Search::none) return outcome;
  }
  return Search::none;
}

/// Whether a guard crosses at none of these values, on a stretch with @p at in its middle (NaN: nothing is known of
/// it). One that is next to nothing beside what it was, and no more than what next to nothing of the states makes of
/// it, is rounding's: what it is at the step's end counts. It has to be both: (x - a)^2 is next to nothing long before
/// x - a is.
bool EventWatch::stays(std::size_t guard, const Range& values, double at) {
  const double low = values.lower(), high = values.upper();
  if (!(low <= high)) return false;
  const double size = std::max(-low, high);
  if (size == 0.0 || (size <= kNextToNothing * largest_[guard] && is_nothing(guard, size, at))) return true;
  if (setting_out_ && onsets_.side[guard] != 0 &&
      (side_[guard] != 0 || !changes_mode(guard, onsets_.side[guard], probe_)))
    return onsets_.side[guard] > 0 ? low >= -onsets_.size[guard] : high <= onsets_.size[guard];
  const bool border_counts = slack(guard) == 0.0 && changes_at_border(guard, probe_);
  if (side_[guard] > 0) return border_counts ? low > 0.0 : low >= -slack(guard);
  if (side_[guard] < 0) return border_counts ? high < 0.0 : high <= slack(guard);
  const double rest = rest_[guard];
  return !(low < -rest && changes_mode(guard, -1, probe_)) && !(high > rest && changes_mode(guard, 1, probe_));
}

/// Whether states that move by next to nothing of the largest that they were change a guard by as much as @p size, at
/// @p at within the step that is searched.
bool EventWatch::is_nothing(std::size_t guard, double size, double at) {
  if (std::isnan(at)) return false;
  if (at != nothing_at_) {
    nothing_at_ = at;
    nothing_.assign(side_.size(), 0.0);
    Branch branch = probe_;
    y_.resize(searched_->size());
    searched_->interpolate(at, y_.data(), branch);
    std::vector<double> here(side_.size()), moves(program_.state_names.size());
    const double* end = searched_->end();
    for (std::size_t k = 0; k < moves.size(); ++k)
      moves[k] = kNextToNothing * std::max(tolerances_.largest(k), std::abs(end[k]));
    if (evaluator_.guards(at, y_.data(), branch, here.data()))
      nothing_ = spread(at, y_.data(), branch, here, 0.0, moves);
  }
  return size <= nothing_[guard];
}

/// Those whose modes are what the point makes of them, from one of their values to the other at once.
std::vector<std::size_t> EventWatch::followed_relations() const {
  std::vector<std::size_t> relations;
  for (std::size_t i = 0; i < side_.size(); ++i)
    if (followed_[i]) relations.push_back(relation_[i]);
  return relations;
}

std::vector<GuardFunctions::Held> EventWatch::held() const {
  std::vector<GuardFunctions::Held> held;
  for (std::size_t i = 0; i < side_.size(); ++i)
    if (stiction_.held(i)) held.push_back({i, stiction_.rests(i)});
  return held;
}

/// Searches a stretch, and keeps what was left undecided.
FirstCrossing EventWatch::prove(double from, double to) {
  constexpr int kWork = 500;
  setting_out_ = to <= onsets_.until;
  FirstCrossing found = first_crossing(functions_, candidates_, from, to, kWork);
  for (const std::size_t guard : found.undecided) {
    if (std::find(undecided_.begin(), undecided_.end(), relation_[guard]) != undecided_.end()) continue;
    undecided_.push_back(relation_[guard]);
    undecided_at_.push_back(found.undecided_at);
  }
  return found;
}

/// A stretch of the step at whose end a guard has crossed, while none has at its beginning; none if there is none, or
/// failure(). By proof, but for modes that follow the point from side to side, and what depends on them.
std::optional<std::pair<double, double>> EventWatch::bracket(Integrator& integrator, double from, double to) {
  searched_ = &integrator;
  nothing_at_ = probed_at_ = std::numeric_limits<double>::quiet_NaN();
  functions_.begin(integrator, held());
  candidates_.clear();
  const std::vector<bool>* free = followed_any_ ? &functions_.free_of(followed_relations()) : nullptr;
  for (std::size_t i = 0; i < side_.size(); ++i)
    if (!idle_[i] && (free == nullptr || ((*free)[i] && !followed_[i]))) candidates_.push_back(i);
  const double settled = std::clamp(onsets_.until, from, to);
  FirstCrossing found = settled > from ? prove(from, settled) : FirstCrossing{};
  if (!found.fault && !found.bracket && settled < to) found = prove(settled, to);
  if (found.fault) {
    fail_with_fault();
    return std::nullopt;
  }
  if (followed_any_) {
    const auto sampled = bracket_by_samples(integrator, from, found.bracket ? found.bracket->second : to);
    return sampled || failure_ ? sampled : found.bracket;
  }
  if (found.bracket) return found.bracket;
  if (probed_at_ == to) {
    end_ = at_probe_;
  } else if (!evaluate(integrator, to, end_)) {
    fail_with_fault();
    return std::nullopt;
  }
  return any_crossed(end_, probe_) ? std::optional(std::pair(from, to)) : std::nullopt;
}

/// The same by the guards' values in the middle, at the end, and where a parabola dips.
std::optional<std::pair<double, double>> EventWatch::bracket_by_samples(Integrator& integrator, double from,
                                                                        double to) {
  const double middle = from + (to - from) / 2;
  const auto failed = [this] {
    fail_with_fault();
    return std::nullopt;
  };
  if (!evaluate(integrator, middle, middle_)) return failed();
  if (any_crossed(middle_, probe_)) return std::pair(from, middle);
  if (!evaluate(integrator, to, end_)) return failed();
  if (any_crossed(end_, probe_)) return std::pair(middle, to);
  const auto low = dip(from, to, middle_, end_);
  if (!low) return std::nullopt;
  if (!evaluate(integrator, *low, at_probe_)) return failed();
  if (any_crossed(at_probe_, probe_)) return std::pair(from, *low);
  return std::nullopt;
}

/// Closes in on the first crossing until the two ends are neighbours among the doubles; the event is the later one.
bool EventWatch::locate(Integrator& integrator, double from, double to) {
  using boost::math::tools::toms748_solve;
  constexpr std::uintmax_t kMostEvaluations = 200;
  bool fault = false;
  // near t = 0 the doubles never end: there the scene's own length gives the measure
  constexpr double epsilon = 2.0 * std::numeric_limits<double>::epsilon();
  const double least = 1e-3 * span_;
  const auto neighbours = [least](double a, double b) {
    return b - a <= epsilon * std::max({std::abs(a), std::abs(b), least});
  };
  event_time_ = to;
  if (!evaluate(integrator, to, end_)) return fail_with_fault();
  for (std::size_t i = 0; i < side_.size() && !neighbours(from, event_time_); ++i) {
    if (!crossed(i, end_[i], probe_)) continue;
    if (side_[i] != 0 && !followed_[i]) located_ = i;
    // A guard of side 0 crosses as soon as it is not zero.
    const auto distance = [&](double t) {
      if (!evaluate(integrator, t, at_probe_)) {
        fault = true;
        return -1.0;
      }
      double value = side_[i] != 0 ? side_[i] * at_probe_[i] : -std::abs(at_probe_[i]);
      if (followed_[i]) value = hold_[i] - std::abs(at_probe_[i]);
      if (value == 0.0) value = -std::numeric_limits<double>::min();  // crossed where it rests, too
      return crossed(i, at_probe_[i], probe_) ? value : std::max(value, std::numeric_limits<double>::min());
    };
    const double at_from = std::max(distance(from), std::numeric_limits<double>::min());
    // The end crosses, as seen above: where a loop is solved, a second look may differ by its tolerance.
    const double at_to = std::min(distance(event_time_), -std::numeric_limits<double>::min());
    if (fault) return fail_with_fault();
    std::uintmax_t evaluations = kMostEvaluations;
    const auto bracket = toms748_solve(distance, from, event_time_, at_from, at_to, neighbours, evaluations);
    if (fault) return fail_with_fault();
    // Next to a point that lies on its border itself (0 at t = 0) the doubles never end, either: 1e-308 s later a root
    // has a slope of 1e153, which no method gets on from.
    const double nearest = from + epsilon * std::max({std::abs(from), std::abs(bracket.second), least});
    event_time_ = std::max(bracket.second, std::min(event_time_, nearest));
    if (!evaluate(integrator, event_time_, end_)) return fail_with_fault();
  }
  return true;
}

/// Of the denominators that have come to zero: a singularity, or a quotient that stays finite and is left alone. A zero
/// far ahead is where a step leads that saw nothing of it: the repulsion that grows towards it may still turn the
/// motion back (two molecules that collide). The step is made again over nine tenths of the way, until what is left is
/// nothing beside the run.
EventWatch::Search EventWatch::check_denominators(Integrator& integrator) {
  constexpr double kNear = 1e-10, kOfTheWay = 0.9;
  const std::size_t states = program_.state_names.size();
  const auto rates = [this](double t, const double* x, double* result) {
    return prepare(t, x, probe_) && evaluator_.rates(t, x, probe_, result);
  };
  Search outcome = Search::found;
  for (const std::size_t i : denominators_.guards()) {
    if (!crossed(i, end_[i], probe_)) continue;
    const bool structural = program_.relations[relation_[i]].structural;
    if (structural || grows_without_bound(approach(integrator), states, rates)) {
      const double from = integrator.previous(), left = event_time_ - from;
      if (!fixed_steps_ && left > kNear * std::max(std::abs(event_time_), span_)) {
        cut_ = from + kOfTheWay * left;
        return Search::nearer;
      }
      failure_ = singularity_failure(program_, relation_[i], event_time_);
      return Search::failed;
    }
    idle_[i] = true;  // until decide() has seen it on its other side
    outcome = Search::none;
  }
  return outcome;
}

bool EventWatch::is_singular(std::size_t relation, double t, const std::vector<double>& x, const Branch& branch) {
  if (program_.relations[relation].structural) return true;
  constexpr double kRoundings = 1e4 * 0x1p-52, kOfScene = 1e-12;
  probe_ = branch;
  const Approach line{t, std::max(kRoundings * std::abs(t), kOfScene * span_), x, std::vector<double>(x.size(), 0.0)};
  return grows_without_bound(line, program_.state_names.size(), [this](double at, const double* y, double* rates) {
    return prepare(at, y, probe_) && evaluator_.rates(at, y, probe_, rates);
  });
}

/// To the event, from where the integrator's last step begins.
Approach EventWatch::approach(Integrator& integrator) {
  constexpr double kLast = 1e-12, kRoundings = 1e4 * 0x1p-52;  // the event's own time is known to some roundings
  const double from = integrator.previous();
  Approach line{event_time_, std::max(kLast * integrator.step(), kRoundings * std::abs(event_time_)),
                std::vector<double>(integrator.size()), std::vector<double>(integrator.size())};
  integrator.interpolate(from, line.slope.data());
  integrator.interpolate(event_time_, line.at.data(), probe_);
  for (std::size_t k = 0; k < line.at.size(); ++k) line.slope[k] = (line.at[k] - line.slope[k]) / (event_time_ - from);
  return line;
}

std::optional<std::size_t> EventWatch::singularity_ahead(double t, const double* x, Branch branch) {
  if (!any() || !prepare(t, x, branch) || !evaluator_.guards(t, x, branch, at_probe_.data())) return std::nullopt;
  const auto guard = denominators_.next_to_zero(at_probe_, largest_);
  return guard ? std::optional(relation_[*guard]) : std::nullopt;
}

}  // namespace bgsim
