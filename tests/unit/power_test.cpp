// Squares and cubes without std::pow.
#include "expression/power.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

using namespace bgsim;

TEST_CASE("cubes are rounded once, whatever the number's size") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> mantissa(-2.0, 2.0);
  std::uniform_int_distribution<int> exponent(-300, 300);
  for (int i = 0; i < 20000; ++i) {
    const double a = std::ldexp(mantissa(random), exponent(random));
    // Two roundings of 64 bits are 2^-10 of one of 53.
    const long double exact = static_cast<long double>(a) * a * a;
    const long double unit = std::ldexp(1.0L, std::ilogb(exact) - 52);
    CHECK(std::abs(static_cast<long double>(power(a, 3.0)) - exact) <= unit * (0.5L + 0x1p-10L));
  }
  for (std::int64_t a = -200000; a <= 200000; a += 7)  // exact: less than 2^53
    CHECK(power(static_cast<double>(a), 3.0) == static_cast<double>(a * a * a));
}

TEST_CASE("powers of what is no number, without bound or next to nothing are what std::pow makes of them") {
  const double infinity = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  for (const double exponent : {2.0, 3.0}) {
    for (const double a : {infinity, -infinity, 0.0, -0.0, 1e200, -1e200, 1e-200, -1e-200, 5e-324, 1.0, -1.0}) {
      CHECK(power(a, exponent) == std::pow(a, exponent));
      CHECK(std::signbit(power(a, exponent)) == std::signbit(std::pow(a, exponent)));
    }
    CHECK(std::isnan(power(nan, exponent)));
  }
  CHECK(std::isnan(power(nan, 0.0)));
  CHECK(std::isnan(power(1.0, nan)));
  CHECK(std::isnan(power(-2.0, 0.5)));
}
