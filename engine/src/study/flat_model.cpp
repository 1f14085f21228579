#include "study/flat_model.hpp"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "bgsim/modes.hpp"
#include "bgsim/text.hpp"
#include "model/element_kinds.hpp"
#include "study/cut_graph.hpp"
#include "study/written_memory.hpp"

namespace bgsim {
namespace {

using Json = nlohmann::ordered_json;

/// Names of everything in a file without submodels.
struct FlatNames {
  std::vector<std::string> parameters, signals, elements, bonds, events;
};

FlatNames make_names(const Model& model) {
  std::unordered_set<std::string> taken;
  // b1, b2, ... are what bonds are called for want of a name.
  for (std::size_t i = 1; i <= model.bonds.size(); ++i) taken.insert("b" + std::to_string(i));
  const auto flat = [&taken](std::string name) {
    std::erase(name, ']');  // "cell[3].store" is cell_3_store
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c == '.' || c == '['; }, '_');
    while (!taken.insert(name).second) name += '_';
    return name;
  };
  FlatNames names;
  for (const Element& element : model.elements) names.elements.push_back(flat(element.name));
  for (const Parameter& parameter : model.parameters) names.parameters.push_back(flat(parameter.name));
  for (const Signal& signal : model.signals) names.signals.push_back(flat(signal.name));
  for (const ModelBond& bond : model.bonds) names.bonds.push_back(flat(bond.name));
  for (const ModelEvent& event : model.events) names.events.push_back(flat(event.name));
  return names;
}

/// A condition as the number that expressions have for it, 1 or 0, which they compare with 0.5. No model has this mark.
constexpr char kMark = '\x01';
std::string marked(const std::string& condition) { return kMark + condition + kMark; }

/// What is compared with 0.5 is written as the condition that it is.
std::string as_conditions(std::string text) {
  const std::string compared = " > 0.5";
  for (auto begin = text.find(kMark); begin != std::string::npos; begin = text.find(kMark)) {
    const auto end = text.find(kMark, begin + 1);
    const std::string condition = text.substr(begin + 1, end - begin - 1);
    const bool whole = text.compare(end + 1, compared.size(), compared) == 0;
    text.replace(begin, end + 1 - begin + (whole ? compared.size() : 0),
                 whole ? condition : "if(" + condition + ", 1, 0)");
  }
  return text;
}

/// `{ "key": value, ... }` on one line.
std::string one_line(const Json& object) {
  if (!object.is_object()) return json_text(object);
  std::string text = "{";
  for (const auto& [key, value] : object.items())
    text += (text.size() > 1 ? ", " : " ") + json_text(Json(key)) + ": " + one_line(value);
  return text + " }";
}

/// `"section": { ... }`, a line for each member.
std::string section(const std::string& name, const Json& members) {
  const bool array = members.is_array();
  std::string text = "  " + json_text(Json(name)) + (array ? ": [" : ": {");
  const char* comma = "";
  for (const auto& [key, value] : members.items()) {
    text += std::string(comma) + "\n    " + (array ? "" : json_text(Json(key)) + ": ") + one_line(value);
    comma = ",";
  }
  return text + (array ? "\n  ]" : "\n  }");
}

class FlatWriter {
 public:
  FlatWriter(const Model& model, const BondGraph& graph, const FlatModelOptions& options)
      : model_(model),
        options_(options),
        names_(make_names(model)),
        pool_(model.pool),
        cut_(graph, options.cuts, options.dropped),
        memory_(written_memory(model)) {
    for (const Scene& scene : model.scenes)
      if (scene.name == options.scene) scene_ = &scene;
    if (scene_ == nullptr) throw std::invalid_argument("there is no scene \"" + options.scene + "\"");
    used_parameter_.assign(model.parameters.size(), false);
    used_signal_.assign(model.signals.size(), false);
    used_bond_.assign(model.bonds.size(), false);
    for (std::size_t i = 0; i < model.elements.size(); ++i)
      if (model.elements[i].contact)
        names_.signals[model.elements[i].contact->displacement.index()] = names_.elements[i] + ".q";
    for (std::size_t i = 0; i < memory_.size(); ++i)
      if (memory_[i].kind == WrittenMemory::Kind::previous)
        names_.signals[i] = "previous(" + names_.signals[memory_[i].of.index()] + ")";
    replace_cut_variables(graph);
    // What is written says which signals, parameters and junctions are needed; so parameters come last.
    write_outputs();
    write_elements();
    write_signals_and_events();
    write_scene();
    drop_junctions(graph);
    write_bonds();
    write_parameters();
  }

  [[nodiscard]] std::string text() const {
    std::string text = "{\n  \"bgsim\": 1,\n  \"name\": " + json_text(Json(options_.name)) + ",\n";
    text += "  \"about\": " + json_text(Json(options_.about)) + ",\n";
    if (!model_.source.empty()) text += "  \"source\": " + json_text(Json(model_.source)) + ",\n";
    if (!parameters_.empty()) text += section("parameters", parameters_) + ",\n";
    if (!signals_.empty()) text += section("signals", signals_) + ",\n";
    text += section("elements", elements_) + ",\n" + section("bonds", bonds_) + ",\n";
    if (!events_.empty()) text += section("events", events_) + ",\n";
    text += section("outputs", outputs_) + ",\n" + section("scenes", scenes_) + "\n}\n";
    return text;
  }

 private:
  // --- expressions

  /// What expressions say of cut elements: replaced, or nothing left to say.
  void replace_cut_variables(const BondGraph& graph) {
    for (const Cut& cut : options_.cuts) {
      const Element& element = model_.elements[cut.element.index()];
      const PortId port = graph.port(cut.element, 0);
      const BondId bond = graph[port].bond;
      const bool into = graph[port].head;
      const auto variable = [&](Variable v) { return port_variable(element, 0, v); };
      const ExprId zero = pool_.constant(0.0);
      const bool no_effort = cut.kind == CutKind::zero_effort;
      if (cut_.gone(cut.element)) {
        const Element& junction = model_.elements[graph[graph.opposite(port)].element.index()];
        const ExprId shared = pool_.symbol(junction.first_symbol);
        replacement_[variable(Variable::effort)] = no_effort ? zero : shared;
        replacement_[variable(Variable::flow)] = no_effort ? (into ? shared : pool_.neg(shared)) : zero;
        replacement_[bond_symbol(bond, Variable::effort)] = no_effort ? zero : shared;
        replacement_[bond_symbol(bond, Variable::flow)] = no_effort ? shared : zero;
      } else if (!into) {
        // A source counts its flow along the half-arrow, what it replaces counted it inwards.
        replacement_[variable(Variable::flow)] = pool_.neg(pool_.symbol(variable(Variable::flow)));
      }
      if (!is_store(element.kind)) continue;
      const bool stays = stores_displacement(element, 0) && !no_effort;
      const SymbolId stored = variable(stored_variable(element, 0));
      if (stays)
        replacement_[stored] = initial_of(element);
      else
        undefined_[stored] = element.name + "." + letter(stored_variable(element, 0));
    }
  }

  [[nodiscard]] SymbolId bond_symbol(BondId bond, Variable variable) {
    if (bond_symbols_.empty())
      for (std::size_t i = 0; i < model_.symbols.size(); ++i)
        if (model_.symbols[i].kind == ModelSymbol::Kind::bond_variable)
          bond_symbols_[model_.symbols[i].bond.index() * 2 + (model_.symbols[i].variable == Variable::flow ? 1 : 0)] =
              SymbolId(i);
    const auto found = bond_symbols_.find(bond.index() * 2 + (variable == Variable::flow ? 1 : 0));
    return found == bond_symbols_.end() ? SymbolId{} : found->second;
  }

  /// The displacement at which a C without flow stays.
  [[nodiscard]] ExprId initial_of(const Element& element) {
    if (const auto found = scene_->initial.find(element.name + ".q"); found != scene_->initial.end())
      return found->second.first;
    return element.initial.empty() ? pool_.constant(0.0) : element.initial.front().value;
  }

  /// A number, or an expression over flat names; marks what it uses. @param user  for whom, in words.
  Json value(ExprId expression, const std::string& user) {
    const std::vector<ExprId> before{expression};
    for (const SymbolId symbol : symbols_in(pool_, before))
      if (const auto found = undefined_.find(symbol); found != undefined_.end())
        throw CutRefused(user + " needs " + found->second);
    const ExprId e = substitute(pool_, expression, replacement_);
    if (pool_.is_constant(e)) return pool_[e].constant;
    const std::vector<ExprId> roots{e};
    for (const SymbolId symbol : symbols_in(pool_, roots)) use(symbol, user);
    std::string text = as_conditions(to_text(pool_, e, [this](SymbolId s) { return symbol_text(s); }));
    for (const auto& table : pool_.tables()) relocate(text, table->file);
    return text;
  }

  /// The same of a condition, which a cut may have decided.
  Json condition(ExprId expression, const std::string& user) {
    Json written = value(expression, user);
    if (!written.is_number()) return written;
    return written.get<double>() != 0.0 ? "0 < 1" : "1 < 0";
  }

  void use(SymbolId symbol, const std::string& user) {
    const ModelSymbol& s = model_.symbols[symbol.index()];
    if (s.kind == ModelSymbol::Kind::parameter) used_parameter_[s.parameter.index()] = true;
    if (s.kind == ModelSymbol::Kind::signal) used_signal_[s.signal.index()] = true;
    if (s.kind == ModelSymbol::Kind::bond_variable) used_bond_[s.bond.index()] = true;
    if (s.kind != ModelSymbol::Kind::port_variable && s.kind != ModelSymbol::Kind::mode) return;
    // Variables of what is cut have been replaced: this one is dropped.
    if (cut_.gone(s.element))
      throw CutRefused(user + " needs \"" + model_.elements[s.element.index()].name + "\"", {s.element});
    cut_.use(s.element);
  }

  [[nodiscard]] std::string symbol_text(SymbolId symbol) const {
    const ModelSymbol& s = model_.symbols[symbol.index()];
    switch (s.kind) {
      case ModelSymbol::Kind::time:
        return "t";
      case ModelSymbol::Kind::parameter:
        return names_.parameters[s.parameter.index()];
      case ModelSymbol::Kind::signal:
        if (memory_[s.signal.index()].kind == WrittenMemory::Kind::latch)
          return marked(names_.signals[s.signal.index()]);
        return names_.signals[s.signal.index()];
      case ModelSymbol::Kind::bond_variable:
        return names_.bonds[s.bond.index()] + "." + letter(s.variable);
      case ModelSymbol::Kind::mode:
        return marked("mode('" + names_.elements[s.element.index()] + "')");
      case ModelSymbol::Kind::port_variable:
        break;
    }
    const Element& element = model_.elements[s.element.index()];
    const std::string port = port_count(element) > 1 ? "." + element.ports[s.port] : "";
    return names_.elements[s.element.index()] + port + "." + letter(s.variable);
  }

  /// Names a data file from where the new model stands.
  void relocate(std::string& text, const std::string& file) const {
    std::error_code ignored;
    const std::filesystem::path folder = std::filesystem::path(options_.file).parent_path();
    const std::string from_here =
        std::filesystem::proximate(file, folder.empty() ? std::filesystem::path(".") : folder, ignored).string();
    for (const char quote : {'"', '\''}) {
      const std::string old = quote + file + quote, now = quote + from_here + quote;
      for (auto at = text.find(old); at != std::string::npos; at = text.find(old, at + now.size()))
        text.replace(at, old.size(), now);
    }
  }

  // --- sections

  static void add_texts(Json& object, const std::string& unit, const std::string& about) {
    if (!unit.empty()) object["unit"] = unit;
    if (!about.empty()) object["about"] = about;
  }

  void write_outputs() {
    for (const Output& output : model_.outputs) {
      const auto& wanted = scene_->outputs;
      if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), output.name) == wanted.end()) continue;
      Json entry{{"value", value(output.value, "the output \"" + output.name + "\"")}};
      add_texts(entry, output.unit, {});
      outputs_[output.name] = std::move(entry);
    }
  }

  void write_elements() {
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      const Element& element = model_.elements[i];
      const auto cut = std::find_if(options_.cuts.begin(), options_.cuts.end(),
                                    [&](const Cut& c) { return c.element == ElementId(i); });
      if (cut_.gone(ElementId(i))) continue;
      if (cut == options_.cuts.end())
        elements_[names_.elements[i]] = element_json(element);
      else
        elements_[names_.elements[i]] = cut->kind == CutKind::zero_effort
                                            ? Json{{"kind", "Se"}, {"effort", 0}, {"about", "cut: zero effort"}}
                                            : Json{{"kind", "Sf"}, {"flow", 0}, {"about", "cut: zero flow"}};
    }
  }

  Json element_json(const Element& element) {
    const std::string user = "\"" + element.name + "\"";
    Json json{{"kind", kind_text(element.kind, element.modulated)}};
    const bool field = is_field(element.kind);
    if (field && element.stored.empty()) json["ports"] = element.ports;
    for (std::size_t port = 0; port < element.stored.size(); ++port)
      json["ports"][element.ports[port]] = std::string(1, letter(element.stored[port]));
    if (element.switches)
      write_switch(json, element, user);
    else if (element.contact)
      write_contact(json, element, user);
    else if (element.diode)
      write_diode(json, element, user);
    else if (element.coefficient.valid())
      json[coefficient_words(element)] = value(element.coefficient, user);
    if (element.energy.valid()) json["energy"] = value(element.energy, user);
    Json laws = Json::array();
    for (const Law& law : element.laws) laws.push_back(law_text(element, law, user));
    if (field && !laws.empty())
      json["laws"] = std::move(laws);
    else if (!laws.empty())
      json["law"] = laws.front();
    for (const InitialValue& initial : element.initial) {
      const std::string key = std::string(field ? element.ports[initial.port] + "." : "") +
                              letter(initial.conjugate ? conjugate_variable(element, initial.port)
                                                       : stored_variable(element, initial.port));
      json["initial"][key] = value(initial.value, user);
    }
    if (element.priority != 0.0) json["priority"] = element.priority;
    add_texts(json, {}, element.about);
    return json;
  }

  void write_switch(Json& json, const Element& element, const std::string& user) {
    const SwitchLaw& law = *element.switches;
    if (!law.remembers) {
      json[law.locks ? "locked" : "closed"] = condition(law.locks ? law.opens : law.closes, user);
      return;
    }
    json["close"] = condition(law.closes, user);
    json["open"] = condition(law.opens, user);
    if (is_closed(element)) json["initial"] = "closed";
  }

  void write_contact(Json& json, const Element& element, const std::string& user) {
    json["gap"] = value(element.coefficient, user);
    const Signal& displacement = model_.signals[element.contact->displacement.index()];
    if (displacement.initial.valid()) json["initial"]["q"] = value(displacement.initial, user);
    const ExprId restitution = element.contact->restitution;
    if (model_.pool.is_constant(restitution, 0.0)) return;
    json["restitution"] = value(restitution, user);
  }

  void write_diode(Json& json, const Element& element, const std::string& user) {
    if (element.diode->out) json["passes"] = "out";
    if (!model_.pool.is_constant(element.coefficient, 0.0)) json["threshold"] = value(element.coefficient, user);
    if (element.diode->fire.valid()) json["fire"] = condition(element.diode->fire, user);
  }

  std::string law_text(const Element& element, const Law& law, const std::string& user) {
    const Json right = value(law.right, user);
    if (law.zero) return "0 = " + (right.is_string() ? right.get<std::string>() : json_text(right));
    const std::string port = port_count(element) > 1 ? element.ports[law.port] + "." : "";
    return port + letter(law.variable) + " = " + (right.is_string() ? right.get<std::string>() : json_text(right));
  }

  /// The displacement of a contact, which belongs to its element.
  [[nodiscard]] bool of_contact(std::size_t signal) const {
    return std::any_of(model_.elements.begin(), model_.elements.end(), [signal](const Element& element) {
      return element.contact && element.contact->displacement.index() == signal;
    });
  }

  /// Signals that are used, and those that they use; events that set what is used, and what they use.
  void write_signals_and_events() {
    std::vector<Json> signals(model_.signals.size()), events(model_.events.size());
    std::vector<bool> signal_done(model_.signals.size(), false), event_done(model_.events.size(), false);
    for (bool more = true; more;) {
      more = false;
      for (std::size_t i = 0; i < model_.signals.size(); ++i) {
        if (!used_signal_[i] || signal_done[i] || of_contact(i)) continue;
        signals[i] = signal_json(i);
        signal_done[i] = more = true;
      }
      for (std::size_t i = 0; i < model_.events.size(); ++i) {
        const ModelEvent& event = model_.events[i];
        if (event_done[i] || is_of_memory(event) || !sets_what_is_used(event)) continue;
        events[i] = event_json(event);
        event_done[i] = more = true;
      }
    }
    for (std::size_t i = 0; i < signals.size(); ++i)
      if (signal_done[i] && memory_[i].kind != WrittenMemory::Kind::previous)
        signals_[names_.signals[i]] = std::move(signals[i]);
    for (std::size_t i = 0; i < events.size(); ++i)
      if (event_done[i]) events_[names_.events[i]] = std::move(events[i]);
  }

  Json signal_json(std::size_t i) {
    const Signal& signal = model_.signals[i];
    const WrittenMemory& memory = memory_[i];
    const std::string user = "the signal \"" + signal.name + "\"";
    Json json = Json::object();
    switch (memory.kind) {
      case WrittenMemory::Kind::previous:
        used_signal_[memory.of.index()] = true;
        return json;
      case WrittenMemory::Kind::latch:
        json["set"] = condition(memory.takes->when, user);
        json["reset"] = condition(memory.resets->when, user);
        if (model_.pool.is_constant(signal.initial, 1.0)) json["initial"] = true;
        add_texts(json, {}, signal.about);
        return json;
      case WrittenMemory::Kind::sampled:
        json["value"] = value(memory.takes->sets.front().value, user);
        json["every"] = value(signal.every, user);
        if (!model_.pool.is_constant(signal.offset, 0.0)) json["offset"] = value(signal.offset, user);
        break;
      case WrittenMemory::Kind::none:
        if (signal.delay) {
          json["delay"] = value(signal.delay->value, user);
          json["by"] = value(signal.delay->by, user);
        } else {
          json[signal.is_state() ? "integral" : "value"] = value(signal.value, user);
        }
    }
    const ExprId initial = signal.delay ? signal.delay->initial : signal.initial;
    if (initial.valid()) json["initial"] = value(initial, user);
    add_texts(json, signal.unit, signal.about);
    return json;
  }

  [[nodiscard]] bool sets_what_is_used(const ModelEvent& event) const {
    return std::any_of(event.sets.begin(), event.sets.end(), [&](const ModelEvent::Set& set) {
      return set.element.valid() ? !cut_.gone(set.element) : bool(used_signal_[set.signal.index()]);
    });
  }

  Json event_json(const ModelEvent& event) {
    const std::string user = "the event \"" + event.name + "\"";
    Json json{{"when", condition(event.when, user)}};
    for (const ModelEvent::Set& set : event.sets) {
      std::string name;
      if (set.element.valid()) {
        const Element& store = model_.elements[set.element.index()];
        if (cut_.is_cut(set.element) || cut_.gone(set.element))
          throw CutRefused(user + " sets what \"" + store.name + "\" holds", {set.element});
        const SymbolId stored = port_variable(store, set.port, stored_variable(store, set.port));
        use(stored, user);
        name = symbol_text(stored);
      } else {
        used_signal_[set.signal.index()] = true;
        name = names_.signals[set.signal.index()];
      }
      json["set"][name] = value(set.value, user);
    }
    if (event.priority != 0.0) json["priority"] = event.priority;
    return json;
  }

  void drop_junctions(const BondGraph& graph) {
    for (const ElementId junction : cut_.drop_dangling(graph)) elements_.erase(names_.elements[junction.index()]);
  }

  void write_bonds() {
    bonds_ = Json::array();
    const auto end = [this](const BondEndText& e) {
      const Element& element = model_.elements[e.element.index()];
      const bool port = e.port && port_count(element) > 1;
      return names_.elements[e.element.index()] + (port ? "." + element.ports[*e.port] : "");
    };
    for (std::size_t i = 0; i < model_.bonds.size(); ++i) {
      if (cut_.gone(BondId(i))) {
        const ModelBond& bond = model_.bonds[i];
        if (used_bond_[i])
          throw CutRefused("something needs the bond \"" + bond.name + "\"", {bond.from.element, bond.to.element});
        continue;
      }
      Json bond{{"from", end(model_.bonds[i].from)}, {"to", end(model_.bonds[i].to)}};
      if (used_bond_[i]) bond["name"] = names_.bonds[i];
      bonds_.push_back(std::move(bond));
    }
  }

  void write_scene() {
    const std::string user = "the scene";
    Json scene = Json::object();
    if (!scene_->about.empty()) scene["about"] = scene_->about;
    if (scene_->start.valid()) scene["start"] = value(scene_->start, user);
    scene["stop"] = value(scene_->stop, user);
    if (scene_->samples) scene["samples"] = *scene_->samples;
    if (scene_->interval.valid()) scene["interval"] = value(scene_->interval, user);
    if (scene_->log_samples) scene["samples"] = Json{{"log", *scene_->log_samples}};
    if (scene_->log_from.valid()) scene["samples"]["from"] = value(scene_->log_from, user);
    for (const auto& [time, place] : scene_->times) scene["times"].push_back(value(time, user));
    const auto state = [&](const std::string& name) { return state_text(name); };
    for (const auto& [name, given] : scene_->initial)
      if (const auto flat = state(name)) scene["initial"][*flat] = value(given.first, user);
    if (!scene_->outputs.empty()) scene["outputs"] = scene_->outputs;
    if (scene_->relative) scene["relative"] = *scene_->relative;
    if (scene_->absolute) scene["absolute"] = *scene_->absolute;
    for (const auto& [name, tolerance] : scene_->absolute_by_state)
      if (const auto flat = state(name)) scene["absolute"][*flat] = tolerance;
    if (scene_->method != Method::automatic) scene["method"] = method_name(scene_->method);
    if (scene_->step) scene["step"] = *scene_->step;
    if (scene_->max_order) scene["max_order"] = *scene_->max_order;
    if (!scene_->close_zeno) scene["zeno"] = "error";
    if (scene_->sequential_impacts) scene["impacts"] = "sequential";
    if (scene_->max_events) scene["max_events"] = *scene_->max_events;
    if (!options_.reference.empty())
      scene["reference"] = {{"file", options_.reference}, {"relative", options_.reference_relative}};
    scene_json_ = std::move(scene);
  }

  /// "left.packet.wall.q" as "left_packet.wall.q"; none if its element has been cut, or its signal is not used.
  [[nodiscard]] std::optional<std::string> state_text(const std::string& name) const {
    for (std::size_t i = 0; i < model_.signals.size(); ++i)
      if (model_.signals[i].is_state() && model_.signals[i].name == name)
        return used_signal_[i] ? std::optional(names_.signals[i]) : std::nullopt;
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      const Element& element = model_.elements[i];
      if (!is_store(element.kind) || name.rfind(element.name + ".", 0) != 0) continue;
      for (std::size_t k = 0; k < port_count(element); ++k) {
        const std::string suffix = name.substr(name.size() - 2);
        if (port_name(element, k) + suffix != name) continue;
        if (cut_.is_cut(ElementId(i)) || cut_.gone(ElementId(i))) return std::nullopt;
        return names_.elements[i] + name.substr(element.name.size());
      }
    }
    return std::nullopt;
  }

  /// Parameters that are used, and those that they use; the scene's values of them.
  void write_parameters() {
    std::vector<Json> entries(model_.parameters.size());
    std::vector<bool> done(model_.parameters.size(), false);
    Json overrides = Json::object();
    for (bool more = true; more;) {
      more = false;
      for (std::size_t i = 0; i < model_.parameters.size(); ++i) {
        if (!used_parameter_[i] || done[i]) continue;
        const Parameter& parameter = model_.parameters[i];
        const std::string user = "the parameter \"" + parameter.name + "\"";
        entries[i] = {{"value", value(parameter.value, user)}};
        add_texts(entries[i], parameter.unit, parameter.about);
        if (const auto found = scene_->parameters.find(parameter.name); found != scene_->parameters.end())
          overrides[names_.parameters[i]] = value(found->second.first, user);
        done[i] = more = true;
      }
    }
    for (std::size_t i = 0; i < entries.size(); ++i)
      if (done[i]) parameters_[names_.parameters[i]] = std::move(entries[i]);
    if (!overrides.empty()) scene_json_["parameters"] = std::move(overrides);
    scenes_[scene_->name] = std::move(scene_json_);
  }

  const Model& model_;
  const FlatModelOptions& options_;
  FlatNames names_;
  ExprPool pool_;
  CutGraph cut_;
  std::vector<WrittenMemory> memory_;  ///< by SignalId
  const Scene* scene_ = nullptr;
  std::unordered_map<SymbolId, ExprId> replacement_;
  std::unordered_map<SymbolId, std::string> undefined_;
  std::unordered_map<std::size_t, SymbolId> bond_symbols_;
  std::vector<bool> used_parameter_, used_signal_, used_bond_;
  Json parameters_ = Json::object(), signals_ = Json::object(), elements_ = Json::object(), bonds_,
       events_ = Json::object(), outputs_ = Json::object(), scenes_ = Json::object(), scene_json_;
};

}  // namespace

std::string cut_text(CutKind kind) { return kind == CutKind::zero_effort ? "zero effort" : "zero flow"; }

std::vector<std::string> flat_names(const Model& model) { return make_names(model).elements; }

std::string flat_model_json(const Model& model, const BondGraph& graph, const FlatModelOptions& options) {
  return FlatWriter(model, graph, options).text();
}

}  // namespace bgsim
