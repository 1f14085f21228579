// Sensitivities of peaks: the top of a smooth output is found whatever the tolerance, and corners and jumps are not
// taken for one.

#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

/// Signals beside a resistor that does nothing.
Study peaking(const std::string& parameters, const std::string& signals, const std::string& output, double stop = 3.0) {
  return Study::from_text(model_text("\"parameters\": { " + parameters + " }, \"signals\": { " + signals + R"x( },
    "elements": { "cap": { "kind": "C", "capacitance": 1 }, "res": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "cap", "to": "res" } ], "outputs": { "y": ")x" +
                                     output + R"x(" }, "scenes": { "s": { "stop": )x" + number_text(stop) +
                                     R"x(, "samples": 3 } })x"));
}

SensitivityTable peak_of(const Study& study, const std::vector<std::string>& to, bool adjoint, double relative,
                         const std::string& scene = {}) {
  return adjoint ? adjoint_sensitivities(study, scene, with_relative(relative), to, SensitivityNorm::peak)
                 : sensitivities(study, scene, with_relative(relative), to, SensitivityNorm::peak);
}

void check_by_both(const Study& study, const std::vector<std::string>& to, const std::vector<double>& exact) {
  for (const bool adjoint : {false, true}) {
    const SensitivityTable table = peak_of(study, to, adjoint, 1e-10);
    for (std::size_t p = 0; p < to.size(); ++p) {
      INFO(to[p] << (adjoint ? ", adjoint" : ", forward"));
      // A thousand tolerances: the top's time is known to some of them, and numbers are about 1.
      CHECK(std::abs(table.of[0][p].derivative - exact[p]) <= 1e-7);
    }
  }
}

void refused_by_both(const Study& study, const std::string& to, const std::string& words) {
  for (const bool adjoint : {false, true})
    CHECK_THROWS_WITH(peak_of(study, {to}, adjoint, 1e-10), Contains("BG414") && Contains("is a corner: " + words));
}

}  // namespace

TEST_CASE("the peak of a circuit is smooth at any tolerance, however far the search stopped from its top") {
  const Study study = Study::from_text(model_text(R"x("parameters": { "U": 5, "R": 0.4, "C": 0.3, "L": 0.5 },
    "elements": { "s": { "kind": "Se", "effort": "U" }, "one": { "kind": "1" },
      "r": { "kind": "R", "resistance": "R" }, "c": { "kind": "C", "capacitance": "C" },
      "i": { "kind": "I", "inertance": "L" } },
    "bonds": [ { "from": "s", "to": "one" }, { "from": "one", "to": "r" }, { "from": "one", "to": "c" },
      { "from": "one", "to": "i" } ], "outputs": { "u": "c.e" }, "scenes": { "s": { "stop": 4, "samples": 3 } })x"));
  // U (1 + exp(-a pi/w)), a = R/(2 L), w^2 = 1/(L C) - a^2; derivatives by 30 digits.
  const std::vector<double> exact{1.6110105606, -3.85513416343, -2.57008944229, 1.54205366537},
      values{5.0, 0.4, 0.3, 0.5};
  for (const bool adjoint : {false, true})
    for (const double relative : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9, 1e-11}) {
      const SensitivityTable table = peak_of(study, {"U", "R", "C", "L"}, adjoint, relative);
      for (std::size_t p = 0; p < exact.size(); ++p) {
        INFO(table.parameters[p] << (adjoint ? ", adjoint" : ", forward") << ", relative " << relative);
        // Of the number over the parameter: runs are off by some tolerances.
        CHECK(std::abs(table.of[0][p].derivative - exact[p]) <= 10.0 * relative * table.values[0] / values[p]);
        CHECK(table.of[0][p].error >= 0.0);  // known
      }
    }
}

TEST_CASE("the peak of the shipped bellow is smooth at any tolerance") {
  const Study study = study_of("models/bellow.json");
  const double exact = peak_of(study, {"packet.R_gas"}, false, 1e-11, "step").of[0][0].derivative;
  for (const bool adjoint : {false, true})
    for (const double relative : {1e-3, 1e-4, 1e-6, 1e-7, 1e-8}) {
      INFO((adjoint ? "adjoint" : "forward") << ", relative " << relative);
      const OutputSensitivity found = peak_of(study, {"packet.R_gas"}, adjoint, relative, "step").of[0][0];
      // Both of a per cent by a third of one; slopes of the orifice are known to some ten tolerances.
      CHECK(std::abs(found.derivative - exact) <= 100.0 * relative * exact);
      CHECK(found.error >= 0.0);
    }
}

TEST_CASE("a peak at a corner or at a jump has no derivative as that of the output") {
  const std::string ramp = R"x("x": { "integral": "1" })x";
  refused_by_both(peaking(R"x("k": 0.4)x", ramp, "2 - abs(x - k)", 2.0), "k", "its slope is 1 before it and -1 behind");
  // So shallow that both slopes are a hundredth of what the output falls by later.
  refused_by_both(peaking(R"x("k": 0.4)x", ramp, "2 - 0.01*abs(x - k) - max(x - 1, 0)", 2.0), "k",
                  "its slope is 0.01 before it and -0.01 behind");
  refused_by_both(peaking(R"x("k": 0.4)x", ramp, "if(t < k, x, 0.2)", 2.0), "k", "it jumps there, from 0.4 to 0.2");
  // Up, to where it falls at once.
  refused_by_both(peaking(R"x("k": 0.4)x", ramp, "if(t < k, 0.2, 1 - 0.5*(x - k))", 2.0), "k",
                  "it jumps there, from 0.2 to 1");
}

TEST_CASE("a peak that is flat on one side of an event has the derivative of that side") {
  const std::string ramp = R"x("x": { "integral": "1" })x";
  // A limit: from there on the output is the limit.
  check_by_both(peaking(R"x("a": 2, "limit": 1.5)x",
                        R"x("x": { "integral": "v" }, "v": { "integral": "-x", "initial": "a" })x", "min(x, limit)"),
                {"a", "limit"}, {0.0, 1.0});
  // A jump up to the top of a parabola.
  check_by_both(peaking(R"x("k": 0.4, "b": 1)x", ramp, "if(t < k, 0.2, b - (x - k)^2)", 1.0), {"k", "b"}, {0.0, 1.0});
  // A swing whose friction changes its sign at the top: sqrt(c^2 + v0^2) - c.
  const double c = 0.2, v0 = 1.5, size = std::hypot(c, v0);
  check_by_both(
      peaking(R"x("c": 0.2, "v0": 1.5)x",
              R"x("x": { "integral": "v" }, "v": { "integral": "-x - if(v > 0, c, -c)", "initial": "v0" })x", "x", 2.5),
      {"c", "v0"}, {c / size - 1.0, v0 / size});
  // An event shortly before the top, and one shortly behind it: x = t - t^2/2 has its top at 1 in both.
  for (const char* const when : {"t > 0.9999999", "t > 1.0000001"})
    check_by_both(peaking(R"x("b": 1)x",
                          std::string(R"x("v": { "integral": "-1", "initial": "b" }, "x": { "integral": "v" },
                            "n": { "integral": "if()x") +
                              when + R"x(, 1, 0)" })x",
                          "x + 0*n", 2.0),
                  {"b"}, {1.0});
}

TEST_CASE("a note says of which parameters the errors are not known, and why") {
  // A swing, sin(t), whose output has no value where it is off by more than 1e-6: at a tolerance of 1e-6 by a third of
  // that, at 1e-5 by more.
  const Study study =
      peaking(R"x("a": 1, "b": 2)x", R"x("x": { "integral": "v" }, "v": { "integral": "-a*x", "initial": "1" })x",
              "x + b + sqrt(1e-6^2 - (x - sin(t))^2)", 6.0);
  for (const bool adjoint : {false, true}) {
    const SensitivityTable table = peak_of(study, {"a", "b"}, adjoint, 1e-6);
    CHECK(std::isnan(table.of[0][0].error));
    CHECK(std::isnan(table.of[0][1].error));
    REQUIRE(!table.notes.empty());
    CHECK_THAT(table.notes.back(), Contains("\"b\" are off (within) is not known") &&
                                       Contains("at ten times the tolerance, failed: ") && Contains("sqrt("));
  }
}
