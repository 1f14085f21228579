#include "run/sink/output_measures.hpp"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "run/sink/gauss_rule.hpp"

namespace bgsim {

OutputMeasures::OutputMeasures(const Program& program, Evaluator& evaluator, bool wanted)
    : evaluator_(evaluator),
      measuring_(wanted && !program.output_names.empty()),
      x_(program.state_names.size() + program.tear_names.size()),
      row_(program.output_names.size()),
      measures_(measuring_ ? program.output_names.size() : 0),
      integral_(measures_.size()),
      square_(measures_.size()) {}

bool OutputMeasures::evaluate(double t, const double* x, std::vector<double>& row) {
  if (measuring_ && evaluator_.outputs(t, x, branch_, row.data())) return true;
  if (std::exchange(measuring_, false)) why_not_ = evaluator_.fault().what + " (" + evaluator_.fault().target + ")";
  return false;
}

void OutputMeasures::begin(double t, const double* x, const Branch& branch, double stop) {
  constexpr double kPieces = 64.0;
  measured_ = t;
  longest_ = (stop - t) / kPieces;
  branch_ = branch;
  if (!evaluate(t, x, row_)) return;
  for (std::size_t i = 0; i < measures_.size(); ++i) {
    measures_[i].initial = measures_[i].least = measures_[i].most = row_[i];
    measures_[i].least_at = measures_[i].most_at = t;
  }
}

void OutputMeasures::add(double to, int order, const Branch& branch, const Solution& solution) {
  const double from = std::exchange(measured_, to);
  if (!measuring_ || !(to > from)) return;
  branch_ = branch;
  // Where the solution is a straight line a step may be most of the run, but outputs need not be polynomials of it.
  const double pieces = longest_ > 0.0 ? std::max(1.0, std::ceil((to - from) / longest_)) : 1.0;
  const double length = (to - from) / pieces;
  double begin = from;
  for (double piece = 1.0; piece <= pieces && measuring_; ++piece) {
    const double end = piece < pieces ? from + length * piece : to;
    add_piece(begin, end, order, solution);
    begin = end;
  }
}

void OutputMeasures::add_piece(double from, double to, int order, const Solution& solution) {
  // Beside the ends, where a step's extreme often is: the sign of the slope there.
  constexpr double kBeside = 1e-3;
  const GaussRule& rule = gauss_rule(std::clamp(order / 2 + 1, 1, kMostGaussPoints));
  const double length = to - from;
  samples_.resize(rule.position.size() + 4);
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    const bool inner = k >= 2 && k - 2 < rule.position.size();
    samples_[k].t = inner                      ? from + length * rule.position[k - 2]
                    : k == 0                   ? from
                    : k == 1                   ? from + kBeside * length
                    : k + 1 == samples_.size() ? to
                                               : to - kBeside * length;
    samples_[k].row.resize(row_.size());
    solution(samples_[k].t, x_.data(), branch_);
    if (!evaluate(samples_[k].t, x_.data(), samples_[k].row)) return;
  }
  for (std::size_t i = 0; i < measures_.size(); ++i) {
    double integral = 0.0, square = 0.0;
    for (std::size_t k = 0; k < rule.weight.size(); ++k) {
      const double value = samples_[k + 2].row[i];
      integral += length * rule.weight[k] * value;
      square += length * rule.weight[k] * value * value;
    }
    integral_[i].add(integral);
    square_[i].add(square);
    // The first of the piece: conditions do not change within it.
    if (!measures_[i].nonzero_at && samples_[2].row[i] != 0.0) measures_[i].nonzero_at = from;
    look_for_extreme(i, 1.0, solution);
    look_for_extreme(i, -1.0, solution);
  }
}

/// The piece's largest value of sign * output, if it may be the largest so far.
void OutputMeasures::look_for_extreme(std::size_t output, double sign, const Solution& solution) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    if (sign * samples_[k].row[output] > sign * samples_[best].row[output]) best = k;
    least = std::min(least, sign * samples_[k].row[output]);
  }
  const OutputMeasure& known = measures_[output];
  const double value = sign * samples_[best].row[output], so_far = sign * (sign > 0.0 ? known.most : known.least);
  take(output, samples_[best].t, samples_[best].row[output]);
  // What lies between the samples exceeds them by less than they differ.
  const bool inner = best > 0 && best + 1 < samples_.size();
  if (!inner || !(value > least) || value + (value - least) <= so_far) return;
  std::vector<double> row(row_.size());
  const auto lower = [&](double t) {
    solution(t, x_.data(), branch_);
    return evaluate(t, x_.data(), row) ? -sign * row[output] : std::numeric_limits<double>::infinity();
  };
  constexpr int kHalfTheDigits = std::numeric_limits<double>::digits / 2;  // a parabola is flat at its top
  std::uintmax_t most_evaluations = 40;
  const auto [t, negative] = boost::math::tools::brent_find_minima(lower, samples_[best - 1].t, samples_[best + 1].t,
                                                                   kHalfTheDigits, most_evaluations);
  if (measuring_) take(output, t, -sign * negative);
}

void OutputMeasures::take(std::size_t output, double t, double value) {
  OutputMeasure& known = measures_[output];
  if (value > known.most) {
    known.most = value;
    known.most_at = t;
  }
  if (value < known.least) {
    known.least = value;
    known.least_at = t;
  }
}

std::vector<OutputMeasure> OutputMeasures::finish(double t, const double* x, const Branch& branch) {
  branch_ = branch;
  if (!evaluate(t, x, row_)) return {};
  for (std::size_t i = 0; i < measures_.size(); ++i) {
    take(i, t, row_[i]);
    measures_[i].final = row_[i];
    measures_[i].integral = integral_[i].value();
    measures_[i].square = square_[i].value();
    if (!measures_[i].nonzero_at && row_[i] != 0.0) measures_[i].nonzero_at = t;
  }
  return std::move(measures_);
}

void append(std::vector<OutputMeasure>& whole, const std::vector<OutputMeasure>& part) {
  if (whole.empty()) {
    whole = part;
    return;
  }
  for (std::size_t i = 0; i < part.size(); ++i) {
    OutputMeasure& sum = whole[i];
    const OutputMeasure& next = part[i];
    sum.final = next.final;
    if (next.least < sum.least) std::tie(sum.least, sum.least_at) = std::pair(next.least, next.least_at);
    if (next.most > sum.most) std::tie(sum.most, sum.most_at) = std::pair(next.most, next.most_at);
    sum.integral += next.integral;
    sum.square += next.square;
    if (!sum.nonzero_at) sum.nonzero_at = next.nonzero_at;
  }
}

}  // namespace bgsim
