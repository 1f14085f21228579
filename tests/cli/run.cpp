// The command line's fixed part: where the trace goes, what is said where, and exit codes.
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "bgsim/csv.hpp"
#include "command.hpp"

using Catch::Contains;
using Catch::StartsWith;

TEST_CASE("a run writes NAME.SCENE.csv into the working folder and says so on standard error") {
  const Workplace here;
  const Outcome run = here.bgsim("decay.json");
  CHECK(run.code == 0);
  CHECK(run.out.empty());
  CHECK_THAT(run.err, Contains("trace: decay.first.csv (3 times, 2 columns)"));
  const auto table = bgsim::parse_csv(here.read("decay.first.csv"));
  CHECK(table.names == std::vector<std::string>{"t", "q", "e, twice"});
  CHECK(table.columns[0] == std::vector<double>{0.0, 0.5, 1.0});
  // 1e-5: an order above the default relative tolerance, for the error that builds up over the steps
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(table.columns[1][i] == Approx(std::exp(-table.columns[0][i])).epsilon(1e-5));
    CHECK(table.columns[2][i] == Approx(4.0 * std::exp(-table.columns[0][i])).epsilon(1e-5));
  }
}

TEST_CASE("another scene is picked by --scene, with its own outputs and times") {
  const Workplace here;
  CHECK(here.bgsim("decay.json --scene longer").code == 0);
  const auto table = bgsim::parse_csv(here.read("decay.longer.csv"));
  CHECK(table.names == std::vector<std::string>{"t", "q"});
  CHECK(table.columns[0] == std::vector<double>{0.0, 0.5, 1.0, 1.5, 2.0});
}

TEST_CASE("what a file name cannot hold becomes an underscore") {
  const Workplace here;
  std::string model = here.read("decay.json");
  const std::string name = "\"decay\"";
  here.write("named.json", model.replace(model.find(name), name.size(), "\"../to/decay\""));
  CHECK(here.bgsim("named.json").code == 0);
  CHECK(here.has("_._to_decay.first.csv"));
}

TEST_CASE("parameters and initial values are changed by --set, several at once, expressions among them") {
  const Workplace here;
  const Outcome run = here.bgsim("decay.json --set 'R=4*C' --set C=1 --set store.q=3 -o out.csv");
  CHECK(run.code == 0);
  const auto table = bgsim::parse_csv(here.read("out.csv"));
  CHECK(table.columns[1].front() == 3.0);
  CHECK(table.columns[1].back() == Approx(3.0 * std::exp(-0.25)).epsilon(1e-5));
}

TEST_CASE("the trace goes to standard output for -o -, and nothing else does") {
  const Workplace here;
  const Outcome run = here.bgsim("decay.json -o -");
  CHECK(run.code == 0);
  CHECK_THAT(run.out, StartsWith("t,q,\"e, twice\"\r\n0,1,4\r\n0.5,"));
  CHECK_FALSE(here.has("decay.first.csv"));
  CHECK_THAT(run.err, Contains("trace: standard output"));
}

TEST_CASE("options may stand before the model") {
  const Workplace here;
  CHECK(here.bgsim("--set R=3 -o - --scene first decay.json").code == 0);
  CHECK(here.bgsim("--relative 1e-8 --absolute 1e-10 --method adams decay.json -o out.csv").code == 0);
}

TEST_CASE("the same run gives the same bytes") {
  const Workplace here;
  CHECK(here.bgsim("decay.json -o a.csv").code == 0);
  CHECK(here.bgsim("run decay.json -o b.csv").code == 0);
  CHECK(here.read("a.csv") == here.read("b.csv"));
}

TEST_CASE("a run that goes well says nothing with --quiet") {
  const Workplace here;
  const Outcome run = here.bgsim("decay.json --quiet");
  CHECK(run.code == 0);
  CHECK(run.err.empty());
  CHECK(here.has("decay.first.csv"));
}

TEST_CASE("report and units are written beside the trace on request") {
  const Workplace here;
  CHECK(here.bgsim("decay.json --report-json report.json --units").code == 0);
  CHECK_THAT(here.read("report.json"), StartsWith("{"));
  CHECK(here.read("decay.first.units.json") == "{\n  \"q\": \"C\",\n  \"e, twice\": \"V\"\n}\n");
}

TEST_CASE("events go to a file or to standard output on request") {
  const Workplace here;
  here.write("square.json", R"x({ "bgsim": 1, "name": "square",
    "elements": { "s": { "kind": "Sf", "flow": "if(t >= 1 and t < 2.5, 1, 0)" }, "n": { "kind": "0" },
                  "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "n" }, { "from": "n", "to": "c" } ],
    "outputs": { "q": "c.q" }, "scenes": { "run": { "stop": 3, "samples": 4 } } })x");
  const std::string table =
      "t,kind,name,quantity,from,to,impulse,energy\r\n"
      "1,time,t >= 1,,false,true,,\r\n"
      "2.5,time,t < 2.5,,true,false,,\r\n";
  CHECK(here.bgsim("square.json --quiet --events events.csv").code == 0);
  CHECK(here.read("events.csv") == table);
  CHECK(here.bgsim("square.json --quiet --events -").out == table);
  // Without events the header alone; a run that fails leaves what happened until then.
  CHECK(here.bgsim("square.json --quiet --stop 0.5 --events -").out == table.substr(0, table.find('\n') + 1));
  CHECK(here.bgsim("square.json --quiet --max-steps 1 --events events.csv").code == 3);
  CHECK_FALSE(here.has("events.csv.partial"));
}

TEST_CASE("every scene goes to its own file with --all-scenes") {
  const Workplace here;
  CHECK(here.bgsim("decay.json --all-scenes").code == 0);
  CHECK(here.has("decay.first.csv"));
  CHECK(here.has("decay.longer.csv"));
  CHECK(here.has("decay.wrong.csv"));
}

TEST_CASE("a model with no file, or at fault, ends with exit code 1 and no trace") {
  const Workplace here;
  const Outcome missing = here.bgsim("nowhere.json");
  CHECK(missing.code == 1);
  CHECK_THAT(missing.err, Contains("nowhere.json"));
  here.write("broken.json", "{ \"bgsim\": 1, ");
  const Outcome broken = here.bgsim("broken.json -o out.csv");
  CHECK(broken.code == 1);
  CHECK_THAT(broken.err, StartsWith("broken.json:1:"));
  CHECK_FALSE(here.has("out.csv"));
  here.write("empty.json", "\n");
  CHECK_THAT(here.bgsim("empty.json").err, Contains("BG101: the file is empty"));
  here.write("wide.json", std::string("\xFF\xFE{\0\"\0b\0", 8));
  CHECK_THAT(here.bgsim("wide.json").err, Contains("written in UTF-16") && Contains("save it as UTF-8"));
}

TEST_CASE("a fault in the file of a submodel is said once, and none of those that come of it") {
  const Workplace here;
  here.write("cell.json", R"({"bgsim": 1, "elements": {"in": {"kind": "1"} "r": {"kind": "R", "resistance": 1}},
    "bonds": [{"from": "in", "to": "r"}], "ports": {"left": "in"}})");
  here.write("pair.json", R"({"bgsim": 1, "types": {"cell": "cell.json"}, "elements": {"a": {"kind": "cell"}},
    "ports": {"l": "a.left"}})");
  here.write("top.json", R"({"bgsim": 1, "types": {"pair": "pair.json"},
    "elements": {"s": {"kind": "Se", "effort": 1}, "p": {"kind": "pair"}}, "bonds": [{"from": "s", "to": "p.l"}],
    "scenes": {"s": {"stop": 1}}})");
  const std::string err = here.bgsim("top.json").err;
  CHECK_THAT(err, Contains("cell.json:1:") && Contains("BG101") && !Contains("BG138") && !Contains("BG204"));
}

TEST_CASE("wrong usage ends with exit code 2, naming what is wrong") {
  const Workplace here;
  const auto refused = [&here](const std::string& arguments, const std::string& word) {
    const Outcome run = here.bgsim(arguments);
    CHECK(run.code == 2);
    CHECK(run.out.empty());
    CHECK_THAT(run.err, Contains(word));
    CHECK_FALSE(here.has("decay.first.csv"));
  };
  refused("", "which model?");
  for (const char* const option : {"--scene", "--resume", "--snapshot", "--events", "--report-json", "-o", "--set"})
    refused("decay.json " + std::string(option) + " ''", "is given an empty text");
  refused("''", "is given an empty text");
  refused("decay.json --sceen first", "--sceen");
  refused("decay.json other.json", "other.json");
  refused("decay.json --scene", "--scene");
  refused("decay.json --relative 0", "--relative");
  refused("decay.json --relative -1e-6", "--relative");
  refused("decay.json --relative small", "--relative");
  refused("decay.json --absolute inf", "--absolute");
  refused("decay.json --method euler", "\"euler\"");
  refused("decay.json --step 1e-4", "bgsim: error BG146");
  refused("decay.json --max-order 6", "bgsim: error BG146");
  refused("decay.json --all-scenes -o x.csv", "--all-scenes");
  refused("decay.json -o - --report-json -", "standard output");
  refused("decay.json -o - --events -", "standard output");
  refused("decay.json --report-json - --events -", "standard output");
  refused("decay.json --all-scenes --events e.csv", "--events");
  refused("decay.json -o x.csv --events x.csv", "would be one file");
  refused("decay.json --scene nosuch", "\"nosuch\"");
  refused("decay.json --set nosuch=1", "\"nosuch\"");
  refused("decay.json --set R", "NAME=EXPR");
  refused("decay.json --set R=1+", "R=1+");
  refused("show decay.json", "--stage");
  refused("show decay.json --stage strokes", "strokes");
}

TEST_CASE("a place that cannot be written to is named, with exit code 2") {
  const Workplace here;
  const Outcome folder = here.bgsim("decay.json -o nowhere/out.csv");
  CHECK(folder.code == 2);
  CHECK_THAT(folder.err, Contains("cannot write \"nowhere/out.csv\": No such file or directory"));
  const Outcome itself = here.bgsim("decay.json -o ./decay.json");
  CHECK(itself.code == 2);
  CHECK_THAT(itself.err, Contains("it is the model itself"));
  const Outcome full = here.bgsim("decay.json -o /dev/full");
  CHECK(full.code == 2);
  CHECK_THAT(full.err, Contains("cannot write \"/dev/full\": No space left on device"));
  const Outcome full_output = here.bgsim("decay.json -o - --quiet", ">/dev/full");
  CHECK(full_output.code == 2);
  CHECK_THAT(full_output.err, Contains("cannot write to standard output: No space left on device"));
}

TEST_CASE("a closed pipe is a failed write that is reported, not a silent end") {
  const Workplace here;
  std::array<int, 2> ends{};
  REQUIRE(pipe(ends.data()) == 0);
  REQUIRE(dup2(ends[1], 9) == 9);  // the shell knows descriptors of one digit only
  close(ends[0]);
  close(ends[1]);
  const Outcome run = here.bgsim("decay.json -o - --quiet", ">&9");
  close(9);
  CHECK(run.code == 2);
  CHECK_THAT(run.err, Contains("cannot write to standard output: Broken pipe"));
}

TEST_CASE("an interrupted run keeps its trace up to there, says so, and ends with exit code 3") {
  const Workplace here;
  // A lossless oscillator over a hundred thousand periods: a minute of work or more, so that it is certainly
  // interrupted.
  const Outcome run = here.bgsim("ring.json -o out.csv", when_rows_are_there("kill -TERM $pid"));
  CHECK(run.code == 3);
  CHECK_THAT(run.err, Contains("trace up to there: out.csv"));
  const auto table = bgsim::parse_csv(here.read("out.csv"));
  CHECK(table.columns[0].front() == 0.0);
  CHECK(table.columns[0].back() < 628318.0);
}

TEST_CASE("a file named like a subcommand is reached as ./NAME") {
  const Workplace here;
  here.write("check", here.read("decay.json"));
  CHECK(here.bgsim("./check").code == 0);
  CHECK(here.has("decay.first.csv"));
}

TEST_CASE("version and help are answered on standard output") {
  const Workplace here;
  const Outcome version = here.bgsim("--version");
  CHECK(version.code == 0);
  CHECK_THAT(version.out, StartsWith("bgsim 0."));
  for (const char* command : {"", "run ", "check ", "equations ", "show ", "verify "}) {
    const Outcome help = here.bgsim(std::string(command) + "--help");
    CHECK(help.code == 0);
    CHECK(help.err.empty());
    CHECK(help.out.size() > 100);
  }
}

TEST_CASE("the model in the README runs as the README says") {
  const Workplace here;
  const std::string readme = bgsim::test::file_text(BGSIM_SOURCE_DIR "/README.md");
  const std::size_t begin = readme.find("```json\n") + 8;
  here.write("rc.json", readme.substr(begin, readme.find("```", begin) - begin));
  CHECK(here.bgsim("rc.json").code == 0);
  const auto table = bgsim::parse_csv(here.read("rc.charge.csv"));
  CHECK(table.columns[1].back() == Approx(5.0 * (1.0 - std::exp(-5.0))).epsilon(1e-5));
  CHECK_THAT(here.bgsim("equations rc.json").out, Contains("store.q' = (5 - store.q/C)/R"));
}

TEST_CASE("scenes that end at 0 are as right and as quick as others", "[long]") {
  const Workplace place;
  // Nothing in the cradle depends on t.
  const std::string cradle = BGSIM_SOURCE_DIR "/models/cradle.json --scene two --quiet -o ";
  REQUIRE(place.bgsim(cradle + "from_zero.csv --stop 10").code == 0);
  // An impact 21 roundings of the time before the end: Radau's steps, which all methods take from there, were too
  // short.
  for (const char* stop : {"12", "14"}) CHECK(place.bgsim(cradle + "later.csv --method bdf --stop " + stop).code == 0);
  const Outcome early = place.bgsim(cradle + "to_zero.csv --start -10 --stop 0");
  INFO(early.err);
  REQUIRE(early.code == 0);
  const auto last = [&](const std::string& file) {
    const std::string text = place.read(file);
    const std::size_t line = text.rfind('\n', text.size() - 2) + 1;
    std::vector<double> values;
    std::istringstream row(text.substr(text.find(',', line) + 1));
    for (std::string cell; std::getline(row, cell, ',');) values.push_back(std::stod(cell));
    return values;
  };
  const std::vector<double> a = last("from_zero.csv"), b = last("to_zero.csv");
  REQUIRE(a.size() == b.size());
  // Times near 10 are rounded to 1.8e-15, dozens of impacts are at such times, and speeds are about 1.
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(b[i] == Approx(a[i]).margin(1e-12).epsilon(0.0));

  place.write("edge.json", R"x({ "bgsim": 1, "name": "edge", "elements": {
    "push": { "kind": "MSf", "flow": "if(t < -0.25, 1, 0)" }, "n": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "push", "to": "n" }, { "from": "n", "to": "c" } ],
    "outputs": { "q": "c.q" }, "scenes": { "s": { "start": -0.5, "stop": 0, "samples": 2 } } })x");
  const Outcome edge = place.bgsim("edge.json -o -");
  place.write("edge.csv", edge.out);
  CHECK(last("edge.csv").front() == Approx(0.25).epsilon(1e-12));  // the integral of a constant, over a few steps
  CHECK(edge.err.find("note") == std::string::npos);
}
