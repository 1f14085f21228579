// bgsim check --passive: what is printed, and the exit codes.
#include <catch2/catch.hpp>

#include "command.hpp"

using Catch::Contains;

TEST_CASE("a proof of passivity is printed by element, and its absence is exit code 1") {
  Workplace here;
  here.write("rc.json", R"x({ "bgsim": 1, "name": "rc", "parameters": { "R": 2, "b": 0 },
    "elements": { "s": { "kind": "Se", "effort": 3 }, "loop": { "kind": "1" },
      "r": { "kind": "R", "law": "e = R*f - b*tanh(f)" }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "c" } ],
    "outputs": { "u": "c.e" }, "scenes": { "a": { "stop": 1 }, "active": { "stop": 1, "parameters": { "b": 4 } } } })x");
  const Outcome proved = here.bgsim("check rc.json --passive");
  CAPTURE(proved.err, proved.out);
  CHECK(proved.code == 0);
  CHECK_THAT(proved.out, Contains("proved") && Contains("Passive:"));
  const Outcome active = here.bgsim("check rc.json --passive --scene active");
  CHECK(active.code == 1);
  CHECK_THAT(active.out, Contains("refuted") && Contains("e f < 0") && Contains("1.91") && !Contains("Passive:"));
  CHECK(here.bgsim("check rc.json --passive --set b=4").code == 1);
  const Outcome unknown = here.bgsim("check rc.json --passive --scene none");
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Contains("BG140"));
  const Outcome alone = here.bgsim("check rc.json --scene a");
  CHECK(alone.code == 2);
  CHECK_THAT(alone.err, Contains("--passive"));
}
