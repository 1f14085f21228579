#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using bgsim::test::compile_text;
using bgsim::test::CompiledModel;
using bgsim::test::model_text;

namespace {

const char* const kScene = R"~("scenes": { "s": { "stop": 1, "samples": 3 } })~";

/// Rates at a point.
std::vector<double> rates_at(const CompiledModel& p, double t, const std::vector<double>& x) {
  Evaluator evaluator(p.program, p.inputs.parameters);
  std::vector<double> rates(x.size());
  Branch branch = first_branch(p.program);
  REQUIRE(evaluator.initialize_modes(t, x.data(), branch));
  REQUIRE(evaluator.rates(t, x.data(), branch, rates.data()));
  return rates;
}

std::vector<double> outputs_at(const CompiledModel& p, double t, const std::vector<double>& x) {
  Evaluator evaluator(p.program, p.inputs.parameters);
  std::vector<double> outputs(p.inputs.outputs.size());
  Branch branch = first_branch(p.program);
  REQUIRE(evaluator.initialize_modes(t, x.data(), branch));
  REQUIRE(evaluator.outputs(t, x.data(), branch, outputs.data()));
  return outputs;
}

/// The explicit Jacobian, dense and row-major, from the evaluator's sparse one.
std::vector<double> jacobian_at(const CompiledModel& p, double t, const std::vector<double>& x) {
  Evaluator evaluator(p.program, p.inputs.parameters);
  Branch branch = first_branch(p.program);
  REQUIRE(evaluator.initialize_modes(t, x.data(), branch));
  const Sparsity& pattern = p.program.jacobian_pattern;
  std::vector<double> values(pattern.row.size()), dense(x.size() * x.size(), 0.0);
  REQUIRE(evaluator.jacobian(t, x.data(), branch, values.data()));
  for (std::size_t column = 0; column < x.size(); ++column)
    for (auto k = pattern.column_start[column]; k < pattern.column_start[column + 1]; ++k)
      dense[static_cast<std::size_t>(pattern.row[static_cast<std::size_t>(k)]) * x.size() + column] =
          values[static_cast<std::size_t>(k)];
  return dense;
}

}  // namespace

TEST_CASE("a series RLC gives the textbook's two state equations") {
  const CompiledModel p = compile_text(model_text(R"~("parameters": { "E": 10, "R": 3, "L": 2, "C": 0.5 },
    "elements": { "s": { "kind": "Se", "effort": "E" }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
                  "l": { "kind": "I", "inertance": "L" }, "c": { "kind": "C", "capacitance": "C" } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "l" },
               { "from": "j", "to": "c" } ],
    "outputs": { "i": "l.f", "u": "r.e" }, )~" + std::string(kScene)));
  REQUIRE(p.system().states.size() == 2);
  CHECK(p.system().states[0].name == "l.p");
  CHECK(p.system().states[1].name == "c.q");
  CHECK(p.study.order().blocks.empty());
  // Exact but for rounding of a handful of operations.
  const std::vector<double> rates = rates_at(p, 0.0, {4.0, 1.0});
  CHECK(rates[0] == Approx(10 - 3 * 2.0 - 1.0 / 0.5).epsilon(1e-15));
  CHECK(rates[1] == Approx(2.0).epsilon(1e-15));
  CHECK(outputs_at(p, 0.0, {4.0, 1.0}) == std::vector<double>{2.0, 6.0});
  CHECK(jacobian_at(p, 0.0, {4.0, 1.0}) == std::vector<double>{-1.5, -2.0, 0.5, 0.0});
}

TEST_CASE("half-arrows that leave R, C, I turn the bond's flow, not the element's law") {
  // The same capacitor discharging through the same resistor, with each half-arrow drawn either way.
  for (const bool reversed : {false, true}) {
    const std::string c = reversed ? R"~({ "from": "c", "to": "j" })~" : R"~({ "from": "j", "to": "c" })~";
    const std::string r = reversed ? R"~({ "from": "r", "to": "j" })~" : R"~({ "from": "j", "to": "r" })~";
    const CompiledModel p =
        compile_text(model_text(R"~("elements": { "j": { "kind": "0" }, "c": { "kind": "C", "capacitance": 2 },
        "r": { "kind": "R", "resistance": 5 } }, "bonds": [ )~" +
                                c + ", " + r + R"~( ],
        "outputs": { "ic": "c.f", "ir": "r.f", "b": "b1.f" }, )~" +
                                kScene));
    const std::vector<double> y = outputs_at(p, 0.0, {10.0});
    CHECK(y[0] == Approx(-1.0).epsilon(1e-15));  // into the capacitor
    CHECK(y[1] == Approx(1.0).epsilon(1e-15));   // into the resistor
    CHECK(y[2] == Approx(reversed ? 1.0 : -1.0).epsilon(1e-15));
    CHECK(rates_at(p, 0.0, {10.0})[0] == Approx(-1.0).epsilon(1e-15));
  }
}

TEST_CASE("TF and GY conserve power whichever way their half-arrows point") {
  for (const std::string kind : {"TF", "GY"})
    for (int arrows = 0; arrows < 4; ++arrows) {
      const std::string one =
          (arrows & 1) != 0 ? R"~({ "from": "x.1", "to": "a" })~" : R"~({ "from": "a", "to": "x.1" })~";
      const std::string two =
          (arrows & 2) != 0 ? R"~({ "from": "b", "to": "x.2" })~" : R"~({ "from": "x.2", "to": "b" })~";
      const CompiledModel p =
          compile_text(model_text(R"~("elements": { "s": { "kind": "Se", "effort": 12 }, "a": { "kind": "1" },
          "r1": { "kind": "R", "resistance": 2 }, "x": { "kind": ")~" +
                                  kind + R"~(", "modulus": 4 }, "b": { "kind": "1" },
          "r2": { "kind": "R", "resistance": 3 } },
          "bonds": [ { "from": "s", "to": "a" }, { "from": "a", "to": "r1" }, )~" +
                                  one + ", " + two +
                                  R"~(, { "from": "b", "to": "r2" } ],
          "outputs": { "supplied": "s.e*s.f", "lost": "r1.e*r1.f + r2.e*r2.f", "f": "s.f" }, )~" +
                                  kScene));
      const std::vector<double> y = outputs_at(p, 0.0, {});
      CHECK(y[0] == Approx(y[1]).epsilon(1e-14));
      // TF: load seen through e1 = 4 e2, f2 = 4 f1 is 16*3; GY: e1 = 4 f2 makes it 16/3.
      CHECK(y[2] == Approx(12.0 / (2.0 + (kind == "TF" ? 48.0 : 16.0 / 3.0))).epsilon(1e-14));
    }
}

TEST_CASE(
    "a mass behind a lever moves with the other: x' = F/(m1 + n^2 m2) and a Jacobian without the dependent store") {
  const CompiledModel p = compile_text(model_text(R"~("parameters": { "m1": 2, "m2": 3, "n": 0.25 },
    "elements": { "f": { "kind": "Se", "effort": 10 }, "v1": { "kind": "1" }, "i1": { "kind": "I", "inertance": "m1" },
      "k": { "kind": "C", "capacitance": "1/200" }, "c": { "kind": "R", "resistance": 4 },
      "lever": { "kind": "TF", "modulus": "n" }, "i2": { "kind": "I", "inertance": "m2" } },
    "bonds": [ { "from": "f", "to": "v1" }, { "from": "v1", "to": "i1" }, { "from": "v1", "to": "k" }, { "from": "v1", "to": "c" },
      { "from": "v1", "to": "lever" }, { "from": "lever", "to": "i2" } ],
    "outputs": { "p2": "i2.p", "v2": "i2.f" }, )~" +
                                                  std::string(kScene)));
  REQUIRE(p.system().states.size() == 2);
  REQUIRE(p.system().dependent.size() == 1);
  REQUIRE(p.study.order().blocks.size() == 1);
  CHECK(p.study.order().blocks[0].linear);
  const double p1 = 0.7, x = 0.01, v1 = p1 / 2;
  const double a = (10 - 200 * x - 4 * v1) / (2 + 3.0 / 16);  // v2 = v1/4: the load adds m2/16
  const std::vector<double> rates = rates_at(p, 0.0, {p1, x});
  CHECK(rates[0] == Approx(2 * a).epsilon(1e-14));
  CHECK(rates[1] == Approx(v1).epsilon(1e-15));
  const std::vector<double> y = outputs_at(p, 0.0, {p1, x});
  CHECK(y[0] == Approx(3 * v1 / 4).epsilon(1e-15));
  const std::vector<double> j = jacobian_at(p, 0.0, {p1, x});
  CHECK(j[0] == Approx(-4.0 / (2 + 3.0 / 16)).epsilon(1e-14));
  CHECK(j[1] == Approx(-400.0 / (2 + 3.0 / 16)).epsilon(1e-14));
}

TEST_CASE("a capacitor on a source follows it: its current is C du/dt") {
  const CompiledModel p =
      compile_text(model_text(R"~("elements": { "s": { "kind": "Se", "effort": "5*sin(3*t)" }, "j": { "kind": "0" },
      "c": { "kind": "C", "capacitance": 0.2 }, "r": { "kind": "R", "resistance": 10 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "c" }, { "from": "j", "to": "r" } ],
    "outputs": { "i": "s.f" }, )~" +
                              std::string(kScene)));
  CHECK(p.system().states.empty());
  const double t = 0.4;
  CHECK(outputs_at(p, t, {})[0] == Approx(0.2 * 15 * std::cos(3 * t) + 0.5 * std::sin(3 * t)).epsilon(1e-14));
}

TEST_CASE("a capacitor on a stepping source is refused: a jump has no derivative") {
  try {
    const CompiledModel p = compile_text(model_text(R"~("elements": { "s": { "kind": "Se", "effort": "step(t - 1)" },
      "j": { "kind": "0" }, "c": { "kind": "C", "capacitance": 0.2 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "c" } ], )~" +
                                                    std::string(kScene)));
    FAIL("accepted");
  } catch (const ModelError& error) {
    REQUIRE(error.diagnostics.size() == 1);
    CHECK(error.diagnostics[0].code == "BG402");
    CHECK(error.diagnostics[0].situation.find("step(t - 1)") != std::string::npos);
  }
}

TEST_CASE("der follows signals, states and dependent stores") {
  const CompiledModel p = compile_text(model_text(R"~("signals": { "u": "t^2", "w": "der(u*c.q)" },
    "elements": { "s": { "kind": "Sf", "flow": 3 }, "c": { "kind": "C", "capacitance": 2 } },
    "bonds": [ { "from": "s", "to": "c" } ],
    "outputs": { "w": "w", "second": "der(der(u))", "power": "der(c.q^2/4)" }, )~" +
                                                  std::string(kScene)));
  const double t = 1.5, q = 7.0;
  const std::vector<double> y = outputs_at(p, t, {q});
  CHECK(y[0] == Approx(2 * t * q + t * t * 3).epsilon(1e-15));
  CHECK(y[1] == Approx(2.0).epsilon(1e-15));
  CHECK(y[2] == Approx(q / 2 * 3).epsilon(1e-15));
}

TEST_CASE("loops of linear resistors are solved exactly and named") {
  const CompiledModel p =
      compile_text(model_text(R"~("elements": { "s": { "kind": "Se", "effort": 10 }, "j": { "kind": "1" },
      "r1": { "kind": "R", "resistance": 2 }, "r2": { "kind": "R", "resistance": 3 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r1" }, { "from": "j", "to": "r2" } ],
    "outputs": { "i": "s.f" }, )~" +
                              std::string(kScene)));
  REQUIRE(p.study.order().blocks.size() == 1);
  CHECK(p.study.order().blocks[0].tears.size() == 1);
  CHECK(outputs_at(p, 0.0, {})[0] == Approx(2.0).epsilon(1e-15));
  const std::string text = describe_loops(p.model(), p.system(), p.study.order());
  CHECK(text.find("linear, through r1, r2") != std::string::npos);
}

TEST_CASE("a nonlinear loop is solved to rounding from a start far away") {
  // Shockley diode and resistor: f = Is (exp(e/Vt) - 1), 5 V over 1 kOhm. Reference: residual of the loop equation.
  const CompiledModel p =
      compile_text(model_text(R"~("elements": { "s": { "kind": "Se", "effort": 5 }, "j": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1000 }, "d": { "kind": "R", "law": "f = 1e-14*(exp(e/0.025852) - 1)"
}
},
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "d" } ],
    "outputs": { "i": "d.f", "v": "d.e" }, )~" +
                              std::string(kScene)));
  const std::vector<double> y = outputs_at(p, 0.0, {});
  CHECK(y[0] == Approx((5 - y[1]) / 1000).epsilon(1e-12));
  CHECK(y[0] == Approx(1e-14 * std::expm1(y[1] / 0.025852)).epsilon(1e-11));  // the exponent magnifies rounding 27-fold
}

TEST_CASE("orifices that were at rest are followed to the flow that they have next, however far away") {
  // Two in series are a loop where one has a laminar part, however small. Its slope there, 2 k |f|, says nothing of
  // that: from f = 4e-64 Newton's step is 1e40 times too long.
  const CompiledModel p = compile_text(model_text(
      R"~("elements": { "c": { "kind": "C", "capacitance": 1 }, "j": { "kind": "1" },
      "r": { "kind": "R", "law": "e = 0.75e10*f*abs(f)" }, "s": { "kind": "R", "law": "e = 0.25e10*f*abs(f) + 1e-200*f" } },
    "bonds": [ { "from": "c", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "s" } ],
    "outputs": { "f": "r.f" }, )~" +
      std::string(kScene)));
  REQUIRE(p.program.blocks.size() == 1);
  Evaluator evaluator(p.program, p.inputs.parameters);
  for (const double last : {0.0, 4.4e-64, -3.4e-51, 1e-5})
    for (const double e : {1e-110, -1e-80, 4.7e-36, 1e5}) {
      INFO("from f = " << last << " to e = " << e);
      Branch branch = first_branch(p.program);
      branch.tears = {last};
      double f = 0.0;
      REQUIRE(evaluator.outputs(0.0, &e, branch, &f));
      CHECK(f == Approx(std::copysign(std::sqrt(std::abs(e) / 1e10), e)).epsilon(1e-14));  // rounding of three steps
    }
}

TEST_CASE("a loop is solved from a start that is ever so far away") {
  // A step of Newton's from 1e20 ends at the roundings of that, 1e4. What is left is nothing beside 1e20, and was taken
  // for the solution.
  const CompiledModel p = compile_text(model_text(
      R"~("elements": { "c": { "kind": "C", "capacitance": 1 }, "j": { "kind": "1" },
      "r": { "kind": "R", "resistance": 5 }, "d": { "kind": "R", "law": "f = 1e-10*(exp(e/0.05) - 1) + e/500" } },
    "bonds": [ { "from": "c", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "d" } ],
    "outputs": { "f": "r.f", "e": "r.e" }, )~" +
      std::string(kScene)));
  REQUIRE(p.program.blocks.size() == 1);
  Evaluator evaluator(p.program, p.inputs.parameters);
  for (const double sign : {1.0, -1.0})
    for (int decade = 0; decade <= 60; ++decade)
      for (const double e : {1.8, 0.3, -2.0}) {
        const double last = 5.23 * sign * std::pow(10.0, decade);
        CAPTURE(last, e);
        Branch branch = first_branch(p.program);
        branch.tears = {last};
        double out[2];
        REQUIRE(evaluator.outputs(0.0, &e, branch, out));
        const double across = e - out[1];
        CHECK(out[0] == Approx(out[1] / 5).epsilon(1e-12));
        // the exponent magnifies rounding by up to forty
        CHECK(out[0] == Approx(1e-10 * std::expm1(across / 0.05) + across / 500).epsilon(1e-11));
      }
}

TEST_CASE("resistors in series whose laws are powers of one degree are one resistor") {
  struct Case {
    const char *first, *second;
    double factor, power;
    bool loop;
  };
  for (const Case& of : {Case{"e = 3*f*abs(f)", "e = 2*sign(f)*f^2", 5.0, 2.0, false},
                         Case{"e = 3*f^3", "e = f*f*f/4", 3.25, 3.0, false},
                         Case{"e = 3*sign(f)*abs(f)^1.75", "e = 2*f*abs(f)^0.75 + f*abs(f)^0.75", 6.0, 1.75, false},
                         Case{"f = sign(e)*sqrt(abs(e)/3)", "f = sign(e)*sqrt(abs(e))", 4.0, 2.0, false},
                         Case{"e = 3*f*abs(f)", "e = 2*f*abs(f) + 1e-30*f", 5.0, 2.0, true}}) {
    INFO(of.first << ", " << of.second);
    const CompiledModel p =
        compile_text(model_text(std::string(
                                    R"~("elements": { "c": { "kind": "C", "capacitance": 0.5 }, "j": { "kind": "1" },
      "r": { "kind": "R", "law": ")~") +
                                of.first + R"~(" }, "s": { "kind": "R", "law": ")~" + of.second + R"~(" } },
    "bonds": [ { "from": "c", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "s" } ],
    "outputs": { "f": "r.f", "e": "s.e" }, )~" +
                                std::string(kScene)));
    CHECK(p.program.blocks.empty() == !of.loop);
    for (const double q : {3.0, -0.02}) {
      const std::vector<double> y = outputs_at(p, 0.0, {q});
      const double flow = std::copysign(std::pow(std::abs(2.0 * q) / of.factor, 1.0 / of.power), q);
      CHECK(y[0] == Approx(flow).epsilon(1e-14));  // rounding of a power and a root
      CHECK(std::abs(y[1]) < std::abs(2.0 * q));
    }
  }
}

TEST_CASE("resistors in series across a transformer are one, but not where its modulus varies") {
  for (const bool varies : {false, true}) {
    const CompiledModel p = compile_text(model_text(
        std::string(
            R"~("elements": { "c": { "kind": "C", "capacitance": 0.5 }, "j": { "kind": "1" }, "k": { "kind": "1" },
      "r": { "kind": "R", "law": "e = 3*f*abs(f)" }, "s": { "kind": "R", "law": "e = 2*f*abs(f)" }, "m": )~") +
        (varies ? R"~({ "kind": "MTF", "modulus": "2.5 + sin(t)" })~" : R"~({ "kind": "TF", "modulus": 2.5 })~") +
        R"~( },
    "bonds": [ { "from": "c", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "m" },
               { "from": "m", "to": "k" }, { "from": "k", "to": "s" } ],
    "outputs": { "f": "r.f" }, )~" +
        std::string(kScene)));
    const double m = 2.5, f = outputs_at(p, 0.0, {1.0})[0];                       // 2 = 3 f^2 + m 2 (m f)^2
    CHECK(f == Approx(std::sqrt(2.0 / (3.0 + 2.0 * m * m * m))).epsilon(1e-14));  // rounding of a sum and a root
    CHECK(p.program.blocks.empty() == !varies);
  }
}

TEST_CASE("a loop of gain one is reported as singular, with its elements") {
  // The source gives what the resistor takes, plus one: no flow satisfies both.
  const CompiledModel p = compile_text(model_text(
      R"~("parameters": { "k": 2 }, "elements": { "s": { "kind": "MSe", "effort": "k*r.f + 1" },
                   "r": { "kind": "R", "resistance": 2 } },
    "bonds": [ { "from": "s", "to": "r" } ], "outputs": { "i": "r.f" }, )~" +
      std::string(kScene)));
  Evaluator evaluator(p.program, p.inputs.parameters);
  double y = 0.0;
  Branch branch = first_branch(p.program);
  CHECK_FALSE(evaluator.outputs(0.0, nullptr, branch, &y));
  CHECK(evaluator.fault().kind == Fault::Kind::loop_singular);
  CHECK(evaluator.fault().target.find("s, r") != std::string::npos);
}

TEST_CASE("a law's fault names the operator and its arguments' values") {
  const CompiledModel p = compile_text(
      model_text(R"~("elements": { "c": { "kind": "C", "law": "e = sqrt(q)" }, "r": { "kind": "R", "resistance": 2 } },
    "bonds": [ { "from": "c", "to": "r" } ], "outputs": { "i": "r.f" }, )~" +
                 std::string(kScene)));
  Evaluator evaluator(p.program, p.inputs.parameters);
  const double q = -0.25;
  double rate = 0.0;
  Branch branch = first_branch(p.program);
  CHECK_FALSE(evaluator.rates(2.0, &q, branch, &rate));
  const Fault& fault = evaluator.fault();
  CHECK(fault.kind == Fault::Kind::not_finite);
  CHECK(fault.what == "sqrt(c.q) with c.q = -0.25");
  CHECK(fault.target == "the rate of \"c.q\"");
  CHECK(fault.elements == std::vector<std::string>{"c"});
  CHECK(fault.time == 2.0);
}

TEST_CASE("initial values of dependent stores are checked against the states that determine them") {
  const auto text = [](const std::string& p2) {
    return model_text(
        R"~("elements": { "v1": { "kind": "1" }, "i1": { "kind": "I", "inertance": 2, "initial": { "p": 4 } },
        "lever": { "kind": "TF", "modulus": 0.5 }, "i2": { "kind": "I", "inertance": 3, "initial": { "p": )~" +
        p2 + R"~( } } },
      "bonds": [ { "from": "v1", "to": "i1" }, { "from": "v1", "to": "lever" }, { "from": "lever", "to": "i2" } ], )~" +
        kScene);
  };
  const CompiledModel good = compile_text(text("3"));  // v1 = 2, v2 = 1, p2 = 3
  Evaluator evaluator(good.program, good.inputs.parameters);
  CHECK(initial_states(evaluator, good.inputs) == std::vector<double>{4.0});
  const CompiledModel bad = compile_text(text("3.1"));
  Evaluator other(bad.program, bad.inputs.parameters);
  try {
    initial_states(other, bad.inputs);
    FAIL("accepted");
  } catch (const ModelError& error) {
    CHECK(error.diagnostics.at(0).code == "BG405");
    CHECK(error.diagnostics.at(0).situation == "the initial value i2.p = 3.1 contradicts i1.p, from which 3 follows");
  }
}

TEST_CASE("the linearization agrees with the evaluator's own Jacobian") {
  // Nonlinear spring, loop of resistors, dependent mass: three kinds of elimination in one model.
  const CompiledModel p = compile_text(
      model_text(R"~("parameters": { "F": 2 }, "elements": { "s": { "kind": "Se", "effort": "F" }, "v": { "kind": "1" },
      "m": { "kind": "I", "inertance": 2 }, "k": { "kind": "C", "law": "e = 3*q + q^3" }, "g": { "kind": "GY", "modulus": 0.5 },
      "w": { "kind": "0" }, "ra": { "kind": "R", "resistance": 4 }, "x": { "kind": "1" }, "rb": { "kind": "R", "law": "e = f + f^3" },
      "c": { "kind": "C", "capacitance": 0.3 }, "n": { "kind": "TF", "modulus": 3 }, "m2": { "kind": "I", "inertance": 5 } },
    "bonds": [ { "from": "s", "to": "v" }, { "from": "v", "to": "m" }, { "from": "v", "to": "k" }, { "from": "v", "to": "g" },
      { "from": "g", "to": "w" }, { "from": "w", "to": "ra" }, { "from": "w", "to": "x" }, { "from": "x", "to": "rb" },
      { "from": "x", "to": "c" }, { "from": "v", "to": "n" }, { "from": "n", "to": "m2" } ],
    "outputs": { "f": "rb.f" }, )~" +
                 std::string(kScene)));
  std::vector<double> x(p.system().states.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = 0.3 + 0.2 * static_cast<double>(i);
  const test::Linearization lin = test::linear_at(p.study, p.inputs, 0.0, x, {"F"});
  const std::vector<double> j = jacobian_at(p, 0.0, x);
  REQUIRE(lin.a.size() == j.size());
  for (std::size_t i = 0; i < j.size(); ++i) CHECK(lin.a[i] == Approx(j[i]).epsilon(1e-12).margin(1e-13));
  // The force accelerates both masses, the second at three times the velocity: m takes 2/(2 + 9*5) of it.
  CHECK(lin.b[0] == Approx(2.0 / 47.0).epsilon(1e-12));
}

TEST_CASE("names that would look alike where equations are typeset are written as they are") {
  const Study study = Study::from_text(R"({ "bgsim": 1, "name": "alike", "parameters": { "R1": 1, "R_1": 2, "R_2": 5,
    "q_c": 3 }, "elements": { "s": { "kind": "Se", "effort": "q_c" }, "j": { "kind": "1" },
    "r": { "kind": "R", "resistance": "R1 + R_1*R_2" }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "c" } ],
    "outputs": { "q": "c.q" }, "scenes": { "run": { "stop": 1 } } })");
  const std::string latex = equations_latex(study.model(), study.equations(), study.order());
  CAPTURE(latex);
  // R_2 has no other that looks like it, and keeps its index.
  CHECK(latex.find("\\dot{\\mathrm{c.q}} &= \\frac{\\mathrm{q\\_c} - \\mathrm{c.q}}{\\mathrm{R1} + \\mathrm{R\\_1} \\, "
                   "R_{2}}") != std::string::npos);
  const std::vector<EquationGroup> groups = equations_mathml(study.model(), study.equations(), study.order());
  CHECK(groups.front().lines.front().left.find("<mi>c.q</mi>") != std::string::npos);
  // In text nothing looks alike.
  const std::string text = equations_text(study.model(), study.equations(), study.order());
  CHECK(text.find("c.q' = (q_c - c.q)/(R1 + R_1*R_2)") != std::string::npos);
}

TEST_CASE("printed equations of a model with switches name the mode that they hold in") {
  const Study study = Study::from_text(R"({ "bgsim": 1, "name": "charge", "elements": {
    "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" }, "w": { "kind": "Sw", "closed": "t > 1" },
    "r": { "kind": "R", "resistance": 1 }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "w" }, { "from": "j", "to": "r" },
      { "from": "j", "to": "c" } ], "outputs": { "q": "c.q" }, "scenes": { "run": { "stop": 2 } } })");
  const auto printed = [](const Study& of) { return equations_text(of.model(), of.equations(), of.order()); };
  CHECK(printed(study).find("in the mode w open\n\nstate equations\n  c.q' = 0\n") != std::string::npos);
  CHECK(equations_latex(study.model(), study.equations(), study.order()).find("% in the mode w open\n") !=
        std::string::npos);
}
