#include "run/integrate/matrices.hpp"

#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace bgsim {
namespace {

sunindextype entries_of(SUNMatrix matrix) {
  return SUNSparseMatrix_IndexPointers(matrix)[SUNSparseMatrix_Columns(matrix)];
}

SUNMatrix clone(SUNMatrix matrix) {
  SUNMatrix copy = SUNMatClone_Sparse(matrix);
  if (copy != nullptr) use_own_operations(copy);
  return copy;
}

int zero(SUNMatrix matrix) {
  std::fill_n(SUNSparseMatrix_Data(matrix), SUNSparseMatrix_NNZ(matrix), 0.0);
  return SUNMAT_SUCCESS;
}

int copy(SUNMatrix from, SUNMatrix to) {
  const sunindextype count = entries_of(from);
  if (SUNSparseMatrix_NNZ(to) < count) return SUNMatCopy_Sparse(from, to);
  if (entries_of(to) != count) {
    const sunindextype columns = SUNSparseMatrix_Columns(from);
    std::copy_n(SUNSparseMatrix_IndexPointers(from), columns + 1, SUNSparseMatrix_IndexPointers(to));
    std::copy_n(SUNSparseMatrix_IndexValues(from), count, SUNSparseMatrix_IndexValues(to));
  }
  std::copy_n(SUNSparseMatrix_Data(from), count, SUNSparseMatrix_Data(to));
  return SUNMAT_SUCCESS;
}

/// c A + 1
int scale_add_identity(double c, SUNMatrix matrix) {
  const sunindextype columns = SUNSparseMatrix_Columns(matrix), *start = SUNSparseMatrix_IndexPointers(matrix),
                     *row = SUNSparseMatrix_IndexValues(matrix);
  double* const data = SUNSparseMatrix_Data(matrix);
  for (sunindextype j = 0; j < columns; ++j)
    for (sunindextype k = start[j]; k < start[j + 1]; ++k) data[k] = c * data[k] + (row[k] == j ? 1.0 : 0.0);
  return SUNMAT_SUCCESS;
}

struct ForestSolver {
  Forest forest;
  SUNLinearSolver klu = nullptr;
  bool by_klu = false;
};

ForestSolver& of(SUNLinearSolver solver) { return *static_cast<ForestSolver*>(solver->content); }

SUNLinearSolver_Type direct(SUNLinearSolver /*solver*/) { return SUNLINEARSOLVER_DIRECT; }
int initialize(SUNLinearSolver solver) { return SUNLinSolInitialize(of(solver).klu); }
int set_up(SUNLinearSolver solver, SUNMatrix matrix) {
  ForestSolver& self = of(solver);
  self.by_klu = !self.forest.factor(SUNSparseMatrix_Data(matrix));
  return self.by_klu ? SUNLinSolSetup(self.klu, matrix) : SUNLS_SUCCESS;
}
int solve(SUNLinearSolver solver, SUNMatrix matrix, N_Vector solution, N_Vector right, double tolerance) {
  ForestSolver& self = of(solver);
  if (self.by_klu) return SUNLinSolSolve(self.klu, matrix, solution, right, tolerance);
  self.forest.solve(N_VGetArrayPointer(right), N_VGetArrayPointer(solution));
  return SUNLS_SUCCESS;
}
int free_solver(SUNLinearSolver solver) {
  const std::unique_ptr<ForestSolver> self(&of(solver));
  SUNLinSolFree(self->klu);
  SUNLinSolFreeEmpty(solver);
  return SUNLS_SUCCESS;
}

}  // namespace

void use_own_operations(SUNMatrix matrix) {
  matrix->ops->clone = clone;
  matrix->ops->zero = zero;
  matrix->ops->copy = copy;
  matrix->ops->scaleaddi = scale_add_identity;
}

SUNLinearSolver make_forest_solver(SUNContext context, Forest forest, SUNLinearSolver klu) {
  SUNLinearSolver solver = SUNLinSolNewEmpty(context);
  if (solver == nullptr) return nullptr;
  solver->content = new ForestSolver{std::move(forest), klu};
  solver->ops->gettype = direct;
  solver->ops->initialize = initialize;
  solver->ops->setup = set_up;
  solver->ops->solve = solve;
  solver->ops->free = free_solver;
  return solver;
}

}  // namespace bgsim
