#include "run/sink/recorder.hpp"

#include "base/stopwatch.hpp"

namespace bgsim {

Recorder::Recorder(const Program& program, Evaluator& evaluator, EventWatch& events, GlobalError& errors,
                   RunClock& clock, const RunInputs& inputs, const SimulateOptions& options, RunResult& result)
    : evaluator_(evaluator),
      events_(events),
      errors_(errors),
      clock_(clock),
      inputs_(inputs),
      options_(options),
      result_(result),
      y_(program.state_names.size() + program.tear_names.size()),
      row_(program.output_names.size()) {
  result.trace.names = program.output_names;
  result.trace.units = program.output_units;
  result.trace.columns.resize(program.output_names.size());
  if (options.rows) return;
  result.trace.times.reserve(inputs.output_times.size());
  for (std::vector<double>& column : result.trace.columns) column.reserve(inputs.output_times.size());
}

Recorder::Outcome Recorder::before(double t, Integrator& integrator) {
  if (!due(t, false)) return Outcome::recorded;
  const Stopwatch watch(seconds_);
  branch_ = integrator.branch();
  while (due(t, false)) {
    const double at = inputs_.output_times[next_];
    integrator.interpolate(at, y_.data(), branch_);
    if (const Outcome outcome = record(at, y_.data()); outcome != Outcome::recorded) return outcome;
  }
  return Outcome::recorded;
}

Recorder::Outcome Recorder::at(double t, const std::vector<double>& x, const Branch& branch) {
  if (!due(t, true)) return Outcome::recorded;
  const Stopwatch watch(seconds_);
  branch_ = branch;
  while (due(t, true))
    if (const Outcome outcome = record(inputs_.output_times[next_], x.data()); outcome != Outcome::recorded)
      return outcome;
  return Outcome::recorded;
}

Recorder::Outcome Recorder::record(double t, const double* y) {
  if (!events_.prepare(t, y, branch_) || !evaluator_.outputs(t, y, branch_, row_.data())) return Outcome::fault;
  errors_.judge(t, y, branch_, row_);
  if (options_.rows) {
    options_.rows(t, row_);
  } else {
    result_.trace.times.push_back(t);
    for (std::size_t i = 0; i < row_.size(); ++i) result_.trace.columns[i].push_back(row_[i]);
  }
  ++next_;
  ++recorded_;
  ++result_.rows;
  last_row_ = t;
  clock_.reach(t);
  return clock_.end() == RunClock::End::none || t >= inputs_.stop ? Outcome::recorded : Outcome::ended;
}

}  // namespace bgsim
