#include "run/watch/stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "run/integrate/dormand_prince_formula.hpp"

namespace bgsim {

namespace {

// What things cost beside the addition of two numbers in a row (0.4 ns where it was measured: bench compare, perf). No
// more than a factor of two depends on them, see look_at_multistep().
constexpr double kApart = 6.0;      // an instruction that is no part of a row
constexpr double kFunction = 40.0;  // a sine, a power, a table
constexpr double kCube = 8.0;
constexpr double kRatesState = 3.0;  // in and out of the rates, and whether it is finite
constexpr double kExplicit = 35.0;   // for a state: sums of stages, weights, norm
constexpr double kMultistep = 25.0;  // the same for BDF
constexpr double kIterations = 3.0;  // of a loop inside the rates
constexpr double kStages = 6.0;
/// Steps of BDF after which the fastest mode is looked at again, whatever it was; then after twice as many.
constexpr std::int64_t kFirstSight = 64;

/// Radians from the negative real axis: nearer to the imaginary one than where BDF of order 4 is stable (73 degrees).
constexpr double kRings = 1.28;

/// A run by BDF takes at least so many steps: what the explicit method costs up to there is no loss.
constexpr double kLeastSteps = 50.0;
/// By how much the explicit method's steps are longer where only the tolerance holds them, at least.
constexpr double kLonger = 2.4;

bool is_function(Op op) {
  return op == Op::pow || (op >= Op::cbrt && op <= Op::expm1) || op == Op::atan2 || op == Op::mod || is_table(op);
}
/// Squares and cubes are products (power.hpp).
bool is_product(const Program& program, const Instruction& one) {
  const double exponent = program.initial_slots[one.b];
  return one.op == Op::pow && (exponent == 2.0 || exponent == 3.0);
}

double cost_of(const Program& program, const Routine& routine) {
  double cost = 0.0;
  for (const CodeList& code : routine.code)
    for (const Strip& strip : code.strips)
      for (std::uint32_t i = strip.first; i < strip.first + strip.count; ++i) {
        const Instruction& one = code.instructions[i];
        const bool product = is_product(program, one);
        cost += is_function(one.op) && !product      ? kFunction
                : strip.kind != Strip::Kind::in_rows ? kApart
                : product                            ? kCube
                                                     : 1.0;
      }
  return cost;
}

}  // namespace

StiffnessWatch::StiffnessWatch(const Program& program, Evaluator& evaluator, const RunInputs& inputs, bool implicit)
    : program_(program),
      evaluator_(evaluator),
      stop_(inputs.stop),
      possible_(inputs.method == Method::automatic && !implicit && inputs.max_order == 0 &&
                program.state_names.size() > kDenseStates &&
                std::all_of(program.blocks.begin(), program.blocks.end(), [](const auto& b) { return b.linear; })) {
  if (!possible_) return;
  const auto states = static_cast<double>(program.state_names.size());
  rates_cost_ = bgsim::cost_of(program, program.rates) + kRatesState * states;
  for (const ProgramBlock& block : program.blocks)
    rates_cost_ += kIterations * (bgsim::cost_of(program, block.residual) + bgsim::cost_of(program, block.jacobian) +
                                  std::pow(static_cast<double>(block.size), 3));
  explicit_step_ = kStages * rates_cost_ + kExplicit * states;
}

double StiffnessWatch::cost_of(const Integrator::Counts& counts) const {
  const auto since = [](long now, long before) { return static_cast<double>(now - before); };
  return since(counts.steps, phase_.steps) * kMultistep * static_cast<double>(program_.state_names.size()) +
         since(counts.rates, phase_.rates) * rates_cost_ + since(counts.iterations, phase_.iterations) * solver_.solve +
         since(counts.factorizations, phase_.factorizations) * solver_.factor;
}

bool StiffnessWatch::see_fastest_mode(double t, const double* x, const Branch& branch) {
  std::vector<double> entries(program_.jacobian_pattern.row.size());
  Branch here = branch;
  if (!evaluator_.jacobian(t, x, here, entries.data())) return false;
  const FastestMode mode = fastest_mode(program_.jacobian_pattern, entries);
  rings_ = mode.angle > kRings;
  // Modes that grow, or are between, are followed: by steps of their own length.
  const double reach = std::max(1.0, dormand_prince::stable_reach(mode.angle));
  stable_step_ = mode.rate > 0.0 ? std::min(reach / mode.rate, stop_ - t) : stop_ - t;
  return stable_step_ > 0.0;
}

bool StiffnessWatch::begin(double t, const double* x, const Branch& branch, const SolverCost& solver) {
  since_ = looked_at_time_ = t;
  if (!possible_) return false;
  const auto entries = static_cast<double>(program_.jacobian_pattern.row.size());
  constexpr double kSolve = 10.0, kFactor = 25.0;
  solver_ = solver.solve > 0.0 ? solver : SolverCost{kSolve * entries, kFactor * entries};
  constexpr double kFirst = 16.0, kTypicalRates = 1.2, kTypicalFactorizations = 0.15;
  next_look_ = static_cast<std::int64_t>(kFirst);
  next_sight_ = kFirstSight;
  multistep_cost_ = kTypicalRates * (rates_cost_ + solver_.solve) + kTypicalFactorizations * solver_.factor +
                    kMultistep * static_cast<double>(program_.state_names.size());
  if (!see_fastest_mode(t, x, branch)) return false;
  // Where the fastest mode rings, BDF of order 3 and more is held by it, too. The explicit method begins, and finds out
  // what holds its steps, unless that is hopeless.
  constexpr double kMostSteps = 2000.0;
  bound_ = explicit_step_ * (stop_ - t) / stable_step_;
  is_explicit_ = bound_ <= kLeastSteps * multistep_cost_;
  if (is_explicit_ || !rings_ || bound_ > kMostSteps * multistep_cost_ || explicit_step_ > kLonger * multistep_cost_)
    return is_explicit_;
  bound_ = 0.0;
  return is_explicit_ = true;
}

void StiffnessWatch::change(double t, const Integrator::Counts& counts) {
  is_explicit_ = !is_explicit_;
  since_ = looked_at_time_ = t;
  ++changes_;
  phase_ = counts;
  looked_at_step_ = 0;
  step_before_ = held_ = longest_ = 0.0;
  next_look_ = is_explicit_ ? 32 : 16;
  next_sight_ = kFirstSight;
}

bool StiffnessWatch::look(double t, const double* x, const Branch& branch, const Integrator::Counts& counts) {
  if (!possible_) return false;
  const std::int64_t steps = counts.steps - phase_.steps;
  if (steps < next_look_ || !(t > looked_at_time_)) return false;
  constexpr std::int64_t kSeldom = 128;
  const double since = static_cast<double>(steps - looked_at_step_), step = (t - looked_at_time_) / since;
  next_look_ = is_explicit_ ? steps + 32 : std::min(2 * steps, steps + kSeldom);
  looked_at_step_ = steps;
  looked_at_time_ = t;
  if (!is_explicit_) multistep_cost_ = cost_of(counts) / static_cast<double>(steps);
  const bool changes = is_explicit_ ? look_at_explicit(t, x, branch, step, since)
                                    : look_at_multistep(t, x, branch, step, cost_of(counts));
  step_before_ = step;
  if (changes) change(t, counts);
  return changes;
}

/// While BDF makes steps: on two grounds it is left.
///
/// The steps are no longer growing, and the explicit method's, held by the tolerance or by the fastest mode, would cost
/// less.
///
/// Or BDF has cost as much as the explicit method would cost to the end where the fastest mode holds all its steps. So
/// it is never left too early by more than a factor of two, whatever it would have come to (and the explicit method
/// knows no cost beyond that but where the tolerance holds its steps, which then are longer than BDF's).
bool StiffnessWatch::look_at_multistep(double t, const double* x, const Branch& branch, double step, double cost) {
  constexpr double kStillGrows = 1.5, kCheaper = 0.8;
  const auto pace = [&] { return explicit_step_ / std::min(kLonger * step, stable_step_); };
  const auto is_bounded = [&] { return penalty_ * explicit_step_ * (stop_ - t) / stable_step_ <= cost; };
  const auto is_cheaper = [&] {
    return step_before_ > 0.0 && step < kStillGrows * step_before_ &&
           penalty_ * pace() < kCheaper * multistep_cost_ / step;
  };
  // What made the fastest mode fast may be over.
  const bool sees = looked_at_step_ >= next_sight_;
  if (sees) next_sight_ = 2 * looked_at_step_;
  if (!sees && (!(stable_step_ > 0.0) || !(is_bounded() || is_cheaper()))) return false;
  if (!see_fastest_mode(t, x, branch) || !(is_bounded() || is_cheaper())) return false;
  bound_ = explicit_step_ * (stop_ - t) / stable_step_;
  if (!is_bounded()) bound_ = 0.0;
  multistep_pace_ = multistep_cost_ / step;
  return true;
}

/// While the explicit method makes steps, those are looked at that the fastest mode holds: BDF might take longer ones.
/// It is tried where they cost more than its own did, and where there was nothing to compare with, after as much as
/// trying costs; each time that this was in vain twice as much.
bool StiffnessWatch::look_at_explicit(double t, const double* x, const Branch& branch, double step, double steps) {
  constexpr double kHeld = 0.6, kMayBeHeld = 0.4, kShorter = 0.5, kDearer = 1.25;
  // Steps that shrink may be held by a mode that was not as fast when it was last looked at.
  const bool shrinks = step < kShorter * longest_;
  longest_ = shrinks ? step : std::max(longest_, step);
  if (step < kMayBeHeld * stable_step_ && !shrinks) return false;
  if (!see_fastest_mode(t, x, branch)) return false;
  if (step < kHeld * stable_step_) return false;
  held_ += steps * explicit_step_;
  const double rest = explicit_step_ * (stop_ - t) / step;
  if (bound_ > 0.0 && rest <= 2.0 * bound_) return false;
  const bool dearer = multistep_pace_ > 0.0 && explicit_step_ / step > kDearer * multistep_pace_;
  const bool tried =
      held_ > kLeastSteps * multistep_cost_ * penalty_ && rest > 2.0 * kLeastSteps * multistep_cost_ * penalty_;
  if (!dearer && !tried) return false;
  penalty_ *= 2.0;
  return true;
}

}  // namespace bgsim
