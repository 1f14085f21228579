/// Comparisons of numbers that say why they are not exact.
#pragma once

#include <catch2/catch.hpp>
#include <limits>

namespace bgsim::test {

/// Equal but for rounding: @p value was computed by at most @p operations operations of double precision on numbers of
/// its own size, each of which is off by half a unit in the last place.
inline Approx same_to_rounding(double value, int operations = 8) {
  return Approx(value).epsilon(operations * std::numeric_limits<double>::epsilon() / 2.0);
}

}  // namespace bgsim::test
