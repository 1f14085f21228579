/// What the two ways to sensitivities share.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bgsim/sensitivity.hpp"
#include "scene/given_values.hpp"

namespace bgsim {

GivenValues given_of(const Model& model, const std::string& scene, const SceneOverrides& overrides);

/// @throws ModelError BG414, always.
[[noreturn]] void refuse_sensitivity(const Model& model, std::string situation, std::string rule, std::string help,
                                     std::optional<Place> place = {});

/// @throws ModelError BG414 delayed signals.
void refuse_delayed(const Model& model);
/// @throws ModelError BG414 what jumps without a derivative in the adjoint equations: delays, switches.
void refuse_jumps(const Model& model);

/// Derives by each parameter of @p to, on up to @p threads threads.
/// @return those by which there is a derivative, in the same order
/// @param refused  as of sensitivities()
/// @throws ModelError what @p work throws but for BG414 where others have a derivative and @p refused is given
std::vector<std::size_t> derive_each(const std::vector<std::string>& to, unsigned threads,
                                     const std::function<void(std::size_t)>& work, RefusedParameters* refused);

/// @throws ModelError the failure of a run.
void throw_failure(const RunResult& result, const Model& model);

/// When each output has its largest magnitude.
struct Peak {
  double time = 0.0, value = 0.0, range = 0.0;
  std::optional<double> opposite;  ///< when it is as large to the other side, as far as the run tells
};

/// @param count     of outputs, the first ones
/// @param relative  tolerance of the run
std::vector<Peak> peaks_of(const RunResult& run, std::size_t count, double relative, const Model& model);

/// Of two peaks to both sides, that are as large: whether they change alike.
/// @param one, other  their derivatives by @p parameter
/// @param scale       how large such a derivative is
/// @throws ModelError BG414 if they do not.
void refuse_two_sides(const Model& model, const RunInputs& inputs, std::size_t output, const Peak& peak, double one,
                      double other, double scale, const std::string& parameter);

/// Of an event at the end of the run whose instant moves with @p parameter: what an output is on the side that the run
/// ends on, and on the other one.
/// @param other    NaN: not known
/// @param largest  magnitude of the output
/// @throws ModelError BG414 if they differ.
void refuse_end_jump(const Model& model, const std::string& output, const std::string& parameter, double here,
                     double other, double largest);

/// The same of a derivative.
/// @param other     NaN: not known
/// @param rounding  of the difference of the two
/// @throws ModelError BG414 if they differ.
void refuse_end(const Model& model, const std::string& output, const std::string& parameter, double here, double other,
                double rounding = 0.0);

/// The root of the mean square, from the integral of the square.
/// @throws ModelError BG414 if it is 0.
double root_mean_square(const Model& model, const RunInputs& inputs, std::size_t output, double square);

double relative_sensitivity(double derivative, double parameter, double value);

/// Parameters whose errors are not known, with what is wrong with the second run.
using UnknownErrors = std::vector<std::pair<std::string, std::string>>;
/// Why `within` is blank; one line for those of the same reason.
void note_unknown(const UnknownErrors& unknown, std::vector<std::string>& notes);

/// The settings of a run by which errors are judged: ten times the tolerance, twice the step.
SceneOverrides looser(const SceneOverrides& overrides, const RunInputs& inputs);

}  // namespace bgsim
