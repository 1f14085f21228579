// bgsim sweep: files, going on after a kill, parts and their union, refusals.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <sstream>
#include <string>

#include "command.hpp"

using Catch::Contains;

namespace {

const char* const kModel = R"({ "bgsim": 1, "name": "rc",
  "parameters": { "R": { "value": 2, "unit": "ohm" }, "C": { "value": 0.5, "unit": "F" } },
  "elements": { "s": { "kind": "Se", "effort": 3 }, "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
    "c": { "kind": "C", "capacitance": "C" } },
  "bonds": [ { "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "c" } ],
  "outputs": { "u": { "value": "c.e", "unit": "V" } },
  "scenes": { "charge": { "stop": 4, "samples": 3 } } })";

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

Workplace& with_model(Workplace& here) {
  here.write("rc.json", kModel);
  return here;
}

}  // namespace

TEST_CASE("a sweep writes a row for each run and says least, mean and largest of each result") {
  Workplace here;
  const Outcome sweep =
      with_model(here).bgsim("sweep rc.json --vary R=1:2:3 --vary C=0.5,0 --result peak='max(u)' --traces");
  CAPTURE(sweep.err);
  CHECK(sweep.code == 0);
  CHECK_THAT(sweep.err, Contains("6 runs, 3 failed"));
  CHECK_THAT(sweep.err, Contains("3 runs: BG145"));
  const std::string table = here.read("rc.charge.sweep/results.csv");
  CHECK(lines(table) == 7);
  CHECK_THAT(table, Catch::StartsWith("run,R,C,peak,status,notes,message\r\n0,1,0.5,2.99"));
  CHECK_THAT(table, Contains("\n5,2,0,,failed,0,"));
  CHECK_THAT(here.read("rc.charge.sweep/trace.4.csv"), Catch::StartsWith("t,u"));
  CHECK_FALSE(here.has("rc.charge.sweep/trace.5.csv"));
}

TEST_CASE("a result that is no finite number in a run is left empty, with a note") {
  Workplace here;
  const Outcome sweep = with_model(here).bgsim(
      "sweep rc.json --vary R=1,2 --result 'a=1/(R-1)' --result 'b=log(final(u)-5)' --result 'd=final(u)/(R-1)' "
      "--result 'u=final(u)' -o it");
  CAPTURE(sweep.err);
  CHECK(sweep.code == 0);
  CHECK_THAT(sweep.err, Contains("2 with notes") && Contains("no value in any run"));
  CHECK_THAT(sweep.err, Contains("the result \"a\" is not a finite number, and left empty"));
  const std::string table = here.read("it/results.csv");
  CHECK_THAT(table, Contains("\n0,1,,,,2.99") && Contains(",completed,3,") && Contains("\n1,2,1,,2.94") &&
                        Contains(",completed,1,"));
}

TEST_CASE("expressions of results and columns may name outputs that are called as elements are") {
  Workplace here;
  std::string model = kModel;
  model.replace(model.find("\"u\": { \"value\""), 3, "\"c\"");
  here.write("rc.json", model);
  REQUIRE(here.bgsim("sweep rc.json --vary R=1,2 --result 'a=max(abs(c))' --result 'b=max(c)' -o it").code == 0);
  CHECK_THAT(here.read("it/results.csv"), Contains("\n0,1,2.99899") && Contains("\n1,2,2.94505"));
  const Outcome run = here.bgsim("rc.json --output w=2*c -o - --quiet");
  CHECK_THAT(run.out, Catch::StartsWith("t,c,w\r\n0,0,0\r\n"));
}

TEST_CASE("settings of the scene are varied like parameters") {
  Workplace here;
  with_model(here);
  REQUIRE(
      here.bgsim("sweep rc.json --vary scene.step=0.1,0.01 --method rk4 --result u='final(u)' -o step --quiet").code ==
      0);
  // u = 3 (1 - exp(-4)); the classical method is wrong by some h^4.
  const std::string table = here.read("step/results.csv");
  CHECK_THAT(table, Contains("0,0.1,2.9450") && Contains("\n1,0.01,2.94505308"));
  REQUIRE(here.bgsim("sweep rc.json --vary scene.stop=1,4 --result u='final(u)' -o stop --quiet").code == 0);
  CHECK_THAT(here.read("stop/results.csv"), Contains("\n0,1,1.8963") && Contains("\n1,4,2.9450"));
}

TEST_CASE("a sweep whose results take no output says that it needs no runs") {
  Workplace here;
  const Outcome done = with_model(here).bgsim("sweep rc.json --vary R=1,2 --result 'p=2*R' -o it");
  CHECK(done.code == 2);
  CHECK_THAT(done.err, Contains("no --result takes an output"));
}

TEST_CASE("a sweep that is killed goes on where it was, and comes to the same table", "[long]") {
  Workplace here;
  with_model(here);
  const std::uint64_t runs = 8000;
  const std::string arguments =
      "sweep rc.json --vary R=0.5:5 --sample random:" + std::to_string(runs) + " --result m='mean(u)' --quiet -j 2";
  const Outcome killed =
      here.bgsim(arguments + " -o cut",
                 "& pid=$!; n=0; until [ $(wc -l < cut/runs.csv 2>/dev/null || echo 0) -gt 50 ] || [ $n -gt "
                 "600 ]; do sleep 0.05; n=$((n+1)); done; kill -KILL $pid; wait $pid");
  CHECK(killed.code != 0);
  const std::size_t before = lines(here.read("cut/runs.csv"));
  REQUIRE(before > 50);
  REQUIRE(before < runs + 1);
  // What the kill may leave of a record.
  here.write("cut/runs.csv", here.read("cut/runs.csv") + std::to_string(runs - 1) + ",0.123");
  const Outcome rest = here.bgsim(arguments + " -o cut");
  CAPTURE(rest.err);
  CHECK(rest.code == 0);
  REQUIRE(here.bgsim(arguments + " -o whole").code == 0);
  CHECK(here.read("cut/results.csv") == here.read("whole/results.csv"));
  CHECK(lines(here.read("cut/runs.csv")) == runs + 1);
}

TEST_CASE("an interrupted sweep says how to go on, and ends with exit code 3") {
  Workplace here;
  const Outcome ended = with_model(here).bgsim(
      "sweep rc.json --vary R=0.5:5 --sample sobol:1000000 -o it",
      "& pid=$!; n=0; until [ $(wc -l < it/runs.csv 2>/dev/null || echo 0) -gt 10 ] || [ $n -gt 600 ]; do sleep 0.05; "
      "n=$((n+1)); done; kill -TERM $pid; wait $pid");
  CHECK(ended.code == 3);
  CHECK_THAT(ended.err, Contains("The same command goes on from there"));
}

TEST_CASE("parts of a sweep in folders of their own are joined to the table of the whole") {
  Workplace here;
  with_model(here);
  const std::string arguments = "sweep rc.json --vary R=1:2:5 --vary C=0.1:1:4 --result m='mean(u)' ";
  REQUIRE(here.bgsim(arguments + "-o whole").code == 0);
  CHECK(here.bgsim(arguments + "--shard 1/3 -o a").code == 0);
  CHECK(here.bgsim(arguments + "--shard 2/3 -o a").code == 0);
  const Outcome early = here.bgsim("sweep --merge a");
  CHECK(early.code == 3);
  CHECK_THAT(early.err, Contains("14 of 20 runs") && Contains("not complete"));
  CHECK(here.bgsim(arguments + "--shard 3/3 -o b").code == 0);
  CHECK(here.bgsim("sweep --merge a b").code == 0);
  CHECK(here.read("a/results.csv") == here.read("whole/results.csv"));
}

TEST_CASE("a folder with another sweep, or with other files, is left alone") {
  Workplace here;
  with_model(here);
  REQUIRE(here.bgsim("sweep rc.json --vary R=1,2 -o it --quiet").code == 0);
  const std::string before = here.read("it/results.csv");
  const auto refused = [&](const std::string& arguments, const std::string& what) {
    const Outcome outcome = here.bgsim("sweep " + arguments);
    CAPTURE(arguments, outcome.err);
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains(what));
    CHECK(here.read("it/results.csv") == before);
  };
  refused("rc.json --vary R=1,3 -o it", "holds another sweep: it differs in vary");
  refused("rc.json --vary R=1,2 -o it --relative 1e-8", "differs in options");
  refused("rc.json --vary R=1,2 -o it --result x='max(u)'", "differs in options, results");
  std::string other = kModel;
  other.replace(other.find("\"effort\": 3"), 11, "\"effort\": 4");
  here.write("rc.json", other);
  refused("rc.json --vary R=1,2 -o it", "differs in checksum");
  refused("rc.json --vary R=1,2 -o .", "holds files, and no sweep");
}

TEST_CASE("a process enters a sweep that another one is just beginning") {
  Workplace here;
  with_model(here);
  // The other process has written its plan, and not named it yet.
  REQUIRE(here.shell("mkdir it && echo '{' > it/sweep.json.1").code == 0);
  const Outcome sweep = here.bgsim("sweep rc.json --vary R=1,2 --share -o it --quiet");
  CAPTURE(sweep.err);
  CHECK(sweep.code == 0);
  REQUIRE(here.bgsim("sweep rc.json --vary R=1,2 -o alone --quiet").code == 0);
  CHECK(here.read("it/results.csv") == here.read("alone/results.csv"));
}

TEST_CASE("what a sweep cannot vary or keep is wrong usage, with the fix") {
  Workplace here;
  with_model(here);
  const auto refused = [&](const std::string& arguments, const std::string& what) {
    const Outcome outcome = here.bgsim("sweep " + arguments + " -o it");
    CAPTURE(arguments, outcome.err);
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains(what));
  };
  refused("rc.json", "nothing is varied");
  refused("", "which model?");
  refused("rc.json --vary Q=1,2", "there is no parameter or state \"Q\"");
  refused("rc.json --vary R=1,2 --set R=3", "is set by --set and varied by --vary");
  refused("rc.json --vary R=1:2", "is a distribution");
  refused("rc.json --vary R=1,2 --result 'max(u)'", "write NAME=EXPR");
  refused("rc.json --vary R=1,2 --result 'x=max(v)'", "unknown name \"v\"");
  refused("rc.json --vary R=1,2 --result 'x=u'", "a result is made of");
  refused("rc.json --vary R=1,2 --result 'x=first(u - 1)'", "first(u - 1) takes a condition, and this is a number");
  refused("rc.json --vary R=1,2 --result 'x=first(u)'", "is a number where a condition is meant");
  refused("rc.json --vary R=1,2 --result 'x=duration(2*u)'", "as in duration(2*u > 0)");
  refused("rc.json --vary R=1,2 --result 'R=max(u)'", "has a column of this name");
  refused("rc.json --vary R=1,2 --result 'status=max(u)'", "has a column of this name");
  refused("rc.json --vary R=1,2 --shard 3/2", "write I/N");
  refused("rc.json --vary R=1,2 --scene none", "there is no scene");
  CHECK(here.bgsim("sweep --merge none").code == 2);
}

TEST_CASE("a condition that is true for an instant alone, and an event's own, are found by first") {
  // u = I (1 - exp(-t)), which the event sets to 0 as soon as it is above 1.
  Workplace here;
  here.write("fire.json", R"x({"bgsim": 1, "name": "fire", "parameters": {"I": 1.5},
    "elements": {"S": {"kind": "Sf", "flow": "I"}, "z": {"kind": "0"}, "c": {"kind": "C", "capacitance": 1}, "r": {"kind": "R", "resistance": 1}},
    "bonds": [{"from": "S", "to": "z"}, {"from": "z", "to": "c"}, {"from": "z", "to": "r"}],
    "events": {"fire": {"when": "c.q > 1", "set": {"c.q": "0"}}}, "outputs": {"v": "c.e"},
    "scenes": {"s": {"stop": 5, "samples": 11}}})x");
  REQUIRE(here.bgsim("sweep fire.json --vary I=1.2,1.5,3 --result 'f=first(v > 1)' --result 'g=first(v >= 1)' "
                     "--result 'never=0*first(v > 2)' -o it")
              .code == 0);
  std::istringstream table(here.read("it/results.csv"));
  std::string row;
  std::getline(table, row);
  std::size_t rows = 0;
  for (; std::getline(table, row); ++rows) {
    CAPTURE(row);
    double current = 0.0, above = 0.0, at_least = 0.0;
    // Nothing between the commas: no value.
    REQUIRE(std::sscanf(row.c_str(), "%*d,%lf,%lf,%lf,,completed", &current, &above, &at_least) == 3);
    REQUIRE_THAT(row, Contains(",,completed"));
    const double right = -std::log(1.0 - 1.0 / current);
    CHECK(above == Approx(right).epsilon(1e-6));  // the tolerance of the runs
    CHECK(at_least == Approx(right).epsilon(1e-6));
  }
  CHECK(rows == 3);
}

TEST_CASE("a picture shows the results of a sweep over what is varied") {
  Workplace here;
  with_model(here);
  REQUIRE(here.bgsim("sweep rc.json --vary R=1:2:5 -o line --picture --quiet").code == 0);
  CHECK_THAT(here.read("line/results.svg"), Contains("<svg") && Contains("u.mean"));
  REQUIRE(here.bgsim("sweep rc.json --vary R=1:2:5 --vary 'C=log(0.1:1:4)' -o map --picture --quiet").code == 0);
  CHECK_THAT(here.read("map/results.svg"), Contains("<svg"));
}

TEST_CASE("a sweep with the sample for it ends with indices of sensitivity, the same from one thread, many, and parts",
          "[long]") {
  Workplace here;
  with_model(here);
  // Ishigami's function of parameters: first 0.3139, 0.4424, 0, total 0.5576, 0.4424, 0.2437.
  std::string model = kModel;
  model.replace(model.find("\"C\": {"), 6, R"("x": 0, "y": 0, "z": 0, "C": {)");
  here.write("rc.json", model);
  const std::string arguments =
      "sweep rc.json --vary x=-3.141592653589793:3.141592653589793 --vary y=-3.141592653589793:3.141592653589793 "
      "--vary z=-3.141592653589793:3.141592653589793 --vary R=1:2 --sample saltelli:512 --stop 0.1 "
      "--no-audit --no-error-estimate --result 'f=sin(x)+7*sin(y)^2+0.1*z^4*sin(x)+0*final(u)' --result 'u=final(u)' ";
  const Outcome whole = here.bgsim(arguments + "-j 1 -o whole --picture");
  CAPTURE(whole.err, whole.out);
  REQUIRE(whole.code == 0);
  CHECK_THAT(whole.out, Contains("f: mean 3.49847") && Contains("first"));
  CHECK_THAT(whole.out, Contains("\nx  0.3133  ") && Contains("\nR  0         0       0       0\n"));
  const std::string table = here.read("whole/indices.csv");
  CHECK_THAT(table,
             Catch::StartsWith("result,quantity,first,first_within,total,total_within,mean,deviation,points\r\n") &&
                 Contains("f,R,0,0,0,0,3.") && Contains("u,x,0,0,0,0,"));
  CHECK_THAT(here.read("whole/indices.svg"), Contains("<svg"));
  REQUIRE(here.bgsim(arguments + "-j 4 -o many --quiet").code == 0);
  CHECK(here.read("many/indices.csv") == table);
  CHECK(here.bgsim(arguments + "--shard 1/2 -o a").code == 0);
  const Outcome half = here.bgsim("sweep --merge a");
  CHECK(half.code == 3);
  CHECK_THAT(half.err, Contains("f has no value in 1536 of 3072 runs"));
  CHECK(here.bgsim(arguments + "--shard 2/2 -o b").code == 0);
  CHECK(here.bgsim("sweep --merge a b --quiet").code == 0);
  CHECK(here.read("a/indices.csv") == table);
}

TEST_CASE("a result without a value in any run leaves an empty panel, and empty indices") {
  Workplace here;
  with_model(here);
  for (const char* const sample : {"--vary R=1:2:3", "--vary R=1:2:3 --vary C=1:2:2",
                                   "--vary R=1:2 --sample saltelli:64", "--vary R=1:2 --sample morris:4"}) {
    const Outcome drawn = here.bgsim(std::string("sweep rc.json ") + sample +
                                     " --result 'never=first(u > 7)' --result 'm=mean(u)' --picture -o it");
    CAPTURE(sample, drawn.err);
    CHECK(drawn.code == 0);
    CHECK_THAT(here.read("it/results.svg"), Contains("no value in any run") && Contains("</svg>"));
    REQUIRE(here.shell("rm -r it").code == 0);
  }
}

TEST_CASE("indices say what is not to be believed of them") {
  Workplace here;
  with_model(here);
  const Outcome morris = here.bgsim(
      "sweep rc.json --vary R=0.001:0.01 --vary C=0:1 --sample morris:3 --result 'u=final(u)' --result 'one=1' -o it "
      "--picture");
  CAPTURE(morris.err, morris.out);
  CHECK(morris.code == 0);
  CHECK_THAT(morris.err, Contains("u changes by") && Contains("its indices are those of their errors") &&
                             Contains("3 paths are few"));
  CHECK_THAT(here.read("it/indices.csv"), Contains("one,R,0,0,0,0,3\r\n"));
  CHECK_THAT(here.read("it/indices.svg"), Contains("<svg"));
  // C = 0 is refused by the model in half of the runs.
  const Outcome failing =
      here.bgsim("sweep rc.json --vary R=1:2 --vary C=0,1 --sample saltelli:64 --result 'u=final(u)' -o failing");
  CHECK(failing.code == 0);
  CHECK_THAT(failing.err, Contains("u has no value in") && Contains("its indices are those of the points that have"));
  CHECK(here.bgsim("sweep rc.json --vary R=1:2 --sample saltelli:1 -o one").code == 2);
}

TEST_CASE("traces of a sweep give bands: quantiles of each output at each time") {
  Workplace here;
  with_model(here);
  // u falls with R. Of 21 runs, 5, 50 and 95 % are the second, the eleventh and the twentieth.
  const Outcome sweep = here.bgsim("sweep rc.json --vary R=1:3:21 --traces --result m='mean(u)' -o it");
  CAPTURE(sweep.err);
  REQUIRE(sweep.code == 0);
  CHECK_THAT(sweep.err, Contains("results.csv, bands.csv"));
  const auto last_of = [&](const std::string& file) {
    const std::string text = here.read(file);
    const auto begin = text.rfind('\n', text.size() - 2) + 1;
    return text.substr(begin, text.find_last_not_of("\r\n") + 1 - begin);  // "4,VALUE"
  };
  const auto value = [&](int run) { return last_of("it/trace." + std::to_string(run) + ".csv").substr(2); };
  CHECK_THAT(here.read("it/bands.csv"), Catch::StartsWith("t,u 5 %,u 50 %,u 95 %,runs\r\n0,0,0,0,21\r\n"));
  const std::string last = last_of("it/bands.csv");
  double five = 0.0, half = 0.0, most = 0.0;
  REQUIRE(std::sscanf(last.c_str(), "4,%lf,%lf,%lf,21", &five, &half, &most) == 3);
  CHECK(five == std::stod(value(19)));
  CHECK(half == std::stod(value(10)));
  CHECK(most == std::stod(value(1)));
  REQUIRE(here.bgsim("plot it u -o it.svg").code == 0);
  CHECK_THAT(here.read("it.svg"), Contains("5 to 95 % of 21 runs"));

  // A run that ends early is in the bands as far as it comes; those that are refused have no trace.
  CHECK(here.bgsim("sweep rc.json --vary C=0,0.5,1 --traces -o failing --quiet").code == 0);
  CHECK_THAT(here.read("failing/bands.csv"), Contains(",2\r\n"));
  CHECK(here.bgsim("sweep rc.json --vary R=1 --traces -o one --quiet").code == 0);
  CHECK(here.bgsim("plot one -o one.svg").code == 0);
  const Outcome apart = here.bgsim("sweep rc.json --vary scene.stop=2,4 --traces -o apart");
  CHECK(apart.code == 0);
  CHECK_THAT(apart.err, Contains("note: there are no bands"));
  CHECK(here.bgsim("plot apart -o apart.svg").code == 2);
  CHECK(here.bgsim("sweep rc.json --vary R=1,2 -o none --quiet").code == 0);
  CHECK_FALSE(here.has("none/bands.csv"));
  const Outcome none = here.bgsim("plot none -o none.svg");
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Contains("has no traces"));
  CHECK(here.bgsim("plot it --x u -o it.svg").code == 2);
  const Outcome unknown = here.bgsim("plot it v -o it.svg");
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Contains("has no column \"v\""));
}

TEST_CASE("processes share a sweep, and what a killed one was making is made by another", "[long]") {
  Workplace here;
  with_model(here);
  const std::uint64_t runs = 5000;  // long enough that the kill comes while they are made
  const std::string arguments =
      "sweep rc.json --vary R=0.5:5 --sample random:" + std::to_string(runs) + " --result m='mean(u)' --quiet -j 1 ";
  REQUIRE(here.bgsim(arguments + "-o whole").code == 0);
  const std::string share = "'" + bgsim_path() + "' " + arguments + "--share -o it & ";
  // One is killed while all three work.
  const Outcome killed = here.shell(share + "pid=$!; " + share + share +
                                    "n=0; until { [ -e it/runs.shared-3.csv ] && [ $(cat it/runs.shared-*.csv | wc -l) "
                                    "-gt 50 ]; } || [ $n -gt 600 ]; "
                                    "do sleep 0.05; n=$((n+1)); done; kill -KILL $pid; wait");
  CAPTURE(killed.err);
  CHECK(here.has("it/runs.shared-3.csv"));
  REQUIRE(here.has("it/results.csv"));
  CHECK(here.read("it/results.csv") == here.read("whole/results.csv"));
  // All is made: another call writes the same, and a part of a sweep cannot be shared.
  CHECK(here.bgsim(arguments + "--share -o it").code == 0);
  CHECK(here.read("it/results.csv") == here.read("whole/results.csv"));
  CHECK(here.bgsim(arguments + "--share --shard 1/2 -o it").code == 2);
  // A sweep that was begun alone is gone on with.
  CHECK(here.bgsim(arguments + "--share -o whole").code == 0);
  CHECK(here.read("it/results.csv") == here.read("whole/results.csv"));
}
