#include <algorithm>

#include "program/evaluator_impl.hpp"

namespace bgsim {

bool Evaluator::take_partials(double t, const double* x, Branch& branch, Rows rows) {
  Impl& impl = *impl_;
  const TransposedPlan& plan = impl.program.transposed;
  impl.taken = rows;
  if (!impl.run(rows == Rows::outputs ? plan.routine : plan.events_routine, t, x, branch)) return false;
  for (std::size_t b = 0; b < impl.program.blocks.size(); ++b)
    if (const LoopOutcome outcome = impl.factorize(b); outcome != LoopOutcome::solved) {
      impl.fail_loop(b, outcome);
      return false;
    }
  return true;
}

/// With weights v of the values g(x, z, p): v g_x - w F_x, where w F_z = v g_z; loops one after the other, the last one
/// first.
void Evaluator::pull_back(std::span<const double> of_rates, std::span<const double> of_rows,
                          std::span<double> by_states, std::span<double> by_columns) {
  Impl& impl = *impl_;
  const Program& program = impl.program;
  const JacobianPlan& plan = program.plan;
  const TransposedPlan& transposed = program.transposed;
  const TransposedPlan::Rows& rows = impl.taken == Rows::outputs  ? transposed.outputs
                                     : impl.taken == Rows::guards ? transposed.guards
                                                                  : transposed.sets;
  std::fill(by_states.begin(), by_states.end(), 0.0);
  std::fill(by_columns.begin(), by_columns.end(), 0.0);
  std::vector<double>& of_tears = impl.back_to_tears;
  of_tears.assign(program.tear_names.size(), 0.0);
  const auto add = [&](const std::vector<JacobianPlan::Entry>& entries, const auto& weights, auto&& sums, double sign) {
    if (std::size(weights) == 0) return;  // all 0
    // What has no weight has no part in the sum, even where its slope has no bound.
    for (const auto& e : entries)
      if (weights[e.row] != 0.0) sums[e.column] += sign * weights[e.row] * impl.slots[e.slot];
  };
  add(plan.rates_by_states, of_rates, by_states, 1.0);
  add(plan.rates_by_tears, of_rates, of_tears, 1.0);
  add(transposed.rates, of_rates, by_columns, 1.0);
  add(rows.by_states, of_rows, by_states, 1.0);
  add(rows.by_tears, of_rows, of_tears, 1.0);
  add(rows.by_columns, of_rows, by_columns, 1.0);
  for (std::size_t b = program.blocks.size(); b-- > 0;) {
    const ProgramBlock& block = program.blocks[b];
    LoopScratch& scratch = impl.loops[b];
    scratch.residual = Eigen::Map<const Eigen::VectorXd>(of_tears.data() + block.first_tear, block.size);
    scratch.matrix.solve_transposed(scratch.residual, scratch.step);
    add(plan.blocks[b].by_states, scratch.step, by_states, -1.0);
    add(plan.blocks[b].by_earlier_tears, scratch.step, of_tears, -1.0);
    add(transposed.blocks[b], scratch.step, by_columns, -1.0);
  }
}

}  // namespace bgsim
