// Orifices at rest: the flow of e = k f |f| begins with a slope by the effort that has no bound.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const std::vector<Method> kMethods{Method::automatic, Method::bdf,     Method::adams,  Method::ida,
                                   Method::erk5,      Method::erk8,    Method::dirk5,  Method::radau,
                                   Method::radau9,    Method::radau13, Method::rodas5p};

/// A store that is empty until t = 0.3, fed through @p way from a sine and drained through resistors in series.
std::string fed(const std::string& way, const std::vector<std::string>& drains) {
  std::string elements, bonds;
  for (std::size_t i = 0; i < drains.size(); ++i) {
    const std::string name = "o" + std::to_string(i);
    elements += R"(, ")" + name + R"(": {"kind": "R", "law": ")" + drains[i] + R"("})";
    bonds += R"(, {"from": "k", "to": ")" + name + R"("})";
  }
  return R"x({"bgsim": 1, "name": "fed", "elements": {"s": {"kind": "Se", "effort": "2*sin(3*t)"}, "j": {"kind": "1"},
    "n": {"kind": "0"}, "c": {"kind": "C", "capacitance": 1}, "k": {"kind": "1"}, )x" +
         way + elements + R"(}, "bonds": [{"from": "s", "to": "j"}, {"from": "j", "to": "n"}, {"from": "n", "to": "c"},
    {"from": "n", "to": "k"}, {"from": "j", "to": "r"})" +
         bonds + R"(], "outputs": {"q": "c.q"}, "scenes": {"s": {"stop": 3, "samples": 31}}})";
}

RunResult run(const std::string& model, Method method, double relative) {
  SceneOverrides overrides;
  overrides.method = method;
  overrides.relative = relative;
  return Study::from_text(model).scene("s", overrides).simulate(untimed());
}

}  // namespace

TEST_CASE("an empty store begins to fill behind orifices, by every method") {
  // A thyristor that is fired at t = 0.3, and a law that lets nothing back. One drain, or two in series with the same
  // flow together, which are a loop: c.q stayed 0 while 0.3 flowed in, or the step size went to nothing.
  const std::string valve = R"("d": {"kind": "D", "fire": "t > 0.3"}, "r": {"kind": "R", "resistance": 1})";
  const std::string one_way = R"x("r": {"kind": "R", "law": "f = if(t > 0.3, max(e, 0), 0)"})x";
  const std::vector<std::pair<std::string, std::vector<std::vector<std::string>>>> laws{
      {"f = sign(e)*sqrt(abs(e))",
       {{"f = sign(e)*sqrt(abs(e))"}, {"e = f*abs(f)"}, {"e = 0.75*f*abs(f)", "e = 0.25*f*abs(f)"}}},
      {"f = sign(e)*abs(e)^0.625", {{"e = f*abs(f)^0.6"}, {"e = 0.3*f*abs(f)^0.6", "e = 0.7*f*abs(f)^0.6"}}}};
  for (const auto& [law, forms] : laws) {
    const RunResult reference = run(fed(one_way, {law}), Method::radau9, 1e-11);
    REQUIRE(reference.stop == StopReason::completed);
    for (const std::vector<std::string>& drains : forms) {
      std::string model = fed(valve, drains);
      model.replace(model.find(R"("bonds": [)") + 10, 0, R"({"from": "j", "to": "d"}, )");
      for (const Method method : kMethods) {
        INFO(drains.front() << ", " << drains.size() << " in series, " << method_name(method));
        const RunResult result = run(model, method, 1e-8);
        REQUIRE(result.stop == StopReason::completed);
        CHECK(result.report.mode_changes == 3);
        CHECK(std::abs(last(result, "q") - last(reference, "q")) < 1e-6);  // a hundred tolerances
        for (std::size_t k = 0; k < result.trace.times.size(); ++k)  // between its steps erk8 is wrong by some 5e-6
          CHECK(std::abs(result.trace["q"][k] - reference.trace["q"][k]) < 1e-5);
      }
    }
  }
}

TEST_CASE("a tank runs empty through an orifice in some hundred steps, by every method") {
  // q' = -sqrt(q): q = (1 - t/2)^2. Solved as a loop, 1e4 to 2e5 steps were made about the end.
  for (const std::string law : {"e = f*abs(f)", "f = sign(e)*sqrt(abs(e))", "e = f*abs(f)^1.0"})
    for (const Method method : kMethods) {
      INFO(law << ", " << method_name(method));
      const RunResult result = run(
          R"({"bgsim": 1, "name": "tank", "elements": {"c": {"kind": "C", "capacitance": 1, "initial": {"q": 1}},
            "r": {"kind": "R", "law": ")" +
              law + R"("}}, "bonds": [{"from": "c", "to": "r"}], "outputs": {"q": "c.q"},
            "scenes": {"s": {"stop": 4, "samples": 41}}})",
          method, 1e-6);
      REQUIRE(result.stop == StopReason::completed);
      CHECK(result.report.steps < 300);
      for (std::size_t k = 0; k < result.trace.times.size(); ++k) {
        const double left = std::max(0.0, 1.0 - result.trace.times[k] / 2.0);
        CHECK(std::abs(result.trace["q"][k] - left * left) < 1e-4);  // a hundred tolerances
      }
    }
}
