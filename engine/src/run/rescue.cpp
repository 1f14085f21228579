// Steps that are made again, and what may go on although the integrator gave up.
#include "run/run.hpp"

namespace bgsim {

/// Whether the last step, up to @p until, is what its rates add up to. If not, it is made again.
bool Run::holds(const StepEnds& ends, double until, bool event) {
  if (events_.holding() || defects_.look(*integrator_, ends, until, event)) return true;
  tolerances_.forget_noise();  // of where the step went
  fresh_ = true;
  return false;
}

/// A step in which a loop came to another of its solutions is made again, ever shorter: the iteration may have strayed.
/// False if that does not help: the solution ends here.
bool Run::go_back() {
  constexpr double kShorter = 0.1;
  constexpr int kMostTimes = 10;
  if (t_ > strayed_at_) strayed_ = 0;
  strayed_at_ = t_;
  if (++strayed_ > kMostTimes) return false;
  integrator_->begin_with(kShorter * integrator_->step());
  fresh_ = true;
  return true;
}

/// Past a border that the laws on this side end at: no step gets there, and those that come near grow ever shorter.
/// True if there is one; jump_ is set if the laws make a jump there.
bool Run::leave_law() {
  if (integrator_->last_fault().kind == Fault::Kind::none) return false;
  continuity_.before(t_, x_.data(), branch_);
  if (!events_.take_across(t_, x_.data(), branch_)) return false;
  if (differentiates()) {
    jump_ = ended_law_failure(t_);
    return true;
  }
  fresh_ = true;
  log_->look(t_, branch_);
  vitality_ = {};
  jump_ = continuity_.after(t_, x_.data(), branch_);
  return true;
}

/// What may go on although the integrator gave up: past a border, or, once, with a fresh start where a kink spoiled
/// what the integrator remembered.
bool Run::rescue() {
  constexpr std::uint64_t kStepsBetween = 10;
  if (clock_.end() != RunClock::End::none) return false;
  fresh_ = true;
  if (integrator_->failure().fault && leave_law()) return !jump_ && settle_instant();
  if (events_.failure()) return false;
  if (steps_ < rescued_at_ + kStepsBetween) return false;
  rescued_at_ = steps_;
  return true;
}

}  // namespace bgsim
