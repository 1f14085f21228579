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

TEST_CASE("a scene starts at 1e8 s with a source that begins at 0") {
  // v' = (sin(s) - v)/tau with s = (t - t0)/tau: v = (sin(s) - cos(s) + exp(-s))/2. A spacing of doubles is 1.5e-6 of
  // tau there, and the state of the first steps is far below what that makes of it.
  constexpr double kTau = 0.01, kEps = std::numeric_limits<double>::epsilon();
  for (const std::string start : {"0", "1e7", "1e8"})
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

}  // namespace bgsim
