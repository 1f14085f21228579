// Radau IIA as in RADAU5 and RADAU. E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 1996, IV.8:
// simplified Newton iteration on the transformed system, error by an embedded formula of the stages' order that the
// real system filters. The dense output is the collocation polynomial, corrected at one point.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "run/integrate/implicit_steps.hpp"
#include "run/integrate/predictive_control.hpp"
#include "run/integrate/radau_formula.hpp"
#include "run/integrate/radau_jacobian.hpp"
#include "run/integrate/radau_polynomial.hpp"
#include "run/integrate/radau_stages.hpp"
#include "run/integrate/radau_systems.hpp"

namespace bgsim {

namespace {

double whole_power(double x, int n) {
  double result = 1.0;
  for (int i = 0; i < n; ++i) result *= x;
  return result;
}

/// With an odd number of stages.
template <std::size_t Stages>
class RadauIntegrator final : public ImplicitSteps {
 public:
  RadauIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs,
                  Loops loops)
      : ImplicitSteps(program, evaluator, tolerances, inputs, loops),
        systems_(make_radau_systems(pattern_of(program, loops), states_, eigenvalues())),
        jacobian_(program, evaluator, tolerances, systems_->dense(), loops),
        polynomial_(size_) {
    order_ = kDegree;  // NOLINT(cppcoreguidelines-prefer-member-initializer): a member of the base
    bend_.assign(size_, 0.0);
    for (auto* const vectors : {&z_, &w_, &right_, &stage_})
      for (std::vector<double>& vector : *vectors) vector.assign(size_, 0.0);
    if (systems_->dense())
      stages_ = std::make_unique<RadauStages>(
          size_, states_, Stages, kTable.inverse[0].data(),
          [this](std::size_t k, const double* x, double* out) { return rates_of_stage(k, x, out); },
          [this](std::size_t k, const double* x, double* full) { return jacobian_of_stage(k, x, full); });
    // As RADAU5 does: the error that is held is of order 3, that of the steps' ends of order 5. But what is recorded
    // between them is not, and nobody expects more than some tolerances there.
    const double held = std::min(0.1 * std::cbrt(inputs.relative * inputs.relative), kLooser * inputs.relative);
    looser_ = held / inputs.relative;
    // Not below what Tolerances leave for rounding in the rates, which is a part of the tolerances themselves.
    newton_part_ = std::min(kNewtonPart, std::max(std::sqrt(held), kNewtonPart / looser_));
  }

  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    if (!begin_at(t, x, branch, limit)) return fault(t);
    extrapolates_ = false;
    from_rest_ = false;
    jacobian_.begin();
    stale_ = kNoJacobian;
    factored_ = 0.0;
    speed_ = kNoSpeed;
    converged_ = 1.0;
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
    previous_ = time_;
    begin_ = y_;
    if (loops_) branch_at_begin_ = branch_;
    if (!(next_ > 0.0)) next_ = first_step(Control::kExponent, looser_);
    double h = fit(next_);
    tolerances_.weights(time_, h, y_.data(), weight_.data());
    resumes_ = false;
    for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
      if (is_lost(h)) return fail(words_);
      if (stale_ == kNoJacobian) {
        if (!see_jacobian(h)) return fault(time_);
        tolerances_.weights(time_, h, y_.data(), weight_.data());
      }
      if (attempt == 0 && !is_resolved()) return false;
      if (factored_ != h) {
        factored_ = 0.0;
        ++counts_.factorizations;
        if (!systems_->factor(h, jacobian_.values(), weight_.data())) {
          h = shorten(h, 0.5, kLinearText);
          continue;
        }
        factored_ = h;
      }
      if (const double reduction = find_stages(h); reduction < 1.0) {
        h = shorten(h, reduction, faulted_ ? kStateEquationsText : kIterationText);
        continue;
      }
      double error = estimate_error(h);
      // Where slopes change within the step no order says that its end is better than the estimate.
      const double share = bent_ || rejected_ ? looser_ : 1.0;
      error *= share;
      if (error < 1.0) {
        const double within = correct(h);
        if (within < 0.0) {
          h = shorten(h, 0.5, kStateEquationsText);
          continue;
        }
        error = std::max(error, share * within);
      }
      if (error < 1.0) {
        if (!accept(h, z_[kLast], stage_branch_[kLast])) {  // no rates at the end
          h = shorten(h, 0.5, kStateEquationsText);
          continue;
        }
        if (!is_solved(h)) {
          take_back();
          resumes_ = true;
          continue;
        }
        const double released = share * released_error(h);
        if (released < 1.0) {
          finish(h, error, Control::quotient_of(std::max(error, released), iterations_));
          return true;
        }
        take_back();
        error = released;
      }
      const double quotient = Control::quotient_of(error, iterations_);
      ++counts_.error_failures;
      words_ = kErrorTestText;
      faulted_ = false;
      rejected_ = true;
      h = first_ ? 0.1 * h : h / quotient;
      if (stale_ != kFresh) stale_ = kNoJacobian;
    }
    return fail(words_);
  }

  void interpolate(double t, double* y) override {
    if (is_end(t, y)) return;
    const double u = (t - previous_) / (time_ - previous_), bubble = radau::bubble<Stages>(u);
    for (std::size_t i = 0; i < size_; ++i) y[i] = y_[i] + polynomial_.from_end(i, u - 1.0) + bubble * bend_[i];
  }

  [[nodiscard]] std::string method() const override {
    return "Radau IIA of order " + std::to_string(kOrder) + ", " + (systems_->dense() ? "dense" : "sparse");
  }

 private:
  using Control = RadauControl<Stages>;
  static constexpr const radau::RadauTable<Stages>& kTable = radau::kTable<Stages>;
  static constexpr std::size_t kLast = Stages - 1, kPairs = Stages / 2;
  static constexpr int kOrder = 2 * static_cast<int>(Stages) - 1, kDegree = static_cast<int>(Stages) + 1;
  static constexpr int kIterations = Control::kIterations, kMostAttempts = 100;
  /// Of what is allowed. The ends of steps of a high order are wrong by little more than what the iteration leaves,
  /// which need not cancel from step to step (`euler_top` at 1e-9).
  static constexpr double kNewtonPart = Stages == 3 ? 0.03 : 0.001;
  /// Than the tolerance. For the high orders, whose steps hardly depend on it, a looser one saves no work.
  static constexpr double kLooser = Stages == 3 ? 5.0 : 1.0;
  /// Newton's iteration converges so fast that the Jacobian serves for another step.
  static constexpr double kServes = 1e-3;
  /// A step so little longer is not worth two factorizations.
  static constexpr double kSame = 1.2;
  static constexpr double kNoSpeed = 1.0;
  static constexpr double kRoundings = 10.0;
  enum Jacobian { kNoJacobian, kOld, kFresh };

  static RadauEigenvalues eigenvalues() {
    RadauEigenvalues all{kTable.gamma, {}};
    for (const auto& pair : kTable.pairs) all.pairs.emplace_back(pair.re, pair.im);
    return all;
  }
  /// Of all stages at state i.
  static std::array<double, Stages> at_state(const std::array<std::vector<double>, Stages>& stages, std::size_t i) {
    std::array<double, Stages> of{};
    for (std::size_t k = 0; k < Stages; ++k) of[k] = stages[k][i];
    return of;
  }

  double shorten(double h, double factor, const char* why) {
    if (stale_ != kFresh) stale_ = kNoJacobian;
    return ImplicitSteps::shorten(h, factor, why);
  }

  bool see_jacobian(double h) {
    ++counts_.jacobians;
    const double factored = std::exchange(factored_, 0.0);
    const double ahead = std::max({time_ - previous_, h, 1e-9 * (limit_ - time_)});
    const auto rates_at_begin = [this](const double* x, double* out) { return rates(time_, x, branch_, out); };
    if (!jacobian_.see({time_, ahead, y_, rate_, branch_}, rates_at_begin, !special_rates_)) return false;
    if (jacobian_.is_as_before()) factored_ = factored;
    stale_ = kFresh;
    return true;
  }

  /// Where Newton's iteration begins: on the polynomial of the step before, or at rest. What is held within a narrow
  /// stretch of a steep law (friction smoothed to less than its tolerance) is lost there by what any polynomial of
  /// states is wrong by.
  void begin_iteration(double h, bool extrapolated) {
    if (!extrapolated || !extrapolates_) {
      for (std::size_t k = 0; k < Stages; ++k) {
        std::fill(z_[k].begin(), z_[k].end(), 0.0);
        std::fill(w_[k].begin(), w_[k].end(), 0.0);
      }
      return;
    }
    const double ratio = h / last_;
    for (std::size_t i = 0; i < size_; ++i) {
      std::array<double, Stages> z{};
      for (std::size_t k = 0; k < Stages; ++k) z[k] = polynomial_.from_end(i, kTable.at[k] * ratio);
      for (std::size_t k = 0; k < Stages; ++k) {
        z_[k][i] = z[k];
        w_[k][i] = radau::dot(kTable.back[k], z);
      }
    }
  }

  /// As iterate(), with all that leads there. What no polynomial leads to may be near the step's beginning.
  double find_stages(double h) {
    if (std::exchange(resumes_, false)) {
      // With slopes of their own the stages follow a law that bends. What ends (a loop's solution) says so in the other
      // iteration.
      if (!loops_ && tears_ == 0 && iterate_by_stages(h)) return 1.0;
      return iterate(h, true, true);
    }
    const bool from_rest = from_rest_;
    const double reduction = iterate(h, !from_rest);
    if (reduction == 1.0 || iterate_by_stages(h)) return 1.0;
    if (faulted_ || !extrapolates_) return reduction;
    const double other = iterate(h, from_rest);
    if (other < 1.0) return std::max(reduction, other);
    from_rest_ = !from_rest;
    return 1.0;
  }

  /// Whether the stages that were found are nearer to the polynomial of the step before than to the step's beginning.
  [[nodiscard]] bool extrapolation_is_nearer(double h) const {
    const double ratio = h / last_;
    double from_polynomial = 0.0, from_rest = 0.0;
    for (std::size_t i = 0; i < size_; ++i)
      for (std::size_t k = 0; k < Stages; ++k) {
        const double extrapolated = polynomial_.from_end(i, kTable.at[k] * ratio), found = z_[k][i];
        from_polynomial += (found - extrapolated) * weight_[i] * ((found - extrapolated) * weight_[i]);
        from_rest += found * weight_[i] * (found * weight_[i]);
      }
    return from_polynomial <= from_rest;
  }

  bool rates_of_stages(double h) {
    for (std::size_t k = 0; k < Stages; ++k)
      for (std::size_t i = 0; i < size_; ++i) stage_[k][i] = y_[i] + z_[k][i];
    std::size_t k = 0;
    if (!loops_ && tears_ == 0 && !special_rates_) k = rates_together(h);
    for (; k < Stages; ++k) {
      const double t = time_ + kTable.at[k] * h;
      if (rates(t, stage_[k].data(), loops_ ? stage_branch_[k] : branch_, right_[k].data())) continue;
      note_fault(t);
      return false;
    }
    return true;
  }
  /// @return  how many of the stages have been evaluated
  std::size_t rates_together(double h) {
    std::size_t k = 0;
    while (k < Stages) {
      Evaluator::Points points;
      points.count = std::min(Evaluator::Points::kMost, Stages - k);
      for (std::size_t j = 0; j < points.count; ++j) {
        points.t[j] = time_ + kTable.at[k + j] * h;
        points.x[j] = stage_[k + j].data();
        points.values[j] = right_[k + j].data();
      }
      if (!evaluator_.rates(points, branch_)) break;
      counts_.rates += static_cast<long>(points.count);
      k += points.count;
    }
    return k;
  }

  /// What the iteration cannot go below.
  [[nodiscard]] double rounding() const { return kRoundings * kEps * norm(y_) / looser_; }

  /// The stages of a step of length h. 1 if they were found, else by how much the step should be shortened.
  /// @param resumes  from the stages that the last call came to.
  double iterate(double h, bool extrapolated, bool resumes = false) {
    constexpr double kDiverged = 0.5, kNoRates = 0.25;
    faulted_ = false;
    bent_ = false;
    reached_ = std::max(newton_part_, rounding());
    if (!resumes) {
      begin_iteration(h, extrapolated);
      if (loops_) stage_branch_.fill(branch_);
      converged_ = std::pow(std::max(converged_, kEps), 0.8);
      speed_ = kServes;
      iterations_ = 0;
    }
    double before = change_, rate_before = speed_;
    for (int iteration = iterations_ + 1; iteration <= kIterations; ++iteration) {
      if (!rates_of_stages(h)) return kNoRates;
      ++counts_.iterations;
      for (std::size_t i = 0; i < size_; ++i) {
        std::array<double, Stages> f = at_state(right_, i);
        for (double& rate : f) rate *= h;
        for (std::size_t k = 0; k < Stages; ++k) right_[k][i] = radau::dot(kTable.back[k], f);
        if (i >= states_) continue;
        right_[0][i] -= kTable.gamma * w_[0][i];
        for (std::size_t k = 1; k < Stages; k += 2) {
          const auto [alpha, beta] = kTable.pairs[k / 2];
          const double v = w_[k][i], w = w_[k + 1][i];
          right_[k][i] = right_[k][i] - alpha * v + beta * w;
          right_[k + 1][i] = right_[k + 1][i] - alpha * w - beta * v;
        }
      }
      systems_->solve_real(right_[0].data());
      for (std::size_t k = 0; k < kPairs; ++k)
        systems_->solve_complex(k, right_[2 * k + 1].data(), right_[2 * k + 2].data());
      double sum = 0.0;
      for (std::size_t k = 0; k < Stages; ++k)
        for (std::size_t i = 0; i < size_; ++i) sum += (right_[k][i] * weight_[i]) * (right_[k][i] * weight_[i]);
      const double change = std::sqrt(sum / static_cast<double>(Stages * size_)) / looser_;
      if (!std::isfinite(change)) return kDiverged;
      if (iteration > 1 && iteration < kIterations) {
        const double rate = change / before;
        speed_ = iteration == 2 ? rate : std::sqrt(rate * rate_before);
        rate_before = rate;
        if (!(speed_ < 0.99)) return kDiverged;
        converged_ = speed_ / (1.0 - speed_);
        const int left = kIterations - 1 - iteration;
        const double at_end = converged_ * change * whole_power(speed_, left) / reached_;
        if (at_end >= 1.0) return 0.8 * std::pow(std::clamp(at_end, 1e-4, 20.0), -1.0 / (4.0 + left));
      }
      before = change_ = std::max(change, kEps);
      const auto& t = kTable.transform;
      for (std::size_t i = 0; i < size_; ++i) {
        std::array<double, Stages> w{};
        for (std::size_t k = 0; k < Stages; ++k) w[k] = w_[k][i] += right_[k][i];
        for (std::size_t k = 0; k < kLast; ++k) z_[k][i] = radau::dot(t[k], w);
        double end = t[kLast][0] * w[0];
        for (std::size_t k = 1; k < Stages; k += 2) end += w[k];  // 1 and 0 of each pair
        z_[kLast][i] = end;
      }
      iterations_ = iteration;
      if (converged_ * change <= reached_) return 1.0;
    }
    return kDiverged;
  }

  /// The same by Newton's method proper, each stage with the Jacobian where it is. At a kink, as of a square root at 0,
  /// slopes differ by orders of magnitude from one stage to the next, and an iteration with the slopes of the step's
  /// beginning converges only for steps far shorter than the error asks for.
  bool iterate_by_stages(double h) {
    if (!stages_ || special_rates_ || faulted_) return false;
    // What the iteration before has come to is a better beginning if it came nearer.
    constexpr double kNearer = 0.5;
    if (!(speed_ < kNearer)) begin_iteration(h, !from_rest_);
    if (loops_) stage_branch_.fill(branch_);
    stages_step_ = h;
    const double reached = std::max(newton_part_, rounding());
    const bool found = stages_->solve(h, y_.data(), z_, weight_.data(), looser_ * reached);
    counts_.iterations += stages_->iterations();
    counts_.jacobians += static_cast<long>(Stages) * stages_->iterations();
    counts_.factorizations += stages_->iterations();
    speed_ = converged_ = kNoSpeed;
    iterations_ = 1;
    bent_ = true;
    return found;
  }
  bool rates_of_stage(std::size_t k, const double* x, double* out) {
    const double t = time_ + kTable.at[k] * stages_step_;
    if (rates(t, x, loops_ ? stage_branch_[k] : branch_, out)) return true;
    note_fault(t);
    return false;
  }
  bool jacobian_of_stage(std::size_t k, const double* x, double* full) {
    const double t = time_ + kTable.at[k] * stages_step_;
    if (jacobian_.see_stage(t, x, loops_ ? stage_branch_[k] : branch_, full)) return true;
    note_fault(t);
    return false;
  }

  /// The distance from the embedded formula, filtered by the real system. Where this is large at a first step or after
  /// a rejection, it is filtered once more: the formula alone is not bounded for stiff components.
  double estimate_error(double h) {
    for (std::size_t i = 0; i < size_; ++i) {
      increment_[i] = i < states_ ? radau::dot(kTable.error, at_state(z_, i)) : 0.0;
      error_[i] = increment_[i] + h * rate_[i];
    }
    raw_ = error_;
    systems_->solve_real(error_.data());
    double error = norm(error_) / looser_;
    if (error >= 1.0 && (first_ || rejected_)) {
      for (std::size_t i = 0; i < size_; ++i) at_[i] = y_[i] + error_[i];
      if (rates(time_, at_.data(), loops_ ? stage_branch_[0] : branch_, right_[0].data())) {
        for (std::size_t i = 0; i < size_; ++i) error_[i] = increment_[i] + h * right_[0][i];
        raw_ = error_;
        systems_->solve_real(error_.data());
        error = norm(error_) / looser_;
      }
    }
    if (!std::isfinite(error)) return 1e10;
    return std::max(error, 1e-10);
  }

  /// Whether the iteration has come to the stages: that it would is taken from its rounds before, or from the steps
  /// before where it had one. The rates at the step's end, which are known by now, say what the next round would have
  /// changed there. (A mass that friction, smoothed to the width of its tolerance, no longer holds: with slopes that
  /// are far too steep by now all changes are small, and grow.)
  bool is_solved(double h) {
    // The high orders iterate to a thousandth of what is allowed, where rounding of their transformation begins.
    if (bent_ || Stages > 3) return true;
    for (std::size_t i = 0; i < size_; ++i)
      increment_[i] = i < states_ ? h * rate_[i] - radau::dot(kTable.inverse[kLast], at_state(z_, i)) : 0.0;
    const double defect = norm(increment_);
    if (defect <= kTable.gamma * looser_ * reached_) return true;  // nothing that the slopes damp
    systems_->solve_real(increment_.data());
    const double next = norm(increment_) / looser_;
    // What shrinks to a tenth in a round may be as much more than what one round later is left.
    constexpr double kShrinks = 0.1;
    return next <= std::max(reached_, rounding()) || next <= std::min(kShrinks * change_, reached_ / kShrinks);
  }

  /// The error of an accepted step by the slopes at its end, where these let go what those at its beginning held. 0
  /// where they do not. Slopes that were seen serve for the next step.
  double released_error(double h) {
    if (!lets_go(h, kTable.gamma, kTable.gamma * looser_)) return 0.0;
    factored_ = 0.0;
    if (!see_jacobian(h) || !systems_->factor(h, jacobian_.values(), weight_.data())) {
      stale_ = kNoJacobian;
      return 0.0;
    }
    ++counts_.factorizations;
    factored_ = h;
    error_ = raw_;
    systems_->solve_real(error_.data());
    const double error = norm(error_) / looser_;
    seen_at_end_ = error < 1.0;
    if (!seen_at_end_) stale_ = kNoJacobian;
    return std::isfinite(error) ? error : 1e10;
  }

  void finish(double h, double error, double quotient) {
    jacobian_.stepped();
    if (from_rest_ && extrapolation_is_nearer(h)) from_rest_ = false;
    order_ = kDegree;
    by_hand_ = false;
    ++counts_.steps;
    double next = control_.next_length(h, error, quotient, rejected_);
    polynomial_.fit(z_);
    last_ = h;
    extrapolates_ = true;
    first_ = rejected_ = false;
    // A rate that one iteration leaves unknown says nothing: with slopes that are far too steep by now any guess passes
    // for converged, and for exact. (A tank that runs empty: the slope of its root is beyond all bounds.)
    if (std::exchange(seen_at_end_, false))
      stale_ = kFresh;
    else
      stale_ = iterations_ > 1 && speed_ <= kServes ? kOld : kNoJacobian;
    if (speed_ <= kServes && next >= h && next <= kSame * h) next = h;
    next_ = next;
  }

  /// What the collocation polynomial needs to satisfy the (linearized) equations at one more point. With d = h f -
  /// M p' there, bubble (kGamma M - h J) bend = d.
  /// @return  how large it is: what the polynomial is wrong by within the step, relative to what is allowed. The
  ///          embedded formula alone does not see it where stiffness holds the stages on the solution. Negative: no
  ///          rates there.
  double correct(double h) {
    const double t = time_ + kTable.corrected_at * h;
    for (std::size_t i = 0; i < size_; ++i) {
      double at = y_[i];
      for (std::size_t k = 0; k < Stages; ++k) at += kTable.value[k] * z_[k][i];
      at_[i] = at;
    }
    if (loops_) probe_ = stage_branch_[radau::corrected_stage<Stages>()];
    if (!rates(t, at_.data(), loops_ ? probe_ : branch_, increment_.data())) {
      note_fault(t);
      return -1.0;
    }
    constexpr double bubble = radau::bubble<Stages>(kTable.corrected_at);
    for (std::size_t i = 0; i < size_; ++i)
      bend_[i] = (h * increment_[i] - (i < states_ ? radau::dot(kTable.slope, at_state(z_, i)) : 0.0)) / bubble;
    systems_->solve_real(bend_.data());
    const double size = kTable.largest_bubble * norm(bend_) / looser_;
    return std::isfinite(size) ? size : 1e10;
  }

  std::unique_ptr<RadauSystems> systems_;
  RadauJacobian jacobian_;
  Control control_;
  RadauPolynomial<Stages> polynomial_;   ///< of the last step
  std::unique_ptr<RadauStages> stages_;  ///< null for sparse systems
  double stages_step_ = 0.0;             ///< that stages_ solves for
  double looser_ = 1.0;                  ///< than the tolerances: what the error of order 3 may be
  double newton_part_ = kNewtonPart;
  std::array<std::vector<double>, Stages> z_, w_;  ///< the stages' increments; the same in the basis of eigenvectors
  std::array<Branch, Stages> stage_branch_;        ///< where rates solve loops: each stage from its own last solution
  double last_ = 1.0;                              ///< step
  Jacobian stale_ = kNoJacobian;
  bool extrapolates_ = false, from_rest_ = false;
  bool seen_at_end_ = false;  ///< the Jacobian is that of the last step's end
  double speed_ = kNoSpeed;   ///< of Newton's iteration: the rate
  double converged_ = 1.0;    ///< the same: the sum of what is left by what was last
  bool bent_ = false;         ///< the stages were found with a Jacobian each
  int iterations_ = 0;
  bool resumes_ = false;                 ///< the iteration goes on where it was
  double change_ = 0.0, reached_ = 0.0;  ///< of the stages by the last round of it; what it may leave
  std::vector<double> bend_;             ///< see correct()
  // Scratch
  std::array<std::vector<double>, Stages> right_, stage_;
};

}  // namespace

std::unique_ptr<Integrator> make_radau_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                  const RunInputs& inputs, int order, Loops loops) {
  if (order == 13) return std::make_unique<RadauIntegrator<7>>(program, evaluator, tolerances, inputs, loops);
  if (order == 9) return std::make_unique<RadauIntegrator<5>>(program, evaluator, tolerances, inputs, loops);
  return std::make_unique<RadauIntegrator<3>>(program, evaluator, tolerances, inputs, loops);
}

}  // namespace bgsim
