// Loops whose variables are unknowns of the integrator for one part of a run, and found inside the rates for another.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "support/circuit.hpp"
#include "support/files.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

const std::string kInside = "loops are solved inside the state equations from t = ";
const std::string kUnknowns = "loops are unknowns of the integrator from t = ";

/// The ring modulator without the stray capacities of its diodes: the coils' currents meet in the diodes alone, and are
/// bound to each other while these block.
std::string ring_modulator_without_strays() {
  auto model = nlohmann::ordered_json::parse(file_text(in_project("tests/data/models/ring_modulator.json")));
  auto bonds = nlohmann::ordered_json::array();
  for (const auto& bond : model["bonds"]) {
    const std::string to = bond["to"];
    if (to != "C3" && to != "C4" && to != "C5" && to != "C6") bonds.push_back(bond);
  }
  model["bonds"] = bonds;
  for (const char* stray : {"C3", "C4", "C5", "C6"}) model["elements"].erase(stray);
  model["scenes"] = {{"trace", {{"stop", 5e-5}, {"samples", 51}}}};
  return model.dump();
}

/// A bridge of diodes with a smoothing capacitor.
std::string bridge() {
  const std::string diode = R"x("law": "f = 1e-9*(exp(e/0.045) - 1)")x";
  return circuit({{"s", "Se", "x", "b", R"x("effort": "17*sin(314*t)")x"},
                  {"rs", "R", "x", "a", resistor("0.5")},
                  {"d1", "R", "a", "plus", diode},
                  {"d2", "R", "b", "plus", diode},
                  {"d3", "R", "0", "a", diode},
                  {"d4", "R", "0", "b", diode},
                  {"c", "C", "plus", "0", "\"capacitance\": 1e-3"},
                  {"r", "R", "plus", "0", resistor("50")}},
                 R"("u": "c.e")", R"("stop": 0.1, "samples": 101)");
}

}  // namespace

TEST_CASE("IDA finds a bridge's loops inside the rates where its own iteration fails") {
  const RunResult by_ida = run_text(bridge(), with_method(Method::ida));
  REQUIRE(by_ida.stop == StopReason::completed);
  CHECK_THAT(by_ida.report.method, Contains("IDA"));
  CHECK_THAT(by_ida.report.method_reason, Contains(kInside));
  const RunResult by_bdf = run_text(bridge(), with_method(Method::bdf, 1e-9));
  REQUIRE(by_bdf.stop == StopReason::completed);
  CHECK(largest_difference(by_bdf, by_ida) < 1e-4);  // a hundred tolerances of 1e-6
}

TEST_CASE("a run by no particular method has loops as unknowns that keep the iteration over states from converging") {
  const std::string text = ring_modulator_without_strays();
  const RunResult by_ida = run_text(text, with_method(Method::ida, 1e-9));
  REQUIRE(by_ida.stop == StopReason::completed);
  // By Radau IIA from the start; by BDF, of a limited order, until its iteration fails too often.
  const int max_order = GENERATE(0, 4);
  CompiledModel model = compile_text(text, with_relative(1e-8));
  model.inputs.max_order = max_order;
  const RunResult chosen = model.run();
  REQUIRE(chosen.stop == StopReason::completed);
  CHECK_THAT(chosen.report.method, Contains(max_order > 0 ? "IDA" : "Radau IIA"));
  CHECK_THAT(chosen.report.method_reason, Contains(max_order > 0 ? kUnknowns : "are unknowns of the integrator"));
  for (const char* output : {"U1", "U2", "U7", "I1", "I3", "I4", "I7", "I8"}) {
    INFO(output);
    const std::vector<double> exact = column(by_ida, output);
    // A thousand tolerances of 1e-8: the fast motions behind each switching of a diode are passed with errors of their
    // own. (The efforts across the blocked coils jump there, and are not compared.)
    CHECK(largest_difference(exact, column(chosen, output)) < 1e-5 * largest_magnitude(exact));
  }
}

TEST_CASE("a run whose loops have changed their form continues from a snapshot bit for bit") {
  for (const bool given : {false, true}) {
    INFO(given);
    CompiledModel model =
        given ? compile_text(ring_modulator_without_strays()) : compile_text(bridge(), with_method(Method::ida));
    if (given) model.inputs.max_order = 4;
    std::vector<std::string> taken;
    SimulateOptions options;
    options.snapshot_steps = 300;
    options.snapshot = [&taken](double /*t*/, const std::string& text) { taken.push_back(text); };
    const RunResult whole = model.run(options);
    REQUIRE(whole.stop == StopReason::completed);
    REQUIRE_THAT(whole.report.method_reason, Contains(given ? kUnknowns : kInside));
    REQUIRE(taken.size() > 2);
    const std::size_t latest = taken.size() - 2;  // the last one is of the end
    SimulateOptions from;
    from.snapshot_steps = 300;
    from.snapshot = [](double /*t*/, const std::string& /*text*/) {};
    from.resume = taken[latest];
    const RunResult part = model.run(from);
    REQUIRE(part.stop == StopReason::completed);
    CHECK(part.report.method_reason == whole.report.method_reason);
    CHECK(part.report.steps == whole.report.steps);
    for (std::size_t c = 0; c < whole.trace.columns.size(); ++c)
      CHECK(part.trace.columns[c].back() == whole.trace.columns[c].back());
  }
}
