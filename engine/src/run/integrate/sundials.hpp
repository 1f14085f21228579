/// The one place where SUNDIALS objects are made and freed.
#pragma once

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include <memory>
#include <string>
#include <vector>

#include "bgsim/evaluator.hpp"

namespace bgsim {

static_assert(sizeof(sunindextype) == sizeof(std::int64_t), "the sparsity patterns are shared with SUNDIALS");

struct ContextDeleter {
  void operator()(SUNContext context) const;
};
struct VectorDeleter {
  void operator()(N_Vector vector) const;
};
struct MatrixDeleter {
  void operator()(SUNMatrix matrix) const;
};
struct LinearSolverDeleter {
  void operator()(SUNLinearSolver solver) const;
};
struct CvodeDeleter {
  void operator()(void* memory) const;
};
struct ArkodeDeleter {
  void operator()(void* memory) const;
};
struct IdaDeleter {
  void operator()(void* memory) const;
};

using ContextHandle = std::unique_ptr<std::remove_pointer_t<SUNContext>, ContextDeleter>;
using VectorHandle = std::unique_ptr<std::remove_pointer_t<N_Vector>, VectorDeleter>;
using MatrixHandle = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, MatrixDeleter>;
using LinearSolverHandle = std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, LinearSolverDeleter>;
using CvodeHandle = std::unique_ptr<void, CvodeDeleter>;
using ArkodeHandle = std::unique_ptr<void, ArkodeDeleter>;
using IdaHandle = std::unique_ptr<void, IdaDeleter>;

/// @throws std::bad_alloc, like the other makers, when memory runs out.
ContextHandle make_context();
VectorHandle make_vector(SUNContext context, std::size_t size);
/// @param multistep  CV_BDF or CV_ADAMS.
CvodeHandle make_cvode(SUNContext context, int multistep);
IdaHandle make_ida(SUNContext context);
using OdeRates = int (*)(double t, N_Vector y, N_Vector rates, void* user);
/// @param expl, impl  one of them null: what is integrated explicitly and implicitly.
ArkodeHandle make_arkode(SUNContext context, OdeRates expl, OdeRates impl, double t, N_Vector y);

/// A matrix and the solver that factors it: dense for small systems, compressed columns with KLU (AMD ordering: on
/// two-dimensional grids twice as fast as SUNDIALS' default COLAMD) for large ones, without KLU along trees.
struct LinearAlgebra {
  MatrixHandle matrix;
  LinearSolverHandle solver;
  const Sparsity* pattern = nullptr;            ///< null: dense
  bool along_trees = false;                     ///< unknowns are coupled along trees (Forest)
  std::shared_ptr<std::vector<double>> weight;  ///< of the unknowns in the error test, for dense ones (row_scales.hpp)
};
/// What solving costs, in additions of numbers in a row.
struct SolverCost {
  double solve = 0.0, factor = 0.0;
};
/// Of a sparse solver that has factored a matrix.
SolverCost solver_cost(const LinearAlgebra& algebra);

LinearAlgebra make_dense(SUNContext context, N_Vector like);
LinearAlgebra make_sparse(SUNContext context, N_Vector like, const Sparsity& pattern);

/// The values of a sparse matrix by its pattern, which is written where it is not yet.
double* sparse_values(SUNMatrix matrix, const Sparsity& pattern);
double* dense_column(SUNMatrix matrix, std::size_t column);
/// Puts values given by a pattern into a dense matrix.
void scatter(SUNMatrix dense, const Sparsity& pattern, const double* entries);

inline double* values(N_Vector vector) { return N_VGetArrayPointer(vector); }
inline const double* values(const VectorHandle& vector) { return N_VGetArrayPointer(vector.get()); }

/// What SUNDIALS has to say goes here instead of to standard error.
struct SolverMessages {
  std::string last_error;
  static void capture(int code, const char* module, const char* function, char* text, void* self);
};

}  // namespace bgsim
