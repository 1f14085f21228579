/// Systems at rest, or nearly so, whose rates are small differences of large terms: a tolerance relative to what is
/// left is below the rounding of the rates. A run that follows rounding needs hundreds of thousands of steps, or never
/// ends.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// 5 V over 300 ohm, a capacitor beside 4 ohm, and one that leaks: both charged as they are without the leak.
std::string circuit(const std::string& leak) {
  return R"({ "bgsim": 1, "name": "leak", "elements": {
    "S": { "kind": "Se", "effort": 5 }, "s": { "kind": "1" }, "R2": { "kind": "R", "resistance": 300 },
    "y1": { "kind": "0" }, "p1": { "kind": "1" }, "C1": { "kind": "C", "capacitance": 6e-5 }, "r": { "kind": "1" },
    "R1": { "kind": "R", "resistance": 4 }, "y5": { "kind": "0" },
    "C7": { "kind": "C", "capacitance": 6e-5, "initial": { "q": 3e-4 } },
    "leak": { "kind": "R", "resistance": )" +
         leak + R"( } },
    "bonds": [ { "from": "S", "to": "s" }, { "from": "s", "to": "R2" }, { "from": "s", "to": "y1" },
      { "from": "y1", "to": "p1" }, { "from": "p1", "to": "C1" }, { "from": "p1", "to": "y5" },
      { "from": "y1", "to": "r" }, { "from": "r", "to": "R1" }, { "from": "r", "to": "y5" },
      { "from": "y5", "to": "C7" }, { "from": "y5", "to": "leak" } ],
    "outputs": { "v1": "C1.e", "v7": "C7.e" }, "scenes": { "run": { "stop": 3, "samples": 31 } } })";
}

const std::vector<Method> kMethods{Method::automatic, Method::adams, Method::ida,    Method::erk4,
                                   Method::dirk4,     Method::radau, Method::rodas5p};
const std::vector<double> kTolerances{1e-4, 1e-6, 1e-8, 1e-10};

}  // namespace

TEST_CASE("circuits at rest behind leaks end within some hundred steps", "[long]") {
  for (const double leak : {1e9, 1e12, 1e15, 1e18})
    for (const Method method : kMethods)
      for (const double relative : kTolerances) {
        CAPTURE(leak, facts_of(method).name, relative);
        const RunResult result = run_text(circuit(std::to_string(leak)), with_method(method, relative));
        REQUIRE(result.stop == StopReason::completed);
        // Explicit steps are limited to 2.8 time constants of C1 beside 4 ohm, 0.24 ms: 4500 in 3 s.
        CHECK(result.report.steps < (method == Method::erk4 ? 9000 : 1000));
        const std::vector<double> v7 = column(result, "v7"), v1 = column(result, "v1");
        // What flows through the leak flows through 300 and 4 ohm. To the state's tolerance, and ten roundings.
        const double flow = 5.0 / (leak + 304.0);
        CHECK(v7.back() == Approx(5.0 - 304.0 * flow).epsilon(0.0).margin(5.0 * relative + 1e-14));
        // The current through 4 ohm is a difference of 5 V: twenty roundings of that are C1's least tolerance, 4e-14 V.
        CHECK(v1.back() == Approx(4.0 * flow).epsilon(10.0 * relative).margin(4e-14));
      }
}

TEST_CASE("what rounding makes of rates is bounded and no more than terms and slopes explain") {
  const CompiledModel compiled = compile_text(circuit("1e12"));
  Evaluator evaluator(compiled.program, compiled.inputs.parameters);
  Branch branch = first_branch(compiled.program);
  const std::vector<double> x{0.0, 3e-4};
  std::vector<double> entries(compiled.program.jacobian_pattern.row.size());
  std::vector<double> rounding;
  REQUIRE(evaluator.jacobian(0.0, x.data(), branch, entries.data(), rounding));
  REQUIRE(rounding.size() == 2);
  // The rates are differences of 5 V over 300 ohm and over 4 ohm: a few units in the last place of these.
  constexpr double kUnit = 1.1e-16;
  for (const double rate : rounding) {
    CHECK(rate > 0.5 * kUnit * 5.0 / 300.0);
    CHECK(rate < 10.0 * kUnit * 5.0 / 4.0);
  }
}
