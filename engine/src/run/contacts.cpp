#include "run/contacts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/codes.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"

namespace bgsim {
namespace {

constexpr std::size_t kKept = 5;  ///< four intervals, hence three ratios

std::string quoted(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i == 0 ? "" : ", ") + in_quotes(names[i]);
  if (names.size() > kMost) text += " and " + std::to_string(names.size() - kMost) + " more";
  return text;
}

std::string series_words(const ContactHistory& history, const Accumulation& series) {
  const std::string impacts =
      std::to_string(history.impacts) + (history.impacts == 1 ? " impact" : " impacts") + " so far, ";
  if (series.ratio == 0.0) return impacts + "and the last flight was lost in the rounding of its way";
  return impacts + "each interval " + number_text(series.ratio, 4) + " of the one before";
}

/// Of a series whose last two intervals are those between the last three of these times.
std::pair<double, double> ratio_and_limit(const std::vector<double>& times) {
  const std::size_t n = times.size();
  const double last = times[n - 1] - times[n - 2], ratio = last / (times[n - 2] - times[n - 3]);
  return {ratio, times[n - 1] + last * ratio / (1.0 - ratio)};
}

}  // namespace

std::optional<Accumulation> came_to_gap(ContactHistory& history, double t, double start, double stop, double early) {
  std::vector<double>& times = history.times;
  if (!times.empty() && times.back() == t) return std::nullopt;
  if (!times.empty()) history.longest = std::max(history.longest, t - times.back());
  if (times.size() == kKept) times.erase(times.begin());
  times.push_back(t);
  if (times.size() < kKept) return std::nullopt;
  // A flight of 2e-6 of the longest has 4e-12 of its height. Changes of the mode 1e-9 of the scene apart end a run.
  constexpr double kSteady = 1e-3, kShrinks = 1.0 - 1e-6, kResolved = 2e-6, kOfScene = 4e-9;
  const double last = t - times[kKept - 2];
  if (!(last < early * std::max(kResolved * history.longest, kOfScene * (stop - start)))) return std::nullopt;
  double least = kShrinks, most = 0.0;
  for (std::size_t k = 2; k < kKept; ++k) {
    const double ratio = (times[k] - times[k - 1]) / (times[k - 1] - times[k - 2]);
    least = std::min(least, ratio);
    most = std::max(most, ratio);
  }
  if (!(most < kShrinks) || most - least > kSteady) return std::nullopt;
  const auto [ratio, limit] = ratio_and_limit(times);
  const Accumulation series{ratio, limit, slows_down(history)};
  if (!(series.limit < stop)) return std::nullopt;
  return series;
}

bool slows_down(const ContactHistory& history) {
  constexpr double kTimes = 2.0;  // forces change
  const std::vector<double>& times = history.times;
  if (times.size() < 2 || !(history.longest > 0.0)) return true;
  const double last = times.back() - times[times.size() - 2];
  return history.rebound * history.longest <= kTimes * last * history.fastest;
}

bool ends_with(const ContactHistory& history, double limit) {
  constexpr double kSame = 0.1;  // of the last interval
  const std::vector<double>& times = history.times;
  if (times.size() < 3) return false;
  const auto [ratio, own] = ratio_and_limit(times);
  return ratio < 1.0 && std::abs(own - limit) <= kSame * (times.back() - times[times.size() - 2]);
}

std::string accumulation_note(const Element& contact, const ContactHistory& history, const Accumulation& series) {
  return "the contact " + in_quotes(contact.name) + " closes at t = " + number_text(series.limit, 13) +
         ", where infinitely many impacts add up: " + series_words(history, series);
}

Diagnostic accumulation_failure(const Element& contact, const ContactHistory& history, const Accumulation& series) {
  return diagnostic_of(
      "BG627",
      "the impacts of the contact " + in_quotes(contact.name) +
          " accumulate towards t = " + number_text(series.limit, 10) + ": " + series_words(history, series),
      contact.place, "the scene says \"zeno\": \"error\"", "with \"zeno\": \"close\" the contact closes there");
}

std::string simultaneous_note(const std::vector<std::string>& contacts, double t) {
  return "at t = " + number_text(t, 6) + " the contacts " + quoted(contacts) +
         " take impulses at once: Newton's restitution holds for all of them together (Moreau); one after the other "
         "they may come to other speeds";
}

std::string long_sequence_note(std::uint64_t impacts, double t) {
  return "at t = " + number_text(t, 6) + " contacts took " + std::to_string(impacts) +
         " impacts at one instant, and closed still: from there on without a rebound";
}

Diagnostic impact_failure(const std::vector<std::string>& contacts, double gained, double t) {
  return diagnostic_of("BG621",
                       "at t = " + number_text(t) + " the impact of " + quoted(contacts) + " would create " +
                           number_text(gained, 4) + " of energy",
                       {}, "an impact loses energy or keeps it",
                       std::string("Newton's rule keeps energy or loses it where the momenta are linear in the speeds, "
                                   "with positive inertances: look for an inertance below 0 or another law p(f)") +
                           (contacts.size() > 1 ? "; with \"impacts\": \"sequential\" the message names one contact"
                                                : "; a lower restitution loses more"));
}

}  // namespace bgsim
