// Which element is left of which: along the power, or to both sides of the middle.
#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "draw/plan.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

Flow along_power(const Model& model, const std::vector<Standing>& standings) {
  Flow flow;
  flow.hands = hands(model);
  const auto host = [&](ElementId id) { return standings[id.index()].host; };
  for (const ModelBond& bond : model.bonds) {
    const ElementId from = host(bond.from.element), to = host(bond.to.element);
    if (from == to) continue;
    const bool spine = passes_power(model.elements[from.index()].kind) && passes_power(model.elements[to.index()].kind);
    // All half-arrows may enter a field: those at its first port come from the left, the others from the right.
    const bool behind = (is_field(model.elements[to.index()].kind) && bond.to.port.value_or(0) > 0) ||
                        flow.hands[to.index()] == Hand::left || flow.hands[from.index()] == Hand::right;
    flow.ranks.push_back({behind ? to : from, behind ? from : to, spine ? 4 : 2});
  }
  return flow;
}

/// The hosts and what is next to what, for walks from one of them.
class Neighbours {
 public:
  Neighbours(const Flow& flow, std::size_t count) : of_(count) {
    for (const Rank& rank : flow.ranks) {
      of_[rank.left.index()].push_back(rank.right.index());
      of_[rank.right.index()].push_back(rank.left.index());
    }
  }

  /// Sizes of the parts that remain without @p hub, and each host's part; hosts out of reach are in none.
  struct Parts {
    std::vector<std::size_t> sizes;
    std::vector<std::size_t> of;        ///< by host, kNone: the hub, or out of reach
    std::vector<std::size_t> distance;  ///< from the hub
  };
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  [[nodiscard]] Parts without(std::size_t hub) const {
    Parts parts{{}, std::vector(of_.size(), kNone), std::vector(of_.size(), kNone)};
    for (const std::size_t start : of_[hub]) {
      if (parts.of[start] != kNone) continue;
      std::vector<std::size_t> waiting{start};
      parts.of[start] = parts.sizes.size();
      for (std::size_t next = 0; next < waiting.size(); ++next)
        for (const std::size_t other : of_[waiting[next]])
          if (other != hub && parts.of[other] == kNone) {
            parts.of[other] = parts.sizes.size();
            waiting.push_back(other);
          }
      parts.sizes.push_back(waiting.size());
    }
    return parts;
  }

  void measure(std::size_t hub, Parts& parts) const {
    std::vector<std::size_t> waiting{hub};
    parts.distance[hub] = 0;
    for (std::size_t next = 0; next < waiting.size(); ++next)
      for (const std::size_t other : of_[waiting[next]])
        if (parts.distance[other] == kNone) {
          parts.distance[other] = parts.distance[waiting[next]] + 1;
          waiting.push_back(other);
        }
  }

  [[nodiscard]] bool branches(std::size_t host) const { return of_[host].size() > 1; }

 private:
  std::vector<std::vector<std::size_t>> of_;
};

/// Which parts stand right of the hub: the largest first, each to the side where less is.
std::vector<bool> right_parts(const std::vector<std::size_t>& sizes) {
  std::vector<std::size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sizes[a] > sizes[b]; });
  std::vector<bool> right(sizes.size(), false);
  std::size_t left_size = 0, right_size = 0;
  for (const std::size_t part : order) {
    right[part] = right_size < left_size;
    (right[part] ? right_size : left_size) += sizes[part];
  }
  return right;
}

/// Whether columns by the longest way from the left would be high and narrow.
bool high_and_narrow(const Model& model, const std::vector<Standing>& standings, const Flow& flow) {
  constexpr double kHigh = 1200.0, kTooHigh = 2.0, kColumn = 115.0, kApart = 20.0;
  const std::size_t count = model.elements.size();
  std::vector<std::vector<std::size_t>> right(count);
  std::vector<std::size_t> open(count, 0), column(count, 0);
  for (const Rank& rank : flow.ranks) {
    right[rank.left.index()].push_back(rank.right.index());
    ++open[rank.right.index()];
  }
  std::vector<std::size_t> waiting;
  for (std::size_t i = 0; i < count; ++i)
    if (open[i] == 0 && standings[i].side == Side::none) waiting.push_back(i);
  for (std::size_t next = 0; next < waiting.size(); ++next)  // elements in circles are left out
    for (const std::size_t other : right[waiting[next]]) {
      column[other] = std::max(column[other], column[waiting[next]] + 1);
      if (--open[other] == 0) waiting.push_back(other);
    }
  const std::vector<Extent> extent = extents(model, standings, flow.hands);
  std::vector<double> heights;
  for (const std::size_t host : waiting) {
    heights.resize(std::max(heights.size(), column[host] + 1), 0.0);
    heights[column[host]] += extent[host].top + extent[host].bottom + kApart;
  }
  if (heights.empty()) return false;
  const double high = *std::max_element(heights.begin(), heights.end());
  return high > kHigh && high > kTooHigh * kColumn * static_cast<double>(heights.size());
}

/// The host without which the largest part that remains is smallest; none in small parts of the graph.
std::size_t hub_of(const Model& model, const std::vector<Standing>& standings, const Neighbours& neighbours) {
  std::size_t hub = Neighbours::kNone, least = Neighbours::kNone;
  for (std::size_t i = 0; i < model.elements.size(); ++i) {
    if (standings[i].side != Side::none || !neighbours.branches(i)) continue;
    const auto sizes = neighbours.without(i).sizes;
    const std::size_t most = *std::max_element(sizes.begin(), sizes.end());
    const std::size_t reached = std::accumulate(sizes.begin(), sizes.end(), std::size_t{0});
    if (4 * reached < model.elements.size() || most >= least) continue;
    least = most;
    hub = i;
  }
  return hub;
}

}  // namespace

Flow flow_of(const Model& model, const std::vector<Standing>& standings) {
  // Finding the middle takes time quadratic in the elements: a second or so for as many as these.
  constexpr std::size_t kMost = 5000;
  Flow flow = along_power(model, standings);
  if (model.elements.size() > kMost || !high_and_narrow(model, standings, flow)) return flow;
  const Neighbours neighbours(flow, model.elements.size());
  const std::size_t hub = hub_of(model, standings, neighbours);
  if (hub == Neighbours::kNone) return flow;
  auto parts = neighbours.without(hub);
  neighbours.measure(hub, parts);
  const std::vector<bool> right = right_parts(parts.sizes);
  const auto on_right = [&](std::size_t host) { return parts.of[host] != Neighbours::kNone && right[parts.of[host]]; };
  for (Rank& rank : flow.ranks) {
    const std::size_t a = parts.distance[rank.left.index()], b = parts.distance[rank.right.index()];
    if (a == Neighbours::kNone || a == b) continue;
    const std::size_t further = a > b ? rank.left.index() : rank.right.index();
    if ((further == rank.right.index()) != on_right(further)) std::swap(rank.left, rank.right);
  }
  for (std::size_t i = 0; i < flow.hands.size(); ++i)
    if (flow.hands[i] != Hand::none && parts.of[i] != Neighbours::kNone)
      flow.hands[i] = on_right(i) ? Hand::right : Hand::left;
  return flow;
}

}  // namespace bgsim
