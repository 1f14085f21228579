#include <catch2/catch.hpp>

#include "support/reading.hpp"

using namespace bgsim;

namespace {

/// A folder of model files.
class Folder {
 public:
  void write(const std::string& name, const std::string& body) const { files_.write(name, test::model_text(body)); }
  Model read(const std::string& name) const { return read_model((files_.path() / name).string()); }
  [[nodiscard]] std::string fault(const std::string& name) const {
    try {
      read(name);
    } catch (const ModelError& error) {
      return test::line_of(error.diagnostics.front(), *error.sources);
    }
    return "none";
  }

 private:
  test::TemporaryFolder files_;
};

const char* const kPart =
    R"x("parameters": { "k": 2, "k2": "2*k" }, "signals": { "u": "k*t" }, "ports": { "end": "wall" },
  "elements": { "wall": { "kind": "1" }, "spring": { "kind": "C", "capacitance": "1/k2" }, "pull": { "kind": "Se", "effort": "u" } },
  "bonds": [ { "from": "wall", "to": "spring" }, { "from": "pull", "to": "wall", "name": "pulling" } ],
  "outputs": { "q": "spring.q" }, "scenes": { "alone": { "stop": 1 } })x";

std::string text_of(const Model& model, ExprId e) {
  return to_text(model.pool, e, [&](SymbolId s) { return symbol_name(model, s); });
}

template <class T>
std::vector<std::string> names(const std::vector<T>& items) {
  std::vector<std::string> result;
  for (const T& item : items) result.push_back(item.name);
  return result;
}

}  // namespace

TEST_CASE("a submodel is unfolded in place of its element, with its names prefixed") {
  Folder folder;
  folder.write("parts/part.json", kPart);
  folder.write("whole.json", R"x("parameters": { "k": 7 }, "types": { "half": "parts/part.json" }, "elements": {
    "first": { "kind": "1" }, "left": { "kind": "half", "parameters": { "k": "k/2" }, "signals": { "u": "first.f" } },
    "right": { "kind": "half" }, "last": { "kind": "0" } },
    "bonds": [ { "from": "first", "to": "last" }, { "from": "left.end", "to": "last" }, { "from": "last", "to": "right.end" } ],
    "outputs": { "q": "left.spring.q", "f": "right.end.f", "P": "left.pulling.e*left.b1.f" },
    "scenes": { "run": { "stop": 1, "parameters": { "right.k": "left.k" }, "initial": { "left.spring.q": "left.k2" } } })x");
  // "pull" is a plain Se; with a signal of a state it would have to be an MSe.
  CHECK_THAT(folder.fault("whole.json"), Catch::StartsWith("BG118 [\"u\"] the Se \"pull\" is modulated by \"u\""));
  std::string part = kPart;
  part.replace(part.find("\"Se\""), 4, "\"MSe\"");
  folder.write("parts/part.json", part);
  const Model m = folder.read("whole.json");
  CHECK(names(m.elements) == std::vector<std::string>{"first", "left.wall", "left.spring", "left.pull", "right.wall",
                                                      "right.spring", "right.pull", "last"});
  CHECK(names(m.parameters) == std::vector<std::string>{"k", "left.k", "left.k2", "right.k", "right.k2"});
  CHECK(m.parameters[1].scope == "left.");
  CHECK(names(m.bonds) ==
        std::vector<std::string>{"left.b1", "left.pulling", "right.b1", "right.pulling", "b1", "b2", "b3"});
  CHECK(text_of(m, m.parameters[1].value) == "k/2");
  CHECK(text_of(m, m.parameters[2].value) == "2*left.k");
  CHECK(text_of(m, m.signals[0].value) == "first.f");
  CHECK(text_of(m, m.signals[1].value) == "right.k*t");
  CHECK(text_of(m, m.outputs[1].value) == "right.wall.f");
  CHECK(text_of(m, m.outputs[2].value) == "left.pulling.e*left.b1.f");
  CHECK(m.bonds[5].from.element == ElementId(1));
  CHECK(names(m.scenes) == std::vector<std::string>{"run"});
  const RunInputs inputs = prepare_scene(m, "");
  CHECK(inputs.parameters == std::vector<double>{7.0, 3.5, 7.0, 3.5, 7.0});
  REQUIRE(inputs.initial.size() == 1);
  CHECK(inputs.initial[0].value == 7.0);
  CHECK(inputs.initial[0].element == ElementId(2));
}

TEST_CASE("a submodel knows its own names only, and shows only its ports") {
  Folder folder;
  std::string part = kPart;
  part.replace(part.find("k*t"), 3, "outer*t");
  folder.write("part.json", part);
  const std::string whole = R"x("parameters": { "outer": 7 }, "types": { "half": "part.json" }, "elements": {
    "j": { "kind": "0" }, "left": { "kind": "half" }, "right": { "kind": "half" } }, "bonds": [ { "from": "j", "to": ")x";
  folder.write("whole.json", whole + "left.end\" } ]");
  CHECK(folder.fault("whole.json") ==
        "BG121 [outer] unknown name \"outer\"; declare it among \"parameters\" or \"signals\"");
  folder.write("part.json", kPart);
  CHECK(folder.fault("whole.json") == "none");
  folder.write("whole.json", whole + "left.wall\" } ]");
  CHECK(folder.fault("whole.json") ==
        "BG131 [\"left.wall\"] the submodel \"left\" has no port \"wall\"; it has \"left.end\"");
  folder.write("whole.json", whole + "left.ned\" } ]");
  CHECK(folder.fault("whole.json") ==
        "BG131 [\"left.ned\"] the submodel \"left\" has no port \"ned\"; did you mean \"left.end\"?");
}

TEST_CASE("a fault in a submodel that is used twice is reported once") {
  Folder folder;
  std::string part = kPart;
  part.replace(part.find("\"1/k2\""), 6, "\"1/k3\"");
  folder.write("part.json", part);
  folder.write(
      "whole.json",
      R"x("types": { "half": "part.json" }, "elements": { "a": { "kind": "half" }, "b": { "kind": "half" } })x");
  try {
    folder.read("whole.json");
    FAIL("accepted");
  } catch (const ModelError& error) {
    CHECK(error.diagnostics.size() == 1);
    CHECK(render(error).find("part.json:2:") != std::string::npos);
  }
}

TEST_CASE("ports can be passed on from inner submodels") {
  Folder folder;
  folder.write("part.json", kPart);
  folder.write(
      "middle.json",
      R"x("types": { "part": "part.json" }, "ports": { "out": "inner.end" }, "elements": { "inner": { "kind": "part" } })x");
  folder.write(
      "whole.json",
      R"x("types": { "middle": "middle.json" }, "elements": { "j": { "kind": "0" }, "m": { "kind": "middle" } },
    "bonds": [ { "from": "j", "to": "m.out" } ], "outputs": { "f": "m.out.f", "q": "m.inner.spring.q" })x");
  const Model m = folder.read("whole.json");
  CHECK(m.elements[m.bonds.back().to.element.index()].name == "m.inner.wall");
  CHECK(text_of(m, m.outputs[0].value) == "m.inner.wall.f");
}

TEST_CASE("submodels nest three hundred files deep") {
  Folder folder;
  folder.write("p0.json", R"x("ports": { "end": "wall" }, "elements": { "wall": { "kind": "1" } })x");
  for (int i = 1; i < 300; ++i)
    folder.write("p" + std::to_string(i) + ".json",
                 R"x("types": { "p": "p)x" + std::to_string(i - 1) +
                     R"x(.json" }, "ports": { "end": "x.end" }, "elements": { "x": { "kind": "p" } })x");
  CHECK(folder.read("p299.json").elements.back().name.size() == 2 * 299 + 4);
}

TEST_CASE("submodels in a circle are named along it") {
  Folder folder;
  folder.write("a.json", R"x("types": { "b": "b.json" }, "elements": { "x": { "kind": "b" } })x");
  folder.write("b.json", R"x("types": { "c": "sub/c.json" }, "elements": { "y": { "kind": "c" } })x");
  folder.write("sub/c.json", R"x("types": { "b": "../b.json" }, "elements": { "z": { "kind": "b" } })x");
  const std::string fault = folder.fault("a.json");
  CHECK_THAT(fault, Catch::StartsWith("BG133 [\"../b.json\"] a submodel contains itself: " + fault.substr(48, 6)));
  CHECK(fault.find("b.json -> ") != std::string::npos);
  CHECK(fault.find("c.json -> ") != std::string::npos);
  CHECK(fault.find("a.json") == std::string::npos);  // leads to the circle, is not part of it
}

TEST_CASE("submodels that double level by level are refused before they are unfolded") {
  Folder folder;
  folder.write("p0.json", R"x("elements": { "a": { "kind": "1" }, "b": { "kind": "1" } })x");
  for (int i = 1; i < 2000; ++i)
    folder.write("p" + std::to_string(i) + ".json",
                 R"x("types": { "p": "p)x" + std::to_string(i - 1) +
                     R"x(.json" }, "elements": { "a": { "kind": "p" }, "b": { "kind": "p" } })x");
  CHECK(folder.fault("p10.json") == "none");
  CHECK_THAT(folder.fault("p1999.json"), Catch::StartsWith("BG137 [\"elements\"] the model has more than 10 million"));
}

TEST_CASE("types are checked: names, files, kinds") {
  Folder folder;
  folder.write("part.json", kPart);
  const auto whole = [&](const std::string& types, const std::string& kind) {
    folder.write("whole.json", "\"types\": " + types + R"x(, "elements": { "x": { "kind": ")x" + kind + "\" } }");
    return folder.fault("whole.json");
  };
  CHECK_THAT(whole(R"x({ "R": "part.json", "p": "part.json" })x", "p"),
             Catch::StartsWith("BG115 [\"R\"] \"R\" cannot be the name of a submodel: it is a kind"));
  CHECK(whole(R"x({ "part": "part.json" })x", "prat") ==
        "BG114 [\"prat\"] there is no kind of element \"prat\"; did you mean \"part\"?");
  CHECK_THAT(whole(R"x({ "part": 3 })x", "part"), Catch::StartsWith("BG113 [3]"));
  CHECK(whole(R"x({ "part": "." })x", "part").find("it is a folder") != std::string::npos);
  CHECK_THAT(whole(R"x([])x", "part"), Catch::StartsWith("BG113 [[]]"));
}

TEST_CASE("a fault in the JSON of a submodel is shown in that file") {
  Folder folder;
  folder.write("part.json", "\"x\": 1,");
  folder.write("whole.json", R"x("types": { "p": "part.json" }, "elements": { "x": { "kind": "p" } })x");
  try {
    folder.read("whole.json");
    FAIL("accepted");
  } catch (const ModelError& error) {
    REQUIRE(error.diagnostics.size() == 1);
    CHECK(render(error).find("part.json:1:37: error BG101") != std::string::npos);
  }
}

TEST_CASE("measured data are read beside the file that names them, once for each use") {
  Folder folder;
  folder.write(
      "sub/part.json",
      R"x("signals": { "u": "table('u.csv', 'u', t) + table('u.csv', 'v', t, spline)", "w": "table('u.csv', 'u', 2*t)"
},
    "elements": { "s": { "kind": "1" } })x");
  folder.write("whole.json",
               R"x("types": { "p": "sub/part.json" }, "elements": { "x": { "kind": "p" }, "y": { "kind": "p" } })x");
  CHECK(folder.fault("whole.json").find("cannot read the data file") != std::string::npos);
  folder.write("sub/u.csv", "");
  CHECK(folder.fault("whole.json").find("BG127 [u.csv]") == 0);
}

TEST_CASE("a submodel is repeated: each copy has its own parameters and signals, and bonds at its ports") {
  Folder folder;
  std::string part = kPart;
  part.replace(part.find("\"Se\""), 4, "\"MSe\"");
  folder.write("part.json", part);
  const std::string whole = R"x("parameters": { "k": 7 }, "types": { "part": "part.json" }, "elements": {
      "cell": { "kind": "part", "repeat": 3, "parameters": { "k": "k + i" }, "signals": { "u": "i*cell[4-i].wall.f" } },
      "mass": { "kind": "I", "repeat": 3, "inertance": 1 } },
    "bonds": [ { "from": "cell[i].end", "to": "mass[i]" } ])x";
  folder.write("whole.json", whole);
  const Model model = folder.read("whole.json");
  CHECK(names(model.parameters) ==
        std::vector<std::string>{"k", "cell[1].k", "cell[1].k2", "cell[2].k", "cell[2].k2", "cell[3].k", "cell[3].k2"});
  CHECK(text_of(model, model.parameters[5].value) == "k + 3");
  CHECK(text_of(model, model.parameters[6].value) == "2*cell[3].k");
  CHECK(names(model.signals) == std::vector<std::string>{"cell[1].u", "cell[2].u", "cell[3].u"});
  CHECK(text_of(model, model.signals[1].value) == "2*cell[2].wall.f");
  CHECK(text_of(model, model.signals[2].value) == "3*cell[1].wall.f");
  CHECK(model.elements[model.bonds[8].from.element.index()].name == "cell[3].wall");
  // Inside, a submodel knows no index of its copy.
  part.replace(part.find("k*t"), 3, "i*t");
  folder.write("part.json", part);
  folder.write("plain.json",
               R"x("types": { "part": "part.json" }, "elements": { "cell": { "kind": "part", "repeat": 3 } })x");
  CHECK(folder.fault("plain.json").starts_with("BG121 [i]"));
  // What is at fault in a repeated element of each copy is said once, and its names are not missed.
  folder.write("part.json", R"x("elements": { "c": { "kind": "C", "repeat": 0, "capacitance": 1 } })x");
  folder.write("plain.json",
               R"x("types": { "part": "part.json" }, "elements": { "cell": { "kind": "part", "repeat": 3 } },
    "outputs": { "u": "cell[2].c[1].e" })x");
  CHECK(folder.fault("plain.json").starts_with("BG139 [0]"));
}
