// The balance supplied = stored + dissipated is an independent measure of a run's accuracy.
#include <catch2/catch.hpp>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const char* const kRlc = R"json({ "bgsim": 1, "name": "rlc",
  "elements": {
    "source": { "kind": "Se", "effort": "sin(3*t)" }, "loop": { "kind": "1" },
    "r": { "kind": "R", "resistance": 0.5 }, "l": { "kind": "I", "inertance": 1 },
    "c": { "kind": "C", "capacitance": 0.25, "initial": { "q": 0.1 } }
  },
  "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "l" },
    { "from": "loop", "to": "c" } ],
  "outputs": { "q": "c.q", "p": "l.p" },
  "scenes": { "main": { "stop": 20, "samples": 11 } } })json";

/// A two-port store driven around a closed path in its (x, y) plane.
std::string field(const std::string& description) {
  return R"json({ "bgsim": 1, "name": "field",
  "elements": {
    "dx": { "kind": "Sf", "flow": "cos(t)" }, "dy": { "kind": "Sf", "flow": "-2*sin(2*t)" },
    "field": { "kind": "CC", "ports": ["x", "y"], )json" +
         description + R"json(, "initial": { "x.q": 0, "y.q": 1 } }
  },
  "bonds": [ { "from": "dx", "to": "field.x" }, { "from": "dy", "to": "field.y" } ],
  "outputs": { "x": "field.x.q" },
  "scenes": { "main": { "stop": 5, "samples": 3 } } })json";
}

}  // namespace

TEST_CASE("the energy balance closes for a right model, and ever better with the tolerance") {
  double before = 1.0;
  for (const double relative : {1e-4, 1e-6, 1e-8, 1e-10}) {
    const EnergyAudit audit = run_text(kRlc, with_relative(relative)).report.energy;
    REQUIRE(audit.done);
    CHECK(audit.supplied - audit.stored - audit.dissipated == Approx(audit.residual).margin(1e-15));
    CHECK(audit.exchanged == 0.0);
    CHECK(audit.relative < 100 * relative);
    CHECK(audit.relative < before);
    before = audit.relative;
  }
}

TEST_CASE("the residual tells the true error of a lossless oscillator's energy") {
  const std::string text = R"json({ "bgsim": 1, "name": "lossless",
    "elements": {
      "loop": { "kind": "1" }, "l": { "kind": "I", "inertance": 1 },
      "c": { "kind": "C", "capacitance": 0.25, "initial": { "q": 0.25 } }
    },
    "bonds": [ { "from": "loop", "to": "l" }, { "from": "loop", "to": "c" } ],
    "outputs": { "E": "c.q^2/0.5 + l.p^2/2" },
    "scenes": { "main": { "stop": 300, "samples": 3 } } })json";
  const RunResult result = run_text(text, with_relative(1e-5));
  const std::vector<double> energy = column(result, "E");
  const double drift = energy.back() - energy.front();
  CHECK(std::abs(drift) > 1e-4 * energy.front());  // a hundred periods leave their mark
  CHECK(result.report.energy.residual == Approx(-drift).epsilon(1e-9));
  // relative to the energy that swings between the stores, 0.125
  CHECK(result.report.energy.relative == Approx(std::abs(drift) / 0.125).epsilon(0.3));
}

TEST_CASE("known terms of the balance come out") {
  // 1 V on R = 2 and C = 0.5: after long, C E^2/2 is stored, as much is lost, C E^2 supplied
  const std::string text = R"json({ "bgsim": 1, "name": "rc",
    "elements": { "source": { "kind": "Se", "effort": 1 }, "loop": { "kind": "1" },
      "r": { "kind": "R", "resistance": 2 }, "c": { "kind": "C", "capacitance": 0.5 } },
    "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "c" } ],
    "outputs": { "v": "c.e" }, "scenes": { "main": { "stop": 50, "samples": 3 } } })json";
  const EnergyAudit audit = run_text(text, with_relative(1e-9)).report.energy;
  CHECK(audit.supplied == Approx(0.5).epsilon(1e-7));
  CHECK(audit.stored == Approx(0.25).epsilon(1e-7));
  CHECK(audit.dissipated == Approx(0.25).epsilon(1e-7));
  CHECK(audit.least_dissipation >= 0.0);
}

TEST_CASE("an active resistor is named") {
  const std::string text = R"json({ "bgsim": 1, "name": "active",
    "elements": { "node": { "kind": "0" }, "gives": { "kind": "R", "resistance": -4 },
      "takes": { "kind": "R", "resistance": 2 }, "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } } },
    "bonds": [ { "from": "node", "to": "gives" }, { "from": "node", "to": "takes" }, { "from": "node", "to": "c" } ],
    "outputs": { "v": "c.e" }, "scenes": { "main": { "stop": 1, "samples": 3 } } })json";
  const RunResult result = run_text(text);
  CHECK(result.report.energy.least_dissipation == Approx(-0.25).epsilon(1e-3));
  CHECK(result.report.energy.least_dissipation_element == "gives");
  CHECK(report_text(result).find("active element: \"gives\"") != std::string::npos);
}

TEST_CASE("a field whose laws are reciprocal balances, one whose laws are not does not") {
  const EnergyAudit by_energy = run_text(field(R"("energy": "x.q^2 + x.q*y.q + y.q^4")")).report.energy;
  REQUIRE(by_energy.done);
  CHECK(by_energy.relative < 1e-4);
  const EnergyAudit by_laws = run_text(field(R"("laws": ["x.e = 2*x.q + y.q", "y.e = x.q + 4*y.q^3"])")).report.energy;
  REQUIRE(by_laws.done);
  CHECK(by_laws.relative < 1e-4);
  CHECK(by_laws.stored == Approx(by_energy.stored).epsilon(1e-6));
  const EnergyAudit violated =
      run_text(field(R"("laws": ["x.e = 2*x.q + 3*y.q", "y.e = x.q + 4*y.q^3"])")).report.energy;
  REQUIRE(violated.done);
  CHECK(violated.relative > 0.01);  // of all that the sources moved to and fro
}

TEST_CASE("jumps and conditions do not spoil the balance") {
  const std::string text = R"json({ "bgsim": 1, "name": "bumper",
    "elements": {
      "push": { "kind": "Se", "effort": "if(t < 1, 3, -1)" }, "v": { "kind": "1" },
      "m": { "kind": "I", "inertance": 1 },
      "stop": { "kind": "C", "law": "e = if(q > 0.5, 1e4*(q - 0.5), 0)" },
      "friction": { "kind": "R", "law": "e = 0.1*f + 0.2*f*abs(f)" }
    },
    "bonds": [ { "from": "push", "to": "v" }, { "from": "v", "to": "m" }, { "from": "v", "to": "stop" },
      { "from": "v", "to": "friction" } ],
    "outputs": { "x": "stop.q" }, "scenes": { "main": { "stop": 3, "samples": 3 } } })json";
  const RunResult result = run_text(text, with_relative(1e-8));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.state_events >= 2);
  REQUIRE(result.report.energy.done);
  CHECK(result.report.energy.relative < 1e-6);
}

TEST_CASE("the shortest scene that there is comes to its end") {
  std::string text = kRlc;
  const std::string scene = "\"stop\": 20, \"samples\": 11";
  REQUIRE(text.find(scene) != std::string::npos);
  text.replace(text.find(scene), scene.size(), "\"stop\": 5e-324, \"interval\": 1");
  for (const Method method : {Method::bdf, Method::adams, Method::dirk4}) {
    const RunResult result = run_text(text, with_method(method));
    CHECK(result.stop == StopReason::completed);
    CHECK(result.report.energy.done);
  }
}

TEST_CASE("the audit can be switched off") {
  SimulateOptions options;
  options.energy_audit = false;
  const RunResult result = run_text(kRlc, {}, options);
  CHECK(!result.report.energy.done);
  CHECK(result.report.energy.why_not == "switched off");
}

TEST_CASE("the course of the balance holds what the stores hold, at output times, and costs nothing unless asked for") {
  std::string text = kRlc;
  text.replace(text.find("\"p\": \"l.p\""), 10, "\"E\": \"c.q^2/0.5 + l.p^2/2\"");
  SimulateOptions options;
  options.energy_course = 1000;
  for (const Method method : {Method::bdf, Method::ida, Method::erk5}) {
    const RunResult result = run_text(text, with_method(method, 1e-8), options);
    const EnergyAudit& audit = result.report.energy;
    const EnergyCourse& course = audit.course;
    REQUIRE(course.times == result.trace.times);
    const std::vector<double> energy = column(result, "E");
    const double turned_over = std::abs(audit.residual) / audit.relative;
    for (std::size_t i = 0; i < energy.size(); ++i) {
      // The same expression of the same interpolated states: rounding alone.
      CHECK(course.stored[i] == Approx(energy[i] - energy[0]).margin(1e-12));
      CHECK(course.supplied[i] - course.stored[i] - course.dissipated[i] == Approx(course.residual[i]).margin(1e-12));
      CHECK(std::abs(course.residual[i]) < 100 * 1e-8 * turned_over);  // a hundred times the tolerance, as above
    }
    CHECK(course.dissipated.back() == Approx(audit.dissipated).margin(1e-12));
  }
  CHECK(run_text(text).report.energy.course.times.empty());
}

TEST_CASE("the course of a model without stores is exact, and its points are spread over the output times") {
  const std::string text = R"json({ "bgsim": 1, "name": "ohm",
    "elements": { "u": { "kind": "Se", "effort": "3*t" }, "r": { "kind": "R", "resistance": 2 } },
    "bonds": [ { "from": "u", "to": "r" } ],
    "outputs": { "i": "r.f" }, "scenes": { "main": { "stop": 1, "samples": 101 } } })json";
  SimulateOptions options;
  options.energy_course = 10;
  const EnergyCourse course = run_text(text, {}, options).report.energy.course;
  REQUIRE(course.times.size() == 11);  // the start, every eleventh, the end
  CHECK(course.times.back() == 1.0);
  for (std::size_t i = 0; i < course.times.size(); ++i) {
    const double t = course.times[i];
    CHECK(course.supplied[i] == Approx(1.5 * t * t * t).margin(1e-14));  // the integral of (3t)^2/2; rounding alone
    CHECK(course.dissipated[i] == Approx(course.supplied[i]).margin(1e-14));
  }
}

TEST_CASE("energies beyond the range of double precision are no audit, and no share of it") {
  // Two stores that discharge into two others.
  const auto discharge = [](const std::string& charge) {
    const std::string store = R"json({ "kind": "C", "capacitance": 1, "initial": { "q": )json" + charge + " } }";
    const std::string r = R"json({ "kind": "R", "resistance": 1 })json",
                      empty = R"json({ "kind": "C", "capacitance": 1 })json";
    return Study::from_text(
        R"json({ "bgsim": 1, "name": "discharge", "elements": { "m": { "kind": "1" }, "n": { "kind": "1" }, "a": )json" +
        store + ", \"r\": " + r + ", \"b\": " + empty + ", \"c\": " + store + ", \"s\": " + r + ", \"d\": " + empty +
        R"json( },
      "bonds": [ { "from": "a", "to": "m" }, { "from": "m", "to": "r" }, { "from": "m", "to": "b" },
        { "from": "c", "to": "n" }, { "from": "n", "to": "s" }, { "from": "n", "to": "d" } ],
      "outputs": { "u": "a.e", "v": "c.e" }, "scenes": { "main": { "stop": 9, "samples": 3 } } })json");
  };
  // Each loses 3/4 of 1.62e308: what both lose is not finite.
  for (const char* charge : {"1.8e154", "1e200"}) {
    const Study beyond = discharge(charge);
    const RunResult result = run(beyond);
    CHECK_FALSE(result.report.energy.done);
    CHECK_FALSE(result.report.energy.why_not.empty());
    CHECK(last(result, "u") > 0.4e154);
    ReduceOptions options;
    options.error = 0.3;
    CHECK_NOTHROW(reduce(beyond, options));
  }
  // All activities fit, and their sum does not.
  const Simulation scene = discharge("1.2e154").scene();
  const RunResult large = scene.simulate();
  REQUIRE(large.report.energy.done);
  double shares = 0.0;
  for (const ElementActivity& row : activities(scene.program(), large)) shares += row.share;
  CHECK(shares == Approx(1.0).epsilon(1e-12));  // roundings
}

TEST_CASE("what a store with a law that jumps holds is the sum of what it takes up between the jumps") {
  // Nothing is dissipated: what is stored stays 0, to the run's own error, and no note doubts the run.
  for (const std::string law :
       {"step(q)", "sign(q)", "if(q > 0.2, 1, -1)", "mod(q, 0.5)", "sign(q)*exp(-abs(q))",
        "q + if(abs(q) > 0.4, 3*sign(q), 0)", "floor(4*q)", "round(3*q) + q^3", "if(q > 0 and q < 0.3, 2, 1) - 0.5"}) {
    INFO(law);
    const RunResult run = run_text(R"json({"bgsim": 1, "name": "jump", "elements": {"j": {"kind": "1"},
      "m": {"kind": "I", "inertance": 1, "initial": {"p": -1}},
      "c": {"kind": "C", "law": "e = )json" +
                                       law + R"json(", "initial": {"q": 0.7}}},
      "bonds": [{"from": "j", "to": "m"}, {"from": "j", "to": "c"}],
      "outputs": {"q": "c.q"}, "scenes": {"main": {"stop": 1.7, "samples": 18}}})json",
                                   with_relative(1e-9));
    REQUIRE(run.stop == StopReason::completed);
    CHECK(std::abs(run.report.energy.stored) < 1e-7);  // of 0.5: a hundred tolerances
    for (const std::string& note : run.report.notes) CHECK(note.find("energy") == std::string::npos);
  }
}
