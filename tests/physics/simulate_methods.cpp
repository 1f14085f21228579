// The same model by different methods, in other units, at the ends of the range of numbers.
#include <catch2/catch.hpp>

#include "support/approx.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// Lossless: L, C, q0 and T may be set.
const char* const kOscillator = R"json({ "bgsim": 1, "name": "oscillator",
  "parameters": { "L": 1, "C": 0.25, "q0": 0.25, "T": 10 },
  "elements": {
    "loop": { "kind": "1" }, "l": { "kind": "I", "inertance": "L" },
    "c": { "kind": "C", "capacitance": "C", "initial": { "q": "q0" } }
  },
  "bonds": [ { "from": "loop", "to": "l" }, { "from": "loop", "to": "c" } ],
  "outputs": { "q": "c.q", "p": "l.p" },
  "scenes": { "main": { "stop": "T", "samples": 11 } } })json";

/// A driven chain of n masses with cubic springs and dampers.
std::string chain(std::size_t n) {
  std::string elements = R"json("wall": { "kind": "Sf", "flow": "0.1*sin(3*t)" })json", bonds;
  std::string before = "wall";
  for (std::size_t k = 0; k < n; ++k) {
    const std::string i = std::to_string(k);
    elements += ", \"n" + i + R"(": { "kind": "0" }, "s)" + i + R"(": { "kind": "C", "law": "e = 10*q + 4*q^3" }, "d)" +
                i + R"(": { "kind": "R", "resistance": 0.5 }, "j)" + i + R"(": { "kind": "1" }, "v)" + i +
                R"(": { "kind": "1" }, "m)" + i + R"(": { "kind": "I", "inertance": 1 })";
    bonds += std::string(k == 0 ? "" : ", ") + R"({ "from": ")" + before + R"(", "to": "n)" + i +
             R"(" }, { "from": "n)" + i + R"(", "to": "j)" + i + R"(" }, { "from": "j)" + i + R"(", "to": "s)" + i +
             R"(" }, { "from": "j)" + i + R"(", "to": "d)" + i + R"(" }, { "from": "n)" + i + R"(", "to": "v)" + i +
             R"(" }, { "from": "v)" + i + R"(", "to": "m)" + i + "\" }";
    before = "v" + i;
  }
  return R"({ "bgsim": 1, "name": "chain", "elements": {)" + elements + "}, \"bonds\": [" + bonds +
         R"(], "outputs": { "p": "m0.p", "q": "s)" + std::to_string(n - 1) +
         R"(.q" }, "scenes": { "main": { "stop": 5, "samples": 51 } } })";
}

}  // namespace

TEST_CASE("CVODE's two methods and IDA agree") {
  const std::string text = chain(3);
  const RunResult bdf = run_text(text, with_method(Method::bdf, 1e-9));
  const RunResult adams = run_text(text, with_method(Method::adams, 1e-9));
  const RunResult ida = run_text(text, with_method(Method::ida, 1e-9));
  CHECK(bdf.report.method == "CVODE BDF, dense");
  CHECK(adams.report.method == "CVODE Adams, dense");
  CHECK(ida.report.method == "IDA, dense");
  // each is within a few hundred tolerances of the truth
  CHECK(largest_difference(bdf, adams) < 3e-7);
  CHECK(largest_difference(bdf, ida) < 3e-7);
}

TEST_CASE("IDA's loop variables are recorded at the output times, not where it last evaluated") {
  // A nonlinear loop beside a store, at times between IDA's steps.
  const char* const text = R"json({ "bgsim": 1, "name": "loop beside a store",
    "elements": {
      "source": { "kind": "Se", "effort": 1 }, "series": { "kind": "1" }, "node": { "kind": "0" }, "branch": { "kind": "1" },
      "r1": { "kind": "R", "law": "e = f + f^3" }, "r2": { "kind": "R", "law": "f = e + 0.1*e^3" },
      "r3": { "kind": "R", "law": "e = f + 0.5*f^3" }, "c": { "kind": "C", "capacitance": 1 }
    },
    "bonds": [ { "from": "source", "to": "series" }, { "from": "series", "to": "r1" }, { "from": "series", "to": "node" },
               { "from": "node", "to": "r2" }, { "from": "node", "to": "branch" }, { "from": "branch", "to": "r3" },
               { "from": "branch", "to": "c" } ],
    "outputs": { "q": "c.q", "e": "node.e", "f": "r1.f" },
    "scenes": { "main": { "stop": 5, "samples": 41 } } })json";
  const RunResult ida = run_text(text, with_method(Method::ida, 1e-6));
  REQUIRE(ida.report.steps > 100);
  double worst = 0.0;
  for (std::size_t i = 0; i < ida.trace.times.size(); ++i) {
    const double q = ida.trace["q"][i], e = ida.trace["e"][i], f = ida.trace["f"][i];
    const double through_c = f - (e + 0.1 * e * e * e);
    worst = std::max({worst, std::abs(f + f * f * f + e - 1.0),
                      std::abs(q + through_c + 0.5 * through_c * through_c * through_c - e)});
  }
  // The laws hold at every row to IDA's tolerance for its loop variables, relative 1e-6, times their slopes (below 10).
  CHECK(worst < 1e-5);
  const RunResult bdf = run_text(text, with_method(Method::bdf, 1e-9));
  CHECK(std::abs(last(ida, "e") - last(bdf, "e")) < 1e-5);
}

TEST_CASE("sparse and dense factorization give the same solution") {
  const std::string text = chain(30);  // 60 states: sparse
  const RunResult sparse = run_text(text, with_method(Method::bdf, 1e-8));
  const RunResult ida = run_text(text, with_method(Method::ida, 1e-8));
  CHECK(sparse.report.method == "CVODE BDF, KLU");
  CHECK(ida.report.method == "IDA, KLU");
  CHECK(largest_difference(sparse, ida) < 3e-6);
  // the first mass of a short chain does not yet feel the end of a long one: compare with a dense run at an early time
  CompiledModel dense = compile_text(chain(20), with_relative(1e-8)),
                longer = compile_text(chain(30), with_relative(1e-8));
  for (CompiledModel* model : {&dense, &longer}) {
    model->inputs.stop = 1.0;
    model->inputs.output_times = {0.0, 0.5, 1.0};
  }
  dense.inputs.method = Method::bdf;
  const RunResult d = dense.run(), s = longer.run();
  CHECK(d.report.method == "CVODE BDF, dense");
  CHECK(std::abs(last(d, "p") - last(s, "p")) < 1e-6 * std::abs(last(s, "p")));
}

TEST_CASE("the same physics in other units gives the same trace") {
  const RunResult si = run_text(kOscillator);
  // charge in units 1/1000, time in units 1/7: q' = 1000 q, L' = L * 49 / 1, C' = C (per unit of charge and effort)
  const RunResult other = run_text(kOscillator, with_parameters({"L=49", "q0=250", "T=70"}));
  REQUIRE(si.trace.times.size() == other.trace.times.size());
  const std::vector<double> q = column(si, "q"), q_other = column(other, "q");
  for (std::size_t i = 0; i < q.size(); ++i) CHECK(std::abs(q_other[i] / 1000 - q[i]) < 1e-10 * 0.25);
}

TEST_CASE("magnitudes at the ends of the range of numbers do no harm") {
  const double w = 2.0, t = 10.0;  // of the ordinary oscillator
  const double cosine = std::cos(w * t);
  SECTION("L = C = 1e-150, q0 = 1e-160") {
    const RunResult result = run_text(kOscillator, with_parameters({"L=1e-150", "C=1e-150", "q0=1e-160", "T=20e-150"}));
    REQUIRE(result.stop == StopReason::completed);
    CHECK(last(result, "q") / 1e-160 == Approx(cosine).margin(3e-3));
  }
  SECTION("L = 1e200, C = 1e-200") {
    const RunResult result = run_text(kOscillator, with_parameters({"L=1e200", "C=1e-200", "q0=1e-160", "T=20"}));
    REQUIRE(result.stop == StopReason::completed);
    CHECK(last(result, "q") / 1e-160 == Approx(cosine).margin(3e-3));
  }
  SECTION("times from femtoseconds to decades") {
    for (const double time : {1e-15, 1.0, 1e9}) {
      CompiledModel model = compile_text(kOscillator);
      model.inputs.parameters[0] = model.inputs.parameters[1] = time / 20.0;
      model.inputs.stop = time;
      model.inputs.output_times = {0.0, time};
      const RunResult result = model.run();
      REQUIRE(result.stop == StopReason::completed);
      CHECK(last(result, "q") / 0.25 == Approx(cosine).margin(3e-3));
    }
  }
  SECTION("nothing at all") {
    const RunResult result = run_text(kOscillator, with_parameters({"q0=0"}));
    REQUIRE(result.stop == StopReason::completed);
    CHECK(last(result, "q") == 0.0);
    CHECK(result.report.steps < 50);
  }
}

TEST_CASE("relative tolerances from 1e-2 to 1e-12 are kept") {
  double before = 1.0;
  for (const double relative : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    const RunResult result = run_text(chain(2), with_relative(relative));
    REQUIRE(result.stop == StopReason::completed);
    static const RunResult exact = run_text(chain(2), with_method(Method::adams, 1e-13));
    const double error = largest_difference(exact, result);
    CHECK(error < 1000 * relative);  // rounding has its share at 1e-12
    CHECK(error < before);
    before = error;
  }
}

TEST_CASE("a state that is zero by cancellation does not force small steps") {
  // two equal springs pull one mass to both sides: its momentum is the difference of equal forces
  const std::string text = R"json({ "bgsim": 1, "name": "cancelled",
    "elements": {
      "left": { "kind": "MSe", "effort": "sin(7*t)/3" }, "right": { "kind": "MSe", "effort": "-sin(7*t)*(1/3)" },
      "v": { "kind": "1" }, "m": { "kind": "I", "inertance": 0.1 }, "k": { "kind": "C", "capacitance": 0.7 },
      "other": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 }, "c": { "kind": "C", "capacitance": 1 },
      "drive": { "kind": "Se", "effort": "sin(7*t)" }
    },
    "bonds": [ { "from": "left", "to": "v" }, { "from": "right", "to": "v" }, { "from": "v", "to": "m" },
      { "from": "v", "to": "k" }, { "from": "drive", "to": "other" }, { "from": "other", "to": "r" },
      { "from": "other", "to": "c" } ],
    "outputs": { "p": "m.p", "q": "c.q" },
    "scenes": { "main": { "stop": 10, "samples": 11 } } })json";
  const RunResult result = run_text(text);
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.steps < 2500);  // about 1000 for the driven RC alone
  CHECK(std::abs(last(result, "p")) < 1e-10);
}

TEST_CASE("absolute tolerances are used as given, and reported when nothing rises above them") {
  SceneOverrides overrides;
  overrides.absolute = 10.0;
  const RunResult result = run_text(kOscillator, overrides);
  REQUIRE(result.report.absolute.size() == 2);
  CHECK(result.report.absolute[0].second == 10.0);
  REQUIRE(result.report.notes.size() == 3);
  CHECK(result.report.notes[0].find("\"c.q\"") != std::string::npos);
  CHECK(result.report.notes[1].find("the energy balance is off") != std::string::npos);
  CHECK(result.report.notes[2].find("estimated to be wrong") != std::string::npos);
  CHECK(run_text(kOscillator).report.notes.empty());
}

TEST_CASE("a model without states is evaluated on its grid") {
  const std::string text = R"json({ "bgsim": 1, "name": "divider",
    "elements": {
      "source": { "kind": "Se", "effort": "if(t < 0.5, 4, 8)" }, "loop": { "kind": "1" },
      "a": { "kind": "R", "resistance": 1 }, "b": { "kind": "R", "resistance": 3 }
    },
    "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "a" }, { "from": "loop", "to": "b" } ],
    "outputs": { "u": "b.e", "i": "a.f" },
    "scenes": { "main": { "stop": 1, "samples": 3 } } })json";
  const RunResult result = run_text(text);
  REQUIRE(result.stop == StopReason::completed);
  CHECK(result.report.method == "none (no states)");
  const std::vector<double> u = column(result, "u");
  CHECK(u[0] == same_to_rounding(3.0));
  CHECK(u[1] == same_to_rounding(6.0));
  CHECK(u[2] == same_to_rounding(6.0));
  REQUIRE(result.report.energy.done);
  CHECK(result.report.energy.supplied == same_to_rounding(4.0 * 0.5 + 16.0 * 0.5, 64));
  CHECK(result.report.energy.relative < 1e-12);
}

TEST_CASE("the same run twice gives the same bytes") {
  const CompiledModel model = compile_text(chain(5));
  CHECK(model.run().trace.columns == model.run().trace.columns);
}

TEST_CASE("rounding passed around a stiff loop does not loosen the tolerances") {
  // The shipped bellow: around its controller and orifice, what an unknown leaves open comes back to it many times
  // larger.
  CompiledModel model = compile_file("models/bellow.json", with_relative(1e-6), "tracking");
  RunInputs& inputs = model.inputs;
  inputs.stop = 3.0;
  inputs.output_times = {0.0, 1.0, 2.0, 3.0};
  const RunResult result = model.run();
  REQUIRE(result.stop == StopReason::completed);
  for (const auto& [state, absolute] : result.report.absolute) CHECK(absolute < 1e-6);  // no state is larger than 1
  // the controller follows within a few mm
  const std::vector<double> x = column(result, "x");
  for (std::size_t i = 0; i < x.size(); ++i) CHECK(x[i] == Approx(0.3 * std::sin(result.trace.times[i])).margin(5e-3));
}
