// What a run tells of its single instants, and its limit of them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "bgsim/trace_csv.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

using Kind = RunEvent::Kind;

struct Logged {
  RunResult result;
  std::vector<RunEvent> events;
  [[nodiscard]] std::vector<RunEvent> of(Kind kind) const {
    std::vector<RunEvent> found;
    std::copy_if(events.begin(), events.end(), std::back_inserter(found),
                 [kind](const RunEvent& event) { return event.kind == kind; });
    return found;
  }
  [[nodiscard]] double energy_of(Kind kind) const {
    double sum = 0.0;
    for (const RunEvent& event : of(kind)) sum += event.energy.value_or(0.0);
    return sum;
  }
};

Logged logged(const std::string& text, SimulateOptions options = untimed()) {
  Logged run;
  options.events = [&run](const RunEvent& event) { run.events.push_back(event); };
  run.result = Study::from_text(text).scene().simulate(options);
  return run;
}

Logged completed(const std::string& text, const SimulateOptions& options = untimed()) {
  Logged run = logged(text, options);
  INFO((run.result.failure ? run.result.failure->situation : ""));
  REQUIRE(run.result.stop == StopReason::completed);
  CHECK(std::is_sorted(run.events.begin(), run.events.end(),
                       [](const RunEvent& a, const RunEvent& b) { return a.t < b.t; }));
  return run;
}

const std::string kBall =
    R"x("elements": {"fall": {"kind": "1"}, "ball": {"kind": "I", "inertance": 2}, "weight": {"kind": "Se", "effort": 19.62},
    "ground": {"kind": "contact", "gap": 0, "initial": {"q": -1}, "restitution": 0.5}},
    "bonds": [{"from": "weight", "to": "fall"}, {"from": "fall", "to": "ball"}, {"from": "fall", "to": "ground"}])x";

std::string scene_of(const std::string& head, const std::string& outputs, const std::string& scene) {
  return R"x({"bgsim": 1, "name": "listed", )x" + head + R"x(, "outputs": {)x" + outputs +
         R"x(}, "scenes": {"run": {)x" + scene + "}}}";
}

}  // namespace

TEST_CASE("impacts are listed with their speeds, impulses and losses, which add up to the balance") {
  const Logged run = completed(scene_of(kBall, R"x("h": "-ground.q")x", R"x("stop": 1, "samples": 3)x"));
  const std::vector<RunEvent> impacts = run.of(Kind::impact);
  const double v = std::sqrt(2 * 9.81), t1 = v / 9.81;
  REQUIRE(impacts.size() == 2);  // the next one is at 2 t1
  double speed = v, t = t1;
  for (const RunEvent& impact : impacts) {
    CHECK(impact.name == "ground");
    CHECK(impact.t == Approx(t).epsilon(1e-12));
    CHECK(std::stod(impact.from) == Approx(speed).epsilon(1e-12));
    CHECK(std::stod(impact.to) == Approx(-0.5 * speed).epsilon(1e-12));
    CHECK(*impact.impulse == Approx(2 * 1.5 * speed).epsilon(1e-12));
    CHECK(*impact.energy == Approx(0.75 * speed * speed).epsilon(1e-12));
    speed /= 2;
    t += 2 * speed / 9.81;
  }
  CHECK(run.energy_of(Kind::impact) == Approx(run.result.report.energy.impacts).epsilon(1e-12));
  CHECK(run.result.report.impacts == impacts.size());
}

TEST_CASE("a ball that comes to rest closes its contact, and every impact before is listed") {
  const Logged run = completed(scene_of(kBall, R"x("h": "-ground.q")x", R"x("stop": 2, "samples": 3)x"));
  CHECK(run.of(Kind::impact).size() == run.result.report.impacts);
  const std::vector<RunEvent> contacts = run.of(Kind::contact);
  REQUIRE(contacts.size() == 1);
  CHECK(contacts.front().from == "free");
  CHECK(contacts.front().to == "closed");
  // It closes where the intervals are below 2e-6 of the longest.
  CHECK(contacts.front().t == Approx(3 * std::sqrt(2 / 9.81)).margin(2e-6));
}

TEST_CASE("switches are listed with the stores that they make jump") {
  // Capacitors of 1 and 2 at 3 and 0: 1 V afterwards, 3 J lost.
  const Logged run = completed(
      R"x({"bgsim": 1, "name": "listed",
    "elements": {"a": {"kind": "C", "capacitance": 1, "initial": {"q": 3}}, "b": {"kind": "C", "capacitance": 2},
                 "left": {"kind": "0"}, "right": {"kind": "0"}, "tie": {"kind": "1"}, "s": {"kind": "Sw", "closed": "t >= 0.5"}},
    "bonds": [{"from": "left", "to": "a"}, {"from": "right", "to": "b"}, {"from": "left", "to": "tie"},
              {"from": "tie", "to": "s"}, {"from": "tie", "to": "right"}],
    "outputs": {"u": "a.e"}, "scenes": {"run": {"times": [0, 0.5, 1], "stop": 1}}})x");
  const std::vector<RunEvent> switches = run.of(Kind::switching), jumps = run.of(Kind::jump),
                              times = run.of(Kind::time);
  REQUIRE(switches.size() == 1);
  CHECK(switches.front().t == 0.5);
  CHECK(switches.front().name == "s");
  CHECK(switches.front().from == "open");
  CHECK(switches.front().to == "closed");
  REQUIRE(times.size() == 1);
  CHECK(times.front().name == "t >= 0.5");
  CHECK(times.front().from == "false");
  CHECK(times.front().to == "true");
  REQUIRE(jumps.size() == 2);
  for (const RunEvent& jump : jumps) {
    CHECK(jump.t == 0.5);
    CHECK(std::stod(jump.to) == Approx(jump.name == "a.q" ? 1.0 : 2.0).epsilon(1e-12));
  }
  CHECK(*jumps[0].energy == Approx(3.0).epsilon(1e-12));
  CHECK_FALSE(jumps[1].energy);
}

TEST_CASE("events, samples and latches are listed with what they set") {
  const Logged run = completed(
      R"x({"bgsim": 1, "name": "listed",
    "signals": {"u": {"value": "c.q", "every": 1, "offset": 0.5}, "before": "previous(u)",
                "high": {"set": "c.q > 2.25", "reset": "c.q < 1"}},
    "elements": {"c": {"kind": "C", "capacitance": 1, "initial": {"q": 1.5}}, "n": {"kind": "0"}, "s": {"kind": "Sf", "flow": 1}},
    "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "c"}],
    "events": {"dump": {"when": "t > 1.25", "set": {"c.q": "c.q - 2.5"}}},
    "outputs": {"u": "u", "before": "before", "high": "if(high, 1, 0)"}, "scenes": {"run": {"stop": 2, "samples": 5}}})x");
  std::string lines;
  for (const RunEvent& event : run.events) {
    if (event.kind == Kind::time || event.kind == Kind::condition) continue;
    CHECK(std::isfinite(event.t));
    lines += number_text(event.t, 6) + " " + std::string(event_kind_text(event.kind)) + " " + event.name + " " +
             number_text(std::stod(event.from == "false"  ? "0"
                                   : event.from == "true" ? "1"
                                                          : event.from),
                         6) +
             " " +
             number_text(std::stod(event.to == "false"  ? "0"
                                   : event.to == "true" ? "1"
                                                        : event.to),
                         6) +
             "\n";
  }
  CHECK(lines ==
        "0.5 sample u 0 2\n"
        "0.75 latch high 0 1\n"
        "1.25 event dump 2.75 0.25\n"
        "1.25 latch high 1 0\n"
        "1.5 sample u 2 0.5\n");
  // 0.25^2/2 - 2.75^2/2
  CHECK(run.energy_of(Kind::event) == Approx(-3.75).epsilon(1e-9));
  CHECK(run.energy_of(Kind::event) == Approx(run.result.report.energy.events).epsilon(1e-12));
}

TEST_CASE("diodes are listed with their sides") {
  // sin(t) through a diode into a resistor.
  const Logged run = completed(
      R"x({"bgsim": 1, "name": "listed",
    "elements": {"s": {"kind": "Se", "effort": "sin(t)"}, "n": {"kind": "1"}, "d": {"kind": "D"}, "r": {"kind": "R", "resistance": 1}},
    "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "d"}, {"from": "n", "to": "r"}],
    "outputs": {"i": "r.f"}, "scenes": {"run": {"stop": 10, "samples": 5}}})x");
  const std::vector<RunEvent> diodes = run.of(Kind::diode);
  REQUIRE(diodes.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(diodes[k].t == Approx((static_cast<double>(k) + 1) * std::acos(-1.0)).epsilon(1e-9));
    CHECK(diodes[k].to == (k % 2 == 0 ? "blocks" : "conducts"));
  }
}

TEST_CASE("what is told is the same whatever the output times are") {
  std::string first;
  for (const char* times : {R"x("samples": 2)x", R"x("samples": 1001)x", R"x("interval": 0.25)x"}) {
    std::string table;
    for (const RunEvent& event :
         completed(scene_of(kBall, R"x("h": "-ground.q")x", R"x("stop": 2, )x" + std::string(times))).events)
      append_event_record(table, event);
    if (first.empty()) first = table;
    CHECK(table == first);
  }
}

TEST_CASE("a run with more events than the scene allows ends with those that it had most of") {
  for (const char* method : {"auto", "bdf", "erk5"}) {
    const Logged run = logged(scene_of(kBall, R"x("h": "-ground.q")x",
                                       R"x("stop": 2, "max_events": 3, "method": ")x" + std::string(method) + "\""));
    REQUIRE(run.result.failure);
    CHECK(run.result.failure->code == "BG628");
    CHECK(run.result.failure->situation.find("more than 3 events: impact \"ground\" 4 times") != std::string::npos);
    CHECK(run.result.report.reached > 1);
  }
  CHECK(logged(scene_of(kBall, R"x("h": "-ground.q")x", R"x("stop": 1, "max_events": 2)x")).result.stop ==
        StopReason::completed);
  const std::string plain =
      R"x("elements": {"s": {"kind": "Se", "effort": "if(sin(t) > 0, 1, 0)"}, "r": {"kind": "R", "resistance": 1}},
      "bonds": [{"from": "s", "to": "r"}])x";
  const Logged algebraic = logged(scene_of(plain, R"x("f": "r.f")x", R"x("stop": 100, "max_events": 5)x"));
  REQUIRE(algebraic.result.failure);  // a model without states
  CHECK(algebraic.result.failure->code == "BG628");
  CHECK(algebraic.of(Kind::time).size() == 6);
}

TEST_CASE("a run that is continued tells what comes after, and counts from the start") {
  const std::string text = scene_of(
      R"x("elements": {"c": {"kind": "C", "capacitance": 1}, "n": {"kind": "0"}, "s": {"kind": "Sf", "flow": "if(sin(t) > 0, 1, -1)"}},
      "bonds": [{"from": "s", "to": "n"}, {"from": "n", "to": "c"}])x",
      R"x("q": "c.q")x", R"x("stop": 30, "samples": 31, "max_events": 8)x");
  std::string snapshot;
  std::size_t before = 0;
  Logged whole;
  SimulateOptions first = untimed();
  first.events = [&](const RunEvent& event) { whole.events.push_back(event); };
  first.snapshot_steps = 20;  // after each the integrator begins with short steps
  first.snapshot = [&](double t, const std::string& json) {
    if (t < 10 || !snapshot.empty()) return;
    snapshot = json;
    before = whole.events.size();
  };
  whole.result = Study::from_text(text).scene().simulate(first);
  REQUIRE(before >= 3);  // at pi, 2 pi and 3 pi
  SimulateOptions then = untimed();
  then.resume = snapshot;
  const Logged rest = logged(text, then);
  REQUIRE(rest.result.failure);
  REQUIRE(whole.result.failure);
  CHECK(rest.result.failure->situation == whole.result.failure->situation);
  REQUIRE(before + rest.events.size() == whole.events.size());
  for (std::size_t i = 0; i < rest.events.size(); ++i) CHECK(rest.events[i].t == whole.events[before + i].t);
}

TEST_CASE("the rows of ceil have its values") {
  const Logged run = completed(scene_of(
      R"x("signals": {"x": {"integral": "ceil(t)"}}, "elements": {"s": {"kind": "Se", "effort": 1}, "r": {"kind": "R", "resistance": 1}},
    "bonds": [{"from": "s", "to": "r"}])x",
      R"x("x": "x")x", R"x("start": -1.5, "stop": 1.5)x"));
  const std::vector<RunEvent> rows = run.of(Kind::time);
  REQUIRE(rows.size() == 3);
  for (int k = 0; k < 3; ++k) {
    CHECK(rows[static_cast<std::size_t>(k)].name == "ceil(t)");
    CHECK(rows[static_cast<std::size_t>(k)].t == Approx(k - 1).margin(1e-15));
    CHECK(rows[static_cast<std::size_t>(k)].from == std::to_string(k - 1));
    CHECK(rows[static_cast<std::size_t>(k)].to == std::to_string(k));
  }
}
