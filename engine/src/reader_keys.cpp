#include <algorithm>
#include <array>

#include "reader.hpp"

namespace bgsim {
namespace {

bool is_reserved(std::string_view name) {
  static constexpr std::array<std::string_view, 31> kReserved{
      "t",    "pi",   "and",  "or",    "not",   "if",    "abs",  "sign", "min",  "max",  "sqrt",
      "cbrt", "exp",  "log",  "log10", "sin",   "cos",   "tan",  "asin", "acos", "atan", "atan2",
      "sinh", "cosh", "tanh", "hypot", "floor", "ssqrt", "step", "der",  "table"};
  return std::find(kReserved.begin(), kReserved.end(), name) != kReserved.end();
}

std::uint64_t object_key(const Document& file, NodeId object) {
  return (std::uint64_t{file.place(object).document.value} << 32U) | object.value;
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

const char* json_kind_name(JsonKind kind) {
  switch (kind) {
    case JsonKind::null:
      return "null";
    case JsonKind::boolean:
      return "true or false";
    case JsonKind::number:
      return "a number";
    case JsonKind::string:
      return "a text";
    case JsonKind::array:
      return "an array";
    case JsonKind::object:
      return "an object";
  }
  return "";
}

std::string suggestion(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string near = nearest_name(std::string(name), candidates);
  return near.empty() ? std::string() : "did you mean " + in_quotes(near) + "?";
}

std::string list_of(const std::vector<std::string>& names, const char* last_separator) {
  constexpr std::size_t kMostListed = 20;
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i == kMostListed) return text + ", ...";
    text += (i == 0 ? "" : i + 1 == names.size() ? last_separator : ", ") + in_quotes(names[i]);
  }
  return text;
}

void Reader::problem(const char* code, std::string situation, std::optional<Place> place, std::string help,
                     std::string rule, std::vector<Note> notes) {
  if (enough_problems()) {
    ++further_problems_;
    return;
  }
  std::string key = code + situation;
  if (place) key += "@" + std::to_string(place->document.value) + ":" + std::to_string(place->begin);
  if (!reported_.insert(std::move(key)).second) return;
  problems_.push_back(
      {Severity::error, code, std::move(situation), place, std::move(notes), std::move(rule), std::move(help)});
}

void Reader::check_keys(const Document& file, NodeId object, std::span<const std::string_view> allowed,
                        const std::string& what) {
  for (NodeId child = file[object].first_child; child.valid(); child = file[child].next_sibling) {
    const std::string_view key = file[child].key;
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    with_unknown_keys_.insert(object_key(file, object));
    const std::vector<std::string> names(allowed.begin(), allowed.end());
    std::string help = suggestion(key, names);
    if (help.empty()) help = what + " may have " + list_of(names);
    problem("BG111", what + " has no key " + in_quotes(key), file.key_place(child), help,
            "unknown keys are errors, so that a slip of the pen is never passed over");
  }
}

void Reader::missing(const Document& file, NodeId object, std::string situation, const Place& place, std::string help,
                     std::string rule) {
  if (!with_unknown_keys_.contains(object_key(file, object)))
    problem("BG112", std::move(situation), place, std::move(help), std::move(rule));
}

bool Reader::expect(const Document& file, NodeId value, JsonKind kind, const std::string& what) {
  if (file[value].kind == kind) return true;
  problem("BG113", what + " must be " + json_kind_name(kind) + ", not " + json_kind_name(file[value].kind),
          file.place(value));
  return false;
}

std::string Reader::text_of(const Document& file, NodeId object, std::string_view key) {
  const NodeId value = file.find(object, key);
  if (!value.valid() || !expect(file, value, JsonKind::string, in_quotes(key))) return {};
  return std::string(file[value].text);
}

NodeId Reader::section(const Scope& scope, std::string_view key, JsonKind kind) {
  const Document& file = document(scope);
  const NodeId value = file.find(Document::root(), key);
  if (!value.valid() || !expect(file, value, kind, in_quotes(key))) return {};
  return value;
}

bool Reader::valid_name(std::string_view name, const Place& place, const std::string& what) {
  const bool good = !name.empty() && is_letter(name[0]) &&
                    std::all_of(name.begin(), name.end(), [](char c) { return is_letter(c) || is_digit(c); });
  if (!good) {
    problem("BG115", in_quotes(name) + " cannot be the name of " + what, place, {},
            "names consist of the letters a-z and A-Z, digits and underscores, and do not begin with a digit");
    return false;
  }
  if (!is_reserved(name)) return true;
  problem("BG115", in_quotes(name) + " cannot be the name of " + what + ": it has a meaning in expressions", place,
          "choose another name, such as " + in_quotes(std::string(name) + "_0"));
  return false;
}

/// Models and scenes may have any name but none; what a file's name cannot hold is replaced where a file is written.
bool Reader::valid_title(std::string_view name, const Place& place, const std::string& what) {
  if (!name.empty()) return true;
  problem("BG115", what + " has an empty name", place, "give it a name: it becomes part of the trace's file name");
  return false;
}

}  // namespace bgsim
