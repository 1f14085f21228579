// What happens before the first step.
#include "run/choose.hpp"
#include "run/failures.hpp"
#include "run/integrate/separability.hpp"
#include "run/notes.hpp"
#include "run/run.hpp"
#include "run/sink/trajectory.hpp"

namespace bgsim {

/// Initial states, modes and loops; everything that can be at fault before the first step.
bool Run::begin() {
  t_ = jumped_at_ = inputs_.start;
  if (!delays_.goes_on()) delays_.clear();
  branch_ = first_branch(program_);
  evaluator_.set_time_modes(t_, branch_);
  x_ = initial_states(evaluator_, inputs_);
  // What was held goes on within the tolerances.
  if (!known_scales_.empty()) tolerances_.accept(t_, known_scales_);
  if (!events_.start(t_, x_.data(), branch_)) return fail(*events_.failure());
  std::vector<std::string> found;
  if (!evaluator_.explore_loops(t_, x_.data(), branch_, found)) return fail_with_fault();
  for (std::string& line : found) result_.report.notes.push_back(std::move(line));
  if (!events_.settle(t_, x_.data(), branch_)) return fail(*events_.failure());
  for (int again = 0; delays_.any() && !delays_.goes_on() && again < 2;
       ++again) {  // conditions may depend on what was before
    if (!delays_.begin(t_, x_.data(), branch_)) return fail(*delays_.failure());
    if (!events_.settle(t_, x_.data(), branch_)) return fail(*events_.failure());
  }
  if (delays_.goes_on() && !delays_.changed(t_, x_.data(), branch_, true)) return fail(*delays_.failure());

  if (instant_ != 0.0) {  // at a time that does not move, from here on
    std::vector<double> rates(x_.size());
    if (!evaluator_.rates(t_, x_.data(), branch_, rates.data())) return fail_with_fault();
    for (std::size_t i = 0; i < program_.varied_states; ++i) x_[program_.varied_states + i] -= rates[i] * instant_;
  }
  // Later stretches begin at borders that have just been passed.
  if (follows_another_) {
    variations_.follow(t_, instant_);
  } else if (program_.varied_states > 0) {
    VariedGuards guards(evaluator_);
    if (auto refused = variations_.begin(evaluator_, guards, t_, x_, branch_, !inputs_.starting_events.empty()))
      return fail(std::move(*refused));
  }
  if (options_.trajectory != nullptr) options_.trajectory->begin(t_, x_, branch_);

  log_->watch(program_);
  log_->look(t_, branch_);
  note(negative_start_note(program_, x_));
  audit_.record_course(inputs_.output_times, options_.energy_course);
  audit_.begin(t_, x_.data(), branch_);
  measures_.begin(t_, x_.data(), branch_, inputs_.stop, inputs_.relative);
  return true;
}

/// False if the method asked for cannot be used on this system.
bool Run::choose_integrator() {
  RunReport& report = result_.report;
  const MethodChoice choice = implicit_ ? choose_method_with_loops(program_, inputs_, multistep_at_)
                                        : choose_method(program_, inputs_, multistep_at_, &stiffness_);
  const MethodFacts& facts = facts_of(choice.method);
  one_step_ = inputs_.method == Method::automatic && facts.family != MethodFamily::multistep;
  const Loops loops = implicit_ ? Loops::unknowns : Loops::inside;
  if (implicit_ && inputs_.method != Method::automatic && facts_of(inputs_.method).family != MethodFamily::multistep &&
      !solves_for_loops(facts_of(inputs_.method)))
    return fail(needs_explicit_form_failure(facts_of(inputs_.method).name));
  report.method_reason = given_at_ && implicit_ ? given_loops_words(*given_at_)
                         : eliminated_at_       ? eliminated_loops_words(*eliminated_at_)
                                                : choice.reason;
  if (facts.family == MethodFamily::collocation) {
    integrator_ = make_radau_integrator(program_, evaluator_, tolerances_, inputs_, facts.order, loops);
  } else if (facts.family == MethodFamily::rosenbrock) {
    integrator_ = make_rodas_integrator(program_, evaluator_, tolerances_, inputs_, loops);
  } else if (choice.method == Method::ida) {
    integrator_ = implicit_ ? make_ida_integrator(program_, evaluator_, tolerances_, inputs_)
                            : make_ida_explicit_integrator(program_, evaluator_, tolerances_, inputs_);
  } else if (choice.method == Method::verlet) {
    NotSeparable obstacle;
    if (!separate(program_, obstacle)) return fail(not_separable_failure(program_, obstacle));
    integrator_ = make_verlet_integrator(program_, evaluator_, inputs_);
  } else if (facts.family == MethodFamily::multistep) {
    integrator_ = make_cvode_integrator(program_, evaluator_, tolerances_, inputs_);
  } else if (inputs_.method == Method::automatic) {
    integrator_ = make_dormand_prince_integrator(program_, evaluator_, tolerances_, inputs_);
  } else {
    integrator_ = make_arkode_integrator(program_, evaluator_, tolerances_, inputs_);
  }
  report.step = inputs_.step;
  double longest = schedule_.sources().longest_step;
  if (const double delay = delays_.longest(); delay > 0.0) longest = longest > 0.0 ? std::min(longest, delay) : delay;
  if (longest > 0.0) integrator_->limit_step(longest);
  if (mode_order_.spent()) integrator_->limit_order(mode_order_.spent()->order);
  return true;
}

/// What follows from the scene alone, before the first step.
bool Run::plan() {
  if (auto too_narrow = schedule_.plan()) return fail(std::move(*too_narrow));
  const SourcePlan& sources = schedule_.sources();
  pace_.know_sources(sources.longest_step, sources.frequency);
  tolerances_.know_edges(sources.edges);
  tolerances_.know_proportional(proportional_states(program_, evaluator_.constants(), inputs_.start, inputs_.stop));
  return true;
}

}  // namespace bgsim
