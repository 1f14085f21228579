// Runs that cannot go on: what is said, and that it is said promptly.
#include <catch2/catch.hpp>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

std::string integrator(const std::string& flow, double initial, double stop) {
  return R"json({ "bgsim": 1, "name": "integrator",
    "elements": {
      "source": { "kind": "MSf", "flow": ")json" +
         flow + R"json(" }, "tank": { "kind": "0" },
      "store": { "kind": "C", "capacitance": 1, "initial": { "q": )json" +
         std::to_string(initial) + R"json( } }
    },
    "bonds": [ { "from": "source", "to": "tank" }, { "from": "tank", "to": "store" } ],
    "outputs": { "q": "store.q" },
    "scenes": { "main": { "stop": )json" +
         std::to_string(stop) + ", \"samples\": 11 } } }";
}

bool says(const RunResult& result, const std::string& code, const std::vector<std::string>& words) {
  if (!result.failure || result.failure->code != code) return false;
  std::string all = result.failure->situation;
  for (const Note& note : result.failure->notes) all += "\n" + note.text;
  INFO(all);
  const bool found = std::all_of(words.begin(), words.end(),
                                 [&](const std::string& word) { return all.find(word) != std::string::npos; });
  CHECK(found);
  return found;
}

}  // namespace

TEST_CASE("a relay that pushes to its own switching point ends with a message that names it") {
  const RunResult result = run_text(integrator("-sign(store.q)", 1, 2));
  REQUIRE(result.stop == StopReason::failed);
  CHECK(says(result, "BG604", {"sign(store.q)", "\"source\"", "t = 1"}));
  CHECK(result.report.steps < 1000);
  CHECK(result.report.reached == Approx(1.0).epsilon(1e-6));
  // the trace so far is kept: 0, 0.2, ..., 1
  REQUIRE(result.trace.times.size() >= 5);
  CHECK(column(result, "q")[4] == Approx(0.2).epsilon(1e-9));
}

TEST_CASE("growth without bound is recognised and dated") {
  const RunResult result = run_text(integrator("store.q^2", 1, 2));
  REQUIRE(result.stop == StopReason::failed);
  CHECK(says(result, "BG605", {"\"store.q\" grows without bound near t = 1"}));
  CHECK(result.report.steps < 5000);
  // 0, 0.2, ..., 0.8; and 1, where the growth is dated late by what the tolerance makes of it
  CHECK((result.trace.times.size() == 5 || result.trace.times.size() == 6));
}

TEST_CASE("growth beyond the range of numbers is distinguished from a law without a value") {
  const RunResult result = run_text(integrator("store.q", 1, 2000), with_relative(1e-3));
  REQUIRE(result.stop == StopReason::failed);
  CHECK(says(result, "BG605", {"\"store.q\" outgrows the range of numbers"}));
  CHECK(result.report.reached == Approx(709.78).epsilon(2e-2));  // log(1.8e308), at this tolerance
}

TEST_CASE("a law without a value stops the run at once, with element, expression and time") {
  const RunResult result = run_text(integrator("sqrt(0.5 - t)", 1, 2));
  REQUIRE(result.stop == StopReason::failed);
  CHECK(says(result, "BG601", {"sqrt(0.5 - t)", "\"source\"", "t = 0.5", "store.q"}));
  CHECK(result.report.steps < 500);
  CHECK(result.trace.times.size() == 3);
  for (const double q : column(result, "q")) CHECK(std::isfinite(q));
}

TEST_CASE("a law without a value at the start is the same message, not a solver's code") {
  const RunResult result = run_text(integrator("sqrt(-1 - t)", 1, 2));
  REQUIRE(result.stop == StopReason::failed);
  CHECK(says(result, "BG601", {"sqrt(-1 - t)", "\"source\"", "t = 0"}));
}

TEST_CASE("an interrupted run keeps its trace") {
  SimulateOptions options;
  options.progress = [](double t) { return t < 50.0; };
  const RunResult result = run_text(integrator("sin(t)", 0, 1000), {}, options);
  REQUIRE(result.stop == StopReason::interrupted);
  CHECK(says(result, "BG606", {"interrupted"}));
  CHECK(result.report.reached >= 50.0);
  CHECK(result.report.reached < 200.0);
  CHECK(!result.trace.times.empty());
}

TEST_CASE("a limit of steps ends the run with the time it got to") {
  SimulateOptions options;
  options.max_steps = 50;
  const RunResult result = run_text(integrator("sin(t)", 0, 1000), {}, options);
  REQUIRE(result.stop == StopReason::failed);
  CHECK(says(result, "BG607", {"50 steps", "t = 1000"}));
  CHECK(result.report.steps == 50);
}

TEST_CASE("conditions that contradict themselves are named") {
  // the source pushes the effort over the threshold only while it is not over it
  const std::string text = R"json({ "bgsim": 1, "name": "contradiction",
    "elements": {
      "source": { "kind": "MSe", "effort": "if(store.q + t > 0.5, -1, 1)" }, "loop": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1 },
      "store": { "kind": "C", "capacitance": 1 }
    },
    "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "store" } ],
    "outputs": { "q": "store.q" },
    "scenes": { "main": { "stop": 2, "samples": 3 } } })json";
  const RunResult result = run_text(text);
  REQUIRE(result.stop == StopReason::failed);
  CHECK(says(result, "BG604", {"\"source\""}));
}
