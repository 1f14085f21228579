// Graphs that determine too much or too little, loops with no, one or several solutions, starts that contradict.
#include <catch2/catch.hpp>
#include <cmath>

#include "extremes.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const char* const kOne = R"("stop": 1, "samples": 11)";

/// Se - 1 - R with a law, R of 0.1.
Ran series(const std::string& effort, const std::string& law) {
  return ran(model_of(R"("source": { "kind": "Se", "effort": ")" + effort + R"(" }, "loop": { "kind": "1" },
      "r": { "kind": "R", "law": ")" +
                          law + R"(" }, "r2": { "kind": "R", "resistance": 0.1 })",
                      "source>loop loop>r loop>r2", R"("f": "r.f")", kOne));
}

const std::vector<Extreme> kEntries{
    {"R with `e = f^3 - f` and 0.1 ohm on 0.1 V: three solutions",
     "the chosen one, its initial guess and the others are reported",
     [] {
       const Ran run = series("0.1", "e = f^3 - f");
       REQUIRE(run.completed());
       const std::string note = run.note("other solutions exist");
       REQUIRE(!note.empty());
       return "note: " + note;
     }},
    {"R with `e = f^2` and 0.1 ohm on -1 V: no solution", "a message with the elements of the loop",
     [] {
       return diagnosis(series("-1", "e = f^2"), "BG602", {"r, r2", "t = 0"});
     }},
    {"R with `e = f^2` on `1 - 2*t`: the solution folds away at t = 0.50125", "a message with the time",
     [] {
       const Ran run = ran(model_of(R"("source": { "kind": "Se", "effort": "1 - 2*t" }, "loop": { "kind": "1" },
           "r": { "kind": "R", "law": "e = f^2" }, "r2": { "kind": "R", "resistance": 0.1 })",
                                    "source>loop loop>r loop>r2", R"("f": "r.f")", R"("stop": 1, "samples": 1001)"));
       CHECK(run.result->trace.times.back() == Approx(0.501).epsilon(1e-9));
       return diagnosis(run, "BG602", {"r, r2"}).substr(0, 80) + " ...";
     }},
    {"a fold while a store follows: `e = f^3 - f`, 0.1 ohm and C", "the same",
     [] {
       const Ran run = ran(model_of(R"("source": { "kind": "Se", "effort": "1 - 2*t" }, "loop": { "kind": "1" },
           "r": { "kind": "R", "law": "e = f^3 - f" }, "r2": { "kind": "R", "resistance": 0.1 },
           "c": { "kind": "C", "capacitance": 1 })",
                                    "source>loop loop>r loop>r2 loop>c", R"("f": "r.f")", kOne));
       // dt = -(3 f^2 - 0.9)/(2 + f) df from f^3 - 0.9 f = 1 to the fold at f^2 = 0.3. There a charge that is off by
       // the tolerance of 1e-6 moves the end by as much over 2 + f. Which of two protections sees it first, rounding
       // decides: no solution, or that another one meets it.
       const auto integral = [](double f) { return 1.5 * f * f - 6.0 * f + 11.1 * std::log(f + 2.0); };
       const double fold = integral(1.2934855559551852) - integral(std::sqrt(0.3));
       CHECK(run.result->report.reached == Approx(fold).epsilon(0.0).margin(1e-6));
       const std::string said = diagnosis(run, "BG602", {"r, r2", "r.e = -0.383406"});
       return said.substr(0, said.find(':')) + " at " + said.substr(said.find("t = "), 9);
     }},
    {"1 ohm and -1 ohm in series: any flow is a solution", "refused before the run, with the elements",
     [] {
       return diagnosis(ran(model_of(R"("source": { "kind": "Se", "effort": 0 }, "loop": { "kind": "1" },
           "r": { "kind": "R", "resistance": 1 }, "r2": { "kind": "R", "resistance": -1 })",
                                     "source>loop loop>r loop>r2", R"("f": "r.f")", kOne)),
                        "BG411", {"\"r\"", "\"r2\""});
     }},
    {"two Se on one 0-junction", "refused with junction and sources",
     [] {
       return diagnosis(ran(model_of(R"("a": { "kind": "Se", "effort": 1 }, "b": { "kind": "Se", "effort": 2 },
           "node": { "kind": "0" }, "r": { "kind": "R", "resistance": 1 })",
                                     "a>node b>node node>r", "", kOne)),
                        "BG301", {"\"node\"", "\"a\"", "\"b\""});
     }},
    {"two Sf on one 1-junction", "the same",
     [] {
       return diagnosis(ran(model_of(R"("a": { "kind": "Sf", "flow": 1 }, "b": { "kind": "Sf", "flow": 2 },
           "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 })",
                                     "a>loop b>loop loop>r", "", kOne)),
                        "BG302", {"\"loop\"", "\"a\"", "\"b\""});
     }},
    {"a ring of TF with moduli 1 and 2 through a charged C",
     "the ring leaves no effort but 0: the charge contradicts it",
     [] {
       return diagnosis(ran(model_of(R"("left": { "kind": "0" }, "right": { "kind": "0" },
           "one": { "kind": "TF", "modulus": 1 }, "two": { "kind": "TF", "modulus": 2 },
           "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "r": { "kind": "R", "resistance": 1 })",
                                     "left>c left>one one>right left>two two>right right>r", "", kOne)),
                        "BG405", {"c.q = 1"});
     }},
    {"a ring of two GY of modulus 1: unit gain", "the ring leaves no effort but 0: the source contradicts it",
     [] {
       return diagnosis(ran(model_of(R"("source": { "kind": "Se", "effort": 1 }, "left": { "kind": "1" },
           "right": { "kind": "1" }, "one": { "kind": "GY", "modulus": 1 }, "two": { "kind": "GY", "modulus": 1 })",
                                     "source>left left>one one>right right>two two>left", R"("f": "left.f")", kOne)),
                        "BG411", {"\"one\"", "\"two\""});
     }},
    {"two bonds side by side between the same 0-junctions, C at one, R at the other",
     "as one bond: the charge decays; how the flow divides nobody asks",
     [] {
       const Ran run = ran(model_of(R"("left": { "kind": "0" }, "right": { "kind": "0" },
           "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "r": { "kind": "R", "resistance": 1 })",
                                    "c>left left>right left>right right>r", R"("q": "c.q")", kOne));
       REQUIRE(run.completed());
       return within(std::abs(run.last("q") - std::exp(-1.0)), 1e-5);
     }},
    {"a ring 1, 0, 0 that lets no flow through, beside it `sin(t)` into an I",
     "the I has the source's flow: its effort is cos(t)",
     [] {
       const Ran run = ran(model_of(R"x("source": { "kind": "Sf", "flow": "sin(t)" }, "a": { "kind": "1" },
           "b": { "kind": "0" }, "c": { "kind": "0" }, "r": { "kind": "R", "resistance": 2 },
           "i": { "kind": "I", "inertance": 1 })x",
                                    "a>b b>c c>a a>r source>b b>i", R"("e": "i.e")", kOne));
       REQUIRE(run.completed());
       return within(std::abs(run.last("e") - std::cos(1.0)), 1e-12);
     }},
    {"a flow source of `sin(t)` into a 0-junction of I only (1 and 2)",
     "one of the two depends on the other and the source: f1 = 2/3 sin(t)",
     [] {
       const Ran run = ran(model_of(R"x("source": { "kind": "Sf", "flow": "sin(t)" }, "node": { "kind": "0" },
           "one": { "kind": "I", "inertance": 1 }, "two": { "kind": "I", "inertance": 2 })x",
                                    "source>node node>one node>two", R"("f": "one.f")", kOne));
       REQUIRE(run.completed());
       return within(std::abs(run.last("f") - 2.0 / 3.0 * std::sin(1.0)), 1e-5);
     }},
    {"C straight across a source of `sin(t)`: index 2 as a DAE of nodes",
     "the index is reduced by differentiating the dependent store: i = cos(t)",
     [] {
       const Ran run = ran(model_of(R"x("source": { "kind": "Se", "effort": "sin(t)" }, "node": { "kind": "0" },
           "c": { "kind": "C", "capacitance": 1 }, "r": { "kind": "R", "resistance": 1 })x",
                                    "source>node node>c node>r", R"("i": "c.f")", kOne));
       REQUIRE(run.completed());
       return within(std::abs(run.last("i") - std::cos(1.0)), 1e-12);
     }},
    {"a bob on a rigid rod, moved along x and y (`models/pendulum.json`): index 3 in Cartesian coordinates",
     "one momentum stays, the others follow through the moduli and their rates",
     [] {
       const CompiledModel compiled = compile_file("models/pendulum.json");
       const Ran run = ran(compiled);
       REQUIRE(run.completed());
       CHECK(run.result->report.states == 2);
       // back at its start after a whole period
       return within(std::abs(std::abs(run.last("theta")) - std::asin(1.0)), 1e-6);
     }},
    {"transistor amplifier (`models/amplifier.json`), a DAE of index 1 in its nodes",
     "charges as states, the loops' variables as unknowns beside them: published values at t = 0.2",
     [] {
       const Ran run = ran(compile_file("models/amplifier.json"));
       REQUIRE(run.completed());
       CHECK(run.result->report.steps < 10000);
       return "U8: " + within(std::abs(run.last("U8") - 1.236995868091548), 1e-6);
     }},
    {"two C in parallel with different charges per farad",
     "the contradiction is reported, with both; nothing is changed silently",
     [] {
       return diagnosis(ran(model_of(R"("a": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } },
           "b": { "kind": "C", "capacitance": 1, "initial": { "q": 0 } }, "r": { "kind": "R", "resistance": 1 },
           "node": { "kind": "0" })",
                                     "node>a node>b node>r", R"("q": "a.q")", kOne)),
                        "BG405", {"b.q = 0", "a.q"});
     }},
    {"the bellow with C2(x) put into its two laws (`tests/data/models/bellow_naive.json`)",
     "such laws are not reciprocal: Maxwell's relation fails, energy is created",
     [] {
       const Study study = study_of("tests/data/models/bellow_naive.json");
       std::string said;
       for (const auto* warnings : {&study.causality().warnings, &study.equations().warnings})
         for (const Diagnostic& warning : *warnings)
           if (warning.code == "BG306") said = warning.situation;
       CHECK(said.find("not reciprocal") != std::string::npos);
       return "warning [BG306](errors.md#bg306): " + said;
     }},
};

const Section kSection("Loops and starts", kEntries);

}  // namespace
