// The estimated error of outputs against their true one.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "support/fed_states.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// @param stop  of a scene with 101 records.
std::string model(const std::vector<FedState>& states, double stop) {
  return fed_states(states, "\"stop\": " + std::to_string(stop) + ", \"samples\": 101");
}

struct System {
  std::string name;
  double stop;
  std::vector<FedState> states;
};

const std::vector<System> kSystems = {
    {"predator and prey", 30, {{"x", "3", "x.q*(1 - y.q)"}, {"y", "2", "y.q*(x.q - 1)"}}},
    {"oscillator", 60, {{"x", "1", "y.q"}, {"y", "0", "-x.q"}}},
    {"damped and driven", 60, {{"x", "0", "y.q"}, {"y", "0", "sin(1.1*t) - x.q - 0.1*y.q"}}},
    {"van der Pol", 20, {{"x", "2", "y.q"}, {"y", "0", "5*(1 - x.q^2)*y.q - x.q"}}},
    {"Duffing", 30, {{"x", "1", "y.q"}, {"y", "0", "0.3*cos(1.2*t) + x.q - x.q^3 - 0.2*y.q"}}},
    {"Brusselator", 20, {{"x", "1.2", "1 + x.q^2*y.q - 4*x.q"}, {"y", "3.1", "3*x.q - x.q^2*y.q"}}},
    {"pendulum", 20, {{"x", "2.5", "y.q"}, {"y", "0", "-sin(x.q)"}}},
    {"stiff beside slow", 20, {{"x", "0", "-1e5*(x.q - sin(t))"}, {"y", "1", "x.q*y.q"}}},
    {"growth", 10, {{"x", "1e-3", "x.q"}, {"y", "0", "x.q"}}},
    {"threshold", 30, {{"x", "0.31", "x.q*(x.q - 0.3)*(1 - x.q)"}}},
    {"a switch of a state", 20, {{"x", "0", "y.q"}, {"y", "1", "-x.q*if(x.q > 0, 1, 25)"}}},
    {"a gate of a phase", 20, {{"x", "0", "1 + 0.5*sin(x.q)"}, {"y", "0", "if(sin(5*x.q) > 0.3, 1, -0.5*y.q)"}}}};

/// Largest errors of the outputs, relative to their ranges: true by a run at a tolerance a hundred thousand times
/// smaller.
struct Errors {
  double exact, estimate;
};

/// By a method of another kind and a tolerance a hundred thousand times smaller.
RunResult reference_of(const System& system) {
  SimulateOptions only_trace;
  only_trace.energy_audit = only_trace.error_estimate = false;
  const bool stiff = system.name == "stiff beside slow";
  const RunResult result =
      run_text(model(system.states, system.stop),
               stiff ? with_method(Method::dirk5, 1e-11) : with_method(Method::erk8, 1e-12), only_trace);
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

Errors errors_of(const System& system, const RunResult& exact, const SceneOverrides& how) {
  const RunResult result = run_text(model(system.states, system.stop), how);
  REQUIRE(result.stop == StopReason::completed);
  REQUIRE(result.report.errors.done);
  Errors worst{0.0, 0.0};
  for (std::size_t k = 0; k < result.trace.columns.size(); ++k) {
    const std::vector<double>& column = exact.trace.columns[k];
    const auto [least, most] = std::minmax_element(column.begin(), column.end());
    worst.exact = std::max(worst.exact, largest_difference(result.trace.columns[k], column) / (*most - *least));
    worst.estimate = std::max(worst.estimate, result.report.errors.estimate[k] / result.report.errors.range[k]);
  }
  return worst;
}

}  // namespace

TEST_CASE("the error of outputs is estimated to within a factor of five, by every method", "[long]") {
  for (const System& system : kSystems) {
    const RunResult exact = reference_of(system);
    for (const Method method : {Method::bdf, Method::adams, Method::ida, Method::erk4, Method::erk5, Method::dirk4,
                                Method::radau, Method::radau9, Method::radau13, Method::rodas5p}) {
      const Errors errors = errors_of(system, exact, with_method(method, 1e-6));
      INFO(system.name << ", " << facts_of(method).name << ": " << errors.exact << ", estimated " << errors.estimate);
      // A millionth of a range is what the references are good for, events included, with room.
      if (errors.exact < 1e-6) {
        CHECK(errors.estimate < 5e-6);
        continue;
      }
      CHECK(errors.estimate > errors.exact / 5.0);
      CHECK(errors.estimate < errors.exact * 5.0);
    }
  }
}

TEST_CASE("the error of outputs of one-step methods is estimated to within a factor of two and a half") {
  // Where x leaves the slow manifold the slopes change within a step as much as they are. In one part for each step the
  // estimate of radau was 3.7 times too small, that of dirk4 3.6 times too large.
  const System relaxation{
      "relaxation oscillation", 97.812, {{"x", "2", "76.7*(x.q - x.q^3/3) - y.q"}, {"y", "0", "x.q"}}};
  const RunResult exact = reference_of(relaxation);
  // Ten times its tolerance.
  const double of_reference = errors_of(relaxation, exact, with_method(Method::erk8, 1e-11)).exact;
  for (const Method method : {Method::erk5, Method::dirk4, Method::radau, Method::rodas5p}) {
    const Errors errors = errors_of(relaxation, exact, with_method(method, 1e-6));
    INFO(facts_of(method).name << ": " << errors.exact << ", estimated " << errors.estimate);
    CHECK(errors.exact > 1e3 * of_reference);  // beyond what the reference is good for
    CHECK(errors.estimate > errors.exact / 2.5);
    CHECK(errors.estimate < errors.exact * 2.5);
  }
}

TEST_CASE("the error of an orbit is estimated to within a factor of one and a half where slopes change fast") {
  // At its closest approach: with no more than halves of a step the estimates were 1.3, 2.2 and 3 times too small. A
  // quarter of what is added may be left out in each step.
  for (const double e : {0.7, 0.8, 0.85}) {
    const System orbit{"orbit",
                       20,
                       {{"x", std::to_string(1.0 - e), "u.q"},
                        {"y", "0", "v.q"},
                        {"u", "0", "-x.q/hypot(x.q, y.q)^3"},
                        {"v", std::to_string(std::sqrt((1.0 + e) / (1.0 - e))), "-y.q/hypot(x.q, y.q)^3"}}};
    const Errors errors = errors_of(orbit, reference_of(orbit), with_method(Method::radau, 1e-6));
    INFO(e << ": " << errors.exact << ", estimated " << errors.estimate);
    CHECK(errors.exact > 1e-5);  // beyond what the reference is good for
    CHECK(errors.estimate > errors.exact / 1.5);
    CHECK(errors.estimate < errors.exact * 1.5);
  }
}

TEST_CASE("the error of an oscillation grows over thousands of periods, and so does its estimate", "[long]") {
  // x = cos(t). Carried along by a function of second order in the step, the estimate stayed below 1e-4 from a thousand
  // periods on, and nothing was noted of errors of 2e-3. The stiff state is x but for 1e-4.
  const std::vector<FedState> oscillator{{"x", "1", "y.q"}, {"y", "0", "-x.q"}};
  std::vector<FedState> beside_stiff = oscillator;
  beside_stiff.push_back({"z", "1", "1e4*(x.q - z.q)"});
  for (const auto& [states, method] :
       std::vector<std::pair<std::vector<FedState>, Method>>{{oscillator, Method::automatic},
                                                             {oscillator, Method::rodas5p},
                                                             {oscillator, Method::erk5},
                                                             {oscillator, Method::bdf},
                                                             {beside_stiff, Method::automatic},
                                                             {beside_stiff, Method::rodas5p}}) {
    INFO(facts_of(method).name << ", " << states.size() << " states");
    const RunResult result = run_text(model(states, 3.2e4), with_method(method, 1e-6));
    REQUIRE(result.stop == StopReason::completed);
    double exact = 0.0;
    for (std::size_t k = 0; k < result.trace.times.size(); ++k)
      exact = std::max(exact, std::abs(result.trace.columns[0][k] - std::cos(result.trace.times[k])));
    CHECK(exact > 1e-4);
    const double estimate = result.report.errors.estimate[0];
    CHECK(estimate > exact / 2.0);
    CHECK(estimate < exact * 2.0);
  }
}

TEST_CASE("the error within steps is estimated to within a factor of two") {
  // A tank behind a root, and two rotors with a shaft, with many records in each step. Radau's ends are six times as
  // good as what is between them, and so was the estimate; erk8's estimate was half of the error.
  const std::vector<std::vector<FedState>> systems{
      {{"h", "0.5", "1 + 0.5*sin(t) - sqrt(h.q)"}},
      {{"v", "0", "3 + 1.5*sin(3*t) - 5*x.q"}, {"w", "0", "2.5*x.q - 0.2*w.q"}, {"x", "0", "v.q - w.q"}}};
  for (const auto& states : systems) {
    const std::string text = fed_states(states, "\"stop\": 20, \"samples\": 2001");
    const RunResult exact = run_text(text, with_method(Method::radau, 1e-12));
    for (const Method method : {Method::radau, Method::erk5, Method::erk8, Method::dirk4, Method::dirk5}) {
      const RunResult run = run_text(text, with_method(method, 1e-6));
      REQUIRE(run.report.errors.done);
      for (std::size_t k = 0; k < run.trace.names.size(); ++k) {
        double error = 0.0;
        for (std::size_t i = 0; i < run.trace.times.size(); ++i)
          error = std::max(error, std::abs(run.trace.columns[k][i] - exact.trace.columns[k][i]));
        INFO(method_name(method) << ' ' << run.trace.names[k] << ": " << error);
        CHECK(run.report.errors.estimate[k] > error / 2.0);
        CHECK(run.report.errors.estimate[k] < error * 2.0);
      }
    }
  }
}

TEST_CASE("outputs that are wrong by more than a ten thousandth of their range are noted") {
  const auto noted = [](const RunResult& result) {
    return std::any_of(result.report.notes.begin(), result.report.notes.end(),
                       [](const std::string& note) { return note.find("estimated to be wrong") != std::string::npos; });
  };
  const std::string text = model(kSystems[0].states, kSystems[0].stop);
  CHECK(noted(run_text(text, with_method(Method::bdf, 1e-5))));
  CHECK_FALSE(noted(run_text(text, with_method(Method::bdf, 1e-10))));
  SimulateOptions options;
  options.error_estimate = false;
  const RunResult without = run_text(text, with_method(Method::bdf, 1e-5), options);
  CHECK_FALSE(noted(without));
  CHECK(without.report.errors.why_not == "switched off");
}

TEST_CASE(
    "outputs that are zero by structure are not noted for their rounding, but those that should be zero and are not") {
  // Balances of laws, of a linear and of a nonlinear exchange, whose terms cancel but for rounding; and an invariant
  // of the exact solution, which no method keeps.
  const auto with_outputs = [](const std::vector<FedState>& states, double stop, const std::string& outputs) {
    std::string text = model(states, stop);
    const std::string head = "\"outputs\": { ";
    return text.insert(text.find(head) + head.size(), outputs + ", ");
  };
  const std::string lotka = with_outputs(kSystems[0].states, kSystems[0].stop,
                                         R"x("angle": "sin(x.q)*cos(y.q) + cos(x.q)*sin(y.q) - sin(x.q + y.q)",
          "square": "(x.q + y.q)^2 - x.q^2 - 2*x.q*y.q - y.q^2",
          "invariant": "x.q - log(x.q) + y.q - log(y.q) - (5 - log(6))")x");
  const std::string exchange =
      with_outputs({{"x", "1", "2*y.q - x.q"}, {"y", "0", "x.q - 2*y.q"}}, 10, R"x("sum": "x.q + y.q - 1")x");
  const std::string turning =
      with_outputs({{"x", "1", "y.q - z.q"}, {"y", "0", "z.q - x.q"}, {"z", "0", "x.q - y.q"}}, 600,
                   R"x("sum": "x.q + y.q + z.q - 1", "radius": "x.q^2 + y.q^2 + z.q^2 - 1")x");
  const auto notes_of = [](const RunResult& result) {
    std::string text;
    for (const std::string& note : result.report.notes)
      if (note.find("estimated to be wrong") != std::string::npos) text += note;
    return text;
  };
  for (const Method method :
       {Method::bdf, Method::adams, Method::ida, Method::erk5, Method::dirk4, Method::radau, Method::rodas5p}) {
    INFO(facts_of(method).name);
    const std::string of_lotka = notes_of(run_text(lotka, with_method(method, 1e-6)));
    CHECK(of_lotka.find("angle") == std::string::npos);
    CHECK(of_lotka.find("square") == std::string::npos);
    CHECK(of_lotka.find("invariant") != std::string::npos);
    CHECK(notes_of(run_text(exchange, with_method(method, 1e-6))).empty());
    const std::string of_turning = notes_of(run_text(turning, with_method(method, 1e-6)));
    CHECK(of_turning.find("sum") == std::string::npos);
    CHECK(of_turning.find("radius") != std::string::npos);
  }
}

TEST_CASE("outputs whose range is small beside their magnitude are noted, but not those that stand still") {
  // exp(1e-4 t) as a ratio of two states, each known to 1e-6: within 1e-3 of the ratio's range of 1e-3.
  const std::string states = model({{"a", "1", "-a.q"}, {"b", "1", "-1.0001*b.q"}}, 10);
  const auto noted = [&states](const std::string& value, double relative) {
    std::string text = states;
    const std::string head = "\"outputs\": { ";
    text.insert(text.find(head) + head.size(), "\"ratio\": \"" + value + "\", ");
    const RunResult result = run_text(text, with_method(Method::bdf, relative));
    return std::any_of(result.report.notes.begin(), result.report.notes.end(), [](const std::string& note) {
      return note.find("wrong") != std::string::npos && note.find("\"ratio\"") != std::string::npos;
    });
  };
  CHECK(noted("a.q/b.q", 1e-6));
  CHECK_FALSE(noted("a.q/b.q", 1e-10));
  CHECK_FALSE(noted("2 + 1e-9*a.q", 1e-6));
}

TEST_CASE("friction that is held forgets errors, and a block at rest has none") {
  // Each time the block stops, the spring's and its own motion begin again: errors do not add up. Carried along with
  // the force of friction as a constant, they were estimated at 97 % of the range where they are 7e-6 of it.
  const auto block = [](const std::string& push) {
    return R"json({ "bgsim": 1, "name": "block", "elements": {
      "push": { "kind": "Se", "effort": ")json" +
           push + R"json(" }, "v": { "kind": "1" }, "m": { "kind": "I", "inertance": 0.743 },
      "spring": { "kind": "C", "capacitance": 0.0125 }, "friction": { "kind": "R", "law": "e = 0.86*f + 1.3*sign(f)" } },
    "bonds": [ { "from": "push", "to": "v" }, { "from": "v", "to": "m" }, { "from": "v", "to": "spring" },
      { "from": "v", "to": "friction" } ],
    "outputs": { "x": "spring.q", "v": "m.f" }, "scenes": { "main": { "stop": 30, "samples": 41 } } })json";
  };
  const auto notes = [](const RunResult& result) { return result.report.notes.size(); };
  const RunResult exact = run_text(block("3*sin(0.95*t)"), with_method(Method::erk8, 1e-12));
  for (const Method method :
       {Method::bdf, Method::adams, Method::erk5, Method::dirk4, Method::radau, Method::rodas5p}) {
    INFO(facts_of(method).name);
    const RunResult moving = run_text(block("3*sin(0.95*t)"), with_method(method, 1e-6));
    REQUIRE(moving.report.errors.done);
    for (std::size_t k = 0; k < 2; ++k) {
      const double range = moving.report.errors.range[k];
      const double error = largest_difference(moving.trace.columns[k], exact.trace.columns[k]) / range;
      CHECK(error < 1e-4);  // a hundred tolerances, over ten strokes
      CHECK(moving.report.errors.estimate[k] / range < 1e-4);
      CHECK(moving.report.errors.estimate[k] / range > 0.1 * error - 1e-7);
    }
    CHECK(notes(moving) == 0);
    CHECK(notes(run_text(block("1.2*sin(0.95*t)"), with_method(method, 1e-6))) == 0);
  }
}

TEST_CASE("errors are estimated where a law has no slope at rest") {
  // Two tanks that come to one level through a turbulent pipe.
  const std::string tanks = R"json({ "bgsim": 1, "name": "tanks", "elements": {
      "a": { "kind": "0" }, "b": { "kind": "0" }, "l": { "kind": "1" },
      "one": { "kind": "C", "capacitance": 0.7992718519047682, "initial": { "e": 64675.86602986671 } },
      "two": { "kind": "C", "capacitance": 1.4930359313052226 },
      "pipe": { "kind": "R", "law": "f = 0.07036223159283349*sign(e)*sqrt(abs(e))" } },
    "bonds": [ { "from": "a", "to": "one" }, { "from": "b", "to": "two" }, { "from": "a", "to": "l" },
      { "from": "l", "to": "b" }, { "from": "l", "to": "pipe" } ],
    "outputs": { "h1": "one.e", "h2": "two.e" }, "scenes": { "main": { "stop": 11289, "samples": 41 } } })json";
  for (const Method method : {Method::bdf, Method::ida, Method::radau, Method::rodas5p}) {
    INFO(facts_of(method).name);
    const RunResult result = run_text(tanks, with_method(method, 1e-6));
    REQUIRE(result.stop == StopReason::completed);
    CHECK(result.report.errors.done);
    CHECK(result.report.notes.empty());
  }
}

TEST_CASE("a condition that a run misses by less than it is wrong is noted, where it matters") {
  // The oscillation passes its border by 5e-7 of its amplitude, for 2e-3 in each period: all of what y is. BDF loses
  // more than that in a few periods.
  const auto notes_of = [](const std::string& rate) {
    const std::string text =
        fed_states({{"x", "0", "v.q"}, {"v", "1", "-x.q"}, {"y", "0", rate}}, "\"stop\": 60, \"samples\": 61");
    std::string all;
    const RunResult run = run_text(text, with_method(Method::bdf, 1e-6));
    REQUIRE(run.stop == StopReason::completed);
    for (const std::string& note : run.report.notes) all += note + "\n";
    return all;
  };
  const std::string jump = "if(x.q > 0.9999995, 1, 0)", kink = "max(x.q - 0.9999995, 0)";
  CHECK(notes_of(jump).find("comes as near to its border as the run is estimated to be wrong") != std::string::npos);
  // far from the border, or where nothing jumps there, there is nothing to note
  CHECK(notes_of("if(x.q > 1.5, 1, 0)").find("near to its border") == std::string::npos);
  CHECK(notes_of(kink).find("near to its border") == std::string::npos);
}

TEST_CASE("a sample that is rounded beside the border between two ticks is noted") {
  // At t = 1 the state is exp(-1): in one model the border between two ticks, in the other the middle of a tick.
  const auto notes_of = [](const std::string& tick, Method method) {
    const std::string text = R"x({"bgsim": 1, "name": "encoder", "parameters": {"tick": ")x" + tick + R"x("},
      "signals": {"seen": {"value": "tick*round(c.q/tick)", "every": 1}},
      "elements": {"j": {"kind": "0"}, "c": {"kind": "C", "capacitance": 1, "initial": {"q": 1}},
        "r": {"kind": "R", "resistance": 1}, "d": {"kind": "C", "capacitance": 1}, "i": {"kind": "MSf", "flow": "seen"}},
      "bonds": [{"from": "j", "to": "c"}, {"from": "j", "to": "r"}, {"from": "i", "to": "d"}],
      "outputs": {"q": "c.q", "sum": "d.q"}, "scenes": {"s": {"stop": 1.5, "samples": 31}}})x";
    const RunResult run = run_text(text, with_method(method, 1e-6));
    REQUIRE(run.stop == StopReason::completed);
    std::string all;
    for (const std::string& note : run.report.notes) all += note + "\n";
    return all;
  };
  for (const Method method : {Method::adams, Method::bdf, Method::ida, Method::erk4, Method::radau}) {
    CAPTURE(facts_of(method).name);
    const std::string border = notes_of("exp(-1)/10.5", method), middle = notes_of("exp(-1)/10", method);
    // Beside the border the run is on one side and the exact solution perhaps on the other.
    const bool doubtful = border.find("what \"seen\" is set to is as near to a border") != std::string::npos,
               wrong = border.find("estimated to be wrong") != std::string::npos;
    CHECK((doubtful || wrong));
    CHECK(middle.empty());
  }
}
