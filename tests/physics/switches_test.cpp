// Ideal switches: runs that go from mode to mode, and stores that jump where switches tie them together.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

RunResult run_switched(const std::string& elements, const std::string& bonds, const std::string& outputs,
                       const std::string& scene, const std::string& more = "", const SimulateOptions& options = {}) {
  const Study study = Study::from_text(R"({"bgsim": 1, "name": "switched", )" + more + R"("elements": {)" + elements +
                                       R"(}, "bonds": [)" + bonds + R"(], "outputs": {)" + outputs +
                                       R"(}, "scenes": {"run": {)" + scene + "}}}");
  return study.scene().simulate(options);
}

void check_completed(const RunResult& result) {
  INFO((result.failure ? result.failure->situation : ""));
  CHECK(result.stop == StopReason::completed);
}

/// What the audit's terms leave, relative to what was turned over: a jump's terms close by construction, the rest is
/// the error of the stretches, at tolerances of 1e-9 and below.
void check_balance(const RunResult& result, double bound = 1e-7) {
  REQUIRE(result.report.energy.done);
  CHECK(result.report.energy.relative < bound);
}

const std::string kPair = R"("a": {"kind": "C", @1, "initial": {"q": 3}}, "b": {"kind": "C", @2},
  "link": {"kind": "Sw", "closed": "@3"}, "series": {"kind": "1"})";
const std::string kPairBonds =
    R"({"from": "a", "to": "series"}, {"from": "series", "to": "link"}, {"from": "series", "to": "b"})";

std::string filled(std::string text, const std::vector<std::string>& parts) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string mark = "@" + std::to_string(i + 1);
    for (auto at = text.find(mark); at != std::string::npos; at = text.find(mark)) text.replace(at, 2, parts[i]);
  }
  return text;
}

// Jumps with linear stores are one linear solve: rounding alone, with a good margin.
constexpr double kRounding = 1e-12;

}  // namespace

TEST_CASE("a junction that is off has no effort or no flow, as with a switch at it") {
  const std::string more = R"("signals": {"go": "t > 1", "hold": "t < 2"}, )", scene = R"("stop": 4, "samples": 17)";
  const std::string rest = R"("s": {"kind": "Se", "effort": 3}, "r": {"kind": "R", "resistance": 1}, "j": {"kind": "0"},
      "c": {"kind": "C", "capacitance": 1}, "m": {"kind": "1"}, "r2": {"kind": "R", "resistance": 0.5},
      "l": {"kind": "R", "resistance": 4}, "c2": {"kind": "C", "capacitance": 0.25}, )";
  const std::string bonds = R"({"from": "s", "to": "n"}, {"from": "n", "to": "r"}, {"from": "n", "to": "j"},
      {"from": "j", "to": "c"}, {"from": "j", "to": "m"}, {"from": "m", "to": "r2"}, {"from": "m", "to": "z"},
      {"from": "z", "to": "l"}, {"from": "z", "to": "c2"})";
  const std::string outputs = R"("v": "c.e", "z": "z.e", "i": "n.f", "through": "n_on.f")";
  const RunResult off = run_switched(rest + R"("n": {"kind": "1", "on": "go"}, "z": {"kind": "0", "on": "hold"})",
                                     bonds, outputs, scene, more);
  const RunResult with =
      run_switched(rest + R"("n": {"kind": "1"}, "z": {"kind": "0"}, "n_on": {"kind": "Sw", "closed": "go"},
      "z_on": {"kind": "Sw", "closed": "not hold"})",
                   bonds + R"(, {"from": "n", "to": "n_on"}, {"from": "z", "to": "z_on"})", outputs, scene, more);
  check_completed(off);
  for (const std::string name : {"v", "z", "i", "through"}) CHECK(column(off, name) == column(with, name));
  CHECK(at(off, "i", 0.5) == 0.0);
  CHECK(at(off, "z", 1.5) > 0.1);
  CHECK(at(off, "z", 3.0) == 0.0);
  // From t = 2 on c is charged through r and discharged through r2 to nothing.
  const double rise = 1.0 + (at(off, "v", 2.0) - 1.0) * std::exp(-3.0 * 2.0);
  CHECK(at(off, "v", 4.0) == Approx(rise).epsilon(1e-6));  // the default tolerance
}

TEST_CASE("two capacitors that a switch connects share their charge") {
  for (const std::string when : {"t >= 1", "t >= 0", "a.e > 2", "not (t < 0.5 or a.e < 0.5)"}) {
    INFO(when);
    const RunResult result = run_switched(filled(kPair, {"\"capacitance\": 1", "\"capacitance\": 2", when}), kPairBonds,
                                          R"("va": "a.e", "vb": "b.e", "moved": "moved")", R"("stop": 2, "samples": 3)",
                                          R"("signals": {"moved": {"integral": "b.f"}}, )");
    check_completed(result);
    CHECK(last(result, "va") == Approx(1.0).epsilon(kRounding));
    CHECK(last(result, "vb") == Approx(1.0).epsilon(kRounding));
    CHECK(last(result, "moved") == Approx(2.0).epsilon(kRounding));
    CHECK(result.report.energy.switching == Approx(3.0).epsilon(kRounding));
    CHECK(result.report.energy.stored == Approx(-3.0).epsilon(kRounding));
    check_balance(result, 1e-12);
    // At the start the switch is on its side before anything is recorded; with a.e > 2 the jump itself opens it again.
    CHECK(result.report.mode_changes == (when == "t >= 0" ? 0U : 1U));
  }
}

TEST_CASE("an output at the time of a switch shows what comes after it") {
  const RunResult result =
      run_switched(filled(kPair, {"\"capacitance\": 1", "\"capacitance\": 2", "t >= 1"}), kPairBonds,
                   R"("va": "a.e", "vb": "b.e")", R"("stop": 2, "times": [0, 0.999999, 1, 2])");
  check_completed(result);
  REQUIRE(result.trace.times == std::vector<double>{0.0, 0.999999, 1.0, 2.0});
  CHECK(result.trace["va"][1] == 3.0);
  CHECK(result.trace["va"][2] == Approx(1.0).epsilon(kRounding));
  CHECK(result.trace["vb"][1] == 0.0);
}

TEST_CASE("a switch that connects a transformer or a gyrator ties what it transforms") {
  for (const double n : {0.5, 2.0, -3.0}) {
    INFO(n);
    const RunResult result = run_switched(
        R"("a": {"kind": "C", "capacitance": 1, "initial": {"q": 3}}, "b": {"kind": "C", "capacitance": 2},
           "link": {"kind": "Sw", "closed": "t >= 1"}, "series": {"kind": "1"}, "tf": {"kind": "TF", "modulus": )" +
            number_text(n) + "}",
        R"({"from": "a", "to": "series"}, {"from": "series", "to": "link"}, {"from": "series", "to": "tf"},
           {"from": "tf", "to": "b"})",
        R"("va": "a.e", "vb": "b.e")", R"("stop": 2, "samples": 3)");
    check_completed(result);
    // (3 - x)/1 = n (n x)/2 with x the charge that leaves a.
    const double x = 3.0 / (1.0 + n * n / 2.0), va = 3.0 - x, vb = n * x / 2.0;
    CHECK(last(result, "va") == Approx(va).epsilon(kRounding));
    CHECK(last(result, "vb") == Approx(vb).epsilon(kRounding));
    CHECK(result.report.energy.switching == Approx(4.5 - va * va / 2 - vb * vb).epsilon(1e-11));
  }
  const RunResult result = run_switched(
      R"("a": {"kind": "C", "capacitance": 1, "initial": {"q": 3}}, "b": {"kind": "I", "inertance": 2},
         "link": {"kind": "Sw", "closed": "t >= 1"}, "series": {"kind": "1"}, "gy": {"kind": "GY", "modulus": 4})",
      R"({"from": "a", "to": "series"}, {"from": "series", "to": "link"}, {"from": "series", "to": "gy"},
         {"from": "gy", "to": "b"})",
      R"("va": "a.e", "fb": "b.f")", R"("stop": 2, "samples": 3)");
  check_completed(result);
  // 3 - x = 4 (4 x)/2.
  CHECK(last(result, "va") == Approx(3.0 - 3.0 / 9.0).epsilon(kRounding));
  CHECK(last(result, "fb") == Approx(4.0 * 3.0 / 9.0 / 2.0).epsilon(kRounding));
}

TEST_CASE("nonlinear capacitors share their charge, and lose the difference of their energies") {
  const RunResult result = run_switched(filled(kPair, {"\"law\": \"e = q^3\"", "\"capacitance\": 2", "t >= 1"}),
                                        kPairBonds, R"("qa": "a.q", "qb": "b.q")", R"("stop": 2, "samples": 3)");
  check_completed(result);
  double q = 1.0;  // q^3 = (3 - q)/2
  for (int i = 0; i < 60; ++i) q -= (q * q * q - (3.0 - q) / 2.0) / (3.0 * q * q + 0.5);
  CHECK(last(result, "qa") == Approx(q).epsilon(1e-10));
  CHECK(last(result, "qb") == Approx(3.0 - q).epsilon(1e-10));
  CHECK(result.report.energy.switching ==
        Approx(81.0 / 4.0 - std::pow(q, 4) / 4.0 - (3.0 - q) * (3.0 - q) / 4.0).epsilon(1e-9));
}

TEST_CASE("a clutch that locks leaves the angular momentum as it is") {
  const RunResult result = run_switched(
      R"("a": {"kind": "I", "inertance": 1, "initial": {"f": 100}}, "b": {"kind": "I", "inertance": 0.5},
         "clutch": {"kind": "Sw", "locked": "t >= 1 and t < 2"}, "drive": {"kind": "1"}, "node": {"kind": "0"},
         "load": {"kind": "1"}, "torque": {"kind": "Se", "effort": "step(t - 2) + 0"})",
      R"({"from": "drive", "to": "a"}, {"from": "drive", "to": "node"}, {"from": "node", "to": "clutch"},
         {"from": "node", "to": "load"}, {"from": "load", "to": "b"}, {"from": "torque", "to": "drive"})",
      R"("wa": "a.f", "wb": "b.f")", R"("stop": 3, "times": [0.5, 1.5, 3], "relative": 1e-10)");
  check_completed(result);
  CHECK(result.trace["wa"][0] == Approx(100.0).epsilon(kRounding));
  CHECK(result.trace["wb"][0] == 0.0);
  CHECK(result.trace["wa"][1] == Approx(200.0 / 3.0).epsilon(kRounding));
  CHECK(result.trace["wb"][1] == Approx(200.0 / 3.0).epsilon(kRounding));
  CHECK(result.report.energy.switching == Approx(5000.0 / 3.0).epsilon(kRounding));
  // Free again, the torque accelerates the drive alone: by 1 in a second.
  CHECK(last(result, "wa") == Approx(200.0 / 3.0 + 1.0).epsilon(1e-9));
  CHECK(last(result, "wb") == Approx(200.0 / 3.0).epsilon(1e-9));
  CHECK(result.report.modes == 2);
  for (const std::string& note : result.report.notes) CHECK(note.find("at once") == std::string::npos);
}

TEST_CASE("an RL chopper of two switches is exact at every output") {
  const std::string elements = R"("v": {"kind": "Se", "effort": 1},
      "high": {"kind": "Sw", "closed": "t - floor(t) < 0.5"}, "low": {"kind": "Sw", "closed": "t - floor(t) >= 0.5"},
      "in": {"kind": "1"}, "n": {"kind": "0"}, "l": {"kind": "I", "inertance": 1}, "r": {"kind": "R", "resistance": 1},
      "loop": {"kind": "1"})";
  const std::string bonds = R"({"from": "v", "to": "in"}, {"from": "in", "to": "high"}, {"from": "in", "to": "n"},
      {"from": "n", "to": "low"}, {"from": "n", "to": "loop"}, {"from": "loop", "to": "l"}, {"from": "loop", "to": "r"})";
  const RunResult result =
      run_switched(elements, bonds, R"("i": "l.f", "u": "n.e")", R"("stop": 2, "samples": 5, "relative": 1e-11)");
  check_completed(result);
  const std::vector<double> exact{0.0, 0.3934693402874, 0.2386512185412, 0.5382186213104, 0.326446095453};
  // A relative tolerance of 1e-11 in each of a few hundred steps.
  for (std::size_t i = 0; i < exact.size(); ++i)
    CHECK(result.trace["i"][i] == Approx(exact[i]).epsilon(0).margin(1e-9));
  CHECK(result.trace["u"][0] == 1.0);
  CHECK(result.trace["u"][1] == 0.0);
  CHECK(result.trace["u"][2] == 1.0);
  CHECK(result.report.energy.switching == 0.0);
  check_balance(result);
  const RunResult steady =
      run_switched(elements, bonds, R"("i": "l.f")", R"("stop": 40.5, "times": [40, 40.5], "relative": 1e-11)");
  check_completed(steady);
  CHECK(steady.trace["i"][0] == Approx(0.3775406687981).epsilon(0).margin(1e-9));
  CHECK(steady.trace["i"][1] == Approx(0.6224593312019).epsilon(0).margin(1e-9));
  CHECK(steady.report.modes == 2);
  CHECK(steady.report.mode_changes == 81);
}

TEST_CASE("a buck converter is as exact as its tolerance by the default method, after thousands of changes, too",
          "[long]") {
  const std::string elements = R"("v": {"kind": "Se", "effort": 24}, "in": {"kind": "1"}, "n": {"kind": "0"},
      "high": {"kind": "Sw", "closed": "t/2e-5 - floor(t/2e-5) < 0.5"}, "low": {"kind": "Sw", "closed": "t/2e-5 - floor(t/2e-5) >= 0.5"},
      "loop": {"kind": "1"}, "l": {"kind": "I", "inertance": 1e-4}, "out": {"kind": "0"},
      "c": {"kind": "C", "capacitance": 1e-4}, "r": {"kind": "R", "resistance": 5})";
  const std::string bonds = R"({"from": "v", "to": "in"}, {"from": "in", "to": "high"}, {"from": "in", "to": "n"},
      {"from": "n", "to": "low"}, {"from": "n", "to": "loop"}, {"from": "loop", "to": "l"}, {"from": "loop", "to": "out"},
      {"from": "out", "to": "c"}, {"from": "out", "to": "r"})";
  const auto run = [&](const char* scene) {
    RunResult result = run_switched(elements, bonds, R"("i": "l.f", "u": "c.e")", scene);
    check_completed(result);
    CHECK(result.report.method == "Radau IIA of order 5, dense");
    return result;
  };
  // By matrix exponentials: the first periods from rest, and the periodic solution, which is reached to 1e-17 in 0.04
  // s.
  const RunResult start = run(R"("stop": 6e-5, "samples": 4)");
  const std::vector<double> i{0.0, 2.37235864437, 4.6293084202, 6.6871728941};
  const std::vector<double> u{0.0, 0.352986119849, 1.14729326903, 2.33457545};
  // The tolerance, 1e-6, of what they come to; the last value has nine digits.
  for (std::size_t k = 0; k < i.size(); ++k) {
    CHECK(std::abs(start.trace["i"][k] - i[k]) < 7e-6);
    CHECK(std::abs(start.trace["u"][k] - u[k]) < 3e-6);
  }
  const RunResult steady = run(R"("stop": 0.04, "times": [0.04])");
  CHECK(steady.report.mode_changes > 3990);
  CHECK(std::abs(steady.trace["i"].back() - 1.799499519554) < 7e-6);
  CHECK(std::abs(steady.trace["u"].back() - 11.99989980371) < 1e-5);
}

TEST_CASE("a coil whose current is cut off loses its energy, and the report says so") {
  const RunResult result = run_switched(
      R"("v": {"kind": "Se", "effort": 1}, "s": {"kind": "Sw", "closed": "t < 1"}, "in": {"kind": "1"},
         "l": {"kind": "I", "inertance": 1}, "r": {"kind": "R", "resistance": 1})",
      R"({"from": "v", "to": "in"}, {"from": "in", "to": "s"}, {"from": "in", "to": "l"}, {"from": "in", "to": "r"})",
      R"("i": "l.f")", R"("stop": 2, "times": [0.5, 1, 2], "relative": 1e-11)");
  check_completed(result);
  const double i = 1.0 - std::exp(-1.0);
  CHECK(result.trace["i"][1] == 0.0);
  CHECK(result.report.energy.switching == Approx(i * i / 2.0).epsilon(1e-9));
  check_balance(result);
  REQUIRE(!result.report.notes.empty());
  CHECK(result.report.notes.front().find("l.p goes from") != std::string::npos);
}

TEST_CASE("a capacitor that a switch puts across a source takes twice what it keeps") {
  const RunResult result = run_switched(
      R"("v": {"kind": "Se", "effort": 5}, "s": {"kind": "Sw", "closed": "t >= 1"}, "in": {"kind": "1"},
         "c": {"kind": "C", "capacitance": 2})",
      R"({"from": "v", "to": "in"}, {"from": "in", "to": "s"}, {"from": "in", "to": "c"})", R"("u": "c.e")",
      R"("stop": 2, "times": [0.5, 1, 2])");
  check_completed(result);
  CHECK(result.trace["u"][0] == 0.0);
  CHECK(result.trace["u"][1] == Approx(5.0).epsilon(kRounding));
  CHECK(result.report.energy.supplied == Approx(50.0).epsilon(kRounding));
  CHECK(result.report.energy.stored == Approx(25.0).epsilon(kRounding));
  CHECK(result.report.energy.switching == Approx(25.0).epsilon(kRounding));
}

TEST_CASE("a switch with hysteresis makes a relaxation oscillator") {
  // Through 1 ohm from 10 V; above 5 V the switch shorts the capacitor, and it begins again at 0: every ln 2.
  const std::string dump = R"("v": {"kind": "Se", "effort": 10}, "r": {"kind": "R", "resistance": 1},
      "c": {"kind": "C", "capacitance": 1}, "s": {"kind": "Sw", "close": "c.e > 5", "open": "c.e < 1"},
      "in": {"kind": "1"}, "n": {"kind": "0"})";
  const std::string bonds = R"({"from": "v", "to": "in"}, {"from": "in", "to": "r"}, {"from": "in", "to": "n"},
      {"from": "n", "to": "c"}, {"from": "n", "to": "s"})";
  const RunResult result = run_switched(dump, bonds, R"("u": "c.e")", R"("stop": 3, "samples": 13, "relative": 1e-10)");
  check_completed(result);
  for (std::size_t i = 0; i < result.trace.times.size(); ++i)
    CHECK(result.trace["u"][i] ==
          Approx(10.0 * (1.0 - std::exp(-std::fmod(result.trace.times[i], std::log(2.0))))).epsilon(0).margin(1e-7));
  CHECK(result.report.energy.switching == Approx(4 * 12.5).epsilon(1e-8));
  check_balance(result);

  // The same with 0.1 ohm in the switch: from 5 V down to 1 V towards 10/11 V with a time constant of 1/11 s.
  const RunResult slow = run_switched(
      dump + R"(, "m": {"kind": "1"}, "rs": {"kind": "R", "resistance": 0.1})",
      R"({"from": "v", "to": "in"}, {"from": "in", "to": "r"}, {"from": "in", "to": "n"}, {"from": "n", "to": "c"},
         {"from": "n", "to": "m"}, {"from": "m", "to": "s"}, {"from": "m", "to": "rs"})",
      R"("u": "c.e")", R"("stop": 2, "times": [0.7, 2], "relative": 1e-10)");
  check_completed(slow);
  const double rest = 10.0 / 11.0, up = std::log(2.0), down = std::log((5.0 - rest) / (1.0 - rest)) / 11.0;
  CHECK(slow.trace["u"][0] == Approx(rest + (5.0 - rest) * std::exp(-11.0 * (0.7 - up))).epsilon(1e-7));
  const double again = std::log(9.0 / 5.0);
  double t = 2.0 - up;
  double u = 0.0;
  while (true) {
    if (t < down) {
      u = rest + (5.0 - rest) * std::exp(-11.0 * t);
      break;
    }
    t -= down;
    if (t < again) {
      u = 10.0 - 9.0 * std::exp(-t);
      break;
    }
    t -= again;
  }
  CHECK(slow.trace["u"][1] == Approx(u).epsilon(1e-6));
}

TEST_CASE("the initial side of a switch with hysteresis is what it stays on") {
  for (const bool closed : {true, false}) {
    const RunResult result = run_switched(
        std::string(R"("v": {"kind": "Se", "effort": 10}, "r": {"kind": "R", "resistance": 1}, "s": {"kind": "Sw",
            "close": "t > 5", "open": "t > 6", "initial": ")") +
            (closed ? "closed" : "open") + R"("},
            "in": {"kind": "1"}, "lamp": {"kind": "R", "resistance": 1})",
        R"({"from": "v", "to": "in"}, {"from": "in", "to": "r"}, {"from": "in", "to": "s"}, {"from": "in", "to": "lamp"})",
        R"("u": "lamp.e")", R"("stop": 7, "times": [4, 5.5, 6.5])");
    check_completed(result);
    CHECK(result.trace["u"][0] == (closed ? 5.0 : 0.0));
    CHECK(result.trace["u"][1] == 5.0);
  }
}

TEST_CASE("a switch with hysteresis begins on the side that its conditions give it, and nothing is lost for it") {
  // A coil with 1 A on a resistor, as the capacitor's voltage, 0.5 exp(-t/2), says; a capacitor with 1 V likewise.
  const RunResult coil = run_switched(
      R"("l": {"kind": "I", "inertance": 1, "initial": {"f": 1}}, "r": {"kind": "R", "resistance": 1},
         "s": {"kind": "Sw", "close": "c.e < 1", "open": "c.e > 2"}, "j": {"kind": "1"}, "n": {"kind": "0"},
         "c": {"kind": "C", "capacitance": 1, "initial": {"e": 0.5}}, "leak": {"kind": "R", "resistance": 2})",
      R"({"from": "j", "to": "l"}, {"from": "j", "to": "r"}, {"from": "j", "to": "s"}, {"from": "n", "to": "c"},
         {"from": "n", "to": "leak"})",
      R"("i": "l.f")", R"("stop": 2, "samples": 3, "relative": 1e-9)");
  check_completed(coil);
  const RunResult capacitor = run_switched(
      R"("c": {"kind": "C", "capacitance": 1, "initial": {"e": 1}}, "r": {"kind": "R", "resistance": 2}, "n": {"kind": "0"},
         "s": {"kind": "Sw", "close": "c.e > 5", "open": "t >= 0", "initial": "closed"})",
      R"({"from": "n", "to": "c"}, {"from": "n", "to": "r"}, {"from": "n", "to": "s"})", R"("u": "c.e")",
      R"("stop": 2, "samples": 3, "relative": 1e-9)");
  check_completed(capacitor);
  for (std::size_t k = 0; k < 3; ++k) {  // a hundred tolerances
    CHECK(std::abs(coil.trace["i"][k] - std::exp(-coil.trace.times[k])) < 1e-7);
    CHECK(std::abs(capacitor.trace["u"][k] - std::exp(-capacitor.trace.times[k] / 2.0)) < 1e-7);
  }
}

TEST_CASE("modes without stores change at the right time") {
  const RunResult result = run_switched(
      R"("v": {"kind": "Se", "effort": "t"}, "r": {"kind": "R", "resistance": 1}, "s": {"kind": "Sw",
         "close": "v.e > 2^0.5", "open": "v.e > 3"}, "in": {"kind": "1"})",
      R"({"from": "v", "to": "in"}, {"from": "in", "to": "r"}, {"from": "in", "to": "s"})", R"("u": "r.e")",
      R"("stop": 2, "times": [1.41421, 1.41422, 2])");
  check_completed(result);
  CHECK(result.trace["u"][0] == 0.0);
  CHECK(result.trace["u"][1] == Approx(1.41422).epsilon(kRounding));
  // Sources do the work of the resistor: the integral of t^2 from sqrt(2) to 2.
  CHECK(result.report.energy.dissipated == Approx((8.0 - 2.0 * std::sqrt(2.0)) / 3.0).epsilon(1e-9));
}

TEST_CASE("two coils that a switch puts in series keep their common flux linkage") {
  // Each with its own source until the bypass between them opens: L1 = 1 with 2 A, L2 = 3 with 0 A; then 0.5 A.
  const RunResult result = run_switched(
      R"("l1": {"kind": "I", "inertance": 1, "initial": {"f": 2}}, "l2": {"kind": "I", "inertance": 3},
         "bypass": {"kind": "Sw", "closed": "t < 1"}, "left": {"kind": "1"}, "node": {"kind": "0"},
         "right": {"kind": "1"})",
      R"({"from": "left", "to": "l1"}, {"from": "left", "to": "node"}, {"from": "node", "to": "bypass"},
         {"from": "node", "to": "right"}, {"from": "right", "to": "l2"})",
      R"("i1": "l1.f", "i2": "l2.f")", R"("stop": 2, "samples": 5)");
  check_completed(result);
  CHECK(last(result, "i1") == Approx(0.5).epsilon(kRounding));
  CHECK(last(result, "i2") == Approx(0.5).epsilon(kRounding));
  CHECK(result.report.energy.switching == Approx(2.0 - 0.5).epsilon(kRounding));
}

TEST_CASE("a switched bridge of capacitors agrees with small resistances in place of its switches") {
  // Three capacitors in a ring, two switches, one of them through a transformer.
  const auto ring = [](const std::string& one, const std::string& two) {
    return run_switched(
        R"("a": {"kind": "C", "capacitance": 1, "initial": {"q": 3}}, "b": {"kind": "C", "capacitance": 2},
           "c": {"kind": "C", "capacitance": 0.5, "initial": {"q": -1}}, "ab": {"kind": "1"}, "bc": {"kind": "1"},
           "nb": {"kind": "0"}, "tf": {"kind": "TF", "modulus": 2}, "leak": {"kind": "R", "resistance": 3}, )" +
            one + "," + two,
        R"({"from": "a", "to": "ab"}, {"from": "ab", "to": "s1"}, {"from": "ab", "to": "nb"}, {"from": "nb", "to": "b"},
           {"from": "nb", "to": "leak"}, {"from": "nb", "to": "bc"}, {"from": "bc", "to": "s2"},
           {"from": "bc", "to": "tf"}, {"from": "tf", "to": "c"})",
        R"("a": "a.e", "b": "b.e", "c": "c.e")", R"("stop": 2, "times": [0.5, 1, 2], "relative": 1e-9)");
  };
  const RunResult ideal =
      ring(R"("s1": {"kind": "Sw", "closed": "t >= 0.25"})", R"("s2": {"kind": "Sw", "closed": "t >= 0.75"})");
  const RunResult real = ring(R"("s1": {"kind": "R", "law": "f = if(t >= 0.25, e/1e-7, 0) + 0"})",
                              R"("s2": {"kind": "R", "law": "f = if(t >= 0.75, e/1e-7, 0) + 0"})");
  check_completed(ideal);
  check_completed(real);
  // 0.1 micro-ohm on capacitors of about a farad: time constants of 1e-7 s, and that much is the difference.
  for (const char* const name : {"a", "b", "c"})
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(ideal.trace[name][i] == Approx(real.trace[name][i]).epsilon(0).margin(2e-6));
  // What the resistances dissipate is what the switches lose: Carnot.
  CHECK(ideal.report.energy.switching + ideal.report.energy.dissipated ==
        Approx(real.report.energy.dissipated).epsilon(1e-5));
}

TEST_CASE("limits and interruptions hold across modes") {
  const std::string elements = R"("v": {"kind": "Se", "effort": 1}, "c": {"kind": "C", "capacitance": 1},
      "r": {"kind": "R", "resistance": 1}, "s": {"kind": "Sw", "closed": "mod(t, 0.1) < 0.05"}, "in": {"kind": "1"})";
  const std::string bonds = R"({"from": "v", "to": "in"}, {"from": "in", "to": "s"}, {"from": "in", "to": "r"},
      {"from": "in", "to": "c"})";
  SimulateOptions options;
  options.max_steps = 60;
  const RunResult limited = run_switched(elements, bonds, R"("u": "c.e")", R"("stop": 10)", "", options);
  REQUIRE(limited.failure);
  CHECK(limited.failure->code == "BG607");
  CHECK(limited.report.steps == 60);
  SimulateOptions stopped;
  stopped.progress = [](double t) { return t < 3.0; };
  const RunResult interrupted = run_switched(elements, bonds, R"("u": "c.e")", R"("stop": 1000)", "", stopped);
  CHECK(interrupted.stop == StopReason::interrupted);
  SimulateOptions snapshot;
  snapshot.resume = "{}";
  CHECK_THROWS_AS(run_switched(elements, bonds, R"("u": "c.e")", R"("stop": 1)", "", snapshot), ModelError);
}

TEST_CASE("a switch that two others make change ends the run where they repeat") {
  const RunResult result = run_switched(
      R"("v": {"kind": "Se", "effort": "t"}, "r": {"kind": "R", "resistance": 1}, "lamp": {"kind": "R", "resistance": 6},
         "s": {"kind": "Sw", "closed": "lamp.e < 1"}, "in": {"kind": "1"})",
      R"({"from": "v", "to": "in"}, {"from": "in", "to": "s"}, {"from": "in", "to": "r"}, {"from": "in", "to": "lamp"})",
      R"("u": "lamp.e")", R"("stop": 2)");
  REQUIRE(result.failure);
  CHECK(result.failure->code == "BG604");
  CHECK(result.report.reached == Approx(7.0 / 6.0).epsilon(1e-9));
}

TEST_CASE("a relay of two switches that slides along its border ends the run") {
  // From 1 V towards 0 by a source of -1 A, and back by one of +1 A: at 0 both push it back.
  const RunResult result = run_switched(
      R"("up": {"kind": "Sf", "flow": 1}, "down": {"kind": "Sf", "flow": -3}, "n": {"kind": "0"}, "m": {"kind": "0"},
         "in": {"kind": "1"}, "s": {"kind": "Sw", "closed": "c.q > 0"}, "by": {"kind": "Sw", "closed": "c.q <= 0"},
         "c": {"kind": "C", "capacitance": 1, "initial": {"q": 1}}, "r": {"kind": "R", "resistance": 1})",
      R"({"from": "up", "to": "n"}, {"from": "down", "to": "m"}, {"from": "m", "to": "by"}, {"from": "m", "to": "in"},
         {"from": "in", "to": "s"}, {"from": "in", "to": "n"}, {"from": "n", "to": "c"}, {"from": "m", "to": "r"})",
      R"("q": "c.q")", R"("stop": 2, "samples": 3)");
  REQUIRE(result.failure);
  CHECK(result.failure->code == "BG604");
  CHECK(result.rows >= 1);
}

TEST_CASE("fast switching at known times is no chattering") {
  // A burst of 200 periods of 1e-6 s in a scene of 1e4 s: the gaps are 5e-11 of the scene.
  const RunResult result = run_switched(
      R"("v": {"kind": "Se", "effort": 1}, "r": {"kind": "R", "resistance": 1},
         "s": {"kind": "Sw", "closed": "t < 1.0002 and mod(min(max(t, 1), 1.0003) - 1, 1e-6) > 5e-7"}, "in": {"kind": "1"},
         "c": {"kind": "C", "capacitance": 1e-3})",
      R"({"from": "v", "to": "in"}, {"from": "in", "to": "r"}, {"from": "in", "to": "s"}, {"from": "in", "to": "c"})",
      R"("u": "c.e")", R"("stop": 1e4, "samples": 2, "relative": 1e-9)");
  check_completed(result);
  // 200 intervals of 5e-7 s, each known to a rounding of t near 1; time constant 1e-3 s.
  CHECK(last(result, "u") == Approx(1.0 - std::exp(-0.1)).epsilon(1e-6));
}

TEST_CASE("a switch whose condition depends on its own flow is open at the start") {
  const RunResult result = run_switched(filled(kPair, {"\"capacitance\": 1", "\"capacitance\": 2", "link.f > 1"}),
                                        kPairBonds, R"("va": "a.e")", R"("stop": 2, "samples": 3)");
  check_completed(result);
  CHECK(last(result, "va") == 3.0);
  CHECK(result.report.energy.switching == 0.0);
}

TEST_CASE("windings that lose all of their flow at once create no energy by rounding") {
  // A forward converter with three coupled windings and a snubber: what is left of the fluxes is rounding when it
  // jumps, and the powers of the windings cancel to less than a thousandth.
  const std::string text = R"({ "bgsim": 1, "name": "forward", "elements": {
      "n1": { "kind": "0" }, "n2": { "kind": "0" }, "n3": { "kind": "0" }, "n4": { "kind": "0" }, "n5": { "kind": "0" },
      "n8": { "kind": "0" }, "core": { "kind": "II", "ports": [ "w1", "w2", "w3" ],
        "energy": "16722.97297297281*w1.p^2 - 13783.488791126498*w1.p*w2.p - 11278.11491705436*w1.p*w3.p + 11593.726867196712*w2.p^2 - 9390.555934918439*w2.p*w3.p + 7762.07403730793*w3.p^2",
        "initial": { "w1.f": 0, "w2.f": 0, "w3.f": 0 } },
      "vd": { "kind": "Se", "effort": 30.31888097760455 }, "j1": { "kind": "1" }, "j2": { "kind": "1" },
      "j3": { "kind": "1" }, "rsn": { "kind": "R", "resistance": 90 },
      "s": { "kind": "Sw", "closed": "mod(t, 1e-05) < 4.799976790540504e-06" }, "ja": { "kind": "1" },
      "da": { "kind": "D" }, "jl": { "kind": "1" }, "co": { "kind": "C", "capacitance": 3.71e-06 },
      "ro": { "kind": "R", "resistance": 2.4780328062285255 } },
    "bonds": [ { "from": "vd", "to": "n1" }, { "from": "n1", "to": "j1" }, { "from": "j1", "to": "n2" },
      { "from": "j1", "to": "core.w1" }, { "from": "n3", "to": "j2" }, { "from": "j2", "to": "core.w2" },
      { "from": "j3", "to": "n8" }, { "from": "j3", "to": "core.w3" }, { "from": "n2", "to": "rsn" },
      { "from": "n2", "to": "s" }, { "from": "n3", "to": "ja" }, { "from": "ja", "to": "n4" },
      { "from": "ja", "to": "da" }, { "from": "n4", "to": "jl" }, { "from": "jl", "to": "n5" },
      { "from": "n5", "to": "co" }, { "from": "n5", "to": "ro" } ],
    "outputs": { "i": "core.w1.f", "v": "co.e" }, "scenes": { "run": { "stop": 2e-4, "samples": 31 } } })";
  for (const double relative : {1e-6, 1e-7, 1e-8, 1e-9, 1e-10}) {
    INFO(relative);
    SceneOverrides overrides = with_relative(relative);
    const RunResult run = Study::from_text(text).scene({}, overrides).simulate(one_run());
    REQUIRE(run.stop == StopReason::completed);
    CHECK(run.report.energy.switching <= 1e-20 * run.report.energy.supplied);
  }
}
