// Loops and conditions that depend on each other where nothing is known of either: f = if(e > 0, sqrt(e), -sqrt(-e)) in
// a loop has no value on the wrong side of its condition, so that no solution there says that it is the wrong one.
#include <algorithm>
#include <cmath>

#include "base/unequal.hpp"
#include "program/evaluator_impl.hpp"

namespace bgsim {

/// The modes at the tears that the slots hold.
void Evaluator::Impl::follow_conditions() {
  for (std::size_t round = 0; round < program.guarded.size() + 2; ++round) {
    for (const auto& code : program.guards.code) run(code);
    if (!take_conditions(slots.data() + program.first_mode).changed) return;
  }
}

bool Evaluator::Impl::solve_with_conditions(double t, const double* x, Branch& branch) {
  if (program.guarded.empty()) return false;
  set_point(t, x, branch);
  free_modes = true;
  bool solved = true;
  for (std::size_t i = 0; solved && i < program.guards.code.size(); ++i) {
    run(program.guards.code[i]);
    if (i == program.guards.solves.size()) break;
    const std::uint32_t block = program.guards.solves[i];
    const std::span<double> z = tears_of(block);
    solved = false;
    // All alike, differences of tears are 0, where a root has no slope: then each another part of the start.
    for (const bool alike : {true, false})
      for (const double start : loop_starts()) {
        if (solved) break;
        for (std::size_t k = 0; k < z.size(); ++k) z[k] = start * (alike ? 1.0 : 0.5 + unequal_part(k + 1));
        solved = solve(block, From::guess) == LoopOutcome::solved;
        if (alike && z.size() > kLargestLocalBlock) break;
      }
    if (!solved) {
      std::fill(z.begin(), z.end(), 0.0);
      solved = solve_bracketed(block) == LoopOutcome::solved;
    }
  }
  free_modes = false;
  if (!solved) return false;
  keep(branch);
  std::copy_n(slots.data() + program.first_mode, branch.modes.size(), branch.modes.begin());
  return true;
}

}  // namespace bgsim
