#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "model/element_kinds.hpp"
#include "support/reading.hpp"

using namespace bgsim;

namespace {

using nlohmann::json;

json schema() { return json::parse(test::file_text(BGSIM_SOURCE_DIR "/docs/model.schema.json")); }

/// Kinds of elements and their keys, as the schema has them.
std::map<std::string, std::set<std::string>> keys_of_kinds() {
  std::map<std::string, std::set<std::string>> result;
  const json s = schema();
  for (const auto& [name, definition] : s["$defs"].items()) {
    if (!definition.contains("properties") || !definition["properties"].contains("kind")) continue;
    const json& kinds = definition["properties"]["kind"];
    if (!kinds.contains("enum")) continue;
    for (const std::string kind : kinds["enum"])
      for (const auto& [key, unused] : definition["properties"].items()) result[kind].insert(key);
  }
  return result;
}

/// Whether the reader says that @p object, put into the place of @p frame's "@", has a key too many.
bool refuses_key(const std::string& frame, const std::string& object) {
  std::string body = frame;
  body.replace(body.find('@'), 1, object);
  return test::codes(body).find("BG111") != std::string::npos;
}

}  // namespace

TEST_CASE("the schema gives each kind of element the keys that the reader takes") {
  const auto kinds = keys_of_kinds();
  std::set<std::string> names;
  for (const auto& [kind, own] : kinds) names.insert(kind);
  const std::vector<std::string> written = kind_texts();
  CHECK(names == std::set<std::string>(written.begin(), written.end()));
  std::set<std::string> keys;
  for (const auto& [kind, own] : kinds) keys.insert(own.begin(), own.end());
  for (const auto& [kind, own] : kinds)
    for (const std::string& key : keys) {
      if (key == "kind") continue;
      INFO(kind << " " << key);
      CHECK(refuses_key(R"x("elements": { "x": @ })x", R"({ "kind": ")" + kind + "\", \"" + key + "\": 1 }") !=
            own.contains(key));
    }
}

TEST_CASE("the schema gives models, bonds, scenes and references the keys that the reader takes") {
  const json s = schema();
  const auto same = [](const json& definition, const std::string& frame) {
    for (const auto& [key, unused] : definition["properties"].items()) {
      INFO(key);
      CHECK_FALSE(refuses_key(frame, "\"" + key + "\": {}"));
    }
    CHECK(refuses_key(frame, "\"other\": 1"));
  };
  const std::string rest = R"x("elements": { "j": { "kind": "1" } })x";
  const json& defs = s["$defs"];
  for (const auto& [key, unused] : s["properties"].items())
    if (key != "elements" && key != "bgsim" && key != "name")
      CHECK_FALSE(refuses_key("@, " + rest, "\"" + key + "\": {}"));
  same(defs["bond"], rest + R"x(, "bonds": [ { @ } ])x");
  same(defs["scene"], rest + R"x(, "scenes": { "s": { @ } })x");
  same(defs["scene"]["properties"]["reference"]["anyOf"][1], rest + R"x(, "scenes": { "s": { "reference": { @ } } })x");
}

TEST_CASE("the schema has the names that expressions need for themselves, and the methods") {
  const json s = schema();
  for (const std::string name : s["$defs"]["name"]["not"]["enum"]) {
    INFO(name);
    CHECK(test::codes(R"x("parameters": { ")x" + name + R"x(": 1 }, "elements": { "j": { "kind": "1" } })x") ==
          "BG115 ");
  }
  for (const std::string method : s["$defs"]["scene"]["properties"]["method"]["enum"])
    CHECK(method_from(method).has_value());
}
