// De and Df: they read what they are bonded to and change nothing.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "support/random_graph.hpp"
#include "support/rounds.hpp"
#include "support/run.hpp"

namespace {

using namespace bgsim;
using namespace bgsim::test;

/// @p graph with a De at each 0-junction and a Df at each 1-junction.
RandomGraph with_detectors(RandomGraph graph) {
  const std::size_t count = graph.elements.size();
  for (std::size_t i = 0; i < count; ++i) {
    const RandomElement at = graph.elements[i];
    if (at.kind != "0" && at.kind != "1") continue;
    const std::string name = "meter_" + at.name;
    graph.elements.push_back({name, at.kind == "0" ? "De" : "Df", 0.0});
    // Half of them with the half-arrow leaving the detector.
    if (i % 2 == 0)
      graph.bonds.emplace_back(at.name, name);
    else
      graph.bonds.emplace_back(name, at.name);
  }
  return graph;
}

/// What the junctions share, recorded beside the outputs, as "at_" and the junction's name.
std::string with_junctions(const RandomGraph& graph) {
  std::string text = graph.json(), more;
  for (const RandomElement& element : graph.elements)
    if (element.kind == "0" || element.kind == "1")
      more += (more.empty() ? "\"at_" : ", \"at_") + element.name + "\": \"" + element.name +
              (element.kind == "0" ? ".e\"" : ".f\"");
  const std::string key = "\"outputs\": {";
  const std::size_t place = text.find(key) + key.size();
  return text.insert(place, more + (text[place] == '}' ? "" : ", "));
}

TEST_CASE("detectors at every junction of random graphs change neither strokes nor motion, and read the junctions") {
  SceneOverrides tight;
  tight.relative = 1e-10;
  const std::uint64_t rounds = share_of(300);
  std::size_t compared = 0, meters = 0, undetermined = 0;
  for (std::uint64_t seed = 1; seed <= rounds; ++seed) {
    const RandomGraph graph = random_graph(seed);
    const RandomGraph metered = with_detectors(graph);
    INFO("seed " << seed << "\n" << metered.json());
    const Study plain = Study::from_text(graph.json()), study = Study::from_text(with_junctions(metered));
    std::string refused;
    try {
      static_cast<void>(plain.order());
    } catch (const ModelError& error) {
      refused = error.diagnostics.front().code;
    }
    if (!refused.empty()) {
      // What is wrong with the graph is wrong with detectors, too.
      CHECK_THROWS_AS(study.order(), ModelError);
      continue;
    }
    // A detector asks for what its junction shares: nothing may determine that in a ring.
    const Study asked = Study::from_text(with_junctions(graph));
    try {
      static_cast<void>(asked.order());
    } catch (const ModelError& error) {
      CHECK(error.diagnostics.front().code == "BG411");
      CHECK_THROWS_AS(study.order(), ModelError);
      ++undetermined;
      continue;
    }
    REQUIRE_NOTHROW(study.order());
    std::set<std::size_t> in_rings;  // solved as a whole: strokes there show one way of many
    for (const Study* at : {&plain, &study})
      for (const JunctionPart& part : at->causality().ranked)
        for (const BondId bond : part.inner) in_rings.insert(bond.index());
    for (std::size_t bond = 0; bond < plain.graph().bonds.size(); ++bond)
      if (!in_rings.contains(bond)) CHECK(plain.causality().strokes[bond].end == study.causality().strokes[bond].end);
    CHECK(plain.equations().energy.size() == study.equations().energy.size());
    if (plain.model().outputs.empty()) continue;
    const RunResult without = plain.scene("", tight).simulate(), with = study.scene("", tight).simulate();
    REQUIRE(without.stop == with.stop);
    if (without.stop != StopReason::completed) continue;
    ++compared;
    for (const std::string& name : without.trace.names) {
      const auto a = without.trace[name], b = with.trace[name];
      double scale = 1.0;
      for (const double value : a) scale = std::max(scale, std::abs(value));
      // A sum with one more zero may be added up in another order; the runs add that up over some hundred steps.
      for (std::size_t i = 0; i < a.size(); ++i) REQUIRE(std::abs(a[i] - b[i]) <= 1e-8 * scale);
    }
    for (const std::string& name : with.trace.names) {
      if (!name.starts_with("meter_")) continue;
      ++meters;
      const auto read = with.trace[name], shared = with.trace["at_" + name.substr(6)];
      for (std::size_t i = 0; i < read.size(); ++i) {
        CAPTURE(name, read[i], shared[i]);
        // The same but for the roundings of a loop, of which each may be another unknown.
        REQUIRE(std::abs(read[i] - shared[i]) <= 1e-10 * std::max(1.0, std::abs(shared[i])));
      }
    }
  }
  CHECK(compared > rounds / 2);
  CHECK(meters > 5 * rounds / 3);
  CHECK(10 * undetermined < rounds);
}

// A motor whose voltage follows the speed that a Df reads: with the winding's inductance left out,
// J w' = k (kp (w_set - w) - k w)/R - b w.
constexpr const char* kMotor = R"x({ "bgsim": 1, "name": "speed_control",
  "parameters": { "R": 2, "k": 0.5, "J": 0.1, "b": 0.05, "kp": 2, "w_set": 10 },
  "signals": { "u": "kp*(w_set - tacho.f)" },
  "elements": {
    "supply": { "kind": "MSe", "effort": "u" }, "voltage": { "kind": "0" }, "voltmeter": { "kind": "De" },
    "coil": { "kind": "1" }, "ohmic": { "kind": "R", "resistance": "R" }, "motor": { "kind": "GY", "modulus": "k" },
    "shaft": { "kind": "1" }, "rotor": { "kind": "I", "inertance": "J" }, "bearing": { "kind": "R", "resistance": "b" },
    "tacho": { "kind": "Df" } },
  "bonds": [ { "from": "supply", "to": "voltage" }, { "from": "voltage", "to": "voltmeter" },
    { "from": "voltage", "to": "coil" }, { "from": "coil", "to": "ohmic" }, { "from": "coil", "to": "motor" },
    { "from": "motor", "to": "shaft" }, { "from": "shaft", "to": "rotor" }, { "from": "shaft", "to": "bearing" },
    { "from": "shaft", "to": "tacho" } ],
  "outputs": { "w": "tacho.f", "u": "voltmeter.e", "current": "ohmic.f", "tacho_effort": "tacho.e",
    "voltmeter_flow": "voltmeter.f" },
  "scenes": { "start": { "stop": 1, "samples": 11 } } })x";

TEST_CASE("a controlled motor follows the speed that its Df reads, and both detectors take no power") {
  const RunResult result = run_text(kMotor, with_relative(1e-9));
  REQUIRE(result.stop == StopReason::completed);
  const double rate = (0.5 * (2.0 + 0.5) / 2.0 + 0.05) / 0.1, final = 0.5 * 2.0 * 10.0 / 2.0 / 0.1 / rate;
  const auto w = result.trace["w"], u = result.trace["u"];
  for (std::size_t i = 0; i < w.size(); ++i) {
    const double exact = final * (1.0 - std::exp(-rate * result.trace.times[i]));
    CHECK(w[i] == Approx(exact).margin(1e-7));  // a hundred times the tolerance of 1e-9, of some 7 rad/s
    CHECK(u[i] == 2.0 * (10.0 - w[i]));
    CHECK(result.trace["tacho_effort"][i] == 0.0);
    CHECK(result.trace["voltmeter_flow"][i] == 0.0);
  }
  CHECK(result.report.energy.relative < 1e-6);
}

}  // namespace
