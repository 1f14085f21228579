#include <algorithm>
#include <unordered_set>

#include "bgsim/evaluator.hpp"
#include "equations/slice_needs.hpp"

namespace bgsim {

void check_start(const std::shared_ptr<const Model>& model, const EquationSystem& system, const BlockOrder& order,
                 const Slice& slice, const RunInputs& inputs) {
  std::unordered_set<SymbolId> in_slice;
  for (const DependentStore& store : slice.system.dependent) in_slice.insert(store.symbol);
  std::vector<std::uint32_t> unchecked;
  std::vector<ExprId> roots;
  for (const DependentStore& store : system.dependent) {
    const std::uint32_t equation = system.symbols[store.symbol.index()].index;
    const bool given = std::any_of(inputs.initial.begin(), inputs.initial.end(), [&](const RunInputs::Initial& i) {
      return i.element == store.element && i.port == store.port;
    });
    if (!given || in_slice.contains(store.symbol)) continue;
    unchecked.push_back(equation);
    roots.push_back(system.equations[equation].expression);
  }
  if (roots.empty()) return;
  // All states are known at the start; nothing is integrated, so their rates are of no concern.
  Needs needs = needs_of(system, roots);
  for (const std::uint32_t equation : unchecked) needs.equations[equation] = true;
  Slice start = take(system, order, needs);
  for (ExprId& rate : start.order.rates) rate = start.order.pool.constant(0.0);
  start.order.origins.resize(start.order.pool.size());
  const Program program = compile(model, start.system, start.order, {{}, false});
  Evaluator evaluator(program, inputs.parameters);
  initial_states(evaluator, inputs);
}

}  // namespace bgsim
