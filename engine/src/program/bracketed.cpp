// Loops with one variable where no iteration has led to a solution: between two points at which the residual has
// different signs there is one, if it is continuous.
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

double Evaluator::Impl::residual_at(std::size_t block, double at) {
  tears_of(block)[0] = at;
  return load_residual(block) ? loops[block].residual[0] : std::numeric_limits<double>::quiet_NaN();
}

LoopOutcome Evaluator::Impl::bisect(std::size_t block, double low, double high) {
  const double first = residual_at(block, low);
  for (double middle = low + (high - low) / 2; middle != low && middle != high; middle = low + (high - low) / 2) {
    const double value = residual_at(block, middle);
    if (std::isnan(value)) return LoopOutcome::no_convergence;
    ((value > 0.0) == (first > 0.0) && value != 0.0 ? low : high) = middle;
  }
  const double at_low = std::abs(residual_at(block, low)), at_high = std::abs(residual_at(block, high));
  tears_of(block)[0] = at_low < at_high ? low : high;
  return accept_by_rounding(block);  // a pole changes sign too, but is no solution
}

/// At the start of a run, where nothing is known of the solution: the sign change that is nearest to the present value.
LoopOutcome Evaluator::Impl::solve_bracketed(std::size_t block) {
  if (program.blocks[block].size != 1) return LoopOutcome::no_convergence;
  const double start = tears_of(block)[0];
  std::optional<std::pair<double, double>> nearest;
  double distance = std::numeric_limits<double>::infinity();
  double before = std::numeric_limits<double>::quiet_NaN(), value_before = before;
  for (const double place : places()) {
    if (!goes_on()) return LoopOutcome::no_convergence;
    const double value = residual_at(block, place);
    const double away = std::max({before - start, start - place, 0.0});
    if (((value_before < 0.0 && value >= 0.0) || (value_before > 0.0 && value <= 0.0)) && away < distance) {
      nearest = {before, place};
      distance = away;
    }
    before = place;
    value_before = value;
  }
  return nearest ? bisect(block, nearest->first, nearest->second) : LoopOutcome::no_convergence;
}

/// In a run: to either side, in ever longer strides, for as long as the residual does not grow. Where it changes its
/// sign so is the solution that the present one goes over into; beyond a fold there is none. An orifice that was at
/// rest, e = k f |f|, has no slope there that says how far away it is.
LoopOutcome Evaluator::Impl::solve_downhill(std::size_t block) {
  if (program.blocks[block].size != 1) return LoopOutcome::no_convergence;
  constexpr double kShortest = 1e-300, kLonger = 10.0;
  const double start = tears_of(block)[0], value = residual_at(block, start);
  for (const double direction : {1.0, -1.0}) {
    double before = start, value_before = value;
    for (double stride = std::max(kShortest, std::numeric_limits<double>::epsilon() * std::abs(start));
         std::isfinite(start + direction * stride); stride *= kLonger) {
      if (!goes_on()) return LoopOutcome::no_convergence;
      const double at = start + direction * stride, value_at = residual_at(block, at);
      if ((value_before > 0.0 && value_at <= 0.0) || (value_before < 0.0 && value_at >= 0.0))
        return bisect(block, before, at);
      if (!(std::abs(value_at) <= std::abs(value_before))) break;
      before = at;
      value_before = value_at;
    }
  }
  return LoopOutcome::no_convergence;
}

}  // namespace bgsim
