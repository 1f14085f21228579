// The explicit Runge-Kutta method of J. R. Dormand and P. J. Prince, of order 5 with an error estimate of order 4, as
// in the program DOPRI5 (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, II.4 to
// II.6): proportional and integral step control, dense output of order 4 by the stages of the step, whose last one is
// the first of the next.
//
// ARKODE has the same method (erk5). For the thousands of states that this one is for, its time is vector sums and a
// seventh evaluation in each step.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "run/integrate/butcher_tables.hpp"
#include "run/integrate/dormand_prince_formula.hpp"
#include "run/integrate/own_steps.hpp"
#include "run/integrate/packages.hpp"

namespace bgsim {

namespace {

/// h (c[0] k[0] + c[1] k[1] + ...), component by component.
template <std::size_t kTerms>
struct Sum {
  std::array<double, kTerms> factors;
  std::array<const double*, kTerms> terms;
  [[nodiscard]] double at(std::size_t i) const {
    double sum = factors[0] * terms[0][i];
    for (std::size_t k = 1; k < kTerms; ++k) sum += factors[k] * terms[k][i];
    return sum;
  }
};

class DormandPrinceIntegrator final : public OwnSteps {
 public:
  DormandPrinceIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs)
      : OwnSteps(program, evaluator, tolerances, inputs),
        program_(program),
        table_(butcher_table(Method::erk5)),
        entries_(program.jacobian_pattern.row.size()) {
    order_ = dormand_prince::kDenseOrder;
    for (std::vector<double>& stage : stage_) stage.assign(size_, 0.0);
  }

  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    if (!begin_at(t, x, branch, limit)) return fault(t);
    bent_known_ = false;
    error_before_ = kLeastError;
    if (!rates(t, y_.data(), stage_[kLast])) return fault(t);
    look(t);
    return true;
  }

  bool advance() override {
    failure_ = {};
    faulted_ = false;
    if (by_hand_ && !rates(time_, y_.data(), stage_[kLast])) return fault(time_);
    if (limit_is_at_hand()) {
      step_by_hand(stage_[kLast]);
      return true;
    }
    previous_ = time_;
    begin_ = y_;
    if (loops_) branch_at_begin_ = branch_;
    std::swap(stage_.front(), stage_[kLast]);
    bent_known_ = by_hand_ = false;
    if (!(next_ > 0.0)) next_ = first_step();
    double h = fit(next_);
    tolerances_.weights(time_, h, y_.data(), weight_.data());
    if (kEps * norm(y_) > 1.0) {
      failure_.too_accurate = true;
      return fail(kTooAccurateText);
    }
    const char* words = kErrorTestText;
    int faults = 0, failures = 0;
    while (faults < kMostFaults && failures < kMostErrorTestFailures) {
      // Time that no longer advances by the step is the run's matter as long as there is a step. One to the limit needs
      // no resolution.
      if (h < limit_ - time_ && !(time_ + 0.1 * h > time_)) break;
      const double end = h >= limit_ - time_ ? limit_ : time_ + h;
      if (!take_stages(h, end)) {
        ++faults;
        words = kStateEquationsText;
        rejected_ = true;
        h *= 0.25;
        continue;
      }
      step_ = h;
      const double error = std::max(error_norm(), kLeastError);
      if (error < 1.0) {
        finish(end, error);
        return true;
      }
      ++failures;
      ++counts_.error_failures;
      words = kErrorTestText;
      faulted_ = false;
      rejected_ = true;
      if (loops_) branch_ = branch_at_begin_;
      h = std::isfinite(error) ? h / std::min(kMostCut, std::pow(error, kOfThisError) / kSafety) : h / kMostCut;
    }
    y_ = begin_;
    if (loops_) branch_ = branch_at_begin_;
    std::swap(stage_.front(), stage_[kLast]);  // where a next advance() expects them
    return fail(words);
  }

  void interpolate(double t, double* y) override {
    if (is_end(t, y)) return;
    bend();
    const double u = (t - previous_) / (time_ - previous_), v = 1.0 - u, h = step_;
    const double *first = stage_.front().data(), *last = stage_[kLast].data();
    for (std::size_t i = 0; i < size_; ++i) {
      const double change = y_[i] - begin_[i], left = h * first[i] - change, right = change - h * last[i] - left;
      y[i] = begin_[i] + u * (change + v * (left + u * (right + v * at_[i])));
    }
  }

  [[nodiscard]] std::string method() const override { return "Dormand-Prince 5(4)"; }
  void weighted_errors(double* error) override {
    const auto estimate = error_sum();
    for (std::size_t i = 0; i < size_; ++i) error[i] = std::abs(step_ * estimate.at(i) * weight_[i]);
  }

 private:
  static constexpr std::size_t kStages = 7, kLast = kStages - 1;
  static constexpr int kMostFaults = 60, kStepsBetweenLooks = 50;
  // DOPRI5's: safety, exponents of this step's error and the one before, bounds of a change.
  static constexpr double kSafety = 0.9, kOfErrorBefore = 0.04, kOfThisError = 0.2 - 0.75 * kOfErrorBefore,
                          kMostCut = 5.0, kMostGrowth = 10.0, kLeastError = 1e-4;

  bool rates(double t, const double* x, std::vector<double>& out) {
    if (OwnSteps::rates(t, x, branch_, out.data())) return true;
    note_fault(t);
    return false;
  }
  [[nodiscard]] double norm(const std::vector<double>& x) const {
    return root_of_mean([&](std::size_t i) { return x[i] * weight_[i]; });
  }
  /// In parts that do not wait for each other.
  template <class Part>
  [[nodiscard]] double root_of_mean(const Part& part) const {
    constexpr std::size_t kSums = 8;
    std::array<double, kSums> sums{};
    std::size_t i = 0;
    for (; i + kSums <= size_; i += kSums)
      for (std::size_t k = 0; k < kSums; ++k) {
        const double one = part(i + k);
        sums[k] += one * one;
      }
    for (; i < size_; ++i) sums[0] += part(i) * part(i);
    double sum = 0.0;
    for (const double one : sums) sum += one;
    return std::sqrt(sum / static_cast<double>(size_));
  }

  /// at = begin_ + h * (the row's sum of stages).
  template <std::size_t kTerms>
  void add_stages(double h, const double* row, const std::array<std::size_t, kTerms>& which,
                  std::vector<double>& at) const {
    Sum<kTerms> sum{};
    for (std::size_t k = 0; k < kTerms; ++k) {
      sum.factors[k] = h * row[which[k]];
      sum.terms[k] = stage_[which[k]].data();
    }
    double* __restrict out = at.data();
    const double* from = begin_.data();
    for (std::size_t i = 0; i < size_; ++i) out[i] = from[i] + sum.at(i);
  }

  /// All stages but the first, which is known; the state at the end. False if one cannot be evaluated.
  bool take_stages(double h, double end) {
    double** a = table_->A;
    const double* c = table_->c;
    const auto stage = [&](std::size_t k) { return rates(time_ + c[k] * h, at_.data(), stage_[k]); };
    const bool known = [&] {
      add_stages<1>(h, a[1], {0}, at_);
      if (!stage(1)) return false;
      add_stages<2>(h, a[2], {0, 1}, at_);
      if (!stage(2)) return false;
      add_stages<3>(h, a[3], {0, 1, 2}, at_);
      if (!stage(3)) return false;
      add_stages<4>(h, a[4], {0, 1, 2, 3}, at_);
      if (!stage(4)) return false;
      add_stages<5>(h, a[5], {0, 1, 2, 3, 4}, at_);
      if (!stage(5)) return false;
      add_stages<5>(h, a[6], {0, 2, 3, 4, 5}, y_);
      return rates(end, y_.data(), stage_[kLast]);
    }();
    if (!known && loops_) branch_ = branch_at_begin_;
    return known;
  }

  [[nodiscard]] Sum<6> error_sum() const {
    constexpr std::array<std::size_t, 6> kWhich{0, 2, 3, 4, 5, 6};
    Sum<6> sum{};
    for (std::size_t k = 0; k < kWhich.size(); ++k) {
      sum.factors[k] = table_->b[kWhich[k]] - table_->d[kWhich[k]];
      sum.terms[k] = stage_[kWhich[k]].data();
    }
    return sum;
  }
  [[nodiscard]] double error_norm() const {
    const auto sum = error_sum();
    const double* weight = weight_.data();
    const double error = step_ * root_of_mean([&](std::size_t i) { return sum.at(i) * weight[i]; });
    return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
  }

  void finish(double end, double error) {
    ++counts_.steps;
    double quotient = std::pow(error, kOfThisError) / std::pow(error_before_, kOfErrorBefore) / kSafety;
    quotient = std::clamp(quotient, 1.0 / kMostGrowth, kMostCut);
    next_ = step_ / quotient;
    if (rejected_) next_ = std::min(next_, step_);
    error_before_ = error;
    time_ = end;
    first_ = rejected_ = false;
    order_ = dormand_prince::kDenseOrder;
    if (++steps_since_look_ >= kStepsBetweenLooks) look(time_);
  }

  /// What the dense output has beyond Hermite's cubic; once a step.
  void bend() {
    if (std::exchange(bent_known_, true)) return;
    Sum<6> sum{};
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t stage = k == 0 ? 0 : k + 1;
      sum.factors[k] = step_ * dormand_prince::kBend[stage];
      sum.terms[k] = stage_[stage].data();
    }
    for (std::size_t i = 0; i < size_; ++i) at_[i] = sum.at(i);
  }

  /// From the rates and how fast they change. Hairer, Norsett, Wanner 1993, II.4.
  double first_step() {
    constexpr double kPart = 0.01, kLongest = 100.0;
    const double left = limit_ - time_;
    tolerances_.weights(time_, left, y_.data(), weight_.data());
    const std::vector<double>& rate = stage_.front();
    const double size = norm(y_), speed = norm(rate);
    double probe = speed > 0.0 && size > 0.0 ? kPart * size / speed : 1e-6 * left;
    probe = std::min(probe, 1e-3 * left);
    for (std::size_t i = 0; i < size_; ++i) at_[i] = y_[i] + probe * rate[i];
    const Branch kept = loops_ ? branch_ : Branch{};
    const bool known = rates(time_ + probe, at_.data(), stage_[1]);
    if (loops_) branch_ = kept;
    faulted_ = false;
    if (!known) return 1e-3 * probe;
    const double bend = root_of_mean([&](std::size_t i) { return (stage_[1][i] - rate[i]) * weight_[i]; }) / probe;
    const double most = std::max(speed, bend);
    const double h = most > 0.0 && std::isfinite(most) ? std::pow(kPart / most, 1.0 / 5.0) : left;
    return std::min({h, kLongest * probe, left});
  }

  /// The method has no use for the Jacobian, but the tolerances have: it tells what rounding leaves unknowable, also
  /// while friction holds a block, whose speed is then rounding alone.
  void look(double t) {
    steps_since_look_ = 0;
    Branch branch = branch_;
    if (!evaluator_.jacobian(t, y_.data(), branch, entries_.data(), rounding_)) return;
    tolerances_.see({t, y_.data(), program_.jacobian_pattern, entries_.data(), rounding_},
                    [&](double at, const double* x, double* f) { return evaluator_.rates(at, x, branch, f); });
  }

  const Program& program_;
  ButcherTableHandle table_;
  std::array<std::vector<double>, kStages> stage_;  ///< rates; between two steps the last one is the next one's first
  double step_ = 0.0;                               ///< the last one
  double error_before_ = kLeastError;
  bool bent_known_ = false;  ///< at_ (scratch) is what bend() says
  int steps_since_look_ = 0;
  // Scratch
  std::vector<double> entries_, rounding_;
};

}  // namespace

std::unique_ptr<Integrator> make_dormand_prince_integrator(const Program& program, Evaluator& evaluator,
                                                           Tolerances& tolerances, const RunInputs& inputs) {
  return std::make_unique<DormandPrinceIntegrator>(program, evaluator, tolerances, inputs);
}

}  // namespace bgsim
