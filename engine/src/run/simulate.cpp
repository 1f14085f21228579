// A run of one program, from its beginning to its report.
#include "bgsim/simulate.hpp"

#include <stdexcept>
#include <utility>

#include "base/codes.hpp"
#include "base/stopwatch.hpp"
#include "bgsim/text.hpp"
#include "run/run.hpp"

namespace bgsim {

RunResult Run::execute() {
  double total = 0.0;
  {
    const Stopwatch watch(total);
    y_.resize(program_.state_names.size() + program_.tear_names.size());
    if (!late_watch_) evaluator_.watch([this] { return clock_.look(); });
    if (options_.resume.empty() ? begin() : resume()) {
      if (program_.state_names.empty())
        follow_grid();
      else
        integrate();
    }
  }
  evaluator_.watch({});
  integration_seconds_ = total - recorder_.seconds() - audit_.seconds();
  const bool may_go_on = result_.stop != StopReason::failed || clock_.end() != RunClock::End::none ||
                         (result_.failure && result_.failure->code == "BG607");
  if (may_go_on && !left_mode_) offer_snapshot();
  result_.stored = stored();
  report();
  return std::move(result_);
}

RunResult simulate(const Program& program, const RunInputs& inputs, const SimulateOptions& options) {
  return simulate(program, inputs, options, wall_seconds);
}

RunResult simulate(const Program& program, const RunInputs& inputs, const SimulateOptions& options, Clock clock) {
  if (inputs.parameters.size() < program.model->parameters.size())  // those of the sides of diodes
    throw std::invalid_argument("a scene with diodes or contacts is run by Simulation::simulate");
  if (!inputs.output_times.empty() && inputs.output_times.front() < inputs.start)
    throw std::invalid_argument("an output time is before the start of the scene");
  if (options.measures && (!options.resume.empty() || options.snapshot))
    throw std::invalid_argument("a snapshot does not hold what the outputs are measured to be");
  if (options.trajectory != nullptr && !options.resume.empty())
    throw std::invalid_argument("a snapshot does not hold the solution before it");
  const DelayTables tables = own_tables(program);
  std::optional<Program> own;
  if (!tables.empty()) own.emplace(with_tables(program, tables));
  Run run(own ? *own : program, inputs, options, std::move(clock), tables);
  RunResult result = run.execute();
  if (!run.left_mode() || result.stop != StopReason::completed) return result;
  result.stop = StopReason::failed;
  result.failure = diagnostic_of("BG619", "at t = " + number_text(result.report.reached) + " a switch leaves its side",
                                 {}, "a program is that of one mode of the switches",
                                 "run the scene by Simulation::simulate, which goes on to the next mode");
  return result;
}

}  // namespace bgsim
