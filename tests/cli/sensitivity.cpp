// bgsim sensitivity: the table, the file, refusals.
#include <catch2/catch.hpp>

#include "command.hpp"

using Catch::Contains;

namespace {

const char* const kModel = R"({ "bgsim": 1, "name": "rc",
  "parameters": { "R": { "value": 2, "unit": "ohm" }, "C": { "value": 0.5, "unit": "F" }, "tau": "R*C" },
  "elements": { "s": { "kind": "Se", "effort": 3 }, "loop": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" },
    "c": { "kind": "C", "capacitance": "C" } },
  "bonds": [ { "from": "s", "to": "loop" }, { "from": "loop", "to": "r" }, { "from": "loop", "to": "c" } ],
  "outputs": { "u": { "value": "c.e", "unit": "V" }, "i": { "value": "r.f", "unit": "A" } },
  "scenes": { "charge": { "stop": 4, "samples": 3, "relative": 1e-9 }, "hold": { "stop": 1, "parameters": { "R": "4*C" } } } })";

Workplace& with_model(Workplace& here) {
  here.write("rc.json", kModel);
  return here;
}

}  // namespace

TEST_CASE("a table of sensitivities begins with what matters most") {
  Workplace here;
  const Outcome all = with_model(here).bgsim("sensitivity rc.json --of u --to c.q,R -o du.csv");
  CAPTURE(all.err);
  CHECK(all.code == 0);
  // u = 3 (1 - exp(-4)): du/dR = -3 exp(-4) 4/R, du/dq0 = exp(-4)/C
  CHECK_THAT(all.out, Contains("u = 2.94505308 V at t = 4") && Contains("-0.109893833") && Contains("V/ohm") &&
                          Contains("0.0366312778"));
  CHECK(all.out.find("\nR ") < all.out.find("\nc.q "));
  CHECK_THAT(here.read("du.csv"), Catch::StartsWith("t,u,d(u)/d(c.q),d(u)/d(R)\r\n0,0,2,0\r\n"));
}

TEST_CASE("by default sensitivities are those of the outputs of the scene to all parameters that are numbers") {
  Workplace here;
  const Outcome all = with_model(here).bgsim("sensitivity rc.json --norm rms --quiet");
  CHECK(all.code == 0);
  CHECK_THAT(all.out,
             Contains("rms of u") && Contains("rms of i") && Contains("\nR ") && Contains("\nC ") && !Contains("tau"));
  // What a scene gives follows: R = 4 C.
  const Outcome hold = here.bgsim("sensitivity rc.json --scene hold --of u --to C --relative 1e-10");
  // R C = 4 C^2 = 1, and u = 3 (1 - exp(-1/(4 C^2))) at t = 1: du/dC = -3 exp(-1) 2/(4 C^3)
  CHECK_THAT(hold.out, Contains("-4.41455329"));
  const Outcome twice = here.bgsim("sensitivity rc.json --of u,double=2*c.e --to R --quiet");
  CHECK_THAT(twice.out, Contains("double = "));
}

TEST_CASE("of all parameters those without a derivative are named, and refused where they are asked for") {
  Workplace here;
  // At the end of the scene the switch has just closed again: with a longer period it would not have.
  here.write("chop.json", R"({ "bgsim": 1, "name": "chop", "parameters": { "T": 0.5, "R": 2 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "w": { "kind": "Sw", "closed": "mod(t, T) < 0.2" },
      "one": { "kind": "1" }, "r": { "kind": "R", "resistance": "R" }, "n": { "kind": "0" },
      "c": { "kind": "C", "capacitance": 1 }, "leak": { "kind": "R", "resistance": 3 } },
    "bonds": [ { "from": "s", "to": "one" }, { "from": "one", "to": "w" }, { "from": "one", "to": "r" },
      { "from": "one", "to": "n" }, { "from": "n", "to": "c" }, { "from": "n", "to": "leak" } ],
    "outputs": { "q": "c.q" }, "scenes": { "s": { "stop": 2 } } })");
  for (const std::string method : {"forward", "differences"}) {
    const Outcome all = here.bgsim("sensitivity chop.json --quiet --method " + method);
    CAPTURE(method, all.out, all.err);
    CHECK(all.code == 0);
    CHECK_THAT(all.out, Contains("\nR ") && !Contains("\nT ") && Contains("\nno derivative by T: "));
    const Outcome one = here.bgsim("sensitivity chop.json --quiet --to R,T --method " + method);
    CHECK(one.code == 1);
    CHECK_THAT(one.err, Contains("BG414"));
  }
  // The mean does not see it.
  CHECK_THAT(here.bgsim("sensitivity chop.json --quiet --norm mean").out,
             Contains("\nT ") && !Contains("no derivative"));
}

TEST_CASE("by the adjoint equations, and by differences of runs, comes the same table") {
  Workplace here;
  const Outcome forward = with_model(here).bgsim("sensitivity rc.json --norm integral --method forward,radau --quiet");
  const Outcome adjoint = here.bgsim("sensitivity rc.json --norm integral --method adjoint,radau --quiet");
  const Outcome differences = here.bgsim("sensitivity rc.json --norm integral --method differences,radau --quiet");
  CAPTURE(forward.err, adjoint.err);
  CHECK(adjoint.code == 0);
  // Of u: 3 (T - tau (1 - e^-T/tau)), by R: -3 (dtau/dR) (1 - e^-4 (1 + 4)) = -1.36263.
  for (const Outcome* each : {&forward, &adjoint, &differences})
    CHECK_THAT(each->out, Contains("integral of u = 9.05494692 V*s\n") && Contains("-1.362632") && Contains("V*s/ohm"));
  CHECK(here.bgsim("sensitivity rc.json --method adjoint --norm final -o s.svg").code == 0);
}

TEST_CASE("what cannot be derived is refused with a reason") {
  Workplace here;
  with_model(here);
  const auto refused = [&](const std::string& arguments, int code, const std::string& part) {
    const Outcome outcome = here.bgsim("sensitivity " + arguments);
    CAPTURE(arguments, outcome.err);
    CHECK(outcome.code == code);
    CHECK_THAT(outcome.err, Contains(part));
    CHECK(outcome.out.empty());
  };
  refused("rc.json --to Q", 2, "BG413");
  refused("rc.json --to u", 2, "is an output");
  refused("rc.json --to R,R", 2, "twice");
  refused("rc.json --of nothing", 2, "BG121");
  refused("rc.json --norm largest", 2, "--norm");
  refused("rc.json --to R -o du.txt", 2, ".csv or .svg");
  refused("rc.json --to R --scene none", 2, "BG140");
  refused("rc.json --to R --max-steps 3", 3, "BG607");
  refused("rc.json --to R --method adjoint,forward", 2, "more than one of forward, adjoint and differences");
  refused("rc.json --to R --method adjoit", 2, "no method \"adjoit\"");
  refused("rc.json --to R --method adjoint -o du.csv", 2, "--method forward");
  refused("rc.json --to R --method adjoint --max-steps 3", 3, "BG607");
  refused("", 2, "model.json");
  here.write("switched.json", R"({ "bgsim": 1, "name": "w", "parameters": { "k": 1 },
    "elements": { "s": { "kind": "Se", "effort": 1 }, "w": { "kind": "Sw", "closed": "t > 1" }, "one": { "kind": "1" },
      "r": { "kind": "R", "resistance": "k" }, "c": { "kind": "C", "capacitance": 1 } },
    "bonds": [ { "from": "s", "to": "one" }, { "from": "one", "to": "w" }, { "from": "one", "to": "r" },
      { "from": "one", "to": "c" } ], "outputs": { "q": "c.q" }, "scenes": { "s": { "stop": 2 } } })");
  refused("switched.json --to k --method adjoint", 1, "BG414");
  // q = 1 - exp(-1/k) since the switch opens at 1.
  CHECK_THAT(here.bgsim("sensitivity switched.json --to k").out, Contains("-0.3678794"));
}

TEST_CASE("a picture shows what one per cent of each parameter does, also where outputs or parameters are 0") {
  Workplace here;
  const Outcome drawn =
      with_model(here).bgsim("sensitivity rc.json --of u --of none=0*c.e --to c.q,R -o du.csv -o du.svg");
  CAPTURE(drawn.err);
  CHECK(drawn.code == 0);
  CHECK(here.has("du.csv"));
  CHECK_THAT(here.read("du.svg"), Catch::Contains("<svg") && Catch::Contains("change in % for 1 %"));
}
