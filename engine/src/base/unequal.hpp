/// Parts of one that are spread evenly, however many there are: what is moved by them is moved by unequal amounts.
#pragma once

#include <cmath>
#include <cstddef>

namespace bgsim {

/// Between 0 and 1: multiples of the golden ratio.
inline double unequal_part(std::size_t n) {
  constexpr double kGolden = 0.6180339887498949;
  return std::fmod(kGolden * static_cast<double>(n), 1.0);
}

}  // namespace bgsim
