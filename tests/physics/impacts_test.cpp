// Several impacts at one instant: one after the other, or at once.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <sstream>
#include <vector>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// Balls of these masses in a row that touch, with these speeds to the right, and a wall behind the last one if asked
/// for.
std::string row_of_balls(const std::vector<double>& masses, const std::vector<double>& speeds,
                         const std::string& restitution, const std::string& impacts, bool wall = false,
                         const std::string& gap = "0") {
  std::ostringstream elements, bonds, outputs;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    elements << (i == 0 ? "" : ", ") << "\"j" << i << R"(": {"kind": "1"}, "m)" << i
             << R"(": {"kind": "I", "inertance": )" << masses[i] << R"(, "initial": {"f": )" << speeds[i] << "}}";
    bonds << (i == 0 ? "" : ", ") << R"({"from": "j)" << i << R"(", "to": "m)" << i << "\"}";
    outputs << (i == 0 ? "" : ", ") << "\"v" << i << R"(": "m)" << i << ".f\"";
    if (i == 0) continue;
    elements << ", \"z" << i << R"(": {"kind": "0"}, "c)" << i << R"(": {"kind": "contact", "gap": )" << gap
             << R"(, "restitution": )" << restitution << "}";
    bonds << R"(, {"from": "j)" << i - 1 << R"(", "to": "z)" << i << R"("}, {"from": "z)" << i << R"(", "to": "j)" << i
          << R"("}, {"from": "z)" << i << R"(", "to": "c)" << i << "\"}";
  }
  if (wall) {
    elements << R"(, "w": {"kind": "contact", "gap": )" << gap << R"(, "restitution": )" << restitution << "}";
    bonds << R"(, {"from": "j)" << masses.size() - 1 << R"(", "to": "w"})";
  }
  return R"({"bgsim": 1, "name": "row", "elements": {)" + elements.str() + R"(}, "bonds": [)" + bonds.str() +
         R"(], "outputs": {)" + outputs.str() + R"(}, "scenes": {"run": {"stop": 1, "samples": 2, "impacts": ")" +
         impacts + "\"}}}";
}

RunResult completed(const std::string& text) {
  RunResult result = Study::from_text(text).scene().simulate(untimed());
  INFO((result.failure ? result.failure->situation : ""));
  REQUIRE(result.stop == StopReason::completed);
  return result;
}

std::vector<double> speeds_after(const RunResult& result) {
  std::vector<double> speeds;
  for (const auto& column : result.trace.columns) speeds.push_back(column.back());
  return speeds;
}

void check_speeds(const RunResult& result, const std::vector<double>& expected, double margin = 1e-14) {
  const std::vector<double> speeds = speeds_after(result);
  REQUIRE(speeds.size() == expected.size());
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    INFO("ball " << i);
    CHECK(speeds[i] == Approx(expected[i]).margin(margin));
  }
}

/// The rule itself: of the pairs that close the fastest one first, until none does.
std::vector<double> one_after_the_other(const std::vector<double>& masses, std::vector<double> v, double e) {
  for (int impact = 0; impact < 100000; ++impact) {
    std::size_t fastest = 0;
    double closing = 1e-13;
    for (std::size_t i = 0; i + 1 < v.size(); ++i)
      if (v[i] - v[i + 1] > closing * (1 + 1e-12)) closing = v[i] - v[i + 1], fastest = i + 1;
    if (fastest == 0) break;
    const double a = masses[fastest - 1], b = masses[fastest], p = (1 + e) * closing * a * b / (a + b);
    v[fastest - 1] -= p / a;
    v[fastest] += p / b;
  }
  return v;
}

constexpr double kGravity = 9.81;

/// Balls above each other over a floor, from below, each with its fall to the one below it.
struct Pile {
  std::vector<double> masses, restitutions, falls;
};

std::string pile_model(const Pile& pile, const std::string& impacts, double stop) {
  std::ostringstream elements, bonds, outputs;
  elements.precision(17);
  for (std::size_t i = 0; i < pile.masses.size(); ++i) {
    const std::string comma = i == 0 ? "" : ", ";
    elements << comma << "\"j" << i << R"(": {"kind": "1"}, "m)" << i << R"(": {"kind": "I", "inertance": )"
             << pile.masses[i] << R"(}, "g)" << i << R"(": {"kind": "Se", "effort": )" << kGravity * pile.masses[i]
             << R"(}, "c)" << i << R"(": {"kind": "contact", "gap": 0, "restitution": )" << pile.restitutions[i]
             << R"(, "initial": {"q": )" << -pile.falls[i] << "}}";
    bonds << comma << R"({"from": "g)" << i << R"(", "to": "j)" << i << R"("}, {"from": "j)" << i << R"(", "to": "m)"
          << i << "\"}, ";
    outputs << comma << "\"q" << i << R"(": "c)" << i << ".q\"";
    if (i == 0) {
      bonds << R"({"from": "j0", "to": "c0"})";
      continue;
    }
    elements << ", \"z" << i << R"(": {"kind": "0"})";
    bonds << R"({"from": "j)" << i << R"(", "to": "z)" << i << R"("}, {"from": "z)" << i << R"(", "to": "j)" << i - 1
          << R"("}, {"from": "z)" << i << R"(", "to": "c)" << i << "\"}";
  }
  return R"({"bgsim": 1, "name": "pile", "elements": {)" + elements.str() + R"(}, "bonds": [)" + bonds.str() +
         R"(], "outputs": {)" + outputs.str() + R"(}, "scenes": {"run": {"stop": )" + std::to_string(stop) +
         R"(, "samples": 201, "impacts": ")" + impacts + "\"}}}";
}

/// The pile impact by impact: between two of them all balls fall alike.
struct FallingPile {
  std::vector<long double> heights, speeds;  ///< upwards
  long double t = 0;

  explicit FallingPile(const Pile& pile) : speeds(pile.masses.size(), 0) {
    long double height = 0;
    for (const double fall : pile.falls) heights.push_back(height += fall);
  }
  void fly(long double h) {
    t += h;
    for (std::size_t i = 0; i < heights.size(); ++i) {
      heights[i] += speeds[i] * h - kGravity * h * h / 2;
      speeds[i] -= kGravity * h;
    }
  }
  /// To the next impact, or to @p stop if that comes before. False: to the latter.
  bool next(const Pile& pile, long double stop) {
    std::size_t who = 0;
    long double after = (speeds[0] + std::sqrt(speeds[0] * speeds[0] + 2 * kGravity * heights[0])) / kGravity;
    for (std::size_t i = 1; i < heights.size(); ++i) {
      const long double closing = speeds[i - 1] - speeds[i], way = std::max(heights[i] - heights[i - 1], 0.0L);
      if (closing > 0 && way / closing < after) after = way / closing, who = i;
    }
    if (t + after > stop) {
      fly(stop - t);
      return false;
    }
    fly(after);
    const long double e = pile.restitutions[who];
    if (who == 0) {
      heights[0] = 0;
      speeds[0] *= -e;
      return true;
    }
    const long double a = pile.masses[who - 1], b = pile.masses[who],
                      impulse = (1 + e) * (speeds[who - 1] - speeds[who]) * a * b / (a + b);
    heights[who] = heights[who - 1];
    speeds[who - 1] -= impulse / a;
    speeds[who] += impulse / b;
    return true;
  }
  [[nodiscard]] long double energy(const Pile& pile) const {
    long double sum = 0;
    for (std::size_t i = 0; i < heights.size(); ++i)
      sum += pile.masses[i] * (speeds[i] * speeds[i] / 2 + kGravity * heights[i]);
    return sum;
  }
};

}  // namespace

TEST_CASE("as many balls leave a cradle as come in, where impacts are sequential", "[long]") {
  for (std::size_t n = 2; n <= 8; ++n)
    for (std::size_t in = 1; in < n; ++in) {
      INFO(in << " of " << n);
      std::vector<double> speeds(n, 0.0), expected(n, 0.0);
      for (std::size_t i = 0; i < in; ++i) speeds[i] = expected[n - 1 - i] = 1.0;
      const RunResult result = completed(row_of_balls(std::vector<double>(n, 0.5), speeds, "1", "sequential"));
      check_speeds(result, expected);
      CHECK(result.report.impacts == in * (n - in));
      CHECK(result.report.energy.impacts == Approx(0.0).margin(1e-14));
    }
}

TEST_CASE("impulses at once give Moreau's answer, and sequential is another one") {
  check_speeds(completed(row_of_balls({1, 1, 1}, {1, 0, 0}, "1", "simultaneous")), {-1.0 / 3, 2.0 / 3, 2.0 / 3});
  check_speeds(completed(row_of_balls({1, 1, 1}, {1, 0, 0}, "1", "sequential")), {0, 0, 1});
}

TEST_CASE("rows of any masses and restitutions follow the rule of the fastest pair") {
  const std::vector<double> masses{1, 3, 0.5, 2, 0.1};
  for (const double e : {1.0, 0.9, 0.5})
    for (const std::vector<double>& speeds :
         std::vector<std::vector<double>>{{1, 0, 0, 0, 0}, {1, 0, 0, 0, -2}, {3, 2, 1, 0, -1}, {0, 1, 0, -1, 0}}) {
      INFO("e = " << e << ", speeds " << speeds[0] << " " << speeds[1] << " " << speeds[4]);
      const RunResult result = completed(row_of_balls(masses, speeds, std::to_string(e), "sequential"));
      // A sequence ends at 1e-9 of the first closing speed, and then at once.
      check_speeds(result, one_after_the_other(masses, speeds, e), 1e-8);
      double p = 0;
      for (std::size_t i = 0; i < masses.size(); ++i) p += masses[i] * (speeds_after(result)[i] - speeds[i]);
      CHECK(p == Approx(0.0).margin(1e-13));
      CHECK(result.report.energy.impacts >= -1e-13);
    }
}

TEST_CASE("infinitely many impacts of one instant come to their limit") {
  // With restitution 0 the three go on together at a third of the speed.
  const RunResult result = completed(row_of_balls({1, 1, 1}, {1, 0, 0}, "0", "sequential"));
  check_speeds(result, {1.0 / 3, 1.0 / 3, 1.0 / 3}, 1e-9);
  CHECK(result.report.energy.impacts == Approx(0.5 - 1.0 / 6).epsilon(1e-9));
  CHECK(result.report.impacts > 10);
  CHECK(result.report.impacts < 100);
}

TEST_CASE("a ball thrown at balls that lean against a wall comes back alone") {
  check_speeds(completed(row_of_balls({1, 1, 1}, {1, 0, 0}, "1", "sequential", true)), {-1, 0, 0});
  check_speeds(
      completed(row_of_balls({1, 1}, {2, 0}, "0.5", "sequential", true)),
      // 2 -> (0.5, 1.5), wall -0.75; closing 1.25 -> 0.5 - 0.9375, -0.75 + 0.9375; wall again, and so on
      [] {
        double a = 2, b = 0;
        for (int i = 0; i < 1000; ++i) {
          if (a > b) {
            const double p = 0.75 * (a - b);
            a -= p, b += p;
          }
          if (b > 0) b *= -0.5;
        }
        return std::vector<double>{a, b};
      }(),
      1e-8);
}

TEST_CASE("impacts at different places of one instant do not touch each other") {
  // Two cradles that strike at once, a little apart from each other in the model: the same as each by itself.
  const RunResult result = completed(row_of_balls({1, 1, 1, 1}, {1, 0, 0, -1}, "1", "sequential"));
  check_speeds(result, {-1, 0, 0, 1});
}

TEST_CASE("a contact that separates as another one closes has no part in the impact") {
  for (const char* const impacts : {"simultaneous", "sequential"}) {
    INFO(impacts);
    // The last one flees; then one that is caught up with at the same instant, by the second impact.
    check_speeds(completed(row_of_balls({1, 1, 1}, {1, 0, 2}, "1", impacts)), {0, 1, 2});
    check_speeds(completed(row_of_balls({1, 1, 1}, {3, 0, 1}, "1", impacts)), {0, 1, 3});
    check_speeds(completed(row_of_balls({1, 1, 1}, {1, 0, 2}, "0.5", impacts)), {0.25, 0.75, 2});
  }
}

TEST_CASE("random rows of balls create no energy, and elastic ones keep it", "[long]") {
  std::mt19937 random(1);
  const auto of = [&random](const std::vector<double>& values) {
    return values[std::uniform_int_distribution<std::size_t>(0, values.size() - 1)(random)];
  };
  for (int round = 0; round < 40; ++round) {
    const std::size_t n = 2 + static_cast<std::size_t>(round % 5);
    std::vector<double> masses, speeds;
    for (std::size_t i = 0; i < n; ++i) {
      masses.push_back(of({0.1, 0.5, 1, 2, 5}));
      speeds.push_back(of({-2, -1, 0, 1, 3}));
    }
    const double e = of({0, 0.2, 0.5, 0.9, 1});
    const bool wall = round % 3 == 0;
    INFO("round " << round << ", restitution " << e);
    // The restitution of each: e, and at contacts that close slowly another one.
    for (const std::string& law : {std::to_string(e), "\"if(f > 1.5, " + std::to_string(e) + ", 0.6)\""}) {
      const RunResult result = completed(row_of_balls(masses, speeds, law, "simultaneous", wall));
      const std::vector<double> after = speeds_after(result);
      double before = 0, left = 0, momentum = 0;
      for (std::size_t i = 0; i < n; ++i) {
        before += masses[i] * speeds[i] * speeds[i] / 2;
        left += masses[i] * after[i] * after[i] / 2;
        momentum += masses[i] * (after[i] - speeds[i]);
        if (i > 0) CHECK(after[i] - after[i - 1] > -1e-12);  // rounding of speeds up to 3
      }
      CHECK(left <= before * (1 + 1e-13));
      if (law == "1.000000") CHECK(left == Approx(before).epsilon(1e-13));
      if (!wall) CHECK(momentum == Approx(0.0).margin(1e-12));
      CHECK(result.report.energy.impacts == Approx(before - left).margin(1e-12 * before));
    }
  }
}

TEST_CASE("balls that fall on each other on a floor come to rest as impact by impact") {
  for (const Pile& pile : {Pile{{0.3, 1}, {0.7, 0.7}, {0.5, 0.1}}, Pile{{0.26, 1}, {0.55, 0.8}, {1, 1}},
                           Pile{{1, 10}, {0.9, 0.9}, {0.5, 0.1}}, Pile{{1, 10.0 / 3}, {0.5, 0.5}, {0.5, 0.1}},
                           Pile{{1, 10.0 / 3, 100.0 / 9}, {0.7, 0.7, 0.7}, {0.5, 0.1, 0.2}}})
    for (const char* const impacts : {"simultaneous", "sequential"}) {
      INFO(pile.masses.size() << " balls, restitution " << pile.restitutions[0] << ", " << impacts);
      FallingPile exact(pile);
      const long double whole = exact.energy(pile);
      while (exact.energy(pile) > 1e-24L * whole) exact.next(pile, 100);
      const double rest = static_cast<double>(exact.t);
      SimulateOptions options = untimed();
      double closed = 0, least = 0;
      options.events = [&](const RunEvent& event) {
        if (event.kind == RunEvent::Kind::contact && event.to == "closed") closed = event.t;
        if (event.kind == RunEvent::Kind::impact) least = std::min(least, event.energy.value_or(0.0));
      };
      const RunResult result = Study::from_text(pile_model(pile, impacts, 1.25 * rest)).scene().simulate(options);
      INFO((result.failure ? result.failure->situation : ""));
      REQUIRE(result.stop == StopReason::completed);
      // At the end contacts close whose flights, some in a row, are within what displacements are resolved to: 1e-9 m,
      // which takes 3e-5 s.
      CHECK(closed == Approx(rest).margin(2e-4));
      CHECK(least >= 0.0);
      // Heights of half a metre and more are resolved to 1e-9 m.
      CHECK(result.report.energy.impacts == Approx(static_cast<double>(whole)).epsilon(2e-9));
      FallingPile falling(pile);
      for (std::size_t row = 0; row < result.trace.times.size(); ++row) {
        const double t = result.trace.times[row];
        const bool at_rest = t > rest + 2e-4;
        if (!at_rest && t > 0.9 * rest) continue;
        if (!at_rest)
          while (falling.next(pile, t)) {
          }
        for (std::size_t i = 0; i < pile.masses.size(); ++i) {
          const long double below = i == 0 ? 0 : falling.heights[i - 1];
          const double q = at_rest ? 0.0 : static_cast<double>(below - falling.heights[i]);
          // Radau's polynomials are exact on parabolas: rounding, which grows from impact to impact.
          CHECK(result.trace.columns[i][row] == Approx(q).margin(1e-11));
        }
      }
    }
}

TEST_CASE("impacts at speeds of rounding create no energy") {
  // Three balls on each other that come to rest, one impact after the other: at speeds of 1e-14 an impact was refused
  // for 2e-29 of 10 of energy (BG621).
  const RunResult run = Study::from_text(R"j({ "bgsim": 1, "name": "stack", "elements": {
      "b0": { "kind": "1" }, "m0": { "kind": "I", "inertance": 1.659 }, "b1": { "kind": "1" },
      "m1": { "kind": "I", "inertance": 0.1111 }, "b2": { "kind": "1" }, "m2": { "kind": "I", "inertance": 1.402 },
      "F0": { "kind": "Se", "effort": 16.27479 }, "F1": { "kind": "Se", "effort": 1.089891 },
      "F2": { "kind": "Se", "effort": 13.75362 }, "r1": { "kind": "0" }, "r2": { "kind": "0" },
      "c0": { "kind": "contact", "gap": 0, "restitution": 0.7, "initial": { "q": -0.3396 } },
      "c1": { "kind": "contact", "gap": 0, "restitution": 0.3, "initial": { "q": 0 } },
      "c2": { "kind": "contact", "gap": 0, "restitution": 0.9, "initial": { "q": 0 } } },
    "bonds": [ { "from": "b0", "to": "m0" }, { "from": "b1", "to": "m1" }, { "from": "b2", "to": "m2" },
      { "from": "F0", "to": "b0" }, { "from": "F1", "to": "b1" }, { "from": "F2", "to": "b2" },
      { "from": "b0", "to": "c0" }, { "from": "r1", "to": "c1" }, { "from": "r1", "to": "b0" },
      { "from": "b1", "to": "r1" }, { "from": "r2", "to": "c2" }, { "from": "r2", "to": "b1" },
      { "from": "b2", "to": "r2" } ],
    "outputs": { "v0": "b0.f", "v1": "b1.f", "v2": "b2.f" },
    "scenes": { "main": { "stop": 1.673, "samples": 501, "impacts": "sequential" } } })j")
                            .scene()
                            .simulate(one_run());
  REQUIRE(run.stop == StopReason::completed);
  for (const char* const ball : {"v0", "v1", "v2"}) CHECK(std::abs(last(run, ball)) < 1e-12);  // at rest
}

TEST_CASE("a speed whose square is beyond the range of numbers has no size that the problem is scaled by") {
  // The exponent of an infinite number overflowed.
  const RunResult run = study_of("models/cradle.json").scene("", with_parameters({"v=-1e308"})).simulate(one_run());
  CHECK(run.stop == StopReason::completed);
}
