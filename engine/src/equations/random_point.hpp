/// Expressions at random values, by which one sees what cancels and what depends on what.
#pragma once

#include <cstdint>
#include <vector>

#include "bgsim/equations.hpp"

namespace bgsim {

/// Values and slopes of expressions at random values of states, parameters, time and all that is no sum, product or
/// quotient. The slopes are those along a random direction of what is indefinite. What cancels for such values cancels
/// for all. Rings of equations ask for values and slopes before they are known: these are found so that they come out
/// as they were taken, by one step of Newton's method each, since what is linear needs no more. Where slopes do not,
/// all depends on all that it is connected with.
///
/// Cost: some passes over the pool, and one more for each value that a ring asks for, up to sixty.
class RandomPoint {
 public:
  /// @param indefinite  unknowns that may have any value, whatever their equations say
  RandomPoint(const EquationSystem& system, const std::vector<SymbolId>& indefinite);

  /// Whether the unknown is 0 for all values.
  [[nodiscard]] bool is_zero(SymbolId unknown) const;
  /// Whether the expression (none: no) depends on anything indefinite.
  [[nodiscard]] bool depends(ExprId e) const;

 private:
  struct Point {
    double value = 0.0, slope = 0.0;
    double size = 0.0, slope_size = 0.0;  ///< sums of the magnitudes of all terms
  };

  void find_reaching();
  void solve_rings(double Point::*what, std::vector<double>& guess);
  [[nodiscard]] bool slopes_agree() const;
  void evaluate_all();
  [[nodiscard]] bool is_indefinite(const ExprNode& node) const;
  [[nodiscard]] const Equation* equation(const ExprNode& node) const;
  [[nodiscard]] std::vector<ExprId> arguments(ExprId e) const;
  [[nodiscard]] Point evaluated(ExprId e) const;
  [[nodiscard]] Point anything(ExprId e) const;

  const EquationSystem& system_;
  std::vector<Point> at_;                    ///< by ExprId
  std::vector<bool> indefinite_;             ///< by SymbolId
  std::vector<bool> reaches_;                ///< by ExprId: a chain of arguments leads from it to something indefinite
  std::vector<double> guess_, guess_slope_;  ///< by ExprId
  std::vector<ExprId> asked_;                ///< that rings ask for before they are known
};

}  // namespace bgsim
