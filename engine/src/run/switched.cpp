#include "run/switched.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "run/contacts.hpp"
#include "run/event_log.hpp"
#include "run/failures.hpp"
#include "run/jump.hpp"
#include "run/run.hpp"
#include "run/sink/output_measures.hpp"
#include "run/tried_sides.hpp"
#include "run/watch/headway.hpp"

namespace bgsim {
namespace {

constexpr double kRounding = 1e-9;  ///< of the energies that a jump's loss is the difference of

class SwitchedRun {
 public:
  SwitchedRun(const SwitchedPrograms& programs, const SwitchedStart& start, const RunInputs& inputs,
              const SimulateOptions& options, const Clock& clock)
      : program_of_(programs.program_of),
        network_of_(programs.network_of),
        impact_of_(programs.impact_of),
        inputs_(inputs),
        options_(options),
        clock_(clock),
        mode_(start.mode),
        is_diode_(start.diodes),
        stored_(start.stored),
        log_(options, inputs),
        logged_(start.mode),
        headway_(inputs.stop),
        begin_(clock()),
        diodes_(static_cast<std::size_t>(std::count(start.diodes.begin(), start.diodes.end(), true))),
        contacts_(diodes_.size()) {
    stored_.t = inputs.start;
  }

  RunResult execute() {
    result_.report.switches = true;
    while (stretch()) {
    }
    finish();
    return std::move(result_);
  }

 private:
  // --- one stretch

  /// From the present instant on in the present mode; false if the run ends with it.
  bool stretch() {
    const Program* program = enter_mode();
    if (program == nullptr) return false;
    log_sides(*program->model, [](bool) { return true; });
    if (auto full = log_.full(stored_.t)) return fail(std::move(*full));
    const SimulateOptions options = options_here();
    const RunInputs inputs = inputs_here(*program);
    Run run(*program, inputs, options, clock_);
    run.know_scales(scales(*program));
    run.share_log(log_);
    if (!events_.empty()) run.know_events(events_);
    const RunResult part = run.execute();
    for (std::size_t i = 0; i < program->states.size(); ++i) {
      double& scale = scale_[key(program->states[i])];
      scale = std::max(scale, run.largest(i));
      if (part.report.steps > 0) tolerance_[key(program->states[i])] = run.tolerance(i);
    }
    add(part);
    if (!program->events.empty()) events_ = run.events();
    if (!part.stored.values.empty()) stored_ = part.stored;
    if (part.stop != StopReason::completed || !run.left_mode()) return false;
    if (stored_.values.size() != program->states.size() + program->dependent.size())
      return fail(no_jump_failure("what the dependent stores hold has no value", stored_.t));
    if (program->state_names.size() == 1 && program->state_names.front() == kModeClock)
      std::erase_if(stored_.values, [&](const auto& value) { return value.signal == program->states.front().signal; });
    if (run.left_by_states()) changes_.push_back(stored_.t);
    take_diodes(run.diodes());
    return change_mode(run.leaving(), *program);
  }

  /// The program of the present instant's mode, with the stores as they are after the jump into it.
  const Program* enter_mode() {
    const Program* program = nullptr;
    constexpr std::size_t kMostJumps = 100;
    std::vector<Mode> met;
    while (true) {
      const Mode last = mode_;
      if (!settle_diodes()) return nullptr;
      if (!kick_.empty()) {
        if (met.size() >= kMostJumps) break;
        if (!one_at_a_time()) met.push_back(mode_);
        if (!take_impact()) return nullptr;
        program = nullptr;
        continue;
      }
      if (program != nullptr && mode_ == last) return hold_bands(*program) ? program : nullptr;
      if (met.size() >= kMostJumps) break;
      met.push_back(mode_);
      program = program_here();
      if (program == nullptr) return nullptr;
      const bool diodes = !program->diode_elements.empty();
      parameters_ = inputs_.parameters;
      if (diodes) parameters_.resize(program->model->parameters.size(), 0.0);
      bool moved = false;
      if (!jump_into_mode(*program, moved)) return nullptr;
      if (!diodes) return program;
      if (!moved) return hold_bands(*program) ? program : nullptr;
      if (!store_jumped(*program, parameters_, x_)) return nullptr;
    }
    fail(diagnostic_of("BG604",
                       "at t = " + number_text(stored_.t) + " the diodes change sides without end: " +
                           std::to_string(kMostJumps) + " times, at last to \"" + mode_words() + "\"",
                       {}, "at one instant diodes change sides until none leaves the side that it is on",
                       "a law beside them gives off energy"));
    return nullptr;
  }

  /// Switches, or diodes and contacts, that are on another side than the log knows.
  template <class Which>
  void log_sides(const Model& model, const Which& which) {
    if (!log_.wanted() || logged_ == mode_) return;
    std::size_t next = 0;
    for (const Element& element : model.elements) {
      if (!is_switch(element.kind)) continue;
      const std::size_t i = next++;
      if (logged_[i] == mode_[i] || !which(is_diode_[i])) continue;
      using Kind = RunEvent::Kind;
      const Kind kind = element.contact ? Kind::contact : element.diode ? Kind::diode : Kind::switching;
      log_.add(
          {kind, stored_.t, element.name, "", side_text(element, logged_[i]), side_text(element, mode_[i]), {}, {}});
      logged_[i] = mode_[i];
    }
  }

  /// Stores that jump from what is stored to the states @p x.
  void log_jump(Evaluator& evaluator, const std::vector<double>& x, std::optional<double> loss) {
    if (!log_.wanted()) return;
    const Program& program = evaluator.program();
    Branch branch = first_branch(program);
    std::vector<double> dependent(program.dependent.size());
    if (!evaluator.initialize_modes(stored_.t, x.data(), branch) ||
        !evaluator.dependents(stored_.t, x.data(), branch, dependent.data()))
      return;  // the run comes to this as well, and says so
    const auto look = [&](const StateInfo& state, const std::string& name, double to) {
      const double from = value_of(stored_, state);
      if (state.signal.valid() || std::abs(to - from) <= kRounding * std::abs(from)) return;
      log_.add({RunEvent::Kind::jump, stored_.t, name, "", shortest_number(from), shortest_number(to), {}, loss});
      loss.reset();
    };
    for (std::size_t i = 0; i < x.size(); ++i) look(program.states[i], program.state_names[i], x[i]);
    for (std::size_t i = 0; i < dependent.size(); ++i)
      look(program.dependent[i], program.dependent_names[i], dependent[i]);
  }

  // --- contacts

  [[nodiscard]] std::vector<ElementId> diode_elements(const Model& model) const {
    std::vector<ElementId> result;
    for (std::size_t i = 0; i < model.elements.size(); ++i)
      if (model.elements[i].diode) result.emplace_back(i);
    return result;
  }

  /// Impulses of contacts that close, with the speeds of their rebound.
  bool take_impact() {
    try {
      const ImpactProgram& impact = impact_of_(mode_);
      const Program& program = impact.program;
      const std::vector<ElementId> elements = diode_elements(*program.model);
      std::vector<double> parameters = inputs_.parameters;
      parameters.resize(program.model->parameters.size(), 0.0);
      std::vector<std::string> names;
      std::size_t next = 0;
      for (std::size_t i = 0; i < elements.size(); ++i) {
        const Element& element = program.model->elements[elements[i].index()];
        if (!element.contact) continue;
        parameters[impact.kicks[next++].index()] = kick_[i].value_or(0.0);
        if (!kick_[i]) continue;
        names.push_back(element.name);
        ++contacts_[i].impacts;
        ++result_.report.impacts;
      }
      Evaluator evaluator(program, parameters);
      Jump jump = jump_into(evaluator, stored_.t, stored_);
      if (jump.failure) return fail(std::move(*jump.failure));
      // Sources did their work at the speeds after the jump. A contact is none: what it takes up at half the sum of
      // both speeds, less what its wall takes, is the loss.
      double rebound = 0.0;
      std::vector<double> impulses(impact.kicks.size(), 0.0);
      for (std::size_t k = 0; k < program.states.size(); ++k) {
        const SignalId signal = program.states[k].signal;
        if (!signal.valid() || signal.index() < impact.first_signal) continue;
        const std::size_t contact = signal.index() - impact.first_signal;
        if (contact >= impact.kicks.size()) continue;
        impulses[contact] = jump.x[k];
        rebound += jump.x[k] * parameters[impact.kicks[contact].index()];
      }
      const bool audited = !program.energy_roles.empty();
      const double loss = audited ? jump.loss - rebound : 0.0;
      if (loss < -kRounding * jump.scale) return fail(impact_failure(names, -loss, stored_.t));
      EnergyAudit& energy = result_.report.energy;
      energy.supplied += audited ? jump.supplied - rebound : 0.0;
      energy.stored += jump.stored;
      energy.exchanged += jump.exchanged;
      energy.impacts += std::max(0.0, loss);
      energy.turnover += jump.scale;
      if (names.size() > 1 && !std::exchange(simultaneous_, true))
        result_.report.notes.push_back(simultaneous_note(names, stored_.t));
      log_impacts(elements, *program.model, impulses, audited ? std::optional(std::max(0.0, loss)) : std::nullopt);
      kick_.clear();
      return store_jumped(program, parameters, jump.x);
    } catch (const ModelError& error) {
      return fail(not_allowed(error));
    }
  }

  void log_impacts(const std::vector<ElementId>& elements, const Model& model, const std::vector<double>& impulses,
                   std::optional<double> loss) {
    if (!log_.wanted()) return;
    std::size_t next = 0;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const Element& element = model.elements[elements[i].index()];
      if (!element.contact) continue;
      const double impulse = impulses[next++];
      if (!kick_[i]) continue;
      log_.add({RunEvent::Kind::impact, stored_.t, element.name, "", shortest_number(closing_[i]),
                shortest_number(0.0 - *kick_[i]), impulse, std::exchange(loss, std::nullopt)});
    }
  }

  /// Whether a contact opens, or rebounds not much further than the tolerance of its displacement. Multistep methods
  /// begin with order 1 and steps that suit the tolerance, and lose such a flight; one-step methods do not.
  [[nodiscard]] bool flies_short(const Program& program) const {
    constexpr double kTolerances = 1e5;
    if (facts_of(inputs_.method).family != MethodFamily::multistep && inputs_.method != Method::automatic) return false;
    if (!program.plan.explicit_form) return false;
    const std::vector<ElementId> elements = diode_elements(*program.model);
    for (std::size_t i = 0; i < flight_.size(); ++i) {
      const bool opens = diodes_[i].touches && diodes_[i].conducts && flight_[i] == 0.0;  // without a speed
      if (opens) return true;
      if (!(flight_[i] > 0.0)) continue;
      const SignalId displacement = program.model->elements[elements[i].index()].contact->displacement;
      const auto tolerance = tolerance_.find(Key{ElementId{}.value, 0, displacement.value});
      if (tolerance == tolerance_.end() || flight_[i] < kTolerances * tolerance->second) return true;
    }
    return false;
  }

  /// Puts the displacements of contacts that touch to their gaps.
  void close_rooms(const DiodeNetwork& network, const std::vector<double>& room) {
    for (std::size_t i = 0; i < room.size(); ++i) {
      if (room[i] == 0.0) continue;
      for (RunInputs::Initial& at : stored_.values)
        if (at.signal.valid() && at.signal == network.displacements[i]) at.value += room[i];
    }
  }

  /// Where contacts leave their sides. False where their impacts must not accumulate, and do.
  bool look_at_contacts(const Program& program) {
    const std::vector<ElementId> elements = diode_elements(*program.model);
    for (std::size_t i = 0; i < diodes_.size(); ++i) {
      const Element& element = program.model->elements[elements[i].index()];
      if (!element.contact) continue;
      DiodeState& contact = diodes_[i];
      contact.touches = !contact.conducts || tripped_[i];
      contact.sticks = false;
      if (!contact.conducts || !tripped_[i]) continue;
      const auto series = came_to_gap(contacts_[i], stored_.t, inputs_.start, inputs_.stop);
      if (!series) continue;
      if (!inputs_.close_zeno) return fail(accumulation_failure(element, contacts_[i], *series));
      result_.report.notes.push_back(accumulation_note(element, contacts_[i], *series));
      contact.sticks = true;
      contacts_[i].times.clear();
      contacts_[i].longest = 0.0;
    }
    return true;
  }

  // --- diodes

  /// What a run saw of the diodes where it left its mode.
  void take_diodes(const std::vector<double>& values) {
    if (values.empty()) return;
    std::size_t next = 0;
    for (std::size_t i = 0; i < diodes_.size(); ++i) {
      while (!is_diode_[next]) ++next;
      DiodeState& diode = diodes_[i];
      diode.conducts = mode_[next++];
      const bool contact = network_of_(mode_).displacements[i].valid();
      diode.source = values[4 * i] - (contact ? 0.0 : diode.resistance * values[4 * i + 1]);
      diode.may_begin = values[4 * i + 3] != 0.0;
    }
  }

  /// Puts the diodes on the sides that the circuit makes them.
  bool settle_diodes() {
    if (diodes_.empty()) return true;
    try {
      const DiodeNetwork& network = network_of_(mode_);
      // A part of the tolerance, and what follows from it is a part of it as well.
      constexpr double kOfTolerance = 1e-3;
      const auto resolution = [this](const StateInfo& state) {
        const auto found = tolerance_.find(key(state));
        return found == tolerance_.end() ? 0.0 : kOfTolerance * found->second;
      };
      DiodeSides sides =
          diode_sides(network, inputs_.parameters, stored_.t, stored_, resolution, diodes_, one_at_a_time());
      if (!goes_on_alone(sides))
        sides = diode_sides(network, inputs_.parameters, stored_.t, stored_, resolution, diodes_);
      if (sides.failure)
        return (may_try(network, sides) && try_sides(resolution, may_be_tried(network))) ||
               fail(std::move(*sides.failure));
      diodes_ = std::move(sides.diodes);
      kick_ = std::move(sides.kick);
      closing_ = std::move(sides.closing);
      flight_ = std::move(sides.flight);
      close_rooms(network, sides.room);
      flow_off_ = std::move(sides.flow_off);
      effort_off_ = std::move(sides.effort_off);
      flow_error_ = std::move(sides.flow_error);
      effort_error_ = std::move(sides.effort_error);
      put_diodes();
      // A diode has left its side, and the series do not say whether by rounding or for good.
      const bool again = !switched_ && mode_ == left_;
      for (std::size_t i = 0; again && i < tripped_.size(); ++i) {
        if (!tripped_[i] || !sides.undecided[i]) continue;
        static_cast<void>(try_sides(resolution, sides.undecided));
        break;
      }
    } catch (const ModelError& error) {
      return fail(not_allowed(error));
    }
    return true;
  }

  /// Whether impacts of this instant still take place one after the other.
  [[nodiscard]] bool one_at_a_time() const {
    constexpr std::uint64_t kMostInARow = 10'000;
    return inputs_.sequential_impacts &&
           !(sequence_.t == stored_.t && (sequence_.count >= kMostInARow || sequence_.ended));
  }

  /// Looks at the next impact of a sequence. It ends where closing speeds have become nothing beside the first: what
  /// is left is taken at once. False if the sides are to be found again for that.
  bool goes_on_alone(const DiodeSides& sides) {
    constexpr double kOfFirst = 1e-9;
    if (sides.kick.empty() || !one_at_a_time()) return true;
    const double closing = *std::max_element(sides.closing.begin(), sides.closing.end());
    if (sequence_.t != stored_.t) sequence_ = {stored_.t, closing, 0, false};
    if (closing <= kOfFirst * sequence_.first) {
      sequence_.ended = true;
      return false;
    }
    if (++sequence_.count == 2 && !std::exchange(sequential_, true))
      result_.report.notes.push_back("at t = " + number_text(stored_.t, 6) +
                                     " several contacts take impulses at one instant: one after the other, that which "
                                     "closes fastest first (\"impacts\": \"sequential\")");
    return true;
  }

  /// Whether sides can be found by trying: that knows no restitution, and helps nobody whose model is at fault.
  [[nodiscard]] bool may_try(const DiodeNetwork& network, const DiodeSides& sides) const {
    if (sides.final) return false;
    const std::vector<ElementId> elements = diode_elements(*network.program.model);
    for (std::size_t i = 0; i < diodes_.size(); ++i) {
      const Element& element = network.program.model->elements[elements[i].index()];
      if (element.contact && diodes_[i].touches && diodes_[i].conducts &&
          !network.program.model->pool.is_constant(element.contact->restitution, 0.0))
        return false;
    }
    return true;
  }
  /// Contacts that do not touch stay free.
  [[nodiscard]] std::vector<bool> may_be_tried(const DiodeNetwork& network) const {
    std::vector<bool> free;
    for (std::size_t i = 0; i < diodes_.size(); ++i)
      free.push_back(!network.displacements[i].valid() || diodes_[i].touches);
    return free;
  }

  void put_diodes() {
    std::size_t next = 0;
    for (std::size_t i = 0; i < mode_.size(); ++i)
      if (is_diode_[i]) mode_[i] = diodes_[next++].conducts;
  }

  /// Where no linear problem says on which sides some diodes are. False where none are possible.
  bool try_sides(const std::function<double(const StateInfo&)>& resolution, const std::vector<bool>& free) {
    std::optional<TriedSides> sides =
        tried_sides(program_of_, mode_, is_diode_, diodes_, free, inputs_, stored_, resolution);
    if (!sides) return false;
    for (std::size_t i = 0; i < diodes_.size(); ++i) {
      diodes_[i].conducts = sides->conducts[i];
      diodes_[i].pinned = false;
      diodes_[i].source = 0.0;
    }
    flow_off_ = flow_error_ = std::move(sides->flow_error);
    effort_off_ = effort_error_ = std::move(sides->effort_error);
    put_diodes();
    return true;
  }

  /// What the stores hold after a jump.
  bool store_jumped(const Program& program, const std::vector<double>& parameters, const std::vector<double>& x) {
    Evaluator evaluator(program, parameters);
    Branch branch = first_branch(program);
    std::vector<double> dependent(program.dependent.size());
    if (!evaluator.initialize_modes(stored_.t, x.data(), branch) ||
        !evaluator.dependents(stored_.t, x.data(), branch, dependent.data()))
      return fail(fault_failure(evaluator.fault()));
    const auto put = [this](const StateInfo& state, double value) {
      for (RunInputs::Initial& at : stored_.values)
        if (at.element == state.element && at.port == state.port && at.signal == state.signal) at.value = value;
    };
    for (std::size_t i = 0; i < x.size(); ++i) put(program.states[i], x[i]);
    for (std::size_t i = 0; i < dependent.size(); ++i) put(program.dependent[i], dependent[i]);
    return true;
  }

  /// A flow or effort that is 0, or comes from 0, may be beyond its border by rounding: by so much the border is moved.
  bool hold_bands(const Program& program) {
    constexpr double kTwice = 2.0, kMore = 4.0;
    // The mode that was left because of a diode turns out to be the right one.
    const bool again = !switched_ && mode_ == left_;
    bands_.resize(diodes_.size(), 0.0);
    Evaluator evaluator(program, parameters_);
    Branch branch = first_branch(program);
    std::vector<double> values(4 * diodes_.size());
    if (!evaluator.initialize_modes(stored_.t, x_.data(), branch) ||
        !evaluator.diodes(stored_.t, x_.data(), branch, values.data()))
      return fail(fault_failure(evaluator.fault()));
    for (std::size_t i = 0; i < diodes_.size(); ++i) {
      const Element& element = program.model->elements[program.diode_elements[i].index()];
      const bool conducts = diodes_[i].conducts;
      diodes_[i].may_begin = values[4 * i + 3] != 0.0;
      const double beyond = conducts ? -values[4 * i + 1] : values[4 * i] - values[4 * i + 2];
      double& band = bands_[i];
      const bool room = element.contact && conducts;  // which is no flow
      if (!again || room) {
        band = std::max(0.0, kTwice * beyond);
      } else if (tripped_[i]) {
        band = std::max({kMore * band, kTwice * beyond, conducts ? flow_error_[i] : effort_error_[i]});
      }
      parameters_[element.diode->band.index()] = band;
      if (room) continue;
      const bool matters = conducts ? !diodes_[i].pinned : *diodes_[i].may_begin;
      if (!matters || !(beyond > (conducts ? flow_off_[i] : effort_off_[i]))) continue;
      return fail(
          diagnostic_of("BG622",
                        "at t = " + number_text(stored_.t) + " the sides of the diodes could not be found: \"" +
                            element.name + "\" " + side_text(element, conducts) + " with the " +
                            (conducts ? "flow " : "effort ") + number_text(conducts ? -beyond : values[4 * i], 4),
                        {}, "an ideal diode takes any flow the way that it passes, and any effort the other way",
                        "a law that is not monotone is between the diodes, or one with a jump"));
    }
    return true;
  }

  const Program* program_here() {
    try {
      const Program& program = program_of_(mode_);
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

  [[nodiscard]] Diagnostic not_allowed(const ModelError& error) const {
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

  [[nodiscard]] std::string mode_words() const { return names_ ? mode_text(*names_, mode_) : "the first one"; }

  /// What the stores hold as the mode begins.
  bool jump_into_mode(const Program& program, bool& moved) {
    Evaluator evaluator(program, parameters_);
    Jump jump = jump_into(evaluator, stored_.t, stored_);
    if (jump.failure) return fail(std::move(*jump.failure));
    x_ = std::move(jump.x);
    moved = jump.moved;
    if (!jump.moved) return true;
    if (jump.loss < -kRounding * jump.scale)
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

  /// A store whose content vanishes at once, with nothing that takes it up.
  void note_lone_jumps(const Jump& jump) {
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
  [[nodiscard]] SimulateOptions options_here() {
    SimulateOptions options = options_;
    options.error_estimate = false;
    if (options_.remark)
      options.remark = [this](const Diagnostic& remark) {
        if (!std::exchange(remarked_, true)) options_.remark(remark);
      };
    if (!options_.rows)
      options.rows = [this](double t, std::span<const double> row) {
        result_.trace.times.push_back(t);
        for (std::size_t i = 0; i < row.size(); ++i) result_.trace.columns[i].push_back(row[i]);
      };
    if (options_.max_steps > 0) options.max_steps = options_.max_steps - result_.report.steps;
    if (options_.time_limit > 0.0) options.time_limit = std::max(1e-9, options_.time_limit - (clock_() - begin_));
    return options;
  }

  [[nodiscard]] RunInputs inputs_here(const Program& program) {
    RunInputs inputs = inputs_;
    inputs.start = stored_.t;
    inputs.parameters = parameters_;
    inputs.output_times = inputs_.output_times.without_first(result_.rows);
    short_flight_ = flies_short(program);
    lifts_off_ = false;
    for (std::size_t i = 0; i < flight_.size(); ++i)
      lifts_off_ = lifts_off_ || (diodes_[i].touches && diodes_[i].conducts && flight_[i] == 0.0);
    if (short_flight_) inputs.method = Method::radau;
    if (short_flight_ && inputs_.method != Method::automatic && !std::exchange(noted_flights_, true))
      result_.report.notes.push_back(
          "what follows where a contact opens, and rebounds that are short beside the tolerance, is integrated by "
          "Radau: "
          "multistep methods, which begin with order 1, lose it");
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

  // --- from mode to mode

  /// Where some switches leave their sides. False if that leads nowhere.
  bool change_mode(const std::vector<double>& leaving, const Program& program) {
    if (stored_.t > instant_) departures_.clear();
    instant_ = stored_.t;
    departures_.push_back({mode_, stored_.values});
    locking_ = false;
    left_ = mode_;
    tripped_.clear();
    for (std::size_t i = 0; i < leaving.size(); ++i)
      if (is_diode_[i]) tripped_.push_back(leaving[i] != 0.0);
    if (!diodes_.empty() && !look_at_contacts(program)) return false;
    switched_ = diodes_.empty();
    for (std::size_t i = 0; i < leaving.size(); ++i) {
      if (leaving[i] == 0.0 || is_diode_[i]) continue;
      switched_ = true;
      mode_[i] = !mode_[i];
      const Element& element = program.model->elements[program.switch_elements[i].index()];
      locking_ = locking_ || element.switches->locks;
    }
    ++result_.report.mode_changes;
    log_sides(*program.model, [](bool diode) { return !diode; });
    return !(switched_ && runs_in_circles(program)) && !chatters(program) && !takes_too_long();
  }

  /// A mode that comes back within one instant, with the stores as they were when it was left.
  bool runs_in_circles(const Program& program) {
    constexpr std::size_t kMostInOneInstant = 1000, kShown = 6;
    const auto same = [this](const Departure& from) { return from.mode == mode_ && same_values(from.stored); };
    const auto first = std::find_if(departures_.begin(), departures_.end(), same);
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

  [[nodiscard]] bool same_values(const std::vector<RunInputs::Initial>& values) const {
    if (values.size() != stored_.values.size()) return false;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (std::abs(values[i].value - stored_.values[i].value) >
          kRounding * std::max(std::abs(values[i].value), std::abs(stored_.values[i].value)))
        return false;
    return true;
  }

  /// A hundred changes in a row, on average less than 1e-9 of the scene apart: as with other events, an end is not in
  /// sight.
  bool chatters(const Program& program) {
    constexpr std::size_t kInARow = 100;
    constexpr double kNear = 1e-9;
    if (changes_.size() > kInARow) changes_.pop_front();
    if (changes_.size() < kInARow || changes_.back() < stored_.t) return false;
    const double gap = (changes_.back() - changes_.front()) / kInARow;
    if (gap > kNear * (inputs_.stop - inputs_.start)) return false;
    fail(diagnostic_of("BG604",
                       "the switches change sides without end near t = " + number_text(stored_.t) + ": " +
                           std::to_string(kInARow) + " changes of the mode within " +
                           number_text(changes_.back() - changes_.front(), 3) + ", at last to \"" +
                           mode_text(*program.model, mode_) + "\"",
                       place_of_switches(program), "between two changes of the mode the time goes on",
                       "give the switch two thresholds that are apart: \"close\" and \"open\""));
    return true;
  }

  /// At the pace that the stretches keep the run takes longer than a run may.
  bool takes_too_long() {
    constexpr double kJudged = 8.0;
    const double seconds = clock_() - begin_;
    headway_.add(seconds, stored_.t, result_.report.steps + result_.rows + result_.report.mode_changes);
    if (options_.time_limit > 0.0 || !(options_.longest_run > 0.0)) return false;
    const auto pace = headway_.pace(std::max(kJudged, seconds / kJudged));
    if (!pace || !(pace->rest > options_.longest_run)) return false;
    fail(diagnostic_of("BG617",
                       "at t = " + number_text(stored_.t) + " the run is busy with changes of the mode, " +
                           std::to_string(result_.report.mode_changes) + " so far; at this pace it would take " +
                           number_text(pace->rest, 2) + " s more",
                       {}, "a run that takes longer than a day is ended",
                       "make the scene shorter, or the switching slower; --time-limit sets another limit"));
    return true;
  }

  [[nodiscard]] static std::optional<Place> place_of_switches(const Program& program) {
    if (program.switch_elements.empty()) return std::nullopt;
    return program.model->elements[program.switch_elements.front().index()].place;
  }

  bool fail(Diagnostic diagnostic) {
    result_.stop = StopReason::failed;
    result_.failure = std::move(diagnostic);
    return false;
  }

  // --- sums

  using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;
  static Key key(const StateInfo& state) { return {state.element.value, state.port, state.signal.value}; }
  [[nodiscard]] std::vector<double> scales(const Program& program) const {
    std::vector<double> result;
    if (scale_.empty()) return result;
    for (const StateInfo& state : program.states) {
      const auto found = scale_.find(key(state));
      result.push_back(found == scale_.end() ? 0.0 : found->second);
    }
    return result;
  }

  /// A stretch's result to the whole run's.
  void add(const RunResult& part) {
    RunReport& report = result_.report;
    const RunReport& own = part.report;
    result_.stop = part.stop;
    result_.failure = part.failure;
    result_.rows += part.rows;
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
          std::find(report.notes.begin(), report.notes.end(), note) == report.notes.end())
        report.notes.push_back(note);
    add_energy(own.energy);
    append(report.measures, own.measures);
    if (report.why_not_measured.empty()) report.why_not_measured = own.why_not_measured;
  }

  /// Where a loop has one solution, it is named once, and not again wherever a mode begins.
  [[nodiscard]] bool solved_before(const std::string& note) const {
    const std::size_t words = note.find(": ");
    if (words == std::string::npos || note.find(", found from the start ") == std::string::npos ||
        note.find("other solutions exist") != std::string::npos)
      return false;
    const std::string loop = note.substr(0, words + 2);
    return std::any_of(result_.report.notes.begin(), result_.report.notes.end(),
                       [&](const std::string& before) { return before.starts_with(loop); });
  }

  /// A contact that opens without a speed is near its gap for a while: nearer than what can be decided there.
  [[nodiscard]] bool of_lift_off(const std::string& note) const {
    return lifts_off_ && note.starts_with("whether ") && note.find("(band of ") != std::string::npos;
  }

  void add_energy(const EnergyAudit& own) {
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

  void finish() {
    RunReport& report = result_.report;
    report.start = inputs_.start;
    report.stop = inputs_.stop;
    report.relative = inputs_.relative;
    report.reached = std::max(report.reached, inputs_.start);
    report.modes = met_.size();
    report.contacts = names_ && std::any_of(names_->elements.begin(), names_->elements.end(),
                                            [](const Element& element) { return element.contact.has_value(); });
    report.errors.possible = false;
    report.errors.why_not = "the model has switches";
    EnergyAudit& energy = report.energy;
    energy.done = audited_ && options_.energy_audit && !result_.report.model.empty();
    if (!energy.done && energy.why_not.empty()) energy.why_not = "the run did not start";
    if (energy.turnover > 0.0) energy.relative = std::abs(energy.residual) / energy.turnover;
    if (lone_jumps_ > noted_.size())
      report.notes.push_back("stores emptied by a switch at once: " + std::to_string(lone_jumps_) + " times in all");
    result_.stored = stored_;
  }

  struct Departure {
    Mode mode;
    std::vector<RunInputs::Initial> stored;
  };

  const ProgramOfMode& program_of_;
  const NetworkOfMode& network_of_;
  const ImpactOfMode& impact_of_;
  const RunInputs& inputs_;
  const SimulateOptions& options_;
  const Clock& clock_;
  Mode mode_;
  std::vector<bool> is_diode_;  ///< by switch
  Stored stored_;               ///< where the last stretch ended
  EventLog log_;
  Mode logged_;  ///< the mode that the log knows
  Headway headway_;
  double begin_;
  std::shared_ptr<const Model> names_;
  RunResult result_;
  EventMemory events_;  ///< empty before the first stretch
  std::vector<DiodeState> diodes_;
  std::vector<ContactHistory> contacts_;     ///< by diode
  std::vector<std::optional<double>> kick_;  ///< by diode: see DiodeSides::kick
  std::vector<double> closing_;              ///< by diode: see DiodeSides::closing
  std::vector<double> flight_;               ///< by diode: see DiodeSides::flight
  bool noted_flights_ = false;
  bool lifts_off_ = false;     ///< a contact opens without a speed in this stretch
  bool short_flight_ = false;  ///< in this stretch; see flies_short()
  struct Sequence {
    double t = -std::numeric_limits<double>::infinity();
    double first = 0.0;  ///< closing speed of the first impact
    std::uint64_t count = 0;
    bool ended = false;
  };
  Sequence sequence_;                          ///< of impacts one after the other, in the latest instant that had any
  bool sequential_ = false;                    ///< such a sequence had more than one impact
  bool simultaneous_ = false;                  ///< several contacts have taken impulses at once
  std::vector<double> flow_off_, effort_off_;  ///< by diode: what they may be off by
  std::vector<double> flow_error_, effort_error_;  ///< the same, without an allowance
  std::vector<double> bands_;                      ///< by diode, of the present program
  std::vector<bool> tripped_;                      ///< by diode: it left its side in the last change of the mode
  Mode left_;                                      ///< from where that was
  std::vector<double> parameters_;                 ///< of the present program: with the bands of diodes
  std::vector<double> x_;                          ///< by state of the present program: after the jump
  std::map<Key, double> scale_;                    ///< largest magnitude of each state, in whatever mode
  std::map<Key, double> tolerance_;                ///< absolute, where it was last a state
  std::set<Mode> met_;
  std::vector<Departure> departures_;  ///< from modes, within the present instant
  double instant_ = -std::numeric_limits<double>::infinity();
  std::deque<double> changes_;  ///< times of the latest that conditions on states made
  bool locking_ = false;        ///< the last change was one of a switch that is written as locked
  bool switched_ = true;        ///< the last change was not one of diodes alone, which cut no flow that is not 0
  bool audited_ = true, remarked_ = false;
  std::size_t lone_jumps_ = 0;
  std::set<std::string> noted_;  ///< stores that have jumped alone
};

}  // namespace

RunResult simulate_switched(const SwitchedPrograms& programs, const SwitchedStart& start, const RunInputs& inputs,
                            const SimulateOptions& options, const Clock& clock) {
  return SwitchedRun(programs, start, inputs, options, clock).execute();
}

}  // namespace bgsim
