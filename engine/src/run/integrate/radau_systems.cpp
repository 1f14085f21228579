#include "run/integrate/radau_systems.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

#include "base/lu.hpp"
#include "run/integrate/column_lu.hpp"
#include "run/integrate/integrator.hpp"

namespace bgsim {

namespace radau {
namespace {

/// Arithmetic on pairs: std::complex looks for NaN in each product.
struct Pair {
  double re = 0.0, im = 0.0;
  friend Pair operator*(Pair a, Pair b) { return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
  friend Pair operator-(Pair a, Pair b) { return {a.re - b.re, a.im - b.im}; }
};
double magnitude(double a) { return std::fabs(a); }
double magnitude(Pair a) { return std::fabs(a.re) + std::fabs(a.im); }
double inverse(double a) { return 1.0 / a; }
Pair inverse(Pair a) {
  // Smith's division: no square overflows.
  if (std::fabs(a.re) >= std::fabs(a.im)) {
    const double ratio = a.im / a.re, size = a.re + a.im * ratio;
    return {1.0 / size, -ratio / size};
  }
  const double ratio = a.re / a.im, size = a.re * ratio + a.im;
  return {ratio / size, -1.0 / size};
}

/// LU with partial pivoting of a matrix of a size known to the compiler, by rows. Reciprocals of the pivots are kept.
template <class Number, std::size_t N>
struct SmallLu {
  std::array<Number, N * N> a{};
  std::array<std::size_t, N> pivot{};

  bool factor() {
    for (std::size_t k = 0; k < N; ++k) {
      std::size_t best = k;
      for (std::size_t i = k + 1; i < N; ++i)
        if (magnitude(a[i * N + k]) > magnitude(a[best * N + k])) best = i;
      pivot[k] = best;
      if (best != k)
        for (std::size_t j = 0; j < N; ++j) std::swap(a[k * N + j], a[best * N + j]);
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

  bool factor() {
    const double size = magnitude(a[0]);
    a[0] = inverse(a[0]);
    return size > 0.0 && std::isfinite(size);
  }
  void solve(std::array<Number, 1>& b) const { b[0] = b[0] * a[0]; }
};

template <std::size_t N>
class SmallSystems final : public RadauSystems {
 public:
  explicit SmallSystems(const RadauEigenvalues& eigenvalues)
      : gamma_(eigenvalues.gamma), pairs_(eigenvalues.pairs), complex_(pairs_.size()) {}

  [[nodiscard]] bool dense() const override { return true; }

  bool factor(double h, const double* jacobian) override {
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j < N; ++j) real_.a[i * N + j] = -h * jacobian[j * N + i] + (i == j ? gamma_ : 0.0);
    if (!real_.factor()) return false;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const double alpha = pairs_[k].real(), beta = pairs_[k].imag();
      for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < N; ++j)
          complex_[k].a[i * N + j] = {-h * jacobian[j * N + i] + (i == j ? alpha : 0.0), i == j ? beta : 0.0};
      if (!complex_[k].factor()) return false;
    }
    return true;
  }

  void solve_real(double* u) override {
    std::array<double, N> b{};
    for (std::size_t i = 0; i < N; ++i) b[i] = u[i];
    real_.solve(b);
    for (std::size_t i = 0; i < N; ++i) u[i] = b[i];
  }

  void solve_complex(std::size_t pair, double* v, double* w) override {
    std::array<Pair, N> b{};
    for (std::size_t i = 0; i < N; ++i) b[i] = {v[i], w[i]};
    complex_[pair].solve(b);
    for (std::size_t i = 0; i < N; ++i) {
      v[i] = b[i].re;
      w[i] = b[i].im;
    }
  }

 private:
  double gamma_;
  std::vector<std::complex<double>> pairs_;
  SmallLu<double, N> real_;
  std::vector<SmallLu<Pair, N>> complex_;
};

class DenseSystems final : public RadauSystems {
 public:
  DenseSystems(std::size_t size, const RadauEigenvalues& eigenvalues)
      : n_(size),
        gamma_(eigenvalues.gamma),
        pairs_(eigenvalues.pairs),
        real_(size),
        complex_(pairs_.size(), ColumnLu<true>(size)) {}

  [[nodiscard]] bool dense() const override { return true; }

  bool factor(double h, const double* jacobian) override {
    double* const real = real_.real();
    for (std::size_t i = 0; i < n_ * n_; ++i) {
      real[i] = -h * jacobian[i];
      if (!std::isfinite(real[i])) return false;
    }
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      std::copy(real, real + n_ * n_, complex_[k].real());
      std::fill(complex_[k].imaginary(), complex_[k].imaginary() + n_ * n_, 0.0);
      for (std::size_t i = 0; i < n_ * n_; i += n_ + 1) {
        complex_[k].real()[i] += pairs_[k].real();
        complex_[k].imaginary()[i] = pairs_[k].imag();
      }
    }
    for (std::size_t i = 0; i < n_ * n_; i += n_ + 1) real[i] += gamma_;
    return real_.factor() && std::all_of(complex_.begin(), complex_.end(), [](auto& lu) { return lu.factor(); });
  }

  void solve_real(double* u) override { real_.solve(u); }
  void solve_complex(std::size_t pair, double* v, double* w) override { complex_[pair].solve(v, w); }

 private:
  std::size_t n_;
  double gamma_;
  std::vector<std::complex<double>> pairs_;
  ColumnLu<false> real_;
  std::vector<ColumnLu<true>> complex_;
};

class SparseSystems final : public RadauSystems {
 public:
  SparseSystems(const Sparsity& pattern, const RadauEigenvalues& eigenvalues)
      : pattern_(pattern),
        n_(static_cast<Eigen::Index>(pattern.size)),
        gamma_(eigenvalues.gamma),
        pairs_(eigenvalues.pairs),
        complex_matrix_(pairs_.size()),
        complex_(pairs_.size()) {
    std::vector<Eigen::Triplet<double>> places;
    places.reserve(pattern.row.size() + pattern.size);
    each([&](std::size_t row, std::size_t column, std::size_t) {
      places.emplace_back(static_cast<int>(row), static_cast<int>(column), 1.0);
    });
    for (int i = 0; i < static_cast<int>(n_); ++i) places.emplace_back(i, i, 1.0);
    real_matrix_.resize(n_, n_);
    real_matrix_.setFromTriplets(places.begin(), places.end());
    real_.analyze(real_matrix_);
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      complex_matrix_[k] = real_matrix_.cast<std::complex<double>>();
      complex_[k].analyze(complex_matrix_[k]);
    }
    place_.reserve(pattern.row.size());
    each([&](std::size_t row, std::size_t column, std::size_t) { place_.push_back(find(row, column)); });
    for (std::size_t i = 0; i < pattern.size; ++i) diagonal_.push_back(find(i, i));
  }

  [[nodiscard]] bool dense() const override { return false; }

  bool factor(double h, const double* jacobian) override {
    double* real = real_matrix_.valuePtr();
    std::fill(real, real + real_matrix_.nonZeros(), 0.0);
    for (std::size_t k = 0; k < place_.size(); ++k) {
      real[place_[k]] = -h * jacobian[k];
      if (!std::isfinite(real[place_[k]])) return false;
    }
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      std::complex<double>* const complex = complex_matrix_[k].valuePtr();
      std::copy(real, real + real_matrix_.nonZeros(), complex);
      for (const Eigen::Index at : diagonal_) complex[at] += pairs_[k];
    }
    for (const Eigen::Index at : diagonal_) real[at] += gamma_;
    if (!real_.factorize(real_matrix_)) return false;
    for (std::size_t k = 0; k < pairs_.size(); ++k)
      if (!complex_[k].factorize(complex_matrix_[k])) return false;
    return true;
  }

  void solve_real(double* u) override {
    Eigen::Map<Eigen::VectorXd> right(u, n_);
    solution_ = real_.solve(right);
    right = solution_;
  }

  void solve_complex(std::size_t pair, double* v, double* w) override {
    complex_right_.resize(n_);
    for (Eigen::Index i = 0; i < n_; ++i) complex_right_[i] = std::complex<double>(v[i], w[i]);
    complex_solution_ = complex_[pair].solve(complex_right_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      v[i] = complex_solution_[i].real();
      w[i] = complex_solution_[i].imag();
    }
  }

 private:
  template <class Visit>
  void each(Visit&& visit) const {
    for (std::size_t column = 0; column < pattern_.size; ++column)
      for (auto k = static_cast<std::size_t>(pattern_.column_start[column]);
           k < static_cast<std::size_t>(pattern_.column_start[column + 1]); ++k)
        visit(static_cast<std::size_t>(pattern_.row[k]), column, k);
  }
  /// Where an entry is among the values.
  [[nodiscard]] Eigen::Index find(std::size_t row, std::size_t column) const {
    const auto* begin = real_matrix_.innerIndexPtr() + real_matrix_.outerIndexPtr()[column];
    const auto* end = real_matrix_.innerIndexPtr() + real_matrix_.outerIndexPtr()[column + 1];
    return std::lower_bound(begin, end, static_cast<int>(row)) - real_matrix_.innerIndexPtr();
  }

  const Sparsity& pattern_;
  Eigen::Index n_;
  double gamma_;
  std::vector<std::complex<double>> pairs_;
  Eigen::SparseMatrix<double> real_matrix_;
  std::vector<Eigen::SparseMatrix<std::complex<double>>> complex_matrix_;
  SparseLu<double> real_;
  std::vector<SparseLu<std::complex<double>>> complex_;
  std::vector<Eigen::Index> place_, diagonal_;  ///< among the values: of the pattern's entries, of the diagonal
  Eigen::VectorXd solution_;
  Eigen::VectorXcd complex_right_, complex_solution_;
};

}  // namespace
}  // namespace radau

std::unique_ptr<RadauSystems> make_radau_systems(const Sparsity& pattern, const RadauEigenvalues& eigenvalues) {
  // Ladders of 70 and 100 states take half as long as by sparse matrices, those of 200 as long (bench methods
  // --random).
  constexpr std::size_t kFullStates = 100;
  switch (pattern.size) {
    case 1:
      return std::make_unique<radau::SmallSystems<1>>(eigenvalues);
    case 2:
      return std::make_unique<radau::SmallSystems<2>>(eigenvalues);
    case 3:
      return std::make_unique<radau::SmallSystems<3>>(eigenvalues);
    case 4:
      return std::make_unique<radau::SmallSystems<4>>(eigenvalues);
    case 5:
      return std::make_unique<radau::SmallSystems<5>>(eigenvalues);
    case 6:
      return std::make_unique<radau::SmallSystems<6>>(eigenvalues);
    case 7:
      return std::make_unique<radau::SmallSystems<7>>(eigenvalues);
    case 8:
      return std::make_unique<radau::SmallSystems<8>>(eigenvalues);
    default:
      if (pattern.size <= kFullStates) return std::make_unique<radau::DenseSystems>(pattern.size, eigenvalues);
      return std::make_unique<radau::SparseSystems>(pattern, eigenvalues);
  }
}

}  // namespace bgsim
