// Laws where they end: roots at zero, poles, growth without bound.
#include <catch2/catch.hpp>
#include <iomanip>
#include <sstream>

#include "extremes.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const char* const kTank = R"("stop": 100, "samples": 11)";

/// Two tanks of 1 m^3/Pa joined by an orifice f = ssqrt(e, delta), levels 1 and 0: the difference d obeys
/// d' = -2 sqrt(d), so d = (1 - t)^2 until both are level at t = 1.
std::string orifice(const std::string& delta, double limit) {
  const Ran run = ran(model_of(
      R"("a": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "left": { "kind": "0" },
      "pipe": { "kind": "1" }, "hole": { "kind": "R", "law": "f = ssqrt(e, )" +
          delta + R"( ) " }, "right": { "kind": "0" }, "b": { "kind": "C", "capacitance": 1 })",
      "left>a left>pipe pipe>hole pipe>right right>b", R"("d": "a.q - b.q")", R"("stop": 10, "samples": 101)"));
  REQUIRE(run.completed());
  const std::vector<double> d = column(*run.result, "d");
  double error = 0.0;
  for (std::size_t i = 0; i < d.size(); ++i) {
    const double rest = std::max(0.0, 1.0 - run.result->trace.times[i]);
    error = std::max(error, std::abs(d[i] - rest * rest));
  }
  return within(error, limit);
}

/// A mass against a gas e = 1 - 1/q.
std::string gas(const std::string& position, const std::string& momentum) {
  return model_of(R"("mass": { "kind": "I", "inertance": 1, "initial": { "p": )" + momentum +
                      R"( } }, "wall": { "kind": "1" },
      "gas": { "kind": "C", "law": "e = 1 - 1/q", "initial": { "q": )" +
                      position + R"( } }, "r": { "kind": "R", "resistance": 0.1 })",
                  "wall>mass wall>gas wall>r", R"("x": "gas.q")", R"("stop": 10, "samples": 11)");
}

/// Two coils of 1 H with coupling @p k, by laws that divide by 1 - k^2.
Ran coupled(const std::string& k) {
  return ran(model_of(R"("field": { "kind": "II", "ports": ["a", "b"], "laws": ["a.f = (a.p - )" + k + "*b.p)/(1 - " +
                          k + R"(^2) ", "b.f = (b.p - )" + k + "*a.p)/(1 - " + k +
                          R"(^2) "] }, "source": { "kind": "Se", "effort": "sin(t) " },
           "left": { "kind": "1" }, "right": { "kind": "1" }, "ra": { "kind": "R", "resistance": 1 },
           "rb": { "kind": "R", "resistance": 1 })",
                      "source>left left>field.a right>field.b left>ra right>rb", R"("p": "field.a.p")",
                      R"("stop": 3, "samples": 11)"));
}

const std::vector<Extreme> kEntries{
    {"orifice `ssqrt(e, d)` between two tanks, d = 1e-3: through no pressure drop at t = 1",
     "level difference (1 - t)^2, then 0, except for the linear law below d", [] { return orifice("1e-3", 1e-3); }},
    {"the same, d = 1e-6", "the same", [] { return orifice("1e-6", 1e-5); }},
    {"the same, d = 1e-9", "the same", [] { return orifice("1e-9", 1e-5); }},
    {"the same, d = 1e-12", "the same", [] { return orifice("1e-12", 1e-5); }},
    {"the same, d = 0: infinite slope at rest", "the same", [] { return orifice("0", 1e-5); }},
    {"tank with outflow `sqrt(q)/10` past the moment at which it is empty, t = 20",
     "the domain of the root ends: a message with the law and the argument; plain CVODE fails with its own message "
     "(\"corrector "
     "convergence\")",
     [] {
       return diagnosis(ran(filling("-sqrt(store.q)/10", "1", kTank)), "BG601", {"sqrt(store.q)", "\"source\""})
                  .substr(0, 40) +
              " ...";
     }},
    {"the same, regularised: `ssqrt(q, 1e-6)/10`", "empty from t = 20 on",
     [] {
       const Ran run = ran(filling("-ssqrt(store.q, 1e-6)/10", "1", kTank));
       REQUIRE(run.completed());
       return within(std::abs(run.last("q")), 1e-6);
     }},
    {"the same, protected by a condition: `if(q > 0, sqrt(q), 0)/10`", "empty from t = 20 on",
     [] {
       const Ran run = ran(filling("-if(store.q > 0, sqrt(store.q), 0)/10", "1", kTank));
       REQUIRE(run.completed());
       return within(std::abs(run.last("q")), 1e-6);
     }},
    {"the same with `sign(q)*sqrt(abs(q))`", "empty from t = 20 on",
     [] {
       const Ran run = ran(filling("-sign(store.q)*sqrt(abs(store.q))/10", "1", kTank));
       REQUIRE(run.completed());
       return within(std::abs(run.last("q")), 1e-6);
     }},
    {"a law without a value from t = 0.5 on", "stop there; plain CVODE tries two million steps",
     [] {
       const Ran run = ran(filling("if(t < 0.5, 1, sqrt(-1 - store.q))", "0", R"("stop": 1, "samples": 11)"));
       CHECK(run.result->report.steps < 100);
       return diagnosis(run, "BG601", {"sqrt", "\"source\"", "t = 0.5"});
     }},
    {"a law without a value at t = 0", "the same message, not a solver's code",
     [] {
       return diagnosis(ran(filling("log(-1 - store.q)", "0", R"("stop": 1, "samples": 11)")), "BG601",
                        {"log", "\"source\"", "t = 0"});
     }},
    {"gas of no volume at the start: `1 - 1/q` with q = 0", "a message at the start",
     [] {
       return diagnosis(ran(gas("0", "0")), "BG601", {"1/gas.q", "\"gas\"", "t = 0"});
     }},
    {"gas pushed through no volume by a mass of 1000 N s",
     "the law ends at q = 0; plain CVODE reports success with a negative volume",
     [] {
       return diagnosis(ran(gas("1", "-1000")), "BG613", {"gas.q", "\"gas\""});
     }},
    {"gas that starts from a negative volume: q = -0.01",
     "the law has a value there, but no gas has this volume: a note; plain CVODE reports success with a negative "
     "volume",
     [] {
       const Ran run = ran(gas("-0.01", "0"));
       const std::string note = run.note("negative");
       CHECK(note.find("gas.q") != std::string::npos);
       return "note: " + note;
     }},
    {"gas that starts from a volume of 1e-2 against 1 bar outside",
     "it oscillates above zero: the energy balance closes",
     [] {
       const Ran run = ran(gas("0.01", "0"));
       REQUIRE(run.completed());
       const std::vector<double> x = column(*run.result, "x");
       CHECK(*std::min_element(x.begin(), x.end()) > 0.0);
       return "completed; energy balance: " + within(run.result->report.energy.relative, 1e-3);
     }},
    {"electrostatic gap above pull-in: force `V^2/(2*(1 - x)^2)`",
     "the plates touch: the law is singular at x = 1; plain CVODE steps over the singularity and beyond 1e11",
     [] {
       return diagnosis(ran(model_of(R"("mass": { "kind": "I", "inertance": 1 }, "plate": { "kind": "1" },
           "spring": { "kind": "C", "capacitance": 1 }, "r": { "kind": "R", "resistance": 0.5 },
           "field": { "kind": "MSe", "effort": "0.36/(2*(1 - spring.q)^2) " })",
                                     "field>plate plate>mass plate>spring plate>r", R"("x": "spring.q")",
                                     R"("stop": 20, "samples": 21)")),
                        "BG613", {"1 - spring.q", "\"field\""});
     }},
    {"q' = q^2 to t = 2", "blow-up at t = 1",
     [] {
       return diagnosis(ran(filling("store.q^2", "1", R"("stop": 2, "samples": 11)")), "BG605",
                        {"\"store.q\" grows without bound near t = 1"});
     }},
    {"`sin(x)/x` with x through zero", "no singularity: the quotient stays finite, q continues",
     [] {
       const Ran run = ran(filling("sin(store.q)/store.q", "-1", R"("stop": 3.7, "samples": 8)"));
       REQUIRE(run.completed());
       CHECK(run.last("q") > 1.0);
       return std::string("completed");
     }},
    {"a field whose laws divide by 1e-15 of their terms: two coils of coupling 1 - 1e-15",
     "such laws lose 15 digits: a note that the energy balance does not close",
     [] {
       const Ran run = coupled("(1 - 1e-15)");
       REQUIRE(run.completed());
       CHECK(!run.note("the energy balance is off").empty());
       return std::string("note: the energy balance is off by some per cent");
     }},
    {"two coils of coupling 1 - 1e-12", "the same laws with three digits left",
     [] {
       const Ran run = coupled("(1 - 1e-12)");
       REQUIRE(run.completed());
       return "completed; energy balance: " + within(run.result->report.energy.relative, 1e-4);
     }},
    {"meaning of expressions: `-2^2`, `2^3^2`, `(-2)^3`, `sign(0)`, `min(1, sqrt(4))`",
     "-4, 512, -8, 0, 1: a power binds tighter than a sign and goes from right to left (ngspice takes v^3 as |v|^3)",
     [] {
       const Ran run =
           ran(model_of(R"("source": { "kind": "Se", "effort": 1 }, "r": { "kind": "R", "resistance": 1 })", "source>r",
                        R"x("a": "-2^2", "b": "2^3^2", "c": "(-2)^3", "d": "sign(0)", "e": "min(1, sqrt(4))")x",
                        R"("stop": 1, "samples": 2)"));
       REQUIRE(run.completed());
       std::vector<double> first;
       for (const std::vector<double>& column : run.result->trace.columns) first.push_back(column.front());
       CHECK(first == std::vector<double>{-4.0, 512.0, -8.0, 0.0, 1.0});
       return std::string("exact");
     }},
    {"kinks of a law: a store filled through an ideal diode, `max(0, sin(t))`, ten periods", "q = 20",
     [] {
       const Ran run = ran(filling("max(0, sin(t))", "0", R"("stop": 62.83185307179586, "samples": 11)"));
       REQUIRE(run.completed());
       return within(std::abs(run.last("q") - 20.0) / 20.0, 1e-5) + " (relative)";
     }},
    {"an exponential law in equilibrium: diode `f = 1e-12*(exp(40*e) - 1)` and 1 V over 1 ohm, from rest at the "
     "solution",
     "nothing moves, and Newton's iteration converges by exact derivatives",
     [] {
       // u + 1e-12 (exp(40 u) - 1) = 1 by bisection: the start is the solution to the last digit
       double low = 0.0, high = 1.0;
       while (true) {
         const double u = 0.5 * (low + high);
         if (u == low || u == high) break;
         (u + 1e-12 * std::expm1(40.0 * u) < 1.0 ? low : high) = u;
       }
       std::ostringstream start;
       start << std::setprecision(17) << low;
       const Ran run = ran(model_of(
           R"x("source": { "kind": "Se", "effort": 1 }, "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
           "node": { "kind": "0" }, "d": { "kind": "R", "law": "f = 1e-12*(exp(40*e) - 1)" },
           "c": { "kind": "C", "capacitance": 1e-9, "initial": { "q": ")x" +
               start.str() + R"x(*1e-9" } })x",
           "source>loop loop>r loop>node node>d node>c", R"("u": "c.e")", R"("stop": 1, "samples": 11)"));
       REQUIRE(run.completed());
       CHECK(run.result->report.convergence_failures == 0);
       CHECK(run.result->report.steps < 200);
       return "no failure to converge; " + within(std::abs(run.last("u") - low), 1e-9);
     }},
    {"measured data with two rows at one time", "refused, with the row",
     [] {
       diagnosis(ran(charging("table('" BGSIM_SOURCE_DIR "/tests/extremes/data/repeated.csv', 'u', t)", "1", "1",
                              R"("stop": 2, "samples": 11)")),
                 "BG127", {"row 3", "does not lie after the row before it"});
       return std::string("[BG127](errors.md#bg127): row 3 does not lie after the row before it");
     }},
    {"a spline through two rows 1e-9 apart with 1 V between them",
     "the spline would swing to 1e9 V: refused, with the rows",
     [] {
       diagnosis(ran(charging("table('" BGSIM_SOURCE_DIR "/tests/extremes/data/near.csv', 'u', t, spline)", "1", "1",
                              R"("stop": 2, "samples": 11)")),
                 "BG127", {"rows 2 and 3", "million times nearer"});
       return std::string(
           "[BG127](errors.md#bg127): rows 2 and 3 lie a million times nearer to each other than their neighbours");
     }},
    {"linear interpolation through the same rows", "a jump at t = 1: u(2) = 1 - exp(-1)",
     [] {
       const Ran run = ran(charging("table('" BGSIM_SOURCE_DIR "/tests/extremes/data/near.csv', 'u', t)", "1", "1",
                                    R"("stop": 2, "samples": 11)"));
       REQUIRE(run.completed());
       return within(std::abs(run.last("u") - (1.0 - std::exp(-1.0))), 1e-5);
     }},
};

const Section kSection("Laws at the limits of their domain", kEntries);

}  // namespace
