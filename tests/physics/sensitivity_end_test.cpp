// Sensitivities where something happens at the very end of the run: what lies on both sides of that decides, by every
// method.

#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

/// Signals beside a resistor that does nothing; the run ends at t = 1.
Study ending(const std::string& parameters, const std::string& signals, const std::string& output,
             const std::string& more = {}) {
  return Study::from_text(model_text("\"parameters\": { " + parameters + " }, \"signals\": { " + signals + R"x( },
    "elements": { "cap": { "kind": "C", "capacitance": 1 }, "res": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "cap", "to": "res" } ], "outputs": { "y": ")x" +
                                     output + "\" }, " + more + R"x("scenes": { "s": { "stop": 1, "samples": 3 } })x"));
}

/// Each method's table; what it is refused with comes instead.
struct Answer {
  std::string method, refused;
  std::vector<double> derivatives;
};
std::vector<Answer> answers(const Study& study, const std::vector<std::string>& to, SensitivityNorm norm) {
  // What runs are wrong by is a hundredth of kWithin.
  const SceneOverrides overrides = with_relative(1e-10);
  std::vector<Answer> result;
  for (const std::string method : {"forward", "adjoint", "differences"}) {
    Answer answer;
    answer.method = method;
    try {
      const SensitivityTable table = method == "forward"   ? sensitivities(study, "", overrides, to, norm)
                                     : method == "adjoint" ? adjoint_sensitivities(study, "", overrides, to, norm)
                                                           : difference_sensitivities(study, "", overrides, to, norm);
      for (const OutputSensitivity& each : table.of.front()) answer.derivatives.push_back(each.derivative);
    } catch (const ModelError& error) {
      answer.refused = render(error);
    }
    result.push_back(answer);
  }
  return result;
}

void refused_by_all(const Study& study, const std::string& to, SensitivityNorm norm) {
  for (const Answer& answer : answers(study, {to}, norm)) {
    INFO(answer.method << ", norm " << static_cast<int>(norm));
    CHECK_THAT(answer.refused, Contains("BG414"));
  }
}

/// Numbers here are about 1; differences over a thousandth, extrapolated, are off by 4e-7 of runs at 1e-10 (see
/// differences_test.cpp).
constexpr double kWithin = 1e-6;

void found_by_all(const Study& study, const std::string& to, SensitivityNorm norm, double exact) {
  for (const Answer& answer : answers(study, {to}, norm)) {
    INFO(answer.method << ", norm " << static_cast<int>(norm) << ": " << answer.refused);
    REQUIRE(answer.derivatives.size() == 1);
    CHECK(std::abs(answer.derivatives.front() - exact) <= kWithin);
  }
}

}  // namespace

TEST_CASE("an edge of a source at the end of the run leaves no derivative by its instant") {
  const Study study = Study::from_text(model_text(R"x("parameters": { "a": 1, "R": 2 },
    "elements": { "s": { "kind": "MSe", "effort": "step(t - a) + t" }, "one": { "kind": "1" },
      "r": { "kind": "R", "resistance": "R" }, "c": { "kind": "C", "capacitance": 0.5 } },
    "bonds": [ { "from": "s", "to": "one" }, { "from": "one", "to": "r" }, { "from": "one", "to": "c" } ],
    "outputs": { "u": "c.e" }, "scenes": { "s": { "stop": 1, "samples": 3 } })x"));
  // R C = 1: u' at the end is greater by 1 behind the edge, so u changes by -1 with a smaller a, and not with a larger.
  refused_by_all(study, "a", SensitivityNorm::final);
  // The voltage rises to the end, so its peak is there.
  refused_by_all(study, "a", SensitivityNorm::peak);
  // Of the mean voltage that is nothing: it is a square of how much earlier the edge is.
  found_by_all(study, "a", SensitivityNorm::mean, 0.0);
  // By R, which has no part in the instant: u = t - T (1 - exp(-t/T)), T = R/2, so du/dR = -(1 - 2/e)/2.
  found_by_all(study, "R", SensitivityNorm::final, -0.5 * (1.0 - 2.0 / std::exp(1.0)));
}

TEST_CASE("a sample that is taken at the end of the run leaves no derivative by the sampling time") {
  // What follows a held t^2: at the end the rate jumps.
  const Study study = ending(R"x("T": 0.25, "b": 2)x",
                             R"x("held": { "value": "b*t", "every": "T" }, "x": { "integral": "held" })x", "x");
  refused_by_all(study, "T", SensitivityNorm::final);
  // The integral of x is of the second order in how much earlier the sample is.
  found_by_all(study, "b", SensitivityNorm::final, 0.25 * (0.25 + 0.5 + 0.75));
  // The held signal itself: the end is a jump, of its integral a corner.
  const Study held = ending(R"x("T": 0.25, "b": 2)x", R"x("held": { "value": "b*t", "every": "T" })x", "held");
  for (const SensitivityNorm norm : {SensitivityNorm::final, SensitivityNorm::peak, SensitivityNorm::mean,
                                     SensitivityNorm::integral, SensitivityNorm::rms})
    refused_by_all(held, "T", norm);
  // By b, which does not move the sample, both sides do not count: the run ends behind it.
  found_by_all(held, "b", SensitivityNorm::final, 1.0);
  found_by_all(held, "b", SensitivityNorm::mean, 0.375);
}

TEST_CASE("the shipped sampled servo has no derivative by its sampling time at the end of a period") {
  // The sides differ by a fortieth, which differences over larger steps do not see beside the bend of the mean.
  const Study study = study_of("models/sampled_servo.json");
  for (const std::string method : {"forward", "adjoint", "differences"}) {
    INFO(method);
    RefusedParameters refused;
    const std::vector<std::string> to{"kp", "Ts"};
    const SensitivityTable table =
        method == "forward"   ? sensitivities(study, "", {}, to, SensitivityNorm::mean, {}, 1, true, &refused)
        : method == "adjoint" ? adjoint_sensitivities(study, "", {}, to, SensitivityNorm::mean, {}, true, &refused)
                              : difference_sensitivities(study, "", {}, to, SensitivityNorm::mean, {}, 1, &refused);
    CHECK(table.parameters == std::vector<std::string>{"kp"});
    REQUIRE(refused.size() == 1);
    CHECK(refused.front().first == "Ts");
  }
}

TEST_CASE("a condition that comes to its border as the run ends leaves no derivative by what moves it") {
  const Study slope =
      ending(R"x("k": 1, "b": 2)x", R"x("x": { "integral": "1" }, "y": { "integral": "if(x > k, b, 0)" })x", "y + t");
  refused_by_all(slope, "k", SensitivityNorm::final);
  refused_by_all(slope, "k", SensitivityNorm::peak);
  found_by_all(slope, "b", SensitivityNorm::final, 0.0);
  found_by_all(slope, "k", SensitivityNorm::mean, 0.0);
  // An output that jumps there: its derivative is 0 before and behind, and its value is not the same.
  const Study jump = ending(R"x("k": 1, "b": 2)x", R"x("x": { "integral": "1" })x", "if(t < k, b*x, 2*b*x)");
  for (const SensitivityNorm norm : {SensitivityNorm::final, SensitivityNorm::peak, SensitivityNorm::mean})
    refused_by_all(jump, "k", norm);
  found_by_all(jump, "b", SensitivityNorm::final, 2.0);
  // An event that would take place with a smaller k.
  const Study sets = ending(R"x("k": 2, "b": 2)x", R"x("x": { "integral": "b" })x", "x",
                            R"x("events": { "back": { "when": "x >= k", "set": { "x": "0" } } }, )x");
  for (const SensitivityNorm norm : {SensitivityNorm::final, SensitivityNorm::peak, SensitivityNorm::mean})
    refused_by_all(sets, "k", norm);
}

TEST_CASE("an event shortly before the end of the run has its derivatives") {
  // Sampled at 0.3, 0.6 and 0.9: the integral of held is b T^2 (1 + 2) + 3 b T (1 - 3 T).
  const Study study = ending(R"x("T": 0.3, "b": 2)x",
                             R"x("held": { "value": "b*t", "every": "T" }, "x": { "integral": "held" })x", "x");
  found_by_all(study, "T", SensitivityNorm::final, 2.0 * (6.0 * 0.3 + 3.0 - 18.0 * 0.3));
}
