// Conditions on variables of loops.
#include <catch2/catch.hpp>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

TEST_CASE("a condition on a loop that no rate needs changes where it should") {
  // The lamp has 6/7 of the voltage t, and the state beside it knows nothing of either.
  const RunResult result = run_text(R"({"bgsim": 1, "name": "beside", "signals": {"x": {"integral": "1"}},
    "elements": {"v": {"kind": "Se", "effort": "t"}, "r": {"kind": "R", "resistance": 1}, "series": {"kind": "1"},
                 "lamp": {"kind": "R", "resistance": 6}},
    "bonds": [{"from": "v", "to": "series"}, {"from": "series", "to": "r"}, {"from": "series", "to": "lamp"}],
    "outputs": {"x": "x", "bright": "if(lamp.e < 1, 0, 1) + 0"},
    "scenes": {
  "run" : { "stop" : 2, "times" : [ 1.1666, 1.1667, 2 ] }
}
})");
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.state_events == 1);
  CHECK(result.trace["bright"][0] == 0.0);  // 7/6 is 1.16667
  CHECK(result.trace["bright"][1] == 1.0);
  CHECK(result.trace["bright"][2] == 1.0);
}
