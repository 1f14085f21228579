/// Sensitivities: by how much the outputs of a scene change with parameters and initial values.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bgsim/study.hpp"

namespace bgsim {

/// What is derived beside the outputs' sensitivities.
struct SensitivityParts {
  bool squares = false;    ///< the integrals over time of the outputs' squares, and their sensitivities
  bool slopes = false;     ///< the outputs' derivatives by time
  bool integrals = false;  ///< the integrals over time of the outputs, and their sensitivities; not with squares
};

/// A scene with the derivatives of its outputs by one parameter, or by one initial value: the variational equations,
/// derived from the expressions of the model, as further states of one system. Compiled once, for any values of
/// parameters.
///
/// Values that are computed from the parameter follow it, initial values among them; the scene's times do not. At an
/// event the sensitivities jump (saltation), since its instant depends on the parameter.
class SensitivityScene {
 public:
  /// @param scene  empty for the first; its outputs are what is derived
  /// @param to     a parameter, or an initial value: "k", "mass.p", "cell.e"
  /// @throws ModelError as Study::scene, BG413 no such parameter, BG414 a model of a kind that has no sensitivities
  /// here.
  SensitivityScene(const Study& study, const std::string& scene, const SceneOverrides& overrides, const std::string& to,
                   const SensitivityParts& parts = {});

  /// The scene's own numbers.
  [[nodiscard]] const RunInputs& inputs() const;
  [[nodiscard]] const std::string& parameter() const;
  /// Of the parameter, in its unit.
  [[nodiscard]] double value() const;
  [[nodiscard]] const std::string& unit() const;  ///< of the parameter; empty where not known

  /// Runs. The columns of the trace are the n outputs x, then dx/dp of each, then, if asked for, dx/dt of each, then
  /// the integrals of x^2 or x, then their derivatives by p.
  /// BG414 is among the failures: the derivative does not exist, or is not found, at an event of this run.
  [[nodiscard]] RunResult run(const SimulateOptions& how = {}) const;
  /// With other values, of the same names set as those the scene was made with, and recorded at @p times.
  [[nodiscard]] RunResult run(const SceneOverrides& overrides, const OutputTimes& times,
                              const SimulateOptions& how = {}) const;

 private:
  struct Inside;
  std::shared_ptr<const Inside> inside_;
};

/// One number of an output over time.
enum class SensitivityNorm {
  final,     ///< its value at the end
  rms,       ///< root of the mean square over the scene
  peak,      ///< its largest magnitude, with its sign
  integral,  ///< over the time of the scene
  mean,      ///< that over the scene's length
};

struct OutputSensitivity {
  double derivative = 0.0;  ///< of the output's number by the parameter
  double relative = 0.0;    ///< times parameter over number: per cent by per cent; NaN if the number is 0
  double error = 0.0;       ///< how far the derivative is off at ten times the tolerance; NaN if that run failed
};

struct SensitivityTable {
  std::string scene;
  std::vector<std::string> outputs, output_units;
  std::vector<double> values;  ///< by output: its number
  std::vector<double> times;   ///< by output: when the peak is; else the scene's stop
  std::vector<std::string> parameters, parameter_units;
  std::vector<double> parameter_values;
  std::vector<std::vector<OutputSensitivity>> of;  ///< by output, then parameter
  Trace trace;                                     ///< outputs, then "d(x)/d(k)" of each output and parameter
  std::vector<std::string> notes;                  ///< of the runs
};

/// Parameters by which there is no derivative, with BG414.
using RefusedParameters = std::vector<std::pair<std::string, Diagnostic>>;

/// The sensitivities of all outputs of a scene to all parameters in @p to, each by a run of its own, on up to
/// @p threads threads. The result does not depend on their number, nor that of one parameter on the others.
/// @param errors  whether each run is made again at ten times its tolerance (twice its step, of a fixed-step method):
/// the difference is more than what is wrong, mostly by a factor of several.
/// @param refused  if given, parameters without a derivative come here, and are left out of the table; unless all are
/// @throws ModelError as SensitivityScene; the failure of a run; BG414 a peak at a corner, an event at the end
///         of the run.
SensitivityTable sensitivities(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                               const std::vector<std::string>& to, SensitivityNorm norm,
                               const SimulateOptions& how = {}, unsigned threads = 1, bool errors = true,
                               RefusedParameters* refused = nullptr);

/// The same by the adjoint equations: one run, and one back over it, for all parameters together. Its cost hardly grows
/// with their number, but with the outputs'. No derivatives over time: the trace holds the outputs alone.
/// @throws ModelError as sensitivities; BG414 also where conditions on different states change at one instant and both
///         matter, and for a system whose loops are too large to be eliminated or that has no states.
/// @note Memory: the states at some six points of each step of the run.
SensitivityTable adjoint_sensitivities(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                                       const std::vector<std::string>& to, SensitivityNorm norm,
                                       const SimulateOptions& how = {}, bool errors = true,
                                       RefusedParameters* refused = nullptr);

/// The same by central differences of runs, extrapolated twice: of all that runs, ideal switches, diodes, contacts and
/// delays among it. OutputSensitivity::error is by how much the last two extrapolations disagree, rounding and errors
/// of the runs included. No derivatives over time. Cost: 10 to 30 runs for each parameter, at a relative tolerance of
/// 1e-10 unless @p overrides give one.
/// @throws ModelError as Study::scene; the failure of a run; BG413; BG414 where the slopes to both sides differ, and
///         for a parameter that is 0.
SensitivityTable difference_sensitivities(const Study& study, const std::string& scene, const SceneOverrides& overrides,
                                          const std::vector<std::string>& to, SensitivityNorm norm,
                                          const SimulateOptions& how = {}, unsigned threads = 1,
                                          RefusedParameters* refused = nullptr);

}  // namespace bgsim
