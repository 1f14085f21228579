#include "scene/given_values.hpp"

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/unit.hpp"
#include "expression/graph.hpp"
#include "expression/parse.hpp"
#include "expression/partial.hpp"
#include "expression/value_unit.hpp"
#include "model/element_kinds.hpp"
#include "scene/set_target.hpp"

namespace bgsim {

namespace {

using ParametersByName = std::unordered_map<std::string_view, std::size_t>;

/// "NAME=EXPR" from the command line.
struct SetText {
  std::string whole, name;
  std::string_view value;  ///< of `whole`
};

/// What is wrong with a text of --set: its code, and the rest of a message.
Diagnostic set_problem(const SetText& set, const std::string& what, std::string help, std::string rule = {},
                       const std::string& code = "BG141") {
  return diagnostic_of(code, "--set " + in_quotes(set.whole) + what, {}, std::move(rule), std::move(help));
}

/// A value of the command line is a number; its unit is the parameter's.
std::string unit_help(const SetText& set, const ExpressionError& error, const std::string& unit_of_parameter) {
  const std::string number(trimmed(set.value.substr(0, error.begin)));
  if (!parse_unit(bare_unit(set.value.substr(error.begin))).unit) return error.help;
  return "write --set " + set.name + "=" + number + ": the number is in the unit that the model gives " +
         in_quotes(set.name) + (unit_of_parameter.empty() ? "" : ", " + unit_of_parameter);
}

/// The value of --set, over parameters; or what is wrong with it.
/// @param unit  of the parameter that is set; may be empty.
std::optional<ExprId> value_of(const SetText& set, const Model& model, const ParametersByName& parameters,
                               const std::string& unit, GivenValues& given) {
  ExpressionScope scope;
  scope.time = model.time;
  scope.name = [&](std::string_view wanted) -> std::optional<ExprId> {
    const auto known = parameters.find(wanted);
    if (known == parameters.end()) return std::nullopt;
    return given.pool.symbol(model.parameters[known->second].symbol);
  };
  scope.known_names = [&model] {
    std::vector<std::string> names;
    for (const Parameter& parameter : model.parameters) names.push_back(parameter.name);
    return names;
  };
  scope.leaves_out = [&](std::size_t, std::size_t, ExprId kept, ExprId lost) {
    const auto name = [&model](SymbolId symbol) { return symbol_name(model, symbol); };
    given.warnings.push_back(set_problem(set, ": " + left_out_words(given.pool, kept, lost, name),
                                         "write what is meant without " + to_text(given.pool, lost, name),
                                         "what cancels, or is multiplied by 0, is not evaluated", "BG128"));
  };
  try {
    const ExprId value = parse_expression(set.value, given.pool, scope);
    for (const ExprId id : reachable(given.pool, std::vector{value})) {
      const bool time = given.pool.is_symbol(id) && given.pool.symbol_of(id) == model.time;
      if (given.pool[id].op != Op::der && !time) continue;
      given.problems.push_back(
          set_problem(set, ": neither t nor der can be used here", {},
                      "parameters and initial values are computed from numbers and parameters only"));
      return std::nullopt;
    }
    return value;
  } catch (const ExpressionError& error) {
    std::string help = error.code == "BG181" ? unit_help(set, error, unit)
                       : error.help.empty()  ? "a value is made of numbers and the model's parameters"
                                             : error.help;
    given.problems.push_back(set_problem(set, std::string(": ") + error.what(), std::move(help), {}, error.code));
    return std::nullopt;
  }
}

}  // namespace

char initial_letter(const Element& element, std::uint32_t port, bool conjugate) {
  return letter(conjugate ? conjugate_variable(element, port) : stored_variable(element, port));
}

std::string initial_name(const Element& element, std::uint32_t port, bool conjugate) {
  return port_name(element, port) + "." + initial_letter(element, port, conjugate);
}

StateNames::StateNames(const Model& model) {
  for (std::size_t i = 0; i < model.signals.size(); ++i)
    if (model.signals[i].is_state()) found_.emplace(model.signals[i].name, Found{{{}, 0, SignalId(i)}, false});
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    const Element& element = model.elements[i];
    for (std::uint32_t port = 0; is_store(element.kind) && port < element.ports.size(); ++port)
      for (const bool conjugate : {false, true})
        found_.emplace(initial_name(element, port, conjugate), Found{{ElementId(i), port, {}}, conjugate});
  }
}

std::optional<StateNames::Found> StateNames::find(const std::string& name) const {
  const auto found = found_.find(name);
  return found == found_.end() ? std::nullopt : std::optional(found->second);
}

GivenValues given_values(const Model& model, const Scene& scene, const SceneOverrides& overrides) {
  GivenValues given{model.pool, {}, {}, {}, {}, {}, {}};
  ParametersByName parameters;
  for (const Parameter& parameter : model.parameters) {
    parameters.emplace(parameter.name, given.parameters.size());
    given.parameters.push_back({parameter.value, parameter.place});
  }
  for (const auto& [name, value] : scene.parameters)
    given.parameters[parameters.at(name)] = {value.first, value.second};

  for (std::size_t i = 0; i < model.elements.size(); ++i)
    for (const InitialValue& initial : model.elements[i].initial)
      given.initial[{ElementId(i), initial.port, {}}] = {initial.value, initial.place, initial.conjugate};
  for (std::size_t i = 0; i < model.signals.size(); ++i)
    if (model.signals[i].initial.valid())
      given.initial[{{}, 0, SignalId(i)}] = {model.signals[i].initial, model.signals[i].initial_place};

  std::optional<StateNames> names;  // put together when the first is asked for
  const auto find_state = [&](const std::string& name) { return (names ? *names : names.emplace(model)).find(name); };
  for (const auto& [name, value] : scene.initial)
    if (const auto state = find_state(name)) given.initial[state->key] = {value.first, value.second, state->conjugate};

  std::unordered_map<std::size_t, std::string> set_parameters;  // what --set has set already: the whole text
  std::map<StateKey, std::string> set_states;
  for (const std::string& text : overrides.set) {
    const auto equals = text.find('=');
    SetText set{text, std::string(trimmed(std::string_view(text).substr(0, equals))), {}};
    if (equals == std::string::npos || set.name.empty()) {
      const bool spaces = equals == std::string::npos && !set.name.empty();
      given.problems.push_back(set_problem(
          set, " is not of the form NAME=EXPR",
          spaces ? "write --set " + set.name + "=VALUE, without spaces around =" : "write --set m=0.02, say"));
      continue;
    }
    set.value = std::string_view(set.whole).substr(equals + 1);
    const auto parameter = parameters.find(set.name);
    const bool is_parameter = parameter != parameters.end();
    const auto state = is_parameter ? std::nullopt : find_state(set.name);
    if (!is_parameter && !state) {
      const UnknownTarget unknown = unknown_target_words(model, set.name);
      given.problems.push_back(set_problem(set, ": " + unknown.situation, unknown.help,
                                           "--set takes parameters and the initial values of stores"));
      continue;
    }
    std::string& before = is_parameter ? set_parameters[parameter->second] : set_states[state->key];
    if (!before.empty()) {
      given.problems.push_back(diagnostic_of("BG141",
                                             "--set " + in_quotes(before) + " and --set " + in_quotes(text) +
                                                 " set the same " + (is_parameter ? "parameter" : "store"),
                                             {}, {}, "keep one of them"));
      continue;
    }
    before = text;
    const std::string unit = is_parameter ? model.parameters[parameter->second].unit : std::string();
    const auto value = value_of(set, model, parameters, unit, given);
    if (!value) continue;
    (is_parameter ? given.set_parameters : given.set_states)[set.name] = *value;
    if (is_parameter)
      given.parameters[parameter->second] = {*value, std::nullopt};
    else
      given.initial[state->key] = {*value, std::nullopt, state->conjugate};
  }
  return given;
}

}  // namespace bgsim
