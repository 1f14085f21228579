/// Linear analysis: a model linearized at a point, its poles, zeros, frequency and step responses (docs/linear.md).
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/simulate.hpp"

namespace bgsim {

/// A state, input, output or loop variable of a linear system.
struct LinearVariable {
  std::string name;   ///< "mass.p", "pump.e", "k", "x"
  std::string unit;   ///< empty if not known
  double value = 0;   ///< at the point
  double rate = 0;    ///< of a state: its time derivative there, 0 at an equilibrium
  bool store = true;  ///< of a state: false for an integral among the signals
  double error = 0;   ///< of a state: how far its value can be off, as the point says
};

/// A matrix that is mostly zero: entries by row, then column, each position once.
struct LinearMatrix {
  struct Entry {
    std::uint32_t row = 0, column = 0;
    double value = 0.0;
  };
  std::size_t rows = 0, columns = 0;
  std::vector<Entry> entries;
};

/// What a store's energy is made of in a small motion: displacement (momentum) and effort (flow) of each port as rows
/// over the states.
struct StoreRows {
  std::string name;                                  ///< of the element
  std::vector<std::vector<double>> held, conjugate;  ///< by port, then state; what depends on inputs is left out
};

/// x' = A x + B0 u + B1 u' + ..., y = C x + D0 u + D1 u' + ... : deviations from the point. Derivatives of inputs occur
/// where a store is in derivative causality behind the input, or an output contains one.
struct LinearSystem {
  std::string model;
  double t = 0.0;
  std::vector<LinearVariable> states, inputs, outputs;
  std::vector<LinearVariable> loops;  ///< variables at which algebraic loops are cut
  LinearMatrix a, c;                  ///< states by states, outputs by states
  std::vector<LinearMatrix> b, d;     ///< by order of the derivative of the inputs; at least one each
  /// The descriptor form E v' = A v + B u, y = C v + D u with the loops not eliminated: v holds the states, the loops'
  /// variables, then for each input of which derivatives occur, that input and its derivatives.
  struct Descriptor {
    std::vector<LinearVariable> variables;
    LinearMatrix e, a, b, c, d;
  } descriptor;
  std::vector<StoreRows> stores;   ///< empty above kLargestDense states
  std::vector<std::string> notes;  ///< what to know of the point
};

/// Systems of more states are not made dense: they have no zeros or step responses here, nor poles if as many states
/// act on each other, but frequency responses.
constexpr std::size_t kLargestDense = 500;

/// Linearizes a model by exact partial derivatives of its expressions.
/// @param model   in the mode of its switches that is wanted.
/// @param point   parameters, `start` as the time, `initial` as what stores and integrals hold, `outputs`. Just after
/// that time
///                where a source jumps at it. `Initial::rounding` says how far a value can be off: a kink within is
///                found.
/// @param inputs  names of parameters (those computed from one follow it), signals (a deviation that is added to it
///                for all who read it), sources ("pump" or "pump.e": a deviation added to the source).
/// @throws ModelError BG406 no such input; BG407 a law has no finite value or slope there; BG408 it has a kink, a jump
/// or the
///         border of a condition there, so that there is no derivative; BG405; those of the stages.
/// @note Time linear in the expressions and their partials; loops are eliminated sparsely.
LinearSystem linear_system(const std::shared_ptr<const Model>& model, const RunInputs& point,
                           const std::vector<std::string>& inputs);

/// Where a run of @p inputs ended, as a point to linearize at: what is stored there, known to the run's tolerance. So a
/// body that friction holds, whose speed is the rounding of 0, is at the kink.
RunInputs point_after(const Model& model, const RunInputs& inputs, const RunResult& result);

/// A share of a pole.
struct PoleShare {
  std::string name;
  double share = 0.0;  ///< of 1
};

/// An eigenvalue of A, s in 1/s; of a pair of conjugate ones, that of positive imaginary part.
struct Pole {
  std::complex<double> s;
  bool pair = false;              ///< its conjugate is a pole too
  double error = 0.0;             ///< estimated, of the magnitude of s: what rounding can have made of it
  std::size_t multiple = 1;       ///< so many poles lie together that rounding does not tell them apart; each is listed
  std::vector<PoleShare> energy;  ///< by store, largest first: share of the energy of its mode
  std::vector<PoleShare> participation;  ///< by state, largest first: |left times right eigenvector|, scaled to sum 1
  [[nodiscard]] double frequency() const { return std::abs(s); }  ///< natural, rad/s
  [[nodiscard]] double damping() const;                           ///< -Re s/|s|; 1 at s = 0
};

/// Some poles: those nearest to a real number.
struct PolesNear {
  double near = 0.0;       ///< in 1/s
  std::size_t count = 10;  ///< a pair of conjugate ones counts once
};

/// Poles, slowest first, or nearest first. Blocks of states that drive others in one direction only are solved for
/// themselves, so that chains of equal parts and free bodies have exact poles; within a block balanced, in extended
/// precision.
/// @param some  not all: blocks of more than kLargestDense states are then solved sparsely
/// @throws ModelError BG409 all are wanted, and a block has more than kLargestDense states; or those nearest to a
/// number
///         cannot be told.
/// @note Time cubic in the largest block; with @p some, a few sparse factorizations for each pole of a large one.
std::vector<Pole> poles(const LinearSystem& system, const std::optional<PolesNear>& some = {});

/// The states that take part in poles at 0: free bodies, positions that nothing holds, conserved sums. By name.
std::vector<std::string> free_states(std::span<const Pole> poles);

/// Finite zeros from an input to an output, with the gain k of k (s - z1)(s - z2).../((s - p1)(s - p2)...).
struct TransferZeros {
  std::vector<Pole> zeros;          ///< without shares
  std::vector<Pole> poles;          ///< of the part between input and output; without shares
  double gain = 0.0;                ///< of the leading coefficients
  double static_gain = 0.0;         ///< G(0); infinite with a pole at 0 that no zero cancels; NaN: not known
  std::size_t cancelled = 0;        ///< poles and zeros at 0 that cancel, each once: they are in neither list
  std::vector<std::string> hidden;  ///< states outside of the path from input to output
};
/// @throws ModelError BG410 the output does not depend on the input; BG409.
TransferZeros transfer_zeros(const LinearSystem& system, std::size_t input, std::size_t output);

/// G(j w) at angular frequencies @p omega (rad/s), from one input to one output.
struct FrequencyResponse {
  std::vector<double> omega;
  std::vector<std::complex<double>> value;  ///< infinite at a pole on the imaginary axis
  double error = 0.0;                       ///< largest relative error, estimated by refinement
};
/// @param right  G((right + j) w) instead: beside the imaginary axis, as if every pole and zero had a little more
/// damping
/// @throws ModelError BG410 the output does not depend on the input.
FrequencyResponse frequency_response(const LinearSystem& system, std::size_t input, std::size_t output,
                                     std::span<const double> omega, double right = 0.0);

/// Response of the outputs to a unit step or impulse of an input at 0, from rest at the point, at equidistant times
/// from 0.
enum class Excitation : std::uint8_t { step, impulse };
struct TimeResponse {
  std::vector<double> times;
  std::vector<double> value;
  /// Weights of the impulse at 0 that the output contains besides, of its derivative, of its second one ...; up to the
  /// last that is not 0.
  std::vector<double> singular;
};
/// By the exponential of A, exact at the times.
/// @throws ModelError BG410; BG409.
TimeResponse time_response(const LinearSystem& system, std::size_t input, std::size_t output, Excitation excitation,
                           double stop, std::size_t points);

/// A state in which all rates are zero, sources held at their values at a time.
struct Equilibrium {
  std::vector<RunInputs::Initial> values;  ///< of all stores and integrals, for RunInputs::initial
  std::vector<LinearVariable> states;
  double residual = 0.0;          ///< largest rate, relative to the terms that it is the sum of
  std::vector<Pole> poles;        ///< empty if it has no linearization
  std::string not_linear;         ///< why it has none, or why it does not tell the stability
  std::vector<std::string> free;  ///< states that take part in what may be moved: others of the same kind are beside it
  bool drifts = false;            ///< what is free, once pushed, goes on without end: a free body
  std::string found;              ///< by what: "Newton's iteration from the start of the scene", ...
  Mode mode;                      ///< of the switches, in which it is one; empty without switches
  /// Switches, diodes and contacts that leave their sides there, and closed contacts that are not at their gaps: it is
  /// an equilibrium of the mode and none of the model.
  std::vector<ElementId> leaves;
  enum class Stability : std::uint8_t { stable, unstable, marginal, unknown } stability = Stability::unknown;
};
struct SteadyOptions {
  bool all = true;  ///< looks for others once one is found
};
/// Equilibria of a model near a scene, the one reached from the scene's start first. Of a model with switches: in the
/// mode that it is in, whether or not they stay there (see steady_states() for all modes).
/// @throws ModelError BG412 none was found; BG601 and the like where laws have no value.
std::vector<Equilibrium> equilibria(const std::shared_ptr<const Model>& model, const RunInputs& scene,
                                    const SteadyOptions& options = {});

}  // namespace bgsim
