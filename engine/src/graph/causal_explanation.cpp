#include "graph/causal_explanation.hpp"

#include <algorithm>
#include <unordered_set>

#include "base/text.hpp"
#include "bgsim/modes.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

// A longer chain shows its beginning and its end.
constexpr std::size_t kLongestChain = 14;

/// Names things of one model and graph.
struct Words {
  const Model& model;
  const BondGraph& graph;
  std::span<const Stroke> strokes;

  const Element& element(ElementId id) const { return model.elements[id.index()]; }
  const std::string& bond(BondId id) const { return model.bonds[id.index()].name; }
  std::string port(PortId id) const {
    const Port& at = graph[id];
    const Element& owner = element(at.element);
    return in_quotes(is_junction(owner.kind) ? owner.name : port_name(owner, at.number));
  }
  std::string kind_and_name(ElementId id) const {
    const Element& at = element(id);
    return kind_words(at) + ' ' + in_quotes(at.name);
  }
  std::string bonds(const std::vector<BondId>& list) const {
    constexpr std::size_t kMost = 4;
    std::string text;
    for (std::size_t i = 0; i < list.size() && i < kMost; ++i) text += (i == 0 ? "" : ", ") + bond(list[i]);
    return list.size() > kMost ? text + " and " + std::to_string(list.size() - kMost) + " more" : text;
  }
  /// The port of @p id at which the bond ends.
  PortId port_at(ElementId id, BondId at) const {
    return graph[graph[at].tail].element == id ? graph[at].tail : graph[at].head;
  }
  std::string given_at(ElementId id, BondId at) const {
    return stroke_at(graph, strokes, port_at(id, at)) ? "flow" : "effort";
  }
  std::string shared(ElementId junction) const {
    return shared_variable(graph.kinds[junction.index()]) == Variable::effort ? "effort" : "flow";
  }
};

std::string forced_text(const Words& words, BondId bond) {
  const Stroke& stroke = words.strokes[bond.index()];
  const ElementKind kind = words.graph.kinds[stroke.element.index()];
  const std::string what = words.kind_and_name(stroke.element);
  if (is_junction(kind)) {
    const std::string shared = words.shared(stroke.element);
    if (stroke.cause.valid()) return what + " has its " + shared + " from " + words.bond(stroke.cause);
    if (words.graph.port_count(stroke.element) == 1) return what + " has no other bond to set its " + shared;
    return "no other bond of " + what + " sets its " + shared;
  }
  const std::string given = words.given_at(stroke.element, bond);
  const std::string taken = !kind_row(kind).crosses ? given : given == "effort" ? "flow" : "effort";
  return what + " turns the " + taken + " of " + words.bond(stroke.cause) + " into the " + given + " of " +
         words.bond(bond);
}

/// One line of a chain: the reason for this stroke.
Note chain_note(const Words& words, BondId bond) {
  const Stroke& stroke = words.strokes[bond.index()];
  const std::string text = words.bond(bond) + ": " + stroke_place_text(words.model, words.graph, words.strokes, bond) +
                           ", because " + stroke_reason_text(words.model, words.graph, words.strokes, bond);
  const bool root = stroke.reason != StrokeReason::propagated;
  return {root ? words.element(stroke.element).place : words.model.bonds[bond.index()].place, text};
}

/// The setter of a junction when it is a root directly at it.
std::optional<Note> direct_setter_note(const Words& words, ElementId junction, BondId bond) {
  const Stroke& stroke = words.strokes[bond.index()];
  if (stroke.reason == StrokeReason::propagated || stroke.element == junction) return std::nullopt;
  const std::string how = stroke.reason == StrokeReason::source ? ""
                          : stroke.reason == StrokeReason::one_way_law
                              ? ", whose law can be used in this direction only,"
                          : stroke.reason == StrokeReason::integral ? ", in integral causality,"
                                                                    : "";
  return Note{words.element(stroke.element).place,
              words.kind_and_name(stroke.element) + how + " sets it through bond " + words.bond(bond)};
}

std::vector<Note> chain_notes(const Words& words, const CausalConflict& conflict) {
  std::vector<Note> notes;
  for (const BondId bond : strokes_behind(words.graph, words.strokes, conflict.bonds)) {
    std::optional<Note> direct;
    if (conflict.kind == CausalConflict::Kind::two_set &&
        std::find(conflict.bonds.begin(), conflict.bonds.end(), bond) != conflict.bonds.end())
      direct = direct_setter_note(words, conflict.element, bond);
    notes.push_back(direct ? std::move(*direct) : chain_note(words, bond));
  }
  if (notes.size() > kLongestChain) {
    const std::size_t left_out = notes.size() - kLongestChain + 1;
    const auto first = notes.begin() + static_cast<std::ptrdiff_t>(kLongestChain / 2);
    *first = {std::nullopt, "... and " + std::to_string(left_out) + " more strokes, each forced by those before ..."};
    notes.erase(first + 1, first + static_cast<std::ptrdiff_t>(left_out));
  }
  return notes;
}

/// The sources among the roots of a conflict, last assigned first.
std::vector<ElementId> sources_behind(const Words& words, const std::vector<BondId>& bonds) {
  std::vector<ElementId> sources;
  for (const BondId bond : strokes_behind(words.graph, words.strokes, bonds))
    if (words.strokes[bond.index()].reason == StrokeReason::source)
      sources.push_back(words.strokes[bond.index()].element);
  std::reverse(sources.begin(), sources.end());
  return sources;
}

std::string help_for_junction(const Words& words, const CausalConflict& conflict, const std::string& shared) {
  const std::vector<ElementId> sources = sources_behind(words, conflict.bonds);
  const bool effort = shared == "effort";
  const std::string fix = effort ? "put an R on a 1-junction in series with " : "put an R on a 0-junction beside ";
  const auto is_contact = [&](ElementId id) { return words.element(id).contact.has_value(); };
  if (std::count_if(sources.begin(), sources.end(), is_contact) > 1)
    return effort ? "between contacts in series a mass is needed, which says how they share their way"
                  : "between contacts that hold one thing from both sides something has to give way: a spring, or room";
  if (!sources.empty()) {
    const Element& last = words.element(sources.front());
    const std::string instead = imposed_variable(last.kind) == Variable::effort ? "an Sf" : "an Se";
    return fix + in_quotes(last.name) + ", or make " +
           (sources.size() > 1 ? "one source " : in_quotes(last.name) + " ") + instead;
  }
  return "put an R, or a C or I without a one-way law, between the elements that set the " + shared;
}

Diagnostic explain_junction(const Words& words, const CausalConflict& conflict) {
  const std::string shared = words.shared(conflict.element);
  const std::string what = words.kind_and_name(conflict.element);
  const bool zero = shared == "effort";
  Diagnostic problem;
  problem.place = words.element(conflict.element).place;
  if (conflict.kind == CausalConflict::Kind::two_set) {
    const std::size_t count = conflict.bonds.size();
    problem.code = zero ? "BG301" : "BG302";
    problem.situation = (count == 2 ? "two" : std::to_string(count)) + " bonds set the " + shared + " of " + what;
    problem.help = help_for_junction(words, conflict, shared);
  } else {
    problem.code = "BG303";
    problem.situation = "no bond sets the " + shared + " of " + what;
    problem.help = "bond a C, an R or " + std::string(zero ? "an Se" : "an I or Sf") + " to " +
                   in_quotes(words.element(conflict.element).name) + ", which can set its " + shared;
  }
  problem.rule = zero ? "a 0-junction has one effort, so exactly one of its bonds carries the causal stroke at the "
                        "junction"
                      : "a 1-junction has one flow, so exactly one of its bonds carries no causal stroke at the "
                        "junction";
  return problem;
}

Diagnostic explain_two_port(const Words& words, const CausalConflict& conflict) {
  const ElementId id = conflict.element;
  const std::string name = in_quotes(words.element(id).name);
  const bool crosses = kind_row(words.graph.kinds[id.index()]).crosses;
  const auto given = [&](std::size_t i) { return words.given_at(id, conflict.bonds[i]); };
  // The element gives one variable at a port and receives the other.
  const auto received = [&](std::size_t i) { return std::string(given(i) == "effort" ? "flow" : "effort"); };
  return {.code = "BG304",
          .situation = words.kind_and_name(id) + " receives the " + received(0) + " of " +
                       words.bond(conflict.bonds[0]) + " and the " + received(1) + " of " +
                       words.bond(conflict.bonds[1]) + ", but its rule relates the two",
          .place = words.element(id).place,
          .notes = {},
          .rule = crosses ? "a GY relates the effort of each bond to the flow of the other, so both or none of its "
                            "bonds carry the causal stroke at it"
                          : "a TF relates its two efforts and its two flows, so exactly one of its two bonds "
                            "carries the causal stroke at it",
          .help = "put an R between " + name + " and one of the elements named above"};
}

Diagnostic explain_two_sources(const Words& words, const CausalConflict& conflict, ElementId first) {
  const bool effort = imposed_variable(words.graph.kinds[conflict.element.index()]) == Variable::effort;
  const std::string shared = effort ? "effort" : "flow";
  return {.code = effort ? "BG301" : "BG302",
          .situation = shared + " sources " + in_quotes(words.element(first).name) + " and " +
                       in_quotes(words.element(conflict.element).name) + " both set the " + shared + " of bond " +
                       in_quotes(words.bond(conflict.bonds.front())),
          .place = words.element(conflict.element).place,
          .notes = {},
          .rule = "a bond has one " + shared,
          .help = effort ? "put a 1-junction with an R between them, or make one of them an Sf"
                         : "put a 0-junction with an R between them, or make one of them an Se"};
}

Diagnostic explain_law(const Words& words, const CausalConflict& conflict) {
  const Port& port = words.graph[conflict.port];
  const Element& element = words.element(port.element);
  const std::string asked = words.given_at(port.element, port.bond);
  const std::string opposite = asked == "effort" ? "flow" : "effort";
  Place place = element.coefficient_place;
  for (const Law& law : element.laws)
    if (law.port == port.number) place = law.place;
  const std::string name = in_quotes(is_junction(element.kind) ? element.name : port_name(element, port.number));
  return {.code = "BG305",
          .situation = "the law of " + name + " cannot give its " + asked + ", which causality requires",
          .place = place,
          .notes = {},
          .rule =
              "a law that cannot be solved for the other variable (a jump, a kink, or the variable does not occur) "
              "fixes the causality of its port",
          .help = "write the law so that it gives the " + asked +
                  ", or put a C, I or R at the junction that can give " + name + " its " + opposite};
}

}  // namespace

std::vector<BondId> direct_causes(const BondGraph& graph, std::span<const Stroke> strokes, BondId bond) {
  const Stroke& stroke = strokes[bond.index()];
  if (stroke.reason != StrokeReason::propagated) return {};
  if (stroke.cause.valid()) return {stroke.cause};
  std::vector<BondId> others;
  for (std::size_t number = 0; number < graph.port_count(stroke.element); ++number) {
    const BondId other = graph[graph.port(stroke.element, number)].bond;
    if (other != bond) others.push_back(other);
  }
  return others;
}

std::vector<BondId> strokes_behind(const BondGraph& graph, std::span<const Stroke> strokes, std::vector<BondId> bonds) {
  std::unordered_set<BondId> seen(bonds.begin(), bonds.end());
  for (std::size_t i = 0; i < bonds.size(); ++i)
    for (const BondId cause : direct_causes(graph, strokes, bonds[i]))
      if (seen.insert(cause).second) bonds.push_back(cause);
  std::sort(bonds.begin(), bonds.end(),
            [&](BondId a, BondId b) { return strokes[a.index()].order < strokes[b.index()].order; });
  return bonds;
}

std::string stroke_place_text(const Model& model, const BondGraph& graph, std::span<const Stroke> strokes,
                              BondId bond) {
  const Bond& at = graph[bond];
  const Words words{model, graph, strokes};
  return "stroke at " + words.port(strokes[bond.index()].end == BondEnd::head ? at.head : at.tail);
}

std::string stroke_reason_text(const Model& model, const BondGraph& graph, std::span<const Stroke> strokes,
                               BondId bond) {
  const Stroke& stroke = strokes[bond.index()];
  const Words words{model, graph, strokes};
  const Element& element = words.element(stroke.element);
  const std::string port = words.port(words.port_at(stroke.element, bond));
  switch (stroke.reason) {
    case StrokeReason::source:
      if (element.idle)
        return in_quotes(element.name) + " is " + (is_closed(element) ? "closed" : "open") +
               " and idle: other switches set what it would";
      return in_quotes(element.name) + (kind_words(element).find_first_of("eo") == 0 ? " is an " : " is a ") +
             kind_words(element);
    case StrokeReason::one_way_law:
      return "the law of " + port + " can give its " + words.given_at(stroke.element, bond) + " only";
    case StrokeReason::zero_modulus:
      return "the modulus of " + in_quotes(element.name) + " is 0 at the start: nothing is divided by it";
    case StrokeReason::integral:
      return port + " is in integral causality";
    case StrokeReason::law_as_written:
      return "the law of " + port + " is used as written";
    case StrokeReason::free_choice:
      return "it was free to choose";
    case StrokeReason::by_elimination:
      return "the other end leads to a conflict (tried for " + port + ")";
    case StrokeReason::by_rank:
      return "the equations of the ring at " + port + " leave nothing else";
    case StrokeReason::propagated:
      return forced_text(words, bond);
  }
  return {};
}

Diagnostic explain_conflict(const Model& model, const BondGraph& graph, std::span<const Stroke> strokes,
                            const CausalConflict& conflict) {
  const Words words{model, graph, strokes};
  Diagnostic problem;
  switch (conflict.kind) {
    case CausalConflict::Kind::two_set:
    case CausalConflict::Kind::none_sets:
      problem = explain_junction(words, conflict);
      break;
    case CausalConflict::Kind::two_port:
      problem = explain_two_port(words, conflict);
      break;
    case CausalConflict::Kind::one_port: {
      const ElementKind kind = graph.kinds[conflict.element.index()];
      const bool source = imposed_variable(kind).has_value();
      const Stroke& stroke = strokes[conflict.bonds.front().index()];
      problem = source ? explain_two_sources(words, conflict, stroke.element) : explain_law(words, conflict);
      break;
    }
  }
  problem.notes = chain_notes(words, conflict);
  return problem;
}

}  // namespace bgsim
