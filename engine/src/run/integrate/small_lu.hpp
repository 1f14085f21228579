/// LU of matrices of up to eight rows, written out by the compiler.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace bgsim::small {

/// Arithmetic on pairs: std::complex looks for NaN in each product.
struct Pair {
  double re = 0.0, im = 0.0;
  friend Pair operator*(Pair a, Pair b) { return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
  friend Pair operator-(Pair a, Pair b) { return {a.re - b.re, a.im - b.im}; }
};
inline double magnitude(double a) { return std::fabs(a); }
inline double magnitude(Pair a) { return std::fabs(a.re) + std::fabs(a.im); }
inline double inverse(double a) { return 1.0 / a; }
inline Pair inverse(Pair a) {
  // Smith's division: no square overflows.
  if (std::fabs(a.re) >= std::fabs(a.im)) {
    const double ratio = a.im / a.re, size = a.re + a.im * ratio;
    return {1.0 / size, -ratio / size};
  }
  const double ratio = a.re / a.im, size = a.re * ratio + a.im;
  return {ratio / size, -1.0 / size};
}

/// LU with partial pivoting of a matrix of a size known to the compiler, by rows. Reciprocals of the pivots are kept.
/// factor() is given what rows are compared by (row_scales.hpp).
template <class Number, std::size_t N>
struct SmallLu {
  std::array<Number, N * N> a{};
  std::array<std::size_t, N> pivot{};

  bool factor(std::array<double, N> scale) {
    for (std::size_t k = 0; k < N; ++k) {
      std::size_t best = k;
      for (std::size_t i = k + 1; i < N; ++i)
        if (magnitude(a[i * N + k]) * scale[i] > magnitude(a[best * N + k]) * scale[best]) best = i;
      pivot[k] = best;
      if (best != k) {
        for (std::size_t j = 0; j < N; ++j) std::swap(a[k * N + j], a[best * N + j]);
        std::swap(scale[k], scale[best]);
      }
      const double size = magnitude(a[k * N + k]);
      if (!(size > 0.0) || !std::isfinite(size)) return false;
      const Number reciprocal = inverse(a[k * N + k]);
      a[k * N + k] = reciprocal;
      for (std::size_t i = k + 1; i < N; ++i) {
        const Number factor = a[i * N + k] * reciprocal;
        a[i * N + k] = factor;
        for (std::size_t j = k + 1; j < N; ++j) a[i * N + j] = a[i * N + j] - factor * a[k * N + j];
      }
    }
    return true;
  }

  void solve(std::array<Number, N>& b) const {
    for (std::size_t k = 0; k < N; ++k)
      if (pivot[k] != k) std::swap(b[k], b[pivot[k]]);
    for (std::size_t k = 0; k < N; ++k)
      for (std::size_t i = k + 1; i < N; ++i) b[i] = b[i] - a[i * N + k] * b[k];
    for (std::size_t k = N; k-- > 0;) {
      for (std::size_t j = k + 1; j < N; ++j) b[k] = b[k] - a[k * N + j] * b[j];
      b[k] = b[k] * a[k * N + k];
    }
  }
};

template <class Number>
struct SmallLu<Number, 1> {
  std::array<Number, 1> a{};

  bool factor(std::array<double, 1> /*scale*/) {
    const double size = magnitude(a[0]);
    a[0] = inverse(a[0]);
    return size > 0.0 && std::isfinite(size);
  }
  void solve(std::array<Number, 1>& b) const { b[0] = b[0] * a[0]; }
};

}  // namespace bgsim::small
