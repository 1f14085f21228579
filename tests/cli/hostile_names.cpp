// Names that somebody chose so that another program would act on them. The generator of many more is
// tests/contracts/hostile.py.
#include <catch2/catch.hpp>

#include "command.hpp"

using Catch::Contains;

namespace {

/// A model with one name for itself, its scene and its output. @p name is the inside of a JSON string.
std::string named(const std::string& name) {
  return R"({ "bgsim": 1, "name": ")" + name + R"(", "elements": { "r": { "kind": "R", "resistance": 1 },
  "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } } }, "bonds": [ { "from": "c", "to": "r" } ],
  "outputs": { ")" +
         name + R"(": { "value": "c.e", "unit": "V" } }, "scenes": { ")" + name +
         R"(": { "stop": 1, "samples": 5 } } })";
}

}  // namespace

TEST_CASE("a picture of a trade runs nothing that a name asks for, and shows the name") {
  const Workplace here;
  for (const std::string name : {"x'; system('touch PWNED'); #", "'; system('touch PWNED'); #", "`touch PWNED`",
                                 "Watt's governor", "x\\n system('touch PWNED')\\n"}) {
    here.write("m.json", named(name));
    CHECK(here.bgsim("trade m.json --budget 0.05 --quiet -o it").code == 0);
    CHECK_FALSE(here.has("PWNED"));
    const std::string shown = name.find("system") != std::string::npos ? "touch PWNED" : name;
    CHECK_THAT(here.read("it.svg"), Contains(shown));
  }
}

TEST_CASE("a plot runs nothing that a column's name or a title asks for") {
  const Workplace here;
  here.write("a.csv", "t,\"x'; system('touch PWNED'); #\",\"`touch PWNED`\",\"\x1b\n\"\n0,1,2,3\n1,2,3,4\n");
  CHECK(here.bgsim("plot a.csv --title \"'; system('touch PWNED') #\"").code == 0);
  CHECK_FALSE(here.has("PWNED"));
  CHECK_THAT(here.read("a.svg"), Contains("\\x1b\\n") && Contains("`touch PWNED`") && !Contains("\x1b"));
}

TEST_CASE("settings and programs beside a model are not used") {
  const Workplace here;
  here.write(".gnuplot", "system('touch PWNED')\n");
  here.write("gnuplot", "#!/bin/sh\ntouch PWNED\n");
  here.write("a.csv", "t,x\n0,1\n1,2\n");
  CHECK(here.bgsim("plot a.csv", "; chmod +x gnuplot").code == 0);
  const Outcome outcome = here.bgsim("--version", "; PATH=:.:$PATH '" BGSIM_COMMAND "' plot a.csv");
  CHECK(outcome.code == 0);
  CHECK_FALSE(here.has("PWNED"));
}

TEST_CASE("units beside a trace are JSON for a name with a line break, and its plot reads them") {
  const Workplace here;
  here.write("m.json", named("a\\n\\u0000b"));
  CHECK(here.bgsim("m.json --units -o x.csv --quiet").code == 0);
  CHECK(here.read("x.units.json") == "{\n  \"a\\n\\u0000b\": \"V\"\n}\n");
  CHECK_THAT(here.bgsim("plot x.csv -o -").out, Contains("a\\n\\x00b") && Contains("<text>V</text>"));
}
