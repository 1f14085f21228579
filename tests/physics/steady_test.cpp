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
