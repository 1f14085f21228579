// What the roundings of the time part: the first steps of a scene that starts far from 0, a row and an event.
#include <algorithm>
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

TEST_CASE("two samplers whose common instants are doubles beside each other") {
  // 3*0.1 and 0.3, 3*0.07 and 0.21: a stretch of one rounding of the time, in which the second circuit, at rest until
  // then, begins to move. Its first scale was taken again without end (BG605).
  struct Pair {
    double first, second;
  };
  const auto held = [](double every, double (*of)(double), double stop) {
    double v = 0.0;
    for (int k = 0; k * every < stop; ++k) {
      const double length = std::min(every, stop - k * every), u = of(k * every);
      v = u + (v - u) * std::exp(-length);
    }
    return v;
  };
  for (const Pair pair : {Pair{0.1, 0.3}, Pair{0.3, 0.1}, Pair{0.1, 0.15}, Pair{0.21, 0.07}, Pair{0.21, 0.14}})
    for (const Method method : {Method::automatic, Method::bdf, Method::adams, Method::ida, Method::radau13,
                                Method::rodas5p, Method::erk5, Method::dirk5}) {
      INFO(pair.first << ' ' << pair.second << ' ' << method_name(method));
      const RunResult result = run_text(
          R"x({"bgsim": 1, "name": "samplers",
            "signals": {"u": {"value": "cos(t)", "every": )x" +
              std::to_string(pair.first) + R"x(}, "w": {"value": "sin(t)", "every": )x" + std::to_string(pair.second) +
              R"x(}},
            "elements": {"su": {"kind": "MSe", "effort": "u"}, "j": {"kind": "1"}, "r": {"kind": "R", "resistance": 1},
              "c": {"kind": "C", "capacitance": 1}, "sw": {"kind": "MSe", "effort": "w"}, "k": {"kind": "1"},
              "s": {"kind": "R", "resistance": 1}, "d": {"kind": "C", "capacitance": 1}},
            "bonds": [{"from": "su", "to": "j"}, {"from": "j", "to": "r"}, {"from": "j", "to": "c"},
              {"from": "sw", "to": "k"}, {"from": "k", "to": "s"}, {"from": "k", "to": "d"}],
            "outputs": {"u": "c.e", "w": "d.e"}, "scenes": {"s": {"stop": 2.02, "samples": 2}}})x",
          with_method(method));
      REQUIRE(result.stop == StopReason::completed);
      // A hundred tolerances, for twenty restarts.
      CHECK(std::abs(result.trace["u"][1] - held(pair.first, std::cos, 2.02)) < 1e-4);
      CHECK(std::abs(result.trace["w"][1] - held(pair.second, std::sin, 2.02)) < 1e-4);
    }
}

TEST_CASE("samples of two rates at multiples of each other are taken together, however their instants round") {
  // 18/972 and 18*(1/972) differ by two roundings: b had what a was one sample before.
  for (const double fs : {972.0, 1872.0, 333.0, 48000.0, 7.0})
    for (const double k : {7.0, 12.0, 18.0, 49.0}) {
      INFO(fs << ' ' << k);
      const RunResult result =
          run_text(R"x({"bgsim": 1, "name": "rates", "parameters": {"fs": )x" + std::to_string(fs) +
                       R"x(, "Ts": "1/fs", "k": )x" + std::to_string(k) + R"x(, "p": "k/fs"},
            "signals": {"a": {"value": "sin(3*t/p)", "every": "Ts"}, "b": {"value": "a", "every": "p"}},
            "elements": {"s": {"kind": "MSe", "effort": "b"}, "j": {"kind": "1"}, "r": {"kind": "R", "resistance": 1},
              "c": {"kind": "C", "capacitance": 0.1}},
            "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "r"}, {"from": "j", "to": "c"}],
            "outputs": {"a": "a", "b": "b"},
            "scenes": {"s": {"start": "0.01*p", "stop": "60.01*p", "samples": 61}}})x",
                   {});
      REQUIRE(result.stop == StopReason::completed);
      // A row is a hundredth of p behind each instant of b, before the next one of a.
      for (std::size_t n = 1; n < result.trace.times.size(); ++n) {
        CHECK(result.trace["b"][n] == result.trace["a"][n]);
        CHECK(std::abs(result.trace["a"][n] - std::sin(3.0 * static_cast<double>(n))) < 1e-9);  // roundings of t
      }
    }
}

}  // namespace bgsim
