/// The value of a relation of time just after an instant at which rounding hides it: floor(1 - t) after 0.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "bgsim/expression.hpp"

namespace bgsim {

struct RightLimit {
  double value = 0.0;
  double hidden = 0.0;  ///< how long rounding hides it
};

/// For one relation at many instants.
class RightLimits {
 public:
  /// @param pool  must outlive this.
  RightLimits(const ExprPool& pool, ExprId relation, SymbolId time, std::span<const double> symbol_values);
  ~RightLimits();
  RightLimits(RightLimits&&) noexcept;

  /// As right_limit().
  std::optional<RightLimit> at(double after);

 private:
  struct Limit;
  std::unique_ptr<Limit> limit_;
};

/// By the derivatives of what is compared or rounded, where that is exactly at its border at @p after and at the next
/// double. None where it is not, so that the values tell; or where the derivatives do not tell either.
std::optional<RightLimit> right_limit(const ExprPool& pool, ExprId relation, SymbolId time,
                                      std::span<const double> symbol_values, double after);

}  // namespace bgsim
