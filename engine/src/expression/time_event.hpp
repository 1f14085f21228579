/// Known times: where a function of time alone changes sign or jumps, found with certainty by interval arithmetic.
#pragma once

#include <optional>
#include <span>

#include "bgsim/expression.hpp"
#include "expression/interval.hpp"
#include "expression/right_limit.hpp"

namespace bgsim {

/// What a search for known times is helped by, and what it could not do.
struct TimeSearch {
  std::optional<double> guess;      ///< where the change may be: it is looked at first, and costs little if it is not
  std::optional<double> undecided;  ///< from here on the relation is not decided by its rounded values, or not in time
};

/// The first time in (after, until] at which @p relation (an expression of time and parameters whose values are
/// piecewise constant: a comparison, sign, step, floor, or a table, which means its cell's index) takes another
/// value than just after @p after, to the last bit: the value holds on [t*, ...).
///
/// Interval arithmetic (Boost.Interval) on the very operations of evaluate() excludes stretches without a change, so
/// that no pulse is missed however narrow. A value counts where it holds on a stretch: the isolated 0 of sign(t - 1) at
/// t = 1, or the contact of sin(t) >= 1, is no change. Contacts cannot be decided: where more than 4096 neighbouring
/// stretches stay undecided, or the search advances 16384 times slower than before, undecided stretches are passed over
/// (the shortest ones first), so that the work stays bounded; a change is then still seen by the values on either side.
///
/// Where the two sides are the same expression on a stretch (min(t, 1) is t before 1) the relation is decided there.
/// The work is bounded; @p search tells where a relation could not be decided.
///
/// @p symbol_values gives the parameters (time's entry is ignored).
/// @param held  the value that it is taken to have at @p after, instead of that just after it: a change that a search
///              from before @p after finds at the next double is found from there, too.
/// @return none if there is none.
/// @note About 50 interval evaluations of the relation for each change (a sawtooth that is compared, and its floor);
///       about 9 where the guess is right.
std::optional<double> next_change(const ExprPool& pool, ExprId relation, SymbolId time,
                                  std::span<const double> symbol_values, double after, double until,
                                  TimeSearch* search = nullptr, std::optional<double> held = {});

/// The value that @p relation has just after @p after: that of the first stretch beyond it on which it is decided. For
/// sign(t) after 0 this is 1, for t > 0 too; for floor(1 - t) it is 0, although 1 - t rounds to 1 there. Where it has
/// no value there, as behind the end of measured data, the value at @p after.
double value_just_after(const ExprPool& pool, ExprId relation, SymbolId time, std::span<const double> symbol_values,
                        double after);

/// For many searches in one relation: what does not depend on the instant is prepared once, which costs as much as a
/// third of a search.
class RelationOfTime {
 public:
  /// @param pool  must outlive this.
  RelationOfTime(const ExprPool& pool, ExprId relation, SymbolId time, std::span<const double> symbol_values)
      : limits_(pool, relation, time, symbol_values), values_(pool, relation, time, symbol_values) {}

  /// As the functions of these names.
  std::optional<double> next_change(double after, double until, TimeSearch* search = nullptr,
                                    std::optional<double> held = {});
  double value_just_after(double after);

 private:
  std::optional<double> change_at(double guess, double begin, double until, double first);

  RightLimits limits_;
  TimeRelation values_;
};

}  // namespace bgsim
