#include "run/watch/first_crossing.hpp"

#include <algorithm>
#include <cmath>

namespace bgsim {

namespace {

struct Stretch {
  double from, to;
  std::vector<std::size_t> candidates;
};

/// Nothing is between neighbouring doubles, and next to nothing between their neighbours.
bool divisible(double from, double to) {
  constexpr double kNeighbours = 4.0 * 0x1p-52;
  const double middle = from + (to - from) / 2;
  return middle > from && middle < to && to - from > kNeighbours * std::max(std::fabs(from), std::fabs(to));
}

}  // namespace

FirstCrossing first_crossing(CrossingFunctions& functions, std::vector<std::size_t> candidates, double from, double to,
                             int work) {
  FirstCrossing result;
  std::vector<Stretch> stack{{from, to, std::move(candidates)}};
  while (!stack.empty()) {
    Stretch stretch = std::move(stack.back());
    stack.pop_back();
    ++result.enclosures;
    if (!functions.enclose(stretch.from, stretch.to)) {
      result.fault = true;
      return result;
    }
    bool all_monotone = true;
    std::vector<std::size_t> open, turning;
    for (const std::size_t i : stretch.candidates) {
      const Jet jet = functions.jet(i);
      if (functions.stays(i, jet)) continue;
      open.push_back(i);
      if (is_monotone(jet)) continue;
      all_monotone = false;
      turning.push_back(i);
    }
    if (open.empty()) continue;
    const bool out_of_work = result.enclosures + 1 >= work;
    if (!all_monotone && !out_of_work && divisible(stretch.from, stretch.to)) {
      const double middle = stretch.from + (stretch.to - stretch.from) / 2;
      stack.push_back({middle, stretch.to, open});
      stack.push_back({stretch.from, middle, std::move(open)});
      continue;
    }
    if (!functions.evaluate(stretch.to)) {
      result.fault = true;
      return result;
    }
    if (std::any_of(open.begin(), open.end(), [&](std::size_t i) { return functions.crossed(i); })) {
      result.bracket = {stretch.from, stretch.to};
      return result;
    }
    if (!all_monotone && out_of_work) {
      if (result.undecided.empty()) result.undecided_at = stretch.from;
      for (const std::size_t i : turning)
        if (std::find(result.undecided.begin(), result.undecided.end(), i) == result.undecided.end())
          result.undecided.push_back(i);
    }
  }
  return result;
}

}  // namespace bgsim
