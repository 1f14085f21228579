// Sensitivities by the adjoint equations: against those by the variational equations, and against closed forms. More
// models, each by both, are in sensitivity_test.cpp.

#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>
#include <regex>

#include "support/nonlinear_graph.hpp"
#include "support/rounds.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

/// The largest difference of two tables: of each derivative over its size, or over what is a thousandth of the output's
/// largest magnitude for a change of the parameter by itself. Where an output has settled it is rounding, and so is
/// what it changes by.
double apart(const SensitivityTable& one, const SensitivityTable& other) {
  REQUIRE(one.of.size() == other.of.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < one.of.size(); ++i)
    for (std::size_t p = 0; p < one.of[i].size(); ++p) {
      const double size = std::max(std::abs(one.of[i][p].derivative), std::abs(other.of[i][p].derivative));
      double largest = 0.0;
      for (const double value : one.trace.columns[i]) largest = std::max(largest, std::abs(value));
      const double least = 1e-3 * largest / std::max(std::abs(one.parameter_values[p]), 1e-30);
      const double scale = std::max(size, least);
      if (scale > 0.0) worst = std::max(worst, std::abs(one.of[i][p].derivative - other.of[i][p].derivative) / scale);
    }
  return worst;
}

/// A graph with each law times a parameter of its own, "k0", "k1", ..., all of them 1.
std::string with_factors(const std::string& json, std::vector<std::string>& names) {
  const std::regex law(R"x("law": "([ef]) = ([^"]*)")x");
  std::string result = "{\"parameters\": {";
  std::string rest;
  auto from = json.begin() + 1;
  for (std::sregex_iterator at(json.begin(), json.end(), law), none; at != none; ++at) {
    const std::string name = "k" + std::to_string(names.size());
    result += (names.empty() ? "\"" : ", \"") + name + "\": 1";
    names.push_back(name);
    rest.append(from, (*at)[0].first);
    rest += "\"law\": \"" + (*at)[1].str() + " = " + name + "*(" + (*at)[2].str() + ")\"";
    from = (*at)[0].second;
  }
  rest.append(from, json.end());
  return result + "}, " + rest;
}

}  // namespace

TEST_CASE("adjoint and variational equations agree on the bellow, over its events, by every norm", "[long]") {
  ReadOptions reading;
  reading.record = {"x", "P2"};
  reading.stop = "0.06";
  const Study study(BGSIM_SOURCE_DIR "/models/bellow.json", reading);
  // The adjoints follow slopes along the dense output: those of the orifice change by orders of magnitude within a
  // pascal, and magnify its errors, 1e-12 of each state, by some 1e5.
  SceneOverrides overrides;
  overrides.relative = 1e-12;
  const std::vector<std::string> to{"packet.k", "m", "packet.D", "packet.P_supply", "packet.A"};
  for (const SensitivityNorm norm : {SensitivityNorm::final, SensitivityNorm::rms, SensitivityNorm::peak,
                                     SensitivityNorm::integral, SensitivityNorm::mean}) {
    INFO("norm " << static_cast<int>(norm));
    // When a peak is, is known to the root of rounding alone, and the derivative goes on changing there.
    const double within = norm == SensitivityNorm::peak ? 1e-5 : 1e-6;
    CHECK(apart(sensitivities(study, "step", overrides, to, norm, {}, 2, false),
                adjoint_sensitivities(study, "step", overrides, to, norm, {}, false)) < within);
  }
}

TEST_CASE("adjoint sensitivities of what decays by very different times") {
  // Two time constants, 1 and 1e-6, one behind the other: y = (1 - e^-T/a) u, and the fast one follows.
  const std::string body = R"x("parameters": { "a": 2, "b": 1e6, "u": 3 },
    "signals": { "x": { "integral": "(u - x)/a" }, "y": { "integral": "b*(x - y)" } },
    "elements": { "cap": { "kind": "C", "capacitance": 1 }, "res": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "cap", "to": "res" } ], "outputs": { "y": "y" }, "scenes": { "s": { "stop": 1, "samples": 2 } })x";
  SceneOverrides overrides;
  overrides.relative = 1e-11;
  const SensitivityTable table =
      adjoint_sensitivities(Study::from_text(model_text(body)), "", overrides, {"a", "b", "u"}, SensitivityNorm::final);
  // y = u (1 - (c e^-t/a - e^-bt)/(c - 1)), c = a b
  const double a = 2, b = 1e6, u = 3, c = a * b, e = std::exp(-1 / a);
  CHECK(table.of[0][0].derivative == Approx(-u * e * (c / (a * a * (c - 1)) - b / ((c - 1) * (c - 1)))).epsilon(1e-8));
  CHECK(table.of[0][1].derivative == Approx(u * e * a / ((c - 1) * (c - 1))).epsilon(1e-5).margin(1e-15));
  CHECK(table.of[0][2].derivative == Approx(1 - c * e / (c - 1)).epsilon(1e-8));
}

TEST_CASE("adjoint sensitivities of a ladder of sections, whose matrix is sparse, and of a rate that is time's alone",
          "[long]") {
  // Sixty RC sections: more states than are solved densely. The gradient by C and R of each is held against three of
  // the variational ones.
  std::string parameters = "\"U\": 1, \"w\": 40", elements = R"x("s": { "kind": "MSe", "effort": "U*cos(w*t)" })x",
              bonds;
  std::string before = "s";
  for (int i = 1; i <= 60; ++i) {
    const std::string n = std::to_string(i);
    parameters +=
        ", \"R" + n + "\": " + number_text(1 + 0.01 * i) + ", \"C" + n + "\": " + number_text(0.1 + 0.003 * i);
    elements += ", \"one" + n + R"(": { "kind": "1" }, "r)" + n + R"(": { "kind": "R", "resistance": "R)" + n +
                R"(" }, "zero)" + n + R"(": { "kind": "0" }, "c)" + n + R"(": { "kind": "C", "capacitance": "C)" + n +
                "\" }";
    for (const auto& [from, to] : {std::pair(before, "one" + n), std::pair("one" + n, "r" + n),
                                   std::pair("one" + n, "zero" + n), std::pair("zero" + n, "c" + n)})
      bonds += std::string(bonds.empty() ? "" : ", ") + R"({ "from": ")" + from + R"(", "to": ")" + to + "\" }";
    before = "zero" + n;
  }
  const Study study = Study::from_text(model_text("\"parameters\": {" + parameters + "}, \"elements\": {" + elements +
                                                  "}, \"bonds\": [" + bonds + R"(], "outputs": { "u": "c3.e" },
    "scenes": { "s": { "stop": 0.3, "samples": 3 } })"));
  SceneOverrides overrides;
  overrides.relative = 1e-10;
  const std::vector<std::string> to{"R2", "C5", "w"};
  for (const SensitivityNorm norm : {SensitivityNorm::final, SensitivityNorm::rms})
    CHECK(apart(sensitivities(study, "", overrides, to, norm, {}, 2, false),
                adjoint_sensitivities(study, "", overrides, to, norm, {}, false)) < 1e-7);
}

TEST_CASE("adjoint and variational equations agree on random graphs with nonlinear laws") {
  NonlinearGraphOptions options;
  options.graph.most_rings = 1;
  options.graph.most_junctions = 4;
  options.graph.sources = 0.25;
  const std::uint64_t rounds = from_environment("BGSIM_RANDOM_ROUNDS", share_of(20)),
                      first = from_environment("BGSIM_RANDOM_SEED", 1);
  std::size_t compared = 0;
  for (std::uint64_t seed = first; seed < first + rounds; ++seed) {
    const NonlinearGraph graph = random_nonlinear_graph(seed, options);
    if (graph.initial.empty()) continue;
    INFO("seed " << seed);
    SceneOverrides overrides;
    overrides.relative = 1e-9;
    try {
      std::vector<std::string> to;
      const Study study = Study::from_text(with_factors(graph.json(), to));
      if (to.size() > 3) to.resize(3);
      const SensitivityTable forward = sensitivities(study, "", overrides, to, SensitivityNorm::final, {}, 2, false);
      const SensitivityTable adjoint =
          adjoint_sensitivities(study, "", overrides, to, SensitivityNorm::final, {}, false);
      const double error = apart(forward, adjoint);
      if (rounds > 20 && error > 1e-6) std::cout << "seed " << seed << ": " << error << "\n";
      CHECK(error < 1e-4);
      ++compared;
    } catch (const ModelError& error) {
      if (rounds > 20)
        std::cout << "seed " << seed << ": " << error.diagnostics.front().code << " "
                  << error.diagnostics.front().situation << "\n";
    }
  }
  CHECK(compared > rounds / 4);
}
