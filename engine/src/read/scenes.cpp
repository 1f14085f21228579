#include <algorithm>
#include <array>
#include <cmath>

#include "read/other_keys.hpp"
#include "read/reader.hpp"

namespace bgsim {

/// Scenes of submodels are not taken over, as their outputs are not.
void Reader::parse_scenes() {
  const NodeId object = section(scopes_[0], "scenes", JsonKind::object);
  if (!object.valid()) return;
  const Document& file = document(scopes_[0]);
  for (NodeId node = file[object].first_child; node.valid(); node = file[node].next_sibling) parse_scene(node);
}

void Reader::parse_scene(NodeId node) {
  static constexpr std::array<std::string_view, 18> kKeys{
      "about",    "start",    "stop",   "samples", "interval",  "times",     "parameters", "initial",    "outputs",
      "relative", "absolute", "method", "step",    "max_order", "reference", "zeno",       "max_events", "impacts"};
  const Document& file = document(scopes_[0]);
  Scene scene;
  scene.name = file[node].key;
  scene.place = file.key_place(node);
  if (!valid_title(scene.name, scene.place, "a scene")) return;
  if (!expect(file, node, JsonKind::object, "a scene")) return;
  check_keys(file, node, kKeys, "a scene");
  scene.about = text_of(file, node, "about");
  parse_times(node, scene);
  parse_scene_parameters(node, scene);
  parse_scene_initial(node, scene);
  parse_scene_outputs(node, scene);
  parse_tolerances(node, scene);
  parse_method(node, scene);
  parse_reference(node, scene);
  model_.scenes.push_back(std::move(scene));
}

void Reader::parse_times(NodeId node, Scene& scene) {
  const Document& file = document(scopes_[0]);
  parse_time(0, node, "start", scene.start, scene.start_place);
  if (!parse_time(0, node, "stop", scene.stop, scene.stop_place))
    missing(file, node, "the scene " + in_quotes(scene.name) + " has no \"stop\"", scene.place,
            "add \"stop\": the time at which it ends");
  parse_output_times(0, node, scene);
}

/// One time of a scene. False if it is not given.
bool Reader::parse_time(std::size_t scope, NodeId object, const char* key, ExprId& time, Place& place) {
  const Document& file = document(scopes_[scope]);
  const NodeId value = file.find(object, key);
  if (!value.valid()) return false;
  const std::string what = in_quotes(key);
  place = file.place(value);
  time = expression({scope, nullptr, what.c_str()}, value, what);
  return true;
}

/// One of "samples", "interval" and "times".
void Reader::parse_output_times(std::size_t scope, NodeId object, Scene& scene) {
  static constexpr std::array<const char*, 3> kWays{"interval", "samples", "times"};
  const Document& file = document(scopes_[scope]);
  const char* first = nullptr;
  for (const char* way : kWays) {
    const NodeId value = file.find(object, way);
    if (!value.valid()) continue;
    if (first != nullptr) {
      problem("BG144",
              "the scene " + in_quotes(scene.name) + " has both " + in_quotes(first) + " and " + in_quotes(way),
              file.key_place(value), "keep one of them");
      return;
    }
    first = way;
    scene.interval_place = file.place(value);
  }
  parse_time(scope, object, "interval", scene.interval, scene.interval_place);
  if (const NodeId samples = file.find(object, "samples"); samples.valid()) {
    if (file[samples].kind == JsonKind::object)
      parse_log_samples(scope, samples, scene);
    else
      scene.samples = sample_count(file, samples, "\"samples\"");
  }
  if (const NodeId times = file.find(object, "times"); times.valid()) parse_listed_times(scope, times, scene);
}

std::optional<std::size_t> Reader::sample_count(const Document& file, NodeId value, const std::string& what) {
  if (!expect(file, value, JsonKind::number, what)) return std::nullopt;
  const double n = file[value].number;
  constexpr double kMostSamples = 1e9;
  if (n == std::floor(n) && n >= 1.0 && n <= kMostSamples) return static_cast<std::size_t>(n);
  problem("BG144", what + " must be a whole number from 1 to 1e9", file.place(value));
  return std::nullopt;
}

/// { "log": 101, "from": 1e-6 }.
void Reader::parse_log_samples(std::size_t scope, NodeId samples, Scene& scene) {
  static constexpr std::array<std::string_view, 2> kKeys{"log", "from"};
  const Document& file = document(scopes_[scope]);
  check_keys(file, samples, kKeys, "\"samples\"");
  parse_time(scope, samples, "from", scene.log_from, scene.log_from_place);
  const NodeId log = file.find(samples, "log");
  if (!log.valid())
    return missing(file, samples, "\"samples\" has no \"log\"", file.place(samples),
                   "add \"log\": the number of output times, evenly spaced by their logarithms");
  scene.log_samples = sample_count(file, log, "\"log\"");
}

void Reader::parse_listed_times(std::size_t scope, NodeId times, Scene& scene) {
  const Document& file = document(scopes_[scope]);
  if (!expect(file, times, JsonKind::array, "\"times\"")) return;
  if (file[times].child_count == 0)
    problem("BG144", "the list of output times is empty", file.place(times),
            "name at least one time, or leave \"times\" out");
  for (NodeId child = file[times].first_child; child.valid(); child = file[child].next_sibling) {
    const ExprId time = expression({scope, nullptr, "\"times\""}, child, "an output time");
    if (time.valid()) scene.times.emplace_back(time, file.place(child));
  }
}

void Reader::parse_scene_parameters(NodeId node, Scene& scene) {
  const Document& file = document(scopes_[0]);
  const NodeId value = file.find(node, "parameters");
  if (!value.valid() || !expect(file, value, JsonKind::object, "\"parameters\"")) return;
  for (NodeId child = file[value].first_child; child.valid(); child = file[child].next_sibling) {
    const std::string name(file[child].key);
    const auto found = names_.find(name);
    if (found == names_.end() || found->second.kind != Entity::Kind::parameter) {
      if (is_broken(0, name) || unreadable(scopes_[0], "parameters")) continue;
      const bool signal = found != names_.end() && found->second.kind == Entity::Kind::signal;
      problem("BG147",
              signal ? in_quotes(name) + " is a signal: a scene can only set parameters"
                     : "there is no parameter " + in_quotes(name) + " for the scene to set",
              file.key_place(child),
              signal ? "write the signal with a parameter that the scene can set"
                     : suggestion(name, known_names({0, nullptr, "a parameter"})));
      continue;
    }
    const ExprId set = expression({0, nullptr, "a parameter"}, child, "a parameter");
    if (set.valid()) scene.parameters[name] = {set, file.place(child)};
  }
}

void Reader::parse_scene_initial(NodeId node, Scene& scene) {
  const Document& file = document(scopes_[0]);
  const NodeId value = file.find(node, "initial");
  if (!value.valid() || !expect(file, value, JsonKind::object, "\"initial\"")) return;
  std::map<std::pair<ElementId, std::uint32_t>, Place> given;
  for (NodeId child = file[value].first_child; child.valid(); child = file[child].next_sibling) {
    const std::string name(file[child].key);
    if (!check_state(name, file.key_place(child), true)) continue;
    const ModelSymbol& symbol = model_.symbols[state_named(name, true)->index()];
    const bool store = symbol.kind == ModelSymbol::Kind::port_variable;
    const auto [first, is_new] = given.emplace(std::pair(symbol.element, symbol.port), file.key_place(child));
    if (store && !is_new) {
      problem("BG184", "two initial values are given for one store", file.key_place(child), "keep one of them",
              "what a store holds and its effort or flow determine each other by its law",
              {{first->second, "this is the other one"}});
      continue;
    }
    const ExprId start = expression({0, nullptr, "an initial value"}, child, "an initial value");
    if (start.valid()) scene.initial[name] = {start, file.place(child)};
  }
}

/// Whether there is a state of that full name.
bool Reader::check_state(const std::string& name, const Place& place, bool or_conjugate) {
  refusal_.reset();
  if (state_named(name, or_conjugate)) return true;
  if (is_broken(0, name) || unreadable(scopes_[0], "elements")) return false;
  if (const auto found = names_.find(name); found != names_.end() && found->second.kind == Entity::Kind::condition) {
    problem("BG147", in_quotes(name) + " is a condition, no state", place,
            "a latch begins on the side that its own \"initial\" says, true or false",
            "states are what the stores hold, and the integrals among the signals");
    return false;
  }
  std::string help = refusal_ ? refusal_->help : index_advice(0, name);
  if (help.empty()) help = suggestion(name, state_names());
  const auto dot = name.rfind('.');
  if (dot != std::string::npos && or_conjugate)
    if (const auto found = names_.find(name.substr(0, dot));
        found != names_.end() && found->second.kind == Entity::Kind::element)
      if (const Element& element = model_.elements[found->second.index]; is_store(element.kind))
        help = initial_advice(element, name.substr(dot + 1), name.substr(0, dot + 1));
  if (help.empty()) help = "states have names like \"mass.p\", \"spring.q\" or \"packet.air.q\"";
  problem("BG147", refusal_ ? refusal_->situation : "there is no state " + in_quotes(name), place, help,
          "states are what the stores hold: q of C and CC, p of I and II, either of IC; and the integrals among the "
          "signals");
  return false;
}

std::vector<std::string> Reader::state_names() const {
  std::vector<std::string> names;
  for (const Signal& signal : model_.signals)
    if (const auto found = names_.find(signal.name);  // the sides of latches are kept as states, too
        signal.is_state() && found != names_.end() && found->second.kind == Entity::Kind::signal &&
        names.size() < kMostSearched)
      names.push_back(signal.name);
  for (const Element& element : model_.elements) {
    if (names.size() >= kMostSearched || enough_problems()) break;
    for (std::size_t port = 0; is_store(element.kind) && port < element.ports.size(); ++port)
      names.push_back(port_name(element, port) + "." + letter(stored_variable(element, port)));
  }
  return names;
}

void Reader::parse_scene_outputs(NodeId node, Scene& scene) {
  const Document& file = document(scopes_[0]);
  const NodeId value = file.find(node, "outputs");
  if (!value.valid() || !expect(file, value, JsonKind::array, "\"outputs\"")) return;
  if (file[value].child_count == 0)
    problem("BG113", "the list of outputs is empty", file.place(value), "leave \"outputs\" out to record all of them");
  std::unordered_set<std::string> seen;
  for (NodeId child = file[value].first_child; child.valid(); child = file[child].next_sibling) {
    if (!expect(file, child, JsonKind::string, "an output's name")) continue;
    const std::string name(file[child].text);
    if (!check_output(name, file.place(child))) continue;
    if (seen.insert(name).second)
      scene.outputs.push_back(name);
    else
      problem("BG116", "the output " + in_quotes(name) + " is listed twice", file.place(child), "leave one out");
  }
}

bool Reader::check_output(const std::string& name, const Place& place) {
  if (outputs_.contains(name)) return true;
  if (unreadable(scopes_[0], "outputs")) return false;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < model_.outputs.size() && !enough_problems(); ++i) names.push_back(model_.outputs[i].name);
  std::string help = suggestion(name, names);
  if (help.empty() && !names.empty()) help = "there are " + list_of(names, " and ");
  problem("BG147", "there is no output " + in_quotes(name), place, help,
          "the outputs are those of the model's \"outputs\"");
  return false;
}

/// A number above 0.
std::optional<double> Reader::positive(NodeId value, const std::string& what) {
  const Document& file = document(scopes_[0]);
  if (!expect(file, value, JsonKind::number, what)) return std::nullopt;
  if (file[value].number > 0.0) return file[value].number;
  problem("BG146", what + " must be greater than 0", file.place(value),
          "leave it out: tolerances then follow each state's own size");
  return std::nullopt;
}

void Reader::parse_tolerances(NodeId node, Scene& scene) {
  const Document& file = document(scopes_[0]);
  if (const NodeId value = file.find(node, "relative"); value.valid()) {
    scene.relative = positive(value, "\"relative\"");
    if (scene.relative.value_or(0.0) >= 1.0)
      problem("BG146", "a relative tolerance of 1 or more gives no accuracy", file.place(value), "write 1e-6, say");
  }
  const NodeId absolute = file.find(node, "absolute");
  if (!absolute.valid()) return;
  if (file[absolute].kind == JsonKind::number) {
    scene.absolute = positive(absolute, "\"absolute\"");
    return;
  }
  if (file[absolute].kind != JsonKind::object)
    return problem(
        "BG113", "\"absolute\" must be a number or an object, not " + std::string(json_kind_name(file[absolute].kind)),
        file.place(absolute), "write one number for all states, or { \"mass.p\": 1e-9, ... }");
  for (NodeId child = file[absolute].first_child; child.valid(); child = file[child].next_sibling) {
    const std::string name(file[child].key);
    const bool known = check_state(name, file.key_place(child));
    const auto value = positive(child, "an absolute tolerance");
    if (known && value) scene.absolute_by_state[name] = *value;
  }
}

/// Whether step and order suit the method is seen when a scene is prepared, since the command line has a say too.
void Reader::parse_method(NodeId node, Scene& scene) {
  const Document& file = document(scopes_[0]);
  scene.method_place = scene.place;
  if (const NodeId value = file.find(node, "method");
      value.valid() && expect(file, value, JsonKind::string, "\"method\"")) {
    scene.method_place = file.place(value);
    if (const auto method = method_from(std::string(file[value].text)))
      scene.method = *method;
    else
      problem("BG146", "there is no method " + in_quotes(file[value].text), file.place(value),
              instead_of_method(file[value].text) + "methods are " + method_list());
  }
  if (const NodeId value = file.find(node, "zeno");
      value.valid() && expect(file, value, JsonKind::string, "\"zeno\"")) {
    const std::string_view way = file[value].text;
    if (way != "close" && way != "error")
      problem("BG113", "\"zeno\" is \"close\" or \"error\", not " + in_quotes(way), file.place(value),
              "write \"close\" or \"error\"",
              "what happens where the impacts of a contact accumulate: it closes, or the run ends");
    scene.close_zeno = way != "error";
  }
  if (const NodeId value = file.find(node, "impacts");
      value.valid() && expect(file, value, JsonKind::string, "\"impacts\"")) {
    const std::string_view way = file[value].text;
    if (way != "sequential" && way != "simultaneous")
      problem("BG113", "\"impacts\" is \"sequential\" or \"simultaneous\", not " + in_quotes(way), file.place(value),
              "write \"sequential\" or \"simultaneous\"",
              "impacts of one instant take place one after the other, or at once");
    scene.sequential_impacts = way == "sequential";
  }
  if (const NodeId value = file.find(node, "max_events");
      value.valid() && expect(file, value, JsonKind::number, "\"max_events\"")) {
    constexpr double kMost = 1e15;
    const double most = file[value].number;
    scene.max_events_place = file.place(value);
    if (most == std::floor(most) && most >= 1.0 && most <= kMost)
      scene.max_events = static_cast<std::uint64_t>(most);
    else
      problem("BG146", "\"max_events\" must be a whole number from 1 to 1e15", file.place(value),
              "leave it out: the number of events is then not limited");
  }
  if (const NodeId value = file.find(node, "step"); value.valid()) scene.step = positive(value, "\"step\"");
  if (const NodeId value = file.find(node, "max_order"); value.valid()) {
    const auto order = positive(value, "\"max_order\"");
    if (!order) return;
    if (*order == std::floor(*order) && *order <= 12.0)
      scene.max_order = static_cast<int>(*order);
    else
      problem("BG146", "\"max_order\" must be a whole number from 1 to 12", file.place(value));
  }
}

/// A CSV file, or { file, relative, absolute, tube, columns }.
void Reader::parse_reference(NodeId node, Scene& scene) {
  static constexpr std::array<std::string_view, 6> kKeys{"file", "relative", "absolute", "tube", "columns", "about"};
  const Document& file = document(scopes_[0]);
  const NodeId value = file.find(node, "reference");
  if (!value.valid()) return;
  Reference reference;
  reference.place = file.place(value);
  if (file[value].kind == JsonKind::string) {
    reference.file = beside(scopes_[0].document, file[value].text);
    scene.reference = std::move(reference);
    return;
  }
  if (file[value].kind != JsonKind::object)
    return problem("BG113",
                   "\"reference\" must be a text or an object, not " + std::string(json_kind_name(file[value].kind)),
                   file.place(value), "write the name of a CSV file, or { \"file\": ..., \"relative\": ... }");
  check_keys(file, value, kKeys, "a reference");
  text_of(file, value, "about");
  if (!file.find(value, "file").valid())
    return missing(file, value, "the reference has no \"file\"", file.key_place(value), "name a CSV file");
  reference.file = beside(scopes_[0].document, text_of(file, value, "file"));
  for (const auto& [key, target] :
       {std::pair{"relative", &reference.relative}, {"absolute", &reference.absolute}, {"tube", &reference.tube}}) {
    const NodeId child = file.find(value, key);
    if (!child.valid() || !expect(file, child, JsonKind::number, in_quotes(key))) continue;
    *target = file[child].number;
    if (*target < 0.0) problem("BG146", in_quotes(key) + " must not be negative", file.place(child));
  }
  if (const NodeId columns = file.find(value, "columns");
      columns.valid() && expect(file, columns, JsonKind::object, "\"columns\""))
    for (NodeId child = file[columns].first_child; child.valid(); child = file[child].next_sibling) {
      const std::string name(file[child].key);
      if (check_output(name, file.key_place(child)) && expect(file, child, JsonKind::string, "a column's name"))
        reference.columns[name] = file[child].text;
    }
  scene.reference = std::move(reference);
}

}  // namespace bgsim
