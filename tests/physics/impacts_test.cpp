// Several impacts at one instant: one after the other, or at once.
#include <catch2/catch.hpp>
#include <cmath>
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
