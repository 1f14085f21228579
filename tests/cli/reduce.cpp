// bgsim reduce and --keep-all: files, tables, exit codes.
#include <catch2/catch.hpp>

#include "command.hpp"

using Catch::Contains;

namespace {

/// A capacitor charged through a resistor; its leak hardly matters, and a lamp on the same battery not at all.
const char* const kLeaky = R"({
  "bgsim": 1, "name": "leaky",
  "parameters": { "R": 1 },
  "elements": {
    "battery": { "kind": "Se", "effort": 1 }, "rail": { "kind": "0" },
    "wire": { "kind": "1" }, "resistor": { "kind": "R", "resistance": "R" },
    "node": { "kind": "0" }, "store": { "kind": "C", "capacitance": 1 }, "leak": { "kind": "R", "resistance": 1e4 },
    "branch": { "kind": "1" }, "lamp": { "kind": "R", "resistance": 1 }, "coil": { "kind": "I", "inertance": 1 }
  },
  "bonds": [
    { "from": "battery", "to": "rail" }, { "from": "rail", "to": "wire" }, { "from": "wire", "to": "resistor" },
    { "from": "wire", "to": "node" }, { "from": "node", "to": "store" }, { "from": "node", "to": "leak" },
    { "from": "rail", "to": "branch" }, { "from": "branch", "to": "lamp" }, { "from": "branch", "to": "coil" }
  ],
  "outputs": { "u": "store.e" },
  "scenes": { "charge": { "stop": 3, "samples": 31 } }
})";

TEST_CASE("reduce writes a model that verifies against its parent's trace, and tells what it cut") {
  const Workplace here;
  here.write("leaky.json", kLeaky);
  const Outcome reduce = here.bgsim("reduce leaky.json --error 1e-3 --csv activity.csv --json reduced.json");
  CHECK(reduce.code == 0);
  CHECK_THAT(reduce.out, Contains("Left away, since no output depends on them: branch lamp coil"));
  CHECK_THAT(reduce.out, Contains("leak") && Contains("zero flow") && Contains("cut") && Contains("####"));
  CHECK_THAT(reduce.err, Contains("leaky.charge.reduced.json"));
  const std::string reduced = here.read("leaky.charge.reduced.json");
  CHECK_THAT(reduced,
             Contains("Reduced by bgsim from leaky.json for its scene charge") && Contains("leak (zero flow, "));
  CHECK_THAT(reduced, !Contains("\"leak\":") && !Contains("\"lamp\":"));
  CHECK_THAT(here.read("activity.csv"), Contains("element,kind,activity,share,cumulative"));
  CHECK_THAT(here.read("reduced.json"), Contains("\"trials\"") && Contains("\"made\": true"));
  const Outcome verify = here.bgsim("verify leaky.charge.reduced.json");
  CHECK(verify.code == 0);
  CHECK_THAT(verify.out, Contains("1 held, 0 missed"));
  CHECK(here.bgsim("leaky.charge.reduced.json").code == 0);
}

TEST_CASE("a run says what it leaves out, and --keep-all leaves out nothing") {
  const Workplace here;
  here.write("leaky.json", kLeaky);
  const Outcome less = here.bgsim("leaky.json --report-json less.json");
  CHECK(less.code == 0);
  CHECK_THAT(less.err, Contains("left out") && Contains("states coil.p; elements lamp, coil"));
  CHECK_THAT(here.read("less.json"), Contains("\"left_out\"") && Contains("\"coil.p\""));
  const Outcome all = here.bgsim("leaky.json --keep-all");
  CHECK(all.code == 0);
  CHECK_THAT(all.err, !Contains("left out") && Contains("2 states"));
}

TEST_CASE("reduce refuses an error that is none, and a model on standard output") {
  const Workplace here;
  CHECK(here.bgsim("reduce decay.json --error 0").code == 2);
  CHECK(here.bgsim("reduce decay.json -o -").code == 2);
  CHECK(here.bgsim("reduce decay.json --csv - --json -").code == 2);
  CHECK(here.bgsim("reduce decay.json --keep nobody").code == 1);
}

}  // namespace
TEST_CASE("a reduced model is not written where its data could not be read") {
  const Workplace here;
  here.write("tab.csv", "t,y\r\n0,1\r\n1,2\r\n2,3\r\n");
  here.write("tab.json", R"x({ "bgsim": 1, "name": "tab",
    "elements": { "v": { "kind": "Se", "effort": "table('tab.csv', 'y', t)" }, "in": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1 }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "v", "to": "in" }, { "from": "in", "to": "r" }, { "from": "in", "to": "c" } ],
    "outputs": { "q": "c.q" }, "scenes": { "run": { "stop": 1, "samples": 11 } } })x");
  REQUIRE(here.shell("mkdir below").code == 0);
  const Outcome below = here.bgsim("reduce tab.json --error 0.01 -o below/small.json");
  CHECK(below.code == 2);
  CHECK_THAT(below.err, Contains("the reduced model could not be read as below/small.json"));
  CHECK_FALSE(here.has("below/small.json"));
  CHECK(here.bgsim("reduce tab.json --error 0.01 -o small.json").code == 0);
  CHECK(here.bgsim("verify small.json").code == 0);
}
