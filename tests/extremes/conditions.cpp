// Conditions on states: relays, friction, stops, and switching without end.
#include <catch2/catch.hpp>

#include "extremes.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A mass on a spring with a resistor's law, let go at x = 1.
std::string sliding(const std::string& law, const std::string& stop) {
  return model_of(R"("mass": { "kind": "I", "inertance": 1 }, "body": { "kind": "1" },
      "spring": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } },
      "friction": { "kind": "R", "law": "e = )" +
                      law + R"(" })",
                  "body>mass body>spring body>friction", R"("x": "spring.q", "v": "mass.f")",
                  "\"stop\": " + stop + ", \"samples\": 11");
}

/// A mass of 1 kg and 1 m/s against a stop of stiffness 1e6 at x = 1: it is back at 1 after pi/1000 s.
std::string stopped(double relative, double limit) {
  const Ran run =
      ran(model_of(R"("mass": { "kind": "I", "inertance": 1, "initial": { "p": 1 } }, "body": { "kind": "1" },
      "stop": { "kind": "C", "law": "e = if(q > 1, 1e6*(q - 1), 0) " })",
                   "body>mass body>stop", R"("x": "stop.q")", R"("stop": 1.5, "samples": 4)"),
          with_relative(relative));
  REQUIRE(run.completed());
  return within(std::abs(run.last("x") - (0.5 + 3.14159265358979e-3)), limit);
}

const std::vector<Extreme> kEntries{
    {"x' = if(min(x, 1) >= 1, 0, 1), from x = 0: equality that is reached and kept",
     "it fills until it is full, and stays: x = 1",
     [] {
       const Ran run = ran(filling("if(min(store.q, 1) >= 1, 0, 1)", "0", R"("stop": 2, "samples": 11)"));
       REQUIRE(run.completed());
       CHECK(run.result->report.state_events == 1);
       return within(std::abs(run.last("q") - 1.0), 1e-9);
     }},
    {"relay x' = -sign(x), from x = 1",
     "the model does not define the motion at 0: stop, name the condition; plain CVODE takes two million steps there",
     [] {
       const Ran run = ran(filling("-sign(store.q)", "1", R"("stop": 2, "samples": 11)"));
       CHECK(run.result->report.steps < 1000);
       return diagnosis(run, "BG604", {"sign(store.q)", "\"source\"", "t = 1"});
     }},
    {"a' = -sign(a) + 2 sign(b), b' = -2 sign(a) - sign(b): ever faster switching (Zeno)",
     "stop with the limit: from (1, 0.5) each round is shorter by the same factor, the sum is t = 0.75",
     [] {
       const Ran run = ran(model_of(
           R"("one": { "kind": "MSf", "flow": "-sign(a.q) + 2*sign(b.q) " }, "first": { "kind": "0" },
           "a": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } },
           "two": { "kind": "MSf", "flow": "-2*sign(a.q) - sign(b.q) " }, "second": { "kind": "0" },
           "b": { "kind": "C", "capacitance": 1, "initial": { "q": 0.5 } })",
           "one>first first>a two>second second>b", R"("a": "a.q", "b": "b.q")", R"("stop": 5, "samples": 11)"));
       return diagnosis(run, "BG604", {"ever faster towards t = 0.75", "sign(a.q)", "sign(b.q)"});
     }},
    {"Coulomb friction `0.08*sign(f)` under a mass on a spring, 50 s",
     "six swings, each shorter by 0.16, then rest at x = 0.04; plain CVODE takes two million steps without completing",
     [] {
       const Ran run = ran(sliding("0.08*sign(f)", "50"));
       REQUIRE(run.completed());
       CHECK(std::abs(run.last("v")) < 1e-12);
       return within(std::abs(run.last("x") - 0.04), 1e-4) + ", at rest";
     }},
    {"the same as `0.08*tanh(f/1e-6)`, 4000 s", "this model creeps: x' = -1e-6 x/0.08 near rest, x(4000) = 0.038",
     [] {
       const Ran run = ran(sliding("0.08*tanh(f/1e-6)", "4000"));
       REQUIRE(run.completed());
       CHECK(run.last("x") < 0.0395);
       return "creeps to " + std::string(std::abs(run.last("x") - 0.038) < 1e-3 ? "0.038" : "another place");
     }},
    {"hard stop of stiffness 1e6, tolerance 1e-6", "back at 1 after pi/1000 s", [] { return stopped(1e-6, 1e-4); }},
    {"the same, tolerance 1e-3", "the same", [] { return stopped(1e-3, 1e-2); }},
    {"stick-slip: mass drawn by a spring at 0.1 m/s, friction falling from 1 to 0.5, 100 s",
     "it sticks and slips for ever; the energy of the drive is stored or lost in friction",
     [] {
       const Ran run = ran(model_of(R"("drive": { "kind": "Sf", "flow": 0.1 }, "pull": { "kind": "0" },
           "spring": { "kind": "C", "capacitance": 1 }, "body": { "kind": "1" }, "mass": { "kind": "I", "inertance": 1 },
           "friction": { "kind": "R", "law": "e = sign(f)*(0.5 + 0.5*exp(-abs(f)/0.05)) " })",
                                    "drive>pull pull>spring pull>body body>mass body>friction",
                                    R"("x": "spring.q", "v": "mass.f")", R"("stop": 100, "samples": 1001)"));
       REQUIRE(run.completed());
       const std::vector<double> v = column(*run.result, "v");
       const auto sticking = std::count_if(v.begin(), v.end(), [](double f) { return std::abs(f) < 1e-9; });
       CHECK(sticking > 300);
       CHECK(*std::max_element(v.begin(), v.end()) > 0.3);
       return "sticks and slips; energy balance: " + within(run.result->report.energy.relative, 1e-4);
     }},
    {"a ball on a spring of 1e6 N/m with damping, 3 s under gravity: contacts ever nearer to each other",
     "it comes to rest on the spring, at -9.81e-6",
     [] {
       const Ran run = ran(model_of(R"("weight": { "kind": "Se", "effort": -9.81 }, "body": { "kind": "1" },
           "mass": { "kind": "I", "inertance": 1 },
           "floor_": { "kind": "C", "law": "e = if(q < 0, 1e6*q, 0) ", "initial": {
      "q" : 1 } },
           "loss": { "kind": "MR", "law": "e = if(floor_.q < 0, 300*f, 0) " })",
                                    "weight>body body>mass body>floor_ body>loss", R"("x": "floor_.q")",
                                    R"("stop": 3, "samples": 31)"));
       REQUIRE(run.completed());
       return within(std::abs(run.last("x") + 9.81e-6), 1e-7);
     }},
};

const Section kSection("Conditions", kEntries);

}  // namespace
