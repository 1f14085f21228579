/// How far a run has strayed from the exact solution: an estimate, carried along.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/stopwatch.hpp"
#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"
#include "run/integrate/column_lu.hpp"
#include "run/integrate/integrator.hpp"
#include "run/integrate/step_polynomial.hpp"
#include "run/sink/near_misses.hpp"
#include "run/sink/pade_exponential.hpp"
#include "run/tolerances.hpp"

namespace bgsim {

/// Errors of steps add up, shrink, or grow, as the equations have it. With p the dense output, r = p' - f(p) what it
/// leaves of the equations, and J = df/dx, the error e = p - x follows
///
///     e' = J e + r,    e = 0 at the start
///
/// to first order; where the dense outputs of two steps do not meet, e jumps with p. This is integrated along with the
/// run, whatever the method. At an event the error of its time is added (saltation), and where states are set, or jump
/// into another mode, so does x - e, at the time at which it comes there. What an output is wrong by is its
/// change from x to x - e. An estimate, no bound. (Global error by defects: P. Zadunaisky, Numer. Math. 27, 1976; R. D.
/// Skeel, Math. Comp. 38, 1982; both from memory.)
///
/// An output that is zero by structure (a balance of laws) has rounding for its range. So where an error is the largest
/// so far, twice the last that was looked at, and large for its output's range, it is held against a bound of rounding.
///
/// The local error of a one-step method is what cancels in the integral of its defect, to the second order of hJ and
/// what J changes by within the step. So its steps are taken by halves as soon as an error is in reach of being noted:
/// a relaxation oscillation by Radau IIA was wrong by four to nine times its estimate without, and by 1.1 times with
/// it. Where more than a quarter of what r adds is left out still, they are taken in up to sixteen parts: orbits of an
/// eccentricity of 0.85 were wrong by three times the estimate of halves, where they are closest.
///
/// @note Costs, for each step, one to three rates, a Jacobian and a factorization of n x n; so much for each part.
class GlobalError {
 public:
  /// Of systems that have an explicit form and up to kDenseStates states, whatever integrates them; finish() says why
  /// there is none.
  GlobalError(const Program& program, Evaluator& evaluator, const Tolerances& tolerances, const RunInputs& inputs,
              bool wanted);

  [[nodiscard]] bool measuring() const { return measuring_; }

  /// Over the integrator's last step, from (@p from, @p x) to @p to.
  void add(double from, const std::vector<double>& x, double to, Integrator& integrator);
  /// Before the modes change at an event (t, x), then after.
  void before_event(double t, const std::vector<double>& x, const Branch& branch);
  /// @param guard  that crossed; none: the event came at a known time.
  void after_event(double t, const std::vector<double>& x, const Branch& branch, std::optional<std::size_t> guard);
  /// What the outputs @p row at a recorded point are wrong by; @p t within the last add().
  void add_row(double t, const double* y, const Branch& branch, const std::vector<double>& row);

  /// Sets states at the time and point that it is given, with the modes there; false if it cannot.
  using Set = std::function<bool(double t, std::vector<double>& x, const Branch& branch)>;
  /// Before states are set at (t, x); then after. What is set is set where the exact solution is taken to be as well.
  void before_set(double t, const std::vector<double>& x, const Branch& branch, const Set& set);
  void after_set(double t, const std::vector<double>& x, const Branch& branch);

  /// An instant at which rates or states jump.
  struct Instant {
    double t = std::numeric_limits<double>::quiet_NaN();
    double late = 0.0;          ///< the exact solution comes to it so much after t
    std::vector<double> exact;  ///< and is there then
    bool known = true;          ///< the time; else a guard crosses its border there
  };
  /// Of a run that ends at (t, x), in a mode that another run goes on from.
  [[nodiscard]] const Instant& leave(double t, const std::vector<double>& x);

  /// What is known of the outputs so far.
  struct Sums {
    double start = 0.0, steps = 0.0;
    std::vector<double> largest, bounded, beyond, least_value, most_value;
  };
  [[nodiscard]] const Sums& sums() const { return sums_; }
  /// Goes on where another run ended, with the states' errors there.
  void go_on(Sums sums, std::vector<double> error);

  /// The first condition that less than the error decides, if there is one.
  [[nodiscard]] const std::vector<NearMisses::Miss>& missed() const { return near_misses_.first(); }
  /// The first state, and when, that would have been set to something else a little farther off than the exact solution
  /// is taken to be (a sample that is rounded, beside the border between two ticks).
  struct DoubtfulSet {
    std::size_t state = 0;
    double t = 0.0;
  };
  [[nodiscard]] const std::optional<DoubtfulSet>& doubtful_set() const { return doubtful_set_; }

  /// Why an estimate that was begun has no result.
  [[nodiscard]] const std::optional<std::string>& lost() const { return lost_; }

  OutputErrors finish(bool completed);
  [[nodiscard]] double seconds() const { return seconds_; }

  template <class Archive>
  void carry(Archive& archive) {
    archive("measuring", measuring_);
    archive("possible", possible_);
    archive("why not", why_not_);
    archive("lost", lost_);
    archive("error", error_);
    archive("begin", begin_error_);
    archive("parts", parts_);
    archive("inner errors", inner_errors_);
    archive("begin parts", begin_parts_);
    archive("near misses", near_misses_);
    carry_doubtful_set(archive);
    archive("from", from_);
    archive("to", to_);
    archive("largest", sums_.largest);
    archive("bounded", sums_.bounded);
    archive("beyond rounding", sums_.beyond);
    archive("start", sums_.start);
    archive("steps", sums_.steps);
    archive("least", sums_.least_value);
    archive("most", sums_.most_value);
  }

 private:
  template <class Archive>
  void carry_doubtful_set(Archive& archive) {
    std::vector<double> set;
    if (doubtful_set_) set = {static_cast<double>(doubtful_set_->state), doubtful_set_->t};
    archive("doubtful set", set);
    doubtful_set_.reset();
    if (set.empty()) return;
    archive.check(set.size() == 2 && set[0] >= 0.0 && set[0] < static_cast<double>(program_.state_names.size()));
    doubtful_set_ = DoubtfulSet{static_cast<std::size_t>(set[0]), set[1]};
  }

  /// A part of the last step.
  struct Within {
    explicit Within(std::size_t states)
        : lu(states), defects(states * kMostPoints), bend(states * (kMostPoints - 1)), jacobian(states * states) {}
    static constexpr std::size_t kMostPoints = 3;  ///< a solution of order q leaves a defect that q/2 + 1 integrate
    std::size_t points = 1;                        ///< of Gauss' rule
    ColumnLu<false> lu;                            ///< of (1 - g hJ)
    std::vector<double> defects;                   ///< by point and state: r there, times its weight and the length
    bool ready = false;                            ///< bend is known
    std::vector<double> bend;                      ///< by n and state: the h a_n / (2 (2n + 1)) of add_bend()
    std::vector<double> jacobian;                  ///< by columns
  };

  void give_up(const std::string& why);
  void come_to(double t, const std::vector<double>& x);
  [[nodiscard]] bool holds(const Branch& branch) const;
  bool set_modes(double t, const std::vector<double>& y, Branch& branch);
  bool take_step(Integrator& integrator);
  [[nodiscard]] bool matters(const std::vector<double>& error) const;
  bool take_parts(std::size_t parts, std::size_t points, const Integrator::Rates& held);
  bool propagate(double from, double to, std::size_t points, const Integrator::Rates& held, Within& within);
  bool moves(const std::vector<double>& jacobian, double length);
  double left_out();
  [[nodiscard]] double part_begin(std::size_t part) const;  ///< of the last step; of parts_: its end
  [[nodiscard]] const double* error_at(std::size_t part) const;
  bool see_rates(const std::array<double, Within::kMostPoints>& at, std::size_t points, const Integrator::Rates& held);
  void see_bend(Within& within);
  void add_bend(Within& within, double part);
  bool see_jacobian(double t, double* jacobian);
  bool rates_at(double t, const std::vector<double>& y, const Integrator::Rates& held, double* rates);
  bool see_differences(double t, const Integrator::Rates& held, double* jacobian);
  void hold_against_rounding(double t, const double* y, const Branch& branch, const std::vector<double>& row);

  const Program& program_;
  Evaluator& evaluator_;
  const Tolerances& tolerances_;
  bool measuring_;
  bool possible_ = true;
  std::string why_not_;
  std::optional<std::string> lost_;
  std::vector<double> error_, begin_error_;  ///< by state: at to_ and from_
  double from_ = 0.0, to_ = 0.0;
  std::size_t parts_ = 1;             ///< of the last step
  std::vector<double> inner_errors_;  ///< by state, where one part ends and the next begins
  std::size_t begin_parts_ = 2;       ///< that the next step is taken in first
  std::vector<Within> within_;        ///< by part
  /// By output: largest error; errors held against rounding; more than rounding; least and most of its value.
  Sums sums_;
  Instant instant_;
  NearMisses near_misses_;
  std::optional<DoubtfulSet> doubtful_set_;
  double seconds_ = 0.0;

  // Scratch
  StepPolynomial polynomial_;
  std::vector<std::uint32_t> all_;
  Branch branch_;
  std::array<std::vector<double>, Within::kMostPoints> at_, slope_at_, rate_at_;  ///< by point of Gauss' rule
  std::vector<double> y_, middle_, rates_, entries_, rates_before_, guards_, guards_off_, row_, state_rounding_,
      rate_rounding_, rounding_;
  std::vector<int> direction_;
  Branch branch_before_, branch_there_;
  std::array<std::vector<double>, 2> farther_;  ///< set there; empty: not looked at
  std::vector<double> right_, moment_, second_, defect_, added_, flow_;
  PadeExponential exponential_{0};
};

}  // namespace bgsim
