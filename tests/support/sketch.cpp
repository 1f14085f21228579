#include "support/sketch.hpp"

#include <map>
#include <sstream>

#include "model/constitutive.hpp"

namespace bgsim::test {

namespace {

std::string coefficient_key(const std::string& kind) {
  static const std::map<std::string, std::string> keys{
      {"Se", "effort"},     {"MSe", "effort"},    {"Sf", "flow"},        {"MSf", "flow"},    {"R", "resistance"},
      {"MR", "resistance"}, {"C", "capacitance"}, {"MC", "capacitance"}, {"I", "inertance"}, {"MI", "inertance"},
      {"TF", "modulus"},    {"MTF", "modulus"},   {"GY", "modulus"},     {"MGY", "modulus"}};
  const auto found = keys.find(kind);
  return found == keys.end() ? "" : found->second;
}

}  // namespace

std::string sketch(const std::string& elements, const std::string& bonds, const std::string& more_elements) {
  std::string json = R"({"bgsim": 1, "name": "sketch", "elements": {)";
  std::istringstream words(elements);
  std::string separator, word;
  while (words >> word) {
    const std::size_t colon = word.find(':'), equals = word.find('=');
    const std::string kind = word.substr(0, colon);
    const std::string name = word.substr(colon + 1, equals == std::string::npos ? equals : equals - colon - 1);
    json += separator + "\n  \"" + name + R"(": {"kind": ")" + kind + '"';
    const std::string key = coefficient_key(kind);
    if (!key.empty())
      json += ", \"" + key + "\": " + (equals == std::string::npos ? std::string("1") : word.substr(equals + 1));
    json += "}";
    separator = ",";
  }
  if (!more_elements.empty()) json += separator + "\n  " + more_elements;
  json += "},\n \"bonds\": [";
  separator.clear();
  std::istringstream arrows(bonds);
  while (arrows >> word) {
    const std::size_t arrow = word.find('>');
    json += separator + "\n  {\"from\": \"" + word.substr(0, arrow) + R"(", "to": ")" + word.substr(arrow + 1) + "\"}";
    separator = ",";
  }
  return json + "]}\n";
}

Stages::Stages(const std::string& json)
    : study(Study::from_text(json, "sketch.json")),
      model(study.model()),
      graph(study.graph()),
      causal(study.causality()) {}

ElementId Stages::element(const std::string& name) const {
  for (std::size_t i = 0; i < model.elements.size(); ++i)
    if (model.elements[i].name == name) return ElementId(i);
  throw std::runtime_error("no element " + name);
}

std::string Stages::stroke(const std::string& bond) const {
  for (std::size_t i = 0; i < model.bonds.size(); ++i)
    if (model.bonds[i].name == bond) return causal.strokes[i].end == BondEnd::head ? "at head" : "at tail";
  throw std::runtime_error("no bond " + bond);
}

std::string Stages::stroke_at(const std::string& bond) const {
  const bool head = stroke(bond) == "at head";
  for (std::size_t i = 0; i < model.bonds.size(); ++i)
    if (model.bonds[i].name == bond)
      return model.elements[graph[head ? graph.bonds[i].head : graph.bonds[i].tail].element.index()].name;
  return {};
}

std::string Stages::states() const {
  std::string text;
  for (const PortId port : causal.integral)
    text += (text.empty() ? "" : " ") + port_name(model.elements[graph[port].element.index()], graph[port].number);
  return text;
}

std::string Stages::dependent() const {
  std::string text;
  for (const DependentPort& port : causal.dependent)
    text += (text.empty() ? "" : " ") + port_name(model.elements[port.element.index()], port.port);
  return text;
}

std::string broken_rule(const Model& model, const BondGraph& graph, const std::vector<Stroke>& strokes) {
  for (std::size_t i = 0; i < graph.kinds.size(); ++i) {
    const ElementId id(i);
    std::size_t here = 0;
    bool laws_usable = true;
    for (std::size_t number = 0; number < graph.port_count(id); ++number) {
      const Port& port = graph[graph.port(id, number)];
      const bool stroke_here = (strokes[port.bond.index()].end == BondEnd::head) == port.head;
      if (stroke_here) ++here;
      if (!is_junction(graph.kinds[i]) &&
          law_use(model, id, number, stroke_here ? Gives::flow : Gives::effort) == LawUse::impossible)
        laws_usable = false;
    }
    const std::size_t count = graph.port_count(id);
    const bool kept = [&] {
      switch (graph.kinds[i]) {
        case ElementKind::zero_junction:
          return here == 1;
        case ElementKind::one_junction:
          return here == count - 1;
        case ElementKind::transformer:
          return here == 1;
        case ElementKind::gyrator:
          return here != 1;
        default:
          return laws_usable;
      }
    }();
    if (!kept) return model.elements[i].name;
  }
  return {};
}

namespace {

std::vector<Diagnostic> diagnostics_of(const std::string& json) {
  try {
    const Stages stages(json);
  } catch (const ModelError& error) {
    return error.diagnostics;
  }
  return {};
}

}  // namespace

std::string problems_of(const std::string& json) {
  std::string codes;
  for (const Diagnostic& problem : diagnostics_of(json)) codes += (codes.empty() ? "" : " ") + problem.code;
  return codes;
}

std::string messages_of(const std::string& json) {
  try {
    const Stages stages(json);
  } catch (const ModelError& error) {
    return render(error);
  }
  return {};
}

}  // namespace bgsim::test
