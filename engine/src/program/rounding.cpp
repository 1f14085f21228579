// What rounding can have made of a value: bounds of errors carried along with the values, instruction by instruction
// (running error analysis: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed. 2002, section 3.3).
#include <algorithm>
#include <cmath>
#include <limits>

#include "expression/table_cell.hpp"
#include "program/evaluator_impl.hpp"

namespace bgsim {

namespace {

constexpr double kUnit = std::numeric_limits<double>::epsilon() / 2;  // of one rounded operation
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// The largest change of @p f where its arguments move by their errors, and the rounding of the function itself, which
/// a mathematical library keeps to an ulp.
template <class Function>
double shaken(double value, const Function& f, const double (&errors)[3]) {
  double most = 0.0;
  for (int signs = 0; signs < 8; ++signs) {
    double shift[3];
    bool known = false;
    for (int k = 0; k < 3; ++k) {
      shift[k] = (signs >> k & 1) != 0 ? errors[k] : -errors[k];
      known = known || (errors[k] == 0.0 && (signs >> k & 1) != 0);  // the same as with the other sign
    }
    if (known) continue;
    const double moved = std::abs(f(shift[0], shift[1], shift[2]) - value);
    if (std::isfinite(moved)) most = std::max(most, moved);  // outside the function's domain nothing is known
  }
  return most + 2.0 * kUnit * std::abs(value);
}

}  // namespace

void Evaluator::Impl::begin_errors(std::span<const double> of_parameters) {
  errors.assign(slots.size(), 0.0);
  std::copy(of_parameters.begin(), of_parameters.end(), errors.begin() + program.first_parameter);
  for (const auto& code : program.once.code) carry_errors(code);
}

void Evaluator::Impl::carry_errors(const CodeList& code) {
  const double* const s = slots.data();
  for (const Instruction& i : code) {
    const double value = s[i.out], a = s[i.a], of_a = errors[i.a];
    double error = 0.0;
    switch (i.op) {
      case Op::add:
      case Op::sub:
        error = of_a + errors[i.b] + kUnit * std::abs(value);
        break;
      case Op::mul:
        error = std::abs(a) * errors[i.b] + std::abs(s[i.b]) * of_a + of_a * errors[i.b] + kUnit * std::abs(value);
        break;
      case Op::div: {
        const double least = std::abs(s[i.b]) - errors[i.b];
        error = least > 0.0 ? (of_a + std::abs(value) * errors[i.b]) / least + kUnit * std::abs(value) : kInfinite;
        break;
      }
      case Op::neg:
        error = of_a;
        break;
      case Op::table:
      case Op::table_slope: {
        const Table& table = program.pool.table(TableId(i.b));
        const double cell = i.c == kNoSlot ? -1.0 : s[i.c];
        error =
            shaken(value,
                   [&](double da, double, double) {
                     return i.op == Op::table ? value_in_cell(table, a + da, cell) : slope_in_cell(table, a + da, cell);
                   },
                   {of_a, 0.0, 0.0});
        break;
      }
      case Op::table_curvature:
      case Op::table_third:
        error = kUnit * std::abs(value);
        break;
      case Op::abs:
        if (smoothing > 0.0) {
          error = of_a + kUnit * std::abs(value);
          break;
        }
        [[fallthrough]];
      default: {
        const bool two = arity(i.op) > 1, three = arity(i.op) > 2;
        const double b = two ? s[i.b] : 0.0, c = three ? s[i.c] : 0.0;
        error = shaken(value, [&](double da, double db, double dc) { return apply(i.op, a + da, b + db, c + dc); },
                       {of_a, two ? errors[i.b] : 0.0, three ? errors[i.c] : 0.0});
      }
    }
    errors[i.out] = std::isnan(error) ? kInfinite : error;
  }
}

void Evaluator::Impl::carry_errors_through(std::size_t block) {
  const ProgramBlock& b = program.blocks[block];
  LoopScratch& scratch = loops[block];
  const std::span<double> of_tears = std::span(errors).subspan(program.first_tear + b.first_tear, b.size);
  std::fill(of_tears.begin(), of_tears.end(), 0.0);
  const bool solvable = load_residual(block) && factorize(block) == LoopOutcome::solved;
  if (!solvable) {
    std::fill(of_tears.begin(), of_tears.end(), kInfinite);
    return;
  }
  for (const auto& code : b.residual.code) carry_errors(code);
  // At a zero of order m, Newton's step is an m-th of the distance that is left.
  constexpr double kOrder = 8.0;
  Eigen::VectorXd of_residuals(static_cast<Eigen::Index>(b.size));
  for (std::size_t r = 0; r < b.size; ++r) {
    const auto k = static_cast<Eigen::Index>(r);
    of_residuals[k] = errors[b.residual.results[r]] + std::abs(scratch.residual[k]);
  }
  const Eigen::VectorXd bounds = pass_through(block, of_residuals);
  for (std::size_t i = 0; i < b.size; ++i) of_tears[i] = kOrder * bounds[static_cast<Eigen::Index>(i)];
}

Eigen::VectorXd Evaluator::Impl::pass_through(std::size_t block, const Eigen::VectorXd& of_residuals) const {
  const LoopScratch& scratch = loops[block];
  const Eigen::VectorXd known = of_residuals.cwiseQuotient(scratch.matrix.row_scale);
  // |inverse| known, column by column; of large loops with the signs of some columns, for time linear in the columns.
  constexpr Eigen::Index kMostColumns = 64;
  const Eigen::Index size = known.size(), columns = std::min(size, kMostColumns);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(size), result(size);
  for (Eigen::Index c = 0; c < columns; ++c) {
    Eigen::VectorXd part = Eigen::VectorXd::Zero(size);
    for (Eigen::Index r = c; r < size; r += columns) part[r] = ((r / columns) % 2 == 0 ? 1.0 : -1.0) * known[r];
    scratch.matrix.solve(part, result);
    sum += result.cwiseAbs();
  }
  return sum.cwiseQuotient(scratch.matrix.column_scale);
}

void Evaluator::Impl::carry_errors_of(const Routine& routine, Branch& branch, double* bounds) {
  const Counts before = counts;  // this is no part of the run
  bool solved = true;
  for (std::size_t i = 0; solved && i < routine.code.size(); ++i) {
    run(routine.code[i]);
    carry_errors(routine.code[i]);
    if (i == routine.solves.size()) continue;
    const std::uint32_t block = routine.solves[i];
    solved = branch.given || solve(block) == LoopOutcome::solved;
    if (solved) carry_errors_through(block);
  }
  if (solved && !branch.given) keep(branch);
  counts = before;
  for (std::size_t i = 0; i < routine.results.size(); ++i) bounds[i] = solved ? errors[routine.results[i]] : kInfinite;
}

/// d tears / d residuals over all loops, each column times the residual's error: F_z dz + F_earlier dz_earlier =
/// -error. The errors of tears that move together cancel in what depends on their difference: the potential of a node
/// that hangs on blocking diodes is anything, the currents into it are not.
bool Evaluator::Impl::pass_errors_through_loops(std::span<const double> of_residuals) {
  const JacobianPlan& plan = program.plan;
  const auto count = static_cast<Eigen::Index>(of_residuals.size());
  tears_by_residuals.setZero(count, count);
  for (std::size_t b = 0; b < plan.blocks.size(); ++b) {
    LoopScratch& scratch = loops[b];
    const auto first = static_cast<Eigen::Index>(program.blocks[b].first_tear);
    const auto size = static_cast<Eigen::Index>(program.blocks[b].size);
    auto own = tears_by_residuals.middleRows(first, size);
    for (Eigen::Index r = 0; r < size; ++r) own(r, first + r) = of_residuals[static_cast<std::size_t>(first + r)];
    for (const auto& e : plan.blocks[b].by_earlier_tears)
      own.row(e.row) += slots[e.slot] * tears_by_residuals.row(e.column);
    for (Eigen::Index c = 0; c < first + size; ++c) {
      scratch.residual = own.col(c).cwiseQuotient(scratch.matrix.row_scale);
      scratch.matrix.solve(scratch.residual, scratch.step);
      own.col(c) = -scratch.step.cwiseQuotient(scratch.matrix.column_scale);
    }
  }
  return tears_by_residuals.allFinite();
}

void Evaluator::Impl::bound_rates(std::vector<double>& bounds) {
  constexpr std::size_t kMostTears = 256;
  const std::size_t tears = program.tear_names.size();
  bounds.clear();
  if (tears > kMostTears) return;
  errors.assign(slots.size(), 0.0);
  std::vector<double> of_residuals(tears, 0.0);
  for (std::size_t i = 0; i < program.rates.code.size(); ++i) {
    run(program.rates.code[i]);
    carry_errors(program.rates.code[i]);
    if (i == program.rates.solves.size()) continue;
    const std::uint32_t block = program.rates.solves[i];
    const ProgramBlock& b = program.blocks[block];
    load_residual(block);
    for (const auto& code : b.residual.code) carry_errors(code);
    // What the iteration left of the residuals is as good as rounding: it depends on where the iteration began.
    for (std::size_t r = 0; r < b.size; ++r) {
      const std::uint32_t result = b.residual.results[r];
      of_residuals[b.first_tear + r] = errors[result] + std::abs(slots[result]);
    }
  }
  const JacobianPlan& plan = program.plan;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(program.states.size()));
  if (tears > 0) {
    if (!pass_errors_through_loops(of_residuals)) return;
    Eigen::MatrixXd by_residuals = Eigen::MatrixXd::Zero(sum.size(), tears_by_residuals.cols());
    for (const auto& e : plan.rates_by_tears)
      by_residuals.row(e.row) += slots[e.slot] * tears_by_residuals.row(e.column);
    sum = by_residuals.cwiseAbs().rowwise().sum();
  }
  bounds.resize(program.states.size());
  for (std::size_t i = 0; i < bounds.size(); ++i)
    bounds[i] = errors[program.rates.results[i]] + sum[static_cast<Eigen::Index>(i)];
}

void Evaluator::power_rounding(double t, const double* x, Branch& branch, double* bounds) {
  impl_->begin_errors();
  impl_->set_point(t, x, branch);
  impl_->carry_errors_of(impl_->program.powers, branch, bounds);
}

void Evaluator::dependent_rounding(double t, const double* x, Branch& branch, std::span<const double> state_errors,
                                   std::span<const double> parameter_errors, double* bounds) {
  Impl& impl = *impl_;
  impl.begin_errors(parameter_errors);
  impl.set_point(t, x, branch);
  std::copy(state_errors.begin(), state_errors.end(), impl.errors.begin() + impl.program.first_state);
  impl.carry_errors_of(impl.program.dependents, branch, bounds);
}

void Evaluator::tear_rounding(double t, const double* x, Branch& branch, double* bounds) {
  Impl& impl = *impl_;
  const Program& program = impl.program;
  impl.begin_errors();
  impl.set_point(t, x, branch);
  for (std::size_t i = 0; i < program.states.size(); ++i) impl.errors[program.first_state + i] = kUnit * std::abs(x[i]);
  std::vector<double> of_rates(program.states.size());
  impl.carry_errors_of(program.rates, branch, of_rates.data());
  std::copy_n(impl.errors.begin() + program.first_tear, program.tear_names.size(), bounds);
}

void Evaluator::output_rounding(double t, const double* x, Branch& branch, std::span<const double> state_errors,
                                double* bounds) {
  Impl& impl = *impl_;
  impl.begin_errors();
  impl.set_point(t, x, branch);
  std::copy(state_errors.begin(), state_errors.end(), impl.errors.begin() + impl.program.first_state);
  impl.carry_errors_of(impl.program.outputs, branch, bounds);
}

void Evaluator::diode_rounding(double t, const double* x, Branch& branch, std::span<const double> state_errors,
                               double time_error, double* bounds) {
  Impl& impl = *impl_;
  impl.begin_errors();
  impl.set_point(t, x, branch);
  impl.errors[impl.program.time_slot] = time_error;
  std::copy(state_errors.begin(), state_errors.end(), impl.errors.begin() + impl.program.first_state);
  impl.carry_errors_of(impl.program.diodes, branch, bounds);
}

bool Evaluator::continuous(double t, const double* x, Branch& branch, double time_error, double* values,
                           double* bounds) {
  Impl& impl = *impl_;
  const Program& program = impl.program;
  std::vector<double> rates(program.states.size());
  if (!this->rates(t, x, branch, rates.data())) return false;
  if (!impl.run_or_given(program.continuous, t, x, branch)) return false;
  if (!impl.take(program.continuous, values, "a quantity that must not jump", {})) return false;
  impl.begin_errors();
  impl.set_point(t, x, branch);
  impl.errors[program.time_slot] = time_error;
  for (std::size_t i = 0; i < rates.size(); ++i)
    impl.errors[program.first_state + i] = std::abs(rates[i]) * time_error + kUnit * std::abs(x[i]);
  impl.carry_errors_of(program.continuous, branch, bounds);
  return true;
}

}  // namespace bgsim
