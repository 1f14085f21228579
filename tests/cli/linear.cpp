// bgsim linearize, poles, zeros, bode, step, steady: results, files, refusals.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bgsim/csv.hpp"
#include "command.hpp"

using Catch::Contains;

namespace {

/// A mass on a spring and a damper, pushed: m = 2, k = 8, d = 0.4.
const char* const kMass = R"({ "bgsim": 1, "name": "mass", "parameters": { "F": { "value": 0, "unit": "N" },
  "m": { "value": 2, "unit": "kg" }, "k": { "value": 8, "unit": "N/m" }, "d": { "value": 0.4, "unit": "N s/m" } },
  "elements": { "push": { "kind": "Se", "effort": "F" }, "v": { "kind": "1" }, "body": { "kind": "I", "inertance": "m" },
    "spring": { "kind": "C", "capacitance": "1/k" }, "damper": { "kind": "R", "resistance": "d" } },
  "bonds": [ { "from": "push", "to": "v" }, { "from": "v", "to": "body" }, { "from": "v", "to": "spring" },
    { "from": "v", "to": "damper" } ],
  "outputs": { "x": { "value": "spring.q", "unit": "m" } },
  "scenes": { "rest": { "stop": 10, "samples": 101 }, "pulled": { "stop": 10, "samples": 101, "initial": { "spring.q": 1 } } } })";

/// A folder with that model.
struct WithMass : Workplace {
  WithMass() { write("mass.json", kMass); }
};

}  // namespace

TEST_CASE("the matrices of a mass on a spring are printed and written, with names and units") {
  const WithMass here;
  const Outcome printed = here.bgsim("linearize mass.json");
  CHECK(printed.code == 0);
  CHECK_THAT(printed.out, Contains("x' = A x + B u, y = C x + D u") && Contains("body.p") && Contains("N s"));
  CHECK(here.bgsim("linearize mass.json --in push,k -o a.json").code == 0);
  const auto json = nlohmann::json::parse(here.read("a.json"));
  CHECK(json["states"][0]["name"] == "body.p");
  CHECK(json["A"] == nlohmann::json({{-0.2, -8.0}, {0.5, 0.0}}));
  // At rest the stiffness does nothing.
  CHECK(json["B"] == nlohmann::json({{1.0, 0.0}, {0.0, 0.0}}));
  CHECK(json["C"] == nlohmann::json({{0.0, 1.0}}));
  CHECK(here.bgsim("linearize mass.json --scene pulled --in k -o b.csv --quiet").code == 0);
  CHECK_THAT(here.read("b.csv"), Contains("B,body.p,k,-1\r\n"));
  CHECK(here.bgsim("linearize mass.json --descriptor -o c.m").code == 0);
  CHECK_THAT(here.read("c.m"), Contains("E(1, 1) = 1;") && Contains("state_names = {'body.p', 'spring.q'}"));
}

TEST_CASE("poles are printed with damping, frequency, and the stores they belong to") {
  const WithMass here;
  const Outcome outcome = here.bgsim("poles mass.json");
  CHECK(outcome.code == 0);
  // s^2 + 0.2 s + 4: damping 0.05, 2 rad/s
  CHECK_THAT(outcome.out, Contains("-0.1 +- 1.9975j") && Contains("0.05") && Contains("body 50 %"));
  CHECK_THAT(here.bgsim("poles mass.json --set d=-0.4").out, Contains("2 poles grow: unstable"));
}

TEST_CASE("what inputs move and outputs show is printed") {
  const WithMass here;
  const Outcome all = here.bgsim("control mass.json");
  CHECK(all.code == 0);
  CHECK(all.out.find("controllable by push.e: 2 of 2 states\nobservable in x: 2 of 2 states\n") != std::string::npos);
  // At rest the stiffness does nothing.
  const Outcome none = here.bgsim("control mass.json --in k --out push.f");
  CHECK(none.code == 1);
  CHECK_THAT(none.out,
             Contains("controllable by k: 0 of 2") && Contains("no causal path from an input: body.p, spring.q"));
  CHECK(here.bgsim("control mass.json --in nothing").code == 1);
}

TEST_CASE("a transfer function is printed in symbols, with its paths and loops") {
  const WithMass here;
  const Outcome outcome = here.bgsim("transfer mass.json --in push --out x --paths");
  CHECK(outcome.code == 0);
  CHECK(outcome.err.empty());
  CHECK_THAT(outcome.out, Contains("\ns^2          2      m\n") && Contains("\ns            0.4    d\n") &&
                              Contains("\n1            8      k\n") && Contains("body, spring") &&
                              Contains("-k/(m*s^2)"));
  CHECK(here.bgsim("transfer mass.json --out x").code == 2);
  CHECK(here.bgsim("transfer mass.json --in m --out x").code == 1);
}

TEST_CASE("a transfer function that is zero at the point is printed without a false note") {
  // Two branches of an RC each, side by side: the voltages of their capacitors differ by nothing where R1 C1 = R2 C2.
  const Workplace here;
  const auto model = [](const char* r2, const char* c2) {
    return R"x({ "bgsim": 1, "parameters": { "R1": 2, "C1": 0.5 }, "elements": {
      "u": { "kind": "Se", "effort": 1 }, "n": { "kind": "0" },
      "j1": { "kind": "1" }, "r1": { "kind": "R", "resistance": "R1" }, "c1": { "kind": "C", "capacitance": "C1" },
      "j2": { "kind": "1" }, "r2": { "kind": "R", "resistance": ")x" +
           std::string(r2) + R"x(" }, "c2": { "kind": "C", "capacitance": ")x" + c2 + R"x(" } },
      "bonds": [ { "from": "u", "to": "n" }, { "from": "n", "to": "j1" }, { "from": "n", "to": "j2" },
        { "from": "j1", "to": "r1" }, { "from": "j1", "to": "c1" }, { "from": "j2", "to": "r2" },
        { "from": "j2", "to": "c2" } ], "outputs": { "d": "c1.e - c2.e" }, "scenes": { "run": { "stop": 1 } } })x";
  };
  here.write("alike.json", model("2", "0.5"));
  here.write("same.json", model("R1", "C1"));
  for (const char* name : {"alike.json", "same.json"}) {
    CAPTURE(name);
    const Outcome outcome = here.bgsim("transfer " + std::string(name) + " --in u --out d");
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.err, !Contains("differs from that of the matrices"));
  }
  CHECK_THAT(here.bgsim("transfer same.json --in u --out d").out,
             Contains("numerator  value  coefficient\n1          0      0"));
}

TEST_CASE("zeros and gain of a transfer function are printed") {
  const WithMass here;
  const Outcome outcome = here.bgsim("zeros mass.json --in F --out push.f");
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("zero  0") && Contains("gain 0.5") && Contains("static gain 0"));
  CHECK_THAT(here.bgsim("zeros mass.json --in F --out x").out,
             Contains("no finite zeros") && Contains("static gain 0.125"));
}

TEST_CASE("a frequency response is that of the closed form, as table and as picture") {
  const WithMass here;
  CHECK(here.bgsim("bode mass.json --in push --out x --from 0.1 --to 100 --points 301 -o a.csv -o a.svg").code == 0);
  const bgsim::CsvTable table = bgsim::parse_csv(here.read("a.csv"));
  REQUIRE(table.columns[0].size() == 301);
  for (std::size_t i = 0; i < 301; ++i) {
    const double w = table.columns[0][i];
    const std::complex<double> s(0.0, w), exact = 1.0 / (2.0 * s * s + 0.4 * s + 8.0);
    // Fifteen digits are written.
    CHECK(table.columns[2][i] == Approx(std::abs(exact)).epsilon(1e-12));
    CHECK(table.columns[5][i] == Approx(exact.real()).epsilon(1e-11).margin(1e-15));
  }
  CHECK_THAT(here.read("a.svg"), Contains(">deg</text>") && Contains("angular frequency in rad/s"));
  const Outcome impedance = here.bgsim("bode mass.json --impedance push --hz --from 1 --to 2 --points 2");
  CHECK(impedance.code == 0);
  const bgsim::CsvTable seen = bgsim::parse_csv(impedance.out);
  const double w = 2.0 * 3.14159265358979323846;
  CHECK(seen.columns[5][0] == Approx(0.4).epsilon(1e-12));
  CHECK(seen.columns[6][0] == Approx(2.0 * w - 8.0 / w).epsilon(1e-12));
}

TEST_CASE("without damping the phase falls at a pole and rises at a zero") {
  const Workplace here;
  // Foster's reactance theorem: the phase of a lossless one-port is 90 or -90 degrees, its poles and zeros in turn.
  here.write("ladder.json", R"({"bgsim": 1, "elements": {"s": {"kind": "Sf", "flow": 0},
    "n": {"kind": "0", "repeat": 4}, "c": {"kind": "C", "repeat": 4, "capacitance": "i*1e-3"},
    "j": {"kind": "1", "repeat": 4}, "l": {"kind": "I", "repeat": 4, "inertance": "0.3/i"}, "end": {"kind": "Se", "effort": 0}},
    "bonds": [{"from": "s", "to": "n[1]"}, {"from": "n[i]", "to": "c[i]"}, {"from": "n[i]", "to": "j[i]"},
      {"from": "j[i]", "to": "l[i]"}, {"from": "j[i]", "to": "n[i+1]"}, {"from": "j[4]", "to": "end"}],
    "scenes": {"run": {"stop": 1}}})");
  const auto phases = [&](const std::string& words, std::size_t points) {
    const Outcome outcome = here.bgsim("bode ladder.json " + words);
    INFO(outcome.err);
    CHECK(outcome.code == 0);
    const bgsim::CsvTable table = bgsim::parse_csv(outcome.out);
    CHECK(table.columns[0].size() == points);
    return table.columns.at(4);
  };
  for (const double phase : phases("--impedance s --from 1 --to 1000", 400))
    CHECK(std::abs(phase) == Approx(90.0).epsilon(0).margin(1e-6));  // what counts as half a turn
  // Four poles, and the current into the last coil has no zero: down by two whole turns.
  const std::vector<double> through = phases("--in s --out 'j[4].f' --from 1 --to 1000", 400);
  CHECK(through.front() == Approx(0.0).margin(1e-6));
  CHECK(through.back() == Approx(-720.0).epsilon(0).margin(1e-6));
}

TEST_CASE("a step response is that of the closed form") {
  const WithMass here;
  const Outcome outcome = here.bgsim("step mass.json --in push --out x --stop 5 --points 51");
  CHECK(outcome.code == 0);
  const bgsim::CsvTable table = bgsim::parse_csv(outcome.out);
  const double w = std::sqrt(4.0 - 0.01);
  for (std::size_t i = 0; i < 51; ++i) {
    const double t = table.columns[0][i];
    const double exact = 0.125 * (1.0 - std::exp(-0.1 * t) * (std::cos(w * t) + 0.1 / w * std::sin(w * t)));
    CHECK(table.columns[1][i] == Approx(exact).margin(1e-13));
  }
  CHECK(here.bgsim("step mass.json --in push --out x --impulse -o i.svg").code == 0);
}

TEST_CASE("what a step or an impulse makes of a derivative of its source is said, by order") {
  // A capacitor across a source: i = C u'. A mass behind another store of its kind: e = 2 u + 3 u'.
  Workplace here;
  here.write(
      "c.json",
      R"x({"bgsim": 1, "name": "c", "elements": {"F": {"kind": "Se", "effort": 1}, "c": {"kind": "C", "capacitance": 0.5}},
    "bonds": [{"from": "F", "to": "c"}], "outputs": {"i": "F.f"}, "scenes": {"s": {"stop": 1}}})x");
  here.write("m.json", R"x({"bgsim": 1, "name": "m", "elements": {"F": {"kind": "Sf", "flow": 1}, "j": {"kind": "1"},
      "m": {"kind": "I", "inertance": 3}, "r": {"kind": "R", "resistance": 2}},
    "bonds": [{"from": "F", "to": "j"}, {"from": "j", "to": "m"}, {"from": "j", "to": "r"}], "outputs": {"e": "F.e", "de": "der(F.e)"},
    "scenes": {"s": {"stop": 1}}})x");
  const auto note = [&](const std::string& arguments) {
    const Outcome outcome = here.bgsim("step " + arguments + " --stop 1 --points 3");
    CHECK(outcome.code == 0);
    return outcome.err;
  };
  CHECK_THAT(note("c.json --in F --out i"), Contains("contains an impulse of weight 0.5 besides"));
  CHECK_THAT(note("c.json --in F --out i --impulse"),
             Contains("contains the derivative of an impulse of weight 0.5 besides"));
  CHECK_THAT(note("m.json --in F --out e"), Contains("contains an impulse of weight 3 besides"));
  CHECK_THAT(note("m.json --in F --out e --impulse"),
             Contains("an impulse of weight 2 and its derivative of weight 3"));
  CHECK_THAT(note("m.json --in F --out de --impulse"),
             Contains("the derivative of an impulse of weight 2 and its second derivative of weight 3"));
}

TEST_CASE("a steady state says that events and samples have no part in it") {
  // The capacitor is emptied whenever it comes to 0.9 of what the source would charge it to.
  const auto model = [](const std::string& more) {
    return R"({ "bgsim": 1, "elements": { "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1 }, "c": { "kind": "C", "capacitance": 1 } },
      "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "c" } ],)" +
           more + R"("scenes": { "run": { "stop": 1 } } })";
  };
  const Workplace here;
  here.write("event.json", model(R"("events": { "empty": { "when": "c.e > 0.9", "set": { "c.q": "0" } } },)"));
  here.write("sample.json", model(R"("signals": { "u": { "value": "c.e", "every": 0.1 } },)"));
  here.write("plain.json", model(""));
  CHECK_THAT(here.bgsim("steady event.json").out, Contains("empty, an event of the model, sets values at an instant") &&
                                                      Contains("whether the point stays at rest is not known"));
  CHECK_THAT(here.bgsim("steady sample.json").out, Contains("u, a sampled signal, sets values at an instant"));
  CHECK_THAT(here.bgsim("steady plain.json").out, !Contains("instant"));
  CHECK_THAT(here.bgsim("poles event.json").err, Contains("empty, an event of the model, sets values at an instant"));
}

TEST_CASE("a linear system has what is sampled, latched and switched at the start of the run") {
  // A coil with a resistance that is sampled at 2 + 3 t, or 1 once a latch is set, or behind a switch that a latch
  // closes: all of them act from the start on. What a signal was before ("initial") is no value of the run.
  const auto model = [](const std::string& signal, const std::string& law) {
    return R"x({ "bgsim": 1, "elements": { "u": { "kind": "Se", "effort": 10 }, "j": { "kind": "1" },
      "r": { "kind": "MR", "resistance": ")x" +
           law + R"x(" }, "l": { "kind": "I", "inertance": 1 } }, "bonds": [ { "from": "u", "to": "j" },
      { "from": "j", "to": "r" }, { "from": "j", "to": "l" } ], "signals": { "g": )x" +
           signal + R"x( }, "outputs": { "i": "l.f" }, "scenes": { "run": { "stop": 3 } } })x";
  };
  const Workplace here;
  here.write("sampled.json", model(R"x({ "value": "2 + 3*t", "every": 1 })x", "g"));
  here.write("latch.json", model(R"x({ "set": "l.f < 3", "reset": "l.f > 60" })x", "if(g, 2, 5)"));
  here.write("switch.json", R"x({ "bgsim": 1, "elements": { "u": { "kind": "Se", "effort": 10 }, "j": { "kind": "1" },
      "s": { "kind": "Sw", "closed": "on" }, "r": { "kind": "R", "resistance": 2 },
      "c": { "kind": "C", "capacitance": 0.25 } }, "bonds": [ { "from": "u", "to": "j" }, { "from": "j", "to": "s" },
      { "from": "j", "to": "r" }, { "from": "j", "to": "c" } ],
      "signals": { "on": { "set": "t >= 0", "reset": "t > 5" } }, "outputs": { "i": "r.f" },
      "scenes": { "run": { "stop": 3 } } })x");
  for (const char* name : {"sampled.json", "latch.json", "switch.json"})
    for (const char* at : {"", " --at 0", " --at 1e-9"}) {
      CAPTURE(name, at);
      const Outcome outcome = here.bgsim("poles " + std::string(name) + at);
      CHECK_THAT(outcome.out, Contains("\n-2 "));
      CHECK_THAT(outcome.err, !Contains("its condition says otherwise"));
    }
  CHECK_THAT(here.bgsim("zeros sampled.json --in u --out i").out, Contains("static gain 0.5\n"));
  for (const char* name : {"sampled.json", "latch.json"}) {
    CAPTURE(name);
    CHECK_THAT(here.bgsim("steady " + std::string(name)).out, Contains("l.p    5"));
  }
}

TEST_CASE("a body that friction holds has no poles of a side that rounding takes") {
  // It slides, and stops: what is left of its speed is 1e-17, on one side of the kink or the other.
  const Workplace here;
  here.write("held.json", R"x({ "bgsim": 1, "elements": { "F": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" },
      "m": { "kind": "I", "inertance": 1, "initial": { "p": 1 } }, "r": { "kind": "R", "law": "e = 2*sign(f) + 0.5*f" },
      "k": { "kind": "C", "capacitance": 0.1, "initial": { "q": 0.3 } } }, "bonds": [ { "from": "F", "to": "j" },
      { "from": "j", "to": "m" }, { "from": "j", "to": "r" }, { "from": "j", "to": "k" } ], "outputs": { "v": "m.f" },
      "scenes": { "run": { "stop": 10 } } })x");
  CHECK_THAT(here.bgsim("poles held.json --at 0.1").out, Contains("-0.25 +- 3.15238j"));  // while it slides
  for (const char* command : {"poles", "linearize"}) {
    const Outcome held = here.bgsim(std::string(command) + " held.json --at 10");
    CHECK(held.code == 1);
    CHECK_THAT(held.err, Contains("BG408") && Contains("sign(m.p) (r) is at its border"));
  }
}

TEST_CASE("a steady state is printed with its residual and stability, and taken as a point") {
  const WithMass here;
  const Outcome outcome = here.bgsim("steady mass.json --set F=4 --scene pulled");
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("1 steady state found") && Contains("stable") && Contains("spring.q  0.5") &&
                              Contains("residual"));
  const Outcome point = here.bgsim("linearize mass.json --at steady --set F=4 --in k");
  CHECK(point.code == 0);
  CHECK_THAT(point.out, Contains("at rest"));
  CHECK_THAT(here.bgsim("linearize mass.json --scene pulled --at 2").out, Contains("at t = 2 of the scene pulled"));
  CHECK_THAT(here.bgsim("poles mass.json --scene pulled").err, Contains("the point is no equilibrium"));
}

TEST_CASE("poles at a time of a run are those of the mode that its switches are in then") {
  const Workplace here;
  // 1/s; with the relay, which closes once u = 1 - exp(-t) is 0.9 and holds, 1 + 4 = 5/s; from t = 5 on 1 + 3 + 4 =
  // 8/s, at u = 1/8.
  here.write("rc.json", R"({ "bgsim": 1, "name": "rc",
    "elements": { "v": { "kind": "Se", "effort": 1 }, "in": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
      "node": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1 },
      "late": { "kind": "1" }, "s": { "kind": "Sw", "closed": "t > 5" }, "r2": { "kind": "R", "resistance": "1/3" },
      "full": { "kind": "1" }, "relay": { "kind": "Sw", "close": "c.e > 0.9", "open": "c.e < 0.1" },
      "r3": { "kind": "R", "resistance": 0.25 } },
    "bonds": [ { "from": "v", "to": "in" }, { "from": "in", "to": "r" }, { "from": "in", "to": "node" },
      { "from": "node", "to": "c" }, { "from": "node", "to": "late" }, { "from": "late", "to": "s" },
      { "from": "late", "to": "r2" }, { "from": "node", "to": "full" }, { "from": "full", "to": "relay" },
      { "from": "full", "to": "r3" } ],
    "outputs": { "u": "c.e" }, "scenes": { "run": { "stop": 10, "samples": 11 } } })");
  const auto pole = [&](const std::string& at) {
    const Outcome done = here.bgsim("poles rc.json --at " + at);
    CAPTURE(at, done.err);
    CHECK(done.code == 0);
    return done.out;
  };
  CHECK_THAT(pole("start"), Contains("-1 "));
  CHECK_THAT(pole("2"), Contains("-1 ") && Contains("s open, relay open"));
  CHECK_THAT(pole("4"), Contains("-5 ") && Contains("s open, relay closed"));
  CHECK_THAT(pole("9"), Contains("-8 ") && Contains("s closed, relay closed"));
  const Outcome both = here.bgsim("poles rc.json --at 2 --mode s=closed");
  CHECK(both.code == 2);
  CHECK_THAT(both.err, Contains("--mode and --at 2 contradict each other"));
}

TEST_CASE("a value that --set gives decides the mode in which a model is linearized") {
  const Workplace here;
  here.write("rc.json", R"({ "bgsim": 1, "name": "rc", "parameters": { "from": 1 },
    "elements": { "v": { "kind": "Se", "effort": 1 }, "in": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
      "node": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1 }, "late": { "kind": "1" },
      "s": { "kind": "Sw", "closed": "t > from" }, "r2": { "kind": "R", "resistance": 0.25 } },
    "bonds": [ { "from": "v", "to": "in" }, { "from": "in", "to": "r" }, { "from": "in", "to": "node" },
      { "from": "node", "to": "c" }, { "from": "node", "to": "late" }, { "from": "late", "to": "s" },
      { "from": "late", "to": "r2" } ],
    "outputs": { "u": "c.e" }, "scenes": { "run": { "stop": 10, "samples": 11 } } })");
  CHECK_THAT(here.bgsim("poles rc.json").out, Contains("s open") && Contains("\n-1 "));
  CHECK_THAT(here.bgsim("poles rc.json --set from=-1").out, Contains("s closed") && Contains("\n-5 "));
  // At rest 1 V without the switch; with it, from t = 1 on, 1/(1 + 4) of that.
  CHECK_THAT(here.bgsim("steady rc.json").out, Contains("c.q    1\n"));
  CHECK_THAT(here.bgsim("steady rc.json --time 2").out, Contains("c.q    0.2\n"));
  const Outcome twice = here.bgsim("poles rc.json --mode s=closed,s=open");
  CHECK(twice.code != 0);
  CHECK_THAT(twice.err, Contains("the side of \"s\" is given twice"));
}

TEST_CASE("a list of outputs takes expressions beside names") {
  const WithMass here;
  const Outcome several = here.bgsim("linearize mass.json --in push --out 'x,F=min(1e9, spring.e),v=body.f' -o a.json");
  CAPTURE(several.err);
  CHECK(several.code == 0);
  const auto json = nlohmann::json::parse(here.read("a.json"));
  REQUIRE(json["outputs"].size() == 3);
  for (std::size_t i = 0; i < 3; ++i) CHECK(json["outputs"][i]["name"] == std::vector<std::string>{"x", "F", "v"}[i]);
  CHECK_THAT(here.bgsim("linearize mass.json --out 'x,,v=body.f'").err, Contains("empty name"));
}

TEST_CASE("the phase falls at a resonance that is narrow beside the step of the frequencies") {
  const WithMass here;
  // Damping ratios of 0.05 to 1e-9: half a turn at 2 rad/s, whatever the number of points.
  for (const char* d : {"0.4", "1e-3", "1e-6", "8e-9"})
    for (const char* points : {"7", "20", "400"}) {
      const Outcome done = here.bgsim("bode mass.json --in push --out x --from 0.1 --to 50 --points " +
                                      std::string(points) + " --set d=" + d + " -o b.csv");
      CAPTURE(d, points, done.err);
      REQUIRE(done.code == 0);
      const bgsim::CsvTable table = bgsim::parse_csv(here.read("b.csv"));
      const auto& phase = table.columns[4];
      CHECK(phase.front() == Approx(0.0).margin(1.0));
      CHECK(phase.back() == Approx(-180.0).margin(1.0));
    }
}

TEST_CASE("the phase behind a hundred resonances has fallen by half a turn at each") {
  const Workplace here;
  std::string elements = R"("v": { "kind": "Se", "effort": 0 })", bonds, before = "v";
  constexpr int kSections = 100;
  for (int i = 0; i < kSections; ++i) {
    const std::string n = std::to_string(i);
    elements += R"(, "j)" + n + R"(": { "kind": "1" }, "r)" + n + R"(": { "kind": "R", "resistance": 0.01 }, "l)" + n +
                R"(": { "kind": "I", "inertance": 1 }, "n)" + n + R"(": { "kind": "0" }, "c)" + n +
                R"(": { "kind": "C", "capacitance": 1 })";
    for (const auto& [from, to] : {std::pair{before, "j" + n}, std::pair{"j" + n, "r" + n}, std::pair{"j" + n, "l" + n},
                                   std::pair{"j" + n, "n" + n}, std::pair{"n" + n, "c" + n}})
      bonds += (bonds.empty() ? "" : ", ") + (R"({ "from": ")" + from) + R"(", "to": ")" + to + "\" }";
    before = "n" + n;
  }
  here.write("line.json", R"({ "bgsim": 1, "name": "line", "elements": { )" + elements + R"( }, "bonds": [ )" + bonds +
                              R"( ], "outputs": { "u": "c99.e" }, "scenes": { "run": { "stop": 1 } } })");
  for (const char* points : {"30", "400"}) {
    const Outcome done = here.bgsim("bode line.json --in v --out u --from 0.01 --to 3 --points " + std::string(points));
    CAPTURE(points, done.err);
    REQUIRE(done.code == 0);
    const bgsim::CsvTable table = bgsim::parse_csv(done.out);
    // Of each section beyond its cut-off 2 rad/s: -180 deg, less what its resistance makes of that, 0.26 deg.
    CHECK(table.columns[4].back() == Approx(-180.0 * kSections).margin(0.5 * kSections));
  }
}

TEST_CASE("a pole at 0 is free where equilibria are beside the point, and nowhere else") {
  const Workplace here;
  const auto write = [&](const std::string& law) {
    here.write("c.json", R"({ "bgsim": 1, "name": "c", "elements": { "j": { "kind": "1" },
      "r": { "kind": "R", "resistance": 2 }, "c": { "kind": "C", "law": ")" +
                             law + R"(" } },
      "bonds": [ { "from": "j", "to": "r" }, { "from": "j", "to": "c" } ],
      "outputs": { "u": "c.q" }, "scenes": { "run": { "stop": 1 } } })");
  };
  write("e = -q^3");
  const Outcome cubic = here.bgsim("steady c.json");
  CHECK_THAT(cubic.out, Contains("of unknown stability: a pole is 0 and there is no equilibrium beside this one"));
  CHECK_THAT(cubic.out, !Contains("free:"));
  write("e = if(abs(q) < 1, 0, q)");
  CHECK_THAT(here.bgsim("steady c.json").out, Contains("stable but for what is free") && Contains("free:"));
  here.write("body.json", R"({ "bgsim": 1, "name": "body", "elements": { "f": { "kind": "Se", "effort": 0 },
    "v": { "kind": "1" }, "m": { "kind": "I", "inertance": 2 } },
    "bonds": [ { "from": "f", "to": "v" }, { "from": "v", "to": "m" } ], "signals": { "x": { "integral": "m.f" } },
    "outputs": { "x": "x" }, "scenes": { "run": { "stop": 1 } } })");
  const Outcome body = here.bgsim("steady body.json");
  CHECK_THAT(body.out,
             Contains("unstable: what is free, once pushed, moves on without end") && Contains("by moving x\n"));
}

TEST_CASE("what linear analysis cannot do is refused with a fix") {
  const WithMass here;
  const auto refused = [&](const std::string& arguments, int code, const std::string& message) {
    const Outcome outcome = here.bgsim(arguments);
    INFO(arguments << "\n" << outcome.out << outcome.err);
    CHECK(outcome.code == code);
    CHECK_THAT(outcome.err, Contains(message));
  };
  refused("linearize mass.json --in psh", 1, "did you mean push?");
  refused("linearize mass.json --out sprng.q", 2, "spring");
  refused("linearize mass.json -o a.txt", 2, ".json, .csv or .m");
  refused("linearize mass.json --at never", 2, "neither start, steady nor a time");
  refused("linearize mass.json --at -1", 2, "before the scene's start");
  refused("linearize mass.json --in push,,k", 2, "empty name");
  refused("zeros mass.json --out x", 2, "--in is missing");
  refused("zeros mass.json --in push", 2, "--out is missing");
  refused("bode mass.json --in push --out x --from 2 --to 1", 2, "the range is empty");
  refused("bode mass.json --in push --out x --from 2 --to 2", 2, "the range is empty");
  refused("bode mass.json --in push --out x --from 0", 2, "above zero");
  refused("bode mass.json --in push --out x --points 0", 2, "from 2 to");
  refused("bode mass.json --in push --out x -o a.png", 2, ".csv or .svg");
  refused("bode mass.json --impedance push --out x", 2, "exclude each other");
  refused("step mass.json --in push --out x --stop 0", 2, "above zero");
  refused("step mass.json --in push --out x --points 1", 2, "from 2 to");
  refused("zeros mass.json --in m --out x", 1, "BG410");
  here.write("free.json", R"({ "bgsim": 1, "name": "free", "elements": { "push": { "kind": "Se", "effort": 5 },
    "body": { "kind": "I", "inertance": 2 } }, "bonds": [ { "from": "push", "to": "body" } ],
    "scenes": { "s": { "stop": 1, "samples": 2 } } })");
  refused("steady free.json", 1, "body.p' = 5");
  CHECK_THAT(here.bgsim("poles free.json").out, Contains("free (poles at 0): body.p"));
}

TEST_CASE("of a large system the poles nearest to a number are asked for, and without that the message says how",
          "[long]") {
  const Workplace here;
  // 600 sections of 1 ohm and 1 F, open at the end: the slowest pole is -4 sin^2(pi/(4 n + 2)).
  here.write("line.json", R"({ "bgsim": 1, "name": "line", "elements": { "src": { "kind": "Se", "effort": 0 },
      "s": { "kind": "1", "repeat": 600 }, "r": { "kind": "R", "resistance": 1, "repeat": 600 },
      "p": { "kind": "0", "repeat": 600 }, "c": { "kind": "C", "capacitance": 1, "repeat": 600 } },
    "bonds": [ { "from": "src", "to": "s[1]" }, { "from": "s[i]", "to": "r[i]" }, { "from": "s[i]", "to": "p[i]" },
      { "from": "p[i]", "to": "c[i]" }, { "from": "p[i]", "to": "s[i+1]" } ], "outputs": { "u": "c[600].e" },
    "scenes": { "s": { "stop": 1 } } })");
  const Outcome all = here.bgsim("poles line.json");
  CHECK(all.code == 1);
  CHECK_THAT(all.err, Contains("BG409: 600 states act on each other") && Contains("bgsim poles --count 10"));
  const Outcome some = here.bgsim("poles line.json --count 2");
  CHECK(some.code == 0);
  CHECK_THAT(some.out, Contains("the 2 nearest to 0:") && Contains("-6.84248e-06") && Contains("-6.1582e-05"));
  CHECK_THAT(here.bgsim("poles line.json --near -2").out, Contains("the 10 nearest to -2:"));
  CHECK(here.bgsim("poles line.json --near inf").code == 2);
  CHECK(here.bgsim("poles line.json --count 0").code == 2);
}

TEST_CASE("names with commas and equals signs are given in double quotes") {
  Workplace here;
  std::string model = kMass;
  const std::string plain = R"("x": { "value": "spring.q", "unit": "m" })";
  model.replace(model.find(plain), plain.size(),
                plain + R"(, "v, in m/s": "v.f", "a=b": "spring.e", "say \"so\"": "body.p")");
  here.write("names.json", model);
  const Outcome run =
      here.bgsim(R"(run names.json --scene pulled --record '"v, in m/s", "a=b","say ""so""",x' -o trace.csv)");
  CHECK(run.code == 0);
  CHECK_THAT(here.read("trace.csv"), Catch::StartsWith("t,\"v, in m/s\",a=b,\"say \"\"so\"\"\",x"));
  CHECK(here.bgsim(R"(run names.json --record 'v, in m/s' -o -)").code == 2);
  CHECK_THAT(here.bgsim(R"(sensitivity names.json --scene pulled --of '"a=b"' --to k)").out, Contains("a=b"));
  CHECK(here.bgsim(R"(bode names.json --in push --out '"v, in m/s"')").code == 0);
  CHECK(here.bgsim(R"(run names.json --output '"p,q=r"=2*x' --record x -o out.csv)").code == 0);
  CHECK_THAT(here.read("out.csv"), Catch::StartsWith("t,x,\"p,q=r\""));
}
