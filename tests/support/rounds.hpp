/// How many random models a test tries.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace bgsim::test {

/// @p usual, or the part of it that BGSIM_RANDOM_SHARE says, at least five: under the sanitizers a tenth, with the
/// release three tenths, in scripts/test --slow all (docs/design/build.md).
inline std::uint64_t share_of(std::uint64_t usual) {
  const char* text = std::getenv("BGSIM_RANDOM_SHARE");
  if (text == nullptr) return usual;
  return std::max<std::uint64_t>(std::min<std::uint64_t>(usual, 5),
                                 static_cast<std::uint64_t>(static_cast<double>(usual) * std::strtod(text, nullptr)));
}

/// A number of the environment: BGSIM_RANDOM_ROUNDS, BGSIM_RANDOM_SEED.
inline std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

}  // namespace bgsim::test
