/// Numbers with a small parameter h: truncated Laurent series whose coefficients know how far rounding can have moved
/// them. They are an ordered field, in which h is positive and smaller than every number.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace bgsim {

/// sum of coefficient[k] h^(order + k), known below h^known. A coefficient within its own rounding counts as zero, and
/// the leading one is not zero, so that the sign is that of the leading coefficient. Plain arithmetic, no allocation.
struct PowerSeries {
  static constexpr int kTerms = 7;
  static constexpr int kExact = 1000;  ///< `known` of a number that is not truncated
  std::array<double, kTerms> coefficient{}, rounding{};
  int order = 0, known = kExact;
  bool zero = true;

  PowerSeries() = default;
  /// Coefficients of h^0, h^1, ...: all that is known, or all that there is.
  /// @param rounding  how far each can be off; the same number of them
  template <std::size_t N>
  static PowerSeries of(const std::array<double, N>& values, const std::array<double, N>& rounding, bool exact) {
    static_assert(N <= kTerms);
    PowerSeries s;
    for (std::size_t k = 0; k < N; ++k) {
      s.coefficient[k] = values[k];
      s.rounding[k] = rounding[k];
    }
    if (!exact) s.known = static_cast<int>(N);
    s.normalize();
    return s;
  }
  static PowerSeries number(double value) { return of<1>({value}, {0.0}, true); }
  /// Of which not even the size is known.
  static PowerSeries unknown() {
    PowerSeries s;
    s.known = -kExact;
    return s;
  }
  /// Times h^power.
  [[nodiscard]] PowerSeries times_power(int power) const {
    PowerSeries s = *this;
    if (!zero) s.order += power;
    if (known != kExact) s.known += power;
    return s;
  }
  /// Times 2^exponent, without rounding.
  [[nodiscard]] PowerSeries times_two_to(int exponent) const {
    PowerSeries s = *this;
    for (double& c : s.coefficient) c = std::ldexp(c, exponent);
    for (double& c : s.rounding) c = std::ldexp(c, exponent);
    return s;
  }
  /// The same, known below h^power at most.
  [[nodiscard]] PowerSeries known_below(int power) const {
    PowerSeries s = *this;
    s.known = std::min(known, power);
    s.normalize();
    return s;
  }

  [[nodiscard]] int sign() const { return zero ? 0 : coefficient[0] > 0.0 ? 1 : -1; }
  /// The coefficient of h^0 where nothing of lower order stands before it; else infinite.
  [[nodiscard]] double finite_part() const {
    if (zero || order > 0) return 0.0;
    if (order < 0) return std::copysign(HUGE_VAL, coefficient[0]);
    return coefficient[0];
  }

  friend PowerSeries operator-(PowerSeries a) {
    for (double& c : a.coefficient) c = -c;
    return a;
  }
  friend PowerSeries operator+(const PowerSeries& a, const PowerSeries& b) {
    PowerSeries s;
    s.known = std::min(a.known, b.known);
    if (a.zero && b.zero) return s;
    s.order = a.zero ? b.order : b.zero ? a.order : std::min(a.order, b.order);
    s.zero = false;
    s.known = std::min({s.known, a.cut(s.order), b.cut(s.order)});
    const int terms = s.terms();
    for (int k = 0; k < terms; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const auto [av, ar] = a.term(s.order + k);
      const auto [bv, br] = b.term(s.order + k);
      s.coefficient[at] = av + bv;
      s.rounding[at] = ar + br + kUnit * std::abs(av + bv);
    }
    s.normalize();
    return s;
  }
  friend PowerSeries operator-(const PowerSeries& a, const PowerSeries& b) { return a + (-b); }
  friend PowerSeries operator*(const PowerSeries& a, const PowerSeries& b) {
    PowerSeries s;
    s.known = product_known(a, b);
    if (a.zero || b.zero) return s;
    s.zero = false;
    s.order = a.order + b.order;
    if (a.last() + b.last() >= kTerms) s.known = std::min(s.known, s.order + kTerms);
    const auto terms = static_cast<std::size_t>(s.terms());
    for (std::size_t i = 0; i < terms; ++i) {
      if (a.coefficient[i] == 0.0 && a.rounding[i] == 0.0) continue;
      for (std::size_t j = 0; i + j < terms; ++j) {
        const double product = a.coefficient[i] * b.coefficient[j];
        s.coefficient[i + j] += product;
        s.rounding[i + j] += std::abs(a.coefficient[i]) * b.rounding[j] + a.rounding[i] * std::abs(b.coefficient[j]) +
                             2.0 * kUnit * std::abs(product);
      }
    }
    s.normalize();
    return s;
  }
  /// @pre b is not zero.
  friend PowerSeries operator/(const PowerSeries& a, const PowerSeries& b) { return a * b.inverse(); }

  struct Term {
    double value, rounding;
  };
  /// The coefficient of h^power.
  [[nodiscard]] Term term(int power) const {
    if (zero || power < order || power >= order + kTerms) return {0.0, 0.0};
    const auto at = static_cast<std::size_t>(power - order);
    return {coefficient[at], rounding[at]};
  }

  /// The derivative by h.
  friend PowerSeries slope_of(const PowerSeries& a) {
    PowerSeries s = a;
    for (int k = 0; k < kTerms; ++k) {
      s.coefficient[static_cast<std::size_t>(k)] *= a.order + k;
      s.rounding[static_cast<std::size_t>(k)] *= std::abs(a.order + k);
    }
    if (!s.zero) --s.order;
    if (s.known != kExact) --s.known;
    s.normalize();
    return s;
  }
  /// function(point + moves), where @p function has the coefficients at the point and @p moves no term of order 0.
  friend PowerSeries compose(const PowerSeries& function, const PowerSeries& moves) {
    const bool exact = function.known == kExact;
    int k = exact ? kTerms - 1 : std::min(function.known, kTerms) - 1;
    if (k < 0) return unknown();
    const auto coefficient = [&](int at) {
      const auto [value, rounding] = function.term(at);
      return of<1>({value}, {rounding}, true);
    };
    PowerSeries s = coefficient(k);
    const int beyond = k + 1;  // what is left out is of this power of the moves
    for (--k; k >= 0; --k) s = coefficient(k) + moves * s;
    const int first = moves.zero ? moves.known : moves.order;
    return exact || first == kExact ? s : s.known_below(first * beyond);
  }

 private:
  static constexpr double kUnit = 2.3e-16;

  /// How many terms from the leading one on are known.
  [[nodiscard]] int terms() const { return known == kExact ? kTerms : std::clamp(known - order, 0, kTerms); }

  /// The last term that is not zero.
  [[nodiscard]] int last() const {
    int k = kTerms - 1;
    while (k > 0 && coefficient[static_cast<std::size_t>(k)] == 0.0) --k;
    return k;
  }
  /// Up to which order the number is known where its terms from @p first on are kept.
  [[nodiscard]] int cut(int first) const { return !zero && order + last() >= first + kTerms ? first + kTerms : kExact; }

  /// a b is known up to where what is unknown of one meets the leading term of the other.
  static int product_known(const PowerSeries& a, const PowerSeries& b) {
    if ((a.zero && a.known == kExact) || (b.zero && b.known == kExact)) return kExact;
    const int first_a = a.zero ? a.known : a.order, first_b = b.zero ? b.known : b.order;
    const int left = a.known == kExact ? kExact : a.known + first_b;
    const int right = b.known == kExact ? kExact : b.known + first_a;
    return std::min(left, right);
  }

  [[nodiscard]] PowerSeries inverse() const {
    PowerSeries s;
    s.zero = false;
    s.order = -order;
    s.known = known == kExact ? kExact : known - 2 * order;
    if (last() > 0) s.known = std::min(s.known, s.order + kTerms);
    const double lead = coefficient[0];
    const auto terms = static_cast<std::size_t>(s.terms());
    for (std::size_t k = 0; k < terms; ++k) {
      double sum = k == 0 ? 1.0 : 0.0, off = 0.0;
      for (std::size_t j = 1; j <= k; ++j) {
        sum -= coefficient[j] * s.coefficient[k - j];
        off += std::abs(coefficient[j]) * s.rounding[k - j] + rounding[j] * std::abs(s.coefficient[k - j]) +
               2.0 * kUnit * std::abs(coefficient[j] * s.coefficient[k - j]);
      }
      s.coefficient[k] = sum / lead;
      s.rounding[k] =
          (off + rounding[0] * std::abs(s.coefficient[k])) / std::abs(lead) + kUnit * std::abs(s.coefficient[k]);
    }
    s.normalize();
    return s;
  }

  /// Takes zeros off the front, and what is not known off the end.
  void normalize() {
    zero = true;
    std::size_t first = kTerms;
    for (std::size_t k = 0; k < kTerms; ++k) {
      const bool is_known = known == kExact || order + static_cast<int>(k) < known;
      if (!is_known || std::abs(coefficient[k]) <= rounding[k]) coefficient[k] = 0.0;
      if (!is_known) rounding[k] = 0.0;
      if (coefficient[k] != 0.0 && first == kTerms) first = k;
    }
    if (first == kTerms) {
      coefficient = {};
      rounding = {};
      order = 0;
      return;
    }
    zero = false;
    order += static_cast<int>(first);
    for (std::size_t k = 0; k < kTerms; ++k) {
      const bool inside = k + first < kTerms;
      coefficient[k] = inside ? coefficient[k + first] : 0.0;
      rounding[k] = inside ? rounding[k + first] : 0.0;
    }
  }
};

}  // namespace bgsim
