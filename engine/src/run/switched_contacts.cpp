// Contacts of a switched run: their impacts, and where these accumulate.
#include "base/text.hpp"
#include "run/failures.hpp"
#include "run/switched_run.hpp"

namespace bgsim {

std::vector<ElementId> SwitchedRun::diode_elements(const Model& model) const {
  std::vector<ElementId> result;
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    if (model.elements[i].diode) result.emplace_back(i);
  return result;
}

bool SwitchedRun::take_impact() {
  held_.clear();
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
      contacts_[i].rebound = std::abs(*kick_[i]);
      contacts_[i].fastest = std::max(contacts_[i].fastest, closing_[i]);
      ++result_.report.impacts;
    }
    Evaluator& evaluator = evaluators_.of(program, parameters);
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
    if (loss < -energy_of_rounding(jump)) return fail(impact_failure(names, -loss, stored_.t));
    EnergyAudit& energy = result_.report.energy;
    energy.supplied += audited ? jump.supplied - rebound : 0.0;
    energy.stored += jump.stored;
    energy.exchanged += jump.exchanged;
    energy.impacts += std::max(0.0, loss);
    energy.turnover += jump.scale;
    if (names.size() > 1 && !std::exchange(simultaneous_, true))
      result_.report.notes.push_back(simultaneous_note(names, stored_.t));
    log_impacts(elements, *program.model, impulses, audited ? std::optional(std::max(0.0, loss)) : std::nullopt);
    if (variation_) variation_->impact(impact, network_of_(mode_), kick_);
    kick_.clear();
    return store_jumped(program, parameters, jump.x);
  } catch (const ModelError& error) {
    return fail(not_allowed(error));
  }
}

void SwitchedRun::log_impacts(const std::vector<ElementId>& elements, const Model& model,
                              const std::vector<double>& impulses, std::optional<double> loss) {
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

bool SwitchedRun::flies_short(const Program& program) const {
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

void SwitchedRun::close_rooms(const DiodeNetwork& network, const std::vector<double>& room) {
  for (std::size_t i = 0; i < room.size(); ++i) {
    if (room[i] == 0.0) continue;
    for (RunInputs::Initial& at : stored_.values)
      if (at.signal.valid() && at.signal == network.displacements[i]) at.value += room[i];
  }
}

void SwitchedRun::put_rests(const Model& model) {
  std::size_t next = 0;
  for (const Element& element : model.elements) {
    if (!element.diode) continue;
    const std::size_t i = next++;
    if (!element.contact || !element.contact->rest.valid()) continue;
    parameters_[element.contact->rest.index()] = rests_[i].value_or(0.0);
    parameters_[element.contact->rest_moves.index()] = rest_moves_[i];
  }
}

bool SwitchedRun::look_at_contacts(const Program& program) {
  const std::vector<ElementId> elements = diode_elements(*program.model);
  for (std::size_t i = 0; variation_ && i < diodes_.size(); ++i)
    if (program.model->elements[elements[i].index()].contact && diodes_[i].conducts && tripped_[i])
      variation_->arrive(i);
  for (std::size_t i = 0; i < diodes_.size(); ++i) {
    const Element& element = program.model->elements[elements[i].index()];
    if (!element.contact) continue;
    DiodeState& contact = diodes_[i];
    contact.touches = !contact.conducts || tripped_[i];
    contact.sticks = false;
    if (!contact.conducts || !tripped_[i]) continue;
    std::optional<Accumulation> series =
        came_to_gap(contacts_[i], stored_.t, inputs_.start, inputs_.stop, inputs_.early_closing);
    const double early = inputs_.early_closing * inputs_.early_closing;  // of the height
    const bool lost = !flight_.empty() && flight_[i] > 0.0 && flight_[i] < early * least_flight_[i];
    if (lost && !series) series = Accumulation{0.0, stored_.t, slows_down(contacts_[i])};
    if (!series) continue;
    // Where another series ends there as well, and the speeds are not those of a rest, the ways between the impacts
    // come to their end first: what is left happens at that instant, impact by impact.
    if (!series->slows && ends_with_others(program, i, *series)) continue;
    if (!inputs_.close_zeno) return fail(accumulation_failure(element, contacts_[i], *series));
    if (variation_ && !variation_->close(i, *series)) return fail(accumulation_variation_failure(element, stored_.t));
    if (++accumulations_ <= kNotedAccumulations)
      result_.report.notes.push_back(accumulation_note(element, contacts_[i], *series));
    contact.sticks = true;
    // The flights that are left out have less height than the displacement is known to, and in the mean the force of
    // their impacts is that of the closed contact. What asks for its mode is to see their end.
    rests_[i] = series->limit;
    if (variation_) rest_moves_[i] = variation_->instant();
    contacts_[i].times.clear();
    contacts_[i].longest = contacts_[i].fastest = 0.0;
  }
  return true;
}

bool SwitchedRun::ends_with_others(const Program& program, std::size_t contact, const Accumulation& series) const {
  const std::vector<ElementId> elements = diode_elements(*program.model);
  for (std::size_t i = 0; i < diodes_.size(); ++i)
    if (i != contact && program.model->elements[elements[i].index()].contact && ends_with(contacts_[i], series.limit))
      return true;
  return false;
}

}  // namespace bgsim
