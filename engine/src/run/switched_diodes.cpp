// On which sides the diodes and contacts of a switched run are.
#include "base/codes.hpp"
#include "run/failures.hpp"
#include "run/switched_run.hpp"
#include "run/tried_sides.hpp"
#include "run/watch/stiction.hpp"

namespace bgsim {

void SwitchedRun::take_diodes(const std::vector<double>& values) {
  if (values.empty()) return;
  if (diodes_.empty()) return;
  const DiodeNetwork& network = network_of_(mode_);
  const std::vector<ElementId> elements = diode_elements(*network.program.model);
  std::size_t next = 0;
  for (std::size_t i = 0; i < diodes_.size(); ++i) {
    while (!is_diode_[next]) ++next;
    DiodeState& diode = diodes_[i];
    diode.conducts = mode_[next++];
    const bool contact = network.displacements[i].valid();
    diode.effort = values[4 * i];
    diode.flow = contact ? 0.0 : values[4 * i + 1];
    diode.may_begin = values[4 * i + 3] != 0.0;
    // A thyristor without a flow ends where its fire does, though the circuit may keep it on its side.
    const ParameterId holding = network.program.model->elements[elements[i].index()].diode->holding;
    if (holding.valid() && diode.conducts && !*diode.may_begin && diode.flow <= parameters_[holding.index()])
      diode.pinned = true;
  }
}

double SwitchedRun::resolution_of(const StateInfo& state) const {
  // A part of the tolerance, and what follows from it is a part of it as well.
  constexpr double kOfTolerance = 1e-3;
  const auto found = tolerance_.find(key(state));
  return found == tolerance_.end() ? 0.0 : kOfTolerance * found->second;
}

Mode SwitchedRun::mode_of_switches() const {
  Mode switches = mode_;
  for (std::size_t i = 0; i < switches.size(); ++i)
    if (is_diode_[i]) switches[i] = false;
  return switches;
}

bool SwitchedRun::settle_diodes() {
  if (diodes_.empty()) return true;
  undecided_.clear();
  at_border_.clear();
  try {
    const DiodeNetwork& network = network_of_(mode_);
    const auto resolution = [this](const StateInfo& state) { return resolution_of(state); };
    DiodeSight& sight = sights_[mode_of_switches()];
    const double span = inputs_.stop - inputs_.start;
    DiodeSides sides = diode_sides(network, inputs_.parameters, stored_.t, stored_, resolution, diodes_, evaluators_,
                                   sight, span, impact_of());
    if (ends_sequence(sides))
      sides = diode_sides(network, inputs_.parameters, stored_.t, stored_, resolution, diodes_, evaluators_, sight,
                          span, impact_of());
    at_border_ = std::move(sides.at_border);
    for (std::size_t i = 0; sides.failure && i < diodes_.size(); ++i)
      if (network.displacements[i].valid()) diodes_[i] = sides.diodes[i];
    if (sides.failure)
      return (may_try(network, sides) && try_sides(resolution, may_be_tried(network))) ||
             fail(std::move(*sides.failure));
    diodes_ = std::move(sides.diodes);
    kick_ = std::move(sides.kick);
    closing_ = std::move(sides.closing);
    at_gap_ = std::move(sides.at_gap);
    flight_ = std::move(sides.flight);
    returns_ = std::move(sides.returns);
    least_flight_ = std::move(sides.least_flight);
    close_rooms(network, sides.room);
    flow_off_ = std::move(sides.flow_off);
    effort_off_ = std::move(sides.effort_off);
    flow_error_ = std::move(sides.flow_error);
    effort_error_ = std::move(sides.effort_error);
    undecided_ = std::move(sides.undecided);
    put_diodes();
    // A diode has left its side, and the series do not say whether by rounding or for good; or it has left it at this
    // instant once more, where the series say that it stays: of a law that ends where the flow does, a root by parts,
    // they know one part. An impact is no stay on these sides.
    const bool again = kick_.empty() && !switched_ && mode_ == left_;
    // What diodes lock and friction holds has a force that nothing determines: the problem's solution may have the
    // diodes carry it, where the mode, in which nothing rubs, has friction do so.
    const bool once_more = again && (again_at_ == stored_.t || !at_border_.empty());
    if (again) again_at_ = stored_.t;
    std::vector<bool> free = once_more ? may_be_tried(network) : undecided_;
    bool any = false;
    for (std::size_t i = 0; again && i < tripped_.size(); ++i) {
      any = any || (tripped_[i] && free[i]);
      free[i] = free[i] && (!once_more || tripped_[i]);
    }
    if (any) static_cast<void>(try_sides(resolution, free));
  } catch (const ModelError& error) {
    return fail(not_allowed(error));
  }
  return true;
}

ImpactOf SwitchedRun::impact_of() const {
  if (sequence_.t == stored_.t && sequence_.ended) return ImpactOf::rest;
  return inputs_.sequential_impacts ? ImpactOf::fastest : ImpactOf::all;
}

bool SwitchedRun::ends_sequence(const DiodeSides& sides) {
  constexpr double kOfFirst = 1e-9;
  constexpr std::uint64_t kMostInARow = 10'000;
  if (sides.kick.empty() || impact_of() == ImpactOf::rest) return false;
  const double closing = *std::max_element(sides.closing.begin(), sides.closing.end());
  if (sequence_.t != stored_.t) sequence_ = {stored_.t, 0.0, 0, false};
  sequence_.fastest = std::max(sequence_.fastest, closing);
  // What a switch brings to contacts that rest on each other has no closing speed, and is no end.
  const bool nothing = closing > 0.0 && closing <= kOfFirst * sequence_.fastest;
  sequence_.ended = nothing || sequence_.count >= kMostInARow;
  if (sequence_.ended) {
    if (sequence_.count >= kMostInARow) result_.report.notes.push_back(long_sequence_note(sequence_.count, stored_.t));
    return true;
  }
  if (++sequence_.count == 2 && inputs_.sequential_impacts && !std::exchange(sequential_, true))
    result_.report.notes.push_back("at t = " + number_text(stored_.t, 6) +
                                   " several contacts take impulses at one instant: one after the other, that which "
                                   "closes fastest first (\"impacts\": \"sequential\")");
  return false;
}

bool SwitchedRun::may_try(const DiodeNetwork& network, const DiodeSides& sides) const {
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

std::vector<bool> SwitchedRun::may_be_tried(const DiodeNetwork& network) const {
  std::vector<bool> free;
  for (std::size_t i = 0; i < diodes_.size(); ++i)
    free.push_back(!network.displacements[i].valid() || diodes_[i].touches);
  return free;
}

void SwitchedRun::put_diodes() {
  std::size_t next = 0;
  for (std::size_t i = 0; i < mode_.size(); ++i)
    if (is_diode_[i]) mode_[i] = diodes_[next++].conducts;
}

bool SwitchedRun::try_sides(const std::function<double(const StateInfo&)>& resolution, const std::vector<bool>& free) {
  std::optional<TriedSides> sides =
      tried_sides(program_of_, mode_, is_diode_, diodes_, free, inputs_, stored_, resolution, at_border_);
  if (!sides) return false;
  for (std::size_t i = 0; i < diodes_.size(); ++i) {
    diodes_[i].conducts = sides->conducts[i];
    diodes_[i].pinned = diodes_[i].pinned && diodes_[i].conducts;
    diodes_[i].effort = diodes_[i].flow = 0.0;
  }
  flow_off_ = flow_error_ = std::move(sides->flow_error);
  effort_off_ = effort_error_ = std::move(sides->effort_error);
  put_diodes();
  return true;
}

bool SwitchedRun::try_allowed() {
  if (diodes_.empty()) return false;
  const Mode refused = mode_;
  const auto resolution = [this](const StateInfo& state) { return resolution_of(state); };
  if (!try_sides(resolution, may_be_tried(network_of_(mode_))) || mode_ == refused) return false;
  result_.stop = StopReason::completed;
  result_.failure.reset();
  return true;
}

bool SwitchedRun::hold_or_try(const Program& program, bool& tried) {
  const std::vector<double> bands = bands_, parameters = parameters_;
  const auto holds = [&](const std::vector<AtBorder>& shared, bool others) {
    try_others_ = others;
    const bool result = hold_bands(program, shared);
    try_others_ = false;
    if (result || result_.failure) return result;
    bands_ = bands;
    parameters_ = parameters;
    return false;
  };
  // What diodes lock needs no friction, as a rule, and that has no part then.
  const bool again = !switched_ && mode_ == left_;
  const bool shares =
      std::any_of(at_border_.begin(), at_border_.end(), [](const AtBorder& at) { return at.mode != 0.0; });
  if (shares && !again && (holds({}, true) || result_.failure)) return !result_.failure;
  if (holds(at_border_, !tried) || result_.failure) return !result_.failure;
  tried = true;
  const auto resolution = [this](const StateInfo& state) { return resolution_of(state); };
  const Mode found = mode_;
  const DiodeNetwork& network = network_of_(mode_);
  const std::vector<ElementId> elements = diode_elements(*network.program.model);
  const bool contacts = std::any_of(elements.begin(), elements.end(), [&](ElementId id) {
    return network.program.model->elements[id.index()].contact.has_value();
  });
  if ((!contacts || !at_border_.empty()) && try_sides(resolution, may_be_tried(network)) && mode_ != found)
    return false;
  mode_ = found;
  return hold_bands(program, at_border_);  // for its message
}

std::vector<double> SwitchedRun::diode_rounding(Evaluator& evaluator, Branch& branch) const {
  // What a jump computes from is as large as what the stores held before it.
  constexpr double kRoundings = 16.0 * std::numeric_limits<double>::epsilon(), kSafety = 4.0;
  const Program& program = evaluator.program();
  std::vector<double> off(program.states.size());
  for (std::size_t i = 0; i < off.size(); ++i) {
    const auto scale = scale_.find(key(program.states[i]));
    off[i] = resolution_of(program.states[i]) +
             kRoundings * std::max({std::abs(x_[i]), std::abs(value_of(stored_, program.states[i])),
                                    scale == scale_.end() ? 0.0 : scale->second});
  }
  std::vector<double> bounds(4 * diodes_.size());
  evaluator.diode_rounding(stored_.t, x_.data(), branch, off, kRoundings * std::abs(stored_.t), bounds.data());
  // So is what holds a law at its border, in which values are linear.
  constexpr double kOfPlaces = 64.0 * std::numeric_limits<double>::epsilon();
  std::vector<double> values(bounds.size()), moved(bounds.size());
  const std::vector<GuardMode> guards = guards_of(evaluator, at_border_);
  bool known = false;
  const auto values_known = [&] {
    return known = known || evaluator.diodes(stored_.t, x_.data(), branch, values.data());
  };
  const auto add_moved = [&] {
    for (std::size_t i = 0; i < bounds.size(); ++i) bounds[i] += kOfPlaces * std::abs(moved[i] - values[i]);
  };
  for (const GuardMode& at : guards) {
    Branch other = branch;
    other.modes[evaluator.guard_relation(at.guard)] += 1.0;
    if (values_known() && evaluator.diodes(stored_.t, x_.data(), other, moved.data())) add_moved();
  }
  for (const Element& element : program.model->elements) {
    if (!element.share.valid() || parameters_[element.share.index()] == 0.0) continue;
    std::vector<double> other = parameters_;
    other[element.share.index()] += 1.0;
    if (values_known() && Evaluator(program, other).diodes(stored_.t, x_.data(), branch, moved.data())) add_moved();
  }
  for (double& bound : bounds) bound = kSafety * bound + std::numeric_limits<double>::min();
  return bounds;
}

double SwitchedRun::lift_off_band(std::size_t i, const Element& contact) const {
  // Well below what a contact may be beyond its gap where it closes, however far the tolerance falls until then.
  constexpr double kOfResolution = 1e-6;
  if (flight_.empty() || !at_gap_[i] || flight_[i] != 0.0) return 0.0;
  const StateInfo displacement{{}, {}, 0, contact.contact->displacement};
  return std::max({kOfResolution * resolution_of(displacement), least_flight_[i], std::numeric_limits<double>::min()});
}

double SwitchedRun::holding_flow(std::size_t i, double flow) const {
  // One that has ended stays as it is, whatever its flow is made of.
  if (diodes_[i].pinned) return std::numeric_limits<double>::lowest();
  // No flow is what rounding makes of none. One that has begun is looked for down to 0.
  return flow > flow_error_[i] ? 0.0 : flow_error_[i];
}

std::vector<std::string> SwitchedRun::shared_outputs(const Program& program) {
  std::vector<std::string> result;
  std::vector<double> own(program.output_names.size()), other(own.size());
  const auto outputs_with = [&](const std::vector<double>& parameters, std::vector<double>& values) {
    Evaluator& evaluator = evaluators_.of(program, parameters);
    Branch branch = first_branch(program);
    if (!evaluator.initialize_modes(stored_.t, x_.data(), branch)) return false;
    hold_at_border(evaluator, parameters, inputs_, at_border_, stored_.t, x_.data(), branch);
    return evaluator.outputs(stored_.t, x_.data(), branch, values.data());
  };
  bool known = false;
  for (const Element& element : program.model->elements) {
    if (!element.share.valid() || parameters_[element.share.index()] == 0.0) continue;
    std::vector<double> moved = parameters_;
    moved[element.share.index()] = 0.0;
    if (!(known = known || outputs_with(parameters_, own)) || !outputs_with(moved, other)) continue;
    for (std::size_t i = 0; i < own.size(); ++i)
      if (own[i] != other[i]) result.push_back(program.output_names[i]);
  }
  return result;
}

bool SwitchedRun::hold_bands(const Program& program, const std::vector<AtBorder>& shared) {
  constexpr double kTwice = 2.0, kMore = 4.0, kFar = 1e6;
  // The mode that was left because of a diode turns out to be the right one.
  const bool again = !switched_ && mode_ == left_;
  bands_.resize(diodes_.size(), 0.0);
  put_shares(program, shared, parameters_);
  Evaluator& evaluator = evaluators_.of(program, parameters_);
  Branch branch = first_branch(program);
  std::vector<double> values(4 * diodes_.size()), rounding;
  if (!evaluator.initialize_modes(stored_.t, x_.data(), branch)) return fail(fault_failure(evaluator.fault()));
  hold_at_border(evaluator, parameters_, inputs_, at_border_, stored_.t, x_.data(), branch);
  if (!evaluator.diodes(stored_.t, x_.data(), branch, values.data())) return fail(fault_failure(evaluator.fault()));
  const auto rounding_of = [&](std::size_t value) {
    if (rounding.empty()) rounding = diode_rounding(evaluator, branch);
    return rounding[value];
  };
  for (std::size_t i = 0; i < diodes_.size(); ++i) {
    const Element& element = program.model->elements[program.diode_elements[i].index()];
    const bool conducts = diodes_[i].conducts;
    diodes_[i].may_begin = values[4 * i + 3] != 0.0;
    const double beyond = conducts ? -values[4 * i + 1] : values[4 * i] - values[4 * i + 2];
    double& band = bands_[i];
    const bool room = element.contact && conducts;  // which is no flow
    // A thyristor that is not fired may be anywhere beyond its border: that is no rounding, and fired it conducts
    // there. One that has ended has rounding for a flow, on the side on which it conducts.
    const bool blocks_anyway = !conducts && !*diodes_[i].may_begin;
    const bool matters = conducts ? !diodes_[i].pinned : !blocks_anyway;
    const std::size_t value = 4 * i + (conducts ? 1 : 0);
    if (blocks_anyway) {
      band = 0.0;
    } else if (!again || room) {
      band = std::max({0.0, kTwice * beyond, room ? lift_off_band(i, element) : 0.0});
      // On its border as far as one sees, it is on either side for as long as one does not see more.
      if (!room && !undecided_.empty() && undecided_[i])
        band = std::max(band, conducts ? flow_error_[i] : effort_error_[i]);
    } else if (tripped_[i]) {
      const double error = conducts ? flow_error_[i] : effort_error_[i];
      // Of what no state of the network is off, and the one state of this mode is.
      band = std::max({kMore * band, kTwice * beyond, error > 0.0 ? error : rounding_of(value)});
    }
    parameters_[element.diode->band.index()] = band;
    if (element.diode->holding.valid())
      parameters_[element.diode->holding.index()] = holding_flow(i, values[4 * i + 1]);
    if (room) continue;
    if (!matters || !(beyond > 0.0)) continue;
    // Where the terms that cancel do not stand in the network of the diodes: what rounding makes of them in this mode.
    // And where the network is seen through a resistance without bound (a mass that nothing pushes), any effort is
    // rounding there: not here.
    const double rounds = rounding_of(value);
    if (beyond <= (beyond > (conducts ? flow_off_[i] : effort_off_[i]) ? rounds : kFar * rounds)) continue;
    if (try_others_) return false;
    return fail(diagnostic_of("BG622",
                              "at t = " + number_text(stored_.t) + " the sides of the diodes could not be found: \"" +
                                  element.name + "\" " + side_text(element, conducts) + " with the " +
                                  (conducts ? "flow " : "effort ") + number_text(conducts ? -beyond : values[4 * i], 4),
                              {}, "an ideal diode takes any flow the way that it passes, and any effort the other way",
                              "a law that is not monotone is between the diodes, or one with a jump"));
  }
  return true;
}

}  // namespace bgsim
