/// Linear systems as dense matrices.
#pragma once

#include <Eigen/Dense>

#include "bgsim/linear.hpp"

namespace bgsim {

inline Eigen::MatrixXd dense(const LinearMatrix& matrix) {
  Eigen::MatrixXd result =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(matrix.rows), static_cast<Eigen::Index>(matrix.columns));
  for (const auto& e : matrix.entries) result(e.row, e.column) = e.value;
  return result;
}

/// What is not zero, by row.
inline LinearMatrix sparse(const Eigen::MatrixXd& matrix) {
  LinearMatrix result{static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols()), {}};
  for (Eigen::Index r = 0; r < matrix.rows(); ++r)
    for (Eigen::Index c = 0; c < matrix.cols(); ++c)
      if (matrix(r, c) != 0.0)
        result.entries.push_back({static_cast<std::uint32_t>(r), static_cast<std::uint32_t>(c), matrix(r, c)});
  return result;
}

/// Eigenvalues of a square matrix by blocks, with errors and shares by row (see poles()). @p exact: how far an entry
/// can be off, relative to it.
struct BlockEigenvalue {
  std::complex<double> value;
  double error = 0.0;
  std::vector<std::uint32_t> rows;         ///< of the block
  std::vector<double> participation;       ///< by row of the block
  std::vector<std::complex<double>> mode;  ///< right eigenvector within the block
};
/// @param some  where all are not needed: blocks of more than kLargestDense rows give their nearest ones
/// @throws std::length_error a block has more than kLargestDense rows, and all are wanted; std::runtime_error.
std::vector<BlockEigenvalue> eigenvalues_by_blocks(const LinearMatrix& matrix,
                                                   const std::optional<PolesNear>& some = {});

/// Path from one input to one output of a system: single columns and rows, derivatives of the input moved to the
/// output.
struct SinglePath {
  std::vector<std::uint32_t> states;  ///< between input and output
  LinearMatrix a;
  Eigen::VectorXd b, c;
  std::vector<double> d;  ///< by order of the derivative
};
/// @throws ModelError BG410.
SinglePath single_path(const LinearSystem& system, std::size_t input, std::size_t output);

}  // namespace bgsim
