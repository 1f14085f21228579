#include "run/integrate/sundials.hpp"

#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <ida/ida.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <cstdlib>
#include <new>

#include "bgsim/text.hpp"

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

std::string returned(const char* integrator, const char* flag, const std::string& own_text) {
  return std::string(integrator) + " returned " + flag + (own_text.empty() ? "" : ": " + visible_line(own_text));
}

}  // namespace

ContextHandle make_context() {
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  return own<ContextHandle>(context);
}

VectorHandle make_vector(SUNContext context, std::size_t size) {
  VectorHandle vector = own<VectorHandle>(N_VNew_Serial(index(size), context));
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
  algebra.solver = own<LinearSolverHandle>(SUNLinSol_Dense(like, algebra.matrix.get(), context));
  return algebra;
}

LinearAlgebra make_sparse(SUNContext context, N_Vector like, const Sparsity& pattern) {
  constexpr int kAmd = 0;
  const sunindextype size = N_VGetLength(like);
  LinearAlgebra algebra;
  algebra.pattern = &pattern;
  algebra.matrix = own<MatrixHandle>(SUNSparseMatrix(size, size, index(pattern.row.size()), CSC_MAT, context));
  sparse_values(algebra.matrix.get(), pattern);
  algebra.solver = own<LinearSolverHandle>(SUNLinSol_KLU(like, algebra.matrix.get(), context));
  SUNLinSol_KLUSetOrdering(algebra.solver.get(), kAmd);
  return algebra;
}

double* sparse_values(SUNMatrix matrix, const Sparsity& pattern) {
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

std::string cvode_words(int flag, const std::string& own_text) {
  switch (flag) {
    case CV_TOO_MUCH_ACC:
      return "the tolerance is beyond double precision";
    case CV_ERR_FAILURE:
      return "the estimated error stayed too large however small the step";
    case CV_CONV_FAILURE:
      return "the corrector iteration did not converge however small the step";
    case CV_LINIT_FAIL:
    case CV_LSETUP_FAIL:
    case CV_LSOLVE_FAIL:
      return "the linear system of a step could not be solved";
    case CV_RHSFUNC_FAIL:
    case CV_FIRST_RHSFUNC_ERR:
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR:
      return "the state equations could not be evaluated";
    case CV_TOO_CLOSE:
      return "the stretch of time is shorter than the resolution of the time itself";
    default: {
      // The library allocates the name with malloc and hands it over.
      const std::unique_ptr<char, void (*)(void*)> name(CVodeGetReturnFlagName(flag), std::free);
      return returned("CVODE", name.get(), own_text);
    }
  }
}

std::string arkode_words(int flag, const std::string& own_text) {
  switch (flag) {
    case ARK_TOO_MUCH_ACC:
      return "the tolerance is beyond double precision";
    case ARK_ERR_FAILURE:
      return "the estimated error stayed too large however small the step";
    case ARK_CONV_FAILURE:
      return "the corrector iteration did not converge";
    case ARK_LINIT_FAIL:
    case ARK_LSETUP_FAIL:
    case ARK_LSOLVE_FAIL:
      return "the linear system of a step could not be solved";
    case ARK_RHSFUNC_FAIL:
    case ARK_FIRST_RHSFUNC_ERR:
    case ARK_REPTD_RHSFUNC_ERR:
    case ARK_UNREC_RHSFUNC_ERR:
      return "the state equations could not be evaluated";
    case ARK_TOO_CLOSE:
      return "the stretch of time is shorter than the resolution of the time itself";
    default: {
      const std::unique_ptr<char, void (*)(void*)> name(ARKStepGetReturnFlagName(flag), std::free);
      return returned("ARKODE", name.get(), own_text);
    }
  }
}

std::string ida_words(int flag, const std::string& own_text) {
  switch (flag) {
    case IDA_TOO_MUCH_ACC:
      return "the tolerance is beyond double precision";
    case IDA_ERR_FAIL:
      return "the estimated error stayed too large however small the step";
    case IDA_CONV_FAIL:
      return "the corrector iteration did not converge however small the step";
    case IDA_LINIT_FAIL:
    case IDA_LSETUP_FAIL:
    case IDA_LSOLVE_FAIL:
      return "the linear system of a step could not be solved";
    case IDA_RES_FAIL:
    case IDA_REP_RES_ERR:
    case IDA_FIRST_RES_FAIL:
      return "the equations could not be evaluated";
    default: {
      const std::unique_ptr<char, void (*)(void*)> name(IDAGetReturnFlagName(flag), std::free);
      return returned("IDA", name.get(), own_text);
    }
  }
}

}  // namespace bgsim
