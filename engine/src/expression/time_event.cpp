#include "expression/time_event.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bgsim {

namespace {

constexpr std::size_t kBlock = 4096;           ///< trials between looks at the progress
constexpr double kCrawl = 1.0 / 16384.0;       ///< of the best progress so far: slower than this is a contact
constexpr std::size_t kMostWork = 20'000'000;  ///< operations of one search
constexpr std::size_t kFewestTrials = 10'000;  ///< of one search, however long the relation is
constexpr double kNoticed = 1e-6;  ///< part of the stretch searched: more than this left undecided is no contact
constexpr double kAround = 16.0;   ///< neighbouring doubles: about what rounding moves a border by
double next_double(double t) { return std::nextafter(t, std::numeric_limits<double>::infinity()); }
bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// A stretch of time on which the relation has one value.
struct Stretch {
  double begin, end, value;
};

/// The last time with @p value between @p with, which has it, and @p without: adjacent to one without it. By regula
/// falsi where what is compared or rounded is nearly a line, then by bisection. @p with where @p without has it, too.
double last_with(TimeRelation& relation, double value, double with, double without) {
  constexpr int kMostRounds = 6;
  constexpr double kFaster = 64.0;  // a round that narrows it by less than six bisections do: a jump, or no line
  const auto at = [&](double t) {
    const auto there = relation.value_on(t, t);
    return there && same(*there, value);
  };
  if (at(without)) return with;
  const auto other = relation.value_on(without, without);
  const double whole = other && *other > value ? value + 1.0 : value;
  double ahead = relation.distance(whole);
  at(with);
  double behind = relation.distance(whole);
  const auto look = [&](double t) {
    if (!(t > with && t < without)) return;
    const bool holds = at(t);
    (holds ? with : without) = t;
    (holds ? behind : ahead) = relation.distance(whole);
  };
  for (int round = 0; round < kMostRounds && next_double(with) < without; ++round) {
    const double length = without - with, share = behind / (behind - ahead);
    if (!(share >= 0.0 && share <= 1.0)) break;
    const double guess = with + share * length, around = kAround * (next_double(guess) - guess);
    look(guess - around);
    look(guess + around);
    if ((without - with) * kFaster > length) break;
  }
  while (next_double(with) < without && std::isfinite(without - with)) look(with + 0.5 * (without - with));
  return with;
}

/// Goes from one decided stretch to the next, with steps that shrink where the relation is undecided and grow again
/// behind.
class Scanner {
 public:
  Scanner(TimeRelation& relation, double begin, double until, std::size_t most_trials)
      : relation_(relation),
        begin_(begin),
        at_(begin),
        until_(until),
        width_(next_double(begin) - begin),
        block_begin_(begin),
        most_trials_(most_trials) {}

  std::optional<Stretch> next() {
    bool shrunk = false;
    while (at_ < until_) {
      if (trials_ >= most_trials_) {
        if (!undecided_from_) undecided_from_ = at_;
        return std::nullopt;
      }
      watch_progress();
      const double begin = at_;
      const double end = std::min(std::max(begin + width_, next_double(begin)), until_);
      if (const auto value = relation_.value_on(begin, end)) {
        at_ = end;
        undecided_ = 0;
        value_ = value;
        if (!shrunk) width_ = std::min(8.0 * (end - begin), until_ - begin_);
        return Stretch{begin, end, *value};
      }
      if (!shrunk && value_ && guesses_ && undecided_ == 0 && least_ == 0.0) {
        // A guess costs less than ever shorter stretches, and one evaluation tells whether they would have come there.
        const double last = last_with(relation_, *value_, begin, end);
        const auto there = last > begin ? relation_.value_on(begin, last) : std::nullopt;
        if (there && same(*there, *value_)) {
          at_ = last;
          width_ = next_double(last) - last;
          return Stretch{begin, last, *value_};
        }
        guesses_ = last == begin;  // where ranges are wider than values, it would be in vain again and again
      }
      if (end == next_double(begin) || width_ <= least_) {
        at_ = end;
        undecided_length_ += end - begin;
        if (!undecided_from_ && undecided_length_ > kNoticed * (until_ - begin_)) undecided_from_ = begin;
        if (++undecided_ % kBlock == 0) least_ = 16.0 * (end - begin);
        width_ = std::max(end - begin, least_);
      } else {
        width_ = std::max((end - begin) / 8.0, least_);
        shrunk = true;
      }
    }
    return std::nullopt;
  }

  /// From where on the relation could not be decided, though it is no mere contact, or the search had to end.
  [[nodiscard]] std::optional<double> undecided_from() const { return undecided_from_; }

 private:
  /// Near a contact the decided stretches become shorter and shorter: allow undecided ones to be passed over.
  void watch_progress() {
    if (++trials_ % kBlock != 0) return;
    const double progress = at_ - block_begin_;
    block_begin_ = at_;
    best_progress_ = std::max(best_progress_, progress);
    if (progress < kCrawl * best_progress_)
      least_ = std::max(least_, 4.0 * progress / static_cast<double>(kBlock));
    else if (undecided_ == 0)
      least_ = 0.0;
  }

  TimeRelation& relation_;
  double begin_, at_, until_, width_;
  bool guesses_ = true;
  std::optional<double> value_;  ///< of the last decided stretch
  double least_ = 0.0;           ///< undecided stretches no longer than this are passed over
  std::size_t undecided_ = 0;    ///< in a row
  std::size_t trials_ = 0;
  double block_begin_, best_progress_ = 0.0;
  std::size_t most_trials_;
  double undecided_length_ = 0.0;
  std::optional<double> undecided_from_;
};

/// The first time with @p value between @p without, which has another one, and @p with: adjacent to one without it.
double first_with(TimeRelation& relation, double value, double without, double with) {
  while (next_double(without) < with) {
    const double middle = without + 0.5 * (with - without);
    const auto there = relation.value_on(middle, middle);
    (there && same(*there, value) ? with : without) = middle;
  }
  return with;
}

}  // namespace

/// The change next to @p guess, if that is the first one and goes to the next value: the relation is decided up to some
/// neighbouring doubles before it, and on as many behind it.
std::optional<double> RelationOfTime::change_at(double guess, double begin, double until, double first) {
  const double around = kAround * (next_double(guess) - guess), before = guess - around, behind = guess + around;
  if (!(begin < before && behind + around <= until)) return std::nullopt;
  const auto unchanged = values_.value_on(begin, before);
  if (!unchanged || !same(*unchanged, first)) return std::nullopt;
  const auto changed = values_.value_on(behind, behind + around);
  if (!changed || !(std::abs(*changed - first) == 1.0)) return std::nullopt;
  return first_with(values_, *changed, before, behind);
}

std::optional<double> RelationOfTime::next_change(double after, double until, TimeSearch* search,
                                                  std::optional<double> held) {
  if (!(next_double(after) <= until)) return std::nullopt;
  // Where rounding hides the side to which the relation goes, the search begins beyond.
  const auto right = held ? std::nullopt : limits_.at(after);
  const double begin = right ? std::max(next_double(after), after + right->hidden) : next_double(after);
  std::optional<double> first = held, change;
  if (right) first = right->value;
  if (search != nullptr && search->guess) {
    if (!first) first = values_.value_on(begin, next_double(begin));
    if (first) change = change_at(*search->guess, begin, until, *first);
    if (change) return change;
  }
  Scanner scanner(values_, begin, until, std::max(kFewestTrials, kMostWork / std::max<std::size_t>(1, values_.size())));
  double unchanged = held ? after : begin;
  while (const auto stretch = scanner.next()) {
    // What was undecided up to here has the value that it has at single times.
    if (!first && stretch->begin > begin) first = values_.value_on(begin, begin);
    if (first && !same(stretch->value, *first)) {
      change = first_with(values_, stretch->value, unchanged, stretch->begin);
      break;
    }
    first = stretch->value;
    unchanged = stretch->end;
  }
  if (search != nullptr) search->undecided = scanner.undecided_from();
  if (change || !first) return change;
  const auto last = values_.value_on(until, until);
  if (!last || same(*last, *first)) return std::nullopt;
  return first_with(values_, *last, unchanged, until);
}

double RelationOfTime::value_just_after(double after) {
  if (const auto right = limits_.at(after)) return right->value;
  const double begin = next_double(after);
  const auto first = Scanner(values_, begin, std::numeric_limits<double>::max(), kFewestTrials).next();
  if (first && !std::isnan(first->value)) return first->value;
  return values_.value_on(after, after).value_or(std::numeric_limits<double>::quiet_NaN());
}

std::optional<double> next_change(const ExprPool& pool, ExprId relation, SymbolId time,
                                  std::span<const double> symbol_values, double after, double until, TimeSearch* search,
                                  std::optional<double> held) {
  return RelationOfTime(pool, relation, time, symbol_values).next_change(after, until, search, held);
}

double value_just_after(const ExprPool& pool, ExprId relation, SymbolId time, std::span<const double> symbol_values,
                        double after) {
  return RelationOfTime(pool, relation, time, symbol_values).value_just_after(after);
}

}  // namespace bgsim
