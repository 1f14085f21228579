// Laws with a jump at one border, however they are written: several conditions, products of signs, a sign within a
// nonlinear expression. What holds the border is a value between those of the two sides.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A block on a spring, that breaks loose, comes to rest and turns back under a force.
std::string block(const std::string& law, const std::string& force, const std::string& speed) {
  return R"j({ "bgsim": 1, "name": "block", "signals": { "mu": "if(s.q > 0.2, 0.7, 0.5)",
      "dir": "sign(n.f)", "side": "if(m.p > 0, 0.5, 1)", "three": "if(n.f > 0, 1, if(n.f < 0, -1, 0))" }, "elements": {
      "n": { "kind": "1" }, "m": { "kind": "I", "inertance": 1.3, "initial": { "f": )j" +
         speed + R"j( } }, "s": { "kind": "C", "capacitance": 0.4 }, "F": { "kind": "Se", "effort": ")j" + force +
         R"j(" }, "r": { "kind": "MR", "law": "e = )j" + law + R"j(" } },
    "bonds": [ { "from": "F", "to": "n" }, { "from": "n", "to": "m" }, { "from": "n", "to": "s" },
      { "from": "n", "to": "r" } ],
    "outputs": { "v": "n.f", "x": "s.q" }, "scenes": { "main": { "stop": 8, "samples": 81 } } })j";
}

}  // namespace

TEST_CASE("a law with one border runs the same however it is written") {
  struct Spelling {
    std::string plain, other;
  };
  const Spelling spellings[] = {
      {"0.8*sign(f)", "if(f > 0, 0.8, if(f < 0, -0.8, 0))"},
      {"0.8*sign(f)", "if(f < 0, -0.8, if(f > 0, 0.8, 0))"},
      {"0.8*sign(f)", "if(f <= 0, if(f >= 0, 0, -0.8), 0.8)"},
      {"0.8*sign(f)", "0.8*step(f) - 0.8*step(-f)"},
      {"0.8*sign(f)", "0.8*(2*step(f) - 1)"},
      {"0.8*sign(f)", "if(0 >= f, -0.8, 0.8)"},
      {"0.8*sign(f)", "0.8*sign(f)*sign(f)*sign(f)"},
      {"if(f > 0, 0.5, -1)", "sign(f)*if(f >= 0, 0.5, 1)"},
      {"if(f > 0, 0.5, -1)", "if(f > 0, 1, -2)*if(f > 0, 0.5, 0.5)"},
      {"if(f > 0, 0.5, -1)", "if(f > 0, 0.5, if(f < 0, -1, 0))"},
      {"0.25 + 0.75*sign(f)", "max(sign(f), -0.5)"},
      {"0.25 + 0.75*sign(f)", "sign(f)*(0.75 + 0.25*sign(f))"},
      {"if(f > 0, exp(0.8) - 1, exp(-0.8) - 1)", "exp(0.8*sign(f)) - 1"},
      {"if(f > 0, exp(0.8) - 1, exp(-0.8) - 1)", "exp(0.8*(2*step(f) - 1)) - 1"},
      {"if(f > 0, 1, -0.5)*mu", "if(f > 0, mu, if(f < 0, -0.5*mu, 0))"},
      {"if(f > 0, 0.5 + 0.4*exp(-f), -0.7)", "if(f > 0, 0.5 + 0.4*exp(-f), if(f < 0, -0.7, 0))"},
      {"0.8*sign(f)", "if(0 < 2*m.p, 0.8, if(-3*f > 0, -0.8, 0))"},
      {"if(f > 0, 0.5, -1)", "if(0 > -f/2, 0.5, 1)*if(0 > f*3, -1, 1)"},
      {"0.8*sign(f)", "0.8*dir"},
      {"0.8*sign(f)", "0.8*three"},
      {"if(f > 0, 0.5, -1)", "side*sign(f)"},
      {"(s.q^2 + 0.3)*sign(f)", "if(f > 0, s.q^2 + 0.3, if(f < 0, -s.q^2 - 0.3, 0))"},
  };
  struct Drive {
    std::string force, speed;
  };
  // From rest either way; from a speed; at the limit of what friction holds.
  const Drive drives[] = {
      {"2.1*sin(1.3*t)", "0"}, {"-2.1*sin(1.3*t)", "0"}, {"1.2*cos(2.1*t)", "0.9"}, {"-3", "0"}, {"3", "0"},
      {"0.8 - 0.4*t", "0"}};
  for (const Spelling& spelling : spellings)
    for (const Drive& drive : drives) {
      const auto run_of = [&drive](const std::string& law, Method method) {
        return run_text(block(law, drive.force, drive.speed), with_method(method, 1e-8), one_run());
      };
      const RunResult plain = run_of(spelling.plain, Method::automatic);
      REQUIRE(plain.stop == StopReason::completed);
      const std::vector<double> speed = column(plain, "v");
      for (const Method method : {Method::automatic, Method::bdf, Method::erk5, Method::rodas5p, Method::ida}) {
        INFO(spelling.other << " under " << drive.force << " from " << drive.speed << " by " << method_name(method));
        const RunResult run = run_of(spelling.other, method);
        REQUIRE(run.stop == StopReason::completed);
        const std::vector<double> other = column(run, "v");
        double largest = 0.1, off = 0.0;
        for (std::size_t i = 0; i < speed.size(); ++i) {
          largest = std::max(largest, std::abs(speed[i]));
          off = std::max(off, std::abs(other[i] - speed[i]));
        }
        // Some hundred tolerances of both runs, as multistep methods leave them.
        CHECK(off <= 3e-6 * largest);
        for (const std::string& note : run.report.notes) CHECK(note.find("indefinite") == std::string::npos);
      }
    }
}

TEST_CASE("a staircase of forty borders, each said twice, is held at each of them") {
  // A tank whose valve opens by a step at each level, with less flow than the next step lets out.
  std::string plain, twice;
  for (int k = 1; k <= 40; ++k) {
    const std::string level = std::to_string(k) + "/10";
    plain += (k == 1 ? "" : " + ") + ("0.05*step(e - " + level + ")");
    twice += (k == 1 ? "" : " + ") + ("if(e > " + level + ", 0.05, if(e < " + level + ", 0, 0.025))");
  }
  const auto tank = [](const std::string& law) {
    return R"j({ "bgsim": 1, "name": "stairs", "elements": { "n": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1 },
      "in": { "kind": "Sf", "flow": "1.02 + 0.9*sin(0.5*t)" }, "valve": { "kind": "R", "law": "f = )j" +
           law + R"j(" } }, "bonds": [ { "from": "in", "to": "n" }, { "from": "n", "to": "c" },
      { "from": "n", "to": "valve" } ], "outputs": { "e": "c.e" }, "scenes": { "main": { "stop": 20, "samples": 81 } } })j";
  };
  const RunResult one = run_text(tank(plain), with_relative(1e-8), one_run());
  REQUIRE(one.stop == StopReason::completed);
  for (const Method method : {Method::automatic, Method::bdf, Method::rodas5p}) {
    INFO(method_name(method));
    const RunResult other = run_text(tank(twice), with_method(method, 1e-8), one_run());
    REQUIRE(other.stop == StopReason::completed);
    const std::vector<double> a = column(one, "e"), b = column(other, "e");
    for (std::size_t i = 0; i < a.size(); ++i) CHECK(std::abs(a[i] - b[i]) <= 3e-6 * 4.0);  // of the range, as above
  }
}
