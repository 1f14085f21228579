#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "run/watch/events.hpp"

namespace bgsim {
namespace {

constexpr double kManyRoundings = 64.0;
constexpr std::size_t kManyInARow = 256;

}  // namespace

/// By guard: what the roundings of states and time make of it, as far as four ways to round them show.
std::vector<double> EventWatch::roundings(double t, const double* x, const Branch& branch) {
  constexpr double kUlps = 2.0 * std::numeric_limits<double>::epsilon();
  std::vector<double> moves(x, x + program_.state_names.size());
  for (double& move : moves) move *= kUlps;
  return spread(t, x, branch, values_, kUlps * t, moves);
}

/// By guard: by how much it leaves the values @p here at (t, x), the largest of four ways: time moves by @p later, each
/// state by its @p moves up or down.
std::vector<double> EventWatch::spread(double t, const double* x, const Branch& branch, const std::vector<double>& here,
                                       double later, const std::vector<double>& moves) {
  constexpr std::array<std::uint32_t, 4> kWays{0, 0x80000000U, 0x9E3779B9U, 0x85EBCA6BU};  // all alike, by turns, mixed
  std::vector<double> moved(moves.size()), there(here.size()), result(here.size(), 0.0);
  Branch probe = branch;
  for (const std::uint32_t way : kWays) {
    for (std::size_t k = 0; k < moved.size(); ++k) {
      const bool down = static_cast<std::uint32_t>(k) * way >= 0x80000000U;
      moved[k] = x[k] + (down ? -moves[k] : moves[k]);
    }
    if (!evaluator_.guards(t + later, moved.data(), probe, there.data())) continue;
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = std::max(result[i], std::abs(there[i] - here[i]));
  }
  return result;
}

/// How far a guard moves along the @p rates in a time that shows it beyond @p rounding. None if nothing moves it, or if
/// it cannot be evaluated there (then @p fault).
std::optional<EventWatch::Motion> EventWatch::motion(std::size_t guard, double t, const double* x,
                                                     const std::vector<double>& rates, Branch branch, double rounding,
                                                     bool& fault) {
  constexpr double kFirst = 1e-13, kFarthest = 1e9, kLonger = 4.0;
  std::vector<double> ahead(rates.size()), there(side_.size());
  for (double after = kFirst * span_; after < kFarthest * span_; after *= kLonger) {
    for (std::size_t k = 0; k < rates.size(); ++k) ahead[k] = x[k] + after * rates[k];
    fault = !evaluator_.guards(t + after, ahead.data(), branch, there.data());
    if (fault) return std::nullopt;
    const double change = there[guard] - values_[guard];
    if (std::abs(change) > kManyRoundings * rounding) return Motion{after, change};
  }
  return std::nullopt;
}

bool EventWatch::turn_back(double t, const double* x, Branch& branch) {
  constexpr double kSmall = 1e-9, kLast = 1e-3;
  const std::vector<std::size_t> candidates = std::exchange(crossed_here_, {});
  std::vector<double> rates(program_.state_names.size());
  Branch probe = branch;
  if (candidates.empty() || !guards(t, x, branch, values_) || !prepare(t, x, probe) ||
      !evaluator_.rates(t, x, probe, rates.data()))
    return false;
  const std::vector<double> rounded = roundings(t, x, branch);
  bool turned = false;
  for (const std::size_t i : candidates) {
    if (hold_[i] == kSetOut) continue;  // it is 0, and its series says where it goes
    if (border_[i] || denominators_.has(i) || followed_[i] || stiction_.held(i) ||
        program_.relations[relation_[i]].kind != Relation::Kind::condition)
      continue;
    // One that was turned back before is located as far beyond the border as it was held for then.
    const double beyond = std::abs(values_[i]);
    const double rounding =
        std::max({beyond - turned_hold_[i], rounded[i], std::numeric_limits<double>::epsilon() * largest_[i]});
    if (!(rounding <= std::max(kSmall * largest_[i], 4.0 * rounded[i]))) continue;  // what was set has moved it away
    bool fault = false;
    const auto moves = motion(i, t, x, rates, probe, rounding, fault);
    if (!moves) {
      rests_ = rests_ || !fault;
      continue;
    }
    const int direction = sign_of(moves->change);
    // At its border exactly it has no side yet, but the mode of one.
    if (side_[i] == 0 ? !changes_mode(i, direction, branch) : direction == side_[i]) continue;
    if (moves->after > kLast * span_) {  // on its way back, but for longer than the run nothing is seen of it
      unresolved_ = true;
      continue;
    }
    std::fill(direction_.begin(), direction_.end(), 0);
    direction_[i] = direction;
    evaluator_.cross(direction_, branch);
    side_[i] = direction;
    turned_at_[i] = t;
    turned_slope_[i] = std::abs(moves->change) / moves->after;
    turned_hold_[i] = hold_[i] = beyond + 2.0 * rounding;
    turned = true;
  }
  return turned;
}

/// Whether what lies between the instant at which a guard was turned back and the one at which it crosses again, now,
/// is lost: it was away by no more than rounding; or by less than the tolerances tell, and crosses against the rates,
/// as a method does whose first steps after a restart are long beside that; or by less than that many times in a row
/// and does not come nearer, as where the errors of such steps keep a ball bouncing.
bool EventWatch::lost_since_turned(std::size_t guard, double t, const double* x, const Branch& branch) {
  if (!(turned_slope_[guard] > 0.0)) return false;
  const double way = (t - turned_at_[guard]) * turned_slope_[guard];
  if (way < kManyRoundings * turned_hold_[guard]) return true;  // on a parabola it was away by a quarter of that
  std::vector<double> rates(program_.state_names.size()), moved(x, x + rates.size()), there(side_.size());
  Branch probe = branch;
  if (!evaluator_.guards(t, x, probe, values_.data()) || !evaluator_.rates(t, x, probe, rates.data())) return false;
  double error = 0.0;
  for (std::size_t k = 0; k < moved.size(); ++k) {
    moved[k] = x[k] + tolerances_.absolute(k) + tolerances_.relative() * std::abs(x[k]);
    if (evaluator_.guards(t, moved.data(), probe, there.data())) error += std::abs(there[guard] - values_[guard]);
    moved[k] = x[k];
  }
  if (way > error) {
    within_[guard] = 0;
    return false;
  }
  if (within_[guard]++ == 0) within_way_[guard] = way;
  if (within_[guard] == kManyInARow) {
    if (!(way < within_way_[guard])) return true;
    within_[guard] = 0;
  }
  bool fault = false;
  const auto moves = motion(guard, t, x, rates, probe, std::abs(values_[guard]), fault);
  return moves && sign_of(moves->change) == side_[guard];
}

}  // namespace bgsim
