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
#include "run/integrate/own_steps.hpp"
#include "run/integrate/packages.hpp"
#include "run/integrate/radau_formula.hpp"
#include "run/integrate/radau_jacobian.hpp"
#include "run/integrate/real_system.hpp"
#include "run/integrate/rodas_formula.hpp"

namespace bgsim {

namespace {

/// Gustafsson's predictive control: as errors went from the step before to this one, they go to the next.
class RodasControl {
 public:
  /// A new stretch.
  void begin() { accepted_ = 0; }

  /// By what a step of that error is divided.
  [[nodiscard]] static double quotient_of(double error) {
    return std::clamp(std::pow(error, kPower) / kSafety, kMostGrowth, kMostCut);
  }

  /// After a step of length @p h that was accepted.
  /// @param rejected  whether a longer one was not
  double next_length(double h, double error, bool rejected) {
    double quotient = quotient_of(error);
    if (++accepted_ > 1) {
      const double predicted = (step_ / h) * std::pow(error * error / error_, kPower) / kSafety;
      quotient = std::max(quotient, std::clamp(predicted, kMostGrowth, kMostCut));
    }
    step_ = h;
    error_ = std::max(1e-2, error);
    return rejected ? std::min(h / quotient, h) : h / quotient;
  }

 private:
  /// The error that is held is of order 4.
  static constexpr double kPower = 1.0 / 5.0;
  static constexpr double kSafety = 0.9, kMostCut = 5.0, kMostGrowth = 1.0 / 6.0;
  std::uint64_t accepted_ = 0;
  double step_ = 0.0, error_ = 0.0;  ///< of the last one
};

class RodasIntegrator final : public OwnSteps {
 public:
  RodasIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs)
      : OwnSteps(inputs.stop - inputs.start),
        evaluator_(evaluator),
        tolerances_(tolerances),
        system_(make_real_system(program.jacobian_pattern)),
        jacobian_(program, evaluator, tolerances, system_->dense()),
        loops_(!program.blocks.empty()) {
    size_ = program.state_names.size();
    order_ = kDegree;
    for (auto* const vector :
         {&y_, &begin_, &rate_, &rate_at_begin_, &weight_, &slope_, &at_, &right_, &error_, &raw_, &increment_})
      vector->assign(size_, 0.0);
    for (std::vector<double>& vector : dense_) vector.assign(size_, 0.0);
    stage_.assign(rodas::kStages * size_, 0.0);
  }

  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    std::copy(x, x + size_, y_.begin());
    begin_ = y_;
    branch_ = branch;
    time_ = previous_ = t;
    limit_ = limit;
    failure_ = {};
    by_hand_ = false;
    first_ = true;
    rejected_ = false;
    jacobian_.begin();
    seen_ = false;
    factored_ = 0.0;
    control_.begin();
    next_ = std::exchange(first_step_, 0.0);
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
    if (!(next_ > 0.0)) next_ = first_step();
    double h = fit(next_);
    tolerances_.weights(time_, h, y_.data(), weight_.data());
    for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
      // Time that no longer advances by the step is the run's matter as long as there is a step. One to the limit needs
      // no resolution.
      if (h < limit_ - time_ && !(time_ + 0.1 * h > time_)) return fail(words_);
      if (!seen_) {
        if (!see_slopes(h)) return fault(time_);
        tolerances_.weights(time_, h, y_.data(), weight_.data());
      }
      if (attempt == 0) {
        // Only now: what the Jacobian is like a little further on is asked by how far the step before went.
        previous_ = time_;
        begin_ = y_;
        if (kEps * norm(y_) > 1.0) {
          failure_.too_accurate = true;
          return fail(kTooAccurateText);
        }
      }
      if (factored_ != h) {
        factored_ = 0.0;
        ++counts_.factorizations;
        if (!system_->factor(rodas::kShift, h, slopes_)) {
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
        if (!accept(h)) {  // no rates at the end
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
  void weighted_errors(double* error) override {
    for (std::size_t i = 0; i < size_; ++i) error[i] = std::abs(error_[i] * weight_[i]);
  }

 private:
  static constexpr int kDegree = 4, kMostAttempts = 100;
  /// Of a system that is not written out: a step so little longer is not worth a factorization.
  static constexpr double kSame = 1.2;
  static constexpr std::size_t kWrittenOut = 8;

  bool rates(double t, const double* x, Branch& branch, double* out) {
    ++counts_.rates;
    return special_rates_ ? special_rates_(t, x, branch, out) : evaluator_.rates(t, x, branch, out);
  }
  void note_fault(double t) {
    faulted_ = true;
    last_fault_ = evaluator_.fault();
    last_fault_.time = t;
  }
  bool fault(double t) {
    note_fault(t);
    return fail(kStateEquationsText);
  }
  /// @return  the next length to try.
  double shorten(double h, double factor, const char* why) {
    ++counts_.convergence_failures;
    words_ = why;
    rejected_ = true;
    if (loops_) branch_ = branch_at_begin_;
    return factor * h;
  }

  [[nodiscard]] double norm(const std::vector<double>& x) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < size_; ++i) sum += (x[i] * weight_[i]) * (x[i] * weight_[i]);
    return std::sqrt(sum / static_cast<double>(size_));
  }

  /// A first step of some tens of roundings of the time is not made shorter: over it the tolerances of states that have
  /// just begun to move are below what rounding makes of the stages.
  [[nodiscard]] double judged(double h, double error) const {
    constexpr double kRoundings = 32.0, kPasses = 0.5, kNotFinite = 1e10;
    return first_ && h <= kRoundings * kEps * std::abs(time_) && error < kNotFinite ? std::min(error, kPasses) : error;
  }

  /// From the rates and how fast they change.
  double first_step() {
    const double left = limit_ - time_;
    tolerances_.weights(time_, left, y_.data(), weight_.data());
    const double size = norm(y_), speed = norm(rate_);
    double probe = speed > 0.0 && size > 0.0 ? 0.01 * size / speed : 1e-6 * left;
    probe = std::min(probe, 1e-3 * left);
    if (loops_) probe_ = branch_;
    for (std::size_t i = 0; i < size_; ++i) at_[i] = y_[i] + probe * rate_[i];
    if (!rates(time_ + probe, at_.data(), loops_ ? probe_ : branch_, error_.data())) return 1e-3 * probe;
    for (std::size_t i = 0; i < size_; ++i) error_[i] = (error_[i] - rate_[i]) / probe;
    constexpr double kExponent = 1.0 / 4.0;  // the embedded formula's order
    const double h = radau::first_length(kExponent, speed, norm(error_), left);
    std::fill(error_.begin(), error_.end(), 0.0);
    return longest_ > 0.0 ? std::min(h, longest_) : h;
  }

  /// By states and by time, where the step begins.
  bool see_slopes(double h) {
    ++counts_.jacobians;
    const double factored = std::exchange(factored_, 0.0);
    const double ahead = std::max({time_ - previous_, h, 1e-9 * (limit_ - time_)});
    const auto rates_at_begin = [this](const double* x, double* out) { return rates(time_, x, branch_, out); };
    if (special_rates_ && system_->dense()) {
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
    if (!special_rates_ && evaluator_.time_slopes(time_, y_.data(), branch, slope_.data())) return;
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
    for (std::size_t i = 0; i < size_; ++i) right_[i] = h * rate[i] + sum_of<K>(rodas::kRight[K], i);
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
      right_[i] = h * right_[i] - slope;
    }
    system_->solve(right_.data());
    const double size = rodas::kLargestBubble / rodas::bubble(u) * norm(right_);
    return std::isfinite(size) ? size : 1e10;
  }

  /// The step's end, which increment_ leads to. False if there are no rates.
  bool accept(double h) {
    rate_at_begin_ = rate_;
    for (std::size_t i = 0; i < size_; ++i) y_[i] = begin_[i] + increment_[i];
    const double end = h >= limit_ - time_ ? limit_ : time_ + h;
    if (loops_) branch_ = stage_branch_;
    if (!rates(end, y_.data(), branch_, rate_.data())) {
      note_fault(end);
      y_ = begin_;
      rate_ = rate_at_begin_;
      return false;
    }
    time_ = end;
    return true;
  }

  void take_back() {
    y_ = begin_;
    rate_ = rate_at_begin_;
    time_ = previous_;
    if (loops_) branch_ = branch_at_begin_;
  }

  /// The error of an accepted step by the slopes at its end, where these no longer damp what those at its beginning
  /// did, as in a step by Radau IIA: a filter as stiff as the beginning hides by how much the step missed the instant
  /// at which a fast state is let go. 0 where they do. Slopes that were seen serve for the next step.
  double released_error(double h) {
    constexpr double kDamped = 0.5, kLeast = rodas::kShift;
    seen_ = false;
    if (!(norm(raw_) > kLeast)) return 0.0;  // it would have passed without damping
    for (std::size_t i = 0; i < size_; ++i) at_[i] = y_[i] + error_[i];
    if (loops_) probe_ = branch_;
    if (!rates(time_, at_.data(), loops_ ? probe_ : branch_, increment_.data())) return 0.0;
    bool let_go = false;
    for (std::size_t i = 0; i < size_ && !let_go; ++i) {
      const double damped = rodas::kShift * error_[i] - h * (increment_[i] - rate_[i]);
      let_go = std::abs(raw_[i] * weight_[i]) > kLeast && std::abs(damped) < kDamped * std::abs(raw_[i]);
    }
    if (!let_go) return 0.0;
    factored_ = 0.0;
    if (!see_slopes(h)) return 0.0;
    ++counts_.factorizations;
    if (!system_->factor(rodas::kShift, h, slopes_)) return 0.0;
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
    next_ = control_.next_length(h, error, rejected_);
    first_ = rejected_ = false;
    if (size_ > kWrittenOut && next_ >= h && next_ <= kSame * h) next_ = h;
  }

  Evaluator& evaluator_;
  Tolerances& tolerances_;
  std::unique_ptr<RealSystem> system_;
  RadauJacobian jacobian_;
  RodasControl control_;
  bool loops_;  ///< rates solve loops, each stage from the solution of the one before
  std::vector<double> rate_, rate_at_begin_, weight_;
  std::vector<double> slope_;                 ///< of the rates by time
  std::vector<double> held_;                  ///< their Jacobian where they hold a friction
  const double* slopes_ = nullptr;            ///< the Jacobian of the step
  std::vector<double> stage_;                 ///< the stages' increments, by state
  std::array<std::vector<double>, 3> dense_;  ///< of the dense output
  Branch branch_at_begin_, stage_branch_, probe_;
  double next_ = 0.0;            ///< the next step, 0: not known
  double factored_ = 0.0;        ///< step that system_ is for; 0: none
  bool seen_ = false;            ///< slopes are those of where the step begins
  bool slopes_by_time_ = false;  ///< they are not all 0
  bool rejected_ = false;
  const char* words_ = kErrorTestText;
  // Scratch
  std::vector<double> at_, right_, error_, raw_, increment_;
};

}  // namespace

std::unique_ptr<Integrator> make_rodas_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                  const RunInputs& inputs) {
  return std::make_unique<RodasIntegrator>(program, evaluator, tolerances, inputs);
}

}  // namespace bgsim
