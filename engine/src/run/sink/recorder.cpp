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
      result_(result) {
  for (std::vector<double>& y : y_) y.resize(program.state_names.size() + program.tear_names.size());
  for (std::vector<double>& row : row_) row.resize(program.output_names.size());
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
  while (due(t, false))
    if (const Outcome outcome = record_some(t, integrator); outcome != Outcome::recorded) return outcome;
  return Outcome::recorded;
}

/// The next rows before @p t, as many as the evaluator takes at once.
Recorder::Outcome Recorder::record_some(double t, Integrator& integrator) {
  Evaluator::Points points;
  for (; points.count < Evaluator::Points::kMost && next_ + points.count < inputs_.output_times.size();
       ++points.count) {
    const std::size_t k = points.count;
    points.t[k] = inputs_.output_times[next_ + k];
    if (!(points.t[k] < t)) break;
    integrator.interpolate(points.t[k], y_[k].data(), branch_);
    points.x[k] = y_[k].data();
    points.values[k] = row_[k].data();
  }
  const std::size_t count = points.count;
  const bool known = count > 1 && !events_.holding() && evaluator_.outputs(points, branch_);
  for (std::size_t k = 0; k < count; ++k) {
    if (!known && branch_.given)
      integrator.interpolate(points.t[k], y_[k].data(), branch_);  // the loops' solution there
    const Outcome outcome =
        known ? keep(points.t[k], y_[k].data(), row_[k]) : record(points.t[k], y_[k].data(), row_[k]);
    if (outcome != Outcome::recorded) return outcome;
  }
  return Outcome::recorded;
}

Recorder::Outcome Recorder::at(double t, const std::vector<double>& x, const Branch& branch) {
  if (!due(t, true)) return Outcome::recorded;
  const Stopwatch watch(seconds_);
  branch_ = branch;
  while (due(t, true))
    if (const Outcome outcome = record(inputs_.output_times[next_], x.data(), row_[0]); outcome != Outcome::recorded)
      return outcome;
  return Outcome::recorded;
}

Recorder::Outcome Recorder::record(double t, const double* y, std::vector<double>& row) {
  if (!events_.prepare(t, y, branch_) || !evaluator_.outputs(t, y, branch_, row.data())) return Outcome::fault;
  return keep(t, y, row);
}

Recorder::Outcome Recorder::keep(double t, const double* y, const std::vector<double>& row) {
  errors_.add_row(t, y, branch_, row);
  if (options_.rows) {
    options_.rows(t, row);
  } else {
    result_.trace.times.push_back(t);
    for (std::size_t i = 0; i < row.size(); ++i) result_.trace.columns[i].push_back(row[i]);
  }
  ++next_;
  ++recorded_;
  ++result_.rows;
  last_row_ = t;
  clock_.reach(t);
  return clock_.end() == RunClock::End::none || t >= inputs_.stop ? Outcome::recorded : Outcome::ended;
}

}  // namespace bgsim
