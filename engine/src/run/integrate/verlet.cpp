// Störmer-Verlet (kick, drift, kick). E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2006, I.1.4.
#include <algorithm>
#include <cmath>

#include "run/integrate/integrator.hpp"
#include "run/integrate/separability.hpp"

namespace bgsim {

namespace {

class VerletIntegrator final : public Integrator {
 public:
  VerletIntegrator(const Program& program, Evaluator& evaluator, const RunInputs& inputs, Halves halves)
      : Integrator(inputs.stop - inputs.start),
        evaluator_(evaluator),
        fixed_step_(inputs.step),
        kicked_(std::move(halves)),
        x_(program.state_names.size()),
        begin_(x_),
        rate_(x_),
        rate_at_begin_(x_),
        rate_at_end_(x_) {
    size_ = x_.size();
    order_ = kDegree;
  }

  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    std::copy(x, x + size_, x_.begin());
    branch_ = branch;
    time_ = previous_ = t;
    limit_ = limit;
    length_ = even_step(t, limit, fixed_step_);
    left_ = static_cast<std::uint64_t>(std::llround((limit - t) / length_));
    failure_ = {};
    return evaluate(t);
  }

  bool advance() override {
    failure_ = {};
    previous_ = time_;
    begin_ = x_;
    ends_known_ = false;
    const double next = left_ <= 1 ? limit_ : time_ + length_;
    const double h = next - time_;
    // rate_ holds the kicked states' rates here; those of the drifting ones are of no use before the kick
    kick(h / 2.0);
    if (!evaluate(time_ + h / 2.0)) return false;
    for (std::size_t i = 0; i < size_; ++i)
      if (!kicked_[i]) x_[i] += h * rate_[i];
    if (!evaluate(next)) return false;
    kick(h / 2.0);
    time_ = next;
    if (left_ > 0) --left_;
    ++counts_.steps;
    return true;
  }

  /// Hermite's cubic: its error is below the method's.
  void interpolate(double t, double* y) override {
    const double h = time_ - previous_;
    if (t == time_ || !(h > 0.0) || !know_ends()) {
      std::copy(x_.begin(), x_.end(), y);
      return;
    }
    const double u = (t - previous_) / h, v = 1.0 - u;
    for (std::size_t i = 0; i < size_; ++i)
      y[i] = v * v * ((1.0 + 2.0 * u) * begin_[i] + u * h * rate_at_begin_[i]) +
             u * u * ((1.0 + 2.0 * v) * x_[i] - v * h * rate_at_end_[i]);
  }

  [[nodiscard]] const double* end() const override { return x_.data(); }
  [[nodiscard]] bool one_step() const override { return true; }
  [[nodiscard]] std::string method() const override { return "Störmer-Verlet, steps of one length"; }
  [[nodiscard]] Counts counts() const override { return counts_; }
  void weighted_errors(double* error) override { std::fill(error, error + size_, 0.0); }

 private:
  static constexpr int kDegree = 3;

  bool evaluate(double t) {
    ++counts_.rates;
    if (evaluator_.rates(t, x_.data(), branch_, rate_.data())) return true;
    failure_.fault = true;
    failure_.words = "the state equations could not be evaluated";
    last_fault_ = evaluator_.fault();
    last_fault_.time = t;
    return false;
  }

  void kick(double h) {
    for (std::size_t i = 0; i < size_; ++i)
      if (kicked_[i]) x_[i] += h * rate_[i];
  }

  /// All rates at both ends of the step, for those who ask for what lies between.
  bool know_ends() {
    if (ends_known_) return true;
    counts_.rates += 2;
    ends_known_ = evaluator_.rates(previous_, begin_.data(), branch_, rate_at_begin_.data()) &&
                  evaluator_.rates(time_, x_.data(), branch_, rate_at_end_.data());
    return ends_known_;
  }

  Evaluator& evaluator_;
  double fixed_step_, length_ = 0.0, limit_ = 0.0;
  std::uint64_t left_ = 0;  ///< steps to the limit
  Halves kicked_;
  std::vector<double> x_, begin_, rate_, rate_at_begin_, rate_at_end_;
  bool ends_known_ = false;
  Counts counts_;
};

}  // namespace

std::unique_ptr<Integrator> make_verlet_integrator(const Program& program, Evaluator& evaluator,
                                                   const RunInputs& inputs) {
  NotSeparable obstacle;
  auto halves = separate(program, obstacle);
  if (!halves) return nullptr;
  return std::make_unique<VerletIntegrator>(program, evaluator, inputs, std::move(*halves));
}

}  // namespace bgsim
