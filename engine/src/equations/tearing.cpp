#include "equations/tearing.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <set>
#include <span>

#include "base/depth_first.hpp"
#include "bgsim/ordering.hpp"

namespace bgsim {
namespace {

constexpr std::size_t kLargestGreedyLoop = 400;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Removes members that lie on no cycle any more; returns whether any are left.
bool prune(const LoopGraph& loop, std::vector<bool>& alive, std::vector<std::uint32_t>& in,
           std::vector<std::uint32_t>& out) {
  const std::size_t n = alive.size();
  bool changed = true, any = false;
  while (changed) {
    changed = false;
    any = false;
    std::fill(in.begin(), in.end(), 0U);
    std::fill(out.begin(), out.end(), 0U);
    for (std::size_t i = 0; i < n; ++i)
      if (alive[i])
        for (const std::uint32_t j : loop.depends_on[i])
          if (alive[j]) ++out[i], ++in[j];
    for (std::size_t i = 0; i < n; ++i) {
      if (!alive[i]) continue;
      if (in[i] == 0 || out[i] == 0) {
        alive[i] = false;
        changed = true;
      } else {
        any = true;
      }
    }
  }
  return any;
}

void tear_greedily(const LoopGraph& loop, std::vector<bool>& torn) {
  const std::size_t n = loop.depends_on.size();
  std::vector<bool> alive(n);
  std::vector<std::uint32_t> in(n), out(n);
  for (std::size_t i = 0; i < n; ++i) alive[i] = !torn[i];
  while (prune(loop, alive, in, out)) {
    std::size_t best = n;
    for (std::size_t i = 0; i < n; ++i) {
      if (!alive[i]) continue;
      if (best == n || std::uint64_t{in[i]} * out[i] > std::uint64_t{in[best]} * out[best]) best = i;
    }
    torn[best] = true;
    alive[best] = false;
  }
}

/// Members in order of completion: dependencies first. @param tear_back_arcs  else there are none.
std::vector<std::uint32_t> completed(const LoopGraph& loop, std::vector<bool>& torn, bool tear_back_arcs) {
  std::vector<std::uint32_t> finished;
  depth_first(
      loop.depends_on.size(), [&](std::size_t i) { return std::span(loop.depends_on[i]); },
      [&](std::size_t i) { return !torn[i]; },
      [&](std::span<const std::size_t>, std::size_t i) { torn[i] = torn[i] || tear_back_arcs; },
      [&](std::size_t i) { finished.push_back(static_cast<std::uint32_t>(i)); });
  return finished;
}

/// Cuts a large loop also where an expression would contain many of its tears: in a network the flow through a branch
/// is the sum of all flows beyond it, and the matrix would be full. Where there is no such expression nothing is cut.
void limit_fill(const LoopGraph& loop, std::vector<bool>& torn) {
  constexpr std::size_t kMostTears = 16;  // in one expression: more branches than most junctions have
  std::vector<std::vector<std::uint32_t>> tears(loop.depends_on.size());
  for (const std::uint32_t i : completed(loop, torn, false)) {
    std::vector<std::uint32_t>& own = tears[i];
    for (const std::uint32_t j : loop.depends_on[i]) {
      if (torn[j])
        own.push_back(j);
      else
        own.insert(own.end(), tears[j].begin(), tears[j].end());
    }
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
    torn[i] = own.size() > kMostTears;
  }
}

/// Cuts what is still whole.
void cut(const LoopGraph& loop, std::vector<bool>& torn) {
  if (torn.size() <= kLargestGreedyLoop)
    tear_greedily(loop, torn);
  else
    completed(loop, torn, true);
}

std::size_t count_of(const std::vector<bool>& torn) {
  return static_cast<std::size_t>(std::count(torn.begin(), torn.end(), true));
}

/// A member, the one that it is a multiple of, and so on.
std::vector<std::uint32_t> multiples(const LoopGraph& loop, std::uint32_t member) {
  std::vector<std::uint32_t> chain{member};
  while (chain.size() < loop.multiple_of.size() && loop.multiple_of[chain.back()] != chain.back())
    chain.push_back(loop.multiple_of[chain.back()]);
  return chain;
}

/// What the rates of states come from that are no multiples of tears.
std::set<std::uint32_t> exposed(const LoopGraph& loop, const std::vector<bool>& torn) {
  std::set<std::uint32_t> result;
  for (const std::uint32_t rate : loop.rates) {
    const std::vector<std::uint32_t> chain = multiples(loop, rate);
    if (std::none_of(chain.begin(), chain.end(), [&](std::uint32_t i) { return torn[i]; })) result.insert(chain.back());
  }
  return result;
}

/// What the rates of dependent stores come from of which no tear is a multiple.
std::set<std::uint32_t> exposed_dependents(const LoopGraph& loop, const std::vector<bool>& torn) {
  std::set<std::uint32_t> result, held;
  for (std::uint32_t i = 0; i < torn.size(); ++i)
    if (torn[i]) held.insert(multiples(loop, i).back());
  for (const std::uint32_t rate : loop.dependent_rates)
    if (const std::uint32_t origin = multiples(loop, rate).back(); !held.contains(origin)) result.insert(origin);
  return result;
}

}  // namespace

Tearing tear(const LoopGraph& loop) {
  const std::size_t n = loop.depends_on.size();
  std::vector<bool> must = loop.must_tear;
  for (std::uint32_t i = 0; i < n; ++i)
    if (std::find(loop.depends_on[i].begin(), loop.depends_on[i].end(), i) != loop.depends_on[i].end()) must[i] = true;
  std::vector<bool> torn = must;
  cut(loop, torn);
  Tearing result;
  std::set<std::uint32_t> rates = exposed(loop, torn);
  if (exposed(loop, must).size() > 1) {
    rates.merge(exposed_dependents(loop, torn));
    result.by_rates = loop.far_apart && !rates.empty() && count_of(torn) + rates.size() <= kLargestLocalBlock;
    for (const std::uint32_t i : rates) torn[i] = torn[i] || result.by_rates;
  } else if (!rates.empty()) {
    torn = must;
    torn[*rates.begin()] = true;
    cut(loop, torn);
  }
  if (count_of(torn) > kLargestLocalBlock) limit_fill(loop, torn);
  result.sequence = completed(loop, torn, false);
  for (std::uint32_t i = 0; i < n; ++i)
    if (torn[i]) result.tears.push_back(i);
  return result;
}

bool has_full_matching(const std::vector<std::vector<std::uint32_t>>& pattern) {
  // Augmenting paths, breadth first (Hopcroft and Karp's phases are not needed at the sizes of loops).
  const std::size_t n = pattern.size();
  std::vector<std::uint32_t> row_of(n, kNone), came_from(n), visited(n, kNone);
  std::vector<std::uint32_t> column_of(n, kNone);
  for (std::uint32_t start = 0; start < n; ++start) {
    std::vector<std::uint32_t> queue{start};
    std::uint32_t free_column = kNone;
    for (std::size_t head = 0; head < queue.size() && free_column == kNone; ++head) {
      for (const std::uint32_t column : pattern[queue[head]]) {
        if (visited[column] == start) continue;
        visited[column] = start;
        came_from[column] = queue[head];
        if (row_of[column] == kNone) {
          free_column = column;
          break;
        }
        queue.push_back(row_of[column]);
      }
    }
    if (free_column == kNone) return false;
    for (std::uint32_t column = free_column; column != kNone;) {
      const std::uint32_t row = came_from[column];
      const std::uint32_t previous = column_of[row];
      row_of[column] = row;
      column_of[row] = column;
      column = previous;
    }
  }
  return true;
}

}  // namespace bgsim
