/// LU of matrices of some tens of rows, real or complex, whose zeros cost nothing.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace bgsim {

/// By columns, real and imaginary parts apart, so that one column is subtracted from another by vector instructions.
template <bool Complex>
class ColumnLu {
 public:
  explicit ColumnLu(std::size_t n)
      : n_(n), re_(n * n), im_(Complex ? n * n : 0), scale_(n, 1.0), pivot_(n), first_(n), last_(n) {}

  /// Column by column; factor() overwrites them.
  [[nodiscard]] double* real() { return re_.data(); }
  [[nodiscard]] double* imaginary() { return im_.data(); }

  /// By partial pivoting; complex numbers by the sum of their parts' magnitudes. Columns that a row has nothing in are
  /// passed over, as is what lies below the last number of a column: matrices of lines cost the square of n.
  /// @param scale  by row, what pivots are compared by (row_scales.hpp); null: rows as they are
  /// @return  false if a pivot is zero or not finite.
  /// @note n^3/3 multiplications at most, four times that for complex matrices.
  bool factor(const double* scale = nullptr) {
    if (scale != nullptr) std::copy_n(scale, n_, scale_.begin());
    for (std::size_t k = 0; k < n_; ++k) {
      double* const re = re_.data() + k * n_;
      double* const im = Complex ? im_.data() + k * n_ : nullptr;
      std::size_t best = k, last = k;
      double most = size_of(k * n_ + k) * scale_[k];
      for (std::size_t i = k + 1; i < n_; ++i) {
        const double size = size_of(k * n_ + i) * scale_[i];
        if (size > most) {
          most = size;
          best = i;
        }
        if (size != 0.0) last = i;  // NaN too
      }
      if (!(most > 0.0) || !std::isfinite(most)) return false;
      pivot_[k] = best;
      if (best != k) swap_rows(k, best);
      last_[k] = last;
      scale_by_pivot(re, im, k, last);
      for (std::size_t j = k + 1; j < n_; ++j) {
        const double a = re_[j * n_ + k], b = Complex ? im_[j * n_ + k] : 0.0;
        if (a == 0.0 && b == 0.0) continue;
        subtract(re_.data() + j * n_, Complex ? im_.data() + j * n_ : nullptr, re, im, a, b, k + 1, last + 1);
      }
      first_[k] = k;
      for (std::size_t i = k; i-- > 0;)
        if (size_of(k * n_ + i) != 0.0) first_[k] = i;
    }
    return true;
  }

  /// The right side becomes the solution. @param y  imaginary parts, of complex matrices.
  void solve(double* x, double* y = nullptr) const {
    for (std::size_t k = 0; k < n_; ++k) {
      if (pivot_[k] != k) {
        std::swap(x[k], x[pivot_[k]]);
        if constexpr (Complex) std::swap(y[k], y[pivot_[k]]);
      }
      subtract_column(x, y, k, k + 1, last_[k] + 1);
    }
    for (std::size_t k = n_; k-- > 0;) {
      const double a = re_[k * n_ + k];
      if constexpr (Complex) {
        const double b = im_[k * n_ + k], p = x[k];
        x[k] = p * a - y[k] * b;
        y[k] = p * b + y[k] * a;
      } else {
        x[k] *= a;
      }
      subtract_column(x, y, k, first_[k], k);
    }
  }

 private:
  [[nodiscard]] double size_of(std::size_t at) const {
    if constexpr (Complex) return std::fabs(re_[at]) + std::fabs(im_[at]);
    return std::fabs(re_[at]);
  }

  /// Of what is left: columns that are done keep their order, and solve() swaps between them.
  void swap_rows(std::size_t k, std::size_t other) {
    std::swap(scale_[k], scale_[other]);
    for (std::size_t j = k; j < n_; ++j) {
      std::swap(re_[j * n_ + k], re_[j * n_ + other]);
      if constexpr (Complex) std::swap(im_[j * n_ + k], im_[j * n_ + other]);
    }
  }

  /// Divides what is below the diagonal by the pivot, and leaves its reciprocal there.
  static void scale_by_pivot(double* __restrict re, double* __restrict im, std::size_t k, std::size_t last) {
    if constexpr (Complex) {
      // Smith's division: no square overflows.
      double a = 0.0, b = 0.0;
      if (std::fabs(re[k]) >= std::fabs(im[k])) {
        const double ratio = im[k] / re[k], size = re[k] + im[k] * ratio;
        a = 1.0 / size;
        b = -ratio / size;
      } else {
        const double ratio = re[k] / im[k], size = re[k] * ratio + im[k];
        a = ratio / size;
        b = -1.0 / size;
      }
      re[k] = a;
      im[k] = b;
      for (std::size_t i = k + 1; i <= last; ++i) {
        const double p = re[i];
        re[i] = p * a - im[i] * b;
        im[i] = p * b + im[i] * a;
      }
    } else {
      const double a = re[k] = 1.0 / re[k];
      for (std::size_t i = k + 1; i <= last; ++i) re[i] *= a;
    }
  }

  /// out -= (a + ib) column, from row @p from to below @p to.
  static void subtract(double* __restrict out_re, double* __restrict out_im, const double* __restrict re,
                       const double* __restrict im, double a, double b, std::size_t from, std::size_t to) {
    if constexpr (Complex) {
      for (std::size_t i = from; i < to; ++i) {
        out_re[i] -= a * re[i] - b * im[i];
        out_im[i] -= a * im[i] + b * re[i];
      }
    } else {
      for (std::size_t i = from; i < to; ++i) out_re[i] -= a * re[i];
    }
  }

  void subtract_column(double* x, double* y, std::size_t k, std::size_t from, std::size_t to) const {
    const double a = x[k], b = Complex ? y[k] : 0.0;
    if (a == 0.0 && b == 0.0) return;
    subtract(x, y, re_.data() + k * n_, Complex ? im_.data() + k * n_ : nullptr, a, b, from, to);
  }

  std::size_t n_;
  std::vector<double> re_, im_;
  std::vector<double> scale_;  ///< by row as they are swapped
  std::vector<std::size_t> pivot_;
  std::vector<std::size_t> first_, last_;  ///< by column: the rows between which it has numbers
};

}  // namespace bgsim
