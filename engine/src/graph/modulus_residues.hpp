/// Values of moduli modulo a prime, at random values of everything that they depend on.
#pragma once

#include <cstdint>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// Evaluates expressions of a model: sums, products, quotients and whole powers exactly; parameters, time, states and
/// other functions as numbers of their own, the same for the same arguments. So "n" and "1/n" multiply to 1, and 2 and
/// 0.5 do, while two parameters never cancel by chance. Signals are followed.
class ModulusResidues {
 public:
  explicit ModulusResidues(const Model& model)
      : model_(model), values_(model.pool.size()), known_(model.pool.size(), false) {}
  std::uint64_t operator()(ExprId expression);

 private:
  [[nodiscard]] std::uint64_t value(ExprId expression) const { return values_[expression.index()]; }
  [[nodiscard]] std::uint64_t apply(ExprId expression) const;

  const Model& model_;
  std::vector<std::uint64_t> values_;
  std::vector<bool> known_;
};

}  // namespace bgsim
