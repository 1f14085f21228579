// What a command reads, and what it writes twice, is not overwritten, by whatever name.
#include <catch2/catch.hpp>
#include <filesystem>

#include "command.hpp"

using Catch::Contains;
namespace fs = std::filesystem;

namespace {

constexpr const char* kTop = R"x({ "bgsim": 1, "name": "top", "types": { "part": "part.json" },
  "elements": { "source": { "kind": "Se", "effort": "table('data.csv', 'u', t)" }, "part": { "kind": "part" } },
  "bonds": [ { "from": "source", "to": "part.in" } ], "outputs": { "q": "part.store.q" }, "scenes": {
  "s": { "stop": 1, "samples": 2, "reference": "ref.csv" }, "s/1": { "stop": 1 }, "s_1": { "stop": 1 } } })x";
constexpr const char* kPart = R"({ "bgsim": 1, "ports": { "in": "line" }, "elements": { "line": { "kind": "1" },
  "drop": { "kind": "R", "resistance": 1 }, "store": { "kind": "C", "capacitance": 1 } },
  "bonds": [ { "from": "line", "to": "drop" }, { "from": "line", "to": "store" } ] })";

void prepare(const Workplace& here) {
  here.write("top.json", kTop);
  here.write("part.json", kPart);
  here.write("data.csv", "t,u\r\n0,1\r\n1,2\r\n");
  here.write("ref.csv", "t,q\r\n0,0\r\n1,0.9\r\n");
  fs::create_symlink("part.json", fs::path(here.folder()) / "soft.csv");
  fs::create_hard_link(fs::path(here.folder()) / "data.csv", fs::path(here.folder()) / "hard.csv");
}

void refused(const Workplace& here, const std::string& arguments, const std::string& why) {
  INFO(arguments);
  const Outcome done = here.bgsim(arguments);
  CHECK(done.code == 2);
  CHECK_THAT(done.err, Contains("cannot write") && Contains(why));
  CHECK(here.read("top.json") == kTop);
  CHECK(here.read("part.json") == kPart);
  CHECK(here.read("data.csv").starts_with("t,u"));
  CHECK(here.read("ref.csv").starts_with("t,q\r\n0,0\r\n"));
}

}  // namespace

TEST_CASE("an output that the command reads is refused, by whatever name") {
  const Workplace here;
  prepare(here);
  const std::string folder = "'" + here.folder() + "/";
  refused(here, "top.json -o top.json", "it is the model itself");
  refused(here, "top.json -o " + folder + "top.json'", "it is the model itself");
  refused(here, "top.json -o ./part.json", "it is a submodel of the model");
  refused(here, "top.json -o soft.csv", "it is a submodel of the model");
  refused(here, "top.json -o data.csv", "it is a data file of the model");
  refused(here, "top.json --report-json hard.csv", "it is a data file of the model");
  refused(here, "top.json -o ref.csv", "it is the reference of scene s");
  fs::copy_file(fs::path(here.folder()) / "data.csv", fs::path(here.folder()) / "data.svg");
  here.write("drawn.json", std::string(kTop).replace(std::string(kTop).find("data.csv"), 8, "data.svg"));
  refused(here, "draw drawn.json -o ../'" + fs::path(here.folder()).filename().string() + "'/data.svg",
          "it is a data file of the model");
  refused(here, "report top.json -o part.json", "it is a submodel of the model");
  refused(here, "reduce top.json -o part.json", "it is a submodel of the model");
  refused(here, "reduce top.json -o r.json --csv data.csv", "it is a data file of the model");
  here.write("x.units.json", kPart);
  here.write("side.json", std::string(kTop).replace(std::string(kTop).find("part.json"), 9, "x.units.json"));
  refused(here, "side.json -o x.csv --units", "it is a submodel of the model");
}

TEST_CASE("an output whose partial file would be one that the command reads is refused") {
  const Workplace here;
  prepare(here);
  here.write("x.csv.partial", kTop);
  refused(here, "x.csv.partial -o x.csv", "it is written by way of \"x.csv.partial\", and of that: it is the model");
  CHECK(here.read("x.csv.partial") == kTop);
  refused(here, "top.json -o y.csv --report-json y.csv.partial", "it is written by way of");
}

TEST_CASE("two outputs with one name are refused") {
  const Workplace here;
  prepare(here);
  refused(here, "top.json -o x.csv --report-json ./x.csv", "would be one file");
  refused(here, "top.json --report-json top.s.csv", "would be one file");
  refused(here, "top.json --units --report-json top.s.units.json", "would be one file");
  refused(here, "reduce top.json -o r.json --csv r.reference.csv", "would be one file");
  refused(here, "reduce top.json -o r.json --csv z --json z", "would be one file");
  fs::create_symlink("t.csv", fs::path(here.folder()) / "t.json");
  refused(here, "trade top.json -o t --no-picture", "would be one file");
  const Outcome schema = here.bgsim("new motor -o model.schema.json --schema");
  CHECK(schema.code == 2);
  CHECK_THAT(schema.err, Contains("would be one file"));
  CHECK_FALSE(here.has("x.csv"));
  CHECK_FALSE(here.has("model.schema.json"));
}

TEST_CASE("plot overwrites no trace and no units that it reads") {
  const Workplace here;
  here.write("a.svg", "t,x\r\n0,1\r\n1,2\r\n");
  here.write("b.csv", "t,x\r\n0,1\r\n1,2\r\n");
  const Outcome itself = here.bgsim("plot a.svg");
  CHECK(itself.code == 2);
  CHECK_THAT(itself.err, Contains("it is the trace itself"));
  const Outcome other = here.bgsim("plot b.csv --against a.svg -o ./a.svg");
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Contains("it is the other trace"));
  CHECK(here.read("a.svg").starts_with("t,x"));
}

TEST_CASE("devices may be named twice, and standard output once") {
  const Workplace here;
  CHECK(here.bgsim("decay.json -o /dev/null --report-json /dev/null").code == 0);
  CHECK(here.bgsim("decay.json -o - --report-json -").code == 2);
  const Outcome both = here.bgsim("decay.json -o - --report-json /dev/stdout", "| cat");
  CHECK(both.out.empty());
  CHECK_THAT(both.err, Contains("would be one file"));
}
