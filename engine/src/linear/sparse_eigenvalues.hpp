/// Eigenvalues of large sparse matrices.
#pragma once

#include <Eigen/SparseCore>
#include <optional>
#include <vector>

#include "linear/dense.hpp"

namespace bgsim {

/// The eigenvalues of a block nearest to wanted.near, nearest first, of pairs the upper one (a pair counts once), with
/// vectors and errors. Each is refined by inverse iteration; then the iteration is started again without those that
/// are known, from another vector, until it finds none that is as near: so eigenvalues that are equal come out as often
/// as they are there.
/// @throws std::runtime_error where they are not told apart, the iteration does not converge, or Spectra was missing
/// when this was compiled.
/// @note Cost: some sparse factorizations for each eigenvalue.
/// @cite lehoucq1998
std::vector<BlockEigenvalue> eigenvalues_near(Eigen::SparseMatrix<double> a, const PolesNear& wanted);

}  // namespace bgsim
