/// Powers, as every evaluation takes them.
#pragma once

#include <cmath>
#include <limits>

namespace bgsim {

inline double power(double a, double b) {
  // std::pow(NaN, 0) and std::pow(1, NaN) are 1
  return std::isnan(a) || std::isnan(b) ? std::numeric_limits<double>::quiet_NaN() : std::pow(a, b);
}

}  // namespace bgsim
