// Dry friction that holds while its limit changes with time: what holds is followed all along a step, however long.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "support/rounds.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A limit of 0.5 + depth cos(frequency t) against a constant pull, which is above the least of it.
struct Dips {
  double frequency, depth, pull;

  [[nodiscard]] double limit(double t) const { return 0.5 + depth * std::cos(frequency * t); }
  [[nodiscard]] std::string text() const {
    return "(0.5 + " + std::to_string(depth) + "*cos(" + std::to_string(frequency) + "*t))";
  }
  /// How far a mass of 1 slides up to @p stop. It breaks loose where the limit falls below the pull, and holds again
  /// where the speed comes back to 0.
  [[nodiscard]] double slides_by(double stop) const {
    const double angle = std::acos((pull - 0.5) / depth);
    double way = 0.0;
    for (int turn = 0;; ++turn) {
      const double from = (2.0 * M_PI * turn + angle) / frequency;
      if (from > stop) return way;
      const auto speed = [&](double t) {
        return (pull - 0.5) * (t - from) - depth / frequency * (std::sin(frequency * t) - std::sin(frequency * from));
      };
      double low = (2.0 * M_PI * (turn + 1) - angle) / frequency, high = low;
      while (speed(high) > 0.0) high += 0.01;
      while (high - low > 1e-13) (speed((low + high) / 2) > 0.0 ? low : high) = (low + high) / 2;
      const double to = std::min(high, stop), d = to - from;
      way += (pull - 0.5) * d * d / 2 +
             depth / (frequency * frequency) * (std::cos(frequency * to) - std::cos(frequency * from)) +
             depth / frequency * std::sin(frequency * from) * d;
    }
  }
};

/// One block under its brake.
std::string block(const Dips& dips, const std::string& law) {
  return R"j({ "bgsim": 1, "name": "block", "signals": { "x": { "integral": "n.f" } }, "elements": {
      "n": { "kind": "1" }, "mass": { "kind": "I", "inertance": 1 }, "pull": { "kind": "Se", "effort": )j" +
         std::to_string(dips.pull) + R"j( }, "brake": { "kind": "MR", "law": "e = )j" + dips.text() + "*" + law +
         R"j(" } },
    "bonds": [ { "from": "n", "to": "mass" }, { "from": "pull", "to": "n" }, { "from": "n", "to": "brake" } ],
    "outputs": { "x": "x" }, "scenes": { "main": { "stop": 10, "samples": 11 } } })j";
}

/// Two blocks of 0.25 and 0.75 that a clutch holds together, the pull on one of them and the brake on the other; beside
/// the pull two dampers in series, one of them nonlinear, that carry nothing to speak of.
std::string tied_blocks(const Dips& dips, bool loop) {
  const std::string with_loop = loop ? R"j(, "line": { "kind": "0" }, "d1": { "kind": "R", "resistance": 1e-9 },
      "d2": { "kind": "R", "law": "e = 1e-9*(f + f^3)" })j"
                                     : "";
  const std::string bonds = loop ? R"(, { "from": "n0", "to": "line" }, { "from": "line", "to": "d1" },
      { "from": "line", "to": "d2" })"
                                 : "";
  return R"j({ "bgsim": 1, "name": "blocks", "signals": { "x": { "integral": "n1.f" } }, "elements": {
      "n0": { "kind": "1" }, "m0": { "kind": "I", "inertance": 0.25 }, "n1": { "kind": "1" },
      "m1": { "kind": "I", "inertance": 0.75 }, "pull": { "kind": "Se", "effort": )j" +
         std::to_string(dips.pull) + R"j( }, "h": { "kind": "0" }, "grip": { "kind": "R", "law": "e = 3*sign(f)" },
      "brake": { "kind": "MR", "law": "e = )j" +
         dips.text() + R"j(*sign(f)" })j" + with_loop + R"j( },
    "bonds": [ { "from": "n0", "to": "m0" }, { "from": "pull", "to": "n0" }, { "from": "n0", "to": "h" },
      { "from": "h", "to": "grip" }, { "from": "h", "to": "n1" }, { "from": "n1", "to": "m1" },
      { "from": "n1", "to": "brake" })j" +
         bonds + R"j( ], "outputs": { "x": "x" }, "scenes": { "main": { "stop": 10, "samples": 11 } } })j";
}

/// A number of four digits behind the point, as the text has it.
double rounded(double value) { return std::round(1e4 * value) / 1e4; }

Dips random_dips(std::mt19937& random) {
  std::uniform_real_distribution<double> frequency(1.0, 6.0), depth(0.3, 0.49), above(1.01, 1.5);
  Dips dips{rounded(frequency(random)), rounded(depth(random)), 0.0};
  dips.pull = rounded((0.5 - dips.depth) * above(random));
  return dips;
}

constexpr Method kMethods[] = {Method::automatic, Method::bdf,  Method::ida,
                               Method::rodas5p,   Method::erk5, Method::dirk5};

}  // namespace

TEST_CASE("a brake whose limit dips below what it holds lets go each time") {
  // Nothing moves while it holds, so steps are as long as the scene allows: times at which it slides were passed over.
  // They are found to the doubles; the way is integrated: `dirk5` is off by up to 1.1e-4 of it at 1e-6.
  std::mt19937 random(15);
  for (std::uint64_t round = 0; round < share_of(40); ++round) {
    const Dips dips = random_dips(random);
    const double expected = dips.slides_by(10.0);
    for (const Method method : kMethods)
      for (const std::string law : {"sign(f)", "if(f > 0, 1, -1)", "(2*step(f) - 1)"}) {
        INFO(block(dips, law) << " by " << method_name(method));
        const RunResult run = run_text(block(dips, law), with_method(method), one_run());
        REQUIRE(run.stop == StopReason::completed);
        CHECK(std::abs(last(run, "x") - expected) <= 2e-4 * expected);
      }
  }
}

TEST_CASE("two clutches that hold, one of which dips, let go each time, also beside a loop") {
  std::mt19937 random(16);
  for (std::uint64_t round = 0; round < share_of(20); ++round) {
    const Dips dips = random_dips(random);
    const double expected = dips.slides_by(10.0);
    for (const bool loop : {false, true})
      for (const Method method : kMethods) {
        INFO(tied_blocks(dips, loop) << " by " << method_name(method));
        const RunResult run = run_text(tied_blocks(dips, loop), with_method(method), one_run());
        REQUIRE(run.stop == StopReason::completed);
        CHECK(std::abs(last(run, "x") - expected) <= 2e-4 * expected);
      }
  }
}
