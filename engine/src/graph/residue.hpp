/// Numbers modulo the prime 2^61 - 1. An expression that vanishes for all values of its symbols vanishes at random
/// ones; one that does not vanish does so there with a probability below 1e-15 (J. T. Schwartz 1980, R. Zippel 1979).
#pragma once

#include <cstdint>

namespace bgsim {

inline constexpr std::uint64_t kPrime = (std::uint64_t{1} << 61U) - 1;

constexpr std::uint64_t sum_of(std::uint64_t a, std::uint64_t b) { return a + b < kPrime ? a + b : a + b - kPrime; }
constexpr std::uint64_t minus(std::uint64_t a) { return a == 0 ? 0 : kPrime - a; }
constexpr std::uint64_t product_of(std::uint64_t a, std::uint64_t b) {
  __extension__ using Wide = unsigned __int128;
  const Wide product = Wide{a} * b;
  return sum_of(static_cast<std::uint64_t>(product & kPrime), static_cast<std::uint64_t>(product >> 61U));
}
constexpr std::uint64_t power_of(std::uint64_t a, std::uint64_t n) {
  std::uint64_t result = 1;
  for (; n > 0; n >>= 1U, a = product_of(a, a))
    if ((n & 1U) != 0) result = product_of(result, a);
  return result;
}
/// 1/a, by Fermat; a is not 0.
constexpr std::uint64_t inverse_of(std::uint64_t a) { return power_of(a, kPrime - 2); }

}  // namespace bgsim
