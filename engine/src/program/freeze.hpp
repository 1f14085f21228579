/// Freezing: relations become modes, so that expressions are smooth between events.
#pragma once

#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bgsim/program.hpp"
#include "program/denominators.hpp"

namespace bgsim {

/// Copies expressions of a BlockOrder into a program's pool, each relation that varies in time replaced by a mode
/// symbol.
class Freezer {
 public:
  /// Fills program.pool, .origins, .relations, .symbol_names (modes) as it goes.
  Freezer(const EquationSystem& system, const BlockOrder& order, Program& program);

  /// The frozen expression. Cost proportional to what is new.
  ExprId operator()(ExprId expression);

  /// The same expression in the program's pool, not frozen.
  ExprId plain(ExprId expression);

  /// Has the factor of a denominator watched.
  void watch(const DenominatorFactor& denominator);

  /// Whether a frozen expression varies with time, and with nothing else.
  [[nodiscard]] bool follows_time(ExprId expression) const { return variation(expression) == Variation::time_only; }

  /// Symbols of the modes, by relation.
  [[nodiscard]] const std::vector<SymbolId>& modes() const { return modes_; }
  /// The relation that holds the cell of a linear table read at this (frozen) argument, if it has one.
  [[nodiscard]] std::uint32_t cell_relation(ExprId argument, TableId table) const;

 private:
  enum Variation : std::uint8_t { unknown, fixed, time_only, state };
  Variation variation(ExprId expression) const { return variation_[expression.index()]; }
  ExprId copy(ExprId expression);
  ExprId copy_plain(ExprId expression);
  ExprId freeze(ExprId expression, Relation relation);
  ExprId freeze_comparison(ExprId expression);
  ExprId freeze_ceil(ExprId expression);
  ExprId freeze_mod(ExprId expression);
  ExprId of_same_sign(ExprId expression);
  ExprId continued(ExprId expression);
  ExprId off_modes(ExprId expression);
  ExprId own_off_mode(ExprId expression);
  ExprId off_cell(ExprId argument, TableId table);
  ExprId either(ExprId left, ExprId right);
  static std::uint64_t cell_key(ExprId argument, TableId table) {
    return (std::uint64_t{argument.value} << 32U) | table.value;
  }

  const EquationSystem& system_;
  const BlockOrder& order_;
  Program& program_;
  std::vector<ExprId> frozen_, plain_;  ///< by ExprId of the order's pool
  std::vector<Variation> variation_;
  std::unordered_map<std::uint32_t, ExprId> off_modes_;  ///< by ExprId of the order's pool, where it was asked for
  std::optional<std::unordered_map<SymbolId, ExprId>> own_borders_;  ///< looked for once
  std::vector<SymbolId> modes_;
  std::vector<TableId> tables_;
  std::unordered_map<std::uint64_t, std::uint32_t> cells_;
  std::unordered_map<std::uint32_t, std::pair<TableId, TableId>> borders_;  ///< by linear table, of its cells
};

}  // namespace bgsim
