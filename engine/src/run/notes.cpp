#include "run/notes.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "run/failures.hpp"
#include "run/watch/source_pace.hpp"

namespace bgsim {

namespace {

/// A condition in a network contains the laws of its neighbours.
std::string shortened(const std::string& text) {
  constexpr std::size_t kLongest = 160;
  return text.size() > kLongest ? text.substr(0, kLongest) + " ..." : text;
}

}  // namespace

std::optional<std::string> quiet_states_note(const Tolerances& tolerances, const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 5;
  std::size_t quiet = 0;
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!tolerances.given(i) || tolerances.largest(i) > tolerances.absolute(i)) continue;
    if (quiet < kMost) text += (quiet == 0 ? "\"" : ", \"") + names[i] + "\"";
    ++quiet;
  }
  if (quiet == 0) return std::nullopt;
  if (quiet > kMost) text += " and " + std::to_string(quiet - kMost) + " more";
  return "never above the absolute tolerance given, hence not controlled: " + text;
}

std::optional<std::string> fast_sources_note(double frequency, double span, std::uint64_t steps) {
  const double step = span / static_cast<double>(steps);
  if (steps == 0 || !(frequency * step > kFollowedPeriods)) return std::nullopt;
  return "a source goes up and down about " + number_text(frequency, 1) +
         " times per unit of time, of which the steps (" + number_text(step, 1) +
         " on average) saw samples only: tighten the tolerance, or replace it by its mean";
}

std::string undecided_note(const Relation& relation, double since) {
  return "from t = " + number_text(since, 6) + " on, " + relation.text +
         " is at its border, or so near that rounding decides: the search for its changes ended there, and it stays as "
         "it was; write it so that its sides differ";
}

std::optional<std::string> indefinite_shares_note(const std::vector<std::size_t>& outputs,
                                                  const std::vector<std::string>& names) {
  if (outputs.empty()) return std::nullopt;
  std::vector<std::string> named;
  for (const std::size_t output : outputs) named.push_back(names[output]);
  return list_of(named, " and ", 6) + (outputs.size() == 1 ? " is" : " are") +
         " indefinite while more frictions or valves hold than what they hold has ways to move: what each takes is one "
         "of many shares";
}

std::optional<std::string> open_balance_note(const EnergyAudit& energy, double relative) {
  constexpr double kOpen = 1e-3, kTimesTolerance = 3.0;
  if (!energy.done || !(energy.relative > std::max(kOpen, kTimesTolerance * relative))) return std::nullopt;
  return "the energy balance is off by " + number_text(100.0 * energy.relative, 2) +
         " %: the run is less accurate than its tolerance, or a law creates or absorbs energy; a smaller relative "
         "tolerance shows which";
}

std::string lost_errors_note(const std::string& why) {
  return "what the outputs are wrong by could not be estimated: " + why;
}

std::optional<std::string> output_errors_note(const OutputErrors& errors, const std::vector<std::string>& names,
                                              double relative) {
  constexpr std::size_t kMost = 5;
  if (!errors.done) return std::nullopt;
  std::vector<std::pair<double, std::size_t>> wrong, open;  // part of the range, output
  for (std::size_t k = 0; k < names.size(); ++k) {
    const double error = errors.estimate[k], range = errors.range[k];
    // What stands still but for the tolerance has no range to compare with, nor has what is zero but for rounding.
    const bool still = errors.is_still(k, relative);
    const double tolerance = relative * errors.magnitude[k];
    const double least = std::max(OutputErrors::kLarge * range, still ? tolerance : 0.0);
    const auto above = [&](double limit) { return error > limit && 2.0 * errors.beyond_rounding[k] > limit; };
    // Where the tolerance alone is more of the range than that, the estimate must be clear of it by what it is known
    // to.
    constexpr double kKnownTo = 5.0;
    const bool coarse = tolerance > OutputErrors::kLarge * range && !still;
    if (above(least))
      wrong.emplace_back(error / range, k);
    else if (coarse && above(least / kKnownTo))
      open.emplace_back(error / range, k);
  }
  if (wrong.empty() && open.empty()) return std::nullopt;
  std::stable_sort(wrong.begin(), wrong.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  const auto drowned = static_cast<std::size_t>(
      std::count_if(wrong.begin(), wrong.end(), [](const auto& output) { return output.first >= 1.0; }));
  const auto list_of = [&](const auto& outputs, std::size_t from, std::size_t to, const auto& words) {
    std::string text;
    for (std::size_t k = from; k < to && k < from + kMost; ++k)
      text += (k == from ? "\"" : ", \"") + names[outputs[k].second] + "\" " + words(outputs[k]);
    return to > from + kMost ? text + " and " + std::to_string(to - from - kMost) + " more" : text;
  };
  const auto list = [&](std::size_t from, std::size_t to, const auto& words) {
    return list_of(wrong, from, to, words);
  };
  const auto percent = [](const auto& output) { return "by " + number_text(100.0 * output.first, 2) + " %"; };
  std::string text;
  if (drowned > 0)
    text = "outputs vary by no more than they are estimated to be wrong by: " +
           list(0, drowned,
                [&](const auto& output) { return "(" + number_text(errors.estimate[output.second], 2) + ")"; });
  if (drowned < wrong.size())
    text += (drowned > 0 ? "; " : "") +
            std::string("outputs are estimated to be wrong by more than 0.01 % of their range: ") +
            list(drowned, wrong.size(), percent);
  if (!open.empty())
    text += (wrong.empty() ? "" : "; ") +
            std::string(
                "outputs vary by so little beside the tolerance that they are not known to 0.01 % of their range, ") +
            "though estimated to be wrong by less: " + list_of(open, 0, open.size(), percent);
  return text + "; a smaller relative tolerance, or --accuracy, gives more digits";
}

std::optional<std::string> beyond_first_order_note(const OutputErrors& errors, const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 5;
  std::vector<std::string> grown;
  double largest = 0.0;
  for (const std::size_t k : errors.beyond_first_order) {
    const double part = errors.estimate[k] / errors.range[k];
    if (part > OutputErrors::kLarge) continue;  // output_errors_note has it
    grown.push_back(names[k]);
    largest = std::max(largest, part);
  }
  if (grown.empty()) return std::nullopt;
  return "to first order, errors of " + list_of(grown, " and ", kMost) +
         " grow to more than what these vary by; a second run " + errors.second_run + " differs by " +
         number_text(largest, 2) + " of the range";
}

std::optional<std::string> negative_start_note(const Program& program, const std::vector<double>& x) {
  for (const Relation& relation : program.relations) {
    if (relation.kind != Relation::Kind::denominator) continue;
    const auto state = std::find(program.state_names.begin(), program.state_names.end(), relation.text);
    if (state == program.state_names.end()) continue;
    const double start = x[static_cast<std::size_t>(state - program.state_names.begin())];
    if (start < 0.0)
      return "a law divides by " + relation.text + ", which is negative at the start (" + number_text(start, 4) +
             "): if this is a volume or a distance, the run is outside the domain of its law";
  }
  return std::nullopt;
}

std::string spent_mode_words(const SpentMode& mode) {
  return "higher orders would be unstable for an eigenmode of " + number_text(mode.frequency, 2) +
         " rad per unit of time, which dies out in " + number_text(1.0 / mode.damping, 1);
}

std::string near_miss_note(const Relation& relation, double time) {
  return "near t = " + number_text(time, 6) + " " + shortened(relation.text) +
         " comes as near to its border as the run is estimated to be wrong, and turns back: a smaller relative "
         "tolerance tells whether it changes there";
}

std::string doubtful_set_note(const std::string& state, double time) {
  return "at t = " + number_text(time, 6) + " what \"" + state +
         "\" is set to is as near to a border of its law as the run is estimated to be wrong: a smaller relative "
         "tolerance tells on which side it is";
}

std::string unproven_note(const Relation& relation, double time) {
  return "whether " + shortened(relation.text) +
         " changed within a step could not be decided within the work allowed, first near t = " + number_text(time, 4) +
         ": shorter steps (a smaller relative tolerance) decide it";
}

std::string coarse_delay_note(const std::string& signal, double time) {
  return "what \"" + signal +
         "\" delays changes within a step by more than its record shows, first near t = " + number_text(time, 4) +
         ": a smaller relative tolerance shows whether it matters";
}

std::string unseen_law_note(const std::string& state, double time) {
  return "the rate of \"" + state +
         "\" varies within steps by more than they show, first near t = " + number_text(time, 4) +
         ": a smaller relative tolerance shows whether it matters";
}

}  // namespace bgsim
