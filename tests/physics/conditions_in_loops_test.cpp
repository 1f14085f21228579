// Conditions on the variables of loops where a run starts: which side holds is known with the loop's solution only.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "bgsim/text.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// E in series with two orifices, one drawn against the direction of the source, a resistance and a C that is empty.
RunResult orifices(const std::string& first, const std::string& second, double effort, double resistance) {
  return run_text(R"({"bgsim": 1, "name": "orifices", "elements": {"s": {"kind": "Se", "effort": )" +
                  number_text(effort) + R"(}, "j": {"kind": "1"}, "a": {"kind": "R", "law": ")" + first +
                  R"("}, "b": {"kind": "R", "law": ")" + second + R"("}, "r": {"kind": "R", "resistance": )" +
                  number_text(resistance) + R"(}, "c": {"kind": "C", "capacitance": 1}},
    "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "a"}, {"from": "b", "to": "j"}, {"from": "j", "to": "r"},
      {"from": "j", "to": "c"}], "outputs": {"f": "r.f"}, "scenes": {"s": {"stop": 1e-3, "samples": 2}}})");
}

}  // namespace

TEST_CASE("a run starts on the right side of conditions in a loop") {
  // No side but the right one has a solution: sqrt(e) ends at 0. 2 f^2 + r f = E.
  const std::vector<std::string> laws{"f = if(e > 0, sqrt(e), -sqrt(-e))", "f = if(e < 0, -sqrt(-e), sqrt(e))",
                                      "f = if(e >= 0, e^0.5, -(-e)^0.5)"};
  for (const std::string& first : laws)
    for (const std::string& second : laws)
      for (const double effort : {5.0, -5.0, 5e-5, -5e5})
        for (const double r : {1e-6, 1.0, 1e6}) {
          INFO(first << ", " << second << ", E = " << effort << ", r = " << r);
          const RunResult result = orifices(first, second, effort, r);
          REQUIRE(result.stop == StopReason::completed);
          const double size = std::abs(effort), f = 2.0 * size / (r + std::sqrt(r * r + 8.0 * size));
          // The loop's own accuracy.
          CHECK(result.trace["f"].front() == Approx(std::copysign(f, effort)).epsilon(1e-9));
        }
}

TEST_CASE("many resistors with conditions in series have the flow that their efforts add up to") {
  // By flow: what the effort of each is, from f(e) by hand. Some are drawn against the direction of the source.
  struct Law {
    const char* text;
    double (*effort)(double);
  };
  const std::vector<Law> laws{
      {"f = if(e > 0, sqrt(e), -sqrt(-e))", [](double f) { return f * std::abs(f); }},
      {"f = if(e < 0, -log(1 - e), log(1 + e))", [](double f) { return std::copysign(std::expm1(std::abs(f)), f); }},
      {"f = if(e > 1, 1 + sqrt(e - 1), e)", [](double f) { return f > 1.0 ? 1.0 + (f - 1.0) * (f - 1.0) : f; }},
      {"f = if(e > 0, 10*e, 1e-3*e)", [](double f) { return f > 0.0 ? f / 10.0 : f / 1e-3; }},
      {"f = if(e < -2, -2 - (-2 - e)^0.6, e)",
       [](double f) { return f < -2.0 ? -2.0 - std::pow(-2.0 - f, 1.0 / 0.6) : f; }}};
  std::mt19937 random(7);
  for (int seed = 0; seed < 60; ++seed) {
    const double effort =
        (seed % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, std::uniform_real_distribution(-2.0, 3.0)(random));
    std::string elements, bonds;
    std::vector<std::pair<Law, double>> used;
    for (int i = 0; i < 2 + seed % 5; ++i) {
      const Law law = laws[random() % laws.size()];
      const bool against = random() % 2 == 0;
      used.emplace_back(law, against ? -1.0 : 1.0);
      const std::string name = "r" + std::to_string(i);
      elements += R"(, ")" + name + R"(": {"kind": "R", "law": ")" + law.text + R"("})";
      bonds += R"(, {"from": ")" + (against ? name : "j") + R"(", "to": ")" + (against ? "j" : name) + R"("})";
    }
    const std::string model = R"({"bgsim": 1, "name": "series", "elements": {"s": {"kind": "Se", "effort": )" +
                              number_text(effort) + R"(}, "j": {"kind": "1"}, "c": {"kind": "C", "capacitance": 1e6})" +
                              elements + R"(}, "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "c"})" + bonds +
                              R"(], "outputs": {"f": "s.f"}, "scenes": {"s": {"stop": 1e-6, "samples": 2}}})";
    INFO(model);
    double low = -1e6, high = 1e6;
    for (int k = 0; k < 200; ++k) {
      const double middle = low + (high - low) / 2.0;
      double sum = 0.0;
      for (const auto& [law, direction] : used) sum += direction * law.effort(direction * middle);
      (sum < effort ? low : high) = middle;
    }
    const RunResult result = run_text(model);
    REQUIRE(result.stop == StopReason::completed);
    CHECK(result.trace["f"].front() == Approx(low).epsilon(1e-9));  // the loop's own accuracy
  }
}

TEST_CASE("ladders of orifices start, however many, as they do by the same law without a condition") {
  // From starts that are all alike the efforts between are 0, where the law has no slope. A hundred rungs are a loop
  // whose variables are unknowns of the integrator.
  const auto ladder = [](const std::string& law, int rungs, bool gyrator) {
    std::string elements = R"("s": {"kind": "Se", "effort": 20}, "j0": {"kind": "1"})",
                bonds = R"({"from": "s", "to": "j0"})";
    for (int i = 0; i < rungs; ++i) {
      const std::string k = std::to_string(i), next = std::to_string(i + 1);
      elements += R"(, "a)" + k + R"(": {"kind": "R", "law": ")" + law + R"("}, "n)" + k + R"(": {"kind": "0"}, "b)" +
                  k + R"(": {"kind": "R", "resistance": 3}, "j)" + next + R"(": {"kind": "1"})";
      bonds += R"(, {"from": "j)" + k + R"(", "to": "a)" + k + R"("}, {"from": "j)" + k + R"(", "to": "n)" + k +
               R"("}, {"from": "n)" + k + R"(", "to": "b)" + k + R"("}, {"from": "n)" + k + R"(", "to": "j)" + next +
               R"("})";
    }
    const std::string end = "j" + std::to_string(rungs);
    elements += R"(, "c": {"kind": "C", "capacitance": 1})";
    if (gyrator) {
      elements +=
          R"(, "g": {"kind": "GY", "modulus": 2}, "j": {"kind": "1"}, "q": {"kind": "R", "law": ")" + law + R"("})";
      bonds += R"(, {"from": ")" + end +
               R"(", "to": "g"}, {"from": "g", "to": "j"}, {"from": "j", "to": "q"}, {"from": "j", "to": "c"})";
    } else {
      bonds += R"(, {"from": ")" + end + R"(", "to": "c"})";
    }
    return run_text(R"({"bgsim": 1, "name": "ladder", "elements": {)" + elements + R"(}, "bonds": [)" + bonds +
                    R"(], "outputs": {"f": "s.f"}, "scenes": {"s": {"stop": 1e-3, "samples": 2}}})");
  };
  for (const auto& [rungs, gyrator] :
       {std::pair(3, false), std::pair(3, true), std::pair(10, false), std::pair(100, false)}) {
    INFO(rungs << (gyrator ? " before a gyrator" : ""));
    const RunResult with = ladder("f = if(e > 0, sqrt(e), -sqrt(-e))", rungs, gyrator);
    const RunResult without = ladder("f = sign(e)*sqrt(abs(e))", rungs, gyrator);
    REQUIRE(with.stop == StopReason::completed);
    REQUIRE(without.stop == StopReason::completed);
    CHECK(with.trace["f"].front() == Approx(without.trace["f"].front()).epsilon(1e-9));  // the loop's own accuracy
  }
}
