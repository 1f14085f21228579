/// What expressions are worth when the parameters are known, and nothing else.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// Values of all expressions of a pool that depend on parameters only. One pass over the pool.
class ParameterValues {
 public:
  /// @param symbol_values  by SymbolId; looked at for parameters only.
  ParameterValues(const Model& model, const ExprPool& pool, std::span<const double> symbol_values);
  /// None if the expression depends on anything but parameters. May be NaN or infinite.
  [[nodiscard]] std::optional<double> of(ExprId expression) const;

 private:
  std::vector<double> values_;
  std::vector<bool> known_;
};

/// "A*X/(rho*T) with A = 1, X = 2, rho = 0": an expression and the values of the names in it.
std::string with_operands(const Model& model, const ExprPool& pool, ExprId expression,
                          std::span<const double> symbol_values);

}  // namespace bgsim
