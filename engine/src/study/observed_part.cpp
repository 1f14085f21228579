#include "study/observed_part.hpp"

#include <algorithm>

#include "bgsim/modes.hpp"
#include "model/element_kinds.hpp"
#include "model/expressions_of.hpp"

namespace bgsim {
namespace {

/// Elements, signals and events as the nodes of one graph, by what they need.
class Reached {
 public:
  explicit Reached(const Model& model)
      : model_(model),
        bonded_(model.elements.size()),
        set_by_(model.elements.size() + model.signals.size()),
        reached_(set_by_.size() + model.events.size(), false) {
    for (const ModelBond& bond : model.bonds) {
      bonded_[bond.from.element.index()].push_back(bond.to.element);
      bonded_[bond.to.element.index()].push_back(bond.from.element);
    }
    for (std::size_t i = 0; i < model.events.size(); ++i)
      for (const ModelEvent::Set& set : model.events[i].sets) set_by_[node_of(set)].push_back(node_of_event(i));
  }

  /// Follows @p root to the end.
  void need(ExprId root) {
    names({root});
    while (!open_.empty()) {
      const std::size_t node = open_.back();
      open_.pop_back();
      if (node < model_.elements.size())
        needs_of(ElementId(node));
      else if (node < set_by_.size())
        needs_of(model_.signals[node - model_.elements.size()]);
      else
        needs_of(model_.events[node - set_by_.size()]);
      if (node < set_by_.size())
        for (const std::size_t event : set_by_[node]) reach(event);
    }
  }

  [[nodiscard]] bool element(std::size_t i) const { return reached_[i]; }
  [[nodiscard]] bool signal(std::size_t i) const { return reached_[model_.elements.size() + i]; }
  [[nodiscard]] bool event(std::size_t i) const { return reached_[node_of_event(i)]; }

 private:
  [[nodiscard]] std::size_t node_of(SignalId signal) const { return model_.elements.size() + signal.index(); }
  [[nodiscard]] std::size_t node_of(const ModelEvent::Set& set) const {
    return set.element.valid() ? set.element.index() : node_of(set.signal);
  }
  [[nodiscard]] std::size_t node_of_event(std::size_t i) const { return set_by_.size() + i; }

  void reach(std::size_t node) {
    if (reached_[node]) return;
    reached_[node] = true;
    open_.push_back(node);
  }

  void needs_of(ElementId id) {
    for (const ElementId other : bonded_[id.index()]) reach(other.index());
    const Element& element = model_.elements[id.index()];
    if (element.contact) reach(node_of(element.contact->displacement));
    names(expressions_of(element));
  }

  void needs_of(const Signal& signal) {
    if (signal.delay) reach(node_of(signal.delay->clock));
    names(expressions_of(signal));
  }

  void needs_of(const ModelEvent& event) {
    if (event.sampled.valid()) reach(node_of(event.sampled));
    for (const ModelEvent::Set& set : event.sets) reach(node_of(set));
    names(expressions_of(event));
  }

  /// Reaches what expressions name. Parameters and initial values, which name parameters only, are all kept.
  void names(std::vector<ExprId> expressions) {
    std::erase_if(expressions, [](ExprId e) { return !e.valid(); });
    for (const SymbolId id : symbols_in(model_.pool, expressions)) {
      const ModelSymbol& symbol = model_.symbols[id.index()];
      switch (symbol.kind) {
        case ModelSymbol::Kind::time:
        case ModelSymbol::Kind::parameter:
          break;
        case ModelSymbol::Kind::signal:
          reach(node_of(symbol.signal));
          break;
        case ModelSymbol::Kind::port_variable:
        case ModelSymbol::Kind::mode:
          reach(symbol.element.index());
          break;
        case ModelSymbol::Kind::bond_variable:
          reach(model_.bonds[symbol.bond.index()].from.element.index());
          break;
      }
    }
  }

  const Model& model_;
  std::vector<std::vector<ElementId>> bonded_;    ///< by ElementId
  std::vector<std::vector<std::size_t>> set_by_;  ///< events, by node of an element or signal
  std::vector<bool> reached_;                     ///< by node
  std::vector<std::size_t> open_;
};

/// The members of @p all that are kept, in order; and where each one is then.
template <class T, class Keep, class Place>
std::vector<T> kept(const std::vector<T>& all, const Keep& keep, const Place& place) {
  std::vector<T> result;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!keep(i)) continue;
    place(i, result.size());
    result.push_back(all[i]);
  }
  return result;
}

LeftOut left_out_of(const Model& model, const Reached& reached) {
  LeftOut left_out;
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    const Element& element = model.elements[i];
    if (reached.element(i) || is_junction(element.kind)) continue;
    left_out.elements.push_back(element.name);
    if (!is_store(element.kind)) continue;
    for (std::size_t port = 0; port < port_count(element); ++port)
      left_out.states.push_back(port_name(element, port) + '.' + letter(stored_variable(element, port)));
  }
  // The clock of the delayed signals has no name that the model gave it.
  std::vector<bool> clock(model.signals.size(), false);
  for (const Signal& signal : model.signals)
    if (signal.delay) clock[signal.delay->clock.index()] = true;
  for (std::size_t i = 0; i < model.signals.size(); ++i)
    if (!reached.signal(i) && !clock[i])
      (model.signals[i].is_state() ? left_out.states : left_out.signals).push_back(model.signals[i].name);
  return left_out;
}

}  // namespace

bool equations_stay(const Model& model) {
  return switches_of(model).empty() && model.events.empty() &&
         std::none_of(model.signals.begin(), model.signals.end(), [](const Signal& s) { return s.delay.has_value(); });
}

std::optional<ObservedPart> observed_part(const Model& model, const std::vector<std::size_t>& outputs) {
  Reached reached(model);
  for (const std::size_t i : outputs) reached.need(model.outputs[i].value);
  ObservedPart part{{}, {}, {}, {}, left_out_of(model, reached)};
  if (part.left_out.nothing()) return std::nullopt;

  const auto whole = std::make_shared<Model>(model);
  Model& made = *whole;
  part.model = whole;
  part.elements.resize(model.elements.size());
  part.signals.resize(model.signals.size());
  part.events.resize(model.events.size());
  std::vector<BondId> bonds(model.bonds.size());
  const auto element = [&](std::size_t i) { return reached.element(i); };
  made.elements =
      kept(model.elements, element, [&](std::size_t i, std::size_t at) { part.elements[i] = ElementId(at); });
  const auto signal = [&](std::size_t i) { return reached.signal(i); };
  made.signals = kept(model.signals, signal, [&](std::size_t i, std::size_t at) { part.signals[i] = SignalId(at); });
  const auto event = [&](std::size_t i) { return reached.event(i); };
  made.events = kept(model.events, event, [&](std::size_t i, std::size_t at) { part.events[i] = at; });
  const auto bond = [&](std::size_t i) { return reached.element(model.bonds[i].from.element.index()); };
  made.bonds = kept(model.bonds, bond, [&](std::size_t i, std::size_t at) { bonds[i] = BondId(at); });
  made.outputs.clear();
  for (const std::size_t i : outputs) made.outputs.push_back(model.outputs[i]);

  const auto now = [](auto& id, const auto& ids) {
    if (id.valid()) id = ids[id.index()];
  };
  for (ModelSymbol& symbol : made.symbols) {
    now(symbol.element, part.elements);
    now(symbol.signal, part.signals);
    now(symbol.bond, bonds);
  }
  for (ModelBond& each : made.bonds) {
    now(each.from.element, part.elements);
    now(each.to.element, part.elements);
  }
  for (Element& each : made.elements)
    if (each.contact) now(each.contact->displacement, part.signals);
  for (Signal& each : made.signals)
    if (each.delay) now(each.delay->clock, part.signals);
  for (ModelEvent& each : made.events) {
    now(each.sampled, part.signals);
    for (ModelEvent::Set& set : each.sets) {
      now(set.element, part.elements);
      now(set.signal, part.signals);
    }
  }
  return part;
}

RunInputs inputs_of_part(RunInputs inputs, const ObservedPart& part) {
  const auto gone = [&](const RunInputs::Initial& initial) {
    return initial.element.valid() ? !part.elements[initial.element.index()].valid()
                                   : !part.signals[initial.signal.index()].valid();
  };
  std::erase_if(inputs.initial, gone);
  for (RunInputs::Initial& initial : inputs.initial) {
    if (initial.element.valid()) initial.element = part.elements[initial.element.index()];
    if (initial.signal.valid()) initial.signal = part.signals[initial.signal.index()];
  }
  std::vector<std::size_t> starting;
  for (const std::size_t event : inputs.starting_events)
    if (part.events[event]) starting.push_back(*part.events[event]);
  inputs.starting_events = std::move(starting);
  for (std::size_t i = 0; i < inputs.outputs.size(); ++i) inputs.outputs[i] = i;
  return inputs;
}

}  // namespace bgsim
