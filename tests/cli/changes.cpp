// What the command line says of a model beside its file: times, columns, parameters in files.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bgsim/csv.hpp"
#include "command.hpp"

using Catch::Contains;
using Catch::StartsWith;
using Names = std::vector<std::string>;

namespace {

bgsim::CsvTable table(const Workplace& here, const std::string& arguments) {
  const Outcome run = here.bgsim("run decay.json --quiet -o out.csv " + arguments);
  CAPTURE(arguments, run.err);
  REQUIRE(run.code == 0);
  return bgsim::parse_csv(here.read("out.csv"));
}

std::string usage_fault(const Workplace& here, const std::string& arguments) {
  const Outcome run = here.bgsim(arguments);
  CAPTURE(arguments, run.err);
  CHECK(run.code == 2);
  CHECK(run.out.empty());
  return run.err;
}

/// An integral, a submodel's port and a signal that is called as an output is.
const char* const kControlled = R"({ "bgsim": 1, "name": "controlled",
  "parameters": { "R": { "value": 2, "unit": "ohm" }, "gain": 1 },
  "signals": { "x": { "integral": "1 - store.e" }, "u": "gain*x" },
  "elements": { "drive": { "kind": "MSe", "effort": "u" }, "loop": { "kind": "1" },
    "left": { "kind": "0" }, "drain": { "kind": "R", "resistance": "R" },
    "store": { "kind": "C", "capacitance": 1, "initial": { "q": 0.5 } } },
  "bonds": [ { "from": "drive", "to": "loop" }, { "from": "loop", "to": "drain" }, { "from": "loop", "to": "left" },
    { "from": "left", "to": "store" } ],
  "outputs": { "u": "2*u", "q": "store.q" },
  "scenes": { "main": { "stop": 1, "samples": 3, "outputs": ["q"] }, "other": { "stop": 2, "interval": 1 } } })";

}  // namespace

TEST_CASE("start, stop and output times of the command line take the place of the scene's") {
  const Workplace here;
  CHECK(table(here, "--stop 2").columns[0] == std::vector<double>{0.0, 1.0, 2.0});
  CHECK(table(here, "--stop 2*R*C --samples 2").columns[0] == std::vector<double>{0.0, 2.0});
  CHECK(table(here, "--stop R --set R=3 --samples 2").columns[0] == std::vector<double>{0.0, 3.0});
  CHECK(table(here, "--start -1 --stop 0 --interval C").columns[0] == std::vector<double>{-1.0, -0.5, 0.0});
  CHECK(table(here, "--scene longer --samples 2").columns[0] == std::vector<double>{0.0, 2.0});
  CHECK_THAT(usage_fault(here, "decay.json --stop -1"), Contains("BG143") && Contains("command line:1:"));
  CHECK_THAT(usage_fault(here, "decay.json --stop t"), Contains("BG118"));
  CHECK_THAT(usage_fault(here, "decay.json --stop Q"), Contains("BG121") && Contains("{ \"stop\": \"Q\" }"));
  CHECK_THAT(usage_fault(here, "decay.json --stop ''"), Contains("is given an empty text"));
  CHECK_THAT(usage_fault(here, "decay.json --samples 3 --interval 1"), Contains("--samples"));
  CHECK_FALSE(here.has("decay.first.csv"));
}

TEST_CASE("a column is any expression over the model's names, with its unit inferred") {
  const Workplace here;
  here.write("controlled.json", kControlled);
  const Outcome run =
      here.bgsim("controlled.json --output 'i=drain.f' --output 'heat = drain.e*drain.f' --units -o o.csv");
  REQUIRE(run.code == 0);
  const auto trace = bgsim::parse_csv(here.read("o.csv"));
  CHECK(trace.names == Names{"t", "q", "i", "heat"});
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(trace.columns[3][i] == Approx(2.0 * trace.columns[2][i] * trace.columns[2][i]).epsilon(1e-12));
  CHECK(nlohmann::json::parse(here.read("o.units.json")).dump().find("W") != std::string::npos);
  CHECK_THAT(usage_fault(here, "decay.json --output q=store.e"), Contains("BG116"));
  CHECK_THAT(usage_fault(here, "decay.json --output a=1 --output a=2"), Contains("BG102"));
  CHECK_THAT(usage_fault(here, "decay.json --output t=1"), Contains("BG115"));
  CHECK_THAT(usage_fault(here, "decay.json --output v=store.w"), Contains("BG121") && Contains("store.w"));
  CHECK_THAT(usage_fault(here, "decay.json --output v="), Contains("the expression is empty"));
  CHECK_THAT(here.bgsim("equations decay.json --output v=2*store.e").out, Contains("\n  v        = 2*store.q/C\n"));
}

TEST_CASE("the option --output with a file's name is the trace's file as before, and what may be both is refused") {
  const Workplace here;
  CHECK(here.bgsim("decay.json --quiet --output plain.csv").code == 0);
  CHECK(here.has("plain.csv"));
  CHECK(here.bgsim("decay.json --quiet --output=./a=b.csv").code == 0);
  CHECK(here.has("a=b.csv"));
  CHECK(here.bgsim("decay.json --quiet -o c=d").code == 0);
  CHECK(here.has("c=d"));
  CHECK_THAT(usage_fault(here, "decay.json --output run=2.csv"), Contains("-o \"run=2.csv\""));
  here.write("q2=store", "");
  CHECK_THAT(usage_fault(here, "decay.json --output q2=store"), Contains("may be a column NAME=EXPR or a file"));
  CHECK_THAT(usage_fault(here, "decay.json --output a.csv -o b.csv"), Contains("two files"));
  CHECK_THAT(usage_fault(here, "decay.json -o a.csv -o b.csv"), Contains("-o"));
  const Outcome run = here.bgsim("decay.json --quiet --output - --output 'twice=2*store.q'");
  CHECK(run.code == 0);
  CHECK_THAT(run.out, StartsWith("t,q,\"e, twice\",twice\r\n"));
}

TEST_CASE("the option --record takes names and groups, each column under a name of its own") {
  const Workplace here;
  here.write("controlled.json", kControlled);
  const auto names = [&](const std::string& list) {
    const Outcome run = here.bgsim("controlled.json --quiet -o r.csv --record " + list);
    CAPTURE(list, run.err);
    REQUIRE(run.code == 0);
    return bgsim::parse_csv(here.read("r.csv")).names;
  };
  CHECK(names("outputs") == Names{"t", "u", "q"});
  CHECK(names("states") == Names{"t", "store.q", "x"});
  CHECK(names("x,drain.f") == Names{"t", "x", "drain.f"});
  CHECK(names("'q, left.e' --record b3.f") == Names{"t", "q", "left.e", "b3.f"});
  CHECK(names("states,outputs,x") == Names{"t", "store.q", "x", "u", "q"});
  CHECK(names("x --output p=drain.e") == Names{"t", "x", "p"});
  CHECK(names("u") == Names{"t", "u"});
  CHECK(names("gain") == Names{"t", "gain"});
  CHECK(names("all") == Names{"t", "u", "q", "drive.e", "drive.f", "loop.f", "left.e", "drain.e", "drain.f", "store.e",
                              "store.f", "store.q", "b3.e", "b3.f", "x", "u (signal)"});
  const auto trace = bgsim::parse_csv(here.read("r.csv"));
  for (std::size_t i = 0; i < 3; ++i) CHECK(trace.columns[1][i] == 2.0 * trace.columns.back()[i]);
  CHECK_THAT(usage_fault(here, "controlled.json --record store.q*2"),
             Contains("BG192") && Contains("--output NAME=EXPR"));
  CHECK_THAT(usage_fault(here, "controlled.json --record t"), Contains("BG192"));
  CHECK_THAT(usage_fault(here, "controlled.json --record store.p"), Contains("BG121"));
  CHECK_THAT(usage_fault(here, "controlled.json --record x,,q"), Contains("the expression is empty"));
  CHECK_THAT(usage_fault(here, "controlled.json --record ''"), Contains("the list is empty"));
}

TEST_CASE("parameters come from files, later ones before earlier ones and --set before all") {
  const Workplace here;
  here.write("a.json", R"({ "R": 4, "C": { "value": "2/R", "about": "fitted", "source": "bgsim" }, "store.q": 3 })");
  here.write("b.json", R"({ "R": "8*C", "C": 0.25 })");
  const auto end = [&](const std::string& arguments) {
    return table(here, arguments + " --relative 1e-9").columns[1].back();  // so that 1e-5 leaves room
  };
  CHECK(end("--parameters a.json") == Approx(3.0 * std::exp(-0.5)).epsilon(1e-5));
  CHECK(end("--parameters a.json --parameters b.json") == Approx(3.0 * std::exp(-2.0)).epsilon(1e-5));
  CHECK(end("--parameters b.json --parameters a.json") == Approx(3.0 * std::exp(-0.5)).epsilon(1e-5));
  CHECK(end("--parameters a.json --set store.q=1 --set R=2") == Approx(std::exp(-0.5)).epsilon(1e-5));
  // a file goes before the scene as well
  CHECK(end("--scene wrong --parameters a.json") == Approx(3.0 * std::exp(-0.5)).epsilon(1e-5));
  const Outcome pipe = here.bgsim("decay.json --quiet --parameters /dev/stdin -o out.csv", "< a.json");
  CHECK(pipe.code == 0);
}

TEST_CASE("faults in a file of parameters are shown in that file") {
  const Workplace here;
  const auto fault = [&](const std::string& text) {
    here.write("p.json", text);
    const Outcome run = here.bgsim("decay.json --parameters p.json");
    CAPTURE(text, run.err);
    CHECK(run.code == 1);
    CHECK_FALSE(here.has("decay.first.csv"));
    return run.err;
  };
  CHECK_THAT(fault("{ \"r\": 1 }"), Contains("p.json:1:3: error BG190") && Contains("did you mean \"R\"?"));
  CHECK_THAT(fault("{ \"R\": { \"valeu\": 1 } }"), Contains("BG111") && Contains("\"value\""));
  CHECK_THAT(fault("{ \"R\": { \"unit\": \"ohm\" } }"), Contains("BG112"));
  CHECK_THAT(fault("{ \"R\": \"2*Q\" }"), Contains("BG121"));
  CHECK_THAT(fault("{ \"R\": [1] }"), Contains("BG113"));
  CHECK_THAT(fault("[]"), Contains("BG113"));
  CHECK_THAT(fault("{ \"R\": 1, \"R\": 2 }"), Contains("BG102"));
  CHECK_THAT(fault("{ \"R\": t }"), Contains("BG101"));
  CHECK_THAT(fault("{ \"R\": \"t\" }"), Contains("BG118"));
  here.write("p.json", "{ \"R\": \"C\", \"C\": \"R\" }");
  CHECK_THAT(usage_fault(here, "decay.json --parameters p.json"), Contains("BG132") && Contains("p.json:1:8"));
  CHECK_THAT(fault("{ \"store.q\": { \"value\": 1, \"unit\": \"m\" } }"), Contains("BG191"));
  CHECK_THAT(usage_fault(here, "decay.json --parameters none.json"), Contains("BG190") && Contains("none.json"));
}

TEST_CASE("the unit in a file of parameters is the model's, or is checked as if the model gave it") {
  const Workplace here;
  std::string model = here.read("decay.json");
  const std::string parameters = R"("R": 2, "C": 0.5)";
  model.replace(model.find(parameters), parameters.size(), R"("R": { "value": 2, "unit": "ohm" }, "C": 0.5)");
  here.write("units.json", model);
  const auto check = [&](const std::string& text) {
    here.write("p.json", text);
    return here.bgsim("check units.json --parameters p.json");
  };
  CHECK(check(R"({ "R": { "value": 3, "unit": "V/A" } })").code == 0);
  CHECK_THAT(check(R"({ "R": { "value": 3, "unit": "kohm" } })").err, Contains("BG191") && Contains("\"ohm\""));
  CHECK(check(R"({ "C": { "value": 3, "unit": "F" } })").code == 0);
  const Outcome wrong = check(R"({ "C": { "value": 3, "unit": "H" } })");
  CHECK(wrong.code == 1);
  CHECK_THAT(wrong.err, Contains("BG161") || Contains("BG162"));
}

TEST_CASE("report, trade and reduce take the same changes") {
  const Workplace here;
  here.write("controlled.json", kControlled);
  here.write("p.json", R"({ "R": 3, "x": 0.5 })");
  const std::string changes = " --parameters p.json --stop 0.5 --output heat=drain.e*drain.f --samples 6 --record q,x";
  const Outcome trade = here.bgsim("trade controlled.json --no-picture --budget 1 -o T" + changes);
  CAPTURE(trade.err);
  CHECK(trade.code == 0);
  CHECK_THAT(here.read("T.csv"), Contains("heat"));
  const Outcome reduce = here.bgsim("reduce controlled.json --set gain=2 -o R.json" + changes);
  CAPTURE(reduce.err);
  REQUIRE(reduce.code == 0);
  const auto reduced = nlohmann::json::parse(here.read("R.json"));
  const auto& scene = reduced["scenes"]["main"];
  CHECK(scene["parameters"] == nlohmann::json{{"R", 3}, {"gain", 2}});
  CHECK(scene["initial"] == nlohmann::json{{"x", 0.5}});
  CHECK(reduced["outputs"].size() == 3);
  CHECK(here.bgsim("verify R.json").code == 0);
  CHECK(bgsim::parse_csv(here.read("R.reference.csv")).columns[0].size() == 6);
  const Outcome report = here.bgsim("report controlled.json --quiet -o R.html" + changes);
  CAPTURE(report.err);
  if (report.code != 2) {  // 2: built without uPlot, and said so
    CHECK(report.code == 0);
    CHECK_THAT(here.read("R.html"), Contains("--parameters p.json --stop 0.5") && Contains("x begins at 0.5"));
  }
}

TEST_CASE("scenes with listed and logarithmic times are run, verified, measured and reduced") {
  const Workplace here;
  std::string model = here.read("decay.json");
  const std::string first = R"("stop": 1, "samples": 3, "reference": { "file": "decay.csv", "relative": 1e-5 } },)";
  REQUIRE(model.find(first) != std::string::npos);
  here.write("listed.json", std::string(model).replace(model.find(first), first.size(),
                                                       R"("stop": 1, "times": [0.25, "C", 0.75] },)"));
  here.write("log.json", std::string(model).replace(model.find(first), first.size(),
                                                    R"("stop": 1, "samples": { "log": 4, "from": 1e-3 } },)"));
  for (const auto& [file, times] : {std::pair{"listed.json", std::vector<double>{0.25, 0.5, 0.75}},
                                    {"log.json", std::vector<double>{1e-3, 1e-2, 1e-1, 1.0}}}) {
    CAPTURE(file);
    CHECK(here.bgsim(std::string(file) + " --quiet -o out.csv").code == 0);
    const auto trace = bgsim::parse_csv(here.read("out.csv"));
    CHECK(trace.columns[0] == times);
    for (std::size_t i = 0; i < times.size(); ++i)
      CHECK(trace.columns[1][i] == Approx(std::exp(-times[i])).epsilon(1e-5));
    const Outcome reduce = here.bgsim("reduce " + std::string(file) + " -o reduced.json");
    CAPTURE(reduce.err);
    CHECK(reduce.code == 0);
    CHECK(here.bgsim("verify reduced.json").code == 0);
    CHECK(here.bgsim("trade " + std::string(file) + " --no-picture --budget 1 --quiet -o T").code == 0);
  }
}
