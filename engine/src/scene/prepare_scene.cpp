#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/codes.hpp"
#include "base/dependence.hpp"
#include "base/document.hpp"
#include "base/text.hpp"
#include "bgsim/model.hpp"
#include "bgsim/text.hpp"
#include "expression/graph.hpp"
#include "expression/rounded.hpp"
#include "model/element_kinds.hpp"
#include "model/output_times.hpp"
#include "read/initial_from_law.hpp"
#include "scene/given_values.hpp"
#include "scene/parameter_values.hpp"
#include "scene/settings.hpp"

namespace bgsim {

namespace {

void stop_if_wrong(std::vector<Diagnostic>& problems, const Model& model) {
  if (!problems.empty()) throw ModelError(std::move(problems), model.sources);
}

/// Where the model begins, for what is missing in it as a whole.
std::optional<Place> head(const Model& model) {
  if (!model.sources || model.sources->empty()) return std::nullopt;
  Place place = model.sources->front().place(Document::root());
  place.end = place.begin + 1;
  return place;
}

/// @throws ModelError BG140.
const Scene& find_scene(const Model& model, const std::string& name) {
  std::vector<std::string> names;
  for (const Scene& scene : model.scenes) {
    if (name.empty() || scene.name == name) return scene;
    names.push_back(scene.name);
  }
  if (names.empty())
    throw ModelError(
        {diagnostic_of("BG140", "the model " + in_quotes(model.name) + " has no scenes, so there is nothing to run",
                       head(model), {}, "add \"scenes\": { \"run\": { \"stop\": 1 } }")},
        model.sources);
  std::string help = nearest_name(name, names);
  help = help.empty() ? "scenes are" : "did you mean " + in_quotes(help) + "? Scenes are";
  for (const std::string& known : names) help += (&known == &names.front() ? " " : ", ") + known;
  throw ModelError({diagnostic_of("BG140", "there is no scene " + in_quotes(name), {}, {}, help)}, model.sources);
}

/// What is given, as numbers.
struct Numbers {
  std::vector<double> values;      ///< by SymbolId: parameters; NaN for all else
  std::vector<double> errors;      ///< by SymbolId: how far roundings can have taken them; empty unless asked for
  std::vector<double> parameters;  ///< by ParameterId
  std::vector<std::size_t> order;  ///< of the parameters: each after those that it refers to
};

/// The value of an expression over parameters, or a message with its operands.
std::optional<double> number(const Model& model, const ExprPool& pool, const Numbers& numbers, ExprId expression,
                             const std::string& what, const std::optional<Place>& place,
                             std::vector<Diagnostic>& problems) {
  const double value = evaluate(pool, expression, numbers.values);
  if (std::isfinite(value)) return value;
  problems.push_back(diagnostic_of(
      "BG142", what + " is not a finite number: " + with_operands(model, pool, expression, numbers.values), place, {},
      "look for a division by 0, an overflow, or a function outside its domain"));
  return std::nullopt;
}

Diagnostic cycle_of(const Model& model, const GivenValues& given, const std::vector<std::size_t>& cycle) {
  std::string chain;
  std::vector<Note> notes;
  for (const std::size_t i : cycle) {
    chain += model.parameters[i].name + " -> ";
    const auto& place = given.parameters[i].place;
    if (notes.size() < 3)
      notes.push_back(
          {place, in_quotes(model.parameters[i].name) + (place ? " is computed here" : " is set by --set")});
  }
  return diagnostic_of("BG132", "parameters depend on each other: " + chain + model.parameters[cycle.front()].name, {},
                       "an override replaces the value in the model",
                       "give one of them a value that does not refer to the others", std::move(notes));
}

/// @throws ModelError BG132, BG142.
Numbers parameter_numbers(const Model& model, const GivenValues& given) {
  const auto refers_to = [&](std::size_t i) {
    std::vector<std::size_t> others;
    for (const SymbolId symbol : symbols_in(given.pool, std::vector{given.parameters[i].value}))
      others.push_back(model.symbols[symbol.index()].parameter.index());
    return others;
  };
  const std::size_t count = given.parameters.size();
  Dependence dependence = order_by_dependence(count, refers_to);
  std::vector<Diagnostic> problems;
  for (const std::vector<std::size_t>& cycle : dependence.cycles) problems.push_back(cycle_of(model, given, cycle));
  stop_if_wrong(problems, model);
  Numbers numbers;
  numbers.values.assign(model.symbols.size(), std::numeric_limits<double>::quiet_NaN());
  numbers.parameters.resize(count);
  numbers.order = std::move(dependence.order);
  std::vector<bool> known(count, true);
  for (const std::size_t i : numbers.order) {
    const Parameter& parameter = model.parameters[i];
    for (const std::size_t other : refers_to(i)) known[i] = known[i] && known[other];
    if (!known[i]) continue;  // for want of another parameter, which is reported
    const auto value = number(model, given.pool, numbers, given.parameters[i].value,
                              "the parameter " + in_quotes(parameter.name), given.parameters[i].place, problems);
    known[i] = value.has_value();
    numbers.parameters[i] = numbers.values[parameter.symbol.index()] = value.value_or(0.0);
  }
  stop_if_wrong(problems, model);
  return numbers;
}

/// How far roundings can have taken the parameters, by ParameterId.
std::vector<double> find_rounding(const Model& model, const GivenValues& given, Numbers& numbers) {
  numbers.errors.assign(model.symbols.size(), 0.0);
  std::vector<double> rounding(given.parameters.size(), 0.0);
  for (const std::size_t i : numbers.order)
    rounding[i] = numbers.errors[model.parameters[i].symbol.index()] =
        rounding_of(given.pool, given.parameters[i].value, numbers.values, numbers.errors);
  return rounding;
}

/// What the numbers of a scene are made from.
struct SceneParts {
  const Model& model;
  const Scene& scene;
  GivenValues& given;
  Numbers& numbers;

  std::optional<double> number(ExprId expression, const std::string& what, const std::optional<Place>& place,
                               std::vector<Diagnostic>& problems) const {
    return bgsim::number(model, given.pool, numbers, expression, what, place, problems);
  }
};

/// What the ports of a store hold at the start, where values are given.
void begin_store(const SceneParts& parts, ElementId element, const std::vector<StartValue>& values,
                 std::vector<RunInputs::Initial>& initial, std::vector<Diagnostic>& problems) {
  const auto& [model, scene, given, numbers] = parts;
  const auto add = [&, &given = given](std::size_t i, double stored, double rounding) {
    const GivenValue& value = given.initial[{element, values[i].port, {}}];
    initial.push_back({element, values[i].port, stored, value.place, {}, rounding});
  };
  if (std::none_of(values.begin(), values.end(), [](const StartValue& v) { return v.conjugate; })) {
    for (std::size_t i = 0; i < values.size(); ++i) add(i, values[i].value, values[i].rounding);
    return;
  }
  const double start = scene.start.valid() ? evaluate(given.pool, scene.start, numbers.values) : 0.0;
  const StoredAtStart found =
      stored_at_start(model, given.pool, element, values, start, numbers.values, numbers.errors);
  for (std::size_t i = 0; found.fault.empty() && i < values.size(); ++i) add(i, found.stored[i], found.rounding[i]);
  if (found.fault.empty()) return;
  const Element& owner = model.elements[element.index()];
  const StartValue& at = values[found.at];
  const std::string name = port_name(owner, at.port) + ".";
  problems.push_back(diagnostic_of(
      "BG183",
      "the initial value " + name + initial_letter(owner, at.port, true) + " = " + number_text(at.value, 6) +
          " does not determine what " + in_quotes(owner.name) + " holds: " + found.fault,
      given.initial[{element, at.port, {}}].place,
      "an initial effort or flow determines what is stored if the law of the store can be inverted",
      "give " + name + initial_letter(owner, at.port, false) + " instead"));
}

/// By increasing element and port, then signal.
std::vector<RunInputs::Initial> initial_numbers(const SceneParts& parts, std::vector<Diagnostic>& problems) {
  const Model& model = parts.model;
  const GivenValues& given = parts.given;
  std::vector<RunInputs::Initial> initial;
  std::vector<StartValue> values;  // of one element
  for (auto at = given.initial.begin(); at != given.initial.end(); ++at) {
    const auto& [key, start] = *at;
    const bool integral = key.signal.valid();
    const std::string name = integral ? model.signals[key.signal.index()].name
                                      : initial_name(model.elements[key.element.index()], key.port, start.conjugate);
    const double* constant = given.pool.is_constant(start.value) ? &given.pool[start.value].constant : nullptr;
    const auto value =
        constant != nullptr && std::isfinite(*constant)
            ? std::optional(*constant)
            : parts.number(start.value, "the initial value of " + in_quotes(name), start.place, problems);
    if (integral) {
      if (value) initial.push_back({{}, 0, *value, start.place, key.signal, 0.0});
      continue;
    }
    if (value)
      values.push_back({key.port, *value, start.conjugate,
                        rounding_of(given.pool, start.value, parts.numbers.values, parts.numbers.errors)});
    if (const auto next = std::next(at); next != given.initial.end() && next->first.element == key.element) continue;
    begin_store(parts, key.element, values, initial, problems);
    values.clear();
  }
  return initial;
}

/// None if one of the times is not a number, which is reported.
std::optional<PreparedTimes> output_times(const SceneParts& parts, double start, double stop,
                                          std::vector<Diagnostic>& problems) {
  const Scene& scene = parts.scene;
  if (scene.interval.valid()) {
    const auto interval = parts.number(scene.interval, "\"interval\"", scene.interval_place, problems);
    return interval ? std::optional(times_at_interval(start, stop, *interval)) : std::nullopt;
  }
  if (scene.log_samples) {
    std::optional<double> from;
    if (scene.log_from.valid()) from = parts.number(scene.log_from, "\"from\"", scene.log_from_place, problems);
    if (scene.log_from.valid() && !from) return std::nullopt;
    return times_by_logarithm(start, stop, *scene.log_samples, from);
  }
  if (scene.times.empty()) return times_by_number(start, stop, scene.samples);
  std::vector<double> list;
  for (const auto& [time, place] : scene.times)
    if (const auto value = parts.number(time, "an output time", place, problems)) list.push_back(*value);
  return list.size() == scene.times.size() ? std::optional(times_listed(start, stop, std::move(list))) : std::nullopt;
}

void prepare_times(const SceneParts& parts, RunInputs& inputs, std::vector<Diagnostic>& problems) {
  const Scene& scene = parts.scene;
  std::optional<double> start = 0.0;
  if (scene.start.valid()) start = parts.number(scene.start, "\"start\"", scene.start_place, problems);
  const auto stop = parts.number(scene.stop, "\"stop\"", scene.stop_place, problems);
  if (!start || !stop) return;
  inputs.start = *start;
  inputs.stop = *stop;
  std::optional<PreparedTimes> prepared = output_times(parts, *start, *stop, problems);
  if (!prepared) return;
  PreparedTimes& times = *prepared;
  const std::size_t columns = scene.outputs.empty() ? parts.model.outputs.size() : scene.outputs.size();
  constexpr double kMostNumbers = 1e9;
  if (times.fault.empty() &&
      static_cast<double>(times.times.size()) * (1.0 + static_cast<double>(columns)) > kMostNumbers) {
    times.fault = "the trace would hold more than 1e9 numbers";
    times.help = "ask for fewer samples or outputs";
  }
  if (times.fault.empty()) {
    inputs.output_times = std::move(times.times);
    return;
  }
  const bool order = !(*stop >= *start);
  const Place place = times.at ? scene.times[*times.at].second : scene.interval_place;
  problems.push_back(diagnostic_of(order ? "BG143" : "BG144", "the scene " + in_quotes(scene.name) + ": " + times.fault,
                                   order || !place.node.valid() ? scene.stop_place : place, {}, times.help));
}

Diagnostic restitution_fault(const Element& element, double value) {
  return diagnostic_of("BG626",
                       "the restitution of the contact " + in_quotes(element.name) + " is " + number_text(value, 6),
                       element.contact->restitution_place, "the speed after an impact is 0 to 1 times that before",
                       "1 keeps all energy, 0 none");
}

/// Coefficients that depend on parameters alone are looked at before anything is computed from them.
void check_coefficients(const SceneParts& parts, std::vector<Diagnostic>& warnings, std::vector<Diagnostic>& problems) {
  const ParameterValues values(parts.model, parts.given.pool, parts.numbers.values);
  for (const Element& element : parts.model.elements) {
    if (element.contact)
      if (const auto value = values.of(element.contact->restitution); value && !(*value >= 0.0 && *value <= 1.0))
        problems.push_back(restitution_fault(element, *value));
    if (!element.coefficient.valid()) continue;
    const auto value = values.of(element.coefficient);
    if (!value) continue;
    const std::string what = "the " + coefficient_words(element) + " of " + in_quotes(element.name);
    const std::string is = what + " is " + number_text(*value, 6);
    if (!std::isfinite(*value)) {
      parts.number(element.coefficient, what, element.coefficient_place, problems);
    } else if (is_store(element.kind) && *value == 0.0) {
      problems.push_back(diagnostic_of("BG145", is, element.coefficient_place,
                                       "a store takes energy in as it fills: its capacitance or inertance is not 0",
                                       "leave the element out, or give it a small positive value"));
    } else if (is_store(element.kind) && *value < 0.0) {
      warnings.push_back(
          diagnostic_of("BG180", is + ": the store is unstable", element.coefficient_place,
                        "a negative store gives off energy as it fills",
                        "if this is not intended, check the sign (a linearised inverted pendulum has such a spring)"));
    } else if (is_diode(element.kind) && !element.contact && *value < 0.0) {
      problems.push_back(diagnostic_of("BG145", is, element.coefficient_place,
                                       "a diode that conducts takes energy in: its threshold is not below 0",
                                       "the way that it conducts is \"passes\": \"in\" or \"out\""));
    } else if (is_resistor(element.kind) && *value < 0.0) {
      warnings.push_back(diagnostic_of("BG148", is + ": the element is active", element.coefficient_place,
                                       "a negative resistance supplies power",
                                       "if it should not supply power, check the sign"));
    }
  }
}

/// Whether the start is a sampling time offset + n every, n = 0, 1, 2, ..., as far as its digits say.
bool starts_with_sample(const SceneParts& parts, const Signal& signal, double start) {
  constexpr double kDigits = 1e-9;  // of the interval; a tenth is none exactly
  const double every = evaluate(parts.given.pool, signal.every, parts.numbers.values);
  const double offset = evaluate(parts.given.pool, signal.offset, parts.numbers.values);
  const double n = std::round((start - offset) / every);
  return n >= 0.0 && std::abs(start - offset - n * every) <= kDigits * every;
}

/// Sampling times: positive, and within the scene. What is sampled at the start.
void prepare_sampling(const SceneParts& parts, RunInputs& inputs, std::vector<Diagnostic>& problems) {
  constexpr double kMostSamples = 1e9;  // far more than runs have, and less than the digits of their times tell apart
  for (const Signal& signal : parts.model.signals) {
    if (!signal.delay) continue;
    const std::string what = "the delay of " + in_quotes(signal.name);
    const auto by = parts.number(signal.delay->by, what, signal.delay->by_place, problems);
    if (by && !(*by > 0.0))
      problems.push_back(diagnostic_of("BG629", what + " is " + number_text(*by, 6), signal.delay->by_place,
                                       "a delayed signal is what it delays was some time before",
                                       "give \"by\" a positive time; a signal that is not late is an expression"));
    if (by && *by > 0.0 && inputs.step > *by)
      problems.push_back(diagnostic_of(
          "BG629", what + ", " + number_text(*by, 6) + ", is shorter than the steps of " + number_text(inputs.step, 6),
          signal.delay->by_place, "a step does not ask for what it computes itself",
          "make the scene's \"step\" shorter than the delay"));
    if (by && *by > 0.0 && (inputs.stop - inputs.start) / *by > kMostSamples)
      problems.push_back(diagnostic_of(
          "BG629",
          what + ", " + number_text(*by, 6) + ", asks for " + number_text((inputs.stop - inputs.start) / *by, 2) +
              " steps in the scene " + in_quotes(inputs.scene),
          signal.delay->by_place, "no step is longer than a delay, and a scene has at most 1e9 of them",
          "check the unit of \"by\"; a signal that is not late is an expression"));
  }
  for (const Signal& signal : parts.model.signals) {
    if (!signal.every.valid()) continue;
    const std::string what = "the sampling time of " + in_quotes(signal.name);
    const auto every = parts.number(signal.every, what, signal.every_place, problems);
    if (!every) continue;
    if (!(*every > 0.0) || !std::isfinite(*every))
      problems.push_back(diagnostic_of("BG186", what + " is " + number_text(*every, 6), signal.every_place,
                                       "samples are taken at offset + n every, n = 0, 1, 2, ...",
                                       "give \"every\" a positive time"));
    else if ((inputs.stop - inputs.start) / *every > kMostSamples)
      problems.push_back(diagnostic_of(
          "BG186",
          what + ", " + number_text(*every, 6) + ", asks for " + number_text((inputs.stop - inputs.start) / *every, 2) +
              " samples in the scene " + in_quotes(inputs.scene),
          signal.every_place, "a scene has at most 1e9 samples of a signal",
          "check the unit of \"every\"; a value that is to be known at every time is no sampled signal"));
    else if (const auto offset = parts.number(signal.offset, what, signal.every_place, problems);
             offset && *offset > inputs.stop)
      inputs.warnings.push_back(
          diagnostic_of("BG187",
                        "the first sample of " + in_quotes(signal.name) + ", at t = " + number_text(*offset, 6) +
                            ", is after the end of the scene " + in_quotes(inputs.scene),
                        signal.every_place, "samples are taken at offset + n every, n = 0, 1, 2, ..."));
    else if (inputs.stop > inputs.start && *every > inputs.stop - inputs.start)
      inputs.warnings.push_back(diagnostic_of(
          "BG187", what + ", " + number_text(*every, 6) + ", is longer than the scene " + in_quotes(inputs.scene),
          signal.every_place, "samples are taken at offset + n every, n = 0, 1, 2, ..."));
  }
  if (!problems.empty()) return;
  for (std::size_t i = 0; i < parts.model.events.size(); ++i) {
    const ModelEvent& event = parts.model.events[i];
    if (event.at_start &&
        (!event.sampled.valid() || starts_with_sample(parts, parts.model.signals[event.sampled.index()], inputs.start)))
      inputs.starting_events.push_back(i);
  }
}

}  // namespace

RunInputs prepare_scene(const Model& model, const std::string& name, const SceneOverrides& overrides) {
  const Scene& scene = find_scene(model, name);
  GivenValues given = given_values(model, scene, overrides);
  stop_if_wrong(given.problems, model);
  Numbers numbers = parameter_numbers(model, given);
  RunInputs inputs;
  inputs.scene = scene.name;
  inputs.warnings = std::move(given.warnings);
  inputs.parameters = numbers.parameters;
  inputs.reference = scene.reference;
  inputs.close_zeno = scene.close_zeno;
  inputs.sequential_impacts = scene.sequential_impacts;
  if (scene.max_events) {
    inputs.max_events = *scene.max_events;
    inputs.max_events_place = scene.max_events_place;
  }
  if (!given.initial.empty()) inputs.rounding = find_rounding(model, given, numbers);
  std::vector<Diagnostic> problems;
  const SceneParts parts{model, scene, given, numbers};
  inputs.initial = initial_numbers(parts, problems);
  prepare_times(parts, inputs, problems);
  inputs.outputs = chosen_outputs(model, scene);
  if (inputs.outputs.empty())
    inputs.warnings.push_back(
        diagnostic_of("BG149", "the model " + in_quotes(model.name) + " has no outputs: its trace has only the times",
                      head(model), {}, "add \"outputs\": { \"x\": \"spring.q\" }, say"));
  choose_tolerances(scene, overrides, inputs, problems);
  choose_method(scene, overrides, inputs, problems);
  check_coefficients(parts, inputs.warnings, problems);
  prepare_sampling(parts, inputs, problems);
  stop_if_wrong(problems, model);
  return inputs;
}

Model with_overrides(const Model& model, const std::string& name, const SceneOverrides& overrides) {
  const std::string scene_name = find_scene(model, name).name;
  GivenValues given = given_values(model, find_scene(model, name), overrides);
  stop_if_wrong(given.problems, model);
  const StateNames states(model);
  Model result = model;
  result.pool = std::move(given.pool);
  for (Scene& scene : result.scenes) {
    if (scene.name != scene_name) continue;
    for (const auto& [parameter, value] : given.set_parameters) scene.parameters[parameter] = {value, Place{}};
    for (const auto& [state, value] : given.set_states) {
      const StateKey store = states.find(state)->key;  // which the scene may name by its other variable
      std::erase_if(scene.initial, [&](const auto& other) { return states.find(other.first)->key == store; });
      scene.initial[state] = {value, Place{}};
    }
    if (overrides.relative) scene.relative = overrides.relative;
    if (overrides.absolute) scene.absolute = overrides.absolute;
    if (overrides.absolute) scene.absolute_by_state.clear();
    const Method method = overrides.method.value_or(scene.method);
    if (overrides.step || method != scene.method) scene.step = overrides.step;
    if (overrides.max_order || method != scene.method) scene.max_order = overrides.max_order;
    scene.method = method;
  }
  return result;
}

}  // namespace bgsim
