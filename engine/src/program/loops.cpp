#include <algorithm>
#include <cmath>
#include <cstdio>

#include "program/evaluator_impl.hpp"

namespace bgsim {
namespace {

constexpr int kMostIterations = 300;  ///< an exponential law gives up one decade of its argument at a time
constexpr double kSmallestDamping = 1e-12;
/// A full Newton step of this relative size has converged: contraction is quadratic, so the next one is below rounding.
constexpr double kConverged = 1e-13;
/// Rounding stalls the iteration above kConverged where terms cancel; below this a stall counts as converged.
constexpr double kStalled = 1e-8;

Eigen::Index to_index(std::size_t i) { return static_cast<Eigen::Index>(i); }

}  // namespace

LoopScratch::LoopScratch(std::size_t size)
    : matrix(to_index(size), to_index(size)),
      factors(to_index(size)),
      residual(to_index(size)),
      scaled(to_index(size)),
      step(to_index(size)),
      next_step(to_index(size)),
      row_scale(to_index(size)),
      column_scale(to_index(size)),
      base(to_index(size)),
      scale(to_index(size)),
      start(size),
      failed(size) {}

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
  for (const auto& code : b.residual.code) run(code);
  bool finite = true;
  for (std::size_t i = 0; i < b.size; ++i) {
    const double value = slots[b.residual.results[i]];
    loops[block].residual[to_index(i)] = value;
    finite = finite && std::isfinite(value);
  }
  return finite;
}

/// Equilibrates and factorizes the partials of a loop's residuals by its tears.
LoopOutcome Evaluator::Impl::factorize(std::size_t block) {
  if (!goes_on()) return LoopOutcome::no_convergence;
  for (const auto& code : program.blocks[block].jacobian.code) run(code);
  const LoopOutcome outcome = factorize_partials(block, kSingularLoop);
  return outcome == LoopOutcome::singular && !program.blocks[block].linear ? factorize_where_blocked(block) : outcome;
}

/// The same with the partials as the slots hold them.
LoopOutcome Evaluator::Impl::factorize_partials(std::size_t block, double singular) {
  const ProgramBlock& b = program.blocks[block];
  LoopScratch& scratch = loops[block];
  scratch.matrix.setZero();
  for (std::size_t i = 0; i < b.entries.size(); ++i) {
    const double value = slots[b.jacobian.results[i]];
    if (!std::isfinite(value)) return LoopOutcome::not_finite;
    scratch.matrix(b.entries[i].first, b.entries[i].second) = value;
  }
  for (Eigen::Index r = 0; r < scratch.matrix.rows(); ++r) {
    // `tear - expression` has terms of magnitude 1, even where they cancel.
    const double floor = b.explicit_row[static_cast<std::size_t>(r)] ? 1.0 : 0.0;
    scratch.row_scale[r] = std::max(scratch.matrix.row(r).cwiseAbs().maxCoeff(), floor);
    if (scratch.row_scale[r] == 0.0) return LoopOutcome::singular;
    scratch.matrix.row(r) /= scratch.row_scale[r];
  }
  if (b.size > 1)
    for (Eigen::Index c = 0; c < scratch.matrix.cols(); ++c) {
      scratch.column_scale[c] = scratch.matrix.col(c).cwiseAbs().maxCoeff();
      if (scratch.column_scale[c] == 0.0) return LoopOutcome::singular;
      scratch.matrix.col(c) /= scratch.column_scale[c];
    }
  else
    scratch.column_scale[0] = 1.0;
  scratch.factors.compute(scratch.matrix);
  const auto pivots = scratch.factors.matrixLU().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > singular * std::max(1.0, pivots.maxCoeff()))) return LoopOutcome::singular;
  return LoopOutcome::solved;
}

LoopOutcome Evaluator::Impl::solve(std::size_t block) {
  ++counts.loop_solves;
  if (program.blocks[block].linear) return solve_linear(block);
  const std::span<double> z = tears_of(block);
  LoopScratch& scratch = loops[block];
  scratch.start.assign(z.begin(), z.end());
  const LoopOutcome outcome = solve_newton(block);
  if (outcome == LoopOutcome::solved) return outcome;
  // Where the damped iteration ended it may be as near as rounding lets it come.
  if (outcome != LoopOutcome::not_finite && accept_by_rounding(block) == LoopOutcome::solved)
    return LoopOutcome::solved;
  scratch.failed.assign(z.begin(), z.end());
  std::copy(scratch.start.begin(), scratch.start.end(), z.begin());
  for (const bool from_zero : {false, true})
    if (solve_limited(block, from_zero) == LoopOutcome::solved) return LoopOutcome::solved;
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
  scratch.residual.array() /= scratch.row_scale.array();
  scratch.step = scratch.factors.solve(scratch.residual);
  for (std::size_t i = 0; i < z.size(); ++i) z[i] = -scratch.step[to_index(i)] / scratch.column_scale[to_index(i)];
  return LoopOutcome::solved;
}

/// Newton iteration damped by the natural monotonicity test: a step is taken if the simplified Newton step that would
/// follow is smaller. The test does not change when equations or unknowns are scaled.
/// (P. Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3.)
LoopOutcome Evaluator::Impl::solve_newton(std::size_t block) {
  LoopScratch& scratch = loops[block];
  const std::span<double> z = tears_of(block);
  const std::span<double> largest_of = std::span(largest).subspan(program.blocks[block].first_tear, z.size());
  const auto newton_step = [&scratch](Eigen::VectorXd& step) {
    scratch.scaled = scratch.residual.cwiseQuotient(scratch.row_scale);
    step = scratch.factors.solve(scratch.scaled);
    step.array() /= -scratch.column_scale.array();
  };
  const auto move = [&](double damping) {
    for (std::size_t i = 0; i < z.size(); ++i) z[i] = scratch.base[to_index(i)] + damping * scratch.step[to_index(i)];
  };
  if (!load_residual(block)) {
    std::fill(z.begin(), z.end(), 0.0);  // the last solution may lie outside the law's domain by now
    if (!load_residual(block)) return LoopOutcome::not_finite;
  }
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    ++counts.loop_iterations;
    if (const LoopOutcome outcome = factorize(block); outcome != LoopOutcome::solved) return outcome;
    newton_step(scratch.step);
    for (std::size_t i = 0; i < z.size(); ++i) {
      const Eigen::Index k = to_index(i);
      scratch.base[k] = z[i];
      scratch.scale[k] = std::max({std::abs(z[i]), std::abs(z[i] + scratch.step[k]), largest_of[i]});
      if (scratch.scale[k] == 0.0) scratch.scale[k] = 1.0;  // step 0 too
    }
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
    if (damping == 1.0 && (next_size <= kConverged || stalled)) {
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

int Evaluator::orientation(std::size_t block) const {
  const LoopScratch& scratch = impl_->loops[block];
  if (scratch.matrix.size() == 0 || scratch.factors.rows() != scratch.matrix.rows()) return 0;
  int sign = static_cast<int>(scratch.factors.permutationP().determinant());
  for (const double pivot : scratch.factors.matrixLU().diagonal()) sign = pivot < 0.0 ? -sign : sign;
  return sign;
}

namespace {

/// Starts of a loop's tears: 0, then both signs over many decades (loops of any unit), all tears alike.
std::vector<double> starts() {
  std::vector<double> result{0.0};
  for (const double decade : {1.0, 1e-3, 1e3, 1e-6, 1e6})
    for (const double sign : {1.0, -1.0}) result.push_back(sign * decade);
  return result;
}

std::string solution_text(const ProgramBlock& block, std::span<const double> z) {
  std::string result;
  for (std::size_t i = 0; i < block.tears.size(); ++i) {
    char number[40];
    std::snprintf(number, sizeof number, "%.6g", z[i]);
    result += (i == 0 ? "" : ", ") + block.tears[i] + " = " + number;
  }
  return result;
}

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

}  // namespace

bool Evaluator::explore_loops(double t, const double* x, Branch& branch, std::vector<std::string>& found) {
  Impl& impl = *impl_;
  std::vector<bool> explored(impl.program.blocks.size(), false);
  const Routine& routine = impl.program.plan.routine;
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
    double first_start = 0.0;
    LoopOutcome outcome = LoopOutcome::no_convergence;
    const std::span<double> z = impl.tears_of(b);
    for (const double start : starts()) {
      std::fill(z.begin(), z.end(), start);
      const LoopOutcome this_one = impl.solve(b);
      if (start == 0.0) outcome = this_one;
      if (this_one != LoopOutcome::solved) continue;
      if (solutions.empty()) first_start = start;
      impl.carry_errors_through(b);
      const auto unknown = std::span(impl.errors).subspan(impl.program.first_tear + block.first_tear, block.size);
      solutions.push_back({{z.begin(), z.end()}, {unknown.begin(), unknown.end()}});
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
    std::string line = "the loop through ";
    for (std::size_t k = 0; k < block.elements.size(); ++k) line += (k == 0 ? "" : ", ") + block.elements[k];
    char number[40];
    std::snprintf(number, sizeof number, "%.6g", first_start);
    line += ": " + solution_text(block, solutions.front().tears) + ", found from the start " + number;
    for (std::size_t k = 1; k < solutions.size(); ++k)
      line += (k == 1 ? "; other solutions exist: " : "; ") + solution_text(block, solutions[k].tears);
    found.push_back(std::move(line));
  }
  impl.keep(branch);
  return true;
}

}  // namespace bgsim
