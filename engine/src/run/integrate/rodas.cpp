// Rodas5P: a Rosenbrock method of order 5. G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P and
// numerical benchmarks within the Julia Differential Equations package, BIT Numer. Math. 63:27 (2023). A step takes the
// Jacobian and the slopes by time where it begins, one factorization and eight linear systems: no iteration that could
// fail.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "run/integrate/dense_jacobian.hpp"
#include "run/integrate/implicit_steps.hpp"
#include "run/integrate/predictive_control.hpp"
#include "run/integrate/radau_jacobian.hpp"
#include "run/integrate/real_system.hpp"
#include "run/integrate/rodas_formula.hpp"

namespace bgsim {

namespace {

/// The error that is held is of order 4.
using RodasControl = PredictiveControl<5, 6>;

class RodasIntegrator final : public ImplicitSteps {
 public:
  RodasIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs,
                  Loops loops)
      : ImplicitSteps(program, evaluator, tolerances, inputs, loops),
        system_(make_real_system(pattern_of(program, loops), states_)),
        jacobian_(program, evaluator, tolerances, system_->dense(), loops) {
    order_ = kDegree;
    slope_.assign(size_, 0.0);
    right_.assign(size_, 0.0);
    for (std::vector<double>& vector : dense_) vector.assign(size_, 0.0);
    stage_.assign(rodas::kStages * size_, 0.0);
  }

  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    if (!begin_at(t, x, branch, limit)) return fault(t);
    jacobian_.begin();
    seen_ = false;
    factored_ = 0.0;
    control_.begin();
    if (!rates(t, y_.data(), branch_, rate_.data())) return fault(t);
    return true;
  }

  bool advance() override {
    failure_ = {};
    if (limit_is_at_hand()) {
      if (!rates(time_, y_.data(), branch_, rate_.data())) return fault(time_);
      step_by_hand(rate_);
      return true;
    }
    if (loops_) branch_at_begin_ = branch_;
    if (!(next_ > 0.0)) next_ = first_step(kFirst, 1.0);
    double h = fit(next_);
    tolerances_.weights(time_, h, y_.data(), weight_.data());
    for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
      if (is_lost(h)) return fail(words_);
      if (!seen_) {
        if (!see_slopes(h)) return fault(time_);
        tolerances_.weights(time_, h, y_.data(), weight_.data());
      }
      if (attempt == 0) {
        // Only now: what the Jacobian is like a little further on is asked by how far the step before went.
        previous_ = time_;
        begin_ = y_;
        if (!is_resolved()) return false;
      }
      if (factored_ != h) {
        factored_ = 0.0;
        ++counts_.factorizations;
        if (!system_->factor(rodas::kShift, h, slopes_, weight_.data())) {
          h = shorten(h, 0.5, kLinearText);
          continue;
        }
        factored_ = h;
      }
      if (!find_stages(h)) {
        h = shorten(h, 0.25, kStateEquationsText);
        continue;
      }
      double error = judged(h, size_of_error());
      if (error < 1.0) {
        const double within = check(h);
        if (within < 0.0) {
          h = shorten(h, 0.5, kStateEquationsText);
          continue;
        }
        error = std::max(error, judged(h, within));
      }
      if (error < 1.0) {
        if (!accept(h, increment_, stage_branch_)) {  // no rates at the end
          h = shorten(h, 0.5, kStateEquationsText);
          continue;
        }
        const double released = judged(h, released_error(h));
        if (released < 1.0) {
          finish(h, std::max(error, released));
          return true;
        }
        take_back();
        error = released;
      }
      ++counts_.error_failures;
      words_ = kErrorTestText;
      faulted_ = false;
      rejected_ = true;
      h = first_ ? 0.1 * h : h / RodasControl::quotient_of(error);
    }
    return fail(words_);
  }

  void interpolate(double t, double* y) override {
    if (is_end(t, y)) return;
    const double u = (t - previous_) / (time_ - previous_);
    for (std::size_t i = 0; i < size_; ++i) y[i] = y_[i] + (u - 1.0) * (y_[i] - begin_[i] - u * bend(i, u));
  }

  [[nodiscard]] std::string method() const override {
    return std::string("Rodas5P of order 5, ") + (system_->dense() ? "dense" : "sparse");
  }

 private:
  static constexpr int kDegree = 4, kMostAttempts = 100;
  /// Of a system that is not written out: a step so little longer is not worth a factorization.
  static constexpr double kSame = 1.2;
  static constexpr std::size_t kWrittenOut = 8;
  static constexpr double kFirst = 1.0 / 4.0;  ///< of a first step: one over the order that is held

  /// A first step of some tens of roundings of the time is not made shorter: over it the tolerances of states that have
  /// just begun to move are below what rounding makes of the stages.
  [[nodiscard]] double judged(double h, double error) const {
    constexpr double kRoundings = 32.0, kPasses = 0.5, kNotFinite = 1e10;
    return first_ && h <= kRoundings * kEps * std::abs(time_) && error < kNotFinite ? std::min(error, kPasses) : error;
  }

  /// By states and by time, where the step begins.
  bool see_slopes(double h) {
    ++counts_.jacobians;
    const double factored = std::exchange(factored_, 0.0);
    const double ahead = std::max({time_ - previous_, h, 1e-9 * (limit_ - time_)});
    const auto rates_at_begin = [this](const double* x, double* out) { return rates(time_, x, branch_, out); };
    if (special_rates_ && system_->dense()) {
      jacobian_.look({time_, ahead, y_, rate_, branch_});
      if (!see_held(rates_at_begin)) return false;
    } else {
      if (!jacobian_.see({time_, ahead, y_, rate_, branch_}, rates_at_begin, !special_rates_)) return false;
      if (slopes_ != held_.data() && jacobian_.is_as_before()) factored_ = factored;
      slopes_ = jacobian_.values();
    }
    see_slope_by_time(h);
    seen_ = true;
    return true;
  }

  /// Of rates that hold a friction, which is balanced by differences itself: over a root of the rounding their noise
  /// makes slopes that no iteration corrects here, and steps of gears that turn together grew tenfold with each decade
  /// of the tolerance.
  template <class RatesAtBegin>
  bool see_held(const RatesAtBegin& rates_at_begin) {
    constexpr double kPart = 1e-5;
    held_.resize(size_ * size_);
    slopes_ = held_.data();
    return difference_jacobian(
        y_, rate_, [this](std::size_t j) { return std::max(tolerances_.absolute(j), kPart * std::abs(y_[j])); },
        rates_at_begin, at_, held_.data());
  }

  /// By differences of second order where rates have no slopes: those that hold a friction, and a root of time at 0.
  void see_slope_by_time(double h) {
    slopes_by_time_ = evaluator_.names_time();
    if (!slopes_by_time_) return;
    if (loops_) probe_ = branch_;
    Branch& branch = loops_ ? probe_ : branch_;
    if (!special_rates_ && tears_ == 0 && evaluator_.time_slopes(time_, y_.data(), branch, slope_.data())) return;
    // Over less the rounding of what holds a block at rest moves it; this is wrong by 1e-4 h^4 and a third derivative.
    constexpr double kPart = 1.0 / 64.0, kRoundings = 1024.0;
    const double move = std::min(std::max(kPart * h, kRoundings * kEps * std::abs(time_)), 0.5 * (limit_ - time_));
    slopes_by_time_ = move > 0.0 && rates(time_ + move, y_.data(), branch, slope_.data()) &&
                      rates(time_ + 2.0 * move, y_.data(), branch, increment_.data());
    for (std::size_t i = 0; i < size_; ++i)
      slope_[i] = (4.0 * (slope_[i] - rate_[i]) - (increment_[i] - rate_[i])) / (2.0 * move);
  }

  /// sum of c_j U_j of state i over the stages before K
  template <std::size_t K, class Coefficients>
  [[nodiscard]] double sum_of(const Coefficients& c, std::size_t i) const {
    const double* const u = stage_.data() + i * rodas::kStages;
    return [&]<std::size_t... J>(std::index_sequence<J...>) { return (0.0 + ... + (c[J] * u[J])); }
    (std::make_index_sequence<K>());
  }

  template <std::size_t K>
  bool find_stage(double h) {
    const double* rate = rate_.data();
    if constexpr (K > 0) {
      for (std::size_t i = 0; i < size_; ++i) at_[i] = y_[i] + sum_of<K>(rodas::kState[K], i);
      const double t = time_ + rodas::kAt[K] * h;
      if (!rates(t, at_.data(), loops_ ? stage_branch_ : branch_, increment_.data())) {
        note_fault(t);
        return false;
      }
      rate = increment_.data();
    }
    for (std::size_t i = 0; i < size_; ++i)
      right_[i] = h * rate[i] + (i < states_ ? sum_of<K>(rodas::kRight[K], i) : 0.0);
    if (rodas::kTime[K] != 0.0 && slopes_by_time_)
      for (std::size_t i = 0; i < size_; ++i) right_[i] += rodas::kTime[K] * h * h * slope_[i];
    if constexpr (K + 1 == rodas::kStages) raw_ = right_;
    system_->solve(right_.data());
    for (std::size_t i = 0; i < size_; ++i) stage_[i * rodas::kStages + K] = right_[i];
    return true;
  }

  /// False where there are no rates.
  bool find_stages(double h) {
    faulted_ = false;
    if (loops_) stage_branch_ = branch_;
    return [&]<std::size_t... K>(std::index_sequence<K...>) { return (find_stage<K>(h) && ...); }
    (std::make_index_sequence<rodas::kStages>());
  }

  /// Of the last stage, whose increment is the distance from the embedded formula. at_ is then the end of that.
  double size_of_error() {
    error_ = right_;
    const double error = norm(error_);
    return std::isfinite(error) ? std::max(error, 1e-10) : 1e10;
  }

  [[nodiscard]] double bend(std::size_t i, double u) const {
    return dense_[0][i] + u * (dense_[1][i] + u * dense_[2][i]);
  }

  /// The dense output, and how far it is from the equations at one point within the step, relative to what is allowed:
  /// the embedded formula does not see what comes and goes between the stages. Negative: no rates there.
  double check(double h) {
    for (std::size_t i = 0; i < size_; ++i) increment_[i] = at_[i] - y_[i] + error_[i];
    for (std::size_t k = 0; k < dense_.size(); ++k)
      for (std::size_t i = 0; i < size_; ++i) dense_[k][i] = sum_of<rodas::kStages>(rodas::kDense[k], i);
    constexpr double u = rodas::kCheckedAt;
    for (std::size_t i = 0; i < size_; ++i) at_[i] = y_[i] + u * (increment_[i] + (1.0 - u) * bend(i, u));
    const double t = time_ + u * h;
    if (loops_) probe_ = stage_branch_;
    if (!rates(t, at_.data(), loops_ ? probe_ : branch_, right_.data())) {
      note_fault(t);
      return -1.0;
    }
    for (std::size_t i = 0; i < size_; ++i) {
      const double slope =
          increment_[i] + (1.0 - 2.0 * u) * bend(i, u) + u * (1.0 - u) * (dense_[1][i] + 2.0 * u * dense_[2][i]);
      right_[i] = h * right_[i] - (i < states_ ? slope : 0.0);
    }
    system_->solve(right_.data());
    const double size = rodas::kLargestBubble / rodas::bubble(u) * norm(right_);
    return std::isfinite(size) ? size : 1e10;
  }

  /// The error of an accepted step by the slopes at its end, where these let go what those at its beginning held, as in
  /// a step by Radau IIA. 0 where they do not. Slopes that were seen serve for the next step.
  double released_error(double h) {
    seen_ = false;
    if (!lets_go(h, rodas::kShift, rodas::kShift)) return 0.0;
    factored_ = 0.0;
    if (!see_slopes(h)) return 0.0;
    ++counts_.factorizations;
    if (!system_->factor(rodas::kShift, h, slopes_, weight_.data())) return 0.0;
    factored_ = h;
    error_ = raw_;
    system_->solve(error_.data());
    const double error = norm(error_);
    if (!(error < 1.0)) seen_ = false;
    return std::isfinite(error) ? error : 1e10;
  }

  void finish(double h, double error) {
    jacobian_.stepped();
    order_ = kDegree;
    by_hand_ = false;
    ++counts_.steps;
    next_ = control_.next_length(h, error, RodasControl::quotient_of(error), rejected_);
    first_ = rejected_ = false;
    if (size_ > kWrittenOut && next_ >= h && next_ <= kSame * h) next_ = h;
  }

  std::unique_ptr<RealSystem> system_;
  RadauJacobian jacobian_;
  RodasControl control_;
  std::vector<double> slope_;                 ///< of the rates by time
  std::vector<double> held_;                  ///< their Jacobian where they hold a friction
  const double* slopes_ = nullptr;            ///< the Jacobian of the step
  std::vector<double> stage_;                 ///< the stages' increments, by state
  std::array<std::vector<double>, 3> dense_;  ///< of the dense output
  Branch stage_branch_;          ///< where rates solve loops: each stage from the solution of the one before
  bool seen_ = false;            ///< slopes are those of where the step begins
  bool slopes_by_time_ = false;  ///< they are not all 0
  std::vector<double> right_;    ///< scratch
};

}  // namespace

std::unique_ptr<Integrator> make_rodas_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                  const RunInputs& inputs, Loops loops) {
  return std::make_unique<RodasIntegrator>(program, evaluator, tolerances, inputs, loops);
}

}  // namespace bgsim
