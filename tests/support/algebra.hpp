/// Linear algebra for oracles. Eigen's decompositions are compiled here, once: each takes seconds wherever it is used.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace bgsim::test {

/// @param matrix  square.
Eigen::MatrixXd exponential(const Eigen::MatrixXd& matrix);
/// @param matrix  square.
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& matrix);

/// matrix = u diag(values) v^T, with u and v square and the values falling.
struct SingularValues {
  Eigen::VectorXd values;
  Eigen::MatrixXd u, v;

  /// How many values are above @p threshold times the largest.
  [[nodiscard]] Eigen::Index rank(double threshold) const;
};

SingularValues singular_values(const Eigen::MatrixXd& matrix);

/// Whether a square matrix has full rank: no pivot below @p threshold times the largest.
bool is_invertible(const Eigen::MatrixXd& matrix, double threshold);
/// The x of matrix x = right, by complete pivoting. @pre is_invertible()
Eigen::MatrixXd solved(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right);
/// The same by partial pivoting, which is faster.
Eigen::VectorXd quickly_solved(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);

}  // namespace bgsim::test
