/// What the simulation loop needs of an integrator: one step at a time, and the solution between.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"
#include "run/tolerances.hpp"

namespace bgsim {

class Integrator {
 public:
  struct Counts {  // in SUNDIALS' own type, which its functions write to
    long steps = 0, rates = 0, jacobians = 0, factorizations = 0, iterations = 0, error_failures = 0,
         convergence_failures = 0;
    Counts& operator+=(const Counts& other);
    template <class Archive>
    void carry(Archive& archive) {
      archive("steps", steps);
      archive("rates", rates);
      archive("jacobians", jacobians);
      archive("factorizations", factorizations);
      archive("iterations", iterations);
      archive("error failures", error_failures);
      archive("convergence failures", convergence_failures);
    }
  };

  virtual ~Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  /// Reinitializes at (t, x) on @p branch, towards @p limit. False if the equations cannot be evaluated there:
  /// last_fault() tells.
  virtual bool restart(double t, const double* x, const Branch& branch, double limit) = 0;
  /// One step, not beyond the limit. False if there is none: failure() tells.
  virtual bool advance() = 0;
  /// From the next restart on, the rates are these instead of the evaluator's; empty: the evaluator's. CVODE only.
  using Rates = std::function<bool(double t, const double* x, Branch& branch, double* rates)>;
  void use_rates(Rates rates) { special_rates_ = std::move(rates); }
  [[nodiscard]] const Rates& special_rates() const { return special_rates_; }
  /// From the next restart on, no higher order than this. CVODE only.
  virtual void limit_order(int /*order*/) {}
  /// Length of the first step after the next restart, instead of the integrator's own choice. Of no effect on steps of
  /// one length.
  void begin_with(double step) { first_step_ = step; }
  /// No step is longer than this. Call before the first restart; of no effect on steps of one length.
  void limit_step(double longest) { longest_ = longest; }
  /// The solution at @p t within the last step: states, then tear variables if these are unknowns of the integrator.
  virtual void interpolate(double t, double* y) = 0;
  /// The same with the branch there, which must be a copy of branch(): tears that are unknowns are set.
  void interpolate(double t, double* y, Branch& branch) {
    interpolate(t, y);
    if (tears_ > 0) std::copy(y + (size_ - tears_), y + size_, branch.tears.begin());
  }
  /// The modes of the last restart, and the loops' solution of the latest evaluation; `given` if the tears are unknowns
  /// of the integrator, and no loop is solved but by its iteration.
  [[nodiscard]] const Branch& branch() const { return branch_; }
  [[nodiscard]] virtual std::string method() const = 0;
  /// Whether a step knows nothing of the one before. Such steps are long beside what the slopes of the rates change
  /// over.
  [[nodiscard]] virtual bool one_step() const { return false; }
  [[nodiscard]] virtual Counts counts() const = 0;
  /// Estimated local error of the failed step relative to the tolerance, by unknown.
  virtual void weighted_errors(double* error) = 0;

  /// All unknowns at the end of the last step.
  [[nodiscard]] virtual const double* end() const = 0;

  [[nodiscard]] double time() const { return time_; }
  [[nodiscard]] double previous() const { return previous_; }
  [[nodiscard]] double step() const { return time_ - previous_; }
  [[nodiscard]] int order() const { return order_; }
  [[nodiscard]] std::size_t size() const { return size_; }

  struct Failure {
    std::string words;
    bool too_accurate = false;  ///< more than double precision gives
    bool fault = false;         ///< the equations could not be evaluated: last_fault() tells
  };
  [[nodiscard]] const Failure& failure() const { return failure_; }
  /// The latest point, tried or accepted, at which the equations could not be evaluated.
  [[nodiscard]] const Fault& last_fault() const { return last_fault_; }

 protected:
  /// @param span  of the scene. Where its magnitude is out of the ordinary, the integrator's own time is counted in a
  ///              unit that makes it ordinary: a power of two, so that nothing is rounded. (Squares of second
  ///              derivatives overflow for time constants below 1e-75.)
  explicit Integrator(double span);
  double time_ = 0.0, previous_ = 0.0;
  int order_ = 1;
  std::size_t size_ = 0;   ///< number of unknowns
  std::size_t tears_ = 0;  ///< of these, the last ones
  Branch branch_;
  Rates special_rates_;
  double unit_ = 1.0;  ///< of the integrator's own time

  /// Whether a length of time is nothing beside the scene: products of two such lengths are below all doubles. Known
  /// times that are as near to 0 are stepped to by hand.
  [[nodiscard]] bool is_nothing(double length) const { return length < 1e-150 * span_; }
  double span_ = 1.0;
  double longest_ = 0.0;     ///< step; 0: any
  double first_step_ = 0.0;  ///< after the next restart; 0: the integrator's own choice
  Failure failure_;
  Fault last_fault_;
};

/// Where a method solves for the loops: inside the rates, or with its own unknowns, which are then the states and after
/// them the tear variables: x' = f(t, x, z), 0 = F(t, x, z).
enum class Loops { inside, unknowns };

/// Where dense factorization gives way to sparse.
inline constexpr std::size_t kDenseStates = 50;

/// A first step may be far too long where all rates start at zero, and each failure divides it by four at most.
inline constexpr int kMostErrorTestFailures = 60;

/// CVODE: backward differentiation or, for method adams, Adams-Moulton; both with Newton's iteration and the exact
/// Jacobian, so that a model that turns out to be stiff costs accuracy nowhere and time only.
std::unique_ptr<Integrator> make_cvode_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                  const RunInputs& inputs);
/// ARKODE: Runge-Kutta methods, explicit or diagonally implicit, with error-controlled steps or steps of one length.
std::unique_ptr<Integrator> make_arkode_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                   const RunInputs& inputs);
/// Störmer-Verlet with steps of one length; null if the system is not separable (separability.hpp).
std::unique_ptr<Integrator> make_verlet_integrator(const Program& program, Evaluator& evaluator,
                                                   const RunInputs& inputs);
/// Radau IIA, error-controlled steps. @param order  5, 9 or 13
std::unique_ptr<Integrator> make_radau_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                  const RunInputs& inputs, int order, Loops loops);
/// Rodas5P, error-controlled steps.
std::unique_ptr<Integrator> make_rodas_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                  const RunInputs& inputs, Loops loops);
/// Dormand and Prince's explicit method of order 5, for many states.
std::unique_ptr<Integrator> make_dormand_prince_integrator(const Program& program, Evaluator& evaluator,
                                                           Tolerances& tolerances, const RunInputs& inputs);
/// IDA: states and tear variables together.
std::unique_ptr<Integrator> make_ida_integrator(const Program& program, Evaluator& evaluator, Tolerances& tolerances,
                                                const RunInputs& inputs);

/// IDA: the states alone, x' - f(t, x) = 0, with the loops solved inside f.
std::unique_ptr<Integrator> make_ida_explicit_integrator(const Program& program, Evaluator& evaluator,
                                                         Tolerances& tolerances, const RunInputs& inputs);

/// Steps of one length between two times: as long as @p longest at most, and a whole number of them.
double even_step(double from, double to, double longest);

}  // namespace bgsim
