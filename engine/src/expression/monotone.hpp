/// Expressions with kinks, cut into smooth parts whose directions are proven.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "expression/graph.hpp"
#include "expression/interval.hpp"
#include "expression/pieces.hpp"

namespace bgsim {

/// Which way an expression goes over a range of x.
enum class Way : std::uint8_t { constant, rising, falling, unknown };

/// A smooth part of an expression, and the range of x in which it holds.
struct Part {
  ExprId expression;
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  ExprId low_border, high_border;  ///< where the ends are finite
};

/// An expression over a range: what it is at both ends, and how it goes between them.
struct Course {
  double low = std::numeric_limits<double>::quiet_NaN(), high = std::numeric_limits<double>::quiet_NaN();
  Way way = Way::unknown;
  Range range{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};  ///< of its values
};

/// Cuts expressions of one symbol, with numbers for all others.
class Cutter {
 public:
  Cutter(ExprPool& pool, SymbolId x, const NumberOf& number) : pool_(pool), x_(x), number_(number) {}

  /// Parts by increasing x; none if the expression cannot be cut into smooth ones.
  std::vector<Part> cut(ExprId expression);
  /// Whether the parts meet and go the same way throughout; constant or unknown if not.
  Way way(const std::vector<Part>& parts);
  /// Of an expression without kinks over the range of a part.
  Way way_of(const Part& part);

  /// The value at @p x.
  [[nodiscard]] double at(ExprId root, double x) const;
  /// A point of a part, 0 < share < 1.
  [[nodiscard]] static double inside(const Part& part, double share);
  /// By position in @p nodes: whether it depends on x.
  [[nodiscard]] std::vector<char> with_x(const std::vector<ExprId>& nodes) const;
  /// The symbols without a number.
  [[nodiscard]] std::vector<SymbolId> varying(ExprId expression) const;

 private:
  [[nodiscard]] std::optional<ExprId> first_decision(ExprId root) const;
  [[nodiscard]] bool hidden_kink(ExprId root) const;
  bool limit_to_data(Part& part);
  bool divide(const Part& part, ExprId decision, std::vector<Part>& open);
  bool zero_of(ExprId guard, ExprId& border, double& root);
  ExprId branch_of(const ExprNode& node, double guard);
  Part with_branch(const Part& part, ExprId decision, ExprId branch);
  [[nodiscard]] bool meet(const Part& lower, const Part& upper) const;
  Way way_by_slope(ExprId expression, double low, double high);

  ExprPool& pool_;
  SymbolId x_;
  const NumberOf& number_;
};

/// The value of an expression; @p number gives those of its symbols.
double value_of(const ExprPool& pool, ExprId root, const NumberOf& number);

}  // namespace bgsim
