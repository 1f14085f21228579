/// The linear system over units: unknowns are logarithms of units, and each equation knows where it comes from.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "bgsim/unit.hpp"

namespace bgsim {

/// constant * product of variables to their powers; or free: whatever is wanted.
struct UnitForm {
  std::vector<std::pair<std::uint32_t, double>> terms;  ///< by increasing variable
  Unit constant;
};
UnitForm operator*(const UnitForm& a, const UnitForm& b);
UnitForm operator/(const UnitForm& a, const UnitForm& b);
UnitForm power(const UnitForm& form, double exponent);

/// A contradiction: the equation that does not hold, and all that its two sides rest on.
struct UnitContradiction {
  std::uint32_t equation = 0;            ///< the one at which it was found
  std::vector<std::uint32_t> equations;  ///< this one and those behind it, nearest first
};

/// Equations `form is a pure number`, solved by propagation and, for what remains, by Gauss-Jordan elimination.
///
/// Propagation takes equations with one unknown, those with the fewest steps behind them first; most models need no
/// more. Rows that remain have two unknowns or more and are eliminated, shortest first, each by its rarest unknown.
class UnitSystem {
 public:
  std::uint32_t add_variable();
  /// @param depth  steps that are counted as behind it from the start: what says less than others comes later.
  /// @return the equation's number: 0, 1, 2, ...
  std::uint32_t add_equation(UnitForm form, std::uint32_t depth = 0);

  /// Solves all equations. Once.
  void solve();
  /// After solve(): uses an equation that is not known to hold, unless it contradicts the others or would give a unit
  /// that is not made of SI units alone.
  /// @return false if it contradicts them.
  bool add_wish(const UnitForm& form);

  [[nodiscard]] std::optional<Unit> value(std::uint32_t variable) const { return variables_[variable].value; }
  [[nodiscard]] std::optional<Unit> value(const UnitForm& form) const;
  /// The equations that a variable's value rests on, nearest first.
  [[nodiscard]] std::vector<std::uint32_t> reasons(std::uint32_t variable) const;
  [[nodiscard]] const UnitForm& form(std::uint32_t equation) const { return rows_[equation].form; }
  [[nodiscard]] std::size_t equations() const { return equations_; }
  /// The first 200: each costs a search for what is behind it.
  [[nodiscard]] const std::vector<UnitContradiction>& contradictions() const { return contradictions_; }
  /// False if the elimination was given up since it grew too large.
  [[nodiscard]] bool complete() const { return complete_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffU;
  static constexpr std::size_t kMostContradictions = 200;
  struct Row {
    UnitForm form;
    std::uint32_t unknown = 0;                         ///< variables without a value
    std::uint32_t depth = 0;                           ///< steps behind the values of its variables
    std::uint32_t parent_a = kNone, parent_b = kNone;  ///< rows that it was combined from
    std::uint32_t made = 0;                            ///< when, by clock_
    std::uint32_t pivot = kNone;                       ///< the variable that it is solved for
    bool settled = false;                              ///< has been used or found to hold
    bool replaced = false;                             ///< by a combination
  };
  struct Variable {
    std::optional<Unit> value;
    std::uint32_t reason = kNone;  ///< the row that gave the value
    std::uint32_t since = 0;       ///< when, by clock_
    std::uint32_t pivot = kNone;   ///< the row that is solved for it
    std::vector<std::uint32_t> rows;
  };

  std::uint32_t add_row(Row row);
  void ready(std::uint32_t row);
  void propagate();
  void settle(std::uint32_t number);
  void eliminate();
  void pivot_on(std::uint32_t number);
  [[nodiscard]] std::uint32_t rarest_unknown(const Row& row) const;
  [[nodiscard]] UnitForm reduced(const UnitForm& form) const;
  [[nodiscard]] UnitForm reduced_known(const UnitForm& form) const;
  [[nodiscard]] std::vector<std::uint32_t> behind(std::uint32_t row) const;

  std::vector<Row> rows_;
  std::vector<Variable> variables_;
  std::vector<std::uint64_t> heap_;  ///< rows with at most one unknown, by depth, then number
  std::vector<UnitContradiction> contradictions_;
  std::uint32_t equations_ = 0;  ///< rows below this number are equations, the others combinations and wishes
  std::uint32_t clock_ = 1;
  std::size_t budget_ = 0;  ///< terms that the elimination may still write
  bool complete_ = true;
};

}  // namespace bgsim
