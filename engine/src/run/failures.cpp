#include "run/failures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/codes.hpp"

namespace bgsim {

namespace {

Diagnostic failure(std::string_view code, std::string situation) { return diagnostic_of(code, std::move(situation)); }

std::string at(double t) { return " at t = " + number_text(t); }

const char* const kLoopRule = "an algebraic loop needs values that satisfy all laws on it at once";
const char* const kLoopHelp =
    "where a law folds back the solution can end: put a small C or I on the loop, or check the laws";

}  // namespace

std::string first_names(const std::vector<std::string>& names) {
  std::string text;
  constexpr std::size_t kMost = 5;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i == 0 ? "\"" : ", \"") + names[i] + "\"";
  if (names.size() > kMost) text += " and " + std::to_string(names.size() - kMost) + " more";
  return text;
}

Diagnostic branch_failure(const ProgramBlock& loop, const std::string& variable, double t, double before,
                          double after) {
  std::string elements;
  for (const std::string& name : loop.elements) elements += (elements.empty() ? "" : ", ") + name;
  const std::string from = number_text(before, 6), to = number_text(after, 6);
  Diagnostic diagnostic =
      failure("BG602", "the solution of the loop through " + elements + " ends" + at(t) + ": " +
                           (from == to ? "another one meets it at " + variable + " = " + from
                                       : variable + " would go from " + from + " to " + to + " at once"));
  diagnostic.rule = kLoopRule;
  diagnostic.help = kLoopHelp;
  diagnostic.place = loop.place;
  return diagnostic;
}

Diagnostic fault_failure(const Fault& fault) {
  const std::string target = fault.target.empty() ? "" : ", needed for " + fault.target;
  const std::string of = fault.elements.empty() ? "" : " of " + first_names(fault.elements);
  Diagnostic diagnostic;
  switch (fault.kind) {
    case Fault::Kind::loop_no_convergence:
      diagnostic = failure("BG602", "no solution was found for " + fault.target + at(fault.time) +
                                        (fault.what.empty() ? "" : "; last tried " + fault.what));
      diagnostic.rule = kLoopRule;
      diagnostic.help = kLoopHelp;
      break;
    case Fault::Kind::loop_singular:
      diagnostic = failure("BG603", fault.target + " is singular" + at(fault.time) +
                                        (fault.what.empty() ? "" : ", where " + fault.what));
      diagnostic.rule = "the laws on an algebraic loop must determine its variables";
      diagnostic.help = "two laws on the loop are equivalent here, or the loop's gain is exactly 1";
      break;
    case Fault::Kind::outside_table:
      diagnostic =
          failure("BG608", "a table is read outside its data" + at(fault.time) + ": " + fault.what + of + target);
      diagnostic.rule = "measured data are not extrapolated";
      diagnostic.help = "extend the data, shorten the scene, or limit the argument with min and max";
      break;
    default:
      diagnostic = failure("BG601", fault.what + of + " is not a finite number" + at(fault.time) + target);
      diagnostic.rule = "every law must give a finite number wherever the run takes it";
      diagnostic.help =
          "the model has left the law's domain: limit the argument, regularise the law (ssqrt for a square root), or "
          "check parameters and units";
  }
  diagnostic.place = fault.place;
  return diagnostic;
}

RelationFacts relation_facts(const Program& program, std::size_t relation) {
  const Relation& r = program.relations[relation];
  RelationFacts facts;
  facts.text = r.text;
  const Model& model = *program.model;
  if (r.where.element.valid()) {
    facts.where = model.elements[r.where.element.index()].name;
    facts.place = model.elements[r.where.element.index()].place;
  } else if (r.where.signal.valid()) {
    facts.where = model.signals[r.where.signal.index()].name;
    facts.place = model.signals[r.where.signal.index()].place;
  }
  return facts;
}

namespace {

void name_relations(Diagnostic& diagnostic, const Program& program, std::span<const std::size_t> relations) {
  for (const std::size_t relation : relations) {
    const RelationFacts facts = relation_facts(program, relation);
    if (relation == relations.front()) {
      diagnostic.place = facts.place;
      continue;
    }
    diagnostic.notes.push_back(
        {facts.place, "so does " + facts.text + (facts.where.empty() ? "" : " of \"" + facts.where + "\"")});
  }
}

std::string first_relation(const Program& program, std::span<const std::size_t> relations) {
  if (relations.empty()) return "a condition";
  const RelationFacts facts = relation_facts(program, relations.front());
  return facts.text + (facts.where.empty() ? "" : " of \"" + facts.where + "\"");
}

/// Roundings decide its digits, so only its order is worth telling.
double decade_above(double value) { return value > 0.0 ? std::pow(10.0, std::ceil(std::log10(value))) : 0.0; }

}  // namespace

Diagnostic chattering_failure(const Program& program, std::span<const std::size_t> relations, double t,
                              std::size_t events, double gap, bool accumulating) {
  Diagnostic diagnostic = failure(
      "BG604", first_relation(program, relations) + (accumulating ? " changes ever faster towards" : " chatters at") +
                   " t = " + number_text(t) + ": the last " + std::to_string(events) + " changes came within " +
                   number_text(decade_above(gap * static_cast<double>(events)), 1));
  name_relations(diagnostic, program, relations);
  diagnostic.rule = "between two changes of a condition some time must pass";
  diagnostic.help =
      "both sides of the condition push back to it: give it a hysteresis, or replace the jump by a steep smooth law "
      "such "
      "as tanh(x/width)";
  return diagnostic;
}

Diagnostic returning_failure(const Program& program, std::size_t relation, double t, std::size_t times) {
  const std::array<std::size_t, 1> relations = {relation};
  Diagnostic diagnostic =
      failure("BG604", first_relation(program, relations) + " comes back to its border again and again" + at(t) + ": " +
                           std::to_string(times) + " times within what the tolerances leave open");
  name_relations(diagnostic, program, relations);
  diagnostic.rule = "between two changes of a condition some time must pass";
  diagnostic.help =
      "the law on one side ends at the border and the other side pushes back to it: give both sides one value there, "
      "the "
      "condition a hysteresis, or replace the jump by a steep smooth law such as tanh(x/width)";
  return diagnostic;
}

Diagnostic contradiction_failure(const Program& program, std::span<const std::size_t> relations, double t) {
  Diagnostic diagnostic =
      failure("BG604", first_relation(program, relations) + " contradicts itself in either state" + at(t));
  name_relations(diagnostic, program, relations);
  diagnostic.rule = "the conditions of a model must be consistent with their own effects";
  diagnostic.help = "a condition that undoes itself at once needs a hysteresis or a delay (a store) on its way";
  return diagnostic;
}

Diagnostic singularity_failure(const Program& program, std::size_t relation, double t) {
  const RelationFacts facts = relation_facts(program, relation);
  const std::string of = facts.where.empty() ? "" : " of \"" + facts.where + "\"";
  const bool structural = program.relations[relation].structural;
  // The time carries the error of the whole run, hence few digits.
  Diagnostic diagnostic =
      failure("BG613", facts.text + ", by which the law" + of + " divides, passes 0 near t = " + number_text(t, 6));
  diagnostic.place = facts.place;
  diagnostic.rule = structural
                        ? "a resistance that gives a flow, a capacitance, an inertance or a modulus that is divided "
                          "by must keep its sign"
                        : "a denominator must not reach zero: beyond this singularity the system is another one";
  diagnostic.help =
      structural ? "keep it away from zero: max(value, least), or change the causality with a store or a \"priority\""
                 : "add what keeps the denominator from zero (a stop, a residual volume), or end the scene earlier";
  return diagnostic;
}

std::optional<BlowUp> recognise_blow_up(const StuckPoint& point) {
  constexpr double kGrown = 1e3, kSudden = 1e-3, kOverflow = 1e290, kBack = 1e-3, kFaster = 1.02;
  std::optional<BlowUp> found;
  for (std::size_t i = 0; i < point.largest_early.size(); ++i)
    if (std::abs(point.y[i]) > kOverflow) return BlowUp{i, point.t, true};
  for (std::size_t i = 0; i < point.rate.size(); ++i) {
    const double size = std::abs(point.y[i]);
    if (!(point.y[i] * point.rate[i] > 0.0) || !(size > kGrown * point.largest_early[i])) continue;
    const double growth_time = point.y[i] / point.rate[i];
    if (!(growth_time < kSudden * (point.t - point.start))) continue;
    const std::vector<double> before = point.rate_before(kBack * growth_time);
    if (!before.empty() && !(1.0 - before[i] / point.rate[i] > kBack * kFaster)) continue;
    if (!found || point.t + growth_time < found->time) found = BlowUp{i, point.t + growth_time, false};
  }
  return found;
}

Diagnostic stuck_failure(const StuckPoint& point) {
  if (const auto blow_up = recognise_blow_up(point)) {
    const std::string state = "\"" + point.names[blow_up->state] + "\"";
    // The date carries the error of the whole run, hence few digits.
    Diagnostic diagnostic =
        failure("BG605", blow_up->overflow ? state + " outgrows the range of numbers" + at(point.t)
                                           : state + " grows without bound near t = " + number_text(blow_up->time, 4));
    diagnostic.place = point.places[blow_up->state];
    diagnostic.notes.push_back({std::nullopt, state + " is " + number_text(point.y[blow_up->state], 2) + at(point.t)});
    diagnostic.rule = "the states of a run must be finite";
    diagnostic.help = "the state grows faster and faster: look for a missing limit, a wrong sign, or an active element";
    return diagnostic;
  }
  Diagnostic diagnostic = failure("BG605", "the step size went to nothing" + at(point.t) + ": " + point.words);
  std::vector<std::size_t> order(point.weighted_error.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  constexpr std::size_t kMost = 3;
  const std::size_t shown = std::min(kMost, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(shown), order.end(),
                    [&](std::size_t a, std::size_t b) {
                      return std::pair(-point.weighted_error[a], a) < std::pair(-point.weighted_error[b], b);
                    });
  for (std::size_t k = 0; k < shown; ++k) {
    const std::size_t i = order[k];
    if (!(point.weighted_error[i] > 0.0) && k > 0) break;
    std::string text = "\"" + point.names[i] + "\" is " + number_text(point.y[i], 6);
    if (i < point.rate.size()) text += ", changing by " + number_text(point.rate[i], 6) + " per unit of time";
    text += "; its error is estimated at " + number_text(point.weighted_error[i], 3) + " times its tolerance";
    diagnostic.notes.push_back({point.places[i], std::move(text)});
    if (k == 0) diagnostic.place = point.places[i];
  }
  diagnostic.rule = "the solution must be smooth between events at the scale of the time's own resolution";
  diagnostic.help =
      "look for a law with a jump or an infinite slope there, or for a tolerance below what rounding allows";
  return diagnostic;
}

Diagnostic time_constant_failure(const std::string& state, double time_constant, double span, const Place& place) {
  Diagnostic diagnostic =
      failure("BG614", "the time constant of \"" + state + "\" is " + number_text(time_constant, 2) +
                           ", for a scene of " + number_text(span, 2));
  diagnostic.place = place;
  diagnostic.rule = "a time constant may be 1e70 times shorter than the scene at most";
  diagnostic.help =
      "at this scale the store is always in balance: leave it out, or give it a value of the scene's scale";
  return diagnostic;
}

Diagnostic narrow_pulse_failure(const std::string& source, double begin, double width, double wide_enough,
                                const std::optional<Place>& place) {
  Diagnostic diagnostic = failure("BG615", "the source " + source + " has a pulse" + at(begin) +
                                               " that lasts no longer than " + number_text(width, 2));
  diagnostic.place = place;
  diagnostic.rule = "double precision resolves times to 1e-16 of their value, and a pulse needs 1e5 of these steps";
  diagnostic.help = "let it last " + number_text(wide_enough, 2) +
                    " or longer, with the same area; an impulse of no duration is an initial value: add it to the "
                    "momentum or displacement of a store, in a scene that starts there";
  return diagnostic;
}

Diagnostic interrupted_failure(double t) { return failure("BG606", "the run was interrupted" + at(t)); }

Diagnostic step_limit_failure(double t, double stop, std::uint64_t steps) {
  Diagnostic diagnostic = failure("BG607", "the limit of " + std::to_string(steps) + " steps was reached" + at(t) +
                                               ", before the stop at t = " + number_text(stop));
  diagnostic.help = "allow more steps, loosen the tolerance, or look for oscillations far faster than the scene";
  return diagnostic;
}

Diagnostic accuracy_failure(double t, double relative) {
  Diagnostic diagnostic =
      failure("BG609", "the relative tolerance " + number_text(relative, 3) + " is beyond double precision" + at(t));
  diagnostic.rule = "rounding limits the accuracy to about 1e-14 of each state, or worse where large terms cancel";
  diagnostic.help = "use a relative tolerance of 1e-12 or more";
  return diagnostic;
}

Diagnostic needs_explicit_form_failure(const std::string& method) {
  Diagnostic diagnostic =
      failure("BG610", "the method \"" + method + "\" cannot be used: the loops are not solved inside the equations");
  diagnostic.rule = "explicit, diagonally implicit and fixed-step methods need the rates as functions of the states";
  diagnostic.help = "take \"ida\", \"radau\" or \"rodas5p\", which solve for states and loops together";
  return diagnostic;
}

}  // namespace bgsim
