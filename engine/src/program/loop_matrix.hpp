/// The partials of a loop's residuals by its tears: equilibrated and factorized, densely or sparsely.
#pragma once

#include <Eigen/LU>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace bgsim {

enum class LoopOutcome : std::uint8_t { solved, not_finite, singular, no_convergence };

class LoopMatrix {
 public:
  /// Which pivots a sparse factorization takes. Kept ones cost a sixth, and are given up where the factors grow.
  enum class Pivots : std::uint8_t { new_ones, kept };

  /// @param entries  (row, column) of each partial, no two alike.
  /// @param refined  solutions have few roundings in each component, beside how large the others may be (only up to
  ///        kLargestLocalBlock rows).
  LoopMatrix(std::size_t size, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& entries,
             bool refined = false);
  LoopMatrix(LoopMatrix&&) noexcept;
  ~LoopMatrix();

  /// @param values  by entry; they are scaled in place.
  /// @param explicit_row  by row: a row whose terms are of magnitude 1, even where they cancel.
  /// @param singular  a pivot this much smaller than the largest is rounding.
  LoopOutcome factorize(std::span<double> values, const std::vector<bool>& explicit_row, double singular,
                        Pivots pivots = Pivots::new_ones);

  /// Solves with the equilibrated matrix: @p right is divided by the rows' scales, the result yet to be by the
  /// columns'.
  void solve(const Eigen::VectorXd& right, Eigen::VectorXd& result) const;

  /// The solution of M^T y = @p right for the matrix M itself, scales undone.
  void solve_transposed(const Eigen::VectorXd& right, Eigen::VectorXd& result) const;

  /// Sign of the determinant; 0 before the first factorization.
  [[nodiscard]] int orientation() const;

  Eigen::VectorXd row_scale, column_scale;

 private:
  struct Sparse;

  LoopOutcome factorize_densely(std::span<const double> values, double singular);
  LoopOutcome factorize_sparsely(std::span<const double> values, double singular, Pivots pivots);
  [[nodiscard]] bool refactorize(double singular);
  void balance(std::span<double> values);
  void refine(const Eigen::VectorXd& right, Eigen::VectorXd& result) const;

  std::vector<std::pair<std::uint32_t, std::uint32_t>> entries_;
  Eigen::VectorXd row_balance_, column_balance_;  ///< 1 but for refined solutions
  Eigen::MatrixXd dense_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
  bool factorized_ = false, refined_ = false;
  std::unique_ptr<Sparse> sparse_;  ///< of large loops only
};

}  // namespace bgsim
