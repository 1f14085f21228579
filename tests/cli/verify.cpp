// bgsim verify, check, equations and show.
#include <catch2/catch.hpp>

#include "command.hpp"

using Catch::Contains;
using Catch::StartsWith;

namespace {

/// decay.json with R in ohms and C in @p unit, as @p name.
void write_with_unit_of_c(const Workplace& here, const std::string& name, const std::string& unit) {
  std::string model = here.read("decay.json");
  const std::string values = "\"R\": 2, \"C\": 0.5";
  model.replace(model.find(values), values.size(),
                R"("R": { "value": 2, "unit": "Ohm" }, "C": { "value": 0.5, "unit": ")" + unit + "\" }");
  here.write(name, model);
}

}  // namespace

TEST_CASE("verify passes what agrees, shows where and by how much the rest does not, and ends with exit code 1") {
  const Workplace here;
  const Outcome run = here.bgsim("verify decay.json");
  CHECK(run.code == 1);
  CHECK_THAT(run.out, Contains("2 held, 1 missed, 0 without a reference"));
  CHECK_THAT(run.out, Contains("decay                    wrong            q"));
  // With R = 1 instead of 2 the store empties twice as fast; exp(-t) - exp(-2 t) is largest at t = 1 among the
  // reference's times 0, 0.25, 0.5, 1: 0.2386 at 0.5, 0.2325 at 1, 0.1723 at 0.25.
  CHECK_THAT(run.out, Contains("0.239"));
  CHECK_THAT(run.out, Contains("at t = 0.5: q = 0.367"));
  CHECK_THAT(run.out, Contains("the reference has 0.6065306597126334"));
}

TEST_CASE("verify names what it does not compare: outputs without a column, and times after the reference's last") {
  const Workplace here;
  here.write("part.json", R"({ "bgsim": 1, "name": "part", "elements": { "n": { "kind": "0" },
    "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "r": { "kind": "R", "resistance": 1 } },
    "bonds": [ { "from": "n", "to": "c" }, { "from": "n", "to": "r" } ], "outputs": { "q": "c.q", "more": "2*c.q" },
    "scenes": { "run": { "stop": 2, "samples": 3, "reference": { "file": "part.csv" } } } })");
  here.write("part.csv", "t,q\n0,1\n1,0.36787944117144233\n");
  const Outcome run = here.bgsim("verify part.json");
  CAPTURE(run.out, run.err);
  CHECK_THAT(run.out, Contains("output more: no column of the reference, not compared"));
  CHECK_THAT(run.out, Contains("the reference ends at t = 1, the scene at 2"));
}

TEST_CASE("verify without files takes models/*.json of the working folder and lists models without references") {
  const Workplace here;
  CHECK(here.bgsim("verify").code == 2);
  std::string bare = here.read("decay.json");
  for (std::size_t at = bare.find(", \"reference\""); at != std::string::npos; at = bare.find(", \"reference\"")) {
    bare.erase(at, bare.find("}", at) + 1 - at);
  }
  CHECK(std::system(("mkdir '" + here.folder() + "/models'").c_str()) == 0);
  here.write("models/bare.json", bare);
  const Outcome run = here.bgsim("verify");
  CHECK(run.code == 0);
  CHECK_THAT(run.out, Contains("models/bare.json: no scene names a reference"));
  CHECK_THAT(run.out, Contains("0 held, 0 missed, 1 without a reference"));
}

TEST_CASE("verify goes on after a model that cannot be read, and fails") {
  const Workplace here;
  here.write("a.json", "{}");
  const Outcome run = here.bgsim("verify a.json decay.json");
  CHECK(run.code == 1);
  CHECK_THAT(run.err, Contains("a.json:1:"));
  CHECK_THAT(run.out, Contains("2 held, 2 missed"));
}

TEST_CASE("check, equations and show answer on standard output") {
  const Workplace here;
  const auto answer = [&here](const std::string& arguments, const std::string& word) {
    const Outcome run = here.bgsim(arguments);
    CHECK(run.code == 0);
    CHECK(run.err.empty());
    CHECK_THAT(run.out, Contains(word));
    CHECK(run.out.back() == '\n');
  };
  answer("check decay.json", "store");
  answer("equations decay.json", "store.q");
  answer("equations decay.json --latex", "\\");
  for (const char* stage : {"model", "graph", "units", "causality", "equations", "order", "program"}) {
    answer(std::string("show decay.json --stage ") + stage, stage == std::string("program") ? "" : "store");
  }
}

TEST_CASE("check tells units that contradict and ends with code 1, a run warns and goes on") {
  const Workplace here;
  write_with_unit_of_c(here, "henry.json", "H");
  const Outcome check = here.bgsim("check henry.json");
  CHECK(check.code == 1);
  CHECK_THAT(check.err, Contains("error BG161: the resistance of \"drain\""));
  CHECK_THAT(check.err, Contains("the capacitance of \"store\" is C"));
  CHECK_THAT(check.out, Contains("units inferred\n  output e, twice"));
  const Outcome run = here.bgsim("henry.json");
  CHECK(run.code == 0);
  CHECK_THAT(run.err, Contains("warning BG161: ") && Contains("bgsim check henry.json explains them"));
  CHECK_THAT(run.err, Contains("q [C], e, twice ["));
  const Outcome quiet = here.bgsim("decay.json --quiet");
  CHECK(quiet.err.empty());
}

TEST_CASE("a parameter that the command line sets to another unit contradicts as one that a scene sets") {
  const Workplace here;
  write_with_unit_of_c(here, "units.json", "F");
  CHECK(here.bgsim("check units.json --set R=3").code == 0);
  const Outcome check = here.bgsim("check units.json --set R=C");
  CHECK(check.code == 1);
  CHECK_THAT(check.err, Contains("error BG161: parameter \"R\" is in Ohm, but its value C is in F"));
  const Outcome run = here.bgsim("units.json --set R=C");
  CHECK(run.code == 0);
  CHECK_THAT(run.err, Contains("warning BG161: ") && Contains("bgsim check units.json --set R=C explains them"));
}

TEST_CASE("check tells the strokes of a model whose equations are refused") {
  const Workplace here;
  here.write("impulse.json", R"json({
    "bgsim": 1, "name": "impulse",
    "elements": {
      "battery": { "kind": "Se", "effort": "step(t - 1)" },
      "wire": { "kind": "1" },
      "store": { "kind": "C", "capacitance": 1 }
    },
    "bonds": [{ "from": "battery", "to": "wire" }, { "from": "wire", "to": "store" }],
    "scenes": { "on": { "stop": 2, "samples": 3 } }
  })json");
  const Outcome run = here.bgsim("check impulse.json");
  CHECK(run.code == 1);
  CHECK_THAT(run.out, Contains("b2: wire --->| store"));
  CHECK_THAT(run.out, Contains("dependent stores"));
  CHECK_THAT(run.err, Contains("error BG402"));
}
