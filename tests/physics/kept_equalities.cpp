// Equalities that are reached and kept, conditions of time that compare it with itself, and those that rounding
// decides.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
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

TEST_CASE("An integral that stops at its limits stays there and leaves them when its rate turns, by every method") {
  // u = 2 sin(1.6 t) + 0.25 cos(7.1 t): min(u, 0) turns within a step, which then leaves the limit before the rate
  // does. 100 changes at one instant, and BG604, were the end of it. Right is the clipped sum over 1e5 parts, by
  // midpoints.
  constexpr double kHigh = 0.29, kLow = -0.81, kStop = 11.0;
  constexpr int kParts = 110000, kSamples = 111;
  const auto u = [](double t) { return 2.0 * std::sin(1.6 * t) + 0.25 * std::cos(7.1 * t); };
  std::vector<double> right{0.05};
  double x = 0.05;
  for (int k = 0; k < kParts; ++k) {
    x = std::clamp(x + u((k + 0.5) * kStop / kParts) * kStop / kParts, kLow, kHigh);
    if ((k + 1) % (kParts / (kSamples - 1)) == 0) right.push_back(x);
  }
  for (const char* rate :
       {"if(x >= high, min(u, 0), if(x <= low, max(u, 0), u))", "if(x >= high and u > 0 or x <= low and u < 0, 0, u)",
        "if(not (x < high), min(u, 0), if(not (x > low), max(u, 0), u))"})
    for (const Method method : {Method::automatic, Method::bdf, Method::ida, Method::adams, Method::erk3, Method::erk5,
                                Method::dirk3, Method::dirk4}) {
      INFO(method_name(method) << ": " << rate);
      const RunResult run = run_text(R"x({"bgsim": 1, "name": "limited", "parameters": {"high": 0.29, "low": -0.81},
        "signals": {"u": "2*sin(1.6*t) + 0.25*cos(7.1*t)", "x": {"integral": ")x" +
                                         std::string(rate) + R"x(", "initial": 0.05}},
        "elements": {"s": {"kind": "Se", "effort": 1}, "r": {"kind": "R", "resistance": 1}},
        "bonds": [{"from": "s", "to": "r"}], "outputs": {"x": "x"}, "scenes": {"run": {"stop": 11, "samples": 111}}})x",
                                     with_method(method));
      REQUIRE(run.stop == StopReason::completed);
      CHECK(run.report.state_events < 200);
      // a ten thousandth of the range, the least that is noted, or a note
      double error = 0.0;
      for (std::size_t i = 0; i < right.size(); ++i) error = std::max(error, std::abs(column(run, "x")[i] - right[i]));
      CHECK((error < 1e-4 * (kHigh - kLow) || !run.report.notes.empty()));
      CHECK(error < 1e-3 * (kHigh - kLow));
    }
}
