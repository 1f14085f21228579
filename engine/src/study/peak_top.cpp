#include "study/peak_top.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.hpp"
#include "bgsim/text.hpp"
#include "run/variation.hpp"

namespace bgsim {
namespace {

/// What rounding leaves of an instant is some hundred times less.
double closest(const RunInputs& inputs) {
  constexpr double kOfRun = 0x1p-32, kRoundings = 4096.0 * std::numeric_limits<double>::epsilon();
  return std::max(kOfRun * (inputs.stop - inputs.start),
                  kRoundings * std::max(std::abs(inputs.start), std::abs(inputs.stop)));
}

/// One side of a time, from there on outward: rows, and what the value and the slope come to at the time itself.
struct Side {
  std::vector<std::size_t> rows;
  double value = 0.0, slope = 0.0;
};

/// The rows of a peak, all values times its sign.
class Rows {
 public:
  Rows(std::vector<PeakRow> rows, double sign, double at) : rows_(std::move(rows)), at_(at) {
    for (PeakRow& row : rows_) {
      row.value *= sign;
      row.slope *= sign;
    }
    while (middle_ + 1 < rows_.size() && rows_[middle_].t < at) ++middle_;
  }

  [[nodiscard]] const PeakRow& operator[](std::size_t i) const { return rows_[i]; }
  [[nodiscard]] std::size_t middle() const { return middle_; }
  /// @param step  1: to later times
  [[nodiscard]] Side side(int step) const {
    Side side;
    for (std::size_t i = middle_; step > 0 ? i + 1 < rows_.size() : i > 0;) {
      i = step > 0 ? i + 1 : i - 1;
      side.rows.push_back(i);
    }
    if (side.rows.size() < 2) return side;
    const PeakRow &near = rows_[side.rows[0]], &far = rows_[side.rows[1]];
    const double share = (near.t - at_) / (far.t - near.t);
    side.slope = near.slope - share * (far.slope - near.slope);
    side.value = near.value - (near.t - at_) * side.slope;
    return side;
  }
  /// How fast the output falls from its value at the peak, on the mean over any of the times.
  [[nodiscard]] double steepest(const Side& side) const {
    double most = 0.0;
    for (const std::size_t row : side.rows)
      most = std::max(most, std::abs(side.value - rows_[row].value) / std::abs(rows_[row].t - at_));
    return most;
  }
  /// Where the slope is 0 between two neighbours.
  [[nodiscard]] PeakTop between(std::size_t one, std::size_t other) const {
    const std::size_t first = std::min(one, other);
    const PeakRow &a = rows_[first], &b = rows_[first + 1];
    const double share = a.slope == b.slope ? 0.0 : std::clamp(a.slope / (a.slope - b.slope), 0.0, 1.0);
    return {first, share, a.t + share * (b.t - a.t)};
  }
  [[nodiscard]] PeakTop at(std::size_t row) const { return {row, 0.0, rows_[row].t}; }

 private:
  std::vector<PeakRow> rows_;
  double at_;
  std::size_t middle_ = 0;
};

/// Follows the slope upward, from the row @p from along @p way, to where it turns.
PeakTop climb(const Rows& rows, std::size_t from, const std::vector<std::size_t>& way, int step) {
  std::size_t before = from;
  for (const std::size_t row : way) {
    if (step * rows[row].slope <= 0.0) return rows.between(before, row);
    before = row;
  }
  return rows.at(from);
}

}  // namespace

std::vector<double> times_around(double t, const RunInputs& inputs) {
  std::vector<double> times{t};
  const double least = closest(inputs);
  for (double by = 0.5 * (inputs.stop - inputs.start); by >= least; by *= 0.5)
    for (const double at : {t - by, t + by})
      if (at >= inputs.start && at <= inputs.stop) times.push_back(at);
  for (const double end : {inputs.start, inputs.stop}) times.push_back(end);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

PeakTop top_of(const Model& model, const RunInputs& inputs, const std::string& name, const Peak& peak,
               const std::vector<double>& instants, const std::function<std::vector<PeakRow>(double)>& rows_at) {
  const double sign = peak.value < 0.0 ? -1.0 : 1.0, top = sign * peak.value, near = 0.5 * closest(inputs);
  const double tolerance = 10.0 * inputs.relative;
  const double known = tolerance * peak.range + 64.0 * std::numeric_limits<double>::epsilon() * top;
  const auto instant_within = [&](double from, double to) {
    return std::find_if(instants.begin(), instants.end(), [&](double t) { return t > from && t < to; });
  };
  double time = peak.time;
  if (is_end(time, inputs.start, inputs.stop)) time = inputs.stop;
  constexpr int kTimes = 3;
  for (int k = 0;; ++k) {
    const Rows rows(rows_at(time), sign, time);
    const std::size_t middle = rows.middle();
    const Side left = rows.side(-1), right = rows.side(1);
    const bool at_instant = instant_within(time - near, time + near) != instants.end();
    const auto refuse = [&](const std::string& why) {
      refuse_sensitivity(model,
                         "the peak of " + in_quotes(name) + " at t = " + number_text(time, 6) + " is a corner: " + why,
                         "a peak changes with a parameter as the output does where it is flat",
                         "ask for --norm final, with --stop at the corner");
    };
    const auto jumps = [&](double from, double to) {
      refuse("it jumps there, from " + number_text(sign * from, 6) + " to " + number_text(sign * to, 6));
    };
    const bool at_end = time <= inputs.start || time >= inputs.stop;
    if (at_end && std::abs(rows[middle].value - top) > known) jumps(top, rows[middle].value);
    if (!at_instant || at_end) {
      const double slope = rows[middle].slope;
      if (slope == 0.0) return rows.at(middle);
      const PeakTop found = slope > 0.0 ? climb(rows, middle, right.rows, 1) : climb(rows, middle, left.rows, -1);
      const std::size_t next = found.share > 0.0 ? found.row + 1 : found.row;
      // Where an event parts the two, the slope may jump there.
      const auto instant = instant_within(rows[found.row].t, rows[next].t);
      if (instant == instants.end() || k == kTimes) return found;
      time = *instant;
      continue;
    }
    // On a side that the peak is reached on, the output is flat there, or its top is further away.
    const auto reaches = [&](const Side& side) { return side.rows.size() >= 2 && std::abs(side.value - top) <= known; };
    double flat = 0.0;
    for (const Side* side : {&left, &right})
      if (reaches(*side)) flat = std::max(flat, tolerance * rows.steepest(*side));
    if (reaches(right) && right.slope >= -flat)
      return right.slope > flat ? climb(rows, middle, right.rows, 1) : rows.at(middle);
    if (reaches(left) && left.slope <= flat) {
      const std::vector<std::size_t> further(left.rows.begin() + 1, left.rows.end());
      return left.slope < -flat ? climb(rows, left.rows.front(), further, -1) : rows.at(left.rows.front());
    }
    if (!reaches(left) || !reaches(right)) jumps(left.value, right.value);
    refuse("its slope is " + number_text(sign * left.slope, 3) + " before it and " +
           number_text(sign * right.slope, 3) + " behind it");
  }
}

}  // namespace bgsim
