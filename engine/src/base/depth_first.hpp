/// Depth-first search with a stack of its own, as deep as memory allows.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace bgsim {

/// Visits all of 0 ... @p count - 1, roots in order of number.
/// @param others  others(i) gives what i refers to, in order: a range of integers.
/// @param enters  enters(i): whether i is visited; asked each time it comes up.
/// @param closes  closes(path, i): an arc leads back to @p i, which is on the path of open ones, innermost last.
/// @param finishes  finishes(i): all that i refers to is done.
/// @note Time linear in the references.
template <class Others, class Enters, class Closes, class Finishes>
void depth_first(std::size_t count, const Others& others, const Enters& enters, const Closes& closes,
                 const Finishes& finishes) {
  enum : unsigned char { kNew, kOpen, kDone };
  struct Open {
    decltype(others(std::size_t{})) list;
    std::size_t next = 0;
  };
  std::vector<unsigned char> state(count, kNew);
  std::vector<std::size_t> path;
  std::vector<Open> places;  // by position in the path
  const auto open = [&](std::size_t i) {
    state[i] = kOpen;
    path.push_back(i);
    places.push_back({others(i)});
  };
  for (std::size_t root = 0; root < count; ++root) {
    if (state[root] != kNew || !enters(root)) continue;
    open(root);
    while (!path.empty()) {
      Open& top = places.back();
      if (top.next == top.list.size()) {
        const std::size_t done = path.back();
        state[done] = kDone;
        path.pop_back();
        places.pop_back();
        finishes(done);
        continue;
      }
      const auto other = static_cast<std::size_t>(top.list[top.next++]);
      if (!enters(other)) continue;
      if (state[other] == kOpen)
        closes(std::span<const std::size_t>(path), other);
      else if (state[other] == kNew)
        open(other);
    }
  }
}

}  // namespace bgsim
