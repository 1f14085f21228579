#include "run/watch/operator_screen.hpp"

#include <algorithm>
#include <cmath>

namespace bgsim {

Range OperatorScreen::Argument::within(double factor) const {
  constexpr double kAtRest = 1e-5;  // of its value: what rests is not to need a box of its own in each step
  const double around = factor * room() + (factor > 1.0 ? kAtRest * std::max(std::fabs(begin), std::fabs(end)) : 0.0);
  return {std::min(begin, end) - around, std::max(begin, end) + around};
}

bool OperatorScreen::Argument::covered() const {
  const Range range = within(1.0);
  return range.lower() >= box.lower() && range.upper() <= box.upper();
}

void OperatorScreen::clear() {
  for (Watched& watched : watched_) watched = Watched();
  begin_ = end_ = std::numeric_limits<double>::quiet_NaN();
}

void OperatorScreen::evaluate(double t, const double* states, const double* tears) {
  states_.clear();
  tears_.clear();
  for (const std::uint32_t i : operators_->states()) states_.push_back(states[i]);
  for (const std::uint32_t i : operators_->tears()) tears_.push_back(tears[i]);
  operators_->evaluate_point(t, states_, tears_);
}

/// The values at the beginning are those at the end of the step before, or of this one when it was first made.
void OperatorScreen::take_ends(const StepEnds& step) {
  if (step.begin == end_) {
    for (Watched& watched : watched_)
      for (Argument* argument : {&watched.a, &watched.b}) {
        argument->before = argument->moved();
        argument->begin = argument->end;
      }
  } else if (step.begin != begin_) {
    evaluate(step.begin, step.states_at_begin, step.tears_at_begin);
    for (std::size_t k = 0; k < watched_.size(); ++k) {
      watched_[k].a.begin = operators_->argument(k, 0);
      watched_[k].b.begin = operators_->argument(k, 1);
      watched_[k].a.before = watched_[k].b.before = 0.0;
    }
  }
  evaluate(step.end, step.states_at_end, step.tears_at_end);
  for (std::size_t k = 0; k < watched_.size(); ++k) {
    watched_[k].a.end = operators_->argument(k, 0);
    watched_[k].b.end = operators_->argument(k, 1);
  }
  begin_ = step.begin;
  end_ = step.end;
}

bool OperatorScreen::bends(std::size_t root) {
  constexpr double kWidest = 64.0, kLeast = 1.0;
  Watched& watched = watched_[root];
  if (operators_->is_record(root)) return operators_->bends(root, watched.a.within(kLeast), watched.b.within(kLeast));
  if (watched.boxed && watched.a.covered() && watched.b.covered()) return false;
  watched.boxed = false;
  for (watched.factor = std::min(2.0 * watched.factor, kWidest); watched.factor >= kLeast; watched.factor /= 4.0) {
    watched.a.box = watched.a.within(watched.factor);
    watched.b.box = watched.b.within(watched.factor);
    watched.boxed = !operators_->bends(root, watched.a.box, watched.b.box);
    if (watched.boxed) return false;
  }
  watched.factor = kLeast;
  return true;
}

bool OperatorScreen::any_bends(const StepEnds& step) {
  take_ends(step);
  bool any = false;
  for (std::size_t k = 0; k < watched_.size(); ++k) any = bends(k) || any;
  return any;
}

}  // namespace bgsim
