// Signals with memory: sampled and held, latched; and signals that are conditions.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const std::vector<Method> kMethods{Method::automatic, Method::bdf,   Method::adams,  Method::ida,     Method::erk5,
                                   Method::dirk4,     Method::radau, Method::radau9, Method::radau13, Method::rodas5p};

std::string model(const std::string& parameters, const std::string& signals, const std::string& graph,
                  const std::string& outputs, const std::string& scene) {
  return R"x({"bgsim": 1, "name": "memory", "parameters": {)x" + parameters + R"x(}, "signals": {)x" + signals + "}, " +
         graph + R"x(, "outputs": {)x" + outputs + R"x(}, "scenes": {"run": {)x" + scene + "}}}";
}

const std::string kSource = R"x("elements": {"s": {"kind": "MSe", "effort": "u"}, "r": {"kind": "R", "resistance": 1}},
  "bonds": [{"from": "s", "to": "r"}])x";

bool is_multistep(Method method) { return method == Method::bdf || method == Method::adams || method == Method::ida; }

RunResult completed(const std::string& text, const SceneOverrides& overrides = {}) {
  RunResult result = Study::from_text(text).scene({}, overrides).simulate(untimed());
  INFO((result.failure ? result.failure->situation : ""));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

}  // namespace

TEST_CASE("a sampled controller follows the recursion of its samples") {
  const double inertia = 0.1, friction = 0.2, every = 0.01, kp = 2, ki = 3, kd = 0.05;
  const std::string text = model(
      R"x("Ts": 0.01)x",
      R"x("err": {"value": "1 - w.f", "every": "Ts"}, "sum": {"value": "previous(sum) + 3*Ts*err", "every": "Ts"},
          "u": {"value": "min(max(2*err + sum + 0.05*(err - previous(err))/Ts, -3), 3)", "every": "Ts"})x",
      R"x("elements": {"motor": {"kind": "MSe", "effort": "u"}, "n": {"kind": "1"}, "w": {"kind": "I", "inertance": 0.1},
          "b": {"kind": "R", "resistance": 0.2}},
          "bonds": [{"from": "motor", "to": "n"}, {"from": "n", "to": "w"}, {"from": "n", "to": "b"}])x",
      R"x("w": "w.f", "u": "u", "old": "previous(err)")x", R"x("stop": 1, "samples": 101)x");
  for (const Method method : kMethods) {
    INFO(facts_of(method).name);
    const RunResult result = completed(text, with_method(method, 1e-8));
    const std::vector<double> w = column(result, "w"), u = column(result, "u"), old = column(result, "old");
    double speed = 0, error = 0, sum = 0, worst = 0;
    for (std::size_t n = 0; n < w.size(); ++n) {
      const double before = error;
      error = 1 - speed;
      sum += ki * every * error;
      const double force = std::clamp(kp * error + sum + kd * (error - before) / every, -3.0, 3.0);
      worst = std::max({worst, std::abs(w[n] - speed), std::abs(u[n] - force), std::abs(old[n] - before)});
      const double decay = std::exp(-friction / inertia * every);
      speed = speed * decay + force / friction * (1 - decay);
    }
    // Ten tolerances; multistep methods begin again at order 1 after each sample.
    CHECK(worst < (is_multistep(method) ? 5e-6 : 1e-7));
  }
}

TEST_CASE("samples are taken at offset + n every, whatever the rounding of records and of other intervals") {
  // u is the time of the latest sample, exact by its definition; records fall on samples and between.
  for (const double every : {0.1, 0.01, 1.0 / 3.0, 0.7, 1e-6, 3.3e5})
    for (const double offset : {0.0, 0.3})
      for (const double start : {0.0, 3.0}) {
        INFO(every << ", offset " << offset << ", start " << start);
        const double begin = start * every, shift = offset * every;
        const auto number = [](double x) { return number_text(x, 17); };
        const RunResult result = completed(
            model("\"Ts\": " + number(every),
                  R"x("u": {"value": "t", "every": "Ts", "offset": )x" + number(shift) + R"x(, "initial": -7})x",
                  kSource, R"x("u": "u")x",
                  "\"start\": " + number(begin) + ", \"stop\": " + number(begin + 40 * every) + ", \"samples\": 81"));
        const std::vector<double> u = column(result, "u");
        for (std::size_t row = 0; row < u.size(); ++row) {
          const double t = result.trace.times[row];
          const double latest = shift + every * std::floor((t - shift) / every + 1e-7);
          const bool none = latest < begin - 1e-7 * every || t < shift - 1e-7 * every;
          // Samples come 6e-14 of the time early; doubles of t.
          CHECK(std::abs(u[row] - (none ? -7.0 : latest)) <= 1e-12 * std::max(t, every));
        }
      }
}

TEST_CASE("samples of one instant are taken in the order of their dependence, previous ones are those before") {
  // b takes every third a, of the same instant although it is declared first; c depends on what follows it.
  const RunResult result =
      completed(model("", R"x("b": {"value": "a", "every": 0.3}, "a": {"value": "previous(a) + 1", "every": 0.1},
                              "c": {"value": "previous(d)", "every": 0.1}, "d": {"value": "10*c + through", "every": 0.1},
                              "through": "a", "u": "a + b")x",
                      kSource, R"x("a": "a", "b": "b", "c": "c", "d": "d")x", R"x("stop": 1, "samples": 21)x"));
  const std::vector<double> a = column(result, "a"), b = column(result, "b"), c = column(result, "c"),
                            d = column(result, "d");
  double old_d = 0, value_d = 0;
  for (std::size_t row = 0; row < a.size(); ++row) {
    const auto n = static_cast<double>(row / 2);
    CHECK(a[row] == n + 1);
    CHECK(b[row] == 3 * std::floor(n / 3) + 1);
    if (row % 2 == 0) {
      old_d = value_d;
      value_d = 10 * old_d + n + 1;
    }
    CHECK(c[row] == Approx(old_d).epsilon(1e-12));  // a state is an integral of 0: exact but for the jump's rounding
    CHECK(d[row] == Approx(value_d).epsilon(1e-12));
  }
}

TEST_CASE("a latch switches a heater on and off at the exact instants") {
  // T' = (60 u - T/0.5)/100 between 19 and 21, from 15: intervals by logarithms.
  const std::string text =
      model("", R"x("heating": {"set": "room.e < 19", "reset": "room.e > 21"}, "u": "if(heating, 60, 0)")x",
            R"x("elements": {"heater": {"kind": "MSf", "flow": "u"}, "n": {"kind": "0"},
                "room": {"kind": "C", "capacitance": 100, "initial": {"e": 15}}, "wall": {"kind": "R", "resistance": 0.5}},
                "bonds": [{"from": "heater", "to": "n"}, {"from": "n", "to": "room"}, {"from": "n", "to": "wall"}])x",
            R"x("T": "room.e", "on": "if(heating, 1, 0)")x", R"x("stop": 200, "samples": 201)x");
  const auto exact = [](double t) {
    const double tau = 50, up = 30;  // towards up while it heats, towards 0 else
    const double first = tau * std::log((up - 15) / (up - 21)), cool = tau * std::log(21.0 / 19.0),
                 heat = tau * std::log((up - 19) / (up - 21));
    if (t < first) return up - (up - 15) * std::exp(-t / tau);
    const double into = std::fmod(t - first, cool + heat);
    return into < cool ? 21 * std::exp(-into / tau) : up - (up - 19) * std::exp(-(into - cool) / tau);
  };
  for (const Method method : kMethods) {
    INFO(facts_of(method).name);
    const RunResult result = completed(text, with_method(method, 1e-8));
    const std::vector<double> temperature = column(result, "T");
    double worst = 0;
    for (std::size_t row = 0; row < temperature.size(); ++row)
      worst = std::max(worst, std::abs(temperature[row] - exact(result.trace.times[row])));
    // A hundred tolerances of 20, since the dense output of dirk4, by which changes are located, is a cubic; multistep
    // methods begin again at order 1 after each change.
    CHECK(worst < (is_multistep(method) ? 1e-4 : 2e-5));
    CHECK(column(result, "on")[0] == 1.0);
  }
}

TEST_CASE("a latch is reset where both conditions hold, and keeps its side where neither does") {
  const RunResult result =
      completed(model("", R"x("a": {"set": "t > 1", "reset": "t > 2 and t < 4", "initial": true},
                    "b": {"set": "t > 1.5", "reset": "t < 3"}, "c": {"set": "t < 1", "reset": "t > 9"},
                    "d": {"set": "a and t > 4.5", "reset": "not c"}, "u": "if(a, 1, 0)")x",
                      kSource, R"x("a": "if(a, 1, 0)", "b": "if(b, 1, 0)", "c": "if(c, 1, 0)", "d": "if(d, 1, 0)")x",
                      R"x("stop": 5, "interval": 0.5)x"));
  // At 0, 0.5, ..., 5. a: true, reset after 2, set again where the reset ends. b: held down until 3. c: at the start.
  CHECK(column(result, "a") == std::vector<double>{1, 1, 1, 1, 1, 0, 0, 0, 1, 1, 1});
  CHECK(column(result, "b") == std::vector<double>{0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1});
  CHECK(column(result, "c") == std::vector<double>{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1});
  CHECK(column(result, "d") == std::vector<double>{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1});
}

TEST_CASE("a signal that is a condition stands for its text") {
  const std::string graph = R"x("elements": {"s": {"kind": "MSe", "effort": "10*u"}, "n": {"kind": "1"},
      "sw": {"kind": "Sw", "closed": "gate"}, "l": {"kind": "I", "inertance": 0.1}, "r": {"kind": "R", "resistance": 2}},
      "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "sw"}, {"from": "n", "to": "l"}, {"from": "n", "to": "r"}])x";
  std::string written_out = graph;
  written_out.replace(written_out.find("\"gate\""), 6, R"x("mod(t, 0.3) < 0.2 and (t > 0.1 or 2*t < 0.1)")x");
  const std::string scene = R"x("stop": 1, "samples": 41)x", output = R"x("f": "l.f")x";
  const RunResult named = completed(model("", R"x("late": "t > 0.1 or 2*t < 0.1", "gate": "mod(t, 0.3) < 0.2 and late",
                              "u": "if(not gate, 1, 2)")x",
                                          graph, output, scene));
  const RunResult plain = completed(model(
      "", R"x("u": "if(not (mod(t, 0.3) < 0.2 and (t > 0.1 or 2*t < 0.1)), 1, 2)")x", written_out, output, scene));
  CHECK(column(named, "f") == column(plain, "f"));
  CHECK(*std::max_element(named.trace.columns[0].begin(), named.trace.columns[0].end()) > 1.0);
}

TEST_CASE("a condition chooses between a sample and a number") {
  const std::vector<double> u =
      column(completed(model("", R"x("in": {"value": "7*t", "every": 0.25}, "go": "t > 0.6", "u": "if(go, in, -1)")x",
                             kSource, R"x("u": "u")x", R"x("stop": 1, "samples": 5)x")),
             "u");
  CHECK(u[2] == -1.0);
  CHECK(u[3] == Approx(5.25).epsilon(1e-12));
  CHECK(u[4] == Approx(7.0).epsilon(1e-12));
}

TEST_CASE("signals with memory of one instant change together before any other condition is looked at") {
  // Two capacitors behind a switch that no consistent instant closes, and an event of the same condition.
  const auto run = [](const std::string& signals, const std::string& condition) {
    return completed(model("\"Ts\": 0.1", signals + R"x(, "n": {"integral": "0"})x",
                           R"x("elements": {"z1": {"kind": "0"}, "z2": {"kind": "0"}, "j": {"kind": "1"},
            "c1": {"kind": "C", "capacitance": 1, "initial": {"q": 1}}, "c2": {"kind": "C", "capacitance": 1, "initial": {"q": 0}},
            "s": {"kind": "Sw", "closed": ")x" +
                               condition + R"x("}},
          "bonds": [{"from": "z1", "to": "c1"}, {"from": "z1", "to": "j"}, {"from": "j", "to": "z2"}, {"from": "z2", "to": "c2"},
            {"from": "j", "to": "s"}],
          "events": {"e": {"when": ")x" +
                               condition + R"x(", "set": {"n": "pre(n) + 1"}}})x",
                           R"x("q1": "c1.q", "n": "n")x", R"x("stop": 1.05, "samples": 22)x"));
  };
  struct Row {
    std::string signals, condition;
  };
  const std::string counter = R"x("a": {"value": "previous(a) + 1", "every": "Ts"})x";
  for (const Row& row :
       {Row{counter + R"x(, "b": {"value": "a", "every": "Ts"})x", "a > b + 0.5 or b > a + 0.5"},
        Row{counter, "a < previous(a) + 0.5"},
        Row{R"x("a": {"value": "1 - previous(a)", "every": "Ts"}, "l": {"set": "a > 0.5", "reset": "a <= 0.5"})x",
            "(a > 0.5 and not l) or (l and a <= 0.5)"}}) {
    INFO(row.condition);
    const RunResult result = run(row.signals, row.condition);
    CHECK(result.report.mode_changes == 0);
    CHECK(last(result, "q1") == 1.0);
    // Before the first sample the second condition holds: that is not the start.
    CHECK(last(result, "n") == 0.0);
    for (const std::string& note : result.report.notes) CHECK(note.find("holds at the start") == std::string::npos);
  }
  // What holds with the first samples holds at the start, and does not become true there: the report says so.
  const RunResult from_start =
      completed(model("\"Ts\": 0.1", R"x("u": {"value": "1", "every": "Ts"}, "n": {"integral": "0"})x",
                      kSource + R"x(, "events": {"e": {"when": "u > 0.5", "set": {"n": "pre(n) + 1"}}})x",
                      R"x("n": "n")x", R"x("stop": 1.05, "samples": 22)x"));
  CHECK(last(from_start, "n") == 0.0);
  REQUIRE_FALSE(from_start.report.notes.empty());
  CHECK(from_start.report.notes.front().find("\"e\" holds at the start") != std::string::npos);
  // True from one sample to the next, the condition becomes true once: sin(7*t) rises four times, and goes on rising.
  const RunResult rising =
      completed(model("\"Ts\": 0.1", R"x("u": {"value": "sin(7*t)", "every": "Ts"}, "n": {"integral": "0"})x",
                      kSource + R"x(, "events": {"e": {"when": "u > previous(u)", "set": {"n": "pre(n) + 1"}}})x",
                      R"x("n": "n")x", R"x("stop": 3.05, "samples": 22)x"));
  CHECK(last(rising, "n") == 4.0);
}

TEST_CASE("latches that depend on each other in a circle change as they are declared") {
  // a needs c, which resets at the same instant; b needs a. Whatever is due is looked at from the first one again, so
  // only what c is when a is looked at decides.
  const std::map<std::string, std::string> declared{
      {"a", R"x("a": {"set": "c and on", "reset": "off"})x"},
      {"b", R"x("b": {"set": "a and on", "reset": "off"})x"},
      {"c", R"x("c": {"set": "b and off", "reset": "on", "initial": true})x"}};
  struct Row {
    std::string on, off, graph;
  };
  for (const Row& row :
       {Row{"x > 1", "x > 50", kSource}, Row{"t >= 1", "t >= 50", kSource},
        Row{"k > 0.5", "k > 50", kSource + R"x(, "events": {"e": {"when": "x >= 1", "set": {"k": "pre(k) + 1"}}})x"},
        Row{"late > 0.5", "late > 50", kSource}}) {
    std::vector<std::string> order{"a", "b", "c"};
    do {
      INFO(row.on << ", declared " << order[0] << order[1] << order[2]);
      std::string signals = R"x("x": {"integral": "1"}, "k": {"integral": "0"}, "u": "if(a, 1, 0)",
        "late": {"value": "k + x", "every": 1}, "on": ")x" +
                            row.on + R"x(", "off": ")x" + row.off + "\"";
      for (const std::string& name : order) signals += ", " + declared.at(name);
      std::vector<RunEvent> changes;
      SimulateOptions options = untimed();
      options.events = [&changes](const RunEvent& event) {
        if (event.kind == RunEvent::Kind::latch) changes.push_back(event);
      };
      const RunResult result = Study::from_text(model("", signals, row.graph,
                                                      R"x("a": "if(a, 1, 0)", "b": "if(b, 1, 0)", "c": "if(c, 1, 0)")x",
                                                      R"x("stop": 2.5, "samples": 2)x"))
                                   .scene()
                                   .simulate(options);
      REQUIRE(result.stop == StopReason::completed);
      const bool first = std::find(order.begin(), order.end(), "a") < std::find(order.begin(), order.end(), "c");
      CHECK(last(result, "a") == (first ? 1.0 : 0.0));
      CHECK(last(result, "b") == (first ? 1.0 : 0.0));
      CHECK(last(result, "c") == 0.0);
      // The report counts what the table lists: changes, and not that nothing sets or resets a latch at the start.
      std::uint64_t counted = 0;
      for (const RunReport::SetEvent& event : result.report.set_events)
        if (event.name.back() == ')') counted += event.count;
      CHECK(counted == changes.size());
      CHECK(changes.size() == (first ? 3 : 1));
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

TEST_CASE("a latch comes after those that it depends on, wherever it is declared") {
  // No circle: "free" is set where "taken" is not, and both could be set at t = 1.
  const std::string free = R"x("free": {"set": "not taken and t >= 1", "reset": "t >= 50"})x",
                    taken = R"x("taken": {"set": "t >= 1", "reset": "t >= 50"})x";
  for (const std::string& signals : {free + ", " + taken, taken + ", " + free}) {
    const RunResult result =
        completed(model("", signals + R"x(, "u": "if(free, 1, 0)")x", kSource,
                        R"x("free": "if(free, 1, 0)", "taken": "if(taken, 1, 0)")x", R"x("stop": 2, "samples": 2)x"));
    CHECK(last(result, "free") == 0.0);
    CHECK(last(result, "taken") == 1.0);
  }
}
