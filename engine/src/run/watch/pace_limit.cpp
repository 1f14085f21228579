#include "run/watch/pace_limit.hpp"

#include <algorithm>

namespace bgsim {

namespace {

constexpr double kBetween = 0.5;                          // seconds between two checks
constexpr double kWait = 600.0;                           // seconds that a person waits without a message
constexpr double kRemarkAfter = 4.0, kRemarkPart = 16.0;  // stretches of the run so far, in seconds and as its part
constexpr double kEndAfter = 8.0, kEndPart = 8.0;
constexpr double kUnknownSpectrum = 60.0;  // seconds before a system whose modes are not known is given up

}  // namespace

PaceLimit::PaceLimit(const Program& program, Evaluator& evaluator, const RunInputs& inputs,
                     const SimulateOptions& options)
    : program_(program), evaluator_(evaluator), inputs_(inputs), options_(options), headway_(inputs.stop) {}

std::optional<Diagnostic> PaceLimit::check(const RunPosition& now) {
  headway_.add(now.seconds, now.t, now.steps + now.rows);
  if (now.seconds - checked_at_ < kBetween) return std::nullopt;
  checked_at_ = now.seconds;
  if (now.seconds - last_.seconds > kRemarkAfter) before_ = std::exchange(last_, now);

  if (const auto pace = headway_.pace(std::max(kRemarkAfter, now.seconds / kRemarkPart));
      pace && !remarked_ && pace->rest > kWait && options_.remark) {
    remarked_ = true;
    options_.remark(slow_run_remark(program_, facts(now, *pace)));
  }
  if (options_.time_limit > 0.0 || !(options_.longest_run > 0.0)) return std::nullopt;
  const auto pace = headway_.pace(std::max(kEndAfter, now.seconds / kEndPart));
  if (!pace || !(pace->rest > options_.longest_run) || pace_may_change(now, *pace)) return std::nullopt;
  return endless_run_failure(program_, facts(now, *pace), options_.longest_run);
}

/// Something is ahead, and within reach of the longest run, after which steps may be longer: a time at which a
/// condition changes for the first time in a while, or the end of a motion that dies out.
bool PaceLimit::pace_may_change(const RunPosition& now, const Headway::Pace& pace) {
  const double reach = options_.longest_run * pace.stretch / pace.seconds;
  const bool quiet = now.t - now.jumped_at >= pace.stretch;
  if (quiet && now.next_known && *now.next_known - now.t < reach) return true;
  if (now.integrator == nullptr || inputs_.step > 0.0) return false;
  if (!now.explicit_form || program_.state_names.size() > kDenseStates) return now.seconds < kUnknownSpectrum;
  const double step = pace.stretch / static_cast<double>(std::max<std::uint64_t>(now.steps - before_.steps, 1));
  return may_pick_up(program_, evaluator_, now.t, now.x, *now.branch, step, now.t - now.jumped_at, reach);
}

PaceFacts PaceLimit::facts(const RunPosition& now, const Headway::Pace& pace) {
  PaceFacts facts;
  facts.t = now.t;
  facts.stop = inputs_.stop;
  facts.seconds = now.seconds;
  facts.pace = pace;
  facts.fixed_step = inputs_.step;
  const double steps = static_cast<double>(std::max<std::uint64_t>(now.steps - before_.steps, 1));
  facts.events = static_cast<double>(now.events - before_.events) / steps;
  facts.jumps = static_cast<double>(now.jumps - before_.jumps) / steps;
  facts.rows = static_cast<double>(now.rows - before_.rows) / steps;
  facts.relation = now.relation;
  if (longest_step_ > 0.0 && 2.0 * pace.progress * (1.0 + facts.rows) > longest_step_)
    facts.source_frequency = source_frequency_;
  if (now.integrator == nullptr) return facts;
  const Integrator::Counts counts = now.integrator->counts();
  facts.iteration_fails = 4 * counts.convergence_failures > counts.steps;
  std::vector<double> errors(now.integrator->size());
  now.integrator->weighted_errors(errors.data());
  const auto largest = static_cast<std::size_t>(std::max_element(errors.begin(), errors.end()) - errors.begin());
  const std::size_t states = program_.state_names.size();
  facts.unknown = largest < states ? program_.state_names[largest] : program_.tear_names[largest - states];
  if (largest < states) facts.place = program_.states[largest].place;
  if (now.explicit_form) facts.fastest = fastest_motion(program_, evaluator_, now.t, now.x, *now.branch);
  return facts;
}

}  // namespace bgsim
