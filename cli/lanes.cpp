#include "lanes.hpp"

#include <algorithm>
#include <cmath>

#include "bgsim/text.hpp"
#include "bgsim/trace_csv.hpp"

namespace bgsim::cli {

namespace {

/// What a lane fills, and what the other side is called. "free" is the other side of "locked" or of "closed".
bool fills(Lane::Kind kind, const std::string& side) {
  return side == "closed" || side == "locked" || side == "conducts" || (kind == Lane::Kind::latch && side == "true") ||
         (kind == Lane::Kind::friction && (side == "held" || side == "0"));
}

std::string side_word(Lane::Kind kind, const std::string& side) {
  switch (kind) {
    case Lane::Kind::contact:
      return fills(kind, side) ? "touches" : "apart";
    case Lane::Kind::diode:
      return fills(kind, side) ? "conducts" : "blocks";
    case Lane::Kind::friction:
      return fills(kind, side) ? "sticks" : "slides";
    default:
      return side;
  }
}

/// Held at its border, with a force or without one. A sign that begins at 0 and leaves it may be that of any law.
bool is_friction(const RunEvent& event) { return event.from == "held" || fills(Lane::Kind::friction, event.to); }

std::string names_of(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > kMost) text += " and " + std::to_string(names.size() - kMost) + " more";
  return text;
}

Lane marks_lane(std::string name, const char* what, std::vector<double> marks, double start) {
  return {Lane::Kind::marks, std::move(name), what, "", 0, {start}, {0.0}, std::move(marks)};
}

}  // namespace

std::string lane_text(const Lane& lane) {
  const auto times = [](std::size_t count, const char* one, const char* many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
  };
  if (lane.kind == Lane::Kind::marks) return lane.name + ": " + times(lane.marks.size(), "time", "times");
  std::string text = lane.name + ": ";
  if (lane.changes == 0) {
    text += (lane.on.empty() ? lane.off : lane.on) + " throughout";
  } else {
    text += lane.on + " (filled), " + lane.off + "; " + times(lane.changes, "change", "changes");
  }
  if (!lane.marks.empty()) text += ", " + times(lane.marks.size(), "impact", "impacts");
  return text;
}

LaneBook::Course& LaneBook::course(Lane::Kind kind, const std::string& name) {
  const auto [found, added] = position_.try_emplace({kind, name}, courses_.size());
  if (added) courses_.push_back({kind, name, "", false, {}, {}});
  return courses_[found->second];
}

void LaneBook::take(const RunEvent& event) {
  using Kind = RunEvent::Kind;
  const auto side = [&](Lane::Kind kind) -> Course& {
    Course& at = course(kind, event.name);
    if (at.first.empty()) at.first = event.from;
    at.sides.push_back({event.t, event.to});
    return at;
  };
  const auto mark = [&](auto& marks, auto& names) {
    const auto [found, added] = marks.try_emplace(event.name);
    if (added) names.push_back(event.name);
    if (found->second.empty() || found->second.back() != event.t) found->second.push_back(event.t);
  };
  switch (event.kind) {
    case Kind::time:
      return;
    case Kind::condition: {
      // The sides of a sign in the law of a resistor; all others are kept until one is held.
      if (event.name.find("sign(") == std::string::npos) return;
      Course& at = side(Lane::Kind::friction);
      at.held = at.held || is_friction(event);
      return;
    }
    case Kind::event:
      return mark(events_, event_names_);
    case Kind::sample:
      return mark(samples_, sample_names_);
    case Kind::latch:
      side(Lane::Kind::latch);
      return;
    case Kind::switching:
      side(Lane::Kind::switching);
      return;
    case Kind::diode:
      side(Lane::Kind::diode);
      return;
    case Kind::contact:
      side(Lane::Kind::contact);
      return;
    case Kind::impact:
      course(Lane::Kind::contact, event.name).marks.push_back(event.t);
      return;
    case Kind::jump:
      if (jumps_.empty() || jumps_.back() != event.t) jumps_.push_back(event.t);
      return;
    case Kind::start: {
      const Lane::Kind kind = event.quantity == event_kind_text(Kind::diode)     ? Lane::Kind::diode
                              : event.quantity == event_kind_text(Kind::contact) ? Lane::Kind::contact
                                                                                 : Lane::Kind::switching;
      course(kind, event.name).first = event.to;
      return;
    }
  }
}

std::vector<Lane> LaneBook::lanes(double start) const {
  std::vector<Lane> all;
  for (const Course& course : courses_) {
    if (course.kind == Lane::Kind::friction && !course.held) continue;
    Lane lane{course.kind, course.name, "", "", 0, {start}, {0.0}, course.marks};
    const auto word = [&](const std::string& side) {
      if (side.empty()) return;
      (fills(course.kind, side) ? lane.on : lane.off) = side_word(course.kind, side);
    };
    word(course.first);
    lane.share.front() = fills(course.kind, course.first) ? 1.0 : 0.0;
    for (const Side& side : course.sides) {
      word(side.to);
      const double share = fills(course.kind, side.to) ? 1.0 : 0.0;
      // Sliding to and fro are one side.
      if (share == lane.share.back()) continue;
      ++lane.changes;
      if (lane.from.back() == side.t) {  // within one instant: what it was before is not seen
        lane.share.back() = share;
        if (lane.from.size() > 1 && lane.share[lane.share.size() - 2] == share) {
          lane.from.pop_back();
          lane.share.pop_back();
        }
        continue;
      }
      lane.from.push_back(side.t);
      lane.share.push_back(share);
    }
    all.push_back(std::move(lane));
  }
  for (const std::string& name : event_names_)
    all.push_back(marks_lane("event " + name, "event", events_.at(name), start));
  if (!jumps_.empty()) all.push_back(marks_lane("jumps of stores", "jump", jumps_, start));
  std::vector<bool> shown(sample_names_.size());
  for (std::size_t i = 0; i < sample_names_.size(); ++i) {
    if (shown[i]) continue;
    const std::vector<double>& times = samples_.at(sample_names_[i]);
    std::vector<std::string> names;
    for (std::size_t k = i; k < sample_names_.size(); ++k)
      if (!shown[k] && samples_.at(sample_names_[k]) == times) {
        shown[k] = true;
        names.push_back(sample_names_[k]);
      }
    all.push_back(marks_lane("sampled " + names_of(names), "sample", times, start));
  }
  return all;
}

Lane merged(const Lane& lane, double from, double to, std::size_t buckets) {
  constexpr double kLeast = 1e-3;
  Lane less = lane;
  less.from.clear();
  less.share.clear();
  std::erase_if(less.marks, [&](double t) { return t < from || t > to; });
  const double width = (to - from) / static_cast<double>(buckets);
  const std::size_t count = lane.from.size();
  if (!(width > 0.0) || count == 0 || lane.from.front() > to) return less;
  const auto begin_of = [&](std::size_t bucket) { return from + static_cast<double>(bucket) * width; };
  const auto bucket_of = [&](double t) {
    return static_cast<std::size_t>(std::clamp((t - from) / width, 0.0, static_cast<double>(buckets - 1)));
  };
  // What part of each bucket is on, and whether something short reaches it.
  std::vector<bool> fast(buckets);
  std::vector<double> on(buckets);
  for (std::size_t i = 0; i < count; ++i) {
    const double a = std::max(lane.from[i], from), b = i + 1 < count ? std::min(lane.from[i + 1], to) : to;
    if (!(a < b)) continue;
    const bool partly = lane.share[i] > 0.0 && lane.share[i] < 1.0;
    const bool brief = partly || (i > 0 && i + 1 < count && lane.from[i + 1] - lane.from[i] < width);
    if (!brief && lane.share[i] == 0.0) continue;
    const std::size_t first = bucket_of(a), last = std::max(first, bucket_of(std::nextafter(b, from)));
    for (std::size_t k = first; k <= last; ++k) {
      if (brief) fast[k] = true;
      on[k] += lane.share[i] * std::max(0.0, std::min(b, begin_of(k + 1)) - std::max(a, begin_of(k))) / width;
    }
  }
  const auto add = [&](double t, double share) {
    if (!less.share.empty() && less.share.back() == share) return;
    less.from.push_back(t);
    less.share.push_back(share);
  };
  std::size_t i = 0;
  for (std::size_t k = 0; k < buckets;) {
    if (fast[k]) {
      add(std::max(begin_of(k), lane.from.front()), std::clamp(on[k], kLeast, 1.0 - kLeast));
      ++k;
      continue;
    }
    const double begin = begin_of(k);
    while (k < buckets && !fast[k]) ++k;
    const double end = k < buckets ? begin_of(k) : std::nextafter(to, HUGE_VAL);
    while (i + 1 < count && lane.from[i + 1] <= begin) ++i;
    if (lane.from[i] < end) add(std::max(begin, lane.from[i]), lane.share[i]);
    while (i + 1 < count && lane.from[i + 1] < end) {
      ++i;
      add(lane.from[i], lane.share[i]);
    }
  }
  return less;
}

std::vector<std::size_t> lanes_to_draw(const std::vector<Lane>& lanes, std::size_t most) {
  std::vector<std::size_t> chosen;
  for (const bool changing : {true, false})
    for (std::size_t i = 0; i < lanes.size() && chosen.size() < most; ++i)
      if ((lanes[i].changes > 0 || !lanes[i].marks.empty()) == changing) chosen.push_back(i);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace bgsim::cli
