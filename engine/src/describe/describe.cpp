#include "bgsim/describe.hpp"

#include <algorithm>
#include <array>

#include "base/text_rows.hpp"
#include "bgsim/text.hpp"
#include "graph/causal_explanation.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

using Findings = std::vector<Finding>;

void add(Findings& findings, std::string heading, std::vector<TextRow> rows, bool new_section = false) {
  if (rows.empty()) return;
  Finding finding{std::move(heading), std::move(rows), 0, new_section};
  if (finding.rows.size() > kMostLines) {
    finding.more = finding.rows.size() - kMostLines;
    finding.rows.resize(kMostLines);
  }
  findings.push_back(std::move(finding));
}

/// The heading, then the rows, whose second column is aligned.
std::string text_of(const Finding& finding) {
  std::string text = (finding.new_section ? "\n" : "") + finding.heading + "\n";
  std::size_t width = 0;
  for (const auto& [left, right] : finding.rows)
    if (left.size() <= kWidestColumn) width = std::max(width, left.size());
  for (const auto& [left, right] : finding.rows) {
    text += "  " + visible_line(left);
    if (!right.empty())
      text += std::string(left.size() < width ? width - left.size() : 0, ' ') + "  " + visible_line(right);
    text += "\n";
  }
  if (finding.more > 0) text += "  ... and " + std::to_string(finding.more) + " more\n";
  return text;
}

struct View {
  const Model& model;
  const BondGraph& graph;
  const CausalGraph& causal;

  const Element& element(ElementId id) const { return model.elements[id.index()]; }
  const Stroke& stroke(BondId id) const { return causal.strokes[id.index()]; }
  const std::string& bond(BondId id) const { return model.bonds[id.index()].name; }
  std::string port(PortId id) const {
    const Element& owner = element(graph[id].element);
    return is_junction(owner.kind) ? owner.name : port_name(owner, graph[id].number);
  }
  /// `b3: inlet --->| packet.air`: the half-arrow from tail to head, the bar at the end where effort acts.
  std::string arrow(BondId id) const {
    const bool at_head = stroke(id).end == BondEnd::head;
    return bond(id) + ": " + port(graph[id].tail) + (at_head ? " --->| " : " |---> ") + port(graph[id].head);
  }
  std::string stored(ElementId id, std::size_t number) const {
    const Element& store = element(id);
    return port_name(store, number) + (stores_displacement(store, number) ? ".q" : ".p");
  }
};

std::size_t integrals(const Model& model) {
  return static_cast<std::size_t>(std::count_if(model.signals.begin(), model.signals.end(),
                                                [](const Signal& signal) { return signal.is_state(); }));
}

void describe_counts(Findings& findings, const View& view) {
  const auto junctions = static_cast<std::size_t>(std::count_if(view.graph.kinds.begin(), view.graph.kinds.end(),
                                                                [](ElementKind kind) { return is_junction(kind); }));
  findings.push_back({"model \"" + short_name(view.model.name) +
                          "\": " + plural(view.graph.kinds.size() - junctions, "element", "elements") + " and " +
                          plural(junctions, "junction", "junctions") + ", " +
                          plural(view.graph.bonds.size(), "bond", "bonds"),
                      {}});
  findings.push_back(
      {plural(view.causal.integral.size() + integrals(view.model), "state", "states") + ", " +
           plural(view.causal.dependent.size(), "dependent store", "dependent stores") + ", " +
           plural(view.causal.free_choices.size(), "free choice of a stroke", "free choices of a stroke"),
       {}});
}

void describe_strokes(Findings& findings, const View& view) {
  const bool detectors = std::any_of(view.graph.kinds.begin(), view.graph.kinds.end(), is_detector);
  const std::array<std::pair<StrokeReason, const char*>, 9> groups{
      {{StrokeReason::source, detectors ? "strokes fixed by sources and detectors" : "strokes fixed by sources"},
       {StrokeReason::one_way_law, "strokes fixed by laws that can be used in one direction only"},
       {StrokeReason::zero_modulus, "strokes chosen: moduli that are 0 at the start multiply"},
       {StrokeReason::integral, "strokes chosen: stores in integral causality"},
       {StrokeReason::law_as_written, "strokes chosen: laws used as written"},
       {StrokeReason::free_choice, "strokes chosen freely"},
       {StrokeReason::by_elimination, "strokes left over: the other end leads to a conflict"},
       {StrokeReason::by_rank, "strokes in rings of junctions, from the rank of their equations"},
       {StrokeReason::propagated, "strokes that follow"}}};
  std::vector<BondId> order(view.causal.strokes.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[view.causal.strokes[i].order] = BondId(i);
  findings.push_back({"the bar | is where effort acts on the element, > is the half-arrow", {}, 0, true});
  for (const auto& [reason, heading] : groups) {
    std::vector<TextRow> rows;
    for (const BondId bond : order)
      if (view.stroke(bond).reason == reason)
        rows.emplace_back(view.arrow(bond), rows.size() < kMostLines && reason != StrokeReason::free_choice
                                                ? stroke_reason_text(view.model, view.graph, view.causal.strokes, bond)
                                                : std::string());
    add(findings, heading, std::move(rows));
  }
}

void describe_states(Findings& findings, const View& view) {
  std::vector<TextRow> states;
  for (const PortId port : view.causal.integral)
    states.emplace_back(view.stored(view.graph[port].element, view.graph[port].number),
                        kind_text(view.element(view.graph[port].element).kind, false));
  for (const Signal& signal : view.model.signals)
    if (signal.is_state()) states.emplace_back(signal.name, "integral");
  if (states.empty())
    findings.push_back({"states: none", {}, 0, true});
  else
    add(findings, "states", std::move(states), true);
  std::vector<TextRow> dependent;
  for (const DependentPort& port : view.causal.dependent) {
    std::vector<std::string> because;
    for (const ElementId id : port.because) because.push_back('"' + view.element(id).name + '"');
    dependent.emplace_back(view.stored(port.element, port.port), because.empty()
                                                                     ? std::string("the structure leaves it no choice")
                                                                     : "is determined by " + join(because, port.more));
  }
  add(findings, "dependent stores (derivative causality): no states of their own", std::move(dependent));
}

void describe_free_choices(Findings& findings, const View& view) {
  std::vector<TextRow> rows;
  for (const FreeChoice& choice : view.causal.free_choices) {
    std::vector<std::string> through;
    for (const ElementId id : choice.path) through.push_back('"' + view.element(id).name + '"');
    rows.emplace_back(view.bond(choice.bond), "decides the strokes at " + join(through));
  }
  add(findings, "algebraic loops run through the bonds whose strokes were free", std::move(rows));
}

/// Nonlinear laws that are not used as they stand.
void describe_laws(Findings& findings, const View& view) {
  std::vector<TextRow> rows;
  for (std::size_t i = 0; i < view.graph.ports.size(); ++i) {
    const Port& port = view.graph.ports[i];
    const Element& element = view.element(port.element);
    if (element.laws.empty() && !element.energy.valid()) continue;
    const LawUse use = view.causal.laws[i].solved.use;
    const std::string given = view.causal.gives(view.graph, PortId(i)) == Gives::effort ? "effort" : "flow";
    if (use == LawUse::inverted) rows.emplace_back(port_name(element, port.number), "inverted, to give its " + given);
    if (use == LawUse::implicit)
      rows.emplace_back(port_name(element, port.number), "solved numerically during the run, to give its " + given);
  }
  add(findings, "laws not used as written", std::move(rows), true);
}

std::string verdict_text(const Reciprocity& test) {
  switch (test.verdict) {
    case Reciprocity::Verdict::by_energy:
      return "reciprocal by construction: its laws are derived from its energy";
    case Reciprocity::Verdict::proved:
      return "reciprocal: its cross derivatives are equal";
    case Reciprocity::Verdict::sampled:
      return "reciprocal as far as tested: its cross derivatives agree at random points";
    case Reciprocity::Verdict::violated:
      return "NOT reciprocal: " + test.text;
    case Reciprocity::Verdict::untested:
      return "reciprocity not tested: " + test.text;
  }
  return {};
}

void describe_fields(Findings& findings, const View& view) {
  std::vector<TextRow> rows;
  for (const FieldTest& field : view.causal.fields)
    rows.emplace_back(view.element(field.element).name, verdict_text(field.reciprocity));
  add(findings, "fields", std::move(rows), true);
}

void describe_parts(Findings& findings, const View& view) {
  const auto parts = connected_parts(view.graph);
  if (parts.size() < 2) return;
  std::vector<TextRow> rows;
  for (const auto& part : parts) {
    std::vector<std::string> names;
    for (const ElementId id : part) names.push_back(view.element(id).name);
    rows.emplace_back(join(names), "");
  }
  add(findings, "the graph falls into " + std::to_string(parts.size()) + " parts that no bond connects",
      std::move(rows), true);
}

/// Half-arrows against the custom, where a bond's variables and an element's have opposite signs.
void describe_half_arrows(Findings& findings, const View& view) {
  std::vector<TextRow> rows;
  for (const Port& port : view.graph.ports) {
    const Element& element = view.element(port.element);
    if (!is_passive(element.kind) || port.head) continue;
    const std::string name = port_name(element, port.number);
    const std::string& bond = view.bond(port.bond);
    std::string leaves = bond, meaning = name;
    leaves.append(" leaves ").append(name);
    meaning.append(".f is counted into the element: ").append(name).append(".f = -").append(bond).append(".f");
    rows.emplace_back(std::move(leaves), std::move(meaning));
  }
  add(findings, "half-arrows that leave a passive element", std::move(rows), true);
}

}  // namespace

std::vector<Finding> causal_findings(const Model& model, const BondGraph& graph, const CausalGraph& causal) {
  const View view{model, graph, causal};
  Findings findings;
  describe_counts(findings, view);
  describe_strokes(findings, view);
  describe_states(findings, view);
  describe_free_choices(findings, view);
  describe_laws(findings, view);
  describe_fields(findings, view);
  describe_parts(findings, view);
  describe_half_arrows(findings, view);
  return findings;
}

std::string describe_causality(const Model& model, const BondGraph& graph, const CausalGraph& causal) {
  std::string text;
  for (const Finding& finding : causal_findings(model, graph, causal)) text += text_of(finding);
  return text;
}

}  // namespace bgsim
