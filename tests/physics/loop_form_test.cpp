// Loops whose variables are unknowns of the integrator for one part of a run, and found inside the rates for another.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

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

TEST_CASE("a loop that only outputs need is solved at each of them, and no unknown of the integrator") {
  // Its variable was one that nothing looked at: it came to 1e20, where the loop was not found, and what it shares
  // equations with, the clock of a delay, was 0.03 s late by the roundings of that.
  const std::pair<const char*, double (*)(double)> laws[] = {
      {"f = 1e-4*(exp(e/0.3) - 1) + e/200", [](double e) { return 1e-4 * std::expm1(e / 0.3) + e / 200.0; }},
      {"f = 0.02*e^3", [](double e) { return 0.02 * e * e * e; }},
      {"e = 100*f + 2e5*f^3", [](double e) {
         double f = 0.0;
         for (int i = 0; i < 200; ++i) f -= (100.0 * f + 2e5 * f * f * f - e) / (100.0 + 6e5 * f * f);
         return f;
       }}};
  for (const auto& [law, flow] : laws)
    for (const double by : {1.0, 3.0})
      for (const Method method :
           {Method::automatic, Method::radau, Method::radau9, Method::rodas5p, Method::ida, Method::bdf}) {
        CAPTURE(law, by, method_name(method));
        const RunResult run =
            compile_text(
                R"x({"bgsim": 1, "name": "late", "signals": {"y": {"delay": "5*sin(0.2*t)", "by": )x" +
                    std::to_string(by) + R"x(, "initial": 0}}, "elements": {"v": {"kind": "MSe", "effort": "y"},
            "j": {"kind": "1"}, "r": {"kind": "R", "resistance": 50}, "d": {"kind": "R", "law": ")x" +
                    law +
                    R"x("}}, "bonds": [{"from": "v", "to": "j"}, {"from": "j", "to": "r"}, {"from": "j", "to": "d"}],
          "outputs": {"u": "d.e", "i": "r.f", "y": "y"}, "scenes": {"s": {"stop": 40, "samples": 2001}}})x",
                with_method(method))
                .run();
        REQUIRE(run.stop == StopReason::completed);
        const std::vector<double> u = column(run, "u"), i = column(run, "i"), y = column(run, "y");
        for (std::size_t k = 0; k < u.size(); ++k) {
          const double t = run.trace.times[k], late = t < by ? 0.0 : 5.0 * std::sin(0.2 * (t - by));
          CHECK(std::abs(y[k] - late) < 1e-5);  // ten tolerances of a range of 10 beside the record of the delay
          CHECK(std::abs(u[k] + 50.0 * i[k] - y[k]) < 1e-9);
          CHECK(std::abs(flow(u[k]) - i[k]) < 1e-9);
        }
      }
}
