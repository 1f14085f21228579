// The first three stages' values as text, one line per item, for `bgsim show`.

#include "base/text.hpp"
#include "bgsim/describe.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"
#include "graph/causal_explanation.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

/// Writes the expressions of one model.
struct Writer {
  const Model& model;

  std::string operator()(ExprId id) const {
    return readable_text(model.pool, id, [this](SymbolId symbol) { return symbol_name(model, symbol); });
  }
};

std::string with_unit(const std::string& unit) { return unit.empty() ? "" : " [" + unit + "]"; }

std::string show_element(const Model& model, const Element& element) {
  const Writer write{model};
  std::string text = "element " + element.name + ": " + kind_text(element.kind, element.modulated);
  if (element.ports.size() > 1) {
    text += " (";
    for (std::size_t port = 0; port < element.ports.size(); ++port)
      text += (port == 0 ? "" : ", ") + element.ports[port] +
              (element.stored.empty() ? "" : std::string(": ") + letter(element.stored[port]));
    text += ")";
  }
  if (element.switches) {
    text += ", " + side_text(element, is_closed(element));
    text += ", closes if " + write(element.switches->closes) + ", opens if " + write(element.switches->opens);
  } else if (element.contact) {
    text += ", " + side_text(element, is_closed(element)) + ", gap " + write(element.coefficient);
    text += ", restitution " + write(element.contact->restitution);
  } else if (element.diode) {
    text += ", " + side_text(element, is_closed(element)) + ", passes " + (element.diode->out ? "out" : "in");
    if (!model.pool.is_constant(element.coefficient, 0.0)) text += ", threshold " + write(element.coefficient);
    if (element.diode->fire.valid()) text += ", fires if " + write(element.diode->fire);
  } else if (element.coefficient.valid())
    text += ", " + coefficient_words(element) + " " + write(element.coefficient);
  if (element.energy.valid()) text += ", energy " + write(element.energy);
  for (const Law& law : element.laws)
    text += ", " + (law.zero ? "0" : symbol_name(model, port_variable(element, law.port, law.variable))) + " = " +
            write(law.right);
  for (const InitialValue& initial : element.initial)
    text +=
        ", initially " + port_name(element, initial.port) + "." +
        letter(initial.conjugate ? conjugate_variable(element, initial.port) : stored_variable(element, initial.port)) +
        " = " + write(initial.value);
  if (element.priority != 0.0) text += ", priority " + shortest_number(element.priority);
  return visible_line(text) + "\n";
}

std::string show_event(const Model& model, const ModelEvent& event) {
  const Writer write{model};
  std::string text = "event " + event.name + ": when " + write(event.when) + " set ";
  for (const ModelEvent::Set& set : event.sets) {
    const Element* store = set.signal.valid() ? nullptr : &model.elements[set.element.index()];
    text += (&set == event.sets.data() ? "" : ", ") +
            (store == nullptr ? model.signals[set.signal.index()].name
                              : port_name(*store, set.port) + "." + letter(stored_variable(*store, set.port))) +
            " = " + write(set.value);
  }
  if (event.priority != 0.0) text += ", priority " + shortest_number(event.priority);
  return visible_line(text) + "\n";
}

std::string show_scene(const Model& model, const Scene& scene) {
  const Writer write{model};
  std::string text = "scene " + scene.name + ":";
  if (scene.start.valid()) text += " start " + write(scene.start) + ",";
  text += " stop " + write(scene.stop);
  if (scene.samples) text += ", samples " + std::to_string(*scene.samples);
  if (scene.interval.valid()) text += ", interval " + write(scene.interval);
  if (scene.log_samples) text += ", samples " + std::to_string(*scene.log_samples) + " by logarithm";
  if (scene.log_from.valid()) text += " from " + write(scene.log_from);
  for (std::size_t i = 0; i < scene.times.size(); ++i)
    text += (i == 0 ? ", times " : " ") + write(scene.times[i].first);
  for (const auto& [name, value] : scene.parameters) text += ", " + name + " = " + write(value.first);
  for (const auto& [name, value] : scene.initial) text += ", initially " + name + " = " + write(value.first);
  for (const std::string& output : scene.outputs) text += ", output " + output;
  if (scene.relative) text += ", relative " + shortest_number(*scene.relative);
  if (scene.absolute) text += ", absolute " + shortest_number(*scene.absolute);
  for (const auto& [name, value] : scene.absolute_by_state)
    text += ", absolute of " + name + " " + shortest_number(value);
  if (scene.method != Method::automatic) text += ", method " + method_name(scene.method);
  if (scene.step) text += ", step " + shortest_number(*scene.step);
  if (scene.max_order) text += ", max_order " + std::to_string(*scene.max_order);
  if (scene.reference) text += ", reference " + scene.reference->file;
  return visible_line(text) + "\n";
}

std::string end_text(const Model& model, const BondEndText& end) {
  const Element& element = model.elements[end.element.index()];
  return end.port && element.ports.size() > 1 ? port_name(element, *end.port) : element.name;
}

std::string port_text(const Model& model, const BondGraph& graph, PortId id) {
  const Element& element = model.elements[graph[id].element.index()];
  return is_junction(element.kind) ? element.name : port_name(element, graph[id].number);
}

std::string reason_word(StrokeReason reason) {
  switch (reason) {
    case StrokeReason::source:
      return "source";
    case StrokeReason::one_way_law:
      return "one-way law";
    case StrokeReason::zero_modulus:
      return "modulus 0 at start";
    case StrokeReason::integral:
      return "integral";
    case StrokeReason::law_as_written:
      return "law as written";
    case StrokeReason::free_choice:
      return "free choice";
    case StrokeReason::by_elimination:
      return "by elimination";
    case StrokeReason::by_rank:
      return "by rank";
    case StrokeReason::propagated:
      return "propagated";
  }
  return {};
}

}  // namespace

std::string show_model(const Model& model) {
  const Writer write{model};
  std::string text;
  const auto line = [&text](const std::string& raw) { text += visible_line(raw) + "\n"; };
  line("model " + model.name);
  for (const Parameter& parameter : model.parameters)
    line("parameter " + parameter.name + " = " + write(parameter.value) + with_unit(parameter.unit));
  for (const Signal& signal : model.signals)
    line("signal " + signal.name + (signal.is_state() ? "' = " : " = ") + write(signal.value) +
         (signal.initial.valid() ? ", initially " + write(signal.initial) : "") + with_unit(signal.unit));
  for (const Element& element : model.elements) text += show_element(model, element);
  for (const ModelBond& bond : model.bonds)
    text += "bond " + bond.name + ": " + end_text(model, bond.from) + " -> " + end_text(model, bond.to) + "\n";
  for (const ModelEvent& event : model.events) text += show_event(model, event);
  for (const Output& output : model.outputs)
    line("output " + output.name + " = " + write(output.value) + with_unit(output.unit));
  for (const Scene& scene : model.scenes) text += show_scene(model, scene);
  return text;
}

std::string show_graph(const Model& model, const BondGraph& graph) {
  std::string text;
  for (std::size_t i = 0; i < graph.kinds.size(); ++i) {
    const Element& element = model.elements[i];
    text += "element " + element.name + ": " + kind_text(element.kind, element.modulated) + ", ports";
    for (std::size_t number = 0; number < graph.port_count(ElementId(i)); ++number) {
      const Port& port = graph[graph.port(ElementId(i), number)];
      const std::string name = is_junction(element.kind) || element.ports.size() < 2 ? "" : element.ports[number] + " ";
      text += (number == 0 ? " " : ", ") + name + (port.head ? "<- " : "-> ") + model.bonds[port.bond.index()].name;
    }
    text += "\n";
  }
  for (std::size_t i = 0; i < graph.bonds.size(); ++i)
    text += "bond " + model.bonds[i].name + ": " + port_text(model, graph, graph.bonds[i].tail) + " -> " +
            port_text(model, graph, graph.bonds[i].head) + "\n";
  return text;
}

std::string show_causality(const Model& model, const BondGraph& graph, const CausalGraph& causal) {
  std::string text;
  for (std::size_t i = 0; i < causal.strokes.size(); ++i) {
    const Stroke& stroke = causal.strokes[i];
    text += "stroke " + model.bonds[i].name + ": " + port_text(model, graph, graph.bonds[i].tail) +
            (stroke.end == BondEnd::head ? " --->| " : " |---> ") + port_text(model, graph, graph.bonds[i].head) +
            ", place " + std::to_string(stroke.order + 1) + ", " + reason_word(stroke.reason) + " " +
            model.elements[stroke.element.index()].name;
    if (stroke.cause.valid()) text += ", from " + model.bonds[stroke.cause.index()].name;
    text += "\n";
  }
  for (const PortId port : causal.integral) text += "integral " + port_text(model, graph, port) + "\n";
  for (const DependentPort& dependent : causal.dependent) {
    text += "dependent " + port_name(model.elements[dependent.element.index()], dependent.port) + ", because of";
    for (const ElementId id : dependent.because) text += " " + model.elements[id.index()].name;
    text += dependent.more ? " and others\n" : "\n";
  }
  for (const FreeChoice& choice : causal.free_choices) {
    text += "free " + model.bonds[choice.bond.index()].name + ", decides";
    for (const ElementId id : choice.path) text += " " + model.elements[id.index()].name;
    text += "\n";
  }
  return text;
}

}  // namespace bgsim
