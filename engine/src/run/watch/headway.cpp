#include "run/watch/headway.hpp"

#include <algorithm>
#include <array>

namespace bgsim {

namespace {

constexpr double kBetweenMarks = 0.1;      // seconds
constexpr double kMarksInRun = 512.0;      // at most, but for the first seconds
constexpr std::uint64_t kLeastWork = 100;  // steps and rows, before anything is said of a pace
constexpr double kPicksUp = 1.02;          // a step that grows by a fiftieth in a quarter of the stretch
constexpr std::size_t kQuarters = 4;

}  // namespace

void Headway::add(double seconds, double t, std::uint64_t work) {
  const double between = std::max(kBetweenMarks, seconds / kMarksInRun);
  if (!marks_.empty() && seconds - marks_.back().seconds < between) return;
  marks_.push_back({seconds, t, work});
  if (marks_.size() > static_cast<std::size_t>(kMarksInRun)) marks_.pop_front();
}

const Headway::Mark& Headway::mark_before(double seconds) const {
  const auto after = std::upper_bound(marks_.begin(), marks_.end(), seconds,
                                      [](double value, const Mark& mark) { return value < mark.seconds; });
  return after == marks_.begin() ? marks_.front() : *(after - 1);
}

std::optional<Headway::Pace> Headway::pace(double seconds) const {
  if (marks_.empty()) return std::nullopt;
  const Mark& now = marks_.back();
  double length = seconds;
  while (now.seconds - length >= marks_.front().seconds &&
         now.work - mark_before(now.seconds - length).work < kLeastWork)
    length *= 2.0;
  if (now.seconds - length < marks_.front().seconds) return std::nullopt;

  std::array<double, kQuarters> progress{};
  Pace pace;
  double best = 0.0;
  const Mark* from = &mark_before(now.seconds - length);
  pace.stretch = now.t - from->t;
  pace.seconds = now.seconds - from->seconds;
  pace.progress = pace.stretch / static_cast<double>(now.work - from->work);
  for (std::size_t i = 0; i < kQuarters; ++i) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(kQuarters);
    const Mark* const to = i + 1 == kQuarters ? &now : &mark_before(now.seconds - (1.0 - share) * length);
    if (to->work == from->work) return std::nullopt;
    progress[i] = (to->t - from->t) / static_cast<double>(to->work - from->work);
    best = std::max(best, (to->t - from->t) / (to->seconds - from->seconds));
    from = to;
  }
  if (progress.back() > kPicksUp * *std::max_element(progress.begin(), progress.end() - 1)) return std::nullopt;
  pace.rest = (stop_ - now.t) / best;
  return pace;
}

}  // namespace bgsim
