/// Failures of a run in words (BG6xx): what happened, to whom, when, and what to do about it.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/model.hpp"
#include "bgsim/text.hpp"

namespace bgsim {

/// "a", "b" and 3 more
std::string first_names(const std::vector<std::string>& names);

/// A law or a loop had no value: BG601 not finite, BG602 loop without solution, BG603 singular loop, BG608 table read
/// outside its data.
Diagnostic fault_failure(const Fault& fault);

/// BG602: the solution of a loop ends, and what is found behind is another one, from @p before to @p after at once.
Diagnostic branch_failure(const ProgramBlock& loop, const std::string& variable, double t, double before, double after);

/// A relation that can no longer be decided.
struct RelationFacts {
  std::string text;
  std::optional<Place> place;
  std::string where;  ///< element or signal
};
RelationFacts relation_facts(const Program& program, std::size_t relation);

/// BG604: events without end, or modes that contradict each other.
Diagnostic chattering_failure(const Program& program, std::span<const std::size_t> relations, double t,
                              std::size_t events, double gap, bool accumulating);
/// A relation that is pushed back to the border at which its law ends, time after time.
Diagnostic returning_failure(const Program& program, std::size_t relation, double t, std::size_t times);
Diagnostic contradiction_failure(const Program& program, std::span<const std::size_t> relations, double t);

/// BG613: a denominator passes zero.
Diagnostic singularity_failure(const Program& program, std::size_t relation, double t);

/// What is known about each unknown where the integrator gave up.
struct StuckPoint {
  double t = 0.0, start = 0.0;
  std::string words;                         ///< the integrator's
  std::vector<std::string> names;            ///< of the unknowns
  std::vector<std::optional<Place>> places;  ///< of their elements or loops
  std::vector<double> y, rate;               ///< rate empty if unknown
  std::vector<double> largest_early;         ///< magnitudes in the first half of the run so far
  std::vector<double> weighted_error;
  /// The rates by so much earlier, along the motion; empty where there are none.
  std::function<std::vector<double>(double by)> rate_before;
};
/// BG605: the step size went to nothing; growth without bound is recognised and dated.
Diagnostic stuck_failure(const StuckPoint& point);
/// The state that grows without bound: when it would be infinite, or that it has left the range of numbers already.
/// With g = y/y' the time in which y grows by what it is, (d ln y'/dt) g is 1 + 1/p for y of (t* - t)^-p, 1 for an
/// exponential and (n - 1)/n for (t - t0)^n: a store that a source has begun to fill does not grow without bound.
struct BlowUp {
  std::size_t state = 0;
  double time = 0.0;
  bool overflow = false;
};
std::optional<BlowUp> recognise_blow_up(const StuckPoint& point);

/// BG614: a store so fast beside the scene that double precision cannot follow it.
Diagnostic time_constant_failure(const std::string& state, double time_constant, double span, const Place& place);

/// BG615: a pulse of the source @p source, an expression, that double precision cannot follow.
/// @param place  none if several elements follow time.
Diagnostic narrow_pulse_failure(const std::string& source, double begin, double width, double wide_enough,
                                const std::optional<Place>& place);

Diagnostic interrupted_failure(double t);                                   // BG606
Diagnostic step_limit_failure(double t, double stop, std::uint64_t steps);  // BG607
Diagnostic accuracy_failure(double t, double relative);                     // BG609
Diagnostic needs_explicit_form_failure(const std::string& method);          // BG610

}  // namespace bgsim
