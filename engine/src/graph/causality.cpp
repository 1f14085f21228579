#include "bgsim/causality.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>

#include "graph/causal_explanation.hpp"
#include "graph/given_starts.hpp"
#include "graph/graph_faults.hpp"
#include "graph/law_numbers.hpp"
#include "graph/rank_causality.hpp"
#include "graph/solved_laws.hpp"
#include "graph/start_moduli.hpp"
#include "graph/store_causes.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

// Taking choices back is for rings of junctions; a graph that needs more than this is refused with the conflict.
constexpr std::size_t kMostReversals = 10000;

BondEnd other(BondEnd end) { return end == BondEnd::head ? BondEnd::tail : BondEnd::head; }

/// A stroke that may be chosen while its bond has none.
struct Choice {
  BondId bond;
  BondEnd end = BondEnd::head;
  StrokeReason reason = StrokeReason::free_choice;
  ElementId element;
};

/// What is chosen before all else.
struct Preference {
  std::vector<ElementId> moduli;  ///< of TF and GY that are to multiply, not to divide
  std::vector<PortId> stores;     ///< in integral causality
};

class Scap {
 public:
  Scap(const Model& model, const BondGraph& graph, const SolvedLaws& laws, const Preference& preference)
      : model_(model),
        graph_(graph),
        laws_(laws),
        preference_(preference),
        strokes_(graph.bonds.size()),
        assigned_(graph.bonds.size()),
        junctions_(graph.kinds.size()),
        broken_(graph.kinds.size()) {
    trail_.reserve(graph.bonds.size());
    for (std::size_t i = 0; i < graph.ports.size(); ++i) {
      JunctionState& junction = junctions_[graph.ports[i].element.index()];
      ++junction.open;
      junction.open_ports ^= static_cast<std::uint32_t>(i);
    }
  }

  [[nodiscard]] std::span<const Stroke> strokes() const { return strokes_; }
  /// Elements whose rule or law was broken last.
  [[nodiscard]] const std::vector<ElementId>& conflicts() const { return conflicts_.empty() ? last_ : conflicts_; }
  [[nodiscard]] std::vector<Diagnostic>& problems() { return problems_; }

  /// @param ranked  parts whose strokes at their outer ports are known.
  bool succeeds(std::span<const RankedPart> ranked) {
    assign_ranked(ranked);
    assign_sources();
    assign_one_way_laws();
    if (problems_.empty()) choose(choices());
    return problems_.empty();
  }

  /// How many of some TF and GY divide by their modulus.
  [[nodiscard]] std::size_t divisions(const std::vector<ElementId>& two_ports) const {
    return static_cast<std::size_t>(std::count_if(two_ports.begin(), two_ports.end(), [&](ElementId id) {
      return stroke_at(graph_, strokes_, graph_.port(id, 0));
    }));
  }
  [[nodiscard]] std::vector<PortId> integral_ports() const {
    std::vector<PortId> ports;
    for (std::size_t i = 0; i < graph_.ports.size(); ++i)
      if (const PortId port(i); is_store(kind(port)))
        if (stroke_at(graph_, strokes_, port) == (integral(port) == Gives::flow)) ports.push_back(port);
    return ports;
  }

  CausalAttempt attempt(bool succeeded) {
    // Choices have all been taken back where none of them helped: shown is what led to the first conflict.
    if (!succeeded && conflicts_.empty()) choose_until_conflict();
    CausalAttempt attempt;
    for (std::size_t i = 0; i < strokes_.size(); ++i)
      attempt.strokes.push_back(assigned_[i] ? std::optional(strokes_[i]) : std::nullopt);
    attempt.conflicts = std::move(conflicts_);
    attempt.problems = std::move(problems_);
    return attempt;
  }

 private:
  struct JunctionState {
    std::uint32_t setters = 0;     // bonds that set the effort of a 0-junction (the flow of a 1-junction)
    BondId setter;                 // the first of them
    std::uint32_t open = 0;        // bonds without a stroke
    std::uint32_t open_ports = 0;  // exclusive or of their ports: the port itself when one is left
  };
  struct Decision {
    std::size_t choice = 0;
    std::size_t trail = 0;
    bool reversed = false;
  };

  const Element& element(PortId port) const { return model_.elements[graph_[port].element.index()]; }
  ElementKind kind(PortId port) const { return graph_.kinds[graph_[port].element.index()]; }
  static BondEnd end_at(const Port& port) { return port.head ? BondEnd::head : BondEnd::tail; }
  /// Where the stroke of the port's bond is when the port gives effort or flow.
  BondEnd end_for(PortId port, Gives gives) const {
    const BondEnd here = end_at(graph_[port]);
    return gives == Gives::flow ? here : other(here);
  }

  // --- one stroke, and what follows from it ---

  void assign(BondId bond, const Stroke& stroke) {
    Stroke& place = strokes_[bond.index()];
    place = stroke;
    place.order = static_cast<std::uint32_t>(trail_.size());
    assigned_[bond.index()] = true;
    trail_.push_back(bond);
    for (const PortId port : {graph_[bond].tail, graph_[bond].head}) {
      waiting_.push_back(port);
      JunctionState& junction = junctions_[graph_[port].element.index()];
      --junction.open;
      junction.open_ports ^= port.value;
      if (sets(port) && junction.setters++ == 0) junction.setter = bond;
    }
  }

  void undo_to(std::size_t length) {
    waiting_.clear();
    next_waiting_ = 0;
    while (trail_.size() > length) {
      const BondId bond = trail_.back();
      for (const PortId port : {graph_[bond].tail, graph_[bond].head}) {
        JunctionState& junction = junctions_[graph_[port].element.index()];
        ++junction.open;
        junction.open_ports ^= port.value;
        if (sets(port) && --junction.setters == 0) junction.setter = BondId();
      }
      assigned_[bond.index()] = false;
      trail_.pop_back();
    }
  }

  /// Whether the bond at a junction's port sets what the junction's bonds share.
  bool sets(PortId port) const {
    const bool here = stroke_at(graph_, strokes_, port);
    const auto shared = shared_variable(kind(port));
    return shared && (*shared == Variable::effort) == here;
  }

  void force(PortId port, bool stroke_here, BondId cause) {
    const BondEnd here = end_at(graph_[port]);
    assign(graph_[port].bond,
           {stroke_here ? here : other(here), StrokeReason::propagated, graph_[port].element, cause, 0});
  }

  /// Follows what is forced until nothing more is, or a rule is broken.
  std::optional<CausalConflict> propagate() {
    while (next_waiting_ < waiting_.size()) {
      const PortId port = waiting_[next_waiting_++];
      if (broken_[graph_[port].element.index()]) continue;
      std::optional<CausalConflict> conflict;
      if (is_junction(kind(port)))
        conflict = follow_junction(graph_[port].element);
      else if (is_two_port(kind(port)))
        conflict = follow_two_port(port);
      else
        conflict = check_one_port(port);
      if (conflict) return conflict;
    }
    waiting_.clear();
    next_waiting_ = 0;
    return std::nullopt;
  }

  std::optional<CausalConflict> follow_junction(ElementId id) {
    // A copy: assigning changes the state.
    const JunctionState state = junctions_[id.index()];
    const bool zero = shared_variable(graph_.kinds[id.index()]) == Variable::effort;
    if (state.setters > 1) return CausalConflict{CausalConflict::Kind::two_set, id, {}, setters_of(id)};
    if (state.setters == 0 && state.open == 0)
      return CausalConflict{CausalConflict::Kind::none_sets, id, {}, bonds_of(id)};
    if (state.setters == 0 && state.open == 1) force(PortId(state.open_ports), zero, BondId());
    if (state.setters == 0 || state.open == 0) return std::nullopt;
    for (std::size_t number = 0; number < graph_.port_count(id); ++number) {
      const PortId port = graph_.port(id, number);
      if (!assigned_[graph_[port].bond.index()]) force(port, !zero, state.setter);
    }
    return std::nullopt;
  }

  std::optional<CausalConflict> follow_two_port(PortId port) {
    const ElementId id = graph_[port].element;
    const PortId partner = graph_.port(id, 1 - graph_[port].number);
    const bool here = stroke_at(graph_, strokes_, port);
    const bool wanted = kind_row(kind(port)).crosses ? here : !here;
    if (!assigned_[graph_[partner].bond.index()]) {
      force(partner, wanted, graph_[port].bond);
    } else if (stroke_at(graph_, strokes_, partner) != wanted) {
      return CausalConflict{
          CausalConflict::Kind::two_port, id, {}, {graph_[graph_.port(id, 0)].bond, graph_[graph_.port(id, 1)].bond}};
    }
    return std::nullopt;
  }

  std::optional<CausalConflict> check_one_port(PortId port) {
    if (laws_.usable(port, stroke_at(graph_, strokes_, port) ? Gives::flow : Gives::effort)) return std::nullopt;
    return CausalConflict{CausalConflict::Kind::one_port, graph_[port].element, port, {graph_[port].bond}};
  }

  std::vector<BondId> bonds_of(ElementId id) const {
    std::vector<BondId> bonds;
    for (std::size_t number = 0; number < graph_.port_count(id); ++number)
      bonds.push_back(graph_[graph_.port(id, number)].bond);
    return bonds;
  }
  std::vector<BondId> setters_of(ElementId id) const {
    std::vector<BondId> bonds;
    for (std::size_t number = 0; number < graph_.port_count(id); ++number) {
      const PortId port = graph_.port(id, number);
      if (assigned_[graph_[port].bond.index()] && sets(port)) bonds.push_back(graph_[port].bond);
    }
    return bonds;
  }

  /// Strokes within such a part are for the eye: no rule is checked there.
  void assign_ranked(std::span<const RankedPart> ranked) {
    const auto follow = [this] {
      while (const auto conflict = propagate()) broken_[conflict->element.index()] = true;
    };
    for (const RankedPart& at : ranked)
      for (std::size_t i = 0; i < at.outer.size(); ++i) assign(graph_[at.part.outer[i]].bond, at.outer[i]);
    for (const RankedPart& at : ranked) {
      follow();
      for (const BondId bond : at.part.inner) {
        if (assigned_[bond.index()]) continue;
        assign(bond, {free_end(graph_[bond]), StrokeReason::by_rank, graph_[graph_[bond].tail].element, {}, 0});
        follow();
      }
      for (const ElementId id : at.part.elements) broken_[id.index()] = true;
    }
  }

  // --- what is fixed: sources, laws for one direction ---

  void assign_sources() {
    // All of them first, so that sources that contradict each other meet at a junction, whichever comes first.
    for (std::size_t i = 0; i < graph_.ports.size(); ++i) {
      const PortId port(i);
      const auto imposed = imposed_variable(kind(port));
      if (!imposed) continue;
      const Gives gives = *imposed == Variable::effort ? Gives::effort : Gives::flow;
      if (!assigned_[graph_[port].bond.index()])
        assign(graph_[port].bond, {end_for(port, gives), StrokeReason::source, graph_[port].element, {}, 0});
    }
    for (std::size_t i = 0; i < graph_.kinds.size(); ++i)
      if (is_junction(graph_.kinds[i]) && graph_.port_count(ElementId(i)) == 1)
        waiting_.push_back(graph_.port(ElementId(i), 0));
    settle();
  }

  void assign_one_way_laws() {
    for (std::size_t i = 0; i < graph_.ports.size(); ++i) {
      const PortId port(i);
      if (is_junction(kind(port)) || assigned_[graph_[port].bond.index()]) continue;
      if (laws_.usable(port, Gives::effort) && laws_.usable(port, Gives::flow)) continue;
      const Gives gives = laws_.usable(port, Gives::effort) ? Gives::effort : Gives::flow;
      assign(graph_[port].bond, {end_for(port, gives), StrokeReason::one_way_law, graph_[port].element, {}, 0});
      settle();
    }
  }

  /// Propagates what is fixed. Each conflict is reported once, and its element left out from then on, so that
  /// independent conflicts come out in one run.
  void settle() {
    while (const auto conflict = propagate()) {
      problems_.push_back(explain_conflict(model_, graph_, strokes_, *conflict));
      broken_[conflict->element.index()] = true;
      conflicts_.push_back(conflict->element);
    }
  }

  // --- what may be chosen ---

  std::vector<Choice> choices() const {
    std::vector<Choice> list;
    list.reserve(graph_.bonds.size());
    for (const ElementId id : preference_.moduli) {
      const PortId port = graph_.port(id, 0);
      list.push_back({graph_[port].bond, end_for(port, Gives::effort), StrokeReason::zero_modulus, id});
    }
    for (const PortId port : preference_.stores) add_store(list, port);
    add_stores(list);
    add_nonlinear_resistors(list);
    const auto internal = [&](PortId port) { return passes_power(kind(port)); };
    for (const bool between_junctions : {true, false})
      for (std::size_t i = 0; i < graph_.bonds.size(); ++i) {
        const Bond& bond = graph_.bonds[i];
        if (assigned_[i] || (internal(bond.tail) && internal(bond.head)) != between_junctions) continue;
        const PortId owner = internal(bond.tail) && !internal(bond.head) ? bond.head : bond.tail;
        list.push_back({BondId(i), free_end(bond), StrokeReason::free_choice, graph_[owner].element});
      }
    return list;
  }

  void add_store(std::vector<Choice>& list, PortId port) const {
    list.push_back({graph_[port].bond, end_for(port, integral(port)), StrokeReason::integral, graph_[port].element});
  }

  void add_stores(std::vector<Choice>& list) const {
    const GivenStarts given(model_);
    const auto is_given = [&](PortId port) { return given(graph_[port].element, graph_[port].number); };
    std::vector<PortId> stores;
    for (std::size_t i = 0; i < graph_.ports.size(); ++i)
      if (is_store(kind(PortId(i)))) stores.push_back(PortId(i));
    std::stable_sort(stores.begin(), stores.end(), [&](PortId a, PortId b) {
      const double first = element(a).priority, second = element(b).priority;
      return first != second ? first > second : is_given(a) && !is_given(b);
    });
    for (const PortId store : stores) add_store(list, store);
  }

  void add_nonlinear_resistors(std::vector<Choice>& list) const {
    for (std::size_t i = 0; i < graph_.ports.size(); ++i) {
      const PortId port(i);
      if (!is_resistor(kind(port))) continue;
      const LawUse effort = laws_.use(port, Gives::effort), flow = laws_.use(port, Gives::flow);
      const bool implicit = effort == LawUse::implicit || flow == LawUse::implicit;
      if (element(port).laws.empty() && !implicit) continue;
      // Of a law "0 = ..." the direction in which it has a closed form.
      const bool closed = effort == LawUse::inverted && flow == LawUse::implicit;
      const Gives written = effort == LawUse::as_written || closed ? Gives::effort : Gives::flow;
      list.push_back({graph_[port].bond, end_for(port, written), StrokeReason::law_as_written, graph_[port].element});
    }
  }

  Gives integral(PortId port) const {
    return stores_displacement(element(port), graph_[port].number) ? Gives::effort : Gives::flow;
  }

  /// The end at which a free stroke decides most: where its bond sets a junction's effort or flow.
  BondEnd free_end(const Bond& bond) const {
    for (const PortId port : {bond.tail, bond.head}) {
      if (const auto shared = shared_variable(kind(port)))
        return *shared == Variable::effort ? end_at(graph_[port]) : other(end_at(graph_[port]));
    }
    return BondEnd::head;
  }

  void choose(const std::vector<Choice>& list) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (assigned_[list[i].bond.index()]) continue;
      decisions_.push_back({i, trail_.size(), false});
      assign(list[i].bond, {list[i].end, list[i].reason, list[i].element, {}, 0});
      const std::optional<CausalConflict> conflict = propagate();
      if (!conflict) continue;
      Diagnostic problem = explain_conflict(model_, graph_, strokes_, *conflict);
      const ElementId broken = conflict->element;
      if (!resolve(list, *conflict, problem)) {
        last_ = {broken};
        problems_.push_back(std::move(problem));
        return;
      }
      i = decisions_.back().choice;
    }
  }

  void choose_until_conflict() {
    if (!decisions_.empty()) undo_to(decisions_.front().trail);
    for (const Choice& choice : choices()) {
      if (assigned_[choice.bond.index()]) continue;
      assign(choice.bond, {choice.end, choice.reason, choice.element, {}, 0});
      if (const auto conflict = propagate()) {
        conflicts_.push_back(conflict->element);
        return;
      }
    }
  }

  /// Takes choices back until the conflict is gone. Only those are touched that the conflict follows from, the last of
  /// them first (conflict-directed backjumping): what is chosen elsewhere in the graph is not to blame.
  /// @return false if no choice is left to take back: no strokes keep all rules.
  bool resolve(const std::vector<Choice>& list, const CausalConflict& conflict, Diagnostic& problem) {
    std::set<BondId> blamed = roots_of(conflict.bonds);
    while (!decisions_.empty()) {
      Decision& last = decisions_.back();
      const Choice& choice = list[last.choice];
      if (!blamed.contains(choice.bond) || last.reversed) {
        if (blamed.erase(choice.bond) > 0) blamed.merge(eliminated_[choice.bond]);
        undo_to(last.trail);
        decisions_.pop_back();
        continue;
      }
      if (++reversals_ > kMostReversals) {
        problem.notes.push_back({std::nullopt, "other strokes were tried " + std::to_string(kMostReversals) +
                                                   " times; there may be some that keep all rules"});
        return false;
      }
      undo_to(last.trail);
      last.reversed = true;
      blamed.erase(choice.bond);
      eliminated_[choice.bond] = std::move(blamed);
      assign(choice.bond, {other(choice.end), StrokeReason::by_elimination, choice.element, {}, 0});
      const std::optional<CausalConflict> next = propagate();
      if (!next) return true;
      blamed = roots_of(next->bonds);
    }
    return false;
  }

  /// The strokes that nothing forces, among those behind some strokes.
  std::set<BondId> roots_of(const std::vector<BondId>& bonds) const {
    std::set<BondId> roots;
    for (const BondId bond : strokes_behind(graph_, strokes_, bonds))
      if (strokes_[bond.index()].reason != StrokeReason::propagated) roots.insert(bond);
    return roots;
  }

  // --- what came out ---

 public:
  CausalGraph result(std::span<const RankedPart> ranked) {
    CausalGraph causal;
    causal.free_choices = free_choices();
    list_stores(model_, graph_, strokes_, trail_, eliminated_, causal);
    causal.warnings = part_warnings(model_, graph_);
    causal.strokes = std::move(strokes_);
    for (const RankedPart& at : ranked) causal.ranked.push_back(at.part);
    for (DependentPort& port : causal.dependent)
      for (const RankedPart& at : ranked)
        if (const auto found = at.because.find(graph_.port(port.element, port.port)); found != at.because.end()) {
          port.because = found->second;
          port.more = port.because.size() > kNamedCauses;
          port.because.resize(std::min(port.because.size(), kNamedCauses));
        }
    return causal;
  }

 private:
  std::vector<FreeChoice> free_choices() const {
    std::vector<FreeChoice> free;
    for (std::size_t i = 0; i < decisions_.size(); ++i) {
      const BondId bond = trail_[decisions_[i].trail];
      const Stroke& stroke = strokes_[bond.index()];
      if (stroke.reason != StrokeReason::free_choice && stroke.reason != StrokeReason::law_as_written) continue;
      const std::size_t end = i + 1 < decisions_.size() ? decisions_[i + 1].trail : trail_.size();
      free.push_back({bond, stroke.element, path(decisions_[i].trail, end)});
    }
    return free;
  }

  /// The elements at the bonds of a stretch of the trail, but for sources and stores.
  std::vector<ElementId> path(std::size_t begin, std::size_t end) const {
    std::vector<ElementId> elements;
    for (std::size_t i = begin; i < end; ++i)
      for (const PortId port : {graph_[trail_[i]].tail, graph_[trail_[i]].head})
        if (!is_store(kind(port)) && !imposed_variable(kind(port))) elements.push_back(graph_[port].element);
    std::sort(elements.begin(), elements.end());
    elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
    return elements;
  }

  const Model& model_;
  const BondGraph& graph_;
  const SolvedLaws& laws_;
  const Preference& preference_;
  std::vector<Stroke> strokes_;
  std::vector<bool> assigned_;
  std::vector<JunctionState> junctions_;  // by ElementId
  std::vector<bool> broken_;              // by ElementId: reported, not followed any more
  std::vector<BondId> trail_;             // bonds in order of assignment
  std::vector<PortId> waiting_;           // first in, first out: short chains of reasons
  std::size_t next_waiting_ = 0;
  std::vector<Decision> decisions_;
  std::unordered_map<BondId, std::set<BondId>> eliminated_;  // what each reversed choice gave way to
  std::size_t reversals_ = 0;
  std::vector<Diagnostic> problems_;
  std::vector<ElementId> conflicts_;
  std::vector<ElementId> last_;  // whose conflict no choice resolves
};

/// Strokes as SCAP chooses them; where junctions form rings, held against the rank of their equations.
template <class Done>
auto with_ranks(const Model& model, const BondGraph& graph, const SolvedLaws& laws, const Preference& preference,
                const Done& done) {
  RankCausality ranks(model, graph, laws);
  for (;;) {
    Scap scap(model, graph, laws, preference);
    const bool succeeded = scap.succeeds(ranks.ranked());
    const bool again = ranks.any() && (succeeded ? ranks.correct(scap.strokes()) : ranks.settle(scap.conflicts()));
    if (!again) return done(scap, succeeded, ranks.ranked());
  }
}

/// A TF or GY multiplies from one side and divides from the other: by a modulus that is 0 at the start only if nothing
/// else is possible. Where stores in their usual order make it divide, those come first that are independent if it does
/// not.
Preference preference_of(const Model& model, const BondGraph& graph, const SolvedLaws& laws) {
  const std::vector<ElementId> zero = moduli_zero_at_start(model);
  Preference preference;
  std::vector<PortId> stores;
  const auto divisions = [&](const Preference& tried) {
    return with_ranks(model, graph, laws, tried, [&](Scap& scap, bool succeeded, std::span<const RankedPart>) {
      stores = scap.integral_ports();
      return succeeded ? scap.divisions(zero) : zero.size();
    });
  };
  const std::size_t as_usual = zero.empty() ? 0 : divisions(preference);
  if (as_usual == 0) return preference;
  const Preference moduli{zero, {}};
  const std::size_t least = divisions(moduli);
  if (least >= as_usual) return preference;
  preference.stores = stores;
  return divisions(preference) <= least ? preference : moduli;
}

}  // namespace

namespace {

CausalGraph assigned(const Model& model, const BondGraph& graph, SolvedLaws laws) {
  const Preference preference = preference_of(model, graph, laws);
  CausalGraph causal =
      with_ranks(model, graph, laws, preference, [&](Scap& scap, bool succeeded, std::span<const RankedPart> ranked) {
        if (!succeeded) throw ModelError(std::move(scap.problems()), model.sources);
        return scap.result(ranked);
      });
  std::move(laws).hand_over(causal.strokes, causal);
  return causal;
}

CausalAttempt attempted(const Model& model, const BondGraph& graph, const SolvedLaws& laws) {
  const Preference usual;
  try {
    return with_ranks(
        model, graph, laws, preference_of(model, graph, laws),
        [](Scap& scap, bool succeeded, std::span<const RankedPart> /*ranked*/) { return scap.attempt(succeeded); });
  } catch (ModelError& error) {  // no strokes are wrong, and the ring has no solution all the same
    Scap scap(model, graph, laws, usual);
    CausalAttempt attempt = scap.attempt(scap.succeeds({}));
    attempt.problems = std::move(error.diagnostics);
    return attempt;
  }
}

}  // namespace

CausalGraph assign_causality(const Model& model, const BondGraph& graph) {
  try {
    return assigned(model, graph, SolvedLaws(model, graph));
  } catch (const ModelError&) {
    SolvedLaws laws(model, graph, numbers_at_start(model));
    if (!laws.any_by_pieces()) throw;
    return assigned(model, graph, std::move(laws));
  }
}

std::optional<CausalGraph> assign_causality_by_pieces(const Model& model, const BondGraph& graph) {
  SolvedLaws laws(model, graph, numbers_at_start(model));
  if (!laws.any_by_pieces()) return std::nullopt;
  try {
    return assigned(model, graph, std::move(laws));
  } catch (const ModelError&) {
    return std::nullopt;
  }
}

CausalAttempt attempt_causality(const Model& model, const BondGraph& graph) {
  CausalAttempt attempt = attempted(model, graph, SolvedLaws(model, graph));
  if (attempt.problems.empty()) return attempt;
  const SolvedLaws laws(model, graph, numbers_at_start(model));
  return laws.any_by_pieces() ? attempted(model, graph, laws) : attempt;
}

std::vector<BondId> reason_chain(const BondGraph& graph, const CausalGraph& causal, BondId bond) {
  return strokes_behind(graph, causal.strokes, {bond});
}

}  // namespace bgsim
