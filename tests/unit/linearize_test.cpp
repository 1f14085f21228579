// What linear_system() refuses. That its matrices are right: equations_test.cpp, tests/physics/oracle_test.cpp and
// linear_test.cpp.

#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

const std::string kScene = R"x("scenes": { "s": { "stop": 1, "samples": 3 } })x";

/// The message with which linear_system() refuses the point @p x at t = 0; empty if it does not.
std::string refusal(const CompiledModel& p, const std::vector<double>& x, const std::vector<std::string>& inputs) {
  try {
    linear_at(p.study, p.inputs, 0.0, x, inputs);
  } catch (const ModelError& error) {
    return error.what();
  }
  return {};
}

/// Two resistors in series on a source, with the laws @p first and @p second.
CompiledModel two_resistors(const std::string& first, const std::string& second) {
  return compile_text(model_text(R"x("parameters": { "E": 0 }, "elements": { "s": { "kind": "Se", "effort": "E" },
      "j": { "kind": "1" }, "a": { "kind": "R", "law": ")x" +
                                 first + R"x(" }, "b": { "kind": "R", "law": ")x" + second + R"x(" } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "a" }, { "from": "j", "to": "b" } ],
    "outputs": { "f": "a.f" }, )x" +
                                 kScene));
}

/// A capacitor with the law @p law that empties through a resistor.
CompiledModel capacitor(const std::string& law) {
  return compile_text(model_text(R"x("parameters": { "R": 2 }, "elements": { "c": { "kind": "C", "law": ")x" + law +
                                 R"x(" }, "r": { "kind": "R", "resistance": "R" } },
    "bonds": [ { "from": "c", "to": "r" } ], "outputs": { "i": "r.f" }, )x" +
                                 kScene));
}

}  // namespace

TEST_CASE("a linearization takes a parameter as input, but no flow that nothing gives") {
  const CompiledModel p = capacitor("e = q");
  CHECK(refusal(p, {1.0}, {"R"}).empty());
  CHECK(refusal(p, {1.0}, {"r.f"}) == "BG406: there is no input \"r.f\"");
}

TEST_CASE("a point at which a law has no finite value is not linearized") {
  CHECK(refusal(capacitor("e = sqrt(q)"), {-1.0}, {}) ==
        "BG407: the system cannot be linearized here: sqrt(c.q) with c.q = -1 is not a finite number");
}

TEST_CASE("a point at which a law has no finite slope is not linearized") {
  const CompiledModel p = capacitor("e = sqrt(q)");
  CHECK(refusal(p, {1.0}, {}).empty());
  CHECK(refusal(p, {0.0}, {}) ==
        "BG407: the system cannot be linearized here: sqrt(c.q) (c) has no finite slope by c.q = 0; the rate of c.q "
        "depends on it");
}

TEST_CASE("a point at which an algebraic loop is singular is not linearized") {
  CHECK(refusal(two_resistors("e = f + f^3", "e = f^5 + f"), {}, {"E"}).empty());
  // Both slopes are 0 in the point of rest: the flow goes with the cube root of the effort.
  CHECK_THAT(refusal(two_resistors("e = f^3 + f^5", "e = f^5 + f^3"), {}, {"E"}),
             Contains("BG407: the system cannot be linearized here: the loop through ") && Contains(" is singular"));
}

TEST_CASE("loops of one system may differ by any scale") {
  const CompiledModel p = compile_text(model_text(R"x("parameters": { "E": 1 }, "elements": {
      "s": { "kind": "Se", "effort": "E" }, "j": { "kind": "0" }, "k": { "kind": "1" }, "l": { "kind": "1" },
      "a": { "kind": "R", "law": "e = f + f^3" }, "b": { "kind": "R", "law": "e = f + f^5" },
      "c": { "kind": "R", "law": "e = 1e20*(f + f^3)" }, "d": { "kind": "R", "law": "e = 1e20*(f + f^5)" } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "k" }, { "from": "j", "to": "l" },
      { "from": "k", "to": "a" }, { "from": "k", "to": "b" }, { "from": "l", "to": "c" }, { "from": "l", "to": "d" } ],
    "outputs": { "f": "a.f", "g": "c.f" }, )x" + kScene));
  const Linearization l = linear_at(p.study, p.inputs, 0.0, {}, {"E"});
  // f solves 2 f + f^3 + f^5 = 1, and its slope is 1/(2 + 3 f^2 + 5 f^4); g is 1/2e20 of E.
  double f = 0.0;
  for (int i = 0; i < 50; ++i) f -= (2 * f + f * f * f + std::pow(f, 5) - 1) / (2 + 3 * f * f + 5 * std::pow(f, 4));
  REQUIRE(l.d.size() == 2);
  CHECK(l.d[0] == Approx(1 / (2 + 3 * f * f + 5 * std::pow(f, 4))).epsilon(1e-9));
  CHECK(l.d[1] == Approx(5e-21).epsilon(1e-9));
}
