#include "base/document.hpp"

#include <catch2/catch.hpp>

#include "bgsim/diagnostic.hpp"

using namespace bgsim;

namespace {

Document parsed(const std::string& text) { return Document::parse(DocumentId(0), "test.json", text); }

std::string slice(const Document& document, const Place& place) {
  return document.text().substr(place.begin, place.end - place.begin);
}

/// "CODE [faulty text] situation; help", or "none".
std::string fault(const std::string& text) {
  try {
    parsed(text);
  } catch (const ModelError& error) {
    const Diagnostic& d = error.diagnostics.front();
    const std::string at =
        d.place->begin < text.size() ? text.substr(d.place->begin, d.place->end - d.place->begin) : "";
    return d.code + " [" + at + "] " + d.situation + (d.help.empty() ? "" : "; " + d.help);
  }
  return "none";
}

}  // namespace

TEST_CASE("every value and every key of a document knows its bytes") {
  const Document d = parsed("{ \"a\" : [1, -2.5e3 ,true],\n\t\"b\":{\"c\":null,\"\":\"x\"} }");
  const NodeId a = d.find(Document::root(), "a"), b = d.find(Document::root(), "b");
  CHECK(slice(d, d.place(Document::root())) == d.text());
  CHECK(slice(d, d.key_place(a)) == "\"a\"");
  CHECK(slice(d, d.place(a)) == "[1, -2.5e3 ,true]");
  const auto items = d.children(a);
  REQUIRE(items.size() == 3);
  CHECK(slice(d, d.place(items[1])) == "-2.5e3");
  CHECK(d[items[1]].number == -2500.0);
  CHECK(slice(d, d.key_place(items[1])) == "-2.5e3");
  CHECK(d[items[2]].boolean);
  CHECK(slice(d, d.place(b)) == "{\"c\":null,\"\":\"x\"}");
  CHECK(slice(d, d.place(d.find(b, "c"))) == "null");
  CHECK(slice(d, d.key_place(d.find(b, ""))) == "\"\"");
  CHECK(d[d.find(b, "")].text == "x");
  CHECK_FALSE(d.find(b, "d").valid());
}

TEST_CASE("pointers name values by RFC 6901") {
  const Document d = parsed(R"({"a/b": {"~": [0, {"x y": 1}]}})");
  const NodeId list = d.find(d.find(Document::root(), "a/b"), "~");
  CHECK(d.pointer(Document::root()).empty());
  CHECK(d.pointer(list) == "/a~1b/~0");
  CHECK(d.pointer(d.find(d.children(list)[1], "x y")) == "/a~1b/~0/1/x y");
}

TEST_CASE("a place inside a text allows for its escapes") {
  // Decoded: a"b<TAB>c, Greek omega (2 bytes), U+1F600 (4 bytes), z
  const Document d = parsed(R"(["a\"b\tcΩ\uD83D\uDE00z"])");
  const NodeId text = d.children(Document::root())[0];
  const std::string decoded(d[text].text);
  REQUIRE(decoded == "a\"b\tc\xCE\xA9\xF0\x9F\x98\x80z");
  const auto at = [&](std::size_t begin, std::size_t end) { return slice(d, d.place_in_string(text, begin, end)); };
  CHECK(at(0, 1) == "a");
  CHECK(at(1, 2) == "\\\"");
  CHECK(at(3, 5) == "\\tc");
  CHECK(at(5, 7) == "Ω");
  CHECK(at(7, 11) == "\\uD83D\\uDE00");
  CHECK(at(11, 12) == "z");
  CHECK(at(0, decoded.size()) == R"(a\"b\tcΩ\uD83D\uDE00z)");
}

TEST_CASE("texts are the decoded ones, with escapes or without") {
  const Document d = parsed(R"({"key": "A\/é", "k2": "plain"})");
  CHECK(d[d.find(Document::root(), "key")].text == "A/é");
  CHECK(d[d.find(Document::root(), "k2")].text == "plain");
  const Document copy = d;  // views must stay valid in copies
  CHECK(copy[copy.find(Document::root(), "key")].text == "A/é");
}

TEST_CASE("a byte order mark is passed over") {
  const Document d = parsed("\xEF\xBB\xBF{\"a\":1}");
  CHECK(slice(d, d.place(d.find(Document::root(), "a"))) == "1");
}

TEST_CASE("numbers are read to the last bit and never bent into range") {
  const Document d = parsed("[0.1, 5e-324, 1.7976931348623157e308, 12345678901234567890, -0.0]");
  const auto n = d.children(Document::root());
  CHECK(d[n[0]].number == 0.1);
  CHECK(d[n[1]].number == 5e-324);
  CHECK(d[n[2]].number == 1.7976931348623157e308);
  CHECK(d[n[3]].number == 12345678901234567890.0);
  CHECK(std::signbit(d[n[4]].number));
  CHECK(fault("[1, 2e308]") ==
        "BG103 [2e308] the number 2e308 is too large for a double (about 1.8e308); choose other units");
  CHECK(fault("[1, -1e-400]") ==
        "BG103 [-1e-400] the number -1e-400 is too small for a double: it would become 0; write 0, or choose other "
        "units");
  CHECK(fault("[0e-400, 0.000]") == "none");
}

TEST_CASE("usual mistakes in JSON are called by their names") {
  const std::string prefix = "BG101 ";
  const std::string json = "this is not JSON: ";
  CHECK(fault("") == prefix + "[] " + json + "the file is empty; the file seems to be cut off");
  CHECK(fault("{\"a\": 1,}") == prefix + "[,] " + json + "nothing follows this comma; remove the last comma");
  CHECK(fault("[1,2,]") == prefix + "[,] " + json + "nothing follows this comma; remove the last comma");
  CHECK(fault("[1,,2]") == prefix + "[,] " + json + "there are two commas; remove one of them");
  CHECK(fault("{\"a\": 1 // x\n}") == prefix + "[/] " + json + "comments are not allowed; put remarks under \"about\"");
  CHECK(fault("{'a': 1}") == prefix + "['] " + json + "names and texts are written in double quotes; write \"...\"");
  CHECK(fault("{a: 1}") == prefix + "[a] " + json + "a name in double quotes is expected here, not a");
  CHECK(fault("{\"a\" 1}") == prefix + "[1] " + json + "a colon is missing between a name and its value");
  CHECK(fault("{\"a\": 1 \"b\": 2}") ==
        prefix + "[\"] " + json + "a comma or a closing bracket is missing before \"b\"");
  CHECK(fault("[1 2]") == prefix + "[2] " + json + "a comma or a closing bracket is missing before 2");
  CHECK(fault("{\"a\": NaN}") == prefix + "[N] " + json + "NaN is not a number; write a finite number");
  CHECK(fault("{\"a\": True}") ==
        prefix + "[T] " + json + "True is not a value; write true, false or null in small letters");
  CHECK(fault("{\"a\": .5}") == prefix + "[.] " + json + ".5 is not a value; write 0.5");
  CHECK(fault("{\"a\": 1}\n}") ==
        prefix + "[}] " + json + "something follows the end of the model; one file holds one model");
  CHECK_THAT(fault(std::string("{\"a\": 1}\0}", 10)), Catch::Contains("something follows the end of the model"));
  CHECK_THAT(fault(std::string("{\"a\": 1}\0", 9)), Catch::Contains("something follows the end of the model"));
  CHECK(fault("{\"a\":\n{\"b\": 1") ==
        prefix + "[] " + json + "the text ends, but the { in line 2 is not closed; the file seems to be cut off");
  CHECK(fault("{\"a\": \"x\n\"}") ==
        prefix + "[\"] " + json +
            "this text is not closed at the end of its line; close it with \", or write \\n for a line break");
  CHECK(fault("{\"a\": \"x") == prefix + "[\"] " + json + "this text is not closed; close it with \"");
  CHECK(fault("[\"\\x\"]") ==
        prefix + "[x] " + json + "this escape is unknown; escapes are \\\" \\\\ \\/ \\b \\f \\n \\r \\t and \\uXXXX");
  CHECK(fault("[\"\xC3\x28\"]") == prefix + "[(] " + json + "the text is not valid UTF-8; save the file as UTF-8");
  CHECK(fault(std::string("[\"a\x01\"]")) ==
        prefix + "[\x01] " + json + "a text holds a control character; write it as an escape, such as \\t");
}

TEST_CASE("duplicate keys are reported with both places, in small objects and large ones") {
  CHECK_THAT(fault("{\"a\": 1, \"b\": 2, \"a\": 3}"),
             Catch::StartsWith("BG102 [\"a\"] the key \"a\" occurs twice in the same object; r"));
  std::string large = "{";
  for (int i = 0; i < 1000; ++i) large += "\"k" + std::to_string(i) + "\": 0, ";
  CHECK(fault(large + "\"z\": 0}") == "none");
  CHECK_THAT(fault(large + "\"k500\": 0}"), Catch::StartsWith("BG102 [\"k500\"] th"));
  try {
    parsed("{\"a\": {\"x\": 1, \"x\": 2, \"x\": 3}, \"\\u0061\": 2}");
    FAIL("accepted");
  } catch (const ModelError& error) {
    CHECK(error.diagnostics.size() == 3);  // an escape does not make another key of it
  }
}

TEST_CASE("nesting a million deep needs no stack") {
  const std::size_t depth = 1'000'000;
  const Document d = parsed(std::string(depth, '[') + std::string(depth, ']'));
  CHECK(d.size() == depth);
  CHECK(d.pointer(NodeId(depth - 1)).size() == 2 * (depth - 1));
}
