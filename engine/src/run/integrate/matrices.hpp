/// Own operations on SUNDIALS' sparse matrices, and an own linear solver in front of KLU.
#pragma once

#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include "run/integrate/forest.hpp"

namespace bgsim {

/// Replaces what SUNDIALS does in every factorization with a matrix by columns whose pattern stays and has the whole
/// diagonal, with the same values. The package's own, compiled without optimisation, also clears and writes the pattern
/// each time.
void use_own_operations(SUNMatrix matrix);

/// Solves along @p forest, and by @p klu where that should choose pivots. Owns @p klu. Null when memory runs out.
SUNLinearSolver make_forest_solver(SUNContext context, Forest forest, SUNLinearSolver klu);

}  // namespace bgsim
