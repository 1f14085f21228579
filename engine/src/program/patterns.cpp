#include "program/patterns.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace bgsim {

namespace {

/// Elimination of loops may fill the Jacobian; beyond this many entries of dz/dx only the implicit form is compiled.
constexpr std::size_t kMostEliminated = 4'000'000;

Sparsity pattern_of(std::size_t size, std::vector<std::pair<std::uint32_t, std::uint32_t>> column_row) {
  for (std::uint32_t i = 0; i < size; ++i) column_row.emplace_back(i, i);
  std::sort(column_row.begin(), column_row.end());
  column_row.erase(std::unique(column_row.begin(), column_row.end()), column_row.end());
  Sparsity result;
  result.size = size;
  result.column_start.assign(size + 1, 0);
  for (const auto& [column, row] : column_row) {
    ++result.column_start[column + 1];
    result.row.push_back(row);
  }
  std::partial_sum(result.column_start.begin(), result.column_start.end(), result.column_start.begin());
  return result;
}

}  // namespace

void find_supports(Program& program, SystemClass system_class) {
  JacobianPlan& plan = program.plan;
  std::size_t total = 0;
  plan.explicit_form = system_class != SystemClass::implicit_dae;
  for (std::size_t b = 0; b < plan.blocks.size() && plan.explicit_form; ++b) {
    JacobianPlan::BlockPart& part = plan.blocks[b];
    for (const auto& entry : part.by_states) part.columns.push_back(entry.column);
    for (const auto& entry : part.by_earlier_tears) {
      const auto& earlier = plan.blocks[plan.block_of_tear[entry.column]].columns;
      part.columns.insert(part.columns.end(), earlier.begin(), earlier.end());
    }
    std::sort(part.columns.begin(), part.columns.end());
    part.columns.erase(std::unique(part.columns.begin(), part.columns.end()), part.columns.end());
    total += part.columns.size() * program.blocks[b].size;
    plan.explicit_form = total <= kMostEliminated;
  }
  if (!plan.explicit_form) program.system_class = SystemClass::implicit_dae;
}

void make_patterns(Program& program, std::size_t states, std::size_t tears) {
  const JacobianPlan& plan = program.plan;
  const auto n = static_cast<std::uint32_t>(states);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> explicit_form, implicit_form;
  for (const auto& e : plan.rates_by_states) explicit_form.emplace_back(e.column, e.row);
  implicit_form = explicit_form;
  for (const auto& e : plan.rates_by_tears) {
    implicit_form.emplace_back(n + e.column, e.row);
    if (plan.explicit_form)
      for (const std::uint32_t column : plan.blocks[plan.block_of_tear[e.column]].columns)
        explicit_form.emplace_back(column, e.row);
  }
  for (std::size_t b = 0; b < plan.blocks.size(); ++b) {
    const std::uint32_t first = n + program.blocks[b].first_tear;
    for (const auto& e : plan.blocks[b].by_states) implicit_form.emplace_back(e.column, first + e.row);
    for (const auto& e : plan.blocks[b].by_earlier_tears) implicit_form.emplace_back(n + e.column, first + e.row);
    for (const auto& e : plan.blocks[b].by_own_tears) implicit_form.emplace_back(first + e.column, first + e.row);
  }
  if (plan.explicit_form) program.jacobian_pattern = pattern_of(n, std::move(explicit_form));
  program.implicit_pattern = pattern_of(n + tears, std::move(implicit_form));
}

}  // namespace bgsim
