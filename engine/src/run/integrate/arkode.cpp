#include <algorithm>
#include <cmath>
#include <limits>

#include "run/integrate/butcher_tables.hpp"
#include "run/integrate/ode.hpp"

namespace bgsim {

double even_step(double from, double to, double longest) {
  // A quotient that is whole but for its rounding does not ask for one step more.
  constexpr double kRounding = 1e-9;
  const double steps = std::max(1.0, std::ceil((to - from) / longest * (1.0 - kRounding)));
  return (to - from) / steps;
}

namespace {

class ArkodeIntegrator final : public OdeBy<Arkode> {
 public:
  ArkodeIntegrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances, const RunInputs& inputs)
      : OdeBy(program, evaluator, tolerances, inputs.stop - inputs.start),
        facts_(facts_of(inputs.method)),
        fixed_step_(inputs.step),
        table_(butcher_table(inputs.method)),
        begin_(make_vector(context_.get(), size_)) {
    newton_ = facts_.implicit();
  }

  bool restart(double t, const double* x, const Branch& branch, double limit) override {
    if (!begin(t, x, branch, limit)) return fault(t);
    if (!facts_.implicit() && !facts_.fixed_step()) look(t);
    begin_here();
    first_ = true;
    if (facts_.fixed_step()) {
      const double length = even_step(t, limit, fixed_step_);
      left_ = static_cast<std::uint64_t>(std::llround((limit - t) / length));
      ARKStepSetFixedStep(memory(), length / unit_);
    }
    failure_ = {};
    return true;
  }

  bool advance() override {
    constexpr int kMostRetries = 60;
    failure_ = {};
    faulted_ = false;
    if (limit_is_at_hand()) return step_by_hand() || fault(time_);
    previous_ = time_;
    N_VScale(1.0, y_.get(), begin_.get());
    // Roundings of the steps before go into the last one, instead of into one more.
    if (facts_.fixed_step() && left_-- == 1) ARKStepSetFixedStep(memory(), (limit_ - time_) / unit_);
    for (int attempt = 0;; ++attempt) {
      double reached = time_ / unit_;
      const int flag = ARKStepEvolve(memory(), limit_ / unit_, y_.get(), &reached, ARK_ONE_STEP);
      if (flag >= 0) {
        stepped(flag, reached);
        first_ = false;
        order_ = degree();
        if (!facts_.implicit() && !facts_.fixed_step() && ++steps_since_look_ >= kStepsBetweenLooks) look(time_);
        return true;
      }
      // ARKODE's explicit stages do not try again with a shorter step where the equations have no value, nor the search
      // for the first step of a stretch.
      const bool retry = faulted_ && (!facts_.implicit() || first_) && !facts_.fixed_step() && attempt < kMostRetries;
      if (!retry || !shorten()) return stepped(flag, reached);
    }
  }

  [[nodiscard]] bool one_step() const override { return true; }
  [[nodiscard]] std::string method() const override {
    std::string text = facts_.words;
    if (facts_.fixed_step()) text += ", steps of one length";
    if (facts_.implicit()) text += linear_algebra();
    return text;
  }

 private:
  static constexpr int kStepsBetweenLooks = 50, kPredictorOfFullOrder = 1, kMostIterations = 6, kCubic = 3;
  static constexpr double kIterationError = 0.03;

  /// ARKODE with the state as it is in y_, at time_.
  void begin_here() {
    const double s = time_ / unit_;
    if (memory() == nullptr) {
      create(s);
    } else {
      total_ += since_restart();
      ARKStepReInit(memory(), facts_.implicit() ? nullptr : &on_rates, facts_.implicit() ? &on_rates : nullptr, s,
                    y_.get());
    }
    set_limit();
    if (!facts_.fixed_step()) set_first_step();
    first_step_ = 0.0;
  }

  void create(double s) {
    const bool implicit = facts_.implicit();
    memory_ = make_arkode(context_.get(), implicit ? nullptr : &on_rates, implicit ? &on_rates : nullptr, s, y_.get());
    set_up();
    // ARKODE uses the order for nothing but the degree of the polynomial between the steps, one below it. With a
    // straight line for a method of order two, the state at an event would be wrong by what no error control has seen;
    // and the polynomial of degree 0, of order one, is the mean of the step's ends at all its points.
    table_->q = facts_.order > 1 ? std::max(facts_.order, kCubic + 1) : 2;
    ARKStepSetTables(memory(), table_->q, table_->p, implicit ? table_.get() : nullptr,
                     implicit ? nullptr : table_.get());
    if (!facts_.fixed_step()) set_longest_step();
    if (implicit) {
      set_newton(&on_jacobian);
      // Hermite's polynomial takes the rates at the step's ends, and evaluated there they would magnify every error of
      // a stiff system: they are taken from the stages instead, and none is evaluated in between (degrees 4 and 5).
      ARKStepSetDeduceImplicitRhs(memory(), 1);
      ARKStepSetInterpolantDegree(memory(), kCubic);
      // Stages that begin from the polynomial through past steps, and a few iterations more than ARKODE's three: with
      // its trivial predictor the bellow's orifice costs eight times the steps at 1e-6.
      ARKStepSetPredictorMethod(memory(), kPredictorOfFullOrder);
      ARKStepSetMaxNonlinIters(memory(), kMostIterations);
      // Each matrix is made of slopes of its own step: with those of a law's end, where they are infinite, Newton's
      // corrections are small wherever the stages are, and the rates deduced from these are anything.
      ARKStepSetJacEvalFrequency(memory(), 1);
      // Of the tolerance; ARKODE's tenth is an error that its own test does not see.
      ARKStepSetNonlinConvCoef(memory(), kIterationError);
    }
  }

  /// Degree of the polynomial between the steps' ends.
  [[nodiscard]] int degree() const {
    if (facts_.order == 1) return 1;
    return facts_.implicit() ? kCubic : std::clamp(facts_.order - 1, kCubic, ARK_INTERP_MAX_DEGREE);
  }

  /// From the step's beginning again, with a quarter of the step. False when there is nothing left to be shortened.
  bool shorten() {
    constexpr double kFirst = 1e-3;
    double tried = 0.0;
    ARKStepGetCurrentStep(memory(), &tried);
    if (tried == 0.0) tried = kFirst * (limit_ - time_) / unit_;  // there was none yet
    const double step = std::min(tried * unit_, limit_ - time_) / 4.0;
    if (!(step > std::numeric_limits<double>::epsilon() * std::abs(time_))) return false;
    N_VScale(1.0, begin_.get(), y_.get());
    begin_here();
    ARKStepSetInitStep(memory(), step / unit_);
    return true;
  }

  /// Explicit methods have no use for the Jacobian, but the tolerances have: it tells what rounding leaves unknowable,
  /// also while friction holds a block, whose speed is then rounding alone.
  void look(double t) {
    steps_since_look_ = 0;
    const double* x = values(y_);
    if (!evaluator_.jacobian(t, x, branch_, entries_.data(), rounding_)) return;
    see({t, x, program_.jacobian_pattern, entries_.data(), rounding_});
  }

  MethodFacts facts_;
  double fixed_step_;  ///< step of a fixed-step method
  ButcherTableHandle table_;
  VectorHandle begin_;  ///< state at the step's beginning
  bool first_ = true;   ///< no step since the restart
  int steps_since_look_ = 0;
  std::uint64_t left_ = 0;  ///< steps of one length to the limit
};

}  // namespace

std::unique_ptr<Integrator> make_arkode_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                   const RunInputs& inputs) {
  return std::make_unique<ArkodeIntegrator>(program, evaluator, tolerances, inputs);
}

}  // namespace bgsim
