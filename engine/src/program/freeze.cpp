#include "program/freeze.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "expression/graph.hpp"
#include "model/samples.hpp"
#include "program/own_borders.hpp"

namespace bgsim {
namespace {

ExprId rebuild(ExprPool& pool, const ExprNode& node, const std::vector<ExprId>& of,
               const std::vector<TableId>& tables) {
  if (is_table(node.op)) return pool.table(node.op, of[node.a], tables[node.b]);
  switch (arity(node.op)) {
    case 1:
      return pool.make(node.op, of[node.a]);
    case 2:
      return pool.make(node.op, of[node.a], of[node.b]);
    default:
      return pool.select(of[node.a], of[node.b], of[node.c]);
  }
}

/// exp(u) - 1 as expm1(u) and log(1 + u) as log1p(u): the same numbers, but exact to rounding for small u, where a
/// diode at rest is. A law that writes 1e-9*(exp(e/Vt) - 1) gives nothing but 0 below e = 1e-16*Vt otherwise.
ExprId exact_near_zero(ExprPool& pool, const ExprNode& node, const std::vector<ExprId>& of) {
  const auto is = [&pool](ExprId e, Op op) { return pool[e].op == op; };
  const auto expm1_of = [&pool](ExprId e) { return pool.make(Op::expm1, ExprId(pool[e].a)); };
  if (node.op == Op::sub || node.op == Op::add) {
    const ExprId a = of[node.a], b = of[node.b];
    const double one = node.op == Op::sub ? 1.0 : -1.0;
    if (is(a, Op::exp) && pool.is_constant(b, one)) return expm1_of(a);
    if (node.op == Op::add && is(b, Op::exp) && pool.is_constant(a, one)) return expm1_of(b);
    if (node.op == Op::sub && is(b, Op::exp) && pool.is_constant(a, one)) return pool.neg(expm1_of(b));
  }
  if (node.op == Op::log) {
    const ExprNode argument = pool[of[node.a]];
    if (argument.op == Op::add) {
      if (pool.is_constant(ExprId(argument.a), 1.0)) return pool.make(Op::log1p, ExprId(argument.b));
      if (pool.is_constant(ExprId(argument.b), 1.0)) return pool.make(Op::log1p, ExprId(argument.a));
    }
    if (argument.op == Op::sub && pool.is_constant(ExprId(argument.a), 1.0))
      return pool.make(Op::log1p, pool.neg(ExprId(argument.b)));
  }
  return {};
}

/// Between which arguments an operator has a value, where it has a finite one at both.
std::optional<std::pair<double, double>> ends_of_law(Op op, const Table* table) {
  constexpr double kNoEnd = std::numeric_limits<double>::infinity();
  if (table != nullptr) {
    if (table->delayed) return std::nullopt;
    return std::pair(table->x.front(), table->x.back());
  }
  if (op == Op::sqrt || op == Op::pow) return std::pair(0.0, kNoEnd);
  if (op == Op::acosh) return std::pair(1.0, kNoEnd);
  if (op == Op::asin || op == Op::acos) return std::pair(-1.0, 1.0);
  return std::nullopt;
}

Relation relation_of(Relation::Kind kind, ExprId guard, Op comparison = Op::lt, TableId table = {}) {
  Relation relation;
  relation.kind = kind;
  relation.guard = guard;
  relation.comparison = comparison;
  relation.table = table;
  return relation;
}

}  // namespace

Freezer::Freezer(const EquationSystem& system, const BlockOrder& order, Program& program)
    : system_(system),
      order_(order),
      program_(program),
      frozen_(order.pool.size()),
      plain_(order.pool.size()),
      variation_(order.pool.size(), unknown) {
  for (const SystemSymbol& symbol : system.symbols) program.symbol_names.push_back(symbol.name);
  for (const auto& table : order.pool.tables()) tables_.push_back(program.pool.add_table(table));
}

ExprId Freezer::operator()(ExprId expression) {
  arguments_first(
      order_.pool, expression, [this](ExprId e) { return frozen_[e.index()].valid(); },
      [this](ExprId e) {
        const ExprNode& node = order_.pool[e];
        Variation most = node.op == Op::symbol ? Variation::state : Variation::fixed;
        if (node.op == Op::symbol) {
          const SystemSymbol::Kind kind = system_.symbols[SymbolId(node.a).index()].kind;
          if (kind == SystemSymbol::Kind::parameter) most = Variation::fixed;
          if (kind == SystemSymbol::Kind::time) most = Variation::time_only;
        }
        for_each_argument(node, [&](ExprId argument) { most = std::max(most, variation_[argument.index()]); });
        variation_[e.index()] = most;
        plain_[e.index()] = copy_plain(e);
        frozen_[e.index()] = copy(e);
        program_.origins.resize(program_.pool.size(), order_.origins[e.index()]);
      });
  return frozen_[expression.index()];
}

ExprId Freezer::plain(ExprId expression) {
  (*this)(expression);
  return plain_[expression.index()];
}

ExprId Freezer::copy_plain(ExprId expression) {
  const ExprNode& node = order_.pool[expression];
  if (node.op == Op::constant) return program_.pool.constant(node.constant);
  if (node.op == Op::symbol) return program_.pool.symbol(SymbolId(node.a));
  return rebuild(program_.pool, node, plain_, tables_);
}

ExprId Freezer::copy(ExprId expression) {
  const ExprNode& node = order_.pool[expression];
  if (node.op == Op::constant || node.op == Op::symbol) return plain_[expression.index()];
  if (variation(expression) == Variation::fixed) return rebuild(program_.pool, node, frozen_, tables_);
  if (is_inequality(node.op)) return freeze_comparison(expression);
  const ExprId argument = frozen_[node.a];
  if (node.op == Op::sign) return freeze(expression, relation_of(Relation::Kind::sign, of_same_sign(ExprId(node.a))));
  if (node.op == Op::step) return freeze(expression, relation_of(Relation::Kind::step, of_same_sign(ExprId(node.a))));
  if (node.op == Op::floor) return freeze(expression, relation_of(Relation::Kind::floor, argument));
  if (node.op == Op::round) return freeze(expression, relation_of(Relation::Kind::round, argument));
  if (node.op == Op::ceil) return freeze_ceil(expression);
  if (node.op == Op::mod) return freeze_mod(expression);
  if (is_table(node.op)) {
    const TableId table = tables_[node.b];
    const auto key = cell_key(argument, table);
    if (program_.pool.table(table).interpolation == Interpolation::linear && !cells_.contains(key)) {
      cells_[key] = static_cast<std::uint32_t>(program_.relations.size());
      freeze(expression, relation_of(Relation::Kind::cell, argument, Op::lt, table));
    }
  }
  if (const ExprId kept = continued(expression); kept.valid()) return kept;
  if (const ExprId exact = exact_near_zero(program_.pool, node, frozen_); exact.valid()) return exact;
  return rebuild(program_.pool, node, frozen_, tables_);
}

/// ceil(a) = -floor(-a), exactly.
ExprId Freezer::freeze_ceil(ExprId expression) {
  const ExprNode& node = order_.pool[expression];
  ExprPool& pool = program_.pool;
  Relation relation = relation_of(Relation::Kind::floor, pool.neg(frozen_[node.a]));
  relation.origin = pool.make(Op::floor, pool.neg(plain_[node.a]));
  relation.negated = true;
  program_.origins.resize(pool.size(), order_.origins[expression.index()]);
  return pool.neg(freeze(expression, std::move(relation)));
}

/// mod(a, b) = a - b*floor(a/b), of which the floor is frozen.
ExprId Freezer::freeze_mod(ExprId expression) {
  const ExprNode& node = order_.pool[expression];
  ExprPool& pool = program_.pool;
  const ExprId a = frozen_[node.a], b = frozen_[node.b];
  if (pool.is_constant(b, 0.0)) return rebuild(pool, node, frozen_, tables_);  // which has no value, and says so
  Relation relation = relation_of(Relation::Kind::floor, pool.div(a, b));
  relation.origin = pool.make(Op::floor, pool.div(plain_[node.a], plain_[node.b]));
  program_.origins.resize(pool.size(), order_.origins[expression.index()]);
  return pool.sub(a, pool.mul(b, freeze(expression, std::move(relation))));
}

/// A law that ends where what it reads has its border: a spline table of one turn at mod(angle, 1), sqrt(1 - mod(x,
/// 1)). Within a step the floor is frozen, so a trial point beyond its border asks for values outside of the law, where
/// none of the run's points lies: as little as a rounding of it is enough. There the law keeps the value of its end, so
/// that the step has an end and the event is found within it. Where the modes hold nothing is changed: what is read
/// outside there is a mistake of the model.
/// @return  none if no mode has borders that it could be read beyond
ExprId Freezer::continued(ExprId expression) {
  const ExprNode& node = order_.pool[expression];
  ExprPool& pool = program_.pool;
  const Table* table = is_table(node.op) ? &pool.table(tables_[node.b]) : nullptr;
  const auto ends = ends_of_law(node.op, table);
  if (!ends) return {};
  ExprId off = off_modes(ExprId(node.a));
  if (node.op == Op::pow) {
    const ExprNode& exponent = pool[frozen_[node.b]];
    if (exponent.op == Op::constant && exponent.constant == std::round(exponent.constant)) return {};
    off = either(off, off_modes(ExprId(node.b)));
  }
  if (!off.valid()) return {};
  const auto law = [&](ExprId at) {
    if (table != nullptr) return pool.table(node.op, at, tables_[node.b]);
    return node.op == Op::pow ? pool.pow(at, frozen_[node.b]) : pool.make(node.op, at);
  };
  const ExprId argument = frozen_[node.a], within = law(argument);
  ExprId value = within;
  const auto keep = [&](Op outside, double end) {
    const ExprId at = pool.constant(end);
    value = pool.select(pool.make(Op::logical_and, off, pool.make(outside, argument, at)), law(at), value);
    program_.continued.emplace(value.value, within);
  };
  keep(Op::lt, ends->first);
  if (std::isfinite(ends->second)) keep(Op::gt, ends->second);
  return value;
}

/// Whether one of the modes with borders that a frozen value follows is not that of the point; none if it follows none.
ExprId Freezer::off_modes(ExprId expression) {
  arguments_first(
      order_.pool, expression, [this](ExprId e) { return off_modes_.contains(e.value); },
      [this](ExprId e) {
        const ExprNode& node = order_.pool[e];
        ExprId all;
        if (variation(e) != Variation::fixed) all = own_off_mode(e);
        // What a relation reads has no part in its value.
        const bool is_mode =
            is_comparison(node.op) || is_rounding(node.op) || node.op == Op::sign || node.op == Op::step;
        if (!is_mode)
          for_each_argument(node, [&](ExprId argument) { all = either(all, off_modes_.at(argument.value)); });
        off_modes_.emplace(e.value, all);
      });
  return off_modes_.at(expression.value);
}

ExprId Freezer::own_off_mode(ExprId expression) {
  const ExprNode& node = order_.pool[expression];
  ExprPool& pool = program_.pool;
  const ExprId one = pool.constant(1.0), half = pool.constant(0.5), zero = pool.constant(0.0);
  const ExprId value = frozen_[expression.index()];
  switch (node.op) {
    case Op::floor:
      return either(pool.make(Op::lt, frozen_[node.a], value),
                    pool.make(Op::ge, frozen_[node.a], pool.add(value, one)));
    case Op::ceil:
      return either(pool.make(Op::gt, frozen_[node.a], value),
                    pool.make(Op::le, frozen_[node.a], pool.sub(value, one)));
    case Op::round:
      return either(pool.make(Op::lt, frozen_[node.a], pool.sub(value, half)),
                    pool.make(Op::gt, frozen_[node.a], pool.add(value, half)));
    case Op::mod: {
      // By the remainder: where a/b rounds to its border that may be below 0, although the mode is that of a/b.
      const ExprId part = pool.div(value, frozen_[node.b]);
      return either(pool.make(Op::lt, part, zero), pool.make(Op::ge, part, one));
    }
    default:
      return is_table(node.op) ? off_cell(frozen_[node.a], tables_[node.b]) : ExprId{};
  }
}

/// The same of the cell of a linear table, but for the data's own ends: beyond them a read is a mistake.
ExprId Freezer::off_cell(ExprId argument, TableId table) {
  const std::uint32_t relation = cell_relation(argument, table);
  if (relation == kNoSlot) return {};
  ExprPool& pool = program_.pool;
  auto found = borders_.find(table.value);
  if (found == borders_.end()) {
    constexpr double kNone = 1e300;
    const std::vector<double> x = pool.table(table).x;
    Table lower, upper;  // by the number of the cell
    for (std::size_t k = 0; k < x.size(); ++k) {
      lower.x.push_back(static_cast<double>(k));
      upper.x.push_back(static_cast<double>(k));
      lower.y.push_back(k == 0 ? -kNone : x[k]);
      upper.y.push_back(k + 2 < x.size() ? x[k + 1] : kNone);
    }
    const TableId low = pool.add_table(std::move(lower)), high = pool.add_table(std::move(upper));
    found = borders_.emplace(table.value, std::pair(low, high)).first;
  }
  const ExprId cell = pool.symbol(modes_[relation]);
  return either(pool.make(Op::lt, argument, pool.table(Op::table, cell, found->second.first)),
                pool.make(Op::ge, argument, pool.table(Op::table, cell, found->second.second)));
}

/// Left or right, of which each may be missing.
ExprId Freezer::either(ExprId left, ExprId right) {
  if (!left.valid() || left == right) return right;
  return right.valid() ? program_.pool.make(Op::logical_or, left, right) : left;
}

ExprId Freezer::freeze_comparison(ExprId expression) {
  const ExprNode& node = order_.pool[expression];
  const auto is_zero = [this](std::uint32_t e) { return order_.pool.is_constant(ExprId(e), 0.0); };
  const ExprId guard = is_zero(node.b)   ? of_same_sign(ExprId(node.a))
                       : is_zero(node.a) ? program_.pool.neg(of_same_sign(ExprId(node.b)))
                                         : program_.pool.sub(frozen_[node.a], frozen_[node.b]);
  return freeze(expression, relation_of(Relation::Kind::condition, guard, node.op));
}

/// Frozen, with a*b for quotients a/b of what varies. A quotient has no bound where b comes to 0: what rests at its
/// border there, at a value that is nothing but rounding, would be let far away from it when b grows again.
ExprId Freezer::of_same_sign(ExprId expression) {
  ExprPool& pool = program_.pool;
  std::vector<ExprId> left{expression}, factors, divisors;
  bool negative = false, quotient = false;
  while (!left.empty()) {
    const ExprId e = left.back();
    left.pop_back();
    const ExprNode& node = order_.pool[e];
    const bool is_fixed = variation(e) == Variation::fixed;
    if (!is_fixed && node.op == Op::neg) {
      negative = !negative;
      left.push_back(ExprId(node.a));
    } else if (!is_fixed && (node.op == Op::mul || node.op == Op::div)) {
      const bool by_fixed = node.op == Op::div && variation(ExprId(node.b)) == Variation::fixed;
      quotient = quotient || (node.op == Op::div && !by_fixed);
      if (by_fixed)
        divisors.push_back(frozen_[node.b]);
      else
        left.push_back(ExprId(node.b));
      left.push_back(ExprId(node.a));
    } else {
      factors.push_back(frozen_[e.index()]);
    }
  }
  if (!quotient) return frozen_[expression.index()];
  ExprId product = factors.front();
  for (std::size_t i = 1; i < factors.size(); ++i) product = pool.mul(product, factors[i]);
  for (const ExprId divisor : divisors) product = pool.div(product, divisor);
  return negative ? pool.neg(product) : product;
}

ExprId Freezer::freeze(ExprId expression, Relation relation) {
  if (!relation.origin.valid()) relation.origin = plain_[expression.index()];
  relation.time_only = variation(expression) == Variation::time_only;
  if (relation.kind != Relation::Kind::denominator) relation.where = order_.origins[expression.index()];
  const auto name = [this](SymbolId symbol) { return program_.symbol_names[symbol.index()]; };
  if (!own_borders_) own_borders_ = own_borders(program_, program_.pool);
  const ExprId plain = plain_[expression.index()];
  relation.text = readable_text(program_.pool,
                                own_borders_->empty() ? plain : substitute(program_.pool, plain, *own_borders_), name);
  if (relation.time_only)
    for (const ExprId e : reachable(program_.pool, std::array{relation.origin}))
      relation.samples = relation.samples || program_.pool.is_constant(e, kSamplesEarly);
  const SymbolId mode(program_.symbol_names.size());
  program_.symbol_names.push_back("mode of " + relation.text);
  modes_.push_back(mode);
  program_.relations.push_back(std::move(relation));
  return program_.pool.symbol(mode);
}

void Freezer::watch(const DenominatorFactor& denominator) {
  const ExprId factor = (*this)(denominator.factor);
  Relation relation = relation_of(Relation::Kind::denominator, factor);
  relation.origin = program_.pool.make(Op::sign, plain_[denominator.factor.index()]);
  program_.origins.resize(program_.pool.size(), denominator.where);
  relation.structural = denominator.structural;
  relation.where = denominator.where;
  freeze(denominator.factor, std::move(relation));
  program_.origins.resize(program_.pool.size(), denominator.where);
}

std::uint32_t Freezer::cell_relation(ExprId argument, TableId table) const {
  const auto found = cells_.find(cell_key(argument, table));
  return found == cells_.end() ? kNoSlot : found->second;
}

}  // namespace bgsim
