// The loop of a switched run: one stretch after the other.
#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/trace_csv.hpp"
#include "run/failures.hpp"
#include "run/switched_run.hpp"

namespace bgsim {

namespace {

RunEvent::Kind kind_of_change(const Element& element) {
  using Kind = RunEvent::Kind;
  return element.contact ? Kind::contact : element.diode ? Kind::diode : Kind::switching;
}

}  // namespace

RunResult SwitchedRun::execute() {
  result_.report.switches = true;
  if (options_.resume.empty() || resume())
    while (stretch()) {
    }
  const double reached = result_.report.reached;
  log_.reach(reached);
  if (auto full = log_.full(reached); full && result_.stop == StopReason::completed) fail(std::move(*full));
  offer_end();
  add_mode_seconds();
  finish();
  result_.mode = mode_;
  return std::move(result_);
}

bool SwitchedRun::stretch() {
  log_.reach(stored_.t);
  if (options_.snapshot && !(stored_.t < inputs_.stop)) {
    at_stop_ = state();
    log_.count_given();
  }
  const Program* program = enter_mode();
  if (program == nullptr || !vary_into(*program)) return false;
  note_indefinite(*program);
  log_start(*program->model, stored_.t);
  log_sides(*program->model, [](bool) { return true; });
  forget_rests();
  if (auto full = log_.full(stored_.t)) return fail(std::move(*full));
  earlier_row_ = last_row_;
  return stretch_in(*program, "");
}

bool SwitchedRun::stretch_in(const Program& in_mode, const std::string& resume) {
  // A flight may be ever so short beside the steps that the tolerance asks for, and within one the solution is known to
  // that: rebounds of 1e-9 s came down 1e-10 s early, each of them.
  constexpr double kLonger = 1.25;
  const Program* const program = &in_mode;
  SimulateOptions options = options_here();
  options.resume = resume;
  const RunInputs inputs = inputs_here(*program);
  Run run(*program, inputs, options, clock_, delayed_, &evaluators_.of(*program, inputs.parameters));
  run.know_scales(scales(*program));
  std::vector<AtBorder> at_border = at_border_;
  at_border.insert(at_border.end(), held_.begin(), held_.end());
  run.know_at_border(std::move(at_border));
  run.know_steps(steps_, next_snapshot_, static_cast<bool>(options.snapshot));
  if (resume.empty()) hand_errors(*program, run);
  if (const double soonest = soonest_return(); resume.empty() && soonest > 0.0)
    run.stop_at(stored_.t + kLonger * soonest);
  run.share_log(log_);
  if (variation_) run.know_instant(variation_->instant(), !(stored_.t > inputs_.start));
  if (!events_.empty()) run.know_events(events_);
  // As long as it is the start, what was before it is to be what the mode found last makes of it.
  if (delays_ && stored_.t > inputs_.start) run.know_delays(std::move(*delays_));
  delays_.reset();
  const RunResult part = run.execute();
  // The clock of a mode without states is no state of the model: the network of the diodes has others by its number.
  const bool only_clock = has_only_clock(*program);
  for (std::size_t i = 0; i < program->states.size() && !only_clock; ++i) {
    double& scale = scale_[key(program->states[i])];
    scale = std::max(scale, run.largest(i));
    if (part.report.steps > 0) tolerance_[key(program->states[i])] = run.tolerance(i);
  }
  steps_ += run.steps();
  next_snapshot_ = run.next_snapshot();
  add(part);
  if (!program->events.empty()) events_ = run.events();
  if (!delayed_.empty()) delays_ = run.delays();
  if (!part.stored.values.empty()) stored_ = part.stored;
  take_errors(*program, run, part);
  const auto drop_clock = [&] {
    if (!only_clock) return;
    std::erase_if(stored_.values, [&](const auto& value) {
      return value.signal == program->states.front().signal || value.signal == program->states.back().signal;
    });
  };
  if (part.stop != StopReason::completed || !run.left_mode()) {
    drop_clock();
    return false;
  }
  if (stored_.values.size() != program->states.size() + program->dependent.size())
    return fail(no_jump_failure("what the dependent stores hold has no value", stored_.t));
  if (!vary_out_of(*program, run)) return false;
  drop_clock();
  if (run.left_by_states()) changes_.push_back(stored_.t);
  take_diodes(run.diodes());
  held_ = run.held();
  return change_mode(run.leaving(), *program);
}

bool SwitchedRun::vary_into(const Program& program) {
  if (!variation_) return true;
  auto refused = variation_->enter(program, parameters_, stored_.t, scales(program), x_);
  return !refused || fail(std::move(*refused));
}

bool SwitchedRun::vary_out_of(const Program& program, Run& run) {
  if (!variation_) return true;
  std::optional<Diagnostic> refused;
  auto departure = run.departure(refused);
  if (!departure) return fail(std::move(*refused));
  variation_->leave(program, parameters_, stored_.t, std::move(*departure), stored_, scales(program));
  return true;
}

double SwitchedRun::soonest_return() const {
  double soonest = 0.0;
  for (const double each : returns_)
    if (each > 0.0 && (soonest == 0.0 || each < soonest)) soonest = each;
  return soonest;
}

const Program* SwitchedRun::enter_mode() {
  const Program* program = nullptr;
  constexpr std::size_t kMostJumps = 100;
  std::vector<Mode> met;
  bool tried = false, settled = false;
  while (true) {
    const Mode last = mode_;
    if (!std::exchange(settled, false) && !settle_diodes()) return nullptr;
    if (!kick_.empty()) {
      if (met.size() >= kMostJumps) break;
      if (impact_of() == ImpactOf::rest) met.push_back(mode_);
      if (!take_impact()) return nullptr;
      program = nullptr;
      continue;
    }
    if (program != nullptr && mode_ == last) {
      if (hold_or_try(*program, tried)) return program;
      if (result_.failure) return nullptr;
      settled = true;
    }
    if (met.size() >= kMostJumps) break;
    met.push_back(mode_);
    program = program_here();
    if (program == nullptr) {
      // Paths of diodes side by side share a current in any way, and the graph allows one of them to conduct.
      if (std::exchange(tried, true) || !try_allowed()) return nullptr;
      settled = true;
      continue;
    }
    const bool diodes = !program->diode_elements.empty();
    parameters_ = inputs_.parameters;
    if (diodes) parameters_.resize(program->model->parameters.size(), 0.0);
    put_rests(*program->model);
    bool moved = false;
    if (!jump_into_mode(*program, moved)) return nullptr;
    if (!diodes) return program;
    if (!moved) {
      if (hold_or_try(*program, tried)) return program;
      if (result_.failure) return nullptr;
      settled = true;
      program = nullptr;  // of the mode that was left now
      continue;
    }
    if (!store_jumped(*program, parameters_, x_)) return nullptr;
    if (variation_) variation_->tie(*program, parameters_);
  }
  fail(diagnostic_of("BG604",
                     "at t = " + number_text(stored_.t) + " the diodes change sides without end: " +
                         std::to_string(kMostJumps) + " times, at last to \"" + mode_words() + "\"",
                     {}, "at one instant diodes change sides until none leaves the side that it is on",
                     "a law beside them gives off energy"));
  return nullptr;
}

void SwitchedRun::log_start(const Model& model, double t) {
  if (!log_.wanted() || std::exchange(logged_start_, true)) return;
  logged_ = mode_;
  std::size_t next = 0;
  for (const Element& element : model.elements) {
    if (!is_switch(element.kind)) continue;
    const std::string kind(event_kind_text(kind_of_change(element)));
    log_.add({RunEvent::Kind::start, t, element.name, kind, "", side_text(element, mode_[next++]), {}, {}});
  }
}

void SwitchedRun::log_sides(const Model& model, const std::function<bool(bool)>& which) {
  if (!log_.wanted() || logged_ == mode_) return;
  std::size_t next = 0, diode = 0;
  for (const Element& element : model.elements) {
    if (!is_switch(element.kind)) continue;
    const std::size_t i = next++;
    const double rest = element.diode ? rests_[diode++].value_or(stored_.t) : stored_.t;
    if (logged_[i] == mode_[i] || !which(is_diode_[i])) continue;
    const bool from = logged_[i];
    logged_[i] = mode_[i];
    // A contact that its wall leaves before its impacts have ended has not touched.
    if (element.contact && mode_[i] && log_.take_back(element.name)) continue;
    const bool later = element.contact && !mode_[i] && rest > stored_.t;
    const RunEvent change{kind_of_change(element),  later ? rest : stored_.t,     element.name, "",
                          side_text(element, from), side_text(element, mode_[i]), {},           {}};
    if (later)
      log_.add_later(change);
    else
      log_.add(change);
  }
}

void SwitchedRun::log_jump(Evaluator& evaluator, const std::vector<double>& x, std::optional<double> loss) {
  if (!log_.wanted()) return;
  const Program& program = evaluator.program();
  Branch branch = first_branch(program);
  std::vector<double> dependent(program.dependent.size());
  if (!evaluator.initialize_modes(stored_.t, x.data(), branch) ||
      !evaluator.dependents(stored_.t, x.data(), branch, dependent.data()))
    return;  // the run comes to this as well, and says so
  const auto look = [&](const StateInfo& state, const std::string& name, double to) {
    const double from = value_of(stored_, state);
    // What a store holds is known to its tolerance: a current that a diode cuts at 0 does not jump there.
    const auto scale = scale_.find(key(state));
    const double size = std::max(std::abs(from), scale == scale_.end() ? 0.0 : scale->second);
    if (state.signal.valid() || std::abs(to - from) <= kRounding * size) return;
    log_.add({RunEvent::Kind::jump, stored_.t, name, "", shortest_number(from), shortest_number(to), {}, loss});
    loss.reset();
  };
  for (std::size_t i = 0; i < x.size(); ++i) look(program.states[i], program.state_names[i], x[i]);
  for (std::size_t i = 0; i < dependent.size(); ++i)
    look(program.dependent[i], program.dependent_names[i], dependent[i]);
}

RunResult simulate_switched(const SwitchedPrograms& programs, const SwitchedStart& start, const RunInputs& inputs,
                            const SimulateOptions& options, const Clock& clock) {
  return SwitchedRun(programs, start, inputs, options, clock).execute();
}

}  // namespace bgsim
