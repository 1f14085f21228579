// Steady states against closed forms, and what has none.

#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

const std::string kScene = R"x("scenes": { "s": { "stop": 1, "samples": 3 } })x";

std::vector<Equilibrium> steady(const Study& study, const std::string& scene = {},
                                const std::vector<std::string>& set = {}) {
  return equilibria(study.shared_model(), prepare_scene(study.model(), scene, with_parameters(set)));
}

double value(const Equilibrium& found, const std::string& name) {
  for (const LinearVariable& state : found.states)
    if (state.name == name) return state.value;
  throw std::invalid_argument("no state " + name);
}

/// A mass in a double well, e = q^3 - q, with a damper.
std::string double_well(double q) {
  return model_text(R"x("elements": { "v": { "kind": "1" }, "m": { "kind": "I", "inertance": 1 },
    "c": { "kind": "C", "law": "e = q^3 - q", "initial": { "q": )x" +
                    std::to_string(q) +
                    R"x( } }, "d": { "kind": "R", "resistance": 0.3 } },
    "bonds": [ { "from": "v", "to": "m" }, { "from": "v", "to": "c" }, { "from": "v", "to": "d" } ], )x" +
                    kScene);
}

}  // namespace

TEST_CASE("a motor under voltage rests at the speed of its closed form") {
  const std::vector<Equilibrium> found = steady(study_of("models/dc_motor.json"));
  REQUIRE(found.size() == 1);
  CHECK(found[0].stability == Equilibrium::Stability::stable);
  // i = b w/K, V = R i + K w
  const double w = 12.0 / (1.2 * 1e-5 / 0.05 + 0.05);
  CHECK(value(found[0], "rotor.p") == Approx(1e-4 * w).epsilon(1e-13));
  CHECK(value(found[0], "coil.p") == Approx(2.5e-3 * 1e-5 * w / 0.05).epsilon(1e-13));
  CHECK(found[0].residual < 1e-12);
}

TEST_CASE("all three states of a double well are found from any start, with their stability") {
  for (const double start : {0.0, 0.2, -0.7, 3.0}) {
    INFO("start " << start);
    const std::vector<Equilibrium> found = steady(Study::from_text(double_well(start)));
    REQUIRE(found.size() == 3);
    int unstable = 0;
    for (const Equilibrium& each : found) {
      const double q = value(each, "c.q");
      CHECK(value(each, "m.p") == 0.0);
      if (each.stability == Equilibrium::Stability::unstable) {
        ++unstable;
        CHECK(q == Approx(0.0).margin(1e-12));
      } else {
        CHECK(each.stability == Equilibrium::Stability::stable);
        CHECK(std::abs(q) == Approx(1.0).epsilon(1e-12));
      }
    }
    CHECK(unstable == 1);
  }
}

TEST_CASE("a pendulum rests upright or hanging, at an angle of its own turn") {
  for (const Equilibrium& each : steady(study_of("models/pendulum.json"))) {
    const double angle = value(each, "gravity.q");
    CHECK(std::abs(std::sin(angle)) < 1e-9);
    CHECK(std::abs(angle) < 100.0);
    CHECK(value(each, "turning.p") == 0.0);
    CHECK((std::cos(angle) > 0.0) == (each.stability != Equilibrium::Stability::unstable));
  }
}

TEST_CASE("a closed cycle of reactions keeps its sum and says what is free") {
  const Study study = study_of("tests/data/models/reaction_cycle.json");
  const std::vector<Equilibrium> found = steady(study);
  REQUIRE(found.size() == 1);
  // K = 1, 2, 3: at rest the amounts are as 1 : 1/2 : 1/3, and their sum is that of the start.
  const RunInputs inputs = prepare_scene(study.model(), "");
  double sum = 0.0;
  for (const RunInputs::Initial& initial : inputs.initial) sum += initial.value;
  const double x = value(found[0], "X.q");
  CHECK(value(found[0], "Y.q") == Approx(x / 2).epsilon(1e-9));
  CHECK(value(found[0], "Z.q") == Approx(x / 3).epsilon(1e-9));
  CHECK(x * (1.0 + 0.5 + 1.0 / 3) == Approx(sum).epsilon(1e-9));
  CHECK(found[0].free.size() == 3);
}

TEST_CASE("two bodies that exchange heat come to the mean of their energies") {
  const Study study = study_of("tests/data/models/two_bodies.json");
  const std::vector<Equilibrium> found = steady(study);
  const RunInputs inputs = prepare_scene(study.model(), "");
  double sum = 0.0;
  for (const RunInputs::Initial& initial : inputs.initial) sum += initial.value;
  CHECK(value(found[0], "body1.q") == Approx(sum / 2).epsilon(1e-9));
  CHECK(value(found[0], "body2.q") == Approx(sum / 2).epsilon(1e-9));
}

TEST_CASE("what has no steady state is refused with what remains") {
  const auto refusal = [](const std::string& body) {
    try {
      steady(Study::from_text(model_text(body + kScene)));
    } catch (const ModelError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(refusal(R"x("elements": { "s": { "kind": "Se", "effort": 5 }, "m": { "kind": "I", "inertance": 2 } },
    "bonds": [ { "from": "s", "to": "m" } ], )x"),
             Contains("BG412") && Contains("m.p' = 5"));
  CHECK_THAT(refusal(R"x("elements": { "s": { "kind": "Sf", "flow": 2 }, "c": { "kind": "C", "capacitance": 2 } },
    "bonds": [ { "from": "s", "to": "c" } ], )x"),
             Contains("BG412") && Contains("c.q' = 2"));
  CHECK_THAT(refusal(R"x("signals": { "x": { "integral": "m.f" } },
    "elements": { "m": { "kind": "I", "inertance": 2, "initial": { "p": 6 } } , "s": { "kind": "Se", "effort": 0 } },
    "bonds": [ { "from": "s", "to": "m" } ], )x"),
             Contains("BG412") && Contains("x' = 3"));
  // A law without a zero.
  CHECK_THAT(
      refusal(R"x("elements": { "c": { "kind": "C", "capacitance": 1 }, "r": { "kind": "R", "law": "f = exp(e)" } },
    "bonds": [ { "from": "c", "to": "r" } ], )x"),
      Contains("BG412"));
}

TEST_CASE("a store that takes all that flows is seen, where it depends on others and no state moves") {
  const auto refusal = [](const std::string& law, double q, double flow) {
    try {
      steady(Study::from_text(model_text(R"x("elements": { "s": { "kind": "Sf", "flow": )x" + std::to_string(flow) +
                                         R"x( }, "n": { "kind": "0" }, "c1": { "kind": "C", "capacitance": 1 },
      "c2": { "kind": "C", "law": ")x" + law +
                                         R"x(", "initial": { "q": )x" + std::to_string(q) + R"x( } } },
    "bonds": [ { "from": "s", "to": "n" }, { "from": "n", "to": "c1" }, { "from": "n", "to": "c2" } ], )x" +
                                         kScene)));
    } catch (const ModelError& error) {
      return std::string(error.what());
    }
    return std::string("found");
  };
  // The sum of charges grows by the flow. Where charge runs away the state's rate is u/(1 + 3 q^2), which is lost in u.
  CHECK_THAT(refusal("e = q^3", 1.0, 1.0), Contains("BG412") && Contains("c1.q' = 1"));
  // q^2 q' = u, with a fold of the loop at q = 1 and -1, where the charge of the other store has an end.
  for (const double start : {-2.0, 0.5, 2.0})
    for (const double flow : {0.1, 1.0}) {
      INFO("start " << start << ", flow " << flow);
      CHECK_THAT(refusal("e = q^3/3 - q", start, flow), Contains("BG412"));
    }
}

TEST_CASE("dependent stores rest where their sources are held and where loops share their flow") {
  const std::string rc = R"x("elements": { "s": { "kind": "Se", "effort": "5 + sin(t)" }, "j": { "kind": "1" },
      "r": { "kind": "R", "resistance": 2 }, "n": { "kind": "0" }, "c1": { "kind": "C", "law": "e = q^3 + q" },
      "c2": { "kind": "C", "capacitance": 3 }, "r2": { "kind": "R", "resistance": 8 }, "rail": { "kind": "0" },
      "held": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "rail" }, { "from": "rail", "to": "held" }, { "from": "rail", "to": "j" },
      { "from": "j", "to": "r" }, { "from": "j", "to": "n" }, { "from": "n", "to": "c1" }, { "from": "n", "to": "c2" },
      { "from": "n", "to": "r2" } ], )x" +
                         kScene;
  const std::vector<Equilibrium> found = steady(Study::from_text(model_text(rc)));
  REQUIRE(found.size() == 1);
  // 4 V at the node: c2 holds 12, c1 the root of q^3 + q = 4.
  double dependent = 0.0;
  for (const RunInputs::Initial& initial : found[0].values) dependent = std::max(dependent, initial.value);
  CHECK(dependent == Approx(12.0).epsilon(1e-12));
  CHECK(found[0].residual < 1e-12);
}

TEST_CASE("a rate that rounding has left of terms a hundred decades larger is no rest") {
  // p' = 1 + sinh(p) - sinh(p) - ...: nothing of the source's 1 is left beside sinh(260) = 4e112.
  const Study study = study_of("tests/data/models/steady_rounding.json");
  const std::vector<Equilibrium> found = steady(study);
  REQUIRE(found.size() == 1);
  // At rest the resistor takes all of it: m2^2 r2 sinh(p) = u1.
  CHECK(value(found[0], "x0.p") == Approx(std::asinh(1.0 / (0.4608 * 0.4608 * 0.3497))).epsilon(1e-9));
}

TEST_CASE("a point is held against its own terms, not against those of the way to it") {
  // All zero was listed as steady, with a rate of 1 and a residual of 3e-25: the iteration had been where rates are
  // 1e24.
  const Study study = study_of("tests/data/models/steady_far.json");
  const auto check = [](const Equilibrium& each) {
    const double q = value(each, "x2.l.q");
    CHECK(std::abs(q * q * q / 8.0 - 15.0 / 16.0 * q + 1.0) < 1e-9);
    CHECK(value(each, "x2.m.p") == Approx(-q * (1.0 + q * q) / 4.0).epsilon(1e-9));
    CHECK(std::abs(value(each, "x1.l.p")) < 1e-9);
    CHECK(std::abs(value(each, "x1.m.p")) < 1e-9);
  };
  try {
    for (const Equilibrium& each : steady(study, "far")) check(each);
  } catch (const ModelError& error) {
    CHECK_THAT(error.what(), Contains("BG412"));
  }
  const std::vector<Equilibrium> found = steady(study, "found");
  REQUIRE(!found.empty());
  for (const Equilibrium& each : found) check(each);
}

TEST_CASE("a pole of a rate is no rest, nor is a loop without a solution") {
  const auto refusal = [](const std::string& body) {
    try {
      steady(Study::from_text(model_text(body + kScene)));
    } catch (const ModelError& error) {
      return std::string(error.what());
    }
    return std::string("found");
  };
  // q' = -1/(q^2 - 4) falls into q = 2, where the rate is as nothing beside the terms of its denominator over
  // themselves.
  CHECK_THAT(refusal(R"x("elements": { "c": { "kind": "C", "capacitance": 1, "initial": { "q": 3 } },
      "r": { "kind": "R", "law": "f = 1/(e^2 - 4)" } }, "bonds": [ { "from": "c", "to": "r" } ], )x"),
             Contains("BG412"));
  // No state at all: e = 1 + e^2 has no solution, by which the store would hold something.
  CHECK_THAT(
      refusal(R"x("elements": { "s": { "kind": "MSe", "effort": "1 + c.q^2" }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "c" } ], )x"),
      Contains("BG"));
}

TEST_CASE("states that rest at 0 together are 0, where a rate goes with their square") {
  // B' = 0.04 A - 1e4 B C - 3e7 B^2: what the iteration leaves of A and B, some 1e-10, is no rest.
  const std::vector<Equilibrium> found = steady(study_of("models/robertson.json"), "long");
  REQUIRE(!found.empty());
  CHECK(value(found[0], "A.q") == 0.0);
  CHECK(value(found[0], "B.q") == 0.0);
  CHECK(value(found[0], "C.q") == Approx(1.0).epsilon(1e-9));
}

TEST_CASE("what two equal efforts leave of a flow is nothing beside what one would make") {
  // Laws that are solved for the flow as a loop, so that the rate is the loop's variable, with what rounding leaves.
  for (const char* law : {"e = f + f^3", "f = sinh(e)", "f = ssqrt(e, 1e-6)"}) {
    INFO(law);
    const std::vector<Equilibrium> found = steady(Study::from_text(model_text(
        std::string(
            R"x("elements": { "s": { "kind": "Se", "effort": 5 }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 },
      "n": { "kind": "0" }, "c1": { "kind": "C", "capacitance": 0.3 }, "j2": { "kind": "1" }, "d": { "kind": "R", "law": ")x") +
        law + R"x(" }, "n2": { "kind": "0" }, "c2": { "kind": "C", "capacitance": 0.7 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "n" }, { "from": "n", "to": "c1" },
      { "from": "n", "to": "j2" }, { "from": "j2", "to": "d" }, { "from": "j2", "to": "n2" }, { "from": "n2", "to": "c2" } ], )x" +
        kScene)));
    REQUIRE(found.size() == 1);
    CHECK(value(found[0], "c1.q") == Approx(1.5).epsilon(1e-9));
    CHECK(value(found[0], "c2.q") == Approx(3.5).epsilon(1e-9));
  }
}

TEST_CASE("tanks that are empty at the start come to the levels that their orifices hold") {
  // The inflow of 0.7 goes through all of them: each level is higher than the next one by k 0.49. At the start no law
  // has a slope.
  for (const std::string law : {"e = K*f*abs(f)", "f = sign(e)*sqrt(abs(e)/(K))"}) {
    INFO(law);
    std::string elements = R"x("s": { "kind": "Sf", "flow": 0.7 })x", bonds = R"x({ "from": "s", "to": "n0" })x";
    constexpr int kTanks = 6;
    for (int i = 0; i < kTanks; ++i) {
      const std::string k = std::to_string(i);
      std::string own = law;
      own.replace(own.find('K'), 1, std::to_string(i + 1));
      elements += R"x(, "n)x" + k + R"x(": { "kind": "0" }, "c)x" + k +
                  R"x(": { "kind": "C", "capacitance": 2 }, "k)x" + k + R"x(": { "kind": "1" }, "o)x" + k +
                  R"x(": { "kind": "R", "law": ")x" + own + R"x(" })x";
      bonds += R"x(, { "from": "n)x" + k + R"x(", "to": "c)x" + k + R"x(" }, { "from": "n)x" + k + R"x(", "to": "k)x" +
               k + R"x(" }, { "from": "k)x" + k + R"x(", "to": "o)x" + k + R"x(" })x";
      if (i + 1 < kTanks) bonds += R"x(, { "from": "k)x" + k + R"x(", "to": "n)x" + std::to_string(i + 1) + R"x(" })x";
    }
    const std::vector<Equilibrium> found = steady(Study::from_text(
        model_text(R"x("elements": { )x" + elements + R"x( }, "bonds": [ )x" + bonds + R"x( ], )x" + kScene)));
    REQUIRE(found.size() == 1);
    CHECK(found[0].stability == Equilibrium::Stability::stable);
    double level = 0.0;
    for (int i = kTanks; i-- > 0;) {
      level += (i + 1) * 0.49;
      CHECK(value(found[0], "c" + std::to_string(i) + ".q") == Approx(2.0 * level).epsilon(1e-9));
    }
  }
}
