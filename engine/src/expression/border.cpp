#include "expression/border.hpp"

#include "expression/apply.hpp"
#include "expression/graph.hpp"

namespace bgsim {
namespace {

/// With 0 for the guard.
ExprId at_border(ExprPool& pool, ExprId root, ExprId guard) {
  IdMap<ExprId> images;
  images.insert(guard, pool.constant(0.0));
  arguments_first(
      pool, root, [&images](ExprId e) { return images.find(e) != nullptr; },
      [&](ExprId e) {
        const ExprNode node = pool[e];  // a copy: the pool grows
        images.insert(e, rebuilt(pool, node, [&images](ExprId a) { return *images.find(a); }));
      });
  return *images.find(root);
}

}  // namespace

bool is_border(Op op) { return op == Op::sign || op == Op::step || is_comparison(op); }

Guard guard_of(ExprPool& pool, const ExprNode& node) {
  Guard guard{is_comparison(node.op) ? pool.sub(ExprId(node.a), ExprId(node.b)) : ExprId(node.a)};
  // A momentum and its speed have one border.
  const auto scales = [&](std::uint32_t by, std::uint32_t what) {
    if (!pool.is_constant(ExprId(by)) || pool[ExprId(by)].constant == 0.0) return false;
    if (pool[ExprId(by)].constant < 0.0) guard.way = -guard.way;
    guard.at = ExprId(what);
    return true;
  };
  for (bool scaled = true; scaled;) {
    const ExprNode at = pool[guard.at];
    scaled = false;
    if (at.op == Op::neg) {
      guard = {ExprId(at.a), -guard.way};
      scaled = true;
    } else if (at.op == Op::mul || at.op == Op::div) {
      scaled = scales(at.b, at.a) || (at.op == Op::mul && scales(at.a, at.b));
    }
  }
  if (const ExprNode at = pool[guard.at]; at.op == Op::sub)
    if (const ExprId other = pool.sub(ExprId(at.b), ExprId(at.a)); other < guard.at) return {other, -guard.way};
  return guard;
}

ExprId on_side(ExprPool& pool, ExprId law, ExprId guard, int side) {
  IdMap<ExprId> images;
  arguments_first(
      pool, law, [&images](ExprId e) { return images.find(e) != nullptr; },
      [&](ExprId e) {
        const ExprNode node = pool[e];  // a copy: the pool grows
        const Guard own = is_border(node.op) ? guard_of(pool, node) : Guard();
        if (own.at.valid() && own.at == guard)
          images.insert(e, pool.constant(apply(node.op, own.way * side, 0.0)));
        else
          images.insert(e, rebuilt(pool, node, [&images](ExprId a) { return *images.find(a); }));
      });
  return *images.find(law);
}

bool meet(ExprPool& pool, ExprId below, ExprId above, ExprId guard) {
  if (below == above) return true;
  const ExprId one = at_border(pool, below, guard), other = at_border(pool, above, guard);
  return one == other ||  // 0 and -0 are two
         (pool.is_constant(one) && pool.is_constant(other) && pool[one].constant == pool[other].constant);
}

}  // namespace bgsim
