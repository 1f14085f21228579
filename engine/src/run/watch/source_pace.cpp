#include "run/watch/source_pace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "expression/graph.hpp"
#include "expression/interval.hpp"

namespace bgsim {

namespace {

struct Cell {
  double begin, end;
  double low, high;  ///< of the source there
};

double width_of(const Range& range) {
  const double width = range.upper() - range.lower();
  return width >= 0.0 ? width : 0.0;  // no value at all: the run will say so
}

std::vector<double> values_of(const Program& program, std::span<const double> parameters) {
  std::vector<double> values(program.symbol_names.size(), 0.0);
  for (std::size_t i = 0; i < parameters.size(); ++i) values[program.parameters[i].index()] = parameters[i];
  return values;
}

/// Splits a scene into stretches where a source is still and where it moves.
///
/// In layers: still is what varies by no more than a thousandth of the range. A low and broad pulse is still beside a
/// high and narrow one and may have its area all the same; so what is still is searched again by itself, until all that
/// is left could not matter.
class PulseSearch {
 public:
  PulseSearch(TimeRelation source, double start, double stop)
      : source_(std::move(source)), span_(stop - start), least_(kFinest * std::max(std::abs(start), std::abs(stop))) {
    constexpr std::size_t kFirst = 64;
    split({start, stop, 0.0, 0.0}, kFirst, still_);
  }

  std::vector<Pulse> run() {
    constexpr int kLayers = 8;
    std::vector<Pulse> all;
    for (int layer = 0; layer < kLayers && search_layer(); ++layer) {
      std::vector<Pulse> pulses = without_narrow(merged());
      // The feet of pulses that are known need no edges of their own: integrators see them from there.
      std::erase_if(pulses, [&](const Pulse& pulse) {
        return std::any_of(all.begin(), all.end(),
                           [&](const Pulse& known) { return pulse.begin <= known.end && known.begin <= pulse.end; });
      });
      all.insert(all.end(), pulses.begin(), pulses.end());
      area_ = std::accumulate(settled_.begin(), settled_.end(), area_, [](double sum, const Cell& cell) {
        return sum + (cell.high - cell.low) * (cell.end - cell.begin);
      });
      if (!(largest_variation(still_) * span_ > kNegligible * area_)) break;
    }
    return all;
  }

  /// Of @p source, which is the one searched.
  [[nodiscard]] std::optional<NarrowPulse> too_narrow(ExprId source) const {
    if (!too_narrow_) return std::nullopt;
    return NarrowPulse{source, *too_narrow_, 2.0 * kNarrow * std::abs(too_narrow_->end)};
  }

 private:
  static constexpr std::size_t kParts = 8;
  static constexpr std::ptrdiff_t kMostParts = 6;
  static constexpr double kFar = std::numeric_limits<double>::infinity();
  static constexpr double kStill = 1e-3;    ///< of the source's whole range
  static constexpr double kFinest = 2e-15;  ///< of the time: cells are not split further
  static constexpr double kNarrow = 2e-11;  ///< of the time: 1e5 neighbouring doubles, below which nothing is followed
  static constexpr double kTogether = 1e-13;   ///< of the time: jumps nearer to each other make a pulse
  static constexpr double kLargestPart = 0.5;  ///< of the scene that pulses may fill
  static constexpr double kNegligible = 1e-9;  ///< of the area of the pulses

  void split(const Cell& cell, std::size_t parts, std::vector<Cell>& into) {
    double begin = cell.begin;
    for (std::size_t i = 1; i <= parts; ++i) {
      const double end =
          i == parts ? cell.end
                     : cell.begin + (cell.end - cell.begin) * (static_cast<double>(i) / static_cast<double>(parts));
      const Range range = source_.range_on(begin, end);
      // No value at all, or no bound: the run will say so if it is, and other stretches are not to be measured by it.
      const bool none = !std::isfinite(range.upper() - range.lower()) || range.lower() > range.upper();
      into.push_back({begin, end, none ? kFar : range.lower(), none ? -kFar : range.upper()});
      begin = end;
      ++evaluations_;
    }
  }

  static void sort(std::vector<Cell>& cells) {
    std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.begin < b.begin; });
  }

  static double length(const std::vector<Cell>& cells) {
    return std::accumulate(cells.begin(), cells.end(), 0.0,
                           [](double sum, const Cell& cell) { return sum + (cell.end - cell.begin); });
  }

  /// Splits what moves of what was still so far into settled_ and still_. False if nothing moves, or too much.
  bool search_layer() {
    constexpr std::size_t kMostCells = 8192;
    known_low_ = kFar;
    known_high_ = -kFar;
    settled_.clear();
    sort(still_);
    varies_ = largest_variation(still_);
    moving_ = drop_still(std::exchange(still_, {}));
    while (!moving_.empty()) {
      if (length(moving_) + length(settled_) > kLargestPart * span_) return false;
      if (evaluations_ + kParts * moving_.size() > kMostCells)
        break;  // the rest is reported as coarsely as it is known
      refine();
    }
    settled_.insert(settled_.end(), moving_.begin(), moving_.end());
    sort(settled_);
    return !settled_.empty();
  }

  static double largest_variation(const std::vector<Cell>& cells) {
    return std::accumulate(cells.begin(), cells.end(), 0.0,
                           [](double most, const Cell& cell) { return std::max(most, cell.high - cell.low); });
  }

  /// Those of @p cells that move. The source's range is that of the cells, which is the tighter the finer they are; but
  /// steps between cells, as on both sides of a known pulse, are none of this layer's.
  std::vector<Cell> drop_still(const std::vector<Cell>& cells) {
    double low = known_low_, high = known_high_;
    for (const Cell& cell : cells) {
      low = std::min(low, cell.low);
      high = std::max(high, cell.high);
    }
    std::vector<Cell> moving;
    for (const Cell& cell : cells) {
      if (cell.high - cell.low > kStill * std::min(high - low, varies_)) {
        moving.push_back(cell);
      } else {
        still_.push_back(cell);
        know(cell);
      }
    }
    return moving;
  }

  void know(const Cell& cell) {
    known_low_ = std::min(known_low_, cell.low);
    known_high_ = std::max(known_high_, cell.high);
  }

  /// Splits what moves, in order of time. A cell of which most parts move is as wide as the pulse in it: these are
  /// settled.
  void refine() {
    std::vector<Cell> parts;
    for (const Cell& cell : moving_) split(cell, kParts, parts);
    const std::vector<Cell> finer = drop_still(parts);
    auto next = finer.begin();
    std::vector<Cell> narrower;
    for (const Cell& cell : moving_) {
      const auto first = next;
      while (next != finer.end() && next->begin < cell.end) ++next;
      for (auto part = first; part != next; ++part) {
        const bool settled = next - first >= kMostParts || part->end - part->begin <= least_;
        (settled ? settled_ : narrower).push_back(*part);
        if (settled) know(*part);
      }
    }
    moving_ = std::move(narrower);
  }

  /// Jumps and flanks that are too narrow to be followed need not be; of a pulse the run must not say nothing.
  std::vector<Pulse> without_narrow(std::vector<Pulse> pulses) {
    std::erase_if(pulses, [&](const Pulse& pulse) {
      const double time = std::max(std::abs(pulse.begin), std::abs(pulse.end));
      if (pulse.end - pulse.begin > kNarrow * time) return false;
      if (!too_narrow_ && leaves_its_ends(pulse)) too_narrow_ = pulse;
      return true;
    });
    return pulses;
  }

  /// What the source has at least, by its size, where it is still.
  [[nodiscard]] double area_of_still() const {
    return std::accumulate(still_.begin(), still_.end(), 0.0, [](double sum, const Cell& cell) {
      const double least = std::max({0.0, cell.low, -cell.high});
      return std::isfinite(least) ? sum + least * (cell.end - cell.begin) : sum;
    });
  }

  /// Whether the source takes values within that are not between those at the ends, by values at single times. Beside
  /// the rest of the source they may have no area: ceil(mod(t, 2)) is 0 for a rounding of time where its sawtooth
  /// begins again.
  bool leaves_its_ends(const Pulse& pulse) {
    constexpr int kPlaces = 256;
    const auto value = [&](double t) { return source_.range_on(t, t); };
    const Range ends = hull(value(pulse.begin), value(pulse.end));
    const double negligible = kNegligible * std::max(area_, area_of_still());
    for (int i = 1; i < kPlaces; ++i) {
      const Range there = value(pulse.begin + (pulse.end - pulse.begin) * i / kPlaces);
      const double whole = std::max(known_high_, there.upper()) - std::min(known_low_, there.lower());
      const double height = std::max(there.upper() - ends.upper(), ends.lower() - there.lower());
      if (height > kStill * whole && height * (pulse.end - pulse.begin) > negligible) return true;
    }
    return false;
  }

  [[nodiscard]] std::vector<Pulse> merged() const {
    std::vector<Pulse> pulses;
    for (const Cell& cell : settled_) {
      if (!pulses.empty() && cell.begin - pulses.back().end <= kTogether * std::abs(cell.begin))
        pulses.back().end = cell.end;
      else
        pulses.push_back({cell.begin, cell.end});
    }
    return pulses;
  }

  TimeRelation source_;
  double span_, least_;
  std::vector<Cell> moving_, settled_, still_;
  double area_ = 0.0;    ///< of the pulses that are known
  double varies_ = 0.0;  ///< within a cell at most, when the layer began
  std::optional<Pulse> too_narrow_;
  std::size_t evaluations_ = 0;
  double known_low_ = kFar, known_high_ = -kFar;
};

void find_pulses(const Program& program, std::span<const double> parameters, double start, double stop,
                 SourcePlan& plan) {
  const std::vector<double> values = values_of(program, parameters);
  for (const ExprId source : program.sources) {
    PulseSearch search(TimeRelation(program.pool, source, program.time, values, false), start, stop);
    const auto found = search.run();
    plan.pulses.insert(plan.pulses.end(), found.begin(), found.end());
    if (!plan.too_narrow) plan.too_narrow = search.too_narrow(source);
  }
  std::sort(plan.pulses.begin(), plan.pulses.end(), [](const Pulse& a, const Pulse& b) { return a.begin < b.begin; });
}

double source_frequency(const Program& program, std::span<const double> parameters, double start, double stop) {
  // Over a quarter of a period a sine covers half of its range on average.
  constexpr int kPlaces = 16, kHalvings = 40;
  const std::vector<double> values = values_of(program, parameters);
  double fastest = 0.0;
  for (const ExprId source : program.sources) {
    TimeRelation relation(program.pool, source, program.time, values, false);
    const double whole = width_of(relation.range_on(start, stop));
    double length = stop - start;
    for (int halving = 0; halving < kHalvings && std::isfinite(whole) && whole > 0.0; ++halving, length /= 2.0) {
      double sum = 0.0;
      for (int i = 0; i < kPlaces; ++i) {
        const double begin = start + (stop - start - length) * (i + 0.5) / kPlaces;
        sum += width_of(relation.range_on(begin, begin + length));
      }
      if (sum > 0.5 * whole * kPlaces) continue;
      if (halving > 0) fastest = std::max(fastest, 0.25 / length);
      break;
    }
  }
  return fastest;
}

std::vector<double> edges_of(const std::vector<Pulse>& pulses, double start, double stop) {
  constexpr int kParts = 8;
  std::vector<double> edges;
  for (const Pulse& pulse : pulses)
    for (const int part : {0, 1, 2, 3, 4, 5, 6, 7, kParts, 2 * kParts}) {  // the last: when its flank has died away
      const double edge = pulse.begin + (pulse.end - pulse.begin) * part / kParts;
      if (edge > start && edge < stop) edges.push_back(edge);
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace

std::optional<Place> only_element_of_time(const Model& model) {
  std::optional<Place> only;
  for (const Element& element : model.elements) {
    std::vector<ExprId> roots;
    if (element.coefficient.valid()) roots.push_back(element.coefficient);
    for (const Law& law : element.laws) roots.push_back(law.right);
    const std::vector<ExprId> nodes = reachable(model.pool, roots);
    const auto is_time = [&](ExprId e) { return model.pool.is_symbol(e) && model.pool.symbol_of(e) == model.time; };
    if (std::none_of(nodes.begin(), nodes.end(), is_time)) continue;
    if (only) return std::nullopt;
    only = element.coefficient.valid() ? element.coefficient_place : element.place;
  }
  return only;
}

SourcePlan plan_sources(const Program& program, std::span<const double> parameters, double start, double stop) {
  constexpr double kMostSteps = 1e6;
  SourcePlan plan;
  if (program.sources.empty() || !(stop > start)) return plan;
  find_pulses(program, parameters, start, stop, plan);
  plan.edges = edges_of(plan.pulses, start, stop);
  plan.frequency = source_frequency(program, parameters, start, stop);
  const double longest = kFollowedPeriods / plan.frequency;
  if (longest < stop - start && longest * kMostSteps > stop - start) plan.longest_step = longest;
  return plan;
}

std::optional<double> SourcePlan::next_edge(double t) const {
  const auto next = std::upper_bound(edges.begin(), edges.end(), t);
  return next == edges.end() ? std::nullopt : std::optional(*next);
}

}  // namespace bgsim
