// Which method `auto` takes in systems of many states, and that it changes where the system does.
#include <catch2/catch.hpp>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

/// Masses of 1 in a row on springs, the first of which is moved; @p damper is the law of a resistor on each mass.
std::string chain(std::size_t masses, const std::string& spring, const std::string& damper, const std::string& stop,
                  const std::string& signals = "") {
  std::string elements = R"-("wall": { "kind": "Sf", "flow": "0.5*sin(t)" })-", bonds, before = "wall";
  for (std::size_t i = 0; i < masses; ++i) {
    const std::string k = std::to_string(i);
    elements += R"(, "link)" + k + R"(": { "kind": "0" }, "at)" + k + R"(": { "kind": "1" }, "spring)" + k +
                R"(": { "kind": "C", "law": "e = )" + spring + R"(" }, "m)" + k +
                R"(": { "kind": "I", "inertance": 1 }, "r)" + k + R"(": { "kind": "MR", "law": "e = )" + damper +
                "\" }";
    for (const auto& [from, to] :
         {std::pair{before, "link" + k}, std::pair{"link" + k, "spring" + k}, std::pair{"link" + k, "at" + k},
          std::pair{"at" + k, "m" + k}, std::pair{"at" + k, "r" + k}})
      bonds += (bonds.empty() ? R"({ "from": ")" : R"(, { "from": ")") + from + R"(", "to": ")" + to + "\" }";
    before = "at" + k;
  }
  return R"({ "bgsim": 1, "name": "chain", "signals": { )" + signals + R"( }, "elements": { )" + elements +
         R"( }, "bonds": [ )" + bonds + R"( ], "outputs": { "first": "at0.f", "fifth": "at4.f", "last": "at)" +
         std::to_string(masses - 1) + R"(.f" }, "scenes": { "main": { "stop": )" + stop + R"(, "samples": 61 } } })";
}

/// A line of resistors and capacitors of 1 / @p sections.
std::string line(std::size_t sections) {
  std::string elements = R"("source": { "kind": "Se", "effort": 1 })", bonds, before = "source";
  const std::string part = "1/" + std::to_string(sections);
  for (std::size_t i = 0; i < sections; ++i) {
    const std::string k = std::to_string(i);
    elements += R"(, "loop)" + k + R"(": { "kind": "1" }, "node)" + k + R"(": { "kind": "0" }, "R)" + k +
                R"(": { "kind": "R", "resistance": ")" + part + R"(" }, "C)" + k +
                R"(": { "kind": "C", "capacitance": ")" + part + "\" }";
    for (const auto& [from, to] : {std::pair{before, "loop" + k}, std::pair{"loop" + k, "R" + k},
                                   std::pair{"loop" + k, "node" + k}, std::pair{"node" + k, "C" + k}})
      bonds += (bonds.empty() ? R"({ "from": ")" : R"(, { "from": ")") + from + R"(", "to": ")" + to + "\" }";
    before = "node" + k;
  }
  return R"({ "bgsim": 1, "name": "line", "elements": { )" + elements + R"( }, "bonds": [ )" + bonds +
         R"( ], "outputs": { "end": ")" + before + R"(.e" }, "scenes": { "main": { "stop": 1, "samples": 21 } } })";
}

/// Largest difference of any output of both, at any time.
double apart(const RunResult& a, const RunResult& b) {
  double largest = 0.0;
  for (std::size_t c = 0; c < a.trace.columns.size(); ++c)
    for (std::size_t i = 0; i < a.trace.times.size(); ++i)
      largest = std::max(largest, std::abs(a.trace.columns[c][i] - b.trace.columns[c][i]));
  return largest;
}

}  // namespace

TEST_CASE("many states that ring are integrated by the explicit method, those that decay fast by BDF") {
  const std::string waves = chain(60, "q + q^3", "0.01*f", "40");
  const RunResult result = run_text(waves, with_relative(1e-7));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.method == "Dormand-Prince 5(4)");
  CHECK_THAT(result.report.method_reason, Contains("not stiff"));
  CHECK(result.report.factorizations == 0);
  const RunResult exact = run_text(waves, with_method(Method::bdf, 1e-11));
  // Velocities of up to 0.5: a hundred tolerances, of waves that add their errors up.
  CHECK(apart(result, exact) < 1e-5);
  CHECK(result.report.steps < run_text(waves, with_method(Method::bdf, 1e-7)).report.steps / 2);

  const RunResult heat = run_text(line(100));
  REQUIRE(heat.stop == StopReason::completed);
  CHECK_THAT(heat.report.method, Contains("BDF"));
  CHECK(heat.report.method_reason == "state equations without loops; many states");
  CHECK(heat.report.steps < 1000);  // 40,000 of the explicit method: four a time constant of 1e-4
}

TEST_CASE("a run of many states goes on with BDF where they become stiff, and says when") {
  // From t = 5 on friction grows to 1e5: rates of 1e5 for another 15, half a million steps of the explicit method.
  const std::string model = chain(60, "q + q^3", "f*(0.01 + 1e4*max(0, t - 5))", "20");
  const RunResult result = run_text(model);
  REQUIRE(result.stop == StopReason::completed);
  CHECK_THAT(result.report.method, Contains("BDF"));
  CHECK_THAT(result.report.method_reason, Contains("many states, and stiff from t = "));
  CHECK(result.report.steps < 4000);
  CHECK(apart(result, run_text(model, with_method(Method::bdf, 1e-10))) < 1e-4);  // a hundred tolerances
}

TEST_CASE("a run of many states goes on with the explicit method where they are stiff no more") {
  const std::string model = chain(60, "q + q^3", "f*(0.01 + if(t < 1, 1e4, 0))", "60");
  const RunResult result = run_text(model);
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.method == "Dormand-Prince 5(4)");
  CHECK_THAT(result.report.method_reason, Contains("not stiff from t = "));
  CHECK(apart(result, run_text(model, with_method(Method::bdf, 1e-10))) < 1e-4);  // a hundred tolerances
}

TEST_CASE("the explicit method stops at the changes of conditions") {
  // Springs that break: no force beyond 0.3.
  const std::string model = chain(60, "if(q < 0.3, q, 0)", "0.01*f", "4");
  const RunResult result = run_text(model, with_relative(1e-7));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.method == "Dormand-Prince 5(4)");
  CHECK(result.report.state_events > 0);
  CHECK(apart(result, run_text(model, with_method(Method::bdf, 1e-10))) < 1e-5);  // a hundred tolerances
}

TEST_CASE("a run of many states that has changed its method is continued from a snapshot bit for bit") {
  const CompiledModel model = compile_text(chain(60, "q + q^3", "f*(0.01 + if(t < 1, 1e4, 0))", "60"));
  std::vector<std::string> taken;
  SimulateOptions options = untimed();
  options.snapshot_steps = 100;
  options.snapshot = [&taken](double /*t*/, const std::string& text) { taken.push_back(text); };
  const RunResult whole = model.run(options);
  REQUIRE(whole.stop == StopReason::completed);
  REQUIRE(taken.size() > 2);
  for (const std::size_t from : {std::size_t{0}, taken.size() / 2, taken.size() - 2}) {
    SimulateOptions again = untimed();
    again.snapshot_steps = 100;
    again.snapshot = [](double /*t*/, const std::string& /*text*/) {};
    again.resume = taken[from];
    const RunResult rest = model.run(again);
    REQUIRE(rest.stop == StopReason::completed);
    CHECK(rest.report.method == whole.report.method);
    CHECK(rest.report.method_reason == whole.report.method_reason);
    const std::size_t rows = rest.trace.times.size(), before = whole.trace.times.size() - rows;
    for (std::size_t c = 0; c < whole.trace.columns.size(); ++c)
      for (std::size_t i = 0; i < rows; ++i) CHECK(rest.trace.columns[c][i] == whole.trace.columns[c][before + i]);
  }
}
