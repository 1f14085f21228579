#include "run/watch/screen.hpp"

#include <algorithm>
#include <cmath>

namespace bgsim {

namespace {

template <class F>
void for_each_unknown(const Enclosure& enclosure, const StepEnds& step, F&& f) {
  std::size_t k = 0;
  for (const std::uint32_t i : enclosure.states()) f(k++, step.states_at_begin[i], step.states_at_end[i]);
  for (const std::uint32_t i : enclosure.tears()) f(k++, step.tears_at_begin[i], step.tears_at_end[i]);
}

}  // namespace

bool Screen::covers(const Enclosure& enclosure, const StepEnds& step) {
  bool inside = valid_ && !enclosure.reads_records() && step.begin >= time_.lower() && step.end <= time_.upper();
  for_each_unknown(enclosure, step, [&](std::size_t k, double a, double b) {
    const double moved = std::fabs(b - a), room = moved + before_[k];
    before_[k] = moved;
    moved_[k] = room;
    inside = inside && std::min(a, b) - room >= box_[k].lower() && std::max(a, b) + room <= box_[k].upper();
  });
  return inside;
}

void Screen::put(Enclosure& enclosure, const StepEnds& step, double factor) {
  constexpr double kAtRest = 1e-5;  // of its value: what rests is not to need a box of its own in each step
  for_each_unknown(enclosure, step, [&](std::size_t k, double a, double b) {
    const double room = factor * moved_[k] + kAtRest * std::max(std::fabs(a), std::fabs(b));
    box_[k] = Range(std::min(a, b) - room, std::max(a, b) + room);
  });
  time_ = Range(step.begin, step.end + factor * (step.end - step.begin));
  enclosure.evaluate_box(time_, box_);
}

bool Screen::passes(Enclosure& enclosure, const StepEnds& step, const std::function<bool()>& nothing_happens) {
  const std::size_t unknowns = enclosure.states().size() + enclosure.tears().size();
  if (before_.size() != unknowns) {
    before_.assign(unknowns, 0.0);
    moved_.assign(unknowns, 0.0);
    box_.assign(unknowns, Range(0.0, 0.0));
  }
  if (covers(enclosure, step)) return true;
  valid_ = false;
  if (pause_ > 0) {
    --pause_;
    return false;
  }
  for (factor_ = std::min(2.0 * factor_, kWidest); factor_ >= kLeast; factor_ /= 4.0) {
    put(enclosure, step, factor_);
    valid_ = nothing_happens();
    if (valid_) return true;
  }
  factor_ = kLeast;
  pause_ = kPause;
  return false;
}

}  // namespace bgsim
