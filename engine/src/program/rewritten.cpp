#include "program/rewritten.hpp"

#include "expression/graph.hpp"

namespace bgsim {

ExprId with_images(BlockOrder& made, ExprId e, const std::vector<ExprId>& images) {
  const ExprNode node = made.pool[e];  // a copy: the pool grows
  bool same = true;
  for_each_argument(node, [&](ExprId a) { same = same && images[a.index()] == a; });
  return same ? e : rebuilt(made.pool, node, [&images](ExprId a) { return images[a.index()]; });
}

void replace_by_images(BlockOrder& made, const std::vector<ExprId>& images) {
  const auto replace = [&images](std::vector<ExprId>& list) {
    for (ExprId& e : list)
      if (e.valid()) e = images[e.index()];
  };
  for (std::vector<ExprId>* list :
       {&made.resolved, &made.rates, &made.outputs, &made.powers, &made.stored, &made.continuous, &made.switches,
        &made.event_conditions, &made.event_values, &made.delayed, &made.delayed_before, &made.diodes, &made.impulses,
        &made.conjugates})
    replace(*list);
  for (std::vector<ExprId>& list : made.port_powers) replace(list);
  for (Block& block : made.blocks) replace(block.residuals);
}

}  // namespace bgsim
