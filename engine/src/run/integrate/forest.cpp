#include "run/integrate/forest.hpp"

#include <algorithm>
#include <cmath>

namespace bgsim {
namespace {

constexpr std::uint32_t kNone = 0xffffffffU;

struct Graph {
  std::vector<std::uint32_t> start, neighbour;
};

/// Who is coupled to whom, in either direction; too many edges for a forest: nothing.
std::optional<Graph> graph_of(const Sparsity& pattern) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t column = 0; column < pattern.size; ++column)
    for (auto k = pattern.column_start[column]; k < pattern.column_start[column + 1]; ++k) {
      const auto a = static_cast<std::uint32_t>(pattern.row[static_cast<std::size_t>(k)]);
      const auto b = static_cast<std::uint32_t>(column);
      if (a != b) edges.emplace_back(std::min(a, b), std::max(a, b));
      if (edges.size() > 2 * pattern.size) return std::nullopt;
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  if (edges.size() >= pattern.size) return std::nullopt;
  Graph graph;
  graph.start.assign(pattern.size + 1, 0);
  for (const auto& [a, b] : edges) ++graph.start[a + 1], ++graph.start[b + 1];
  for (std::size_t i = 0; i < pattern.size; ++i) graph.start[i + 1] += graph.start[i];
  std::vector<std::uint32_t> next(graph.start.begin(), graph.start.end() - 1);
  graph.neighbour.resize(2 * edges.size());
  for (const auto& [a, b] : edges) graph.neighbour[next[a]++] = b, graph.neighbour[next[b]++] = a;
  return graph;
}

struct Walk {
  std::vector<std::uint32_t> order, parent;  ///< unknowns, the nearest first; by unknown, the root's is itself
  bool ring = false;
};

/// @param parent  scratch by unknown: those of the tree are overwritten.
void walk_from(const Graph& graph, std::uint32_t root, Walk& walk) {
  walk.order.assign(1, root);
  walk.parent[root] = root;
  walk.ring = false;
  for (std::size_t k = 0; k < walk.order.size(); ++k) {
    const std::uint32_t at = walk.order[k];
    for (std::uint32_t e = graph.start[at]; e < graph.start[at + 1]; ++e) {
      const std::uint32_t next = graph.neighbour[e];
      if (next == walk.parent[at]) continue;
      walk.order.push_back(next);
      walk.parent[next] = at;
      if (walk.order.size() > walk.parent.size()) {
        walk.ring = true;
        return;
      }
    }
  }
}

std::int64_t entry(const Sparsity& pattern, std::size_t row, std::size_t column) {
  const auto first = pattern.row.begin() + pattern.column_start[column];
  const auto last = pattern.row.begin() + pattern.column_start[column + 1];
  const auto found = std::lower_bound(first, last, static_cast<std::int64_t>(row));
  return found != last && *found == static_cast<std::int64_t>(row) ? found - pattern.row.begin() : -1;
}

}  // namespace

std::optional<Forest> Forest::of(const Sparsity& pattern) {
  const auto graph = graph_of(pattern);
  if (!graph) return std::nullopt;
  const std::size_t n = pattern.size;
  Forest forest;
  Walk walk;
  walk.parent.assign(n, kNone);
  std::vector<std::uint32_t> position(n, kNone);
  for (std::uint32_t any = 0; any < n; ++any) {
    if (position[any] != kNone) continue;
    // From one end of the longest path to the other, and then from its middle: arms of equal length do not wait for
    // each other.
    walk_from(*graph, any, walk);
    if (walk.ring) return std::nullopt;
    walk_from(*graph, walk.order.back(), walk);
    std::vector<std::uint32_t> path(1, walk.order.back());
    while (walk.parent[path.back()] != path.back()) path.push_back(walk.parent[path.back()]);
    walk_from(*graph, path[path.size() / 2], walk);
    for (const std::uint32_t at : walk.order) {
      position[at] = static_cast<std::uint32_t>(forest.unknown_.size());
      forest.unknown_.push_back(at);
      forest.parent_.push_back(position[walk.parent[at]]);
      const bool root = walk.parent[at] == at;
      forest.diagonal_.push_back(entry(pattern, at, at));
      forest.to_parent_.push_back(root ? -1 : entry(pattern, walk.parent[at], at));
      forest.from_parent_.push_back(root ? -1 : entry(pattern, at, walk.parent[at]));
    }
  }
  for (std::vector<double>* values : {&forest.pivot_, &forest.below_, &forest.above_, &forest.terms_, &forest.work_})
    values->assign(n, 0.0);
  forest.find_arms();
  return forest;
}

void Forest::find_arms() {
  const auto n = static_cast<std::uint32_t>(unknown_.size());
  constexpr std::uint32_t kShortest = 8;
  for (std::uint32_t first = 2; first < n;) {
    std::uint32_t end = first;
    while (end < n && parent_[end] + 2 == end) ++end;
    const std::uint32_t even = first + (end - first) / 2 * 2;
    if (even - first >= kShortest) arms_.push_back({first, even});
    first = std::max(end, first + 1);
  }
}

/// A pivot is taken as it is if little of it was lost in the sum that it is, and if its parent's is not lost beside
/// what the elimination adds to it. The second is the bound 1e-3 of KLU for pivots on the diagonal, for both directions
/// together, so that it does not depend on units.
bool Forest::factor(const double* entries) {
  constexpr double kLost = 1e-6, kMost = 1e6;
  const std::size_t n = unknown_.size();
  const auto value = [entries](std::int64_t at) { return at < 0 ? 0.0 : entries[at]; };
  for (std::size_t k = 0; k < n; ++k) {
    pivot_[k] = value(diagonal_[k]);
    terms_[k] = std::fabs(pivot_[k]);
  }
  for (std::size_t k = n; k-- > 0;) {
    const double pivot = pivot_[k], size = std::fabs(pivot);
    if (!(size > kLost * terms_[k]) || !std::isfinite(pivot)) return false;
    pivot_[k] = 1.0 / pivot;
    const std::uint32_t parent = parent_[k];
    if (parent == k) continue;
    below_[k] = value(to_parent_[k]) * pivot_[k];
    above_[k] = value(from_parent_[k]) * pivot_[k];
    const double less = below_[k] * value(from_parent_[k]);
    if (!(std::fabs(less) <= kMost * terms_[parent])) return false;
    pivot_[parent] -= less;
    terms_[parent] += std::fabs(less);
  }
  return true;
}

void Forest::solve(const double* right, double* solution) {
  double* const w = work_.data();
  const double *const below = below_.data(), *const above = above_.data(), *const pivot = pivot_.data();
  const std::uint32_t* const unknown = unknown_.data();
  const std::size_t n = unknown_.size();
  for (std::size_t k = 0; k < n; ++k) w[k] = right[unknown[k]];
  // A root's factors below and above it are 0.
  std::size_t end = n;
  const auto up = [&](std::size_t first) {
    for (; end > first; --end) w[parent_[end - 1]] -= below[end - 1] * w[end - 1];
  };
  for (auto arms = arms_.rbegin(); arms != arms_.rend(); ++arms) {
    up(arms->end);
    double one = w[end - 1], other = w[end - 2];
    for (; end > arms->first + 1; end -= 2) {
      one = w[end - 3] -= below[end - 1] * one;
      other = w[end - 4] -= below[end - 2] * other;
    }
  }
  up(0);
  std::size_t k = 0;
  const auto down = [&](std::size_t last) {
    for (; k < last; ++k) solution[unknown[k]] = w[k] = w[k] * pivot[k] - above[k] * w[parent_[k]];
  };
  for (const Arms& arms : arms_) {
    down(arms.first);
    double other = w[k - 2], one = w[k - 1];
    for (; k + 1 < arms.end; k += 2) {
      other = w[k] * pivot[k] - above[k] * other;
      one = w[k + 1] * pivot[k + 1] - above[k + 1] * one;
      solution[unknown[k]] = w[k] = other;
      solution[unknown[k + 1]] = w[k + 1] = one;
    }
  }
  down(n);
}

}  // namespace bgsim
