#include <algorithm>
#include <array>

#include "base/codes.hpp"
#include "read/other_keys.hpp"
#include "read/reader.hpp"

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

/// How a value of the wrong type is written, where that is likely to be known.
std::string help_for_type(const Document& file, NodeId value, JsonKind wanted, const std::string& what) {
  const JsonKind is = file[value].kind;
  if (what == "\"parameters\"") return "write an object: { \"m\": 2, \"k\": { \"value\": 350, \"unit\": \"N/m\" } }";
  if (what == "\"signals\"") return "write an object: { \"u\": \"sin(t)\" }";
  if (what == "\"outputs\"")
    return wanted == JsonKind::object ? "write an object, with a name for each column: { \"v\": \"body.f\" }"
                                      : "write a list of names: [\"v\", \"x\"]";
  if (what == "\"events\"")
    return "write an object: { \"bounce\": { \"when\": \"height <= 0\", \"set\": { \"mass.p\": \"-0.7*pre(mass.p)\" } "
           "} }";
  if (what == "\"set\"") return "write an object, store to expression: { \"mass.p\": \"-0.7*pre(mass.p)\" }";
  if (what == "\"elements\"") return "write an object: { \"mass\": { \"kind\": \"I\", \"inertance\": 2 } }";
  if (what == "\"bonds\"") return "write an array: [{ \"from\": \"body\", \"to\": \"mass\" }]";
  if (what == "\"scenes\"") return "write an object: { \"run\": { \"stop\": 1 } }";
  if (what == "\"types\"") return "write an object, name to file: { \"packet\": \"packet.json\" }";
  if (what == "\"initial\"") return "write an object: { \"q\": 0.1 } at a C, { \"p\": 0.1 } at an I";
  if (what == "an element") return "write an object: { \"kind\": \"R\", \"resistance\": 1 }";
  if (what == "a bond") return "write an object: { \"from\": \"body\", \"to\": \"mass\" }";
  if (what == "a scene") return "write an object: { \"stop\": 1 }";
  if (what == "\"laws\"") return "write an array with one law for each port: [\"a.e = ...\", \"b.e = ...\"]";
  if (what == "\"law\"") return "write an equation in quotes, such as \"e = k*q^3\"";
  if (wanted == JsonKind::number && is == JsonKind::string) return "write a number, without quotes and without a unit";
  if (wanted == JsonKind::string && is == JsonKind::number)
    return "write it in quotes: " +
           in_quotes(file.text().substr(file.place(value).begin, file.place(value).end - file.place(value).begin));
  return {};
}

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
      diagnostic_of(code, std::move(situation), place, std::move(rule), std::move(help), std::move(notes)));
}

void Reader::check_keys(const Document& file, NodeId object, std::span<const std::string_view> allowed,
                        const std::string& what, std::optional<ElementKind> kind) {
  for (NodeId child = file[object].first_child; child.valid(); child = file[child].next_sibling) {
    const std::string_view key = file[child].key;
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    with_unknown_keys_.insert(object_key(file, object));
    const std::vector<std::string> names(allowed.begin(), allowed.end());
    std::string help = kind ? instead_of_key(*kind, key) : instead_of_key(what, key);
    if (help.empty()) help = suggestion(key, names);
    if (help.empty()) help = what + " may have " + list_of(names);
    problem("BG111", what + " has no key " + in_quotes(key), file.key_place(child), help,
            "unknown keys are errors, so that a misspelt key is never ignored");
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
          file.place(value), help_for_type(file, value, kind, what));
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

bool Reader::unreadable(const Scope& scope, std::string_view key) const {
  const Document& file = document(scope);
  const NodeId value = file.find(Document::root(), key);
  if (!value.valid()) return key == "elements";
  return file[value].kind != (key == "bonds" ? JsonKind::array : JsonKind::object);
}

namespace {

/// "write "spring_constant"" for a name with other signs in it.
std::string valid_spelling(std::string_view name) {
  std::string spelling;
  for (const char c : name) {
    if (begins_name(c) || is_digit(c))
      spelling += c;
    else if (!spelling.empty() && spelling.back() != '_')
      spelling += '_';
  }
  while (!spelling.empty() && spelling.back() == '_') spelling.pop_back();
  if (spelling.empty()) return {};
  return "write " + in_quotes(is_digit(spelling[0]) ? "x" + spelling : spelling) + ", say";
}

}  // namespace

bool Reader::valid_name(std::string_view name, const Place& place, const std::string& what) {
  const bool good = !name.empty() && begins_name(name[0]) &&
                    std::all_of(name.begin(), name.end(), [](char c) { return begins_name(c) || is_digit(c); });
  if (!good) {
    problem("BG115", in_quotes(name) + " cannot be the name of " + what, place, valid_spelling(name),
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
