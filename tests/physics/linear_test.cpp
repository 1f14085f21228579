// Linear analysis against closed forms, against the tableau of random graphs, and what it refuses.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "support/algebra.hpp"
#include "support/random_graph.hpp"
#include "support/rounds.hpp"
#include "support/run.hpp"
#include "support/tableau.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;
using Complex = std::complex<double>;
using Eigen::Index;

namespace {

const std::string kScene = R"x("scenes": { "s": { "stop": 1, "samples": 3 } })x";

LinearSystem linear_at_start(const Study& study, const std::vector<std::string>& inputs = {},
                             const std::vector<std::string>& set = {}) {
  return study.linearized(prepare_scene(study.model(), "", with_parameters(set)), inputs);
}

LinearSystem linear_text_at_start(const std::string& body, const std::vector<std::string>& inputs = {},
                                  const std::vector<std::string>& set = {}) {
  return linear_at_start(Study::from_text(model_text(body + kScene)), inputs, set);
}

double entry(const LinearMatrix& matrix, std::size_t row, std::size_t column) {
  for (const auto& e : matrix.entries)
    if (e.row == row && e.column == column) return e.value;
  return 0.0;
}

std::string refusal(const std::string& body, const std::vector<std::string>& inputs = {},
                    const std::vector<std::string>& set = {}) {
  try {
    linear_text_at_start(body, inputs, set);
  } catch (const ModelError& error) {
    return error.what();
  }
  return {};
}

/// A capacitor that empties through a resistor of the law @p law, charged with @p q.
std::string emptying(const std::string& law, double q) {
  return R"x("elements": { "c": { "kind": "C", "capacitance": 1, "initial": { "q": )x" + number_text(q, 17) +
         R"x( } }, "r": { "kind": "R", "law": ")x" + law + R"x(" } },
         "bonds": [ { "from": "c", "to": "r" } ], "outputs": { "i": "r.f" }, )x";
}

/// n equal sections of resistor and capacitor behind buffers: x_k' = x_(k-1) - x_k, all poles at -1.
std::string buffered_chain(int n) {
  std::string signals = R"("signals": { "x1": { "integral": "u - x1" })";
  for (int k = 2; k <= n; ++k)
    signals += ", \"x" + std::to_string(k) + "\": { \"integral\": \"x" + std::to_string(k - 1) + " - x" +
               std::to_string(k) + "\" }";
  return R"("parameters": { "u": 1 }, )" + signals +
         R"( }, "elements": { "c": { "kind": "C", "capacitance": 1 }, "r": { "kind": "R", "resistance": 1 } },
         "bonds": [ { "from": "c", "to": "r" } ], "outputs": { "y": "x)" +
         std::to_string(n) + R"(" }, )";
}

/// G(s) of the tableau: stores' displacements and bonds' efforts and flows to unit deviations of all sources.
Eigen::MatrixXcd tableau_response(const Tableau& tableau, Complex s) {
  const Eigen::MatrixXcd matrix =
      tableau.law_y.cast<Complex>() + tableau.law_x.cast<Complex>() * tableau.rate_y.cast<Complex>() / s;
  // As twice as many real equations, which the tests' algebra solves.
  const Index n = matrix.rows(), k = tableau.law_u.cols();
  Eigen::MatrixXd real(2 * n, 2 * n), right = Eigen::MatrixXd::Zero(2 * n, k);
  real << matrix.real(), -matrix.imag(), matrix.imag(), matrix.real();
  right.topRows(n) = -tableau.law_u;
  const Eigen::MatrixXd y = solved(real, right);
  Eigen::MatrixXcd result(n, k);
  result.real() = y.topRows(n);
  result.imag() = y.bottomRows(n);
  return result;
}

}  // namespace

TEST_CASE("a series circuit has the matrices and poles of its closed form") {
  const Study study = study_of("models/rlc.json");
  const LinearSystem system = linear_at_start(study, {"battery"});
  REQUIRE(system.states.size() == 2);
  CHECK(system.inputs[0].name == "battery.e");
  CHECK(system.inputs[0].unit == "V");
  CHECK(system.inputs[0].value == 10.0);
  const std::size_t p = system.states[0].name == "coil.p" ? 0 : 1, q = 1 - p;
  CHECK(system.states[p].unit == "Wb");
  // p' = E - R p/L - q/C, q' = p/L
  CHECK(entry(system.a, p, p) == Approx(-1e4).epsilon(1e-14));
  CHECK(entry(system.a, p, q) == Approx(-1e5).epsilon(1e-14));
  CHECK(entry(system.a, q, p) == Approx(1e3).epsilon(1e-14));
  CHECK(entry(system.b[0], p, 0) == 1.0);
  CHECK(system.states[p].rate == 10.0);
  const std::vector<Pole> found = poles(system);
  REQUIRE(found.size() == 1);
  CHECK(found[0].pair);
  CHECK(found[0].s.real() == Approx(-5000).epsilon(1e-14));
  CHECK(found[0].s.imag() == Approx(std::sqrt(1e8 - 25e6)).epsilon(1e-14));
  CHECK(found[0].damping() == Approx(0.5).epsilon(1e-14));
  // Without losses both would hold half of the energy; so they do here, since each is a half of the mode's mean.
  CHECK(found[0].energy[0].share == Approx(0.5).epsilon(1e-12));
  CHECK(found[0].error < 1e-9);
}

TEST_CASE("a deviation of a source reaches a store in derivative causality as its derivative") {
  // C on a source, with R beside it: i = u/R + C u'.
  const LinearSystem system = linear_text_at_start(R"x("parameters": { "u": 2 },
    "elements": { "s": { "kind": "Se", "effort": "u" }, "j": { "kind": "0" }, "c": { "kind": "C", "capacitance": 3 },
      "r": { "kind": "R", "resistance": 4 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "c" }, { "from": "j", "to": "r" } ],
    "outputs": { "i": "s.f" }, )x",
                                                   {"u"});
  CHECK(system.states.empty());
  REQUIRE(system.d.size() == 2);
  CHECK(entry(system.d[0], 0, 0) == Approx(0.25).epsilon(1e-15));
  CHECK(entry(system.d[1], 0, 0) == Approx(3.0).epsilon(1e-15));
  const std::vector<double> omega{0.0, 2.0};
  const FrequencyResponse response = frequency_response(system, 0, 0, omega);
  CHECK(response.value[0] == Complex(0.25, 0.0));
  CHECK(std::abs(response.value[1] - Complex(0.25, 6.0)) < 1e-14);
  const TransferZeros found = transfer_zeros(system, 0, 0);
  REQUIRE(found.zeros.size() == 1);
  CHECK(found.zeros[0].s.real() == Approx(-1.0 / 12).epsilon(1e-14));
  // The descriptor form has the input and its derivative as variables, and says the same.
  const auto& form = system.descriptor;
  REQUIRE(form.variables.size() >= 2);
  CHECK(form.variables.back().name == "u'");
}

TEST_CASE("parameters that are computed from an input follow it, those that a scene gives do not") {
  const std::string body = R"x("parameters": { "k": 2, "g": "3*k", "h": "g + k" },
    "elements": { "s": { "kind": "Sf", "flow": "h" }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "c" } ], "outputs": { "q": "c.q", "h": "h" }, )x";
  CHECK(entry(linear_text_at_start(body, {"k"}).b[0], 0, 0) == 4.0);
  CHECK(entry(linear_text_at_start(body, {"k"}).d[0], 1, 0) == 4.0);
  CHECK(entry(linear_text_at_start(body, {"k"}, {"g=1"}).b[0], 0, 0) == 1.0);
}

TEST_CASE("poles of equal sections in a row are exact, whatever their number") {
  // As eigenvalues of one full matrix twelve equal ones are known to a tenth at best.
  const LinearSystem system = linear_text_at_start(buffered_chain(12));
  const std::vector<Pole> found = poles(system);
  REQUIRE(found.size() == 13);
  for (const Pole& pole : found) {
    CHECK(pole.s == Complex(-1.0, 0.0));
    CHECK(pole.multiple == 13);
  }
}

TEST_CASE("a free body has poles at exactly zero, with the names of what is free") {
  const LinearSystem system = linear_text_at_start(R"x("parameters": { "F": 0 },
    "signals": { "x": { "integral": "body.f" } },
    "elements": { "push": { "kind": "Se", "effort": "F" }, "body": { "kind": "I", "inertance": 3 } },
    "bonds": [ { "from": "push", "to": "body" } ], "outputs": { "x": "x" }, )x",
                                                   {"push"});
  const std::vector<Pole> found = poles(system);
  REQUIRE(found.size() == 2);
  CHECK(found[0].s == 0.0);
  CHECK(found[1].s == 0.0);
  CHECK(free_states(poles(system)).size() == 2);
  const TransferZeros path = transfer_zeros(system, 0, 0);
  CHECK(path.zeros.empty());
  CHECK(path.gain == Approx(1.0 / 3).epsilon(1e-15));
  CHECK(std::isinf(path.static_gain));
}

TEST_CASE("a free body that only differences show has a static gain") {
  // A torque on one of two disks on a shaft: its twist rests at J2/((J1 + J2) k), the torque of the shaft at a share.
  const LinearSystem system = linear_text_at_start(R"x("parameters": { "T": 0 }, "elements": {
    "drive": { "kind": "Se", "effort": "T" }, "a": { "kind": "1" }, "j1": { "kind": "I", "inertance": 0.02 },
    "n": { "kind": "0" }, "b": { "kind": "1" }, "k": { "kind": "C", "capacitance": "1/120" },
    "r": { "kind": "R", "resistance": 0.1 }, "c": { "kind": "1" }, "j2": { "kind": "I", "inertance": 0.05 } },
    "bonds": [ { "from": "drive", "to": "a" }, { "from": "a", "to": "j1" }, { "from": "a", "to": "n" },
      { "from": "n", "to": "b" }, { "from": "b", "to": "k" }, { "from": "b", "to": "r" }, { "from": "n", "to": "c" },
      { "from": "c", "to": "j2" } ],
    "outputs": { "twist": "k.q", "torque": "k.e + r.e", "difference": "r.f", "speed": "j1.f", "rate": "der(j1.f)" }, )x",
                                                   {"T"});
  const double expected[] = {0.05 / 0.07 / 120, 0.05 / 0.07, 0.0, std::numeric_limits<double>::infinity(), 1 / 0.07};
  const std::size_t zeros[] = {0, 1, 1, 1, 1};  // a pair counts once
  for (std::size_t output = 0; output < 5; ++output) {
    CAPTURE(system.outputs[output].name);
    const TransferZeros path = transfer_zeros(system, 0, output);
    if (std::isinf(expected[output]))
      CHECK(std::isinf(path.static_gain));
    else
      CHECK(path.static_gain == Approx(expected[output]).epsilon(1e-7).margin(0.0));  // the limit leaves 1e-8
    CHECK(path.cancelled == (output == 3 ? 0 : 1));
    CHECK(path.zeros.size() == zeros[output]);
    CHECK(path.poles.size() == (output == 3 ? 2 : 1));
  }
}

TEST_CASE("a zero far below all else does not hide that an integrator is left") {
  // A resistor and a capacitor in series, seen by a flow source: R + 1/(C s), with its zero at 1e-12 rad/s.
  const LinearSystem system = linear_text_at_start(R"x("parameters": { "F": 0 }, "elements": {
    "s": { "kind": "Sf", "flow": "F" }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 1e6 },
    "c": { "kind": "C", "capacitance": 1e6 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "c" } ],
    "outputs": { "e": "r.e + c.e" }, )x",
                                                   {"F"});
  const TransferZeros path = transfer_zeros(system, 0, 0);
  CHECK(std::isinf(path.static_gain));
  CHECK(path.cancelled == 0);
}

TEST_CASE("poles of very different sizes are each right") {
  // Two oscillators, at 1e9 and 1e-6 rad/s.
  const LinearSystem system = linear_text_at_start(R"x("elements": {
    "j1": { "kind": "1" }, "m1": { "kind": "I", "inertance": 1e-12 }, "k1": { "kind": "C", "capacitance": 1e-6 },
    "j2": { "kind": "1" }, "m2": { "kind": "I", "inertance": 1e6 }, "k2": { "kind": "C", "capacitance": 1e6 } },
    "bonds": [ { "from": "j1", "to": "m1" }, { "from": "j1", "to": "k1" }, { "from": "j2", "to": "m2" },
      { "from": "j2", "to": "k2" } ], "outputs": { "v": "m1.f" }, )x");
  const std::vector<Pole> found = poles(system);
  REQUIRE(found.size() == 2);
  CHECK(found[0].s.imag() == Approx(1e-6).epsilon(1e-14));
  CHECK(found[1].s.imag() == Approx(1e9).epsilon(1e-14));
  CHECK(found[0].s.real() == 0.0);
  CHECK(found[1].s.real() == 0.0);
}

TEST_CASE("a graded chain has its smallest pole to the digits that its error tells") {
  // Three capacitors of 1, 1e-6, 1e-12 F between 1 ohm resistors to ground and each other, all in one block.
  const LinearSystem system = linear_text_at_start(R"x("elements": {
    "n1": { "kind": "0" }, "n2": { "kind": "0" }, "n3": { "kind": "0" },
    "c1": { "kind": "C", "capacitance": 1 }, "c2": { "kind": "C", "capacitance": 1e-6 },
    "c3": { "kind": "C", "capacitance": 1e-12 }, "g": { "kind": "R", "resistance": 1 },
    "j12": { "kind": "1" }, "r12": { "kind": "R", "resistance": 1 }, "j23": { "kind": "1" },
    "r23": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "n1", "to": "c1" }, { "from": "n1", "to": "g" }, { "from": "n1", "to": "j12" },
      { "from": "j12", "to": "r12" }, { "from": "j12", "to": "n2" }, { "from": "n2", "to": "c2" },
      { "from": "n2", "to": "j23" }, { "from": "j23", "to": "r23" }, { "from": "j23", "to": "n3" },
      { "from": "n3", "to": "c3" } ], "outputs": { "u": "c1.e" }, )x");
  const std::vector<Pole> found = poles(system);
  REQUIRE(found.size() == 3);
  // The characteristic polynomial of the admittances, in exact fractions: c1 c2 c3 s^3 + ... = 0, Newton from the
  // sizes.
  const long double c1 = 1.0L, c2 = 1e-6L, c3 = 1e-12L;
  for (std::size_t i = 0; i < 3; ++i) {
    long double s = found[i].s.real();
    for (int k = 0; k < 60; ++k) {
      const auto value = [&](long double x) {
        const long double y3 = 1 + c3 * x, y2 = 2 + c2 * x, y1 = 2 + c1 * x;
        return y1 * (y2 * y3 - 1) - y3;
      };
      const long double h = s * 1e-7L, slope = (value(s + h) - value(s - h)) / (2 * h);
      s -= value(s) / slope;
    }
    // Twice the error that is told, since that is an estimate.
    CHECK(std::abs(found[i].s.real() - static_cast<double>(s)) <= 2.0 * found[i].error);
    CHECK(found[i].error <= 1e-12 * std::abs(found[i].s.real()));
  }
}

TEST_CASE("frequency responses of random linear graphs are those of the tableau") {
  std::size_t compared = 0, with_derivatives = 0;
  for (std::uint64_t seed = 70001; seed < 70001 + share_of(300); ++seed) {
    RandomGraphOptions options;
    options.most_rings = 1;
    options.sources = 0.25;
    const RandomGraph random = random_graph(seed, options);
    INFO("seed " << seed << "\n" << random.json());
    const Study study = Study::from_text(random.json());
    std::vector<std::string> inputs;
    for (const Parameter& parameter : study.model().parameters) inputs.push_back(parameter.name);
    if (inputs.empty() || study.model().outputs.empty()) continue;
    const RunInputs point = prepare_scene(study.model(), "");
    const Tableau tableau = form_tableau(study.model(), study.graph(), point.parameters);
    if (!motion_of(tableau).regular) continue;
    LinearSystem system;
    try {
      system = study.linearized(point, inputs);
    } catch (const ModelError& error) {
      INFO(error.what());
      REQUIRE((error.diagnostics.front().code.starts_with("BG3") || error.diagnostics.front().code == "BG403" ||
               error.diagnostics.front().code == "BG411"));
      continue;
    }
    const double w = 0.37;
    const std::vector<double> omega{w};
    const Eigen::MatrixXcd theirs = tableau_response(tableau, {0.0, w});
    const auto bonds = static_cast<Index>(study.graph().bonds.size());
    const double size = theirs.cwiseAbs().maxCoeff();
    for (std::size_t i = 0; i < inputs.size(); ++i)
      for (std::size_t k = 0; k < tableau.stores.size(); ++k) {
        // Outputs are e, f and q or p of each store.
        const Port& port = study.graph()[tableau.stores[k]];
        const auto bond = static_cast<Index>(port.bond.index());
        const Complex expected[2] = {theirs(bond, static_cast<Index>(i)),
                                     theirs(bonds + bond, static_cast<Index>(i)) * (port.head ? 1.0 : -1.0)};
        for (std::size_t j = 0; j < 2; ++j) {
          Complex ours = 0.0;
          try {
            ours = frequency_response(system, i, 3 * k + j, omega).value[0];
          } catch (const ModelError& error) {
            REQUIRE(error.diagnostics.front().code == "BG410");
          }
          // Both are solved to rounding, and random graphs are conditioned to some thousands.
          REQUIRE(std::abs(ours - expected[j]) <= 1e-9 * std::max(size, 1.0));
        }
      }
    ++compared;
    if (system.b.size() > 1 || system.d.size() > 1) ++with_derivatives;
  }
  CHECK(compared > share_of(300) / 4);
  CHECK(with_derivatives > 0);
}

TEST_CASE("zeros are where the response vanishes, and gain and poles give the response back") {
  std::size_t compared = 0;
  for (std::uint64_t seed = 71001; seed < 71001 + share_of(150); ++seed) {
    RandomGraphOptions options;
    options.most_rings = 0;
    options.most_junctions = 4;
    options.sources = 0.2;
    const Study study = Study::from_text(random_graph(seed, options).json());
    INFO("seed " << seed);
    if (study.model().parameters.empty() || study.model().outputs.empty()) continue;
    LinearSystem system;
    try {
      system = study.linearized(prepare_scene(study.model(), ""), {study.model().parameters[0].name});
    } catch (const ModelError&) {
      continue;
    }
    for (std::size_t output = 0; output < system.outputs.size(); ++output) {
      TransferZeros found;
      try {
        found = transfer_zeros(system, 0, output);
      } catch (const ModelError& error) {
        REQUIRE(error.diagnostics.front().code == "BG410");
        continue;
      }
      const double w = 1.3;
      const Complex s(0.0, w);
      Complex product = found.gain;
      for (const Pole& zero : found.zeros) product *= zero.pair ? (s - zero.s) * (s - std::conj(zero.s)) : s - zero.s;
      for (const Pole& pole : found.poles) product /= pole.pair ? (s - pole.s) * (s - std::conj(pole.s)) : s - pole.s;
      const std::vector<double> omega{w};
      const Complex direct = frequency_response(system, 0, output, omega).value[0];
      INFO("output " << system.outputs[output].name << " " << product << " " << direct);
      // Multiple zeros are known to the root of rounding, and so is the product.
      REQUIRE(std::abs(product - direct) <= 1e-6 * (std::abs(direct) + 1e-12));
      ++compared;
    }
  }
  CHECK(compared > share_of(150));
}

TEST_CASE("a kink at the point is named, and no kink where both sides have one slope") {
  CHECK_THAT(refusal(emptying("f = abs(e)", 0.0)), Contains("BG408") && Contains("at its border"));
  CHECK_THAT(refusal(emptying("f = max(e, 0)", 0.0)), Contains("BG408"));
  CHECK_THAT(refusal(emptying("f = if(e > 0, 2*e, e)", 0.0)), Contains("BG408") && Contains("c.q"));
  CHECK_THAT(refusal(emptying("f = if(e > 1, 1 + 2*e, e)", 1.0)), Contains("BG408") && Contains("jumps"));
  CHECK_THAT(refusal(emptying("f = e + floor(2*e)", 0.5)), Contains("BG408") && Contains("jumps"));
  CHECK_THAT(refusal(emptying("f = sign(e)*sqrt(abs(e))", 0.0)), Contains("BG407") && Contains("slope"));
  CHECK_THAT(refusal(emptying("f = ssqrt(e, 0)", 0.0)), Contains("BG407"));
  CHECK_THAT(refusal(emptying("f = cbrt(e)", 0.0)), Contains("BG407") && Contains("cbrt"));
  CHECK_THAT(refusal(emptying("f = hypot(e, 0)", 0.0)), Contains("BG407"));
  CHECK(refusal(emptying("f = e*abs(e)", 0.0)).empty());
  CHECK(refusal(emptying("f = if(e > 0, e^2, -e^2)", 0.0)).empty());
  CHECK(refusal(emptying("f = if(e > 0, e, sin(e))", 0.0)).empty());
  CHECK(refusal(emptying("f = ssqrt(e, 1e-3)", 0.0)).empty());
  CHECK(refusal(emptying("f = abs(e)", 1.0)).empty());
  CHECK(refusal(emptying("f = max(e, 0)", -1.0)).empty());
}

TEST_CASE("a slope that changes within the uncertainty of the point is not known") {
  const Study study = Study::from_text(model_text(emptying("f = sign(e)*sqrt(abs(e))", 1e-8) + kScene));
  RunInputs point = prepare_scene(study.model(), "");
  CHECK_NOTHROW(study.linearized(point));
  point.initial[0].rounding = 3e-9;
  CHECK_THROWS_WITH(study.linearized(point), Contains("BG408") && Contains("uncertain"));
}

TEST_CASE("inputs that there are not are refused with what is meant") {
  const std::string body = R"x("parameters": { "stiffness": 2 },
    "elements": { "pump": { "kind": "Se", "effort": 1 }, "c": { "kind": "C", "law": "e = stiffness*q" } , "j": { "kind": "1" },
    "r": { "kind": "R", "resistance": 1 } }, "bonds": [ { "from": "pump", "to": "j" }, { "from": "j", "to": "c" },
    { "from": "j", "to": "r" } ], "outputs": { "q": "c.q" }, )x";
  const auto help = [&](const std::string& input) {
    try {
      linear_text_at_start(body, {input});
    } catch (const ModelError& error) {
      return error.diagnostics.front().code + " " + error.diagnostics.front().help;
    }
    return std::string();
  };
  CHECK(help("stifness") == "BG406 did you mean stiffness?");
  CHECK(help("pump.f") == "BG406 the source pump gives pump.e");
  CHECK(help("c.q") == "BG406 c is no source; add one to the model where the input acts");
  CHECK(help("pump").empty());
  CHECK(help("stiffness").empty());
}

TEST_CASE("an output that no input reaches has no response") {
  const LinearSystem system = linear_text_at_start(R"x("parameters": { "a": 1, "b": 1 },
    "elements": { "s": { "kind": "Sf", "flow": "a" }, "c": { "kind": "C", "capacitance": 1 },
      "s2": { "kind": "Sf", "flow": "b" }, "c2": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "c" }, { "from": "s2", "to": "c2" } ], "outputs": { "q": "c.q" }, )x",
                                                   {"b"});
  const std::vector<double> omega{1.0};
  CHECK_THROWS_WITH(frequency_response(system, 0, 0, omega), Contains("BG410"));
  CHECK_THROWS_WITH(transfer_zeros(system, 0, 0), Contains("BG410"));
  CHECK_THROWS_WITH(time_response(system, 0, 0, Excitation::step, 1.0, 11), Contains("BG410"));
}

TEST_CASE("the step response is the run of the same model whose source steps") {
  const Study study = study_of("models/dc_motor.json");
  const LinearSystem system = linear_at_start(study, {"V"});
  const RunResult result = run(study);
  // Before the load comes at 0.1 s, from rest: 12 times the unit response. The run is at 1e-9.
  const TimeResponse response = time_response(system, 0, 1, Excitation::step, 0.09, 91);
  const std::vector<double> omega = column(result, "omega");
  for (std::size_t i = 0; i < response.times.size(); ++i)
    CHECK(12.0 * response.value[i] == Approx(omega[i]).margin(1e-7 * largest_magnitude(omega)));
}

TEST_CASE("models of the repository are linearized, and slopes are those of differences of the rates") {
  for (const std::string& file : runnable_models_in("models")) {
    INFO(file);
    const Study study = study_of(file).at_start();
    const RunInputs point = prepare_scene(study.model(), "");
    LinearSystem system;
    try {
      system = study.linearized(point);
    } catch (const ModelError& error) {
      // What begins at a kink says so.
      const std::string code = error.diagnostics.front().code;
      REQUIRE((code == "BG407" || code == "BG408" || code == "BG629"));
      continue;
    }
    const CompiledModel compiled = compile_study(study, point);
    Evaluator evaluator(compiled.program, point.parameters);
    const std::vector<double> x = initial_states(evaluator, point);
    if (compiled.program.state_names == std::vector<std::string>{"(clock)"}) {  // of a mode in which nothing is stored
      REQUIRE(system.states.empty());
      continue;
    }
    REQUIRE(system.states.size() == x.size());
    for (std::size_t j = 0; j < x.size(); ++j) {
      double scale = std::abs(x[j]);
      if (scale == 0.0) continue;  // no size to take a difference by
      const double h = 1e-6 * scale;
      std::vector<double> up = x, down = x, f_up(x.size()), f_down(x.size());
      up[j] += h;
      down[j] -= h;
      Branch one = first_branch(compiled.program), two = one;
      if (!evaluator.initialize_modes(point.start, up.data(), one) ||
          !evaluator.initialize_modes(point.start, down.data(), two) ||
          !evaluator.rates(point.start, up.data(), one, f_up.data()) ||
          !evaluator.rates(point.start, down.data(), two, f_down.data()))
        continue;
      for (std::size_t i = 0; i < x.size(); ++i) {
        // Central differences: rounding of the rates over 2 h, and their third derivative.
        const double rounding = 1e-15 * (std::abs(f_up[i]) + std::abs(system.states[i].rate)) / h;
        const double slope = (f_up[i] - f_down[i]) / (2.0 * h);
        CHECK(entry(system.a, i, j) == Approx(slope).epsilon(1e-4).margin(100.0 * rounding));
      }
    }
  }
}
