// What happens at one instant: known times, events of states, what the model's events set, switches that turn.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "run/failures.hpp"
#include "run/run.hpp"
#include "run/sink/trajectory.hpp"

namespace bgsim {

/// Modes beyond a known time.
bool Run::take_time_event() {
  between_ = true;
  ++time_events_;
  jumped_at_ = t_;
  continuity_.before(t_, x_.data(), branch_);
  const Branch before = differentiates() ? branch_ : Branch{};
  const Branch on_the_way = schedule_.denominators().empty() ? Branch{} : branch_;
  schedule_.pass(t_, branch_);
  for (const std::size_t relation : schedule_.denominators())
    if (branch_.modes[relation] != on_the_way.modes[relation] &&
        events_.is_singular(relation, t_, known_from_.empty() ? x_ : known_from_, on_the_way))
      return fail(singularity_failure(program_, relation, t_));
  delays_.pass(t_);
  if (!events_.settle(t_, x_.data(), branch_)) return fail(*events_.failure());
  if (differentiates() && !vary_event(before, {})) return false;
  if (auto jump = continuity_.after(t_, x_.data(), branch_)) return fail(std::move(*jump));
  log_->look(t_, branch_);
  due_ = between_ = false;
  return settle_instant() && (delays_.changed(t_, x_.data(), branch_) || fail(*delays_.failure()));
}

bool Run::take_state_event() {
  const double t = events_.event_time();
  const bool at_once = t == t_;  // nothing of the step is taken: where it begins a condition changes
  if (!at_once) {
    errors_.add(t_, x_, t, *integrator_);
    // The moment is known to within its roundings: an output time as near as that shows what comes after.
    constexpr double kLocated = 100.0 * std::numeric_limits<double>::epsilon();
    if (!emit(recorder_.before(t - kLocated * std::abs(t), *integrator_))) return false;
    if (!audit_to(t)) return false;
  }
  between_ = true;
  if (!at_once) go_to(t);
  jumped_at_ = t;
  continuity_.before(t_, x_.data(), branch_);
  if (!at_once) errors_.before_event(t_, x_, branch_);
  const Branch before = differentiates() ? branch_ : Branch{};
  if (!events_.cross(x_.data(), branch_)) return fail(*events_.failure());
  delays_.pass(t_);
  if (delays_.any() && !events_.settle(t_, x_.data(), branch_)) return fail(*events_.failure());
  if (differentiates() && !vary_event(before, events_.crossed_guard())) return false;
  if (!at_once) errors_.after_event(t_, x_, branch_, events_.crossed_guard());
  if (auto jump = continuity_.after(t_, x_.data(), branch_)) return fail(std::move(*jump));
  tolerances_.forget_noise();  // of rates beyond the event, evaluated on the side before it
  between_ = false;
  fresh_ = true;
  log_->look(t_, branch_);
  if (events_.stays_within_tolerance()) take_multistep();
  if (settle_instant()) return delays_.changed(t_, x_.data(), branch_) ? emit_here() : fail(*delays_.failure());
  left_by_states_ = left_mode_;
  return false;
}

/// Samples and latches that are due change one after the other: switches and the events of the file see all of them
/// changed. False if the run ends here.
bool Run::settle_memory() {
  while (jumps_.any()) {
    if (!events_.prepare(t_, x_.data(), branch_)) return fail_with_fault();
    if (!jumps_.look(t_, x_.data(), branch_, true)) return fail(*jumps_.failure());
    if (jumps_.due().empty()) return true;
    if (!take_events()) return false;
  }
  return true;
}

/// At one instant: switches first, then the events of the model that are due, until neither does anything. False if the
/// run ends here.
bool Run::settle_instant() {
  std::optional<std::size_t> latest;
  bool turned = false;
  if (auto full = log_->full(t_)) return fail(std::move(*full));
  while (stays_in_mode()) {
    if (!jumps_.any()) return true;
    if (!events_.prepare(t_, x_.data(), branch_)) return fail_with_fault();
    if (!jumps_.look(t_, x_.data(), branch_, false)) return fail(*jumps_.failure());
    if (!jumps_.due().empty()) {
      if (turned && jumps_.repeats(t_))
        return fail(jumps_.endless(t_, "it is due again as soon as it has taken place"));
      latest = jumps_.due().front();
      const bool memory = jumps_.of_memory();
      if (!take_events() || (memory && !settle_memory())) return false;
    } else if (latest && events_.turn_back(t_, x_.data(), branch_)) {
      turned = true;
      log_->look(t_, branch_);
    } else {
      if (!latest) return true;
      if (events_.unresolved()) return fail(jumps_.accumulation(*latest, t_));
      if (events_.rests())
        if (auto note = jumps_.resting(*latest, t_)) result_.report.notes.push_back(std::move(*note));
      return true;
    }
  }
  return false;
}

/// What the events that are due set.
bool Run::take_events() {
  if (events_.unresolved()) return fail(jumps_.accumulation(jumps_.due().front(), t_));
  jumped_at_ = t_;
  fresh_ = true;
  measures_.look(t_, x_.data(), branch_);
  // Before the start there was no value that a first one could jump from.
  const bool watched = continuity_.watches_sets() && t_ > inputs_.start;
  if (watched) continuity_.before(t_, x_.data(), branch_);
  const std::vector<double> x_before = options_.trajectory != nullptr ? x_ : std::vector<double>{};
  const Branch branch_before = options_.trajectory != nullptr ? branch_ : Branch{};
  std::vector<double> rates(program_.varied_states > 0 ? x_.size() : 0);
  if (!rates.empty() && !evaluator_.rates(t_, x_.data(), branch_, rates.data())) return fail_with_fault();
  errors_.before_set(t_, x_, branch_, [this](double t, std::vector<double>& x, const Branch& branch) {
    return jumps_.set_elsewhere(t, x, branch);
  });
  for (const std::size_t event : jumps_.due()) {
    const std::vector<double> before = log_->wanted() ? x_ : std::vector<double>{};
    audit_.before_jump(t_, x_.data(), branch_);
    jumps_.set(event, x_);
    if (!events_.jumped(t_, x_.data(), program_.events[event], branch_)) return fail(*events_.failure());
    const double energy = audit_.after_jump(t_, x_.data(), branch_);
    jumps_.bring(event, energy);
    if (!log_->wanted()) continue;
    log_->add_set(t_, program_, event, before, x_, options_.energy_audit ? std::optional(energy) : std::nullopt);
    log_->look(t_, branch_);
  }
  if (watched)
    if (auto jump = continuity_.after_sets(t_, x_.data(), branch_)) return fail(std::move(*jump));
  if (!rates.empty() && !vary_sets(rates)) return false;
  if (options_.trajectory != nullptr) options_.trajectory->set(t_, x_before, branch_before, x_, branch_, jumps_.due());
  errors_.after_set(t_, x_, branch_);
  if (auto full = log_->full(t_)) return fail(std::move(*full));
  tolerances_.forget_noise();
  tolerances_.accept(t_, x_);
  return jumps_.taken(t_) || fail(*jumps_.failure());
}

/// Whether all switches stay on their side. If not, the run ends here, before anything is recorded of this instant.
bool Run::stays_in_mode() {
  if (program_.switch_elements.empty()) return true;
  leaves_.resize(program_.switch_elements.size());
  if (!events_.prepare(t_, x_.data(), branch_) || !evaluator_.switches(t_, x_.data(), branch_, leaves_.data()))
    return fail_with_fault();
  left_mode_ = std::any_of(leaves_.begin(), leaves_.end(), [](double leaves) { return leaves != 0.0; });
  // The next mode sees a state, not what was held: of a mass that a contact throws back it could not say which it is.
  if (left_mode_ && events_.holding()) static_cast<void>(put_on_borders(0.0));
  if (left_mode_ && !program_.diode_elements.empty()) {
    diodes_.resize(4 * program_.diode_elements.size());
    if (!evaluator_.diodes(t_, x_.data(), branch_, diodes_.data())) return fail_with_fault();
  }
  return !left_mode_;
}

}  // namespace bgsim
