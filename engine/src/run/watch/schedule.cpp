#include "run/watch/schedule.hpp"

#include <algorithm>

#include "run/failures.hpp"

namespace bgsim {

std::optional<Diagnostic> Schedule::plan() {
  sources_ = plan_sources(program_, inputs_.parameters, inputs_.start, inputs_.stop);
  if (!sources_.too_narrow) return std::nullopt;
  const NarrowPulse& pulse = *sources_.too_narrow;
  return narrow_pulse_failure(
      readable_text(program_.pool, pulse.source, [&](SymbolId id) { return program_.symbol_names[id.index()]; }),
      pulse.when.begin, pulse.when.end - pulse.when.begin, pulse.wide_enough, only_element_of_time(*program_.model));
}

std::optional<double> Schedule::next(double t) const {
  const auto known = evaluator_.next_time_event(t, inputs_.stop);
  const auto edge = sources_.next_edge(t);
  if (known && edge) return std::min(*known, *edge);
  return known ? known : edge;
}

std::vector<double> Schedule::samples(double t) const {
  constexpr std::size_t kEvents = 3;
  std::vector<double> times;
  double at = t;
  for (std::size_t i = 0; i < kEvents; ++i) {
    const auto event = evaluator_.next_time_event(at, inputs_.stop);
    if (!event) break;
    at = *event;
    times.push_back(at);
  }
  for (std::size_t i = 0; i < std::min(kEvents, sources_.pulses.size()); ++i)
    times.push_back(sources_.pulses[i].begin + (sources_.pulses[i].end - sources_.pulses[i].begin) / 2);
  for (const double part : {0.0137, 0.113, 0.379, 0.731}) times.push_back(t + part * (inputs_.stop - t));
  return times;
}

}  // namespace bgsim
