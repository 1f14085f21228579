// Events of a model: stores that are set at the instant at which a condition becomes true.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

RunResult run_events(const std::string& signals, const std::string& elements, const std::string& bonds,
                     const std::string& events, const std::string& outputs, const std::string& scene,
                     const SimulateOptions& options = {}) {
  const Study study =
      Study::from_text(R"x({"bgsim": 1, "name": "events", "signals": {)x" + signals + R"x(}, "elements": {)x" +
                       elements + R"x(}, "bonds": [)x" + bonds + R"x(], "events": {)x" + events +
                       R"x(}, "outputs": {)x" + outputs + R"x(}, "scenes": {"run": {)x" + scene + "}}}");
  return study.scene().simulate(options);
}

void check_completed(const RunResult& result) {
  INFO((result.failure ? result.failure->situation : ""));
  CHECK(result.stop == StopReason::completed);
}

const std::string kBall = R"x("ball": {"kind": "1"}, "mass": {"kind": "I", "inertance": 2},
  "weight": {"kind": "Se", "effort": -19.62})x";
const std::string kBallBonds = R"x({"from": "weight", "to": "ball"}, {"from": "ball", "to": "mass"})x";
const std::string kHeight = R"x("x": {"integral": "ball.f", "initial": 1})x";
const std::string kBounce = R"x("bounce": {"when": "x <= 0", "set": {"mass.p": "-0.7*pre(mass.p)"}})x";
constexpr double kG = 9.81, kE = 0.7;

/// Height and speed of the ball.
struct Flight {
  double x, v;
};
Flight exact_ball(double t) {
  double begin = -std::sqrt(2.0 / kG), speed = std::sqrt(2.0 * kG);
  while (begin + 2.0 * speed / kG < t) {
    begin += 2.0 * speed / kG;
    speed *= kE;
  }
  const double s = t - begin;
  return {speed * s - kG * s * s / 2.0, speed - kG * s};
}

}  // namespace

TEST_CASE("a bouncing ball keeps to its parabolas by every method") {
  for (const std::string method : {"auto", "bdf", "adams", "radau", "radau9", "radau13", "rodas5p", "ida", "erk4",
                                   "erk8", "dirk4", "rk4\", \"step\": \"0.01"}) {
    INFO(method);
    std::string scene = R"x("stop": 2.4, "samples": 25, "relative": 1e-10, "method": ")x" + method + "\"";
    // A step is a number.
    if (const auto at = scene.find("\"0.01\""); at != std::string::npos) scene.replace(at, 6, "0.01");
    const RunResult result = run_events(kHeight, kBall, kBallBonds, kBounce, R"x("x": "x", "v": "ball.f")x", scene);
    check_completed(result);
    // Parabolas are exact for all of these but for rounding, of which impacts make 1/e of the time's error each, and
    // for the iteration of multistep methods, which is a part of the tolerance of 1e-10.
    for (std::size_t i = 0; i < result.trace.times.size(); ++i) {
      const Flight exact = exact_ball(result.trace.times[i]);
      CHECK(result.trace["x"][i] == Approx(exact.x).margin(1e-8));
      CHECK(result.trace["v"][i] == Approx(exact.v).margin(1e-7));
    }
    REQUIRE(result.report.set_events.size() == 1);
    CHECK(result.report.set_events[0].count == 8);
    // Each bounce takes the part 1 - e^2 of the kinetic energy, m g h before the first.
    const double lost = 19.62 * (1.0 - std::pow(kE, 16.0));
    CHECK(result.report.set_events[0].energy == Approx(-lost).epsilon(1e-8));
    CHECK(result.report.energy.events == Approx(-lost).epsilon(1e-8));
    CHECK(result.report.energy.relative < 1e-8);
  }
}

TEST_CASE("a ball that comes to rest ends the run at the limit of its bounces") {
  for (const char* e : {"0.1", "0.5", "0.7", "0.9", "0.99", "0.999"}) {
    INFO(e);
    const double restitution = std::stod(e);
    const double limit = std::sqrt(2.0 / kG) * (1.0 + restitution) / (1.0 - restitution);
    const std::string bounce =
        std::string(R"x("bounce": {"when": "x <= 0", "set": {"mass.p": "-)x") + e + "*pre(mass.p)\"}}";
    SimulateOptions options;
    options.energy_audit = false;
    const RunResult result =
        run_events(kHeight, kBall, kBallBonds, bounce, R"x("x": "x")x",
                   "\"samples\": 3, \"relative\": 1e-9, \"stop\": " + std::to_string(1.2 * limit), options);
    REQUIRE(result.failure);
    CHECK(result.failure->code == "BG623");
    if (restitution >= 0.5 && restitution <= 0.9) {
      // The run ends where an interval is below 2e-6 of the longest one, 2 e t1: what follows adds up to as much by
      // e/(1 - e).
      CHECK(result.report.reached < limit);
      CHECK(result.report.reached >
            limit * (1.0 - 2e-6 * 2.0 * restitution * restitution / (1.0 + restitution)) - 1e-12);
      CHECK(result.failure->situation.find("towards t = " + number_text(limit, 9).substr(0, 9)) != std::string::npos);
    } else {
      // Before that a flight is no longer than what is resolved: the floor is held for two roundings more at each of N
      // bounces, and v dt = g dt^2/2 is compared with 64 times that. What follows adds up to dt/(1 - e). The longest of
      // the values is 1; eight times for the roundings of the speed.
      const double bounces = static_cast<double>(result.report.set_events[0].count);
      const double flight = std::sqrt(2.0 * 64.0 * 2.0 * bounces * std::numeric_limits<double>::epsilon() / kG);
      CHECK(std::abs(result.report.reached - limit) < 8.0 * flight / (1.0 - restitution));
    }
    // The law has no least height: nothing is below the floor but by rounding.
    for (const double x : result.trace["x"]) CHECK(x > -1e-9);
  }
}

TEST_CASE("no method loses a ball through the floor in flights below its tolerance", "[long]") {
  for (const char* method : {"bdf", "adams", "ida", "erk5", "dirk4", "radau", "radau9", "radau13", "rodas5p"})
    for (const char* floor : {"0", "1000"})
      for (const char* e : {"0.3", "0.9", "0.99"}) {
        INFO(method << ", floor " << floor << ", e " << e);
        const double restitution = std::stod(e), ground = std::stod(floor);
        const double limit = std::sqrt(2.0 / kG) * (1.0 + restitution) / (1.0 - restitution);
        SimulateOptions options;
        options.energy_audit = false;
        const RunResult result = run_events(
            std::string(R"x("x": {"integral": "ball.f", "initial": ")x") + floor + " + 1\"}", kBall, kBallBonds,
            std::string(R"x("bounce": {"when": "x <= )x") + floor + R"x(", "set": {"mass.p": "-)x" + e +
                "*pre(mass.p)\"}}",
            R"x("x": "x")x",
            std::string(R"x("samples": 101, "method": ")x") + method + "\", \"stop\": " + std::to_string(1.2 * limit),
            options);
        REQUIRE(result.failure);
        CHECK(result.failure->code == "BG623");
        // The located instant is right to the tolerance of the height, 1e-6 of it.
        for (const double x : result.trace["x"]) CHECK(x > ground - 1e-6 * (1.0 + ground));
      }
}

TEST_CASE("bounces below the rounding of the height end the run and let nothing through the floor") {
  // At a height of 1e6 the doubles are 1e-10 apart.
  const RunResult result = run_events(R"x("x": {"integral": "ball.f", "initial": 1000001})x", kBall, kBallBonds,
                                      R"x("bounce": {"when": "x <= 1000000", "set": {"mass.p": "-0.7*pre(mass.p)"}})x",
                                      R"x("x": "x")x", R"x("stop": 20, "samples": 201)x");
  REQUIRE(result.failure);
  CHECK(result.failure->code == "BG623");
  // The heights are multiples of 1.2e-10 m: bounces of some 1e-8 m, which last 1e-4 s, end it.
  CHECK(result.report.reached == Approx(2.558633965586).epsilon(1e-3));
  for (const double x : result.trace["x"]) CHECK(x > 1e6 - 1e-6);
}

TEST_CASE("events count and reset integrals, at their times to rounding") {
  const RunResult result = run_events(
      R"x("x": {"integral": "1.3"}, "n": {"integral": 0}, "last": {"integral": 0})x", kBall, kBallBonds,
      R"x("reset": {"when": "x >= 1", "set": {"x": 0, "n": "pre(n) + 1", "last": "t"}})x",
      R"x("x": "x", "n": "n", "last": "last")x", R"x("stop": 9.9, "times": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9.9])x");
  check_completed(result);
  CHECK(result.report.set_events[0].count == 12);
  for (std::size_t i = 0; i < 11; ++i) {
    const double turns = 1.3 * result.trace.times[i], n = std::floor(turns);
    CHECK(result.trace["n"][i] == n);
    CHECK(result.trace["x"][i] == Approx(turns - n).margin(1e-12));
    if (n > 0.0) CHECK(result.trace["last"][i] == Approx(n / 1.3).epsilon(1e-12));
  }
}

TEST_CASE("an event that leaves its guard where it is takes place once") {
  for (const char* when : {"x > 1", "x >= 1", "t >= 1", "t > 1", "step(x - 1) > 0.5", "not (x < 1)"}) {
    INFO(when);
    const RunResult result =
        run_events(R"x("x": {"integral": 1}, "n": {"integral": 0})x", kBall, kBallBonds,
                   std::string(R"x("count": {"when": ")x") + when + R"x(", "set": {"n": "n + 1"}})x", R"x("n": "n")x",
                   R"x("stop": 2, "times": [0, 0.999999, 1.000001, 2])x");
    check_completed(result);
    CHECK(result.trace["n"][1] == 0.0);
    CHECK(result.trace["n"][2] == 1.0);
    CHECK(result.trace["n"][3] == 1.0);
  }
}

TEST_CASE("a condition that holds at the start waits until it becomes true") {
  const RunResult result = run_events(R"x("n": {"integral": 0})x", kBall, kBallBonds,
                                      R"x("count": {"when": "sin(t) >= 0", "set": {"n": "n + 1"}})x", R"x("n": "n")x",
                                      R"x("stop": 10, "times": [0, 3, 6, 7, 10])x");
  check_completed(result);
  CHECK(result.trace["n"][2] == 0.0);
  CHECK(result.trace["n"][3] == 1.0);
  CHECK(result.trace["n"][4] == 1.0);
  CHECK(std::any_of(result.report.notes.begin(), result.report.notes.end(),
                    [](const std::string& note) { return note.find("holds at the start") != std::string::npos; }));
}

TEST_CASE("events of one instant take place by priority, each from what is then") {
  const auto run = [](const char* first, const char* second) {
    return run_events(R"x("a": {"integral": 0, "initial": 3}, "b": {"integral": 0, "initial": 5})x", kBall, kBallBonds,
                      std::string(R"x("one": {"when": "t >= 1", "set": {"a": "pre(b)"}, "priority": )x") + first +
                          R"x(}, "two": {"when": "t >= 1", "set": {"b": "pre(a)"}, "priority": )x" + second + "}",
                      R"x("a": "a", "b": "b")x", R"x("stop": 2, "samples": 2)x");
  };
  const RunResult together = run("0", "0");  // from one set of values: exchanged
  CHECK(last(together, "a") == 5.0);
  CHECK(last(together, "b") == 3.0);
  const RunResult one_first = run("1", "0");
  CHECK(last(one_first, "a") == 5.0);
  CHECK(last(one_first, "b") == 5.0);
  const RunResult two_first = run("-1", "2");
  CHECK(last(two_first, "a") == 3.0);
  CHECK(last(two_first, "b") == 3.0);
}

TEST_CASE("what an event sets may make another one due at the same instant") {
  const RunResult result =
      run_events(R"x("a": {"integral": 0}, "b": {"integral": 0}, "c": {"integral": 0})x", kBall, kBallBonds,
                 R"x("first": {"when": "t >= 1", "set": {"a": 1}}, "second": {"when": "a > 0.5", "set": {"b": "t"}},
         "third": {"when": "b > 0.5", "set": {"c": "t"}})x",
                 R"x("a": "a", "b": "b", "c": "c")x", R"x("stop": 2, "times": [0, 1, 2])x");
  check_completed(result);
  CHECK(result.trace["a"][1] == 1.0);
  CHECK(result.trace["b"][1] == 1.0);
  CHECK(result.trace["c"][1] == 1.0);
}

TEST_CASE("stores that are tied to one that is set follow it") {
  // A lever of 3: the load moves at a third of the speed, and its momentum follows at once.
  const RunResult result =
      run_events(R"x("unused": "t")x",
                 R"x("body": {"kind": "1"}, "mass": {"kind": "I", "inertance": 2, "priority": 1, "initial": {"p": 6}},
         "lever": {"kind": "TF", "modulus": 3}, "other": {"kind": "1"}, "load": {"kind": "I", "inertance": 5})x",
                 R"x({"from": "body", "to": "mass"}, {"from": "body", "to": "lever"}, {"from": "lever", "to": "other"},
         {"from": "other", "to": "load"})x",
                 R"x("halt": {"when": "t >= 1", "set": {"mass.p": "pre(mass.p)/2"}})x",
                 R"x("p": "mass.p", "l": "load.p")x", R"x("stop": 2, "samples": 3)x");
  check_completed(result);
  const double before = result.trace["l"][0];
  CHECK(result.trace["p"][0] == 6.0);
  CHECK(last(result, "p") == 3.0);
  CHECK(last(result, "l") == Approx(before / 2.0).epsilon(1e-12));
  // Half the speed is a quarter of the energy, that of the load included.
  const double all = 6.0 * 6.0 / 4.0 + before * before / 10.0;
  CHECK(result.report.energy.events == Approx(-0.75 * all).epsilon(1e-12));
  CHECK(result.report.energy.relative < 1e-12);
}

TEST_CASE("events take place in models with switches and diodes, too") {
  // A capacitor is charged through a switch that is closed in [1, 2]; a counter and a reset at 3 V.
  const RunResult result = run_events(
      R"x("n": {"integral": 0}, "closed": {"integral": 0})x",
      R"x("battery": {"kind": "Se", "effort": 10}, "series": {"kind": "1"}, "r": {"kind": "R", "resistance": 1},
         "sw": {"kind": "Sw", "closed": "t >= 1 and t < 2"}, "cap": {"kind": "C", "capacitance": 1})x",
      R"x({"from": "battery", "to": "series"}, {"from": "series", "to": "r"}, {"from": "series", "to": "sw"},
         {"from": "series", "to": "cap"})x",
      R"x("reset": {"when": "cap.e > 3", "set": {"cap.q": 0, "n": "n + 1"}},
         "on": {"when": "t >= 1", "set": {"closed": "closed + 1"}})x",
      R"x("u": "cap.e", "n": "n", "closed": "closed")x", R"x("stop": 4, "samples": 5, "relative": 1e-10)x");
  check_completed(result);
  const double period = std::log(10.0 / 7.0), turns = std::floor(1.0 / period);
  CHECK(last(result, "n") == turns);
  CHECK(last(result, "closed") == 1.0);
  // By Radau at 1e-10.
  CHECK(last(result, "u") == Approx(10.0 * -std::expm1(-(1.0 - turns * period))).epsilon(1e-8));
  CHECK(result.report.energy.events == Approx(-turns * 4.5).epsilon(1e-8));
  CHECK(result.report.energy.relative < 1e-8);
}

TEST_CASE("a run with events that goes on from a snapshot is the same run") {
  const Study study = Study::from_text(
      R"x({"bgsim": 1, "name": "events", "signals": {)x" + kHeight + R"x(}, "elements": {)x" + kBall +
      R"x(}, "bonds": [)x" + kBallBonds + R"x(], "events": {)x" + kBounce +
      R"x(}, "outputs": {"x": "x", "v": "ball.f"}, "scenes": {"run": {"stop": 2.5, "samples": 26}}})x");
  std::vector<std::string> snapshots;
  SimulateOptions options;
  options.snapshot_steps = 5;
  options.snapshot = [&](double, const std::string& text) { snapshots.push_back(text); };
  const RunResult whole = study.scene().simulate(options);
  check_completed(whole);
  REQUIRE(snapshots.size() > 3);
  for (const std::string& text : snapshots) {
    SimulateOptions resumed = options;
    resumed.resume = text;
    resumed.snapshot = [](double, const std::string&) {};
    const RunResult rest = study.scene().simulate(resumed);
    check_completed(rest);
    if (rest.rows == 0) continue;  // of the end
    CHECK(rest.trace["x"].back() == whole.trace["x"].back());
    CHECK(rest.trace["v"].back() == whole.trace["v"].back());
    CHECK(rest.report.set_events[0].count == whole.report.set_events[0].count);
    CHECK(rest.report.energy.events == whole.report.energy.events);
  }
}

TEST_CASE("no bounce is lost, whatever the height of the floor and the restitution") {
  for (const char* e : {"0.05", "0.3", "0.9", "0.99"})
    for (const char* floor : {"0", "1000", "-37.3", "1000000"}) {
      INFO(e << ", " << floor);
      const double limit = std::sqrt(2.0 / kG) * (1.0 + std::stod(e)) / (1.0 - std::stod(e));
      const std::string start = std::to_string(std::stod(floor) + 1.0);
      const RunResult result =
          run_events(R"x("x": {"integral": "ball.f", "initial": )x" + start + "}", kBall, kBallBonds,
                     std::string(R"x("bounce": {"when": "x <= )x") + floor + R"x(", "set": {"mass.p": "-)x" + e +
                         R"x(*pre(mass.p)"}})x",
                     R"x("x": "x")x", "\"samples\": 501, \"stop\": " + std::to_string(1.2 * limit));
      REQUIRE(result.failure);
      CHECK((result.failure->code == "BG623" || result.failure->code == "BG604"));
      // Beyond the floor by roundings of the height only.
      for (const double x : result.trace["x"])
        CHECK(x - std::stod(floor) > -1e-14 * (1.0 + std::abs(std::stod(floor))) * 100);
    }
}
