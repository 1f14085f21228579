// Eigenvalues of a large block that are nearest to a number: Arnoldi's iteration of the shifted inverse, as often as it
// finds further ones.
#include "linear/sparse_eigenvalues.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <stdexcept>

#include "base/lu.hpp"
#include "base/text.hpp"
#include "bgsim/text.hpp"

#if __has_include(<Spectra/GenEigsRealShiftSolver.h>)
#include <Spectra/GenEigsRealShiftSolver.h>
#define BGSIM_HAS_SPECTRA
#endif

namespace bgsim {
namespace {

using Index = Eigen::Index;
using Complex = std::complex<double>;
using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;
using ComplexVector = Eigen::VectorXcd;

constexpr double kRoundOff = std::numeric_limits<double>::epsilon();
constexpr double kEntry = 4.0 * kRoundOff;  // as in eigenvalues.cpp

/// Powers of two by row, such that rows and columns of D^-1 A D have like magnitudes (Parlett and Reinsch).
Vector balance(Matrix& a) {
  Vector scale = Vector::Ones(a.rows());
  for (int sweep = 0; sweep < 200; ++sweep) {
    Vector row = Vector::Zero(a.rows()), column = Vector::Zero(a.rows());
    for (Index c = 0; c < a.cols(); ++c)
      for (Matrix::InnerIterator e(a, c); e; ++e)
        if (e.row() != c) {
          row(e.row()) += std::abs(e.value());
          column(c) += std::abs(e.value());
        }
    Vector factor = Vector::Ones(a.rows());
    for (Index i = 0; i < a.rows(); ++i) {
      if (row(i) == 0.0 || column(i) == 0.0) continue;
      // Half the way at a time, since all rows are scaled at once.
      const double f = std::exp2(std::round(0.25 * std::log2(row(i) / column(i))));
      if (row(i) / f + column(i) * f < 0.95 * (row(i) + column(i))) factor(i) = f;
    }
    if ((factor.array() == 1.0).all()) break;
    for (Index c = 0; c < a.cols(); ++c)
      for (Matrix::InnerIterator e(a, c); e; ++e) e.valueRef() *= factor(c) / factor(e.row());
    scale.array() *= factor.array();
  }
  return scale;
}

template <class Scalar>
Eigen::SparseMatrix<Scalar> shifted(const Matrix& a, Scalar shift) {
  Eigen::SparseMatrix<Scalar> identity(a.rows(), a.rows());
  identity.setIdentity();
  Eigen::SparseMatrix<Scalar> result = a.cast<Scalar>() - shift * identity;
  result.makeCompressed();
  return result;
}

/// An eigenvalue with both vectors: a x = value x, y a = value y, y x = 1 (no conjugates).
struct Found {
  Complex value;
  ComplexVector x, y;
  double error = 0.0;
  [[nodiscard]] bool pair() const { return value.imag() != 0.0; }
};

/// Takes the directions of what is found out of a vector; of a pair, both.
template <class V>
void take_out(const std::vector<Found>& found, bool left, V& vector) {
  for (const Found& one : found) {
    const ComplexVector &along = left ? one.y : one.x, &against = left ? one.x : one.y;
    const Complex part = (against.array() * vector.template cast<Complex>().array()).sum();
    if constexpr (std::is_same_v<typename V::Scalar, double>) {
      vector -= (one.pair() ? 2.0 : 1.0) * (part * along).real();
    } else {
      const Complex other = (against.conjugate().array() * vector.array()).sum();
      vector -= part * along;
      if (one.pair()) vector -= other * along.conjugate();
    }
  }
}

/// (a - shift)^-1 without what is found already, as Spectra wants it.
class ShiftedInverse {
 public:
  using Scalar = double;
  ShiftedInverse(const SparseLu<double>& lu, const std::vector<Found>& found, Index rows)
      : lu_(lu), found_(found), rows_(rows) {}
  [[nodiscard]] Index rows() const { return rows_; }
  [[nodiscard]] Index cols() const { return rows_; }
  void set_shift(double /*shift*/) {}  // it is factorized already
  void perform_op(const double* in, double* out) const {
    // Before, since an eigenvalue at the shift would multiply its direction by 1e16; afterwards, since rounding did.
    Vector result = Eigen::Map<const Vector>(in, rows_);
    take_out(found_, false, result);
    result = lu_.solve(result);
    for (int again = 0; again < 2; ++again) take_out(found_, false, result);
    Eigen::Map<Vector>(out, rows_) = result;
  }

 private:
  const SparseLu<double>& lu_;
  const std::vector<Found>& found_;
  Index rows_;
};

/// The sum of |y_i a_ij x_j|, and y a x.
std::pair<double, Complex> forms(const Matrix& a, const ComplexVector& y, const ComplexVector& x) {
  long double gross = 0;
  std::complex<long double> image = 0;
  for (Index c = 0; c < a.cols(); ++c)
    for (Matrix::InnerIterator e(a, c); e; ++e) {
      const Complex term = y(e.row()) * e.value() * x(c);
      gross += std::abs(term);
      image += std::complex<long double>(term.real(), term.imag());
    }
  return {static_cast<double>(gross), Complex(static_cast<double>(image.real()), static_cast<double>(image.imag()))};
}

/// Inverse iteration for both vectors, away from those that are found; none if it does not come to rest.
std::optional<Found> refined(const Matrix& a, Complex value, ComplexVector x, const std::vector<Found>& found,
                             double scale) {
  ComplexVector y = x.conjugate() + ComplexVector::Constant(x.size(), Complex(1e-3 * x.cwiseAbs().maxCoeff()));
  constexpr int kMostRounds = 8;
  for (int round = 0; round < kMostRounds; ++round) {
    // Off the eigenvalue by a little, so that no pivot is 0.
    const Complex shift = value + Complex(1e-12 * scale, value.imag() == 0.0 ? 0.0 : 1e-12 * scale);
    SparseLu<Complex> lu;
    const auto matrix = shifted<Complex>(a, shift);
    lu.analyze(matrix);
    if (!lu.factorize(matrix)) return std::nullopt;
    for (int again = 0; again < 2; ++again) {
      x = lu.solve(x);
      y = lu.solve_transposed(y);
      take_out(found, false, x);
      take_out(found, true, y);
      x /= x.norm();
      y /= y.norm();
    }
    const Complex product = (y.array() * x.array()).sum();
    if (!x.allFinite() || !y.allFinite() || product == 0.0) return std::nullopt;
    const auto [gross, image] = forms(a, y, x);
    const Complex next = image / product;
    const double moved = std::abs(next - value);
    value = value.imag() == 0.0 ? Complex(next.real()) : next;
    const double error = kEntry * gross / std::abs(product);
    if (!(error < scale)) return std::nullopt;  // vectors at right angles: eigenvalues that are not told apart
    if (moved <= 4.0 * error) return Found{value, x, y / product, error + moved};
  }
  return std::nullopt;
}

double largest(const Matrix& a) {
  double result = 0.0;
  for (Index c = 0; c < a.cols(); ++c)
    for (Matrix::InnerIterator e(a, c); e; ++e) result = std::max(result, std::abs(e.value()));
  return result;
}

/// Factorizes a - shift; where that is singular, beside it.
double factorize_near(const Matrix& a, double near, SparseLu<double>& lu) {
  double shift = near, aside = 1e-10 * largest(a);
  lu.analyze(shifted<double>(a, 1.0));
  for (int attempt = 0; attempt < 4; ++attempt, aside *= 100.0) {
    const Matrix matrix = shifted<double>(a, shift);
    if (lu.factorize(matrix)) {
      const Vector probe = lu.solve(Vector::Ones(a.rows()));
      if (probe.allFinite()) return shift;
    }
    shift = near + aside;
  }
  throw std::runtime_error("the matrix is singular beside " + number_text(near, 6));
}

}  // namespace

#ifdef BGSIM_HAS_SPECTRA

namespace {

/// One iteration: eigenvalues that it is sure of, nearest first, with their vectors; of pairs the upper ones.
std::vector<std::pair<Complex, ComplexVector>> arnoldi(const SparseLu<double>& lu, const std::vector<Found>& found,
                                                       Index rows, double shift, Index wanted, std::size_t pass) {
  ShiftedInverse inverse(lu, found, rows);
  const Index some = std::min(wanted, rows - 2), basis = std::min(rows, 2 * some + 20);
  Spectra::GenEigsRealShiftSolver<ShiftedInverse> solver(inverse, some, basis, shift);
  // Any start will do that is no eigenvector; a fixed one, so that the answer is the same each time.
  Vector start(rows);
  std::uint64_t state = 0x9E3779B97F4A7C15U + pass;
  for (Index i = 0; i < rows; ++i) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    start(i) = static_cast<double>(state >> 11U) * 0x1p-53 - 0.5;
  }
  take_out(found, false, start);
  solver.init(start.data());
  constexpr Index kMostRestarts = 300;
  constexpr double kTolerance = 1e-9;  // refined later
  solver.compute(Spectra::SortRule::LargestMagn, kMostRestarts, kTolerance);
  const auto values = solver.eigenvalues();
  const auto vectors = solver.eigenvectors();
  std::vector<std::pair<Complex, ComplexVector>> result;
  for (Index k = 0; k < values.size(); ++k)
    if (values(k).imag() >= 0.0 && std::isfinite(std::abs(values(k)))) result.emplace_back(values(k), vectors.col(k));
  std::stable_sort(result.begin(), result.end(),
                   [&](const auto& a, const auto& b) { return std::abs(a.first - shift) < std::abs(b.first - shift); });
  return result;
}

}  // namespace

std::vector<BlockEigenvalue> eigenvalues_near(Eigen::SparseMatrix<double> a, const PolesNear& wanted) {
  const Vector scale = balance(a);
  SparseLu<double> lu;
  const auto nearer = [&](const Found& one, const Found& other) {
    return std::abs(one.value - wanted.near) < std::abs(other.value - wanted.near);
  };
  const double shift = factorize_near(a, wanted.near, lu);
  const double size = largest(a);
  std::vector<Found> found;
  const auto limit = [&] {  // what is farther is not wanted
    return found.size() < wanted.count ? std::numeric_limits<double>::infinity()
                                       : std::abs(found[wanted.count - 1].value - wanted.near) * (1.0 + 1e-9);
  };
  // Distances from the shift beyond this part of the least are rounding of the inverse: they wait for the next pass.
  constexpr double kSpan = 1e7;
  const std::size_t most_passes = 10 + wanted.count;
  bool complete = false;
  for (std::size_t pass = 0; pass < most_passes && !complete; ++pass) {
    const auto candidates = arnoldi(lu, found, a.rows(), shift, static_cast<Index>(wanted.count) + 2, pass);
    if (candidates.empty()) throw std::runtime_error("Arnoldi's iteration does not converge");
    const double least = std::abs(candidates.front().first - shift);
    complete = found.size() >= wanted.count;  // unless one is found that belongs to the nearest
    for (const auto& [value, vector] : candidates) {
      if (std::abs(value - wanted.near) > limit()) continue;
      complete = false;
      if (std::abs(value - shift) > kSpan * least) break;
      const double scale_near = std::max(std::abs(value), 1e-6 * size);
      std::optional<Found> one;
      // Two equal real ones look like a pair.
      if (std::abs(value.imag()) < 1e-5 * scale_near)
        one = refined(a, value.real(), vector.real().cast<Complex>(), found, scale_near);
      if (!one) one = refined(a, value, vector, found, scale_near);
      if (!one) throw std::runtime_error("eigenvalues near " + number_text(value.real(), 6) + " are not told apart");
      found.push_back(std::move(*one));
      std::stable_sort(found.begin(), found.end(), nearer);
    }
  }
  if (!complete) throw std::runtime_error("more and more eigenvalues are found at the same distance");
  if (found.size() > wanted.count) found.resize(wanted.count);
  std::vector<BlockEigenvalue> result;
  for (const Found& one : found) {
    BlockEigenvalue made;
    made.value = one.value;
    made.error = one.error;
    double sum = 0.0;
    for (Index i = 0; i < a.rows(); ++i) {
      made.rows.push_back(static_cast<std::uint32_t>(i));
      made.participation.push_back(std::abs(one.y(i) * one.x(i)));
      sum += made.participation.back();
      made.mode.push_back(one.x(i) * scale(i));
    }
    for (double& part : made.participation) part /= sum;
    result.push_back(std::move(made));
  }
  return result;
}

#else

std::vector<BlockEigenvalue> eigenvalues_near(Eigen::SparseMatrix<double> /*a*/, const PolesNear& /*wanted*/) {
  throw std::runtime_error("this bgsim was built without Spectra (Debian: apt-get install libspectra-dev)");
}

#endif

}  // namespace bgsim
