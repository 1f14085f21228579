#include "graph/rank_causality.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <unordered_map>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "graph/causal_explanation.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

/// Elimination in larger parts is left to where strokes fail: there it is the only way.
constexpr std::size_t kLargestLookedAt = 2000;

Gives other(Gives gives) { return gives == Gives::effort ? Gives::flow : Gives::effort; }

}  // namespace

JunctionRank RankCausality::rank_of(const JunctionPart& part) {
  const auto modulus = [this](ElementId id) {
    return Coefficient{residues_(model_.elements[id.index()].coefficient), {}};
  };
  return {graph_, part, modulus, nullptr};
}

/// Outer ports in the order in which they choose: sources, laws for one direction, stores by priority, nonlinear
/// resistors, the others.
std::vector<PortId> RankCausality::by_right(const JunctionPart& part) const {
  const auto rank = [&](PortId port) {
    if (imposed_variable(kind(port))) return 0;
    if (!laws_.usable(port, Gives::effort) || !laws_.usable(port, Gives::flow)) return 1;
    if (is_store(kind(port))) return 2;
    return model_.elements[graph_[port].element.index()].laws.empty() ? 4 : 3;
  };
  const auto priority = [&](PortId port) { return model_.elements[graph_[port].element.index()].priority; };
  const auto given = [&](PortId port) { return given_(graph_[port].element, graph_[port].number); };
  std::vector<PortId> order = part.outer;
  std::stable_sort(order.begin(), order.end(), [&](PortId a, PortId b) {
    if (rank(a) != rank(b) || rank(a) != 2) return rank(a) < rank(b);
    return priority(a) != priority(b) ? priority(a) > priority(b) : given(a) && !given(b);
  });
  return order;
}

bool RankCausality::correct(std::span<const Stroke> strokes) {
  bool corrected = false;
  std::vector<Diagnostic> problems;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (state_[i] != State::open) continue;
    state_[i] = State::right;
    const JunctionPart& part = parts_[i];
    if (part.inner.size() > kLargestLookedAt) continue;
    const bool apparent = std::any_of(part.outer.begin(), part.outer.end(), [&](PortId port) {
      return is_store(kind(port)) && seems_to_depend(part, strokes, port);
    });
    if (!apparent && computes_in_sequence(part, strokes)) continue;
    JunctionRank rank = rank_of(part);
    const bool right = !apparent && take_all(part, strokes, rank) && only_states_determine(part, strokes, rank);
    if (right && rank.determines_all()) continue;
    state_[i] = State::ranked;
    if (right) keep(part, strokes, rank);
    corrected = right || solve(part, strokes, &problems) || corrected;
  }
  if (!problems.empty()) throw ModelError(std::move(problems), model_.sources);
  return corrected;
}

bool RankCausality::settle(const std::vector<ElementId>& conflicts) {
  bool all = !conflicts.empty();
  std::set<std::size_t> found;
  for (const ElementId conflict : conflicts) {
    const auto holds = [&](const JunctionPart& part) {
      const bool at_port = std::any_of(part.outer.begin(), part.outer.end(),
                                       [&](PortId port) { return graph_[port].element == conflict; });
      return at_port || std::binary_search(part.elements.begin(), part.elements.end(), conflict);
    };
    const auto part = std::find_if(parts_.begin(), parts_.end(), holds);
    const auto at = static_cast<std::size_t>(part - parts_.begin());
    all = all && part != parts_.end() && state_[at] == State::open;
    if (all) found.insert(at);
  }
  for (const std::size_t at : found) {
    if (!all) break;
    state_[at] = State::ranked;
    all = solve(parts_[at], {}, nullptr);
  }
  return all;
}

/// Whether the strokes at the outer ports are a choice that determines all others; takes it.
bool RankCausality::take_all(const JunctionPart& part, std::span<const Stroke> strokes, JunctionRank& rank) const {
  return std::all_of(part.outer.begin(), part.outer.end(), [&](PortId port) {
    return rank.take(rank.variable(port, stroke_at(graph_, strokes, port) ? Gives::flow : Gives::effort));
  });
}

/// Whether each store in derivative causality follows from states, sources and laws for one direction.
bool RankCausality::only_states_determine(const JunctionPart& part, std::span<const Stroke> strokes,
                                          const JunctionRank& rank) const {
  const auto given = [&](PortId port) { return stroke_at(graph_, strokes, port) ? Gives::flow : Gives::effort; };
  const auto known = [&](PortId port) {
    if (is_store(kind(port))) return given(port) == integral(port);
    return imposed_variable(kind(port)) || !laws_.usable(port, Gives::effort) || !laws_.usable(port, Gives::flow);
  };
  return std::all_of(part.outer.begin(), part.outer.end(), [&](PortId store) {
    if (!is_store(kind(store)) || known(store)) return true;
    const JunctionRank::Row row = rank.determined(rank.variable(store, integral(store)));
    return std::all_of(part.outer.begin(), part.outer.end(),
                       [&](PortId port) { return known(port) || !row.contains(rank.variable(port, given(port))); });
  });
}

std::vector<ElementId> RankCausality::elements_in(const JunctionPart& part, const JunctionRank& rank,
                                                  const JunctionRank::Row& row) const {
  std::set<ElementId> elements;
  for (const PortId port : part.outer)
    for (const Gives gives : {Gives::effort, Gives::flow})
      if (row.contains(rank.variable(port, gives))) elements.insert(graph_[port].element);
  return {elements.begin(), elements.end()};
}

/// Keeps the strokes at the outer ports where they are right, but something within the part is not determined.
void RankCausality::keep(const JunctionPart& part, std::span<const Stroke> strokes, const JunctionRank& rank) {
  RankedPart ranked{part, {}, {}};
  for (const PortId port : part.outer) {
    const Stroke& stroke = strokes[graph_[port].bond.index()];
    const bool forced = stroke.reason == StrokeReason::propagated || stroke.reason == StrokeReason::by_elimination;
    const StrokeReason reason = forced ? StrokeReason::by_rank : stroke.reason;
    ranked.outer.push_back({stroke.end, reason, graph_[port].element, {}, 0});
    const Gives gives = stroke_at(graph_, strokes, port) ? Gives::flow : Gives::effort;
    if (is_store(kind(port)) && gives != integral(port))
      ranked.because[port] = elements_in(part, rank, rank.determined(rank.variable(port, integral(port))));
  }
  ranked_.push_back(std::move(ranked));
}

/// The port that computes a variable of a bond: the flow is given where the stroke is, the effort at the other end.
PortId RankCausality::giver(std::span<const Stroke> strokes, BondId bond, Variable variable) const {
  const bool at_head = strokes[bond.index()].end == BondEnd::head;
  return at_head == (variable == Variable::flow) ? graph_[bond].head : graph_[bond].tail;
}

/// Calls @p need for the variables from which a junction, TF or GY computes one that it gives.
template <class Need>
void RankCausality::computed_from(std::span<const Stroke> strokes, PortId giver, Variable variable,
                                  const Need& need) const {
  const ElementId id = graph_[giver].element;
  if (is_two_port(kind(giver))) {
    const Variable across = kind_row(kind(giver)).crosses ? other_of(variable) : variable;
    return need(graph_[graph_.port(id, 1 - graph_[giver].number)].bond, across);
  }
  const Variable shared = *shared_variable(kind(giver));
  for (std::size_t k = 0; k < graph_.port_count(id); ++k) {
    const PortId port = graph_.port(id, k);
    const bool setter = stroke_at(graph_, strokes, port) == (shared == Variable::effort);
    if (port != giver && (variable != shared || setter)) need(graph_[port].bond, variable);
  }
}

/// Whether everything in the part follows from what is given at its outer ports, one after the other: then the choice
/// at these ports is right, and no rank is needed.
bool RankCausality::computes_in_sequence(const JunctionPart& part, std::span<const Stroke> strokes) const {
  enum class Mark : std::uint8_t { open, entered, done };
  using Quantity = std::pair<BondId, Variable>;
  std::unordered_map<BondId, std::array<Mark, 2>> marks;
  const auto mark = [&](const Quantity& q) -> Mark& { return marks[q.first][q.second == Variable::flow ? 1 : 0]; };
  for (const BondId bond : part.inner)
    for (const Variable variable : {Variable::effort, Variable::flow}) {
      std::vector<Quantity> open{{bond, variable}};
      bool circle = false;
      while (!open.empty() && !circle) {
        const Quantity top = open.back();
        if (mark(top) != Mark::open) {
          mark(top) = Mark::done;
          open.pop_back();
          continue;
        }
        mark(top) = Mark::entered;
        const PortId port = giver(strokes, top.first, top.second);
        if (!std::binary_search(part.elements.begin(), part.elements.end(), graph_[port].element)) continue;
        computed_from(strokes, port, top.second, [&](BondId other, Variable needed) {
          const Quantity next{other, needed};
          if (mark(next) == Mark::open) open.push_back(next);
          circle = circle || mark(next) == Mark::entered;
        });
      }
      if (circle) return false;
    }
  return true;
}

/// Whether a store in derivative causality would get its effort (or flow) from the rate of a dependent store or from a
/// resistor: strokes that follow each other through a tree never lead there.
bool RankCausality::seems_to_depend(const JunctionPart& part, std::span<const Stroke> strokes, PortId store) const {
  const auto given = [&](PortId port) { return stroke_at(graph_, strokes, port) ? Gives::flow : Gives::effort; };
  if (given(store) == integral(store)) return false;
  std::vector<std::pair<BondId, Variable>> open;
  std::set<std::pair<BondId, Variable>> seen;
  const auto need = [&](BondId bond, Variable variable) {
    if (seen.emplace(bond, variable).second) open.emplace_back(bond, variable);
  };
  need(graph_[store].bond, given(store) == Gives::effort ? Variable::flow : Variable::effort);
  while (!open.empty()) {
    const auto [bond, variable] = open.back();
    open.pop_back();
    const PortId port = giver(strokes, bond, variable);
    if (std::binary_search(part.elements.begin(), part.elements.end(), graph_[port].element)) {
      computed_from(strokes, port, variable, need);
      continue;
    }
    const bool state = is_store(kind(port)) && given(port) == integral(port);
    const StrokeReason reason = strokes[bond.index()].reason;
    if (!state && reason != StrokeReason::source && reason != StrokeReason::one_way_law) return true;
  }
  return false;
}

bool RankCausality::solve(const JunctionPart& part, std::span<const Stroke> strokes,
                          std::vector<Diagnostic>* problems) {
  JunctionRank rank = rank_of(part);
  RankedPart ranked{part, std::vector<Stroke>(part.outer.size()), {}};
  bool possible = true;
  for (const PortId port : by_right(part)) {
    const ElementKind kind = this->kind(port);
    Gives wanted = Gives::effort;
    StrokeReason reason = StrokeReason::free_choice;
    bool fixed = false;
    if (const auto imposed = imposed_variable(kind)) {
      wanted = *imposed == Variable::effort ? Gives::effort : Gives::flow;
      reason = StrokeReason::source;
      fixed = true;
    } else if (!laws_.usable(port, Gives::effort) || !laws_.usable(port, Gives::flow)) {
      wanted = laws_.usable(port, Gives::effort) ? Gives::effort : Gives::flow;
      reason = StrokeReason::one_way_law;
      fixed = true;
    } else if (is_store(kind)) {
      wanted = integral(port);
      reason = StrokeReason::integral;
    } else if (laws_.use(port, Gives::effort) != laws_.use(port, Gives::flow)) {
      wanted = laws_.use(port, Gives::effort) == LawUse::as_written ? Gives::effort : Gives::flow;
      reason = StrokeReason::law_as_written;
    } else if (!strokes.empty()) {
      wanted = stroke_at(graph_, strokes, port) ? Gives::flow : Gives::effort;
    }
    if (!rank.take(rank.variable(port, wanted))) {
      const std::vector<ElementId> from = elements_in(part, rank, rank.determined(rank.variable(port, wanted)));
      if (fixed && problems != nullptr) problems->push_back(contradiction(part, port, wanted, from));
      possible = possible && !fixed;
      if (is_store(kind)) ranked.because[port] = from;
      wanted = other(wanted);
      reason = StrokeReason::by_rank;
      rank.take(rank.variable(port, wanted));
    }
    const auto at = std::lower_bound(part.outer.begin(), part.outer.end(), port) - part.outer.begin();
    const bool head = graph_[port].head == (wanted == Gives::flow);
    ranked.outer[static_cast<std::size_t>(at)] = {
        head ? BondEnd::head : BondEnd::tail, reason, graph_[port].element, {}, 0};
  }
  if (possible) ranked_.push_back(std::move(ranked));
  return possible;
}

/// @param from  the elements that give what determines it.
Diagnostic RankCausality::contradiction(const JunctionPart& part, PortId port, Gives gives,
                                        const std::vector<ElementId>& from) const {
  const Element& element = model_.elements[graph_[port].element.index()];
  const std::string variable = gives == Gives::effort ? "effort" : "flow";
  std::vector<std::string> through, others;
  std::vector<Note> notes;
  for (const bool junctions : {false, true}) {
    if (junctions && !through.empty()) break;
    for (const ElementId id : part.elements) {
      const Element& at = model_.elements[id.index()];
      if (is_junction(at.kind) != junctions) continue;
      through.push_back(in_quotes(at.name));
      if (notes.size() < 3) notes.push_back({at.place, "the ring runs through " + in_quotes(at.name)});
    }
  }
  for (const ElementId id : from) others.push_back(in_quotes(model_.elements[id.index()].name));
  const auto list = [](const std::vector<std::string>& names) {
    constexpr std::size_t kMost = 5;
    std::string text;
    for (std::size_t i = 0; i < names.size() && i < kMost; ++i) text += (i == 0 ? "" : ", ") + names[i];
    return names.size() > kMost ? text + " and " + std::to_string(names.size() - kMost) + " more" : text;
  };
  const std::string what =
      others.empty() ? " leaves no " + variable + " but 0 to " + in_quotes(element.name)
                     : " determines the " + variable + " of " + in_quotes(element.name) + " from " + list(others);
  return diagnostic_of(
      "BG411", "the ring through " + list(through) + what + ", which gives that " + variable + " itself", element.place,
      "what junctions, TF and GY determine no element can set; where they form a ring, the rank of "
      "their equations tells what they determine",
      "correct a modulus or a half-arrow of the ring, or give the ring an R or a store of its own", std::move(notes));
}

}  // namespace bgsim
