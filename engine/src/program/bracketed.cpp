// Loops with one variable at the start, where no iteration has led to a solution: between two points at which the
// residual has different signs there is one, if it is continuous.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "program/evaluator_impl.hpp"

namespace bgsim {

namespace {

/// Both signs of 60 decades, and 0; increasing.
std::vector<double> places() {
  constexpr int kDecades = 30, kInOne = 3;
  std::vector<double> result;
  for (int k = kDecades * kInOne; k >= -kDecades * kInOne; --k) result.push_back(-std::pow(10.0, double(k) / kInOne));
  result.push_back(0.0);
  for (int k = -kDecades * kInOne; k <= kDecades * kInOne; ++k) result.push_back(std::pow(10.0, double(k) / kInOne));
  return result;
}

}  // namespace

LoopOutcome Evaluator::Impl::solve_bracketed(std::size_t block) {
  if (program.blocks[block].size != 1) return LoopOutcome::no_convergence;
  double& z = tears_of(block)[0];
  const double start = z;
  const auto residual = [&](double at) {
    z = at;
    return load_residual(block) ? loops[block].residual[0] : std::numeric_limits<double>::quiet_NaN();
  };
  std::optional<std::pair<double, double>> nearest;
  double distance = std::numeric_limits<double>::infinity();
  double before = std::numeric_limits<double>::quiet_NaN(), value_before = before;
  for (const double place : places()) {
    if (!goes_on()) return LoopOutcome::no_convergence;
    const double value = residual(place);
    const double away = std::max({before - start, start - place, 0.0});
    if (((value_before < 0.0 && value >= 0.0) || (value_before > 0.0 && value <= 0.0)) && away < distance) {
      nearest = {before, place};
      distance = away;
    }
    before = place;
    value_before = value;
  }
  if (!nearest) return LoopOutcome::no_convergence;
  auto [low, high] = *nearest;
  const bool rises = residual(high) > residual(low);
  for (double middle = low + (high - low) / 2; middle > low && middle < high; middle = low + (high - low) / 2) {
    const double value = residual(middle);
    if (std::isnan(value)) return LoopOutcome::no_convergence;
    ((value > 0.0) == rises ? high : low) = middle;
  }
  const double at_low = std::abs(residual(low)), at_high = std::abs(residual(high));
  z = at_low < at_high ? low : high;
  return accept_by_rounding(block);  // a pole changes sign too, but is no solution
}

}  // namespace bgsim
