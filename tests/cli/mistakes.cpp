// Command lines with a mistake in them: what is meant is named.
#include <catch2/catch.hpp>

#include "command.hpp"

namespace {

constexpr const char* kModel = R"({
  "bgsim": 1,
  "name": "cart",
  "parameters": { "m": { "value": 2, "unit": "kg" }, "k": 100, "b": 0.5 },
  "elements": {
    "force":  { "kind": "Se", "effort": 1 },
    "body":   { "kind": "1" },
    "mass":   { "kind": "I", "inertance": "m" },
    "spring": { "kind": "C", "law": "e = k*q" },
    "damper": { "kind": "R", "resistance": "b" }
  },
  "bonds": [
    { "from": "force", "to": "body" },
    { "from": "body", "to": "mass" },
    { "from": "body", "to": "spring" },
    { "from": "body", "to": "damper" }
  ],
  "outputs": { "v": "body.f" },
  "scenes": { "run": { "stop": 1, "samples": 11 }, "pull": { "stop": 1, "samples": 11 } }
})";

/// The model with one piece of its text replaced.
std::string with(const std::string& piece, const std::string& other) {
  std::string text = kModel;
  const auto at = text.find(piece);
  REQUIRE(at != std::string::npos);
  return text.replace(at, piece.size(), other);
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a word that is neither a command nor a file gets the nearest command and the list") {
  const Workplace place;
  place.write("cart.json", kModel);
  for (const char* line : {"chek cart.json", "chek"}) {
    const Outcome wrong = place.bgsim(line);
    CHECK(wrong.code == 2);
    CHECK(has(wrong.err, "\"chek\" is neither a command nor a file\ndid you mean check?\ncommands: run check "));
  }
  CHECK(has(place.bgsim("simulate cart.json").err, "bgsim run simulates"));
  CHECK(has(place.bgsim("help").err, "bgsim --help"));
  CHECK(has(place.bgsim("cart").err, "did you mean cart.json?"));
  CHECK(has(place.bgsim("zzzzzz cart.json").err, "commands: run check "));
}

TEST_CASE("a file that is not there gets the nearest one of its folder") {
  const Workplace place;
  place.write("cart.json", kModel);
  CHECK(has(place.bgsim("crat.json").err, "did you mean \"cart.json\"?"));
  CHECK(has(place.bgsim("check ./crat.json").err, "did you mean \"./cart.json\"?"));
  CHECK(has(place.bgsim("nowhere/cart.json").err, "there is no folder \"nowhere\""));
}

TEST_CASE("a wrong option gets the nearest one, or what says the same here") {
  const Workplace place;
  place.write("cart.json", kModel);
  const auto err = [&](const std::string& line) {
    const Outcome outcome = place.bgsim(line);
    CHECK(outcome.code == 2);
    return outcome.err;
  };
  CHECK(has(err("cart.json --realtive 1e-3"), "has no option --realtive\ndid you mean --relative?"));
  CHECK(has(err("cart.json --realtive=1e-3"), "did you mean --relative?"));
  CHECK(has(err("cart.json -scene run"), "did you mean --scene?"));
  CHECK(has(err("cart.json --tolerance 1e-3"), "it is called --relative"));
  CHECK(has(err("check cart.json --zzzz"), "bgsim check has no option --zzzz\noptions: "));
  CHECK(has(err("cart.json --scene run --scene pull"), "--scene is given twice"));
  CHECK(has(err("cart.json --scene"), "--scene needs a value: --scene NAME"));
  CHECK(has(err("cart.json k=3"), "write --set k=3"));
  CHECK(has(err("cart.json --set k = 3"), "without spaces"));
  CHECK(has(err("cart.json other.json"), "one file at a time"));
  CHECK(has(err("cart.json --method bdff"), "did you mean bdf?"));
  CHECK(has(err("cart.json --method BDF"), "did you mean bdf?"));
  CHECK(has(err("cart.json --max-steps 0"), "0 is not a number above zero"));
  CHECK(has(err("draw"), "which model? bgsim draw model.json"));
}

TEST_CASE("a run names its dependent stores") {
  const Workplace place;
  place.write("cart.json",
              with(R"("damper": { "kind": "R", "resistance": "b" })", R"("damper": { "kind": "I", "inertance": 3 })"));
  const Outcome run = place.bgsim("cart.json");
  CHECK(run.code == 0);
  CHECK(
      has(run.err,
          "dependent stores (derivative causality), without states of their own: damper.p is determined by \"mass\""));
  CHECK(has(run.err, "see bgsim check cart.json"));
  place.write("cart.json", kModel);
  CHECK_FALSE(has(place.bgsim("cart.json").err, "dependent"));
}

TEST_CASE("run, check and draw say that a graph falls into parts, unless signals connect these") {
  const Workplace place;
  const std::string parts = with(R"({ "from": "body", "to": "damper" })", R"({ "from": "force2", "to": "damper" })");
  std::string text = parts;
  text.replace(text.find(R"("body":   {)"), 0, R"("force2": { "kind": "Se", "effort": 1 }, )");
  place.write("parts.json", text);
  for (const char* line : {"parts.json --quiet", "check parts.json", "draw parts.json"}) {
    const Outcome outcome = place.bgsim(line);
    INFO(line);
    CHECK(outcome.code == 0);
    CHECK(has(outcome.err, "warning BG206: the graph falls into 2 parts"));
    CHECK(has(outcome.err, "a part: \"force2\", \"damper\""));
  }
  text.replace(text.find(R"("kind": "Se", "effort": 1 }, )"), 27, R"("kind": "MSe", "effort": "spring.e" })");
  place.write("parts.json", text);
  CHECK(place.bgsim("check parts.json").err.empty());
}

TEST_CASE("a negative stiffness runs with a warning and grows as the exact solution does") {
  const Workplace place;
  std::string text = with(R"("spring": { "kind": "C", "law": "e = k*q" })",
                          R"("spring": { "kind": "C", "capacitance": "-1/k", "initial": { "q": 1 } })");
  text.replace(text.find(R"("effort": 1)"), 11, R"("effort": 0)");
  text.replace(text.find(R"("b": 0.5)"), 8, R"("b": 0.0)");
  text.replace(text.find(R"("v": "body.f")"), 13, R"x("v": "spring.q/cosh(sqrt(k/m)*t)")x");
  place.write("pendulum.json", text);
  const Outcome run = place.bgsim("pendulum.json -o - --relative 1e-8");
  CHECK(run.code == 0);
  CHECK(has(run.err, "warning BG180: the capacitance of \"spring\" is -0.01: the store is unstable"));
  CHECK_FALSE(has(run.err, "energy balance is off"));
  // q = cosh(sqrt(k/m) t) for a start from rest; errors of 1e-8 a step grow as the solution does, some hundred steps.
  const double last = std::stod(run.out.substr(run.out.rfind(',') + 1));
  CHECK(last == Approx(1.0).epsilon(1e-5));
}

TEST_CASE("parameters of a scene that depend on each other are an error in the model, those of --set wrong usage") {
  const Workplace here;
  here.write("circle.json", R"({ "bgsim": 1, "name": "circle", "parameters": { "a": 1, "b": 2 },
    "elements": { "s": { "kind": "Se", "effort": "a" }, "r": { "kind": "R", "resistance": "b" } },
    "bonds": [ { "from": "s", "to": "r" } ], "outputs": { "f": "r.f" },
    "scenes": { "run": { "stop": 1, "parameters": { "a": "b", "b": "a" } }, "plain": { "stop": 1 },
      "half": { "stop": 1, "parameters": { "a": "b" } } } })");
  const Outcome scene = here.bgsim("circle.json -o -");
  CHECK(scene.code == 1);
  CHECK_THAT(scene.err, Catch::Contains("BG132: parameters depend on each other: a -> b -> a"));
  CHECK(here.bgsim("circle.json --scene plain --set a=b --set b=a -o -").code == 2);
  CHECK(here.bgsim("circle.json --scene half --set b=a -o -").code == 2);
}

TEST_CASE("a value of --set that leaves out what has no value everywhere is used with a warning") {
  const Workplace here;
  const Outcome run = here.bgsim("decay.json --set 'R=0*log(C - 1) + 2' -o -");
  CHECK(run.code == 0);
  CHECK_THAT(run.err,
             Catch::Contains("BG128: --set \"R=0*log(C - 1) + 2\": this is taken as 0, also where log(C - 1) has "
                             "no value"));
  CHECK_THAT(here.bgsim("decay.json --set R=4/2 -o -").err, !Catch::Contains("BG128"));
}
