/// Systems of linear equations by Eigen's LU decompositions, which are compiled once: they cost some seconds of
/// compilation in each source that names them.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

namespace bgsim {

/// P A = L U of a dense square matrix, with pivots by row.
class DenseLu {
 public:
  explicit DenseLu(const Eigen::MatrixXd& matrix);
  ~DenseLu();
  DenseLu(const DenseLu&) = delete;
  DenseLu& operator=(const DenseLu&) = delete;

  /// An estimate of 1/(|A| |A^-1|): 0 where A is singular.
  [[nodiscard]] double rcond() const;
  /// A^-1 right, column by column; not finite where A is singular.
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

/// A x = right of a dense square matrix, with pivots by row and column: a solution of a singular system that has one.
Eigen::VectorXd solve_with_full_pivots(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);

/// The same as DenseLu of a sparse square matrix, columns ordered by COLAMD. Of double and std::complex<double>.
template <class Scalar>
class SparseLu {
 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;  ///< compressed
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  SparseLu();
  ~SparseLu();
  SparseLu(const SparseLu&) = delete;
  SparseLu& operator=(const SparseLu&) = delete;

  /// The order of the columns, for all matrices with these places.
  void analyze(const Matrix& matrix);
  /// @returns false if the matrix, whose places were analyzed, is singular.
  bool factorize(const Matrix& matrix);
  [[nodiscard]] Vector solve(const Vector& right) const;
  /// Of the transposed matrix, without conjugates.
  [[nodiscard]] Vector solve_transposed(const Vector& right) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

}  // namespace bgsim
