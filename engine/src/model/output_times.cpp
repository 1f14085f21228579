#include "model/output_times.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bgsim {
namespace {

constexpr std::size_t kDefaultSamples = 501;

/// Sets fault and help if there is no span of time from @p start to @p stop.
void check_span(PreparedTimes& prepared, double start, double stop) {
  if (!(stop >= start))
    prepared.fault = "it stops before it starts";
  else if (!std::isfinite(stop - start))
    prepared.fault = "the span of time is too long for a double";
  if (!prepared.fault.empty()) prepared.help = "\"stop\" must not lie before \"start\"";
}

/// Whether neighbouring times differ enough for a step between them to mean something.
void check_step(PreparedTimes& prepared, double start, double stop, double step) {
  const double largest = std::max(std::abs(start), std::abs(stop));
  const double least = std::max(4.0 * std::numeric_limits<double>::epsilon() * largest,
                                std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon());
  if (step >= least) return;
  prepared.fault = "its output times cannot be distinguished in double precision";
  prepared.help = "use fewer samples or a longer scene, or measure time in another unit or from another origin";
}

}  // namespace

OutputTimes OutputTimes::equidistant(double start, double stop, std::size_t count) {
  OutputTimes times;
  times.form_ = Form::shares;
  times.start_ = start;
  times.stop_ = stop;
  times.count_ = count;
  return times;
}

OutputTimes OutputTimes::at_multiples(double start, double stop, double interval, std::size_t count) {
  OutputTimes times = equidistant(start, stop, count);
  times.form_ = Form::multiples;
  times.interval_ = interval;
  return times;
}

OutputTimes OutputTimes::without_first(std::size_t count) const {
  OutputTimes rest = *this;
  rest.first_ += std::min(count, size());
  return rest;
}

double OutputTimes::operator[](std::size_t i) const {
  const std::size_t number = first_ + i;
  if (form_ == Form::list) return list_[number];
  if (number + 1 == count_) return stop_;
  const double n = static_cast<double>(number);
  if (form_ == Form::multiples) return start_ + interval_ * n;
  return start_ + (stop_ - start_) * (n / static_cast<double>(count_ - 1));
}

std::size_t OutputTimes::first_after(double t) const {
  std::size_t low = 0, high = size();
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if ((*this)[middle] > t)
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

std::vector<double> OutputTimes::list() const {
  std::vector<double> times(size());
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = (*this)[i];
  return times;
}

PreparedTimes times_by_number(double start, double stop, std::optional<std::size_t> samples) {
  PreparedTimes prepared;
  check_span(prepared, start, stop);
  if (!prepared.fault.empty()) return prepared;
  const bool instant = start == stop;
  const std::size_t count = samples.value_or(instant ? 1 : kDefaultSamples);
  if (instant && count > 1) {
    prepared.fault = std::to_string(count) + " samples are requested, but it stops where it starts";
    prepared.help = "write \"samples\": 1, or a later \"stop\"";
  } else if (!instant && count < 2) {
    prepared.fault = "one sample cannot include both \"start\" and \"stop\"";
    prepared.help = "write \"samples\": 2 or more";
  } else {
    if (!instant) check_step(prepared, start, stop, (stop - start) / static_cast<double>(count - 1));
    prepared.times = OutputTimes::equidistant(start, stop, count);
  }
  return prepared;
}

PreparedTimes times_at_interval(double start, double stop, double interval) {
  PreparedTimes prepared;
  check_span(prepared, start, stop);
  if (!prepared.fault.empty()) return prepared;
  prepared.times = OutputTimes::equidistant(start, stop, 1);
  if (!(interval > 0.0)) {
    prepared.fault = "\"interval\" must be greater than 0";
    return prepared;
  }
  if (start == stop) return prepared;
  check_step(prepared, start, stop, interval);
  if (!prepared.fault.empty()) return prepared;
  constexpr double kMostSteps = 1e9, kSameTime = 1e-9;
  const double steps = (stop - start) / interval;
  if (steps > kMostSteps) {
    prepared.fault = "more than 1e9 output times are requested";
    prepared.help = "write a longer \"interval\"";
    return prepared;
  }
  const double whole = std::round(steps);
  const bool even = whole >= 1.0 && std::abs(whole - steps) <= kSameTime * steps;
  const std::size_t count = static_cast<std::size_t>(even ? whole : std::floor(steps) + 1.0) + 1;
  prepared.times =
      even ? OutputTimes::equidistant(start, stop, count) : OutputTimes::at_multiples(start, stop, interval, count);
  return prepared;
}

PreparedTimes times_by_logarithm(double start, double stop, std::size_t samples, std::optional<double> first) {
  constexpr std::size_t kMost = 10'000'000;  // they are a list in memory
  PreparedTimes prepared;
  check_span(prepared, start, stop);
  if (!prepared.fault.empty()) return prepared;
  const double from = first.value_or(start);
  if (!(from > 0.0)) {
    prepared.fault = first ? "\"from\" must be greater than 0" : "logarithmic output times cannot begin at its start";
    prepared.help = "write \"from\": the first output time, greater than 0";
  } else if (from < start || from >= stop) {
    prepared.fault = "the first of its output times does not lie between \"start\" and \"stop\"";
    prepared.help = "write \"from\": the first output time, before \"stop\"";
  } else if (samples < 2 || samples > kMost) {
    prepared.fault = "\"log\" must be a number from 2 to 1e7";
  }
  if (!prepared.fault.empty()) return prepared;
  std::vector<double> list(samples, stop);
  // Powers of ten, so that 1e-3 to 1e3 by seven samples gives 0.01 and not its neighbour.
  const double lowest = std::log10(from), span = std::log10(stop) - lowest;
  for (std::size_t i = 0; i + 1 < samples; ++i)
    list[i] =
        i == 0 ? from : std::pow(10.0, lowest + span * (static_cast<double>(i) / static_cast<double>(samples - 1)));
  check_step(prepared, from, list[1], list[1] - from);
  prepared.times = OutputTimes(std::move(list));
  return prepared;
}

PreparedTimes times_listed(double start, double stop, std::vector<double> list) {
  PreparedTimes prepared;
  check_span(prepared, start, stop);
  for (std::size_t i = 0; i < list.size() && prepared.fault.empty(); ++i) {
    if (list[i] < start || list[i] > stop) {
      prepared.fault = "an output time is not between \"start\" and \"stop\"";
      prepared.help =
          list[i] > stop ? "leave it out, or write a later \"stop\"" : "leave it out, or write an earlier \"start\"";
    } else if (i > 0 && list[i] <= list[i - 1]) {
      prepared.fault = "an output time is not later than the one before it";
      prepared.help = "list the times in increasing order, each once";
    } else if (i > 0) {
      check_step(prepared, list[i - 1], list[i], list[i] - list[i - 1]);
    }
    if (!prepared.fault.empty()) prepared.at = i;
  }
  prepared.times = OutputTimes(std::move(list));
  return prepared;
}

}  // namespace bgsim
