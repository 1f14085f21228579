#include "run/stuck.hpp"

#include <algorithm>
#include <cmath>

namespace bgsim {

namespace {

StuckPoint describe(const LastPoint& point, const std::string& words, const Program& program, Evaluator& evaluator,
                    Integrator& integrator, const Magnitudes& magnitudes) {
  const std::size_t states = point.x.size(), size = states + program.tear_names.size();
  StuckPoint stuck;
  stuck.t = point.t;
  stuck.start = point.start;
  stuck.words = words;
  stuck.names = program.state_names;
  stuck.names.insert(stuck.names.end(), program.tear_names.begin(), program.tear_names.end());
  for (const StateInfo& state : program.states) stuck.places.emplace_back(state.place);
  stuck.places.resize(size);
  for (const ProgramBlock& block : program.blocks)
    std::fill_n(stuck.places.begin() + static_cast<std::ptrdiff_t>(states + block.first_tear), block.size, block.place);
  stuck.y = point.x;
  stuck.rate.resize(states);
  Branch there = point.branch;
  if (!evaluator.rates(point.t, point.x.data(), there, stuck.rate.data())) stuck.rate.clear();
  stuck.y.insert(stuck.y.end(), there.tears.begin(), there.tears.end());
  stuck.largest_early = magnitudes.early();
  stuck.rate_before = [&point, &evaluator, rate = stuck.rate, x = point.x](double by) mutable {
    for (std::size_t i = 0; i < rate.size(); ++i) x[i] = point.x[i] - by * rate[i];
    std::vector<double> before(rate.size());
    Branch branch = point.branch;
    if (rate.empty() || !evaluator.rates(point.t - by, x.data(), branch, before.data())) before.clear();
    return before;
  };
  stuck.weighted_error.assign(integrator.size(), 0.0);
  integrator.weighted_errors(stuck.weighted_error.data());
  return stuck;
}

}  // namespace

Diagnostic stuck_at(const LastPoint& point, const std::string& words, const Program& program, Evaluator& evaluator,
                    Integrator& integrator, EventWatch& events, const Magnitudes& magnitudes) {
  constexpr double kJustAhead = 1e-6;
  const StuckPoint stuck = describe(point, words, program, evaluator, integrator, magnitudes);
  const Fault& fault = integrator.last_fault();
  const bool faulty =
      integrator.failure().fault ||
      (fault.kind != Fault::Kind::none && std::abs(fault.time - point.t) <= kJustAhead * (point.t - point.start));
  if (const auto relation = events.singularity_ahead(point.t, point.x.data(), point.branch))
    return singularity_failure(program, *relation, point.t);
  return faulty && !recognise_blow_up(stuck) ? fault_failure(fault) : stuck_failure(stuck);
}

}  // namespace bgsim
