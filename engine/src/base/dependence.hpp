/// Quantities that refer to each other: in which order they can be computed, or which of them run in a circle.
#pragma once

#include <cstddef>
#include <vector>

namespace bgsim {

struct Dependence {
  std::vector<std::size_t> order;                ///< each after all that it refers to (circles aside)
  std::vector<std::vector<std::size_t>> cycles;  ///< each refers to the next, the last to the first; no member shared
};

/// Depth first with a stack of its own, in order of number. @p refers_to(i) gives what i refers to.
/// @note Time linear in the references.
template <class RefersTo>
Dependence order_by_dependence(std::size_t count, const RefersTo& refers_to) {
  enum : unsigned char { kNew, kOpen, kDone };
  struct Frame {
    std::size_t at;
    std::vector<std::size_t> others;
    std::size_t next = 0;
  };
  Dependence result;
  result.order.reserve(count);
  std::vector<unsigned char> state(count, kNew), in_cycle(count, 0);
  std::vector<Frame> stack;
  const auto note_cycle = [&](std::size_t to) {
    std::size_t begin = stack.size();
    while (stack[--begin].at != to) {
    }
    std::vector<std::size_t> cycle;
    for (std::size_t i = begin; i < stack.size(); ++i) {
      if (in_cycle[stack[i].at] != 0) return;  // one circle tells enough of the quantities in it
      cycle.push_back(stack[i].at);
    }
    for (const std::size_t member : cycle) in_cycle[member] = 1;
    result.cycles.push_back(std::move(cycle));
  };
  for (std::size_t root = 0; root < count; ++root) {
    if (state[root] != kNew) continue;
    state[root] = kOpen;
    stack.push_back({root, refers_to(root)});
    while (!stack.empty()) {
      Frame& top = stack.back();
      if (top.next == top.others.size()) {
        state[top.at] = kDone;
        result.order.push_back(top.at);
        stack.pop_back();
        continue;
      }
      const std::size_t other = top.others[top.next++];
      if (state[other] == kOpen) {
        note_cycle(other);
      } else if (state[other] == kNew) {
        state[other] = kOpen;
        stack.push_back({other, refers_to(other)});
      }
    }
  }
  return result;
}

}  // namespace bgsim
