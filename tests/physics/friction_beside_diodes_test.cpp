// Dry friction that is held beside ideal diodes and contacts: what holds it and what these carry follow from each
// other.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <set>

#include "support/chain.hpp"
#include "support/rounds.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

constexpr Method kMethods[] = {Method::automatic, Method::bdf, Method::erk5, Method::rodas5p};

RunResult run_scene(const std::string& text, Method method, double relative) {
  return Study::from_text(text).scene("main", with_method(method, relative)).simulate(SimulateOptions{});
}

/// A mass of 1 that a force pulls, a clutch to another mass of 1, and there a backstop: a speed of 0 or less.
std::string clutch_and_backstop(const std::string& law, const std::string& force, const std::string& backstop) {
  return R"({ "bgsim": 1, "name": "backstop", "elements": {
      "n0": { "kind": "1" }, "m0": { "kind": "I", "inertance": 1 }, "F": { "kind": "Se", "effort": ")" +
         force + R"(" }, "h": { "kind": "0" }, "grip": { "kind": "R", "law": ")" + law + R"(" },
      "n1": { "kind": "1" }, "m1": { "kind": "I", "inertance": 1 }, "stop": )" +
         backstop + R"( },
    "bonds": [ { "from": "n0", "to": "m0" }, { "from": "F", "to": "n0" }, { "from": "n0", "to": "h" },
      { "from": "h", "to": "grip" }, { "from": "h", "to": "n1" }, { "from": "n1", "to": "m1" },
      { "from": "n1", "to": "stop" } ],
    "outputs": { "v0": "n0.f", "v1": "n1.f", "push": "stop.e" }, "scenes": { "main": { "stop": 7, "samples": 15 } } })";
}

const char* const kDiode = R"({ "kind": "D", "passes": "out" })";
const char* const kContact = R"({ "kind": "contact", "gap": 0, "initial": { "q": 0 } })";

}  // namespace

TEST_CASE("a backstop beside friction that is held opens where the force turns") {
  // Both masses go back together, with a quarter of the force. The effort of the backstop is that of friction, which a
  // network with its sign at 0 knows nothing of: it pulled.
  const struct {
    std::string force;
    double (*speed)(double);
  } members[] = {
      {"0.5*cos(t)", [](double t) { return t < M_PI_2 ? 0.0 : 0.25 * (std::sin(t) - 1.0); }},
      {"if(t < 1, 0.5, -0.5)", [](double t) { return -0.25 * std::max(0.0, t - 1.0); }},
      {"-0.5", [](double t) { return -0.25 * t; }},
  };
  for (const std::string law : {"e = sign(f)", "e = if(f >= 0, 1, -1)", "e = if(f < 0, -1, 1)", "e = 2*step(f) - 1",
                                "e = if(f > 0, 1, if(f < 0, -1, 0))"})
    for (const auto& member : members)
      for (const char* const backstop : {kDiode, kContact})
        for (const Method method : kMethods) {
          INFO(law << ", " << member.force << ", " << backstop << " by " << method_name(method));
          const RunResult run = run_scene(clutch_and_backstop(law, member.force, backstop), method, 1e-8);
          REQUIRE(run.stop == StopReason::completed);
          for (std::size_t i = 0; i < run.trace.times.size(); ++i) {
            // A hundred tolerances of the largest speed, 0.5.
            const double exact = member.speed(run.trace.times[i]);
            CHECK(column(run, "v0")[i] == Approx(exact).margin(5e-7));
            CHECK(column(run, "v1")[i] == Approx(exact).margin(5e-7));
            CHECK(column(run, "push")[i] >= -1e-9);
          }
        }
}

TEST_CASE("a ratchet beside friction that is held drags nothing along") {
  // m2 is pulled back and holds m0 by friction; m1 may go faster than m0, not slower.
  const std::string text = R"j({ "bgsim": 1, "name": "ratchet", "elements": {
      "n0": { "kind": "1" }, "m0": { "kind": "I", "inertance": 1 }, "n1": { "kind": "1" },
      "m1": { "kind": "I", "inertance": 1 }, "n2": { "kind": "1" }, "m2": { "kind": "I", "inertance": 1 },
      "F": { "kind": "Se", "effort": -0.08 }, "h": { "kind": "0" }, "ratchet": { "kind": "D", "passes": "out" },
      "k": { "kind": "0" }, "grip": { "kind": "R", "law": "e = sign(f)" } },
    "bonds": [ { "from": "n0", "to": "m0" }, { "from": "n1", "to": "m1" }, { "from": "n2", "to": "m2" },
      { "from": "F", "to": "n2" }, { "from": "n0", "to": "h" }, { "from": "h", "to": "n1" },
      { "from": "h", "to": "ratchet" }, { "from": "n0", "to": "k" }, { "from": "k", "to": "n2" },
      { "from": "k", "to": "grip" } ],
    "outputs": { "v0": "n0.f", "v1": "n1.f", "v2": "n2.f" }, "scenes": { "main": { "stop": 4, "samples": 5 } } })j";
  for (const Method method : kMethods) {
    INFO(method_name(method));
    const RunResult run = run_scene(text, method, 1e-8);
    REQUIRE(run.stop == StopReason::completed);
    CHECK(column(run, "v0").back() == Approx(-0.16).epsilon(1e-9));
    CHECK(column(run, "v2").back() == Approx(-0.16).epsilon(1e-9));
    CHECK(std::abs(column(run, "v1").back()) <= 1e-12);
  }
}

namespace {

using Rows = std::vector<std::vector<double>>;

/// The largest difference, in parts of the largest speed.
double between(const Rows& a, const Rows& b) {
  double largest = 0.1, most = 0.0;
  for (std::size_t row = 0; row < a.size(); ++row)
    for (std::size_t i = 0; i < a[row].size(); ++i) {
      largest = std::max(largest, std::abs(a[row][i]));
      most = std::max(most, std::abs(a[row][i] - b[row][i]));
    }
  return most / largest;
}

/// How far speeds are from time stepping; none where that has not come to an answer itself: of masses that throw each
/// other to and fro at intervals of its steps it has another one for each step.
std::optional<double> off_from_stepping(const Chain& chain, const RunResult& run) {
  constexpr double kKnown = 1e-3, kOff = 2e-3;
  Rows speeds(run.trace.times.size());
  for (std::size_t row = 0; row < speeds.size(); ++row)
    for (std::size_t i = 0; i < chain.masses.size(); ++i)
      speeds[row].push_back(column(run, "v" + std::to_string(i))[row]);
  Rows rows = chain.stepped(1e-4);
  for (const double step : {2e-5, 1e-6}) {
    Rows finer = chain.stepped(step);
    if (between(finer, rows) > kKnown) return std::nullopt;
    rows = std::move(finer);
    if (between(rows, speeds) <= kOff) break;
  }
  return between(rows, speeds);
}

}  // namespace

TEST_CASE("friction between what a backstop and a contact lock has a part, and is noted") {
  // m1 is pushed against the backstop and against m2, which 0.2 pull away from it and friction of 1 holds. Up to 0.3 s
  // friction holds both; then the backstop takes what is more, and the part of friction is anything from 0.2 on.
  const std::string text = R"j({ "bgsim": 1, "name": "locked", "elements": {
      "n1": { "kind": "1" }, "m1": { "kind": "I", "inertance": 1 }, "F1": { "kind": "Se", "effort": "0.5 + t" },
      "stop": { "kind": "D", "passes": "out" }, "h": { "kind": "0" },
      "touch": { "kind": "contact", "gap": 0, "initial": { "q": 0 } }, "n2": { "kind": "1" },
      "m2": { "kind": "I", "inertance": 1 }, "F2": { "kind": "Se", "effort": 0.2 },
      "grip": { "kind": "R", "law": "e = sign(f)" } },
    "bonds": [ { "from": "n1", "to": "m1" }, { "from": "F1", "to": "n1" }, { "from": "n1", "to": "stop" },
      { "from": "n1", "to": "h" }, { "from": "h", "to": "n2" }, { "from": "h", "to": "touch" },
      { "from": "n2", "to": "m2" }, { "from": "F2", "to": "n2" }, { "from": "n2", "to": "grip" } ],
    "outputs": { "v1": "n1.f", "v2": "n2.f", "push": "touch.e", "grip": "grip.e", "stop": "stop.e" },
    "scenes": { "main": { "stop": 2, "samples": 21 } } })j";
  for (const Method method : kMethods) {
    INFO(method_name(method));
    const RunResult run = run_scene(text, method, 1e-8);
    REQUIRE(run.stop == StopReason::completed);
    for (std::size_t i = 0; i < run.trace.times.size(); ++i) {
      const double t = run.trace.times[i], push = column(run, "push")[i], grip = column(run, "grip")[i];
      CHECK(std::abs(column(run, "v1")[i]) <= 1e-12);
      CHECK(std::abs(column(run, "v2")[i]) <= 1e-12);
      CHECK(push >= -1e-9);
      CHECK(grip == Approx(0.2 + push).margin(1e-9));
      CHECK(grip <= 1.0 + 1e-9);
      CHECK(column(run, "stop")[i] == Approx(0.5 + t - push).margin(1e-9));
      CHECK(column(run, "stop")[i] >= -1e-9);
    }
    const auto& notes = run.report.notes;
    CHECK(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
      return note.find("\"grip\" is held between what diodes or contacts lock") != std::string::npos;
    }));
  }
}

TEST_CASE("laws of two sides of very different size run beside a diode that blocks as they do alone") {
  // The side in force is not what is left of both: 1e12 f^3 and 1/(1 - f) are at f = -3 and 1 what loses all digits of
  // the other one, or has no value.
  const auto text = [](const std::string& stop) {
    return R"j({ "bgsim": 1, "name": "sides", "elements": { "n1": { "kind": "1" },
      "m1": { "kind": "I", "inertance": 1, "initial": { "p": -3 } }, "F1": { "kind": "Se", "effort": "if(t < 2, 0, 3)" },
      "b1": { "kind": "R", "law": "e = if(f > 0, 1 + 1e12*f^3, -1/(1 - f))" },
      "b2": { "kind": "R", "law": "e = if(f > 0, 1/(1 + f), if(f < 0, -2, 0))" }, "stop": )j" +
           stop + R"j( }, "bonds": [ { "from": "F1", "to": "n1" }, { "from": "n1", "to": "m1" },
      { "from": "n1", "to": "b1" }, { "from": "n1", "to": "b2" }, { "from": "n1", "to": "stop" } ],
    "outputs": { "v": "n1.f", "b1": "b1.e" }, "scenes": { "main": { "stop": 4, "samples": 41 } } })j";
  };
  const char* const no_stop = R"({ "kind": "Se", "effort": 0 })";
  // The gap is not reached.
  const char* const stop = R"({ "kind": "contact", "gap": 100, "initial": { "q": 0 } })";
  const RunResult alone = run_scene(text(no_stop), Method::automatic, 1e-8);
  REQUIRE(alone.stop == StopReason::completed);
  for (const Method method : kMethods) {
    INFO(method_name(method));
    const RunResult beside = run_scene(text(stop), method, 1e-8);
    REQUIRE(beside.stop == StopReason::completed);
    // Some hundred tolerances of the range, as multistep methods leave them.
    for (std::size_t i = 0; i < alone.trace.times.size(); ++i)
      CHECK(std::abs(column(beside, "v")[i] - column(alone, "v")[i]) <= 3e-6 * 3.0);
  }
}

TEST_CASE("brakes with two limits beside a backstop take what time stepping gives them") {
  // A drum with two brakes and a backstop (its speed is 0 or less), and a mass that grips it. Impulses within their
  // limits by Gauss-Seidel, in steps of 1e-4.
  struct Limits {
    double below, above;
  };
  struct Brakes {
    std::string first, second, grip;
    Limits brakes, grips;
  };
  const Brakes cases[] = {
      {"if(f > 0, 0.3, -0.5)", "if(f < 0, -0.2, 0.1)", "if(f > 0, 0.9, -0.6)", {-0.7, 0.4}, {-0.6, 0.9}},
      {"if(-f > 0, -0.1, 1.3)", "if(0 > f, -0.6, 0.1)", "if(f < 0, -1.2, 0.6)", {-0.7, 1.4}, {-1.2, 0.6}},
  };
  for (const Brakes& brakes : cases) {
    const std::string text = R"j({ "bgsim": 1, "name": "drum", "elements": { "n": { "kind": "1" },
      "J": { "kind": "I", "inertance": 0.5 }, "T": { "kind": "Se", "effort": "4*sin(0.9*t) - 2" },
      "b1": { "kind": "R", "law": "e = )j" +
                             brakes.first + R"j(" }, "b2": { "kind": "R", "law": "e = )j" + brakes.second +
                             R"j(" }, "grip": { "kind": "R", "law": "e = )j" + brakes.grip + R"j(" },
      "stop": { "kind": "D", "passes": "out" }, "h": { "kind": "0" }, "n2": { "kind": "1" },
      "m2": { "kind": "I", "inertance": 1 }, "F2": { "kind": "Se", "effort": "1.5*cos(1.7*t)" } },
    "bonds": [ { "from": "T", "to": "n" }, { "from": "n", "to": "J" }, { "from": "n", "to": "b1" },
      { "from": "n", "to": "b2" }, { "from": "n", "to": "stop" }, { "from": "n", "to": "h" },
      { "from": "h", "to": "grip" }, { "from": "h", "to": "n2" }, { "from": "n2", "to": "m2" },
      { "from": "F2", "to": "n2" } ],
    "outputs": { "v": "n.f", "w": "n2.f" }, "scenes": { "main": { "stop": 10, "samples": 11 } } })j";
    constexpr double kStep = 1e-4, kJ = 0.5, kBoth = kJ / (1.0 + kJ);
    Rows known{{0.0, 0.0}};
    double v = 0.0, w = 0.0, brake = 0.0, grip = 0.0, stop = 0.0;
    for (int step = 0; step < 100000; ++step) {
      const double t = (step + 0.5) * kStep;
      const double freely = v + kStep * (4.0 * std::sin(0.9 * t) - 2.0) / kJ;
      const double mass = w + kStep * 1.5 * std::cos(1.7 * t);
      const auto drum = [&] { return freely - (brake + grip + stop) / kJ; };
      for (int sweep = 0; sweep < 100; ++sweep) {
        brake = std::clamp(brake + kJ * drum(), kStep * brakes.brakes.below, kStep * brakes.brakes.above);
        grip =
            std::clamp(grip + kBoth * (drum() - (mass + grip)), kStep * brakes.grips.below, kStep * brakes.grips.above);
        stop = std::max(0.0, stop + kJ * drum());
      }
      v = drum();
      w = mass + grip;
      if ((step + 1) % 10000 == 0) known.push_back({v, w});
    }
    for (const Method method : kMethods) {
      INFO(brakes.first << " by " << method_name(method));
      const RunResult run = run_scene(text, method, 1e-8);
      REQUIRE(run.stop == StopReason::completed);
      for (std::size_t i = 0; i < known.size(); ++i) {
        // Instants of the steps are off by one step each, times a slope of 10.
        CHECK(std::abs(column(run, "v")[i] - known[i][0]) < 1e-3);
        CHECK(std::abs(column(run, "w")[i] - known[i][1]) < 1e-3);
      }
    }
  }
}

TEST_CASE("a contact at its gap between masses that friction holds does not shorten the steps") {
  // Its displacement is what rounding leaves of two equal speeds. Its tolerance was relative to that alone, since
  // methods whose slopes are by differences where friction is held did not look at the rounding of the rates: 1e4 to
  // 1e5 steps. A step for each of thirty rows and some tens after each of up to twenty changes are enough.
  for (const unsigned seed : {224U, 236U, 328U, 329U, 342U, 360U})
    for (const Method method :
         {Method::automatic, Method::bdf, Method::ida, Method::rodas5p, Method::radau9, Method::dirk5}) {
      std::mt19937 random(seed);
      const Chain chain = random_chain(random, true);
      INFO("seed " << seed << " by " << method_name(method) << ": " << chain.text());
      const RunResult run = run_scene(chain.text(), method, 1e-6);
      REQUIRE(run.stop == StopReason::completed);
      CHECK(run.report.steps < 1000);
      // As in the test of random chains.
      const std::optional<double> off = off_from_stepping(chain, run);
      REQUIRE(off);
      CHECK(*off <= 2e-3);
    }
}

TEST_CASE("random chains with friction and contacts agree with time stepping", "[long]") {
  // Where an impact would create energy a chain is refused. Of the others docs/design/state.md says what is missing.
  const std::map<std::pair<bool, std::uint64_t>, std::string> may_be_refused{
      {{false, 10}, "BG622"}, {{false, 111}, "BG622"}, {{true, 3}, "BG621"}};
  // With contacts: masses that throw each other to and fro at intervals of the steps.
  const std::set<std::uint64_t> unknown_to_stepping{1, 18, 103, 111, 113, 118, 138, 151, 154, 192, 196, 207};
  struct Round {
    std::string direction;
    bool contacts;
    std::uint64_t models;
  };
  std::vector<Round> rounds{{"sign(f)", false, share_of(200)}, {"sign(f)", true, share_of(230)}};
  for (const char* const direction :
       {"if(f > 0, 1, if(f < 0, -1, 0))", "2*step(f) - 1", "if(f < 0, -1, 1)", "1 - 2*step(-f)"})
    for (const bool contacts : {false, true}) rounds.push_back({direction, contacts, share_of(60)});
  for (const Round& round : rounds) {
    for (std::uint64_t seed = 0; seed < round.models; ++seed) {
      std::mt19937 random(static_cast<unsigned>(seed));
      Chain chain = random_chain(random, round.contacts);
      chain.direction = round.direction;
      INFO("seed " << seed << ": " << chain.text());
      const RunResult run = run_scene(chain.text(), Method::automatic, 1e-7);
      if (run.stop != StopReason::completed) {
        INFO(run.failure->situation);
        const auto known = may_be_refused.find({round.contacts, seed});
        REQUIRE(known != may_be_refused.end());
        CHECK(run.failure->code == known->second);
        continue;
      }
      const std::optional<double> off = off_from_stepping(chain, run);
      if (!off) CHECK((round.contacts && unknown_to_stepping.contains(seed)));
      // Twice what is known of the steps.
      CHECK(off.value_or(0.0) <= 2e-3);
    }
  }
}
