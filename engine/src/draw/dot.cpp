// The drawing in Graphviz's language, for those who want to work on it there.
#include <algorithm>
#include <map>

#include "bgsim/text.hpp"
#include "draw/plan.hpp"

namespace bgsim {

namespace {

/// Characters of a text. Graphviz reads no string of more than 16384 bytes; a visible character takes five at most
/// ("&amp;").
constexpr std::size_t kLongest = 3000;

/// A text that Graphviz takes as it is: in quotes, without escapes (\N, \l) and entities (&lt;), in one line.
std::string dot_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : short_line(visible_line(text), kLongest)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
    if (c == '&') out += "amp;";
  }
  return out + '"';
}

struct DotWriter {
  const Model& model;
  const DrawnCausality& causality;

  /// What the element is called in the file: its name, with its number where only the name's ends are shown.
  std::string identifier(ElementId element) const {
    const std::string name = visible_line(model.elements[element.index()].name);
    return dot_string(character_count(name) <= kLongest ? name : name + " #" + std::to_string(element.index()));
  }

  std::string node(std::size_t i) const {
    const Element& element = model.elements[i];
    const bool faulty =
        std::find(causality.faulty.begin(), causality.faulty.end(), ElementId(i)) != causality.faulty.end();
    return identifier(ElementId(i)) + " [label=" +
           dot_string(kind_text(element.kind, element.modulated) + (is_junction(element.kind) ? "  " : " : ") +
                      local_name(element.name)) +
           (faulty ? ", fontcolor=red" : "") + "];\n";
  }

  /// "teelvee": the stroke at the end, half an arrow behind it.
  std::string bond(std::size_t i) const {
    const ModelBond& at = model.bonds[i];
    const auto holds = [&](const std::vector<BondId>& list) {
      return std::find(list.begin(), list.end(), BondId(i)) != list.end();
    };
    const auto& stroke = causality.strokes[i];
    const auto detects = [&](ElementId element) { return is_detector(model.elements[element.index()].kind); };
    if (detects(at.from.element) || detects(at.to.element))
      return identifier(at.from.element) + " -> " + identifier(at.to.element) +
             " [label=" + dot_string(local_name(at.name)) +
             (detects(at.from.element) ? ", arrowhead=none, arrowtail=vee];\n" : ", arrowhead=vee, arrowtail=none];\n");
    std::string text = identifier(at.from.element) + " -> " + identifier(at.to.element) +
                       " [label=" + dot_string(local_name(at.name)) +
                       ", arrowhead=" + (stroke == BondEnd::head ? "teervee" : "rvee") +
                       ", arrowtail=" + (stroke == BondEnd::tail ? "tee" : "none");
    if (holds(causality.dependent)) text += ", color=\"#c2410c\"";
    if (holds(causality.free)) text += ", color=\"#1d4ed8\"";
    return text + "];\n";
  }
};

}  // namespace

std::string drawing_dot(const Model& model, const DrawnCausality& causality) {
  const DotWriter write{model, causality};
  std::string text = "digraph " + dot_string(short_name(model.name)) +
                     " {\nrankdir=LR;\nnode [shape=plaintext];\nedge [dir=both, fontsize=10];\n";
  std::map<std::string, std::vector<std::size_t>> by_scope;
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    std::string scope = scope_of(model.elements[i].name);
    by_scope[scope].push_back(i);
    for (; !scope.empty(); scope = scope_of(scope.substr(0, scope.size() - 1))) by_scope[scope];
  }
  std::vector<std::string> open;
  const auto close_until = [&](const std::string& scope) {
    for (; !open.empty() && !scope.starts_with(open.back()); open.pop_back()) text += "}\n";
  };
  for (const auto& [scope, elements] : by_scope) {
    close_until(scope);
    if (!scope.empty()) {
      const std::string name = scope.substr(0, scope.size() - 1);
      text += "subgraph " + dot_string("cluster_" + name) + " {\nlabel=" + dot_string(local_name(name)) + ";\n";
      open.push_back(scope);
    }
    for (const std::size_t i : elements) text += write.node(i);
  }
  for (; !open.empty(); open.pop_back()) text += "}\n";
  for (std::size_t i = 0; i < model.bonds.size(); ++i) text += write.bond(i);
  for (const ReadSignal& signal : read_signals(model)) {
    const ElementId from = signal.from.valid() ? signal.from : model.bonds[signal.from_bond.index()].from.element;
    text += write.identifier(from) + " -> " + write.identifier(signal.to) + " [label=" + dot_string(signal.label) +
            ", style=dashed, dir=forward, arrowhead=vee, constraint=false];\n";
  }
  return text + "}\n";
}

}  // namespace bgsim
