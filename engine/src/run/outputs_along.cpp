#include "run/outputs_along.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "run/failures.hpp"

namespace bgsim {
namespace {

/// Puts the states at @p t into @p x. @return the stretch
std::size_t find(const Trajectory& trajectory, double t, std::vector<double>& x) {
  const std::vector<Trajectory::Event>& events = trajectory.events();
  const auto later = std::upper_bound(events.begin(), events.end(), t,
                                      [](double at, const Trajectory::Event& event) { return at < event.t; });
  const auto s = static_cast<std::size_t>(later - events.begin());
  const std::vector<Trajectory::Step>& steps = trajectory.stretches()[s].steps;
  const auto behind = std::upper_bound(steps.begin(), steps.end(), t,
                                       [](double at, const Trajectory::Step& step) { return at < step.from; });
  if (behind != steps.begin())
    trajectory.interpolate(*std::prev(behind), t, x);
  else
    x = s > 0 ? events[s - 1].behind() : trajectory.start();
  return s;
}

}  // namespace

OutputsAlong output_along(const Program& program, const RunInputs& inputs, const Trajectory& trajectory,
                          std::size_t output, const std::vector<double>& times) {
  Evaluator evaluator(program, inputs.parameters);
  std::vector<double> x(trajectory.states()), rates(x.size()), by_states(x.size()),
      by_columns(program.transposed.columns.size() + 1), outputs(program.output_names.size()),
      weights(outputs.size(), 0.0);
  weights[output] = 1.0;
  OutputsAlong result;
  for (const double t : times) {
    Branch branch = trajectory.stretches()[find(trajectory, t, x)].end;
    if (!evaluator.rates(t, x.data(), branch, rates.data()) ||
        !evaluator.outputs(t, x.data(), branch, outputs.data()) ||
        !evaluator.take_partials(t, x.data(), branch, Evaluator::Rows::outputs)) {
      result.failure = fault_failure(evaluator.fault());
      return result;
    }
    evaluator.pull_back({}, weights, by_states, by_columns);
    result.values.push_back(outputs[output]);
    result.slopes.push_back(std::inner_product(by_states.begin(), by_states.end(), rates.begin(), by_columns.back()));
  }
  return result;
}

}  // namespace bgsim
