#include "support/algebra.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <unsupported/Eigen/MatrixFunctions>

namespace bgsim::test {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd exponential(const MatrixXd& matrix) { return matrix.exp(); }

Eigen::VectorXcd eigenvalues(const MatrixXd& matrix) {
  return Eigen::EigenSolver<MatrixXd>(matrix, false).eigenvalues();
}

Index SingularValues::rank(double threshold) const {
  Index count = 0;
  while (count < values.size() && values(count) > threshold * values(0)) ++count;
  return count;
}

SingularValues singular_values(const MatrixXd& matrix) {
  const Eigen::JacobiSVD<MatrixXd> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixU(), svd.matrixV()};
}

bool is_invertible(const MatrixXd& matrix, double threshold) {
  Eigen::FullPivLU<MatrixXd> lu(matrix);
  lu.setThreshold(threshold);
  return lu.isInvertible();
}

MatrixXd solved(const MatrixXd& matrix, const MatrixXd& right) {
  // Eigen's own solve() takes the address of the first column even where there is none.
  if (right.cols() == 0) return {matrix.cols(), 0};
  return Eigen::FullPivLU<MatrixXd>(matrix).solve(right);
}

Eigen::VectorXd quickly_solved(const MatrixXd& matrix, const Eigen::VectorXd& right) {
  return Eigen::PartialPivLU<MatrixXd>(matrix).solve(right);
}

}  // namespace bgsim::test
