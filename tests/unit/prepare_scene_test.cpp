#include <catch2/catch.hpp>
#include <cmath>

#include "support/reading.hpp"

using namespace bgsim;
using test::line_of;
using test::read;

namespace {

Model model(const std::string& scenes, const std::string& parameters = R"x("a": 2, "b": "a^2", "c": "b + a")x") {
  return read(R"x("parameters": { )x" + parameters + R"x( }, "elements": {
    "s": { "kind": "Se", "effort": "a" }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": "a" },
    "k": { "kind": "C", "capacitance": "b", "initial": { "q": "c" } }, "m": { "kind": "I", "inertance": "b" } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" }, { "from": "j", "to": "k" }, { "from": "j", "to": "m" } ],
    "outputs": { "q": "k.q", "p": "m.p", "P": "s.e*s.f" },
    "scenes": { )x" +
              scenes + " }");
}

std::string fault(const Model& m, const std::string& scene = {}, const SceneOverrides& overrides = {}) {
  try {
    prepare_scene(m, scene, overrides);
  } catch (const ModelError& error) {
    return line_of(error.diagnostics.front(), *error.sources);
  }
  return "none";
}
std::string fault_of(const std::string& scene, const std::vector<std::string>& set = {}) {
  SceneOverrides overrides;
  overrides.set = set;
  return fault(model("\"run\": { " + scene + " }"), {}, overrides);
}

}  // namespace

TEST_CASE("parameters are computed from each other, whatever the order") {
  const RunInputs inputs =
      prepare_scene(model(R"x("run": { "stop": 1 })x", R"x("c": "b + a", "b": "a^2", "a": 2)x"), "");
  CHECK(inputs.scene == "run");
  CHECK(inputs.parameters == std::vector<double>{6.0, 4.0, 2.0});
  REQUIRE(inputs.initial.size() == 1);
  CHECK(inputs.initial[0].value == 6.0);
  CHECK(inputs.output_times.size() == 501);
  CHECK(inputs.outputs == std::vector<std::size_t>{0, 1, 2});
  CHECK(inputs.relative == 1e-6);
}

TEST_CASE("the command line overrides the scene, the scene the model, and what depends on it follows") {
  const Model m = model(R"x("run": { "stop": "c", "parameters": { "a": 3, "c": "2*b" }, "initial": { "m.p": "a" } })x");
  const RunInputs scene = prepare_scene(m, "run");
  CHECK(scene.parameters == std::vector<double>{3.0, 9.0, 18.0});
  CHECK(scene.stop == 18.0);
  SceneOverrides overrides;
  overrides.set = {"a=4", "k.q=-1", "m.p=b/2"};
  overrides.relative = 1e-9;
  overrides.absolute = 1e-12;
  overrides.method = Method::ida;
  const RunInputs inputs = prepare_scene(m, "run", overrides);
  CHECK(inputs.parameters == std::vector<double>{4.0, 16.0, 32.0});
  REQUIRE(inputs.initial.size() == 2);
  CHECK(inputs.initial[0].element == ElementId(3));
  CHECK(inputs.initial[0].value == -1.0);
  CHECK_FALSE(inputs.initial[0].place.has_value());
  CHECK(inputs.initial[1].value == 8.0);
  CHECK(inputs.relative == 1e-9);
  CHECK(inputs.absolute == 1e-12);
  CHECK(inputs.method == Method::ida);
}

TEST_CASE("scenes are found by name, the first one by default") {
  const Model m = model(R"x("one": { "stop": 1 }, "two": { "stop": 2, "outputs": ["P", "q"], "method": "adams" })x");
  CHECK(prepare_scene(m, "").stop == 1.0);
  const RunInputs two = prepare_scene(m, "two");
  CHECK(two.stop == 2.0);
  CHECK(two.outputs == std::vector<std::size_t>{2, 0});
  CHECK(two.method == Method::adams);
  CHECK(fault(m, "tow") == "BG140 there is no scene \"tow\"; did you mean \"two\"? Scenes are one, two");
  CHECK(fault(m, "other") == "BG140 there is no scene \"other\"; scenes are one, two");
}

TEST_CASE("output times include both ends, to the last bit") {
  const auto times = [](const std::string& scene) {
    return prepare_scene(model("\"run\": { " + scene + " }"), "").output_times.list();
  };
  CHECK(times(R"x("stop": 1, "samples": 5)x") == std::vector<double>{0.0, 0.25, 0.5, 0.75, 1.0});
  CHECK(times(R"x("start": -1, "stop": 1, "samples": 3)x") == std::vector<double>{-1.0, 0.0, 1.0});
  CHECK(times(R"x("stop": 12.566370614359172, "samples": 501)x").back() == 12.566370614359172);
  CHECK(times(R"x("stop": 1, "interval": 0.25)x") == std::vector<double>{0.0, 0.25, 0.5, 0.75, 1.0});
  CHECK(times(R"x("stop": 1, "interval": 0.4)x") == std::vector<double>{0.0, 0.4, 0.8, 1.0});
  CHECK(times(R"x("stop": 1, "interval": 5)x") == std::vector<double>{0.0, 1.0});
  CHECK(times(R"x("stop": 1, "interval": 0.1)x").size() == 11);  // 0.1 does not divide 1 in binary; to rounding it does
  CHECK(times(R"x("start": 3, "stop": 3)x") == std::vector<double>{3.0});
  CHECK(times(R"x("start": 3, "stop": 3, "samples": 1)x") == std::vector<double>{3.0});
  CHECK(times(R"x("start": 3, "stop": 3, "interval": 1)x") == std::vector<double>{3.0});
  const auto many = times(R"x("start": 1e6, "stop": 1000001, "samples": 1000001)x");
  CHECK(std::is_sorted(many.begin(), many.end()));
  CHECK(std::adjacent_find(many.begin(), many.end()) == many.end());
}

TEST_CASE("times that make no sense are refused") {
  CHECK_THAT(fault_of(R"x("start": 1, "stop": 0)x"),
             Catch::StartsWith("BG143 [0] the scene \"run\": it stops before it starts; "));
  CHECK_THAT(fault_of(R"x("stop": 1, "samples": 1)x"), Catch::StartsWith("BG144 [1]"));
  CHECK_THAT(fault_of(R"x("start": 2, "stop": 2, "samples": 3)x"),
             Catch::StartsWith("BG144 [3] the scene \"run\": 3 samples are requested, but it stops whe"));
  CHECK_THAT(fault_of(R"x("stop": 1, "interval": "-a")x"),
             Catch::StartsWith("BG144 [\"-a\"] the scene \"run\": \"interval\" must be greater than 0"));
  CHECK_THAT(fault_of(R"x("stop": 1, "interval": 1e-10)x"),
             Catch::StartsWith("BG144 [1e-10] the scene \"run\": more than 1e9 output times are"));
  CHECK_THAT(fault_of(R"x("stop": 1, "samples": 900000000)x"),
             Catch::StartsWith("BG144 [900000000] the scene \"run\": the trace would hold more than"));
  CHECK_THAT(fault_of(R"x("stop": 5e-324)x"),
             Catch::StartsWith("BG144 [5e-324] the scene \"run\": its output times cannot be distinguished "));
  CHECK_THAT(fault_of(R"x("start": 1e16, "stop": 10000000000000002, "samples": 3)x"), Catch::StartsWith("BG144"));
  CHECK_THAT(fault_of(R"x("start": -1.7e308, "stop": 1.7e308)x"), Catch::StartsWith("BG144"));
  CHECK(fault_of(R"x("stop": "1/(a - 2)")x") ==
        "BG142 [\"1/(a - 2)\"] \"stop\" is not a finite number: 1/(a - 2) with a = 2; look for a division by 0, an "
        "overflow, "
        "or a function outside its domain");
}

TEST_CASE("a parameter that is not a number is reported once, with its operands") {
  const Model m = model(R"x("run": { "stop": 1 })x", R"x("a": 0, "b": "log(a)", "c": "b + 1")x");
  try {
    prepare_scene(m, "");
    FAIL("accepted");
  } catch (const ModelError& error) {
    REQUIRE(error.diagnostics.size() == 1);  // c, which follows from b, is not reported
    CHECK_THAT(line_of(error.diagnostics[0], *error.sources),
               Catch::StartsWith("BG142 [\"log(a)\"] the parameter \"b\" is not a finite number: log(a) with a = 0; "));
  }
}

TEST_CASE("the option --set is understood or refused with its text") {
  CHECK(fault_of("\"stop\": 1", {"a"}) ==
        "BG141 --set \"a\" is not of the form NAME=EXPR; write --set a=VALUE, without spaces around =");
  CHECK_THAT(fault_of("\"stop\": 1", {"=3"}), Catch::StartsWith("BG141"));
  CHECK(fault_of("\"stop\": 1", {"k.p=3"}) ==
        "BG141 --set \"k.p=3\": \"k.p\" is not an initial value of the element \"k\"; these can be set: \"b\" or "
        "\"k.q\"");
  CHECK_THAT(fault_of("\"stop\": 1", {"a=2*"}), Catch::StartsWith("BG120 --set \"a=2*\": a numb"));
  CHECK_THAT(fault_of("\"stop\": 1", {"a=d"}), Catch::StartsWith("BG121 --set \"a=d\": unknown name \"d\""));
  CHECK_THAT(fault_of("\"stop\": 1", {"a=2*t"}), Catch::StartsWith("BG141 --set \"a=2*t\": neither t nor "));
  CHECK(fault_of("\"stop\": 1", {"a=1", " a = 3 "}) ==
        "BG141 --set \"a=1\" and --set \" a = 3 \" set the same parameter; keep one of them");
  CHECK(fault_of("\"stop\": 1", {" a = 3 "}) == "none");
  CHECK(
      fault_of("\"stop\": 1", {"a=b"}) ==
      "BG132 parameters depend on each other: a -> b -> a; give one of them a value that does not refer to the others");
}

TEST_CASE("a store of size 0 is refused, and one below 0 is reported, as is a resistance below 0") {
  CHECK_THAT(fault_of("\"stop\": 1", {"b=0"}), Catch::StartsWith("BG145 [\"b\"] the capacitance of \"k\" is 0; leav"));
  SceneOverrides negative;
  negative.set = {"b=-1"};
  const RunInputs unstable = prepare_scene(model(R"x("run": { "stop": 1 })x"), "", negative);
  REQUIRE(unstable.warnings.size() == 2);
  CHECK(unstable.warnings[0].code == "BG180");
  CHECK(unstable.warnings[0].situation == "the capacitance of \"k\" is -1: the store is unstable");
  CHECK(unstable.warnings[1].situation == "the inertance of \"m\" is -1: the store is unstable");
  const Model m = model(R"x("run": { "stop": 1, "parameters": { "a": -2, "b": 1, "c": 1 } })x");
  const RunInputs inputs = prepare_scene(m, "");
  REQUIRE(inputs.warnings.size() == 1);
  CHECK(inputs.warnings[0].code == "BG148");
  CHECK(inputs.warnings[0].situation == "the resistance of \"r\" is -2: the element is active");
}

TEST_CASE("tolerances are positive, whoever gives them") {
  const Model m = model(R"x("run": { "stop": 1, "relative": 1e-8, "absolute": { "k.q": 1e-9 } })x");
  CHECK(prepare_scene(m, "").absolute_by_state.at("k.q") == 1e-9);
  CHECK(prepare_scene(m, "").relative == 1e-8);
  SceneOverrides overrides;
  overrides.relative = 0.0;
  CHECK(fault(m, "", overrides) == "BG146 the relative tolerance must lie between 0 and 1; write 1e-6, say");
  overrides.relative = 1e-3;
  overrides.absolute = std::nan("");
  CHECK_THAT(fault(m, "", overrides), Catch::StartsWith("BG146"));
}

TEST_CASE("a model without scenes has nothing to run") {
  CHECK_THAT(fault(read(R"x("elements": { "j": { "kind": "1" } })x")),
             Catch::StartsWith("BG140 [{] the model \"test\" has no scenes, so there is nothing to run; ad"));
}

TEST_CASE("references are read with their tolerances") {
  const Model m = read_model_text("folder/test.json", test::model_text(R"x("elements": { "j": { "kind": "1" } },
    "outputs": { "f": "j.f" }, "scenes": { "a": { "stop": 1, "reference": "ref/a.csv" },
    "b": { "stop": 1, "reference": { "file": "b.csv", "relative": 1e-4, "absolute": 0.1, "tube": 0.2, "columns": { "f": "flow" } } } })x"));
  CHECK(m.scenes[0].reference->file == "folder/ref/a.csv");
  CHECK(m.scenes[0].reference->relative == 1e-6);
  CHECK(m.scenes[1].reference->tube == 0.2);
  CHECK(m.scenes[1].reference->columns.at("f") == "flow");
  CHECK(
      test::fault(
          R"x("elements": { "j": { "kind": "1" } }, "scenes": { "a": { "stop": 1, "reference": { "fil": "x" } } })x") ==
      "BG111 [\"fil\"] a reference has no key \"fil\"; did you mean \"file\"?");
}

TEST_CASE("many equidistant times cost no memory and are those of the formula") {
  const OutputTimes many = OutputTimes::equidistant(-1.0, 3.0, 1000000001);
  CHECK(many.size() == 1000000001);
  CHECK(many.front() == -1.0);
  CHECK(many[123456789] == -1.0 + 4.0 * (123456789.0 / 1e9));
  CHECK(many.back() == 3.0);
  const OutputTimes multiples = OutputTimes::at_multiples(0.5, 1.0, 0.1, 6);
  CHECK(multiples.list() ==
        std::vector<double>{0.5, 0.5 + 0.1, 0.5 + 0.1 * 2.0, 0.5 + 0.1 * 3.0, 0.5 + 0.1 * 4.0, 1.0});
  CHECK(OutputTimes::equidistant(2.0, 2.0, 1).list() == std::vector<double>{2.0});
  CHECK(OutputTimes().empty());
}

TEST_CASE("output times may be spaced by their logarithms") {
  const auto times = [](const std::string& scene) {
    return prepare_scene(model("\"run\": { " + scene + " }"), "").output_times.list();
  };
  CHECK(times(R"("stop": 1000, "samples": { "log": 7, "from": 1e-3 })") ==
        std::vector<double>{1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 1000.0});
  CHECK(times(R"("start": 0.5, "stop": 8, "samples": { "log": 2 })") == std::vector<double>{0.5, 8.0});
  const std::vector<double> spaced = times(R"("start": "a", "stop": "2^5*a", "samples": { "log": 6 })");
  for (std::size_t i = 0; i < 6; ++i) CHECK(spaced[i] == Approx(std::ldexp(2.0, static_cast<int>(i))).epsilon(1e-15));
  CHECK(fault_of(R"("stop": 1, "samples": { "log": 5 })") ==
        "BG144 [{ \"log\": 5 }] the scene \"run\": logarithmic output times cannot begin at its start; write \"from\": "
        "the first output time, greater than 0");
  CHECK(fault_of(R"("stop": 1, "samples": { "log": 5, "from": "a - 2" })").find("must be greater than 0") !=
        std::string::npos);
  CHECK(fault_of(R"("stop": 1, "samples": { "log": 5, "from": 1 })").find("does not lie between") != std::string::npos);
  CHECK(fault_of(R"("start": 1, "stop": 2, "samples": { "log": 5, "from": 0.5 })").find("does not lie between") !=
        std::string::npos);
  CHECK(fault_of(R"("start": 1, "stop": "1 + 1e-12", "samples": { "log": 100000 })").find("distinguished") !=
        std::string::npos);
  CHECK(fault_of(R"("start": 1, "stop": 2, "samples": { "log": 1 })").substr(0, 5) == "BG144");
  CHECK(test::codes(R"("elements": {}, "scenes": { "r": { "stop": 1, "samples": { "from": 1 } } })").find("BG112") !=
        std::string::npos);
  CHECK(test::codes(R"("elements": {}, "scenes": { "r": { "stop": 1, "samples": { "log": 2.5 } } })").find("BG144") !=
        std::string::npos);
}

TEST_CASE("output times may be listed, with or without start and stop") {
  const auto times = [](const std::string& scene) {
    return prepare_scene(model("\"run\": { " + scene + " }"), "").output_times.list();
  };
  CHECK(times(R"("stop": 1, "times": [0, 0.1, "a/4", 1])") == std::vector<double>{0.0, 0.1, 0.5, 1.0});
  CHECK(times(R"("start": -1, "stop": 1, "times": [0.25])") == std::vector<double>{0.25});
  CHECK(fault_of(R"("stop": 1, "times": [0, 0.5, 0.5])").substr(0, 12) == "BG144 [0.5] ");
  CHECK(fault_of(R"("stop": 1, "times": [0, "a"])").substr(0, 12) == "BG144 [\"a\"] ");
  CHECK(fault_of(R"("start": 1, "stop": 3, "times": [0.5, 2])").substr(0, 12) == "BG144 [0.5] ");
  CHECK(fault_of(R"x("stop": 1, "times": [0.1, "1/(a - 2)"])x").substr(0, 5) == "BG142");
  CHECK(test::codes(R"("elements": {}, "scenes": { "r": { "stop": 1, "times": [] } })").find("BG144") !=
        std::string::npos);
  for (const char* two : {R"("times": [1], "samples": 2)", R"("times": [1], "interval": 2)",
                          R"("samples": { "log": 2, "from": 0.1 }, "interval": 2)"})
    CHECK(test::codes(std::string(R"("elements": {}, "scenes": { "r": { "stop": 1, )") + two + " } }").find("BG144") !=
          std::string::npos);
}
