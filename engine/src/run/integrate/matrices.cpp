#include "run/integrate/matrices.hpp"

#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "run/integrate/direct_solver.hpp"

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

class ForestSolver {
 public:
  ForestSolver(Forest forest, SUNLinearSolver klu) : forest_(std::move(forest)), klu_(klu) {}
  ~ForestSolver() { SUNLinSolFree(klu_); }
  ForestSolver(const ForestSolver&) = delete;
  ForestSolver& operator=(const ForestSolver&) = delete;

  int initialize() { return SUNLinSolInitialize(klu_); }
  int set_up(SUNMatrix matrix) {
    by_klu_ = !forest_.factor(SUNSparseMatrix_Data(matrix));
    return by_klu_ ? SUNLinSolSetup(klu_, matrix) : SUNLS_SUCCESS;
  }
  int solve(SUNMatrix matrix, N_Vector solution, N_Vector right, double tolerance) {
    if (by_klu_) return SUNLinSolSolve(klu_, matrix, solution, right, tolerance);
    forest_.solve(N_VGetArrayPointer(right), N_VGetArrayPointer(solution));
    return SUNLS_SUCCESS;
  }

 private:
  Forest forest_;
  SUNLinearSolver klu_;
  bool by_klu_ = false;
};

}  // namespace

void use_own_operations(SUNMatrix matrix) {
  matrix->ops->clone = clone;
  matrix->ops->zero = zero;
  matrix->ops->copy = copy;
  matrix->ops->scaleaddi = scale_add_identity;
}

SUNLinearSolver make_forest_solver(SUNContext context, Forest forest, SUNLinearSolver klu) {
  return make_direct_solver(context, std::make_unique<ForestSolver>(std::move(forest), klu));
}

}  // namespace bgsim
