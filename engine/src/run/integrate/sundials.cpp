#include "run/integrate/sundials.hpp"

#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <ida/ida.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <new>
#include <utility>

#include "run/integrate/dense_solver.hpp"
#include "run/integrate/matrices.hpp"
#include "run/integrate/vectors.hpp"

namespace bgsim {

void ContextDeleter::operator()(SUNContext context) const { SUNContext_Free(&context); }
void VectorDeleter::operator()(N_Vector vector) const { N_VDestroy(vector); }
void MatrixDeleter::operator()(SUNMatrix matrix) const { SUNMatDestroy(matrix); }
void LinearSolverDeleter::operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
void CvodeDeleter::operator()(void* memory) const { CVodeFree(&memory); }
void ArkodeDeleter::operator()(void* memory) const { ARKStepFree(&memory); }
void IdaDeleter::operator()(void* memory) const { IDAFree(&memory); }

namespace {

template <class Handle, class Raw>
Handle own(Raw raw) {
  if (raw == nullptr) throw std::bad_alloc();
  return Handle(raw);
}

sunindextype index(std::size_t size) { return static_cast<sunindextype>(size); }

}  // namespace

ContextHandle make_context() {
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  return own<ContextHandle>(context);
}

VectorHandle make_vector(SUNContext context, std::size_t size) {
  VectorHandle vector = own<VectorHandle>(N_VNew_Serial(index(size), context));
  use_own_operations(vector.get());
  N_VConst(0.0, vector.get());
  return vector;
}

CvodeHandle make_cvode(SUNContext context, int multistep) { return own<CvodeHandle>(CVodeCreate(multistep, context)); }

IdaHandle make_ida(SUNContext context) { return own<IdaHandle>(IDACreate(context)); }

ArkodeHandle make_arkode(SUNContext context, OdeRates expl, OdeRates impl, double t, N_Vector y) {
  return own<ArkodeHandle>(ARKStepCreate(expl, impl, t, y, context));
}

LinearAlgebra make_dense(SUNContext context, N_Vector like) {
  const sunindextype size = N_VGetLength(like);
  LinearAlgebra algebra;
  algebra.matrix = own<MatrixHandle>(SUNDenseMatrix(size, size, context));
  algebra.weight = std::make_shared<std::vector<double>>(static_cast<std::size_t>(size), 1.0);
  algebra.solver = own<LinearSolverHandle>(make_dense_solver(context, algebra.weight));
  return algebra;
}

LinearAlgebra make_sparse(SUNContext context, N_Vector like, const Sparsity& pattern) {
  constexpr int kAmd = 0;
  const sunindextype size = N_VGetLength(like);
  LinearAlgebra algebra;
  algebra.pattern = &pattern;
  algebra.matrix = own<MatrixHandle>(SUNSparseMatrix(size, size, index(pattern.row.size()), CSC_MAT, context));
  use_own_operations(algebra.matrix.get());
  sparse_values(algebra.matrix.get(), pattern);
  algebra.solver = own<LinearSolverHandle>(SUNLinSol_KLU(like, algebra.matrix.get(), context));
  SUNLinSol_KLUSetOrdering(algebra.solver.get(), kAmd);
  if (auto forest = Forest::of(pattern)) {
    algebra.along_trees = true;
    SUNLinearSolver klu = algebra.solver.release();
    algebra.solver = own<LinearSolverHandle>(make_forest_solver(context, std::move(*forest), klu));
  }
  return algebra;
}

SolverCost solver_cost(const LinearAlgebra& algebra) {
  // Measured beside additions in a row (bench compare, perf).
  constexpr double kAlongTrees = 10.0, kFactorAlongTrees = 25.0, kForEntry = 5.0, kForOperation = 2.5;
  const auto size = static_cast<double>(SUNSparseMatrix_Columns(algebra.matrix.get()));
  if (algebra.along_trees) return {kAlongTrees * size, kFactorAlongTrees * size};
  sun_klu_numeric* const numeric = SUNLinSol_KLUGetNumeric(algebra.solver.get());
  sun_klu_symbolic* const symbolic = SUNLinSol_KLUGetSymbolic(algebra.solver.get());
  if (numeric == nullptr || symbolic == nullptr) return {};
  sun_klu_common* const common = SUNLinSol_KLUGetCommon(algebra.solver.get());
  klu_l_flops(symbolic, numeric, common);
  return {kForEntry * static_cast<double>(numeric->lnz + numeric->unz), kForOperation * common->flops};
}

double* sparse_values(SUNMatrix matrix, const Sparsity& pattern) {
  if (SUNSparseMatrix_IndexPointers(matrix)[pattern.size] == index(pattern.row.size()))
    return SUNSparseMatrix_Data(matrix);
  std::copy(pattern.column_start.begin(), pattern.column_start.end(), SUNSparseMatrix_IndexPointers(matrix));
  std::copy(pattern.row.begin(), pattern.row.end(), SUNSparseMatrix_IndexValues(matrix));
  return SUNSparseMatrix_Data(matrix);
}

double* dense_column(SUNMatrix matrix, std::size_t column) { return SUNDenseMatrix_Column(matrix, index(column)); }

void scatter(SUNMatrix dense, const Sparsity& pattern, const double* entries) {
  double* out = SUNDenseMatrix_Data(dense);
  std::fill(out, out + pattern.size * pattern.size, 0.0);
  for (std::size_t column = 0; column < pattern.size; ++column)
    for (auto k = static_cast<std::size_t>(pattern.column_start[column]);
         k < static_cast<std::size_t>(pattern.column_start[column + 1]); ++k)
      out[column * pattern.size + static_cast<std::size_t>(pattern.row[k])] = entries[k];
}

void SolverMessages::capture(int code, const char* /*module*/, const char* /*function*/, char* text, void* self) {
  // Warnings (t + h = t and the like) are judged by the loop, which watches the steps itself.
  if (code < 0) static_cast<SolverMessages*>(self)->last_error = text;
}

}  // namespace bgsim
