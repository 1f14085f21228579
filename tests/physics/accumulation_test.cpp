// Where infinitely many impacts end, and what sees that instant.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

constexpr double kG = 9.81;

/// A ball that falls from a height of 1 m, and what reads its contact.
std::string ball(double restitution, const std::string& signals, const std::string& outputs, const std::string& scene,
                 const std::string& force = "9.81", const std::string& elements = "", const std::string& bonds = "") {
  std::ostringstream text;
  text
      << R"x({"bgsim": 1, "name": "ball", "signals": {)x" << signals
      << R"x(}, "elements": {"fall": {"kind": "1"}, "ball": {"kind": "I", "inertance": 1}, "weight": {"kind": "Se", "effort": ")x"
      << force << R"x("}, "ground": {"kind": "contact", "gap": 0, "initial": {"q": -1}, "restitution": )x"
      << restitution << "}" << elements
      << R"x(}, "bonds": [{"from": "weight", "to": "fall"}, {"from": "fall", "to": "ball"}, {"from": "fall", "to": "ground"})x"
      << bonds << R"x(], "outputs": {)x" << outputs << R"x(}, "scenes": {"run": {)x" << scene << "}}}";
  return text.str();
}

double rest_of(double restitution) { return std::sqrt(2.0 / kG) * (1.0 + restitution) / (1.0 - restitution); }

struct Ran {
  RunResult result;
  std::vector<RunEvent> events;
};

Ran run(const std::string& text) {
  Ran ran;
  SimulateOptions options;
  options.events = [&](const RunEvent& event) { ran.events.push_back(event); };
  ran.result = Study::from_text(text).scene().simulate(options);
  INFO((ran.result.failure ? ran.result.failure->situation : ""));
  REQUIRE(ran.result.stop == StopReason::completed);
  return ran;
}

/// Those that are no impacts.
std::vector<RunEvent> changes(const std::vector<RunEvent>& events) {
  std::vector<RunEvent> result;
  for (const RunEvent& event : events)
    if (event.kind != RunEvent::Kind::impact && event.kind != RunEvent::Kind::start) result.push_back(event);
  return result;
}

}  // namespace

TEST_CASE("a contact touches from where its impacts end", "[long]") {
  // The run leaves out flights of less than 2e-6 of the longest: at 0.99 the last of them is 2e-4 of it before the end.
  // Errors: the ratio of the intervals is known to rounding over the last of them, 1e-15*t/4e-6, times 1/(1 - e)^2.
  struct Case {
    double restitution, within;
  };
  for (const Case& at : {Case{0.05, 1e-12}, Case{0.3, 1e-12}, Case{0.7, 1e-12}, Case{0.9, 2e-11}, Case{0.99, 1e-8}})
    for (const char* method : {"auto", "radau", "rodas5p", "erk5"}) {
      INFO(at.restitution << " by " << method);
      const double rest = rest_of(at.restitution), stop = std::ceil(rest) + 1.0;
      std::ostringstream scene;
      scene << R"x("samples": 11, "stop": )x" << stop << R"x(, "method": ")x" << method << '"';
      const Ran ran = run(ball(at.restitution,
                               R"x("clock": {"integral": "if(mode('ground'), 1, 0)"},
                                  "late": {"integral": "if(mode('ground'), t, 0)"})x",
                               R"x("clock": "clock", "late": "late")x", scene.str()));
      CHECK(std::abs(last(ran.result, "clock") - (stop - rest)) < at.within);
      CHECK(std::abs(last(ran.result, "late") - 0.5 * (stop * stop - rest * rest)) < at.within * stop);
      const std::vector<RunEvent> seen = changes(ran.events);
      REQUIRE(seen.size() == 1);
      CHECK(seen[0].kind == RunEvent::Kind::contact);
      CHECK(seen[0].to == "closed");
      CHECK(std::abs(seen[0].t - rest) < at.within);
    }
}

TEST_CASE("the table of events has the end of the impacts where no condition asks for the mode") {
  const Ran ran = run(ball(0.9, "", R"x("h": "ground.q")x", R"x("samples": 11, "stop": 10)x"));
  const std::vector<RunEvent> seen = changes(ran.events);
  REQUIRE(seen.size() == 1);
  CHECK(std::abs(seen[0].t - rest_of(0.9)) < 2e-11);  // as above
  CHECK(ran.events.back().kind == RunEvent::Kind::contact);
}

TEST_CASE("switches and latches that ask for a contact follow at the end of its impacts") {
  // A capacitor is charged through a switch that closes there, and a lamp is latched at the same instant.
  const double rest = rest_of(0.9);
  const Ran ran =
      run(ball(0.9, R"x("lit": {"set": "mode('ground')", "reset": "t < 0", "initial": false})x",
               R"x("q": "cap.q", "lit": "if(lit, 1, 0)")x", R"x("samples": 11, "stop": 10)x", "9.81",
               R"x(, "i": {"kind": "Se", "effort": 1}, "one": {"kind": "1"}, "r": {"kind": "R", "resistance": 1},
                  "gate": {"kind": "Sw", "closed": "mode('ground')"}, "cap": {"kind": "C", "capacitance": 1})x",
               R"x(, {"from": "i", "to": "one"}, {"from": "one", "to": "r"}, {"from": "one", "to": "gate"},
                  {"from": "one", "to": "cap"})x"));
  CHECK(last(ran.result, "q") == Approx(1.0 - std::exp(-(10.0 - rest))).epsilon(1e-6));  // the tolerance
  CHECK(last(ran.result, "lit") == 1.0);
  std::vector<std::string> names;
  for (const RunEvent& event : changes(ran.events)) {
    names.push_back(event.name);
    CHECK(std::abs(event.t - rest) < 2e-11);
  }
  std::sort(names.begin(), names.end());
  CHECK(names == std::vector<std::string>{"gate", "ground", "lit"});
}

TEST_CASE("a ball that is lifted before its impacts have ended has not touched") {
  // At 0.99 the last flight that the run follows is 2e-4 s before the end: at half of that a force lifts the ball.
  const double rest = rest_of(0.99);
  std::ostringstream force;
  force.precision(17);
  force << "if(t < " << rest - 1e-4 << ", 9.81, -1)";
  const std::string stop = std::to_string(std::ceil(rest) + 1.0);
  const Ran ran =
      run(ball(0.99, R"x("clock": {"integral": "if(mode('ground'), 1, 0)"})x", R"x("clock": "clock", "v": "-ball.f")x",
               R"x("samples": 11, "stop": )x" + stop, force.str()));
  CHECK(last(ran.result, "clock") == 0.0);
  CHECK(last(ran.result, "v") == Approx(std::stod(stop) - (rest - 1e-4)).epsilon(1e-6));
  for (const RunEvent& event : changes(ran.events)) CHECK(event.kind != RunEvent::Kind::contact);
}

TEST_CASE("impacts may end before t = 0, and more than once") {
  // It begins with the speed 1 upwards at -20. From -10 to -9 a force lifts it to 1/2, with the speed 1 again.
  const double first = -20.0 + 2.0 / (1.0 - 0.5), second = -9.0 + 1.0 + std::sqrt(2.0) * (1.0 + 1.0 / (1.0 - 0.5));
  const Ran ran = run(R"x({"bgsim": 1, "name": "twice", "signals": {"clock": {"integral": "if(mode('ground'), 1, 0)"}},
    "elements": {"fall": {"kind": "1"}, "ball": {"kind": "I", "inertance": 1, "initial": {"p": -1}},
      "weight": {"kind": "Se", "effort": "if(t < -10 or t >= -9, 1, -1)"},
      "ground": {"kind": "contact", "gap": 0, "initial": {"q": 0}, "restitution": 0.5}},
    "bonds": [{"from": "weight", "to": "fall"}, {"from": "fall", "to": "ball"}, {"from": "fall", "to": "ground"}],
    "outputs": {"clock": "clock"}, "scenes": {"run": {"start": -20, "stop": -1, "samples": 20}}})x");
  // Parabolas, which Radau IIA follows to rounding.
  CHECK(last(ran.result, "clock") == Approx(-10.0 - first - 1.0 - second).epsilon(1e-11));
  std::vector<double> closed, opened;
  for (const RunEvent& event : changes(ran.events)) {
    if (event.kind != RunEvent::Kind::contact) continue;
    (event.to == "closed" ? closed : opened).push_back(event.t);
  }
  REQUIRE(closed.size() == 2);
  REQUIRE(opened.size() == 1);
  CHECK(closed[0] == Approx(first).epsilon(1e-11));
  CHECK(opened[0] == Approx(-10.0).epsilon(1e-11));
  CHECK(closed[1] == Approx(second).epsilon(1e-11));
}

TEST_CASE("a slope of what asks for a contact is that of each of its sides") {
  // The derivative of if(mode, t, 0) is 1 or 0: at the end of the impacts it has the jump of any change of the mode.
  const Ran ran = run(ball(0.9, R"x("d": {"value": "der(if(mode('ground'), t, 0))"}, "sum": {"integral": "d"})x",
                           R"x("sum": "sum", "d": "d")x", R"x("samples": 11, "stop": 10)x"));
  CHECK(std::abs(last(ran.result, "sum") - (10.0 - rest_of(0.9))) < 2e-11);  // as above
  CHECK(last(ran.result, "d") == 1.0);
}

TEST_CASE("the change of side at the end of the impacts is one of the scene's events, and counted once") {
  const std::string scene = R"x("samples": 11, "stop": 10, "max_events": )x";
  const Ran all = run(ball(0.9, "", R"x("h": "ground.q")x", scene + "1000"));
  const auto count = static_cast<std::size_t>(std::count_if(
      all.events.begin(), all.events.end(), [](const RunEvent& event) { return event.kind != RunEvent::Kind::start; }));
  CHECK(all.result.report.mode_changes == all.result.report.impacts);
  CHECK(count == all.result.report.impacts + 1);
  CHECK(run(ball(0.9, "", R"x("h": "ground.q")x", scene + std::to_string(count))).events.size() == all.events.size());
  for (const char* signals : {"", R"x("clock": {"integral": "if(mode('ground'), 1, 0)"})x"}) {
    const RunResult full =
        Study::from_text(ball(0.9, signals, R"x("h": "ground.q")x", scene + std::to_string(count - 1)))
            .scene()
            .simulate();
    REQUIRE(full.stop == StopReason::failed);
    CHECK(full.failure->code == "BG628");
  }
}

namespace {

/// A block of mass 1 that comes in with a speed of 1 from 0.1 before a light body, which is 0.1 before a wall.
struct Squeezed {
  double mass, of_block, of_wall;  ///< the light body's; restitutions

  [[nodiscard]] std::string text() const {
    std::ostringstream text;
    text << R"x({"bgsim": 1, "name": "squeezed", "signals": {"x": {"integral": "n0.f"}}, "elements": {
        "n0": {"kind": "1"}, "m0": {"kind": "I", "inertance": 1, "initial": {"f": 1}}, "n1": {"kind": "1"},
        "m1": {"kind": "I", "inertance": )x"
         << mass << R"x(}, "h": {"kind": "0"},
        "between": {"kind": "contact", "gap": 0, "initial": {"q": -0.1}, "restitution": )x"
         << of_block << R"x(}, "wall": {"kind": "contact", "gap": 0, "initial": {"q": -0.1}, "restitution": )x"
         << of_wall
         << R"x(}}, "bonds": [{"from": "n0", "to": "m0"}, {"from": "n1", "to": "m1"}, {"from": "n0", "to": "h"},
        {"from": "h", "to": "between"}, {"from": "h", "to": "n1"}, {"from": "n1", "to": "wall"}],
        "outputs": {"x": "x", "v0": "n0.f", "v1": "n1.f"}, "scenes": {"run": {"stop": 1, "samples": 11}}})x";
    return text.str();
  }

  struct State {
    long double x = 0.0L, v0 = 1.0L, v1 = 0.0L;
    std::uint64_t impacts = 0;
  };
  /// At t = 1, impact by impact with the gaps as unknowns, which may become as small as they like.
  [[nodiscard]] State at_the_end() const {
    State at;
    long double between = 0.1L, wall = 0.1L, left = 1.0L;
    const long double m = mass;
    while (std::max(std::fabs(at.v0), std::fabs(at.v1)) > 1e-15L) {
      const long double closing = at.v0 - at.v1;
      const long double first = closing > 0.0L ? between / closing : 2.0L, second = at.v1 > 0.0L ? wall / at.v1 : 2.0L;
      const long double step = std::min({first, second, left});
      at.x += at.v0 * step;
      between -= closing * step;
      wall -= at.v1 * step;
      left -= step;
      if (step < first && step < second) return at;
      ++at.impacts;
      if (first <= second) {
        between = 0.0L;
        const long double impulse = (1.0L + of_block) * closing / (1.0L + 1.0L / m);
        at.v0 -= impulse;
        at.v1 += impulse / m;
      } else {
        wall = 0.0L;
        at.v1 *= -of_wall;
      }
    }
    return at;
  }
};

}  // namespace

TEST_CASE("impacts of two contacts in turn that use up their ways come to the speeds that they have without end") {
  // The intervals shrink faster than the speeds: where they are 2e-6 of the longest the speeds may be a third of the
  // first one. Closed there, block and body went back from the wall at up to 0.15 instead of staying.
  int ends = 0, go_back = 0;
  for (const double mass : {0.05, 0.1, 0.2, 0.3, 0.5})
    for (const double of_block : {0.05, 0.1, 0.3, 0.5})
      for (const double of_wall : {0.1, 0.3, 0.45}) {
        const Squeezed squeezed{mass, of_block, of_wall};
        const Squeezed::State exact = squeezed.at_the_end();
        const bool at_rest = std::fabs(exact.v0) <= 1e-15L;
        ++(at_rest ? ends : go_back);
        for (const double relative : {1e-4, 1e-6, 1e-9}) {
          INFO(squeezed.text() << " at " << relative << ": " << exact.impacts << " impacts");
          const RunResult result =
              Study::from_text(squeezed.text()).scene("run", with_relative(relative)).simulate(one_run());
          REQUIRE(result.stop == StopReason::completed);
          // Bodies without a force keep their speeds. Where speeds do fall as intervals do, the contact closes at 2e-6
          // of the longest interval, and what it had left of its speed is no more than that of the first one: 6e-8
          // here.
          const double tolerance = std::max(1e-7, relative);
          CHECK(std::abs(last(result, "x") - static_cast<double>(exact.x)) <= tolerance);
          CHECK(std::abs(last(result, "v0") - static_cast<double>(exact.v0)) <= tolerance);
          CHECK(std::abs(last(result, "v1") - static_cast<double>(exact.v1)) <= tolerance);
        }
      }
  CHECK(ends > 5);
  CHECK(go_back > 5);
}
