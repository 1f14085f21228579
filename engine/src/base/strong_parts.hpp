/// Parts of a graph in which each depends on each other.
#pragma once

#include <cstdint>
#include <vector>

namespace bgsim {

struct StrongParts {
  std::vector<std::uint32_t> part_of;  ///< parts are numbered so that what others depend on comes first
  std::uint32_t count = 0;
};
/// The strongly connected parts of what depends on what, in linear time.
StrongParts strong_parts(const std::vector<std::vector<std::uint32_t>>& depends_on);

}  // namespace bgsim
