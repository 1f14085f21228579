// What is said of a model outside of its files: parameters in files of their own, and the command line's changes of
// outputs and times. Both are read as documents, so that their faults have places.

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "bgsim/unit.hpp"
#include "read/reader.hpp"

namespace bgsim {
namespace {

using Json = nlohmann::ordered_json;

/// A text from the command line, which may hold any bytes, as JSON.
std::string json_string(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// What the command line says as a document: a line for each option.
std::string command_line_text(const ReadOptions& options) {
  std::string text;
  const auto add = [&text](const char* key, const std::string& value) {
    text += std::string(text.empty() ? "{ " : ",\n  ") + "\"" + key + "\": " + value;
  };
  if (options.start) add("start", json_string(*options.start));
  if (options.stop) add("stop", json_string(*options.stop));
  if (options.interval) add("interval", json_string(*options.interval));
  if (options.samples) add("samples", std::to_string(*options.samples));
  std::string outputs, record;
  for (const auto& [name, value] : options.outputs)
    outputs += (outputs.empty() ? "{ " : ", ") + json_string(name) + ": " + json_string(value);
  if (!outputs.empty()) add("outputs", outputs + " }");
  for (const std::string& name : options.record) record += (record.empty() ? "[" : ", ") + json_string(name);
  if (!record.empty()) add("record", record + "]");
  return text.empty() ? text : text + " }";
}

/// The other name by which an initial value says what a store holds: "mass.f" for "mass.p".
std::string other_name(std::string name) {
  constexpr std::string_view kLetters = "qepf", kOthers = "eqfp";
  const std::size_t dot = name.rfind('.');
  const auto at = dot != std::string::npos && dot + 2 == name.size() ? kLetters.find(name.back()) : std::string::npos;
  if (at == std::string::npos) return {};
  name.back() = kOthers[at];
  return name;
}

}  // namespace

void Reader::apply_options() {
  for (const std::string& path : options_.parameter_files) read_parameter_file(path);
  read_command_line();
}

// --- parameters

void Reader::read_parameter_file(const std::string& path) {
  const DocumentId id = load_parameters(path);
  if (!id.valid() || !expect(document(id), Document::root(), JsonKind::object, "a file of parameters")) return;
  scopes_.push_back({"", id, 0, {}});
  const Document& file = document(id);
  for (NodeId node = file[Document::root()].first_child; node.valid(); node = file[node].next_sibling)
    set_from_file(scopes_.size() - 1, node);
}

/// A parameter or an initial value, in every scene.
void Reader::set_from_file(std::size_t scope, NodeId node) {
  static constexpr std::array<std::string_view, 4> kKeys{"value", "unit", "about", "source"};
  const Document& file = document(scopes_[scope]);
  const std::string name(file[node].key);
  const auto found = names_.find(name);
  const bool parameter = found != names_.end() && found->second.kind == Entity::Kind::parameter;
  if (is_broken(0, name)) return;
  if (!parameter && !state_named(name, true)) {
    std::vector<std::string> candidates = known_names({0, nullptr, "a parameter"});
    for (std::string& state : state_names()) candidates.push_back(std::move(state));
    problem("BG190", "there is no parameter or state " + in_quotes(name) + " for the file to set", file.key_place(node),
            suggestion(name, candidates),
            "a file of parameters sets parameters and initial values by their full names, as --set does");
    return;
  }
  NodeId value = node;
  if (file[node].kind == JsonKind::object) {
    check_keys(file, node, kKeys, "a parameter");
    text_of(file, node, "about");
    text_of(file, node, "source");
    value = file.find(node, "value");
    if (!value.valid())
      return missing(file, node, "the parameter " + in_quotes(name) + " has no \"value\"", file.key_place(node),
                     "add \"value\": a number or an expression");
    const NodeId unit = file.find(node, "unit");
    if (unit.valid() && !parameter)
      return problem("BG191", "the initial value " + in_quotes(name) + " has a \"unit\"", file.place(unit),
                     "leave it out: the unit of a state follows from the model");
    if (unit.valid() && !check_file_unit(model_.parameters[found->second.index], file, unit)) return;
  }
  const ExprId set = expression({scope, nullptr, "a parameter"}, value, "a parameter");
  if (!set.valid()) return;
  for (Scene& scene : model_.scenes) {
    if (!parameter) scene.initial.erase(other_name(name));
    (parameter ? scene.parameters : scene.initial)[name] = {set, file.place(value)};
  }
}

/// A unit must be the model's own. One that the model does not give is from here on the parameter's.
bool Reader::check_file_unit(Parameter& parameter, const Document& file, NodeId node) {
  const std::string text = expect(file, node, JsonKind::string, "\"unit\"") ? std::string(file[node].text) : "";
  if (text.empty()) return false;
  if (parameter.unit.empty()) {
    parameter.unit = text;
    parameter.unit_place = file.place(node);
    return true;
  }
  const ParsedUnit here = parse_unit(text), there = parse_unit(parameter.unit);
  const bool same = here.unit && there.unit ? same_unit(*here.unit, *there.unit) : text == parameter.unit;
  if (!same)
    problem("BG191",
            "the parameter " + in_quotes(parameter.name) + " is in " + in_quotes(parameter.unit) +
                ", the file gives it in " + in_quotes(text),
            file.place(node), "write its value in " + in_quotes(parameter.unit), "no unit is converted silently",
            {{parameter.unit_place, "its unit is given here"}});
  return same;
}

// --- the command line

void Reader::read_command_line() {
  std::string text = command_line_text(options_);
  if (text.empty()) return;
  const DocumentId id = add_document(kCommandLine, std::move(text), true);
  if (!id.valid()) return;
  scopes_.push_back({"", id, 0, {}});
  const std::size_t scope = scopes_.size() - 1;
  change_times(scope);
  command_line_scope_ = scope;
  if (!options_.outputs.empty()) add_outputs(scope);
  const NodeId list = document(id).find(Document::root(), "record");
  if (list.valid() && problems_.empty()) record(scope, list);
}

void Reader::change_times(std::size_t scope) {
  const NodeId root = Document::root();
  const bool other_times = options_.interval || options_.samples;
  for (Scene& scene : model_.scenes) {
    parse_time(scope, root, "start", scene.start, scene.start_place);
    parse_time(scope, root, "stop", scene.stop, scene.stop_place);
    if (!other_times) continue;
    scene.samples.reset();
    scene.log_samples.reset();
    scene.interval = scene.log_from = {};
    scene.times.clear();
    parse_output_times(scope, root, scene);
  }
}

/// Further outputs are recorded by every scene.
void Reader::add_outputs(std::size_t scope) {
  const std::size_t before = model_.outputs.size();
  parse_outputs(scope);
  for (Scene& scene : model_.scenes)
    for (std::size_t i = before; i < model_.outputs.size() && !scene.outputs.empty(); ++i)
      scene.outputs.push_back(model_.outputs[i].name);
}

/// What is recorded in place of the scenes' outputs; further outputs are recorded in any case.
void Reader::record(std::size_t scope, NodeId list) {
  const Document& file = document(scopes_[scope]);
  std::vector<std::string> names;
  for (NodeId item = file[list].first_child; item.valid(); item = file[item].next_sibling)
    record_name(scope, item, names);
  for (const auto& [name, value] : options_.outputs) names.push_back(name);
  std::unordered_set<std::string> seen;
  std::erase_if(names, [&](const std::string& name) { return !seen.insert(name).second; });
  if (names.empty() && problems_.empty())
    problem("BG192", "there is nothing to record", file.place(list), "name quantities, or leave --record out");
  for (Scene& scene : model_.scenes) scene.outputs = names;
}

void Reader::record_name(std::size_t scope, NodeId item, std::vector<std::string>& names) {
  const Document& file = document(scopes_[scope]);
  const std::string_view name = file[item].text;
  const Place place = file.place(item);
  if (name == "all" || name == "states" || name == "outputs") return record_group(name, place, names);
  if (outputs_.contains(std::string(name))) return names.emplace_back(name), void();
  const ExprId quantity = parse({scope, nullptr, nullptr}, item, name, 0);
  if (!quantity.valid()) return;
  const bool column = model_.pool.is_symbol(quantity) && model_.pool.symbol_of(quantity) != model_.time;
  if (column) return record_symbol(model_.pool.symbol_of(quantity), place, names);
  problem("BG192", in_quotes(name) + " is neither an output nor a quantity of the model", place,
          "write --output NAME=EXPR to record an expression",
          "--record takes names, and the groups all, states, outputs");
}

/// Outputs; what stores hold, and integrals; or these and every effort, flow and signal.
void Reader::record_group(std::string_view group, const Place& place, std::vector<std::string>& names) {
  if (group != "states")
    for (const Output& output : model_.outputs) names.push_back(output.name);
  if (group == "outputs") return;
  const bool all = group == "all";
  for (const Element& element : model_.elements) {
    const bool junction = is_junction(element.kind);
    if (junction && all) record_symbol(element.first_symbol, place, names);
    for (std::size_t port = 0; !junction && port < port_count(element); ++port) {
      if (all) record_symbol(port_variable(element, port, Variable::effort), place, names);
      if (all) record_symbol(port_variable(element, port, Variable::flow), place, names);
      if (is_store(element.kind))
        record_symbol(port_variable(element, port, stored_variable(element, port)), place, names);
    }
  }
  for (std::size_t i = 0; all && i < model_.bonds.size(); ++i) {
    const auto at_junction = [&](const BondEndText& end) {
      return is_junction(model_.elements[end.element.index()].kind);
    };
    if (!at_junction(model_.bonds[i].from) || !at_junction(model_.bonds[i].to)) continue;  // known by its element
    for (const Variable variable : {Variable::effort, Variable::flow})
      record_symbol(bond_symbol(BondId(i), variable), place, names);
  }
  for (const Signal& signal : model_.signals)
    if (all || signal.is_state()) record_symbol(signal.symbol, place, names);
}

/// A quantity under its own name. Where an output of that name is something else, both are recorded.
void Reader::record_symbol(SymbolId symbol, const Place& place, std::vector<std::string>& names) {
  Output column;
  column.value = model_.pool.symbol(symbol);
  column.place = place;
  column.name = symbol_name(model_, symbol);
  for (auto there = outputs_.find(column.name); there != outputs_.end(); there = outputs_.find(column.name)) {
    if (model_.outputs[there->second].value == column.value) return names.push_back(column.name);
    column.name += model_.symbols[symbol.index()].kind == ModelSymbol::Kind::signal ? " (signal)" : " (of the model)";
  }
  outputs_.emplace(column.name, model_.outputs.size());
  names.push_back(column.name);
  model_.outputs.push_back(std::move(column));
}

}  // namespace bgsim
