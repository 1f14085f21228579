// Loops through laws whose slope is 0, or has no bound, where the flow is 0: pipes, e = k f |f|. Newton's iteration has
// no matrix there. With sqrt(x^2 + d^2) for |x| each law has a slope: far below d it is a straight line (a laminar
// pipe). For d far above all flows the loop is nearly linear; from there d falls, and each solution starts the next
// iteration. Laws that rise keep rising with d, so that in a network of such laws there is one solution for each d, and
// it follows d without a gap.
#include <algorithm>
#include <cmath>

#include "program/evaluator_impl.hpp"

namespace bgsim {

namespace {

constexpr double kWidest = 1e12, kNarrowest = 1e-30;
constexpr double kFirstFactor = 0.1, kLargestFactor = 1e-4, kSmallestFactor = 0.9;
constexpr int kMostWidths = 400;

/// Of what a loop's flows have been: a slope for the matrix where a law has none.
constexpr double kOfLargest = 1e-8;

}  // namespace

void Evaluator::Impl::run_smoothed(const Routine& routine) {
  double* const s = slots.data();
  for (const auto& code : routine.code)
    for (const Instruction& i : code) {
      if (i.op == Op::abs)
        s[i.out] = std::hypot(s[i.a], smoothing);
      else if (i.op == Op::sign)  // the slope of |x|; signs that the model writes are modes
        s[i.out] = s[i.a] / std::hypot(s[i.a], smoothing);
      else
        run({&i, 1});
    }
}

LoopOutcome Evaluator::Impl::solve_smoothed(std::size_t block) {
  const ProgramBlock& b = program.blocks[block];
  const auto has_abs = [](const CodeList& code) {
    return std::any_of(code.begin(), code.end(), [](const Instruction& i) { return i.op == Op::abs; });
  };
  if (std::none_of(b.residual.code.begin(), b.residual.code.end(), has_abs)) return LoopOutcome::no_convergence;
  const std::span<double> z = tears_of(block);
  const std::span<double> largest_of = std::span(largest).subspan(b.first_tear, z.size());
  const std::vector<double> largest_before(largest_of.begin(), largest_of.end());
  std::fill(z.begin(), z.end(), 0.0);
  std::vector<double> last(z.begin(), z.end());
  LoopOutcome outcome = LoopOutcome::no_convergence;
  double width = kWidest, factor = kFirstFactor, reached = kWidest / kFirstFactor;
  for (int k = 0; k < kMostWidths && width > kNarrowest && goes_on(); ++k) {
    std::fill(largest_of.begin(), largest_of.end(), 0.0);  // those of other widths are no measure
    smoothing = width;
    const auto iterations = counts.loop_iterations;
    outcome = solve_newton(block, Steps::resolved);
    smoothing = 0.0;
    if (outcome == LoopOutcome::solved) {
      constexpr int kFew = 3;
      if (accept_by_rounding(block) == LoopOutcome::solved) break;
      outcome = LoopOutcome::no_convergence;
      last.assign(z.begin(), z.end());
      reached = width;
      factor = counts.loop_iterations - iterations <= kFew ? std::max(factor * factor, kLargestFactor) : factor;
    } else {
      std::copy(last.begin(), last.end(), z.begin());
      factor = std::sqrt(factor);
      if (factor > kSmallestFactor) break;
    }
    width = reached * factor;
  }
  std::copy(largest_before.begin(), largest_before.end(), largest_of.begin());
  if (outcome == LoopOutcome::solved)
    for (std::size_t i = 0; i < z.size(); ++i) largest_of[i] = std::max(largest_of[i], std::abs(z[i]));
  return outcome;
}

/// Factorizes with a slope where a law has none, or one without a bound.
LoopOutcome Evaluator::Impl::factorize_smoothed(std::size_t block) {
  double of = 0.0;
  bool any = false;
  for (const CodeList& code : program.blocks[block].residual.code)
    for (const Instruction& i : code)
      if (i.op == Op::abs) {
        any = true;
        of = std::max(of, std::abs(slots[i.a]));
      }
  if (!any) return LoopOutcome::singular;
  if (of == 0.0) of = 1.0;
  smoothing = kOfLargest * of;
  run_smoothed(program.blocks[block].residual);  // the partials contain its values
  run_smoothed(program.blocks[block].jacobian);
  const LoopOutcome outcome = factorize_partials(block, 0.0);
  smoothing = 0.0;
  run_loop(program.blocks[block].residual);
  return outcome;
}

}  // namespace bgsim
