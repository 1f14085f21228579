// Structural controllability and observability against cases that are known, and the ranks of random graphs.
#include "bgsim/structure.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "support/algebra.hpp"
#include "support/random_graph.hpp"
#include "support/rounds.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const std::string kTail = R"x(, "scenes": { "s": { "stop": 1, "samples": 3 } } })x";
using Names = std::vector<std::string>;

StructuralControl control_of(const Study& study, const Names& inputs) {
  return structural_control(study.shared_model(), prepare_scene(study.model(), ""), inputs);
}

/// Dimension of what b, A b, A^2 b, ... span: each vector made orthogonal to those before, twice.
std::size_t krylov_rank(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  std::vector<Eigen::VectorXd> basis;
  const auto take = [&](Eigen::VectorXd v) {
    const double size = v.norm();
    if (size == 0.0) return;
    for (int pass = 0; pass < 2; ++pass)
      for (const Eigen::VectorXd& q : basis) v -= q.dot(v) * q;
    // Random values: what is left of a vector is either some parts in a thousand, or rounding.
    if (v.norm() > 1e-9 * size) basis.push_back(v.normalized());
  };
  for (Eigen::Index c = 0; c < b.cols(); ++c) take(b.col(c));
  for (std::size_t i = 0; i < basis.size(); ++i) take(a * basis[i]);
  return basis.size();
}

Eigen::MatrixXd dense_of(const LinearMatrix& matrix) {
  Eigen::MatrixXd result =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(matrix.rows), static_cast<Eigen::Index>(matrix.columns));
  for (const auto& e : matrix.entries) result(e.row, e.column) = e.value;
  return result;
}

}  // namespace

TEST_CASE("two capacitors in series are charged alike: one combination of them is not moved") {
  const Study study = Study::from_text(
      R"x({ "bgsim": 1, "name": "series", "parameters": { "R": 2, "A": 0.1, "B": 0.3 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
      "a": { "kind": "C", "capacitance": "A" }, "b": { "kind": "C", "capacitance": "B" } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "a" }, { "from": "j", "to": "b" } ],
    "outputs": { "i": "r.f" })x" +
      kTail);
  const StructuralControl found = control_of(study, {"s"});
  CHECK(found.states == Names{"a.q", "b.q"});
  CHECK(found.controllable.rank == 1);
  CHECK(found.controllable.without_path.empty());
  CHECK(found.controllable.combinations == std::vector<Names>{{"a.q", "b.q"}});
  // The current shows their sum alone.
  CHECK(found.observable.rank == 1);
  CHECK(found.observable.combinations == std::vector<Names>{{"a.q", "b.q"}});
}

TEST_CASE("what no causal path reaches is named") {
  // The buffer drives a second circuit, and nothing comes back.
  const Study study = Study::from_text(
      R"x({ "bgsim": 1, "name": "buffer", "parameters": { "R": 2, "C": 0.1, "r": 1, "c": 3 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "j": { "kind": "1" }, "R1": { "kind": "R", "resistance": "R" },
      "C1": { "kind": "C", "capacitance": "C" }, "buffer": { "kind": "MSe", "effort": "u" }, "k": { "kind": "1" },
      "R2": { "kind": "R", "resistance": "r" }, "C2": { "kind": "C", "capacitance": "c" } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "R1" }, { "from": "j", "to": "C1" },
      { "from": "buffer", "to": "k" }, { "from": "k", "to": "R2" }, { "from": "k", "to": "C2" } ],
    "signals": { "u": "C1.e" }, "outputs": { "u1": "C1.e", "u2": "C2.e" })x" +
      kTail);
  StructuralControl found = control_of(study, {"buffer"});
  CHECK(found.controllable.rank == 1);
  CHECK(found.controllable.without_path == Names{"C1.q"});
  CHECK(found.controllable.combinations.empty());
  CHECK(found.observable.rank == 2);
  RunInputs first = prepare_scene(study.model(), "");
  first.outputs = {0};
  found = structural_control(study.shared_model(), first, {"s"});
  CHECK(found.controllable.rank == 2);
  CHECK(found.observable.rank == 1);
  CHECK(found.observable.without_path == Names{"C2.q"});
}

TEST_CASE("a model without inputs is looked at for observability alone") {
  const Study tanks = study_of("models/tanks.json");
  const StructuralControl found = control_of(tanks, {});
  CHECK(found.inputs.empty());
  CHECK(found.controllable.rank == 0);
  CHECK(found.controllable.without_path == found.states);
  CHECK(found.observable.rank == found.states.size());
}

TEST_CASE("equal parts are controllable for almost all values, unless they are one parameter") {
  // Two RC circuits at one source: controllable if their time constants differ.
  const auto circuits = [](const std::string& second) {
    return Study::from_text(
        R"x({ "bgsim": 1, "name": "two", "parameters": { "R": 2, "C": 0.1, "r": 2, "c": 0.1 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "z": { "kind": "0" }, "j": { "kind": "1" }, "k": { "kind": "1" },
      "R1": { "kind": "R", "resistance": "R" }, "C1": { "kind": "C", "capacitance": "C" }, )x" +
        second +
        R"x( },
    "bonds": [ { "from": "s", "to": "z" }, { "from": "z", "to": "j" }, { "from": "z", "to": "k" }, { "from": "j", "to": "R1" },
      { "from": "j", "to": "C1" }, { "from": "k", "to": "R2" }, { "from": "k", "to": "C2" } ],
    "outputs": { "u": "C1.e - C2.e" })x" +
        kTail);
  };
  const Study apart =
      circuits(R"x("R2": { "kind": "R", "resistance": "r" }, "C2": { "kind": "C", "capacitance": "c" })x");
  CHECK(control_of(apart, {"s"}).controllable.rank == 2);
  const Study same =
      circuits(R"x("R2": { "kind": "R", "resistance": "R" }, "C2": { "kind": "C", "capacitance": "C" })x");
  CHECK(control_of(same, {"s"}).controllable.rank == 1);
  CHECK(control_of(same, {"s"}).observable.rank == 1);
}

TEST_CASE("ranks of random graphs are those of their matrices") {
  std::size_t compared = 0, short_of_full = 0;
  for (std::uint64_t seed = 91001; seed < 91001 + share_of(400); ++seed) {
    RandomGraphOptions options;
    options.most_rings = 1;
    options.most_junctions = 5;
    options.sources = 0.2;
    nlohmann::ordered_json json = nlohmann::ordered_json::parse(random_graph(seed, options).json());
    Names inputs;
    for (const auto& [name, value] : json["parameters"].items()) inputs.push_back(name);
    for (auto& [name, element] : json["elements"].items())
      for (auto& [key, value] : element.items())
        if (value.is_number()) {
          json["parameters"]["p_" + name] = value;
          value = "p_" + name;
        }
    const Study study = Study::from_text(json.dump());
    INFO("seed " << seed);
    if (inputs.empty() || study.model().outputs.empty()) continue;
    if (inputs.size() > 2) inputs.resize(2);
    RunInputs point = prepare_scene(study.model(), "");
    point.outputs = {seed % study.model().outputs.size()};
    StructuralControl found;
    LinearSystem numbers;
    try {
      numbers = study.linearized(point, inputs);
      found = structural_control(study.shared_model(), point, inputs);
    } catch (const ModelError& error) {
      INFO(error.what());
      const std::string code = error.diagnostics.front().code;
      REQUIRE((code.starts_with("BG3") || code == "BG403" || code == "BG407" || code == "BG411"));
      continue;
    }
    const Eigen::MatrixXd a = dense_of(numbers.a);
    Eigen::MatrixXd b = dense_of(numbers.b.back());
    // (s - A)^-1 s^k B_k acts on the states as A^k B_k
    for (std::size_t k = numbers.b.size() - 1; k-- > 0;) b = (dense_of(numbers.b[k]) + a * b).eval();
    CHECK(found.controllable.rank == krylov_rank(a, b));
    CHECK(found.observable.rank == krylov_rank(a.transpose(), dense_of(numbers.c).transpose()));
    ++compared;
    if (found.controllable.rank < found.states.size()) ++short_of_full;
  }
  CHECK(compared > share_of(400) / 4);
  CHECK(short_of_full > 0);
}
