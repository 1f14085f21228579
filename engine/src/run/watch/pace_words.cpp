#include "run/watch/pace_words.hpp"

#include "base/codes.hpp"
#include "run/failures.hpp"

namespace bgsim {

namespace {

/// "40 s", "12 min", "3.5 h", "20 days", "3e+90 years"
std::string duration_words(double seconds) {
  constexpr double kMinute = 60.0, kHour = 3600.0, kDay = 86400.0, kYear = 365.25 * kDay;
  if (seconds < 2.0 * kMinute) return number_text(seconds, 2) + " s";
  if (seconds < 2.0 * kHour) return number_text(seconds / kMinute, 2) + " min";
  if (seconds < 2.0 * kDay) return number_text(seconds / kHour, 2) + " h";
  if (seconds < 2.0 * kYear) return number_text(seconds / kDay, 3) + " days";
  return number_text(seconds / kYear, 2) + " years";
}

struct Limit {
  std::string words;
  std::optional<Place> place;
};

Limit limit_of(const Program& program, const PaceFacts& facts) {
  constexpr double kMany = 0.125;  // events a step
  constexpr double kManyRows = 8.0;
  const double step = facts.pace.progress * (1.0 + facts.rows);
  const auto every = [&](double by_step) { return ", every " + number_text(step / by_step, 2) + " of t"; };
  if (facts.events > kMany && facts.relation) {
    const RelationFacts relation = relation_facts(program, *facts.relation);
    return {"the condition " + relation.text + (relation.where.empty() ? "" : " of \"" + relation.where + "\"") +
                ", which changes" + every(facts.events),
            relation.place};
  }
  if (facts.jumps > kMany) return {"conditions of t, which change" + every(facts.jumps), {}};
  if (facts.rows > kManyRows) return {"the output times" + every(facts.rows), {}};
  if (facts.fixed_step > 0.0) return {"the length that was set for them, " + number_text(facts.fixed_step, 3), {}};
  if (facts.source_frequency > 0.0)
    return {"a source that goes up and down with a frequency of " + number_text(facts.source_frequency, 2), {}};
  Limit limit{"the error in " + (facts.unknown.empty() ? "the states" : "\"" + facts.unknown + "\""), facts.place};
  if (!facts.fastest) return limit;
  const FastestMotion& fastest = *facts.fastest;
  const std::string state = "\"" + program.state_names[fastest.state] + "\"";
  if (fastest.state == fastest.other)
    limit.words += "; the smallest time constant is that of " + state + ", ";
  else
    limit.words += "; the fastest motion is that of " + state + " against \"" + program.state_names[fastest.other] +
                   "\", with a time constant of ";
  limit.words += number_text(1.0 / fastest.rate, 2);
  return limit;
}

Diagnostic with_limit(Diagnostic diagnostic, const Program& program, const PaceFacts& facts) {
  Limit limit = limit_of(program, facts);
  const std::string step = number_text(facts.pace.progress * (1.0 + facts.rows), 2);
  diagnostic.notes.push_back({limit.place, "steps are " + step + " long on average, limited by " + limit.words});
  // A coil in front of diodes that all block: the voltage between these depends on currents of 1e-25 A.
  constexpr std::size_t kMostLoops = 4;
  for (const ProgramBlock& loop : program.blocks)
    if (facts.iteration_fails && !loop.linear && diagnostic.notes.size() <= kMostLoops)
      diagnostic.notes.push_back(
          {loop.place, "the integrator's iteration fails in more than every fourth step: what the loop through " +
                           first_names(loop.elements) +
                           " gives may depend on the states too sharply; a resistance or a small store at its nodes "
                           "makes it smoother"});
  return diagnostic;
}

std::string pace_text(const PaceFacts& facts) {
  return "t = " + number_text(facts.t, 3) + " of " + number_text(facts.stop, 3) + " after " +
         duration_words(facts.seconds) + "; at this pace it takes " + duration_words(facts.pace.rest) + " more";
}

}  // namespace

Diagnostic slow_run_remark(const Program& program, const PaceFacts& facts) {
  Diagnostic remark = diagnostic_of("BG616");
  remark.situation = "the run is slow: " + pace_text(facts);
  remark.help =
      "remove the fast motion, choose another method, or loosen the tolerance; a limit of time keeps "
      "what is computed until then";
  return with_limit(std::move(remark), program, facts);
}

Diagnostic endless_run_failure(const Program& program, const PaceFacts& facts, double longest_run) {
  Diagnostic failure = diagnostic_of("BG617");
  failure.situation = "the run was ended, because it would take too long: " + pace_text(facts);
  failure.rule = "a run at a steady pace that would take more than " + duration_words(longest_run) + " is ended";
  failure.help = "remove the fast motion, or choose another method; bgsim run --no-time-limit lets it go on";
  return with_limit(std::move(failure), program, facts);
}

Diagnostic time_limit_failure(double t, double stop, double seconds) {
  Diagnostic failure = diagnostic_of("BG618");
  failure.situation = "the limit of " + number_text(seconds, 6) +
                      " s of wall time was reached at t = " + number_text(t) +
                      ", before the stop at t = " + number_text(stop);
  failure.help = "allow more time, loosen the tolerance, or look for motion far faster than the scene";
  return failure;
}

}  // namespace bgsim
