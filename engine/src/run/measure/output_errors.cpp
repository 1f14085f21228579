#include <algorithm>
#include <cmath>
#include <limits>

#include "bgsim/verify.hpp"

namespace bgsim {

std::vector<OutputError> output_errors(const Trace& full, const Trace& reduced) {
  const std::size_t columns = full.names.size();
  std::vector<OutputError> errors;
  for (std::size_t c = 0; c < columns; ++c) {
    OutputError error{full.names[c], 0.0, 0.0, full.times.empty() ? 0.0 : full.times.front()};
    double least = std::numeric_limits<double>::infinity(), most = -least, magnitude = 0.0, root = 0.0;
    for (std::size_t r = 0; r < full.times.size(); ++r) {
      const double value = full.columns[c][r];
      const double distance = std::abs(reduced.columns[c][r] - value);
      least = std::min(least, value);
      most = std::max(most, value);
      magnitude = std::max(magnitude, std::abs(value));
      // An unstable method gives errors whose squares are beyond the range of double precision.
      root = std::hypot(root, distance);
      if (distance > error.error) {
        error.error = distance;
        error.time = full.times[r];
      }
    }
    // A constant has no range but roundings: it is held to its magnitude.
    constexpr double kRoundings = 1e-12;
    const double range = most - least > kRoundings * magnitude ? most - least : magnitude;
    if (error.error > 0.0) {
      error.rms = root / std::sqrt(static_cast<double>(full.times.size())) / range;
      error.error /= range;
    }
    errors.push_back(error);
  }
  return errors;
}

OutputError worst(const std::vector<OutputError>& errors) {
  const auto found = std::max_element(errors.begin(), errors.end(),
                                      [](const OutputError& a, const OutputError& b) { return a.error < b.error; });
  return found == errors.end() ? OutputError{} : *found;
}

}  // namespace bgsim
