#include "program/partial_lists.hpp"

#include <limits>

namespace bgsim {
namespace {

constexpr std::uint32_t kNotWanted = std::numeric_limits<std::uint32_t>::max();

/// Columns of all that derivatives are taken by: states, tears, then parameters and time.
class Taker {
 public:
  Taker(ExprPool& pool, std::vector<Origin>& origins, const EquationSystem& system, const std::vector<Block>& blocks,
        const std::vector<std::uint32_t>* columns)
      : pool_(pool),
        origins_(origins),
        states_(static_cast<std::uint32_t>(system.states.size())),
        column_of_(system.symbols.size(), kNotWanted) {
    std::uint32_t next = 0;
    const auto give = [&](SymbolId symbol) { column_of_[symbol.index()] = next++; };
    for (const State& state : system.states) give(state.symbol);
    for (const Block& block : blocks)
      for (const SymbolId tear : block.tears) give(tear);
    inner_ = next;
    if (columns == nullptr) return;
    for (const std::uint32_t parameter : *columns) give(system.parameters[parameter]);
    give(system.time);
  }

  template <class Take>
  void row(ExprId root, const Take& take) {
    const auto wanted = [this](SymbolId symbol) {
      return symbol.index() < column_of_.size() && column_of_[symbol.index()] != kNotWanted;
    };
    const auto partials = gradient(pool_, root, wanted);
    origins_.resize(pool_.size(), Origin(origins_[root.index()]));
    for (const auto& [symbol, value] : partials) take(column_of_[symbol.index()], value);
  }

  void row(ExprId root, std::uint32_t index, Partials& by_states, Partials& by_tears, Partials& by_columns) {
    row(root, [&](std::uint32_t column, ExprId value) {
      if (column < states_)
        by_states.push_back({index, column, value});
      else if (column < inner_)
        by_tears.push_back({index, column - states_, value});
      else
        by_columns.push_back({index, column - inner_, value});
    });
  }

 private:
  ExprPool& pool_;
  std::vector<Origin>& origins_;
  std::uint32_t states_, inner_ = 0;
  std::vector<std::uint32_t> column_of_;  ///< by SymbolId
};

}  // namespace

SystemPartials take_partials(ExprPool& pool, std::vector<Origin>& origins, const EquationSystem& system,
                             const std::vector<Block>& blocks, const std::vector<ExprId>& rates,
                             const std::vector<std::vector<ExprId>>& residuals, const std::vector<ExprId>& outputs,
                             const std::vector<std::uint32_t>* columns) {
  SystemPartials made;
  Taker taker(pool, origins, system, blocks, columns);
  for (std::uint32_t i = 0; i < rates.size(); ++i)
    taker.row(rates[i], i, made.rates_by_states, made.rates_by_tears, made.rates_by_columns);
  std::uint32_t first = 0;
  for (std::uint32_t b = 0; b < residuals.size(); ++b) {
    BlockPartials partials;
    Partials by_tears;
    for (std::uint32_t r = 0; r < residuals[b].size(); ++r)
      taker.row(residuals[b][r], r, partials.by_states, by_tears, partials.by_columns);
    for (const Partial& each : by_tears) {
      if (each.column >= first)
        partials.by_own_tears.push_back({each.row, each.column - first, each.value});
      else
        partials.by_earlier_tears.push_back(each);
    }
    first += static_cast<std::uint32_t>(blocks[b].tears.size());
    made.blocks.push_back(std::move(partials));
  }
  for (std::uint32_t i = 0; i < outputs.size() && columns != nullptr; ++i)
    taker.row(outputs[i], i, made.outputs.by_states, made.outputs.by_tears, made.outputs.by_columns);
  return made;
}

RowPartials take_guard_partials(Program& program, const EquationSystem& system, const std::vector<Block>& blocks,
                                const std::vector<std::uint32_t>& columns) {
  RowPartials made;
  Taker taker(program.pool, program.origins, system, blocks, &columns);
  for (std::uint32_t i = 0; i < program.relations.size(); ++i)
    if (program.relations[i].kind != Relation::Kind::denominator)  // no law changes where these do
      taker.row(program.relations[i].guard, i, made.by_states, made.by_tears, made.by_columns);
  return made;
}

RowPartials take_set_partials(Program& program, const EquationSystem& system, const std::vector<Block>& blocks,
                              const std::vector<ExprId>& values, const std::vector<std::uint32_t>& columns) {
  RowPartials made;
  Taker taker(program.pool, program.origins, system, blocks, &columns);
  for (std::uint32_t i = 0; i < values.size(); ++i)
    taker.row(values[i], i, made.by_states, made.by_tears, made.by_columns);
  return made;
}

SystemPartials take_plain_partials(const EquationSystem& system, BlockOrder& order, const CompileOptions& options) {
  std::vector<std::vector<ExprId>> residuals;
  for (const Block& block : order.blocks) residuals.push_back(block.residuals);
  std::vector<ExprId> outputs;
  for (const std::size_t i : options.outputs) outputs.push_back(order.outputs[i]);
  return take_partials(order.pool, order.origins, system, order.blocks, order.rates, residuals, outputs,
                       options.columns);
}

}  // namespace bgsim
