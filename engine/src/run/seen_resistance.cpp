#include "run/seen_resistance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace bgsim {
namespace {

/// A part of the scan where r |slope| is a power of r; all as decades.
struct PowerLaw {
  int power = 0;
  double begin = 0.0, end = 0.0;  ///< r
  double size = 0.0;              ///< r |slope| at the begin
  [[nodiscard]] double at(double r) const { return size + power * (r - begin); }
};

std::vector<PowerLaw> power_laws(const std::vector<SlopesThrough>& scan, std::size_t order) {
  constexpr double kWhole = 0.01;  // where circuit and resistance are of the same size a power is none
  std::vector<PowerLaw> laws;
  std::optional<PowerLaw> last;
  for (const SlopesThrough& point : scan) {
    if (point.slopes[order] == 0.0 || !std::isfinite(point.slopes[order])) continue;
    const double r = std::log10(point.resistance), size = std::log10(std::abs(point.slopes[order])) + r;
    if (last) {
      const double power = (size - last->size) / (r - last->begin), whole = std::round(power);
      if (std::abs(power - whole) <= kWhole) laws.push_back({static_cast<int>(whole), last->begin, r, last->size});
    }
    last = PowerLaw{0, r, r, size};
  }
  return laws;
}

/// Where one law ends and the next begins.
struct Knee {
  double r = 0.0, weight = 0.0;
};

void add_knees(const std::vector<PowerLaw>& laws, std::vector<Knee>& knees) {
  constexpr double kSame = 0.02;  // decades between two parts of one law
  for (std::size_t i = 0; i + 1 < laws.size(); ++i) {
    const PowerLaw &before = laws[i], &after = laws[i + 1];
    const int change = after.power - before.power;
    const double apart = before.size - after.at(before.begin);
    if (change != 0)
      knees.push_back({before.begin + apart / change, std::abs(static_cast<double>(change))});
    else if (std::abs(apart) > kSame)
      knees.push_back({0.5 * (before.end + after.begin), std::min(1.0, std::abs(apart))});
  }
}

double lowest_of(const std::vector<Knee>& knees) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Knee& knee : knees) lowest = std::min(lowest, knee.r);
  return lowest;
}

double mean(const std::vector<Knee>& knees) {
  constexpr double kFar = 6.0;
  const double lowest = lowest_of(knees);
  double weight = 0.0, sum = 0.0;
  for (const Knee& knee : knees) {
    if (knee.r > lowest + kFar) continue;
    weight += knee.weight;
    sum += knee.weight * knee.r;
  }
  return sum / weight;
}

}  // namespace

double seen_resistance(const std::vector<SlopesThrough>& scan, double span) {
  constexpr double kRoundings = 10.0;  // decades
  std::vector<Knee> knees;
  std::optional<double> alone;
  double least = -std::numeric_limits<double>::infinity();
  for (std::size_t order = 0; order < 3; ++order) {
    const std::vector<PowerLaw> laws = power_laws(scan, order);
    std::vector<Knee> of_order;
    add_knees(laws, of_order);
    for (const Knee& knee : of_order)
      if (knee.r > least) knees.push_back(knee);
    if (order == 0 && !knees.empty()) least = lowest_of(knees) - kRoundings;
    if (alone || laws.empty() || laws.front().power == 0) continue;
    alone =
        laws.front().begin - (laws.front().size + static_cast<double>(order) * std::log10(span)) / laws.front().power;
  }
  return std::pow(10.0, knees.empty() ? alone.value_or(0.0) : mean(knees));
}

}  // namespace bgsim
