#include "run/sink/output_measures.hpp"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

namespace bgsim {

namespace {

/// What an enclosure may be wider than the values are, of which a sum or a product takes one state twice.
constexpr double kWider = 4.0;

}  // namespace

OutputMeasures::OutputMeasures(const Program& program, std::span<const double> parameters, Evaluator& evaluator,
                               bool wanted)
    : evaluator_(evaluator),
      measuring_(wanted && !program.output_names.empty()),
      x_(program.state_names.size() + program.tear_names.size()),
      row_(program.output_names.size()),
      hidden_(program.output_names.size(), false),
      found_(program.output_names.size(), 0.0),
      measures_(measuring_ ? program.output_names.size() : 0),
      integral_(measures_.size()),
      square_(measures_.size()),
      size_(measures_.size()),
      left_(measures_.size()),
      peaks_(measures_.size()) {
  if (measuring_) bounds_.emplace(program, parameters);
  if (bounds_ && !bounds_->any()) bounds_.reset();
}

bool OutputMeasures::evaluate(double t, const double* x, std::vector<double>& row) {
  if (measuring_ && evaluator_.outputs(t, x, branch_, row.data())) return true;
  if (std::exchange(measuring_, false)) why_not_ = evaluator_.fault().what + " (" + evaluator_.fault().target + ")";
  return false;
}

void OutputMeasures::begin(double t, const double* x, const Branch& branch, double stop, double relative) {
  constexpr double kPieces = 64.0;
  constexpr int kHalvings = 20'000;  // some 0.1 s
  spare_ = kHalvings;
  relative_ = relative;
  span_ = stop - t;
  measured_ = t;
  longest_ = (stop - t) / kPieces;
  branch_ = branch;
  if (!evaluate(t, x, row_)) return;
  for (std::size_t i = 0; i < measures_.size(); ++i) {
    measures_[i].initial = measures_[i].least = measures_[i].most = row_[i];
    measures_[i].least_at = measures_[i].most_at = t;
    peaks_[i] = {Peak{row_[i]}, Peak{-row_[i]}};
  }
}

void OutputMeasures::add(double to, int order, const Branch& branch, const Solution& solution) {
  const double from = std::exchange(measured_, to);
  if (!measuring_ || !(to > from)) return;
  branch_ = branch;
  if (bounds_ && modes_ != branch.modes) {
    modes_ = branch.modes;
    bounds_->set_modes(modes_);
  }
  // Where the solution is a straight line a step may be most of the run, but outputs need not be polynomials of it.
  const double pieces = longest_ > 0.0 ? std::max(1.0, std::ceil((to - from) / longest_)) : 1.0;
  const double length = (to - from) / pieces;
  double begin = from;
  for (double piece = 1.0; piece <= pieces && measuring_; ++piece) {
    const double end = piece < pieces ? from + length * piece : to;
    if (!measure(piece_, begin, end, order, solution)) return;
    constexpr int kHalvingsHere = 2000;  // so that rounding at one place does not use up all
    spare_here_ = std::min(kHalvingsHere, spare_);
    spare_ -= spare_here_;
    add_piece(piece_, order, 0, solution);
    spare_ += spare_here_;
    begin = end;
  }
}

void OutputMeasures::look(double t, const double* x, const Branch& branch) {
  if (!measuring_) return;
  branch_ = branch;
  if (!evaluate(t, x, row_)) return;
  for (std::size_t i = 0; i < measures_.size(); ++i) {
    take(i, t, row_[i]);
    if (!measures_[i].nonzero_at && row_[i] != 0.0) measures_[i].nonzero_at = t;
  }
}

bool OutputMeasures::measure(Piece& piece, double from, double to, int order, const Solution& solution) {
  // Beside the ends, where a step's extreme often is: the sign of the slope there.
  constexpr double kBeside = 1e-3;
  const GaussRule& rule = gauss_rule(std::clamp(order / 2 + 1, 1, kMostGaussPoints));
  const double length = to - from;
  piece.from = from;
  piece.to = to;
  std::vector<Sample>& samples = piece.samples;
  samples.resize(rule.position.size() + 4);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const bool inner = k >= 2 && k - 2 < rule.position.size();
    samples[k].t = inner                     ? from + length * rule.position[k - 2]
                   : k == 0                  ? from
                   : k == 1                  ? from + kBeside * length
                   : k + 1 == samples.size() ? to
                                             : to - kBeside * length;
    samples[k].row.resize(row_.size());
    solution(samples[k].t, x_.data(), branch_);
    if (!evaluate(samples[k].t, x_.data(), samples[k].row)) return false;
    if (bounds_) {
      piece.states.resize(samples.size());
      bounds_->keep(x_, piece.states[k]);
    }
  }
  piece.integral.assign(measures_.size(), 0.0);
  piece.square.assign(measures_.size(), 0.0);
  piece.size.assign(measures_.size(), 0.0);
  for (std::size_t i = 0; i < measures_.size(); ++i)
    for (std::size_t k = 0; k < rule.weight.size(); ++k) {
      const double value = samples[k + 2].row[i];
      piece.integral[i] += length * rule.weight[k] * value;
      piece.square[i] += length * rule.weight[k] * value * value;
      piece.size[i] += length * rule.weight[k] * std::abs(value);
    }
  return true;
}

double OutputMeasures::largest(std::size_t output) const {
  return std::max({std::abs(measures_[output].least), std::abs(measures_[output].most), found_[output]});
}

double OutputMeasures::off_at_ends(const std::array<Piece, 2>& halves, std::size_t output, const GaussRule& rule) {
  const std::size_t points = rule.position.size();
  double begin = 0.0, end = 0.0;
  for (std::size_t half = 0; half < 2; ++half)
    for (std::size_t k = 0; k < points; ++k) {
      const double weight = rule.at_begin[half * points + k];
      begin += weight * halves[half].samples[k + 2].row[output];
      end += weight * halves[1 - half].samples[points + 1 - k].row[output];
    }
  return std::max(std::abs(begin - halves[0].samples.front().row[output]),
                  std::abs(end - halves[1].samples.back().row[output]));
}

bool OutputMeasures::differ(const Piece& whole, const std::array<Piece, 2>& halves) const {
  constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
  // Where a narrow pulse begins it is small, and as noisy as where it is not: rounding of a state over the width.
  constexpr double kBesidePulse = 1e-3;
  const double length = whole.to - whole.from, share = span_ > 0.0 ? length / span_ : 0.0;
  const GaussRule& rule = gauss_rule(static_cast<int>(halves[0].samples.size()) - 4);
  const double unseen = length * rule.position.front() / 2.0;  // before the first point of the halves
  for (std::size_t i = 0; i < measures_.size(); ++i) {
    const double largest = this->largest(i);
    // Of the piece, or of its share in what came before: tails of a pulse need no digits of their own.
    const auto apart = [&](double one, double two, double size, double before, double most, double pulse) {
      const double least = kRounding * most + kBesidePulse * relative_ * pulse;
      return std::abs(one - two) > relative_ * std::max(size, before * share) + least * length;
    };
    const double size = halves[0].size[i] + halves[1].size[i], square = halves[0].square[i] + halves[1].square[i];
    const double off = unseen * off_at_ends(halves, i, rule);
    const double found = found_[i];
    if (apart(whole.integral[i], halves[0].integral[i] + halves[1].integral[i], size, size_[i].value(), largest,
              found) ||
        apart(whole.square[i], square, square, square_[i].value(), largest * largest, found * found) ||
        apart(off, 0.0, size, size_[i].value(), largest, found) ||
        apart(2.0 * largest * off, 0.0, square, square_[i].value(), largest * largest, found * found))
      return true;
  }
  return false;
}

/// What holds the values of the bounds' outputs over pieces that follow each other. False: their points show these.
bool OutputMeasures::enclose(std::span<const Piece> pieces) {
  times_.clear();
  states_.clear();
  for (const Piece& piece : pieces)
    for (std::size_t k = 0; k < piece.samples.size(); ++k) {
      if (!times_.empty() && !(piece.samples[k].t > times_.back())) continue;
      times_.push_back(piece.samples[k].t);
      states_.push_back(piece.states[k]);
    }
  return bounds_->enclose(pieces.front().from, pieces.back().to, times_, states_);
}

/// The largest magnitude found where the bounds leave most room, until the points show as much as is left.
double OutputMeasures::found_in(double from, double to, std::size_t which, const Solution& solution) {
  constexpr int kParts = 400, kOnePoint = 0;
  const std::size_t output = bounds_->outputs()[which];
  struct Part {
    double room, from, to;
    bool operator<(const Part& other) const { return room < other.room; }
  };
  std::priority_queue<Part> parts;
  parts.push({std::numeric_limits<double>::infinity(), from, to});
  double found = 0.0;
  for (int k = 0; k < kParts && !parts.empty() && parts.top().room > kWider * found; ++k) {
    const Part part = parts.top();
    parts.pop();
    const double middle = part.from + 0.5 * (part.to - part.from);
    if (!(middle > part.from && middle < part.to)) continue;
    for (const bool second : {false, true}) {
      const double begin = second ? middle : part.from, end = second ? part.to : middle;
      if (!measure(probe_, begin, end, kOnePoint, solution)) return found;
      for (const Sample& sample : probe_.samples) found = std::max(found, std::abs(sample.row[output]));
      enclose({&probe_, 1});
      const Range all = bounds_->of(which);
      parts.push({std::max(std::abs(all.lower()), std::abs(all.upper())), begin, end});
    }
  }
  return found;
}

bool OutputMeasures::hide(const std::array<Piece, 2>& halves, bool whole, const Solution& solution) {
  if (!bounds_) return false;
  if (whole) std::fill(found_.begin(), found_.end(), 0.0);
  if (!enclose(halves)) return false;
  std::vector<std::size_t> open;
  const auto look = [&] {
    open.clear();
    for (std::size_t k = 0; k < bounds_->outputs().size(); ++k) {
      const std::size_t output = bounds_->outputs()[k];
      double least = std::numeric_limits<double>::infinity(), most = -least;
      for (const Piece& half : halves)
        for (const Sample& sample : half.samples) {
          least = std::min(least, sample.row[output]);
          most = std::max(most, sample.row[output]);
        }
      const Range all = bounds_->of(k);
      const double more = std::max(least - all.lower(), all.upper() - most);
      if (std::isfinite(more) && more > kWider * (most - least) + relative_ * largest(output)) open.push_back(k);
    }
    return !open.empty();
  };
  if (!look()) return false;
  if (whole) {
    // What a pulse comes to is looked for first: its tails need no digits of their own.
    for (const std::size_t k : open)
      found_[bounds_->outputs()[k]] = found_in(halves[0].from, halves[1].to, k, solution);
    enclose(halves);
    if (!look()) return false;
  }
  if (spare_here_ == 0)
    for (const std::size_t k : open) hidden_[bounds_->outputs()[k]] = true;
  return true;
}

void OutputMeasures::add_piece(const Piece& piece, int order, std::size_t depth, const Solution& solution) {
  constexpr int kFine =
      2 * (kMostGaussPoints - 1);      // the most points: what varies faster than the steps is no such polynomial
  constexpr double kShortest = 1e-12;  // of the run: what is left there adds no digit
  const double middle = piece.from + 0.5 * (piece.to - piece.from);
  if (middle > piece.from && middle < piece.to && piece.to - piece.from > kShortest * span_) {
    if (depth == halves_.size()) halves_.emplace_back();
    std::array<Piece, 2>& halves = halves_[depth];
    if (!measure(halves[0], piece.from, middle, order, solution) ||
        !measure(halves[1], middle, piece.to, order, solution))
      return;
    const bool hides = hide(halves, depth == 0, solution);  // first: it finds what differences matter beside
    if (hides || differ(piece, halves)) {
      if (spare_here_ > 0) {
        --spare_here_;
        for (const Piece& half : halves)
          if (measuring_) add_piece(half, kFine, depth + 1, solution);
        return;
      }
      for (std::size_t i = 0; i < measures_.size(); ++i)
        left_[i].add(std::abs(piece.integral[i] - halves[0].integral[i] - halves[1].integral[i]));
    }
  }
  for (std::size_t i = 0; i < measures_.size(); ++i) {
    integral_[i].add(piece.integral[i]);
    square_[i].add(piece.square[i]);
    size_[i].add(piece.size[i]);
    // The first of the piece: conditions do not change within it.
    if (!measures_[i].nonzero_at && piece.samples[2].row[i] != 0.0) measures_[i].nonzero_at = piece.from;
    extremes_.clear();
    look_for_extreme(piece.samples, i, 1.0, solution);
    look_for_extreme(piece.samples, i, -1.0, solution);
    // In the order of time: what is lower before a peak is no valley behind it, after which comes another one.
    std::sort(extremes_.begin(), extremes_.end());
    for (const auto& [t, value] : extremes_) take(i, t, value);
  }
}

/// The piece's largest value of sign * output, if it may be the largest so far: to extremes_.
void OutputMeasures::look_for_extreme(const std::vector<Sample>& samples, std::size_t output, double sign,
                                      const Solution& solution) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (sign * samples[k].row[output] > sign * samples[best].row[output]) best = k;
    least = std::min(least, sign * samples[k].row[output]);
  }
  const OutputMeasure& known = measures_[output];
  const double value = sign * samples[best].row[output];
  const double so_far = std::max(value, sign * (sign > 0.0 ? known.most : known.least));
  extremes_.emplace_back(samples[best].t, samples[best].row[output]);
  // What lies between the samples exceeds them by less than they differ.
  const bool inner = best > 0 && best + 1 < samples.size();
  if (!inner || !(value > least) || value + (value - least) <= so_far) return;
  std::vector<double> row(row_.size());
  // By the part of the way: the search knows its argument to some 1e-9 and no better, which may be more than all times.
  const double from = samples[best - 1].t, length = samples[best + 1].t - from;
  const auto lower = [&](double part) {
    const double t = from + part * length;
    solution(t, x_.data(), branch_);
    return evaluate(t, x_.data(), row) ? -sign * row[output] : std::numeric_limits<double>::infinity();
  };
  constexpr int kHalfTheDigits = std::numeric_limits<double>::digits / 2;  // a parabola is flat at its top
  std::uintmax_t most_evaluations = 40;
  const auto [part, negative] =
      boost::math::tools::brent_find_minima(lower, 0.0, 1.0, kHalfTheDigits, most_evaluations);
  if (measuring_) extremes_.emplace_back(from + part * length, -sign * negative);
}

void OutputMeasures::take(std::size_t output, double t, double value) {
  OutputMeasure& known = measures_[output];
  const double within = relative_ * (known.most - known.least);
  double least = -known.least;
  take(peaks_[output][0], value, t, within, known.most, known.most_at);
  take(peaks_[output][1], -value, t, within, least, known.least_at);
  known.least = -least;
}

void OutputMeasures::take(Peak& peak, double value, double t, double within, double& most, double& at) {
  if (value < peak.value - within) peak.left = true;
  if (!(value > most)) return;
  most = value;
  if (peak.left && value <= peak.value + within) return;
  peak = {value, false};
  at = t;
}

std::vector<OutputMeasure> OutputMeasures::finish(double t, const double* x, const Branch& branch) {
  branch_ = branch;
  if (!evaluate(t, x, row_)) return {};
  for (std::size_t i = 0; i < measures_.size(); ++i) {
    take(i, t, row_[i]);
    measures_[i].final = row_[i];
    measures_[i].integral = integral_[i].value();
    measures_[i].square = square_[i].value();
    if (hidden_[i] || left_[i].value() > relative_ * size_[i].value()) coarse_.push_back(i);
    if (!measures_[i].nonzero_at && row_[i] != 0.0) measures_[i].nonzero_at = t;
  }
  return std::move(measures_);
}

namespace {

/// The later of two extremes, if it is one beyond rounding; with it the time.
void take_later(double sign, double& value, double& at, double later, double later_at) {
  constexpr double kRoundings = 64.0 * std::numeric_limits<double>::epsilon();
  if (!(sign * later > sign * value)) return;
  if (std::abs(later - value) > kRoundings * std::abs(value)) at = later_at;
  value = later;
}

}  // namespace

void append(std::vector<OutputMeasure>& whole, const std::vector<OutputMeasure>& part) {
  if (whole.empty()) {
    whole = part;
    return;
  }
  for (std::size_t i = 0; i < part.size(); ++i) {
    OutputMeasure& sum = whole[i];
    const OutputMeasure& next = part[i];
    sum.final = next.final;
    take_later(-1.0, sum.least, sum.least_at, next.least, next.least_at);
    take_later(1.0, sum.most, sum.most_at, next.most, next.most_at);
    sum.integral += next.integral;
    sum.square += next.square;
    if (!sum.nonzero_at) sum.nonzero_at = next.nonzero_at;
  }
}

}  // namespace bgsim
