// Switched systems whose answers are known in closed form, to 1e-9 (docs/known-answers.md); the numbers were computed
// in thirty digits. And extremes: accumulation with restitution 0.999, friction that turns over at once, 1e5 periods.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "support/files.hpp"
#include "support/rounds.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

constexpr double kDigits = 1e-9;  // what the tolerance of 1e-11 a step leaves over some hundred steps
constexpr double kPi = std::numbers::pi;

struct Answer {
  RunResult result;
  std::vector<RunEvent> events;

  [[nodiscard]] std::vector<double> times_of(RunEvent::Kind kind, const std::string& name,
                                             const std::string& to = "") const {
    std::vector<double> times;
    for (const RunEvent& event : events)
      if (event.kind == kind && event.name == name && (to.empty() || event.to == to)) times.push_back(event.t);
    return times;
  }
};

Answer answer(const std::string& text) {
  Answer run;
  SimulateOptions options = untimed();
  options.second_run = false;
  options.events = [&run](const RunEvent& event) { run.events.push_back(event); };
  run.result = Study::from_text(text).scene().simulate(options);
  INFO((run.result.failure ? run.result.failure->situation : ""));
  REQUIRE(run.result.stop == StopReason::completed);
  return run;
}

/// @param bonds  "a>b b>c"
std::string model(const std::string& elements, const std::string& bonds, const std::string& outputs,
                  const std::string& scene, const std::string& signals = "") {
  std::string list;
  std::istringstream words(bonds);
  for (std::string word; words >> word;)
    list += (list.empty() ? "" : ", ") + (R"x({"from": ")x" + word.substr(0, word.find('>'))) + R"x(", "to": ")x" +
            word.substr(word.find('>') + 1) + "\"}";
  return R"x({"bgsim": 1, "name": "answer", "signals": {)x" + signals + R"x(}, "elements": {)x" + elements +
         R"x(}, "bonds": [)x" + list + R"x(], "outputs": {)x" + outputs +
         R"x(}, "scenes": {"run": {"relative": 1e-11, )x" + scene + "}}}";
}

void near(double value, double right, double size = 1.0) {
  CHECK(value == Approx(right).margin(kDigits * size).epsilon(0));
}

const std::string kBall = R"x("fall": {"kind": "1"}, "ball": {"kind": "I", "inertance": 1},
    "weight": {"kind": "Se", "effort": 9.81}, "ground": {"kind": "contact", "gap": 0, "initial": {"q": -1}, "restitution": )x";

}  // namespace

TEST_CASE("a ball that falls from 1 m: hits, limit, path, speed") {
  const Answer run =
      answer(model(kBall + "0.7}", "weight>fall fall>ball fall>ground", R"x("path": "path", "v": "ball.f")x",
                   R"x("times": [0, 2.7], "stop": 2.7)x", R"x("path": {"integral": "abs(ball.f)"})x"));
  const std::vector<double> hits = run.times_of(RunEvent::Kind::impact, "ground");
  REQUIRE(hits.size() > 2);
  near(hits[0], 0.4515236409857);
  near(hits[1], 1.083656738366);
  // What is left out where the bounces are below 2e-6 of the first is bridged by the geometric series.
  near(run.times_of(RunEvent::Kind::contact, "ground").front(), 2.558633965586, 5e3);
  const std::string& note =
      *std::find_if(run.result.report.notes.begin(), run.result.report.notes.end(),
                    [](const auto& text) { return text.find("closes at t = ") != std::string::npos; });
  near(std::stod(note.substr(note.find("closes at t = ") + 14)), 2.558633965586, 10.0);
  near(last(run.result, "path"), 2.921568627451, 5);  // 39 flights
  const auto first = std::find_if(run.events.begin(), run.events.end(),
                                  [](const RunEvent& event) { return event.kind == RunEvent::Kind::impact; });
  near(std::stod(first->from), 4.42944691807);
}

TEST_CASE("capacitors of 1 and 2 at 3 and 0 share their charge: 1 V, 3 J lost") {
  const Answer run = answer(model(
      R"x("a": {"kind": "C", "capacitance": 1, "initial": {"q": 3}}, "b": {"kind": "C", "capacitance": 2}, "x": {"kind": "0"},
         "y": {"kind": "0"}, "tie": {"kind": "1"}, "s": {"kind": "Sw", "closed": "t >= 1"})x",
      "x>a y>b x>tie tie>s tie>y", R"x("u": "a.e", "v": "b.e")x", R"x("times": [0, 2], "stop": 2)x"));
  near(last(run.result, "u"), 1.0);
  near(last(run.result, "v"), 1.0);
  near(run.result.report.energy.switching, 3.0);
}

TEST_CASE(
    "a clutch brings 100/s and 0 to 66.67/s and loses 1667 J, by friction in time or as an ideal switch at once") {
  for (const bool ideal : {false, true}) {
    const Answer run = answer(model(
        std::string(R"x("a": {"kind": "I", "inertance": 1, "initial": {"f": 100}}, "b": {"kind": "I", "inertance": 0.5},
         "drive": {"kind": "1"}, "node": {"kind": "0"}, "load": {"kind": "1"}, "clutch": )x") +
            (ideal ? R"x({"kind": "Sw", "locked": "t >= 1"})x" : R"x({"kind": "R", "law": "e = 20*sign(f)"})x"),
        "drive>a drive>node node>clutch node>load load>b", R"x("wa": "a.f", "wb": "b.f")x",
        R"x("times": [0, 0.5, 3], "stop": 3)x"));
    near(last(run.result, "wa"), 200.0 / 3.0, 100);
    near(last(run.result, "wb"), 200.0 / 3.0, 100);
    near(run.result.report.energy.switching, ideal ? 5000.0 / 3.0 : 0.0, 5000);
    near(run.result.report.energy.dissipated, ideal ? 0.0 : 5000.0 / 3.0, 5000);
    if (ideal) continue;
    near(run.result.trace["wa"][1], 90.0, 100);
    const auto held = std::find_if(run.events.begin(), run.events.end(),
                                   [](const RunEvent& event) { return event.to == "held" || event.to == "0"; });
    REQUIRE(held != run.events.end());
    near(held->t, 5.0 / 3.0);
  }
}

TEST_CASE("a half-wave rectifier with R = L = 1 lets go at 3.94 rad") {
  const std::string times =
      "[0, " + number_text(kPi / 2, 17) + ", " + number_text(kPi, 17) + ", " + number_text(2 * kPi, 17) + "]";
  const Answer run = answer(model(
      R"x("v": {"kind": "Se", "effort": "sin(t)"}, "loop": {"kind": "1"}, "r": {"kind": "R", "resistance": 1},
         "l": {"kind": "I", "inertance": 1}, "d": {"kind": "D"})x",
      "v>loop loop>r loop>l loop>d", R"x("i": "l.f", "mean": "area/(2*pi)")x",
      R"x("times": )x" + times + R"x(, "stop": )x" + number_text(2 * kPi, 17),
      R"x("area": {"integral": "r.e + l.e"})x"));
  near(run.times_of(RunEvent::Kind::diode, "d", "blocks").front(), 3.940733135693);
  near(run.result.trace["i"][1], 0.6039397881754);
  near(run.result.trace["i"][2], 0.5216069591319);
  near(last(run.result, "mean"), 0.2701373506169);
}

namespace {

const std::string kChopper = R"x("v": {"kind": "Se", "effort": 1}, "in": {"kind": "1"}, "node": {"kind": "0"},
    "high": {"kind": "Sw", "closed": "t - floor(t) < 0.5"}, "free": {"kind": "D", "passes": "out"}, "loop": {"kind": "1"},
    "r": {"kind": "R", "resistance": 1}, "l": {"kind": "I", "inertance": 1})x";
constexpr const char* kChopperBonds = "v>in in>high in>node node>free node>loop loop>r loop>l";

}  // namespace

TEST_CASE("an RL chopper from rest and in its periodic state") {
  const Answer run = answer(
      model(kChopper, kChopperBonds, R"x("i": "l.f")x", R"x("times": [0, 0.5, 1, 1.5, 2, 40, 40.5], "stop": 40.5)x"));
  const std::vector<double> right{
      0.0, 0.3934693402874, 0.2386512185412, 0.5382186213104, 0.326446095453, 0.3775406687981, 0.6224593312019};
  for (std::size_t k = 0; k < right.size(); ++k) near(run.result.trace["i"][k], right[k]);
}

TEST_CASE("an RL chopper is where it has to be after up to 1e5 periods", "[long]") {
  const std::uint64_t periods = share_of(100000) < 100000 ? 10000 : 100000;  // all in scripts/test --slow
  const std::string last = std::to_string(periods), before = std::to_string(periods - 1);
  const Answer run = answer(model(kChopper, kChopperBonds, R"x("i": "l.f")x",
                                  R"("times": [)" + before + ", " + before + ".5, " + last + R"(], "stop": )" + last));
  near(run.result.trace["i"][0], 0.3775406687981);
  near(run.result.trace["i"][1], 0.6224593312019);
  near(run.result.trace["i"][2], 0.3775406687981);
  CHECK(run.times_of(RunEvent::Kind::switching, "high").size() == 2 * periods);
  CHECK(run.result.report.modes <= 3);
}

TEST_CASE("a buck converter with a freewheel diode, from rest and in its periodic state", "[long]") {
  nlohmann::json buck = nlohmann::json::parse(file_text(in_project("models/buck.json")));
  buck["scenes"] = {{"run", {{"relative", 1e-11}, {"stop", 0.04001}, {"times", {2e-5, 4e-5, 6e-5, 0.04, 0.04001}}}}};
  const Answer run = answer(buck.dump());
  const std::vector<std::pair<double, double>> right{{2.37235864437, 0.352986119849},
                                                     {4.6293084202, 1.14729326903},
                                                     {6.6871728941, 2.33457545},
                                                     {1.799499519554, 11.99989980371},
                                                     {3.000500480446, 12.00010019629}};
  for (std::size_t k = 0; k < right.size(); ++k) {
    near(run.result.trace["i"][k], right[k].first, 10);
    near(run.result.trace["u"][k], right[k].second, 10);
  }
}

TEST_CASE("a bridge of six diodes: mean, least and greatest voltage") {
  nlohmann::json bridge = nlohmann::json::parse(file_text(in_project("models/rectifier_b6.json")));
  bridge["signals"] = {{"area", {{"integral", "r.e + l.e"}}}};
  bridge["outputs"]["area"] = "area";
  bridge["scenes"] = {
      {"run", {{"relative", 1e-11}, {"stop", 2 * kPi}, {"times", {0.0, kPi / 6, kPi / 3, kPi / 2, 2 * kPi}}}}};
  const Answer run = answer(bridge.dump());
  near(last(run.result, "area") / (2 * kPi), 1.653986686265);
  for (const std::size_t low : {0U, 2U}) near(run.result.trace["u"][low], 1.5);
  for (const std::size_t high : {1U, 3U}) near(run.result.trace["u"][high], std::sqrt(3.0));
}

TEST_CASE("a block on a belt sticks for 10 s and slips for 3.536 s") {
  nlohmann::json block = nlohmann::json::parse(file_text(in_project("models/stick_slip.json")));
  const double slip = 3.53638377329, greatest = 10.0 + std::atan(0.2);
  block["scenes"] = {
      {"run",
       {{"relative", 1e-11}, {"stop", 10.0 + slip + 10.5}, {"times", {10.0, greatest, greatest + kPi, 10.0 + slip}}}}};
  const Answer run = answer(block.dump());
  // It slips where the grip lets go, and sticks from where friction holds it.
  const std::vector<double> slips = run.times_of(RunEvent::Kind::switching, "grip", "closed");
  const std::vector<double> sticks = run.times_of(RunEvent::Kind::switching, "grip", "open");
  REQUIRE(slips.size() == 2);
  REQUIRE(sticks.size() == 1);
  near(slips[0], 10.0, 10);
  near(sticks[0], 10.0 + slip, 10);
  near(slips[1], 10.0 + slip + 10.0, 10);
  near(run.result.trace["x"][0], 1.0);
  near(run.result.trace["x"][1], 1.009901951359);
  near(run.result.trace["x"][2], -0.009901951359);
  near(run.result.trace["x"][3], 0.0);
}

TEST_CASE("a mass on a spring with dry friction 0.1 turns at 1, -0.8, 0.6, -0.4, 0.2 and rests at 0") {
  std::string times = "0";
  for (int k = 1; k <= 6; ++k) times += ", " + number_text(k * kPi, 17);
  for (const char* method : {"auto", "radau", "rodas5p", "erk5", "dirk4"}) {
    INFO(method);
    const Answer run = answer(model(
        R"x("v": {"kind": "1"}, "m": {"kind": "I", "inertance": 1}, "spring": {"kind": "C", "capacitance": 1, "initial": {"q": 1}},
           "rub": {"kind": "R", "law": "e = 0.1*sign(f)"})x",
        "v>m v>spring v>rub", R"x("x": "spring.q", "v": "m.f")x",
        R"x("times": [)x" + times + R"x(, 20], "stop": 20, "method": ")x" + method + "\""));
    const std::vector<double> right{1.0, -0.8, 0.6, -0.4, 0.2, 0.0, 0.0, 0.0};
    for (std::size_t k = 0; k < right.size(); ++k) near(run.result.trace["x"][k], right[k]);
    near(last(run.result, "v"), 0.0);
  }
}

TEST_CASE("friction that stops a block and lets it go at once turns its force over") {
  // Pushed back by 0.3 against friction of 0.1: it comes to rest after 2.5 s at an acceleration of 0.4, and goes back
  // from there with 0.2 in the same instant. A push of 0.1 it holds.
  for (const char* method : {"auto", "radau", "rodas5p", "bdf", "erk5", "dirk4"})
    for (const double push : {0.3, 0.1}) {
      INFO(method << ", " << push);
      const Answer run =
          answer(model(R"x("push": {"kind": "Se", "effort": )x" + number_text(push, 17) +
                           R"x(}, "v": {"kind": "1"}, "m": {"kind": "I", "inertance": 1, "initial": {"f": -1}},
           "rub": {"kind": "R", "law": "e = 0.1*sign(f)"})x",
                       "push>v v>m v>rub", R"x("x": "x", "v": "m.f")x",
                       R"x("times": [0, 2, 8], "stop": 8, "method": ")x" + std::string(method) + "\"",
                       R"x("x": {"integral": "m.f"})x"));
      const double turn = 1.0 / (push + 0.1), after = push > 0.1 ? 8.0 - turn : 0.0, back = push - 0.1;
      // Multistep methods begin with order 1 after the change: some tolerances more.
      const double size = std::string(method) == "bdf" ? 100.0 : 10.0;
      near(run.result.trace["v"][1], -1.0 + 2.0 * (push + 0.1), size);
      near(last(run.result, "v"), back * after, size);
      near(last(run.result, "x"), -0.5 * turn + 0.5 * back * after * after, size);
    }
}

TEST_CASE("bounces with restitution 0.999 come to their limit after a quarter of an hour", "[long]") {
  const Answer run = answer(model(kBall + "0.999}", "weight>fall fall>ball fall>ground", R"x("h": "-ground.q")x",
                                  R"x("times": [0, 950], "stop": 950)x"));
  const double first = std::sqrt(2.0 / 9.81), limit = first * 1.999 / 0.001;
  const std::string& note =
      *std::find_if(run.result.report.notes.begin(), run.result.report.notes.end(),
                    [](const auto& text) { return text.find("closes at t = ") != std::string::npos; });
  near(std::stod(note.substr(note.find("closes at t = ") + 14)), limit,
       10 * limit);  // 13,000 flights, each as exact as a step
  CHECK(run.times_of(RunEvent::Kind::impact, "ground").size() > 10000);
  CHECK(last(run.result, "h") == 0.0);
}
