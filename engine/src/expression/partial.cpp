#include "expression/partial.hpp"

#include <array>
#include <cmath>
#include <unordered_set>
#include <vector>

#include "expression/graph.hpp"

namespace bgsim {

namespace {

/// Apart from its sign and a number before it: quotients are written with these elsewhere.
ExprId bare(const ExprPool& pool, ExprId id) {
  for (;;) {
    const ExprNode& node = pool[id];
    if (node.op == Op::neg)
      id = ExprId(node.a);
    else if (node.op == Op::mul && pool.is_constant(ExprId(node.a)))
      id = ExprId(node.b);
    else
      return id;
  }
}

/// What decides whether it has a value: of a quotient what it is divided by, else the expression itself.
ExprId decides(const ExprPool& pool, ExprId id) {
  const ExprNode& node = pool[id];
  return node.op == Op::div || node.op == Op::mod ? bare(pool, ExprId(node.b)) : id;
}

}  // namespace

bool is_partial(const ExprPool& pool, ExprId id) {
  const ExprNode& node = pool[id];
  const auto number = [&](std::uint32_t argument) -> std::optional<double> {
    const ExprId at(argument);
    return pool.is_constant(at) ? std::optional(pool[at].constant) : std::nullopt;
  };
  switch (node.op) {
    case Op::div:
    case Op::mod:
      return number(node.b).value_or(0.0) == 0.0;
    case Op::pow: {
      const auto base = number(node.a), exponent = number(node.b);
      return !(base && *base > 0.0) && !(exponent && *exponent >= 0.0 && std::floor(*exponent) == *exponent);
    }
    case Op::sqrt:
      return pool[ExprId(node.a)].op != Op::abs;
    case Op::log:
    case Op::log10:
    case Op::log1p:
    case Op::asin:
    case Op::acos:
    case Op::acosh:
    case Op::atanh:
    case Op::table:
      return true;
    default:
      return false;
  }
}

ExprId lost_partial(const ExprPool& pool, std::span<const ExprId> arguments, ExprId divisor, ExprId result) {
  std::unordered_set<std::uint32_t> kept;
  for (const ExprId id : reachable(pool, std::array{result}))
    if (is_partial(pool, id)) kept.insert(decides(pool, id).value);
  std::vector<ExprId> open(arguments.begin(), arguments.end());
  std::unordered_set<std::uint32_t> seen;
  while (!open.empty()) {
    const ExprId id = open.back();
    open.pop_back();
    if (!seen.insert(id.value).second) continue;
    if (is_partial(pool, id) && !kept.contains(decides(pool, id).value)) return id;
    // What if(...) chooses is guarded by its condition.
    if (pool[id].op == Op::select)
      open.emplace_back(pool[id].a);
    else
      for_each_argument(pool[id], [&](ExprId argument) { open.push_back(argument); });
  }
  if (!divisor.valid() || kept.contains(bare(pool, divisor).value)) return {};
  return pool.is_constant(divisor) && !pool.is_constant(divisor, 0.0) ? ExprId() : divisor;
}

std::string left_out_words(const ExprPool& pool, ExprId kept, ExprId lost, const SymbolName& name) {
  return "this is taken as " + to_text(pool, kept, name) + ", also where " + to_text(pool, lost, name) +
         (is_partial(pool, lost) ? " has no value" : " is 0");
}

}  // namespace bgsim
