// Initial efforts of C and flows of I: what is stored follows by the law.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/approx.hpp"
#include "support/reading.hpp"

using namespace bgsim;
using test::line_of;
using test::read;

namespace {

/// A store on a junction with a resistor, and a field between two junctions.
Model model(const std::string& store, const std::string& scene = R"("stop": 1)") {
  return read(R"x("parameters": { "a": 2, "k": 100, "m": 4 }, "signals": { "s": "a*t" }, "elements": {
    "j": { "kind": "1" }, "r": { "kind": "R", "resistance": "a" }, "x": )x" +
              store + R"x( },
    "bonds": [ { "from": "j", "to": "r" }, { "from": "j", "to": "x" } ],
    "outputs": { "f": "r.f" }, "scenes": { "run": { )x" +
              scene + " } }");
}

double stored(const Model& m, const std::vector<std::string>& set = {}) {
  SceneOverrides overrides;
  overrides.set = set;
  const RunInputs inputs = prepare_scene(m, "", overrides);
  REQUIRE(inputs.initial.size() == 1);
  return inputs.initial[0].value;
}

std::string fault(const std::string& store, const std::string& scene = R"("stop": 1)") {
  try {
    const Model m = model(store, scene);
    prepare_scene(m, "");
  } catch (const ModelError& error) {
    return line_of(error.diagnostics.front(), *error.sources);
  }
  return "none";
}

}  // namespace

TEST_CASE("an initial flow of an inertia and an effort of a capacitor become what is stored") {
  CHECK(stored(model(R"x({ "kind": "I", "inertance": "m", "initial": { "f": 3 } })x")) == 12.0);
  CHECK(stored(model(R"x({ "kind": "C", "capacitance": "1/k", "initial": { "e": "a" } })x")) ==
        test::same_to_rounding(0.02));
  CHECK(stored(model(R"x({ "kind": "C", "law": "e = k*q^3", "initial": { "e": -2700 } })x")) ==
        test::same_to_rounding(-3.0));
  CHECK(stored(model(R"x({ "kind": "C", "law": "q = tanh(e)/k", "initial": { "e": 1 } })x")) ==
        test::same_to_rounding(std::tanh(1.0) / 100.0));
  // A relativistic mass: f = p/sqrt(m^2 + (p/a)^2), so that p = m f/sqrt(1 - (f/a)^2); the slope is above 0 everywhere.
  CHECK(stored(model(R"x({ "kind": "I", "law": "p = m*f/sqrt(1 - (f/a)^2)", "initial": { "f": 1 } })x")) ==
        test::same_to_rounding(4.0 / std::sqrt(0.75)));
}

TEST_CASE("a law without a closed inverse is solved where it is proven to have one solution") {
  // e = k q + a q^3 with q = 2: 216. Found to the last bits by bracketing.
  const Model hardening = model(R"x({ "kind": "C", "law": "e = k*q + a*q^3", "initial": { "e": 216 } })x");
  CHECK(stored(hardening) == test::same_to_rounding(2.0));
  CHECK(stored(model(R"x({ "kind": "C", "law": "e = -k*q - sinh(q)", "initial": { "e": 100 } })x")) < 0.0);
  CHECK(fault(R"x({ "kind": "C", "law": "e = k*q^2", "initial": { "e": 5 } })x").find("BG183") != std::string::npos);
  CHECK(fault(R"x({ "kind": "C", "law": "e = sin(q)", "initial": { "e": 2 } })x").find("BG183") != std::string::npos);
  CHECK(fault(R"x({ "kind": "C", "law": "e = tanh(q)", "initial": { "e": 2 } })x").find("BG183") != std::string::npos);
  // Slopes in which q occurs several times, and kinks: each has one solution.
  CHECK(stored(model(R"x({ "kind": "C", "law": "e = q/sqrt(1 + q^2/4)", "initial": { "e": 0.3 } })x")) ==
        test::same_to_rounding(0.3 / std::sqrt(0.9775)));
  CHECK(stored(model(R"x({ "kind": "C", "law": "e = q/(1 + abs(q))", "initial": { "e": -0.75 } })x")) ==
        test::same_to_rounding(-3.0));
  CHECK(stored(model(R"x({ "kind": "C", "law": "e = max(q, 0)", "initial": { "e": 2 } })x")) == 2.0);
  CHECK(stored(model(R"x({ "kind": "I", "law": "f = p*exp(-p^2) + p/k", "initial": { "f": 1e6 } })x")) ==
        test::same_to_rounding(1e8));
  // sqrt(q) + q = 0.75 where sqrt(q) is 0.5: the law ends at 0
  CHECK(stored(model(R"x({ "kind": "C", "law": "e = sqrt(q) + q", "initial": { "e": 0.75 } })x")) ==
        test::same_to_rounding(0.25));
  const auto words = [](const std::string& law, const std::string& effort) {
    return fault(R"x({ "kind": "C", "law": ")x" + law + R"x(", "initial": { "e": )x" + effort + " } }");
  };
  CHECK_THAT(words("e = q/(1 + q^2)", "0.4"), Catch::Contains("its law gives it for several values of x.q: 0.5, 2"));
  CHECK_THAT(words("e = q/(1 + q^2)", "0.6"), Catch::Contains("no value of x.q gives it by the law"));
  CHECK_THAT(words("e = max(q, 0)", "0"), Catch::Contains("may give it for several values of x.q, or for none"));
}

TEST_CASE("the law is solved with the parameters of the scene and of the command line") {
  const std::string mass = R"x({ "kind": "I", "inertance": "m", "initial": { "f": 3 } })x";
  CHECK(stored(model(mass, R"x("stop": 1, "parameters": { "m": 5 })x")) == 15.0);
  CHECK(stored(model(mass), {"m=6"}) == 18.0);
  CHECK(stored(model(mass), {"x.f=2"}) == 8.0);
  CHECK(stored(model(mass), {"x.p=1"}) == 1.0);
  CHECK(stored(model(mass, R"x("stop": 1, "initial": { "x.p": 7 })x")) == 7.0);
  CHECK(stored(model(mass, R"x("stop": 1, "initial": { "x.f": 0.5 })x")) == 2.0);
  // Signals of t have the value of the scene's start.
  const std::string moving = R"x({ "kind": "MI", "inertance": "m + s", "initial": { "f": 3 } })x";
  CHECK(stored(model(moving, R"("start": 2, "stop": 3)")) == 24.0);
}

TEST_CASE("two initial values of one store are refused, and so are those of what a store does not give") {
  CHECK(fault(R"x({ "kind": "I", "inertance": 1, "initial": { "f": 3, "p": 3 } })x").find("BG184") !=
        std::string::npos);
  CHECK(fault(R"x({ "kind": "I", "inertance": 1, "initial": { "e": 3 } })x").find("BG135") != std::string::npos);
  CHECK(fault(R"x({ "kind": "C", "capacitance": 1, "initial": { "f": 3 } })x").find("BG135") != std::string::npos);
  CHECK(fault(R"x({ "kind": "MC", "capacitance": "1 + r.f^2", "initial": { "e": 3 } })x").find("BG117") !=
        std::string::npos);
}

TEST_CASE("a law may use the store's own effort under another name") {
  // Beside a single resistor the effort of both is one, and the flow a function of it: a varactor is no dissipator.
  const auto varactor = [](const std::string& value) {
    return test::fault(
        R"x("parameters": { "c": 1 }, "elements": { "j": { "kind": "0" }, "r": { "kind": "R", "resistance": 2 },
      "x": { "kind": "MC", "law": ")x" +
        value + R"x(" } },
      "bonds": [ { "from": "j", "to": "r" }, { "from": "j", "to": "x" } ], "scenes": { "run": { "stop": 1 } })x");
  };
  CHECK(varactor("q = c*e/(1 + j.e^2)") == "none");
  CHECK(varactor("q = c*e/(1 + r.e^2)") == "none");
  CHECK(varactor("q = c*e/(1 + r.f^2)").find("BG117") != std::string::npos);
}

TEST_CASE("efforts of several ports of a field are solved for together") {
  const auto field = [](const std::string& energy, const std::string& initial) {
    return read(R"x("parameters": { "k": 2, "c": 3 }, "elements": { "a": { "kind": "1" }, "b": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1 }, "s": { "kind": "R", "resistance": 1 },
      "x": { "kind": "CC", "ports": ["u", "v"], "energy": ")x" +
                energy + R"x(", "initial": { )x" + initial + R"x( } } },
      "bonds": [ { "from": "a", "to": "r" }, { "from": "b", "to": "s" }, { "from": "a", "to": "x.u" },
                 { "from": "b", "to": "x.v" } ],
      "outputs": { "f": "r.f" }, "scenes": { "run": { "stop": 1 } })x");
  };
  // E = k u^2/2 + c (u - v)^2/2: e_u = k u + c (u - v), e_v = c (v - u).
  const std::string springs = "k*u.q^2/2 + c*(u.q - v.q)^2/2";
  const RunInputs both = prepare_scene(field(springs, R"("u.e": 4, "v.e": 6)"), "");
  REQUIRE(both.initial.size() == 2);
  CHECK(both.initial[0].value == test::same_to_rounding(5.0));
  CHECK(both.initial[1].value == test::same_to_rounding(7.0));
  // One effort beside a displacement of the other port.
  const RunInputs one = prepare_scene(field(springs, R"("u.q": 1, "v.e": 6)"), "");
  CHECK(one.initial[0].value == 1.0);
  CHECK(one.initial[1].value == test::same_to_rounding(3.0));
  CHECK_THROWS_AS(prepare_scene(field("c*(u.q - v.q)^2/2", R"("u.e": 4, "v.e": 6)"), ""), ModelError);
}
