// Steady states of models with switches, diodes and contacts: the mode is part of what is looked for.

#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

SteadyStates steady(const std::string& text, const SteadyOptions& options = {}) {
  const Study study = Study::from_text(text);
  return steady_states(study, prepare_scene(study.model(), "s"), options);
}

double value(const Equilibrium& found, const std::string& name) {
  for (const LinearVariable& state : found.states)
    if (state.name == name) return state.value;
  throw std::invalid_argument("no state " + name);
}

/// A source behind a diode and 10 ohm, one of 3 V behind a diode and 20 ohm, on a capacitor with 1000 ohm beside it.
std::string two_rectifiers(const std::string& u) {
  return model_text(R"x("elements": { "u": { "kind": "MSe", "effort": ")x" + u + R"x(" }, "i": { "kind": "1" },
    "d": { "kind": "D" }, "r": { "kind": "R", "resistance": 10 }, "out": { "kind": "0" },
    "c": { "kind": "C", "capacitance": 0.001, "initial": { "q": 0.001 } }, "load": { "kind": "R", "resistance": 1000 },
    "u2": { "kind": "Se", "effort": 3 }, "i2": { "kind": "1" }, "d2": { "kind": "D" },
    "r2": { "kind": "R", "resistance": 20 } },
    "bonds": [ { "from": "u", "to": "i" }, { "from": "i", "to": "d" }, { "from": "i", "to": "r" },
      { "from": "i", "to": "out" }, { "from": "out", "to": "c" }, { "from": "out", "to": "load" },
      { "from": "u2", "to": "i2" }, { "from": "i2", "to": "d2" }, { "from": "i2", "to": "r2" },
      { "from": "i2", "to": "out" } ],
    "scenes": { "s": { "stop": 1, "samples": 3 } })x");
}

/// A force presses a mass on a spring of 100 N/m against a stop at 0.1 m.
std::string stop(double force) {
  return model_text(R"x("elements": { "v": { "kind": "1" }, "m": { "kind": "I", "inertance": 2 },
    "k": { "kind": "C", "capacitance": 0.01 }, "d": { "kind": "R", "resistance": 5 },
    "f": { "kind": "Se", "effort": )x" +
                    std::to_string(force) + R"x( },
    "stop": { "kind": "contact", "gap": 0.1, "restitution": 0.3 } },
    "bonds": [ { "from": "f", "to": "v" }, { "from": "v", "to": "m" }, { "from": "v", "to": "k" },
      { "from": "v", "to": "d" }, { "from": "v", "to": "stop" } ],
    "scenes": { "s": { "stop": 3, "samples": 3 } })x");
}

}  // namespace

// Linear circuits: a few roundings. Conductances of what conducts, times their voltages, are what flows.
TEST_CASE("diodes are on the sides that the steady state has, not those of the start") {
  const auto rest = [](double u, bool first, bool second) {
    return ((first ? u / 10.0 : 0.0) + (second ? 3.0 / 20.0 : 0.0)) /
           (0.001 + (first ? 0.1 : 0.0) + (second ? 0.05 : 0.0));
  };
  struct Case {
    double u;
    bool first, second;
  };
  for (const Case& each : {Case{-5.0, false, true}, Case{2.9, false, true}, Case{2.99, true, true},
                           Case{8.0, true, false}, Case{3.0, true, true}}) {
    INFO("u = " << each.u);
    for (const bool all : {true, false}) {
      const SteadyStates states = steady(two_rectifiers(std::to_string(each.u)), {all});
      REQUIRE(states.found.size() == 1);
      CHECK(states.switches == 2);
      CHECK(states.found[0].mode == Mode{each.first, each.second});
      CHECK(states.found[0].leaves.empty());
      CHECK(states.found[0].stability == Equilibrium::Stability::stable);
      CHECK(value(states.found[0], "c.q") == Approx(0.001 * rest(each.u, each.first, each.second)).epsilon(1e-13));
    }
  }
  // Where no switch stays on its side, equilibria of modes alone are none.
  const Study study = Study::from_text(two_rectifiers("-5"));
  const std::vector<Equilibrium> of_mode =
      equilibria(study.in_mode({true, true}).shared_model(), prepare_scene(study.model(), "s"));
  REQUIRE(of_mode.size() == 1);
  CHECK(of_mode[0].leaves == std::vector<ElementId>{ElementId(2)});
  CHECK_THAT(of_mode[0].found, Contains("d conducts in this mode, and its condition says otherwise"));
}

TEST_CASE("sources are held as they are just after the time asked for, in runs to the rest as well") {
  // At t = 2 the source jumps from -5 to 8.
  const Study study = Study::from_text(two_rectifiers("if(t >= 2, 8, -5)"));
  RunInputs scene = prepare_scene(study.model(), "s");
  scene.start = 2.0;
  const SteadyStates states = steady_states(study, scene);
  REQUIRE(states.found.size() == 1);
  CHECK(value(states.found[0], "c.q") == Approx(0.001 * 0.8 / 0.101).epsilon(1e-13));
}

TEST_CASE("of a long ladder of diodes all conduct", "[long]") {
  // Each section takes one look at a mode: what is before it has to conduct first.
  constexpr int kSections = 40;
  std::string elements = R"x("u": { "kind": "Se", "effort": 5 })x", bonds, before = "u";
  for (int i = 0; i < kSections; ++i) {
    const std::string n = std::to_string(i);
    elements += ", \"j" + n + R"x(": { "kind": "1" }, "r)x" + n + R"x(": { "kind": "R", "resistance": 2 }, "d)x" + n +
                R"x(": { "kind": "D" }, "o)x" + n + R"x(": { "kind": "0" }, "c)x" + n +
                R"x(": { "kind": "C", "capacitance": 1 })x";
    for (const std::string& to : {"r" + n, "d" + n, "o" + n})
      bonds += (bonds.empty() ? "{ \"from\": \"" : ", { \"from\": \"") + ("j" + n) + "\", \"to\": \"" + to + "\" }";
    bonds += ", { \"from\": \"" + before + "\", \"to\": \"j" + n + "\" }, { \"from\": \"o" + n + "\", \"to\": \"c" + n +
             "\" }";
    before = "o" + n;
  }
  elements += R"x(, "load": { "kind": "R", "resistance": 20 })x";
  bonds += ", { \"from\": \"" + before + "\", \"to\": \"load\" }";
  const SteadyStates states = steady(model_text("\"elements\": { " + elements + " }, \"bonds\": [ " + bonds +
                                                " ], \"scenes\": { \"s\": { \"stop\": 1, \"samples\": 3 } }"));
  REQUIRE(states.found.size() == 1);
  CHECK(states.found[0].mode == Mode(kSections, true));
  // 5 V over 100 ohm.
  for (const int i : {0, 17, kSections - 1})
    CHECK(value(states.found[0], "c" + std::to_string(i) + ".q") == Approx(5.0 - 0.05 * 2.0 * (i + 1)).epsilon(1e-12));
}

TEST_CASE("a mass rests at its stop where the force presses it there, else before it") {
  for (const double force : {5.0, 9.99, 10.01, 30.0, 1e4}) {
    INFO("force " << force);
    const bool pressed = force > 10.0;
    const SteadyStates states = steady(stop(force));
    REQUIRE(states.found.size() == 1);
    CHECK(states.found[0].mode == Mode{!pressed});
    const double rest = pressed ? 0.1 : force / 100.0;
    // At the stop the spring is where the run's way has ended, to its tolerance; the contact is put to its gap.
    CHECK(value(states.found[0], "k.q") == Approx(rest).epsilon(pressed ? 1e-5 : 1e-12));
    CHECK(value(states.found[0], "stop.q") == Approx(rest).epsilon(1e-12));
    if (pressed) CHECK(states.found[0].free == std::vector<std::string>{"k.q"});
  }
}

TEST_CASE("a ball comes to rest on the ground") {
  const Study study = study_of("models/ball_contact.json");
  const SteadyStates states = steady_states(study, prepare_scene(study.model(), ""));
  REQUIRE(states.found.size() == 1);
  CHECK(states.found[0].mode == Mode{false});
  CHECK(states.found[0].stability == Equilibrium::Stability::stable);
  CHECK(states.found[0].free.empty());
}

TEST_CASE("of a switch with hysteresis both sides may rest, or neither", "[long]") {
  const auto text = [](double source, double load) {
    return model_text(R"x("elements": { "u": { "kind": "Se", "effort": )x" + std::to_string(source) + R"x( },
      "i": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 }, "out": { "kind": "0" },
      "c": { "kind": "C", "capacitance": 1 }, "il": { "kind": "1" },
      "s": { "kind": "Sw", "close": "c.e > 3", "open": "c.e < 1" },
      "load": { "kind": "R", "resistance": )x" +
                      std::to_string(load) + R"x( } },
      "bonds": [ { "from": "u", "to": "i" }, { "from": "i", "to": "r" }, { "from": "i", "to": "out" },
        { "from": "out", "to": "c" }, { "from": "out", "to": "il" }, { "from": "il", "to": "s" },
        { "from": "il", "to": "load" } ],
      "scenes": { "s": { "stop": 10, "samples": 3 } })x");
  };
  const SteadyStates both = steady(text(2.5, 1.0));
  REQUIRE(both.found.size() == 2);
  CHECK(value(both.found[0], "c.q") == Approx(2.5).epsilon(1e-13));
  CHECK(both.found[0].mode == Mode{false});
  CHECK(value(both.found[1], "c.q") == Approx(1.25).epsilon(1e-13));
  CHECK(both.found[1].mode == Mode{true});
  // Open it charges beyond 3 V, closed it comes below 1 V: it switches on and off.
  const Study none = Study::from_text(text(4.0, 0.1));
  std::string message;
  try {
    steady_states(none, prepare_scene(none.model(), "s"));
  } catch (const ModelError& error) {
    message = render(error);
  }
  CHECK_THAT(message, Contains("BG412") && Contains("in 2 modes of its switches") &&
                          Contains("in the mode s open there is a rest at which \"s\" leaves its side") &&
                          Contains("in the mode s closed there is a rest at which \"s\" leaves its side"));
  // Several starts lead to the same rest.
  const auto times_of = [&message](const std::string& words) {
    std::size_t count = 0;
    for (std::size_t at = message.find(words); at != std::string::npos; at = message.find(words, at + 1)) ++count;
    return count;
  };
  CHECK(times_of("in the mode s open there is") == 1);
  CHECK(times_of("in the mode s closed there is") == 1);
}
