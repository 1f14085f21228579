/// From what a scene says of its output times to the times.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/output_times.hpp"

namespace bgsim {

/// Times from start to stop; or what is wrong with them.
struct PreparedTimes {
  OutputTimes times;
  std::string fault, help;
  std::optional<std::size_t> at;  ///< of a list: which one is at fault
};

/// @p samples equidistant times, 501 if not said; one if the scene stops where it starts.
PreparedTimes times_by_number(double start, double stop, std::optional<std::size_t> samples);
/// Multiples of @p interval after the start, then the stop, unless a multiple meets it to within 1e-9 of the span.
PreparedTimes times_at_interval(double start, double stop, double interval);
/// @p samples times from @p first, the start if not said, to the stop, one as many times the one before as the next is.
PreparedTimes times_by_logarithm(double start, double stop, std::size_t samples, std::optional<double> first);
/// The times of a list, which need not hold start and stop.
PreparedTimes times_listed(double start, double stop, std::vector<double> list);

}  // namespace bgsim
