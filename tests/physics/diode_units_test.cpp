// Models with diodes and contacts are the same in any units: efforts times E, flows times F, times times T.
#include <catch2/catch.hpp>
#include <cmath>

#include "bgsim/text.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

struct Scaled {
  std::string name, elements, bonds, outputs;
  double stop;
};

/// Outputs as they are in the units of 1. R, C, I, Q and P: a resistance, a capacitance, an inertance, a displacement
/// and a momentum of 1 there.
Study study_of(const Scaled& model) {
  std::string list;
  std::istringstream words(model.bonds);
  for (std::string word; words >> word;) {
    const auto arrow = word.find('>');
    list += (list.empty() ? "" : ", ") + (R"({"from": ")" + word.substr(0, arrow)) + R"(", "to": ")" +
            word.substr(arrow + 1) + "\"}";
  }
  return Study::from_text(R"x({"bgsim": 1, "name": "units", "parameters": {"E": 1, "F": 1, "T": 1,
      "R": "E/F", "C": "F*T/E", "I": "E*T/F", "Q": "F*T", "P": "E*T"}, "elements": {)x" +
                          model.elements + R"x(}, "bonds": [)x" + list + R"x(], "outputs": {)x" + model.outputs +
                          R"x(}, "scenes": {"run": {"stop": ")x" + number_text(model.stop) +
                          R"x(*T", "samples": 31}}})x");
}

/// Junctions, by the first letter of their names: j and k are 1, n, o and z are 0.
std::string junctions(const std::string& names) {
  std::string text;
  std::istringstream words(names);
  for (std::string word; words >> word;)
    text += ", \"" + word + R"(": {"kind": ")" + (word[0] == 'j' || word[0] == 'k' ? "1" : "0") + "\"}";
  return text;
}

std::vector<Scaled> models() {
  return {
      {"a pump with two valves and a chamber behind them",
       R"x("s": {"kind": "Sf", "flow": "F*sin(t/T)"}, "in": {"kind": "D", "passes": "out"}, "out": {"kind": "D"},
           "c": {"kind": "C", "capacitance": "3*C"}, "r": {"kind": "R", "resistance": "2*R"})x" +
           junctions("n j o"),
       "s>n n>in n>j j>out j>o o>c o>r", R"x("q": "c.q/Q")x", 20},
      {"a pump with two valves, and an orifice that empties what is behind them between two strokes",
       R"x("s": {"kind": "Sf", "flow": "F*sin(t/T)"}, "in": {"kind": "D", "passes": "out"}, "out": {"kind": "D"},
           "c": {"kind": "C", "capacitance": "C"}, "r": {"kind": "R", "law": "e = E*(f/F)*abs(f/F)"})x" +
           junctions("n j o k"),
       "s>n n>in n>j j>out j>o o>c o>k k>r", R"x("q": "c.q/Q")x", 15},
      {"a rectifier with an orifice in series",
       R"x("s": {"kind": "Se", "effort": "1.9*E*sin(4.8*t/T)"}, "d": {"kind": "D"},
           "ro": {"kind": "R", "law": "e = E*0.25*(f/F)*abs(f/F)"}, "c": {"kind": "C", "capacitance": "0.08*C"},
           "r": {"kind": "R", "resistance": "16*R"})x" +
           junctions("j o k z"),
       "s>j j>d j>o o>k k>ro k>z z>c z>r", R"x("q": "c.q/Q")x", 7.3},
      {"a bridge behind a line",
       R"x("s": {"kind": "Se", "effort": "3*E*sin(t/T)"}, "l": {"kind": "I", "inertance": "0.5*I"},
           "rs": {"kind": "R", "resistance": "0.1*R"}, "d1": {"kind": "D"}, "d2": {"kind": "D"},
           "d3": {"kind": "D", "passes": "out"}, "d4": {"kind": "D", "passes": "out"},
           "c": {"kind": "C", "capacitance": "C"}, "r": {"kind": "R", "resistance": "5*R"})x" +
           junctions("j na nb o j1 j2"),
       "s>j j>l j>rs j>na nb>j na>j1 j1>d1 j1>o nb>j2 j2>d2 j2>o na>d3 nb>d4 o>c o>r",
       R"x("q": "c.q/Q", "p": "l.p/P")x", 20},
      {"a source, a store and a coil that a diode clamps",
       R"x("s": {"kind": "Sf", "flow": "F"}, "c": {"kind": "C", "capacitance": "C"},
           "i": {"kind": "I", "inertance": "I"}, "d": {"kind": "D", "threshold": "0.5*E"})x" +
           junctions("z"),
       "s>z z>c z>i z>d", R"x("q": "c.q/Q", "p": "i.p/P")x", 5},
      {"a step-up converter",
       R"x("s": {"kind": "Se", "effort": "E"}, "l": {"kind": "I", "inertance": "I"},
           "sw": {"kind": "Sw", "closed": "mod(t/T, 1) < 0.5"}, "d": {"kind": "D", "threshold": "0.05*E"},
           "c": {"kind": "C", "capacitance": "2*C"}, "r": {"kind": "R", "resistance": "3*R"})x" +
           junctions("j n k o"),
       "s>j j>l j>n n>sw n>k k>d k>o o>c o>r", R"x("q": "c.q/Q", "p": "l.p/P")x", 20.3},
      {"a contact beside a diode with a threshold",
       R"x("s": {"kind": "Sf", "flow": "F*step(t/T - 1)"}, "k": {"kind": "contact", "gap": "0.5*Q", "restitution": 0},
           "i": {"kind": "I", "inertance": "I"}, "r": {"kind": "R", "resistance": "R"},
           "d": {"kind": "D", "threshold": "0.5*E"})x" +
           junctions("z z2"),
       "s>z z>k z>i z>z2 z2>r z2>d", R"x("p": "i.p/P", "q": "k.q/Q")x", 4},
      {"a moving mass, a contact and a diode beside a resistance",
       R"x("i": {"kind": "I", "inertance": "I", "initial": {"p": "-P"}}, "k": {"kind": "contact", "gap": "0.5*Q", "restitution": 0},
           "r": {"kind": "R", "resistance": "5*R"}, "d": {"kind": "D"})x" +
           junctions("z j zz"),
       "z>j j>i z>k z>zz zz>r zz>d", R"x("p": "i.p/P", "q": "k.q/Q")x", 4},
      {"a doubler",
       R"x("s": {"kind": "Se", "effort": "E*sin(t/T)"}, "rs": {"kind": "R", "resistance": "0.1*R"},
           "c1": {"kind": "C", "capacitance": "C"}, "d1": {"kind": "D", "passes": "out"}, "d2": {"kind": "D"},
           "c2": {"kind": "C", "capacitance": "C"}, "r": {"kind": "R", "resistance": "20*R"})x" +
           junctions("j n k o"),
       "s>j j>rs j>c1 j>n n>d1 n>k k>d2 k>o o>c2 o>r", R"x("q1": "c1.q/Q", "q2": "c2.q/Q")x", 20},
      {"a thyristor before a load",
       R"x("s": {"kind": "Se", "effort": "E*sin(t/T)"}, "rs": {"kind": "R", "resistance": "0.2*R"},
           "l": {"kind": "I", "inertance": "0.5*I"}, "d": {"kind": "D", "fire": "mod(t/T, 6.283185307179586) > 1"},
           "c": {"kind": "C", "capacitance": "C"}, "r": {"kind": "R", "resistance": "R"})x" +
           junctions("j z"),
       "s>j j>rs j>l j>d j>z z>c z>r", R"x("q": "c.q/Q", "p": "l.p/P")x", 12},
      {"a mass that bounces",
       R"x("s": {"kind": "Se", "effort": "E"}, "m": {"kind": "I", "inertance": "I"},
           "k": {"kind": "contact", "gap": "Q", "restitution": 0.7}, "r": {"kind": "R", "resistance": "0.1*R"})x" +
           junctions("j"),
       "s>j j>m j>r j>k", R"x("p": "m.p/P", "q": "k.q/Q")x", 6},
  };
}

}  // namespace

TEST_CASE("diodes and contacts know no unit", "[long]") {
  for (const Scaled& model : models()) {
    const Study study = study_of(model);
    const RunResult one = run(study, "run");
    INFO(model.name << (one.failure ? ": " + one.failure->situation : ""));
    REQUIRE(one.stop == StopReason::completed);
    for (const auto& [effort, flow] : std::vector<std::pair<std::string, std::string>>{{"1", "1e-5"},
                                                                                       {"1e5", "1e-4"},
                                                                                       {"1e5", "1e-9"},
                                                                                       {"1e3", "1e-12"},
                                                                                       {"1e15", "1e-15"},
                                                                                       {"1e-5", "1e3"},
                                                                                       {"1e-9", "1e9"},
                                                                                       {"1e-15", "1e15"}})
      for (const std::string time : {"1", "1e-9"}) {
        INFO("E = " << effort << ", F = " << flow << ", T = " << time);
        const RunResult other = run(study, "run", {"E=" + effort, "F=" + flow, "T=" + time});
        INFO((other.failure ? other.failure->situation : ""));
        REQUIRE(other.stop == StopReason::completed);
        REQUIRE(other.trace.columns.size() == one.trace.columns.size());
        // Ten tolerances: steps differ where rounding does.
        for (std::size_t i = 0; i < one.trace.columns.size(); ++i)
          for (std::size_t k = 0; k < one.trace.times.size(); ++k)
            CHECK(other.trace.columns[i][k] == Approx(one.trace.columns[i][k]).epsilon(0).margin(1e-5));
      }
  }
}

TEST_CASE("a pump between two valves has the pressure of its exact solution, in pascals and cubic metres") {
  // C p' = max(Q sin t, 0) - p/R: while it delivers p = Q (R sin t - R^2 C cos t)/(1 + (R C)^2) + k exp(-t/(R C)).
  const double c = 1e-8, r = 2e8, q = 1e-3, tau = r * c;
  double p = 0.0;
  const double pi = std::acos(-1.0);
  const auto forced = [&](double t) { return q * r * (std::sin(t) - tau * std::cos(t)) / (1.0 + tau * tau); };
  for (int period = 0; period < 2; ++period)
    p = (forced(pi) + (p - forced(0.0)) * std::exp(-pi / tau)) * std::exp(-pi / tau);
  const Study pump = Study::from_text(R"x({"bgsim": 1, "name": "pump", "elements": {
      "s": {"kind": "Sf", "flow": "1e-3*sin(t)"}, "n": {"kind": "0"}, "suction": {"kind": "D", "passes": "out"},
      "j": {"kind": "1"}, "delivery": {"kind": "D"}, "o": {"kind": "0"}, "c": {"kind": "C", "capacitance": 1e-8},
      "r": {"kind": "R", "resistance": 2e8}},
      "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "suction"}, {"from": "n", "to": "j"},
                {"from": "j", "to": "delivery"}, {"from": "j", "to": "o"}, {"from": "o", "to": "c"}, {"from": "o", "to": "r"}],
      "outputs": {"p": "c.e", "f": "-suction.f"}, "scenes": {"run": {"stop": "4*pi", "samples": 41}}})x");
  const RunResult result = run(pump);
  REQUIRE(result.stop == StopReason::completed);
  CHECK(last(result, "p") == Approx(p).epsilon(1e-5));  // ten tolerances
  for (const double f : column(result, "f")) CHECK(f >= -1e-12);
}

TEST_CASE("a suction valve before an orifice stays shut where the chamber only comes to the pressure of the tank") {
  // q = Q/w (1 - cos wt) touches 0 and turns back. What lets the valve open there must not keep it open.
  for (const auto& [effort, flow] : std::vector<std::pair<double, double>>{{1.0, 1.0}, {1e6, 1e-4}, {1e5, 1e-6}}) {
    const auto text = [](double value) { return number_text(value); };
    const Study pump = Study::from_text(R"x({"bgsim": 1, "name": "pump", "parameters": {"E": )x" + text(effort) +
                                        R"x(, "F": )x" + text(flow) + R"x(}, "elements": {
      "s": {"kind": "Sf", "flow": "0.5354*F*sin(7.992*t)"}, "n": {"kind": "0"},
      "c": {"kind": "C", "capacitance": "0.8249*F/E"}, "j": {"kind": "1"}, "k": {"kind": "1"}, "o": {"kind": "0"},
      "ro": {"kind": "R", "law": "e = E*0.02243*(f/F)*abs(f/F)"}, "suction": {"kind": "D"},
      "delivery": {"kind": "D"}, "l": {"kind": "1"}, "line": {"kind": "Se", "effort": "0.5*E"}, "h": {"kind": "0"}},
      "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "c"}, {"from": "j", "to": "ro"}, {"from": "j", "to": "o"},
                {"from": "o", "to": "k"}, {"from": "k", "to": "suction"}, {"from": "k", "to": "n"},
                {"from": "n", "to": "l"}, {"from": "l", "to": "delivery"}, {"from": "l", "to": "h"}, {"from": "line", "to": "h"}],
      "outputs": {"q": "c.q/F"}, "scenes": {"run": {"stop": 4.012, "samples": 41}}})x");
    for (const Method method : {Method::automatic, Method::bdf, Method::radau13, Method::rodas5p}) {
      INFO("E = " << effort << ", F = " << flow << ", method " << static_cast<int>(method));
      SceneOverrides overrides;
      overrides.method = method;
      const RunResult result = pump.scene("run", overrides).simulate(untimed());
      REQUIRE(result.stop == StopReason::completed);
      // A hundred tolerances: while the valve is open by mistake, what comes in is the root of what the pressure is
      // off.
      for (std::size_t k = 0; k < result.trace.times.size(); ++k)
        CHECK(result.trace.columns[0][k] ==
              Approx(0.5354 / 7.992 * (1.0 - std::cos(7.992 * result.trace.times[k]))).margin(1e-5));
    }
  }
}

TEST_CASE("a delivery valve shuts at each turn of the piston, whatever orifice the suction valve stands before",
          "[long]") {
  // While the delivery valve conducts, its flow is that of the piston, A sin wt.
  struct Pump {
    double flow, w, capacitance, orifice, effort, stop;
  };
  const std::vector<Pump> pumps = {
      {1.5, 2.856, 0.08895, 0.4402, 0.5, 13.173},  {1.478, 7.642, 0.01636, 0.5708, 1, 4.278},
      {1.367, 3.237, 0.1389, 0.1181, 1, 10.615},   {1.002, 3.188, 0.02304, 0.4504, 1, 9.623},
      {0.5451, 5.922, 0.1197, 0.05284, 0.5, 6.29}, {0.9547, 7.401, 0.01428, 0.0342, 1, 2.607},
      {1.765, 7.392, 0.1143, 0.2913, 1, 3.478},    {1.939, 7.51, 0.04544, 2.871, 1, 4.704}};
  struct Run {
    Method method;
    double relative;
  };
  for (const Pump& p : pumps)
    for (const auto& [effort, flow] : std::vector<std::pair<double, double>>{{1.0, 1.0}, {1e6, 1e-4}, {1e3, 1e-3}}) {
      const auto text = [](double value) { return number_text(value); };
      const Study study = Study::from_text(
          R"x({"bgsim": 1, "name": "pump", "parameters": {"E": )x" + text(effort) + R"x(, "F": )x" + text(flow) +
          R"x(}, "elements": {"s": {"kind": "Sf", "flow": "F*)x" + text(p.flow) + "*sin(" + text(p.w) +
          R"x(*t)"}, "n": {"kind": "0"}, "c": {"kind": "C", "capacitance": "F/E*)x" + text(p.capacitance) +
          R"x("}, "ro": {"kind": "R", "law": "e = E*)x" + text(p.orifice) +
          R"x(*(f/F)*abs(f/F)"}, "j": {"kind": "1"}, "o": {"kind": "0"}, "k": {"kind": "1"}, "l": {"kind": "1"},
          "suction": {"kind": "D"}, "delivery": {"kind": "D"}, "h": {"kind": "0"}, "line": {"kind": "Se", "effort": "E*)x" +
          text(p.effort) +
          R"x("}}, "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "c"}, {"from": "j", "to": "ro"},
          {"from": "j", "to": "o"}, {"from": "o", "to": "k"}, {"from": "k", "to": "suction"}, {"from": "k", "to": "n"},
          {"from": "n", "to": "l"}, {"from": "l", "to": "delivery"}, {"from": "l", "to": "h"},
          {"from": "line", "to": "h"}], "outputs": {"q": "c.q/F"}, "scenes": {"run": {"stop": )x" +
          text(p.stop) + R"x(, "samples": 41}}})x");
      for (const auto& [method, relative] :
           {Run{Method::automatic, 1e-6}, {Method::bdf, 1e-9}, {Method::rodas5p, 1e-6}, {Method::automatic, 1e-8}}) {
        INFO("A = " << p.flow << ", E = " << effort << ", F = " << flow << ", method " << static_cast<int>(method)
                    << " at " << relative);
        SceneOverrides overrides;
        overrides.method = method;
        overrides.relative = relative;
        std::vector<double> shuts;
        SimulateOptions options = untimed();
        options.second_run = options.error_estimate = false;
        options.events = [&shuts](const RunEvent& event) {
          if (event.name == "delivery" && event.to == "blocks" && event.t > 0.0) shuts.push_back(event.t);
        };
        const RunResult result = study.scene("run", overrides).simulate(options);
        REQUIRE(result.stop == StopReason::completed);
        const double turn = std::acos(-1.0) / p.w;
        REQUIRE(shuts.size() == static_cast<std::size_t>(0.5 * (p.stop / turn + 1.0)));
        // The flow is no state: the instant is as good as the search for it, and the band that rounding needs.
        for (std::size_t k = 0; k < shuts.size(); ++k)
          CHECK(shuts[k] == Approx(static_cast<double>(2 * k + 1) * turn).margin(1e-5 * turn).epsilon(0.0));
      }
    }
}
