// Laws of resistors that are equations: "0 = ...".
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A resistor at a source.
std::string at_source(const std::string& source, const std::string& law, const std::string& parameters = "") {
  return R"x({ "bgsim": 1, "name": "one_port", "parameters": {)x" + parameters + R"x(}, "elements": {
               "s": )x" +
         source + R"x(, "j": { "kind": "1" }, "r": { "kind": "R", "law": ")x" + law + R"x(" } },
               "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" } ],
               "outputs": { "e": "r.e", "f": "r.f" }, "scenes": { "run": { "stop": 3, "samples": 31 } } })x";
}

std::string effort(const std::string& value) { return R"x({ "kind": "Se", "effort": ")x" + value + "\" }"; }
std::string flow(const std::string& value) { return R"x({ "kind": "Sf", "flow": ")x" + value + "\" }"; }

/// Zero of an increasing function.
double bisect(const std::function<double(double)>& f, double low, double high) {
  for (int i = 0; i < 200; ++i) {
    const double middle = low + (high - low) / 2;
    (f(middle) > 0.0 ? high : low) = middle;
  }
  return low + (high - low) / 2;
}

}  // namespace

TEST_CASE("an equation of e and f is solved for either") {
  struct Row {
    std::string law, e, f;  ///< manufactured: e and f over time that satisfy the law
    std::function<double(double)> f_of_e;
  };
  const std::vector<Row> rows{
      {"0 = f - e - e^3", "cos(t)", "cos(t) + cos(t)^3", [](double e) { return e + e * e * e; }},
      {"0 = e + e^5 - 3*f", "cos(t)", "(cos(t) + cos(t)^5)/3", [](double e) { return (e + std::pow(e, 5)) / 3; }},
      {"0 = 2*e - f + 1", "cos(t)", "2*cos(t) + 1", [](double e) { return 2 * e + 1; }},
      {"0 = tanh(e) + e - f", "5*cos(t)", "tanh(5*cos(t)) + 5*cos(t)", [](double e) { return std::tanh(e) + e; }},
      {"0 = f - exp(e) - e", "5*cos(t)", "exp(5*cos(t)) + 5*cos(t)", [](double e) { return std::exp(e) + e; }},
      {"0 = f - e*abs(e) - e", "cos(t)", "cos(t)*abs(cos(t)) + cos(t)", [](double e) { return e * std::abs(e) + e; }},
      {"0 = f - if(e > 0, 2*e, e)", "cos(t)", "cos(t) + max(cos(t), 0)", [](double e) { return e > 0 ? 2 * e : e; }},
      {"0 = e^3 - f", "cos(t)", "cos(t)^3", [](double e) { return e * e * e; }},
  };
  for (const Row& row : rows)
    for (const std::string& source : {effort(row.e), flow(row.f)}) {
      INFO(row.law << " at " << source);
      const RunResult run = run_text(at_source(source, row.law));
      REQUIRE(run.stop == StopReason::completed);
      for (std::size_t k = 0; k < run.trace.times.size(); ++k)
        // Newton's iteration ends at 1e-13.
        CHECK(std::abs(column(run, "f")[k] - row.f_of_e(column(run, "e")[k])) <
              1e-12 * largest_magnitude(column(run, "f")));
    }
}

TEST_CASE("the friction of Colebrook gives the pressure drop of a flow, and the flow of a pressure drop") {
  const std::string parameters = R"x("K": 3e4, "c": 1e7, "roughness": 1e-4)x";
  const std::string law = "0 = f/sqrt(e/K) + 2*log10(roughness/3.7 + 2.51/(c*sqrt(e/K)))";
  const RunResult of_flow = run_text(at_source(flow("0.02 + 0.01*sin(t)"), law, parameters));
  const RunResult of_drop = run_text(at_source(effort("0.2 + 0.1*sin(t)"), law, parameters));
  for (const RunResult* const run : {&of_flow, &of_drop}) {
    REQUIRE(run->stop == StopReason::completed);
    for (std::size_t k = 0; k < run->trace.times.size(); ++k) {
      const double f = column(*run, "f")[k];
      // Colebrook's own form, by its friction factor.
      const double lambda = bisect(
          [f](double x) { return -1 / std::sqrt(x) - 2 * std::log10(1e-4 / 3.7 + 2.51 / (1e7 * f * std::sqrt(x))); },
          1e-3, 1.0);
      // Rounding of the logarithm, magnified twentyfold by the slope.
      CHECK(column(*run, "e")[k] == Approx(lambda * 3e4 * f * f).epsilon(1e-11));
    }
  }
}

TEST_CASE("a diode with its series resistance is one equation, solved for current or voltage") {
  const std::string law = "0 = f - 1e-12*(exp((e - 2*f)/0.026) - 1)";
  const RunResult of_voltage = run_text(at_source(effort("5*sin(4*t)"), law));
  const RunResult of_current = run_text(at_source(flow("exp(3*sin(2*t)) - 0.5e-12"), law));
  for (const RunResult* const run : {&of_voltage, &of_current}) {
    REQUIRE(run->stop == StopReason::completed);
    for (std::size_t k = 0; k < run->trace.times.size(); ++k) {
      const double e = column(*run, "e")[k];
      const double f =
          bisect([e](double x) { return x - 1e-12 * std::expm1(std::min((e - 2 * x) / 0.026, 600.0)); }, -2e-12, 30.0);
      CHECK(column(*run, "f")[k] == Approx(f).epsilon(1e-9).margin(1e-22));
    }
  }
}

TEST_CASE("several solutions of an equation are reported, as those of any loop") {
  const RunResult run = run_text(at_source(flow("0.01*t"), "0 = e^3 - e - f"));
  const bool reported = std::any_of(run.report.notes.begin(), run.report.notes.end(), [](const std::string& note) {
    return note.find("other solutions exist") != std::string::npos;
  });
  CHECK(reported);
}

TEST_CASE("no pulse of a loop's variable is stepped over between two points at which it is nothing") {
  // A rectifier whose diode is an implicit law with its own resistance. The third pulse of its current lay within one
  // step of BDF: 4.6 % of the range.
  const std::string text = R"x({"bgsim": 1, "name": "rectifier", "elements": {"n": {"kind": "0"}, "j": {"kind": "1"},
      "u": {"kind": "Se", "effort": "8.19709*sin(219.091*t)"}, "c": {"kind": "C", "capacitance": 8.24096e-4},
      "d": {"kind": "R", "law": "0 = f - 1e-12*(exp((e - 1.82862*f)/0.026) - 1)"}, "load": {"kind": "R", "resistance": 4588.62}},
    "bonds": [{"from": "u", "to": "j"}, {"from": "j", "to": "d"}, {"from": "j", "to": "n"}, {"from": "n", "to": "c"},
              {"from": "n", "to": "load"}],
    "outputs": {"v": "c.e", "i": "d.f"}, "scenes": {"s": {"stop": 0.0912863, "samples": 101}}})x";
  const RunResult exact = run_text(text, with_method(Method::dirk5, 1e-9));
  for (const Method method : {Method::automatic, Method::bdf, Method::adams, Method::dirk4}) {
    INFO(method_name(method));
    const RunResult run = run_text(text, with_method(method, 1e-6));
    REQUIRE(run.stop == StopReason::completed);
    // A hundred tolerances of ranges of 7.5 and 1.1.
    CHECK(largest_difference(column(exact, "v"), column(run, "v")) < 7.5e-4);
    CHECK(largest_difference(column(exact, "i"), column(run, "i")) < 1.1e-4);
  }
}

TEST_CASE("an equation without a solution ends the run") {
  const RunResult run = run_text(at_source(flow("-1 - t"), "0 = e^2 + e^4 - f"));
  CHECK(run.stop != StopReason::completed);
}
