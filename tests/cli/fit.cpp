// bgsim fit: the tables, the files, what is refused; and bgsim without it.
#include <catch2/catch.hpp>
#include <filesystem>

#include "command.hpp"

using Catch::Contains;

namespace {

namespace fs = std::filesystem;

const char* const kModel = R"({ "bgsim": 1, "name": "rc",
  "parameters": { "R": { "value": 2, "unit": "ohm" }, "C": { "value": 0.5, "unit": "F" } },
  "elements": { "s": { "kind": "Se", "effort": 3 }, "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
    "c": { "kind": "C", "capacitance": "C" } },
  "bonds": [ { "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "c" } ],
  "outputs": { "u": { "value": "c.e", "unit": "V" } },
  "scenes": { "charge": { "stop": 4, "samples": 41, "relative": 1e-9 }, "from_one": { "stop": 3, "samples": 31, "relative": 1e-9, "initial": { "c.q": 1 } } } }
)";

bool is_built() { return fs::exists(fs::path(bgsim_path()).parent_path() / "bgsim-fit"); }

Workplace& with_data(Workplace& here) {
  here.write("rc.json", kModel);
  REQUIRE(here.bgsim("rc.json --set R=1.25 --output volts=c.e -o data.csv --quiet").code == 0);
  REQUIRE(here.bgsim("rc.json --scene from_one --set R=1.25 --output volts=c.e -o other.csv --quiet").code == 0);
  return here;
}

}  // namespace

TEST_CASE("a fit prints values and residuals, and writes the model and the traces") {
  if (!is_built()) return;
  Workplace here;
  const Outcome found =
      with_data(here).bgsim("fit rc.json data.csv --match u=volts --vary R=0.5:4 --write fitted.json -o both.csv");
  CAPTURE(found.err);
  CHECK(found.code == 0);
  CHECK_THAT(found.out, Contains("R  1.25 ") && Contains("ohm") && Contains("volts") && Contains("41 values compared"));
  std::string expected = kModel;
  const auto at = expected.find("\"value\": 2");
  const std::string fitted = here.read("fitted.json");
  CHECK(fitted.substr(0, at) == expected.substr(0, at));
  CHECK(fitted.substr(fitted.find(", \"unit\": \"ohm\"")) == expected.substr(expected.find(", \"unit\": \"ohm\"")));
  CHECK_THAT(here.read("both.csv"), Catch::StartsWith("t,u,data(volts)\r\n0,0,0\r\n"));
  CHECK(here.bgsim("fitted.json --quiet").code == 0);
}

TEST_CASE("several scenes, quantities that are no outputs, words for what is not told apart") {
  if (!is_built()) return;
  Workplace here;
  with_data(here);
  const Outcome scenes =
      here.bgsim("fit rc.json --data charge=data.csv --data from_one=other.csv --match u=volts --vary R,C=0.1:3");
  CAPTURE(scenes.err);
  CHECK(scenes.code == 0);
  CHECK_THAT(scenes.out,
             Contains("R  1.25 ") && Contains("C  0.5 ") && Contains("from_one") && Contains("correlation"));
  const Outcome together = here.bgsim("fit rc.json data.csv --match c.e=volts --vary R --vary C=0.1:3");
  CAPTURE(together.err);
  CHECK(together.code == 0);
  CHECK_THAT(together.out, Contains("do not tell R and the others apart") && Contains("R by 1 %, C by -1 %"));
}

TEST_CASE("what a fit is asked for and cannot do is wrong usage, and writes nothing") {
  if (!is_built()) return;
  Workplace here;
  with_data(here);
  const auto refused = [&](const std::string& arguments, int code, const std::string& part) {
    const Outcome outcome = here.bgsim("fit " + arguments);
    CAPTURE(arguments, outcome.err);
    CHECK(outcome.code == code);
    CHECK_THAT(outcome.err, Contains(part));
    CHECK(outcome.out.empty());
  };
  refused("", 2, "model.json");
  refused("rc.json", 2, "which data");
  refused("rc.json none.csv --match u=volts --vary R", 2, "none.csv");
  refused("rc.json data.csv --match u --vary R", 2, "OUTPUT=COLUMN");
  refused("rc.json data.csv --match u=volt --vary R", 2, "did you mean \"volts\"?");
  refused("rc.json data.csv --match w=volts --vary R", 2, "w");
  refused("rc.json data.csv --match u=volts --vary Q", 2, "BG413");
  refused("rc.json data.csv --match u=volts --vary R=4:1", 2, "BG416");
  refused("rc.json data.csv --match u=volts", 2, "BG415");
  refused("rc.json data.csv --vary R", 2, "BG418");
  refused("rc.json data.csv --match u=volts --vary R --scene none", 2, "BG140");
  refused("rc.json data.csv --match u=volts --vary R --stop 1 --start 5", 2, "BG143");
  refused("rc.json data.csv --match u=volts --vary R --sigma u=-1", 2, "--sigma");
  refused("rc.json data.csv --match u=volts --vary R --sigma i=1", 2, "no --match");
  refused("rc.json data.csv --match u=volts --vary R --sigma u=0.1 --sigma u=0.2", 2, "twice");
  refused("rc.json data.csv --match u=volts --vary R --loss square", 2, "huber:D");
  refused("rc.json data.csv --match u=volts --vary R --loss huber:1", 2, "BG418");
  refused("rc.json data.csv --data charge=data.csv --match u=volts --vary R", 2, "--data");
  refused("rc.json data.csv --match u=volts --vary R --write data.csv", 2, ".json");
  refused("rc.json data.csv --match u=volts --vary R --write rc.json", 2, "rc.json");
  refused("rc.json data.csv --match u=volts --vary R -o data.csv", 2, "data.csv");
  refused("rc.json data.csv --match u=volts --vary R --max-steps 3", 3, "BG607");
  const Outcome few = here.bgsim("fit rc.json data.csv --match u=volts --vary R --iterations 1 --write fitted.json");
  CHECK(few.code == 3);
  CHECK_THAT(few.err, Contains("not converged"));
  CHECK(!here.has("fitted.json"));
}

TEST_CASE("a value whose influence is rounding has none") {
  if (!is_built()) return;
  // The mass of a pendulum cancels; its derivative is some 1e-16. It had a standard error of 3e12.
  Workplace here;
  here.write("pendulum.json",
             R"x({"bgsim": 1, "name": "pendulum", "parameters": {"m": 0.3, "g": 9.81, "L": 0.7, "b": 0.2},
    "signals": {"th": {"integral": "w.f", "initial": 0.5}},
    "elements": {"w": {"kind": "1"}, "I": {"kind": "I", "inertance": "m*L^2"}, "G": {"kind": "MSe", "effort": "-m*g*L*sin(th)"},
                 "r": {"kind": "R", "resistance": "b*m"}},
    "bonds": [{"from": "w", "to": "I"}, {"from": "G", "to": "w"}, {"from": "w", "to": "r"}], "outputs": {"th": "th"},
    "scenes": {"s": {"stop": 3, "samples": 61}}})x");
  REQUIRE(here.bgsim("run pendulum.json --set L=0.72 -o data.csv").code == 0);
  const Outcome both = here.bgsim("fit pendulum.json data.csv --match th=th --vary L,m");
  CHECK(both.code == 2);
  CHECK_THAT(both.err, Contains("BG419") && Contains("\"m\" = 0.3 has no influence"));
}

TEST_CASE("bgsim without bgsim-fit beside it says what fit needs") {
  Workplace here;
  fs::copy_file(bgsim_path(), fs::path(here.folder()) / "alone");
  const Outcome alone = here.shell("./alone fit --help");
  CHECK(alone.code == 2);
  CHECK_THAT(alone.err, Contains("scripts/bgsim fit") && Contains("libceres-dev"));
  CHECK(here.shell("./alone --help").out.find("  fit ") != std::string::npos);
}
