// bgsim trade: files, table, pick, refusals.
#include <catch2/catch.hpp>

#include "command.hpp"

using Catch::Contains;

TEST_CASE("a trade writes its table and page, prints the table, and tells the setting for an accuracy") {
  const Workplace here;
  const Outcome trade = here.bgsim("trade decay.json --no-picture --budget 2 --accuracy 1e-3");
  CHECK(trade.code == 0);
  CHECK_THAT(trade.out, Contains("reference: --method "));
  CHECK_THAT(trade.out, Contains("accuracy 0.001: --method "));
  CHECK_THAT(here.read("decay.first.trade.csv"), Catch::StartsWith("method,"));
  CHECK_THAT(here.read("decay.first.trade.json"), Contains("\"rows\""));
  CHECK_THAT(here.read("decay.first.trade.html"), Contains("<table>"));
  CHECK_FALSE(here.has("decay.first.trade.svg"));
}

TEST_CASE("files of a trade are named by -o, and --quiet prints nothing") {
  const Workplace here;
  const Outcome trade = here.bgsim("trade decay.json --scene longer --no-picture --budget 0.3 -o it --quiet");
  CHECK(trade.code == 0);
  CHECK(trade.out.empty());
  CHECK(trade.err.empty());
  CHECK(here.has("it.csv"));
}

TEST_CASE("an accuracy that no setting of the table reaches is reported with exit code 3") {
  const Workplace here;
  const Outcome trade = here.bgsim("trade decay.json --no-picture --budget 0.3 --accuracy 1e-16");
  CHECK(trade.code == 3);
  CHECK_THAT(trade.err, Contains("no setting of the table reaches the accuracy 1e-16"));
}

TEST_CASE("a model that nothing can be measured on is refused by trade with the reason and exit code 3") {
  const Workplace here;
  const Outcome trade = here.bgsim("trade ring.json --no-picture --budget 0.2 --scene nowhere");
  CHECK(trade.code == 2);
}

TEST_CASE("a run takes the method, its step and its order from the command line") {
  const Workplace here;
  CHECK_THAT(here.bgsim("decay.json --method rk4 --step 0.1").err, Contains("classical Runge-Kutta of order 4"));
  CHECK_THAT(here.bgsim("decay.json --method bdf --max-order 2").err, Contains("CVODE BDF of order up to 2"));
  const Outcome unknown = here.bgsim("decay.json --method rk45");
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Contains("there is no method \"rk45\"; did you mean erk5? There are auto, bdf"));
  const Outcome stepless = here.bgsim("decay.json --method verlet");
  CHECK(stepless.code == 2);
  CHECK_THAT(stepless.err, Contains("needs a fixed step, which is not given"));
}

TEST_CASE("a run with an accuracy finds the setting, tells it, and runs with it") {
  const Workplace here;
  const Outcome run = here.bgsim("decay.json --accuracy 1e-4");
  CHECK(run.code == 0);
  CHECK_THAT(run.err, Contains("accuracy 0.0001: --method "));
  CHECK(here.has("decay.first.csv"));
  const Outcome both = here.bgsim("decay.json --accuracy 1e-4 --method bdf");
  CHECK(both.code == 2);
  CHECK_THAT(both.err, Contains("--accuracy"));
}

TEST_CASE("a run with an accuracy of what has no states is a run") {
  const Workplace here;
  here.write("law.json", R"x({ "bgsim": 1, "name": "law",
    "elements": { "s": { "kind": "Se", "effort": "sin(t)" }, "j": { "kind": "1" }, "r": { "kind": "R", "resistance": 4 } },
    "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "r" } ],
    "outputs": { "f": "r.f" }, "scenes": { "run": { "stop": 1, "times": [0, 1] } } })x");
  const Outcome run = here.bgsim("law.json --accuracy 1e-6 -o law.csv");
  CHECK(run.code == 0);
  CHECK_THAT(run.err, Contains("accuracy 1e-06: there are no states to integrate"));
  CHECK(here.read("law.csv") == "t,f\r\n0,0\r\n1,0.21036774620197413\r\n");  // sin(1)/4
}
