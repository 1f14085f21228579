// The run that tells what another one is wrong by.
#include "study/second_run.hpp"

#include <catch2/catch.hpp>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

TEST_CASE("a second run may take ten seconds and four times those of the first, and less where less was asked for") {
  const CompiledModel model = compile_text(R"({ "bgsim": 1, "name": "ball", "elements": { "n": { "kind": "1" },
      "m": { "kind": "I", "inertance": 1, "initial": { "p": 1 } } }, "bonds": [ { "from": "n", "to": "m" } ],
    "outputs": { "v": "n.f" }, "scenes": { "main": { "stop": 1, "samples": 2 } } })");
  const RunResult first = model.run();
  REQUIRE(first.stop == StopReason::completed);
  const auto limit_of = [&](double asked, double longest, double seconds) {
    SimulateOptions options;
    options.time_limit = asked;
    options.longest_run = longest;
    SecondRun second(model.inputs, options, true);
    RunResult result = first;
    result.report.errors = {};  // nothing was carried along
    double limit = -1.0;
    second.estimate(result, seconds, [&](const RunInputs&, const SimulateOptions& how) {
      limit = how.time_limit;
      RunResult other = first;
      other.stop = StopReason::failed;
      other.failure = Diagnostic{};
      other.failure->situation = "the limit was reached";
      return other;
    });
    CHECK(result.report.errors.why_not.find("did not complete: the limit was reached") != std::string::npos);
    return limit;
  };
  CHECK(limit_of(0.0, 1e5, 0.5) == 12.0);
  CHECK(limit_of(0.0, 1e5, 5.0) == 30.0);
  CHECK(limit_of(3.0, 1e5, 0.5) == 2.5);
  CHECK(limit_of(100.0, 1e5, 0.5) == 12.0);
  CHECK(limit_of(0.0, 0.0, 0.5) == 0.0);  // nothing depends on the time
}
