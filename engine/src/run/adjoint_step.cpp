#include "run/adjoint_step.hpp"

#include "run/integrate/integrator.hpp"
#include "run/integrate/radau_formula.hpp"

namespace bgsim {

AdjointStages::AdjointStages(const Sparsity& pattern) : pattern_(pattern) {
  for (std::vector<double>& values : jacobians_) values.resize(pattern.row.size());
}

/// Entries of M, the transpose of the Jacobian.
template <class Add>
void AdjointStages::for_each(std::size_t stage, const Add& add) const {
  for (std::size_t column = 0; column < pattern_.size; ++column)
    for (auto k = pattern_.column_start[column]; k < pattern_.column_start[column + 1]; ++k)
      add(static_cast<Eigen::Index>(column), static_cast<Eigen::Index>(pattern_.row[static_cast<std::size_t>(k)]),
          jacobians_[stage][static_cast<std::size_t>(k)]);
}

Eigen::MatrixXd AdjointStages::times(std::size_t stage, const Eigen::MatrixXd& y) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(y.rows(), y.cols());
  for_each(stage,
           [&](Eigen::Index row, Eigen::Index column, double value) { result.row(row) += value * y.row(column); });
  return result;
}

/// With the matrix in triplets_.
bool AdjointStages::solve(Factors& factors, Eigen::Index size, Eigen::MatrixXd& right) {
  if (pattern_.size <= kDenseStates) {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
    for (const auto& each : triplets_) matrix(each.row(), each.col()) += each.value();
    factors.dense.compute(matrix);
    right = factors.dense.solve(right).eval();
    return right.allFinite();
  }
  Sparse matrix(size, size);
  matrix.setFromTriplets(triplets_.begin(), triplets_.end());
  if (!factors.analyzed) factors.sparse.analyzePattern(matrix);
  factors.analyzed = true;
  factors.sparse.factorize(matrix);
  if (factors.sparse.info() != Eigen::Success) return false;
  right = factors.sparse.solve(right).eval();
  return right.allFinite();
}

bool AdjointStages::solve(double h, Eigen::MatrixXd& right) {
  const auto n = static_cast<Eigen::Index>(pattern_.size);
  triplets_.clear();
  for (Eigen::Index i = 0; i < 3 * n; ++i) triplets_.emplace_back(i, i, 1.0);
  for (std::size_t j = 0; j < 3; ++j)
    for_each(j, [&](Eigen::Index row, Eigen::Index column, double value) {
      for (std::size_t i = 0; i < 3; ++i)
        triplets_.emplace_back(static_cast<Eigen::Index>(i) * n + row, static_cast<Eigen::Index>(j) * n + column,
                               -h * radau::kCoefficients[i][j] * value);
    });
  return solve(stages_, 3 * n, right);
}

bool AdjointStages::filter(double h, Eigen::MatrixXd& right) {
  const auto n = static_cast<Eigen::Index>(pattern_.size);
  triplets_.clear();
  for (Eigen::Index i = 0; i < n; ++i) triplets_.emplace_back(i, i, radau::kGamma);
  for_each(kBegin, [&](Eigen::Index row, Eigen::Index column, double value) {
    triplets_.emplace_back(row, column, -h * value);
  });
  return solve(begin_, n, right);
}

}  // namespace bgsim
