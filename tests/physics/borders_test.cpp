// Conditions that make no jump before a store that depends on them, and conditions that do.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// C straight across a source of any effort: its flow is capacitance times the effort's derivative.
std::string across(const std::string& effort, double stop = 4.0, const std::string& elements = "") {
  return R"({"bgsim": 1, "name": "across", "parameters": {"low": 1, "high": 2}, "elements": {
    "source": {"kind": "MSe", "effort": ")" +
         effort + R"("}, "c": {"kind": "C", "capacitance": 2}, "fill": {"kind": "Sf", "flow": 1},
    "tank": {"kind": "C", "capacitance": 1, "initial": {"q": 0.25}})" +
         elements + R"(}, "bonds": [{"from": "source", "to": "c"}, {"from": "fill", "to": "tank"}],
    "outputs": {"f": "c.f", "q": "c.q", "level": "tank.q"},
    "scenes": {"run": {"stop": )" +
         std::to_string(stop) + R"(, "samples": 9}}})";
}

std::string failure(const std::string& text) {
  try {
    const RunResult run = run_text(text);
    return run.failure ? "run: " + run.failure->code + " " + run.failure->situation : "completed";
  } catch (const ModelError& error) {
    return error.diagnostics.front().code + " " + error.diagnostics.front().situation;
  }
}

}  // namespace

TEST_CASE("A condition that is continuous at its border may stand before a store that depends on it") {
  // The derivative is known by hand between the borders, which no sample meets.
  const std::vector<double> triangle{-2, -2, 2, 2, -2, -2, 2, 2, -2};
  CHECK(column(run_text(across("abs(t - 2*floor(t/2) - 1)", 4.5)), "f") == triangle);
  const RunResult ramp = run_text(across("if(t < 1, t, 2*t - 1)"));
  CHECK(column(ramp, "f") == std::vector<double>{2, 2, 4, 4, 4, 4, 4, 4, 4});
  CHECK(last(run_text(across("mod(t, 1)*(1 - mod(t, 1))", 0.5)), "q") == Approx(0.5).epsilon(1e-14));
  // of a state: the tank's level passes 1 at t = 0.75
  const RunResult of_state = run_text(across("if(tank.q < 1, tank.q, tank.q^2)"));
  REQUIRE(of_state.stop == StopReason::completed);
  CHECK(last(of_state, "f") == Approx(4.0 * 4.25).epsilon(1e-6));
  CHECK(column(of_state, "f")[1] == Approx(2.0).epsilon(1e-6));
}

TEST_CASE("A condition that jumps before a store is refused, at the latest where it is met") {
  CHECK(failure(across("if(t < 1, low, high)")) ==
        "BG402 the time derivative of if(t < 1, low, high) is needed, but it jumps");
  CHECK(failure(across("floor(tank.q)")).substr(0, 5) == "BG402");
  CHECK(failure(across("if(t < 1, t, if(t < 2, 1, high))")).substr(0, 5) == "BG402");
  // Continuous with the model's own parameters: only the run can tell.
  const std::string text = across("if(t < 1, low, high - 1)");
  CHECK(failure(text) == "completed");
  const RunResult run = run_text(text, with_parameters({"high=3"}));
  REQUIRE(run.failure);
  CHECK(run.failure->code == "BG402");
  CHECK(run.failure->situation ==
        "the time derivative of if(t < 1, low, high - 1) is needed, but it jumps: from 1 to 2 at t = 1");
}

TEST_CASE("A store whose law jumps is refused before what determines it, also where the law has to be solved") {
  const auto across_law = [](const std::string& more) {
    return R"({"bgsim": 1, "name": "law", "elements": {"s": {"kind": "Se", "effort": "t"},
    "c": {"kind": "MC", "law": "e = q + q^3 + )" +
           more + R"("}}, "bonds": [{"from": "s", "to": "c"}], "outputs": {"f": "c.f", "q": "c.q"},
    "scenes": {"run": {"stop": 2, "samples": 5}}})";
  };
  CHECK(failure(across_law("if(t < 1, 0, 1)")).substr(0, 11) == "run: BG402 ");
  // t = q + q^3 + t - 1 from t = 1: q stays where q + q^3 = 1.
  const RunResult bent = run_text(across_law("if(t < 1, 0, t - 1)"));
  REQUIRE(bent.stop == StopReason::completed);
  CHECK(last(bent, "q") == Approx(0.6823278038280193).epsilon(1e-14));
  CHECK(column(bent, "f")[1] == Approx(0.649791102672498).epsilon(1e-12));
  CHECK(last(bent, "f") == 0.0);
}
