// A model's own text with other numbers in it.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/fit.hpp"
#include "bgsim/text.hpp"
#include "scene/given_values.hpp"

namespace bgsim {
namespace {

/// One change: bytes [begin, end) become `text`.
struct Edit {
  std::size_t begin = 0, end = 0;
  std::string text;
};

/// A member of a JSON object: its key, and its value's bytes.
struct Member {
  std::string key;
  std::size_t begin = 0, end = 0;
};

/// Walks over JSON that has been read before, so that it is known to be well formed.
class JsonText {
 public:
  explicit JsonText(std::string_view text) : text_(text) {}

  /// The members of the object that begins at @p at, with its brace. Keys with escapes are kept as written.
  [[nodiscard]] std::vector<Member> members(std::size_t at) const {
    std::vector<Member> all;
    at = after_blanks(at + 1);
    while (text_[at] != '}') {
      Member member;
      const std::size_t end = end_of_string(at);
      member.key = text_.substr(at + 1, end - at - 2);
      member.begin = after_blanks(after_blanks(end) + 1);  // behind the colon
      member.end = end_of_value(member.begin);
      all.push_back(member);
      at = after_blanks(member.end);
      if (text_[at] == ',') at = after_blanks(at + 1);
    }
    return all;
  }
  [[nodiscard]] std::size_t after_blanks(std::size_t at) const {
    return std::min(text_.find_first_not_of(" \t\r\n", at), text_.size());
  }

 private:
  [[nodiscard]] std::size_t end_of_string(std::size_t at) const {
    for (++at; text_[at] != '"'; ++at)
      if (text_[at] == '\\') ++at;
    return at + 1;
  }
  [[nodiscard]] std::size_t end_of_value(std::size_t at) const {
    if (text_[at] == '"') return end_of_string(at);
    if (text_[at] != '{' && text_[at] != '[') return std::min(text_.find_first_of(",}] \t\r\n", at), text_.size());
    std::size_t depth = 0;
    while (true) {
      if (text_[at] == '"') {
        at = end_of_string(at);
        continue;
      }
      if (text_[at] == '{' || text_[at] == '[') ++depth;
      if (text_[at] == '}' || text_[at] == ']') --depth;
      ++at;
      if (depth == 0) return at;
    }
  }

  std::string_view text_;
};

/// What a value becomes in the scenes of the fit.
struct NewValue {
  std::string name;
  bool parameter = false;
  double value = 0.0;
};

class Rewriting {
 public:
  Rewriting(const Study& study, const FitPlan& plan, const FitResult& result, const SceneOverrides& overrides,
            const ReadOptions& reading)
      : model_(study.model()),
        reading_(reading),
        text_(source_texts(*model_.sources).front().text),
        path_(source_texts(*model_.sources).front().path) {
    for (const FitData& data : plan.data) {
      const RunInputs inputs = prepare_scene(model_, data.scene, overrides);
      if (std::find(scenes_.begin(), scenes_.end(), inputs.scene) == scenes_.end()) scenes_.push_back(inputs.scene);
    }
    overrides_.set = overrides.set;
    std::set<std::string> fitted;
    for (const FittedValue& value : result.values) fitted.insert(value.name);
    std::erase_if(overrides_.set, [&](const std::string& text) { return fitted.contains(name_of(text)); });
    for (const FittedValue& value : result.values)
      overrides_.set.push_back(value.name + "=" + shortest_number(value.value));
  }

  std::string run(const std::string& path) {
    for (const bool in_place : {true, false}) {
      std::string written = with_edits(in_place);
      if (!gives_the_same(written)) continue;
      check_there(written, path);
      return written;
    }
    throw ModelError(
        {diagnostic_of("BG421", "the fitted values cannot be written into " + short_path(path_), {},
                       "the file that is written, read again with the same options, has the values of the fit",
                       "give them to a run with --set, or in a file with --parameters")},
        model_.sources);
  }

 private:
  static std::string name_of(const std::string& set) {
    return std::string(trimmed(std::string_view(set).substr(0, set.find('='))));
  }

  const Scene& scene_of(const Model& model, const std::string& name) const {
    return *std::find_if(model.scenes.begin(), model.scenes.end(), [&](const Scene& s) { return s.name == name; });
  }

  /// Values in a scene: those of --set are computed there.
  std::vector<NewValue> values_in(const std::string& scene) const {
    const GivenValues given = given_values(model_, scene_of(model_, scene), overrides_);
    const RunInputs inputs = prepare_scene(model_, scene, overrides_);
    std::vector<NewValue> values;
    for (const std::string& set : overrides_.set) {
      NewValue value{name_of(set), false, 0.0};
      for (std::size_t i = 0; i < model_.parameters.size(); ++i)
        if (model_.parameters[i].name == value.name) {
          value.parameter = true;
          value.value = inputs.parameters[i];
        }
      if (!value.parameter) {
        const auto at = given.set_states.find(value.name);
        value.value = at != given.set_states.end() && given.pool.is_constant(at->second)
                          ? given.pool[at->second].constant
                          : std::nan("");
      }
      values.push_back(value);
    }
    return values;
  }

  /// Where the value stands in the model's own file, if it does.
  std::optional<Place> place_of(const NewValue& value, const Scene& scene) const {
    const auto& given = value.parameter ? scene.parameters : scene.initial;
    if (const auto at = given.find(value.name); at != given.end()) return at->second.second;
    if (value.parameter) {
      for (const Parameter& parameter : model_.parameters)
        if (parameter.name == value.name) return parameter.place;
      return std::nullopt;
    }
    const auto state = StateNames(model_).find(value.name);
    if (!state) return std::nullopt;
    if (state->key.signal.valid()) {
      const Signal& signal = model_.signals[state->key.signal.index()];
      return signal.initial.valid() ? std::optional(signal.initial_place) : std::nullopt;
    }
    for (const InitialValue& initial : model_.elements[state->key.element.index()].initial)
      if (initial.port == state->key.port && initial.conjugate == state->conjugate) return initial.place;
    return std::nullopt;
  }

  /// The scene gives what a store holds by its effort or flow, and q or p is fitted, or the other way round: one takes
  /// the place of the other.
  std::optional<Edit> in_place_of_other(const NewValue& value, const Scene& scene) const {
    if (value.parameter) return std::nullopt;
    const StateNames names(model_);
    const auto state = names.find(value.name);
    for (const auto& [other, given] : scene.initial) {
      const auto of = names.find(other);
      if (!state || !of || other == value.name || of->key != state->key) continue;
      const Place& place = given.second;
      const std::size_t key = text_.rfind(json_text_of(other), place.begin);
      if (place.document.index() != 0 || key == std::string_view::npos) return std::nullopt;
      return Edit{key, place.end, json_text_of(value.name) + ": " + shortest_number(value.value)};
    }
    return std::nullopt;
  }

  /// @param in_place  numbers are replaced where they stand; else all are written into the scenes.
  std::string with_edits(bool in_place) const {
    std::vector<Edit> edits;
    for (const std::string& name : scenes_) {
      const Scene& scene = scene_of(model_, name);
      std::vector<NewValue> rest;
      for (const NewValue& value : values_in(name)) {
        if (!std::isfinite(value.value)) continue;  // and is found missing when the text is read again
        const std::optional<Place> place = place_of(value, scene);
        const auto& own = value.parameter ? scene.parameters : scene.initial;
        const bool here = place && place->document.index() == 0 && place->end > place->begin &&
                          place->end <= text_.size() && text_[place->begin] != '{';
        if (auto replaced = in_place_of_other(value, scene))
          edits.push_back(std::move(*replaced));
        else if (here && (in_place || own.contains(value.name)))
          edits.push_back({place->begin, place->end, shortest_number(value.value)});
        else
          rest.push_back(value);
      }
      into_scene(scene, rest, edits);
    }
    std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.begin > b.begin; });
    std::string written(text_);
    std::size_t last = written.size() + 1;
    for (const Edit& edit : edits) {
      if (edit.begin == last) continue;  // a place that several scenes share
      written.replace(edit.begin, edit.end - edit.begin, edit.text);
      last = edit.begin;
    }
    return written;
  }

  void into_scene(const Scene& scene, const std::vector<NewValue>& values, std::vector<Edit>& edits) const {
    if (values.empty() || scene.place.document.index() != 0) return;
    const JsonText json(text_);
    const std::size_t colon = text_.find(':', scene.place.end);  // the place is that of the key
    const std::size_t open = colon == std::string_view::npos ? text_.size() : json.after_blanks(colon + 1);
    if (open >= text_.size() || text_[open] != '{') return;
    const std::vector<Member> members = json.members(open);
    std::string added;
    for (const bool parameter : {true, false}) {
      const std::string key = parameter ? "parameters" : "initial";
      std::string inside;
      for (const NewValue& value : values)
        if (value.parameter == parameter)
          inside += (inside.empty() ? "" : ", ") + json_text_of(value.name) + ": " + shortest_number(value.value);
      if (inside.empty()) continue;
      const auto found = std::find_if(members.begin(), members.end(), [&](const Member& m) { return m.key == key; });
      if (found == members.end()) {
        added.append(" \"").append(key).append("\": { ").append(inside).append(" },");
      } else if (text_[found->begin] == '{') {
        const bool empty = json.members(found->begin).empty();
        edits.push_back({found->begin + 1, found->begin + 1, " " + inside + (empty ? "" : ",")});
      }
    }
    if (added.empty()) return;
    if (members.empty()) added.pop_back();
    edits.push_back({open + 1, open + 1, added});
  }

  static std::string json_text_of(const std::string& name) {
    std::string text = "\"";
    for (const char c : name) {
      if (c == '"' || c == '\\') text += '\\';
      text += c;
    }
    return text + '"';
  }

  /// What the model names is found from the file's own folder, too.
  void check_there(const std::string& written, const std::string& path) const {
    if (path.empty()) return;
    try {
      static_cast<void>(read_model_text(path, written, reading_));
    } catch (const ModelError& error) {
      const Diagnostic& first = error.diagnostics.front();
      throw ModelError(
          {diagnostic_of("BG421", "the model could not be read as " + short_path(path) + ": " + first.situation, {},
                         "submodels and data are named relative to the folder of the file that names them",
                         "write it into the folder of " + short_path(path_) + ", or say where they are with --path")},
          model_.sources);
    }
  }

  /// Read again, all parameters and initial values of the scenes are those of the fit, to the bit.
  bool gives_the_same(const std::string& written) const {
    try {
      const Model again = read_model_text(path_, written, reading_);
      for (const std::string& name : scenes_) {
        const RunInputs wanted = prepare_scene(model_, name, overrides_), found = prepare_scene(again, name);
        if (wanted.parameters != found.parameters || wanted.initial.size() != found.initial.size()) return false;
        for (std::size_t i = 0; i < wanted.initial.size(); ++i) {
          const RunInputs::Initial &a = wanted.initial[i], &b = found.initial[i];
          if (a.element != b.element || a.port != b.port || a.signal != b.signal || a.value != b.value) return false;
        }
      }
      return true;
    } catch (const ModelError&) {
      return false;
    }
  }

  const Model& model_;
  const ReadOptions& reading_;
  std::string_view text_;
  std::string path_;
  std::vector<std::string> scenes_;
  SceneOverrides overrides_;
};

}  // namespace

std::string fitted_text(const Study& study, const FitPlan& plan, const FitResult& result,
                        const SceneOverrides& overrides, const ReadOptions& reading, const std::string& path) {
  return Rewriting(study, plan, result, overrides, reading).run(path);
}

}  // namespace bgsim
