/// From what a scene says of its output times to the times.
#pragma once

#include <optional>
#include <string>

#include "bgsim/output_times.hpp"

namespace bgsim {

/// Times from start to stop, both included; or what is wrong with them.
struct PreparedTimes {
  OutputTimes times;
  std::string fault, help;
};

/// @p samples equidistant times, 501 if not said; one if the scene stops where it starts.
PreparedTimes times_by_number(double start, double stop, std::optional<std::size_t> samples);
/// Multiples of @p interval after the start, then the stop, unless a multiple meets it to within 1e-9 of the span.
PreparedTimes times_at_interval(double start, double stop, double interval);

}  // namespace bgsim
