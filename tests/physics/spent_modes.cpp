// Weakly damped modes that are over: the order of BDF is limited for them.
#include <catch2/catch.hpp>
#include <complex>
#include <numbers>

#include "run/integrate/spectrum.hpp"
#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// A slow store driven by sin(t) through a mass on a stiff spring, which rings at 1e4 rad/s and has died out after
/// 0.02.
std::string ringing(const std::string& scene) {
  return R"x({ "bgsim": 1, "name": "ringing", "elements": {
      "source": { "kind": "Se", "effort": "sin(t)" }, "loop": { "kind": "1" },
      "mass": { "kind": "I", "inertance": 1e-4, "initial": { "p": 1e-3 } },
      "loss": { "kind": "R", "resistance": 0.02 }, "spring": { "kind": "C", "capacitance": 1e-4 } },
      "bonds": [ { "from": "source", "to": "loop" }, { "from": "loop", "to": "mass" }, { "from": "loop", "to": "loss" },
                 { "from": "loop", "to": "spring" } ],
      "outputs": { "q": "spring.q" }, "scenes": { "main": { "stop": 20, "samples": 21)x" +
         scene + " } } }";
}

}  // namespace

TEST_CASE("the angles in which BDF is stable are those of its boundary locus") {
  for (int order = 1; order <= 5; ++order) {
    // The locus: h lambda = sum of (1 - zeta)^j / j over |zeta| = 1.
    double least = 90.0;
    constexpr int kPoints = 20000;
    for (int k = 1; k < kPoints; ++k) {
      const std::complex<double> zeta = std::polar(1.0, std::numbers::pi * k / kPoints);
      std::complex<double> sum = 0.0, power = 1.0;
      for (int j = 1; j <= order; ++j) {
        power *= 1.0 - zeta;
        sum += power / static_cast<double>(j);
      }
      if (sum.real() < -1e-12)
        least = std::min(least, std::atan2(std::abs(sum.imag()), -sum.real()) * 180.0 / std::numbers::pi);
    }
    // two decimals are tabulated
    CHECK(stable_angle(order) == Approx(least).margin(0.006));
  }
}

TEST_CASE("a weakly damped mode that is over limits the order of BDF, and the report names it", "[long]") {
  const RunResult limited = run_text(ringing(R"(, "method": "bdf")"));
  CHECK(limited.report.method == "CVODE BDF of order up to 2, dense");
  CHECK(limited.report.method_reason.find("an eigenmode of 1e+04 rad per unit of time, which dies out in 0.01") !=
        std::string::npos);
  // What is left is q = C sin(t), but for the mass: 1e-8 of it.
  CHECK(last(limited, "q") == Approx(1e-4 * std::sin(20.0)).epsilon(1e-4));
  const RunResult unlimited = run_text(ringing(R"(, "max_order": 5)"));
  CHECK(unlimited.report.method == "CVODE BDF of order up to 5, dense");
  // Orders 3 to 5 are unstable for the mode unless the steps resolve it.
  CHECK(limited.report.steps * 2 < unlimited.report.steps);
}

TEST_CASE("an oscillation that is part of the solution limits no order") {
  const RunResult undamped = run_text(R"({ "bgsim": 1, "name": "lc", "elements": { "loop": { "kind": "1" },
      "l": { "kind": "I", "inertance": 1 }, "c": { "kind": "C", "capacitance": 1, "initial": { "q": 1 } } },
      "bonds": [ { "from": "loop", "to": "l" }, { "from": "loop", "to": "c" } ],
      "outputs": { "q": "c.q" }, "scenes": { "main": { "stop": 1000, "samples": 3, "method": "bdf" } } })");
  CHECK(undamped.report.method == "CVODE BDF, dense");
}
