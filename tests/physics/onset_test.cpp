// Conditions that are exactly at their border where a run begins, and leave it by a higher power of time: which way
// they go is what the equations say, by every method and at every tolerance.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "support/run.hpp"

namespace bgsim {
namespace {

using namespace test;

const std::vector<Method> kMethods{Method::automatic, Method::radau9, Method::bdf, Method::adams,  Method::dirk3,
                                   Method::dirk5,     Method::erk5,   Method::ida, Method::rodas5p};

/// A mass of 1 on a spring of 1 and a damper of 0.1, with the force 1 from rest on: q = t^2/2 - t^3/60 + ..., for 1 s.
/// n counts how often the condition comes to hold.
std::string pushed(const std::string& when, const std::string& more = "", const std::string& more_bonds = "") {
  return R"x({"bgsim": 1, "name": "pushed", "signals": {"n": {"integral": "0"}, "lost": {"integral": "n"}},
    "elements": {"F": {"kind": "MSe", "effort": "1"}, "j": {"kind": "1"}, "m": {"kind": "I", "inertance": 1},
                 "k": {"kind": "C", "capacitance": 1}, "b": {"kind": "R", "resistance": 0.1})x" +
         more + R"x(},
    "bonds": [{"from": "F", "to": "j"}, {"from": "j", "to": "m"}, {"from": "j", "to": "k"}, {"from": "j", "to": "b"})x" +
         more_bonds + R"x(],
    "events": {"c": {"when": ")x" +
         when + R"x(", "set": {"n": "pre(n) + 1"}}},
    "outputs": {"n": "n", "v": "m.f", "lost": "lost"}, "scenes": {"s": {"stop": 1, "samples": 11}}})x";
}

/// At every tolerance: how often, and for how long.
void check(const std::string& model, double times, const std::vector<Method>& methods = kMethods) {
  for (const Method method : methods)
    for (const double relative : {1e-4, 1e-6, 1e-9, 1e-12}) {
      INFO("method " << facts_of(method).name << ", relative " << relative);
      const RunResult result = run_text(model, with_method(method, relative));
      REQUIRE_FALSE(result.failure);
      CHECK(last(result, "n") == Approx(times).margin(1e-9));     // an integral of 0, which rounds
      CHECK(last(result, "lost") == Approx(times).margin(1e-9));  // it happens at the start
    }
}

}  // namespace

TEST_CASE("a condition that leaves its border by a higher power of time goes where the equations lead", "[long]") {
  // at first t^3/2, t^3/2, 1e-2 t^4, t^2/2, -0.0167 t^3, -1/6 t^3
  for (const std::string never : {"k.q*m.f < 0", "t*k.q < 0", "sin(2*t)*k.q*m.f < 0", "atan2(k.q*t, 1) < 0",
                                  "min(k.q, t)*t < 0", "floor(t*k.q) < 0", "mod(t*k.q, 1.5) > 1", "k.q - t*t/2 > 0",
                                  "m.f - sin(t) > 0", "round(t*k.q + 0.5) < 1", "(k.q + 2)^2 - 4 - 4*k.q < 0"}) {
    INFO(never);
    check(pushed(never), 0.0);
  }
  for (const std::string at_once : {"k.q*m.f > 0", "t*k.q > 0", "floor(-t*k.q) < 0", "mod(-t*k.q, 1.5) > 1",
                                    "k.q > 0.1*m.f^3", "k.q - 0.25*m.f^2 > 0"}) {
    INFO(at_once);
    check(pushed(at_once), 1.0);
  }
  // Beyond a thousandth of the scene the values tell, and t^3/60 is less than what BDF and Adams at low orders make of
  // q.
  check(pushed("k.q - t*t/2 < 0"), 1.0, {Method::radau9, Method::dirk5, Method::erk5, Method::rodas5p});
}

TEST_CASE("the same where rates depend on loops") {
  // a resistive loop between two junctions, fed by the damper's effort: the spring's flow is one of its unknowns
  const std::string more =
      R"x(, "g": {"kind": "0"}, "h": {"kind": "1"}, "r1": {"kind": "R", "law": "e = 2*f + 0.1*f^3"},
      "i": {"kind": "0"}, "r2": {"kind": "R", "law": "e = 3*f + 0.2*f^3"}, "r3": {"kind": "R", "resistance": 5})x";
  const std::string bonds =
      R"x(, {"from": "j", "to": "g"}, {"from": "g", "to": "h"}, {"from": "h", "to": "r1"}, {"from": "g", "to": "r3"},
      {"from": "h", "to": "i"}, {"from": "i", "to": "r2"})x";
  for (const std::string never : {"k.q*m.f < 0", "t*r2.e < 0", "r1.f*r3.f*k.q < 0"}) {
    INFO(never);
    check(pushed(never, more, bonds), 0.0);
  }
  check(pushed("k.q*r2.f > 0", more, bonds), 1.0);
  // A linear loop, whose matrix is made of parameters alone.
  const std::string linear = R"x(, "g": {"kind": "0"}, "h": {"kind": "1"}, "r1": {"kind": "R", "resistance": 2},
      "i": {"kind": "0"}, "r2": {"kind": "R", "resistance": 3}, "r3": {"kind": "R", "resistance": 5})x";
  for (const std::string never : {"k.q*m.f < 0", "k.q*m.f > t^2", "r1.f*r3.f*k.q < 0"}) {
    INFO(never);
    check(pushed(never, linear, bonds), 0.0);
  }
  check(pushed("k.q > 0.1*r2.f^3", linear, bonds), 1.0);
}

TEST_CASE("the same where an event has emptied stores, and where a source begins") {
  // A coil and a capacitor in series with a resistor, all 1, from rest at 0.5 on with the effort 1:
  // l.f = u - u^2/2 + ..., u = t - 0.5.
  const auto circuit = [](const std::string& effort, const std::string& events) {
    return R"x({"bgsim": 1, "name": "emptied", "signals": {"n": {"integral": "0"}},
      "elements": {"V": {"kind": "MSe", "effort": ")x" +
           effort + R"x("}, "j": {"kind": "1"}, "r": {"kind": "R", "resistance": 1},
        "l": {"kind": "I", "inertance": 1}, "c": {"kind": "C", "capacitance": 1}},
      "bonds": [{"from": "V", "to": "j"}, {"from": "j", "to": "r"}, {"from": "j", "to": "l"}, {"from": "j", "to": "c"}],
      "events": {"a": {"when": "l.f - (t - 0.5) < 0", "set": {"n": "pre(n) + 1"}})x" +
           events + R"x(},
      "outputs": {"n": "n", "q": "c.q"}, "scenes": {"s": {"stop": 1, "samples": 11}}})x";
  };
  // q = 1 - exp(-u/2) (cos w u + sin(w u)/(2 w)), w^2 = 3/4, at u = 0.5
  const double w = std::sqrt(0.75);
  const double q = 1.0 - std::exp(-0.25) * (std::cos(0.5 * w) + std::sin(0.5 * w) / (2.0 * w));
  const std::string emptied = circuit("1", R"x(, "z": {"when": "t >= 0.5", "set": {"c.q": "0", "l.p": "0"}})x");
  const std::string pulse = circuit("if(t >= 0.5, 1, 0)", "");
  for (const std::string& model : {emptied, pulse})
    for (const Method method : kMethods)
      for (const double relative : {1e-4, 1e-6, 1e-9}) {
        INFO((model == pulse ? "pulse, " : "emptied, ") << facts_of(method).name << ", relative " << relative);
        const RunResult result = run_text(model, with_method(method, relative));
        REQUIRE_FALSE(result.failure);
        // At rest l.f - (t - 0.5) is 0.5 before the pulse; the condition comes to hold at 0.5, once.
        CHECK(last(result, "n") == Approx(1.0).margin(1e-9));
        CHECK(last(result, "q") == Approx(q).margin(100.0 * relative));  // a hundred tolerances
      }
}

TEST_CASE("a diode whose flow begins with the square of time blocks where that comes back to 0") {
  // A chamber that pulses, with the capacitance 1/(1.03 - 0.97 cos(20 t)), drives a coil behind a diode against 80.
  const std::string model = R"x({"bgsim": 1, "name": "chamber", "elements": {
      "c": {"kind": "MC", "law": "e = (1.03 - 0.97*cos(20*t))*q", "initial": {"q": 120}}, "n": {"kind": "0"}, "j": {"kind": "1"},
      "d": {"kind": "D"}, "r": {"kind": "R", "resistance": 0.05}, "l": {"kind": "I", "inertance": 0.0005}, "s": {"kind": "Se", "effort": -80}},
    "bonds": [{"from": "n", "to": "c"}, {"from": "n", "to": "j"}, {"from": "j", "to": "d"}, {"from": "j", "to": "r"},
              {"from": "j", "to": "l"}, {"from": "s", "to": "j"}],
    "outputs": {"q": "c.q", "i": "l.f"}, "scenes": {"s": {"stop": 1, "samples": 101}}})x";
  const auto simulated = [&](Method method, double relative) {
    return Study::from_text(model).scene("s", with_method(method, relative)).simulate(one_run());
  };
  const RunResult exact = simulated(Method::erk5, 1e-12);
  REQUIRE_FALSE(exact.failure);
  for (const Method method : {Method::automatic, Method::radau9, Method::bdf, Method::rodas5p})
    for (const double relative : {1e-6, 1e-7, 1e-8, 1e-9, 1e-10}) {
      INFO("method " << facts_of(method).name << ", relative " << relative);
      const RunResult result = simulated(method, relative);
      REQUIRE_FALSE(result.failure);
      for (const double i : column(result, "i")) CHECK(i >= 0.0);
      // A thousand tolerances: each change of the diode passes the errors of its instant on. (It was 4 % of the range.)
      CHECK(largest_difference(column(result, "q"), column(exact, "q")) < 120.0 * 1000.0 * relative);
    }
}

TEST_CASE("a latch whose condition is a product of states at rest brakes nothing") {
  // x = 2/w exp(-t/20) sin(w t), w^2 = 4 - 1/400: a mass of 1 on a spring of 4 thrown with 2 and damped by 0.1
  const std::string model =
      R"x({"bgsim": 1, "name": "thrown", "signals": {"back": {"set": "sin(2*t)*k.q < 0", "reset": "t < -1"}},
    "elements": {"j": {"kind": "1"}, "m": {"kind": "I", "inertance": 1, "initial": {"p": 2}}, "k": {"kind": "C", "capacitance": 0.25},
                 "b": {"kind": "MR", "law": "e = if(back, 5, 0.1)*f"}},
    "bonds": [{"from": "j", "to": "m"}, {"from": "j", "to": "k"}, {"from": "j", "to": "b"}],
    "outputs": {"x": "k.q"}, "scenes": {"s": {"stop": 1, "samples": 11}}})x";
  const double w = std::sqrt(4.0 - 1.0 / 400.0);
  for (const Method method : kMethods) {
    INFO("method " << facts_of(method).name);
    const RunResult result = run_text(model, with_method(method, 1e-9));
    REQUIRE_FALSE(result.failure);
    CHECK(last(result, "x") ==
          Approx(2.0 / w * std::exp(-0.05) * std::sin(w)).epsilon(1e-6));  // a thousand times the tolerance
  }
}

}  // namespace bgsim
