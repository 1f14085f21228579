/// The adjoint equations of a run: the gradient of numbers of its outputs by everything, by one run back over it.
#pragma once

#include <optional>
#include <vector>

#include "bgsim/simulate.hpp"
#include "run/sink/trajectory.hpp"

namespace bgsim {

/// One number of an output.
struct AdjointFigure {
  enum class Kind : std::uint8_t {
    value,     ///< at `time`; where something jumps there, after it
    integral,  ///< over the run
    square,    ///< integral of the square
  };
  std::size_t output = 0;  ///< of the program
  Kind kind = Kind::value;
  double time = 0.0;
};

/// What is varied: by how much the parameters (by TransposedPlan::columns) and the states at the start change with it.
struct AdjointSeed {
  std::vector<double> columns, states;
};

/// The other side of an event at the end of the run, whose instant moves with some seed.
struct AdjointBeside {
  std::vector<bool> moves;                      ///< by seed: whether it does with this one
  std::vector<double> values;                   ///< by figure that is a value: what the output is there
  std::vector<std::vector<double>> difference;  ///< by figure, then seed: of the derivatives on this side less those
                                                ///< there; empty: not known
};

struct AdjointResult {
  std::optional<Diagnostic> failure;          ///< BG414, BG606, BG618, or an evaluation that failed
  std::vector<std::vector<double>> gradient;  ///< by figure, then seed
  std::vector<std::vector<double>> terms;     ///< the same: the sum of the magnitudes that a derivative is a sum of
  std::vector<AdjointBeside> beside;
  std::vector<double> value;  ///< by figure that is a value: its output
  std::uint64_t steps = 0;
};

/// Integrates lambda' = -f_x^T lambda - y_x^T backward over @p trajectory by Radau IIA, each figure a column of lambda,
/// and with it the integrals of f_p^T lambda + y_p^T; over events by the transposed saltation matrix. No step passes a
/// border of the run's own steps, beyond which the solution is another polynomial. Error control as of runs: what a
/// step is off by is below inputs.relative times the largest magnitude of each adjoint and of what each parameter has
/// gathered.
/// Cost: a few evaluations a step, and one factorization of 3n; hardly more for more seeds.
/// @param program     with a TransposedPlan, states, and loops that can be eliminated
/// @param trajectory  of a completed run of it with @p inputs
/// @param how         limits of time and progress, which are those of the run back by itself
AdjointResult run_back(const Program& program, const RunInputs& inputs, const Trajectory& trajectory,
                       const std::vector<AdjointFigure>& figures, const std::vector<AdjointSeed>& seeds,
                       const SimulateOptions& how = {});

}  // namespace bgsim
