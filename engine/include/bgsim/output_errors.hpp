/// How far the outputs of two runs are apart.
#pragma once

#include <string>
#include <vector>

#include "bgsim/simulate.hpp"

namespace bgsim {

/// The largest distance of an output from the full model's, relative to the full output's range over the scene.
struct OutputError {
  std::string output;
  double error = 0.0;  ///< infinite where the full output is constant 0 and the reduced one is not
  double rms = 0.0;
  double time = 0.0;  ///< of the largest
};
/// By output. Both traces have the same times and columns.
std::vector<OutputError> output_errors(const Trace& full, const Trace& reduced);
/// The largest of them.
OutputError worst(const std::vector<OutputError>& errors);

}  // namespace bgsim
