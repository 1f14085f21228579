#include "source_pace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ranges.hpp"

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
class PulseSearch {
 public:
  PulseSearch(TimeRelation source, double start, double stop)
      : source_(std::move(source)), span_(stop - start), least_(kJump * std::max(std::abs(start), std::abs(stop))) {
    constexpr std::size_t kFirst = 64;
    split({start, stop, 0.0, 0.0}, kFirst, moving_);
  }

  std::vector<Pulse> run() {
    constexpr std::size_t kParts = 8, kMostCells = 4096;
    const auto length = [](double sum, const Cell& cell) { return sum + (cell.end - cell.begin); };
    const auto total = [&] {
      double sum = 0.0;
      for (const Cell& cell : moving_) sum = length(sum, cell);
      return sum;
    };
    drop_still();
    while (!moving_.empty()) {
      const double before = total();
      if (before > kLargestPart * span_ || evaluations_ + kParts * moving_.size() > kMostCells) return {};
      std::vector<Cell> finer;
      for (const Cell& cell : moving_) split(cell, kParts, finer);
      moving_ = std::move(finer);
      drop_still();
      drop_jumps();
      if (total() > before / 2) break;
    }
    return merged();
  }

 private:
  static constexpr double kFar = std::numeric_limits<double>::infinity();
  static constexpr double kStill = 1e-3;       ///< of the source's whole range
  static constexpr double kJump = 1e-10;       ///< of the time: what is narrower counts as a jump
  static constexpr double kLargestPart = 0.5;  ///< of the scene that pulses may fill

  void split(const Cell& cell, std::size_t parts, std::vector<Cell>& into) {
    double begin = cell.begin;
    for (std::size_t i = 1; i <= parts; ++i) {
      const double end =
          i == parts ? cell.end
                     : cell.begin + (cell.end - cell.begin) * (static_cast<double>(i) / static_cast<double>(parts));
      const Range range = source_.range_on(begin, end);
      const bool none = !(range.lower() <= range.upper());  // no value at all: the run will say so
      into.push_back({begin, end, none ? kFar : range.lower(), none ? -kFar : range.upper()});
      begin = end;
      ++evaluations_;
    }
  }

  /// The source's range is that of the cells, which is the tighter the finer they are.
  void drop_still() {
    double low = still_low_, high = still_high_;
    for (const Cell& cell : moving_) {
      low = std::min(low, cell.low);
      high = std::max(high, cell.high);
    }
    std::erase_if(moving_, [&](const Cell& cell) {
      const bool still = !(cell.high - cell.low > kStill * (high - low));
      if (still) {
        still_low_ = std::min(still_low_, cell.low);
        still_high_ = std::max(still_high_, cell.high);
      }
      return still;
    });
  }

  void drop_jumps() {
    std::erase_if(moving_, [&](const Cell& cell) { return cell.end - cell.begin <= least_; });
  }

  [[nodiscard]] std::vector<Pulse> merged() const {
    std::vector<Pulse> pulses;
    for (const Cell& cell : moving_) {
      if (!pulses.empty() && pulses.back().end == cell.begin)
        pulses.back().end = cell.end;
      else
        pulses.push_back({cell.begin, cell.end});
    }
    return pulses;
  }

  TimeRelation source_;
  double span_, least_;
  std::vector<Cell> moving_;
  std::size_t evaluations_ = 0;
  double still_low_ = kFar, still_high_ = -kFar;
};

std::vector<Pulse> find_pulses(const Program& program, std::span<const double> parameters, double start, double stop) {
  std::vector<Pulse> pulses;
  const std::vector<double> values = values_of(program, parameters);
  for (const ExprId source : program.sources) {
    const auto found = PulseSearch(TimeRelation(program.pool, source, program.time, values, false), start, stop).run();
    pulses.insert(pulses.end(), found.begin(), found.end());
  }
  std::sort(pulses.begin(), pulses.end(), [](const Pulse& a, const Pulse& b) { return a.begin < b.begin; });
  return pulses;
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

SourcePlan plan_sources(const Program& program, std::span<const double> parameters, double start, double stop) {
  constexpr double kMostSteps = 1e6;
  SourcePlan plan;
  if (program.sources.empty() || !(stop > start)) return plan;
  plan.pulses = find_pulses(program, parameters, start, stop);
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

bool SourcePlan::is_edge(double t) const { return std::binary_search(edges.begin(), edges.end(), t); }

}  // namespace bgsim
