// mode("name"): the side of a switch, diode or contact as a condition.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

RunResult completed(const std::string& text, Method method = Method::automatic) {
  RunResult result = Study::from_text(text).scene({}, with_method(method, 1e-8)).simulate(untimed());
  INFO((result.failure ? result.failure->situation : ""));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

std::string refusal(const std::string& text) {
  try {
    Study::from_text(text);
  } catch (const ModelError& error) {
    std::string all;
    for (const Diagnostic& problem : error.diagnostics) all += problem.code + ": " + problem.situation + "\n";
    return all;
  }
  return "";
}

/// A half-wave rectifier into R, with more.
std::string rectifier(const std::string& signals, const std::string& outputs, const std::string& more = "") {
  return R"x({"bgsim": 1, "name": "m", )x" + more + R"x("signals": {)x" + signals +
         R"x(}, "elements": {"s": {"kind": "Se", "effort": "sin(t)"}, "n": {"kind": "1"}, "d": {"kind": "D"},
         "r": {"kind": "MR", "law": "e = f"}}, "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "d"}, {"from": "n", "to": "r"}],
         "outputs": {)x" +
         outputs + R"x(}, "scenes": {"run": {"stop": 20, "samples": 401}}})x";
}

}  // namespace

TEST_CASE("the mode of a diode is known to outputs, integrals, events and latches") {
  for (const Method method : {Method::automatic, Method::bdf, Method::erk5}) {
    const RunResult result = completed(
        rectifier(
            R"x("on": "mode('d')", "time": {"integral": "if(on, 1, 0)"}, "count": {"integral": "0"},
                     "seen": {"set": "not mode('d')", "reset": "t < 0"}, "held": {"value": "if(mode('d'), 1, 2)", "every": 5})x",
            R"x("on": "if(mode('d'), 1, 0)", "time": "time", "count": "count", "seen": "if(seen, 1, 0)", "held": "held")x",
            R"x("events": {"up": {"when": "on", "set": {"count": "count + 1"}}}, )x"),
        method);
    const double pi = std::acos(-1.0);
    for (std::size_t row = 0; row < result.trace.times.size(); ++row) {
      const double t = result.trace.times[row], periods = std::floor(t / (2 * pi)), phase = t - 2 * pi * periods;
      if (std::abs(std::sin(t)) < 1e-9) continue;
      CHECK(result.trace["on"][row] == (phase < pi ? 1.0 : 0.0));
      CHECK(result.trace["time"][row] == Approx(periods * pi + std::min(phase, pi)).margin(1e-9));
      CHECK(result.trace["count"][row] ==
            Approx(periods).margin(1e-12));  // what holds at the start has not become true
      CHECK(result.trace["seen"][row] == (t > pi ? 1.0 : 0.0));
      const double sample = 5 * std::floor(t / 5);
      if (sample > 0)
        CHECK(result.trace["held"][row] == Approx(std::fmod(sample, 2 * pi) < pi ? 1.0 : 2.0).epsilon(1e-12));
    }
  }
}

TEST_CASE("a law may depend on the mode of a switch, in series with it or not") {
  const RunResult result = completed(
      R"x({"bgsim": 1, "name": "m",
    "elements": {"s": {"kind": "Se", "effort": 6}, "n": {"kind": "1"}, "w": {"kind": "Sw", "closed": "t >= 1 and t < 2"},
                 "r": {"kind": "R", "resistance": 2}, "s2": {"kind": "MSe", "effort": "if(mode('w'), 5, 3)"},
                 "r2": {"kind": "MR", "resistance": "if(mode('w') and t < 1.5, 5, 3)"}},
    "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "w"}, {"from": "n", "to": "r"}, {"from": "s2", "to": "r2"}],
    "outputs": {"i": "r.f", "j": "r2.f"}, "scenes": {"run": {"times": [0.5, 1, 1.4, 1.6, 2, 3], "stop": 3}}})x");
  const double expected[6][2] = {{0, 1}, {3, 1}, {3, 1}, {3, 5.0 / 3}, {0, 1}, {0, 1}};
  for (std::size_t row = 0; row < 6; ++row) {
    CHECK(result.trace["i"][row] == expected[row][0]);
    CHECK(result.trace["j"][row] == Approx(expected[row][1]).epsilon(1e-15));
  }
}

TEST_CASE("a switch follows the mode of another one from the start on, and nothing is lost for it") {
  // The coil's way is closed by w2, which follows w1: opened at the start, its current would be lost.
  const RunResult result = completed(
      R"x({"bgsim": 1, "name": "m",
    "elements": {"c": {"kind": "I", "inertance": 1, "initial": {"f": 1}}, "n": {"kind": "1"},
                 "w2": {"kind": "Sw", "closed": "mode('w1')"}, "w1": {"kind": "Sw", "closed": "t < 2"},
                 "r": {"kind": "R", "resistance": 1}},
    "bonds": [{"from": "n", "to": "c"}, {"from": "n", "to": "w2"}, {"from": "n", "to": "r"}, {"from": "n", "to": "w1"}],
    "outputs": {"i": "c.f", "m": "if(mode('w2'), 1, 0)"}, "scenes": {"run": {"times": [0, 1, 1.999], "stop": 1.999}}})x");
  CHECK(result.trace["i"][0] == 1.0);
  CHECK(result.trace["i"][1] == Approx(std::exp(-1.0)).epsilon(1e-7));
  CHECK(result.trace["m"][2] == 1.0);
  CHECK(result.report.energy.switching == 0.0);
}

TEST_CASE("locked switches, contacts and junctions have modes that say what they are called by") {
  const RunResult result = completed(
      R"x({"bgsim": 1, "name": "m",
    "elements": {"fall": {"kind": "1"}, "ball": {"kind": "I", "inertance": 1}, "weight": {"kind": "Se", "effort": 9.81},
                 "ground": {"kind": "contact", "gap": 0, "initial": {"q": -1}},
                 "s": {"kind": "Se", "effort": 1}, "j": {"kind": "1", "on": "t > 0.25"}, "r": {"kind": "R", "resistance": 1},
                 "z": {"kind": "0", "on": "t > 0.25"}, "f": {"kind": "Sf", "flow": 1}, "g": {"kind": "R", "resistance": 1},
                 "v": {"kind": "1"}, "m": {"kind": "I", "inertance": 1}, "brake": {"kind": "Sw", "locked": "t > 0.25"}},
    "bonds": [{"from": "weight", "to": "fall"}, {"from": "fall", "to": "ball"}, {"from": "fall", "to": "ground"},
              {"from": "s", "to": "j"}, {"from": "j", "to": "r"}, {"from": "f", "to": "z"}, {"from": "z", "to": "g"},
              {"from": "v", "to": "m"}, {"from": "v", "to": "brake"}],
    "outputs": {"touch": "if(mode('ground'), 1, 0)", "j": "if(mode('j'), 1, 0)", "z": "if(mode('z'), 1, 0)",
                "brake": "if(mode('brake'), 1, 0)", "e": "g.e"},
    "scenes": {"run": {"times": [0, 0.25, 0.3, 0.6], "stop": 1}}})x");
  for (const char* name : {"j", "z", "brake", "e"})
    for (std::size_t row = 0; row < 4; ++row) {
      INFO(name << row);
      CHECK(result.trace[name][row] == (row < 2 ? 0.0 : 1.0));
    }
  CHECK(result.trace["touch"][2] == 0.0);
  CHECK(result.trace["touch"][3] == 1.0);
}

TEST_CASE("modes that would depend on themselves are refused") {
  const auto says = [](const std::string& text, const std::string& with) {
    INFO(refusal(text));
    CHECK(refusal(text).find(with) != std::string::npos);
  };
  std::string law = rectifier("", R"x("i": "r.f")x");
  law.replace(law.find("e = f"), 5, "e = if(mode('d'), 1, 2)*f");
  says(law, "BG132: the law of \"r\" depends on mode('d')");
  // The same through a signal.
  std::string through = rectifier(R"x("k": "if(mode('d'), 1, 2)")x", R"x("i": "r.f")x");
  through.replace(through.find("e = f"), 5, "e = k*f");
  says(through, "BG132: the law of \"r\" depends on mode('d')");
  // A latch breaks the circle.
  std::string latch = rectifier(R"x("k": {"set": "mode('d')", "reset": "not mode('d')"})x", R"x("i": "r.f")x");
  latch.replace(latch.find("e = f"), 5, "e = if(k, 1, 2)*f");
  CHECK(refusal(latch).empty());
  CHECK(completed(latch).trace["i"][15] > 0.0);

  const auto switches = [](const std::string& a, const std::string& b) {
    return R"x({"bgsim": 1, "name": "m", "elements": {"s": {"kind": "Se", "effort": 6}, "n": {"kind": "1"}, "r": {"kind": "R", "resistance": 2},
      "a": {"kind": "Sw", )x" +
           a + R"x(}, "b": {"kind": "Sw", )x" + b + R"x(}},
      "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "r"}, {"from": "n", "to": "a"}, {"from": "n", "to": "b"}],
      "outputs": {"i": "r.f"}, "scenes": {"run": {"stop": 1}}})x";
  };
  says(switches(R"x("closed": "mode('b')")x", R"x("closed": "not mode('a')")x"),
       "BG132: the conditions of switches depend on each other's modes: a -> b -> a");
  says(switches(R"x("closed": "mode('a') or t > 1")x", R"x("closed": "t > 0")x"),
       "BG132: the conditions of switches depend on each other's modes: a -> a");
  CHECK(refusal(switches(R"x("close": "not mode('b') and t > 0.5", "open": "t > 0.7")x", R"x("closed": "mode('a')")x"))
            .empty());
  says(switches(R"x("closed": "mode('c')")x", R"x("closed": "t > 0")x"), "BG121: there is no switch");
  says(switches(R"x("closed": "mode('r')")x", R"x("closed": "t > 0")x"), "BG121: \"r\" has no mode: it is of kind R");
  says(switches(R"x("closed": "mode(r)")x", R"x("closed": "t > 0")x"), "BG121");
  says(switches(R"x("closed": "mode('b') > 0")x", R"x("closed": "t > 0")x"), "BG124");
}
