#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "bgsim/expression.hpp"
#include "expression/apply.hpp"
#include "expression/graph.hpp"

namespace bgsim {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct OpInfo {
  Op op;
  int arity;
  std::string_view name;
};
constexpr std::array kOps{
    OpInfo{Op::constant, 0, "constant"},
    OpInfo{Op::symbol, 0, "symbol"},
    OpInfo{Op::neg, 1, "-"},
    OpInfo{Op::add, 2, "+"},
    OpInfo{Op::sub, 2, "-"},
    OpInfo{Op::mul, 2, "*"},
    OpInfo{Op::div, 2, "/"},
    OpInfo{Op::pow, 2, "^"},
    OpInfo{Op::abs, 1, "abs"},
    OpInfo{Op::sign, 1, "sign"},
    OpInfo{Op::sqrt, 1, "sqrt"},
    OpInfo{Op::cbrt, 1, "cbrt"},
    OpInfo{Op::exp, 1, "exp"},
    OpInfo{Op::log, 1, "log"},
    OpInfo{Op::log10, 1, "log10"},
    OpInfo{Op::sin, 1, "sin"},
    OpInfo{Op::cos, 1, "cos"},
    OpInfo{Op::tan, 1, "tan"},
    OpInfo{Op::asin, 1, "asin"},
    OpInfo{Op::acos, 1, "acos"},
    OpInfo{Op::atan, 1, "atan"},
    OpInfo{Op::sinh, 1, "sinh"},
    OpInfo{Op::cosh, 1, "cosh"},
    OpInfo{Op::tanh, 1, "tanh"},
    OpInfo{Op::asinh, 1, "asinh"},
    OpInfo{Op::acosh, 1, "acosh"},
    OpInfo{Op::atanh, 1, "atanh"},
    OpInfo{Op::log1p, 1, "log1p"},
    OpInfo{Op::expm1, 1, "expm1"},
    OpInfo{Op::floor, 1, "floor"},
    OpInfo{Op::ceil, 1, "ceil"},
    OpInfo{Op::round, 1, "round"},
    OpInfo{Op::step, 1, "step"},
    OpInfo{Op::min, 2, "min"},
    OpInfo{Op::max, 2, "max"},
    OpInfo{Op::atan2, 2, "atan2"},
    OpInfo{Op::hypot, 2, "hypot"},
    OpInfo{Op::ssqrt, 2, "ssqrt"},
    OpInfo{Op::mod, 2, "mod"},
    OpInfo{Op::lt, 2, "<"},
    OpInfo{Op::le, 2, "<="},
    OpInfo{Op::gt, 2, ">"},
    OpInfo{Op::ge, 2, ">="},
    OpInfo{Op::eq, 2, "=="},
    OpInfo{Op::ne, 2, "!="},
    OpInfo{Op::logical_and, 2, "and"},
    OpInfo{Op::logical_or, 2, "or"},
    OpInfo{Op::logical_not, 1, "not"},
    OpInfo{Op::select, 3, "if"},
    OpInfo{Op::table, 1, "table"},
    OpInfo{Op::table_slope, 1, "table_slope"},
    OpInfo{Op::table_curvature, 1, "table_curvature"},
    OpInfo{Op::table_third, 1, "table_third"},
    OpInfo{Op::der, 1, "der"},
};
constexpr bool operators_in_order() {
  for (std::size_t i = 0; i < kOps.size(); ++i)
    if (kOps[i].op != static_cast<Op>(i)) return false;
  return true;
}
static_assert(operators_in_order());
static_assert(kOps.size() == static_cast<std::size_t>(Op::der) + 1);

std::size_t hash_of(const ExprNode& node) {
  std::uint64_t h = static_cast<std::uint64_t>(node.op) + 0x9E3779B97F4A7C15U;
  const auto mix = [&h](std::uint64_t word) {
    h ^= word;
    h *= 0xBF58476D1CE4E5B9U;
    h ^= h >> 29U;
  };
  mix((std::uint64_t{node.a} << 32U) | node.b);
  mix(node.c);
  mix(std::bit_cast<std::uint64_t>(node.constant));
  return h;
}

bool same(const ExprNode& l, const ExprNode& r) {
  return l.op == r.op && l.a == r.a && l.b == r.b && l.c == r.c &&
         std::bit_cast<std::uint64_t>(l.constant) == std::bit_cast<std::uint64_t>(r.constant);
}

bool same(const Table& l, const Table& r) {
  return l.delayed == r.delayed && l.inverse == r.inverse && l.column == r.column &&
         l.interpolation == r.interpolation && l.file == r.file && l.x == r.x && l.y == r.y;
}

}  // namespace

int arity(Op op) { return kOps[static_cast<std::size_t>(op)].arity; }
std::string_view name_of(Op op) { return kOps[static_cast<std::size_t>(op)].name; }

double apply(Op op, double a, double b, double c) { return apply_now(op, a, b, c); }

bool ExprPool::is_constant(ExprId id, double value) const {
  const ExprNode& node = nodes_[id.index()];
  return node.op == Op::constant && node.constant == value;
}

ExprId ExprPool::intern(const ExprNode& node) {
  if (2 * (nodes_.size() + 1) > index_.size()) {
    index_.assign(std::max<std::size_t>(64, 2 * index_.size()), ExprId::kNone);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      std::size_t at = hash_of(nodes_[i]) & (index_.size() - 1);
      while (index_[at] != ExprId::kNone) at = (at + 1) & (index_.size() - 1);
      index_[at] = static_cast<std::uint32_t>(i);
    }
  }
  std::size_t at = hash_of(node) & (index_.size() - 1);
  while (index_[at] != ExprId::kNone) {
    if (same(nodes_[index_[at]], node)) return ExprId(index_[at]);
    at = (at + 1) & (index_.size() - 1);
  }
  if (nodes_.size() >= ExprId::kNone) throw std::length_error("more than 2^32 - 1 different expressions");
  index_[at] = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back(node);
  return ExprId(nodes_.size() - 1);
}

TableId ExprPool::add_table(Table table) {
  for (std::size_t i = 0; i < tables_.size(); ++i)
    if (same(*tables_[i], table)) return TableId(i);
  if (table.interpolation == Interpolation::spline && table.slope2.size() != table.x.size()) prepare_spline(table);
  tables_.push_back(std::make_shared<const Table>(std::move(table)));
  return TableId(tables_.size() - 1);
}

TableId ExprPool::add_table(const std::shared_ptr<const Table>& table) {
  for (std::size_t i = 0; i < tables_.size(); ++i)
    if (tables_[i] == table || same(*tables_[i], *table)) return TableId(i);
  tables_.push_back(table);
  return TableId(tables_.size() - 1);
}

std::vector<ExprId> reachable(const ExprPool& pool, std::span<const ExprId> roots) {
  std::vector<ExprId> found;
  IdMap<char> seen;
  for (const ExprId root : roots)
    if (seen.insert(root, 1)) found.push_back(root);
  for (std::size_t next = 0; next < found.size(); ++next)
    for_each_argument(pool[found[next]], [&](ExprId a) {
      if (seen.insert(a, 1)) found.push_back(a);
    });
  std::sort(found.begin(), found.end());  // children have smaller ids
  return found;
}

std::vector<SymbolId> symbols_in(const ExprPool& pool, std::span<const ExprId> roots) {
  std::vector<SymbolId> symbols;
  for (const ExprId id : reachable(pool, roots))
    if (pool.is_symbol(id)) symbols.push_back(pool.symbol_of(id));
  std::sort(symbols.begin(), symbols.end());
  return symbols;
}

double evaluate(const ExprPool& pool, ExprId root, std::span<const double> symbol_values) {
  const std::vector<ExprId> nodes = reachable(pool, {&root, 1});
  IdMap<double> values;
  double value = kNaN;
  for (const ExprId id : nodes) {
    const ExprNode& node = pool[id];
    std::array<double, 3> x{};
    std::size_t n = 0;
    for_each_argument(node, [&](ExprId a) { x[n++] = *values.find(a); });
    if (node.op == Op::constant)
      value = node.constant;
    else if (node.op == Op::symbol)
      value = node.a < symbol_values.size() ? symbol_values[node.a] : kNaN;
    else if (is_table(node.op))
      value = apply_table(node.op, pool.table(TableId(node.b)), x[0]);
    else
      value = apply(node.op, x[0], x[1], x[2]);
    values.insert(id, value);
  }
  return value;
}

ExprId substitute(ExprPool& pool, ExprId root, const std::unordered_map<SymbolId, ExprId>& replacement) {
  IdMap<ExprId> memo;
  ExprId result = root;
  for (const ExprId id : reachable(pool, {&root, 1})) {
    const ExprNode node = pool[id];  // a copy: the pool grows
    result = id;
    if (node.op == Op::symbol) {
      const auto found = replacement.find(SymbolId(node.a));
      if (found != replacement.end() && found->second.valid()) result = found->second;
    } else {
      bool changed = false;
      for_each_argument(node, [&](ExprId a) { changed = changed || *memo.find(a) != a; });
      if (changed) result = rebuilt(pool, node, [&](ExprId a) { return *memo.find(a); });
    }
    memo.insert(id, result);
  }
  return result;
}

Translator::Translator(const ExprPool& from, ExprPool& to, std::function<ExprId(SymbolId)> replace,
                       std::function<ExprId(ExprId)> on_der)
    : from_(from), to_(to), replace_(std::move(replace)), on_der_(std::move(on_der)) {}

ExprId Translator::operator()(ExprId expression) {
  const auto memo = [this](ExprId id) -> ExprId { return id.index() < memo_.size() ? memo_[id.index()] : ExprId(); };
  arguments_first(
      from_, expression, [&](ExprId id) { return memo(id).valid(); },
      [&](ExprId id) {
        const ExprNode node = from_[id];  // a copy: both pools may be one
        ExprId image;
        if (node.op == Op::symbol) {
          image = replace_(SymbolId(node.a));
        } else if (node.op == Op::der && on_der_) {
          image = on_der_(memo(ExprId(node.a)));
        } else if (is_table(node.op)) {
          if (tables_.size() <= node.b) tables_.resize(node.b + 1);
          if (!tables_[node.b].valid()) tables_[node.b] = to_.add_table(from_.tables()[node.b]);
          image = to_.table(node.op, memo(ExprId(node.a)), tables_[node.b]);
        } else {
          image = rebuilt(to_, node, memo);
        }
        if (!image.valid()) throw std::logic_error("Translator: a symbol or derivative has no replacement");
        if (memo_.size() < from_.size()) memo_.resize(from_.size());
        memo_[id.index()] = image;
      });
  return memo(expression);
}

}  // namespace bgsim
