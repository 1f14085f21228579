// Ideal diodes: sides that the circuit decides.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// @param bonds  "from>to" separated by spaces.
RunResult run_diodes(const std::string& elements, const std::string& bonds, const std::string& outputs,
                     const std::string& scene, const std::string& more = "") {
  std::string list;
  std::istringstream words(bonds);
  for (std::string word; words >> word;) {
    const auto arrow = word.find('>');
    list += (list.empty() ? "" : ", ") + (R"({"from": ")" + word.substr(0, arrow)) + R"(", "to": ")" +
            word.substr(arrow + 1) + "\"}";
  }
  const Study study = Study::from_text(R"({"bgsim": 1, "name": "diodes", )" + more + R"("elements": {)" + elements +
                                       R"(}, "bonds": [)" + list + R"(], "outputs": {)" + outputs +
                                       R"(}, "scenes": {"run": {)" + scene + "}}}");
  RunResult result = study.scene().simulate(SimulateOptions{});
  INFO((result.failure ? result.failure->situation : ""));
  REQUIRE(result.stop == StopReason::completed);
  REQUIRE(result.report.energy.done);
  CHECK(result.report.energy.relative < 1e-6);  // at tolerances of 1e-6 and below
  return result;
}

const double kPi = std::acos(-1.0);

/// A rectifier of four diodes on the nodes a and b, fed through "src" and "v", into p against ground.
const std::string kBridge = R"("src": {"kind": "1"}, "a": {"kind": "0"}, "b": {"kind": "0"}, "p": {"kind": "0"},
  "s1": {"kind": "1"}, "d1": {"kind": "D"}, "s3": {"kind": "1"}, "d3": {"kind": "D"},
  "d2": {"kind": "D", "passes": "out"}, "d4": {"kind": "D", "passes": "out"}, )";
const std::string kBridgeBonds = "v>src src>a b>src a>s1 s1>d1 s1>p b>s3 s3>d3 s3>p a>d2 b>d4 ";

}  // namespace

TEST_CASE("a diode and a resistor pass half of a sine") {
  const RunResult result = run_diodes(
      R"("v": {"kind": "Se", "effort": "sin(t) "}, "d": {"kind": "D"}, "r": {"kind": "R", "resistance": 2},
         "in": {"kind": "1"})",
      "v>in in>d in>r", R"("i": "r.f", "e": "d.e", "f": "d.f")", R"("stop": 20, "samples": 41)");
  for (std::size_t k = 0; k < result.trace.times.size(); ++k) {
    const double v = std::sin(result.trace.times[k]);
    CHECK(result.trace["i"][k] == Approx(std::max(v, 0.0) / 2.0).epsilon(0).margin(1e-12));
    CHECK(result.trace["e"][k] == Approx(std::min(v, 0.0)).epsilon(0).margin(1e-12));
  }
  CHECK(result.report.mode_changes == 6);
}

TEST_CASE("a half-wave rectifier with a coil conducts until its current ends") {
  const RunResult result = run_diodes(
      R"("v": {"kind": "Se", "effort": "sin(t) "}, "d": {"kind": "D"}, "r": {"kind": "R", "resistance": 1},
         "l": {"kind": "I", "inertance": 1}, "in": {"kind": "1"})",
      "v>in in>d in>r in>l", R"("i": "l.f", "on": "on")",
      R"("stop": "2*pi", "times": ["pi/2", "pi", 3.9407331, 3.9407332, "2*pi"], "relative": 1e-11)",
      R"("signals": {"on": {"integral": "if(d.f > 0, 1, 0) "}}, )");
  CHECK(result.trace["i"][0] == Approx(0.6039397881754).epsilon(1e-9));
  CHECK(result.trace["i"][1] == Approx(0.5216069591319).epsilon(1e-9));
  CHECK(result.trace["i"][2] > 0.0);
  CHECK(result.trace["i"][3] == 0.0);
  CHECK(last(result, "on") == Approx(3.940733135693).epsilon(1e-9));
}

TEST_CASE("a freewheeling diode takes over the current of a coil") {
  const RunResult result = run_diodes(
      R"("v": {"kind": "Se", "effort": "sin(t) "}, "d": {"kind": "D"}, "free": {"kind": "D", "passes": "out"},
         "r": {"kind": "R", "resistance": 1}, "l": {"kind": "I", "inertance": 1}, "in": {"kind": "1"},
         "n": {"kind": "0"}, "out": {"kind": "1"})",
      "v>in in>d in>n n>free n>out out>r out>l", R"("i": "l.f", "u": "n.e")",
      R"("stop": 9, "samples": 19, "relative": 1e-11)");
  const double at_pi = (1.0 + std::exp(-kPi)) / 2.0, at_two = at_pi * std::exp(-kPi);
  for (std::size_t k = 0; k < result.trace.times.size(); ++k) {
    const double t = result.trace.times[k], forced = (std::sin(t) - std::cos(t)) / 2.0;
    const double i = t < kPi         ? forced + std::exp(-t) / 2.0
                     : t < 2.0 * kPi ? at_pi * std::exp(kPi - t)
                                     : forced + (at_two + 0.5) * std::exp(2.0 * kPi - t);
    CHECK(result.trace["i"][k] == Approx(i).epsilon(0).margin(1e-9));
    CHECK(result.trace["u"][k] == Approx(std::max(std::sin(t), 0.0)).epsilon(0).margin(1e-12));
  }
  CHECK(result.report.energy.switching == Approx(0.0).margin(1e-12));
}

TEST_CASE("a peak rectifier follows the source and lets go where its current ends") {
  const RunResult result = run_diodes(
      R"("v": {"kind": "Se", "effort": "sin(t) "}, "d": {"kind": "D"}, "r": {"kind": "R", "resistance": 5},
         "c": {"kind": "C", "capacitance": 1}, "in": {"kind": "1"}, "n": {"kind": "0"})",
      "v>in in>d in>n n>r n>c", R"("u": "c.e", "i": "d.f")", R"("stop": 8, "samples": 81, "relative": 1e-11)");
  const double off = kPi - std::atan(5.0);  // C cos t + sin t/R = 0
  double on = 2.0 * kPi + 0.5;              // sin t = sin(off) exp(-(t - off)/5)
  for (int k = 0; k < 100; ++k) on = 2.0 * kPi + std::asin(std::sin(off) * std::exp(-(on - off) / 5.0));
  for (std::size_t k = 0; k < result.trace.times.size(); ++k) {
    const double t = result.trace.times[k];
    const double u =
        t < off || (t > on && t < 2 * kPi + off) ? std::sin(t) : std::sin(off) * std::exp(-(t - off) / 5.0);
    CHECK(result.trace["u"][k] == Approx(u).epsilon(0).margin(1e-9));
  }
}

TEST_CASE("a bridge of diodes rectifies, whatever is before and behind it") {
  const std::string source = R"("v": {"kind": "Se", "effort": "10*sin(t) "}, )";
  const std::string rectified = R"("v": {"kind": "Se", "effort": "10*abs(sin(t)) "}, "p": {"kind": "0"}, )";
  const std::string coil =
      R"("o": {"kind": "1"}, "r": {"kind": "R", "resistance": 5}, "l": {"kind": "I", "inertance": 20})";
  const std::string outputs = R"("u": "p.e", "i": "r.f")";
  const std::string scene = R"("stop": 20, "samples": 101, "relative": 1e-10)";
  const auto same = [](const RunResult& a, const RunResult& b) {
    for (const char* const name : {"u", "i"})
      for (std::size_t k = 0; k < a.trace.times.size(); ++k)
        // Two runs at 1e-10 of numbers up to 10.
        CHECK(a.trace[name][k] == Approx(b.trace[name][k]).epsilon(0).margin(2e-8));
  };
  SECTION("a resistor") {
    const std::string load = R"("r": {"kind": "R", "resistance": 5})";
    same(run_diodes(source + kBridge + load, kBridgeBonds + "p>r", outputs, scene),
         run_diodes(rectified + load, "v>p p>r", outputs, scene));
  }
  SECTION("a resistor and a coil") {
    same(run_diodes(source + kBridge + coil, kBridgeBonds + "p>o o>r o>l", outputs, scene),
         run_diodes(rectified + coil, "v>p p>o o>r o>l", outputs, scene));
  }
  SECTION("a capacitor, and the charge that comes back through no diode") {
    const std::string load = R"("r": {"kind": "R", "resistance": 5}, "c": {"kind": "C", "capacitance": 0.4})";
    const RunResult bridge = run_diodes(source + kBridge + load, kBridgeBonds + "p>r p>c", outputs, scene);
    const RunResult half = run_diodes(rectified + load + R"(, "in": {"kind": "1"}, "d": {"kind": "D"})",
                                      "v>in in>d in>p p>r p>c", outputs, scene);
    same(bridge, half);
  }
  SECTION("a coil in front of it") {
    const std::string load = R"("r": {"kind": "R", "resistance": 5}, "c": {"kind": "C", "capacitance": 0.4},
        "ls": {"kind": "I", "inertance": 0.1})";
    const RunResult result =
        run_diodes(source + kBridge + load, kBridgeBonds + "p>r p>c src>ls", R"("u": "p.e", "i": "ls.f")",
                   R"("stop": 20, "samples": 21, "relative": 1e-10)");
    // By hand: i' = (v - sign(i) u)/L while there is a current; it begins where |v| > u.
    const int steps = 20000;
    double i = 0.0, u = 0.0;
    for (int k = 0; k < 20; ++k)
      for (int n = 0; n < steps; ++n) {
        const double h = 1.0 / steps, t = k + n * h, v = 10.0 * std::sin(t + h / 2.0);
        const double way = i != 0.0 ? std::copysign(1.0, i) : std::abs(v) > u ? std::copysign(1.0, v) : 0.0;
        const double middle_u = u + h / 2.0 * (way * i - u / 5.0) / 0.4;
        const double middle_i = way == 0.0 ? 0.0 : i + h / 2.0 * (10.0 * std::sin(t) - way * u) / 0.1;
        const double next = way == 0.0 ? 0.0 : i + h * (v - way * middle_u) / 0.1;
        u += h * (way * middle_i - middle_u / 5.0) / 0.4;
        i = way * next < 0.0 ? 0.0 : next;
        // The midpoint rule with steps of 5e-5, and as much where the current ends.
        if (n + 1 < steps) continue;
        CHECK(result.trace["u"][static_cast<std::size_t>(k) + 1] == Approx(u).epsilon(0).margin(1e-5));
        CHECK(result.trace["i"][static_cast<std::size_t>(k) + 1] == Approx(i).epsilon(0).margin(2e-4));
      }
  }
}

TEST_CASE("six diodes rectify three phases") {
  std::string elements, bonds = "p>ld ld>n ld>r ld>l ";
  for (const std::string k : {"0", "1", "2"}) {
    elements += R"("v@": {"kind": "Se", "effort": "cos(t - 2*pi*@/3) "}, "ph@": {"kind": "1"}, "a@": {"kind": "0"},
      "up@": {"kind": "1"}, "lo@": {"kind": "1"}, "du@": {"kind": "D"}, "dl@": {"kind": "D"}, )";
    bonds += "v@>ph@ ph@>a@ a@>up@ up@>du@ up@>p n>lo@ lo@>dl@ lo@>a@ ";
    for (auto at = elements.find('@'); at != std::string::npos; at = elements.find('@')) elements.replace(at, 1, k);
    for (auto at = bonds.find('@'); at != std::string::npos; at = bonds.find('@')) bonds.replace(at, 1, k);
  }
  const RunResult result = run_diodes(elements + R"("p": {"kind": "0"}, "n": {"kind": "0"}, "ld": {"kind": "1"},
          "r": {"kind": "R", "resistance": 1}, "l": {"kind": "I", "inertance": 1})",
                                      bonds, R"("u": "r.e + l.e", "mean": "mean", "i": "l.f")",
                                      R"("stop": "2*pi", "samples": 181, "relative": 1e-11)",
                                      R"("signals": {"mean": {"integral": "(r.e + l.e)/(2*pi) "}}, )");
  CHECK(last(result, "mean") == Approx(1.653986686265).epsilon(1e-9));
  for (std::size_t k = 0; k < result.trace.times.size(); ++k) {
    const double t = result.trace.times[k];
    double high = -1.0, low = 1.0;
    for (int phase = 0; phase < 3; ++phase) {
      high = std::max(high, std::cos(t - 2.0 * kPi * phase / 3.0));
      low = std::min(low, std::cos(t - 2.0 * kPi * phase / 3.0));
    }
    CHECK(result.trace["u"][k] == Approx(high - low).epsilon(0).margin(1e-9));
  }
}

TEST_CASE("six diodes commutate behind coils: each phase does what the one before did a third of a period earlier",
          "[long]") {
  // While two diodes of a side conduct, their coils depend on each other, and the series of the one that has just come
  // to 0 reach no further than its order 0. The order of elements decides which coil is the dependent one.
  std::string elements, bonds;
  for (const std::string k : {"0", "1", "2"}) {
    elements += R"("n@": {"kind": "0"}, "a@": {"kind": "0"}, "j_l@": {"kind": "1"}, "j_u@": {"kind": "1"},
      "j_d@": {"kind": "1"}, "v@": {"kind": "Se", "effort": "5.04291*sin(112.743*t + 0.1 - 2*pi*@/3) "},
      "l@": {"kind": "I", "inertance": 0.0034637228186583644}, "u@": {"kind": "D"}, "d@": {"kind": "D"}, )";
    bonds += "v@>n@ j_l@>l@ n@>j_l@ j_l@>a@ j_u@>u@ a@>j_u@ j_u@>p j_d@>d@ n>j_d@ j_d@>a@ ";
    for (auto at = elements.find('@'); at != std::string::npos; at = elements.find('@')) elements.replace(at, 1, k);
    for (auto at = bonds.find('@'); at != std::string::npos; at = bonds.find('@')) bonds.replace(at, 1, k);
  }
  for (const std::string relative : {"1e-6", "1e-9"}) {
    INFO(relative);
    const RunResult result =
        run_diodes(elements + R"("p": {"kind": "0"}, "n": {"kind": "0"}, "m": {"kind": "0"}, "j_r": {"kind": "1"},
          "j_l": {"kind": "1"}, "leak": {"kind": "R", "resistance": 1175.592}, "r": {"kind": "R", "resistance": 3.91864},
          "l": {"kind": "I", "inertance": 0.05643504768899178})",
                   bonds + "n>leak j_r>r p>j_r j_r>m j_l>l m>j_l j_l>n", R"("i": "l.f", "i0": "l0.f", "i1": "l1.f")",
                   R"("stop": "18*pi/112.743", "samples": 1081, "relative": )" + relative);
    // What the coils remember of the start falls by exp(-3.8) a period: 1e-15 are left after nine. Then each differs by
    // the errors of the runs alone.
    const double margin = 100.0 * std::stod(relative);
    const std::size_t period = 120, third = period / 3;
    double largest = 0.0;
    for (std::size_t k = result.trace.times.size() - period; k < result.trace.times.size(); ++k) {
      largest = std::max(largest, std::abs(result.trace["i0"][k]));
      CHECK(result.trace["i1"][k] == Approx(result.trace["i0"][k - third]).epsilon(0).margin(margin));
      CHECK(result.trace["i"][k] == Approx(result.trace["i"][k - third]).epsilon(0).margin(margin));
    }
    CHECK(largest > 1.0);
  }
}

TEST_CASE("a buck converter with a freewheeling diode is exact in both conduction modes", "[long]") {
  const auto run = [](const std::string& load, const std::string& scene) {
    return run_diodes(
        R"("v": {"kind": "Se", "effort": 24}, "chop": {"kind": "Sw", "closed": "t/2e-5 - floor(t/2e-5) < 0.5"},
           "node": {"kind": "0"}, "free": {"kind": "D", "passes": "out"}, "loop": {"kind": "1"}, "in": {"kind": "1"},
           "out": {"kind": "0"}, "coil": {"kind": "I", "inertance": 1e-4}, "cap": {"kind": "C", "capacitance": 1e-4},
           "load": {"kind": "R", "resistance": )" +
            load + "}",
        "v>in in>chop in>node node>free node>loop loop>coil loop>out out>cap out>load",
        R"("i": "coil.f", "u": "cap.e")", scene);
  };
  const RunResult start = run("5", R"("stop": 6e-5, "samples": 4, "relative": 1e-11)");
  const std::vector<double> i{0.0, 2.37235864437, 4.6293084202, 6.6871728941};
  const std::vector<double> u{0.0, 0.352986119849, 1.14729326903, 2.33457545};
  for (std::size_t k = 0; k < i.size(); ++k) {
    CHECK(start.trace["i"][k] == Approx(i[k]).epsilon(0).margin(1e-9));
    CHECK(start.trace["u"][k] == Approx(u[k]).epsilon(0).margin(5e-9));  // the last value has nine digits
  }
  CHECK(start.report.energy.switching == Approx(0.0).margin(1e-12));
  const RunResult steady = run("5", R"("stop": 0.04, "times": [0.04])");
  CHECK(steady.trace["i"].back() == Approx(1.799499519554).epsilon(0).margin(7e-6));
  CHECK(steady.trace["u"].back() == Approx(11.99989980371).epsilon(0).margin(1e-5));
  // With little load the current ends within each period: three modes.
  const RunResult light = run("500", R"("stop": 0.002, "samples": 3)");
  CHECK(light.report.modes == 3);
  CHECK(last(light, "i") == 0.0);
}

TEST_CASE("a thyristor waits for its fire, and goes out by itself") {
  const RunResult result = run_diodes(
      R"("v": {"kind": "Se", "effort": "sin(t) "}, "d": {"kind": "D", "fire": "mod(t, 2*pi) >= 1 and mod(t, 2*pi) < 1.2"},
         "r": {"kind": "R", "resistance": 1}, "l": {"kind": "I", "inertance": 1}, "in": {"kind": "1"})",
      "v>in in>d in>r in>l", R"("i": "l.f", "e": "d.e")",
      R"("stop": 7.2, "times": [0.5, 1.5, 3, 5, 6.5, 7.2], "relative": 1e-11)");
  const auto current = [](double t) {
    return (std::sin(t) - std::cos(t)) / 2.0 - (std::sin(1.0) - std::cos(1.0)) / 2.0 * std::exp(1.0 - t);
  };
  CHECK(result.trace["i"][0] == 0.0);
  CHECK(result.trace["e"][0] == Approx(std::sin(0.5)).epsilon(1e-12));
  CHECK(result.trace["i"][1] == Approx(current(1.5)).epsilon(1e-9));
  CHECK(result.trace["i"][2] == Approx(current(3.0)).epsilon(1e-9));
  CHECK(result.trace["i"][3] == 0.0);
  CHECK(result.trace["e"][4] == Approx(std::sin(6.5)).epsilon(1e-12));
  CHECK(result.trace["i"][4] == 0.0);
}

TEST_CASE("a diode between two capacitors lets them share their charge one way only") {
  for (const bool forward : {true, false}) {
    const RunResult result =
        run_diodes(std::string(R"("a": {"kind": "C", "capacitance": 1, "initial": {"q": )") + (forward ? "3" : "-3") +
                       R"(}}, "b": {"kind": "C", "capacitance": 2}, "s": {"kind": "1"}, "d": {"kind": "D"})",
                   "a>s s>d s>b", R"("a": "a.e", "b": "b.e")", R"("stop": 1, "samples": 3)");
    CHECK(last(result, "a") == Approx(forward ? 1.0 : -3.0).epsilon(1e-12));
    CHECK(last(result, "b") == Approx(forward ? 1.0 : 0.0).margin(1e-12));
    CHECK(result.report.energy.switching == Approx(forward ? 3.0 : 0.0).margin(1e-12));
  }
}

TEST_CASE("a threshold is the effort of a diode that conducts, and its loss is dissipated") {
  const RunResult result = run_diodes(
      R"("v": {"kind": "Se", "effort": "2*sin(t) "}, "d": {"kind": "D", "passes": "out", "threshold": 0.7},
         "r": {"kind": "R", "resistance": 2}, "in": {"kind": "1"})",
      "v>in in>d in>r", R"("i": "r.f", "e": "d.e", "f": "d.f")", R"("stop": "2*pi", "samples": 41, "relative": 1e-9)");
  for (std::size_t k = 0; k < result.trace.times.size(); ++k)
    CHECK(result.trace["i"][k] ==
          Approx(std::min(0.0, 2.0 * std::sin(result.trace.times[k]) + 0.7) / 2.0).epsilon(0).margin(1e-12));
  CHECK(result.report.energy.dissipated == Approx(result.report.energy.supplied).epsilon(1e-9));
}

TEST_CASE("of diodes side by side that of the lowest threshold conducts, as if it were alone") {
  // Behind a resistor and beside a coil, into a store: their own circuit has no resistance.
  const auto circuit_of = [](const std::string& source, const std::vector<std::string>& diodes) {
    std::string elements, bonds;
    for (std::size_t i = 0; i < diodes.size(); ++i) {
      const std::string d = "d" + std::to_string(i), j = "j" + std::to_string(i);
      elements += ", \"" + d + R"(": {"kind": "D")" + diodes[i] + "}, \"" + j + R"(": {"kind": "1"})";
      bonds += R"(, {"from": "a", "to": ")" + j + R"("}, {"from": ")" + j + R"(", "to": ")" + d + R"("}, {"from": ")" +
               j + R"(", "to": "b"})";
    }
    return R"x({"bgsim": 1, "name": "sides", "elements": {"s": {"kind": "MSe", "effort": ")x" + source +
           R"x("}, "j": {"kind": "1"}, "r": {"kind": "R", "resistance": 1}, "a": {"kind": "0"}, "b": {"kind": "0"},
        "l": {"kind": "I", "inertance": 0.05}, "c": {"kind": "C", "capacitance": 0.001}, "out": {"kind": "R", "resistance": 50})x" +
           elements + R"x(}, "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "r"}, {"from": "j", "to": "a"},
        {"from": "a", "to": "l"}, {"from": "b", "to": "c"}, {"from": "b", "to": "out"})x" +
           bonds + R"x(], "outputs": {"u": "c.e", "i": "l.f"}, "scenes": {"s": {"stop": 0.04, "samples": 201}}})x";
  };
  const std::string low = R"(, "threshold": 0.01)", high = R"(, "threshold": 0.3)", far = R"(, "threshold": 30)";
  const std::pair<std::string, std::vector<std::vector<std::string>>> cases[] = {
      {"", {{"", high}, {high, ""}, {"", far}, {"", low, high}, {high, low, ""}, {"", ""}}},
      {low, {{low, high}, {high, low}, {low, low, far}}}};
  for (const std::string source : {"30*sin(314.15926535*t)", "24.3", "30*cos(500*t)"})
    for (const auto& [alone, together] : cases) {
      const RunResult one = Study::from_text(circuit_of(source, {alone})).scene().simulate(SimulateOptions{});
      REQUIRE(one.stop == StopReason::completed);
      for (const auto& diodes : together) {
        CAPTURE(source, diodes);
        const RunResult run = Study::from_text(circuit_of(source, diodes)).scene().simulate(SimulateOptions{});
        REQUIRE(run.stop == StopReason::completed);
        for (std::size_t k = 0; k < run.trace.times.size(); ++k) {  // ten tolerances of a range of 30
          CHECK(std::abs(run.trace["u"][k] - one.trace["u"][k]) < 3e-4);
          CHECK(std::abs(run.trace["i"][k] - one.trace["i"][k]) < 3e-4);
        }
      }
    }
}

TEST_CASE("a bridge at rest, whose source begins at 0, finds the diodes of its coil's current") {
  // The current begins with the square of the time: which diodes carry it shows in the last coefficient that is known.
  // Source resistance, load resistance, coil over its time constant; some of them ended with BG605.
  for (const auto& [rs, r, l] : {std::tuple{2.0878991048307989e-4, 1.8378898479403504e-3, 4.9192e-3},
                                 std::tuple{1e-3, 0.2, 3.0}, std::tuple{0.4, 4.0, 0.2}, std::tuple{0.01, 1.0, 10.0}}) {
    INFO(rs << ", " << r << ", " << l);
    const RunResult result = run_diodes(
        kBridge + R"("v": {"kind": "Se", "effort": "sin(t) "}, "rs": {"kind": "R", "resistance": )" +
            shortest_number(rs) + R"(}, "m": {"kind": "1"}, "r": {"kind": "R", "resistance": )" + shortest_number(r) +
            R"(}, "l": {"kind": "I", "inertance": )" + shortest_number(l) + "}",
        kBridgeBonds + "src>rs p>m m>r m>l", R"("i": "l.f")", R"("stop": 1.5, "samples": 4, "relative": 1e-10)");
    const double sum = rs + r, z = sum * sum + l * l;
    for (std::size_t k = 0; k < 4; ++k) {
      const double t = result.trace.times[k];
      CHECK(result.trace["i"][k] ==
            Approx((sum * std::sin(t) - l * std::cos(t) + l * std::exp(-sum / l * t)) / z).epsilon(1e-8).margin(1e-12));
    }
  }
}

TEST_CASE("a diode over a coil between capacitors goes on carrying its current when a source charges both") {
  // A second derivative that cancels, and is rounding, made its resistance 2.7e17 times too large, and its border as
  // wide as 66043: it let go of the current, and blocked with a forward voltage of 1.4.
  const RunResult result = run_diodes(
      R"("n1": {"kind": "0"}, "n2": {"kind": "0"}, "n3": {"kind": "0"}, "j0": {"kind": "1"},
         "v0": {"kind": "Se", "effort": 3.874}, "rs": {"kind": "R", "resistance": 1.452}, "j1": {"kind": "1"},
         "d1": {"kind": "D"}, "j2": {"kind": "1"}, "l2": {"kind": "I", "inertance": 0.765}, "j3": {"kind": "1"},
         "s3": {"kind": "Sw", "closed": "t > 0.1 and t < 1.14"}, "j4": {"kind": "1"},
         "c4": {"kind": "C", "capacitance": 0.542}, "j5": {"kind": "1"},
         "c5": {"kind": "C", "capacitance": 0.156, "initial": {"e": 0.997}}, "j6": {"kind": "1"},
         "s7": {"kind": "Sw", "closed": "t > 100"}, "j7": {"kind": "1"}, "d8": {"kind": "D"}, "j8": {"kind": "1"},
         "d9": {"kind": "D"})",
      "v0>j0 j0>n1 j0>rs n1>j1 j1>n2 j1>d1 n2>j2 j2>n3 j2>l2 n1>j3 j3>s3 n2>j4 j4>c4 n3>j5 j5>c5 j6>n2 j6>s7 n2>j7 "
      "j7>n3 j7>d8 j8>n2 j8>d9",
      R"("u4": "c4.e", "u5": "c5.e", "coil": "l2.f", "v8": "d8.e")",
      R"("stop": 2, "times": [1.1, 1.2, 1.4, 1.7, 2], "relative": 1e-9)");
  const double u0 = result.trace["u4"][0];
  for (std::size_t k = 0; k < 5; ++k) {
    const double since = std::max(0.0, result.trace.times[k] - 1.14);
    const double u = 3.874 + (u0 - 3.874) * std::exp(-since / (1.452 * (0.542 + 0.156)));
    CAPTURE(since);
    // A hundred tolerances.
    CHECK(std::abs(result.trace["u4"][k] - u) < 1e-7);
    CHECK(std::abs(result.trace["u5"][k] - u) < 1e-7);
    CHECK(std::abs(result.trace["coil"][k] - result.trace["coil"][0]) < 1e-7);
    CHECK(std::abs(result.trace["v8"][k]) < 1e-7);
  }
}

TEST_CASE("two paths of two diodes each, side by side, conduct as one when the switch between their middles opens") {
  // All four were found to conduct, which the graph does not allow (BG619).
  const RunResult result = run_diodes(
      R"x("n1": {"kind": "0"}, "n2": {"kind": "0"}, "n3": {"kind": "0"}, "n4": {"kind": "0"}, "n5": {"kind": "0"},
         "j0": {"kind": "1"}, "v0": {"kind": "Se", "effort": 3.106}, "rs": {"kind": "R", "resistance": 1.771},
         "j1": {"kind": "1"}, "r1": {"kind": "R", "resistance": 1.763}, "j2": {"kind": "1"}, "d2": {"kind": "D"},
         "j3": {"kind": "1"}, "l3": {"kind": "I", "inertance": 0.193, "initial": {"f": -0.795}}, "j4": {"kind": "1"},
         "r4": {"kind": "R", "resistance": 0.79}, "j5": {"kind": "1"},
         "s5": {"kind": "Sw", "closed": "mod(t - 1.103691, 1.139) < 0.768825"}, "j6": {"kind": "1"},
         "r6": {"kind": "R", "resistance": 1.358}, "l7": {"kind": "I", "inertance": 0.249}, "j7": {"kind": "1"},
         "d8": {"kind": "D"}, "j8": {"kind": "1"}, "d9": {"kind": "D"}, "j9": {"kind": "1"}, "d10": {"kind": "D"},
         "j10": {"kind": "1"}, "s12": {"kind": "Sw", "closed": "mod(t - 0.477868, 0.772) < 0.2316"},
         "j11": {"kind": "1"}, "d13": {"kind": "D"}, "j12": {"kind": "1"}, "d15": {"kind": "D"})x",
      "v0>j0 j0>n1 j0>rs n1>j1 j1>n2 j1>r1 n1>j2 j2>n3 j2>d2 n3>j3 j3>n4 j3>l3 n3>j4 j4>n5 j4>r4 n1>j5 j5>s5 n2>j6 "
      "j6>r6 j6>l7 n3>j7 j7>d8 n4>j8 j8>d9 n5>j9 j9>d10 n2>j10 j10>n3 j10>s12 n1>j11 j11>n2 j11>d13 n2>j12 j12>d15",
      R"("i": "rs.f", "v": "s5.e", "down": "d8.f + d15.f + d9.f + d10.f + r6.f + s5.f")",
      R"("stop": 4.392, "samples": 101, "relative": 1e-9)");
  for (std::size_t k = 0; k < result.trace.times.size(); ++k) {
    CAPTURE(result.trace.times[k]);
    // Nothing stands between n1 and the reference but diodes and a switch, one path of which always conducts.
    CHECK(std::abs(result.trace["v"][k]) < 1e-9);
    CHECK(std::abs(result.trace["i"][k] - 3.106 / 1.771) < 1e-9);
    CHECK(std::abs(result.trace["down"][k] - result.trace["i"][k]) < 1e-9);
  }
}

TEST_CASE("a program with diodes is not run without what finds their sides") {
  const CompiledModel compiled = compile_file("models/half_wave.json");
  CHECK_THROWS_AS(compiled.run(), std::invalid_argument);
}
