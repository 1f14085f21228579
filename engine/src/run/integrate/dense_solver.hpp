/// An own linear solver for SUNDIALS' dense matrices.
#pragma once

#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include <memory>
#include <vector>

namespace bgsim {

/// Solves as the package's own one does, but compares pivots by @p weight, the weights of the unknowns in the error
/// test (row_scales.hpp): whoever has these keeps them up to date. Null when memory runs out.
SUNLinearSolver make_dense_solver(SUNContext context, std::shared_ptr<const std::vector<double>> weight);

}  // namespace bgsim
