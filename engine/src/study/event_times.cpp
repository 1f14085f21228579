#include "study/event_times.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bgsim {

void EventTimes::take(const RunEvent& event) {
  using Kind = RunEvent::Kind;
  std::string what = event.name;
  switch (event.kind) {
    case Kind::time:
    case Kind::condition:
    case Kind::sample:
    case Kind::jump:
    case Kind::start:
      return;
    case Kind::event:
      break;
    case Kind::impact:
      what += " (impact)";
      break;
    case Kind::latch:
    case Kind::switching:
    case Kind::diode:
    case Kind::contact:
      what += " (" + event.to + ")";
      if (const auto before = last_.find(event.name); before != last_.end() && before->second.from == event.to)
        returns_.push_back({event.name + " (" + before->second.to + ")", what, before->second.t, event.t});
      last_[event.name] = {event.t, event.from, event.to};
      break;
  }
  times_[what].push_back(event.t);
}

std::map<std::string, std::vector<double>> EventTimes::lasting(double shortest) const {
  std::map<std::string, std::vector<double>> kept = times_;
  const auto drop = [&kept](const std::string& what, double t) {
    std::vector<double>& times = kept[what];
    const auto at = std::lower_bound(times.begin(), times.end(), t);
    if (at != times.end() && *at == t) times.erase(at);
    if (times.empty()) kept.erase(what);
  };
  double until = -std::numeric_limits<double>::infinity();
  for (const Return& each : returns_) {
    if (each.until - each.at > shortest || each.at <= until) continue;
    drop(each.there, each.at);
    drop(each.back, each.until);
    until = each.until;  // there, back and there again is one change that lasts
  }
  return kept;
}

bool has_events(const Model& model) {
  return !model.events.empty() || std::any_of(model.elements.begin(), model.elements.end(),
                                              [](const Element& element) { return is_switch(element.kind); });
}

bool EventDistance::parted(double t) const {
  // An output time as near as that to an event shows what comes after it.
  constexpr double kLocated = 200.0 * std::numeric_limits<double>::epsilon();
  const double near = kLocated * std::abs(t);
  const auto after = std::lower_bound(between.begin(), between.end(), t - near,
                                      [](const auto& interval, double at) { return interval.second < at; });
  return after != between.end() && after->first <= t + near;
}

namespace {

/// From each of @p from to the nearest of @p to.
void look(const std::vector<double>& from, const std::vector<double>& to, const std::string& what,
          EventDistance& distance) {
  for (const double t : from) {
    const auto after = std::lower_bound(to.begin(), to.end(), t);
    double nearest = after == to.end() ? to.back() : *after;
    if (after != to.begin() && t - *(after - 1) < std::abs(nearest - t)) nearest = *(after - 1);
    if (nearest == t) continue;
    distance.between.emplace_back(std::min(t, nearest), std::max(t, nearest));
    if (std::abs(nearest - t) > distance.largest) {
      distance.largest = std::abs(nearest - t);
      distance.what = what;
    }
  }
}

void merge(std::vector<std::pair<double, double>>& intervals) {
  std::sort(intervals.begin(), intervals.end());
  std::size_t kept = 0;
  for (const auto& interval : intervals) {
    if (kept > 0 && interval.first <= intervals[kept - 1].second)
      intervals[kept - 1].second = std::max(intervals[kept - 1].second, interval.second);
    else
      intervals[kept++] = interval;
  }
  intervals.resize(kept);
}

}  // namespace

EventDistance event_distance(const EventTimes& one, const EventTimes& other, double span) {
  constexpr double kShortest = 1e-12;
  EventDistance distance;
  const auto ours = one.lasting(kShortest * span), theirs = other.lasting(kShortest * span);
  const auto missing = [&](const std::string& what) {
    if (distance.largest < span) distance.what = what;
    distance.largest = std::max(distance.largest, span);
  };
  for (const auto& [what, times] : ours) {
    const auto found = theirs.find(what);
    if (found == theirs.end()) {
      missing(what);
      continue;
    }
    look(times, found->second, what, distance);
    look(found->second, times, what, distance);
  }
  for (const auto& [what, times] : theirs)
    if (!ours.contains(what)) missing(what);
  merge(distance.between);
  return distance;
}

}  // namespace bgsim
