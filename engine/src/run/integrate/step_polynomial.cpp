#include "run/integrate/step_polynomial.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

namespace bgsim {

namespace {

constexpr std::size_t kMost = StepPolynomial::kHighestDegree + 1;
using Coefficients = std::array<double, kMost>;

/// Where a polynomial of a degree is sampled on [0, 1] (Chebyshev points with both ends, so that rounding is not
/// magnified), and what makes Bernstein coefficients of the samples.
struct Conversion {
  std::vector<double> points;
  std::vector<double> matrix;  ///< by rows

  explicit Conversion(std::size_t degree) : points(degree + 1, 0.0) {
    const auto n = static_cast<Eigen::Index>(degree);
    for (std::size_t k = 1; k <= degree; ++k)
      points[k] = 0.5 - 0.5 * std::cos(std::numbers::pi * static_cast<double>(k) /
                                       static_cast<double>(std::max<std::size_t>(degree, 1)));
    if (degree > 0) points[degree] = 1.0;
    Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic> bernstein(n + 1, n + 1);
    for (Eigen::Index k = 0; k <= n; ++k) {
      const long double s = points[static_cast<std::size_t>(k)];
      long double binomial = 1.0L;
      for (Eigen::Index j = 0; j <= n; ++j) {
        bernstein(k, j) =
            binomial * std::pow(s, static_cast<long double>(j)) * std::pow(1.0L - s, static_cast<long double>(n - j));
        binomial *= static_cast<long double>(n - j) / static_cast<long double>(j + 1);
      }
    }
    const Eigen::MatrixXd inverse = bernstein.inverse().cast<double>();
    for (Eigen::Index j = 0; j <= n; ++j)
      for (Eigen::Index k = 0; k <= n; ++k) matrix.push_back(inverse(j, k));
  }
};

/// Made when it is first asked for: a run needs two or three of them.
template <std::size_t Degree>
const Conversion& conversion_of() {
  static const Conversion conversion(Degree);
  return conversion;
}

const Conversion& conversion(std::size_t degree) {
  constexpr auto kAll = []<std::size_t... Degree>(std::index_sequence<Degree...>) {
    return std::array{&conversion_of<Degree>...};
  }
  (std::make_index_sequence<kMost>());
  return kAll[degree]();
}

/// Coefficients on [0, s] instead of [0, 1].
void keep_left(Coefficients& b, std::size_t degree, double s) {
  for (std::size_t level = 1; level <= degree; ++level)
    for (std::size_t j = degree; j >= level; --j) b[j] = (1.0 - s) * b[j - 1] + s * b[j];
}
/// Coefficients on [s, 1].
void keep_right(Coefficients& b, std::size_t degree, double s) {
  for (std::size_t level = 1; level <= degree; ++level)
    for (std::size_t j = 0; j + level <= degree; ++j) b[j] = (1.0 - s) * b[j] + s * b[j + 1];
}

}  // namespace

void StepPolynomial::take(double begin, double end, int degree, std::span<const std::uint32_t> unknowns,
                          std::size_t size, const std::function<void(double t, double* y)>& at) {
  begin_ = begin;
  end_ = end;
  degree_ = static_cast<std::size_t>(std::clamp(degree, 0, kHighestDegree));
  count_ = unknowns.size();
  const Conversion& c = conversion(degree_);
  const std::size_t points = degree_ + 1;
  y_.resize(size);
  samples_.resize(points * count_);
  coefficients_.resize(points * count_);
  for (std::size_t k = 0; k < points; ++k) {
    at(k + 1 == points ? end : begin + c.points[k] * (end - begin), y_.data());
    for (std::size_t i = 0; i < count_; ++i) samples_[i * points + k] = y_[unknowns[i]];
  }
  // Of the differences from the first sample: roundings of what stands still are none of its motion.
  for (std::size_t i = 0; i < count_; ++i) {
    const double* samples = samples_.data() + i * points;
    double* b = coefficients_.data() + i * points;
    b[0] = samples[0];
    Coefficients moved{};
    for (std::size_t k = 1; k < points; ++k) moved[k] = samples[k] - samples[0];
    for (std::size_t j = 1; j + 1 < points; ++j) {
      const double* row = c.matrix.data() + j * points;
      double sum = 0.0;
      for (std::size_t k = 1; k < points; ++k) sum += row[k] * moved[k];
      b[j] = samples[0] + sum;
    }
    b[points - 1] = samples[points - 1];
  }
}

Jet StepPolynomial::over(std::size_t which, double from, double to) const {
  constexpr double kRounding = 0x1p-49;
  const std::size_t points = degree_ + 1;
  Coefficients b;
  std::copy_n(coefficients_.begin() + static_cast<std::ptrdiff_t>(which * points), points, b.begin());
  const double length = end_ - begin_;
  const double s = (from - begin_) / length, e = (to - begin_) / length;
  if (e < 1.0) keep_left(b, degree_, e);
  if (s > 0.0) keep_right(b, degree_, s / e);
  Jet jet;
  const auto [low, high] = std::minmax_element(b.begin(), b.begin() + static_cast<std::ptrdiff_t>(points));
  const double room = *low == *high ? 0.0 : kRounding * std::max(std::fabs(*low), std::fabs(*high));
  jet.value = Range(*low - room, *high + room);
  double least = 0.0, most = 0.0;
  for (std::size_t j = 1; j < points; ++j) {
    const double slope = b[j] - b[j - 1];
    least = j == 1 ? slope : std::min(least, slope);
    most = j == 1 ? slope : std::max(most, slope);
  }
  const double scale = to > from ? static_cast<double>(degree_) / (to - from) : 0.0;
  jet.slope = Range(scale * least, scale * most);
  jet.curve = Range(0.0, 0.0);
  if (degree_ > 1 && to > from) {
    double low_bend = b[2] - 2.0 * b[1] + b[0], high_bend = low_bend;
    for (std::size_t j = 3; j < points; ++j) {
      const double bend = b[j] - 2.0 * b[j - 1] + b[j - 2];
      low_bend = std::min(low_bend, bend);
      high_bend = std::max(high_bend, bend);
    }
    const double squared = scale * (scale - 1.0 / (to - from)), bend_room = 4.0 * room;
    jet.curve = Range(squared * (low_bend - bend_room), squared * (high_bend + bend_room));
  }
  for (std::size_t level = degree_; level > 0; --level) {
    if (level == 1) jet.middle_slope = scale * (b[1] - b[0]);
    for (std::size_t j = 0; j < level; ++j) b[j] = 0.5 * (b[j] + b[j + 1]);
  }
  jet.middle = b[0];
  return jet;
}

void StepPolynomial::over(double from, double to, std::vector<Jet>& jets) const {
  jets.resize(count_);
  for (std::size_t i = 0; i < count_; ++i) jets[i] = over(i, from, to);
}

std::pair<double, double> StepPolynomial::at(std::size_t which, double t) const {
  const std::size_t points = degree_ + 1;
  Coefficients b;
  std::copy_n(coefficients_.begin() + static_cast<std::ptrdiff_t>(which * points), points, b.begin());
  const double length = end_ - begin_, s = (t - begin_) / length;
  double slope = 0.0;
  for (std::size_t level = degree_; level > 0; --level) {
    if (level == 1) slope = static_cast<double>(degree_) * (b[1] - b[0]) / length;
    for (std::size_t j = 0; j < level; ++j) b[j] = (1.0 - s) * b[j] + s * b[j + 1];
  }
  return {b[0], slope};
}

/// By differences of the coefficients, so that what stands still has no slope. The Bernstein polynomials at the time
/// are the same for all unknowns. @param degree  as a number or, where the compiler is to know it, as a constant
template <class Degree>
void StepPolynomial::at(Degree degree, double t, double* values, double* slopes) const {
  const double length = end_ - begin_, s = (t - begin_) / length;
  Coefficients lower{}, share{};  // of one degree less; sums of those from each on
  lower[0] = 1.0;
  for (std::size_t level = 1; level < degree; ++level) {
    for (std::size_t j = level; j > 0; --j) lower[j] = (1.0 - s) * lower[j] + s * lower[j - 1];
    lower[0] *= 1.0 - s;
  }
  const double scale = static_cast<double>(degree) / length;
  double rest = 0.0;
  for (std::size_t j = degree; j-- > 0;) {
    share[j] = rest + s * lower[j];  // B_{j+1} + ... + B_n of degree n
    rest += lower[j];
  }
  for (std::size_t j = 0; j < degree; ++j) lower[j] *= scale;
  for (std::size_t i = 0; i < count_; ++i) {
    const double* b = coefficients_.data() + i * (degree + 1);
    double value = b[0], slope = 0.0;
    for (std::size_t j = 0; j < degree; ++j) {
      const double moved = b[j + 1] - b[j];
      value += share[j] * moved;
      slope += lower[j] * moved;
    }
    values[i] = value;
    slopes[i] = slope;
  }
}

void StepPolynomial::at(double t, double* values, double* slopes) const {
  constexpr std::size_t kRadau = 4;
  if (degree_ == kRadau)
    at(std::integral_constant<std::size_t, kRadau>(), t, values, slopes);
  else
    at(degree_, t, values, slopes);
}

}  // namespace bgsim
