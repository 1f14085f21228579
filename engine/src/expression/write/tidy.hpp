/// Expressions as a person would write them: products with the number first, then parameters, then states; one
/// fraction; sums that begin with a positive term; like terms collected, equal factors cancelled.
#pragma once

#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bgsim/expression.hpp"

namespace bgsim {

/// Rewrites for display only: equal where both are defined, but x/x is cancelled and rounding differs.
class Tidier {
 public:
  /// @param order  symbols in the order in which they are to stand in a product.
  Tidier(const ExprPool& from, std::span<const SymbolId> order);
  /// The tidied expression, in pool().
  ExprId operator()(ExprId root);
  [[nodiscard]] const ExprPool& pool() const { return to_; }
  ExprId symbol(SymbolId symbol) { return to_.symbol(symbol); }

 private:
  /// coefficient times the product of factors to integer powers; factors increase.
  struct Monomial {
    double coefficient = 1.0;
    std::vector<std::pair<ExprId, int>> factors;
  };
  Monomial read(ExprId expression);
  Monomial read_sum(ExprId expression);
  static Monomial atom(ExprId expression) { return {1.0, {{expression, 1}}}; }
  static Monomial multiply(const Monomial& a, const Monomial& b, int power_of_b);
  ExprId write(const Monomial& monomial);
  [[nodiscard]] std::vector<std::pair<ExprId, bool>> terms_of(ExprId sum) const;
  ExprId turned(ExprId sum);
  ExprId write_factors(const Monomial& monomial, double coefficient, int sign);

  const ExprPool& from_;
  ExprPool to_;
  std::unordered_map<ExprId, Monomial> known_;  ///< by expression of from_
};

}  // namespace bgsim
