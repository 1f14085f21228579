// Loops through exponential laws, where Newton's iteration from far away fails: a diode's current overflows, or its
// slope is nothing. Each exponential is replaced by its tangent at a point of its own, which follows the solution by
// the logarithm of what the tangent asks for: the step that gives the exponential the value that its tangent had. (L.
// W. Nagel, SPICE2: A Computer Program to Simulate Semiconductor Circuits, ERL-M520, 1975, limits junction voltages so;
// from memory.)
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "program/evaluator_impl.hpp"

namespace bgsim {

namespace {

constexpr int kMostLimited = 200;
constexpr double kBarelyRegular = 1e-15;  // a step may be wrong by half, for the next one corrects it
constexpr double kNear = 1e-9;            // of an exponential's argument to its tangent's point: the tangent is the law

constexpr double kRounding = 2.0;    // of a residual over its rounding: there is nothing left to be improved
constexpr double kNegligible = 1e6;  // the same: each law holds to 1e-10 of its terms
constexpr double kSlow = 0.5;        // of a residual over that of the iteration before
constexpr int kPatience = 5;         // slow iterations

/// Below, the slope of an exponential is no number any more; a node between two diodes that block hangs on such slopes.
constexpr double kLeastExponent = -700.0;

constexpr double kMostExponent = 100.0;  // of a first tangent
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// No iteration puts an exponential's argument farther than this from zero.
constexpr double kFarthest = 1e6;

bool is_exponential(Op op) { return op == Op::exp || op == Op::expm1; }

/// The tangent's next point, for an argument that the tangent's solution puts at @p wanted.
double follow(double at, double wanted) {
  constexpr double kSmall = 1.0;
  wanted = std::max(wanted, kLeastExponent);
  if (!(wanted > at + kSmall) || wanted <= 0.0) return wanted;  // below 1 an exponential is tame
  constexpr double kMost = 3.0;
  const double from = std::max(at, 0.0);
  return from + std::min(std::log1p(wanted - from), kMost);
}

}  // namespace

bool Evaluator::Impl::has_exponentials(std::size_t block) const {
  const auto any_in = [](const CodeList& code) {
    return std::any_of(code.begin(), code.end(), [](const Instruction& i) { return is_exponential(i.op); });
  };
  const ProgramBlock& b = program.blocks[block];
  return std::any_of(b.residual.code.begin(), b.residual.code.end(), any_in);
}

LoopOutcome Evaluator::Impl::solve_limited(std::size_t block, bool from_zero) {
  const ProgramBlock& b = program.blocks[block];
  LoopScratch& scratch = loops[block];
  const std::span<double> z = tears_of(block);
  std::unordered_map<std::uint32_t, double> points;  // of the tangents, by the argument's slot
  for (const Routine* const routine : {&b.residual, &b.jacobian})
    for (const auto& code : routine->code)
      for (const Instruction& i : code)
        if (is_exponential(i.op)) points.emplace(i.a, from_zero ? 0.0 : kUnknown);
  if (points.empty()) return LoopOutcome::no_convergence;

  // Exponentials by their tangents, everything else as it is.
  const auto run_with_tangents = [&](const Routine& routine, const auto& exponential) {
    for (const auto& code : routine.code)
      for (const Instruction& i : code) {
        if (is_exponential(i.op))
          slots[i.out] = exponential(i);
        else
          run({&i, 1});
      }
  };
  double farthest = 0.0;
  const auto value = [&](const Instruction& i) {
    double& point = points[i.a];
    point = std::isnan(point) ? std::clamp(slots[i.a], kLeastExponent, kMostExponent) : follow(point, slots[i.a]);
    const double slope = std::exp(point), off = slots[i.a] - point;
    if (slots[i.a] > kLeastExponent) farthest = std::max(farthest, std::abs(off) / std::max(1.0, std::abs(slots[i.a])));
    return slope * off + (i.op == Op::exp ? slope : std::expm1(point));
  };
  double beyond = 0.0;
  const auto reach = [&](const Instruction& i) {
    beyond = std::max(beyond, std::abs(slots[i.a]));
    return 1.0;
  };
  const auto slope = [&](const Instruction& i) {
    const double point = points[i.a];
    return i.op == Op::exp ? std::exp(point) : std::expm1(point);
  };
  if (from_zero) std::fill(z.begin(), z.end(), 0.0);
  double least = 0.0, before = 0.0;
  int slow = 0;
  for (int iteration = 0; iteration < kMostLimited && goes_on(); ++iteration) {
    ++counts.loop_iterations;
    const double ratio = iteration > 0 ? residual_over_rounding(block) : std::numeric_limits<double>::infinity();
    slow = ratio > kSlow * before ? slow + 1 : 0;
    before = ratio;
    // Slow is what hangs on diodes that block: what is left of the residuals is nothing beside any current.
    if (ratio <= kRounding || (slow >= kPatience && ratio <= kNegligible)) return factorize(block);
    farthest = 0.0;
    run_with_tangents(b.residual, value);
    for (std::size_t i = 0; i < b.size; ++i) {
      const double residual = slots[b.residual.results[i]];
      if (!std::isfinite(residual)) return LoopOutcome::not_finite;
      scratch.residual[static_cast<Eigen::Index>(i)] = residual;
    }
    // The derivative of an exponential is the exponential itself: the slope, for the partials.
    for (const auto& code : b.residual.code)
      for (const Instruction& i : code)
        if (is_exponential(i.op)) slots[i.out] = slope(i);
    run_with_tangents(b.jacobian, slope);
    LoopOutcome outcome = factorize_partials(block, kBarelyRegular);
    // As steep as it takes to be regular: the flatter, the faster the iteration.
    if (outcome == LoopOutcome::singular) outcome = factorize_with_slopes(block, least, kBarelyRegular);
    for (; outcome == LoopOutcome::singular && least < 0.0;
         outcome = factorize_with_slopes(block, least, kBarelyRegular))
      least = std::min(0.0, least + 5.0);
    least -= 2.0;
    if (outcome != LoopOutcome::solved) return outcome;
    scratch.scaled = scratch.residual.cwiseQuotient(scratch.matrix.row_scale);
    scratch.matrix.solve(scratch.scaled, scratch.step);
    scratch.step.array() /= -scratch.matrix.column_scale.array();
    if (!scratch.step.allFinite()) return LoopOutcome::not_finite;
    // A slope of 1e-80 may ask for 1e80 volts, which would leave no digits for the next step.
    for (std::size_t i = 0; i < z.size(); ++i)
      scratch.base[static_cast<Eigen::Index>(i)] =
          std::exchange(z[i], z[i] + scratch.step[static_cast<Eigen::Index>(i)]);
    beyond = 0.0;
    run_with_tangents(b.residual, reach);
    const double part = std::min(1.0, kFarthest / beyond);
    double farthest_step = 0.0;
    for (std::size_t i = 0; i < z.size(); ++i) {
      const double step = part * scratch.step[static_cast<Eigen::Index>(i)];
      z[i] = scratch.base[static_cast<Eigen::Index>(i)];
      if (step == 0.0) continue;
      farthest_step = std::max(farthest_step, std::abs(step) / std::max(std::abs(z[i]), std::abs(z[i] + step)));
      z[i] += step;
    }
    if (iteration > 0 && farthest <= kNear && farthest_step <= kNear) return LoopOutcome::solved;
  }
  return LoopOutcome::no_convergence;
}

/// Factorizes with the exponentials' slopes not below that at @p least. A loop that hangs on diodes that block has
/// slopes of 1e-80 beside those of its resistors, or none in double precision, and its matrix is singular to rounding.
/// One that is singular even with the slopes that its diodes have at rest, at 0, is so whatever they do.
LoopOutcome Evaluator::Impl::factorize_with_slopes(std::size_t block, double least, double singular) {
  bool any = false;
  for (const auto& code : program.blocks[block].jacobian.code)
    for (const Instruction& i : code) {
      any = any || i.op == Op::exp;
      if (i.op == Op::exp)
        slots[i.out] = std::exp(std::max(slots[i.a], least));
      else
        run({&i, 1});
    }
  return any ? factorize_partials(block, singular) : LoopOutcome::singular;
}

LoopOutcome Evaluator::Impl::factorize_where_blocked(std::size_t block) {
  const LoopOutcome outcome = factorize_with_slopes(block, kLeastExponent, kSingularLoop);
  return outcome == LoopOutcome::singular ? factorize_with_slopes(block, 0.0, kSingularLoop) : outcome;
}

/// The residuals at the present tears, as a multiple of what rounding can have made of them: the largest.
double Evaluator::Impl::residual_over_rounding(std::size_t block) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const ProgramBlock& b = program.blocks[block];
  if (!load_residual(block)) return kInfinite;
  std::vector<double> elsewhere(slots.size(), 0.0);  // what is carried from loop to loop is not touched
  elsewhere.swap(errors);
  for (const double& tear : tears_of(block))  // there is no number between this one and the next
    errors[static_cast<std::size_t>(&tear - slots.data())] = std::numeric_limits<double>::epsilon() * std::abs(tear);
  for (const auto& code : b.residual.code) carry_errors(code);
  double largest_ratio = 0.0;
  for (std::size_t r = 0; r < b.size; ++r) {
    const double residual = std::abs(loops[block].residual[static_cast<Eigen::Index>(r)]);
    const double bound = errors[b.residual.results[r]];
    if (residual > 0.0) largest_ratio = std::max(largest_ratio, bound < kInfinite ? residual / bound : kInfinite);
  }
  elsewhere.swap(errors);
  return largest_ratio;
}

/// A solution that is one as far as double precision tells: Newton's step from it is below what rounding has made of
/// the tears. Near zero, where a law's own digits end, the iteration asks for more than there is.
LoopOutcome Evaluator::Impl::accept_by_rounding(std::size_t block) {
  if (!(residual_over_rounding(block) <= kRounding)) return LoopOutcome::no_convergence;
  return factorize(block);
}

}  // namespace bgsim
