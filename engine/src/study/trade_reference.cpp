// The trade's reference: several methods at a tight tolerance, and how far they stay from each other.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/codes.hpp"
#include "run/failures.hpp"
#include "run/integrate/spectrum.hpp"
#include "study/trade_runs.hpp"

namespace bgsim {

namespace {

/// An output that varies by less than so many times what two tight runs differ by is taken for zero, or a constant.
constexpr double kNoise = 10.0;
/// Part of an output's magnitude that two tight runs always agree to, so that a constant is not judged by its last
/// bits.
constexpr double kConstant = 1e-9;

struct Candidate {
  TradeSetting setting;
  TimedRun run;
  bool finished = false, hopeless = false;
  std::string why;
};

struct OutputRange {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  [[nodiscard]] double width() const { return high - low; }
  [[nodiscard]] double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
};

std::vector<OutputRange> ranges_of(const Trace& trace) {
  std::vector<OutputRange> ranges(trace.columns.size());
  for (std::size_t c = 0; c < ranges.size(); ++c)
    for (const double value : trace.columns[c]) {
      ranges[c].low = std::min(ranges[c].low, value);
      ranges[c].high = std::max(ranges[c].high, value);
    }
  return ranges;
}

}  // namespace

void mark_zeros(const Trace& trace, Zeros& zeros) {
  const std::vector<OutputRange> ranges = ranges_of(trace);
  zeros.resize(ranges.size(), false);
  for (std::size_t c = 0; c < ranges.size(); ++c) zeros[c] = zeros[c] || ranges[c].magnitude() == 0.0;
}

namespace {

/// The instants of events, as an output more.
TradeOutput instants_of(double span, const EventDistance& distance) {
  TradeOutput output;
  output.name = "event times";
  output.unit = "s";
  output.range = span;
  if (output.range <= kNoise * distance.largest) {
    output.why_not = "two tight runs differ in the instants of " + distance.what;
    output.unresolved = true;
  } else {
    output.reference = distance.largest / output.range;
  }
  return output;
}

}  // namespace

double compare(const TradeCourse& first, const TradeCourse& other, const Zeros& zeros,
               std::vector<TradeOutput>& outputs) {
  const Trace& trace = first.trace;
  const Trace& second = other.trace;
  const std::size_t columns = trace.names.size();
  const std::vector<OutputRange> ranges = ranges_of(trace);
  const double span = trace.times.empty() ? 0.0 : trace.times.back() - trace.times.front();
  const EventDistance instants = event_distance(first.events, other.events, span);
  std::vector<double> difference(columns, 0.0);
  for (std::size_t c = 0; c < columns; ++c)
    for (std::size_t i = 0; i < trace.times.size(); ++i)
      if (!instants.parted(trace.times[i]))
        difference[c] = std::max(difference[c], std::abs(trace.columns[c][i] - second.columns[c][i]));
  outputs.assign(columns, {});
  double largest = 0.0;
  for (std::size_t c = 0; c < columns; ++c) {
    TradeOutput& output = outputs[c];
    output.name = trace.names[c];
    output.unit = trace.units[c];
    const double width = ranges[c].width(), magnitude = ranges[c].magnitude();
    const bool constant = width <= kConstant * magnitude;
    output.range = constant ? magnitude : width;
    if (zeros[c]) {
      output.why_not = "zero throughout";
    } else if (output.range <= kNoise * difference[c]) {
      output.why_not = "not distinguishable from zero: two tight runs differ by as much as it varies";
      output.drowned = output.unresolved = true;
    } else {
      output.reference = difference[c] / output.range;
      largest = std::max(largest, output.reference);
    }
  }
  if (first.events.all().empty() && other.events.all().empty()) return largest;
  outputs.push_back(instants_of(span, instants));
  return std::max(largest, outputs.back().reference);
}

namespace {

[[noreturn]] void give_up(std::string situation, std::vector<Note> notes, std::string help) {
  Diagnostic diagnostic = diagnostic_of("BG611");
  diagnostic.situation = std::move(situation);
  diagnostic.notes = std::move(notes);
  diagnostic.rule = "errors are measured against a reference, and a second method must vouch for it";
  diagnostic.help = std::move(help);
  throw TradeFailure(std::move(diagnostic));
}

struct Best {
  double error = std::numeric_limits<double>::infinity();
  std::size_t first = 0, second = 0;
  std::vector<TradeOutput> outputs;
  /// Number of outputs that move, but not above the noise: another pair may tell them.
  [[nodiscard]] auto noisy() const {
    return std::count_if(outputs.begin(), outputs.end(), [](const TradeOutput& output) { return output.unresolved; });
  }
  [[nodiscard]] bool better_than(const Best& other) const {
    return other.outputs.empty() || std::pair(noisy(), error) < std::pair(other.noisy(), other.error);
  }
  [[nodiscard]] bool good_enough(double wanted) const { return !outputs.empty() && noisy() == 0 && error <= wanted; }
};

/// The two that agree best. Of the two the one with the smaller distance to a third is not known; the first that ended
/// is taken, since its error is at most the distance if the other's is not larger.
Best best_pair(const std::vector<Candidate>& candidates, const Zeros& zeros) {
  Best best;
  for (std::size_t a = 0; a < candidates.size(); ++a)
    for (std::size_t b = a + 1; b < candidates.size(); ++b) {
      if (!candidates[a].finished || !candidates[b].finished) continue;
      Best pair{0.0, a, b, {}};
      const TimedRun &one = candidates[a].run, &other = candidates[b].run;
      pair.error = compare({one.result.trace, one.events}, {other.result.trace, other.events}, zeros, pair.outputs);
      if (pair.better_than(best)) best = std::move(pair);
    }
  return best;
}

std::vector<Candidate> candidates_at(double relative) {
  std::vector<Candidate> candidates;
  for (const Method method :
       {Method::radau, Method::dirk5, Method::erk8, Method::bdf, Method::adams, Method::ida, Method::erk5})
    candidates.push_back({{method, 0, relative, 0.0}, {}, false, false, {}});
  return candidates;
}

/// Candidates at one tolerance, and the two of them that agree best.
struct Attempt {
  std::vector<Candidate> candidates;
  Best best;
  [[nodiscard]] bool found() const { return !best.outputs.empty(); }
};

/// Runs what has not ended yet within @p limit; ends as soon as two agree as wanted. True then.
bool extend(TradeRuns& runs, Attempt& attempt, Zeros& zeros, double limit, double wanted) {
  for (Candidate& candidate : attempt.candidates) {
    if (candidate.finished || candidate.hopeless || runs.ended()) continue;
    runs.tell("reference: " + setting_flags(candidate.setting));
    TimedRun run = runs.exact(candidate.setting, limit);
    candidate.finished = run.completed();
    candidate.hopeless = !run.completed() && !run.cut;
    if (!candidate.finished) {
      candidate.why =
          run.cut ? "cut after " + number_text(limit, 2) + " s at t = " + number_text(run.result.report.reached, 4)
                  : run.result.failure.value().situation;
      continue;
    }
    candidate.run = std::move(run);
    mark_zeros(candidate.run.result.trace, zeros);
    attempt.best = best_pair(attempt.candidates, zeros);
    if (attempt.best.good_enough(wanted)) return true;
  }
  return false;
}

/// Every candidate gets a little time, then those that are left get more: the method that suits need not be known.
Attempt attempt_at(TradeRuns& runs, Zeros& zeros, double relative, double wanted, double budget) {
  constexpr std::array<double, 4> kParts{1.0 / 200.0, 1.0 / 40.0, 1.0 / 10.0, 1.0 / 3.0};
  constexpr double kAcceptable = 1e-6, kPatience = 1.0 / 50.0;
  Attempt attempt;
  attempt.candidates = candidates_at(relative);
  for (const double part : kParts) {
    if (extend(runs, attempt, zeros, part * budget, wanted)) break;
    if (attempt.found() && (part > kPatience || attempt.best.good_enough(std::max(kAcceptable, wanted)))) break;
  }
  return attempt;
}

}  // namespace

void require_measurable(const TradeRuns& runs) {
  if (runs.program().state_names.empty())
    give_up("the model has no states, so no method has anything to do", {}, "run it: its outputs are exact");
  if (runs.program().output_names.empty())
    give_up("the scene has no outputs to judge errors by", {}, "name \"outputs\" in the model");
  if (!(runs.inputs().stop > runs.inputs().start))
    give_up("the scene stops where it starts", {}, "let \"stop\" be later than \"start\"");
}

ReferenceTrace find_reference(TradeRuns& runs, double relative, double wanted, double budget) {
  require_measurable(runs);
  constexpr double kTightest = 1e-13, kLoosest = 1e-7, kTighter = 100.0;
  // A tolerance a hundred times tighter costs some three times as much; what takes thirty times as long is of no use.
  constexpr double kPatience = 30.0;
  Zeros zeros;
  Attempt attempt = attempt_at(runs, zeros, relative, wanted, budget);
  for (double tolerance = relative / kTighter;
       attempt.found() && !attempt.best.good_enough(wanted) && tolerance > 0.9 * kTightest && !runs.ended();
       tolerance /= kTighter) {
    const double cost = attempt.candidates[attempt.best.first].run.cpu_seconds;
    Attempt tighter = attempt_at(runs, zeros, tolerance, wanted, std::min(budget, kPatience * std::max(cost, 1e-2)));
    if (!tighter.found()) break;
    if (tighter.best.better_than(attempt.best)) attempt = std::move(tighter);
  }
  std::vector<Note> notes;
  for (double looser = relative * kTighter; !attempt.found() && looser <= kLoosest; looser *= kTighter) {
    for (const Candidate& candidate : attempt.candidates)
      notes.push_back({std::nullopt, setting_flags(candidate.setting) + ": " + candidate.why});
    attempt = attempt_at(runs, zeros, looser, wanted, budget);
  }
  if (runs.ended()) give_up("the trade was ended before it had a reference", {}, "let it run on");
  if (!attempt.found())
    give_up("no two methods come to the end of the scene with a tight tolerance", std::move(notes),
            "a larger --budget gives each run more time; a scene that fails by itself must be corrected first");
  ReferenceTrace reference;
  const Best& best = attempt.best;
  Candidate& first = attempt.candidates[best.first];
  reference.trace = std::move(first.run.result.trace);
  reference.events = std::move(first.run.events);
  reference.facts = {first.setting, attempt.candidates[best.second].setting, best.error, first.run.cpu_seconds, {}};
  reference.outputs = best.outputs;
  for (std::size_t c = 0; c < reference.outputs.size(); ++c) {
    TradeOutput& output = reference.outputs[c];
    const bool zero = c < zeros.size() && zeros[c];
    output.unresolved = output.unresolved && !zero && first.setting.relative > kTellsZero;
    if (output.unresolved && reference.facts.unresolved.empty()) reference.facts.unresolved = output.name;
  }
  const auto any = [&](const auto& is) { return std::any_of(reference.outputs.begin(), reference.outputs.end(), is); };
  if (!any([](const TradeOutput& output) { return output.judged(); }) &&
      any([](const TradeOutput& output) { return output.drowned; }))
    give_up("no output can be judged: " + setting_flags(reference.facts.setting) + " and " +
                setting_flags(reference.facts.second) + " differ by as much as each of them varies",
            {}, "record what the outputs are made of, whose parts are larger");
  if (!any([](const TradeOutput& output) { return output.judged(); }))
    give_up("no output of the scene moves: there is nothing to judge errors by", {}, "record outputs that vary");
  return reference;
}

double fastest_rate(const Program& program, const RunInputs& inputs) {
  constexpr std::size_t kMostStates = 200;
  const std::size_t states = program.state_names.size();
  if (states == 0 || states > kMostStates || !program.switch_elements.empty() || !program.plan.explicit_form)
    return 0.0;
  Evaluator evaluator(program, inputs.parameters);
  const std::vector<double> x = initial_states(evaluator, inputs);
  Branch branch = first_branch(program);
  if (!evaluator.initialize_modes(inputs.start, x.data(), branch)) return 0.0;
  double fastest = 0.0;
  for (const std::complex<double> mode : eigenvalues(program, evaluator, inputs.start, x.data(), branch))
    fastest = std::max(fastest, std::abs(mode));
  return fastest;
}

}  // namespace bgsim
