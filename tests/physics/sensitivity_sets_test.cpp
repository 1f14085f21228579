// Sensitivities over events that set stores, samples and latches: against closed forms, and differences of runs.

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <functional>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

using Complex = std::complex<double>;

/// Tolerances of the runs, and what is asked for: as in sensitivity_test.cpp.
constexpr double kRelative = 1e-11;
constexpr double kExact = 1e-8;

SensitivityTable table_of(const std::string& body, const std::vector<std::string>& to,
                          SensitivityNorm norm = SensitivityNorm::final, const std::vector<std::string>& set = {}) {
  SceneOverrides overrides = with_parameters(set);
  overrides.relative = kRelative;
  return sensitivities(Study::from_text(model_text(body)), "", overrides, to, norm);
}

/// The same by the adjoint equations, to their own tolerance.
void check_adjoint(const std::string& body, const std::vector<std::string>& to, const SensitivityTable& forward,
                   SensitivityNorm norm = SensitivityNorm::final) {
  constexpr double kAdjoint = 1e-7;  // they follow slopes along a dense output, which loses some digits more
  SceneOverrides overrides;
  overrides.relative = kRelative;
  const SensitivityTable table = adjoint_sensitivities(Study::from_text(model_text(body)), "", overrides, to, norm);
  REQUIRE(table.outputs == forward.outputs);
  for (std::size_t i = 0; i < table.outputs.size(); ++i)
    for (std::size_t p = 0; p < to.size(); ++p) {
      INFO("adjoint: " << table.outputs[i] << " by " << to[p]);
      const double expected = forward.of[i][p].derivative;
      CHECK(std::abs(table.of[i][p].derivative - expected) <= kAdjoint * std::max(std::abs(expected), 1e-2));
    }
}

std::string refusal(const std::string& body, const std::vector<std::string>& to) {
  try {
    table_of(body, to);
  } catch (const ModelError& error) {
    return error.what();
  }
  return "not refused";
}

/// The derivatives of a closed form by each of its arguments, exact to rounding: by a step into the imaginary numbers.
std::vector<double> exact(const std::function<Complex(const std::vector<Complex>&)>& form,
                          const std::vector<double>& at) {
  constexpr double kStep = 1e-30;
  std::vector<double> all;
  for (std::size_t i = 0; i < at.size(); ++i) {
    std::vector<Complex> moved(at.begin(), at.end());
    moved[i] += Complex(0.0, kStep);
    all.push_back(form(moved).imag() / kStep);
  }
  return all;
}

void check_row(const SensitivityTable& table, std::size_t row, const std::vector<double>& expected) {
  REQUIRE(table.of[row].size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    INFO(table.outputs[row] << " by " << table.parameters[i] << ": " << table.of[row][i].derivative << " for "
                            << expected[i]);
    CHECK(std::abs(table.of[row][i].derivative - expected[i]) <= kExact * std::max(std::abs(expected[i]), 1e-3));
  }
}

/// A ball on a floor, with the time of its latest impact.
std::string ball(double stop) {
  return R"x("parameters": { "m": 0.1, "g": 9.81, "e": 0.7, "h": 1 },
    "signals": { "height": { "integral": "one.f", "initial": "h" }, "stamp": { "integral": "0", "initial": 0 } },
    "elements": { "one": { "kind": "1" }, "mass": { "kind": "I", "inertance": "m" },
      "weight": { "kind": "Se", "effort": "-m*g" } },
    "bonds": [ { "from": "weight", "to": "one" }, { "from": "one", "to": "mass" } ],
    "events": { "bounce": { "when": "height <= 0", "set": { "mass.p": "-e*pre(mass.p)", "stamp": "t" } } },
    "outputs": { "height": "height", "v": "one.f", "stamp": "stamp" },
    "scenes": { "s": { "stop": )x" +
         number_text(stop, 17) + R"x(, "samples": 11 } })x";
}

}  // namespace

TEST_CASE("sensitivities of a bouncing ball: its height, its speed, and when it hit the floor") {
  const double stop = 1.9;  // 0.45, 1.08, 1.52, 1.83: after four impacts
  const auto flight = [&](const std::vector<Complex>& p) {
    struct Flight {
      Complex at, speed;
    };
    const Complex g = p[0], e = p[1], h = p[2];
    Flight now{std::sqrt(2.0 * h / g), e * std::sqrt(2.0 * g * h)};
    for (int impact = 1; impact < 4; ++impact) now = {now.at + 2.0 * now.speed / g, e * now.speed};
    return now;
  };
  const std::vector<double> at = {9.81, 0.7, 1.0};
  const SensitivityTable table = table_of(ball(stop), {"g", "e", "h", "m"});
  check_adjoint(ball(stop), {"g", "e", "h", "m"}, table);
  for (const SensitivityNorm norm : {SensitivityNorm::integral, SensitivityNorm::rms})
    check_adjoint(ball(stop), {"g", "e", "h", "m"}, table_of(ball(stop), {"g", "e", "h", "m"}, norm), norm);
  const auto without_mass = [](std::vector<double> all) {
    all.push_back(0.0);
    return all;
  };
  check_row(table, 0,
            without_mass(exact(
                [&](const auto& p) {
                  const auto now = flight(p);
                  return now.speed * (stop - now.at) - 0.5 * p[0] * (stop - now.at) * (stop - now.at);
                },
                at)));
  check_row(table, 1,
            without_mass(exact(
                [&](const auto& p) {
                  const auto now = flight(p);
                  return now.speed - p[0] * (stop - now.at);
                },
                at)));
  check_row(table, 2, without_mass(exact([&](const auto& p) { return flight(p).at; }, at)));
}

TEST_CASE("sensitivities over an event whose instant is a parameter, and what it sets depends on the instant") {
  // p falls by exp(-r t) until a, then k p + c a^2, and falls again.
  const std::string body = R"x("parameters": { "a": 0.8, "k": 0.5, "c": 3, "r": 1.2 }, "elements": {
      "one": { "kind": "1" }, "m": { "kind": "I", "inertance": 1, "initial": { "p": 2 } },
      "res": { "kind": "R", "resistance": "r" } },
    "bonds": [ { "from": "one", "to": "m" }, { "from": "one", "to": "res" } ],
    "events": { "kick": { "when": "t > a", "set": { "m.p": "k*pre(m.p) + c*t^2" } } }, "outputs": { "p": "m.p" },
    "scenes": { "s": { "stop": 2, "samples": 3 } })x";
  const auto form = [](const std::vector<Complex>& p) {
    const Complex a = p[0], k = p[1], c = p[2], r = p[3], p0 = p[4];
    return (k * p0 * std::exp(-r * a) + c * a * a) * std::exp(-r * (2.0 - a));
  };
  const std::vector<double> at = {0.8, 0.5, 3.0, 1.2, 2.0};
  check_row(table_of(body, {"a", "k", "c", "r", "m.p"}), 0, exact(form, at));
  // Its integral: what jumps lies within it.
  const auto integral = [](const std::vector<Complex>& p) {
    const Complex a = p[0], k = p[1], c = p[2], r = p[3], p0 = p[4], first = std::exp(-r * a);
    return (p0 * (1.0 - first) + (k * p0 * first + c * a * a) * (1.0 - std::exp(-r * (2.0 - a)))) / r;
  };
  check_row(table_of(body, {"a", "k", "c", "r", "m.p"}, SensitivityNorm::integral), 0, exact(integral, at));
  for (const SensitivityNorm norm : {SensitivityNorm::final, SensitivityNorm::integral, SensitivityNorm::rms})
    check_adjoint(body, {"a", "k", "c", "r", "m.p"}, table_of(body, {"a", "k", "c", "r", "m.p"}, norm), norm);
}

TEST_CASE("sensitivities over events of two priorities at one instant, one of which the other makes due") {
  // At x = b x becomes x + c, which makes the second due: it sets y to x y, from after the first.
  const std::string body = R"x("parameters": { "b": 1, "c": 2, "w": 1.5 },
    "signals": { "x": { "integral": "w" }, "y": { "integral": "x", "initial": 1 } },
    "elements": { "cap": { "kind": "C", "capacitance": 1 }, "res": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "cap", "to": "res" } ],
    "events": { "first": { "when": "x >= b", "set": { "x": "x + c" }, "priority": 2 },
                "second": { "when": "x >= b + 0.5*c", "set": { "y": "x*y" }, "priority": 1 } },
    "outputs": { "y": "y", "x": "x" }, "scenes": { "s": { "stop": 1, "samples": 3 } })x";
  const auto y = [](const std::vector<Complex>& p) {
    const Complex b = p[0], c = p[1], w = p[2], T = b / w, left = 1.0 - T;
    return (b + c) * (1.0 + 0.5 * w * T * T) + (b + c) * left + 0.5 * w * left * left;
  };
  const auto x = [](const std::vector<Complex>& p) { return p[1] + p[2]; };
  const SensitivityTable table = table_of(body, {"b", "c", "w"});
  check_adjoint(body, {"b", "c", "w"}, table);
  check_row(table, 0, exact(y, {1.0, 2.0, 1.5}));
  check_row(table, 1, exact(x, {1.0, 2.0, 1.5}));
}

TEST_CASE("sensitivities where an event sets a store to what a loop gives") {
  // A divider whose upper resistor bends: u = e0 - i r - i^3, i = u/s; the event sets the capacitor to a multiple of u.
  const std::string body = R"x("parameters": { "E": 4, "r": 0.5, "s": 2, "k": 0.3, "a": 0.6 }, "elements": {
      "source": { "kind": "Se", "effort": "E*(1 + t)" }, "loop": { "kind": "1" },
      "upper": { "kind": "R", "law": "e = r*f + f^3" }, "lower": { "kind": "R", "resistance": "s" },
      "cap": { "kind": "C", "capacitance": 1, "initial": { "q": 0.1 } }, "leak": { "kind": "R", "resistance": 1 },
      "node": { "kind": "0" } },
    "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "upper" }, { "from": "loop", "to": "lower" },
      { "from": "node", "to": "cap" }, { "from": "node", "to": "leak" } ],
    "events": { "set": { "when": "t > a", "set": { "cap.q": "k*lower.e" } } }, "outputs": { "q": "cap.q" },
    "scenes": { "s": { "stop": 1, "samples": 3 } })x";
  // With i from (r + s) i + i^3 = E (1 + a): q = k s i exp(a - 1).
  const double E = 4.0, r = 0.5, s = 2.0, k = 0.3, a = 0.6;
  double i = 1.0;
  for (int again = 0; again < 60; ++again) i -= ((r + s) * i + i * i * i - E * (1 + a)) / (r + s + 3 * i * i);
  const double slope = r + s + 3 * i * i, e = std::exp(a - 1.0);
  check_adjoint(body, {"E", "r", "s", "k", "a"}, table_of(body, {"E", "r", "s", "k", "a"}));
  check_row(table_of(body, {"E", "r", "s", "k", "a"}), 0,
            {k * s * (1 + a) / slope * e, -k * s * i / slope * e, k * (i - s * i / slope) * e, s * i * e,
             k * s * (E / slope + i) * e});
}

TEST_CASE("sensitivities of sampled controllers and latches agree with differences of runs") {
  const std::string sampled = R"x("parameters": { "T": 0.21, "k": 1.3, "m": 0.8, "target": 0.9, "width": 0.15 },
    "signals": { "x": { "integral": "one.f", "initial": 0 },
      "u": { "value": "k*(target - x) - 0.4*one.f", "every": "T" },
      "near": { "set": "x > target - width", "reset": "x < 0.1" } },
    "elements": { "motor": { "kind": "MSe", "effort": "u + if(near, 0.05, 0)" }, "one": { "kind": "1" },
      "mass": { "kind": "I", "inertance": "m" }, "drag": { "kind": "R", "resistance": 0.3 } },
    "bonds": [ { "from": "motor", "to": "one" }, { "from": "one", "to": "mass" }, { "from": "one", "to": "drag" } ],
    "outputs": { "x": "x", "v": "one.f" }, "scenes": { "s": { "stop": 3.3, "samples": 5 } })x";
  const std::vector<std::string> to = {"T", "k", "m", "target", "width"};
  const double at[] = {0.21, 1.3, 0.8, 0.9, 0.15};
  const SensitivityTable table = table_of(sampled, to);
  check_adjoint(sampled, to, table);
  for (std::size_t p = 0; p < to.size(); ++p) {
    const auto ends = [&](double value) {
      return table_of(sampled, {"k"}, SensitivityNorm::final, {to[p] + "=" + number_text(value, 17)}).values;
    };
    // Extrapolated from differences over 1e-4 and 5e-5, so off by 1e-16 of fifth derivatives, which for the period,
    // whose end is the fifteenth sample's, are some 1e5 units; runs at 1e-11 add 2e-7 in all.
    constexpr double kStep = 1e-4, kWithin = 2e-7;
    const auto difference = [&](double step, std::size_t output) {
      return (ends(at[p] + step)[output] - ends(at[p] - step)[output]) / (2 * step);
    };
    for (std::size_t i = 0; i < table.outputs.size(); ++i) {
      INFO(table.outputs[i] << " by " << to[p]);
      const double exact = (4 * difference(0.5 * kStep, i) - difference(kStep, i)) / 3;
      CHECK(table.of[i][p].derivative == Approx(exact).epsilon(kWithin).margin(kWithin));
    }
  }
}

TEST_CASE("events that set stores and have no derivative are refused") {
  const auto body = [](const std::string& when) {
    return R"x("parameters": { "a": 1, "b": 1 }, "signals": { "x": { "integral": "1" }, "y": { "integral": "1" } },
      "elements": { "cap": { "kind": "C", "capacitance": 1 }, "res": { "kind": "R", "resistance": 1 } },
      "bonds": [ { "from": "cap", "to": "res" } ],
      "events": { "set": { "when": ")x" +
           when +
           R"x(", "set": { "x": "5*x" } } }, "outputs": { "x": "x" }, "scenes": { "s": { "stop": 8, "samples": 3 } })x";
  };
  // Two conditions at one instant, which the parameter parts.
  CHECK_THAT(refusal(body("x >= a and y >= b"), {"a"}),
             Contains("BG414") && Contains("\"set\" takes place, where conditions change that another value"));
}
