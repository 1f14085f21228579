#include "output_times.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bgsim {
namespace {

constexpr std::size_t kDefaultSamples = 501;

std::string faulty_span(double start, double stop) {
  if (!(stop >= start)) return "it stops before it starts";
  return std::isfinite(stop - start) ? "" : "the span of time is too long for a double";
}

/// Whether neighbouring times differ enough for a step between them to mean something.
void check_step(OutputTimes& times) {
  const double largest = std::max(std::abs(times.start), std::abs(times.stop));
  const double least = std::max(4.0 * std::numeric_limits<double>::epsilon() * largest,
                                std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon());
  if (times.step >= least) return;
  times.fault = "its output times cannot be told apart in double precision";
  times.help = "ask for fewer samples or a longer scene, or measure time in another unit or from another origin";
}

}  // namespace

std::vector<double> OutputTimes::values() const {
  std::vector<double> times(count, stop);
  const double steps = static_cast<double>(count - 1);
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const double n = static_cast<double>(i);
    times[i] = even ? start + (stop - start) * (n / steps) : start + step * n;
  }
  return times;
}

OutputTimes times_by_number(double start, double stop, std::optional<std::size_t> samples) {
  OutputTimes times{start, stop, 0.0, 1, true, faulty_span(start, stop), {}};
  if (!times.fault.empty()) {
    times.help = "\"stop\" must not lie before \"start\"";
    return times;
  }
  const bool instant = start == stop;
  times.count = samples.value_or(instant ? 1 : kDefaultSamples);
  if (instant && times.count > 1) {
    times.fault = std::to_string(times.count) + " samples are asked for, but it stops where it starts";
    times.help = "write \"samples\": 1, or a later \"stop\"";
  } else if (!instant && times.count < 2) {
    times.fault = "one sample cannot include both \"start\" and \"stop\"";
    times.help = "write \"samples\": 2 or more";
  } else if (!instant) {
    times.step = (stop - start) / static_cast<double>(times.count - 1);
    check_step(times);
  }
  return times;
}

OutputTimes times_at_interval(double start, double stop, double interval) {
  OutputTimes times{start, stop, interval, 1, true, faulty_span(start, stop), {}};
  if (!times.fault.empty()) {
    times.help = "\"stop\" must not lie before \"start\"";
    return times;
  }
  if (!(interval > 0.0)) {
    times.fault = "\"interval\" must be greater than 0";
    return times;
  }
  if (start == stop) return times;
  check_step(times);
  if (!times.fault.empty()) return times;
  constexpr double kMostSteps = 1e9, kSameTime = 1e-9;
  const double steps = (stop - start) / interval;
  if (steps > kMostSteps) {
    times.fault = "more than 1e9 output times are asked for";
    times.help = "write a longer \"interval\"";
    return times;
  }
  const double whole = std::round(steps);
  times.even = whole >= 1.0 && std::abs(whole - steps) <= kSameTime * steps;
  times.count = static_cast<std::size_t>(times.even ? whole : std::floor(steps) + 1.0) + 1;
  return times;
}

}  // namespace bgsim
