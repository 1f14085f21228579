// What the stretches of a switched run sum up to.
#include "base/text.hpp"
#include "model/add_symbols.hpp"
#include "run/notes.hpp"
#include "run/sink/output_measures.hpp"
#include "run/switched_run.hpp"
#include "run/watch/pace_words.hpp"

namespace bgsim {

std::vector<double> SwitchedRun::scales(const Program& program) const {
  std::vector<double> result;
  if (scale_.empty()) return result;
  for (const StateInfo& state : program.states) {
    const auto found = scale_.find(key(state));
    result.push_back(found == scale_.end() ? 0.0 : found->second);
  }
  return result;
}

void SwitchedRun::add(const RunResult& part) {
  RunReport& report = result_.report;
  const RunReport& own = part.report;
  result_.stop = part.stop;
  result_.failure = part.failure;
  if (part.failure && part.failure->code == "BG618")  // of what was left of the limit
    result_.failure = time_limit_failure(own.reached, inputs_.stop, options_.time_limit);
  result_.rows += part.rows;
  result_.beside_end.insert(result_.beside_end.end(), part.beside_end.begin(), part.beside_end.end());
  if (variation_) {
    result_.instants.insert(result_.instants.end(), part.instants.begin(), part.instants.end());
    result_.instants.push_back(own.reached);
  }
  report.model = own.model;
  report.scene = own.scene;
  if (!own.method.empty() &&
      (!short_flight_ || report.method.empty())) {  // a mode that begins at the stop makes no step
    report.method = own.method;
    report.method_reason = own.method_reason;
  }
  const bool clock = own.absolute.size() == 1 && own.absolute.front().first == kModeClock;
  report.states = std::max(report.states, own.states - (clock ? 1 : 0));
  report.algebraic = std::max(report.algebraic, own.algebraic);
  report.loops = std::max(report.loops, own.loops);
  report.step = own.step;
  report.relative = own.relative;
  report.reached = own.reached;
  report.steps += own.steps;
  report.rate_evaluations += own.rate_evaluations;
  report.jacobian_evaluations += own.jacobian_evaluations;
  report.factorizations += own.factorizations;
  report.nonlinear_iterations += own.nonlinear_iterations;
  report.error_test_failures += own.error_test_failures;
  report.convergence_failures += own.convergence_failures;
  report.loop_iterations += own.loop_iterations;
  report.time_events += own.time_events;
  report.state_events += own.state_events;
  for (const auto& [state, tolerance] : own.absolute) {
    if (clock) break;
    const auto same = [&name = state](const auto& entry) { return entry.first == name; };
    const auto found = std::find_if(report.absolute.begin(), report.absolute.end(), same);
    if (found == report.absolute.end())
      report.absolute.emplace_back(state, tolerance);
    else
      found->second = tolerance;
  }
  for (const auto& [stage, seconds] : own.stage_seconds) {
    const auto same = [&name = stage](const auto& entry) { return entry.first == name; };
    const auto found = std::find_if(report.stage_seconds.begin(), report.stage_seconds.end(), same);
    if (found == report.stage_seconds.end())
      report.stage_seconds.emplace_back(stage, seconds);
    else
      found->second += seconds;
  }
  report.set_events = own.set_events;  // counted over all stretches
  constexpr std::size_t kMostNotes = 20;
  for (const std::string& note : own.notes)
    if (report.notes.size() < kMostNotes && !solved_before(note) && !of_lift_off(note) &&
        std::find(report.notes.begin(), report.notes.end(), note) == report.notes.end()) {
      report.notes.push_back(note);
      if (std::find(own.undecided.begin(), own.undecided.end(), note) != own.undecided.end())
        report.undecided.push_back(note);
    }
  if (estimates_) report.errors = own.errors;
  add_energy(own.energy);
  append(report.measures, own.measures);
  if (report.why_not_measured.empty()) report.why_not_measured = own.why_not_measured;
}

bool SwitchedRun::solved_before(const std::string& note) const {
  const std::size_t words = note.find(": ");
  if (words == std::string::npos || note.find(", found from the start ") == std::string::npos ||
      note.find("other solutions exist") != std::string::npos)
    return false;
  const std::string loop = note.substr(0, words + 2);
  return std::any_of(result_.report.notes.begin(), result_.report.notes.end(),
                     [&](const std::string& before) { return before.starts_with(loop); });
}

bool SwitchedRun::of_lift_off(const std::string& note) const {
  return lifts_off_ && note.starts_with("whether ") && note.find(kBandParameter) != std::string::npos;
}

void SwitchedRun::add_energy(const EnergyAudit& own) {
  EnergyAudit& energy = result_.report.energy;
  if (!own.done) {
    audited_ = false;
    energy.why_not = own.why_not;
    return;
  }
  EnergyCourse& course = energy.course;
  const EnergyCourse& piece = own.course;
  for (std::size_t i = 0; i < piece.times.size(); ++i) {
    course.times.push_back(piece.times[i]);
    course.supplied.push_back(energy.supplied + energy.events + piece.supplied[i]);
    course.stored.push_back(energy.stored + piece.stored[i]);
    course.dissipated.push_back(energy.dissipated + energy.switching + energy.impacts + piece.dissipated[i]);
    course.exchanged.push_back(energy.exchanged + piece.exchanged[i]);
    course.residual.push_back(energy.residual + piece.residual[i]);
  }
  energy.supplied += own.supplied;
  energy.stored += own.stored;
  energy.dissipated += own.dissipated;
  energy.exchanged += own.exchanged;
  energy.residual += own.residual;
  energy.events += own.events;
  energy.turnover += own.turnover;
  energy.activity.resize(own.activity.size());
  for (std::size_t i = 0; i < own.activity.size(); ++i) energy.activity[i] += own.activity[i];
  if (own.least_dissipation < energy.least_dissipation || energy.least_dissipation_element.empty()) {
    energy.least_dissipation = own.least_dissipation;
    energy.least_dissipation_element = own.least_dissipation_element;
  }
}

void SwitchedRun::add_mode_seconds() {
  double rest = clock_() - begin_;
  for (const auto& [stage, seconds] : result_.report.stage_seconds) rest -= seconds;
  result_.report.stage_seconds.insert(result_.report.stage_seconds.begin(), {"modes", std::max(0.0, rest)});
}

void SwitchedRun::finish() {
  RunReport& report = result_.report;
  report.start = inputs_.start;
  report.stop = inputs_.stop;
  report.relative = inputs_.relative;
  report.reached = std::max(report.reached, inputs_.start);
  report.modes = met_.size();
  report.accumulations = accumulations_;
  report.contacts = names_ && std::any_of(names_->elements.begin(), names_->elements.end(),
                                          [](const Element& element) { return element.contact.has_value(); });
  if (estimates_) {
    if (auto note = output_errors_note(report.errors, result_.trace.names, inputs_.relative))
      report.notes.push_back(std::move(*note));
  } else if (options_.error_estimate && report.errors.possible && result_.stop == StopReason::completed) {
    report.notes.push_back(lost_errors_note(report.errors.why_not));
  }
  EnergyAudit& energy = report.energy;
  energy.done = audited_ && options_.energy_audit && !result_.report.model.empty();
  if (!energy.done && energy.why_not.empty()) energy.why_not = "the run did not start";
  if (energy.turnover > 0.0) energy.relative = std::abs(energy.residual) / energy.turnover;
  if (accumulations_ > kNotedAccumulations)
    report.notes.push_back("contacts closed where infinitely many impacts add up " + std::to_string(accumulations_) +
                           " times in all");
  if (lone_jumps_ > noted_.size())
    report.notes.push_back("stores emptied by a switch at once: " + std::to_string(lone_jumps_) + " times in all");
  result_.stored = stored_;
}

}  // namespace bgsim
