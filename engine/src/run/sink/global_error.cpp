#include "run/sink/global_error.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
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
/// One of each pair of poles of the Pade approximant of exp with degrees 3 and 4, and the residue there.
struct PadePole {
  std::complex<double> at, residue;
};
constexpr std::array<PadePole, 2> kPadePoles{
    {{{3.21280689687153398, 4.77308743327664250}, {-11.301539995971487, 12.471675850250231}},
     {{4.78719310312846602, 1.56747641689520812}, {13.301539995971487, -60.071732737047443}}}};
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr std::size_t kMostParts = 16;  ///< of a step
/// Where states would be set if the error were not as it is estimated, in parts of the way to the exact solution.
constexpr std::array<double, 2> kFarther{3.0, -2.0};

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
  for (auto* const vector : {&right_, &moment_, &second_, &defect_, &added_, &flow_, &part_, &imaginary_part_})
    vector->resize(states);
  within_.assign(kMostParts, Within(states));
  pole_lu_ = ColumnLu<true>(states);
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
  // (1 + (1 - 2 g) hJ) e + defect + J (moment - 2 g h defect), through (1 - g hJ) twice: right to second order in hJ.
  const bool followed = moves(within.jacobian, length) && follow(within.jacobian, length);
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

/// What exp(hJ) makes of the error, in flow_, by the Pade approximant of degrees 3 and 4: right to the seventh order in
/// hJ where a step follows an oscillation, and nothing of what is stiff. As the sum of its poles' parts. By a function
/// of second order, oscillations turned by another angle than the solution does: after a thousand periods what early
/// steps had left was out of phase with what late ones leave, and their sum did not grow any more
/// (`global_error_test`). False where there is none.
bool GlobalError::follow(const std::vector<double>& jacobian, double length) {
  const std::size_t states = error_.size();
  std::fill(flow_.begin(), flow_.end(), 0.0);
  for (const PadePole& pole : kPadePoles) {
    double *const re = pole_lu_.real(), *const im = pole_lu_.imaginary();
    std::fill_n(im, states * states, 0.0);
    for (std::size_t k = 0; k < states * states; ++k) re[k] = length * jacobian[k];
    for (std::size_t i = 0; i < states; ++i) {
      re[i * states + i] -= pole.at.real();
      im[i * states + i] = -pole.at.imag();
    }
    if (!pole_lu_.factor()) return false;
    part_ = error_;
    std::fill(imaginary_part_.begin(), imaginary_part_.end(), 0.0);
    pole_lu_.solve(part_.data(), imaginary_part_.data());
    for (std::size_t i = 0; i < states; ++i)
      flow_[i] += 2.0 * (pole.residue.real() * part_[i] - pole.residue.imag() * imaginary_part_[i]);
  }
  return true;
}

void GlobalError::before_event(double t, const std::vector<double>& x, const Branch& branch) {
  if (!measuring_) return;
  branch_before_ = branch;
  if (!evaluator_.rates(t, x.data(), branch_before_, rates_before_.data()))
    std::fill(rates_before_.begin(), rates_before_.end(), 0.0);
}

void GlobalError::after_event(double t, const std::vector<double>& x, const Branch& branch,
                              std::optional<std::size_t> guard) {
  if (!measuring_ || !guard) return;
  const std::size_t relation = evaluator_.guard_relation(*guard);
  if (program_.relations[relation].is_between(branch_before_.modes[relation]))
    return;  // what was held is released where the rates are continuous
  const Stopwatch watch(seconds_);
  branch_ = branch;
  if (!evaluator_.rates(t, x.data(), branch_, rates_.data())) return;
  guards_.resize(evaluator_.guard_count());
  guards_off_.resize(guards_.size());
  // The guard at the event, where the exact states are, and a moment before: by so much the event comes early or late.
  const double moment = std::max(1e-3 * (to_ - from_), 64.0 * kEpsilon * std::abs(t));
  for (std::size_t i = 0; i < x.size(); ++i) y_[i] = x[i];
  if (!evaluator_.guards(t, y_.data(), branch_before_, guards_.data())) return;
  const double here = guards_[*guard];
  for (std::size_t i = 0; i < x.size(); ++i) y_[i] = x[i] - error_[i];
  if (!evaluator_.guards(t, y_.data(), branch_before_, guards_off_.data())) return;
  const double exact = guards_off_[*guard];
  for (std::size_t i = 0; i < x.size(); ++i) y_[i] = x[i] - moment * rates_before_[i];
  if (!evaluator_.guards(t - moment, y_.data(), branch_before_, guards_off_.data())) return;
  const double speed = (here - guards_off_[*guard]) / moment;
  const double late = (here - exact) / speed;
  if (!std::isfinite(late)) return;
  instant_ = {t, late, x, false};
  for (std::size_t i = 0; i < x.size(); ++i) instant_.exact[i] += late * rates_before_[i] - error_[i];
  for (std::size_t i = 0; i < x.size(); ++i) error_[i] += late * (rates_[i] - rates_before_[i]);
}

/// To an instant of which nothing is known yet: at a known time, or at the start.
void GlobalError::come_to(double t, const std::vector<double>& x) {
  if (instant_.t == t) return;
  instant_ = {t, 0.0, x};
  for (std::size_t i = 0; i < x.size(); ++i) instant_.exact[i] -= error_[i];
}

void GlobalError::before_set(double t, const std::vector<double>& x, const Branch& branch, const Set& set) {
  if (!measuring_) return;
  come_to(t, x);
  for (std::vector<double>& farther : farther_) farther.clear();
  // The modes are those of the point, unless it is at the border of what sets.
  const auto set_there = [&](double at, std::vector<double>& states) {
    branch_there_ = branch;
    if (instant_.known) {
      std::copy(states.begin(), states.end(), y_.begin());
      if (!set_modes(at, y_, branch_there_)) return false;
    }
    return set(at, states, branch_there_);
  };
  if (instant_.known)
    for (std::size_t k = 0; k < kFarther.size(); ++k) {
      farther_[k] = x;
      for (std::size_t i = 0; i < x.size(); ++i) farther_[k][i] += kFarther[k] * (instant_.exact[i] - x[i]);
      if (!set_there(t, farther_[k])) farther_[k].clear();
    }
  if (!set_there(t + instant_.late, instant_.exact))
    give_up("what is set at t = " + number_text(t, 6) + " has no value for the exact solution");
}

void GlobalError::after_set(double t, const std::vector<double>& x, const Branch& branch) {
  if (!measuring_) return;
  for (std::size_t i = 0; i < x.size(); ++i) error_[i] = x[i] - instant_.exact[i];
  for (std::size_t k = 0; k < kFarther.size() && !doubtful_set_; ++k)
    for (std::size_t i = 0; i < farther_[k].size() && !doubtful_set_; ++i) {
      const double much = OutputErrors::kLarge * std::max(tolerances_.largest(i), std::abs(x[i]));
      const double jump = farther_[k][i] - x[i] + kFarther[k] * error_[i];
      if (std::abs(error_[i]) <= much && std::abs(jump) > much) doubtful_set_ = DoubtfulSet{i, t};
    }
  if (instant_.late == 0.0) return;
  branch_ = branch;
  if (!evaluator_.rates(t, x.data(), branch_, rates_.data())) return;
  for (std::size_t i = 0; i < x.size(); ++i) error_[i] += instant_.late * rates_[i];
}

const GlobalError::Instant& GlobalError::leave(double t, const std::vector<double>& x) {
  come_to(t, x);
  return instant_;
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

void GlobalError::add_row(double t, const double* y, const Branch& branch, const std::vector<double>& row) {
  if (!measuring_) return;
  const Stopwatch watch(seconds_);
  for (std::size_t k = 0; k < row.size(); ++k) {
    sums_.least_value[k] = std::min(sums_.least_value[k], row[k]);
    sums_.most_value[k] = std::max(sums_.most_value[k], row[k]);
  }
  // Between the ends of a part: a straight line, and what bends it.
  std::size_t at = 0;
  while (at + 1 < parts_ && t > part_begin(at + 1)) ++at;
  const double *const left = error_at(at), *const right = error_at(at + 1);
  const double a = part_begin(at), b = part_begin(at + 1);
  const double part = b > a ? std::clamp((t - a) / (b - a), 0.0, 1.0) : 1.0;
  for (std::size_t i = 0; i < error_.size(); ++i) y_[i] = y[i] - (left[i] + part * (right[i] - left[i]));
  if (part < 1.0) add_bend(within_[at], part);
  branch_ = branch;
  branch_.given = false;
  if (!evaluator_.outputs(t, y_.data(), branch_, row_.data())) return;
  for (std::size_t k = 0; k < row.size(); ++k)
    if (const double size = std::abs(row[k] - row_[k]); std::isfinite(size))
      sums_.largest[k] = std::max(sums_.largest[k], size);
  hold_against_rounding(t, y, branch, row);
}

void GlobalError::hold_against_rounding(double t, const double* y, const Branch& branch,
                                        const std::vector<double>& row) {
  constexpr double kUnitsOfStep = 8.0;
  const auto size = [&](std::size_t k) { return std::abs(row[k] - row_[k]); };
  const auto due = [&](std::size_t k) {
    return std::isfinite(size(k)) && size(k) > 2.0 * sums_.bounded[k] &&
           size(k) > OutputErrors::kLarge * (sums_.most_value[k] - sums_.least_value[k]);
  };
  bool any = false;
  for (std::size_t k = 0; k < row.size() && !any; ++k) any = due(k);
  if (!any) return;
  // Both what was recorded and what it is compared with are rounded. Each step rounds the states by some units, which
  // add up like a random walk; what rounding makes of the rates (a balance of forces at rest) at most all of the time.
  branch_ = branch;
  branch_.given = false;
  if (!evaluator_.jacobian(t, y, branch_, entries_.data(), rate_rounding_)) rate_rounding_.clear();
  for (std::size_t i = 0; i < state_rounding_.size(); ++i)
    state_rounding_[i] = kUnitsOfStep * kEpsilon * std::sqrt(sums_.steps + 1.0) * std::abs(y[i]) +
                         (rate_rounding_.empty() ? 0.0 : (t - sums_.start) * rate_rounding_[i]);
  if (!rate_rounding_.empty() && holds(branch_)) {
    // A block at rest drifts by the rounding of the forces that hold it.
    const std::vector<double> momenta = state_rounding_;
    const Sparsity& pattern = program_.jacobian_pattern;
    for (std::size_t column = 0; column < momenta.size(); ++column)
      for (auto k = static_cast<std::size_t>(pattern.column_start[column]);
           k < static_cast<std::size_t>(pattern.column_start[column + 1]); ++k)
        state_rounding_[static_cast<std::size_t>(pattern.row[k])] +=
            (t - sums_.start) * std::abs(entries_[k]) * momenta[column];
  }
  branch_ = branch;
  branch_.given = false;
  evaluator_.output_rounding(t, y, branch_, state_rounding_, rounding_.data());
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (!due(k)) continue;
    sums_.bounded[k] = size(k);
    if (size(k) > 2.0 * rounding_[k]) sums_.beyond[k] = size(k);
  }
}

OutputErrors GlobalError::finish(bool completed) {
  OutputErrors errors;
  if (measuring_ && !completed) give_up("the run did not come to its end");
  errors.why_not = why_not_;
  errors.possible = possible_;
  if (!measuring_) return errors;
  errors.done = true;
  errors.estimate = sums_.largest;
  errors.beyond_rounding = sums_.beyond;
  for (std::size_t k = 0; k < sums_.largest.size(); ++k) {
    errors.range.push_back(std::max(0.0, sums_.most_value[k] - sums_.least_value[k]));
    errors.magnitude.push_back(std::max(std::abs(sums_.most_value[k]), std::abs(sums_.least_value[k])));
  }
  return errors;
}

}  // namespace bgsim
