#include <algorithm>
#include <array>
#include <span>

#include "base/depth_first.hpp"
#include "read/other_keys.hpp"
#include "read/reader.hpp"

namespace bgsim {
namespace {

constexpr double kMostElements = 1e7;

}  // namespace

/// The "types" of a file; files are loaded when an element is of that kind.
std::unordered_map<std::string_view, Reader::Type>& Reader::types_of(DocumentId id) {
  const auto [there, is_new] = types_.try_emplace(id.value);
  if (!is_new) return there->second;
  const Document& file = document(id);
  const NodeId types = file.find(Document::root(), "types");
  if (!types.valid() || !expect(file, types, JsonKind::object, "\"types\"")) return there->second;
  for (NodeId node = file[types].first_child; node.valid(); node = file[node].next_sibling) {
    Type type{node, {}, false};
    if (written_kind(file[node].key)) {
      problem("BG115", in_quotes(file[node].key) + " cannot be the name of a submodel: it is a kind of element",
              file.key_place(node), "choose another name");
      continue;
    }
    type.refused = !valid_name(file[node].key, file.key_place(node), "a submodel") ||
                   !expect(file, node, JsonKind::string, "a submodel's file");
    there->second.emplace(file[node].key, type);
  }
  return there->second;
}

/// The submodels that the elements of a file are, loaded.
std::vector<Reader::Use> Reader::uses_of(DocumentId id) {
  std::vector<Use> uses;
  std::unordered_map<std::string_view, std::size_t> position;
  const NodeId elements = document(id).find(Document::root(), "elements");
  if (!elements.valid()) return uses;
  auto& types = types_of(id);
  for (NodeId node = document(id)[elements].first_child; node.valid(); node = document(id)[node].next_sibling) {
    const Document& file = document(id);
    const NodeId kind = file[node].kind == JsonKind::object ? file.find(node, "kind") : NodeId{};
    if (!kind.valid() || file[kind].kind != JsonKind::string || written_kind(file[kind].text)) continue;
    const auto type = types.find(file[kind].text);
    if (type == types.end() || type->second.refused) continue;
    const auto [known, is_new] = position.try_emplace(type->first, uses.size());
    if (!is_new) {
      uses[known->second].times += copies_of(file, node);
      continue;
    }
    const double times = copies_of(file, node);
    const Place place = file.place(type->second.node);
    const DocumentId other = load(submodel_file(id, file[type->second.node].text), std::nullopt, place);
    type->second.file = other;
    type->second.refused = !other.valid() || !is_model(other);
    uses.push_back({&type->second, times});
  }
  return uses;
}

/// Loads all files of the model, finds submodels that contain themselves, and counts the elements before they are
/// unfolded.
void Reader::survey(DocumentId root) {
  std::vector<DocumentId> files{root};
  std::vector<std::vector<Use>> uses;               // of each file
  std::vector<std::vector<std::size_t>> submodels;  // the files of these uses
  std::unordered_map<std::uint32_t, std::size_t> position{{root.value, 0}};
  for (std::size_t i = 0; i < files.size(); ++i) {
    uses.push_back(uses_of(files[i]));
    std::erase_if(uses[i], [](const Use& use) { return use.type->refused; });
    submodels.emplace_back();
    for (const Use& use : uses[i]) {
      const auto [known, is_new] = position.try_emplace(use.type->file.value, files.size());
      if (is_new) files.push_back(use.type->file);
      submodels[i].push_back(known->second);
    }
  }
  std::vector<double> elements(files.size());  // a double never overflows where submodels double level by level
  depth_first(
      files.size(), [&](std::size_t i) { return std::span(submodels[i]); }, [](std::size_t) { return true; },
      [&](std::span<const std::size_t> path, std::size_t i) {
        std::string chain;
        for (const std::size_t file : path)
          if (!chain.empty() || file == i) chain += document(files[file]).path() + " -> ";
        for (const Use& use : uses[path.back()]) {
          if (use.type->refused || use.type->file != files[i]) continue;
          problem("BG133", "a submodel contains itself: " + chain + document(files[i]).path(),
                  document(files[path.back()]).place(use.type->node), "break the circle",
                  "submodels are unfolded completely");
          use.type->refused = true;
        }
      },
      [&](std::size_t i) {
        const NodeId section = document(files[i]).find(Document::root(), "elements");
        const Document& file = document(files[i]);
        for (NodeId node = section.valid() ? file[section].first_child : NodeId{}; node.valid();
             node = file[node].next_sibling)
          elements[i] += copies_of(file, node);
        for (std::size_t j = 0; j < uses[i].size(); ++j) elements[i] += uses[i][j].times * elements[submodels[i][j]];
      });
  const double total = elements[0];
  if (total <= kMostElements) {
    model_.elements.reserve(static_cast<std::size_t>(total));
    names_.reserve(2 * static_cast<std::size_t>(total));  // about as many bonds as elements
    return;
  }
  problem("BG137", "the model has more than 10 million elements, submodels unfolded",
          document(root).key_place(document(root).find(Document::root(), "elements")),
          "look for submodels that hold several copies of each other, level over level, and for \"repeat\"");
  give_up();
}

/// An element whose kind is one of the file's "types". Its scope is entered by declare_all.
void Reader::declare_instance(std::size_t scope, NodeId node, std::string_view kind) {
  static constexpr std::array<std::string_view, 5> kKeys{"kind", "parameters", "signals", "about", "repeat"};
  const Document& file = document(scopes_[scope]);
  const auto& types = types_of(scopes_[scope].document);
  const auto type = types.find(kind);
  if (type == types.end()) {
    const NodeId section = file.find(Document::root(), "types");
    if (section.valid() && file[section].kind != JsonKind::object) return;  // reported
    std::vector<std::string> candidates = kind_texts();
    std::string kinds;
    for (const std::string& name : candidates) kinds += name + ' ';
    for (const auto& [name, unused] : types) candidates.emplace_back(name);
    std::sort(candidates.begin(), candidates.end());
    std::string help = instead_of_kind(kind);
    if (help.empty()) help = suggestion(kind, candidates);
    if (help.empty()) help = "kinds are " + kinds + "and those in \"types\"";
    return problem("BG114", "there is no kind of element " + in_quotes(kind), file.place(file.find(node, "kind")),
                   help);
  }
  check_keys(file, node, kKeys, "a submodel");
  text_of(file, node, "about");
  if (type->second.refused) return;
  const std::string full = scopes_[scope].prefix + std::string(file[node].key) + index_text(scopes_[scope].indices);
  const auto index = static_cast<std::uint32_t>(scopes_.size());
  if (!claim(full, {Entity::Kind::instance, index, file.key_place(node)})) return;
  scopes_.push_back({full + ".", type->second.file, scope, node});
}

/// An instance's "parameters" and "signals" replace the submodel's own; their texts use the names of the outer model.
void Reader::apply_overrides(std::size_t scope) {
  const Scope& own = scopes_[scope];
  const Document& file = document(scopes_[own.parent]);
  for (const bool signals : {false, true}) {
    const NodeId object = file.find(own.instance, signals ? "signals" : "parameters");
    if (!object.valid() || !expect(file, object, JsonKind::object, signals ? "\"signals\"" : "\"parameters\""))
      continue;
    const auto kind = signals ? Entity::Kind::signal : Entity::Kind::parameter;
    for (NodeId node = file[object].first_child; node.valid(); node = file[node].next_sibling) {
      const std::string_view name = file[node].key;
      const auto found = names_.find(own.prefix + std::string(name));
      if (signals && found != names_.end() && found->second.kind == Entity::Kind::condition) {
        override_condition(scope, found->second.index, node);
        continue;
      }
      if (found == names_.end() || found->second.kind != kind) {
        std::vector<std::string> candidates;
        if (const NodeId declared = section(own, signals ? "signals" : "parameters", JsonKind::object);
            declared.valid())
          for (const NodeId child : document(own).children(declared)) candidates.emplace_back(document(own)[child].key);
        std::string help = suggestion(name, candidates);
        if (help.empty() && !candidates.empty()) help = "it has " + list_of(candidates, " and ");
        problem("BG136",
                "the submodel " + in_quotes(document(own).path()) + " has no " + (signals ? "signal " : "parameter ") +
                    in_quotes(name),
                file.key_place(node), help);
        continue;
      }
      if (signals) {
        override_signal(scope, found->second.index, node);
      } else {
        parameter_text_[found->second.index] = {static_cast<std::uint32_t>(own.parent), node};
        model_.parameters[found->second.index].place = file.place(node);
      }
    }
  }
}

/// An expression takes the place of whatever the submodel says of its signal; an object may make an integral of it, or
/// give an integral another initial value.
void Reader::override_signal(std::size_t scope, std::uint32_t index, NodeId node) {
  static constexpr std::array<std::string_view, 3> kKeys{"value", "integral", "initial"};
  const auto parent = static_cast<std::uint32_t>(scopes_[scope].parent);
  const Document& file = document(scopes_[parent]);
  Signal& signal = model_.signals[index];
  SignalText& text = signal_text_[index];
  QuantityKeys keys{node, {}, Signal::Kind::value};
  if (file[node].kind == JsonKind::object) {
    check_keys(file, node, kKeys, "a submodel's signal");
    keys = quantity_keys(file, node, true);
    if (!keys.value.valid() && !(keys.initial.valid() && signal.is_state()))
      return missing(file, node, "the signal " + in_quotes(file[node].key) + " has no \"value\"", file.key_place(node),
                     "add \"value\": an expression, or \"integral\": its rate");
  }
  if (keys.value.valid()) {
    std::erase_if(delays_, [index](const DelayText& delay) { return delay.signal.index() == index; });
    std::erase_if(memories_, [index](const Memory& memory) { return memory.signal.index() == index; });
    signal.kind = keys.kind;
    signal.place = file.place(keys.value);
    text = {{parent, keys.value}, {}};
  }
  if (keys.initial.valid()) {
    signal.initial_place = file.place(keys.initial);
    text.initial = {parent, keys.initial};
  }
}

/// "ports": { "body": "wall" }: who uses this file as the submodel `left` may bond to `left.body`, the junction
/// left.wall. A port may also name a port of an inner submodel.
void Reader::declare_exports(std::size_t scope) {
  const NodeId object = section(scopes_[scope], "ports", JsonKind::object);
  if (!object.valid()) return;
  const Document& file = document(scopes_[scope]);
  const std::string& prefix = scopes_[scope].prefix;
  for (NodeId node = file[object].first_child; node.valid(); node = file[node].next_sibling) {
    const std::string name(file[node].key);
    const bool fault_is_known = is_broken(scope, name);
    broken_.insert(prefix + name);  // until it turns out to be sound
    if (!valid_name(name, file.key_place(node), "a port")) continue;
    if (!expect(file, node, JsonKind::string, "a port's junction")) continue;
    const std::string junction(file[node].text);
    ElementId target;
    if (const auto inner = exports_.find(prefix + junction); inner != exports_.end())
      target = inner->second;
    else if (const auto own = names_.find(prefix + junction);
             own != names_.end() && own->second.kind == Entity::Kind::element &&
             junction.find('.') == std::string::npos && is_junction(model_.elements[own->second.index].kind))
      target = ElementId(own->second.index);
    if (!target.valid() && (junction == name ? fault_is_known : is_broken(scope, junction))) continue;
    if (!target.valid()) {
      std::vector<std::string> candidates;
      for (std::size_t i = 0; !enough_problems() && i < model_.elements.size(); ++i) {
        const Element& e = model_.elements[i];
        if (is_junction(e.kind) && element_text_[i].names == scope) candidates.push_back(e.name.substr(prefix.size()));
      }
      std::string help = suggestion(junction, candidates);
      if (help.empty() && !candidates.empty()) help = "the junctions are " + list_of(candidates, " and ");
      problem(
          "BG138",
          "the port " + in_quotes(name) + " names " + in_quotes(junction) + ", which is not a junction of this model",
          file.place(node), help, "the ports of a submodel are junctions, to which other models bond");
      continue;
    }
    // A port may have its junction's own name; any other name must be free.
    if (name != junction)
      if (const auto taken = names_.find(prefix + name); taken != names_.end()) {
        problem("BG116", "the name " + in_quotes(name) + " is used twice", file.key_place(node),
                "rename one of the two", "a port has its junction's name or another one",
                {{taken->second.place, "it is used here first"}});
        continue;
      }
    exports_.emplace(prefix + name, target);
    broken_.erase(prefix + name);
  }
}

}  // namespace bgsim
