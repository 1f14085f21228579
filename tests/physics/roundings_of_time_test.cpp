// What the roundings of the time part: the first steps of a scene that starts far from 0, a row and an event.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "support/run.hpp"

namespace bgsim {
namespace {

using namespace test;

}  // namespace

TEST_CASE("a scene starts at 1e9 s with a source that begins at 0") {
  // v' = (sin(s) - v)/tau with s = (t - t0)/tau: v = (sin(s) - cos(s) + exp(-s))/2. A spacing of doubles is 1e-5 of tau
  // there, and the state of the first steps is far below what that makes of it.
  constexpr double kTau = 0.01, kEps = std::numeric_limits<double>::epsilon();
  for (const std::string start : {"0", "1e7", "1e8", "1e9"})
    for (const Method method : {Method::automatic, Method::bdf, Method::adams, Method::ida, Method::radau,
                                Method::radau9, Method::rodas5p, Method::erk5, Method::dirk5}) {
      INFO(start << ' ' << method_name(method));
      const RunResult result = run_text(R"x({"bgsim": 1, "name": "far", "parameters": {"t0": )x" + start + R"x(},
        "elements": {"s": {"kind": "Se", "effort": "sin((t - t0)/0.01)"}, "j": {"kind": "1"},
                     "r": {"kind": "R", "resistance": 1}, "c": {"kind": "C", "capacitance": 0.01}},
        "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "r"}, {"from": "j", "to": "c"}],
        "outputs": {"v": "c.e"}, "scenes": {"s": {"start": "t0", "stop": "t0 + 0.1", "samples": 11}}})x",
                                        with_method(method));
      REQUIRE(result.stop == StopReason::completed);
      const double t0 = std::stod(start);
      for (std::size_t k = 0; k < result.trace.times.size(); ++k) {
        const double s = (result.trace.times[k] - t0) / kTau;
        const double right = (std::sin(s) - std::cos(s) + std::exp(-s)) / 2.0;
        // Fifty tolerances; the tolerance allows for twenty roundings of the time, by which v moves at 1/tau at most.
        CHECK(std::abs(result.trace["v"][k] - right) < 5e-5 + 20.0 * kEps * t0 / kTau);
      }
    }
}

TEST_CASE("a row that roundings part from a known time shows what comes after it") {
  // Row 4n is at n T as the scene counts it, n T + 0.5 T the middle of the period: each by a rounding before or after
  // the instants at which the conditions change.
  for (const double period : {29.563693357721686, 2.521979042212251, 0.1, 1.0 / 3.0}) {
    const std::string text = number_text(period, 17);
    INFO(text);
    const RunResult result = run_text(R"x({"bgsim": 1, "name": "rows", "parameters": {"T": )x" + text + R"x(},
      "signals": {"n": {"integral": "0"}, "half": {"integral": "0"}},
      "elements": {"s": {"kind": "Sf", "flow": 1}, "r": {"kind": "R", "resistance": 1}},
      "bonds": [{"from": "s", "to": "r"}],
      "events": {"a": {"when": "mod(t, T) < T/2", "set": {"n": "n + 1"}},
                 "b": {"when": "mod(t - 0.5*T, T) < 0.25*T", "set": {"half": "half + 1"}}},
      "outputs": {"n": "n", "half": "half"}, "scenes": {"s": {"stop": "20*T", "samples": 81}}})x");
    REQUIRE(result.stop == StopReason::completed);
    for (std::size_t row = 0; row + 1 < 81; ++row) {
      CHECK(result.trace["n"][row] == static_cast<double>(row / 4));
      CHECK(result.trace["half"][row] == static_cast<double>((row + 2) / 4));
    }
  }
}

}  // namespace bgsim
