// Conditions that make no jump before a store that depends on them, and conditions that do.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// C straight across a source of any effort: its flow is capacitance times the effort's derivative.
std::string across(const std::string& effort, double stop = 4.0, const std::string& elements = "") {
  return R"({"bgsim": 1, "name": "across", "parameters": {"low": 1, "high": 2}, "elements": {
    "source": {"kind": "MSe", "effort": ")" +
         effort + R"("}, "c": {"kind": "C", "capacitance": 2}, "fill": {"kind": "Sf", "flow": 1},
    "tank": {"kind": "C", "capacitance": 1, "initial": {"q": 0.25}})" +
         elements + R"(}, "bonds": [{"from": "source", "to": "c"}, {"from": "fill", "to": "tank"}],
    "outputs": {"f": "c.f", "q": "c.q", "level": "tank.q"},
    "scenes": {"run": {"stop": )" +
         std::to_string(stop) + R"(, "samples": 9}}})";
}

std::string failure(const std::string& text) {
  try {
    const RunResult run = run_text(text);
    return run.failure ? "run: " + run.failure->code + " " + run.failure->situation : "completed";
  } catch (const ModelError& error) {
    return error.diagnostics.front().code + " " + error.diagnostics.front().situation;
  }
}

}  // namespace

TEST_CASE("A condition that is continuous at its border may stand before a store that depends on it") {
  // The derivative is known by hand between the borders, which no sample meets.
  const std::vector<double> triangle{-2, -2, 2, 2, -2, -2, 2, 2, -2};
  CHECK(column(run_text(across("abs(t - 2*floor(t/2) - 1)", 4.5)), "f") == triangle);
  const RunResult ramp = run_text(across("if(t < 1, t, 2*t - 1)"));
  CHECK(column(ramp, "f") == std::vector<double>{2, 2, 4, 4, 4, 4, 4, 4, 4});
  CHECK(last(run_text(across("mod(t, 1)*(1 - mod(t, 1))", 0.5)), "q") == Approx(0.5).epsilon(1e-14));
  // of a state: the tank's level passes 1 at t = 0.75
  const RunResult of_state = run_text(across("if(tank.q < 1, tank.q, tank.q^2)"));
  REQUIRE(of_state.stop == StopReason::completed);
  CHECK(last(of_state, "f") == Approx(4.0 * 4.25).epsilon(1e-6));
  CHECK(column(of_state, "f")[1] == Approx(2.0).epsilon(1e-6));
}

TEST_CASE("A condition that jumps before a store is refused, at the latest where it is met") {
  CHECK(failure(across("if(t < 1, low, high)")) ==
        "BG402 the time derivative of if(t < 1, low, high) is needed, but it jumps");
  CHECK(failure(across("floor(tank.q)")).substr(0, 5) == "BG402");
  CHECK(failure(across("if(t < 1, t, if(t < 2, 1, high))")).substr(0, 5) == "BG402");
  // Continuous with the model's own parameters: only the run can tell.
  const std::string text = across("if(t < 1, low, high - 1)");
  CHECK(failure(text) == "completed");
  const RunResult run = run_text(text, with_parameters({"high=3"}));
  REQUIRE(run.failure);
  CHECK(run.failure->code == "BG402");
  CHECK(run.failure->situation ==
        "the time derivative of if(t < 1, low, high - 1) is needed, but it jumps: from 1 to 2 at t = 1");
}

TEST_CASE("A store whose law jumps is refused before what determines it, also where the law has to be solved") {
  const auto across_law = [](const std::string& more) {
    return R"({"bgsim": 1, "name": "law", "elements": {"s": {"kind": "Se", "effort": "t"},
    "c": {"kind": "MC", "law": "e = q + q^3 + )" +
           more + R"("}}, "bonds": [{"from": "s", "to": "c"}], "outputs": {"f": "c.f", "q": "c.q"},
    "scenes": {"run": {"stop": 2, "samples": 5}}})";
  };
  CHECK(failure(across_law("if(t < 1, 0, 1)")).substr(0, 11) == "run: BG402 ");
  // t = q + q^3 + t - 1 from t = 1: q stays where q + q^3 = 1.
  const RunResult bent = run_text(across_law("if(t < 1, 0, t - 1)"));
  REQUIRE(bent.stop == StopReason::completed);
  CHECK(last(bent, "q") == Approx(0.6823278038280193).epsilon(1e-14));
  CHECK(column(bent, "f")[1] == Approx(0.649791102672498).epsilon(1e-12));
  CHECK(last(bent, "f") == 0.0);
}

TEST_CASE("a signal that jumps as it is sampled, set or late is refused before a dependent store") {
  // Two masses, the flow between which is the signal: its jump would be an impulse on both.
  const auto tied = [](const std::string& signal, const std::string& events = "") {
    return R"x({"bgsim": 1, "name": "tied", "signals": {"u": )x" + signal + R"x(}, "elements": {
      "a": {"kind": "1"}, "z": {"kind": "0"}, "b": {"kind": "1"}, "m1": {"kind": "I", "inertance": 1},
      "m2": {"kind": "I", "inertance": 1}, "s": {"kind": "MSf", "flow": "u"}},
      "bonds": [{"from": "a", "to": "m1"}, {"from": "a", "to": "z"}, {"from": "z", "to": "b"}, {"from": "b", "to": "m2"},
                {"from": "s", "to": "z"}])x" +
           events +
           R"x(, "outputs": {"p1": "m1.p", "sum": "m1.p + m2.p"}, "scenes": {"run": {"stop": 3, "samples": 4}}})x";
  };
  const std::string set = R"x(, "events": {"x": {"when": "t >= 0.5", "set": {"u": 1}}})x";
  struct Row {
    std::string model, words;
  };
  for (const Row& row :
       {Row{tied(R"x({"value": "sin(t)", "every": 1})x"), "is needed, but it jumps: from 0 to 0.841471 at t = 1"},
        Row{tied(R"x({"integral": "0"})x", set), "is needed, but it jumps: from 0 to 1 at t = 0.5"},
        Row{tied(R"x({"delay": "step(t - 0.5)", "by": 0.2})x"), "is needed, but it jumps: from 0 to 1 at t = 0.7"}}) {
    const RunResult run = run_text(row.model);
    REQUIRE(run.failure);
    CHECK(run.failure->code == "BG402");
    CHECK(run.failure->situation.find(row.words) != std::string::npos);
    REQUIRE_FALSE(run.failure->notes.empty());
    CHECK(run.failure->notes.front().text.find("is in derivative causality") != std::string::npos);
  }
  const auto refused = [](const std::string& text, const std::string& words) {
    const RunResult run = run_text(text);
    REQUIRE(run.failure);
    CHECK(run.failure->code == "BG402");
    CHECK(run.failure->situation.find(words) != std::string::npos);
  };
  // A source that follows a store that an event sets: both momenta would take the impulse.
  refused(R"x({"bgsim": 1, "name": "tied", "elements": {
      "a": {"kind": "1"}, "z": {"kind": "0"}, "b": {"kind": "1"}, "m1": {"kind": "I", "inertance": 1},
      "m2": {"kind": "I", "inertance": 1}, "s": {"kind": "MSf", "flow": "2*k.e"}, "n": {"kind": "0"},
      "k": {"kind": "C", "capacitance": 1}, "r": {"kind": "R", "resistance": 10}},
      "bonds": [{"from": "a", "to": "m1"}, {"from": "a", "to": "z"}, {"from": "z", "to": "b"}, {"from": "b", "to": "m2"},
                {"from": "s", "to": "z"}, {"from": "n", "to": "k"}, {"from": "n", "to": "r"}],
      "events": {"x": {"when": "t >= 1", "set": {"k.q": 1}}},
      "outputs": {"p1": "m1.p"}, "scenes": {"run": {"stop": 3, "samples": 4}}})x",
          "from 0 to 2 at t = 1");
  // A ratio that is sampled, between two masses.
  refused(R"x({"bgsim": 1, "name": "geared", "signals": {"u": {"value": "1 + sin(t)", "every": 1, "initial": 1}},
      "elements": {"a": {"kind": "1"}, "x": {"kind": "MTF", "modulus": "u"}, "b": {"kind": "1"},
        "m1": {"kind": "I", "inertance": 1, "initial": {"p": 1}}, "m2": {"kind": "I", "inertance": 1}},
      "bonds": [{"from": "a", "to": "m1"}, {"from": "a", "to": "x"}, {"from": "x", "to": "b"}, {"from": "b", "to": "m2"}],
      "outputs": {"p1": "m1.p"}, "scenes": {"run": {"stop": 3, "samples": 4}}})x",
          "of u is needed, but it jumps: from 1 to 1.84147 at t = 1");
  // der(...) of a signal that is sampled, or late with a jump, where nothing depends on another store.
  for (const std::string signal :
       {R"x({"value": "sin(t)", "every": 1})x", R"x({"delay": "step(t - 0.5)", "by": 0.2})x"})
    refused(R"x({"bgsim": 1, "name": "der", "signals": {"u": )x" + signal + R"x(, "v": "der(u)"}, "elements": {
        "z": {"kind": "0"}, "c": {"kind": "C", "capacitance": 1}, "s": {"kind": "MSf", "flow": "v"}},
        "bonds": [{"from": "s", "to": "z"}, {"from": "z", "to": "c"}],
        "outputs": {"q": "c.q"}, "scenes": {"run": {"stop": 3, "samples": 4}}})x",
            "is needed, but it jumps: from 0 to ");
  // A store that bonds tie to the one that an event sets is set with it.
  const RunResult set_together = run_text(R"x({"bgsim": 1, "name": "both", "elements": {"n": {"kind": "0"},
      "c1": {"kind": "C", "capacitance": 1}, "c2": {"kind": "C", "capacitance": 2}, "r": {"kind": "R", "resistance": 1}},
      "bonds": [{"from": "n", "to": "c1"}, {"from": "n", "to": "c2"}, {"from": "n", "to": "r"}],
      "events": {"x": {"when": "t >= 1", "set": {"c1.q": 3}}},
      "outputs": {"q2": "c2.q"}, "scenes": {"run": {"stop": 1, "samples": 2}}})x");
  REQUIRE_FALSE(set_together.failure);
  CHECK(last(set_together, "q2") == Approx(6.0).epsilon(1e-12));
  // What is sampled and does not change, or is late and has no jump, makes no impulse: p1 = -u/2.
  const RunResult constant = run_text(tied(R"x({"value": "0*t", "every": 1})x"));
  REQUIRE_FALSE(constant.failure);
  CHECK(last(constant, "p1") == 0.0);
  const RunResult ramp = run_text(tied(R"x({"delay": "max(t - 0.5, 0)", "by": 0.5})x"));
  REQUIRE_FALSE(ramp.failure);
  CHECK(last(ramp, "p1") == Approx(-1.0).epsilon(1e-6));  // the tolerance
  CHECK(last(ramp, "sum") == Approx(0.0).margin(1e-6));
}

TEST_CASE("the fourth derivative of a spline is 0 between its knots, and refused where it would have to be more") {
  // Delayed signals are cubics, too: behind two gyrators and a law with a kink the equations ask for that many.
  const std::string late = R"x({"bgsim": 1, "name": "late", "signals": {"u": {"delay": "i.p", "by": 0.4, "initial": 1}},
    "elements": {"j0": {"kind": "1"}, "j1": {"kind": "0"}, "j2": {"kind": "0"}, "j3": {"kind": "1"}, "j4": {"kind": "0"},
      "x0": {"kind": "GY", "modulus": 1}, "x3": {"kind": "GY", "modulus": 1}, "c": {"kind": "C", "capacitance": 1},
      "i": {"kind": "I", "inertance": 1, "initial": {"p": 1}}, "r": {"kind": "R", "law": "e = if(f > 0, 7*f, f)"}, "s": {"kind": "MSf", "flow": "u"}},
    "bonds": [{"from": "j0", "to": "x0"}, {"from": "x0", "to": "j1"}, {"from": "j3", "to": "x3"}, {"from": "x3", "to": "j4"},
      {"from": "j2", "to": "c"}, {"from": "j3", "to": "i"}, {"from": "j4", "to": "r"}, {"from": "s", "to": "j1"},
      {"from": "j0", "to": "j2"}, {"from": "j1", "to": "j3"}],
    "outputs": {"p": "i.p"}, "scenes": {"run": {"stop": 10, "samples": 26}}})x";
  // p' = (u' - p/7)/2, u' = 0 up to t = 0.4: 0.4 by hand, then by the method of steps with collocation at 25 points.
  for (const Method method : {Method::automatic, Method::bdf, Method::ida, Method::radau9}) {
    INFO(facts_of(method).name);
    const RunResult run = run_text(late, with_method(method, 1e-8));
    REQUIRE_FALSE(run.failure);
    // Three hundred tolerances: the slope of what was recorded is wrong by more than the record.
    CHECK(at(run, "p", 0.4) == Approx(std::exp(-0.4 / 14.0)).margin(3e-6));
    CHECK(at(run, "p", 4.0) == Approx(0.5837410713634705).margin(3e-6));
    CHECK(at(run, "p", 10.0) == Approx(0.23392580416189268).margin(3e-6));
  }
  // Of a spline itself: the third derivative is constant between its knots, the fourth would be impulses at them.
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "bgsim_fourth_derivative.csv";
  std::ofstream(file) << "t,u\n0,0\n1,1\n2,0\n3,2\n4,1\n";
  const auto differentiated = [&](int times) {
    std::string signals = R"x("d0": "table(')x" + file.string() + R"x(', 'u', t, spline)")x";
    for (int k = 1; k <= times; ++k)
      signals += R"x(, "d)x" + std::to_string(k) + R"x(": "der(d)x" + std::to_string(k - 1) + R"x()")x";
    return R"x({"bgsim": 1, "name": "spline", "signals": {)x" + signals + R"x(}, "elements": {"z": {"kind": "0"},
      "c": {"kind": "C", "capacitance": 1}, "s": {"kind": "MSf", "flow": "d)x" +
           std::to_string(times) + R"x("}},
      "bonds": [{"from": "s", "to": "z"}, {"from": "z", "to": "c"}],
      "outputs": {"q": "c.q", "d2": "d2"}, "scenes": {"run": {"stop": 4, "samples": 9}}})x";
  };
  const RunResult third = run_text(differentiated(3));
  REQUIRE_FALSE(third.failure);
  // q is the second derivative less what that is at the start: as good as the tolerance.
  CHECK(last(third, "q") == Approx(last(third, "d2") - column(third, "d2").front()).margin(1e-5));
  CHECK(failure(differentiated(4)).substr(0, 5) == "BG402");
  std::filesystem::remove(file);
}
