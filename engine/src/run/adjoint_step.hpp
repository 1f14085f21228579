/// One step of Radau IIA for linear equations whose matrix changes with time.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <array>
#include <vector>

#include "bgsim/program.hpp"

namespace bgsim {

/// Solves the stages of y' = M(s) y + c(s), where M is the transposed Jacobian of a program at each stage: z_i - h sum
/// a_ij M_j z_j = right_i. Densely up to kDenseStates states, else sparsely. Columns of y are solutions beside each
/// other.
class AdjointStages {
 public:
  explicit AdjointStages(const Sparsity& pattern);

  /// The values of the Jacobian at stages 0 to 2, and at the step's beginning (kBegin); by the pattern.
  static constexpr std::size_t kBegin = 3;
  [[nodiscard]] std::vector<double>& jacobian(std::size_t stage) { return jacobians_[stage]; }
  /// M y at a stage.
  [[nodiscard]] Eigen::MatrixXd times(std::size_t stage, const Eigen::MatrixXd& y) const;

  /// @param right  by stage, one below the other; the increments take its place. False if the matrix is singular.
  bool solve(double h, Eigen::MatrixXd& right);
  /// (gamma - h M)^-1 right with the matrix at the beginning; false if it is singular.
  bool filter(double h, Eigen::MatrixXd& right);

 private:
  using Sparse = Eigen::SparseMatrix<double>;
  struct Factors {
    Eigen::PartialPivLU<Eigen::MatrixXd> dense;
    Eigen::SparseLU<Sparse> sparse;
    bool analyzed = false;
  };
  bool solve(Factors& factors, Eigen::Index size, Eigen::MatrixXd& right);
  template <class Add>
  void for_each(std::size_t stage, const Add& add) const;

  const Sparsity& pattern_;
  std::array<std::vector<double>, 4> jacobians_;
  std::vector<Eigen::Triplet<double>> triplets_;
  Factors stages_, begin_;
};

}  // namespace bgsim
