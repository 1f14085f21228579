// States that shrink and grow again: what is small now decides what is large later.
#include <catch2/catch.hpp>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// Stores of capacitance 1, each fed by a flow that the others' contents modulate.
std::string populations(const std::vector<std::pair<std::string, std::string>>& rates,
                        const std::vector<std::string>& initial, const std::string& scene) {
  std::string elements, bonds, outputs;
  for (std::size_t i = 0; i < rates.size(); ++i) {
    const auto& [name, rate] = rates[i];
    const std::string comma = i == 0 ? "" : ", ";
    elements += comma + "\"in_" + name + R"x(": { "kind": "MSf", "flow": ")x" + rate + R"x(" }, "n_)x" + name +
                R"x(": { "kind": "0" }, ")x" + name + R"x(": { "kind": "C", "capacitance": 1, "initial": { "q": )x" +
                initial[i] + " } }";
    bonds += comma + R"x({ "from": "in_)x" + name + R"x(", "to": "n_)x" + name + R"x(" }, { "from": "n_)x" + name +
             R"x(", "to": ")x" + name + "\" }";
    outputs += comma + "\"" + name + "\": \"" + name + ".q\"";
  }
  return R"x({ "bgsim": 1, "name": "populations", "elements": { )x" + elements + R"x( }, "bonds": [ )x" + bonds +
         R"x( ], "outputs": { )x" + outputs + R"x( }, "scenes": { "main": { )x" + scene + " } } }";
}

}  // namespace

TEST_CASE("a state that falls to 1e-7 and rises again comes back to where it was, by all methods") {
  // y' = 32 (t - 1) y: y = exp(16 ((t - 1)^2 - 1)).
  const std::string text = populations({{"y", "32*(t - 1)*y.q"}}, {"1"}, R"x("stop": 2, "samples": 21)x");
  for (const Method method : {Method::bdf, Method::adams, Method::erk5, Method::dirk4, Method::radau, Method::ida}) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(text, with_method(method, 1e-6));
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
      const double t = run.trace.times[k], exact = std::exp(16.0 * ((t - 1.0) * (t - 1.0) - 1.0));
      // Some hundred steps with errors of 1e-6 of the present value, which the equation carries along unchanged.
      CHECK(std::abs(run.trace["y"][k] - exact) < 2e-3 * exact);
    }
  }
}

TEST_CASE("growth from 1e-12 to a limit follows the logistic function") {
  const std::string text = populations({{"y", "y.q*(1 - y.q)/0.029"}}, {"1e-12"}, R"x("stop": 1, "samples": 21)x");
  const RunResult run = run_text(text, with_method(Method::bdf, 1e-6));
  REQUIRE(run.stop == StopReason::completed);
  for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
    const double exact = 1.0 / (1.0 + (1e12 - 1.0) * std::exp(-run.trace.times[k] / 0.029));
    CHECK(std::abs(run.trace["y"][k] - exact) < 1e-3);  // a relative error of some hundred 1e-6, times y (1 - y) <= 1/4
  }
}

TEST_CASE("prey and predators that fall to 1e-3 keep their cycle") {
  // Lotka and Volterra: x - log x + y - log y stays.
  const std::string text =
      populations({{"x", "x.q*(1 - y.q)"}, {"y", "y.q*(x.q - 1)"}}, {"5", "5"}, R"x("stop": 60, "samples": 121)x");
  const auto first_integral = [](double x, double y) { return x - std::log(x) + y - std::log(y); };
  for (const Method method : {Method::bdf, Method::erk5}) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(text, with_method(method, 1e-6));
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t k = 0; k < run.trace.times.size(); ++k) {
      REQUIRE(run.trace["x"][k] > 0.0);
      REQUIRE(run.trace["y"][k] > 0.0);
      // A thousand steps, each with 1e-6 of the states, of a first integral of 6.8.
      CHECK(std::abs(first_integral(run.trace["x"][k], run.trace["y"][k]) - first_integral(5.0, 5.0)) < 2e-2);
    }
  }
}

TEST_CASE("an oscillation that is damped and then driven comes back by its own factor") {
  // x'' + c x' + 100 x = 0 with c = 10 up to t = 3, then -10: e^-15 and back.
  const std::string text = populations({{"x", "v.q"}, {"v", "-100*x.q - if(t < 3, 10, -10)*v.q"}}, {"1", "0"},
                                       R"x("stop": 6, "samples": 7)x");
  const RunResult run = run_text(text, with_method(Method::bdf, 1e-6));
  REQUIRE(run.stop == StopReason::completed);
  // The exact solution, by the roots 5 (-1 +- i sqrt 3) and their negatives.
  CHECK(std::abs(last(run, "x") - -0.49989100991400315) < 5e-3);
}

TEST_CASE("a state that only shrinks, or that others feed, costs what it cost") {
  // Decay by a constant rate, by a power, and an empty tank: proved to shrink, or linear.
  const auto steps = [](const char* rate, const char* q) {
    const RunResult run =
        run_text(populations({{"y", rate}}, {q}, R"x("stop": 100, "samples": 2)x"), with_method(Method::bdf, 1e-6));
    REQUIRE(run.stop == StopReason::completed);
    return run.report.steps;
  };
  // An absolute tolerance of 1e-6 of the start takes about 100 steps for each; one relative to what is left of e^-100
  // would take some 500.
  CHECK(steps("-y.q", "1") < 200);
  CHECK(steps("-y.q - y.q^3", "1") < 200);
  CHECK(steps("1 - y.q", "0") < 200);
}

TEST_CASE("a tank behind a valve that another state moves runs empty, by laws that end there in finite time") {
  // q' = -v sqrt(q) with v = 0.5 + 0.01 sin(t): empty when the integral of v is 2, near t = 3.97.
  const auto emptied = [](const char* law) {
    return run_text(populations({{"v", "0.01*cos(t)"}, {"q", law}}, {"0.5", "1"}, R"x("stop": 100, "samples": 101)x"),
                    with_method(Method::bdf, 1e-6));
  };
  const RunResult run = emptied("-v.q*if(q.q > 0, sqrt(q.q), 0)");
  REQUIRE(run.stop == StopReason::completed);
  CHECK(run.report.steps < 2000);
  for (std::size_t k = 5; k < run.trace.times.size(); ++k)
    CHECK(std::abs(run.trace["q"][k]) < 1e-3);  // the root of the tolerance, 1e-6: the law's slope at zero is infinite
  // With a root on both sides of zero the run has to come to its end.
  CHECK(emptied("-v.q*sign(q.q)*sqrt(abs(q.q))").stop == StopReason::completed);
}
