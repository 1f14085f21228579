// Rounding is no finding: neither an active element, nor another solution of a loop, nor a curve that moves. What is
// small and real stays one.
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "command.hpp"

using Catch::Contains;

namespace {

/// An RR that turns 250 W round without loss, whose two products differ by rounding, and a resistor beside it.
std::string turner(const std::string& resistance) {
  return R"json({ "bgsim": 1, "name": "turner",
    "elements": { "a": { "kind": "Se", "effort": "10*sin(3*t) + 0.1" }, "b": { "kind": "Se", "effort": "25*cos(2*t)" },
      "turn": { "kind": "RR", "ports": ["x", "y"], "laws": ["x.f = y.e/3", "y.f = -x.e/3"] },
      "feed": { "kind": "Sf", "flow": "1e-5*sin(t)" }, "small": { "kind": "R", "resistance": )json" +
         resistance + R"json( } },
    "bonds": [ { "from": "a", "to": "turn.x" }, { "from": "b", "to": "turn.y" }, { "from": "feed", "to": "small" } ],
    "outputs": { "f": "turn.x.f" }, "scenes": { "s": { "stop": 5, "samples": 101 } } })json";
}

const std::string kModels = BGSIM_SOURCE_DIR "/tests/data/models/";

/// A pair of columns that cancel, a sum of them that is rounding, a real signal of some nanometres, a constant.
std::string trace_of(double small) {
  std::ostringstream rows;
  rows.precision(17);
  rows << "t,left,right,sum,small,constant\r\n";
  for (int i = 0; i <= 100; ++i) {
    const double t = 0.1 * i, left = 0.3 * std::sin(t);
    rows << t << ',' << left << ',' << -left << ',' << (i % 3 - 1) * 5.5e-17 << ',' << small * std::cos(t) << ','
         << 5.0 + (i % 2) * 8.8817841970012523e-16 << "\r\n";
  }
  return rows.str();
}

/// Whether there is a number at an axis; gnuplot writes it with a blank before.
bool has_tick(const std::string& svg, const std::string& text) {
  return svg.find(" " + text + "<") != std::string::npos;
}

}  // namespace

TEST_CASE("what rounding leaves of a lossless field is no active element") {
  const Workplace here;
  here.write("turner.json", turner("1"));
  const Outcome outcome = here.bgsim("turner.json -o -");
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.err, Contains("dissipated") && !Contains("active element"));
}

TEST_CASE("an active element of 1e-10 W beside 250 W is named") {
  const Workplace here;
  here.write("turner.json", turner("-4"));
  const Outcome outcome = here.bgsim("turner.json -o -");
  CHECK_THAT(outcome.err, Contains("active element: \"small\" gave off up to 4e-10") ||
                              Contains("active element: \"small\" gave off up to 3.9"));
}

TEST_CASE("solutions of a loop that differ by rounding are one, and one of 1e-10 beside 0 is another") {
  const Workplace here;
  for (const std::string model : {"diode_resistor", "diode_bridge"}) {
    INFO(model);
    const Outcome outcome = here.bgsim("'" + kModels + model + ".json' -o -");
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.err, Contains("the loop through") && !Contains("other solutions exist"));
  }
  here.write("folds.json", R"({ "bgsim": 1, "name": "folds",
    "elements": { "s": { "kind": "Se", "effort": 0 }, "j": { "kind": "1" },
      "r": { "kind": "R", "law": "e = 1e18*f^3 - f" }, "r2": { "kind": "R", "resistance": 0.1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "r2" } ],
    "outputs": { "f": "j.f" }, "scenes": { "x": { "stop": 1, "samples": 3 } } })");
  // 1e18 f^3 = 0.9 f: 0, and f of 9.5e-10 either way.
  CHECK_THAT(here.bgsim("folds.json -o -").err, Contains("other solutions exist: "));
}

TEST_CASE("plot draws a column that is only rounding at the scale of its unit, and a small real one at its own") {
  const Workplace here;
  here.write("run.csv", trace_of(1e-9));
  here.write("run.units.json", R"({ "left": "m", "right": "m", "sum": "m", "small": "m", "constant": "V" })");
  REQUIRE(here.bgsim("plot run.csv sum -o sum.svg").code == 0);
  const std::string sum = here.read("sum.svg");
  CHECK_THAT(sum, Contains("sum (only rounding)") && Contains("t in s"));
  CHECK(has_tick(sum, "0.2"));
  CHECK_THAT(sum, !Contains("e-17"));
  REQUIRE(here.bgsim("plot run.csv small -o small.svg").code == 0);
  CHECK_THAT(here.read("small.svg"), Contains("1x10") || Contains("1e-09"));
  CHECK_THAT(here.read("small.svg"), !Contains("only rounding"));
  REQUIRE(here.bgsim("plot run.csv constant -o constant.svg").code == 0);
  CHECK(has_tick(here.read("constant.svg"), "5.2"));
  // With no units known, nothing is known of what the sum is of.
  here.write("bare.csv", trace_of(1e-9));
  REQUIRE(here.bgsim("plot bare.csv sum -o bare.svg").code == 0);
  CHECK_THAT(here.read("bare.svg"), !Contains("only rounding"));
}

TEST_CASE("plot draws a reference dashed over the columns that it has") {
  const Workplace here;
  here.write("run.csv", trace_of(1e-9));
  here.write("reference.csv", "t,left\r\n0,0\r\n5,0.1\r\n10,0\r\n");
  REQUIRE(here.bgsim("plot run.csv left constant --each -o with.svg --reference reference.csv").code == 0);
  const std::string with = here.read("with.svg");
  CHECK_THAT(with, Contains("stroke-dasharray") && Contains(">reference<"));
  CHECK(with.find(">reference<") == with.rfind(">reference<"));  // over one of the two
  const Outcome nothing = here.bgsim("plot run.csv constant --reference reference.csv");
  CHECK(nothing.code == 2);
  CHECK_THAT(nothing.err, Contains("reference.csv has none of the columns that are drawn"));
}
