// Stores at rest beside others, in units in which nothing of them is more than a rounding of the others.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const std::vector<Method> kMethods{Method::automatic, Method::bdf,     Method::adams,  Method::ida,
                                   Method::dirk3,     Method::dirk5,   Method::erk5,   Method::radau,
                                   Method::radau9,    Method::radau13, Method::rodas5p};

RunResult completed(const std::string& text, Method method) {
  RunResult result = Study::from_text(text).scene({}, with_method(method)).simulate(one_run());
  INFO((result.failure ? result.failure->situation : ""));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

bool is_zero(double value) { return value == 0.0; }

}  // namespace

TEST_CASE("a mass that nothing moves stays at rest beside a displacement, whatever its unit, by every method") {
  // q = 1e-3 (1 - cos t) never comes to the stop or the spring behind its slack, so p = 0. Elimination that compares
  // 1/m with 1 took the displacement's rounding for a momentum, whose tolerance is that of rounding: runs without end.
  for (const char* const mass : {"1e-6", "1e-10", "1e-20"})
    for (const std::string stop :
         {R"x({"kind": "contact", "gap": 1})x", R"x({"kind": "C", "law": "e = 1e-5*max(q - 1, 0)"})x"})
      for (const Method method : kMethods) {
        CAPTURE(mass, stop, method_name(method));
        const RunResult run =
            completed(R"x({"bgsim": 1, "name": "rest", "elements": {
            "s": {"kind": "Sf", "flow": "1e-3*sin(t)"}, "n": {"kind": "0"}, "c": )x" +
                          stop + R"x(, "j": {"kind": "1"}, "m": {"kind": "I", "inertance": )x" + mass + R"x(}},
          "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "c"}, {"from": "n", "to": "j"},
                    {"from": "j", "to": "m"}],
          "outputs": {"p": "m.p", "q": "c.q"}, "scenes": {"s": {"stop": 50, "samples": 51}}})x",
                      method);
        CHECK(run.report.steps < 500);
        CHECK(std::all_of(run.trace["p"].begin(), run.trace["p"].end(), is_zero));
        for (std::size_t k = 0; k < run.trace.times.size(); ++k)  // 500 steps, each with the tolerance of 2e-9
          CHECK(std::abs(run.trace["q"][k] - 1e-3 * (1.0 - std::cos(run.trace.times[k]))) < 1e-6);
      }
}

TEST_CASE("a mass behind an open contact stays at rest while another one is moved away, by every method") {
  // x = 1e3 sin(1e-3 t) - t from 0 on, away from the contact: the second mass has nothing that moves it.
  for (const Method method : kMethods) {
    CAPTURE(method_name(method));
    const RunResult run = completed(R"x({"bgsim": 1, "name": "apart", "elements": {
        "f": {"kind": "Se", "effort": "-1e-9*sin(1e-3*t)"}, "j1": {"kind": "1"}, "m1": {"kind": "I", "inertance": 1e-3},
        "n": {"kind": "0"}, "c": {"kind": "contact", "gap": 1e-6}, "j2": {"kind": "1"},
        "m2": {"kind": "I", "inertance": 1e-4}},
      "bonds": [{"from": "f", "to": "j1"}, {"from": "j1", "to": "m1"}, {"from": "j1", "to": "n"},
                {"from": "n", "to": "c"}, {"from": "n", "to": "j2"}, {"from": "j2", "to": "m2"}],
      "outputs": {"p": "m2.p", "q": "c.q"}, "scenes": {"s": {"stop": 1000, "samples": 101}}})x",
                                    method);
    CHECK(run.report.steps < 1000);
    CHECK(std::all_of(run.trace["p"].begin(), run.trace["p"].end(), is_zero));
    const double t = run.trace.times.back();
    CHECK(run.trace["q"].back() ==
          Approx(1e-3 * (1e3 * std::sin(1e-3 * t) - t)).epsilon(1e-4));  // a hundred tolerances
  }
}

TEST_CASE("sixty masses at rest beside displacements stay there, with sparse matrices") {
  // Each displacement has a source of its own; springs behind slack between the masses tie all of them together, or
  // not.
  const std::string slack = R"x("kind": "C", "law": "e = 1e-5*max(q - 1, 0)")x";
  for (const bool tied : {false, true}) {
    std::string elements, bonds, momenta = "0";
    const auto element = [&](const std::string& name, const std::string& text) {
      elements += (elements.empty() ? "\"" : ", \"") + name + "\": {" + text + "}";
    };
    const auto bond = [&](const std::string& from, const std::string& to) {
      bonds += (bonds.empty() ? "{\"from\": \"" : ", {\"from\": \"") + from + "\", \"to\": \"" + to + "\"}";
    };
    for (int i = 0; i < 60; ++i) {
      const std::string k = std::to_string(i);
      element("s" + k, R"x("kind": "Sf", "flow": "1e-3*sin((1 + )x" + k + R"x(/60)*t)")x");
      element("n" + k, R"x("kind": "0")x");
      element("c" + k, slack);
      element("j" + k, R"x("kind": "1")x");
      element("m" + k, R"x("kind": "I", "inertance": 1e-10)x");
      bond("s" + k, "n" + k);
      bond("n" + k, "c" + k);
      bond("n" + k, "j" + k);
      bond("j" + k, "m" + k);
      momenta += " + abs(m" + k + ".p)";
      for (const int back : {1, 10}) {
        if (!tied || i < back) continue;
        const std::string tie = k + "_" + std::to_string(back);
        element("z" + tie, R"x("kind": "0")x");
        element("k" + tie, slack);
        bond("j" + std::to_string(i - back), "z" + tie);
        bond("z" + tie, "k" + tie);
        bond("z" + tie, "j" + k);
      }
    }
    const std::string model = R"x({"bgsim": 1, "name": "sixty", "elements": {)x" + elements + R"x(}, "bonds": [)x" +
                              bonds + R"x(], "outputs": {"p": ")x" + momenta + R"x(", "q": "c0.q"},
                              "scenes": {"s": {"stop": 20, "samples": 51}}})x";
    for (const Method method : {Method::bdf, Method::ida, Method::radau, Method::rodas5p}) {
      CAPTURE(tied, method_name(method));
      const RunResult run = completed(model, method);
      CHECK(run.report.method.find("dense") == std::string::npos);
      CHECK(run.report.steps < 500);
      CHECK(std::all_of(run.trace["p"].begin(), run.trace["p"].end(), is_zero));
      for (std::size_t k = 0; k < run.trace.times.size(); ++k)  // 500 steps, each with the tolerance of 2e-9
        CHECK(std::abs(run.trace["q"][k] - 1e-3 * (1.0 - std::cos(run.trace.times[k]))) < 1e-6);
    }
  }
}
