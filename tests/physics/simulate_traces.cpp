// Runs held against reference traces (tests/data/traces): closed forms in 40 digits, and published problems solved in
// 113 bits. What is measured is the largest error over the whole trace, relative to the column's largest magnitude.
//
// Backward differentiation promises local errors: over a whole trace they add up to 5..100 times the relative tolerance
// where the solution forgets them, and to more where it oscillates undamped.
#include <catch2/catch.hpp>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

std::string rlc(const std::string& resistance) {
  return R"({
  "bgsim": 1, "name": "rlc",
  "elements": {
    "source": { "kind": "Se", "effort": 10 },
    "loop": { "kind": "1" },
    "r": { "kind": "R", "resistance": )" +
         resistance + R"( },
    "l": { "kind": "I", "inertance": 1e-3 },
    "c": { "kind": "C", "capacitance": 1e-5 }
  },
  "bonds": [
    { "from": "source", "to": "loop" }, { "from": "loop", "to": "r" },
    { "from": "loop", "to": "l" }, { "from": "loop", "to": "c" }
  ],
  "outputs": { "q": "c.q", "vC": "c.e", "lambda": "l.p", "i": "l.f" },
  "scenes": { "on": { "stop": 2e-3, "samples": 201 } }
})";
}

/// A ladder of n sections of R and C behind a source of 1 V.
std::string ladder(std::size_t n, const std::string& outputs) {
  std::string elements = R"("source": { "kind": "Se", "effort": 1 })", bonds;
  for (std::size_t k = 1; k <= n; ++k) {
    const std::string i = std::to_string(k);
    elements += ", \"s" + i + R"(": { "kind": "1" }, "r)" + i + R"(": { "kind": "R", "resistance": 100 }, "n)" + i +
                R"(": { "kind": "0" }, "c)" + i + R"(": { "kind": "C", "capacitance": 1e-7 })";
    bonds += std::string(k == 1 ? "" : ", ") + R"({ "from": ")" +
             (k == 1 ? std::string("source") : "n" + std::to_string(k - 1)) + R"(", "to": "s)" + i +
             R"(" }, { "from": "s)" + i + R"(", "to": "r)" + i + R"(" }, { "from": "s)" + i + R"(", "to": "n)" + i +
             R"(" }, { "from": "n)" + i + R"(", "to": "c)" + i + "\" }";
  }
  return R"({ "bgsim": 1, "name": "ladder", "elements": {)" + elements + "}, \"bonds\": [" + bonds +
         "], \"outputs\": {" + outputs + R"(}, "scenes": { "on": { "stop": 1e-3, "samples": 2 } } })";
}

const char* const kTwoTanks = R"json({
  "bgsim": 1, "name": "two tanks",
  "parameters": { "rho": 1000, "g": 9.81 },
  "elements": {
    "left": { "kind": "C", "capacitance": "0.05/(rho*g)", "initial": { "q": 0.05 } },
    "right": { "kind": "C", "capacitance": "0.02/(rho*g)", "initial": { "q": 0.004 } },
    "pl": { "kind": "0" }, "pr": { "kind": "0" }, "flow": { "kind": "1" },
    "orifice": { "kind": "R", "law": "f = 0.62*1e-4*sign(e)*sqrt(2*abs(e)/rho)" }
  },
  "bonds": [
    { "from": "pl", "to": "left" }, { "from": "pl", "to": "flow" }, { "from": "flow", "to": "orifice" },
    { "from": "flow", "to": "pr" }, { "from": "pr", "to": "right" }
  ],
  "outputs": { "h1": "left.q/0.05", "h2": "right.q/0.02", "Q": "orifice.f" },
  "scenes": { "equalise": { "stop": 100, "samples": 2 } }
})json";

const char* const kTorricelli = R"json({
  "bgsim": 1, "name": "torricelli",
  "elements": {
    "tank": { "kind": "C", "capacitance": "0.05/(1000*9.81)", "initial": { "q": 0.05 } },
    "bottom": { "kind": "0" },
    "orifice": { "kind": "R", "law": "f = if(e > 0, 0.62*1e-4*sqrt(2*e/1000), 0)" }
  },
  "bonds": [ { "from": "bottom", "to": "tank" }, { "from": "bottom", "to": "orifice" } ],
  "outputs": { "h": "tank.q/0.05", "p": "tank.e", "Q": "orifice.f", "V": "tank.q" },
  "scenes": { "drain": { "stop": 500, "samples": 2 } }
})json";

const char* const kGasSpring = R"json({
  "bgsim": 1, "name": "gas spring",
  "parameters": { "A": 1e-3, "pa": 1e5, "x0": 0.1 },
  "elements": {
    "piston": { "kind": "I", "inertance": 0.5 },
    "v": { "kind": "1" },
    "gas": { "kind": "C", "law": "e = -pa*A*(x0/q)^1.4", "initial": { "q": 0.02 } },
    "air": { "kind": "Se", "effort": "-pa*A" }
  },
  "bonds": [ { "from": "air", "to": "v" }, { "from": "v", "to": "piston" }, { "from": "v", "to": "gas" } ],
  "outputs": { "x": "gas.q", "v": "piston.f" },
  "scenes": { "bounce": { "stop": 1, "samples": 2 } }
})json";

const char* const kStiff = R"json({
  "bgsim": 1, "name": "two time scales",
  "elements": {
    "source": { "kind": "Se", "effort": 1 }, "s1": { "kind": "1" }, "r1": { "kind": "R", "resistance": 1 },
    "n1": { "kind": "0" }, "c1": { "kind": "C", "capacitance": 1e-6 },
    "s2": { "kind": "1" }, "r2": { "kind": "R", "resistance": 1e6 }, "c2": { "kind": "C", "capacitance": 1 }
  },
  "bonds": [
    { "from": "source", "to": "s1" }, { "from": "s1", "to": "r1" }, { "from": "s1", "to": "n1" },
    { "from": "n1", "to": "c1" }, { "from": "n1", "to": "s2" }, { "from": "s2", "to": "r2" }, { "from": "s2", "to": "c2" }
  ],
  "outputs": { "v1": "c1.e", "v2": "c2.e" },
  "scenes": { "on": { "stop": 1e7, "samples": 2 } }
})json";

const char* const kRobertson = R"json({
  "bgsim": 1, "name": "robertson",
  "elements": {
    "a": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } },
    "b": { "kind": "C", "capacitance": 1 },
    "c": { "kind": "C", "capacitance": 1 },
    "na": { "kind": "0" }, "nb": { "kind": "0" }, "nc": { "kind": "0" },
    "ra": { "kind": "MSf", "flow": "-0.04*a.q + 1e4*b.q*c.q" },
    "rb": { "kind": "MSf", "flow": "0.04*a.q - 1e4*b.q*c.q - 3e7*b.q^2" },
    "rc": { "kind": "MSf", "flow": "3e7*b.q^2" }
  },
  "bonds": [
    { "from": "ra", "to": "na" }, { "from": "na", "to": "a" }, { "from": "rb", "to": "nb" }, { "from": "nb", "to": "b" },
    { "from": "rc", "to": "nc" }, { "from": "nc", "to": "c" }
  ],
  "outputs": { "y1": "a.q", "y2": "b.q", "y3": "c.q" },
  "scenes": { "long": { "stop": 1e11, "samples": 2 } }
})json";

const char* const kVanDerPol = R"json({
  "bgsim": 1, "name": "van der pol",
  "elements": {
    "v": { "kind": "1" },
    "m": { "kind": "I", "inertance": 1e-6 },
    "spring": { "kind": "C", "capacitance": 1, "initial": { "q": 2 } },
    "damper": { "kind": "MR", "resistance": "spring.q^2 - 1" }
  },
  "bonds": [ { "from": "v", "to": "m" }, { "from": "v", "to": "spring" }, { "from": "v", "to": "damper" } ],
  "outputs": { "y1": "spring.q", "y2": "m.f" },
  "scenes": { "relaxation": { "stop": 2, "samples": 2 } }
})json";

}  // namespace

TEST_CASE("series RLC circuits follow their closed forms at every output time") {
  const std::vector<std::string> names{"q", "vC", "lambda", "i"};
  CHECK(largest_error(compile_text(rlc("10")), reference_trace("ana_rlc_under"), names) < 1e-4);
  CHECK(largest_error(compile_text(rlc("20")), reference_trace("ana_rlc_critical"), names) < 1e-4);
  CHECK(largest_error(compile_text(rlc("200")), reference_trace("ana_rlc_over"), names) < 1e-4);
}

TEST_CASE("the error falls with the relative tolerance") {
  const CsvTable exact = reference_trace("ana_rlc_under");
  double before = 1.0;
  for (const double relative : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}) {
    const double error = largest_error(compile_text(rlc("10"), with_relative(relative)), exact, {"q", "lambda"});
    CHECK(error < before / 10);     // two decades of tolerance bring at least one of error
    CHECK(error < 300 * relative);  // eight oscillations: see the note at the top
    before = error;
  }
}

TEST_CASE("RC ladders of 10 and 100 sections follow their eigenvalue solution") {
  CHECK(largest_error(compile_text(ladder(10, R"("v1": "c1.e", "v5": "c5.e", "v10": "c10.e")")),
                      reference_trace("ana_rc_ladder_10"), {"v1", "v5", "v10"}) < 3e-5);
  // beyond 50 states the Jacobian is sparse
  CHECK(largest_error(compile_text(ladder(100, R"("v1": "c1.e", "v50": "c50.e", "v100": "c100.e")")),
                      reference_trace("ana_rc_ladder_100"), {"v1", "v50", "v100"}) < 3e-5);
}

TEST_CASE("two tanks level out through an orifice in finite time and rest") {
  // The root's slope is infinite where the levels meet; the last stretch is below the states' tolerance, but the flow
  // is the root of what remains of it.
  CHECK(largest_error(compile_text(kTwoTanks, with_relative(1e-8)), reference_trace("ana_two_tanks_orifice"),
                      {"h1", "h2"}) < 1e-5);
}

TEST_CASE("a tank runs empty and stays empty") {
  CHECK(largest_error(compile_text(kTorricelli), reference_trace("ana_torricelli"), {"h", "p", "V"}) < 2e-5);
}

TEST_CASE("an adiabatic gas spring bounces between its exact turning points") {
  CHECK(largest_error(compile_text(kGasSpring, with_relative(1e-9)), reference_trace("ana_gas_spring_adiabatic"),
                      {"x", "v"}) < 1e-5);
}

TEST_CASE("time constants twelve decades apart are both resolved") {
  CHECK(largest_error(compile_text(kStiff), reference_trace("ana_stiff_1e12"), {"v1", "v2"}) < 2e-5);
}

TEST_CASE("Robertson's reaction is followed to 1e11 without absolute tolerances") {
  CHECK(largest_error(compile_text(kRobertson), reference_trace("pub_robertson"), {"y1", "y2", "y3"}) < 5e-5);
}

TEST_CASE("the stiff van der Pol oscillator follows its published solution") {
  // The jumps are 1e-6 wide and the reference's grid does not see into them; the error is theirs in time.
  CHECK(largest_error(compile_text(kVanDerPol, with_relative(1e-8)), reference_trace("pub_van_der_pol_stiff"), {"y1"}) <
        1e-4);
}
