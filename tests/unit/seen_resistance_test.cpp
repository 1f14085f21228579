// At which resistance in series with a source something is seen of a circuit, by circuits whose slopes are known.
#include "run/seen_resistance.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

using namespace bgsim;

namespace {

using Slopes = std::function<std::array<double, 3>(double r)>;

std::vector<SlopesThrough> scan(const Slopes& slopes) {
  std::vector<SlopesThrough> result;
  for (int power = -36; power <= 36; power += 3)
    result.push_back({std::pow(10.0, power), slopes(std::pow(10.0, power))});
  return result;
}

double seen(const Slopes& slopes, double span) { return seen_resistance(scan(slopes), span); }

/// A resistance.
Slopes resistance(double value) {
  return [=](double r) { return std::array<double, 3>{-1.0 / (value + r), 0.0, 0.0}; };
}
/// An inertance with a resistance: L f' = s - (R + r) f.
Slopes coil(double inertance, double value) {
  return [=](double r) { return std::array<double, 3>{0.0, -1.0 / inertance, (value + r) / (inertance * inertance)}; };
}
/// A capacitance with an inertance beside it: r f = e - s, C e' = -f - p/L, p' = e.
Slopes tank(double capacitance, double inertance) {
  return [=](double r) {
    const double rate = 1.0 / (r * capacitance);
    return std::array<double, 3>{-1.0 / r, rate / r, (1.0 / (inertance * capacitance) - rate * rate) / r};
  };
}

}  // namespace

TEST_CASE("the resistance that a diode is seen through is about the circuit's own") {
  constexpr double kSpan = 10.0;
  for (const double size : {1e-24, 1e-9, 1.0, 1e5, 1e18}) {
    INFO(size);
    // To three digits: between the powers of the scan the laws are straight lines to a thousandth.
    CHECK(seen(resistance(5.0 * size), kSpan) == Approx(5.0 * size).epsilon(1e-2));
    CHECK(seen(coil(2.0 * size, 3.0 * size), kSpan) == Approx(3.0 * size).epsilon(1e-2));
    // sqrt(L/C)
    CHECK(seen(tank(3.0 / size, 0.75 * size), kSpan) == Approx(0.5 * size).epsilon(1e-2));
    // Alone: the time constants L/r and r C are those of the run.
    CHECK(seen(coil(2.0 * size, 0.0), kSpan) == Approx(0.2 * size).epsilon(1e-6));
    const Slopes capacitor = [&](double r) { return std::array<double, 3>{-1.0 / r, size / (r * r), 0.0}; };
    CHECK(seen(capacitor, kSpan) == Approx(10.0 * size).epsilon(1e-6));
  }
}

TEST_CASE("what rounding leaves of slopes that cancel is no circuit") {
  // Beyond 1e6 ohm, where 1/r^2 is lost in terms of 1e-16.
  const Slopes noisy = [](double r) {
    const double f = -0.5 / (r + 1.0);
    return std::array<double, 3>{f, -0.25 / ((r + 1.0) * (r + 1.0)) + 1e-17, 1e-17 * r};
  };
  CHECK(seen(noisy, 1.0) == Approx(1.0).epsilon(1e-2));
  const Slopes nothing = [](double) { return std::array<double, 3>{}; };
  CHECK(seen(nothing, 1.0) == 1.0);
}
