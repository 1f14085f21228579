#include "run/sink/global_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "bgsim/text.hpp"
#include "run/integrate/dense_jacobian.hpp"
#include "run/sink/gauss_rule.hpp"

namespace bgsim {

namespace {

/// The propagation over a step that is long beside what it follows is that of the L-stable SDIRK method of order two
/// with this diagonal: a stiff error is forgotten.
constexpr double kDiagonal = 1.0 - 1.0 / std::numbers::sqrt2;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr std::size_t kMostParts = 16;  ///< of a step

double legendre(int n, double x) {
  return n == 0 ? 1.0 : n == 1 ? x : n == 2 ? 1.5 * x * x - 0.5 : (2.5 * x * x - 1.5) * x;
}

/// @p sum += factor J x; J by columns.
void add_product(const std::vector<double>& jacobian, const std::vector<double>& x, double factor,
                 std::vector<double>& sum) {
  const std::size_t n = x.size();
  for (std::size_t j = 0; j < n; ++j) {
    const double* const column = jacobian.data() + j * n;
    const double by = factor * x[j];
    for (std::size_t i = 0; i < n; ++i) sum[i] += column[i] * by;
  }
}

}  // namespace

GlobalError::GlobalError(const Program& program, Evaluator& evaluator, const Tolerances& tolerances,
                         const RunInputs& inputs, bool wanted)
    : program_(program),
      evaluator_(evaluator),
      tolerances_(tolerances),
      measuring_(false),
      near_misses_(program, evaluator, tolerances) {
  const std::size_t states = program.state_names.size(), outputs = program.output_names.size();
  if (!wanted)
    why_not_ = "switched off";
  else if (!program.plan.explicit_form)
    why_not_ = "the system has no explicit form";
  else if (states > kDenseStates)
    why_not_ = "more than " + std::to_string(kDenseStates) + " states";
  else
    measuring_ = states > 0 && outputs > 0;
  possible_ = !wanted || why_not_.empty() || states == 0;  // without states nothing is integrated
  if (!measuring_) return;
  from_ = to_ = sums_.start = inputs.start;
  error_.assign(states, 0.0);
  begin_error_.assign(states, 0.0);
  inner_errors_.assign((kMostParts - 1) * states, 0.0);
  sums_.largest.assign(outputs, 0.0);
  sums_.bounded.assign(outputs, 0.0);
  sums_.beyond.assign(outputs, 0.0);
  sums_.least_value.assign(outputs, kInfinity);
  sums_.most_value.assign(outputs, -kInfinity);
  all_.resize(states);
  std::iota(all_.begin(), all_.end(), 0U);
  y_.resize(states + program.tear_names.size());
  middle_.resize(states);
  rates_.resize(states);
  rates_before_.resize(states);
  entries_.resize(program.jacobian_pattern.row.size());
  row_.resize(outputs);
  state_rounding_.resize(states);
  rounding_.resize(outputs);
  for (auto* const by_point : {&at_, &slope_at_, &rate_at_})
    for (std::vector<double>& vector : *by_point) vector.resize(states);
  for (auto* const vector : {&right_, &moment_, &second_, &defect_, &added_, &flow_}) vector->resize(states);
  within_.assign(kMostParts, Within(states));
  exponential_ = PadeExponential(states);
}

void GlobalError::give_up(const std::string& why) {
  measuring_ = false;
  why_not_ = why;
  lost_ = why;
}

/// Whether a sign or condition is held at its border.
bool GlobalError::holds(const Branch& branch) const {
  return std::any_of(program_.guarded.begin(), program_.guarded.end(),
                     [&](std::uint32_t index) { return program_.relations[index].is_between(branch.modes[index]); });
}

/// Sets the modes of @p branch to those that its guards have at a point. Signs that are held stay.
bool GlobalError::set_modes(double t, const std::vector<double>& y, Branch& branch) {
  const std::size_t count = evaluator_.guard_count();
  if (count == 0) return true;
  guards_.resize(count);
  direction_.assign(count, 0);
  if (!evaluator_.guards(t, y.data(), branch, guards_.data())) return false;
  std::size_t guard = 0;
  for (const std::uint32_t index : program_.guarded) {
    const Relation& relation = program_.relations[index];
    if (relation.has_borders()) {
      for (std::size_t side = guard; side < guard + 2; ++side)
        if (guards_[side] < 0.0) direction_[side] = -1;
      guard += 2;
      continue;
    }
    if (!relation.is_between(branch.modes[index]) && guards_[guard] != 0.0)
      direction_[guard] = guards_[guard] > 0.0 ? 1 : -1;
    ++guard;
  }
  evaluator_.cross(direction_, branch);
  return true;
}

/// The rates at a point. A dense output may be beyond the border at which the laws of this side end (a root at an empty
/// tank): there those of the point hold.
bool GlobalError::rates_at(double t, const std::vector<double>& y, const Integrator::Rates& held, double* rates) {
  if (held) return held(t, y.data(), branch_, rates);
  if (evaluator_.rates(t, y.data(), branch_, rates)) return true;
  branch_there_ = branch_;
  return set_modes(t, y, branch_there_) && evaluator_.rates(t, y.data(), branch_there_, rates);
}

/// In the middle between the dense output, in y_, and where the exact solution is taken to be: where a law bends more
/// sharply than the error is small (a square root at 0), the slope there is nearer to what takes one to the other. With
/// the modes that hold there: beyond a border a law goes on as it was never meant to (a transistor's conductance).
bool GlobalError::see_jacobian(double t, double* jacobian) {
  for (std::size_t i = 0; i < error_.size(); ++i) middle_[i] = y_[i] - 0.5 * error_[i];
  branch_there_ = branch_;
  const bool there =
      set_modes(t, middle_, branch_there_) && evaluator_.jacobian(t, middle_.data(), branch_there_, entries_.data());
  // A law without a slope where it rests (a turbulent pipe between two tanks that are level) has one over a distance.
  if (!there && !evaluator_.jacobian(t, y_.data(), branch_, entries_.data())) return see_differences(t, {}, jacobian);
  spread_entries(program_.jacobian_pattern, entries_.data(), jacobian);
  return true;
}

/// The Jacobian by differences from rates_, over the tolerances, as the integrators take it.
bool GlobalError::see_differences(double t, const Integrator::Rates& held, double* jacobian) {
  static const double kPart = std::sqrt(kEpsilon);
  std::copy_n(y_.begin(), middle_.size(), middle_.begin());
  for (std::size_t j = 0; j < error_.size(); ++j) {
    double* const column = jacobian + j * error_.size();
    std::fill_n(column, error_.size(), 0.0);
    const double move = std::max(kPart * std::abs(y_[j]), tolerances_.absolute(j));
    if (move == 0.0) continue;
    middle_[j] = y_[j] + move;
    if (!rates_at(t, middle_, held, rates_before_.data())) {
      give_up("the slopes of the rates could not be evaluated at t = " + number_text(t, 6));
      return false;
    }
    for (std::size_t i = 0; i < error_.size(); ++i) column[i] = (rates_before_[i] - rates_[i]) / (middle_[j] - y_[j]);
    middle_[j] = y_[j];
  }
  return true;
}

void GlobalError::add(double from, const std::vector<double>& x, double to, Integrator& integrator) {
  if (!measuring_ || !(to > from)) return;
  const Stopwatch watch(seconds_);
  const std::size_t states = error_.size();
  const auto interpolate = [&integrator](double t, double* y) { integrator.interpolate(t, y); };
  polynomial_.take(integrator.previous(), integrator.time(), integrator.order(), all_, integrator.size(), interpolate);
  branch_ = integrator.branch();
  branch_.given = false;
  std::swap(begin_error_, error_);
  from_ = from;
  to_ = to;
  sums_.steps += 1.0;
  for (std::size_t i = 0; i < states; ++i) begin_error_[i] += polynomial_.at(i, from).first - x[i];
  error_ = begin_error_;
  if (take_step(integrator) && matters(error_))
    near_misses_.look(polynomial_, from, to, integrator.branch(), begin_error_, error_);
}

/// Takes error_ over the last step. False if it gave up.
bool GlobalError::take_step(Integrator& integrator) {
  const Integrator::Rates& held = integrator.special_rates();
  const auto points =
      std::clamp(static_cast<std::size_t>(integrator.order() / 2 + 1), std::size_t{1}, Within::kMostPoints);
  if (!matters(begin_error_) || !integrator.one_step()) {
    if (!take_parts(1, points, held)) return false;
    if (!matters(error_) || !integrator.one_step()) return true;
  }
  // What is left out falls with the square of a part's length, by a fourth. If it does not, a law bends so sharply that
  // shorter parts show no more of it.
  constexpr double kMost = 0.25;
  double before = kInfinity;
  for (std::size_t parts = begin_parts_;; parts *= 2) {
    if (!take_parts(parts, points, held)) return false;
    const double out = left_out();
    const bool sharp = out > 0.5 * before;
    if (out > kMost && !sharp && parts < kMostParts) {
      before = out;
      continue;
    }
    begin_parts_ = parts > 2 && (sharp || 4.0 * out <= kMost) ? parts / 2 : parts;
    return true;
  }
}

/// Takes error_ from begin_error_ over the last step in so many parts of equal length.
bool GlobalError::take_parts(std::size_t parts, std::size_t points, const Integrator::Rates& held) {
  error_ = begin_error_;
  parts_ = parts;
  for (std::size_t k = 0; k < parts; ++k) {
    if (k > 0)
      std::copy(error_.begin(), error_.end(),
                inner_errors_.begin() + static_cast<std::ptrdiff_t>((k - 1) * error_.size()));
    if (!propagate(part_begin(k), part_begin(k + 1), points, held, within_[k])) return false;
  }
  return true;
}

double GlobalError::part_begin(std::size_t part) const {
  return part == parts_ ? to_ : from_ + static_cast<double>(part) / static_cast<double>(parts_) * (to_ - from_);
}

/// What first order leaves out over the parts of the last step, in parts of what r adds to the error there: both as the
/// largest over the states, beside what these have reached. Left out are J^2 times the integral of (to - t)^2 r / 2,
/// and J', by differences from one part to the next, times that of (t - middle) e. Each of them goes through (1 - g hJ)
/// as often as J is in it, and twice more, as the error does: what is stiff forgets it.
double GlobalError::left_out() {
  const std::size_t states = error_.size();
  const auto size = [&](const std::vector<double>& values) {
    double most = 0.0;
    for (std::size_t i = 0; i < states; ++i)
      if (const double reached = tolerances_.largest(i); reached > 0.0)
        most = std::max(most, std::abs(values[i]) / reached);
    return most;
  };
  // What r would add if none of it cancelled.
  std::fill(added_.begin(), added_.end(), 0.0);
  for (std::size_t k = 0; k < parts_; ++k)
    for (std::size_t n = 0; n < within_[k].points; ++n)
      for (std::size_t i = 0; i < states; ++i) added_[i] += std::abs(within_[k].defects[n * states + i]);
  if (!matters(added_)) return 0.0;
  const double length = (to_ - from_) / static_cast<double>(parts_);
  double out = 0.0;
  std::fill(added_.begin(), added_.end(), 0.0);
  for (std::size_t k = 0; k < parts_; ++k) {
    Within& within = within_[k];
    const GaussRule& rule = gauss_rule(static_cast<int>(within.points));
    // What r adds, as in propagate(), and the second moment of r.
    for (auto* const vector : {&defect_, &moment_, &second_}) std::fill(vector->begin(), vector->end(), 0.0);
    for (std::size_t n = 0; n < within.points; ++n) {
      const double left = length * (1.0 - rule.position[n]);
      const double* const defects = within.defects.data() + n * states;
      for (std::size_t i = 0; i < states; ++i) {
        defect_[i] += defects[i];
        moment_[i] += (left - 2.0 * kDiagonal * length) * defects[i];
        second_[i] += 0.5 * left * left * defects[i];
      }
    }
    add_product(within.jacobian, moment_, 1.0, defect_);
    within.lu.solve(defect_.data());
    within.lu.solve(defect_.data());
    for (std::size_t i = 0; i < states; ++i) added_[i] += defect_[i];
    std::fill(moment_.begin(), moment_.end(), 0.0);
    add_product(within.jacobian, second_, 1.0, moment_);
    within.lu.solve(moment_.data());
    std::fill(right_.begin(), right_.end(), 0.0);
    add_product(within.jacobian, moment_, 1.0, right_);
    // The integral of (t - middle) e: of the straight line, and of what bends it (P_3 - P_1; P_2 - P_0 is even).
    see_bend(within);
    const double *const begin = error_at(k), *const end = error_at(k + 1);
    for (std::size_t i = 0; i < states; ++i) {
      moment_[i] = length * length / 12.0 * (end[i] - begin[i]);
      if (within.points > 2) moment_[i] -= length * length / 6.0 * within.bend[states + i];
    }
    const std::size_t right = std::max<std::size_t>(k, 1);
    add_product(within_[right].jacobian, moment_, 1.0 / length, right_);
    add_product(within_[right - 1].jacobian, moment_, -1.0 / length, right_);
    for (int i = 0; i < 3; ++i) within.lu.solve(right_.data());
    out += size(right_);
  }
  return out == 0.0 ? 0.0 : out / size(added_);
}

/// At the beginning of a part of the last step, or at its end: that of the next.
const double* GlobalError::error_at(std::size_t part) const {
  if (part == 0) return begin_error_.data();
  return part == parts_ ? error_.data() : inner_errors_.data() + (part - 1) * error_.size();
}

/// Whether an error is in reach of what is noted of outputs: a thousandth of that, beside the largest value of some
/// state so far.
bool GlobalError::matters(const std::vector<double>& error) const {
  constexpr double kReach = 1e-3 * OutputErrors::kLarge;
  for (std::size_t i = 0; i < error.size(); ++i)
    if (std::abs(error[i]) > kReach * tolerances_.largest(i)) return true;
  return false;
}

/// The rates at points of polynomial_, all at once where that can be done.
bool GlobalError::see_rates(const std::array<double, Within::kMostPoints>& at, std::size_t points,
                            const Integrator::Rates& held) {
  Evaluator::Points all;
  all.count = points;
  for (std::size_t k = 0; k < points; ++k) {
    polynomial_.at(at[k], at_[k].data(), slope_at_[k].data());
    all.t[k] = at[k];
    all.x[k] = at_[k].data();
    all.values[k] = rate_at_[k].data();
  }
  if (!held && evaluator_.rates(all, branch_)) return true;
  for (std::size_t k = 0; k < points; ++k) {
    if (rates_at(at[k], at_[k], held, rate_at_[k].data())) continue;
    give_up("the rates could not be evaluated at t = " + number_text(at[k], 6));
    return false;
  }
  return true;
}

/// Takes error_ from one time to another within polynomial_. False if it gave up.
bool GlobalError::propagate(double from, double to, std::size_t points, const Integrator::Rates& held, Within& within) {
  const std::size_t states = error_.size();
  const double length = to - from;
  const GaussRule& rule = gauss_rule(static_cast<int>(points));
  std::array<double, Within::kMostPoints> at{};
  for (std::size_t k = 0; k < points; ++k) at[k] = from + rule.position[k] * length;
  if (!see_rates(at, points, held)) return false;
  // Where friction is held it takes whatever force an error brings. What holds is solved for, and has no program.
  const std::size_t middle = points / 2;
  std::copy(at_[middle].begin(), at_[middle].end(), y_.begin());
  std::copy(rate_at_[middle].begin(), rate_at_[middle].end(), rates_.begin());
  double* const jacobian = within.jacobian.data();
  if (!(held ? see_differences(at[middle], held, jacobian) : see_jacobian(at[middle], jacobian))) return false;
  // Integrals of r and of (to - t) r by Gauss' rule.
  within.points = points;
  within.ready = false;
  std::fill(defect_.begin(), defect_.end(), 0.0);
  std::fill(moment_.begin(), moment_.end(), 0.0);
  for (std::size_t k = 0; k < points; ++k) {
    const double weight = length * rule.weight[k], left = length * (1.0 - rule.position[k]);
    double* const defects = within.defects.data() + k * states;
    for (std::size_t i = 0; i < states; ++i) {
      const double r = weight * (slope_at_[k][i] - rate_at_[k][i]);
      defect_[i] += r;
      moment_[i] += left * r;
      defects[i] = r;
    }
  }
  // By a function of second order in hJ, oscillations turned by another angle than the solution does: after a thousand
  // periods what early steps had left was out of phase with what late ones leave, and their sum did not grow any more
  // (global_error_test). What an error of the step itself is wrong by does not add up.
  // (1 + (1 - 2 g) hJ) e + defect + J (moment - 2 g h defect), through (1 - g hJ) twice: right to second order in hJ.
  const bool followed = moves(within.jacobian, length) && exponential_.apply(within.jacobian, length, error_, flow_);
  for (std::size_t i = 0; i < states; ++i) {
    moment_[i] -= 2.0 * kDiagonal * length * defect_[i];
    right_[i] = defect_[i];
    if (followed) continue;
    moment_[i] += (1.0 - 2.0 * kDiagonal) * length * error_[i];
    right_[i] += error_[i];
  }
  double* const matrix = within.lu.real();
  for (std::size_t j = 0; j < states; ++j) {
    const double* const column = jacobian + j * states;
    for (std::size_t i = 0; i < states; ++i) {
      right_[i] += column[i] * moment_[j];
      matrix[j * states + i] = -kDiagonal * length * column[i];
    }
    matrix[j * states + j] += 1.0;
  }
  bool finite = within.lu.factor();
  if (finite) {
    within.lu.solve(right_.data());
    within.lu.solve(right_.data());
    for (std::size_t i = 0; followed && i < states; ++i) right_[i] += flow_[i];
    for (const double x : right_) finite = finite && std::isfinite(x);
  }
  if (!finite) {
    give_up("it grew beyond all numbers");
    return false;
  }
  std::copy(right_.begin(), right_.end(), error_.begin());
  return true;
}

/// Whether the error matters, and moves in the step by more than a twentieth of itself: by less, second order leaves
/// some 1e-6 of it.
bool GlobalError::moves(const std::vector<double>& jacobian, double length) {
  constexpr double kLittle = 0.05;
  if (!matters(error_)) return false;
  std::fill(flow_.begin(), flow_.end(), 0.0);
  add_product(jacobian, error_, length, flow_);
  double size = 0.0, change = 0.0;
  for (std::size_t i = 0; i < error_.size(); ++i) {
    const double reached = tolerances_.largest(i);
    if (!(reached > 0.0)) continue;
    size = std::max(size, std::abs(error_[i]) / reached);
    change = std::max(change, std::abs(flow_[i]) / reached);
  }
  return change > kLittle * size;
}

void GlobalError::go_on(Sums sums, std::vector<double> error) {
  if (!measuring_) return;
  sums_ = std::move(sums);
  error_ = begin_error_ = std::move(error);
  parts_ = 1;
}

/// Between both ends of a part the error is not on a straight line: what the dense output is wrong by there, and not at
/// the ends, is the integral of r up to each time, less its share of the whole. With r as a sum of a_n P_n(x), Legendre
/// polynomials of x from -1 to 1, that is the sum over n > 0 of
///
///     h a_n (P_{n+1}(x) - P_{n-1}(x)) / (2 (2n + 1)),
///
/// through (1 - g hJ), since stiff states forget r within the step.
void GlobalError::see_bend(Within& within) {
  if (std::exchange(within.ready, true)) return;
  const std::size_t states = error_.size();
  const GaussRule& rule = gauss_rule(static_cast<int>(within.points));
  std::fill(within.bend.begin(), within.bend.end(), 0.0);
  for (std::size_t n = 1; n < within.points; ++n) {
    double* const bend = within.bend.data() + (n - 1) * states;
    for (std::size_t k = 0; k < within.points; ++k) {
      const double shape = 0.5 * legendre(static_cast<int>(n), 2.0 * rule.position[k] - 1.0);
      for (std::size_t i = 0; i < states; ++i) bend[i] += shape * within.defects[k * states + i];
    }
    within.lu.solve(bend);
  }
}

/// Takes what bends the error from y_, at a part of the way from 0 to 1.
void GlobalError::add_bend(Within& within, double part) {
  see_bend(within);
  const std::size_t states = error_.size();
  const double x = 2.0 * part - 1.0;
  for (std::size_t n = 1; n < within.points; ++n) {
    const double shape = legendre(static_cast<int>(n) + 1, x) - legendre(static_cast<int>(n) - 1, x);
    for (std::size_t i = 0; i < states; ++i) y_[i] -= shape * within.bend[(n - 1) * states + i];
  }
}

}  // namespace bgsim
