#include "run/seen_resistances.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

namespace bgsim {
namespace {

struct Point {
  double log_r = 0.0, log_size = 0.0;  ///< of r |slope|
};

/// A part of the scan where r |slope| is a power of r.
struct PowerLaw {
  int power = 0;
  Point first;
  double log_end = 0.0;
  [[nodiscard]] double at(double log_r) const { return first.log_size + power * (log_r - first.log_r); }
};

std::vector<PowerLaw> power_laws(const std::vector<Point>& points) {
  constexpr double kWhole = 0.01;  // where circuit and resistance are of the same size a power is none
  std::vector<PowerLaw> laws;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Point &from = points[i], &to = points[i + 1];
    const double power = (to.log_size - from.log_size) / (to.log_r - from.log_r);
    if (std::abs(power - std::round(power)) <= kWhole)
      laws.push_back({static_cast<int>(std::round(power)), from, to.log_r});
  }
  return laws;
}

/// Without those that are rounding: what is left where terms cancel that follow the law of another part of the scan.
std::vector<Point> beyond_rounding(const std::vector<Point>& points) {
  constexpr double kRoundings = 64.0;
  const double rounding = std::log10(kRoundings * std::numeric_limits<double>::epsilon());
  const std::vector<PowerLaw> laws = power_laws(points);
  std::vector<Point> left;
  std::copy_if(points.begin(), points.end(), std::back_inserter(left), [&](const Point& point) {
    return std::none_of(laws.begin(), laws.end(),
                        [&](const PowerLaw& law) { return point.log_size <= law.at(point.log_r) + rounding; });
  });
  return left;
}

/// Where one law ends and the next begins.
struct Knee {
  double log_r = 0.0, weight = 0.0;
};

std::vector<Knee> knees_between(const std::vector<PowerLaw>& laws) {
  constexpr double kSame = 0.02;  // decades between two parts of one law
  std::vector<Knee> knees;
  for (std::size_t i = 0; i + 1 < laws.size(); ++i) {
    const PowerLaw &before = laws[i], &after = laws[i + 1];
    const int change = after.power - before.power;
    const double apart = before.first.log_size - after.at(before.first.log_r);
    if (change != 0)
      knees.push_back({before.first.log_r + apart / change, std::abs(static_cast<double>(change))});
    else if (std::abs(apart) > kSame)
      knees.push_back({0.5 * (before.log_end + after.first.log_r), std::min(1.0, std::abs(apart))});
  }
  return knees;
}

/// Without those so far above the lowest that terms of its size are lost there: what is left is rounding.
void drop_far(std::vector<Knee>& knees) {
  constexpr double kFar = 12.0, kSure = 0.05;
  double lowest = std::numeric_limits<double>::infinity();
  for (const Knee& knee : knees)
    if (knee.weight > kSure) lowest = std::min(lowest, knee.log_r);
  std::erase_if(knees, [&](const Knee& knee) { return knee.log_r > lowest + kFar; });
}

struct Seen {
  std::vector<Knee> knees;
  std::optional<double> alone;  ///< log10 of the r of the time constant
};

Seen look_at(const std::vector<SlopesThrough>& scan, double span) {
  Seen seen;
  for (std::size_t order = 0; order < 3; ++order) {
    std::vector<Point> points;
    for (const SlopesThrough& at : scan)
      if (at.slopes[order] != 0.0 && std::isfinite(at.slopes[order]))
        points.push_back(
            {std::log10(at.resistance), std::log10(std::abs(at.slopes[order])) + std::log10(at.resistance)});
    const std::vector<PowerLaw> laws = power_laws(beyond_rounding(points));
    const std::vector<Knee> knees = knees_between(laws);
    seen.knees.insert(seen.knees.end(), knees.begin(), knees.end());
    const double time = static_cast<double>(order) * std::log10(span);
    if (order > 0 && !seen.alone && !laws.empty() && laws.front().power != 0)
      seen.alone = laws.front().first.log_r - (laws.front().first.log_size + time) / laws.front().power;
  }
  drop_far(seen.knees);
  return seen;
}

/// What knees weigh in a range, and their mean there.
class KneeRange {
 public:
  static constexpr double kDecades = 8.0;

  explicit KneeRange(std::vector<Knee> knees) : knees_(std::move(knees)), weight_{0.0}, moment_{0.0} {
    std::sort(knees_.begin(), knees_.end(), [](const Knee& a, const Knee& b) { return a.log_r < b.log_r; });
    for (const Knee& knee : knees_) {
      weight_.push_back(weight_.back() + knee.weight);
      moment_.push_back(moment_.back() + knee.weight * knee.log_r);
    }
  }
  [[nodiscard]] const std::vector<Knee>& knees() const { return knees_; }
  [[nodiscard]] double weight(double from) const { return weight_[end(from)] - weight_[begin(from)]; }
  [[nodiscard]] double mean(double from) const { return (moment_[end(from)] - moment_[begin(from)]) / weight(from); }

 private:
  [[nodiscard]] std::size_t begin(double from) const {
    const auto at = std::lower_bound(knees_.begin(), knees_.end(), from,
                                     [](const Knee& knee, double log_r) { return knee.log_r < log_r; });
    return static_cast<std::size_t>(at - knees_.begin());
  }
  [[nodiscard]] std::size_t end(double from) const {
    const auto at = std::upper_bound(knees_.begin(), knees_.end(), from + kDecades,
                                     [](double log_r, const Knee& knee) { return log_r < knee.log_r; });
    return static_cast<std::size_t>(at - knees_.begin());
  }

  std::vector<Knee> knees_;
  std::vector<double> weight_, moment_;  ///< of all knees before one
};

}  // namespace

std::vector<double> seen_resistances(const std::vector<std::vector<SlopesThrough>>& scans, double span) {
  std::vector<Seen> seen;
  std::vector<Knee> every;
  for (const auto& scan : scans) {
    seen.push_back(look_at(scan, span));
    every.insert(every.end(), seen.back().knees.begin(), seen.back().knees.end());
  }
  const KneeRange all(std::move(every));
  std::vector<double> resistances;
  for (Seen& at : seen) {
    const KneeRange own(std::move(at.knees));
    double best = 0.0, log_r = at.alone.value_or(0.0);
    for (const Knee& knee : own.knees()) {
      const double weight = own.weight(knee.log_r) + all.weight(knee.log_r);
      if (!(weight > best)) continue;
      best = weight;
      log_r = own.mean(knee.log_r);
    }
    resistances.push_back(std::pow(10.0, log_r));
  }
  return resistances;
}

}  // namespace bgsim
