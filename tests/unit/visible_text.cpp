// The writers of text for people, XML, CSV and JSON: what a name may hold, whatever it holds.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bgsim/csv.hpp"
#include "bgsim/text.hpp"
#include "bgsim/trace_csv.hpp"
#include "bgsim/xml.hpp"

using namespace std::string_literals;
using bgsim::short_name;
using bgsim::visible_line;
using bgsim::visible_text;

TEST_CASE("what has a shape stays as it is") {
  for (const char* text : {"", "rc", "Watt's governor", "\"a\\b\"", "\u03c9\u2080 \u00fcber \u6f22\u5b57", "q\u0307",
                           "\u06a9\u200c\u06a9", "\U0001f527", "a b  c"}) {
    CHECK(visible_text(text) == text);
    CHECK(visible_line(text) == text);
  }
}

TEST_CASE("control characters, marks without a shape and bytes that are no UTF-8 are written out") {
  CHECK(visible_text("\x1b[31mred\x7f"s) == "\\x1b[31mred\\x7f");
  CHECK(visible_text("a\0b"s) == "a\\x00b");
  CHECK(visible_text("\u009b31m\u0085") == "\\u{9b}31m\\u{85}");
  CHECK(visible_text("\u202etxt\u2066\u200b\ufeff") == "\\u{202e}txt\\u{2066}\\u{200b}\\u{feff}");
  CHECK(visible_text("\x9b\xff") == "\\x9b\\xff");
  CHECK(visible_text("\xc3") == "\\xc3");                    // cut off
  CHECK(visible_text("\xc0\xaf") == "\\xc0\\xaf");           // longer than needed
  CHECK(visible_text("\xed\xa0\x80") == "\\xed\\xa0\\x80");  // a surrogate
  CHECK(visible_text("\xf4\x90\x80\x80") == "\\xf4\\x90\\x80\\x80");
  CHECK(visible_text("\U0010ffff\U000e0041") == "\\u{10ffff}\\u{e0041}");
}

TEST_CASE("a text keeps its lines, a line holds none") {
  CHECK(visible_text("a\nb\tc\r\nd\re") == "a\nb\tc\nd\\re");
  CHECK(visible_line("a\nb\tc\r\nd\re") == "a\\nb\\tc\\r\\nd\\re");
}

TEST_CASE("what is written out is written out once") {
  std::string all;
  for (int byte = 0; byte < 256; ++byte) all += static_cast<char>(byte);
  all += "\u202e\u0301\u0301\u0301\u0301\u0301\u0301";
  CHECK(visible_text(visible_text(all)) == visible_text(all));
  CHECK(visible_line(visible_line(all)) == visible_line(all));
}

TEST_CASE("a flood of marks on one letter is written out from the fifth on") {
  std::string flood = "a";
  for (int i = 0; i < 6; ++i) flood += "\u0301";
  CHECK(visible_text(flood) == "a\u0301\u0301\u0301\u0301\\u{301}\\u{301}");
}

TEST_CASE("a long name is shown by its ends and its length, cut between characters") {
  CHECK(short_name("short\n") == "short\\n");
  CHECK(short_name(std::string(120, 'a')) == std::string(120, 'a'));
  CHECK(short_name(std::string(1000000, 'a')) ==
        std::string(80, 'a') + "..." + std::string(20, 'a') + " (1000000 characters)");
  std::string wide;
  for (int i = 0; i < 200; ++i) wide += "\u6f22";
  const std::string shown = short_name(wide);
  CHECK(visible_line(shown) == shown);
  CHECK_THAT(shown, Catch::EndsWith(" (200 characters)"));
}

TEST_CASE("XML holds any text, and shows what it has no place for") {
  CHECK(bgsim::xml_text("<a b=\"&\">") == "&lt;a b=&quot;&amp;&quot;&gt;");
  CHECK(bgsim::xml_text("\x1b\0\ufffe\xff\r\n"s) == "\\x1b\\x00\\u{fffe}\\xff\n");
}

TEST_CASE("a name of a column comes back from CSV as it was") {
  for (const std::string& name :
       std::vector<std::string>{"=cmd|' /C calc'!A0", "a,b", "\"", "a\r\nb", "\r", " x ", "\x1b\0"s, "\xff"}) {
    const bgsim::Trace trace{{name}, {""}, {0.0}, {{1.0}}};
    std::ostringstream text;
    bgsim::write_trace_csv(text, trace);
    CHECK(bgsim::parse_csv(text.str()).names.back() == name);
  }
}

TEST_CASE("units are JSON whatever the names hold, and read back the same where they are UTF-8") {
  const std::vector<std::string> names{"a\nb", "\x1b\0"s, "\"\\", "</script>", "\u2028"};
  const auto units = nlohmann::json::parse(bgsim::trace_units_json({names, {"1", "2", "3", "4", "5"}, {}, {}}));
  for (std::size_t i = 0; i < names.size(); ++i) CHECK(units.at(names[i]) == std::to_string(i + 1));
  CHECK(nlohmann::json::parse(bgsim::trace_units_json({{"\xff"}, {"m"}, {}, {}})).at("\ufffd") == "m");
  CHECK(bgsim::trace_units_json({{"x"}, {""}, {}, {}}) == "{}\n");
}
