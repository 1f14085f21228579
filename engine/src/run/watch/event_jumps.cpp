#include "run/watch/event_jumps.hpp"

#include <algorithm>
#include <cmath>

#include "base/codes.hpp"
#include "bgsim/text.hpp"
#include "equations/derivative_faults.hpp"
#include "run/failures.hpp"

namespace bgsim {
namespace {

constexpr std::size_t kTimes = 5;  ///< four intervals, hence three ratios

}  // namespace

EventJumps::EventJumps(const Program& program, Evaluator& evaluator, const RunInputs& inputs)
    : program_(program),
      evaluator_(evaluator),
      starting_(inputs.starting_events),
      stop_(inputs.stop),
      conditions_(program.events.size()),
      values_(program.event_values.results.size()),
      noted_(program.events.size(), false) {
  const std::size_t count = program.events.size();
  memory_ = {std::vector<bool>(count, true),
             std::vector<bool>(count, false),
             std::vector<std::vector<double>>(count),
             std::vector<double>(count, 0.0),
             std::vector<std::uint64_t>(count, 0),
             std::vector<double>(count, 0.0),
             0,
             inputs.start};
}

bool EventJumps::see_conditions(double t, const double* x, Branch& branch) {
  if (evaluator_.event_conditions(t, x, branch, conditions_.data())) return true;
  failure_ = fault_failure(evaluator_.fault());
  return false;
}

bool EventJumps::begin(double t, const double* x, Branch& branch) {
  if (!any()) return true;
  if (!see_conditions(t, x, branch)) return false;
  for (std::size_t i = 0; i < conditions_.size(); ++i) memory_.armed[i] = conditions_[i] == 0.0;
  for (const std::size_t i : starting_) memory_.starts[i] = true;
  return true;
}

bool EventJumps::begin_others(double t, const double* x, Branch& branch, std::vector<std::string>& notes) {
  if (!any()) return true;
  if (!see_conditions(t, x, branch)) return false;
  for (std::size_t i = 0; i < conditions_.size(); ++i) {
    if (program_.events[i].memory) continue;
    memory_.armed[i] = conditions_[i] == 0.0;
    if (!memory_.armed[i])
      notes.push_back("the condition of the event \"" + program_.events[i].name +
                      "\" holds at the start: it takes place when it has been false and becomes true");
  }
  return true;
}

bool EventJumps::look(double t, const double* x, Branch& branch, bool memory) {
  due_.clear();
  if (!any() || !see_conditions(t, x, branch)) return !failure_;
  double highest = 0.0;
  for (std::size_t i = 0; i < conditions_.size(); ++i) {
    if (memory && !program_.events[i].memory) continue;
    if (conditions_[i] == 0.0) memory_.armed[i] = true;
    if (!memory_.starts[i] && (conditions_[i] == 0.0 || !memory_.armed[i])) continue;
    const double priority = program_.events[i].priority;
    if (!due_.empty() && priority < highest) continue;
    if (!due_.empty() && priority > highest) due_.clear();
    highest = priority;
    due_.push_back(i);
  }
  if (due_.empty()) return true;
  for (const std::size_t i : due_)
    for (const ProgramEvent::Set& set : program_.events[i].sets)
      if (!set.state) {
        failure_ = dependent_target(program_.events[i].name, set.name, set.place, " at t = " + number_text(t));
        return false;
      }
  if (!evaluator_.event_values(t, x, branch, values_.data())) {
    failure_ = fault_failure(evaluator_.fault());
    failure_->place = program_.events[due_.front()].place;
    return false;
  }
  return !conflicts();
}

/// Two events of one priority that set a state to different values.
bool EventJumps::conflicts() {
  std::vector<std::pair<std::uint32_t, std::size_t>> first;  // state, event
  std::vector<double> value;
  for (const std::size_t i : due_) {
    const ProgramEvent& event = program_.events[i];
    for (std::size_t k = 0; k < event.sets.size(); ++k) {
      const std::uint32_t state = *event.sets[k].state;
      const double set = values_[event.first_value + k];
      const auto same = std::find_if(first.begin(), first.end(), [state](const auto& at) { return at.first == state; });
      if (same == first.end()) {
        first.emplace_back(state, i);
        value.push_back(set);
        continue;
      }
      const double other = value[static_cast<std::size_t>(same - first.begin())];
      if (other == set) continue;
      failure_ = diagnostic_of(
          "BG624",
          "the events \"" + program_.events[same->second].name + "\" and \"" + event.name + "\" set " +
              event.sets[k].name + " at one instant, to " + number_text(other, 6) + " and " + number_text(set, 6),
          event.sets[k].place, "events of one priority take place together, each from what was before",
          "give one of them a higher \"priority\": it takes place first");
      return true;
    }
  }
  return false;
}

void EventJumps::set(std::size_t event, std::vector<double>& x) {
  const ProgramEvent& at = program_.events[event];
  const bool latch = at.memory && !program_.model->events[event].sampled.valid();
  bool counts = !latch;
  for (std::size_t k = 0; k < at.sets.size(); ++k) {
    double& value = x[*at.sets[k].state];
    counts = counts || value != values_[at.first_value + k];
    value = values_[at.first_value + k];
  }
  if (counts) ++memory_.counts[event];
}

std::vector<EventJumps::SetSlope> EventJumps::set_slopes() const {
  const std::size_t sets = values_.size() / 3;  // behind these two slopes for each (linear/variations)
  std::vector<SetSlope> slopes;
  for (const std::size_t event : due_) {
    const ProgramEvent& at = program_.events[event];
    for (std::size_t k = 0; k < at.sets.size(); ++k) {
      const std::size_t slope = sets + 2 * (at.first_value + k);
      slopes.push_back({*at.sets[k].state, values_[slope], values_[slope + 1]});
    }
  }
  return slopes;
}

bool EventJumps::set_elsewhere(double t, std::vector<double>& x, Branch branch) {
  values_elsewhere_.resize(values_.size());
  if (!evaluator_.event_values(t, x.data(), branch, values_elsewhere_.data())) return false;
  for (const std::size_t i : due_) {
    const ProgramEvent& event = program_.events[i];
    for (std::size_t k = 0; k < event.sets.size(); ++k)
      x[*event.sets[k].state] = values_elsewhere_[event.first_value + k];
  }
  return true;
}

bool EventJumps::taken(double t) {
  constexpr std::uint64_t kMostAtOneInstant = 1000;
  if (memory_.here_at != t) memory_.here = 0;
  memory_.here_at = t;
  memory_.here += due_.size();
  if (memory_.here > kMostAtOneInstant) {
    failure_ = endless(t, std::to_string(kMostAtOneInstant) + " events at this instant so far");
    return false;
  }
  for (const std::size_t i : due_) {
    memory_.armed[i] = memory_.starts[i] = false;
    std::vector<double>& times = memory_.times[i];
    if (!times.empty() && times.back() == t) continue;
    if (times.size() == kTimes) times.erase(times.begin());
    times.push_back(t);
    double& longest = memory_.longest[i];
    if (times.size() > 1) longest = std::max(longest, t - times[times.size() - 2]);
    // What a guard does in an interval goes with the square of that, and is resolved to 1e-13 of its largest value: at
    // 3e-7 of the longest interval nothing is left.
    constexpr double kSteady = 1e-3, kResolved = 2e-6;
    const auto found = series(i, kSteady);
    if (!found || !(found->last < kResolved * longest) || !(found->limit < stop_)) continue;
    failure_ = accumulation(i, *found);
    return false;
  }
  return true;
}

bool EventJumps::repeats(double t) const {
  return std::any_of(due_.begin(), due_.end(),
                     [&](std::size_t i) { return !memory_.times[i].empty() && memory_.times[i].back() == t; });
}

Diagnostic EventJumps::endless(double t, const std::string& how) const {
  const ProgramEvent& event = program_.events[due_.back()];
  return diagnostic_of(
      "BG604", "at t = " + number_text(t) + " the event \"" + event.name + "\" takes place without end: " + how,
      event.place, "at one instant events take place until none is due",
      "change what it sets, or its condition: what an event sets must not make itself due again at once");
}

std::optional<std::string> EventJumps::resting(std::size_t event, double t) {
  if (noted_[event]) return std::nullopt;
  noted_[event] = true;
  return "the event \"" + program_.events[event].name +
         "\" leaves its condition at its border, and at rest there, first at t = " + number_text(t, 6) +
         ": it takes place again only when the condition has been false";
}

std::optional<EventJumps::Series> EventJumps::series(std::size_t event, double steady) const {
  constexpr double kShrinks = 0.9999;
  const std::vector<double>& times = memory_.times[event];
  if (times.size() < kTimes) return std::nullopt;
  std::vector<double> ratios;
  for (std::size_t k = 2; k < times.size(); ++k)
    ratios.push_back((times[k] - times[k - 1]) / (times[k - 1] - times[k - 2]));
  const auto [least, most] = std::minmax_element(ratios.begin(), ratios.end());
  if (!(*most < kShrinks) || *most - *least > steady) return std::nullopt;
  const double last = times.back() - times[times.size() - 2], ratio = ratios.back();
  return Series{last, ratio, times.back() + last * ratio / (1.0 - ratio)};
}

bool EventJumps::overdue(double t) {
  constexpr double kSteady = 0.05, kTwice = 2.0, kShort = 1e-2;
  for (std::size_t i = 0; i < program_.events.size(); ++i) {
    if (memory_.armed[i] || memory_.times[i].size() < kTimes) continue;
    const auto found = series(i, kSteady);
    if (!found || found->last > kShort * memory_.longest[i] || !(t > memory_.times[i].back() + kTwice * found->last))
      continue;
    failure_ = accumulation(i, *found);
    return true;
  }
  return false;
}

Diagnostic EventJumps::accumulation(std::size_t event, const Series& series) const {
  return accumulated(event, "towards t = " + number_text(series.limit, 10),
                     "each interval " + number_text(series.ratio, 4) + " of the one before");
}

Diagnostic EventJumps::accumulation(std::size_t event, double t) const {
  return accumulated(event, "near t = " + number_text(t, 6),
                     "at last for less than double precision or the tolerance of the method resolves");
}

Diagnostic EventJumps::accumulated(std::size_t event, const std::string& where, const std::string& how) const {
  const ProgramEvent& at = program_.events[event];
  return diagnostic_of("BG623",
                       "the event \"" + at.name + "\" takes place ever faster " + where + ": " +
                           std::to_string(memory_.counts[event]) + " times so far, " + how,
                       at.place, "infinitely many events before one instant say nothing of what comes after it",
                       "end the scene before, or let another element take over below some speed, such as an Sw that "
                       "locks");
}

}  // namespace bgsim
