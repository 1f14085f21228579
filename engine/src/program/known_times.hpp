/// What a run knows of its conditions on time: when they change next, and what they are.
#pragma once

#include <array>
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
  /// Where the change after @p after is if every other one has the same distance, as those of a clock and of a pulse
  /// have: by the last three.
  [[nodiscard]] std::optional<double> guess(double after) const {
    const double next = changes[1] + (changes[2] - changes[0]);
    return changes[2] <= after && after < next ? std::optional(next) : std::nullopt;
  }
  void take_change(double t) { changes = {changes[1], changes[2], t}; }

  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  double next_change = kUnknown;  ///< infinite where there is none
  double looked_from = kUnknown, looked_until = kUnknown;
  std::array<double, 3> changes{kUnknown, kUnknown, kUnknown};  ///< the last ones
  std::uint32_t near_changes = 0;                               ///< in a row, each just after the one before
  std::optional<double> undecided;                              ///< TimeSearch::undecided, the first
  double mode_at = kUnknown;                                    ///< where its value was last asked for
  double mode = 0.0;                                            ///< just after that
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
