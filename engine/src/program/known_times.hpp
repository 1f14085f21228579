/// What a run knows of its conditions on time: when they change next, and what they are.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "bgsim/expression.hpp"

namespace bgsim {

/// Of one condition.
struct KnownTime {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  double next_change = kUnknown;  ///< infinite where there is none
  double looked_from = kUnknown, looked_until = kUnknown;
  std::uint32_t near_changes = 0;   ///< in a row, each just after the one before
  std::optional<double> undecided;  ///< TimeSearch::undecided, the first
  double mode_at = kUnknown;        ///< where its value was last asked for
  double mode = 0.0;                ///< just after that
};

/// By condition, for all programs of one model: a condition on time does not depend on the mode in which it is met, and
/// a search for its next change takes some hundred evaluations in interval arithmetic.
class KnownTimes {
 public:
  /// The place of @p relation with the values of its parameters, whichever pool it is in; it stays where it is. None
  /// where tables are read: what they hold may be the run's own.
  KnownTime* of(const ExprPool& pool, ExprId relation, SymbolId time, std::span<const double> symbol_values);

 private:
  std::map<std::string, KnownTime> known_;  ///< by operations, constants and parameters, bit for bit
};

}  // namespace bgsim
