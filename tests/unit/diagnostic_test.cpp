#include "bgsim/diagnostic.hpp"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "base/codes.hpp"
#include "base/document.hpp"

using namespace bgsim;

namespace {

/// A model of these keys: only of models is an excerpt shown.
Sources sources_of(std::string text) {
  text.insert(text.rfind('}'), "\n, \"bgsim\": 1");
  Sources sources;
  sources.push_back(Document::parse(DocumentId(0), "two_sources.json", text));
  return sources;
}

}  // namespace

TEST_CASE("a message shows place, excerpt, pointer, further places, rule, help and link") {
  const Sources sources =
      sources_of("{\n  \"elements\": {\n    \"bus\":     { \"kind\": \"0\" },\n    \"battery\": 1\n  }\n}");
  const Document& file = sources.front();
  const NodeId elements = file.find(Document::root(), "elements");
  Diagnostic d;
  d.code = "BG301";
  d.situation = "two bonds set the effort of 0-junction \"bus\"";
  d.place = file.key_place(file.find(elements, "bus"));
  d.notes = {{file.key_place(file.find(elements, "battery")), "effort source \"battery\" sets it through bond b1"},
             {std::nullopt, "and so on"}};
  d.rule = "a 0-junction has one effort";
  d.help = "make one source an Sf";
  CHECK(render(d, sources) == R"(two_sources.json:3:5: error BG301: two bonds set the effort of 0-junction "bus"
   3 |     "bus":     { "kind": "0" },
     |     ^~~~~ /elements/bus
two_sources.json:4:5: note: effort source "battery" sets it through bond b1
   4 |     "battery": 1
     |     ^~~~~~~~~ /elements/battery
note: and so on
  rule: a 0-junction has one effort
  help: make one source an Sf
  see docs/errors.md#bg301
)");
}

TEST_CASE("a message without a place has neither position nor excerpt") {
  CHECK(render({Severity::warning, "BG306", "something is odd", {}, {}, {}, {}}, {}) ==
        "warning BG306: something is odd\n  see docs/errors.md#bg306\n");
}

TEST_CASE("columns count characters, and tabs stay tabs") {
  const Sources sources = sources_of("{\"Ωä\":\t\"x\"}");
  const Document& file = sources.front();
  const NodeId value = file.find(Document::root(), "Ωä");
  CHECK(render({Severity::error, "BG113", "s", file.place(value), {}, {}, {}}, sources) ==
        "two_sources.json:1:8: error BG113: s\n   1 | {\"Ωä\":\t\"x\"\n     |       \t^~~ /Ωä\n  see "
        "docs/errors.md#bg113\n");
}

TEST_CASE("a line of a megabyte is clipped around the place") {
  std::string text = "{\"a\": [0";
  for (int i = 0; i < 500'000; ++i) text += ",1";
  text += "], \"b\": 2, \"c\": [0";
  for (int i = 0; i < 500'000; ++i) text += ",1";
  text += "]}";
  const Sources sources = sources_of(text);
  const Document& file = sources.front();
  const std::string message =
      render({Severity::error, "BG113", "s", file.place(file.find(Document::root(), "b")), {}, {}, {}}, sources);
  CHECK(message.size() < 500);
  CHECK(message.find("1, ...") == std::string::npos);
  CHECK(message.find("1 | ...") != std::string::npos);
  CHECK(message.find("], \"b\": 2, \"c\": [0,1") != std::string::npos);
  // The caret is below the 2.
  const auto line = message.find("   1 | "), caret = message.find("     | ");
  const auto column = message.find('^', caret) - caret;
  CHECK(message[line + column] == '2');
}

TEST_CASE("a place that spans lines is marked to the end of its first line") {
  const Sources sources = sources_of("{\n  \"a\": [\n    1\n  ]\r\n}");
  const Document& file = sources.front();
  CHECK(render({Severity::error, "BG113", "s", file.place(file.find(Document::root(), "a")), {}, {}, {}}, sources) ==
        "two_sources.json:2:8: error BG113: s\n   2 |   \"a\": [\n     |        ^ /a\n  see docs/errors.md#bg113\n");
}

TEST_CASE("control characters of a file do not reach the terminal") {
  const Sources sources = sources_of("{\"a\": 1}");
  const std::string message = render({Severity::error, "BG111", "no key \"\x1B[31m\"", {}, {}, {}, {}}, sources);
  CHECK(message.find('\x1B') == std::string::npos);
}

TEST_CASE("an error of several problems tells the first and how many there are") {
  const Diagnostic one{Severity::error, "BG112", "first", {}, {}, {}, {}};
  const Diagnostic two{Severity::error, "BG113", "second", {}, {}, {}, {}};
  const ModelError error({one, two}, nullptr);
  CHECK(std::string(error.what()) == "BG112: first (and 1 more)");
  CHECK(render(error) ==
        "error BG112: first\n  see docs/errors.md#bg112\n\nerror BG113: second\n  see docs/errors.md#bg113\n");
}

TEST_CASE("the nearest name is a misspelling away, or there is none") {
  const std::vector<std::string> names{"resistance", "law", "kind", "R_b", "x_ref"};
  CHECK(nearest_name("resistence", names) == "resistance");
  CHECK(nearest_name("lwa", names) == "law");
  CHECK(nearest_name("r_b", names) == "R_b");
  CHECK(nearest_name("capacity", names).empty());
  CHECK(nearest_name("x", names).empty());
}

TEST_CASE("a message has the severity of its code") {
  const Diagnostic error = diagnostic_of("BG113", "situation", {}, "rule", "help");
  CHECK(error.severity == Severity::error);
  CHECK(render(error, {}) == "error BG113: situation\n  rule: rule\n  help: help\n  see docs/errors.md#bg113\n");
  CHECK(diagnostic_of("BG306").severity == Severity::warning);
  CHECK(code_row("BG306").title == "A field whose laws are not reciprocal");
  CHECK_THROWS_AS(diagnostic_of("BG999"), std::logic_error);
}
