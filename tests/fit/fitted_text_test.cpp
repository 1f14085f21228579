// The model with the fitted values in it: all else byte for byte.
#include <catch2/catch.hpp>

#include "fit_support.hpp"
#include "support/files.hpp"

using namespace bgsim;
using namespace bgsim::test;
using Catch::Matchers::Contains;

namespace {

std::string written(const std::string& model, const std::vector<std::pair<std::string, double>>& values,
                    const SceneOverrides& overrides = {}, const std::vector<std::string>& scenes = {""}) {
  const Study study = Study::from_text(model);
  FitPlan plan;
  for (const std::string& scene : scenes)
    plan.data.push_back(measured(
        {0.0}, [](double) { return 0.0; }, scene));
  FitResult result;
  for (const auto& [name, value] : values) {
    result.values.emplace_back();
    result.values.back().name = name;
    result.values.back().value = value;
  }
  return fitted_text(study, plan, result, overrides);
}

/// @p text with the one @p from replaced.
std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

const char* const kModel = R"({ "bgsim": 1, "name": "m",
	"parameters": { "R":2.00,  "C": { "unit": "F", "value": "1/2" }, "tau": "R*C" },
  "elements": { "r": { "kind": "R", "resistance": "R" }, "c": { "kind": "C", "capacitance": "C", "initial": { "q": 1 } },
     "d": { "kind": "C", "capacitance": "tau" }, "one": { "kind": "1" } },
  "bonds": [ { "from": "c", "to": "one" }, { "from": "one", "to": "r" }, { "from": "one", "to": "d" } ],
  "outputs": { "u": "c.e" },
  "scenes": {
    "a": { "stop": 1 },
    "b": { "about": "a \"quoted\" { brace", "parameters": { "R": 7 }, "stop": 1 } , "c" : { "initial":{}, "stop": 1 } } }
)";

}  // namespace

TEST_CASE("fitted values replace the numbers where these stand, and nothing else changes") {
  const std::string model = kModel;
  CHECK(written(model, {{"R", 2.5}}) == with(model, "2.00", "2.5"));
  CHECK(written(model, {{"C", 1e-7}}) == with(model, "\"1/2\"", "1e-07"));
  CHECK(written(model, {{"R", 0.1}, {"c.q", -3}}) == with(with(model, "2.00", "0.1"), "\"q\": 1", "\"q\": -3"));
  // What a scene gives is what is fitted there.
  CHECK(written(model, {{"R", 2.5}}, {}, {"b"}) == with(model, "\"R\": 7", "\"R\": 2.5"));
  // Two scenes, of which one gives its own.
  CHECK(written(model, {{"R", 2.5}}, {}, {"a", "b"}) == with(with(model, "2.00", "2.5"), "\"R\": 7", "\"R\": 2.5"));
}

TEST_CASE("values that the file does not have yet are written into the scenes of the fit") {
  const std::string model = kModel;
  CHECK(written(model, {{"d.q", 4}}) == with(model, "\"a\": {", "\"a\": { \"initial\": { \"d.q\": 4 },"));
  CHECK(written(model, {{"d.q", 4}}, {}, {"c"}) == with(model, "\"initial\":{", "\"initial\":{ \"d.q\": 4"));
  CHECK(written(model, {{"C", 4}, {"d.e", 1}}, {}, {"b"}) ==
        with(with(model, "\"1/2\"", "4"), "\"b\": {", "\"b\": { \"initial\": { \"d.e\": 1 },"));
  // An effort in the place of a charge that the element gives.
  CHECK_THAT(written(model, {{"c.e", 6}}), Contains("\"initial\": { \"c.e\": 6 }"));
  // In the place of the one that the scene gives.
  const std::string by_effort = with(model, "\"a\": {", "\"a\": { \"initial\": { \"c.e\": 0.5 },");
  CHECK(written(by_effort, {{"c.q", 4}}) == with(model, "\"a\": {", "\"a\": { \"initial\": { \"c.q\": 4 },"));
  const std::string by_charge = with(model, "\"a\": {", "\"a\": { \"initial\": { \"c.q\" : 0.5 , \"d.q\": 1 },");
  CHECK(written(by_charge, {{"c.e", 4}}) ==
        with(model, "\"a\": {", "\"a\": { \"initial\": { \"c.e\": 4 , \"d.q\": 1 },"));
}

TEST_CASE("what --set gave is written with the fit, and a computed parameter becomes a number") {
  const std::string model = kModel;
  CHECK(written(model, {{"R", 2.5}}, with_parameters({"C=3"})) == with(with(model, "2.00", "2.5"), "\"1/2\"", "3"));
  CHECK(written(model, {{"tau", 9}}) == with(model, "\"R*C\"", "9"));
  CHECK(written(model, {{"R", 2.5}}, with_parameters({"tau=2*R"})) == with(with(model, "2.00", "2.5"), "\"R*C\"", "5"));
}

TEST_CASE("a number that two scenes share and need different is written into both") {
  const std::string model = kModel;
  CHECK(written(model, {{"C", 4}}, with_parameters({"tau=2*R"}), {"a", "b"}) ==
        with(with(model, "\"a\": {", "\"a\": { \"parameters\": { \"tau\": 4, \"C\": 4 },"), "{ \"R\": 7",
             "{ \"tau\": 14, \"C\": 4, \"R\": 7"));
}

TEST_CASE("values that the file would not give back are not written") {
  CHECK_THROWS_WITH(written(kModel, {{"R", 4}}, with_parameters({"c.q=3*C"})), Contains("BG421"));
}

TEST_CASE("parameters of a submodel are written into the scene of the model, not into the submodel") {
  const TemporaryFolder here;
  here.write("part.json", R"({ "bgsim": 1, "name": "part", "parameters": { "k": 1 }, "ports": { "p": "p" },
    "elements": { "p": { "kind": "0" }, "s": { "kind": "C", "capacitance": "1/k" } }, "bonds": [ { "from": "p", "to": "s" } ] })");
  here.write("whole.json", R"({ "bgsim": 1, "name": "whole", "types": { "part": "part.json" },
    "elements": { "x": { "kind": "part" }, "y": { "kind": "part" }, "r": { "kind": "R", "resistance": 1 },
      "one": { "kind": "1" } },
    "bonds": [ { "from": "x.p", "to": "one" }, { "from": "one", "to": "r" }, { "from": "one", "to": "y.p" } ],
    "outputs": { "u": "r.e" }, "scenes": { "s": { "stop": 1 } } })");
  const std::string file = (here.path() / "whole.json").string();
  const Study study(file);
  FitPlan plan;
  plan.data.push_back(measured({0.0}, [](double) { return 0.0; }));
  FitResult result;
  result.values.emplace_back();
  result.values.back().name = "x.k";
  result.values.back().value = 5.0;
  CHECK(fitted_text(study, plan, result) ==
        with(here.read("whole.json"), "\"s\": {", "\"s\": { \"parameters\": { \"x.k\": 5 },"));
  // In another folder there is no part.json.
  here.write("other/readme", "");
  CHECK_THROWS_WITH(fitted_text(study, plan, result, {}, {}, (here.path() / "other/whole.json").string()),
                    Contains("BG421") && Contains("part.json"));
}
