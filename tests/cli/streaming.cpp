// A trace while its run goes on: what is on disk, who reads it, and what it costs.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <sstream>

#include "bgsim/csv.hpp"
#include "bgsim/trace_csv.hpp"
#include "command.hpp"

using Catch::Contains;

namespace {

/// Rows of whole records; the last may have been cut.
std::ptrdiff_t records(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

/// Most memory that a run took, in kB.
long peak_of(const Workplace& here, const std::string& model) {
  const pid_t child = fork();
  if (child == 0) {
    const std::string file = here.folder() + "/" + model, trace = here.folder() + "/big.csv";
    execl(bgsim_path().c_str(), "bgsim", file.c_str(), "--quiet", "-o", trace.c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  REQUIRE(wait4(child, &status, 0, &usage) == child);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
  return usage.ru_maxrss;
}

std::string rows_of(int samples) {
  return R"x({ "bgsim": 1, "name": "rows",
    "elements": { "s": { "kind": "Se", "effort": "sin(t)" }, "j": { "kind": "1" },
                  "r": { "kind": "R", "resistance": 3 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" } ],
    "outputs": { "f": "r.f", "e": "s.e" }, "scenes": { "run": { "stop": 1, "samples": )x" +
         std::to_string(samples) + " } } }";
}

}  // namespace

TEST_CASE("a run that is killed leaves its rows in the partial file, and the old trace as it was") {
  const Workplace here;
  for (const char* signal : {"KILL", "ABRT"}) {
    INFO(signal);
    here.write("out.csv", "old");
    const Outcome run =
        here.bgsim("ring.json -o out.csv", when_rows_are_there(std::string("kill -") + signal + " $pid"));
    CHECK(run.code > 128);
    const std::string partial = here.read("out.csv.partial");
    CHECK(partial.starts_with("t,x\r\n0,0\r\n"));
    CHECK(here.read("out.csv") == "old");
  }
}

TEST_CASE("rows reach the partial file while the run goes on, not at its end") {
  const Workplace here;
  const Outcome run = here.bgsim(
      "ring.json -o out.csv",
      when_rows_are_there("cp out.csv.partial first; n=0; while cmp -s out.csv.partial first && [ $n -lt 600 ]; "
                          "do sleep 0.05; n=$((n+1)); done; cp out.csv.partial second; kill -TERM $pid"));
  CHECK(run.code == 3);
  const std::string first = here.read("first"), second = here.read("second");
  CHECK(records(second) > records(first));
  CHECK(second.starts_with(first));
  CHECK(here.read("out.csv").starts_with(second));
  CHECK_FALSE(here.has("out.csv.partial"));
}

TEST_CASE("a closed terminal ends a run in good order, and not one that ignores it") {
  const Workplace here;
  const Outcome run = here.bgsim("ring.json -o out.csv", when_rows_are_there("kill -HUP $pid"));
  CHECK(run.code == 3);
  CHECK_THAT(run.err, Contains("BG606") && Contains("trace up to there: out.csv"));
  // As under nohup. The run is alive after the signal, and ended by another.
  const Outcome ignoring =
      here.bgsim("--version", "; trap '' HUP; '" + bgsim_path() + "' ring.json -o out.csv 2>.err " +
                                  when_rows_are_there("kill -HUP $pid; sleep 0.5; kill -0 $pid && echo alive; "
                                                      "kill -TERM $pid"));
  CHECK(ignoring.code == 3);
  CHECK_THAT(ignoring.out, Contains("alive"));
}

TEST_CASE("a reader of standard output gets rows while the run goes on, and its end ends the run") {
  const Workplace here;
  const Outcome run = here.bgsim("ring.json -o - --quiet", "; echo $? >code; } | { head -n 2");
  CHECK(run.out == "t,x\r\n0,0\r\n");
  CHECK(here.read("code") == "2\n");
  CHECK_THAT(here.read(".err"), Contains("cannot write to standard output: Broken pipe"));
}

TEST_CASE("a reader that goes away before there is a second row ends the run, too") {
  const Workplace here;
  const Outcome run = here.bgsim("ring.json -o - --quiet --set mass.p=1e-3 --step 1e-3 --method rk4",
                                 "; echo $? >code; } | { head -n 1");
  CHECK(run.out == "t,x\r\n");
  CHECK(here.read("code") == "2\n");
}

TEST_CASE("a full disk ends a run at once, with the reason and the name of what there is") {
  const Workplace here;
  here.write("out.csv", "old");
  here.write("many.json", rows_of(1000000));
  // A limit of file size is a disk that is full for one file.
  const Outcome run = here.bgsim("--version", "; ulimit -f 16; '" + bgsim_path() + "' many.json -o out.csv 2>.err");
  CHECK(run.code == 2);
  CHECK_THAT(run.err, Contains("cannot write \"out.csv\": File too large") &&
                          Contains("what was written before is in \"out.csv.partial\""));
  CHECK(here.read("out.csv") == "old");
  CHECK(here.read("out.csv.partial").starts_with("t,f,e\r\n0,0,0\r\n"));
}

TEST_CASE("the memory of a run does not grow with its rows", "[long]") {
  const Workplace here;
  here.write("few.json", rows_of(1000));
  here.write("many.json", rows_of(1000000));
  const long few = peak_of(here, "few.json"), many = peak_of(here, "many.json");
  // A million rows of three numbers take 24 MB; what is handed over at once takes half a megabyte.
  CHECK(many < few + 8000);
  const std::string text = here.read("big.csv");
  CHECK(records(text) == 1000001);
  CHECK(text.ends_with("\r\n"));
}

TEST_CASE("a streamed trace has the bytes of one that is written at once") {
  const Workplace here;
  const Outcome run = here.bgsim("decay.json -o out.csv --quiet");
  REQUIRE(run.code == 0);
  const bgsim::CsvTable table = bgsim::parse_csv(here.read("out.csv"));
  bgsim::Trace trace;
  trace.names.assign(table.names.begin() + 1, table.names.end());
  trace.times = table.columns.front();
  trace.columns.assign(table.columns.begin() + 1, table.columns.end());
  std::ostringstream text;
  bgsim::write_trace_csv(text, trace);
  CHECK(text.str() == here.read("out.csv"));
}

TEST_CASE("a run ends at its limit of steps or of time with the trace up to there") {
  const Workplace here;
  const Outcome steps = here.bgsim("ring.json -o out.csv --max-steps 100");
  CHECK(steps.code == 3);
  CHECK_THAT(steps.err, Contains("BG607: the limit of 100 steps") && Contains("trace up to there: out.csv"));
  const Outcome time = here.bgsim("ring.json -o out.csv --time-limit 0.3");
  CHECK(time.code == 3);
  CHECK_THAT(time.err, Contains("BG618: the limit of 0.3 s") && Contains("trace up to there: out.csv"));
  CHECK(here.read("out.csv").starts_with("t,x\r\n0,0\r\n"));
  const Outcome both = here.bgsim("ring.json --time-limit 1 --no-time-limit");
  CHECK(both.code == 2);
  for (const char* wrong : {"--time-limit 0", "--time-limit -1", "--max-steps 0", "--time-limit nan"}) {
    INFO(wrong);
    CHECK(here.bgsim(std::string("ring.json ") + wrong).code == 2);
  }
}

TEST_CASE("a run is continued from its snapshot on the command line") {
  const Workplace here;
  const Outcome first =
      here.bgsim("ring.json -o part1.csv --max-steps 300 --stop 100 --samples 1001 --snapshot s.json --quiet");
  CHECK(first.code == 3);
  REQUIRE(here.has("s.json"));
  // the same file may be continued and replaced
  const Outcome second = here.bgsim(
      "ring.json -o part2.csv --stop 100 --samples 1001 --max-steps 600 --resume s.json --snapshot s.json --quiet");
  CHECK(second.code == 3);
  CHECK_THAT(second.err, Contains("BG607: the limit of 600 steps"));
  const bgsim::CsvTable a = bgsim::parse_csv(here.read("part1.csv")), b = bgsim::parse_csv(here.read("part2.csv"));
  REQUIRE(!b.columns.front().empty());
  CHECK(a.columns.front().back() < b.columns.front().front());

  const Outcome other = here.bgsim("decay.json -o out.csv --resume s.json");
  CHECK(other.code == 1);
  CHECK_THAT(other.err, Contains("BG171: the run cannot be continued"));
  CHECK(!here.has("out.csv"));
  here.write("static.json", R"x({ "bgsim": 1, "name": "static", "elements": { "s": { "kind": "Se", "effort": "t" },
      "r": { "kind": "R", "resistance": 2 } }, "bonds": [ { "from": "s", "to": "r" } ], "outputs": { "f": "r.f" },
      "scenes": { "main": { "stop": 1, "samples": 3 } } })x");
  const Outcome without = here.bgsim("static.json -o out2.csv --snapshot s3.json --quiet");
  CHECK(without.code == 0);
  CHECK_THAT(without.err, Contains("no snapshot was written: the run has no states"));
  CHECK(!here.has("s3.json"));
  const Outcome none = here.bgsim("ring.json --resume nothing.json");
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Contains("cannot read the snapshot \"nothing.json\""));
  for (const char* wrong : {"--snapshot-steps 5", "--snapshot -", "--all-scenes --snapshot s.json",
                            "--all-scenes --resume s.json", "--resume s.json -o s.json", "--snapshot ring.json",
                            "--snapshot x.csv -o x.csv", "--snapshot s2.json --snapshot-steps 0"}) {
    INFO(wrong);
    CHECK(here.bgsim(std::string("ring.json ") + wrong).code == 2);
  }
}

TEST_CASE("report and verify end their runs at the same limits, and say so") {
  const Workplace here;
  const Outcome report = here.bgsim("report ring.json -o out.html --max-steps 100 --quiet");
  CHECK(report.code == 3);
  CHECK_THAT(report.err, Contains("BG607: the limit of 100 steps"));
  CHECK(here.has("out.html"));  // with the trace up to there
  here.write("r.csv", "t,x\r\n0,0\r\n628318,0\r\n");
  std::string text = here.read("ring.json");
  here.write("held.json", text.replace(text.find("\"relative\""), 0, "\"reference\": \"r.csv\", "));
  const Outcome verify = here.bgsim("verify held.json --time-limit 0.3");
  CHECK(verify.code == 3);
  CHECK_THAT(verify.err, Contains("BG618: the limit of 0.3 s"));
}
