// Units, and coefficients that are zero, negative, infinite, or become so.
#include <catch2/catch.hpp>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "extremes.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const char* const kOne = R"("stop": 1, "samples": 11)";

/// A column as a part of @p unit.
std::vector<double> scaled(const Ran& run, const std::string& name, double unit) {
  REQUIRE(run.completed());
  std::vector<double> values = column(*run.result, name);
  for (double& value : values) value /= unit;
  return values;
}

/// A run with a store of less than 0, whose q comes to @p charge.
std::string unstable(const Ran& run, double charge) {
  REQUIRE(run.completed());
  REQUIRE(run.warnings.size() == 1);
  CHECK(run.warnings.front().code == "BG180");
  // Errors of 1e-6 a step, some dozens of them, grow by no more than the solution does: e within the scene.
  return "warning BG180; " + within(std::abs(run.last("q") - charge), 1e-4);
}

/// One period of an oscillator in units in which inertance, capacitance and charge are these, against that with 1,
/// 1, 1.
std::string same_in_units(const std::string& inertance, const std::string& capacitance, const std::string& charge,
                          const std::string& stop, double current) {
  const std::string samples = ", \"samples\": 21";
  const Ran ordinary = ran(oscillator("1", "1", "1", "\"stop\": 6.283185307179586" + samples));
  const Ran other = ran(oscillator(inertance, capacitance, charge, "\"stop\": " + stop + samples));
  const double gap = std::max(largest_difference(scaled(other, "q", std::stod(charge)), scaled(ordinary, "q", 1.0)),
                              largest_difference(scaled(other, "i", current), scaled(ordinary, "i", 1.0)));
  CHECK(other.result->report.energy.done);
  CHECK(other.result->report.energy.relative == Approx(ordinary.result->report.energy.relative).epsilon(1e-3));
  return "the same trace: " + within(gap, 1e-10) + "; the energy balance too";
}

/// The bellow's step in millimetres, grams and @p milliseconds (or seconds) against that in metres, kilograms, seconds,
/// extension and pressure. The last bits differ, and with them, after some thousand steps, the steps themselves: what
/// is left is the solver's own error, hence the tolerance.
std::string bellow_in_units(bool milliseconds) {
  const double length = 1e3, mass = 1e3, time = milliseconds ? 1e3 : 1.0;
  const double pressure = mass / (length * time * time), volume = length * length * length;
  const std::vector<std::pair<const char*, double>> factors{{"packet.A", length * length},
                                                            {"packet.k", mass / (time * time)},
                                                            {"m", mass},
                                                            {"packet.R_b", mass / time},
                                                            {"packet.X", length},
                                                            {"packet.omega", 1.0 / time},
                                                            {"packet.kp", 1.0 / length},
                                                            {"packet.kd", time / length},
                                                            {"packet.P_supply", pressure},
                                                            {"packet.delta", pressure},
                                                            {"packet.K_orifice", volume / time / std::sqrt(pressure)},
                                                            {"packet.C2", volume / pressure}};
  const CompiledModel ordinary = compile_file("models/bellow.json", with_relative(1e-13), "step");
  std::vector<std::string> set;
  for (const auto& [name, factor] : factors) {
    const auto at = std::find_if(ordinary.model().parameters.begin(), ordinary.model().parameters.end(),
                                 [&, n = name](const auto& parameter) { return parameter.name == n; });
    REQUIRE(at != ordinary.model().parameters.end());
    const auto i = static_cast<std::size_t>(at - ordinary.model().parameters.begin());
    std::ostringstream text;
    text << name << '=' << std::setprecision(17) << ordinary.inputs.parameters[i] * factor;
    set.push_back(text.str());
  }
  SceneOverrides overrides = with_relative(1e-13);
  overrides.set = set;
  CompiledModel other = compile_file("models/bellow.json", overrides, "step");
  other.inputs.stop *= time;
  std::vector<double> times = other.inputs.output_times.list();
  for (double& t : times) t *= time;
  other.inputs.output_times = std::move(times);
  const Ran a = ran(ordinary), b = ran(other);
  double gap = 0.0;
  for (const auto& [name, unit] : {std::pair("x", length), std::pair("P2", pressure)}) {
    const std::vector<double> exact = scaled(a, name, 1.0);
    const double largest = std::abs(*std::max_element(
        exact.begin(), exact.end(), [](double left, double right) { return std::abs(left) < std::abs(right); }));
    gap = std::max(gap, largest_difference(scaled(b, name, unit), exact) / largest);
  }
  return "the same trace: " + within(gap, 1e-10);
}

const char* const kSameTrace = "the same physics in other units is the same trace, to 1e-10";

std::string two_time_constants(const std::string& resistance) {
  const Ran run = ran(model_of(R"("source": { "kind": "Se", "effort": 1 }, "loop": { "kind": "1" },
      "r": { "kind": "R", "resistance": )" +
                                   resistance + R"( }, "node": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1 },
      "branch": { "kind": "1" }, "r2": { "kind": "R", "resistance": 1 }, "c2": { "kind": "C", "capacitance": 1 })",
                               "source>loop loop>r loop>node node>c node>branch branch>r2 branch>c2",
                               R"("a": "c.q", "b": "c2.q")", kOne));
  REQUIRE(run.completed());
  // exact: x' = A x + b with A = [-1/R-1 1; 1 -1]
  const double r = std::stod(resistance), trace = -1.0 / r - 2.0;
  const double root = std::sqrt(trace * trace / 4.0 - 1.0 / r), fast = trace / 2.0 - root, slow = 1.0 / r / fast;
  // x = 1 + alpha (slow mode) + beta (fast mode), modes (v, 1) with v = 1 + eigenvalue
  const double alpha = -fast / (fast - slow), beta = slow / (fast - slow);
  const double b = 1.0 + alpha * std::exp(slow) + beta * std::exp(fast);
  return within(std::abs(run.last("b") - b), 2e-5);
}

std::string transformer(const std::string& kind, const std::string& modulus) {
  return model_of(R"("source": { "kind": "Se", "effort": 1 }, "first": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1 }, "x": { "kind": ")" +
                      kind + R"(", "modulus": ")" + modulus + R"(" }, "second": { "kind": "1" },
      "i": { "kind": "I", "inertance": 1 }, "r2": { "kind": "R", "resistance": 1 })",
                  "source>first first>r first>x x>second second>i second>r2", R"("f": "i.f")",
                  R"("stop": 2, "samples": 12)");
}

const std::vector<Extreme> kEntries{
    {"L = C = 1e-150, q0 = 1e-160, over one period of 6e-150 s",
     std::string(kSameTrace) +
         "; plain CVODE with a tolerance of 1e-9 reports success and is wrong by 86 %, with a fitting one "
         "it cannot start",
     [] { return same_in_units("1e-150", "1e-150", "1e-160", "6.283185307179586e-150", 1e-10); }},
    {"L = C = q0 = 1e150", kSameTrace,
     [] { return same_in_units("1e150", "1e150", "1e150", "6.283185307179586e150", 1.0); }},
    {"L = 1e200, C = 1e-200, q0 = 1: momenta near 1e200",
     std::string(kSameTrace) + "; the energy p^2/(2 L) must not overflow in its square",
     [] { return same_in_units("1e200", "1e-200", "1", "6.283185307179586", 1.0); }},
    {"the bellow (`models/bellow.json`, scene `step`, tolerance 1e-13) in mm and g", kSameTrace,
     [] { return bellow_in_units(false); }},
    {"the same in mm, g and ms", kSameTrace, [] { return bellow_in_units(true); }},
    {"the oscillator with `\"absolute\": 1e-9`, far above all values", "a note that nothing was controlled",
     [] {
       const Ran run = ran(oscillator("1e-150", "1e-150", "1e-160",
                                      R"("stop": 6.283185307179586e-150, "samples": 3, "absolute": 1e-9)"));
       REQUIRE(run.completed());
       const std::string note = run.note("never above the absolute tolerance");
       CHECK(note.find("\"l.p\", \"c.q\"") != std::string::npos);
       return "note: " + note;
     }},
    {"`\"absolute\": 0`", "plain CVODE: CV_ILL_INPUT; here a message that points to the key",
     [] {
       return diagnosis(ran(oscillator("1", "1", "0", R"("stop": 1, "absolute": 0)")), "BG146", {"\"absolute\""});
     }},
    {"time constants 1 and 1e-3 (R between source and C)", "the exact solution of two exponentials",
     [] { return two_time_constants("1e-3"); }},
    {"the same with 1e-9", "the same", [] { return two_time_constants("1e-9"); }},
    {"the same with 1e-15", "the same", [] { return two_time_constants("1e-15"); }},
    {"C of 1e-30 F behind 1 ohm, 1 s", "u(1) = 1: the store is in equilibrium at once",
     [] {
       const Ran run = ran(charging("1", "1", "1e-30", kOne));
       REQUIRE(run.completed());
       CHECK(std::abs(run.last("u") - 1.0) <= 1e-6);
       return std::string("error below 1e-06");
     }},
    {"C of 1e-100 F behind 1 ohm", "the same, or a message to remove the store",
     [] {
       return diagnosis(ran(charging("1", "1", "1e-100", kOne)), "BG614", {"\"c.q\"", "1e-100"});
     }},
    {"R of 1e-300 ohm", "the same",
     [] { return diagnosis(ran(charging("1", "1e-300", "1", kOne)), "BG614", {"\"c.q\""}); }},
    {"GY of modulus 1e150", "the same",
     [] { return diagnosis(ran(transformer("GY", "1e150")), "BG614", {"\"i.p\""}); }},
    {"R = 1e300 ohm", "q(1) = 1e-300",
     [] {
       const Ran run = ran(charging("1", "1e300", "1", kOne));
       REQUIRE(run.completed());
       return within(std::abs(run.last("q") / 1e-300 - 1.0), 1e-6) + " (relative)";
     }},
    {"R = -1 ohm on a charged C, 1000 s", "q = exp(t): a warning, and overflow at t = 709.78",
     [] {
       const Ran run = ran(charging("0", "-1", "1", R"("stop": 1000, "samples": 11)", "1"));
       REQUIRE(!run.warnings.empty());
       CHECK(run.warnings.front().code == "BG148");
       CHECK(run.result->report.reached == Approx(709.78).epsilon(1e-3));
       return "warning BG148, then " + diagnosis(run, "BG605", {"\"c.q\" outgrows"});
     }},
    {"C = -1 behind 1 ohm", "q = exp(t) - 1: a warning, and the motion that grows",
     [] { return unstable(ran(charging("1", "1", "-1", kOne)), std::exp(1.0) - 1.0); }},
    {"I = -1 beside C = 1", "q = cosh(t): the same",
     [] { return unstable(ran(oscillator("-1", "1", "1", kOne)), std::cosh(1.0)); }},
    {"C = 0", "refused before the run, with the element's name",
     [] { return diagnosis(ran(charging("1", "1", "0", kOne)), "BG145", {"\"c\""}); }},
    {"I = 0", "the same", [] { return diagnosis(ran(oscillator("0", "1", "1", kOne)), "BG145", {"\"l\""}); }},
    {"C = 1e308*10, infinite", "the same",
     [] {
       return diagnosis(ran(charging("1", "1", "1e308*10", kOne)), "BG142", {"\"c\"", "1e+308*10"});
     }},
    {"R = 1/0", "the same",
     [] {
       return diagnosis(ran(charging("1", "1/0", "1", kOne)), "BG142", {"\"r\"", "1/0"});
     }},
    {"TF of modulus 1/0", "the same", [] { return diagnosis(ran(transformer("TF", "1/0")), "BG142", {"\"x\""}); }},
    {"TF with modulus 0 as denominator", "refused where it is first used, with the element's name",
     [] {
       return diagnosis(ran(transformer("TF", "0")), "BG601", {"\"x\"", "i.p/0"});
     }},
    {"GY of modulus 0", "nothing passes: the load stays at rest",
     [] {
       const Ran run = ran(transformer("GY", "0"));
       REQUIRE(run.completed());
       return within(std::abs(run.last("f")), 0.0);
     }},
    {"R = 0 between a source and a C with q0 = 0", "C follows the source, and the start contradicts it: both are named",
     [] {
       return diagnosis(ran(charging("1", "0", "1", kOne, "0")), "BG405", {"c.q = 0", "which 1 follows"});
     }},
    {"capacitance `1 - t` over 2 s", "the law has a singularity at t = 1; beyond it the system is another one",
     [] {
       const Ran run = ran(charging("1", "1", "1 - t", R"("stop": 2, "samples": 12)"));
       return diagnosis(run, run.said ? run.said->code : "", {"1 - t", "\"c\"", "t = 1"});
     }},
    {"resistance `1 - t` of a leak (it gives the flow)",
     "the same; without a check of denominators, the run completes with the energy of an active element",
     [] {
       const Ran run = ran(model_of(R"("source": { "kind": "Sf", "flow": 1 }, "node": { "kind": "0" },
           "r": { "kind": "R", "resistance": "1 - t" }, "c": { "kind": "C", "capacitance": 1 })",
                                    "source>node node>r node>c", R"("u": "c.e")", R"("stop": 2, "samples": 12)"));
       return diagnosis(run, "BG613", {"1 - t", "\"r\""});
     }},
    {"MTF of modulus `1 - t`", "the same",
     [] {
       return diagnosis(ran(transformer("MTF", "1 - t")), "BG613", {"1 - t", "\"x\""});
     }},
    {"MGY of modulus `1 - t`, used as factor only", "the run completes: the energy balance closes",
     [] {
       const Ran run = ran(transformer("MGY", "1 - t"));
       REQUIRE(run.completed());
       return "completed; energy balance: " + within(run.result->report.energy.relative, 1e-5);
     }},
};

const Section kSection("Values and units", kEntries);

}  // namespace
