// When a run changes its method where it is: to BDF, or to the other form of its loops.
//
// Whether the loops' variables are unknowns of the integrator (IDA, Radau IIA, Rodas5P), or found inside the rates.
// Each form runs what the other cannot, so a run may change from one to the other where it is.
//
// As unknowns, they are found by the iteration of a step, which has none of the safeguards of a loop's own solver, and
// by IDA they are what a polynomial says between the ends of a step: a diode's exponential, or a kink, is too much for
// both (bridge, three_phase_rectifier, charge_pump_if in tests/physics/loop_form_test.cpp). Inside the rates, a loop
// whose solution moves faster than the states do, or is hardly determined by them, makes rates that no iteration over
// states converges with: currents of coils that meet in diodes, of index 2 while these block (ring modulator without
// its stray capacities, there). A condition is held at its border by rates whose modes depend on the point: inside
// them, too.
#include "bgsim/text.hpp"
#include "run/run.hpp"

namespace bgsim {

/// What failed with the loops' variables as unknowns is tried again with them found inside the rates, before it is an
/// error. False if that is not possible, or was so already.
bool Run::eliminate_loops() {
  if (!implicit_ || !program_.plan.explicit_form || program_.blocks.empty() || clock_.end() != RunClock::End::none)
    return false;
  eliminated_at_ = t_;
  given_at_.reset();
  return change_form(false);
}

/// What Radau IIA, or the explicit method, failed at is tried by BDF, or by IDA where the loops stay unknowns, before
/// it is an error, if `auto` has chosen. False if it had not.
bool Run::take_multistep() {
  if (!one_step_ || clock_.end() != RunClock::End::none) return false;
  multistep_at_ = t_;
  stiffness_.give_up();
  return change_form(implicit_);
}

/// Whether the integrator's iteration fails in more than every fourth step with loops inside the rates, or four times a
/// step by Radau IIA: where it does, the other form, or the other method, has little to lose. Each once in a run.
/// (Radau fails about once a step where friction is smoothed to less than its tolerance, and is right there; BDF takes
/// such friction for a force of one sign.)
bool Run::iteration_stalls() {
  constexpr std::uint64_t kSteps = 256;
  const long most = one_step_ ? 1024 : 64;
  const bool other_form = !program_.rates.solves.empty() && !given_at_ && !eliminated_at_;
  if (inputs_.method != Method::automatic || !(one_step_ || (other_form && !implicit_)) || events_.holding() ||
      steps_ < next_look_)
    return false;
  const long failures = counts().convergence_failures;
  const bool stall = next_look_ > 0 && failures > failures_seen_ + most;
  next_look_ = steps_ + kSteps;
  failures_seen_ = failures;
  return stall;
}

/// Between BDF and the explicit method, where `auto` has that choice.
void Run::follow_stiffness() {
  if (implicit_ || multistep_at_ || events_.holding()) return;
  if (stiffness_.look(t_, x_.data(), branch_, counts())) change_form(false);
}

void Run::give_loops() {
  given_at_ = t_;
  change_form(true);
  tolerances_.estimate(evaluator_, t_, x_.data(), branch_, schedule_.samples(t_));
}

bool Run::change_form(bool implicit) {
  counts_before_ = counts();
  implicit_ = implicit;
  tolerances_.use_tears(implicit);
  fresh_ = true;
  return choose_integrator();
}

std::string given_loops_words(double since) {
  return "loops are unknowns of the integrator from t = " + number_text(since) +
         " on: solved inside the state equations, they kept its iteration from converging";
}

std::string eliminated_loops_words(double since) {
  return "loops are solved inside the state equations from t = " + number_text(since) +
         " on: as unknowns of the integrator they were not found, or kept a condition from being held at its border";
}

}  // namespace bgsim
