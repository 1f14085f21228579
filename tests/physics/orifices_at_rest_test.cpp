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

TEST_CASE("an empty store begins to fill behind an orifice, by every method") {
  // A thyristor that is fired at t = 0.3, and a law that lets nothing back. The tolerance of the store was 0, and the
  // step size went to nothing.
  const std::string one_way = R"x("r": {"kind": "R", "law": "f = if(t > 0.3, max(e, 0), 0)"})x";
  for (const std::string law : {"f = sign(e)*sqrt(abs(e))", "f = sign(e)*abs(e)^0.625", "f = 3*sign(e)*abs(e)^0.3"}) {
    const RunResult reference = run(fed(one_way, {law}), Method::radau9, 1e-11);
    REQUIRE(reference.stop == StopReason::completed);
    std::string model = fed(R"("d": {"kind": "D", "fire": "t > 0.3"}, "r": {"kind": "R", "resistance": 1})", {law});
    model.replace(model.find(R"("bonds": [)") + 10, 0, R"({"from": "j", "to": "d"}, )");
    for (const Method method : kMethods) {
      INFO(law << ", " << method_name(method));
      const RunResult result = run(model, method, 1e-8);
      REQUIRE(result.stop == StopReason::completed);
      CHECK(result.report.mode_changes == 3);
      CHECK(std::abs(last(result, "q") - last(reference, "q")) < 1e-6);  // a hundred tolerances
      for (std::size_t k = 0; k < result.trace.times.size(); ++k)        // between its steps erk8 is wrong by some 5e-6
        CHECK(std::abs(result.trace["q"][k] - reference.trace["q"][k]) < 1e-5);
    }
  }
}

TEST_CASE("a tank runs empty through an orifice in some hundred steps, by every method") {
  // q' = -sqrt(q): q = (1 - t/2)^2.
  for (const std::string law : {"f = sign(e)*sqrt(abs(e))", "f = sign(e)*abs(e)^0.5"})
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

TEST_CASE("tanks in series that are all empty fill one after the other through their orifices") {
  // The flow into the k-th begins with a power of time that doubles with k: some 1e-60 after a moment.
  std::string elements = R"x("s": {"kind": "Se", "effort": "1 + sin(t)"}, "j0": {"kind": "1"})x",
              bonds = R"({"from": "s", "to": "j0"})";
  constexpr int kTanks = 20;
  for (int i = 0; i < kTanks; ++i) {
    const std::string k = std::to_string(i), next = std::to_string(i + 1);
    elements += R"x(, "o)x" + k + R"x(": {"kind": "R", "law": "e = f*abs(f)"}, "n)x" + k + R"x(": {"kind": "0"}, "c)x" +
                k + R"x(": {"kind": "C", "capacitance": 1})x";
    bonds += R"x(, {"from": "j)x" + k + R"x(", "to": "o)x" + k + R"x("}, {"from": "j)x" + k + R"x(", "to": "n)x" + k +
             R"x("}, {"from": "n)x" + k + R"x(", "to": "c)x" + k + R"x("})x";
    if (i + 1 < kTanks) {
      elements += R"x(, "j)x" + next + R"x(": {"kind": "1"})x";
      bonds += R"x(, {"from": "n)x" + k + R"x(", "to": "j)x" + next + R"x("})x";
    }
  }
  const std::string model = R"({"bgsim": 1, "name": "tanks", "elements": {)" + elements + R"(}, "bonds": [)" + bonds +
                            R"(], "outputs": {"first": "c0.q", "last": "c19.q"},
                               "scenes": {"s": {"stop": 10, "samples": 11}}})";
  const RunResult reference = run(model, Method::radau9, 1e-9);
  REQUIRE(reference.stop == StopReason::completed);
  for (const Method method :
       {Method::automatic, Method::bdf, Method::ida, Method::dirk5, Method::radau, Method::rodas5p}) {
    INFO(method_name(method));
    const RunResult result = run(model, method, 1e-6);
    REQUIRE(result.stop == StopReason::completed);
    for (const char* output : {"first", "last"})
      CHECK(last(result, output) == Approx(last(reference, output)).margin(1e-4));  // a hundred tolerances
  }
}
