// What `auto` chooses, and what becomes of a run where the choice does not get on.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A store of 1 that a signal empties.
std::string emptied(const std::string& law) {
  return R"({ "bgsim": 1, "name": "store", "elements": { "j": { "kind": "0" },
      "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } }, "s": { "kind": "MSf", "flow": ")" +
         law + R"(" } },
      "bonds": [ { "from": "s", "to": "j" }, { "from": "j", "to": "c" } ],
      "outputs": { "q": "c.q" }, "scenes": { "main": { "stop": 100, "samples": 101 } } })";
}

/// A mass of 1 under a force of 6 sin t, with friction of 5.
std::string rubbed(const std::string& friction) {
  return R"json({ "bgsim": 1, "name": "mass", "elements": { "j": { "kind": "1" },
      "m": { "kind": "I", "inertance": 1, "initial": { "p": 1 } }, "r": { "kind": "R", "law": "e = )json" +
         friction + R"json(" }, "s": { "kind": "Se", "effort": "6*sin(t)" } },
      "bonds": [ { "from": "j", "to": "m" }, { "from": "j", "to": "r" }, { "from": "s", "to": "j" } ],
      "outputs": { "v": "m.f" }, "scenes": { "main": { "stop": 100, "samples": 101 } } })json";
}

}  // namespace

TEST_CASE("a store that a signal has emptied rests, whatever the law's slope there") {
  // q = (1 - t/20)^2 up to t = 20, or what the other laws give; then 0 or 0.3. Some laws cross the border again and
  // again by rounding, each time with the law of the wrong side continued.
  const std::string law = GENERATE("-sign(c.q)*sqrt(abs(c.q))/10", "-sign(c.q)*abs(c.q)^(1/3)/10",
                                   "if(c.q > 0, -sqrt(abs(c.q)), sqrt(abs(c.q)))/10", "-c.q/sqrt(abs(c.q) + 1e-30)/10",
                                   "-ssqrt(c.q, 1e-12)/10", "-cbrt(c.q)/10");
  const double relative = GENERATE(1e-3, 1e-6);
  INFO(law << " at " << relative);
  const RunResult result = run_text(emptied(law), with_relative(relative));
  REQUIRE(result.stop == StopReason::completed);
  CHECK(std::abs(last(result, "q")) < 2.0 * relative);  // of what the store has held
  CHECK(result.report.steps < 5000);                    // most need 30; half a million by Radau
}

TEST_CASE("a run by Radau whose condition changes within the tolerances goes on by BDF, and says so") {
  const RunResult result = run_text(emptied("if(c.q > 0, -sqrt(abs(c.q)), 2*sqrt(abs(c.q)))/10"), with_relative(1e-6));
  CHECK(result.report.method == "CVODE BDF, dense");
  CHECK(result.report.method_reason.find("by BDF from t = ") != std::string::npos);
  // What jumps at its border still chatters.
  const RunResult relay = run_text(emptied("-sign(c.q)/10"), with_relative(1e-6));
  REQUIRE(relay.stop == StopReason::failed);
  CHECK(relay.failure->code == "BG604");
}

TEST_CASE("friction smoothed over less than its tolerance is run by Radau as dry friction is") {
  // Coulomb's friction, whose moments of sticking and slipping are events.
  const RunResult dry = run_text(rubbed("5*sign(f)"), with_relative(1e-9));
  REQUIRE(dry.stop == StopReason::completed);
  struct Smoothed {
    const char* friction;
    double relative, margin;
  };
  // Of a velocity of 1. What a smooth layer of 1e-6 differs by is of that size. A layer of a hundredth of the tolerance
  // leaves the moment open at which the mass begins to slide, and the run says how wrong it may be; BDF comes to a
  // velocity of 100 there.
  const Smoothed given = GENERATE(values<Smoothed>(
      {{"5*tanh(f/1e-6)", 1e-7, 1e-4}, {"5*f/sqrt(f^2 + 1e-12)", 1e-7, 1e-4}, {"5*tanh(f/1e-8)", 1e-6, 0.5}}));
  INFO(given.friction);
  const RunResult smooth = run_text(rubbed(given.friction), with_relative(given.relative));
  REQUIRE(smooth.stop == StopReason::completed);
  CHECK(smooth.report.method == "Radau IIA of order 5, dense");
  CHECK(smooth.report.steps < 3000);
  double worst = 0.0;
  for (std::size_t i = 0; i < dry.trace.times.size(); ++i)
    worst = std::max(worst, std::abs(smooth.trace["v"][i] - dry.trace["v"][i]));
  CHECK(worst < given.margin);
  if (given.margin > 0.1) CHECK(!smooth.report.notes.empty());
}
