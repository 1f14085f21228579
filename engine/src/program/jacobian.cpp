#include <algorithm>
#include <cmath>

#include "program/evaluator_impl.hpp"

namespace bgsim {
namespace {

std::int64_t position(const Sparsity& pattern, std::size_t row, std::size_t column) {
  const auto first = pattern.row.begin() + pattern.column_start[column];
  const auto last = pattern.row.begin() + pattern.column_start[column + 1];
  return std::lower_bound(first, last, static_cast<std::int64_t>(row)) - pattern.row.begin();
}

std::uint32_t rank(const std::vector<std::uint32_t>& sorted, std::uint32_t value) {
  return static_cast<std::uint32_t>(std::lower_bound(sorted.begin(), sorted.end(), value) - sorted.begin());
}

}  // namespace

/// Where each partial derivative goes, looked up once.
void Evaluator::Impl::prepare_positions() {
  const JacobianPlan& plan = program.plan;
  const std::size_t n = program.state_names.size();
  if (plan.explicit_form) {
    for (const auto& e : plan.rates_by_states)
      explicit_rates.push_back(position(program.jacobian_pattern, e.row, e.column));
    for (const auto& e : plan.rates_by_tears) {
      auto& targets = explicit_tears.emplace_back();
      for (const std::uint32_t column : plan.blocks[plan.block_of_tear[e.column]].columns)
        targets.push_back(position(program.jacobian_pattern, e.row, column));
    }
    for (std::size_t b = 0; b < plan.blocks.size(); ++b) {
      const JacobianPlan::BlockPart& part = plan.blocks[b];
      auto& own = own_columns.emplace_back();
      for (const auto& e : part.by_states) own.push_back(rank(part.columns, e.column));
      auto& earlier = earlier_columns.emplace_back();
      for (const auto& e : part.by_earlier_tears) {
        auto& targets = earlier.emplace_back();
        for (const std::uint32_t column : plan.blocks[plan.block_of_tear[e.column]].columns)
          targets.push_back(rank(part.columns, column));
      }
      loops[b].by_states.resize(static_cast<Eigen::Index>(program.blocks[b].size),
                                static_cast<Eigen::Index>(part.columns.size()));
    }
  }
  const Sparsity& implicit = program.implicit_pattern;
  for (const auto& e : plan.rates_by_states) implicit_entries.push_back(position(implicit, e.row, e.column));
  for (const auto& e : plan.rates_by_tears) implicit_entries.push_back(position(implicit, e.row, n + e.column));
  for (std::size_t b = 0; b < plan.blocks.size(); ++b) {
    const std::size_t first = n + program.blocks[b].first_tear;
    for (const auto& e : plan.blocks[b].by_states)
      implicit_entries.push_back(position(implicit, first + e.row, e.column));
    for (const auto& e : plan.blocks[b].by_earlier_tears)
      implicit_entries.push_back(position(implicit, first + e.row, n + e.column));
    for (const auto& e : plan.blocks[b].by_own_tears)
      implicit_entries.push_back(position(implicit, first + e.row, first + e.column));
  }
  for (std::size_t i = 0; i < n; ++i) implicit_diagonal.push_back(position(implicit, i, i));
}

/// With the tears from y.
bool Evaluator::Impl::run_implicit(const Routine& routine, double t, const double* y, const Branch& branch) {
  if (!goes_on()) return false;
  const std::size_t n = program.state_names.size();
  slots[program.time_slot] = t;
  std::copy_n(y, n, slots.data() + program.first_state);
  std::copy_n(y + n, program.tear_names.size(), slots.data() + program.first_tear);
  std::copy(branch.modes.begin(), branch.modes.end(), slots.data() + program.first_mode);
  for (const auto& code : routine.code) run(code);
  return true;
}

/// df/dx = f_x + f_z dz/dx, and for each loop F_z dz/dx = -(F_x + F_earlier dz_earlier/dx).
bool Evaluator::Impl::eliminate(double* values) {
  const JacobianPlan& plan = program.plan;
  for (std::size_t b = 0; b < plan.blocks.size(); ++b) {
    const JacobianPlan::BlockPart& part = plan.blocks[b];
    LoopScratch& scratch = loops[b];
    if (const LoopOutcome outcome = factorize(b); outcome != LoopOutcome::solved) {
      fail_loop(b, outcome);
      return false;
    }
    scratch.by_states.setZero();
    for (std::size_t i = 0; i < part.by_states.size(); ++i)
      scratch.by_states(part.by_states[i].row, own_columns[b][i]) += slots[part.by_states[i].slot];
    for (std::size_t i = 0; i < part.by_earlier_tears.size(); ++i) {
      const auto& e = part.by_earlier_tears[i];
      const std::uint32_t other = plan.block_of_tear[e.column];
      const auto row = static_cast<Eigen::Index>(e.column - program.blocks[other].first_tear);
      const auto& targets = earlier_columns[b][i];
      for (std::size_t k = 0; k < targets.size(); ++k)
        scratch.by_states(e.row, targets[k]) +=
            slots[e.slot] * loops[other].by_states(row, static_cast<Eigen::Index>(k));
    }
    for (Eigen::Index c = 0; c < scratch.by_states.cols(); ++c) {
      scratch.residual = scratch.by_states.col(c).cwiseQuotient(scratch.matrix.row_scale);
      scratch.matrix.solve(scratch.residual, scratch.step);
      scratch.by_states.col(c) = -scratch.step.cwiseQuotient(scratch.matrix.column_scale);
    }
  }
  for (std::size_t i = 0; i < plan.rates_by_states.size(); ++i)
    values[explicit_rates[i]] += slots[plan.rates_by_states[i].slot];
  for (std::size_t i = 0; i < plan.rates_by_tears.size(); ++i) {
    const auto& e = plan.rates_by_tears[i];
    const std::uint32_t other = plan.block_of_tear[e.column];
    const auto row = static_cast<Eigen::Index>(e.column - program.blocks[other].first_tear);
    for (std::size_t k = 0; k < explicit_tears[i].size(); ++k)
      values[explicit_tears[i][k]] += slots[e.slot] * loops[other].by_states(row, static_cast<Eigen::Index>(k));
  }
  return true;
}

bool Evaluator::Impl::slopes(double t, const double* x, Branch& branch, double* values) {
  ++counts.jacobians;
  if (!run(program.plan.routine, t, x, branch)) return false;
  std::fill_n(values, static_cast<std::size_t>(program.jacobian_pattern.column_start.back()), 0.0);
  return eliminate(values);
}

bool Evaluator::Impl::all_finite(double t, const double* values) {
  const auto nonzeros = static_cast<std::size_t>(program.jacobian_pattern.column_start.back());
  for (std::size_t i = 0; i < nonzeros; ++i) {
    if (std::isfinite(values[i])) continue;
    for (const auto& e : program.plan.rates_by_states)
      if (!std::isfinite(slots[e.slot])) {
        fail_at(e.slot, "the Jacobian of \"" + program.state_names[e.row] + "\"");
        return false;
      }
    fault = {Fault::Kind::not_finite, t, "a partial derivative", "the Jacobian", {}, {}};
    return false;
  }
  return true;
}

bool Evaluator::jacobian(double t, const double* x, Branch& branch, double* values) {
  return impl_->slopes(t, x, branch, values) && impl_->all_finite(t, values);
}

bool Evaluator::jacobian(double t, const double* x, Branch& branch, double* values, std::vector<double>& rounding) {
  if (!jacobian(t, x, branch, values)) return false;
  impl_->bound_rates(rounding);
  return true;
}

bool Evaluator::slopes(double t, const double* x, Branch& branch, double* values, std::vector<double>& rounding) {
  if (!impl_->slopes(t, x, branch, values)) return false;
  impl_->bound_rates(rounding);
  return true;
}

bool Evaluator::residual(double t, const double* y, const Branch& branch, const double* yp, double* r) {
  Impl& impl = *impl_;
  ++impl.counts.rates;
  const Program& program = impl.program;
  if (!impl.run_implicit(program.implicit_residual, t, y, branch)) return false;
  if (!impl.take(program.implicit_residual, r, "the rate of", program.state_names)) return false;
  for (std::size_t i = 0; i < states(); ++i) r[i] = yp[i] - r[i];
  return true;
}

bool Evaluator::residual_jacobian(double t, double cj, const double* y, const Branch& branch, double* values) {
  Impl& impl = *impl_;
  ++impl.counts.jacobians;
  const Program& program = impl.program;
  const JacobianPlan& plan = program.plan;
  if (!impl.run_implicit(plan.implicit_routine, t, y, branch)) return false;
  const auto nonzeros = static_cast<std::size_t>(program.implicit_pattern.column_start.back());
  std::fill_n(values, nonzeros, 0.0);
  auto target = impl.implicit_entries.begin();
  bool finite = true;
  const auto add = [&](const std::vector<JacobianPlan::Entry>& entries, double sign) {
    for (const auto& e : entries) {
      const double value = impl.slots[e.slot];
      if (!std::isfinite(value) && finite) impl.fail_at(e.slot, "the Jacobian");
      finite = finite && std::isfinite(value);
      values[*target++] += sign * value;
    }
  };
  add(plan.rates_by_states, -1.0);
  add(plan.rates_by_tears, -1.0);
  for (const JacobianPlan::BlockPart& part : plan.blocks) {
    add(part.by_states, 1.0);
    add(part.by_earlier_tears, 1.0);
    add(part.by_own_tears, 1.0);
  }
  for (const std::int64_t diagonal : impl.implicit_diagonal) values[diagonal] += cj;
  return finite;
}

}  // namespace bgsim
