// From one mode of a switched run to the next: the program, the jump, and where changes of the mode have no end.
#include <limits>

#include "base/codes.hpp"
#include "run/failures.hpp"
#include "run/switched_run.hpp"

namespace bgsim {

bool SwitchedRun::store_jumped(const Program& program, const std::vector<double>& parameters,
                               const std::vector<double>& x) {
  Evaluator& evaluator = evaluators_.of(program, parameters);
  Branch branch = first_branch(program);
  std::vector<double> dependent(program.dependent.size());
  if (!evaluator.initialize_modes(stored_.t, x.data(), branch) ||
      !evaluator.dependents(stored_.t, x.data(), branch, dependent.data()))
    return fail(fault_failure(evaluator.fault()));
  store_exactly(evaluator);
  put_stored(stored_, program, x, dependent);
  return true;
}

Mode SwitchedRun::settling() const {
  Mode settling;
  std::size_t next = 0;
  for (std::size_t i = 0; i < mode_.size(); ++i) {
    if (!is_diode_[i]) continue;
    const std::optional<double>& rest = rests_[next++];
    if (!rest || !(*rest > stored_.t) || mode_[i]) continue;
    settling.resize(mode_.size());
    settling[i] = true;
  }
  return settling;
}

void SwitchedRun::forget_rests() {
  std::size_t next = 0;
  for (std::size_t i = 0; i < mode_.size(); ++i) {
    if (!is_diode_[i]) continue;
    std::optional<double>& rest = rests_[next++];
    if (rest && (mode_[i] || !(*rest > stored_.t))) rest.reset();
  }
}

const Program* SwitchedRun::program_here() {
  try {
    const Program& program = program_of_(mode_, settling());
    met_.insert(mode_);
    if (result_.trace.names.empty()) {
      result_.trace.names = program.output_names;
      result_.trace.units = program.output_units;
      result_.trace.columns.resize(program.output_names.size());
      names_ = program.model;
    }
    return &program;
  } catch (const ModelError& error) {
    fail(not_allowed(error));
    return nullptr;
  }
}

/// Outputs that idle switches and diodes leave indefinite, each once.
void SwitchedRun::note_indefinite(const Program& program) {
  std::string outputs;
  std::size_t count = 0;
  std::vector<std::string> names = shared_outputs(program);
  const bool shared = !names.empty();
  names.insert(names.end(), program.indefinite_outputs.begin(), program.indefinite_outputs.end());
  for (const std::string& output : names)
    if (indefinite_.insert(output).second) outputs += (count++ == 0 ? "\"" : "\", \"") + output;
  if (outputs.empty()) return;
  std::string why;
  const auto add = [&why](const Element& element, const std::string& words) {
    why += (why.empty() ? "\"" : ", \"") + element.name + "\" " + words;
  };
  for (const Element& element : program.model->elements)
    if (element.idle)
      add(element, "is " + std::string(side_text(element, is_closed(element))) +
                       " beside switches that are, too, and is taken to have no " +
                       (is_closed(element) ? "flow" : "effort"));
  for (const ElementId id : program.indefinite_diodes) {
    const Element& element = program.model->elements[id.index()];
    add(element, is_closed(element) ? "has no flow, whatever its effort is, and is taken to conduct"
                                    : "has no effort beside diodes that conduct, and is taken to have no flow");
  }
  for (const Element& element : program.model->elements)
    if (shared && element.share.valid() && parameters_[element.share.index()] != 0.0)
      add(element, "is held between what diodes or contacts lock, and its part is one of many");
  result_.report.notes.push_back("from t = " + number_text(stored_.t, 6) + " " + outputs +
                                 (count == 1 ? "\" is" : "\" are") + " indefinite: " + why);
}

Diagnostic SwitchedRun::not_allowed(const ModelError& error) const {
  Diagnostic diagnostic = error.diagnostics.front();
  diagnostic.notes.insert(diagnostic.notes.begin(), Note{std::nullopt, "in this mode " + diagnostic.situation});
  diagnostic.code = "BG619";
  diagnostic.severity = Severity::error;
  diagnostic.situation = "at t = " + number_text(stored_.t) +
                         " the switches come to a mode that the graph does not "
                         "allow: " +
                         mode_words();
  return diagnostic;
}

double SwitchedRun::energy_of_rounding(const Jump& jump) const {
  // Speeds that are some roundings of those the run has had carry so much of its energy, and follow no law.
  constexpr double kRoundings = 64.0 * std::numeric_limits<double>::epsilon();
  return kRounding * jump.scale + kRoundings * kRoundings * result_.report.energy.turnover;
}

bool SwitchedRun::jump_into_mode(const Program& program, bool& moved) {
  Evaluator& evaluator = evaluators_.of(program, parameters_);
  Jump jump = jump_into(evaluator, stored_.t, stored_);
  if (jump.failure) return fail(std::move(*jump.failure));
  x_ = std::move(jump.x);
  moved = jump.moved;
  jump_exactly(evaluator);
  if (!jump.moved) return true;
  held_.clear();
  if (jump.loss < -energy_of_rounding(jump))
    return fail(diagnostic_of(
        "BG621",
        "at t = " + number_text(stored_.t) + " the switches come to \"" + mode_words() +
            "\", and the jump of the stores would create " + number_text(-jump.loss, 4) + " of energy",
        {}, "what a switch ties together loses energy or keeps it",
        "a store of negative capacitance or inertance, or a law that falls, is among those that are tied"));
  EnergyAudit& energy = result_.report.energy;
  energy.supplied += jump.supplied;
  energy.stored += jump.stored;
  energy.exchanged += jump.exchanged;
  energy.switching += std::max(0.0, jump.loss);
  energy.turnover += jump.scale;
  log_jump(evaluator, x_, options_.energy_audit ? std::optional(std::max(0.0, jump.loss)) : std::nullopt);
  note_lone_jumps(jump);
  return true;
}

void SwitchedRun::note_lone_jumps(const Jump& jump) {
  constexpr std::size_t kMostNoted = 4;
  if (locking_ || !switched_) return;
  for (const LoneJump& lone : jump.lone) {
    if (std::abs(lone.after) > kRounding * std::abs(lone.before)) continue;
    // Less than the tolerance of what it has been: an ideal switch that opens where the current passes zero.
    const auto scale = scale_.find(key(lone.store));
    if (scale != scale_.end() && std::abs(lone.before) <= inputs_.relative * scale->second) continue;
    ++lone_jumps_;
    if (noted_.size() >= kMostNoted || !noted_.insert(lone.name).second) continue;
    std::string text = "at t = " + number_text(stored_.t) + " " + lone.name + " goes from " +
                       number_text(lone.before, 6) + " to 0 at once (" + mode_words() + "): ";
    if (!options_.energy_audit) {
      text += "no other store takes it up";
    } else {
      text += number_text(std::max(0.0, jump.loss), 6) + " of energy is lost in the switch";
    }
    const bool momentum = lone.name.back() == 'p';
    text += momentum ? "; what stores a momentum, such as a coil, needs a way on for its flow when a switch opens"
                     : "; what stores a displacement, such as a capacitor, is short-circuited";
    result_.report.notes.push_back(std::move(text));
  }
}

SimulateOptions SwitchedRun::options_here() {
  SimulateOptions options = options_;
  options.error_estimate = options_.error_estimate && estimates_;
  if (options_.remark)
    options.remark = [this](const Diagnostic& remark) {
      if (!std::exchange(remarked_, true)) options_.remark(remark);
    };
  options.rows = [this](double t, std::span<const double> row) {
    last_row_ = t;
    if (options_.rows) return options_.rows(t, row);
    result_.trace.times.push_back(t);
    for (std::size_t i = 0; i < row.size(); ++i) result_.trace.columns[i].push_back(row[i]);
  };
  snapshot_given_ = false;
  if (options_.snapshot) options.snapshot = [this](double t, const std::string& stretch) { offer_stretch(t, stretch); };
  if (options_.time_limit > 0.0) options.time_limit = std::max(1e-9, options_.time_limit - (clock_() - begin_));
  return options;
}

RunInputs SwitchedRun::inputs_here(const Program& program) {
  RunInputs inputs = inputs_;
  inputs.start = stored_.t;
  inputs.parameters = parameters_;
  if (earlier_row_)
    inputs.output_times = inputs_.output_times.without_first(inputs_.output_times.first_after(*earlier_row_));
  short_flight_ = flies_short(program);
  lifts_off_ = false;
  for (std::size_t i = 0; i < flight_.size(); ++i)
    lifts_off_ = lifts_off_ || (diodes_[i].touches && diodes_[i].conducts && flight_[i] == 0.0);
  if (short_flight_) inputs.method = Method::radau;
  if (short_flight_ && inputs_.method != Method::automatic && !std::exchange(noted_flights_, true))
    result_.report.notes.push_back(
        "what follows where a contact opens, and rebounds that are short beside the tolerance, is integrated by "
        "Radau: multistep methods, which begin with order 1, lose it");
  inputs.initial.clear();
  for (std::size_t i = 0; i < program.states.size(); ++i) {
    const StateInfo& state = program.states[i];
    inputs.initial.push_back({state.element, state.port, x_[i], state.place, state.signal});
  }
  std::sort(inputs.initial.begin(), inputs.initial.end(), [](const auto& a, const auto& b) {
    return std::tuple(a.element, a.port, a.signal) < std::tuple(b.element, b.port, b.signal);
  });
  return inputs;
}

bool SwitchedRun::change_mode(const std::vector<double>& leaving, const Program& program) {
  if (stored_.t > instant_) departures_.clear();
  instant_ = stored_.t;
  departures_.push_back({mode_, stored_.values});
  locking_ = false;
  left_ = mode_;
  tripped_.clear();
  bool turns = false;  // and not only a contact has come to rest, which stays on its side
  for (std::size_t i = 0; i < leaving.size(); ++i) {
    const Element& element = program.model->elements[program.switch_elements[i].index()];
    const bool settles = element.contact && element.contact->settling;
    const bool leaves = leaving[i] != 0.0 && !(settles && stored_.t >= *rests_[tripped_.size()]);
    turns = turns || leaves;
    if (is_diode_[i]) tripped_.push_back(leaves);
  }
  if (!diodes_.empty() && !look_at_contacts(program)) return false;
  switched_ = diodes_.empty();
  for (std::size_t i = 0; i < leaving.size(); ++i) {
    if (leaving[i] == 0.0 || is_diode_[i]) continue;
    switched_ = true;
    mode_[i] = !mode_[i];
    const Element& element = program.model->elements[program.switch_elements[i].index()];
    locking_ = locking_ || element.switches->locks;
  }
  if (turns) ++result_.report.mode_changes;
  log_sides(*program.model, [](bool diode) { return !diode; });
  return !runs_in_circles(program) && !chatters(program) && !takes_too_long();
}

bool SwitchedRun::runs_in_circles(const Program& program) {
  constexpr std::size_t kMostInOneInstant = 1000, kShown = 6;
  const auto same = [this](const Departure& from) { return from.mode == mode_ && same_values(from.stored); };
  // Diodes may leave a mode again with the same contents, as borders are moved by roundings, but not without end.
  const auto first = switched_ ? std::find_if(departures_.begin(), departures_.end(), same) : departures_.end();
  if (first == departures_.end() && departures_.size() < kMostInOneInstant) return false;
  std::string cycle;
  const auto count = static_cast<std::size_t>(departures_.end() - first);
  for (std::size_t i = departures_.size() - std::min(count > 0 ? count : kShown, kShown); i < departures_.size(); ++i)
    cycle += "\"" + mode_text(*program.model, departures_[i].mode) + "\", ";
  cycle += "\"" + mode_text(*program.model, mode_) + "\"";
  fail(diagnostic_of("BG604", "at t = " + number_text(stored_.t) + " the modes of the switches repeat: " + cycle,
                     place_of_switches(program),
                     "at one instant switches change sides until none leaves the side that it is on",
                     "a condition that its own switch makes false needs two thresholds: \"close\" and \"open\""));
  return true;
}

bool SwitchedRun::same_values(const std::vector<RunInputs::Initial>& values) const {
  if (values.size() != stored_.values.size()) return false;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::abs(values[i].value - stored_.values[i].value) >
        kRounding * std::max(std::abs(values[i].value), std::abs(stored_.values[i].value)))
      return false;
  return true;
}

bool SwitchedRun::chatters(const Program& program) {
  constexpr std::size_t kInARow = 100;
  constexpr double kNear = 1e-9;
  if (changes_.size() > kInARow) changes_.pop_front();
  if (changes_.size() < kInARow || changes_.back() < stored_.t) return false;
  const double gap = (changes_.back() - changes_.front()) / kInARow;
  if (gap > kNear * (inputs_.stop - inputs_.start)) return false;
  fail(diagnostic_of(
      "BG604",
      "the switches change sides without end near t = " + number_text(stored_.t) + ": " + std::to_string(kInARow) +
          " changes of the mode within " + number_text(changes_.back() - changes_.front(), 3) + ", at last to \"" +
          mode_text(*program.model, mode_) + "\"",
      place_of_switches(program), "between two changes of the mode the time goes on",
      std::find(is_diode_.begin(), is_diode_.end(), false) == is_diode_.end()
          ? "another method (radau), or a smaller relative tolerance, resolves how diodes and contacts leave "
            "their sides"
          : "give the switch two thresholds that are apart: \"close\" and \"open\""));
  return true;
}

bool SwitchedRun::takes_too_long() {
  constexpr double kStretches = 8.0, kBetweenAsking = 0.05;  // seconds
  const double seconds = clock_() - begin_;
  // Modes may follow each other without a step, in which a run would ask.
  if (options_.time_limit > 0.0 && seconds >= options_.time_limit) {
    fail(time_limit_failure(stored_.t, inputs_.stop, options_.time_limit));
    return true;
  }
  if (options_.progress && seconds - asked_ > kBetweenAsking) {
    asked_ = seconds;
    if (!options_.progress(stored_.t)) {
      fail(interrupted_failure(stored_.t));
      result_.stop = StopReason::interrupted;
      return true;
    }
  }
  headway_.add(seconds, stored_.t, result_.report.steps + result_.rows + result_.report.mode_changes);
  if (options_.time_limit > 0.0 || !(options_.longest_run > 0.0)) return false;
  const auto pace = headway_.pace(std::max(kStretches, seconds / kStretches));
  if (!pace || !(pace->rest > options_.longest_run)) return false;
  fail(diagnostic_of("BG617",
                     "at t = " + number_text(stored_.t) + " the run is busy with changes of the mode, " +
                         std::to_string(result_.report.mode_changes) + " so far; at this pace it would take " +
                         number_text(pace->rest, 2) + " s more",
                     {}, "a run that takes longer than a day is ended",
                     "make the scene shorter, or the switching slower; --time-limit sets another limit"));
  return true;
}

std::optional<Place> SwitchedRun::place_of_switches(const Program& program) {
  if (program.switch_elements.empty()) return std::nullopt;
  return program.model->elements[program.switch_elements.front().index()].place;
}

bool SwitchedRun::fail(Diagnostic diagnostic) {
  result_.stop = StopReason::failed;
  result_.failure = std::move(diagnostic);
  return false;
}

}  // namespace bgsim
