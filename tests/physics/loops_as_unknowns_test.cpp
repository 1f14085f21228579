// Radau IIA and Rodas5P with the loops' variables as unknowns beside the states: M y' = f(t, y), with M singular.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "support/circuit.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

/// A diode between two resistors charges a capacitor: the loop's unknown is an effort under an exponential.
std::string charged() {
  return circuit({{"s", "Se", "a", "0", R"x("effort": "3*sin(20*t)")x"},
                  {"rs", "R", "a", "b", resistor("100")},
                  {"d", "R", "b", "c", R"x("law": "f = 1e-6*(exp(e/0.05) - 1)")x"},
                  {"r", "R", "c", "0", resistor("2000")},
                  {"k", "C", "c", "0", R"("capacitance": 1e-4)"}},
                 R"("u": "k.e", "i": "d.f", "ud": "d.e")", R"("stop": 1, "samples": 201)");
}

/// A capacitor empties through a resistor and a law of the third degree in series.
std::string cubic() {
  return circuit({{"s", "Sf", "0", "a", R"x("flow": "1 + sin(3*t)")x"},
                  {"k", "C", "a", "0", R"("capacitance": 0.5)"},
                  {"r1", "R", "a", "b", resistor("0.3")},
                  {"r2", "R", "b", "0", R"x("law": "f = e + 4*e^3")x"}},
                 R"("u": "k.e", "i": "r1.f")", R"("stop": 5, "samples": 101)");
}

}  // namespace

TEST_CASE("Radau IIA and Rodas5P find a loop's variables in a step's own iteration") {
  const std::string text = GENERATE(charged(), cubic());
  // The loops are solved inside the rates here, by safeguards and to rounding.
  const RunResult exact = run_text(text, with_method(Method::dirk5, 1e-11));
  REQUIRE(exact.stop == StopReason::completed);
  for (const Method method : {Method::radau, Method::radau9, Method::radau13, Method::rodas5p, Method::automatic})
    for (const double relative : {1e-5, 1e-7, 1e-9}) {
      const RunResult result = run_text(text, with_method(method, relative));
      INFO(result.report.method << " at " << relative);
      REQUIRE(result.stop == StopReason::completed);
      CHECK_THAT(result.report.method_reason,
                 method == Method::automatic ? Contains("are unknowns of the integrator") : Contains("asked for"));
      // A hundred tolerances: that of u in the diode's exponential is sixty of the loop's own (3 V over 0.05 V), and
      // the reference has a hundred of its own.
      CHECK(largest_difference(exact, result) < 100.0 * relative + 1e-9);
      // Every output is solved to rounding for the states of its time: the loop's variable is no polynomial there.
      if (text != charged()) continue;
      for (std::size_t row = 0; row < result.trace.times.size(); ++row) {
        const double ud = column(result, "ud")[row], i = column(result, "i")[row], u = column(result, "u")[row];
        CHECK(std::abs(3.0 * std::sin(20.0 * result.trace.times[row]) - 100.0 * i - ud - u) < 1e-12);
        CHECK(std::abs(i - 1e-6 * (std::exp(ud / 0.05) - 1.0)) < 1e-12);
      }
    }
}

TEST_CASE("the error of a run with loops as unknowns falls with its tolerance") {
  const RunResult exact = run_text(cubic(), with_method(Method::dirk5, 1e-12));
  double before = 0.0;
  for (const double relative : {1e-3, 1e-5, 1e-7, 1e-9}) {
    const RunResult result = run_text(cubic(), with_method(Method::radau9, relative));
    const double error = largest_difference(exact, result);
    INFO(relative << ": " << error);
    if (before > 0.0) CHECK(error < before / 3.0);  // of a hundred that the tolerance falls by: it is far below that
    before = error;
  }
}

TEST_CASE("a network whose loops cannot be eliminated is run by Radau IIA and Rodas5P", "[long]") {
  // A grid of turbulent pipes between three tanks, of which nothing but the states can be solved for by themselves.
  std::vector<Part> parts{{"s", "Se", "n0_0", "0", R"x("effort": "10*sin(3*t)")x"},
                          {"out", "R", "n8_8", "0", resistor("1")}};
  const auto node = [](int i, int j) { return "n" + std::to_string(i) + "_" + std::to_string(j); };
  const std::string law = R"x("law": "e = 2*f*abs(f) + 0.1*f")x";
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 9; ++j) {
      const std::string at = std::to_string(i) + std::to_string(j);
      if (i < 8) parts.push_back({"a" + at, "R", node(i, j), node(i + 1, j), law});
      if (j < 8) parts.push_back({"b" + at, "R", node(i, j), node(i, j + 1), law});
    }
  for (int k = 0; k < 3; ++k)
    parts.push_back({"c" + std::to_string(k), "C", node(k + 2, 3), "0",
                     R"("capacitance": 0.5, "initial": {"q": )" + std::to_string(k + 1) + "}"});
  const std::string text = circuit(parts, R"("u": "c0.e", "q": "c2.q", "f": "out.f")", R"("stop": 1, "samples": 21)");
  const RunResult exact = run_text(text, with_method(Method::ida, 1e-9));
  REQUIRE(exact.stop == StopReason::completed);
  for (const Method method : {Method::radau, Method::radau9, Method::rodas5p}) {
    const RunResult result = run_text(text, with_method(method, 1e-7));
    INFO(result.report.method);
    REQUIRE(result.stop == StopReason::completed);
    CHECK_THAT(result.report.method, Contains("sparse"));
    // A thousand tolerances: between turbulent pipes a flow is the root of what the potentials are wrong by.
    CHECK(largest_difference(exact, result) < 1e-4);
  }
  const RunResult refused = run_text(text, with_method(Method::dirk5));
  REQUIRE(refused.failure);
  CHECK(refused.failure->code == "BG610");
}
