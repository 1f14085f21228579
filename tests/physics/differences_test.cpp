// Sensitivities by differences of runs: where variational equations have them as well, where switches, diodes and
// contacts have closed forms, and where there are none.

#include <catch2/catch.hpp>
#include <cmath>

#include "support/held_capacitor.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

SensitivityTable differences(const Study& study, const std::string& scene, const std::vector<std::string>& to,
                             SensitivityNorm norm = SensitivityNorm::final) {
  return difference_sensitivities(study, scene, {}, to, norm);
}

/// Of the output's number over the parameter. Extrapolated differences over a thousandth of the parameter are off by
/// its sixth powers; runs at 1e-10 that are off by a tolerance, over a quarter of a thousandth, by 4e-7.
constexpr double kWithin = 1e-6;

}  // namespace

TEST_CASE("differences of runs agree with variational equations, for every norm", "[long]") {
  const Study study = study_of("models/bellow.json");
  for (const SensitivityNorm norm : {SensitivityNorm::final, SensitivityNorm::rms, SensitivityNorm::peak,
                                     SensitivityNorm::integral, SensitivityNorm::mean}) {
    const SceneOverrides overrides = with_relative(1e-10);
    const SensitivityTable exact = sensitivities(study, "step", overrides, {"packet.k", "m"}, norm),
                           other = difference_sensitivities(study, "step", overrides, {"packet.k", "m"}, norm);
    REQUIRE(other.outputs == exact.outputs);
    REQUIRE(exact.outputs[0] == "x");
    CHECK(other.parameters == exact.parameters);
    CHECK(other.parameter_values == exact.parameter_values);
    CHECK(other.times[0] == Approx(exact.times[0]).epsilon(1e-6));  // of a peak: flat there
    for (std::size_t p = 0; p < 2; ++p) {
      INFO(exact.parameters[p] << ", norm " << static_cast<int>(norm));
      const double size = std::abs(exact.values[0] / exact.parameter_values[p]);
      CHECK(std::abs(other.of[0][p].derivative - exact.of[0][p].derivative) <= kWithin * size);
      CHECK(other.of[0][p].error <= kWithin * size);
    }
  }
}

TEST_CASE("no method lets the times of a scene follow the parameter, though they are expressions of it") {
  // y = 1 - exp(-(t - start)/R): at t = 2 from 0, and from -1.
  const Study study = Study::from_text(R"({ "bgsim": 1, "name": "times", "parameters": { "R": 1 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
      "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "c" } ],
    "outputs": { "y": "c.e" }, "scenes": { "end": { "stop": "2*R", "samples": 5 },
      "start": { "start": "-R", "stop": 2, "samples": 3 } } })");
  for (const auto& [scene, length] : {std::pair("end", 2.0), std::pair("start", 3.0)}) {
    INFO(scene);
    const double exact = -length * std::exp(-length);
    CHECK(std::abs(differences(study, scene, {"R"}).of[0][0].derivative - exact) < kWithin);
    CHECK(
        std::abs(sensitivities(study, scene, with_relative(1e-10), {"R"}, SensitivityNorm::final).of[0][0].derivative -
                 exact) < kWithin);
    CHECK(std::abs(adjoint_sensitivities(study, scene, with_relative(1e-10), {"R"}, SensitivityNorm::final)
                       .of[0][0]
                       .derivative -
                   exact) < kWithin);
  }
}

TEST_CASE("what differences of runs are said to be known to covers what the runs are wrong by") {
  // A circuit that has rung out: what is left of the start hangs on every step of the run.
  const Study study = study_of("models/rlc.json");
  const SensitivityTable exact = sensitivities(study, "under", with_relative(1e-12), {"C", "L", "R"},
                                               SensitivityNorm::final),
                         table = differences(study, "under", {"C", "L", "R"});
  for (std::size_t i = 0; i < table.of.size(); ++i)
    for (std::size_t p = 0; p < 3; ++p) {
      INFO(table.outputs[i] << " by " << table.parameters[p]);
      const OutputSensitivity& found = table.of[i][p];
      // An estimate by one looser run, not a bound.
      CHECK(std::abs(found.derivative - exact.of[i][p].derivative) <= 3.0 * found.error);
      CHECK(found.error <= 1e-2 * std::abs(found.derivative));
    }
}

TEST_CASE("differences of runs over switches and contacts have the derivatives of closed forms") {
  const HeldCapacitor held;
  const std::vector<double> exact = held.derivatives();
  const SensitivityTable table = differences(held.study(), "run", held.parameters);
  for (std::size_t p = 0; p < exact.size(); ++p) {
    INFO(table.parameters[p]);
    CHECK(table.of[0][p].derivative == Approx(exact[p]).epsilon(kWithin));
  }

  // A ball that rebounds once: v = e v0 - g (t - t1), v0 = sqrt(2 g h), t1 = sqrt(2 h/g).
  const Study ball = Study::from_text(R"x({ "bgsim": 1, "name": "ball", "parameters": { "g": 9.81, "h": 1, "e": 0.7 },
    "elements": { "one": { "kind": "1" }, "m": { "kind": "I", "inertance": 0.3 },
      "weight": { "kind": "Se", "effort": "0.3*g" }, "ground": { "kind": "contact", "gap": "h", "restitution": "e" } },
    "bonds": [ { "from": "weight", "to": "one" }, { "from": "one", "to": "m" }, { "from": "one", "to": "ground" } ],
    "outputs": { "v": "m.f" }, "scenes": { "run": { "stop": 0.8, "samples": 3 } } })x");
  const double g = 9.81, h = 1, rest = 0.7, v0 = std::sqrt(2 * g * h), t1 = std::sqrt(2 * h / g);
  // Downward is positive here: v = -e v0 + g (0.8 - t1).
  const SensitivityTable bounce = differences(ball, "run", {"e", "h", "g"});
  CHECK(bounce.values[0] == Approx(-rest * v0 + g * (0.8 - t1)).epsilon(1e-9));
  CHECK(bounce.of[0][0].derivative == Approx(-v0).epsilon(kWithin));
  CHECK(bounce.of[0][1].derivative == Approx(-rest * v0 / (2 * h) - g * t1 / (2 * h)).epsilon(kWithin));
  CHECK(bounce.of[0][2].derivative == Approx(-rest * v0 / (2 * g) + 0.8 - 0.5 * t1).epsilon(kWithin));
}

TEST_CASE("differences of runs refuse corners and jumps, and parameters that are 0") {
  const auto body = [](const std::string& rate) {
    return Study::from_text(R"x({ "bgsim": 1, "name": "corner", "parameters": { "a": 1, "zero": 0 },
      "signals": { "x": { "integral": ")x" +
                            rate + R"x(" } },
      "elements": { "cap": { "kind": "C", "capacitance": 1 }, "res": { "kind": "R", "resistance": 1 } },
      "bonds": [ { "from": "cap", "to": "res" } ], "outputs": { "x": "x" },
      "scenes": { "run": { "stop": 2, "samples": 3 } } })x");
  };
  CHECK_THROWS_WITH(
      differences(body("3*max(a, 1)"), "run", {"a"}),
      Contains("BG414") && Contains("\"x\" changes with \"a\" by 0 to smaller values and by 6 to larger"));
  CHECK_THROWS_WITH(differences(body("if(a >= 1, 2, 1)"), "run", {"a"}), Contains("BG414"));
  CHECK_THROWS_WITH(differences(body("a + zero"), "run", {"zero"}),
                    Contains("BG414") && Contains("\"zero\" is 0, or not known"));
  CHECK(differences(body("a^2"), "run", {"a"}).of[0][0].derivative == Approx(4.0).epsilon(kWithin));
}

TEST_CASE("what differences are said to be known to covers the flights that a contact leaves out when it closes") {
  // A ball rests from T = sqrt(2h/g)(1 + e)/(1 - e) on, and its force until then is that of impacts: the mean force is
  // m g (3 - T)/3. The run closes the contact some flights before T, a part of 2e-6 of the longest.
  ReadOptions reading;
  reading.record = {"force"};
  const Study force(BGSIM_SOURCE_DIR "/models/ball_contact.json", reading);
  const double m = 0.2, g = 9.81, h = 1.0, fall = std::sqrt(2.0 * h / g);
  for (const double e : {0.7, 0.69, 0.5}) {
    SceneOverrides overrides = with_parameters({"e=" + number_text(e)});
    const SensitivityTable table = difference_sensitivities(force, "", overrides, {"e", "h"}, SensitivityNorm::mean);
    const double T = fall * (1.0 + e) / (1.0 - e);
    const std::vector<double> exact{-m * g / 3.0 * fall * 2.0 / ((1.0 - e) * (1.0 - e)), -m * g / 3.0 * T / (2.0 * h)};
    for (std::size_t p = 0; p < exact.size(); ++p) {
      INFO(table.parameters[p] << ", e = " << e << ": " << table.of[0][p].derivative << " for " << exact[p]);
      CHECK(std::abs(table.of[0][p].derivative - exact[p]) <= table.of[0][p].error);
      // Runs that leave out ten times as much are off by ten times as much: some 1e-4 of the derivatives.
      CHECK(table.of[0][p].error <= 1e-3 * std::abs(exact[p]));
    }
  }
}
