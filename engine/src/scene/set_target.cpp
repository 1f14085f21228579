#include "scene/set_target.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {
namespace {

std::string last_part(const std::string& name) {
  const auto dot = name.rfind('.');
  return dot == std::string::npos ? name : name.substr(dot + 1);
}

std::vector<std::string> state_names(const Model& model) {
  std::vector<std::string> names;
  for (const Signal& signal : model.signals)
    if (signal.is_state()) names.push_back(signal.name);
  for (const Element& element : model.elements)
    for (std::size_t port = 0; is_store(element.kind) && port < element.ports.size(); ++port)
      names.push_back(port_name(element, port) + "." + letter(stored_variable(element, port)));
  return names;
}

/// What --set can change of an element: the parameters in its value, and what it holds at the start.
std::string help_for_element(const Model& model, const Element& element) {
  std::vector<std::string> names;
  std::vector<ExprId> values;
  if (element.coefficient.valid()) values.push_back(element.coefficient);
  if (element.energy.valid()) values.push_back(element.energy);
  for (const Law& law : element.laws) values.push_back(law.right);
  for (const SymbolId id : symbols_in(model.pool, values))
    if (model.symbols[id.index()].kind == ModelSymbol::Kind::parameter) names.push_back(symbol_name(model, id));
  for (std::size_t port = 0; is_store(element.kind) && port < element.ports.size(); ++port)
    names.push_back(port_name(element, port) + "." + letter(stored_variable(element, port)));
  if (names.empty()) return "give its value a name among \"parameters\", and set that";
  return "these can be set: " + list_of(names, " or ", 6);
}

}  // namespace

UnknownTarget unknown_target_words(const Model& model, const std::string& name) {
  for (const Signal& signal : model.signals)
    if (signal.name == name)
      return {in_quotes(name) + " is a signal, which is computed at each instant",
              "write the signal with a parameter, and set that"};
  const auto dot = name.rfind('.');
  const Element* owner = nullptr;
  for (const Element& element : model.elements) {
    if (element.name == name) return {in_quotes(name) + " is an element", help_for_element(model, element)};
    if (dot != std::string::npos && element.name == name.substr(0, dot)) owner = &element;
  }
  if (owner != nullptr)
    return {in_quotes(name) + " is not an initial value of the element " + in_quotes(owner->name),
            help_for_element(model, *owner)};
  for (const Output& output : model.outputs)
    if (output.name == name)
      return {in_quotes(name) + " is an output, a column of the trace", "set the parameters that it depends on"};
  std::vector<std::string> names = state_names(model), alike;
  for (const Parameter& parameter : model.parameters) {
    names.push_back(parameter.name);
    if (last_part(parameter.name) == name) alike.push_back(parameter.name);
  }
  UnknownTarget unknown{"there is no parameter or state " + in_quotes(name), {}};
  if (!alike.empty()) {
    unknown.help = "names inside submodels are written in full: " + list_of(alike, " or ", 6);
    return unknown;
  }
  std::sort(names.begin(), names.end());
  const std::string near = nearest_name(name, names);
  if (!near.empty())
    unknown.help = "did you mean " + in_quotes(near) + "?";
  else if (names.empty())
    unknown.help = "the model has neither parameters nor stores";
  else
    unknown.help = "there are " + list_of(names, " or ", 6);
  return unknown;
}

}  // namespace bgsim
