// Sensitivities against closed forms, and against differences of runs.

#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

/// The tightest that the integrators reach with all digits to spare: errors of states are then some 1e-10 of their
/// size, and 1e-8, which the tests ask for, is a hundred times that.
constexpr double kRelative = 1e-11;
constexpr double kExact = 1e-8;

SensitivityTable table_of(const std::string& body, const std::vector<std::string>& to,
                          SensitivityNorm norm = SensitivityNorm::final, const std::vector<std::string>& set = {}) {
  SceneOverrides overrides = with_parameters(set);
  overrides.relative = kRelative;
  return sensitivities(Study::from_text(model_text(body)), "", overrides, to, norm);
}

void check_all(const std::vector<double>& found, const std::vector<double>& exact) {
  REQUIRE(found.size() == exact.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    INFO("number " << i << ": " << found[i] << " for " << exact[i]);
    CHECK(std::abs(found[i] - exact[i]) <= kExact * std::max(std::abs(exact[i]), 1e-3));
  }
}

std::vector<double> first_row(const SensitivityTable& table) {
  std::vector<double> all;
  for (const OutputSensitivity& each : table.of.front()) all.push_back(each.derivative);
  return all;
}

SensitivityTable adjoint_table_of(const std::string& body, const std::vector<std::string>& to,
                                  SensitivityNorm norm = SensitivityNorm::final) {
  SceneOverrides overrides;
  overrides.relative = kRelative;
  return adjoint_sensitivities(Study::from_text(model_text(body)), "", overrides, to, norm);
}

/// By both methods, which are to agree.
std::vector<double> derivatives(const std::string& body, const std::vector<std::string>& to,
                                SensitivityNorm norm = SensitivityNorm::final) {
  const SensitivityTable table = table_of(body, to, norm), adjoint = adjoint_table_of(body, to, norm);
  INFO("adjoint against forward");
  CHECK(adjoint.values.front() == Approx(table.values.front()).epsilon(kExact).margin(1e-11));
  check_all(first_row(adjoint), first_row(table));
  return first_row(table);
}

/// By both methods the same.
std::string refusal(const std::string& body, const std::vector<std::string>& to,
                    SensitivityNorm norm = SensitivityNorm::final) {
  std::string words[2];
  for (const bool adjoint : {false, true}) try {
      adjoint ? adjoint_table_of(body, to, norm) : table_of(body, to, norm);
    } catch (const ModelError& error) {
      words[adjoint ? 1 : 0] = error.what();
    }
  CHECK(words[1] == words[0]);
  return words[0];
}

/// A model of integrals alone; the elements beside them are there since a model has some.
std::string integrals(const std::string& parameters, const std::string& signals, const std::string& output,
                      double stop) {
  return R"x("parameters": {)x" + parameters + R"x(}, "signals": {)x" + signals + R"x(},
    "elements": { "cap": { "kind": "C", "capacitance": 1 }, "res": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "cap", "to": "res" } ], "outputs": { "y": ")x" +
         output + R"x(" }, "scenes": { "s": { "stop": )x" + number_text(stop, 17) + R"x(, "samples": 11 } })x";
}

}  // namespace

TEST_CASE("sensitivities of a charging capacitor: source, resistance, capacitance, start and what follows them") {
  const std::string body = R"x("parameters": { "R": 2, "C": 0.5, "U": 3, "part": 5, "q0": "C/part" },
    "elements": { "s": { "kind": "Se", "effort": "U" }, "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
      "c": { "kind": "C", "capacitance": "C", "initial": { "q": "q0" } } },
    "bonds": [ { "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "c" } ],
    "outputs": { "u": "c.e" }, "scenes": { "s": { "stop": 2, "samples": 11 } })x";
  // u = U + (u0 - U) exp(-T/(R C)), u0 = q0/C = 1/part: C is in the start and leaves it again.
  const double T = 2.0, R = 2.0, C = 0.5, U = 3.0, u0 = 0.2, e = std::exp(-T / (R * C));
  check_all(derivatives(body, {"U", "R", "C", "part", "q0", "c.q", "c.e"}),
            {1.0 - e, (u0 - U) * e * T / (R * R * C), (u0 - U) * e * T / (R * C * C), -e / 25.0, e / C, e / C, e});
  const SensitivityTable table = table_of(body, {"R", "c.q"});
  CHECK(table.of[0][0].relative == Approx(table.of[0][0].derivative * R / table.values[0]).epsilon(1e-14));
  CHECK(table.trace.names == std::vector<std::string>{"u", "d(u)/d(R)", "d(u)/d(c.q)"});
  for (std::size_t i = 0; i < table.trace.times.size(); ++i) {
    const double t = table.trace.times[i];
    CHECK(std::abs(table.trace["d(u)/d(c.q)"][i] - std::exp(-t) / C) < kExact);
    CHECK(std::abs(table.trace["d(u)/d(R)"][i] - (u0 - U) * std::exp(-t) * t / (R * R * C)) < kExact);
  }
}

TEST_CASE("sensitivities of an oscillator at the end, of its mean square and of its peak") {
  const auto body = [](const std::string& r) {
    return R"x("parameters": { "m": 2, "k": 8, "x0": 0.3, "r": )x" + r + R"x( },
    "elements": { "mass": { "kind": "I", "inertance": "m" }, "one": { "kind": "1" }, "res": { "kind": "R", "resistance": "r" },
      "spring": { "kind": "C", "capacitance": "1/k", "initial": { "q": "x0" } } },
    "bonds": [ { "from": "one", "to": "mass" }, { "from": "one", "to": "spring" }, { "from": "one", "to": "res" } ],
    "outputs": { "x": "spring.q" }, "scenes": { "s": { "stop": 3, "samples": 11 } })x";
  };
  // x = x0 cos(w t), w = sqrt(k/m) = 2
  const double T = 3.0, m = 2.0, k = 8.0, x0 = 0.3, w = 2.0;
  const double by_w = -x0 * T * std::sin(w * T);
  check_all(derivatives(body("0"), {"m", "k", "x0"}), {by_w * -w / (2 * m), by_w * w / (2 * k), std::cos(w * T)});
  // mean square: x0^2 (T/2 + sin(2 w T)/(4 w))/T
  const double square = x0 * x0 * (0.5 + std::sin(2 * w * T) / (4 * w * T));
  const double square_by_w = x0 * x0 * (std::cos(2 * w * T) / (2 * w) - std::sin(2 * w * T) / (4 * w * w * T));
  const double rms = std::sqrt(square);
  check_all(derivatives(body("0"), {"k", "x0"}, SensitivityNorm::rms),
            {square_by_w * w / (2 * k) / (2 * rms), rms / x0});
  // Damped, its largest magnitude is the start's x0 = 0.3; that of the velocity's is inside.
  check_all(derivatives(body("1"), {"k", "x0"}, SensitivityNorm::peak), {0.0, 1.0});
}

TEST_CASE("sensitivity of an overshoot") {
  // x'' + 2 z x' + x = 1 from rest overshoots to 1 + exp(-pi z/sqrt(1 - z^2)).
  const double z = 0.3, pi = std::acos(-1.0), root = std::sqrt(1 - z * z);
  const std::string body =
      integrals(R"x("z": 0.3)x", R"x("x": { "integral": "v" }, "v": { "integral": "1 - x - 2*z*v" })x", "x", 12.0);
  check_all(derivatives(body, {"z"}, SensitivityNorm::peak), {-std::exp(-pi * z / root) * pi / (root * root * root)});
}

TEST_CASE("sensitivities through a nonlinear loop: the implicit function theorem") {
  // q' = -f with q/C = R f + a f^3, of which two resistors in series make a loop. From q' = C (R + 3 a f^2) f' = -f:
  // C (R ln(f/f0) + 1.5 a (f^2 - f0^2)) + t = 0.
  const std::string body = R"x("parameters": { "R": 2, "a": 0.7, "C": 0.5, "q0": 1.35 },
    "elements": { "c": { "kind": "C", "capacitance": "C", "initial": { "q": "q0" } }, "one": { "kind": "1" },
      "r": { "kind": "R", "resistance": "R" }, "n": { "kind": "R", "law": "e = a*f^3" } },
    "bonds": [ { "from": "c", "to": "one" }, { "from": "one", "to": "r" }, { "from": "one", "to": "n" } ],
    "outputs": { "f": "n.f" }, "scenes": { "s": { "stop": 1, "samples": 3 } })x";
  const double R = 2, a = 0.7, C = 0.5, f0 = 1.0, T = 1.0;  // q0 = C (R f0 + a f0^3)
  double f = 0.5;
  for (int i = 0; i < 60; ++i)
    f -= (C * (R * std::log(f / f0) + 1.5 * a * (f * f - f0 * f0)) + T) / (C * (R / f + 3 * a * f));
  const double by_f = C * (R / f + 3 * a * f), by_f0 = -C * (R / f0 + 3 * a * f0);
  const double start = C * (R + 3 * a * f0 * f0);  // dq0/df0
  const double f0_by_R = -C * f0 / start, f0_by_a = -C * f0 * f0 * f0 / start, f0_by_C = -(R * f0 + a) / start;
  check_all(derivatives(body, {"R", "a", "C", "q0"}),
            {-(C * std::log(f / f0) + by_f0 * f0_by_R) / by_f, -(C * 1.5 * (f * f - f0 * f0) + by_f0 * f0_by_a) / by_f,
             -(-T / C + by_f0 * f0_by_C) / by_f, -by_f0 / start / by_f});
}

TEST_CASE("a store in derivative causality changes with what it is tied to") {
  // Two masses and a lever, pushed: v = F t/(m + n r^2), and the far end's momentum is n r v.
  const std::string body = R"x("parameters": { "F": 3, "m": 2, "n": 4, "r": 0.5 },
    "elements": { "s": { "kind": "Se", "effort": "F" }, "one": { "kind": "1" }, "near": { "kind": "I", "inertance": "m" },
      "lever": { "kind": "TF", "modulus": "r" }, "far": { "kind": "1" }, "distant": { "kind": "I", "inertance": "n" } },
    "bonds": [ { "from": "s", "to": "one" }, { "from": "one", "to": "near" }, { "from": "far", "to": "lever" },
      { "from": "lever", "to": "one" }, { "from": "far", "to": "distant" } ],
    "outputs": { "p": "distant.p" }, "scenes": { "s": { "stop": 2, "samples": 3 } })x";
  const SensitivityTable table = table_of(body, {"F", "m", "n", "r"});
  // The modulus is that of flows or of its inverse, by the arrow: r or 1/r.
  for (const double r : {0.5, 2.0}) {
    const double F = 3, m = 2, n = 4, T = 2, all = m + n * r * r, p = n * r * F * T / all;
    if (std::abs(p - table.values[0]) > 1e-6) continue;
    const double by_r = n * F * T * (m - n * r * r) / (all * all);
    std::vector<double> found;
    for (const auto& each : table.of[0]) found.push_back(each.derivative);
    check_all(found, {p / F, -p / all, r * F * T * m / (all * all), by_r * (r == 0.5 ? 1.0 : -r * r)});
    return;
  }
  FAIL("neither modulus gives " << table.values[0]);
}

TEST_CASE("sensitivities jump where a condition on states changes the rates") {
  // x' = -a down to c, then -b.
  const std::string body = integrals(R"x("a": 2, "b": 0.5, "c": 1, "x0": 3)x",
                                     R"x("x": { "integral": "if(x > c, -a, -b)", "initial": "x0" })x", "x", 2.5);
  const double a = 2, b = 0.5, c = 1, x0 = 3, T = 2.5;
  check_all(derivatives(body, {"a", "b", "c", "x0"}), {-b * (x0 - c) / (a * a), -(T - (x0 - c) / a), 1 - b / a, b / a});
}

TEST_CASE("sensitivities to the time of a step, and to what it steps to") {
  const std::string body = integrals(R"x("t1": 0.7, "u": 2, "v": 5, "late": "2*t1")x",
                                     R"x("x": { "integral": "if(t < late, u, v) - x" })x", "x", 3.0);
  // x = u (1 - e^-t) until s = 2 t1, then v + (x(s) - v) e^-(t-s)
  const double s = 1.4, u = 2, v = 5, T = 3, e = std::exp(-(T - s));
  check_all(derivatives(body, {"t1", "u", "v"}), {2 * (u - v) * e, (1 - std::exp(-s)) * e, 1 - e});
}

TEST_CASE("sensitivities of impact times: what goes on after them, several events in a row") {
  // Dropped from h, at the floor a clock is started; one that has run for d starts another.
  const std::string body =
      integrals(R"x("g": 9.81, "h": 1.7, "d": 0.2, "v0": 0.4)x",
                R"x("y": { "integral": "v", "initial": "h" }, "v": { "integral": "-g", "initial": "v0" },
                   "n": { "integral": "if(y < 0, 1, 0)" }, "k": { "integral": "if(n > d, n, 0)" })x",
                "k", 1.5);
  // k = (n^2 - d^2)/2 with n = T - t*, h + v0 t* = g t*^2/2
  const double g = 9.81, h = 1.7, d = 0.2, v0 = 0.4, T = 1.5, root = std::sqrt(v0 * v0 + 2 * g * h);
  const double hit = (v0 + root) / g, n = T - hit;
  check_all(derivatives(body, {"h", "v0", "g", "d"}), {-n / root, -n * hit / root, n * hit * hit / 2 / root, -d});
}

TEST_CASE("a relay through a loop: the slope of its condition takes the loop's variables along") {
  // C u' = -i, i by u = R i + a i^3 in a loop; once i < c a drain is opened: u' = -i/C - w.
  const std::string body = R"x("parameters": { "R": 2, "a": 0.7, "c": 0.6, "w": 0.3, "q0": 2.7 },
    "elements": { "cap": { "kind": "C", "capacitance": 1, "initial": { "q": "q0" } }, "one": { "kind": "1" },
      "zero": { "kind": "0" }, "drain": { "kind": "MSf", "flow": "if(n.f < c, w, 0)" },
      "r": { "kind": "R", "resistance": "R" }, "n": { "kind": "R", "law": "e = a*f^3" } },
    "bonds": [ { "from": "zero", "to": "cap" }, { "from": "zero", "to": "one" }, { "from": "zero", "to": "drain" },
      { "from": "one", "to": "r" }, { "from": "one", "to": "n" } ],
    "outputs": { "q": "cap.q", "f": "n.f" }, "scenes": { "s": { "stop": 3, "samples": 3 } })x";
  // Against central differences of runs with two steps, extrapolated: off by some 1e-8 with errors of runs of 1e-11.
  const Study study = Study::from_text(model_text(body));
  SceneOverrides overrides;
  overrides.relative = 1e-12;
  const std::vector<std::string> to{"R", "a", "c", "w", "q0"};
  const SensitivityTable table = sensitivities(study, "", overrides, to, SensitivityNorm::final);
  const Simulation scene = study.scene("", overrides);
  for (std::size_t p = 0; p < to.size(); ++p) {
    const double value = table.parameter_values[p];
    const auto slope = [&](double h, std::size_t i) {
      const auto last = [&](double v) { return scene.with(to[p], v).simulate().trace.columns[i].back(); };
      return (last(value + h) - last(value - h)) / (2 * h);
    };
    for (std::size_t i = 0; i < 2; ++i) {
      const double h = 1e-3 * value, expected = (4 * slope(h / 2, i) - slope(h, i)) / 3;
      INFO(to[p] << " " << i << ": " << table.of[i][p].derivative << " " << expected);
      CHECK(std::abs(table.of[i][p].derivative - expected) < 3e-7 * std::max(1.0, std::abs(expected)));
    }
  }
}

TEST_CASE("sensitivities of bellow and actuator are those that differences of runs show", "[long]") {
  // Differences with two steps, extrapolated, from runs at 1e-10: off by the runs' errors over the step of a
  // thousandth, some 1e-6 of the derivative; kinks of the orifice leave more of those that are small.
  const auto compare = [](const char* file, const std::string& scene, double stop, const std::string& output,
                          const std::vector<std::string>& to) {
    ReadOptions reading;
    reading.stop = number_text(stop, 17);
    reading.record = {output};
    const Study study(std::string(BGSIM_SOURCE_DIR "/models/") + file, reading);
    SceneOverrides overrides;
    overrides.relative = 1e-10;
    const SensitivityTable table = sensitivities(study, scene, overrides, to, SensitivityNorm::final, {}, 2, false);
    const Simulation run = study.scene(scene, overrides, {.energy_audit = false});
    SimulateOptions how;
    how.energy_audit = how.error_estimate = false;
    for (std::size_t p = 0; p < to.size(); ++p) {
      const double value = table.parameter_values[p];
      const auto slope = [&](double h) {
        const auto last = [&](double v) { return run.with(to[p], v).simulate(how).trace.columns[0].back(); };
        return (last(value + h) - last(value - h)) / (2 * h);
      };
      const double expected = (4 * slope(5e-4 * value) - slope(1e-3 * value)) / 3;
      INFO(file << ", " << to[p] << ": " << table.of[0][p].derivative << " " << expected);
      CHECK(table.of[0][p].derivative == Approx(expected).epsilon(1e-4));
    }
  };
  compare("bellow.json", "step", 0.1, "x", {"packet.k", "m", "packet.D", "packet.P_supply", "packet.T"});
  compare("actuator.json", "start", 0.05, "theta", {"m"});
}

TEST_CASE("functions with kinks, tables and remainders have the sensitivities of the side that they are on") {
  // x' = -a abs(x - c) falls to c and stays above it: x = c + (x0 - c) exp(-a t)
  const double e = std::exp(-2.0);
  check_all(derivatives(integrals(R"x("a": 2, "c": 1, "x0": 3)x",
                                  R"x("x": { "integral": "-a*abs(x - c)", "initial": "x0" })x", "x", 1.0),
                        {"a", "c", "x0"}),
            {-2.0 * e, 1 - e, e});
  // A saw tooth of period p, integrated over 2.5 periods: p^2/2 each, then p^2/8; its jumps move with p.
  // d/dp of the integral to T of mod(t, p): -sum of floor(t/p) dt + jumps = with N = 2 whole ones:
  // I = N p^2/2 + (T - N p)^2/2.
  const double p = 0.8, T = 2.0;
  check_all(derivatives(integrals(R"x("p": 0.8)x", R"x("x": { "integral": "mod(t, p)" })x", "x", T), {"p"}),
            {2 * p - 2 * (T - 2 * p)});
  // The smaller of two.
  check_all(
      derivatives(integrals(R"x("a": 2, "b": 0.5)x", R"x("x": { "integral": "min(a, b*t)" })x", "x", 6.0), {"a", "b"}),
      {6.0 - 4.0, 8.0});
}

TEST_CASE("initial values by the law of the store, and integrals from expressions") {
  // e = k q + n q^3 = e0 at the start; q' = -q (R = k + n q^2 makes f = q... by the resistor's law f = e/(k + n q^2)).
  const std::string body = R"x("parameters": { "k": 2, "n": 0.5, "e0": 3.5, "i0": "e0^2" },
    "signals": { "s": { "integral": "-0.5*s", "initial": "i0" } },
    "elements": { "c": { "kind": "C", "law": "e = k*q + n*q^3", "initial": { "e": "e0" } },
      "zero": { "kind": "0" }, "r": { "kind": "MR", "law": "f = c.q" } },
    "bonds": [ { "from": "zero", "to": "c" }, { "from": "zero", "to": "r" } ],
    "outputs": { "y": "c.q + s" }, "scenes": { "s": { "stop": 1, "samples": 3 } })x";
  // 3.5 = 2 q + 0.5 q^3
  double q = 1.5;
  for (int i = 0; i < 60; ++i) q -= (2 * q + 0.5 * q * q * q - 3.5) / (2 + 1.5 * q * q);
  const double slope = 2 + 1.5 * q * q, e = std::exp(-1.0), h = std::exp(-0.5);
  check_all(derivatives(body, {"k", "n", "e0", "c.e", "c.q", "s"}),
            {-q / slope * e, -q * q * q / slope * e, e / slope + 7.0 * h, e / slope, e, h});
}

TEST_CASE("what has no sensitivity is refused") {
  CHECK_THAT(
      refusal(integrals(
                  R"x("c": 1)x",
                  R"x("x": { "integral": "if(t > 1 and t < 2, 1, 0) + if(c < 0.5, y, 0)" }, "y": { "integral": "1" })x",
                  "x", 3.0),
              {"nothing"}),
      Contains("BG413") && Contains("there is no parameter or state \"nothing\""));
  // Two conditions at one instant, moved by different parameters.
  CHECK_THAT(refusal(integrals(R"x("a": 1, "b": 1)x",
                               R"x("x": { "integral": "if(t < a, 1, 0)*if(y < b, 1, 3)" }, "y": { "integral": "1" })x",
                               "x", 2.0),
                     {"a"}),
             Contains("BG414"));
  // Dry friction that holds.
  CHECK_THAT(
      refusal(R"x("parameters": { "dry": 1 }, "elements": { "m": { "kind": "I", "inertance": 1, "initial": { "p": 1 } },
      "one": { "kind": "1" }, "r": { "kind": "R", "law": "e = dry*sign(f)" } },
      "bonds": [ { "from": "one", "to": "m" }, { "from": "one", "to": "r" } ], "outputs": { "v": "m.f" },
      "scenes": { "s": { "stop": 3, "samples": 3 } })x",
              {"m.p"}),
      Contains("BG414") && Contains("dry friction"));
  // A tank that empties through a root.
  CHECK_THAT(
      refusal(integrals(R"x("k": 1)x", R"x("q": { "integral": "if(q > 0, -k*sqrt(q), 0)", "initial": 1 })x", "q", 3.0),
              {"k"}),
      Contains("BG"));
  // A mean square of nothing.
  CHECK_THAT(refusal(integrals(R"x("a": 0)x", R"x("x": { "integral": "a" })x", "x", 1.5), {"a"}, SensitivityNorm::rms),
             Contains("BG414") && Contains("mean square"));
  // A peak at a corner.
  CHECK_THAT(refusal(integrals(R"x("a": 1)x", R"x("x": { "integral": "if(t < a, 1, -1)" })x", "x", 1.5), {"a"},
                     SensitivityNorm::peak),
             Contains("BG414") && Contains("corner"));
  // A peak that the output jumps away from, to where it is flat.
  CHECK_THAT(refusal(integrals(R"x("a": 1)x", R"x("x": { "integral": "1" })x", "if(t > a, 0.5, x)", 1.5), {"a"},
                     SensitivityNorm::peak),
             Contains("BG414") && Contains("corner: it jumps there, from 1 to 0.5"));
}

TEST_CASE("sensitivities to periods and shares of periods: what changes where a period ends has its instant") {
  // On for d T of each period T: x(T_end) counts two whole pulses and the part of the third.
  const auto by = [](const std::string& rate, double stop) {
    return derivatives(integrals(R"x("T": 1, "d": 0.25)x", R"x("x": { "integral": ")x" + rate + R"x(" })x", "x", stop),
                       {"T", "d"});
  };
  check_all(by("if(mod(t, T) < d*T, 1, 0)", 2.1), {2 * 0.25 - 2.0, 2.0});  // 2 d T + (2.1 - 2 T)
  check_all(by("if(mod(t, T) < d*T, 1, 0)", 2.6), {3 * 0.25, 3.0});        // 3 d T
  check_all(by("if(t - T*floor(t/T) < d, 1, 0)", 2.1), {-2.0, 2.0});       // 2 d + (2.1 - 2 T)
  check_all(by("if(mod(t + d, T) < 0.3*T, 1, 0)", 2.1), {0.9, -1.0});      // (0.3 T - d) + 2 0.3 T
  // A triangle: |t/T - whole - 1/2| < d for 2 d T of each period, in its middle.
  check_all(by("if(abs(mod(t, T) - 0.5*T) < d, 1, 0)", 2.0 - 1e-9), {0.0, 4.0});
}

TEST_CASE("integrals and means of outputs that jump") {
  // y = x until t = a, then c: integral of t + c (T - a).
  const std::string body =
      integrals(R"x("a": 1, "c": 5, "b": 1)x", R"x("x": { "integral": "b" })x", "if(t > a, c, x)", 3.0);
  check_all(derivatives(body, {"a", "b", "c"}, SensitivityNorm::integral), {1.0 - 5.0, 0.5, 2.0});
  check_all(derivatives(body, {"a", "b", "c"}, SensitivityNorm::mean), {-4.0 / 3, 0.5 / 3, 2.0 / 3});
  // The square: t^2 until a, then c^2; rms = sqrt(J/T).
  const double rms = std::sqrt((1.0 / 3 + 25 * 2) / 3);
  check_all(derivatives(body, {"a", "b", "c"}, SensitivityNorm::rms),
            {(1.0 - 25) / (6 * rms), (2.0 / 3) / (6 * rms), 20.0 / (6 * rms)});
}

TEST_CASE("what the adjoint equations alone do not have is refused") {
  // Two conditions on different states that change at one instant, by symmetry, whatever the parameter.
  const std::string twins = integrals(
      R"x("k": 1)x",
      R"x("x": { "integral": "k" }, "y": { "integral": "k" }, "z": { "integral": "if(x > 1, 2, 1)*if(y > 1, 3, 1)" })x",
      "z", 2.0);
  check_all(first_row(table_of(twins, {"k"})), {5.0});
  CHECK_THROWS_WITH(adjoint_table_of(twins, {"k"}), Contains("BG414") && Contains("at the same time"));
  // Nothing that is stored.
  const std::string stateless = integrals(R"x("k": 2)x", R"x("x": { "integral": "1" })x", "k^2*sin(t)", 2.0);
  check_all(first_row(table_of(stateless, {"k"})), {4.0 * std::sin(2.0)});
  CHECK_THROWS_WITH(adjoint_table_of(stateless, {"k"}),
                    Contains("BG414") && Contains("nothing that the outputs depend on is stored"));
  // Changes of the mode: q = k (1 - exp(-1/k)).
  const std::string switched = R"x("elements": { "s": { "kind": "Se", "effort": 1 },
      "w": { "kind": "Sw", "closed": "t < 1" }, "one": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
      "c": { "kind": "C", "capacitance": "k" } }, "parameters": { "k": 2 },
      "bonds": [ { "from": "s", "to": "one" }, { "from": "one", "to": "w" }, { "from": "one", "to": "r" },
      { "from": "one", "to": "c" } ], "outputs": { "q": "c.q" }, "scenes": { "s": { "stop": 2, "samples": 3 } })x";
  check_all(first_row(table_of(switched, {"k"})), {1.0 - 1.5 * std::exp(-0.5)});
  CHECK_THROWS_WITH(adjoint_table_of(switched, {"k"}), Contains("BG414") && Contains("ideal switches"));
}

TEST_CASE("a peak that is as large to both sides has no derivative where the two change differently") {
  // x + b = a cos(t) + b: for b > 0 the peak is a + b, for b < 0 it is -(a - b). By a both grow alike.
  const std::string body = integrals(
      R"x("a": 2, "b": 0)x", R"x("x": { "integral": "v", "initial": "a" }, "v": { "integral": "-x" })x", "x + b", 4.0);
  CHECK_THAT(refusal(body, {"b"}, SensitivityNorm::peak), Contains("BG414") && Contains("as large to both sides"));
  check_all(derivatives(body, {"a"}, SensitivityNorm::peak), {1.0});
  // Beyond the tolerance one side is the larger.
  const std::string larger =
      integrals(R"x("a": 2, "b": 1e-6)x", R"x("x": { "integral": "v", "initial": "a" }, "v": { "integral": "-x" })x",
                "x + b", 4.0);
  check_all(derivatives(larger, {"b"}, SensitivityNorm::peak), {1.0});
}

TEST_CASE("no sensitivity where the derivatives of both sides differ") {
  const auto model = [](const std::string& parameters, const std::string& rate, const std::string& start = "1") {
    return integrals(parameters, R"x("x": { "integral": ")x" + rate + R"x(", "initial": ")x" + start + R"x(" })x", "x",
                     2.0);
  };
  const auto refused = [&](const std::string& body) { return refusal(body, {"k"}); };
  const auto is_414 = Contains("BG414");
  // Among parameters, and in laws of parameters alone.
  CHECK_THAT(refused(model(R"x("k": 2, "limit": 2, "used": "min(k, limit)")x", "-used")),
             is_414 && Contains("min(k, limit)"));
  CHECK_THAT(refused(model(R"x("k": 3, "n": "floor(k)")x", "-n")), is_414);
  CHECK_THAT(refused(model(R"x("k": 3)x", "if(k > 3, 1, 2)")), is_414);
  CHECK_THAT(refused(model(R"x("k": 0)x", "abs(k)")), is_414);
  CHECK_THAT(refused(model(R"x("k": 0)x", "1", "abs(k)")), is_414);
  CHECK(refused(model(R"x("k": 3.5, "n": "floor(k)", "limit": 2, "used": "min(k, limit)")x", "k - n*used")).empty());
  // At the start.
  CHECK_THAT(refused(model(R"x("k": 1)x", "if(x > 1, -1, -2)", "k")), is_414 && Contains("start"));
  CHECK_THAT(refused(model(R"x("k": 1)x", "if(x >= 1, 1, 2)", "k")), is_414 && Contains("start"));
  CHECK_THAT(refused(model(R"x("k": 0)x", "if(t < k, 1, 2)")), is_414 && Contains("start"));
  CHECK(refused(model(R"x("k": 1)x", "if(x > 1, -k*x, -2*k)", "1")).find("BG414") == std::string::npos);
}

TEST_CASE("the sensitivity to one parameter does not depend on the others, nor on the number of threads") {
  const std::string body = integrals(R"x("a": 2, "b": 0.5, "c": 1)x",
                                     R"x("x": { "integral": "if(x > c, -a, -b*x)", "initial": 3 })x", "x", 2.5);
  const Study study = Study::from_text(model_text(body));
  const SensitivityTable one = sensitivities(study, "", {}, {"b"}, SensitivityNorm::final);
  const SensitivityTable all = sensitivities(study, "", {}, {"a", "b", "c"}, SensitivityNorm::final, {}, 3);
  CHECK(one.of[0][0].derivative == all.of[0][1].derivative);
}

TEST_CASE("sensitivities where a flow turns back through laws with a kink in their slope") {
  // On both sides the rate is that flow, which is 0 there: what rounding leaves of it was taken for a jump (BG414).
  constexpr double kStop = 6.0;
  const auto mean = [](double k) {  // of q' = f, k f + f |f| = 10 sin(t) - 20 q
    const auto flow = [k](double t, double q) {
      const double e = 10.0 * std::sin(t) - 20.0 * q;
      return (e < 0.0 ? -1.0 : 1.0) * 0.5 * (std::sqrt(k * k + 4.0 * std::abs(e)) - k);
    };
    constexpr int kSteps = 200'000;
    constexpr double h = kStop / kSteps;
    double q = 0.0, sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double t = h * i, a = flow(t, q), b = flow(t + h / 2, q + h / 2 * a), c = flow(t + h / 2, q + h / 2 * b),
                   d = flow(t + h, q + h * c), next = q + h / 6 * (a + 2 * b + 2 * c + d);
      sum += h / 2 * (q + next);
      q = next;
    }
    return sum / kStop;
  };
  const double exact = (mean(1.0 + 1e-4) - mean(1.0 - 1e-4)) / 2e-4;
  for (const std::string law :
       {"K*f + f*abs(f)", "f*(K + abs(f))", "K*f + max(f, 0)^2 - max(-f, 0)^2", "K*f + sign(f)*f^2"}) {
    INFO(law);
    const std::string body = R"j("parameters": { "K": 1 }, "elements": { "s": { "kind": "MSe", "effort": "10*sin(t)" },
        "j": { "kind": "1" }, "r": { "kind": "R", "law": "e = )j" +
                             law + R"j(" }, "c": { "kind": "C", "capacitance": 0.05 } },
      "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "c" } ],
      "outputs": { "q": "c.q" }, "scenes": { "main": { "stop": 6, "samples": 11 } })j";
    const Study study = Study::from_text(model_text(body));
    // At the default tolerance, where the flow at the event is farthest from 0. Differences of the sums leave 1e-8.
    const SensitivityTable table = sensitivities(study, "", with_relative(1e-6), {"K"}, SensitivityNorm::mean);
    CHECK(std::abs(first_row(table).front() - exact) <= 1e-6 * std::abs(exact));
    CHECK(std::abs(derivatives(body, {"K"}, SensitivityNorm::mean).front() - exact) <= 1e-7 * std::abs(exact));
  }
}

TEST_CASE("adjoint sensitivities where a source's step turns the flows of a loop back") {
  // Two compartments behind an airway, with Rohrer's resistances: the adjoint equations freeze the sign of f*abs(f),
  // and with that of before the step the loop has no solution (BG602). By both methods.
  const std::string body = R"j("parameters": { "K1": 1.2, "K2": 0.8, "Rb": 1.9, "C": 0.05 }, "elements": {
      "vent": { "kind": "Se", "effort": "if(t < 1.5, 15, 5)" }, "aw": { "kind": "1" },
      "r0": { "kind": "R", "law": "e = K1*f + K2*f*abs(f)" }, "n": { "kind": "0" }, "b": { "kind": "1" },
      "rb": { "kind": "R", "law": "e = Rb*f + 0.5*f*abs(f)" }, "cb": { "kind": "C", "capacitance": "C" },
      "a": { "kind": "1" }, "ra": { "kind": "R", "resistance": 1.8 }, "ca": { "kind": "C", "capacitance": "C" } },
    "bonds": [ { "from": "vent", "to": "aw" }, { "from": "aw", "to": "r0" }, { "from": "aw", "to": "n" },
      { "from": "n", "to": "a" }, { "from": "n", "to": "b" }, { "from": "b", "to": "rb" }, { "from": "b", "to": "cb" },
      { "from": "a", "to": "ra" }, { "from": "a", "to": "ca" } ],
    "outputs": { "V": "cb.q" }, "scenes": { "main": { "stop": 6, "samples": 11 } })j";
  for (const SensitivityNorm norm : {SensitivityNorm::mean, SensitivityNorm::final})
    for (const double derivative : derivatives(body, {"K1", "C"}, norm)) CHECK(std::isfinite(derivative));
}
