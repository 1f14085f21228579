#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "bgsim/text.hpp"
#include "program/evaluator_impl.hpp"

namespace bgsim {
namespace {

constexpr int kFewIterations = 40;
constexpr double kSmallestDamping = 1e-12;
/// A full Newton step of this relative size has converged: contraction is quadratic, so the next one is below rounding.
constexpr double kConverged = 1e-13;
/// A tear that has become so small a part of what it was is known to no more than the roundings of that.
constexpr double kShrank = 1e-3;
/// Rounding stalls the iteration above kConverged where terms cancel; below this a stall counts as converged.
constexpr double kStalled = 1e-8;

Eigen::Index to_index(std::size_t i) { return static_cast<Eigen::Index>(i); }

}  // namespace

LoopScratch::LoopScratch(const ProgramBlock& block)
    : matrix(block.size, block.entries, block.refined),
      partials(block.entries.size()),
      residual(to_index(block.size)),
      scaled(to_index(block.size)),
      step(to_index(block.size)),
      next_step(to_index(block.size)),
      base(to_index(block.size)),
      scale(to_index(block.size)),
      start(block.size),
      failed(block.size) {}

double Evaluator::Impl::scaled_norm(const Eigen::VectorXd& step, const Eigen::VectorXd& scale) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    if (step[i] == 0.0) continue;
    const double ratio = step[i] / scale[i];
    sum += ratio * ratio;
  }
  return std::sqrt(sum / static_cast<double>(step.size()));
}

bool Evaluator::Impl::load_residual(std::size_t block) {
  const ProgramBlock& b = program.blocks[block];
  if (free_modes) follow_conditions();
  run_loop(b.residual);
  bool finite = true;
  for (std::size_t i = 0; i < b.size; ++i) {
    const double value = slots[b.residual.results[i]];
    loops[block].residual[to_index(i)] = value;
    finite = finite && std::isfinite(value);
  }
  return finite;
}

/// Equilibrates and factorizes the partials of a loop's residuals by its tears.
LoopOutcome Evaluator::Impl::factorize(std::size_t block, LoopMatrix::Pivots pivots) {
  if (!goes_on()) return LoopOutcome::no_convergence;
  run_loop(program.blocks[block].jacobian);
  const LoopOutcome outcome = factorize_partials(block, kSingularLoop, pivots);
  if (outcome == LoopOutcome::solved || program.blocks[block].linear || smoothing > 0.0) return outcome;
  if (outcome == LoopOutcome::singular && factorize_where_blocked(block) == LoopOutcome::solved)
    return LoopOutcome::solved;
  return factorize_smoothed(block) == LoopOutcome::solved ? LoopOutcome::solved : outcome;
}

/// The same with the partials as the slots hold them.
LoopOutcome Evaluator::Impl::factorize_partials(std::size_t block, double singular, LoopMatrix::Pivots pivots) {
  const ProgramBlock& b = program.blocks[block];
  LoopScratch& scratch = loops[block];
  for (std::size_t i = 0; i < b.entries.size(); ++i) scratch.partials[i] = slots[b.jacobian.results[i]];
  return scratch.matrix.factorize(scratch.partials, b.explicit_row, singular, pivots);
}

LoopOutcome Evaluator::Impl::solve(std::size_t block, From from) {
  ++counts.loop_solves;
  if (program.blocks[block].linear && !free_modes) return solve_linear(block);
  const std::span<double> z = tears_of(block);
  LoopScratch& scratch = loops[block];
  scratch.start.assign(z.begin(), z.end());
  // An iteration of a large loop is dear, and exponentials may take hundreds: where a few do not do they are limited.
  const bool limit_first = z.size() > kLargestLocalBlock && has_exponentials(block);
  LoopOutcome outcome = solve_newton(block, Steps::relative, limit_first ? kFewIterations : kMostIterations);
  if (outcome == LoopOutcome::solved) return outcome;
  if (limit_first) {
    for (const bool from_zero : {false, true}) {
      std::copy(scratch.start.begin(), scratch.start.end(), z.begin());
      if (solve_limited(block, from_zero) == LoopOutcome::solved) return LoopOutcome::solved;
    }
    std::copy(scratch.start.begin(), scratch.start.end(), z.begin());
    outcome = solve_newton(block);
    if (outcome == LoopOutcome::solved) return outcome;
  }
  // Where the damped iteration ended it may be as near as rounding lets it come.
  if (outcome != LoopOutcome::not_finite && accept_by_rounding(block) == LoopOutcome::solved)
    return LoopOutcome::solved;
  scratch.failed.assign(z.begin(), z.end());
  std::copy(scratch.start.begin(), scratch.start.end(), z.begin());
  // What rounding makes of a tear may be anything where the matrix is nearly singular: the residuals decide.
  if (solve_newton(block, Steps::resolved) == LoopOutcome::solved && accept_by_rounding(block) == LoopOutcome::solved)
    return LoopOutcome::solved;
  std::copy(scratch.start.begin(), scratch.start.end(), z.begin());
  for (const bool from_zero : {false, true})
    if (solve_limited(block, from_zero) == LoopOutcome::solved) return LoopOutcome::solved;
  std::copy(scratch.start.begin(), scratch.start.end(), z.begin());
  if (from == From::last_solution && solve_downhill(block) == LoopOutcome::solved) return LoopOutcome::solved;
  if (solve_smoothed(block) == LoopOutcome::solved) return LoopOutcome::solved;
  std::copy(scratch.failed.begin(), scratch.failed.end(), z.begin());
  return outcome;
}

/// From zero, so that the result depends on nothing but the point.
LoopOutcome Evaluator::Impl::solve_linear(std::size_t block) {
  LoopScratch& scratch = loops[block];
  const std::span<double> z = tears_of(block);
  std::fill(z.begin(), z.end(), 0.0);
  if (!load_residual(block)) return LoopOutcome::not_finite;
  if (const LoopOutcome outcome = factorize(block); outcome != LoopOutcome::solved) return outcome;
  ++counts.loop_iterations;
  scratch.residual.array() /= scratch.matrix.row_scale.array();
  scratch.matrix.solve(scratch.residual, scratch.step);
  for (std::size_t i = 0; i < z.size(); ++i)
    z[i] = -scratch.step[to_index(i)] / scratch.matrix.column_scale[to_index(i)];
  return LoopOutcome::solved;
}

/// Newton iteration damped by the natural monotonicity test: a step is taken if the simplified Newton step that would
/// follow is smaller. The test does not change when equations or unknowns are scaled. A tear that is zero but for
/// rounding (the flow through a balanced bridge) has no size of its own: with resolved steps it is measured by what
/// rounding makes of it.
/// (P. Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3.)
LoopOutcome Evaluator::Impl::solve_newton(std::size_t block, Steps steps, int most) {
  LoopScratch& scratch = loops[block];
  const std::span<double> z = tears_of(block);
  const std::span<double> largest_of = std::span(largest).subspan(program.blocks[block].first_tear, z.size());
  const auto newton_step = [&scratch](Eigen::VectorXd& step) {
    scratch.scaled = scratch.residual.cwiseQuotient(scratch.matrix.row_scale);
    scratch.matrix.solve(scratch.scaled, step);
    step.array() /= -scratch.matrix.column_scale.array();
  };
  const auto move = [&](double damping) {
    for (std::size_t i = 0; i < z.size(); ++i) z[i] = scratch.base[to_index(i)] + damping * scratch.step[to_index(i)];
  };
  // A step from 1e20 ends at the roundings of that, 1e5 from the solution, where the next step is small beside 1e20
  // alone.
  const auto still_small = [&] {
    for (std::size_t i = 0; i < z.size(); ++i) {
      const Eigen::Index k = to_index(i);
      const double size = std::max({std::abs(z[i]), std::abs(z[i] + scratch.next_step[k]), largest_of[i]});
      const bool shrank = size < kShrank * std::abs(scratch.base[k]);
      if (shrank && std::abs(scratch.next_step[k]) > kStalled * size) return false;
    }
    return true;
  };
  if (!load_residual(block)) {
    std::fill(z.begin(), z.end(), 0.0);  // the last solution may lie outside the law's domain by now
    if (!load_residual(block)) return LoopOutcome::not_finite;
  }
  for (int iteration = 0; iteration < most; ++iteration) {
    ++counts.loop_iterations;
    // Those of this solution's first matrix: of an earlier one, the result would depend on what was solved before.
    const auto pivots = iteration == 0 ? LoopMatrix::Pivots::new_ones : LoopMatrix::Pivots::kept;
    if (const LoopOutcome outcome = factorize(block, pivots); outcome != LoopOutcome::solved) return outcome;
    newton_step(scratch.step);
    for (std::size_t i = 0; i < z.size(); ++i) {
      const Eigen::Index k = to_index(i);
      scratch.base[k] = z[i];
      scratch.scale[k] = std::max({std::abs(z[i]), std::abs(z[i] + scratch.step[k]), largest_of[i]});
      if (scratch.scale[k] == 0.0) scratch.scale[k] = 1.0;  // step 0 too
    }
    if (steps == Steps::resolved) scratch.scale = scratch.scale.cwiseMax(resolution(block) / kConverged);
    const double size = scaled_norm(scratch.step, scratch.scale);
    double damping = 1.0, next_size = 0.0;
    for (;; damping /= 2) {
      if (damping < kSmallestDamping) return LoopOutcome::no_convergence;
      move(damping);
      if (!load_residual(block)) continue;
      newton_step(scratch.next_step);
      next_size = scaled_norm(scratch.next_step, scratch.scale);
      if (size <= kStalled || next_size <= (1.0 - damping / 4) * size) break;
    }
    const bool stalled = size <= kStalled && next_size > size / 4;
    if (damping == 1.0 && (stalled || (next_size <= kConverged && still_small()))) {
      for (std::size_t i = 0; i < z.size(); ++i) {
        const Eigen::Index k = to_index(i);
        if (!stalled) z[i] += scratch.next_step[k];
        largest_of[i] = std::max(largest_of[i], std::abs(z[i]));
      }
      return LoopOutcome::solved;
    }
  }
  return LoopOutcome::no_convergence;
}

/// What rounding of the residuals makes of the tears.
Eigen::VectorXd Evaluator::Impl::resolution(std::size_t block) {
  const ProgramBlock& b = program.blocks[block];
  std::vector<double> elsewhere(slots.size(), 0.0);
  elsewhere.swap(errors);
  for (const double& tear : tears_of(block))
    errors[static_cast<std::size_t>(&tear - slots.data())] = std::numeric_limits<double>::epsilon() * std::abs(tear);
  for (const auto& code : b.residual.code) carry_errors(code);
  Eigen::VectorXd of_residuals(to_index(b.size));
  for (std::size_t r = 0; r < b.size; ++r) of_residuals[to_index(r)] = errors[b.residual.results[r]];
  elsewhere.swap(errors);
  return pass_through(block, of_residuals).cwiseMin(std::numeric_limits<double>::max());
}

int Evaluator::orientation(std::size_t block) const { return impl_->loops[block].matrix.orientation(); }

std::vector<double> loop_starts() {
  std::vector<double> result{0.0};
  for (const double decade : {1.0, 1e-3, 1e3, 1e-6, 1e6})
    for (const double sign : {1.0, -1.0}) result.push_back(sign * decade);
  return result;
}

namespace {

/// A solution of a loop, and how far its tears can be from where an exact computation would have put them.
struct LoopSolution {
  std::vector<double> tears, unknown;
};

/// Leaves out solutions that have been found before: those that differ by less than rounding and what is left of the
/// residuals make of them, or relatively by less than two branches of a law ever do where Newton has stopped early.
void drop_repeated(std::vector<LoopSolution>& solutions) {
  constexpr double kSame = 1e-6;
  std::vector<LoopSolution> kept;
  const auto alike = [&](const LoopSolution& a, const LoopSolution& b) {
    for (std::size_t i = 0; i < a.tears.size(); ++i)
      if (std::abs(a.tears[i] - b.tears[i]) >
          std::max(kSame * std::max(std::abs(a.tears[i]), std::abs(b.tears[i])), a.unknown[i] + b.unknown[i]))
        return false;
    return true;
  };
  for (LoopSolution& solution : solutions)
    if (std::none_of(kept.begin(), kept.end(), [&](const auto& other) { return alike(solution, other); }))
      kept.push_back(std::move(solution));
  solutions = std::move(kept);
}

/// "the loop through r, r2: r.e = 0, found from the start 0; other solutions exist: r.e = 0.2". Of other solutions of a
/// loop with many variables those that differ.
std::string solutions_text(const ProgramBlock& block, const std::string& from,
                           const std::vector<LoopSolution>& solutions) {
  constexpr double kSame = 1e-6;
  const std::vector<double>& first = solutions.front().tears;
  std::vector<std::size_t> all(first.size());
  std::iota(all.begin(), all.end(), 0U);
  std::string line = loop_words(block) + ": " + tear_words(block, first, all) + ", found " + from;
  for (std::size_t k = 1; k < solutions.size(); ++k) {
    const std::vector<double>& other = solutions[k].tears;
    std::vector<std::size_t> which = all;
    if (which.size() > kMostLoopNames)
      std::erase_if(which, [&](std::size_t i) {
        return std::abs(other[i] - first[i]) <= kSame * std::max(std::abs(other[i]), std::abs(first[i]));
      });
    line += (k == 1 ? "; other solutions exist: " : "; ") + tear_words(block, other, which);
  }
  return line;
}

}  // namespace

bool Evaluator::explore_loops(double t, const double* x, Branch& branch, std::vector<std::string>& found) {
  Impl& impl = *impl_;
  std::vector<bool> explored(impl.program.blocks.size(), false);
  const Routine& routine = impl.program.plan.routine;
  constexpr std::size_t kMostSingle = 8;  // a pipe of a thousand sections has as many loops of one kind
  std::size_t single = 0;
  impl.begin_errors();
  impl.set_point(t, x, branch);
  for (std::size_t i = 0; i < routine.code.size(); ++i) {
    impl.run(routine.code[i]);
    impl.carry_errors(routine.code[i]);
    if (i == routine.solves.size()) break;
    const std::uint32_t b = routine.solves[i];
    const ProgramBlock& block = impl.program.blocks[b];
    if (block.linear) {
      if (const LoopOutcome outcome = impl.solve(b); outcome != LoopOutcome::solved) {
        impl.fail_loop(b, outcome);
        return false;
      }
      impl.carry_errors_through(b);
      continue;
    }
    std::vector<LoopSolution> solutions;
    std::string from = "from the start 0";
    LoopOutcome outcome = LoopOutcome::no_convergence;
    const std::span<double> z = impl.tears_of(b);
    const std::vector<double> last(z.begin(), z.end());
    for (const double start : loop_starts()) {
      std::fill(z.begin(), z.end(), start);
      const LoopOutcome this_one = impl.solve(b, Impl::From::guess);
      if (start == 0.0) outcome = this_one;
      if (this_one != LoopOutcome::solved) continue;
      if (solutions.empty()) from = "from the start " + number_text(start, 6);
      impl.carry_errors_through(b);
      const auto unknown = std::span(impl.errors).subspan(impl.program.first_tear + block.first_tear, block.size);
      solutions.push_back({{z.begin(), z.end()}, {unknown.begin(), unknown.end()}});
      if (block.size > kLargestLocalBlock) break;
    }
    if (solutions.empty() && outcome != LoopOutcome::singular) {
      std::fill(z.begin(), z.end(), 0.0);
      bool solved = impl.solve_bracketed(b) == LoopOutcome::solved;
      if (!solved) {
        std::copy(last.begin(), last.end(), z.begin());
        solved = impl.solve(b) == LoopOutcome::solved;
        from = "with its conditions";
      }
      if (solved) {
        impl.carry_errors_through(b);
        const auto unknown = std::span(impl.errors).subspan(impl.program.first_tear + block.first_tear, block.size);
        solutions.push_back({{z.begin(), z.end()}, {unknown.begin(), unknown.end()}});
      }
    }
    drop_repeated(solutions);
    if (solutions.empty()) {
      std::fill(z.begin(), z.end(), 0.0);
      impl.load_residual(b);
      impl.fail_loop(b, outcome);
      return false;
    }
    std::copy(solutions.front().tears.begin(), solutions.front().tears.end(), z.begin());
    impl.carry_errors_through(b);
    if (solutions.size() > 1 || ++single <= kMostSingle) found.push_back(solutions_text(block, from, solutions));
  }
  if (single > kMostSingle)
    found.push_back(std::to_string(single - kMostSingle) + " more loops, with one solution each that was found");
  impl.keep(branch);
  return true;
}

}  // namespace bgsim
