/// The values an expression of time takes over a stretch of time.
#pragma once

#include <array>
#include <boost/numeric/interval.hpp>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "bgsim/expression.hpp"

namespace bgsim {

/// An interval that holds every value that the rounded operations of evaluate() give, empty for NaN. Rounding is
/// monotone: x <= y gives x + z <= y + z after rounding as before it. So the ends need no outward rounding but for the
/// functions of the mathematical library, which may be off by a unit in the last place.
using Range = boost::numeric::interval<
    double, boost::numeric::interval_lib::policies<boost::numeric::interval_lib::save_state_nothing<
                                                       boost::numeric::interval_lib::rounded_arith_exact<double>>,
                                                   boost::numeric::interval_lib::checking_base<double>>>;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Where a function leaves its domain within a range, or nothing is known of it.
inline const Range kAllNumbers(-kInfinity, kInfinity);

[[nodiscard]] inline bool is_empty(const Range& x) { return !(x.lower() <= x.upper()); }
[[nodiscard]] inline bool is_thin(const Range& x) { return x.lower() == x.upper(); }

/// What holds all values of one operator on arguments within @p a, @p b and @p c, of which those beyond the operator's
/// arity are not looked at. All numbers where arguments leave its domain in part, empty where they leave it altogether.
/// @param table  of a table's operator, else null.
Range range_of(Op op, const Table* table, const Range& a, const Range& b, const Range& c);

/// Evaluates one relation over stretches of time, with the parameters fixed.
class TimeRelation {
 public:
  /// @param cells  whether a table at the top means its cell's index instead of its value
  TimeRelation(const ExprPool& pool, ExprId relation, SymbolId time, std::span<const double> symbol_values,
               bool cells = true);

  /// The relation's value if it is the same at all times in [begin, end], NaN being a value like others.
  std::optional<double> value_on(double begin, double end);
  /// How far what is compared or rounded was from where it would be at its border, at the single time last asked for;
  /// NaN where that is not known. For floor, from the whole number @p whole.
  [[nodiscard]] double distance(double whole) const;
  /// What holds all values that it takes in [begin, end]: empty if there is none.
  Range range_on(double begin, double end);
  /// Operations of one evaluation.
  [[nodiscard]] std::size_t size() const { return steps_.size(); }

 private:
  struct Step {
    Op op;
    std::uint32_t a, b, c, out;
    const Table* table;
    int arity;
  };
  void run(const Step& step);
  void follow(const Step& step);
  [[nodiscard]] std::optional<Range> of_equals(const Step& step) const;
  std::uint32_t twin_of(const Step& step);

  std::vector<Step> steps_;  ///< of what depends on time
  /// By value: the one that it is on the whole stretch, whatever the time (min(t, 1) is t before 1); itself if none is
  /// known. So t > min(t, 1) is decided though the ranges of both sides are the same.
  std::vector<std::uint32_t> same_;
  std::map<std::array<std::uint32_t, 4>, std::uint32_t> twins_;  ///< operator and arguments -> value
  std::vector<Range> values_;
  std::vector<std::uint32_t> time_;  ///< where time occurs
  const Table* cells_ = nullptr;     ///< the relation is this table's cell
};

/// The cell of @p table that holds @p x; the first or last one outside the data.
std::size_t nearest_cell(const Table& table, double x);

}  // namespace bgsim
