#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <unordered_map>

#include "base/codes.hpp"
#include "base/dependence.hpp"
#include "base/document.hpp"
#include "base/text.hpp"
#include "bgsim/model.hpp"
#include "bgsim/text.hpp"
#include "bgsim/unit.hpp"
#include "expression/parse.hpp"
#include "expression/rounded.hpp"
#include "expression/value_unit.hpp"
#include "model/element_kinds.hpp"
#include "model/output_times.hpp"
#include "read/initial_from_law.hpp"
#include "scene/parameter_values.hpp"
#include "scene/set_target.hpp"

namespace bgsim {
namespace {

std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(' '), end = text.find_last_not_of(' ');
  return begin == std::string::npos ? std::string() : text.substr(begin, end + 1 - begin);
}

/// A value that is set from outside the model's own text: by the scene or the command line (then without a place).
struct Given {
  ExprId value;
  std::optional<Place> place;
  bool conjugate = false;  ///< an initial value of the effort or flow that the law gives, not of what is stored
};

/// A store's port, as initial values name it.
struct StorePort {
  std::uint64_t key = 0;
  bool conjugate = false;
};

class ScenePreparation {
 public:
  ScenePreparation(const Model& model, const SceneOverrides& overrides)
      : model_(model), pool_(model.pool), overrides_(overrides) {
    for (std::size_t i = 0; i < model_.parameters.size(); ++i) parameters_.emplace(model_.parameters[i].name, i);
  }

  RunInputs run(const std::string& name) {
    const Scene& scene = find(name);
    inputs_.scene = scene.name;
    for (const Parameter& parameter : model_.parameters) values_.push_back({parameter.value, parameter.place});
    for (const auto& [parameter, value] : scene.parameters)
      values_[parameters_.at(parameter)] = {value.first, value.second};
    collect_initial(scene);
    for (const std::string& text : overrides_.set) apply(text);
    stop_if_wrong();
    evaluate_parameters();
    stop_if_wrong();
    if (!initial_.empty()) find_rounding();
    evaluate_initial(scene);
    prepare_times(scene);
    choose_outputs(scene);
    prepare_tolerances(scene);
    prepare_method(scene);
    inputs_.reference = scene.reference;
    check_coefficients();
    stop_if_wrong();
    return std::move(inputs_);
  }

  /// What --set says, as the scene would say it.
  Model settled(const std::string& name) {
    const std::string scene_name = find(name).name;
    values_.resize(model_.parameters.size());
    for (const std::string& text : overrides_.set) apply(text);
    stop_if_wrong();
    Model result = model_;
    result.pool = pool_;
    for (Scene& scene : result.scenes) {
      if (scene.name != scene_name) continue;
      for (const auto& [parameter, value] : set_parameters_) scene.parameters[parameter] = {value, Place{}};
      for (const auto& [state, value] : set_states_) {
        const std::uint64_t store = find_state(state)->key;  // which the scene may name by its other variable
        std::erase_if(scene.initial, [&](const auto& given) { return find_state(given.first)->key == store; });
        scene.initial[state] = {value, Place{}};
      }
      if (overrides_.relative) scene.relative = overrides_.relative;
      if (overrides_.absolute) scene.absolute = overrides_.absolute;
      if (overrides_.absolute) scene.absolute_by_state.clear();
      const Method method = overrides_.method.value_or(scene.method);
      if (overrides_.step || method != scene.method) scene.step = overrides_.step;
      if (overrides_.max_order || method != scene.method) scene.max_order = overrides_.max_order;
      scene.method = method;
    }
    return result;
  }

 private:
  void problem(const char* code, std::string situation, std::optional<Place> place, std::string help = {},
               std::string rule = {}) {
    problems_.push_back(diagnostic_of(code, std::move(situation), place, std::move(rule), std::move(help)));
  }
  void stop_if_wrong() {
    if (!problems_.empty()) throw ModelError(std::move(problems_), model_.sources);
  }

  /// Where the model begins, for what is missing in it as a whole.
  [[nodiscard]] std::optional<Place> head() const {
    if (!model_.sources || model_.sources->empty()) return std::nullopt;
    Place place = model_.sources->front().place(Document::root());
    place.end = place.begin + 1;
    return place;
  }

  const Scene& find(const std::string& name) {
    std::vector<std::string> names;
    for (const Scene& scene : model_.scenes) {
      if (name.empty() || scene.name == name) return scene;
      names.push_back(scene.name);
    }
    if (names.empty()) {
      problem("BG140", "the model " + in_quotes(model_.name) + " has no scenes, so there is nothing to run", head(),
              "add \"scenes\": { \"run\": { \"stop\": 1 } }");
    } else {
      std::string help = nearest_name(name, names);
      help = help.empty() ? "scenes are" : "did you mean " + in_quotes(help) + "? Scenes are";
      for (const std::string& known : names) help += (&known == &names.front() ? " " : ", ") + known;
      problem("BG140", "there is no scene " + in_quotes(name), {}, help);
    }
    throw ModelError(std::move(problems_), model_.sources);
  }

  // --- what is given

  /// What an element's port stores, by increasing element and port; then the integrals among the signals.
  static std::uint64_t key(ElementId element, std::uint32_t port) {
    return (std::uint64_t{element.value} << 32U) | port;
  }
  static std::uint64_t key(SignalId signal) { return key(ElementId(), signal.value); }
  [[nodiscard]] static char initial_letter(const Element& element, bool conjugate) {
    return stores_displacement(element.kind) ? (conjugate ? 'e' : 'q') : (conjugate ? 'f' : 'p');
  }
  [[nodiscard]] static std::string initial_name(const Element& element, std::uint32_t port, bool conjugate) {
    return port_name(element, port) + "." + initial_letter(element, conjugate);
  }

  void collect_initial(const Scene& scene) {
    for (std::size_t i = 0; i < model_.elements.size(); ++i)
      for (const InitialValue& initial : model_.elements[i].initial)
        initial_[key(ElementId(i), initial.port)] = {initial.value, initial.place, initial.conjugate};
    for (std::size_t i = 0; i < model_.signals.size(); ++i)
      if (model_.signals[i].initial.valid())
        initial_[key(SignalId(i))] = {model_.signals[i].initial, model_.signals[i].initial_place};
    for (const auto& [state, value] : scene.initial)
      if (const auto store = find_state(state)) initial_[store->key] = {value.first, value.second, store->conjugate};
  }

  /// The store of a state by its full name. The names are put together once, when the first is asked for.
  std::optional<StorePort> find_state(const std::string& name) {
    if (states_.empty()) {
      for (std::size_t i = 0; i < model_.signals.size(); ++i)
        if (model_.signals[i].is_state()) states_.emplace(model_.signals[i].name, StorePort{key(SignalId(i)), false});
      for (std::size_t i = 0; i < model_.elements.size(); ++i) {
        const Element& element = model_.elements[i];
        for (std::uint32_t port = 0; is_store(element.kind) && port < element.ports.size(); ++port)
          for (const bool conjugate : {false, true})
            states_.emplace(initial_name(element, port, conjugate), StorePort{key(ElementId(i), port), conjugate});
      }
    }
    const auto found = states_.find(name);
    return found == states_.end() ? std::nullopt : std::optional(found->second);
  }

  /// "NAME=EXPR" from the command line.
  void apply(const std::string& text) {
    const auto equals = text.find('=');
    const std::string name = trimmed(text.substr(0, equals));
    if (equals == std::string::npos || name.empty())
      return problem("BG141", "--set " + in_quotes(text) + " is not of the form NAME=EXPR", {},
                     equals == std::string::npos && !name.empty()
                         ? "write --set " + name + "=VALUE, without spaces around ="
                         : "write --set m=0.02, say");
    const auto parameter = parameters_.find(name);
    const auto state = parameter == parameters_.end() ? find_state(name) : std::nullopt;
    if (parameter == parameters_.end() && !state) return unknown_target(text, name);
    const std::string target = state ? "state " + std::to_string(state->key) : name;
    if (const auto [before, is_new] = set_before_.emplace(target, text); !is_new)
      return problem("BG141",
                     "--set " + in_quotes(before->second) + " and --set " + in_quotes(text) + " set the same " +
                         (state ? "store" : "parameter"),
                     {}, "keep one of them");
    ExpressionScope scope;
    scope.time = model_.time;
    scope.name = [this](std::string_view wanted) -> std::optional<ExprId> {
      const auto known = parameters_.find(wanted);
      if (known == parameters_.end()) return std::nullopt;
      return pool_.symbol(model_.parameters[known->second].symbol);
    };
    scope.known_names = [this] { return parameter_names(); };
    try {
      const ExprId value = parse_expression(std::string_view(text).substr(equals + 1), pool_, scope);
      for (const ExprId id : reachable(pool_, std::vector{value}))
        if (pool_[id].op == Op::der || (pool_.is_symbol(id) && pool_.symbol_of(id) == model_.time))
          return problem("BG141", "--set " + in_quotes(text) + ": neither t nor der can be used here", {}, {},
                         "parameters and initial values are computed from numbers and parameters only");
      (state ? set_states_ : set_parameters_)[name] = value;
      if (state)
        initial_[state->key] = {value, std::nullopt, state->conjugate};
      else
        values_[parameter->second] = {value, std::nullopt};
    } catch (const ExpressionError& error) {
      problem(error.code.c_str(), "--set " + in_quotes(text) + ": " + error.what(), {},
              error.code == "BG181" ? unit_help(text, name, error, parameter)
              : error.help.empty()  ? "a value is made of numbers and the model's parameters"
                                    : error.help);
    }
  }

  /// A value of the command line is a number; its unit is the parameter's.
  template <class Found>
  std::string unit_help(const std::string& text, const std::string& name, const ExpressionError& error,
                        const Found& parameter) {
    const auto equals = text.find('=');
    const std::string number = trimmed(text.substr(equals + 1, error.begin));
    const std::string_view unit = bare_unit(std::string_view(text).substr(equals + 1 + error.begin));
    if (!parse_unit(unit).unit) return error.help;
    const bool known = parameter != parameters_.end() && !model_.parameters[parameter->second].unit.empty();
    return "write --set " + name + "=" + number + ": the number is in the unit that the model gives " +
           in_quotes(name) + (known ? ", " + model_.parameters[parameter->second].unit : "");
  }

  void unknown_target(const std::string& text, const std::string& name) {
    const UnknownTarget unknown = unknown_target_words(model_, name);
    problem("BG141", "--set " + in_quotes(text) + ": " + unknown.situation, {}, unknown.help,
            "--set takes parameters and the initial values of stores");
  }

  [[nodiscard]] std::vector<std::string> parameter_names() const {
    std::vector<std::string> names;
    for (const Parameter& parameter : model_.parameters) names.push_back(parameter.name);
    return names;
  }

  // --- values

  void evaluate_parameters() {
    const auto refers_to = [this](std::size_t i) {
      std::vector<std::size_t> others;
      for (const SymbolId symbol : symbols_in(pool_, std::vector{values_[i].value}))
        others.push_back(model_.symbols[symbol.index()].parameter.index());
      return others;
    };
    const Dependence dependence = order_by_dependence(values_.size(), refers_to);
    for (const std::vector<std::size_t>& cycle : dependence.cycles) {
      std::string chain;
      std::vector<Note> notes;
      for (const std::size_t i : cycle) {
        chain += model_.parameters[i].name + " -> ";
        if (notes.size() < 3)
          notes.push_back({values_[i].place, in_quotes(model_.parameters[i].name) +
                                                 (values_[i].place ? " is computed here" : " is set by --set")});
      }
      problem("BG132", "parameters depend on each other: " + chain + model_.parameters[cycle.front()].name, {},
              "give one of them a value that does not refer to the others",
              "an override replaces the value in the model");
      problems_.back().notes = std::move(notes);
    }
    stop_if_wrong();
    symbol_values_.assign(model_.symbols.size(), std::numeric_limits<double>::quiet_NaN());
    std::vector<bool> known(values_.size(), true);
    inputs_.parameters.resize(values_.size());
    parameter_order_ = dependence.order;
    for (const std::size_t i : dependence.order) {
      const Parameter& parameter = model_.parameters[i];
      for (const std::size_t other : refers_to(i)) known[i] = known[i] && known[other];
      if (!known[i]) continue;  // for want of another parameter, which is reported
      const auto value = number(values_[i].value, "the parameter " + in_quotes(parameter.name), values_[i].place);
      known[i] = value.has_value();
      inputs_.parameters[i] = symbol_values_[parameter.symbol.index()] = value.value_or(0.0);
    }
  }

  /// The value of an expression over parameters, or a message with its operands.
  std::optional<double> number(ExprId expression, const std::string& what, const std::optional<Place>& place) {
    const double value = evaluate(pool_, expression, symbol_values_);
    if (std::isfinite(value)) return value;
    problem("BG142", what + " is not a finite number: " + with_operands(model_, pool_, expression, symbol_values_),
            place, "look for a division by 0, an overflow, or a function outside its domain");
    return std::nullopt;
  }

  /// How far roundings can have taken the parameters: a parameter after those that it refers to.
  void find_rounding() {
    symbol_errors_.assign(model_.symbols.size(), 0.0);
    inputs_.rounding.assign(values_.size(), 0.0);
    for (const std::size_t i : parameter_order_)
      inputs_.rounding[i] = symbol_errors_[model_.parameters[i].symbol.index()] =
          rounding_of(pool_, values_[i].value, symbol_values_, symbol_errors_);
  }

  void evaluate_initial(const Scene& scene) {
    std::vector<std::uint64_t> stores;
    for (const auto& [store, unused] : initial_) stores.push_back(store);
    std::sort(stores.begin(), stores.end());
    std::vector<StartValue> values;  // of one element
    for (std::size_t i = 0; i < stores.size(); ++i) {
      const ElementId element(stores[i] >> 32U);
      const auto port = static_cast<std::uint32_t>(stores[i]);
      const Given& given = initial_[stores[i]];
      const SignalId signal = element.valid() ? SignalId() : SignalId(port);
      const std::string name = element.valid() ? initial_name(model_.elements[element.index()], port, given.conjugate)
                                               : model_.signals[signal.index()].name;
      const double* constant = pool_.is_constant(given.value) ? &pool_[given.value].constant : nullptr;
      std::optional<double> value;
      if (constant != nullptr && std::isfinite(*constant))
        value = *constant;
      else
        value = number(given.value, "the initial value of " + in_quotes(name), given.place);
      if (value && signal.valid()) inputs_.initial.push_back({{}, 0, *value, given.place, signal, 0.0});
      if (signal.valid()) continue;
      if (value) values.push_back({port, *value, given.conjugate});
      if (i + 1 < stores.size() && ElementId(stores[i + 1] >> 32U) == element) continue;
      begin_store(element, values, scene);
      values.clear();
    }
  }

  /// What the ports of a store hold at the start, where values are given.
  void begin_store(ElementId element, const std::vector<StartValue>& values, const Scene& scene) {
    const auto add = [&](std::size_t i, double stored) {
      const Given& given = initial_[key(element, values[i].port)];
      const double rounding =
          values[i].conjugate ? 0.0 : rounding_of(pool_, given.value, symbol_values_, symbol_errors_);
      inputs_.initial.push_back({element, values[i].port, stored, given.place, {}, rounding});
    };
    if (std::none_of(values.begin(), values.end(), [](const StartValue& v) { return v.conjugate; })) {
      for (std::size_t i = 0; i < values.size(); ++i) add(i, values[i].value);
      return;
    }
    const double start = scene.start.valid() ? evaluate(pool_, scene.start, symbol_values_) : 0.0;
    const StoredAtStart found = stored_at_start(model_, pool_, element, values, start, symbol_values_);
    for (std::size_t i = 0; found.fault.empty() && i < values.size(); ++i) add(i, found.stored[i]);
    if (found.fault.empty()) return;
    const Element& owner = model_.elements[element.index()];
    const StartValue& at = values[found.at];
    const std::string name = port_name(owner, at.port) + ".";
    problem("BG183",
            "the initial value " + name + initial_letter(owner, true) + " = " + number_text(at.value, 6) +
                " does not determine what " + in_quotes(owner.name) + " holds: " + found.fault,
            initial_[key(element, at.port)].place, "give " + name + initial_letter(owner, false) + " instead",
            "an initial effort or flow determines what is stored if the law of the store can be inverted");
  }

  void prepare_times(const Scene& scene) {
    std::optional<double> start = 0.0;
    if (scene.start.valid()) start = number(scene.start, "\"start\"", scene.start_place);
    const auto stop = number(scene.stop, "\"stop\"", scene.stop_place);
    if (!start || !stop) return;
    inputs_.start = *start;
    inputs_.stop = *stop;
    std::optional<PreparedTimes> prepared = output_times(scene, *start, *stop);
    if (!prepared) return;
    PreparedTimes& times = *prepared;
    const std::size_t columns = scene.outputs.empty() ? model_.outputs.size() : scene.outputs.size();
    constexpr double kMostNumbers = 1e9;
    if (times.fault.empty() &&
        static_cast<double>(times.times.size()) * (1.0 + static_cast<double>(columns)) > kMostNumbers) {
      times.fault = "the trace would hold more than 1e9 numbers";
      times.help = "ask for fewer samples or outputs";
    }
    if (times.fault.empty()) {
      inputs_.output_times = std::move(times.times);
      return;
    }
    const bool order = !(*stop >= *start);
    const Place place = times.at ? scene.times[*times.at].second : scene.interval_place;
    problem(order ? "BG143" : "BG144", "the scene " + in_quotes(scene.name) + ": " + times.fault,
            order || !place.node.valid() ? scene.stop_place : place, times.help);
  }

  /// None if one of them is not a number, which is reported.
  std::optional<PreparedTimes> output_times(const Scene& scene, double start, double stop) {
    if (scene.interval.valid()) {
      const auto interval = number(scene.interval, "\"interval\"", scene.interval_place);
      return interval ? std::optional(times_at_interval(start, stop, *interval)) : std::nullopt;
    }
    if (scene.log_samples) {
      std::optional<double> from;
      if (scene.log_from.valid()) from = number(scene.log_from, "\"from\"", scene.log_from_place);
      if (scene.log_from.valid() && !from) return std::nullopt;
      return times_by_logarithm(start, stop, *scene.log_samples, from);
    }
    if (scene.times.empty()) return times_by_number(start, stop, scene.samples);
    std::vector<double> list;
    for (const auto& [time, place] : scene.times)
      if (const auto value = number(time, "an output time", place)) list.push_back(*value);
    return list.size() == scene.times.size() ? std::optional(times_listed(start, stop, std::move(list))) : std::nullopt;
  }

  void choose_outputs(const Scene& scene) {
    if (scene.outputs.empty()) {
      for (std::size_t i = 0; i < model_.outputs.size(); ++i) inputs_.outputs.push_back(i);
      if (model_.outputs.empty())
        warn("BG149", "the model " + in_quotes(model_.name) + " has no outputs: its trace has only the times", head(),
             "add \"outputs\": { \"x\": \"spring.q\" }, say");
      return;
    }
    std::unordered_map<std::string_view, std::size_t> positions;
    for (std::size_t i = 0; i < model_.outputs.size(); ++i) positions.emplace(model_.outputs[i].name, i);
    for (const std::string& name : scene.outputs) inputs_.outputs.push_back(positions.at(name));
  }

  void prepare_tolerances(const Scene& scene) {
    inputs_.relative = overrides_.relative.value_or(scene.relative.value_or(1e-6));
    inputs_.absolute = overrides_.absolute ? overrides_.absolute : scene.absolute;
    if (!overrides_.absolute) inputs_.absolute_by_state = scene.absolute_by_state;
    if (!(inputs_.relative > 0.0 && inputs_.relative < 1.0))
      problem("BG146", "the relative tolerance must lie between 0 and 1", {}, "write 1e-6, say");
    if (inputs_.absolute && !(*inputs_.absolute > 0.0 && std::isfinite(*inputs_.absolute)))
      problem("BG146", "the absolute tolerance must be a finite number greater than 0", {},
              "leave it out: it then follows each state's own size");
  }

  /// Step and order are part of the method: a method from the command line does not take over the scene's.
  void prepare_method(const Scene& scene) {
    inputs_.method = overrides_.method.value_or(scene.method);
    const bool of_scene = inputs_.method == scene.method;
    const auto step = overrides_.step || !of_scene ? overrides_.step : scene.step;
    const auto max_order = overrides_.max_order || !of_scene ? overrides_.max_order : scene.max_order;
    const MethodFacts& facts = facts_of(inputs_.method);
    const std::string method = "the method " + in_quotes(facts.name);
    const std::optional<Place> place = overrides_.method ? std::nullopt : std::optional(scene.method_place);
    if (facts.fixed_step() && !step)
      problem("BG146", method + " needs a fixed step, which is not given", place,
              "give the step in units of t: \"step\": 1e-3 in the scene, or --step 1e-3");
    if (!facts.fixed_step() && step)
      problem("BG146", method + " chooses its steps by the tolerances; a step cannot be given", place,
              "remove the step, or use euler, implicit_euler, rk4 or verlet");
    if (step && !(*step > 0.0 && std::isfinite(*step)))
      problem("BG146", "the step must be a finite number greater than 0", place);
    if (max_order && facts.most_order == 0)
      problem("BG146", method + " has a fixed order, which cannot be limited", place, "remove the limit of the order");
    else if (max_order && (*max_order < 1 || *max_order > facts.most_order))
      problem("BG146", "the order of " + method + " is limited to 1 to " + std::to_string(facts.most_order), place);
    inputs_.step = step.value_or(0.0);
    inputs_.max_order = max_order.value_or(0);
  }

  // --- physics

  void warn(const char* code, std::string situation, std::optional<Place> place, std::string help = {},
            std::string rule = {}) {
    inputs_.warnings.push_back(diagnostic_of(code, std::move(situation), place, std::move(rule), std::move(help)));
  }

  /// Coefficients that depend on parameters alone are looked at before anything is computed from them.
  void check_coefficients() {
    const ParameterValues values(model_, pool_, symbol_values_);
    for (const Element& element : model_.elements) {
      if (!element.coefficient.valid()) continue;
      const auto value = values.of(element.coefficient);
      if (!value) continue;
      const std::string what = "the " + coefficient_words(element) + " of " + in_quotes(element.name);
      if (!std::isfinite(*value)) {
        number(element.coefficient, what, element.coefficient_place);
      } else if (is_store(element.kind) && *value == 0.0) {
        problem("BG145", what + " is " + number_text(*value, 6), element.coefficient_place,
                "leave the element out, or give it a small positive value",
                "a store takes energy in as it fills: its capacitance or inertance is not 0");
      } else if (is_store(element.kind) && *value < 0.0) {
        warn("BG180", what + " is " + number_text(*value, 6) + ": the store is unstable", element.coefficient_place,
             "if this is not intended, check the sign (a linearised inverted pendulum has such a spring)",
             "a negative store gives off energy as it fills");
      } else if (is_resistor(element.kind) && *value < 0.0) {
        warn("BG148", what + " is " + number_text(*value, 6) + ": the element is active", element.coefficient_place,
             "if it should not supply power, check the sign", "a negative resistance supplies power");
      }
    }
  }

  const Model& model_;
  ExprPool pool_;  ///< the model's, with what the command line adds
  const SceneOverrides& overrides_;
  RunInputs inputs_;
  std::unordered_map<std::string_view, std::size_t> parameters_;  ///< by name
  std::unordered_map<std::string, StorePort> states_;             ///< by name; empty until the first is asked for
  std::unordered_map<std::string, std::string> set_before_;       ///< what --set has set: target to the whole text
  std::vector<Given> values_;                                     ///< by ParameterId
  std::unordered_map<std::uint64_t, Given> initial_;              ///< by key()
  std::map<std::string, ExprId> set_parameters_, set_states_;     ///< by --set
  std::vector<double> symbol_values_;                             ///< of parameters; NaN for the others
  std::vector<double> symbol_errors_;                             ///< by SymbolId
  std::vector<std::size_t> parameter_order_;                      ///< each after those that it refers to
  std::vector<Diagnostic> problems_;
};

}  // namespace

RunInputs prepare_scene(const Model& model, const std::string& scene, const SceneOverrides& overrides) {
  return ScenePreparation(model, overrides).run(scene);
}

Model with_overrides(const Model& model, const std::string& scene, const SceneOverrides& overrides) {
  return ScenePreparation(model, overrides).settled(scene);
}

}  // namespace bgsim
