// Transfer functions in symbols against closed forms, the numerical linearization, and Mason's formula.
#include "bgsim/transfer.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "expression/parse.hpp"
#include "support/random_graph.hpp"
#include "support/rounds.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;
using Complex = std::complex<double>;

namespace {

RunInputs point_of(const Study& study, const std::string& output, const std::vector<std::string>& set = {}) {
  RunInputs point = prepare_scene(study.model(), "", with_parameters(set));
  point.outputs.clear();
  for (std::size_t i = 0; i < study.model().outputs.size(); ++i)
    if (study.model().outputs[i].name == output) point.outputs.push_back(i);
  REQUIRE(point.outputs.size() == 1);
  return point;
}

TransferFunction transfer_of(const Study& study, const std::string& input, const std::string& output,
                             const std::vector<std::string>& set = {}) {
  return transfer_function(study.shared_model(), point_of(study, output, set), input);
}

std::vector<std::string> texts(const SymbolicPolynomial& polynomial) {
  std::vector<std::string> result;
  for (const SymbolicNumber& number : polynomial) result.push_back(number.text);
  return result;
}

/// The polynomial with the parameters of a point, from the texts alone.
Complex value_of(const SymbolicPolynomial& polynomial, const Model& model, const std::vector<double>& parameters,
                 Complex s) {
  ExprPool pool;
  ExpressionScope scope;
  scope.time = SymbolId(0);
  scope.name = [&](std::string_view name) -> std::optional<ExprId> {
    for (std::size_t i = 0; i < model.parameters.size(); ++i)
      if (model.parameters[i].name == name) return pool.symbol(SymbolId(i + 1));
    return std::nullopt;
  };
  std::vector<double> values(1, 0.0);
  values.insert(values.end(), parameters.begin(), parameters.end());
  Complex sum = 0.0;
  for (std::size_t i = polynomial.size(); i-- > 0;)
    sum = sum * s + evaluate(pool, parse_expression(polynomial[i].text, pool, scope), values);
  return sum;
}

/// Sum over sets of loops that do not touch each other, nor @p taken: products of -gain.
Complex mason(const std::vector<CausalPath>& loops, std::size_t from, std::vector<std::uint32_t>& taken, Complex s) {
  Complex sum = 1.0;
  for (std::size_t i = from; i < loops.size(); ++i) {
    const bool touches = std::any_of(loops[i].nodes.begin(), loops[i].nodes.end(), [&](std::uint32_t node) {
      return std::find(taken.begin(), taken.end(), node) != taken.end();
    });
    if (touches) continue;
    const std::size_t before = taken.size();
    taken.insert(taken.end(), loops[i].nodes.begin(), loops[i].nodes.end());
    sum -= loops[i].at(s) * mason(loops, i + 1, taken, s);
    taken.resize(before);
  }
  return sum;
}

Complex by_mason(const CausalPaths& found, Complex s) {
  Complex sum = 0.0;
  for (const CausalPath& path : found.paths) {
    std::vector<std::uint32_t> taken = path.nodes;
    sum += path.at(s) * mason(found.loops, 0, taken, s);
  }
  std::vector<std::uint32_t> none;
  return sum / mason(found.loops, 0, none, s);
}

/// All numbers of elements as parameters p_ELEMENT.
std::string with_names(const std::string& text) {
  nlohmann::ordered_json model = nlohmann::ordered_json::parse(text);
  for (auto& [name, element] : model["elements"].items())
    for (auto& [key, value] : element.items())
      if (value.is_number()) {
        model["parameters"]["p_" + name] = value;
        value = "p_" + name;
      }
  return model.dump();
}

const std::string kTail = R"x(, "scenes": { "s": { "stop": 1, "samples": 3 } } })x";

}  // namespace

TEST_CASE("transfer functions of a motor are those of the textbook") {
  const Study study = study_of("models/dc_motor.json");
  const TransferFunction motor = transfer_of(study, "V", "omega");
  CHECK(texts(motor.numerator) == std::vector<std::string>{"K"});
  CHECK(texts(motor.denominator) == std::vector<std::string>{"R*b + K^2", "R*J + L*b", "L*J"});
  CHECK(motor.values.empty());
  CHECK(motor.mismatch < 1e-12);  // roundings
  const CausalPaths paths = causal_paths(study.shared_model(), point_of(study, "omega"), "V");
  REQUIRE(paths.paths.size() == 1);
  CHECK(paths.paths[0].gain == "K/(L*J*s^2)");
  REQUIRE(paths.loops.size() == 3);
  CHECK(paths.loops[0].gain == "-R/(L*s)");
  CHECK(paths.loops[0].elements == std::vector<std::string>{"winding", "coil"});
  CHECK(paths.loops[1].gain == "-K^2/(L*J*s^2)");
  CHECK(paths.loops[2].gain == "-b/(J*s)");
}

TEST_CASE("a loop of resistors and a store behind a source have their transfer functions, too") {
  // Ra and Rb with nothing but each other between the source and C: an algebraic loop at the 0-junction.
  const Study divider = Study::from_text(
      R"x({ "bgsim": 1, "name": "divider", "parameters": { "Ra": 2, "Rb": 3, "Rc": 5, "C": 0.1 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" }, "a": { "kind": "R", "resistance": "Ra" },
      "z": { "kind": "0" }, "b": { "kind": "R", "resistance": "Rb" }, "k": { "kind": "1" },
      "r": { "kind": "R", "resistance": "Rc" }, "c": { "kind": "C", "capacitance": "C" } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "a" }, { "from": "j", "to": "z" },
      { "from": "z", "to": "b" }, { "from": "z", "to": "k" }, { "from": "k", "to": "r" }, { "from": "k", "to": "c" } ],
    "outputs": { "u": "c.e", "v": "b.e" })x" +
      kTail);
  const TransferFunction u = transfer_of(divider, "s", "u");
  CHECK(texts(u.numerator) == std::vector<std::string>{"Rb"});
  CHECK(texts(u.denominator) == std::vector<std::string>{"Ra + Rb", "Ra*Rb*C + Ra*Rc*C + Rb*Rc*C"});
  const TransferFunction v = transfer_of(divider, "s", "v");
  CHECK(texts(v.numerator) == std::vector<std::string>{"Rb", "Rb*Rc*C"});
  CHECK(texts(v.denominator) == texts(u.denominator));
  CHECK(std::abs(by_mason(causal_paths(divider.shared_model(), point_of(divider, "v"), "s"), {0.3, 2.0}) -
                 value_of(v.numerator, divider.model(), point_of(divider, "v").parameters, {0.3, 2.0}) /
                     value_of(v.denominator, divider.model(), point_of(divider, "v").parameters, {0.3, 2.0})) < 1e-14);

  // The current into a capacitor at a source: C s, a polynomial with no denominator; beside R, with one.
  const Study behind = Study::from_text(
      R"x({ "bgsim": 1, "name": "behind", "parameters": { "R": 2, "C": 0.1, "L": 0.3 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "z": { "kind": "0" }, "c": { "kind": "C", "capacitance": "C" },
      "j": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" }, "l": { "kind": "I", "inertance": "L" } },
    "bonds": [ { "from": "s", "to": "z" }, { "from": "z", "to": "c" }, { "from": "z", "to": "j" },
      { "from": "j", "to": "r" }, { "from": "j", "to": "l" } ],
    "outputs": { "i": "s.f", "ic": "c.f" })x" +
      kTail);
  const TransferFunction i = transfer_of(behind, "s", "i");
  // The sign is that of the model's half-arrow out of the source.
  CHECK(texts(i.numerator) == std::vector<std::string>{"1", "R*C", "L*C"});
  CHECK(texts(i.denominator) == std::vector<std::string>{"R", "L"});
  const TransferFunction ic = transfer_of(behind, "s", "ic");
  CHECK(texts(ic.numerator) == std::vector<std::string>{"0", "C"});
  CHECK(texts(ic.denominator) == std::vector<std::string>{"1"});
  CHECK(ic.hidden == std::vector<std::string>{"l.p"});
}

TEST_CASE("sums in denominators are cleared, and numbers stay decimal") {
  const Study study = Study::from_text(
      R"x({ "bgsim": 1, "name": "sums", "parameters": { "R": 2, "r": 3, "a": 7 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" },
      "x": { "kind": "R", "resistance": "1/(1/R + 1/r)" }, "c": { "kind": "C", "capacitance": 0.1 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "x" }, { "from": "j", "to": "c" } ],
    "outputs": { "u": "c.e", "scaled": "sqrt(a)*c.e/3" })x" +
      kTail);
  const TransferFunction u = transfer_of(study, "s", "u");
  CHECK(texts(u.numerator) == std::vector<std::string>{"10*R + 10*r"});
  CHECK(texts(u.denominator) == std::vector<std::string>{"10*R + 10*r", "R*r"});
  const TransferFunction scaled = transfer_of(study, "s", "scaled");
  CHECK_THAT(texts(scaled.numerator)[0], Contains("sqrt(a)"));
  CHECK(scaled.mismatch < 1e-12);
}

TEST_CASE("slopes of nonlinear laws are named, with their values at the point") {
  const Study study = Study::from_text(
      R"x({ "bgsim": 1, "name": "tank", "parameters": { "k": 2, "A": 3 },
    "elements": { "in": { "kind": "Sf", "flow": 4 }, "z": { "kind": "0" }, "tank": { "kind": "C", "law": "e = q/A", "initial": { "q": 12 } },
      "hole": { "kind": "R", "law": "f = k*ssqrt(e, 1e-3)" } },
    "bonds": [ { "from": "in", "to": "z" }, { "from": "z", "to": "tank" }, { "from": "z", "to": "hole" } ],
    "outputs": { "h": "tank.e" })x" +
      kTail);
  const TransferFunction tank = transfer_of(study, "in", "h");
  CHECK(texts(tank.numerator) == std::vector<std::string>{"1"});
  CHECK(texts(tank.denominator) == std::vector<std::string>{"slope(hole.f, hole.e)", "A"});
  REQUIRE(tank.values.size() == 1);
  CHECK(tank.values[0].second == Approx(0.5).epsilon(1e-6));  // k/(2 sqrt(e)) with e = 4
  // What rests at 0 has no part: k q^3 at q = 0 is no spring.
  const Study rest = Study::from_text(
      R"x({ "bgsim": 1, "name": "rest", "parameters": { "k": 2, "c": 5, "m": 3 },
    "elements": { "f": { "kind": "Se", "effort": 0 }, "j": { "kind": "1" }, "spring": { "kind": "C", "law": "e = c*q + k*q^3" },
      "mass": { "kind": "I", "inertance": "m" } },
    "bonds": [ { "from": "f", "to": "j" }, { "from": "j", "to": "spring" }, { "from": "j", "to": "mass" } ],
    "outputs": { "x": "spring.q" })x" +
      kTail);
  const TransferFunction x = transfer_of(rest, "f", "x");
  CHECK(texts(x.numerator) == std::vector<std::string>{"1"});
  CHECK(texts(x.denominator) == std::vector<std::string>{"c", "0", "m"});
}

TEST_CASE("what has no transfer function in symbols is refused") {
  const auto refusal = [](const Study& study, const std::string& input, const std::string& output) -> std::string {
    try {
      static_cast<void>(transfer_of(study, input, output));
    } catch (const ModelError& error) {
      return error.what();
    }
    return {};
  };
  const Study motor = study_of("models/dc_motor.json");
  CHECK_THAT(refusal(motor, "nothing", "omega"), Contains("BG406"));
  const Study no_states = Study::from_text(
      R"x({ "bgsim": 1, "name": "none", "parameters": { "R": 2 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "r": { "kind": "R", "resistance": "R" } },
    "bonds": [ { "from": "s", "to": "r" } ], "outputs": { "i": "r.f", "one": "R" })x" +
      kTail);
  const TransferFunction i = transfer_of(no_states, "s", "i");
  CHECK(texts(i.numerator) == std::vector<std::string>{"1"});
  CHECK(texts(i.denominator) == std::vector<std::string>{"R"});
  CHECK_THAT(refusal(no_states, "s", "one"), Contains("BG410"));
  // A ladder of forty sections has more terms than a page.
  std::string elements = R"x("s": { "kind": "Se", "effort": 1 })x", bonds, parameters, last = "s";
  for (int n = 0; n < 40; ++n) {
    const std::string id = std::to_string(n);
    parameters += (n > 0 ? ", " : "") + ("\"R" + id + "\": 1, \"C" + id + "\": 1");
    elements += ", \"j" + id + R"x(": { "kind": "1" }, "z)x" + id + R"x(": { "kind": "0" }, "r)x" + id +
                R"x(": { "kind": "R", "resistance": "R)x" + id + R"x(" }, "c)x" + id +
                R"x(": { "kind": "C", "capacitance": "C)x" + id + "\" }";
    bonds += (n > 0 ? ", " : "") + ("{ \"from\": \"" + last + "\", \"to\": \"j" + id + "\" }, { \"from\": \"j" + id +
                                    "\", \"to\": \"r" + id + "\" }, { \"from\": \"j" + id + "\", \"to\": \"z" + id +
                                    "\" }, { \"from\": \"z" + id + "\", \"to\": \"c" + id + "\" }");
    last = "z" + id;
  }
  const auto ladder = [&](const std::string& output) {
    return Study::from_text(R"x({ "bgsim": 1, "name": "ladder", "parameters": { )x" + parameters +
                            " }, \"elements\": { " + elements + " }, \"bonds\": [ " + bonds +
                            " ], \"outputs\": { \"u\": \"" + output + "\" }" + kTail);
  };
  CHECK_THAT(refusal(ladder("c39.e"), "s", "u"), Contains("BG409"));
}

TEST_CASE("random graphs have the transfer functions that their matrices have, at other parameters, too") {
  std::size_t compared = 0, with_loops = 0, by_loops = 0;
  for (std::uint64_t seed = 81001; seed < 81001 + share_of(400); ++seed) {
    RandomGraphOptions options;
    options.most_rings = 1;
    options.most_junctions = 4;
    options.most_at_junction = 2;
    options.sources = 0.25;
    const Study study = Study::from_text(with_names(random_graph(seed, options).json()));
    INFO("seed " << seed);
    const auto& parameters = study.model().parameters;
    if (study.model().outputs.empty() || parameters.empty() || !parameters[0].name.starts_with("u_")) continue;
    const std::string input = parameters[0].name,
                      output = study.model().outputs[seed % study.model().outputs.size()].name;
    const RunInputs point = point_of(study, output);
    TransferFunction transfer;
    try {
      transfer = transfer_function(study.shared_model(), point, input);
    } catch (const ModelError& error) {
      INFO(error.what());
      // No equations of index 1, or no path.
      const std::string code = error.diagnostics.front().code;
      REQUIRE((code.starts_with("BG3") || code == "BG403" || code == "BG407" || code == "BG409" || code == "BG410" ||
               code == "BG411"));
      continue;
    }
    // Sums of some hundred products; random graphs are conditioned to some thousands.
    constexpr double kRounding = 1e-7;
    CHECK(transfer.mismatch < 1e-12);
    // Other values of the elements, within 20 % so that no singular graph comes near.
    std::mt19937_64 random(seed);
    std::vector<std::string> set;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const double factor = 0.8 + 0.4 * static_cast<double>(random() >> 11U) * 0x1p-53;
      set.push_back(parameters[i].name + "=" + std::to_string(factor * point.parameters[i]));
    }
    const RunInputs other = point_of(study, output, set);
    LinearSystem numbers;
    try {
      numbers = study.linearized(other, {input});
    } catch (const ModelError&) {
      continue;
    }
    for (const double w : {0.1, 1.0, 7.0}) {
      const Complex s(0.0, w);
      const std::vector<double> omega{w};
      const Complex exact = frequency_response(numbers, 0, 0, omega).value[0];
      const Complex own = value_of(transfer.numerator, study.model(), other.parameters, s) /
                          value_of(transfer.denominator, study.model(), other.parameters, s);
      if (!std::isfinite(std::abs(exact))) continue;
      CAPTURE(w, exact, own);
      REQUIRE(std::abs(own - exact) <= kRounding * std::max(std::abs(exact), 1e-3));
    }
    ++compared;
    if (!numbers.loops.empty()) ++with_loops;
    const CausalPaths paths = causal_paths(study.shared_model(), point, input, 60);
    if (!paths.all || paths.loops.size() > 30) continue;
    const Complex s(0.1, 1.7);
    Complex numerator = 0.0, denominator = 0.0;
    for (std::size_t i = transfer.numerator.size(); i-- > 0;) numerator = numerator * s + transfer.numerator[i].value;
    for (std::size_t i = transfer.denominator.size(); i-- > 0;)
      denominator = denominator * s + transfer.denominator[i].value;
    const Complex own = numerator / denominator, mason = by_mason(paths, s);
    CAPTURE(own, mason, paths.loops.size(), paths.paths.size());
    REQUIRE(std::abs(own - mason) <= kRounding * std::max(std::abs(own), 1e-3));
    ++by_loops;
  }
  INFO(compared << " compared, " << with_loops << " with loops, " << by_loops << " by Mason");
  CHECK(compared > share_of(400) / 6);
  CHECK(by_loops > share_of(400) / 8);
}
