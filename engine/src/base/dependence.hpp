/// Quantities that refer to each other: in which order they can be computed, or which of them run in a circle.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "base/depth_first.hpp"

namespace bgsim {

struct Dependence {
  std::vector<std::size_t> order;                ///< each after all that it refers to (circles aside)
  std::vector<std::vector<std::size_t>> cycles;  ///< each refers to the next, the last to the first; no member shared
};

/// Depth first, in order of number. @p refers_to(i) gives what i refers to.
/// @note Time linear in the references.
template <class RefersTo>
Dependence order_by_dependence(std::size_t count, const RefersTo& refers_to) {
  Dependence result;
  result.order.reserve(count);
  std::vector<unsigned char> in_cycle(count, 0);
  const auto note_cycle = [&](std::span<const std::size_t> path, std::size_t to) {
    const auto cycle = path.subspan(static_cast<std::size_t>(std::find(path.begin(), path.end(), to) - path.begin()));
    for (const std::size_t member : cycle)
      if (in_cycle[member] != 0) return;  // one circle tells enough of the quantities in it
    for (const std::size_t member : cycle) in_cycle[member] = 1;
    result.cycles.emplace_back(cycle.begin(), cycle.end());
  };
  depth_first(
      count, refers_to, [](std::size_t) { return true; }, note_cycle,
      [&](std::size_t i) { result.order.push_back(i); });
  return result;
}

}  // namespace bgsim
