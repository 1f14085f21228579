/// The times at which a scene is recorded.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace bgsim {

/// Increasing times from start to stop, both included; or what is wrong with them.
struct OutputTimes {
  double start = 0.0, stop = 0.0;
  double step = 0.0;      ///< between one time and the next; the last one may be nearer
  std::size_t count = 1;  ///< of times
  bool even = true;       ///< the steps divide the span: times are placed by their share of it
  std::string fault, help;

  /// @pre no fault
  [[nodiscard]] std::vector<double> values() const;
};

/// @p samples equidistant times, 501 if not said; one if the scene stops where it starts.
OutputTimes times_by_number(double start, double stop, std::optional<std::size_t> samples);
/// Multiples of @p interval after the start, then the stop, unless a multiple meets it to within 1e-9 of the span.
OutputTimes times_at_interval(double start, double stop, double interval);

}  // namespace bgsim
