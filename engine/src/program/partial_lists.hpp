/// The partial derivatives that a program is compiled with.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

struct Partial {
  std::uint32_t row, column;
  ExprId value;
};
using Partials = std::vector<Partial>;

struct BlockPartials {
  Partials by_states, by_earlier_tears, by_own_tears, by_columns;  ///< rows and own columns within the block
};

/// Of values that are no rates: by row.
struct RowPartials {
  Partials by_states, by_tears, by_columns;
};

/// Of rates and loops; those by parameters and time, and of outputs and guards, where a TransposedPlan is wanted.
struct SystemPartials {
  Partials rates_by_states, rates_by_tears, rates_by_columns;
  std::vector<BlockPartials> blocks;
  RowPartials outputs, guards, sets;
};

/// Takes them, and lets the pool grow by them. Cost: the expressions below each row.
/// @param origins    by ExprId of @p pool; grows with it
/// @param blocks     their tears are the columns behind the states
/// @param residuals  by block
/// @param columns    see CompileOptions; null: none, and none of outputs
SystemPartials take_partials(ExprPool& pool, std::vector<Origin>& origins, const EquationSystem& system,
                             const std::vector<Block>& blocks, const std::vector<ExprId>& rates,
                             const std::vector<std::vector<ExprId>>& residuals, const std::vector<ExprId>& outputs,
                             const std::vector<std::uint32_t>* columns);

/// Of what the events set, by Program::event_values.
/// @param values  frozen
RowPartials take_set_partials(Program& program, const EquationSystem& system, const std::vector<Block>& blocks,
                              const std::vector<ExprId>& values, const std::vector<std::uint32_t>& columns);

/// Of the guards of a program's relations, by relation.
RowPartials take_guard_partials(Program& program, const EquationSystem& system, const std::vector<Block>& blocks,
                                const std::vector<std::uint32_t>& columns);

/// Of a system that is not frozen yet, whose pool grows. Frozen afterwards, what they jump at is a relation of its own:
/// min, max and abs have slopes that jump although they themselves do not.
SystemPartials take_plain_partials(const EquationSystem& system, BlockOrder& order, const CompileOptions& options);

/// Each partial by what @p change makes of it.
template <class Change>
SystemPartials changed(SystemPartials partials, const Change& change) {
  const auto all = [&change](Partials& list) {
    for (Partial& each : list) each.value = change(each.value);
  };
  for (Partials* list : {&partials.rates_by_states, &partials.rates_by_tears, &partials.rates_by_columns}) all(*list);
  for (BlockPartials& block : partials.blocks)
    for (Partials* list : {&block.by_states, &block.by_earlier_tears, &block.by_own_tears, &block.by_columns})
      all(*list);
  for (Partials* list : {&partials.outputs.by_states, &partials.outputs.by_tears, &partials.outputs.by_columns})
    all(*list);
  return partials;
}

}  // namespace bgsim
