// Equalities that are reached and kept, conditions of time that compare it with itself, and those that rounding
// decides.
#include <algorithm>
#include <catch2/catch.hpp>
#include <tuple>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A source that a condition on the tank's level switches, seen by an integral.
std::string level_switch(const std::string& value) {
  return R"({"bgsim": 1, "name": "level", "elements": {"fill": {"kind": "Sf", "flow": 1},
    "tank": {"kind": "C", "capacitance": 1}, "drive": {"kind": "MSe", "effort": ")" +
         value + R"("}, "r": {"kind": "R", "resistance": 1}},
    "signals": {"sum": {"integral": "drive.e"}},
    "bonds": [{"from": "fill", "to": "tank"}, {"from": "drive", "to": "r"}],
    "outputs": {"e": "drive.e", "sum": "sum", "q": "tank.q"}, "scenes": {"run": {"stop": 2.25, "samples": 10}}})";
}

}  // namespace

TEST_CASE("A level that is reached and kept fulfils its condition") {
  // The level passes 1 at t = 1, where min(tank.q, 1) comes to rest.
  for (const auto& [law, before, after] :
       {std::tuple("if(min(tank.q, 1) >= 1, 1, 2)", 2.0, 1.0), std::tuple("if(min(tank.q, 1) < 1, 2, 1)", 2.0, 1.0),
        std::tuple("if(max(1 - tank.q, 0) <= 0, 1, 2)", 2.0, 1.0), std::tuple("2 - step(min(tank.q, 1) - 1)", 2.0, 1.0),
        std::tuple("floor(min(tank.q, 1))", 0.0, 1.0), std::tuple("if(max(1 - tank.q, 0) > 0, 2, 1)", 2.0, 1.0)}) {
    INFO(law);
    const RunResult run = run_text(level_switch(law));
    REQUIRE(run.stop == StopReason::completed);
    CHECK(column(run, "e").front() == before);
    CHECK(last(run, "e") == after);
    CHECK(last(run, "sum") == Approx(before + 1.25 * after).epsilon(1e-9));  // linear: no error but the event's
  }
}

TEST_CASE("Conditions of time that compare it with itself change where their sides part") {
  const auto values = [](const std::string& effort) {
    return column(run_text(R"({"bgsim": 1, "name": "own", "elements": {"s": {"kind": "Se", "effort": ")" + effort +
                           R"("}, "r": {"kind": "R", "resistance": 1}}, "bonds": [{"from": "s", "to": "r"}],
    "outputs": {"e": "s.e"}, "scenes": {"run": {"stop": 2, "samples": 5}}})"),
                  "e");
  };
  // at 0, 0.5, 1, 1.5, 2, continuous from the right
  CHECK(values("if(t > min(t, 1), 1, 2)") == std::vector<double>{2, 2, 1, 1, 1});
  CHECK(values("floor(1 - t)") == std::vector<double>{0, 0, -1, -1, -2});
  CHECK(values("if(abs(t - 1) > t - 1, 1, 2)") == std::vector<double>{1, 1, 2, 2, 2});
}

TEST_CASE("A condition that rounding decides is reported, and the run ends", "[long]") {
  const RunResult run = run_text(R"x({"bgsim": 1, "name": "noise", "elements": {"s": {"kind": "Se",
    "effort": "floor(sin(t)^2 + cos(t)^2)"}, "r": {"kind": "R", "resistance": 1}},
    "bonds": [{"from": "s", "to": "r"}], "outputs": {"e": "s.e"}, "scenes": {"run": {"stop": 2, "samples": 5}}})x");
  REQUIRE(run.stop == StopReason::completed);
  const auto& notes = run.report.notes;
  CHECK(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
    return note.find("floor(sin(t)^2 + cos(t)^2) is at its border") != std::string::npos;
  }));
}
