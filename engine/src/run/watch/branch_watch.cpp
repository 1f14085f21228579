#include "run/watch/branch_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "run/failures.hpp"

namespace bgsim {
namespace {

constexpr double kLarge = 0.1;  ///< part of its magnitude by which a loop variable may change unasked

}  // namespace

BranchWatch::BranchWatch(const Program& program, Evaluator& evaluator, double start, double stop)
    : program_(program), evaluator_(evaluator) {
  constexpr double kFirst = 1e-9;  // of the scene: loops at rest begin with roundings
  ripe_ = start + kFirst * (stop - start);
  watched_.assign(program.tear_names.size(), false);
  for (const ProgramBlock& block : program.blocks) {
    if (block.linear) continue;
    any_ = true;
    std::fill_n(watched_.begin() + block.first_tear, block.size, true);
  }
  largest_.assign(watched_.size(), 0.0);
  if (any_) orientation_.assign(program.blocks.size(), 0);
}

void BranchWatch::begin(const Integrator& integrator) {
  if (!any_) return;
  last_ = integrator.branch().tears;
  last_states_.assign(integrator.end(), integrator.end() + program_.state_names.size());
  for (std::size_t b = 0; b < orientation_.size(); ++b) orientation_[b] = evaluator_.orientation(b);
  for (std::size_t i = 0; i < last_.size(); ++i) largest_[i] = std::max(largest_[i], std::abs(last_[i]));
}

BranchWatch::Change BranchWatch::change(const std::vector<double>& from, const std::vector<double>& to,
                                        const std::vector<double>& rounding) const {
  // The first doubles above 0 are as far from each other as from 0: what a wave has not reached jumps from one to the
  // next (a pipe from rest).
  constexpr double kLeast = std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
  Change most;
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    if (!watched_[i]) continue;
    const double scale = std::max({largest_[i], std::abs(from[i]), std::abs(to[i])});
    const double moved = std::abs(to[i] - from[i]) - (rounding.empty() ? 0.0 : rounding[i]);
    const double size = scale > kLeast ? std::max(0.0, moved) / scale : 0.0;
    if (size > most.size) most = {size, i};
  }
  return most;
}

/// The loops' solution at the states y_.
bool BranchWatch::solve(Integrator& integrator, double t, const std::vector<double>& start,
                        std::vector<double>& solution) {
  probe_ = integrator.branch();
  probe_.tears = start;
  std::vector<double> rates(program_.state_names.size());
  if (!evaluator_.rates(t, y_.data(), probe_, rates.data())) return false;
  solution = probe_.tears;
  return true;
}

bool BranchWatch::solve_at(Integrator& integrator, double t, const std::vector<double>& start,
                           std::vector<double>& solution) {
  y_.resize(integrator.size());
  integrator.interpolate(t, y_.data());
  return solve(integrator, t, start, solution);
}

/// How far two solutions beside each other can be apart by rounding, where the last one was found.
std::vector<double> BranchWatch::rounding_at(double t) {
  std::vector<double> bounds(watched_.size());
  evaluator_.tear_rounding(t, y_.data(), probe_, bounds.data());
  for (double& bound : bounds) bound = std::isfinite(bound) ? 2.0 * bound : 0.0;
  return bounds;
}

/// Whether the variable changes by half as much and more again if the states change once more as they did between these
/// times: after a fold it does not.
bool BranchWatch::goes_on(Integrator& integrator, double from, double to, std::size_t tear) {
  constexpr double kAsFast = 0.5;
  std::vector<double> solution;
  std::vector<double> before = last_states_;
  if (from != integrator.previous()) {  // a step may be shorter than the roundings of its times
    if (!solve_at(integrator, from, low_, solution)) return false;
    before = y_;
  }
  if (!solve_at(integrator, to, high_, solution)) return false;
  std::vector<double> rates(program_.state_names.size()), ahead(rates.size());
  for (std::size_t i = 0; i < ahead.size(); ++i) ahead[i] = y_[i] + (y_[i] - before[i]);
  return evaluator_.rates(to + (to - from), ahead.data(), probe_, rates.data()) &&
         std::abs(probe_.tears[tear] - high_[tear]) >= kAsFast * std::abs(high_[tear] - low_[tear]);
}

const ProgramBlock& BranchWatch::block_of(std::size_t tear) const {
  return *std::find_if(program_.blocks.begin(), program_.blocks.end(), [tear](const ProgramBlock& block) {
    return tear >= block.first_tear && tear < block.first_tear + block.size;
  });
}

/// Between the solutions low_ and high_: halves the way from @p from to @p to, towards where most of the change is,
/// until the change is small. What is left of it if it stays large however short the way.
template <class SolveAt>
std::optional<BranchWatch::Change> BranchWatch::narrow(double& from, double& to, const std::vector<double>& rounding,
                                                       SolveAt solve_in_between) {
  constexpr double kShrinks = 0.7;  // what is smooth, even a square root at zero, changes less in half the time
  constexpr int kHalvings = 40;
  const double small = std::max(kLarge, kShrinks * change(low_, high_, rounding).size);
  for (int halvings = 0; halvings < kHalvings && change(low_, high_, rounding).size > small; ++halvings) {
    const double middle = from + (to - from) / 2;
    if (!(middle > from && middle < to) || !solve_in_between(middle)) break;
    if (change(low_, middle_, rounding).size > change(middle_, high_, rounding).size) {
      to = middle;
      high_ = middle_;
    } else {
      from = middle;
      low_ = middle_;
    }
  }
  const Change left = change(low_, high_, rounding);
  return left.size > small ? std::optional(left) : std::nullopt;
}

std::optional<Diagnostic> BranchWatch::check(Integrator& integrator) {
  if (!any_) return std::nullopt;
  now_ = integrator.branch().tears;
  std::optional<Diagnostic> jump;
  for (std::size_t b = 0; b < orientation_.size() && !jump; ++b) {
    const ProgramBlock& block = program_.blocks[b];
    if (block.linear || orientation_[b] * evaluator_.orientation(b) >= 0) continue;
    const std::size_t tear = block.first_tear;
    jump = branch_failure(block, program_.tear_names[tear], integrator.time(), last_[tear], now_[tear]);
  }
  if (jump) return jump;
  if (integrator.time() > ripe_ && change(last_, now_, {}).size > kLarge) jump = look_between(integrator);
  if (!jump) begin(integrator);
  return jump;
}

std::optional<Diagnostic> BranchWatch::look_between(Integrator& integrator) {
  const double previous = integrator.previous();
  if (!solve_at(integrator, integrator.time(), last_, now_)) return std::nullopt;
  const std::vector<double> rounding = rounding_at(integrator.time());
  const auto failure = [&](const Change& left, double t) {
    return branch_failure(block_of(left.tear), program_.tear_names[left.tear], t, low_[left.tear], high_[left.tear]);
  };
  // The last evaluation was that of the step's end, or nearly so, and a multistep method's polynomial need not begin at
  // the last states. What lies between is within the tolerance, but a law may be ever so steep there.
  low_ = last_;
  std::copy(last_states_.begin(), last_states_.end(), y_.begin());
  if (previous < integrator.time() && solve(integrator, previous, last_, low_) &&
      solve_at(integrator, previous, low_, high_)) {
    const std::vector<double> begin = high_, states = y_;
    const auto on_the_way = [&](double part) {
      for (std::size_t i = 0; i < last_states_.size(); ++i)
        y_[i] = last_states_[i] + part * (states[i] - last_states_[i]);
      return solve(integrator, previous, low_, middle_);
    };
    double from = 0.0, to = 1.0;
    if (change(low_, high_, rounding).size > kLarge)
      if (const auto left = narrow(from, to, rounding, on_the_way)) return failure(*left, previous);
    low_ = begin;
  }
  high_ = now_;
  double from = previous, to = integrator.time();
  const auto left = narrow(from, to, rounding, [&](double t) { return solve_at(integrator, t, low_, middle_); });
  return left && !goes_on(integrator, from, to, left->tear) ? std::optional(failure(*left, to)) : std::nullopt;
}

}  // namespace bgsim
