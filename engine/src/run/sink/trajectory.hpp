/// The solution of a run, kept whole.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "bgsim/evaluator.hpp"

namespace bgsim {

/// The accepted steps' dense output as polynomials, and the events between them. Memory: states times (order + 1)
/// doubles a step.
class Trajectory {
 public:
  struct Step {
    double from = 0.0, to = 0.0;
    std::size_t first = 0;    ///< in `values`
    std::uint32_t nodes = 0;  ///< of the polynomial, at Chebyshev's points from `to` to `from`; by node, then state
  };
  /// From one change of conditions to the next.
  struct Stretch {
    std::vector<Step> steps;
    Branch end;  ///< the loops' solution where it ends
  };
  /// Between two stretches.
  struct Event {
    double t = 0.0;
    std::vector<double> x;
    Branch before, after;
    std::optional<std::size_t> crossed;  ///< relation whose guard was found at its border; none at a known time
    std::vector<std::size_t> sets;       ///< events of the model that set states then: x is before, x_after behind that
    std::vector<double> x_after;
    [[nodiscard]] const std::vector<double>& behind() const { return sets.empty() ? x : x_after; }
  };

  /// Puts the solution at a time into @p x, with the branch of a point nearby.
  using Solution = std::function<void(double t, double* x, Branch& branch)>;

  void begin(double t, const std::vector<double>& x, const Branch& branch);
  /// @param order  of the solution's polynomial.
  void add(double from, double to, int order, const Branch& branch, const Solution& solution);
  void event(double t, const std::vector<double>& x, const Branch& before, const Branch& after,
             std::optional<std::size_t> crossed);
  /// Events of the model have set states. @param before  point and branch then; @p x, @p after behind them
  void set(double t, std::vector<double> x_before, const Branch& before, const std::vector<double>& x,
           const Branch& after, const std::vector<std::size_t>& events);

  /// The states at @p t within @p step.
  void interpolate(const Step& step, double t, std::vector<double>& x) const;

  [[nodiscard]] std::size_t states() const { return start_.size(); }
  [[nodiscard]] const std::vector<double>& start() const { return start_; }
  [[nodiscard]] const Branch& start_branch() const { return start_branch_; }
  [[nodiscard]] const std::vector<Stretch>& stretches() const { return stretches_; }
  /// One fewer than stretches.
  [[nodiscard]] const std::vector<Event>& events() const { return events_; }
  /// How large each state has been.
  [[nodiscard]] const std::vector<double>& largest() const { return largest_; }

 private:
  void take(const double* x);

  std::vector<double> start_, largest_, values_, scratch_;
  Branch start_branch_;
  std::vector<Stretch> stretches_;
  std::vector<Event> events_;
};

}  // namespace bgsim
