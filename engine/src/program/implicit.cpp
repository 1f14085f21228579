#include "program/implicit.hpp"

#include "expression/graph.hpp"
#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

bool two_sided(const Relation& relation) {
  return relation.kind == Relation::Kind::sign || relation.kind == Relation::Kind::step ||
         (relation.kind == Relation::Kind::condition && !relation.time_only);
}

class ImplicitEquations {
 public:
  ImplicitEquations(Program& program, const std::vector<ExprId>& rates) : program_(program) {
    const auto slot_of = [&](std::size_t slot) {
      return program.pool.symbol_of(program.slot_expression[slot]).index();
    };
    kind_.resize(program.symbol_names.size());
    kind_[slot_of(program.time_slot)] = {Kind::time, 0};
    for (std::uint32_t slot = program.first_state; slot < program.first_tear; ++slot)
      kind_[slot_of(slot)] = {Kind::state, slot - program.first_state};
    for (std::uint32_t slot = program.first_tear; slot < program.first_mode; ++slot)
      kind_[slot_of(slot)] = {Kind::tear, slot - program.first_tear};
    for (std::uint32_t i = 0; i < program.relations.size(); ++i)
      if (can_rest(program, i)) kind_[slot_of(program.first_mode + i)] = {Kind::mode, i};
    for (const ExprId rate : rates) rates_.push_back(straightened(rate));
  }

  /// With the slopes by what it is solved for.
  ImplicitEquation solved(ExprId value) {
    ImplicitEquation equation{value, {}, {}};
    for (const auto& [symbol, partial] : gradient(program_.pool, value, [this](SymbolId s) {
           return kind(s).what == Kind::tear || kind(s).what == Kind::mode;
         }))
      (kind(symbol).what == Kind::tear ? equation.by_tears : equation.by_modes)
          .emplace_back(kind(symbol).which, partial);
    return equation;
  }

  /// How fast a guard of states and time moves. Not valid for one that a loop moves.
  ExprId rate_of(ExprId guard) {
    ExprPool& pool = program_.pool;
    ExprId rate = pool.constant(0.0);
    for (const auto& [symbol, partial] : gradient(
             pool, guard, [this](SymbolId s) { return kind(s).what != Kind::other && kind(s).what != Kind::mode; })) {
      if (kind(symbol).what == Kind::tear) return {};
      rate = pool.add(rate, kind(symbol).what == Kind::time ? partial : pool.mul(partial, rates_[kind(symbol).which]));
    }
    return rate;
  }

  /// With straight lines between the two sides of conditions that can be held: as a held mode is evaluated.
  ExprId straightened(ExprId root) {
    ExprPool& pool = program_.pool;
    arguments_first(
        pool, root, [this](ExprId e) { return e.index() < straight_.size() && straight_[e.index()].valid(); },
        [&](ExprId e) {
          const ExprNode node = pool[e];  // a copy: the pool grows
          bool same = true;
          for_each_argument(node, [&](ExprId a) { same = same && straight_[a.index()] == a; });
          ExprId image = same ? e : rebuilt(pool, node, [this](ExprId a) { return straight_[a.index()]; });
          if (const ExprNode made = pool[image]; made.op == Op::select && is_mode(ExprId(made.a)))
            image = pool.add(ExprId(made.c), pool.mul(ExprId(made.a), pool.sub(ExprId(made.b), ExprId(made.c))));
          straight_.resize(std::max(straight_.size(), pool.size()));
          straight_[e.index()] = image;
        });
    return straight_[root.index()];
  }

 private:
  enum class Kind : std::uint8_t { other, time, state, tear, mode };
  struct Symbol {
    Kind what = Kind::other;
    std::uint32_t which = 0;
  };
  [[nodiscard]] const Symbol& kind(SymbolId symbol) const { return kind_[symbol.index()]; }
  [[nodiscard]] bool is_mode(ExprId e) const {
    return program_.pool[e].op == Op::symbol && kind(program_.pool.symbol_of(e)).what == Kind::mode;
  }

  Program& program_;
  std::vector<Symbol> kind_;  ///< by SymbolId
  std::vector<ExprId> rates_, straight_;
};

}  // namespace

bool can_rest(const Program& program, std::uint32_t relation) {
  const Relation& at = program.relations[relation];
  if (!two_sided(at) || !at.where.element.valid()) return false;
  return is_resistor(program.model->elements[at.where.element.index()].kind);
}

void add_implicit_equations(Program& program, const std::vector<ExprId>& rates,
                            const std::vector<std::vector<ExprId>>& residuals) {
  bool any = false;
  for (const std::uint32_t relation : program.guarded) any = any || can_rest(program, relation);
  if (!any) return;
  ImplicitEquations equations(program, rates);
  program.border_rates.resize(program.relations.size());
  for (const std::uint32_t relation : program.guarded) {
    if (!can_rest(program, relation)) continue;
    const ExprId rate = equations.rate_of(program.relations[relation].guard);
    if (rate.valid()) program.border_rates[relation] = equations.solved(rate);
  }
  for (const std::vector<ExprId>& block : residuals)
    for (const ExprId residual : block)
      program.loop_equations.push_back(equations.solved(equations.straightened(residual)));
  program.origins.resize(program.pool.size());
}

}  // namespace bgsim
