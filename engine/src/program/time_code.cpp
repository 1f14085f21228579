#include "program/time_code.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "program/evaluator_impl.hpp"

namespace bgsim {
namespace {

/// Writes expressions of a pool that has grown beyond a program's own as instructions on its slots and further ones.
class Writer {
 public:
  Writer(const Program& program, const ExprPool& pool, TimeCode& to)
      : program_(program), pool_(pool), to_(to), slot_of_(pool.size(), kNoSlot) {
    for (std::size_t slot = 0; slot < program.slot_expression.size(); ++slot)
      slot_of_[program.slot_expression[slot].index()] = static_cast<std::uint32_t>(slot);
  }

  /// What depends on parameters only and has a slot is in Program::once. All else is computed here, whoever else does.
  void write(const std::vector<ExprId>& roots) {
    std::vector<char> varies(pool_.size(), 0);
    std::vector<char> is_parameter(program_.symbol_names.size(), 0);
    for (const SymbolId parameter : program_.parameters) is_parameter[parameter.index()] = 1;
    for (const ExprId e : reachable(pool_, roots)) {
      const ExprNode& node = pool_[e];
      if (node.op == Op::constant) continue;
      if (node.op == Op::symbol) {
        varies[e.index()] = is_parameter[node.a] != 0 ? 0 : 1;
        continue;
      }
      const std::uint32_t children[] = {node.a, node.b, node.c};
      for (int k = 0; k < arity(node.op); ++k) varies[e.index()] = std::max(varies[e.index()], varies[children[k]]);
      const bool known = slot_of_[e.index()] != kNoSlot;
      if (varies[e.index()] != 0)
        to_.code.push_back(instruction(e));
      else if (!known)
        to_.once.push_back(instruction(e));
    }
  }

  std::uint32_t slot(ExprId e) {
    std::uint32_t& slot = slot_of_[e.index()];
    if (slot == kNoSlot) {
      slot = static_cast<std::uint32_t>(program_.slots + to_.more_slots.size());
      to_.more_slots.push_back(pool_.is_constant(e) ? pool_[e].constant : 0.0);
    }
    return slot;
  }

 private:
  Instruction instruction(ExprId e) {
    const ExprNode node = pool_[e];
    Instruction result{node.op, 0, 0, 0, 0};
    result.a = slot(ExprId(node.a));
    if (is_table(node.op)) {
      result.b = node.b;
      result.c = cell_slot(ExprId(node.a), TableId(node.b));
    } else {
      if (arity(node.op) > 1) result.b = slot(ExprId(node.b));
      if (arity(node.op) > 2) result.c = slot(ExprId(node.c));
    }
    result.out = slot(e);
    return result;
  }

  /// The mode that says which cell of a table an argument is in.
  [[nodiscard]] std::uint32_t cell_slot(ExprId argument, TableId table) const {
    const auto is_it = [&](const Relation& relation) {
      return relation.kind == Relation::Kind::cell && relation.guard == argument && relation.table == table;
    };
    const auto found = std::find_if(program_.relations.begin(), program_.relations.end(), is_it);
    if (found == program_.relations.end()) return kNoSlot;
    return program_.first_mode + static_cast<std::uint32_t>(found - program_.relations.begin());
  }

  const Program& program_;
  const ExprPool& pool_;
  TimeCode& to_;
  std::vector<std::uint32_t> slot_of_;  ///< by ExprId
};

std::vector<ExprId> results_of(const Program& program, const Routine& routine) {
  std::vector<ExprId> result;
  for (const std::uint32_t slot : routine.results) result.push_back(program.slot_expression[slot]);
  return result;
}

}  // namespace

TimeCode::TimeCode(const Program& program) {
  const std::vector<ExprId> of_rates = results_of(program, program.rates);
  std::vector<std::vector<ExprId>> of_blocks;
  std::vector<ExprId> all = of_rates;
  for (const ProgramBlock& block : program.blocks) {
    of_blocks.push_back(results_of(program, block.residual));
    all.insert(all.end(), of_blocks.back().begin(), of_blocks.back().end());
  }
  const std::vector<SymbolId> symbols = symbols_in(program.pool, all);
  if (std::find(symbols.begin(), symbols.end(), program.time) == symbols.end()) return;

  ExprPool pool = program.pool;
  struct Taken {
    std::optional<std::size_t> block;
    std::uint32_t row;
    ExprId value;
  };
  std::vector<Taken> taken;
  const auto take = [&](std::optional<std::size_t> block, const std::vector<ExprId>& roots) {
    for (std::uint32_t row = 0; row < roots.size(); ++row)
      for (const auto& [symbol, value] :
           gradient(pool, roots[row], [&](SymbolId wanted) { return wanted == program.time; }))
        taken.push_back({block, row, value});
  };
  take({}, of_rates);
  for (std::size_t b = 0; b < of_blocks.size(); ++b) take(b, of_blocks[b]);
  if (taken.empty()) return;
  empty_ = false;
  std::vector<ExprId> roots;
  for (const Taken& each : taken) roots.push_back(each.value);
  Writer writer(program, pool, *this);
  writer.write(roots);
  blocks.resize(of_blocks.size());
  for (const Taken& each : taken)
    (each.block ? blocks[*each.block] : rates).push_back({each.row, writer.slot(each.value)});
}

/// f_t + f_z dz/dt, and for each loop F_z dz/dt = -(F_t + F_earlier dz_earlier/dt).
bool Evaluator::time_slopes(double t, const double* x, Branch& branch, double* values) {
  Impl& impl = *impl_;
  const Program& program = impl.program;
  std::fill_n(values, states(), 0.0);
  if (!names_time()) return true;
  const TimeCode& code = *impl.time_code;
  if (program.blocks.empty()) {
    if (!impl.goes_on()) return false;
    impl.set_point(t, x, branch);
  } else if (!impl.run(program.plan.routine, t, x, branch)) {
    return false;
  }
  impl.run(code.code);
  std::vector<double>& of_tears = impl.tears_by_time;
  for (std::size_t b = 0; b < program.blocks.size(); ++b) {
    const ProgramBlock& block = program.blocks[b];
    LoopScratch& scratch = impl.loops[b];
    if (const LoopOutcome outcome = impl.factorize(b); outcome != LoopOutcome::solved) {
      impl.fail_loop(b, outcome);
      return false;
    }
    scratch.residual.setZero();
    for (const TimeCode::Entry& e : code.blocks[b]) scratch.residual[e.row] += impl.slots[e.slot];
    for (const auto& e : program.plan.blocks[b].by_earlier_tears)
      scratch.residual[e.row] += impl.slots[e.slot] * of_tears[e.column];
    scratch.scaled = scratch.residual.cwiseQuotient(scratch.matrix.row_scale);
    scratch.matrix.solve(scratch.scaled, scratch.step);
    for (std::uint32_t k = 0; k < block.size; ++k)
      of_tears[block.first_tear + k] = -scratch.step[k] / scratch.matrix.column_scale[k];
  }
  for (const TimeCode::Entry& e : code.rates) values[e.row] += impl.slots[e.slot];
  for (const auto& e : program.plan.rates_by_tears) values[e.row] += impl.slots[e.slot] * of_tears[e.column];
  for (std::size_t i = 0; i < states(); ++i) {
    if (std::isfinite(values[i])) continue;
    impl.fault = {Fault::Kind::not_finite, t, "the partial derivative by time", program.state_names[i], {}, {}};
    return false;
  }
  return true;
}

bool Evaluator::names_time() {
  if (!impl_->time_code) impl_->begin_time_code();
  return !impl_->time_code->empty();
}

void Evaluator::Impl::begin_time_code() {
  time_code = std::make_unique<const TimeCode>(program);
  slots.insert(slots.end(), time_code->more_slots.begin(), time_code->more_slots.end());
  tears_by_time.assign(program.tear_names.size(), 0.0);
  run(time_code->once);
}

}  // namespace bgsim
