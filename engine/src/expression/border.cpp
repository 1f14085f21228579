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
  ExprId at = is_comparison(node.op) ? pool.sub(ExprId(node.a), ExprId(node.b)) : ExprId(node.a);
  // A momentum and its speed have one border.
  for (bool scaled = true; scaled;) {
    const ExprNode& product = pool[at];
    const auto positive = [&pool](std::uint32_t e) {
      return pool.is_constant(ExprId(e)) && pool[ExprId(e)].constant > 0;
    };
    scaled = false;
    if ((product.op == Op::mul || product.op == Op::div) && positive(product.b)) {
      at = ExprId(product.a);
      scaled = true;
    } else if (product.op == Op::mul && positive(product.a)) {
      at = ExprId(product.b);
      scaled = true;
    }
  }
  if (pool[at].op == Op::neg) return {ExprId(pool[at].a), -1};
  const ExprId other = is_comparison(node.op) ? pool.sub(ExprId(node.b), ExprId(node.a)) : pool.neg(at);
  return other < at ? Guard{other, -1} : Guard{at, 1};
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
